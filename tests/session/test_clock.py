"""The pacer and its ledger, on a clock of the test's own and on the real one."""

import dataclasses
import itertools
import threading
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest

from trainer.session.time.ledger import SECOND_NS, Histogram, Ledger
from trainer.session.time.pacer import (
    MAX_CATCH_UP,
    MIN_TIME_SPEED,
    FreePacer,
    MonotonicClock,
    Pacer,
    PacerEvent,
    PacerEventKind,
    Policy,
    WaitResult,
)
from trainer.session.time.timekeeping import Timekeeping

PERIOD = SECOND_NS // 2  # [ns] of the step 0.5 s at speed 1, which most tests use


class FakeClock:
    """Time that passes only when a test says so."""

    def __init__(self) -> None:
        self.time = self.used = 12_345
        self.oversleep = self.asked = 0

    def now(self) -> int:
        return self.time

    def cpu(self) -> int:
        self.asked += 1
        return self.used

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        if wake.is_set() and self.time < deadline:
            return 0
        self.time = max(self.time, deadline) + self.oversleep
        self.oversleep = 0
        return self.time

    def work(self, duration: int) -> None:
        self.time += duration
        self.used += duration

    def stand_still(self, duration: int) -> None:
        self.time += duration


class Entry(NamedTuple):
    """One tick as it was entered [ns]."""

    deadline: int
    start: int
    work: int


class DetailedLedger(Ledger):
    """A ledger that keeps every tick."""

    def __init__(self, step: float) -> None:
        super().__init__(step)
        self.rows: list[Entry] = []

    def record(self, deadline: int, start: int, work: int, count: int = 1) -> None:
        """Enter one tick [ns], and keep it."""
        super().record(deadline, start, work, count)
        self.rows += [Entry(deadline, start, work)] * count


class Bench:
    """A running pacer on a fake clock, and the start of every tick since."""

    def __init__(
        self, policy: Policy = Policy.CATCH_UP, step: float = 0.5, speed: float = 1.0
    ) -> None:
        self.clock, self.ledger, self.wake = FakeClock(), DetailedLedger(step), threading.Event()
        self.pacer = Pacer(self.clock, self.ledger, speed, policy)
        self.begun = self.clock.time
        self.starts: list[int] = []
        self.pacer.run()

    def tick(self, *works: int) -> list[PacerEvent]:
        """Do ticks of these lengths [ns]; return the events."""
        events: list[PacerEvent] = []
        for work in works:
            assert self.pacer.wait(self.wake) is WaitResult.DUE
            self.pacer.begin()
            self.starts.append(self.clock.time - self.begun)
            self.clock.work(work)
            events += self.pacer.end()
        return events

    def spacings(self) -> list[float]:
        """Return the times between the starts of ticks [period of 0.5 s]."""
        return [(b - a) / PERIOD for a, b in itertools.pairwise(self.starts)]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def periods(number: float) -> int:
    return int(number * PERIOD)


def test_a_million_ticks_do_not_drift_by_a_nanosecond() -> None:
    bench = Bench(step=0.1, speed=3.0)
    for _ in range(999_999):
        bench.pacer.begin()  # a deadline depends on the number of the tick, not on the wait
    bench.tick(0)

    assert bench.starts == [33_333_300_000_000]  # 999 999 * 0.1 s / 3
    bench.tick(0)
    assert bench.starts[-1] == 33_333_333_333_333  # 1 000 000 * 0.1 s / 3, rounded down


@pytest.mark.parametrize(("step", "speed"), [(0.1, 3.0), (0.5, 0.7), (0.3, 1.0), (1, 99.9)])
def test_every_deadline_is_the_exact_product_rounded_down(step: float, speed: float) -> None:
    bench = Bench(step=step, speed=speed)
    bench.tick(*[0] * 500)

    period = Fraction(str(step)) / Fraction(str(speed)) * SECOND_NS
    assert bench.starts == [int(k * period) for k in range(500)]


def test_nothing_is_due_before_run_and_in_a_freeze() -> None:
    clock, wake = FakeClock(), threading.Event()
    pacer = Pacer(clock, Ledger(0.5), 1.0, Policy.CATCH_UP)
    wake.set()

    assert pacer.frozen
    assert pacer.wait(wake) is WaitResult.WOKEN
    pacer.run()
    assert not pacer.frozen
    assert pacer.wait(wake) is WaitResult.DUE
    pacer.freeze()
    clock.stand_still(periods(10))
    assert pacer.wait(wake) is WaitResult.WOKEN


