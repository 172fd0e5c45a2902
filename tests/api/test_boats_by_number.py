"""Many boats by numbers: each is the boat that it would be alone."""

from pathlib import Path

import numpy as np
import pytest
from helpers.lanes import sample_cases

import trainer
from trainer.config.files import shipped_path
from trainer.core.kernel import Numbers

ORDERS = ("stern", "rudder", "depth")
READS = ("z", "theta", "psi")


def whole(fleet: trainer.Fleet) -> bytes:
    return fleet._whole.tobytes()  # noqa: SLF001  all that there is of the boats


def sail(count: int = 6, sea: str = "sea-state-5", **options: object) -> trainer.Fleet:
    given = {"sea": sea, "speed": 8.0, "depth": 40.0} | options
    return trainer.Fleet("bb2", count, orders=ORDERS, reads=READS, **given)


def drawn(chance: np.random.Generator, fleet: trainer.Fleet) -> Numbers:
    shape = (len(fleet), len(fleet.orders))
    share = chance.uniform(0.0, 1.0, shape)
    values: Numbers = fleet.low + share * (fleet.high - fleet.low) * [0.5, 0.5, 0.3]
    return values


@pytest.mark.parametrize("count", sample_cases([4, 250], 4))
@pytest.mark.parametrize("generator", ["calm", "filter", "cosines", "filter-1969"])
def test_every_boat_flies_as_it_does_alone(generator: str, count: int, tmp_path: Path) -> None:
    text = shipped_path("seas", "sea-state-4").read_text("utf-8")
    sea = "calm" if generator == "calm" else str(tmp_path / "sea.toml")
    (tmp_path / "sea.toml").write_text(f'{text}\ngenerator = "{generator}"\n', "utf-8")
    steps, chance = 12, np.random.default_rng(3)
    fleet = sail(count, sea)
    alone = [
        trainer.Boat("bb2", speed=8, depth=40, sea=sea, seed=1 + each).by_number(ORDERS, READS)
        for each in range(count)
    ]
    for _ in range(steps):
        values = drawn(chance, fleet)
        seen = fleet.step(values)
        assert seen.tolist() == [
            by_number.step(row).tolist() for by_number, row in zip(alone, values, strict=True)
        ]
    assert fleet.status.tolist() == [0] * count
    assert len({row.tobytes() for row in seen}) == count


@pytest.mark.parametrize(
    "current", ["set_deg = 90\ndrift_kn = 2", "table = [[0, 90, 2], [80, 90, 0]]"]
)
def test_a_world_that_acts_moves_each_boat_as_it_does_alone(current: str, tmp_path: Path) -> None:
    text = shipped_path("seas", "sea-state-4").read_text("utf-8")
    (tmp_path / "sea.toml").write_text(f"{text}\n[current]\n{current}\n", "utf-8")
    sea = str(tmp_path / "sea.toml")
    fleet = sail(3, sea, ticks=4, each_tick=True, threads=2)
    boats = [trainer.Boat("bb2", speed=8, depth=40, sea=sea, seed=1 + each) for each in range(3)]
    alone = [boat.by_number(ORDERS, READS, 4) for boat in boats]
    chance = np.random.default_rng(6)

    for _ in range(15):
        values = drawn(chance, fleet)
        rows = fleet.step(values)
        ends = [each.step(row).tolist() for each, row in zip(alone, values, strict=True)]
        assert rows[:, -1].tolist() == ends

    for each, boat in enumerate(boats):
        boat.restore(fleet.snapshot(each))
        assert boat.state["water_east"] > 0.5
    assert len({*rows[0, :, 0].tolist()}) == 4  # after each tick another depth


def test_threads_and_rows_of_each_tick_change_no_bit() -> None:
    one, two = sail(7), sail(7, threads=3, ticks=4, each_tick=True)
    chance = np.random.default_rng(4)
    for _ in range(5):
        values = drawn(chance, one)
        rows = [one.step(values) for _ in range(4)]
        assert two.step(values).tolist() == np.stack(rows, axis=1).tolist()
    assert whole(one) == whole(two)


