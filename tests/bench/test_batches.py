"""A figure of batches: what one repetition costs, of a boat that is one."""

from collections.abc import Callable
from functools import partial

import pytest
from helpers.loops import in_a_loop

from bench.batches import BATCH_NS, BatchCost, Voyage, long_enough, time_batches
from trainer.analysis.bench.ticks import BATCH_COUNT
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError


def test_a_batch_cost_is_per_repetition(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0]
    monkeypatch.setattr("time.perf_counter_ns", lambda: clock[0])
    calls: list[int] = []

    def work(count: int) -> None:
        compiling = 0 if calls else 10**9
        calls.append(count)
        clock[0] += 1000 * count + compiling

    # 2^14: the first power of two that takes 10 ms at 1 us each
    assert time_batches([work]) == [BatchCost(1000.0, 1000.0, BATCH_COUNT, 2**14)]
    assert calls[-BATCH_COUNT:] == [2**14] * BATCH_COUNT


def boat_under_way(fill: Callable[[Boat], object]) -> Boat:
    """Return BB2 with its own battery, after something was done to it."""
    boat = Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(5.0, 60.0, 0.0)
    fill(boat)
    return boat


def test_each_batch_begins_from_the_boat_put_back() -> None:
    boat, begun = boat_under_way(lambda _: None), []

    def take(count: int) -> None:
        begun.append(boat.snapshot().tobytes())
        in_a_loop(boat.records, count)

    time_batches([Voyage.of(boat, take)])

    assert len(begun) > BATCH_COUNT
    assert len({*begun}) == 1


@pytest.mark.parametrize(
    ("fill", "told"),
    [
        (lambda boat: boat.state.__setitem__("battery_spent", 1e12), "the battery went flat"),
        (lambda boat: boat.state.__setitem__("z", 5664.0), "collapse at 5664 m"),
        (lambda boat: insert_casualty(boat, "bus-dc-lost"), "dc without power"),
        (lambda boat: boat.state.__setitem__("u", 2e3), "it has done 0 of"),
    ],
)
def test_a_boat_that_is_lost_frozen_or_without_power_has_no_figure(
    fill: Callable[[Boat], object], told: str
) -> None:
    boat = boat_under_way(fill)

    with pytest.raises(ConfigError, match=f"bb2.toml has no figure in a benchmark: .*{told}"):
        time_batches([Voyage.of(boat, partial(in_a_loop, boat.records))])


def test_an_interruption_does_not_make_batches_short(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0]
    monkeypatch.setattr("time.perf_counter_ns", lambda: clock[0])
    calls: list[int] = []

    def work(count: int) -> None:
        calls.append(count)
        clock[0] += 1000 * count + (0 if len(calls) % 3 else BATCH_NS)

    assert long_enough(work) == 2**14
