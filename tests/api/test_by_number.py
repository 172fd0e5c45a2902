"""A boat by numbers: the same boat as by words, to the bit, and nothing where a number is wrong."""

import copy
import math
import pickle
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from helpers.boats import make_boat, start_bb2
from helpers.lanes import sample_cases

import trainer
from trainer.api.by_number import BoatByNumber, rules_of
from trainer.boat.effects import numbered_orders
from trainer.boat.machine_code import EMPTY_CHART, bind
from trainer.config.world.sea import load_sea
from trainer.core.elementary import nearest_turn
from trainer.core.entry import steer
from trainer.core.state import STATE, new_scratch
from trainer.io.orders.grammar import Order, parse

BOATS = ("bb2", "remus100", "sdv-mk9")
WORDS = {  # of each order by a number: its sides, and the sign of a number said to that side
    "rudder": {"rudder left": 1.0, "rudder right": 1.0},
    "stern": {"stern planes rise": 1.0, "stern planes dive": 1.0},
    "bow": {"bow planes rise": 1.0, "bow planes dive": 1.0},
    "turns": {"turns": 1.0},
    "rpm": {"rpm": 1.0},
    "depth": {"depth": 1.0},
    "course": {"course": 1.0},
    "speed": {"speed": 1.0},
    "flood auxiliary": {"flood auxiliary": 1.0, "pump auxiliary": -1.0},
    "flood depth-control": {"flood depth-control": 1.0, "pump depth-control": -1.0},
    "pump trim forward": {"pump trim forward": 1.0, "pump trim aft": -1.0},
}
MOST = {"rudder": 20, "stern": 20, "bow": 20, "turns": 5, "rpm": 30, "depth": 90, "course": 359}
READS = ("z", "theta", "w")


def whole(boat: trainer.Boat) -> bytes:
    return np.array([*boat.state.values()]).tobytes()


def sailing(vessel: str = "bb2", **options: object) -> trainer.Boat:
    return trainer.Boat(vessel, **{"speed": 3, "depth": 40} | options)


@pytest.mark.parametrize("given", [[10**400, 0], ["a", 0], [[1], [2, 3]], [1j, 0], object()])
def test_what_is_no_number_is_refused_in_one_line_and_moves_nothing(given: object) -> None:
    boat = sailing()
    numbers, fleet = (
        boat.by_number(["stern", "bow"], READS, 2),
        trainer.Fleet("bb2", count=1, orders=["stern", "bow"], reads=READS, ticks=2),
    )
    before = whole(boat)
    for call in (numbers.step, numbers.clip, fleet.step, fleet.clip):
        with pytest.raises(trainer.TrainerError, match=r"^(step|clip)\(\): give numbers, not"):
            call(given)  # type: ignore[arg-type]
    assert whole(boat) == before


def drawn_orders(chance: np.random.Generator, known: list[str]) -> Iterator[tuple[str, str, float]]:
    """Yield names of orders, words to one side, and the same as a number."""
    while True:
        name = known[chance.integers(len(known))]
        side = [*WORDS[name]][chance.integers(len(WORDS[name]))]
        words = f"{side} {chance.integers(MOST.get(name, 3) + 1)}"
        order = parse(words)
        assert isinstance(order, Order), words
        yield name, words, WORDS[name][side] * order.value


@pytest.mark.parametrize("count", sample_cases([60, 1700], 60))
@pytest.mark.parametrize("sea", ["calm", "sea-state-5"])
@pytest.mark.parametrize("vessel", BOATS)
def test_orders_by_number_do_what_their_words_do(vessel: str, sea: str, count: int) -> None:
    chance = np.random.default_rng(len(vessel + sea))
    told, steered = sailing(vessel, sea=sea), sailing(vessel, sea=sea)
    known = [*numbered_orders(make_boat(vessel))]
    assert set(known) <= WORDS.keys()
    faces = {name: steered.by_number([name], READS) for name in known}
    drawn = drawn_orders(chance, known)
    for name, words, number in (next(drawn) for _ in range(count)):
        try:
            told.order(words)
        except trainer.TrainerError:  # beyond this boat's limits
            with pytest.raises(trainer.TrainerError, match=name):
                faces[name].step([number])
            continue
        told.run(1e-3)  # a tick
        row = faces[name].step([number])
        assert whole(told) == whole(steered), words
        assert row.tolist() == [steered.state[read] for read in READS]