def test_a_reset_leaves_no_trace_in_others_and_a_seed_begins_its_own_sea() -> None:
    fleet, chance = sail(), np.random.default_rng(5)
    start = fleet.reset()
    for _ in range(20):
        fleet.step(drawn(chance, fleet))
    before = [fleet.snapshot(each) for each in range(6)]
    mask = np.array([False, True, False, False, True, False])

    seen = fleet.reset(mask)

    assert seen[mask].tolist() == start[mask].tolist()
    assert fleet.column("tick").tolist() == [20.0, 0.0, 20.0, 20.0, 0.0, 20.0]
    for each in np.flatnonzero(~mask).tolist():
        assert fleet.snapshot(each).moment_for(fleet.plan) == before[each].moment_for(fleet.plan)
    fleet.reset(mask, seeds=(77, 5))
    fresh = sail(2, seeds=(77, 5))
    values = drawn(chance, fleet)
    values[1], values[4] = (0.1, 0.0, 50.0), (0.2, 0.0, 50.0)
    assert fleet.step(values)[mask].tolist() == fresh.step(values[mask]).tolist()
    assert fleet.column("seed").tolist() == [1.0, 77.0, 3.0, 4.0, 5.0, 6.0]


def test_moments_go_from_boats_to_fleets_and_back() -> None:
    fleet, boat = sail(3), trainer.Boat("bb2", speed=8, depth=40, sea="sea-state-5", seed=9)
    boat.order("rudder left 10")
    boat.run(30)
    fleet.restore(2, boat.snapshot())
    by_number = boat.by_number(ORDERS, READS)
    values = np.array([[0.1, -0.1, 50.0]] * 3)
    for _ in range(10):
        assert fleet.step(values)[2].tolist() == by_number.step(values[2]).tolist()
    boat.restore(fleet.snapshot(1))
    assert boat.state["z"] == fleet.column("z")[1]
    assert boat.time == 5.0
    assert fleet.step(values)[1].tolist() == by_number.step(values[1]).tolist()
    other = trainer.Fleet("remus100", 1, orders=["stern"], reads=["z"])
    with pytest.raises(trainer.TrainerError, match="of another vessel file, or another method"):
        boat.restore(other.snapshot(0))


def test_a_lost_boat_rests_and_the_others_go_on() -> None:
    fleet = sail(3)
    fleet._states["u"][1] = np.nan  # noqa: SLF001  no order by number loses a boat at once
    values = np.array([[0.1, 0.0, 50.0]] * 3)
    for _ in range(2):
        fleet.step(values)
        assert (fleet.status != 0).tolist() == [False, True, False]
    values[1] = np.nan  # is not asked of a boat that rests
    fleet.step(values)
    assert fleet.column("tick").tolist() == [3.0, 0.0, 3.0]
    fleet.reset(np.array([False, True, False]))
    fleet.step(fleet.clip([[0.1, 0.0, 900.0]] * 3))
    assert fleet.status.tolist() == [0, 0, 0]


def test_what_is_wrong_is_named_and_nothing_moves() -> None:
    fleet = sail(2)
    before = whole(fleet)
    for values, told in (
        ([[0.1, 0.0, 50.0], [0.1, 2.0, 50.0]], "boat 1: rudder must be -0.523599 to 0.523599, not"),
        ([[np.nan, 0.0, 50.0], [0.1, 0.0, 50.0]], "boat 0: stern must be .* not nan"),
        ([0.1, 0.0, 50.0], r"give \(2, 3\) numbers, not \(3,\)"),
    ):
        with pytest.raises(trainer.TrainerError, match=told):
            fleet.step(values)
        assert whole(fleet) == before
    with pytest.raises(trainer.TrainerError, match="give a mask of 2 booleans"):
        fleet.reset(np.array([0, 1]))
    with pytest.raises(trainer.TrainerError, match="give 2 seeds, not 1"):
        fleet.reset(seeds=[3])
    assert whole(fleet) == before
    for wrong, told in (
        ({"count": 0}, "count must be 1 to 1000000, not 0"),
        ({"threads": 0}, "threads must be 1 to 1024, not 0"),
        ({"ticks": 0}, "ticks must be 1 to 1000000, not 0"),
        ({"sea": "sea-state-55"}, "sea-state-55"),
        ({"seeds": [1, 2, 3]}, "give 2 seeds, not 3"),
    ):
        with pytest.raises(trainer.TrainerError, match=told):
            sail(**{"count": 2, **wrong})  # type: ignore[arg-type]
