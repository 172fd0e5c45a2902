"""The timekeeping of the ticks: their speed, their slips, and what the system grants them.

``session`` and ``control`` run time by it. The process asks the system for a real-time priority and
locked memory, reports the answer, and gives them back. All threads get the priority, not only the
one that ticks: a ticking thread that waits for the interpreter would else wait for whatever keeps
its holder off the processor. New threads inherit the priority of the thread that starts them.
"""

import contextlib
import ctypes
import math
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from trainer.session.time.ledger import SECOND_NS, Ledger
from trainer.session.time.pacer import (
    MAX_CATCH_UP,
    MIN_TIME_SPEED,
    Clock,
    FreePacer,
    Pacer,
    PacerEvent,
    PacerEventKind,
    Policy,
)

# [s] after which a thread may ask another for the interpreter. Python's own 5 ms would outlast the
# spinning before a tick (SPIN_TIME_NS); by this, a busy thread has handed it over when that is due.
SWITCH_INTERVAL_S: Final = 120e-6
# Real-time priorities. All threads have one, not only that which ticks: it may have to wait for the
# interpreter, and so for whatever keeps the thread that holds it off the processor.
TICK_PRIORITY: Final = 20  # of the thread that ticks
OTHER_PRIORITY: Final = 10  # of the others
THREADS_FOLDER: Final = Path("/proc/self/task")
SET_TIMER_SLACK: Final = 29  # of prctl
IN_USE: Final = 1 | 2 | 4  # of mlockall: now and later, but nothing that is merely set aside
NOT_PERMITTED: Final = "not permitted"
NOT_AVAILABLE: Final = "not on this system"
QUIET_TIME_NS: Final = 10 * SECOND_NS  # [ns] without a slip, after which the next one is announced
SLIP_TIME_NS: Final = SECOND_NS  # [ns] of slipping until the speed falls
# [-] overruns in that time; a machine that stumbles once or twice keeps its speed
MIN_OVERRUNS: Final = 5
TICK_SHARE: Final = 0.8  # [-] of the clock that ticks take at the lower speed (docs/timing.md)


@dataclass(frozen=True)
class PunctualityResult:
    """The answers of the system to the demands for punctuality, in words."""

    priority: str = "normal"
    memory: str = "not locked"
    timer: str = "usual"

    def line(self) -> str:
        """Return it in one line."""
        return f"priority {self.priority}, memory {self.memory}, timer slack {self.timer}"


class NoPunctuality:
    """No demands on the system, for runs without deadlines, and for tests."""

    granted: PunctualityResult | None = None

    def keep(self) -> None:
        """Do nothing."""

    def relax(self) -> None:
        """Do nothing."""


class Punctuality:
    """The demands of the ticking thread and its process while time is kept."""

    def __init__(self, *, realtime: bool) -> None:
        """``realtime``: also what can slow down others, a real-time priority and locked memory."""
        self.granted: PunctualityResult | None = None  # at the last time it was asked for
        self._realtime = realtime
        self._interval = 0.0  # [s] what it was; 0 while nothing has been asked for

    def keep(self) -> None:
        """Make all demands, unless they are made. The short waits are the calling thread's."""
        if self._interval:
            return
        self._interval = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        timer = "1 ns" if _timer_slack(1) else f"usual ({NOT_AVAILABLE})"
        more = self._realtime
        self.granted = (
            PunctualityResult(_raise(), _lock(), timer) if more else PunctualityResult(timer=timer)
        )

    def relax(self) -> None:
        """Take back all demands, if they are made."""
        if not self._interval:
            return
        sys.setswitchinterval(self._interval)
        self._interval = 0.0
        _timer_slack(0)  # what it was
        if self._realtime and sys.platform == "linux":
            with contextlib.suppress(PermissionError):
                _schedule(os.SCHED_OTHER, 0, 0)
            ctypes.CDLL(None).munlockall()


def _raise() -> str:
    """Give every thread a real-time priority; return what came of it."""
    if sys.platform != "linux":
        return f"normal (real-time: {NOT_AVAILABLE})"
    try:
        _schedule(os.SCHED_FIFO, TICK_PRIORITY, OTHER_PRIORITY)
    except PermissionError:
        return f"normal (real-time: {NOT_PERMITTED})"
    return "real-time"


def _schedule(policy: int, first: int, rest: int) -> None:
    """Put all threads under a policy, the first with its own priority; PermissionError."""
    if sys.platform != "linux":
        return
    for thread in (int(path.name) for path in THREADS_FOLDER.iterdir()):
        level = os.sched_param(first if thread == os.getpid() else rest)
        with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
            os.sched_setscheduler(thread, policy, level)


def _lock() -> str:
    """Keep the memory of the process from being paged out; return what came of it."""
    if sys.platform != "linux":
        return f"not locked ({NOT_AVAILABLE})"
    done = ctypes.CDLL(None).mlockall(IN_USE)
    return "locked" if done == 0 else f"not locked ({NOT_PERMITTED})"


