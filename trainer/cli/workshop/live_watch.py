"""The watch of a boat under way, which tells the instructor of its session.

It is an observer like any other: a process of its own, for which the boat waits no more than for a
page. ``identify/boat/live`` makes a record of what it hears, and judges it in a thread.
"""

import contextlib
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from queue import Empty, SimpleQueue
from typing import Final

from trainer.config.files import ConfigError
from trainer.console.client import Client, Item, LineLoss, RoleRefusal, RoleTaken
from trainer.console.readings import ChannelReadings
from trainer.identify.boat.live import (
    SHOWN_FIELDS,
    LiveRecord,
    LiveVerdict,
    state_words,
)
from trainer.identify.boat.watch import BoatWatch, WatchFiles, watch_boat
from trainer.io import paths
from trainer.io.orders.sentences import Sentence
from trainer.io.serial_line import LinkError

LOOK_S: Final = 0.1  # [s] from look to look at what has come
CLOSE_TIMEOUT_S: Final = 2.0  # [s] for the line to be closed
TIME_CHANNEL: Final = "time"
WATCHER_ROLE: Final = "observer"
LENGTH_TOLERANCE: Final = 0.01  # [-] by which a session's boat may differ from the fitted one


@dataclass(frozen=True)
class Judgement:
    """What a thread has found, or why nothing could be."""

    number: int  # of the record
    begun: float  # [s] of the session
    found: tuple[WatchFiles, BoatWatch] | None
    trouble: str = ""


@dataclass
class SessionWatch:
    """A watch of one session: what it hears, what it finds, what it has told."""

    files: WatchFiles
    client: Client
    tell: Callable[[str], None]
    record: LiveRecord
    picture: ChannelReadings = field(default_factory=ChannelReadings)
    verdict: LiveVerdict = field(default_factory=LiveVerdict)
    last: tuple[WatchFiles, BoatWatch] | None = None
    over: bool = False

    def __post_init__(self) -> None:
        self._found: SimpleQueue[Judgement] = SimpleQueue()
        self._judging = False
        self._due_rows, self._rest_until, self._begun_at = 0, 0.0, 0.0
        self._trouble = ""

    def take(self, item: Item) -> None:
        """Take what has come; ConfigError where the session is none for this watch."""
        if isinstance(item, RoleRefusal):
            raise ConfigError(f"the session does not let a watch in: {item.reason}")
        if isinstance(item, RoleTaken):
            self.client.order("name watch")
            self.tell("watching")
        elif isinstance(item, LineLoss):
            self.tell(f"the line is lost: {item.why}; it is tried again")
        elif isinstance(item, Sentence):
            self._hear(item)

    def _hear(self, sentence: Sentence) -> None:
        """Take a sentence of the session."""
        if sentence.kind in ("TRN", "TRS"):
            channel = self.picture.take(sentence, 0.0)
            if channel and self.picture.word(TIME_CHANNEL, "replay") != "yes":
                reading = self.picture.reading(channel)
                self._begin_anew(
                    self.record.hear(channel, reading.tick, reading.seconds, reading.values)
                )
        elif sentence.kind == "TRF":
            _, _, what, subject = sentence.fields
            if what == "back":
                self._begin_anew(self.record.begin("time has jumped"))
            elif what == "range":
                self._check_boat(subject)
            self.over = self.over or what == "over"

    def _check_boat(self, subject: str) -> None:
        """Refuse a session whose boat is of another length."""
        key, _, value = subject.partition("=")
        length = self.record.vessel.length
        if key == "length" and abs(float(value) - length) > LENGTH_TOLERANCE * length:
            raise ConfigError(
                f"the session's boat is {value} m long, and {self.record.vessel.file.path.name} "
                f"is {length:g} m: watch a session of the boat that was fitted"
            )

    def _begin_anew(self, why: str) -> None:
        """Note that the record begins anew, if it does."""
        if why:
            self.verdict, self._due_rows = LiveVerdict(), 0
            self.tell(f"begins anew: {why}")

    def look(self) -> None:
        """Tell what a thread has found, and begin to judge where that is due."""
        with contextlib.suppress(Empty):
            self._take_judgement(self._found.get_nowait())
        if self._judging or time.monotonic() < self._rest_until:
            return
        if len(self.record.rows) < self._due_rows:
            return
        self._due_rows = len(self.record.rows) + self.record.window_rows
        try:
            files = replace(self.files, trials=(self.record.trial(),))
        except ConfigError as error:
            self._wait_for(str(error))
            return
        self._judging, self._begun_at = True, time.monotonic()
        place = self.record.number, self.record.seconds[0]
        threading.Thread(target=self._judge, args=(files, *place), daemon=True).start()

    def _judge(self, files: WatchFiles, number: int, begun: float) -> None:
        """Judge a record in a thread."""
        try:
            self._found.put(Judgement(number, begun, (files, watch_boat(files))))
        except ConfigError as error:
            self._found.put(Judgement(number, begun, None, str(error)))

    def _take_judgement(self, judged: Judgement) -> None:
        """Tell what has been found, unless the record has begun anew since."""
        self._judging, now = False, time.monotonic()
        self._rest_until = now + (now - self._begun_at)  # half of one processor at most
        if judged.number != self.record.number:
            return
        if judged.found is None:
            self._wait_for(judged.trouble)
            return
        self.last, self._trouble, report = judged.found, "", judged.found[1]
        self.tell(state_words(report, judged.begun))
        for text in self.verdict.news(report, judged.begun):
            self.client.order(f"mark watch: {text}")
            self.tell(text)

    def _wait_for(self, trouble: str) -> None:
        """Tell once why nothing can be said yet."""
        if trouble.partition(" ")[2] != self._trouble.partition(" ")[2]:
            self.tell(f"nothing can be said yet: {trouble}")
        self._trouble = trouble


def watch_session(
    files: WatchFiles,
    url: str | None,
    token: str | None,
    biases: Mapping[str, float],
    tell: Callable[[str], None],
) -> tuple[WatchFiles, BoatWatch] | None:
    """Watch a session until it ends or Ctrl-C; return the last verdict, None without.

    ConfigError where there is no session, or one of another boat.
    """
    token = token or paths.left_token(url)
    wishes = dict.fromkeys((TIME_CHANNEL, *SHOWN_FIELDS), "")
    client = Client(
        lambda: url or paths.nearest_session(), f"{WATCHER_ROLE} {token or ''}".rstrip(), wishes
    )
    try:
        client.dial()
    except LinkError as error:
        raise ConfigError(f"{error}; or name records to watch") from None
    watch = SessionWatch(files, client, tell, LiveRecord(files.fitted.vessel, biases))
    client.start()
    try:
        while not watch.over:
            for item in client.take():
                watch.take(item)
            watch.look()
            time.sleep(LOOK_S)
    except KeyboardInterrupt:
        tell("left")
    finally:
        client.close(CLOSE_TIMEOUT_S)
    return watch.last
