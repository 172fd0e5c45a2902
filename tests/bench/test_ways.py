"""A tick in three ways and in trouble, and what a session adds: structure, never the speed."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from helpers.loops import CASUALTY_KINDS

from bench import session_ticks, ways
from bench.session_ticks import SessionFigures, effect, time_session
from bench.ways import WaysFigures, time_ways
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.io.recording.absence import NoRecording

SHORT_BATCH_NS = 1_000_000
Figures = tuple[WaysFigures, SessionFigures]


@pytest.fixture(scope="module")
def figures() -> Figures:
    """Return what batches of a millisecond give, and a second of orders."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("bench.batches.BATCH_NS", SHORT_BATCH_NS)
        file = load_vessel("bb2")
        return time_ways(file), time_session(file, 1)


@pytest.mark.process
def test_batches_are_many_long_and_their_least_is_not_above_the_median(
    figures: Figures,
) -> None:
    tick = figures[1].attended
    batches = [tick.boat, tick.bare, tick.csv_row, tick.recorded, tick.subscribed]
    batches += [b for update in figures[0].updates for b in (update.called, update.in_kernel)]

    for batch in batches:
        assert batch.batches >= 9
        assert 0.0 < batch.least_ns <= batch.median_ns
        # long enough when calibrated; a machine that was ten times busier then is beyond belief
        assert batch.median_ns * batch.repetitions > SHORT_BATCH_NS / 10


@pytest.mark.process
def test_three_ways_to_compute_are_timed_and_the_crossing_is_their_difference(
    figures: Figures,
) -> None:
    ways = [(u.equations, u.rates, u.integrator) for u in figures[0].updates]

    assert ways == [
        ("modified", "lagged", "adams2"),
        ("full", "exact", "adams2"),
        ("full", "exact", "rk4"),
    ]
    for update in figures[0].updates:
        assert update.crossing_ns == update.called.least_ns - update.in_kernel.least_ns


@pytest.mark.process
def test_the_troubled_tick_has_six_casualties_and_a_ratio_to_the_calm_one(
    figures: Figures,
) -> None:
    troubled = figures[0].troubled

    assert len(CASUALTY_KINDS) == 6
    assert troubled.times_the_calm == troubled.troubled.least_ns / troubled.calm.least_ns
    assert "tanks at work and six casualties" in "\n".join(ways.lines(figures[0]))


@pytest.mark.process
def test_orders_over_tcp_are_answered_and_act_within_a_tick(
    figures: Figures,
) -> None:
    latency = figures[1].latency

    assert latency.orders > 1
    assert latency.tick_s == 0.05
    assert 0 < latency.reply.p50_ns <= latency.reply.p99_ns <= latency.reply.max_ns
    assert latency.ticks_to_effect_most == 1
    assert f"{latency.orders} orders; from order to effect: 1 tick at most" in "\n".join(
        session_ticks.lines(figures[1])
    )


def test_an_order_that_acts_late_is_seen_to(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    boat.start(5.0, 60.0, 0.0)
    boat.state.rudder_by_hand, boat.state.ordered_r = 1.0, -0.2
    states = [boat.snapshot()[0]]
    for ordered in (-0.2, -0.2, 0.2, 0.2):  # the rudder is on its way at first
        boat.state.ordered_r = ordered
        boat.tick()
        states.append(boat.snapshot()[0])

    assert [effect(states[given:]) for given in (0, 1, 2)] == [3, 2, 1]


@pytest.mark.process
def test_a_boat_without_a_rudder_has_no_effect_to_tell(
    figures: Figures,
) -> None:
    steered = replace(figures[1].latency, ticks_to_effect_most=0)

    assert "none: this boat has no rudder" in "\n".join(
        session_ticks.lines(replace(figures[1], latency=steered))
    )


def test_a_boat_that_loses_its_numbers_is_refused(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    boat.start(5.0, 60.0, 0.0)
    boat.state.q = np.inf

    with (
        session_ticks.session_of(boat, math.inf, NoRecording(), ()) as session,
        pytest.raises(ConfigError, match=r"bb2\.toml has no place .* out of all bounds"),
    ):
        session_ticks.run_to(session, 2)