def test_each_boat_takes_the_orders_that_it_has_something_for() -> None:
    assert [*numbered_orders(make_boat("bb2"))] == [*WORDS]
    few = [*numbered_orders(make_boat("remus100"))]
    assert "bow" not in few
    assert {"rudder", "stern", "rpm", "depth"} <= set(few)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ([0.6, 0.0], "stern must be -0.523599 to 0.523599, not 0.6"),
        ([0.0, -1.0], "depth must be 0 to 250, not -1"),
        ([math.nan, 50.0], "stern must be .*, not nan"),
        ([0.0, math.inf], "depth must be .*, not inf"),
        ([0.0], "give 2 numbers, not 1"),
        ([[0.0, 50.0]], "give 2 numbers, not 1 by 2"),
        (0.0, "give 2 numbers, not one"),
    ],
)
def test_a_wrong_number_is_refused_and_moves_nothing(row: object, told: str) -> None:
    boat = sailing()
    face = boat.by_number(["stern", "depth"], ["z"])
    face.step([0.1, 60.0])
    before = whole(boat)
    with pytest.raises(trainer.TrainerError, match=told):
        face.step(row)  # type: ignore[arg-type]
    assert whole(boat) == before
    assert face.step(face.clip([0.1, 900.0])).tolist() == [boat.state["z"]]


def test_limits_are_those_of_the_words_and_a_number_is_brought_within() -> None:
    face = sailing().by_number(["rudder", "depth"], [])
    assert np.degrees(face.high[0]) == pytest.approx(30.0)
    assert (face.low[1], face.high[1]) == (0.0, 250.0)
    assert face.clip([-9.0, 300.0]).tolist() == [face.low[0], 250.0]
    assert face.step(face.low).shape == (0,)


def test_a_step_of_many_ticks_is_so_many_steps() -> None:
    once, often = sailing(sea="sea-state-3"), sailing(sea="sea-state-3")
    row = once.by_number(["stern"], ["z", "tick"], ticks=20).step([0.05])
    face = often.by_number(["stern"], ["z", "tick"])
    rows = [face.step([0.05]) for _ in range(20)]
    assert row.tolist() == rows[-1].tolist() == [often.state["z"], 20.0]
    assert rows[0].tolist() != rows[-1].tolist()  # each row is one's own
    assert whole(once) == whole(often)


def test_it_is_the_same_boat_with_its_snapshots_words_and_copies() -> None:
    boat = sailing()
    face = boat.by_number(["depth"], ["z"])
    boat.run(5)
    kept = boat.snapshot()
    first = [face.step([50.0]).tolist() for _ in range(40)]
    other, third = copy.copy(boat), pickle.loads(pickle.dumps(boat))  # noqa: S301  our own
    assert whole(other) == whole(third) == whole(boat)
    boat.order("rudder left 10")
    boat.run(10)
    assert boat.columns["t"].tolist() == [t / 2 for t in (*range(11), *range(50, 71))]
    boat.restore(kept)
    assert boat.columns["t"][-1] == 5.0
    assert [face.step([50.0]).tolist() for _ in range(40)] == first
    assert whole(boat) == whole(other)
    other.by_number(["depth"], ["z"]).step([50.0])
    assert whole(boat) != whole(other)


def test_a_boat_that_is_lost_says_so_and_stays() -> None:
    boat = start_bb2()
    face = BoatByNumber(boat, threading.Lock(), ["depth"], ["z"], 1)
    boat.state.u = math.nan
    states = set()
    for _ in range(3):
        with pytest.raises(trainer.TrainerError, match="out of all bounds after tick 0"):
            face.step([50.0])
        states.add(boat.plain.tobytes())
    assert len(states) == 1
    assert boat.state.ordered_depth == 50.0


