"""The pacing of a run: when each tick is due, and what follows late ones.

Tick k is due at anchor + k h / speed, computed from k in integers, so nothing drifts. A loop reads

    pacer.run()
    while more:
        if pacer.wait(wake) is WAIT_WOKEN:
            wake.clear()  # then look at what arrived, and wait on for the same deadline
        else:
            pacer.begin()
            ...  # the work of one tick
            for event in pacer.end():
                print(event)

Everything but ``wake`` belongs to the one thread that runs the loop. Times are integer nanoseconds.

A tick may be late because its work took too long, because other programs held the processor, or
because the whole process was stopped (Ctrl-Z, a suspended laptop). The first two are lateness, and
are made up or slipped by a ``Policy``. The last is a gap: time goes on after it as if it had not
been. The clock and the processor time together tell them apart (``_look``).
"""

import math
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import partial
from typing import Final, Protocol

from trainer.session.time.ledger import SECOND_NS, Ledger

# A wait is cut in pieces: some systems deliver Ctrl-C, and notice a suspension, only between two.
MAX_NAP_NS: Final = SECOND_NS // 2  # [ns]
# Sleep ends a little before a deadline, and the rest is spun away: long enough to wake up, and to
# get the interpreter from a busy thread (SWITCH_INTERVAL_S); short enough to cost nothing.
SPIN_TIME_NS: Final = 300_000  # [ns]
MIN_TIME_SPEED, MAX_TIME_SPEED = 0.1, 100.0  # [-] speeds a pacer accepts
MAX_CATCH_UP = 5  # [-] late ticks run back to back before the rest are given up
# Oversleeping longer than this (and than a period) is not scheduling: the process was stopped. Such
# a gap is not made up: the boat would rush through it as soon as the process goes on.
STOPPED_TIME_NS = SECOND_NS // 4  # [ns]
# A tick may block for a while and is then late by its own doing; off the processor for more than
# this many periods (and STOPPED_TIME_NS) it was a stopped process too, or a debugger, which looks
# the same.
STOPPED_PERIODS = 4


class Clock(Protocol):
    """The clock as a pacer needs it."""

    def now(self) -> int:
        """Return a time [ns] that never runs backwards."""

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Return the time [ns] once ``deadline`` is past, 0 if ``wake`` is set before."""


class MonotonicClock:
    """The machine's own clock; counts a suspended machine's sleep where the system tells it."""

    now: Callable[[], int]  # [ns]; nothing of Python's is between the system and its caller

    def __init__(self) -> None:
        self.now = time.perf_counter_ns
        if sys.platform == "linux":
            self.now = partial(time.clock_gettime_ns, time.CLOCK_BOOTTIME)

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""
        return time.thread_time_ns()

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Return the time [ns] once ``deadline`` is past, 0 if ``wake`` is set before."""
        now, woken = self.now, wake.is_set
        while (remaining := deadline - SPIN_TIME_NS - now()) > 0:
            if wake.wait(min(remaining, MAX_NAP_NS) / SECOND_NS):
                return reached if (reached := now()) >= deadline else 0
        while (reached := now()) < deadline:
            if woken():
                return 0
        return reached


class Policy(Enum):
    """What follows a tick that ends after the next deadline."""

    SLIP = "slip"  # the schedule moves: simulated time is lost
    CATCH_UP = "catch-up"  # late ticks run back to back, at most MAX_CATCH_UP, then slip
    FREEZE = "freeze"  # stop until told to run


class WaitResult(Enum):
    """Why a wait came back."""

    DUE = "due"
    WOKEN = "woken"


# Names of their own, because looking up a member of an Enum calls a Python function each time.
WAIT_DUE, WAIT_WOKEN = WaitResult.DUE, WaitResult.WOKEN


class PacerEventKind(Enum):
    """The messages of a pacer."""

    SLIPPED = "slipped: the deadline had passed by"
    FROZE = "froze: the deadline had passed by"
    GAP = "the process was not running for"