def test_an_hour_of_freeze_is_followed_by_the_rest_of_the_period_and_no_burst(bench: Bench) -> None:
    bench.tick(periods(0.25))
    bench.pacer.freeze()
    bench.clock.stand_still(3600 * SECOND_NS)
    bench.pacer.run()
    events = bench.tick(0, 0, 0)

    assert bench.spacings() == [7201.0, 1.0, 1.0]
    assert events == []
    summary = bench.ledger.summary()
    assert (summary.gaps, summary.skipped, summary.caught_up, summary.overruns) == (0, 0, 0, 0)


def test_a_new_speed_scales_the_rest_of_the_period(bench: Bench) -> None:
    bench.tick(periods(0.5))
    bench.pacer.set_speed(10.0)
    bench.tick(0, 0)
    bench.pacer.set_speed(0.1)
    bench.tick(0)

    assert bench.spacings() == [0.55, 0.1, 10.0]


def test_a_new_speed_in_a_freeze_stays_frozen(bench: Bench) -> None:
    bench.tick(0)
    bench.pacer.freeze()
    bench.pacer.set_speed(2.0)
    assert bench.pacer.frozen
    bench.pacer.run()
    bench.tick(0)

    assert bench.spacings() == [0.5]


def test_slip_gives_up_the_deadlines_that_passed_and_goes_on_from_there() -> None:
    bench = Bench(Policy.SLIP)
    events = bench.tick(0, periods(2.5), 0, 0)

    assert bench.spacings() == [1.0, 2.5, 1.0]
    assert [(e.what, e.length) for e in events] == [(PacerEventKind.SLIPPED, periods(1.5))]
    summary = bench.ledger.summary()
    assert (summary.overruns, summary.skipped, summary.caught_up) == (1, 2, 0)


def test_catch_up_runs_late_ticks_at_once_until_the_schedule_is_met() -> None:
    bench = Bench(Policy.CATCH_UP)
    events = bench.tick(0, periods(3.5), 0, 0, 0, 0)

    assert bench.spacings() == [1.0, 3.5, 0.0, 0.0, 0.5]
    assert events == []
    summary = bench.ledger.summary()
    # Deadlines 1 and 2 periods on were more than a period away, the third only half of one.
    assert (summary.overruns, summary.skipped, summary.caught_up) == (1, 0, 2)


def test_catch_up_stops_after_five_ticks_slips_and_says_so() -> None:
    bench = Bench(Policy.CATCH_UP)
    events = bench.tick(periods(8.5), *[0] * 7)

    # Five back to back, then a full period; deadlines 6, 7 and 8 had passed and are given up.
    assert bench.spacings() == [8.5, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]
    assert [(e.what, e.length) for e in events] == [(PacerEventKind.SLIPPED, periods(2.5))]
    summary = bench.ledger.summary()
    assert (summary.overruns, summary.skipped, summary.caught_up) == (1, 3, MAX_CATCH_UP)


def test_an_overload_for_good_counts_every_tick_and_keeps_slipping() -> None:
    bench = Bench(Policy.CATCH_UP)
    events = bench.tick(*[periods(2)] * 14)

    assert set(bench.spacings()) == {2.0}
    # The second tick is just one period late, the next five are caught up; then all over again.
    assert [e.tick for e in events if e.what is PacerEventKind.SLIPPED] == [7, 14]
    summary = bench.ledger.summary()
    assert (summary.overruns, summary.caught_up) == (14, 2 * MAX_CATCH_UP)


def test_freeze_on_overrun_stops_says_so_and_runs_on_without_a_burst() -> None:
    bench = Bench(Policy.FREEZE)
    events = bench.tick(0, periods(1.5))

    assert [(e.what, e.length) for e in events] == [(PacerEventKind.FROZE, periods(0.5))]
    assert str(events[0]) == "tick 2: froze: the deadline had passed by 0.250 s"
    assert bench.pacer.frozen
    bench.clock.stand_still(periods(20))
    bench.pacer.run()
    bench.tick(0, 0)
    assert bench.spacings() == [1.0, 21.5, 1.0]
    assert bench.ledger.summary().overruns == 1


@pytest.mark.parametrize("step", [0.5, 1.0])
@pytest.mark.parametrize("policy", Policy)
def test_a_process_stopped_in_the_wait_goes_on_without_a_burst(step: float, policy: Policy) -> None:
    bench = Bench(policy, step)
    bench.tick(0, 0)
    bench.clock.oversleep = 5 * SECOND_NS
    events = bench.tick(0, 0, 0)

    own = step * SECOND_NS / PERIOD
    assert bench.spacings() == [own, own + 10.0, own, own]
    assert [(e.what, e.length) for e in events] == [(PacerEventKind.GAP, 5 * SECOND_NS)]
    summary = bench.ledger.summary()
    assert (summary.gaps, summary.gap_ns) == (1, 5 * SECOND_NS)
    assert (summary.overruns, summary.caught_up, summary.skipped) == (0, 0, 0)


