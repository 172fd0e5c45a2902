"""A feed carries what the tick hands over to one outlet, by its own thread.

Handing over is an append. Where time runs as fast as it can and the outlet does not keep up the
tick waits, so that nothing is lost; where time is kept it never does, and what there is no room for
is counted.

A run may be wound back, so that its ticks do; the time in the viewer goes on all the same. The time
of a tick's work is known only after its state has been handed over: it comes with the next.
"""

import math
import threading
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple, Protocol

import click
import numpy as np

from trainer.session.layout import LAYOUT
from trainer.session.rerun.batch import Batch, Block, Times, Told, Worked, states
from trainer.session.stations.station import News
from trainer.session.stations.subscriptions import Promptly, Publisher, Subscription
from trainer.session.stations.view import Pace
from trainer.session.time.ledger import Ledger


class Taken(NamedTuple):
    """A picture as it was handed over, and the ledger at that moment."""

    tick: int
    state: bytes
    pace: Pace
    timed: int  # ticks in the ledger
    lateness: int  # [ns] of the last of them
    work: int  # [ns]


class Heard(NamedTuple):
    """News, as they were handed over."""

    tick: int
    kind: str
    text: str


Handed = Taken | Heard


class Gathering:
    """Where the run stands, from batch to batch."""

    def __init__(self, step: float) -> None:
        """Take the step [s]."""
        self._step = step
        self._last: Taken | None = None
        self._seconds = 0.0  # of the last picture

    def batch(self, handed: Sequence[Handed]) -> Batch:
        """Return what was handed over, in that order."""
        pictures, worked, told = Rows(), Rows(), Rows()
        for each in handed:
            if isinstance(each, Heard):
                told.add(each, each.tick, self._seconds)
                continue
            last = self._last
            if last is not None and each.timed != last.timed:
                worked.add(each, last.tick, self._seconds)
            if self._moved(last, each):
                pictures.add(each, each.tick, self._seconds)
            self._last = each
        return Batch(_block(pictures), _timings(worked), _told_rows(told))

    def _moved(self, last: Taken | None, taken: Taken) -> bool:
        """Let time go on to a picture; return whether it is another than the last."""
        if last is None:
            self._seconds = taken.tick * self._step
            return True
        ahead = taken.tick - last.tick
        if ahead == 0 and taken.state == last.state:
            return False
        same = ahead > 0 and taken.pace.branch == last.pace.branch
        self._seconds += (ahead if same else 1) * self._step
        return True


class Rows:
    """Some of what was handed over, with its times. In columns, which the collector passes by."""

    def __init__(self) -> None:
        self.handed: list[Any] = []
        self.ticks: list[int] = []
        self.seconds: list[float] = []

    def add(self, handed: Handed, tick: int, seconds: float) -> None:
        """Take one with its tick and time [s]."""
        self.handed.append(handed)
        self.ticks.append(tick)
        self.seconds.append(seconds)

    @property
    def times(self) -> Times:
        """Return when each was."""
        return Times.of(self.ticks, self.seconds)


def _block(rows: Rows) -> Block:
    paces = [taken.pace for taken in rows.handed]
    return Block(
        rows.times,
        states([taken.state for taken in rows.handed], LAYOUT),
        np.array([pace.branch for pace in paces], np.int64),
        np.array([pace.replaying for pace in paces], np.bool_),
    )


def _timings(rows: Rows) -> Worked:
    return Worked(
        rows.times,
        np.array([taken.lateness for taken in rows.handed], np.float64),
        np.array([taken.work for taken in rows.handed], np.float64),
    )


def _told_rows(rows: Rows) -> Told:
    kinds = tuple(heard.kind for heard in rows.handed)
    return Told(rows.times, kinds, tuple(heard.text for heard in rows.handed))


CHUNK: Final = 4096  # handed on at once
ROOM: Final = 4 * CHUNK  # states that may wait: 32 MB
LONGEST: Final = 2.0  # [s] that a tick waits for room


class Sink(Protocol):
    """Where batches go; its methods may wait, and raise when they cannot go on."""

    name: str  # in what is told of it
    period: float  # [s] from batch to batch
    patience: float  # [s] that it has for what is left at the end
    needed: bool  # a run has failed where it has

    def open(self) -> None:
        """Get ready."""
        ...

    def write(self, batch: Batch) -> None:
        """Take a batch, and bring it out."""
        ...

    def close(self) -> None:
        """End."""
        ...