@dataclass(frozen=True)
class PacerEvent:
    """One thing worth telling the user."""

    what: PacerEventKind
    tick: int  # [-] ticks begun so far
    length: int  # [ns]

    def __str__(self) -> str:
        return f"tick {self.tick}: {self.what.value} {self.length / SECOND_NS:.3f} s"


class Pacer:
    """Ticks of h at a speed against the clock; frozen until told to run."""

    def __init__(self, clock: Clock, ledger: Ledger, speed: float, policy: Policy) -> None:
        """Take the speed [-]; ValueError outside MIN_TIME_SPEED to MAX_TIME_SPEED."""
        self.ledger, self.frozen = ledger, True
        self._clock, self._policy = clock, policy
        self._set_period(_period(ledger.step, speed))
        self._left = Fraction(0)  # [-] of the period, from the freeze to the tick after it
        self._woke = 0  # when the last wait ended with a tick due, 0 once that has begun
        self._anchor = self._tick = 0
        self._next = 0  # when the next tick is due: at anchor + tick * period
        self._deadline = self._start = 0  # of the tick at work
        self._seen = self._seen_cpu = 0  # when the thread was last known to be running
        self._in_a_row = 0
        self._listened = False  # a wait has ended in WAIT_WOKEN since the last tick
        self._events: list[PacerEvent] = []

    def run(self) -> None:
        """Go on where the freeze stopped, as if no time had passed."""
        if self.frozen:
            now = self._clock.now()
            self.frozen = False
            self._look(now)
            self._reanchor(now + int(self._left * self._period))

    def freeze(self) -> None:
        """Stop the ticks until ``run``. Lateness is forgiven."""
        self._woke = 0
        if not self.frozen:
            self.frozen = True
            self._left = max((self._next - self._clock.now()) / self._period, Fraction(0))

    def set_speed(self, speed: float) -> None:
        """Change the speed [-]; lateness is forgiven. ValueError beyond its limits."""
        period = _period(self.ledger.step, speed)
        running = not self.frozen
        self.freeze()
        self._set_period(period)
        if running:
            self.run()

    def wait(self, wake: threading.Event) -> WaitResult:
        """Return WAIT_DUE at the next tick, WAIT_WOKEN if ``wake`` is set before or while frozen.

        A late tick lets arrived orders be heard once, and then goes on, because a flood of orders
        must not hold it up.
        """
        if self.frozen:
            _wait_frozen(self._clock, wake)
            self._listened = True
            return WAIT_WOKEN
        entered = self._clock.now()
        if still := self._look(entered):
            self._gap(still, entered)
        due = self._next
        if entered >= due and not self._listened and wake.is_set():
            self._listened = True
            return WAIT_WOKEN
        awaited = max(due, entered)
        latest = awaited + self._overslept
        reached = self._clock.wait_until(due, wake)
        now = reached or self._clock.now()
        if now > latest:
            self._gap(now - awaited, now)
        self._seen = now  # it has slept since, and used the processor for SPIN_TIME_NS at most
        self._woke = reached
        self._listened = not reached
        return WAIT_DUE if reached else WAIT_WOKEN

    def begin(self) -> None:
        """Start the work of a tick, also a single one in a freeze.

        What is done between the end of its wait and this is work too.
        """
        woke, self._woke = self._woke, 0
        start = self._start = woke or self._clock.now()
        if self.frozen:
            self._look(start)
            self._deadline = start
            return
        if not woke and (still := self._still(start)):
            self._gap(still, start)
        due = self._deadline = self._next
        self._tick += 1
        self._next = self._anchor + self._tick * self._numerator // self._denominator
        if start - due > self._whole:
            self._in_a_row += 1
            self.ledger.caught_up += 1
        else:
            self._in_a_row = 0

    def end(self) -> tuple[PacerEvent, ...]:
        """End the work of a tick; return what has happened since the last one."""
        now = self._clock.now()
        still = self._still(now)
        self.ledger.record(self._deadline, self._start, max(now - self._start - still, 0))
        if not self.frozen:
            if still:
                self._gap(still, now + self._whole)
            else:
                self._judge(now)
        if not self._events:
            return ()
        events, self._events = tuple(self._events), []
        return events

    def _judge(self, now: int) -> None:
        due = self._next
        # A tick begun after this deadline is late by the fault of another: own work alone counts.
        if now > (due if self._start <= due else self._start + self._whole):
            self.ledger.overruns += 1
        if now <= due:
            return
        exhausted = self._in_a_row >= MAX_CATCH_UP and now - due > self._whole
        if self._policy is Policy.FREEZE:
            self._say(PacerEventKind.FROZE, now - due)
            self.freeze()
        elif self._policy is Policy.SLIP or exhausted:
            self._say(PacerEventKind.SLIPPED, now - due)
            last_passed = math.ceil((now + 1 - self._anchor) / self._period) - 1
            self.ledger.skipped += last_passed - self._tick + 1
            self._reanchor(max(now, self._start + self._whole))

    def _gap(self, length: int, due: int) -> None:
        self.ledger.gaps += 1
        self.ledger.gap_ns += length
        self._say(PacerEventKind.GAP, length)
        self._reanchor(due)

    def _still(self, now: int) -> int:
        """Return what ``_look`` does, without asking the system if too little time has passed."""
        return self._look(now) if now - self._seen > self._stopped else 0

    def _look(self, now: int) -> int:
        """Return how long [ns] the process was stopped since the last look, 0 if briefly."""
        seen, seen_cpu = self._seen, self._seen_cpu
        self._seen, self._seen_cpu = now, self._clock.cpu()
        still = (now - seen) - (self._seen_cpu - seen_cpu)
        return still if still > self._stopped else 0

    def _say(self, what: PacerEventKind, length: int) -> None:
        self._events.append(PacerEvent(what, self.ledger.ticks, length))

    def _set_period(self, period: Fraction) -> None:
        # fractions are slow, and between a deadline and its tick every microsecond is lateness;
        # a whole number is beyond the period where it is beyond the whole of it
        self._period, self._whole = period, int(period)
        self._numerator, self._denominator = period.numerator, period.denominator
        self._overslept = max(int(period), STOPPED_TIME_NS)
        self._stopped = max(int(STOPPED_PERIODS * period), STOPPED_TIME_NS)

    def _reanchor(self, due: int) -> None:
        self._anchor = self._next = due
        self._tick = 0