@pytest.mark.parametrize("step", [0.5, 1.0])
def test_a_process_stopped_in_the_work_goes_on_without_a_burst(step: float) -> None:
    bench = Bench(step=step)
    bench.pacer.wait(bench.wake)
    bench.pacer.begin()
    bench.clock.work(1000)
    bench.clock.stand_still(5 * SECOND_NS)
    end = bench.clock.time - bench.begun
    events = bench.pacer.end()
    bench.tick(0, 0)

    assert bench.starts[0] - end == step * SECOND_NS
    assert [(e.what, e.length) for e in events] == [(PacerEventKind.GAP, 5 * SECOND_NS)]
    summary = bench.ledger.summary()
    assert (summary.gaps, summary.overruns, summary.work.max_ns) == (1, 0, 1000)


def test_a_process_stopped_while_an_order_is_handled_goes_on_without_a_burst(bench: Bench) -> None:
    bench.tick(0)
    bench.wake.set()
    bench.pacer.wait(bench.wake)
    bench.wake.clear()
    bench.clock.stand_still(5 * SECOND_NS)
    bench.tick(0, 0, 0)

    assert bench.spacings() == [10.0, 1.0, 1.0]
    assert bench.ledger.summary().gaps == 1


def test_a_tick_that_blocks_for_three_periods_is_an_overrun_not_a_gap(bench: Bench) -> None:
    bench.pacer.wait(bench.wake)
    bench.pacer.begin()
    bench.clock.stand_still(periods(3))
    bench.pacer.end()

    summary = bench.ledger.summary()
    assert (summary.overruns, summary.gaps, summary.work.max_ns) == (1, 0, periods(3))


def test_no_tick_on_time_asks_the_system_for_its_processor_time(bench: Bench) -> None:
    for _ in range(3):
        bench.pacer.wait(bench.wake)
        asked = bench.clock.asked
        bench.pacer.begin()
        bench.clock.work(periods(0.4))
        bench.pacer.end()

        assert bench.clock.asked == asked


def test_a_single_step_in_a_freeze_is_recorded_on_time(bench: Bench) -> None:
    bench.tick(0)
    bench.pacer.freeze()
    bench.clock.stand_still(periods(30))
    bench.pacer.begin()
    bench.clock.work(9)
    assert bench.pacer.end() == ()

    assert (bench.ledger.work, bench.ledger.lateness) == (9, 0)


def test_unpaced_ticks_are_always_due_and_their_work_is_still_measured() -> None:
    clock, wake, ledger = FakeClock(), threading.Event(), Ledger(0.5)
    pacer = FreePacer(clock, ledger)
    pacer.run()
    for _ in range(10):
        assert pacer.wait(wake) is WaitResult.DUE
        pacer.begin()
        clock.work(periods(0.2))
        assert pacer.end() == ()

    assert clock.time == 12_345 + periods(2)
    assert ledger.summary().duty_cycle == pytest.approx(0.2, rel=1e-12)


def test_unpaced_hears_orders_and_freezes() -> None:
    wake = threading.Event()
    pacer = FreePacer(MonotonicClock(), Ledger(0.5))
    pacer.run()
    wake.set()
    assert pacer.wait(wake) is WaitResult.WOKEN

    pacer.freeze()
    wake.clear()
    threading.Timer(0.05, wake.set).start()
    assert pacer.wait(wake) is WaitResult.WOKEN


@pytest.mark.parametrize("speed", [0.0, 0.09, 100.1, -1.0, float("nan"), float("inf")])
def test_a_speed_out_of_range_is_refused_and_changes_nothing(bench: Bench, speed: float) -> None:
    bench.tick(0)
    with pytest.raises(ValueError, match=r"not between 0\.1 and 100"):
        bench.pacer.set_speed(speed)
    bench.tick(0)

    assert bench.spacings() == [1.0]


@pytest.mark.parametrize("step", [0.0, -0.5, float("nan"), float("inf")])
def test_a_step_that_is_no_time_is_refused(step: float) -> None:
    with pytest.raises(ValueError, match="not a finite time above 0"):
        Ledger(step)


def test_percentiles_are_at_most_a_thirty_second_too_high_and_never_too_low() -> None:
    durations = np.random.default_rng(1).lognormal(11, 2, 20_000).astype(int)
    histogram = Histogram()
    for duration in durations.tolist():
        histogram.add(duration)

    spread = histogram.spread()
    found = np.array([spread.p50_ns, spread.p99_ns, spread.p999_ns])
    true = np.percentile(durations, [50, 99, 99.9], method="inverted_cdf")
    assert np.all(found >= true)
    assert np.all(found <= true * (1 + 1 / 32))
    assert spread.max_ns == durations.max()


