"""Feeds, each of which carries states and news to Rerun by its own thread.

An outlet is a viewer or a file (``request``). Handing over is an append. In a run that keeps time
the tick never waits: states without room are counted and lost. In a run as fast as it goes the tick
waits for an outlet that does not keep up, so that nothing is lost.
"""

import math
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

import click

from trainer.io.orders.grammar import Refused
from trainer.session.rerun.batch import Batch, BatchCollector, TakenNews, TakenPicture
from trainer.session.stations.station import News
from trainer.session.stations.subscriptions import PromptSender, Publisher, Subscription
from trainer.session.stations.view import Pace
from trainer.session.time.ledger import Ledger

CHUNK_STATES: Final = 4096  # handed on at once
MAX_WAITING_STATES: Final = 4 * CHUNK_STATES  # states that may wait: 32 MB
MAX_TICK_WAIT_S: Final = 2.0  # [s] that a tick of a run without time waits for room


class Sink(Protocol):
    """The far end of a feed. Its methods may wait, and raise when they cannot go on."""

    name: str  # in messages about it
    period: float  # [s] from batch to batch
    patience: float  # [s] that it has for what is left at the end
    needed: bool  # a run has failed where it has

    def open(self) -> None:
        """Get ready."""

    def write(self, batch: Batch) -> None:
        """Take a batch, and bring it out."""

    def close(self) -> None:
        """End."""


class Feed:
    """One outlet with its thread, which carries to it what the session hands over."""

    def __init__(self, sink: Sink, step: float) -> None:
        """Carry to ``sink``, from a run with that step [s]."""
        self.trouble = ""  # what has become of it, "" while all is well
        self.lost = 0  # pictures
        self.sink = sink
        self._gathering = BatchCollector(step)
        self._waiting: deque[TakenPicture | TakenNews] = deque()
        self._called = threading.Event()
        self._room = threading.Event()
        self._closing = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=sink.name, daemon=True)
        self._thread.start()

    def hand(self, handed: TakenPicture | TakenNews) -> None:
        """Take a state or news to carry. This is an append, unless there is no room."""
        waiting = self._waiting
        if len(waiting) >= CHUNK_STATES and not self._make_room(handed):
            return
        waiting.append(handed)

    def end(self) -> None:
        """Carry what waits by the thread, and end."""
        self._closing.set()
        self._called.set()

    def close(self) -> None:
        """End the feed, and wait no longer than the sink's limit."""
        self.end()
        if not self._over.wait(self.sink.patience):
            self._tell("it did not take all in time: its end is missing")
        elif self.lost:
            self._tell(f"{self.lost} ticks are missing: it did not take them in time")

    def _make_room(self, handed: TakenPicture | TakenNews) -> bool:
        """Wake the thread; return whether there is room. Wait for room where no time is kept."""
        if self._over.is_set():
            return False
        if not self._called.is_set():
            self._called.set()
        hurried = isinstance(handed, TakenPicture) and math.isinf(handed.pace.speed)
        if len(self._waiting) < MAX_WAITING_STATES:
            return True
        self._room.clear()
        if len(self._waiting) >= MAX_WAITING_STATES and not (
            hurried and self._room.wait(MAX_TICK_WAIT_S)
        ):
            self.lost += isinstance(handed, TakenPicture)
            return False
        return True

    def _tell(self, trouble: str) -> None:
        self.trouble = self.trouble or f"{self.sink.name}: {trouble}"

    def _run(self) -> None:
        try:
            self.sink.open()
            while not self._closing.is_set():
                self._called.wait(self.sink.period)
                self._called.clear()
                self._carry()
            self._carry()
            self.sink.close()
        except Exception as error:  # noqa: BLE001 whatever fails here, the run goes on
            reason, *_ = str(error).splitlines() or [type(error).__name__]
            self._tell(f"{reason}; nothing more goes there")
        finally:
            self._over.set()
            self._waiting.clear()
            self._room.set()

    def _carry(self) -> None:
        """Carry all that waits now, piece by piece."""
        while count := min(len(self._waiting), CHUNK_STATES):
            handed = [self._waiting.popleft() for _ in range(count)]
            self._room.set()
            self.sink.write(self._gathering.batch(handed))


@dataclass
class Log:
    """A sender that serves subscriptions by ``sending``, and hands pictures to feeds."""

    sending: Publisher | PromptSender
    ledger: Ledger
    feeds: Sequence[Feed]
    _last: tuple[int, bytes, Pace] | None = field(default=None, init=False)
    _told: set[str] = field(default_factory=set, init=False)

    @property
    def troubles(self) -> deque[str]:
        """Return the troubles that the session announces, the end of a feed once."""
        for feed in self.feeds:
            if feed.trouble and feed.trouble not in self._told:
                self._told.add(feed.trouble)
                self.sending.troubles.append(feed.trouble)
        return self.sending.troubles

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Set the picture to send from now on."""
        self.sending.offer(tick, state, pace)
        self._last = tick, state, pace
        self._hand_last()

    def hear(self, news: News) -> None:
        """Hand an event to the feeds."""
        heard = TakenNews(news.tick, news.kind, news.text)
        for feed in self.feeds:
            feed.hand(heard)

    def _hand_last(self) -> None:
        if self._last is not None:
            ledger = self.ledger
            taken = TakenPicture(*self._last, ledger.ticks, ledger.lateness, ledger.work)
            for feed in self.feeds:
                feed.hand(taken)

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        self.sending.add(subscription)

    def lack(self, channel: str) -> Refused | None:
        """Return why the boat has no such channel, None where it has."""
        return self.sending.lack(channel)

    def strike(self, subscription: Subscription) -> None:
        """Send to a subscription no more."""
        self.sending.strike(subscription)

    def close(self, patience: float) -> None:
        """Send and feed what is due, waiting for each as long as it may take."""
        self._hand_last()  # its work has been timed only now
        for feed in self.feeds:
            feed.end()
        self.sending.close(patience)
        for feed in self.feeds:
            feed.close()

    def account(self) -> int:
        """Print how feeds failed; return the exit code.

        An incomplete file is an error. A viewer that has gone is none.
        """
        for feed in self.feeds:
            if feed.trouble:
                click.echo(f"trainer: {feed.trouble}", err=True)
        return int(any(feed.trouble and feed.sink.needed for feed in self.feeds))