class FreePacer:
    """A pacer as fast as the machine allows. It has no deadlines to miss."""

    def __init__(self, clock: Clock, ledger: Ledger) -> None:
        self.ledger, self.frozen = ledger, True
        self._clock = clock
        self._start = 0
        self._listening = False  # the last wait was woken: a flood of input shares with the ticks

    def run(self) -> None:
        """Make every tick due at once."""
        self.frozen = False

    def freeze(self) -> None:
        """Stop the ticks until ``run``."""
        self.frozen = True

    def wait(self, wake: threading.Event) -> WaitResult:
        """Return WAIT_WOKEN if ``wake`` is set, else WAIT_DUE; in a freeze wait for ``wake``."""
        if self.frozen:
            _wait_frozen(self._clock, wake)
        self._listening = wake.is_set() and not (self._listening and not self.frozen)
        return WAIT_WOKEN if self._listening else WAIT_DUE

    def begin(self) -> None:
        """Start the work of a tick."""
        self._start = self._clock.now()

    def end(self, count: int = 1) -> tuple[PacerEvent, ...]:
        """End the work of a tick, or of so many at once. Nothing can have happened."""
        work = (self._clock.now() - self._start) // count
        self.ledger.record(self._start, self._start, work, count)
        return ()


def _period(step: Fraction, speed: float) -> Fraction:
    if not MIN_TIME_SPEED <= speed <= MAX_TIME_SPEED:
        raise ValueError(f"speed {speed} is not between {MIN_TIME_SPEED:g} and {MAX_TIME_SPEED:g}")
    return step * SECOND_NS / Fraction(str(speed))


def _wait_frozen(clock: Clock, wake: threading.Event) -> None:
    """Wait until ``wake`` is set: in a freeze no tick is due."""
    while clock.wait_until(clock.now() + MAX_NAP_NS, wake):
        pass