class Feed:
    """One outlet with its thread."""

    def __init__(self, sink: Sink, step: float) -> None:
        """Carry to ``sink``, from a run with that step [s]."""
        self.trouble = ""  # what has become of it, "" while all is well
        self.lost = 0  # pictures
        self.sink = sink
        self._gathering = Gathering(step)
        self._waiting: deque[Handed] = deque()
        self._called = threading.Event()
        self._room = threading.Event()
        self._closing = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=sink.name, daemon=True)
        self._thread.start()

    def hand(self, handed: Handed) -> None:
        """Take what is to be carried; an append, unless there is no room."""
        waiting = self._waiting
        if len(waiting) >= CHUNK and not self._make_room(handed):
            return
        waiting.append(handed)

    def end(self) -> None:
        """Carry what waits by the thread, and end."""
        self._closing.set()
        self._called.set()

    def close(self) -> None:
        """End, waiting for it no longer than the sink has patience."""
        self.end()
        if not self._over.wait(self.sink.patience):
            self._tell("it did not take all in time: its end is missing")
        elif self.lost:
            self._tell(f"{self.lost} ticks are missing: it did not take them in time")

    def _make_room(self, handed: Handed) -> bool:
        """Call the thread; return whether there is room, waiting for it where time is not kept."""
        if self._over.is_set():
            return False
        if not self._called.is_set():
            self._called.set()
        hurried = isinstance(handed, Taken) and math.isinf(handed.pace.speed)
        if len(self._waiting) < ROOM:
            return True
        self._room.clear()
        if len(self._waiting) >= ROOM and not (hurried and self._room.wait(LONGEST)):
            self.lost += isinstance(handed, Taken)
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
            self._tell(f"{reason(error)}; nothing more goes there")
        finally:
            self._over.set()
            self._waiting.clear()
            self._room.set()

    def _carry(self) -> None:
        """Carry what waits by now, piece by piece."""
        while count := min(len(self._waiting), CHUNK):
            handed = [self._waiting.popleft() for _ in range(count)]
            self._room.set()
            self.sink.write(self._gathering.batch(handed))


def reason(error: Exception) -> str:
    """Return what an error says, in one line."""
    told = str(error).splitlines() or [type(error).__name__]
    return told[0]


# The log hands the publisher's offers and all events to feeds as well.


@dataclass
class Log:
    """Sends what is subscribed as ``sending`` does, and feeds what there is to be fed."""

    sending: Publisher | Promptly
    ledger: Ledger
    feeds: Sequence[Feed]
    _last: tuple[int, bytes, Pace] | None = field(default=None, init=False)
    _told: set[str] = field(default_factory=set, init=False)

    @property
    def troubles(self) -> deque[str]:
        """Return the news for somebody to tell, with the end of a feed once."""
        for feed in self.feeds:
            if feed.trouble and feed.trouble not in self._told:
                self._told.add(feed.trouble)
                self.sending.troubles.append(feed.trouble)
        return self.sending.troubles

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Set the picture to send from now on."""
        self.sending.offer(tick, state, pace)
        ledger = self.ledger
        taken = Taken(tick, state, pace, ledger.ticks, ledger.lateness, ledger.work)
        self._last = tick, state, pace
        for feed in self.feeds:
            feed.hand(taken)

    def hear(self, news: News) -> None:
        """Take what has happened."""
        heard = Heard(news.tick, news.kind, news.text)
        for feed in self.feeds:
            feed.hand(heard)

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        self.sending.add(subscription)

    def strike(self, subscription: Subscription) -> None:
        """Send to a subscription no more."""
        self.sending.strike(subscription)

    def close(self, patience: float) -> None:
        """Send and feed what is due, waiting for each as long as it may take."""
        if self._last is not None:
            ledger = self.ledger  # the last tick's work has been timed only now
            taken = Taken(*self._last, ledger.ticks, ledger.lateness, ledger.work)
            for feed in self.feeds:
                feed.hand(taken)
        for feed in self.feeds:
            feed.end()
        self.sending.close(patience)
        for feed in self.feeds:
            feed.close()

    def account(self) -> int:
        """Print what has become of feeds that went wrong; return the exit code.

        A file that is not complete is one; a viewer that has gone is not.
        """
        for feed in self.feeds:
            if feed.trouble:
                click.echo(f"trainer: {feed.trouble}", err=True)
        return int(any(feed.trouble and feed.sink.needed for feed in self.feeds))