def test_what_numbers_cannot_do_is_refused_by_name(tmp_path: object) -> None:
    boat = sailing()
    for orders, reads, ticks, told in (
        (
            ["stren"],
            ["z"],
            1,
            "orders: no order 'stren' takes a number; nearest is stern; there are rudd",
        ),
        (["stern"], ["thetta"], 1, "reads: the state has no 'thetta'; nearest is theta"),
        ([], ["z"], 1, "orders: give a list of names"),
        ("stern", ["z"], 1, "orders: give a list of names"),
        (10**30, ["z"], 1, "orders: give a list of names"),
        (["stern"], 1, 1, "reads: give a list of names"),
        (["stern"], "z", 1, "reads: give a list of names"),
        (["stern"], ["z"], 0, "ticks must be 1 to 1000000, not 0"),
        (["stern"], ["z"], 1.5, "ticks must be 1 to 1000000, not 1.5"),
    ):
        with pytest.raises(trainer.TrainerError, match=told):
            boat.by_number(orders, reads, ticks)  # type: ignore[arg-type]
    with pytest.raises(trainer.TrainerError, match="by_number: not with exercise=, which is for"):
        trainer.Boat(exercise="depth-changes").by_number(["stern"], ["z"])
    with (
        trainer.Boat(record=f"{tmp_path}/a.trainer") as kept,
        pytest.raises(trainer.TrainerError, match="by_number: not with record="),
    ):
        kept.by_number(["stern"], ["z"])


def test_a_world_that_acts_is_written_before_each_tick_of_a_step() -> None:
    reads = ["x", "y", "z"]
    boats = [trainer.Boat("bb2", speed=6, depth=30) for _ in range(2)]
    steered = boats[0].by_number(["stern"], reads, 5)
    for boat in boats:
        boat.order("current set 090 drift 2")
    boats[1].order("stern planes rise 2")
    wide = np.radians(2.0)

    for _ in range(40):  # over the ramp of the current, and while it stands
        rows = steered.step([wide])

    boats[1].run(100.0)
    assert boats[0].snapshot().time == 100.0
    assert rows.tolist() == [boats[1].state[name] for name in reads]
    assert rows[1] > 50.0
    before = boats[0].state  # as it stays where a number is refused
    with pytest.raises(trainer.TrainerError, match="stern must be"):
        steered.step([np.nan])
    assert boats[0].state == before
    for boat in boats:
        boat.order("current set 180 drift 1")  # its ramp begins
    boats[0].by_number(["flood auxiliary"], reads, 5).step([1000.0])  # once, not at each tick
    boats[1].order("flood auxiliary 1")
    boats[1].run(2.5)
    assert boats[0].state == boats[1].state


def test_an_angle_is_turned_to_the_nearest_as_ieee_has_it() -> None:
    turn = getattr(nearest_turn, "py_func", nearest_turn)
    chance = np.random.default_rng(5)
    powers = chance.integers(-300, 12, 3000).tolist()
    angles = [chance.uniform(-1.0, 1.0) * 10.0**power for power in powers]
    angles += [float(k) * math.pi for k in range(-9, 10)]
    angles += [k * math.tau + chance.uniform(-1e-9, 1e-9) for k in range(-99, 99)]
    assert [turn(x) for x in angles] == [math.remainder(x, math.tau) for x in angles]


def test_boats_in_a_row_fly_as_each_does_alone() -> None:
    boat, count, ticks = start_bb2(), 5, 4
    boat.put_to_sea(load_sea("sea-state-3"))
    orders = [numbered_orders(boat)[name] for name in ("stern", "depth")]
    rules, offsets = rules_of(orders), np.array([10.0, 11.0])
    values = np.column_stack([np.linspace(-0.2, 0.2, count), np.full(count, 50.0)])
    values[3, 0] = math.nan
    states = np.repeat(boat.records.state, count)
    rest = boat.records.vessel, boat.records.compact, boat.records.scheme
    out = np.zeros((count, 1 + ticks * 2))
    call = bind(
        steer, (*rest, states, new_scratch(), EMPTY_CHART), rules, values, offsets, ticks, out
    )
    assert call() == 1
    assert out[:, 0].tolist() == [0.0, 0.0, 0.0, -1.0, 0.0]
    for index in range(count):
        own, last = boat.records.state.copy(), np.zeros((1, 3))
        records = *rest, own, new_scratch(), EMPTY_CHART
        alone = bind(steer, records, rules, values[index : index + 1], offsets, ticks, last)
        alone()
        assert own.tobytes() == states[index : index + 1].tobytes()
        assert last[0].tolist() == [out[index, 0], *out[index, -2:]]
        assert (own.tobytes() == boat.records.state.tobytes()) is (index == 3)
    values[3, 0] = 0.0
    assert call() == 1  # who rests goes on resting
    assert states["tick"].tolist() == [8.0, 8.0, 8.0, 0.0, 8.0]
    assert states.dtype == STATE