def _timer_slack(nanoseconds: int) -> bool:
    """Limit how late this thread's waits end, 0 for the usual. Return whether that worked."""
    if sys.platform != "linux":
        return False
    return bool(ctypes.CDLL(None).prctl(SET_TIMER_SLACK, nanoseconds, 0, 0, 0) == 0)


@dataclass(frozen=True)
class LedgerMark:
    """Where the ledger stood at a moment of the clock."""

    now: int  # [ns]
    ticks: int
    overruns: int


class SlipJudge:
    """Slips that follow each other, announced once and judged as a whole."""

    def __init__(self) -> None:
        self._begun: LedgerMark | None = None  # of those at the present speed
        self._latest: LedgerMark | None = None

    def begin(self, mark: LedgerMark) -> bool:
        """Take a slip; return whether it is the first after a quiet time."""
        latest, self._latest = self._latest, mark
        first = latest is None or (
            mark.now - latest.now > QUIET_TIME_NS and mark.ticks - latest.ticks > MAX_CATCH_UP + 1
        )
        if first or self._begun is None:
            self._begun = mark
        return first

    def change(self) -> None:
        """Judge only later slips, because the speed of time has changed."""
        self._begun = None

    def cost(self, mark: LedgerMark) -> float:
        """Return how long [ns] a tick takes where ticks cannot keep up. 0: they can.

        They cannot if at least half of them overran. Fewer overruns are the fault of other programs
        that hold the machine up.
        """
        begun = self._begun
        if begun is None or mark.now - begun.now < SLIP_TIME_NS:
            return 0.0
        ticks, overruns = mark.ticks - begun.ticks, mark.overruns - begun.overruns
        return (mark.now - begun.now) / ticks if overruns >= max(MIN_OVERRUNS, ticks / 2) else 0.0


def keeper(clock: Clock, ledger: Ledger, speed: float, policy: Policy) -> Pacer | FreePacer:
    """Return what paces ticks at ``speed``. An infinite speed is as fast as the machine allows."""
    if math.isinf(speed):
        return FreePacer(clock, ledger)
    return Pacer(clock, ledger, speed, policy)


@dataclass
class Timekeeping:
    """The clock, the ledger, and the pacer of the moment."""

    clock: Clock
    ledger: Ledger
    policy: Policy
    pacer: Pacer | FreePacer
    speed: float  # [-]
    punctuality: Punctuality | NoPunctuality = field(default_factory=NoPunctuality)
    slips: SlipJudge = field(default_factory=SlipJudge)
    fallen_from: float = 0.0  # [-] the speed that was asked for and is not held, 0 where it is

    @classmethod
    def at(cls, clock: Clock, step: float, speed: float, policy: Policy) -> "Timekeeping":
        """Return the keeping of time at ``speed``, infinity for as fast as it goes."""
        ledger = Ledger(step)
        return cls(clock, ledger, policy, keeper(clock, ledger, speed, policy), speed)

    @property
    def frozen(self) -> bool:
        """Return whether time stands still."""
        return self.pacer.frozen

    @contextlib.contextmanager
    def attended(self) -> Iterator[None]:
        """Make the demands inside the block, in the ticking thread."""
        self._attend()
        try:
            yield
        finally:
            self.punctuality.relax()

    def change(self, speed: float) -> None:
        """Set the speed of time from now on."""
        self.speed, self.fallen_from = speed, 0.0
        self.slips.change()
        self._attend()
        if math.isfinite(speed) and isinstance(self.pacer, Pacer):
            self.pacer.set_speed(speed)
            return
        frozen = self.pacer.frozen
        self.pacer = keeper(self.clock, self.ledger, speed, self.policy)
        if not frozen:
            self.pacer.run()

    def judge(self, events: tuple[PacerEvent, ...]) -> list[tuple[str, str]]:
        """Return the messages of a tick's events, each with its kind.

        Slips that follow each other are one message. Where ticks take longer than the clock gives
        them, the speed falls to what the machine holds.
        """
        messages = []
        for event in events:
            if event.what is not PacerEventKind.SLIPPED:
                messages.append(("trouble", str(event)))
                continue
            mark = LedgerMark(self.clock.now(), self.ledger.ticks, self.ledger.overruns)
            if self.slips.begin(mark):
                messages.append(("trouble", str(event)))
            elif cost := self.slips.cost(mark):
                messages.append(("time", self._fall(cost)))
        return messages

    def _fall(self, cost: float) -> str:
        """Let time go no faster than ticks that cost so much [ns] allow; return it in words."""
        asked_speed, before = self.speed, self.fallen_from or self.speed
        held = TICK_SHARE * float(self.ledger.step) * SECOND_NS / cost
        self.change(max(float(f"{min(held, TICK_SHARE * asked_speed):.2g}"), MIN_TIME_SPEED))
        self.fallen_from = before
        return (
            f"time x{asked_speed:g} is more than this machine holds: x{self.speed:g} from here on"
        )

    def _attend(self) -> None:
        """Make the demands where time is kept. A run as fast as it goes has no deadline to miss."""
        (self.punctuality.keep if math.isfinite(self.speed) else self.punctuality.relax)()
