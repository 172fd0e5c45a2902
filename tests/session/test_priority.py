"""What a system is asked for by a run that keeps time, and that it is all given back."""

import os
import sys
import threading

import pytest

from trainer.session.time import timekeeping
from trainer.session.time.ledger import SECOND_NS
from trainer.session.time.pacer import SPIN_TIME_NS, MonotonicClock, Policy
from trainer.session.time.timekeeping import (
    NOT_PERMITTED,
    SWITCH_INTERVAL_S,
    Punctuality,
    Timekeeping,
)

linux = pytest.mark.skipif(sys.platform != "linux", reason="as Linux has it")


@pytest.fixture
def policies(monkeypatch: pytest.MonkeyPatch) -> dict[int, tuple[int, int]]:
    """Return policy and priority by thread, as they would be set."""
    given: dict[int, tuple[int, int]] = {}

    def schedule(thread: int, policy: int, level: os.sched_param) -> None:
        given[thread] = policy, level.sched_priority

    monkeypatch.setattr(os, "sched_setscheduler", schedule)
    monkeypatch.setattr(timekeeping, "_lock", lambda: "locked")
    return given


@linux
def test_every_thread_is_raised_the_ticking_one_above_the_others_and_all_are_put_back(
    policies: dict[int, tuple[int, int]],
) -> None:
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    asked = Punctuality(realtime=True)
    asked.keep()
    raised = dict(policies)
    asked.relax()
    over.set()
    other.join()

    assert raised[os.getpid()] == (os.SCHED_FIFO, timekeeping.TICK_PRIORITY)
    assert raised[other.native_id or 0] == (os.SCHED_FIFO, timekeeping.OTHER_PRIORITY)
    assert timekeeping.TICK_PRIORITY > timekeeping.OTHER_PRIORITY
    assert set(policies.values()) == {(os.SCHED_OTHER, 0)}


@linux
def test_what_is_not_permitted_is_said_and_done_without(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    asked = Punctuality(realtime=True)
    asked.keep()
    asked.relax()

    assert asked.granted
    assert f"priority normal (real-time: {NOT_PERMITTED})" in asked.granted.line()


def test_the_interpreter_changes_hands_sooner_while_time_is_kept_and_not_after() -> None:
    before = sys.getswitchinterval()
    asked = Punctuality(realtime=False)
    asked.keep()
    asked.keep()
    during = sys.getswitchinterval()
    asked.relax()

    assert during == pytest.approx(SWITCH_INTERVAL_S)
    assert sys.getswitchinterval() == before


def test_sleep_ends_early_enough_to_get_the_interpreter_from_a_busy_thread() -> None:
    # it asks after SWITCH_INTERVAL_S, and a busy thread asks for it back after as long again
    assert SWITCH_INTERVAL_S * SECOND_NS < SPIN_TIME_NS < 3 * SWITCH_INTERVAL_S * SECOND_NS


def test_a_run_that_goes_as_fast_as_it_can_has_no_precedence_over_others() -> None:
    time = Timekeeping.at(MonotonicClock(), 0.5, 1.0, Policy.CATCH_UP)
    done: list[str] = []

    class Asked(Punctuality):
        def keep(self) -> None:
            done.append("keep")

        def relax(self) -> None:
            done.append("relax")

    time.punctuality = Asked(realtime=True)
    with time.attended():
        time.change(float("inf"))
        time.change(2.0)

    assert done == ["keep", "relax", "keep", "relax"]


class Late:
    """A clock whose every reading is a little later; it wakes exactly in time."""

    def __init__(self) -> None:
        self.time = 0

    def now(self) -> int:
        self.time += 1000
        return self.time

    def cpu(self) -> int:
        return self.time

    def wait_until(self, deadline: int, _wake: threading.Event) -> int:
        self.time = max(self.time, deadline)
        return self.now()


def test_what_is_done_between_a_wait_and_its_tick_is_work_and_not_lateness() -> None:
    clock = Late()
    time = Timekeeping.at(clock, 0.5, 1.0, Policy.CATCH_UP)
    time.pacer.run()
    time.pacer.wait(threading.Event())
    clock.time += 7_000_000  # orders of the schedule are carried out
    time.pacer.begin()
    time.pacer.end()

    ledger = time.ledger.summary()
    assert ledger.lateness.max_ns < 10_000
    assert ledger.work.max_ns > 7_000_000


def test_a_wake_is_heeded_in_the_last_moment_before_a_deadline_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = MonotonicClock()
    readings = iter(range(0, SPIN_TIME_NS, 1000))
    monkeypatch.setattr(clock, "now", lambda: next(readings))
    wake = Set(after=3)

    assert not clock.wait_until(SPIN_TIME_NS, wake)
    assert next(readings) < SPIN_TIME_NS // 2


class Set(threading.Event):
    """An event that is set after some looks at it."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self.looks = after

    def is_set(self) -> bool:
        self.looks -= 1
        return self.looks < 0