@pytest.mark.parametrize("duration", [0, 1, 63, 64, 65, 10**9, 2**63 - 1])
def test_a_lone_duration_is_every_percentile(duration: int) -> None:
    histogram = Histogram()
    histogram.add(duration)

    assert set(dataclasses.astuple(histogram.spread())) == {duration}


def test_the_real_wait_ends_at_the_deadline_or_when_woken() -> None:
    clock, wake = MonotonicClock(), threading.Event()
    deadline = clock.now() + SECOND_NS // 50
    assert deadline <= clock.wait_until(deadline, wake) <= clock.now()

    timer = threading.Timer(0.05, wake.set)
    timer.start()
    far = clock.now() + 60 * SECOND_NS
    assert not clock.wait_until(far, wake)
    assert clock.now() < far
    assert clock.wait_until(deadline, wake), "an order that comes with the deadline does not win"


def overloaded(
    policy: Policy, cost: float, ticks: int
) -> tuple[Timekeeping, list[tuple[str, str]]]:
    """Return time kept at x100 by ticks of 0.5 s that cost so many periods; and what was told."""
    clock = FakeClock()
    keeping = Timekeeping.at(clock, 0.5, 100.0, policy)
    keeping.pacer.run()
    told: list[tuple[str, str]] = []
    wake = threading.Event()
    for _ in range(ticks):
        assert keeping.pacer.wait(wake) is WaitResult.DUE
        keeping.pacer.begin()
        clock.work(periods(cost / 100))
        told += keeping.judge(keeping.pacer.end())
    return keeping, told


def test_a_late_tick_waits_for_what_has_arrived_but_not_for_a_flood_of_it() -> None:
    bench = Bench(Policy.SLIP)
    bench.tick(periods(3))  # every tick is late from here on
    for _ in range(3):
        bench.wake.set()  # and never cleared: there is always more
        assert bench.pacer.wait(bench.wake) is WaitResult.WOKEN
        bench.tick(periods(3))


def test_what_was_heard_before_a_deadline_does_not_make_its_tick_later(bench: Bench) -> None:
    bench.tick(0)
    bench.wake.set()
    assert bench.pacer.wait(bench.wake) is WaitResult.WOKEN
    bench.clock.work(periods(1.1))  # hearing it took beyond the deadline
    assert bench.pacer.wait(bench.wake) is WaitResult.DUE


@pytest.mark.parametrize("policy", [Policy.SLIP, Policy.CATCH_UP])
def test_the_speed_falls_to_what_the_machine_holds_and_that_is_said_once(policy: Policy) -> None:
    keeping, told = overloaded(policy, cost=4.0, ticks=3000)

    assert keeping.speed == 20.0  # a quarter of 100, and a fifth of the clock to spare
    assert [kind for kind, _ in told] == ["trouble", "time"]
    assert "slipped" in told[0][1]
    assert told[1][1] == "time x100 is more than this machine holds: x20 from here on"
    assert isinstance(keeping.pacer, Pacer)
    assert not keeping.frozen


def test_a_machine_that_holds_no_more_than_the_slowest_speed_goes_on_at_that() -> None:
    keeping, _ = overloaded(Policy.CATCH_UP, cost=4000.0, ticks=100)
    assert keeping.speed == MIN_TIME_SPEED


def test_a_machine_that_stumbles_keeps_its_speed() -> None:
    keeping, told = overloaded(Policy.CATCH_UP, cost=0.5, ticks=10)
    for _ in range(20):  # held up for ten periods each time
        keeping.clock.work(periods(0.2))  # type: ignore[attr-defined]
        for _ in range(50):
            keeping.pacer.wait(threading.Event())
            keeping.pacer.begin()
            told += keeping.judge(keeping.pacer.end())

    assert keeping.ledger.skipped > 50
    assert keeping.speed == 100.0
    assert len(told) == 1  # the first slip, and no line for each of the others


def test_a_slip_after_a_quiet_time_is_told_again() -> None:
    keeping, told = overloaded(Policy.SLIP, cost=0.5, ticks=1)
    for _ in range(3):
        for cost in (3.0, *[0.0] * 2100):  # 10.5 s on time
            keeping.pacer.wait(threading.Event())
            keeping.pacer.begin()
            keeping.clock.work(periods(cost / 100))  # type: ignore[attr-defined]
            told += keeping.judge(keeping.pacer.end())
    assert len(told) == 3


def test_ticks_flown_at_once_are_counted_each_by_its_share_of_the_work() -> None:
    ledger = Ledger(0.5)
    ledger.record(0, 0, 3000, 4)
    summary = ledger.summary()
    assert summary.ticks == 4
    assert summary.work.p50_ns == pytest.approx(3000, rel=1 / 32)
    assert summary.duty_cycle == pytest.approx(4 * 3000 / (4 * 0.5e9))
