"""The current around a boat: its forms, the orders that change it, and what is refused."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import take_ticks
from helpers.nursery import run_trainer
from helpers.orders import read_order
from helpers.places import environment
from helpers.sessions import start_plan

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.world.current import CurrentAround, Line, TidalEllipse, current_text, flow_of
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.world.current import Current, Tide
from trainer.config.world.sea import parse_sea
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.units import KNOT

HEAD = 'schema = "exercise/1"\nname = "Adrift"\nbriefing = "A current."\nduration_s = 60\n'
UNIFORM = "[current]\nset_deg = 90\ndrift_kn = 2\n"
DEEP = 60.0  # [m]
TIDE = Tide(major_kn=2.0, towards_deg=10.0, period_h=1.0)


def around(current: Current | None = None) -> CurrentAround:
    """Return the current around a boat with ticks of half a second."""
    return CurrentAround(0.5, 60.0, flow_of(current))


def water(line: Line, depth: float) -> tuple[float, float]:
    """Return the water north and east [m/s] of a line at a depth [m]."""
    return line[0] + line[2] * depth, line[1] + line[3] * depth


# Its forms


def test_a_tide_runs_round_its_ellipse_in_twelve_hours_and_a_bit() -> None:
    tide = Tide(major_kn=1.0 / KNOT, minor_kn=0.2 / KNOT, towards_deg=30.0)
    flow = flow_of(Current(tide=tide))
    assert flow
    quarter = 44714.0 / 4.0  # [s]
    for turn, expected in enumerate(
        [(0.86603, 0.5), (-0.1, 0.17321), (-0.86603, -0.5), (0.1, -0.17321)]
    ):
        assert flow(turn * quarter, DEEP)[:2] == pytest.approx(expected, abs=5e-5)
    assert flow(0.0, DEEP)[2:] == (0.0, 0.0)


def test_the_phase_of_a_tide_is_how_long_ago_it_was_strongest() -> None:
    numbers = {"major_kn": 1.0, "minor_kn": -0.3, "towards_deg": 200.0, "period_h": 6.0}
    early, late = (flow_of(Current(tide=Tide(**numbers, phase_h=each))) for each in (0.0, 1.5))
    assert early
    assert late
    assert late(0.0, DEEP) == early(1.5 * 3600.0, DEEP)
    # b below zero turns the other way: a quarter later it is to the left of where it was
    before, after = (complex(*early(hours * 3600.0, DEEP)[:2]) for hours in (0.0, 1.5))
    assert (after / before).imag == pytest.approx(-0.3, abs=1e-9)


def test_a_tide_turns_about_its_mean() -> None:
    numbers = {"major_kn": 1.0, "minor_kn": 0.2, "towards_deg": 30.0, "period_h": 6.0}
    alone = flow_of(Current(tide=Tide(**numbers)))
    flow = flow_of(Current(tide=Tide(**numbers, mean_set_deg=90.0, mean_drift_kn=0.5)))
    assert alone
    assert flow
    for time in (0.0, 4000.0, 10800.0, 21600.0):
        north, east = alone(time, DEEP)[:2]
        assert flow(time, DEEP) == pytest.approx((north, east + 0.5 * KNOT, 0.0, 0.0))
    part = around(Current(tide=Tide(**numbers, mean_set_deg=90.0, mean_drift_kn=0.5)))
    assert part.carried(21600.0) == pytest.approx((0.0, 21600.0 * 0.5 * KNOT), abs=1e-6)


def test_between_two_rows_the_water_is_straight_in_between_and_beyond_it_is_theirs() -> None:
    flow = flow_of(Current(table=((10.0, 0.0, 2.0), (50.0, 90.0, 1.0), (100.0, 90.0, 0.0))))
    assert flow
    knots = {
        -5.0: (2.0, 0.0),
        10.0: (2.0, 0.0),
        20.0: (1.5, 0.25),
        50.0: (0.0, 1.0),
        75.0: (0.0, 0.5),
        100.0: (0.0, 0.0),
        400.0: (0.0, 0.0),
    }
    for depth, expected in knots.items():
        there = water(flow(0.0, depth), depth)
        assert there == pytest.approx([KNOT * each for each in expected], abs=1e-12), depth
    # a line holds beside its depth: the core has it where the boat is within the tick
    assert water(flow(0.0, 20.0), 30.0) == pytest.approx([KNOT, 0.5 * KNOT])
    assert flow(0.0, 5.0)[2:] == flow(0.0, 300.0)[2:] == (0.0, 0.0)


# Orders


def test_an_order_takes_the_place_of_table_and_tide_in_a_straight_ramp() -> None:
    part = around(Current(table=((0.0, 180.0, 2.0), (100.0, 180.0, 1.0))))
    was = part.at(1000, DEEP)
    told = part.obey(read_order("current set 090 drift 3"), 1000)
    assert told == "current set 090 drift 3 kn: towards 090 at 3 kn, within 60 s"
    wanted = (0.0, 3.0 * KNOT, 0.0, 0.0)
    assert part.at(1000, DEEP) == was
    middle = [(a + b) / 2.0 for a, b in zip(was, wanted, strict=True)]
    assert part.at(1060, DEEP) == pytest.approx(middle, abs=1e-12)
    assert part.at(1120, DEEP) == part.at(9000, 0.0) == pytest.approx(wanted, abs=1e-12)
    before = part.at(9000, DEEP)
    part.obey(read_order("current off"), 9000)
    assert part.at(9000, DEEP) == before  # it begins from what was ordered


def test_off_leaves_water_that_stands_still_to_the_last_bit() -> None:
    part = around()
    assert not part.acts
    part.obey(read_order("current set 222 drift 1.7"), 3)
    assert part.acts
    assert part.obey(read_order("current off"), 40) == "current off: no current, within 60 s"
    assert part.at(100, DEEP)[0] != 0.0
    assert part.at(160, DEEP) == (0.0, 0.0, 0.0, 0.0)


def test_orders_told_again_after_a_jump_make_the_same_bits_as_those_lived_through() -> None:
    rng = np.random.default_rng(5)
    given = [
        (int(tick), read_order(f"current set {rng.integers(360)} drift {rng.uniform(0, 4):.2f}"))
        for tick in np.cumsum(rng.integers(1, 150, 30))  # most within the ramp of those before
    ]
    lived = around(Current(tide=TIDE))
    for i, (tick, each) in enumerate(given):
        lived.obey(each, tick)
        again = around(Current(tide=TIDE))
        for then, before in given[: i + 1]:
            again.obey(before, then)
        for later in (0, 7, 60, 119, 120, 500):
            assert again.at(tick + later, DEEP) == lived.at(tick + later, DEEP)
        assert lived.at(tick + 120, DEEP) == lived.changes[-1].line  # no trace of the tide
    first = given[0][0]  # a tick of the past has the water that it had
    assert lived.at(first - 1, DEEP) == TidalEllipse(TIDE)(0.5 * (first - 1), DEEP)


def drifted() -> CurrentAround:
    """Return a tide in which one order's ramp begins within another's."""
    part = around(Current(tide=TIDE))
    for tick, text in ((300, "set 090 drift 3"), (370, "off"), (1000, "set 200 drift 1")):
        part.obey(read_order(f"current {text}"), tick)
    return part


def test_what_floats_has_gone_as_far_as_the_water_has_in_small_steps() -> None:
    part, step = drifted(), 0.05
    for end in (90.0, 200.0, 700.0):
        middles = (np.arange(round(end / step)) + 0.5) * step
        gone = sum(np.array(part.floating(each)) for each in middles.tolist()) * step
        assert part.carried(end) == pytest.approx(gone, abs=2e-4)


def test_what_floats_is_at_the_same_place_to_the_bit_whoever_asks_and_when() -> None:
    live = around(Current(tide=TIDE))
    places = {}
    for tick in range(1300):
        text = {300: "set 090 drift 3", 370: "off", 1000: "set 200 drift 1"}.get(tick)
        places[tick] = live.carried(0.5 * tick)
        if text:
            live.obey(read_order(f"current {text}"), tick)
    again = drifted()
    assert {tick: again.carried(0.5 * tick) for tick in (1299, 50, 301, 0, 1010)}.items() <= (
        places.items()
    )
    again.forget()
    assert again.carried(400.0) == around(Current(tide=TIDE)).carried(400.0)


def test_no_step_of_a_ramp_is_longer_than_the_ramp_has_it() -> None:
    part = around()
    part.obey(read_order("current set 000 drift 2"), 10)
    part.obey(read_order("current set 180 drift 2"), 50)
    part.obey(read_order("current off"), 90)
    north = np.array([part.at(tick, DEEP)[0] for tick in range(300)])
    assert np.abs(np.diff(north)).max() < 4.0 * KNOT / 120.0 + 1e-12
    assert north[-1] == 0.0


def test_a_current_is_told_towards_where_it_goes() -> None:
    assert current_text(0.0, KNOT) == "towards 090 at 1 kn"
    assert current_text(-2.0 * KNOT, -1e-9) == "towards 180 at 2 kn"
    assert current_text(1e-4, 0.0) == "no current"


# In an exercise and in a sea


@pytest.fixture
def plan_of(tmp_path: Path) -> Callable[..., Plan]:
    """Return a function that plans an exercise of a text, in a sea of another."""

    def planned(exercise: str, sea: str = "") -> Plan:
        path = tmp_path / "adrift.toml"
        (tmp_path / "own-sea.toml").write_text("[sea]\nsea_state = 0\n" + sea)
        path.write_text(HEAD + 'sea = "./own-sea.toml"\n' + exercise)
        return plan_run(RunOptions(exercise=str(path)))

    return planned


def test_the_first_picture_has_the_current_and_each_tick_carries_the_boat(
    plan_of: Callable[..., Plan],
) -> None:
    still, carried = start_plan(plan_of("")), start_plan(plan_of(UNIFORM))
    assert carried.state.current == pytest.approx([0.0, 2.0 * KNOT, 0.0, 0.0])
    for _ in range(40):
        assert still.tick() == carried.tick() == 0
    assert carried.state.y - still.state.y == pytest.approx(20.0 * 2.0 * KNOT, abs=1e-9)
    assert carried.state.x == pytest.approx(float(still.state.x), abs=1e-9)
    assert carried.state.u == still.state.u


def test_a_sea_file_may_have_a_current_and_the_exercise_s_own_takes_its_place(
    plan_of: Callable[..., Plan],
) -> None:
    assert start_plan(plan_of("", UNIFORM)).state.water_east == pytest.approx(2.0 * KNOT)
    own = "[current]\nset_deg = 180\ndrift_kn = 1\n"
    assert start_plan(plan_of(own, UNIFORM)).state.water_north == pytest.approx(-KNOT)


def test_a_boat_with_nothing_around_her_ticks_as_she_always_did(
    plan_of: Callable[..., Plan],
) -> None:
    boat = start_plan(plan_of(""))
    assert boat.tick is boat.advance
    assert isinstance(obey_order(boat, read_order("current set 090 drift 2")), str)
    assert boat.tick is not boat.advance
    take_ticks(boat, 10)
    assert boat.state.water_east > 0.0
    boat.world.obey_anew([])
    assert boat.tick is boat.advance


def test_the_ramp_of_an_order_is_the_file_s(plan_of: Callable[..., Plan]) -> None:
    told = obey_order(start_plan(plan_of(UNIFORM + "ramp_s = 120\n")), read_order("current off"))
    assert told == "current off: no current, within 120 s"
    told = obey_order(start_plan(plan_of("")), read_order("current set 010 drift 0.5"))
    assert told == "current set 010 drift 0.5 kn: towards 010 at 0.5 kn, within 60 s"


# What is wrong

WRONG = {
    "set_deg = 90": "has set_deg and lacks drift_kn: give one of set_deg with drift_kn, table, ti",
    "ramp_s = 60": "has none of them: give one of set_deg with drift_kn, table, tide",
    "set_deg = 90\ndrift_kn = 2\ntable = [[0, 90, 2]]": "has set_deg, drift_kn, table: give one",
    "table = [[0, 90, 2]]\ntide = {major_kn = 1, towards_deg = 0}": "has table, tide: give one",
    "set_deg = 90\ndrift_kn = 11": "drift_kn = 11: must be 0 to 10 kn",
    "set_deg = 361\ndrift_kn = 1": "set_deg = 361: must be 0 to 360 deg",
    "set_deg = 90\ndrift_kn = nan": "drift_kn = nan: must be finite, 0 to 10 kn",
    "set_deg = 90\ndrift = 1": "drift = 1: no such key; nearest is drift_kn",
    "set_deg = 90\ndrift_kn = 1\nramp_s = 30": "ramp_s = 30: must be 60 to 3600 s",
    "table = [[50, 90, 2], [10, 90, 1]]": "table[1] = [10, 90, 1]: depths must rise: 10 m is not",
    "table = [[0, 90]]": "table[0] = [0, 90]: must be three numbers: depth m, set deg, drift kn",
    "table = [[0, 90, 12]]": "table[0][2] = 12: must be 0 to 10 kn",
    "table = []": "table = []: must be a list of 1 to 50 rows",
    "table = 3": "table = 3: must be a list of 1 to 50 rows",
    "tide = {major_kn = 1, minor = 1, towards_deg = 0}": "minor = 1: no such key; nearest is minor",
    "tide = {major_kn = 1, towards_deg = 0, mean_drift_kn = 1}": (
        "tide has mean_drift_kn and lacks mean_set_deg: give both, or neither"
    ),
    "tide = {major_kn = 1}": "[current.tide] lacks towards_deg",
    "tide = {major_kn = 1, minor_kn = -2, towards_deg = 0}": "minor_kn = -2: is more than major_kn",
    "tide = {major_kn = 1, towards_deg = 0, period_h = 0}": "period_h = 0: must be 1 to 1000 h",
    "tide = 2": "must be a table, not 2",
}


@pytest.mark.parametrize(("text", "told"), WRONG.items())
def test_what_is_no_current_is_told_in_one_line_with_what_would_be(text: str, told: str) -> None:
    for read, head in ((parse_exercise, HEAD), (parse_sea, "[sea]\nsea_state = 0\n")):
        with pytest.raises(ConfigError) as wrong:
            read(f"{head}[current]\n{text}\n", Path("my.toml"))
        assert wrong.value.problems[0].startswith("my.toml: ")
        assert told in str(wrong.value)
        assert "[current" in str(wrong.value)


@pytest.mark.process
@pytest.mark.parametrize("words", [("run", "{0}"), ("run", "--sea", "{1}")])
def test_a_wrong_current_ends_a_run_with_code_2(words: tuple[str, ...], tmp_path: Path) -> None:
    exercise, sea = tmp_path / "wrong.toml", tmp_path / "sea.toml"
    exercise.write_text(HEAD + "[current]\nset_deg = 90\n")
    sea.write_text("[sea]\nsea_state = 1\n[current]\nset_deg = 90\n")
    typed = [word.format(exercise, sea) for word in words]
    done = run_trainer(*typed, "--headless", env=environment(), timeout=120)
    assert done.returncode == 2
    *_, line = done.stderr.splitlines()  # before it perhaps that the core is being compiled
    assert "[current] has set_deg and lacks drift_kn" in line


# Many ticks at once


@pytest.mark.parametrize(
    ("current", "words", "stands"),
    [
        (UNIFORM, "", True),
        (UNIFORM, "current set 180 drift 1", False),  # until it is whole, after a minute
        ("[current.tide]\nmajor_kn = 2.0\ntowards_deg = 10.0\nperiod_h = 1.0\n", "", False),
    ],
)
def test_many_ticks_at_once_are_in_the_same_water_as_each_by_itself(
    tmp_path: Path,
    current: str,
    words: str,
    stands: bool,  # noqa: FBT001
) -> None:
    path = tmp_path / "adrift.toml"
    path.write_text(HEAD + current, encoding="utf-8")
    plan = plan_run(RunOptions(exercise=str(path)))
    boats = [Boat(plan.file, plan.method) for _ in range(2)]
    for boat in boats:
        plan.start(boat)
        if words:
            boat.world.obey(read_order(words), 0)
    together, singly = boats
    assert together.world.stands(0) == stands
    places = np.arange(3)
    rows = np.empty((300, 3))

    assert together.fly(places, rows) == 0
    for _ in rows:
        assert singly.tick() == 0
    assert together.records.state.tobytes() == singly.records.state.tobytes()
    assert together.world.stands(300) == (stands or bool(words))
