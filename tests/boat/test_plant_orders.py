"""What a crew orders of the plant, and what comes of it: by the words of the boat's own orders.

The figures of long chains are those of the statement, flown by a sketch of the same model.
"""

import math
import tomllib
from collections.abc import Callable
from copy import deepcopy

import pytest
from helpers.boats import make_boat, start_bb2, start_boat

from trainer.boat.boat import Boat
from trainer.boat.casualties import arm_casualty, insert_casualty
from trainer.boat.effects import effects_of_boat
from trainer.boat.helm import obey_order
from trainer.boat.quantities import quantity_of
from trainer.config.boat.vessel import VesselFile, load_vessel, read_vessel
from trainer.config.exercise.condition import PLANT_QUANTITIES
from trainer.config.exercise.derived import compile_condition
from trainer.config.files import ConfigError, Position
from trainer.config.world.sea import load_sea
from trainer.core.state import offset_of
from trainer.core.update import LATE_OFFSETS, PLANT_BEGIN, WRITTEN_COUNT
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.units import KNOT

Events = dict[float, str]
LOOK_S = 2.0


def told(boat: Boat, line: str) -> str | Refused:
    """Return the answer to an order."""
    order = parse(line)
    assert isinstance(order, Order), line
    return obey_order(boat, order)


class Planesman:
    """Works both pairs of planes by hand: looks every two seconds, orders whole degrees."""

    def __init__(self, boat: Boat, depth: float, bubble: float = 8.0) -> None:
        """Have a boat kept at a depth [m], within a pitch [deg]."""
        self.boat, self.depth, self.bubble = boat, depth, bubble
        self._next = 0.0
        self._said = ["", ""]

    def look(self) -> None:
        """Order what the depth, its rate and the pitch ask for, where that is new."""
        if self.boat.time < self._next:
            return
        self._next = self.boat.time + LOOK_S
        s = self.boat.state
        error, sinking = float(s.z) - self.depth, float(s.zdot)
        wanted = max(-self.bubble, min(self.bubble, 0.5 * (error + 6.0 * sinking)))
        pitch, turning = math.degrees(s.theta), math.degrees(s.q)
        stern = max(-30, min(30, round(2.0 * (wanted - pitch) - 10.0 * turning)))
        bow = max(-20, min(20, 5 * round(0.4 * error + 2.0 * sinking)))
        for i, (pair, angle) in enumerate((("stern", stern), ("bow", bow))):
            said = f"{pair} planes {'rise' if angle > 0 else 'dive'} {abs(angle)}"
            line = said if angle else f"{pair} planes zero"
            if line != self._said[i]:
                self._said[i] = line
                assert isinstance(told(self.boat, line), str)


def flown(boat: Boat, events: Events, seconds: float, man: Planesman | None = None) -> list[float]:
    """Fly a boat; return its depths [m], one for each tick."""
    waiting = sorted(events.items())
    depths = []
    while boat.time < seconds:
        while waiting and boat.time >= waiting[0][0]:
            for line in waiting.pop(0)[1].split("; "):
                answer = told(boat, line)
                assert isinstance(answer, str), (line, answer)
        if man:
            man.look()
        assert boat.tick() == 0
        depths.append(float(boat.state.z))
    return depths


def bb2_at(knots: float, depth: float) -> Boat:
    """Return BB2 by the set it is flown by."""
    return start_boat(knots * KNOT, depth, equations="modified")


@pytest.mark.parametrize(
    "line", ["isolate main", "bus tie shut", "stern planes emergency", "fight fire aft"]
)
def test_a_boat_without_a_plant_says_so(line: str) -> None:
    boat = make_boat("remus100")
    before = boat.snapshot()

    answer = told(boat, line)

    assert isinstance(answer, Refused)
    assert answer.reason.startswith("this boat has no plant")
    assert boat.snapshot().tobytes() == before.tobytes()


def test_a_casualty_of_the_plant_needs_one() -> None:
    answer = insert_casualty(make_boat("remus100"), "fire-aft")

    assert isinstance(answer, Refused)
    assert answer.reason.startswith("this boat has no plant")


def test_conditions_name_what_the_plant_shows() -> None:
    boat = bb2_at(6.0, 60.0)
    said = "casualty bus-port-lost; loads shed; isolate main; stern planes emergency; "
    flown(boat, {0.0: f"{said}casualty oil-leak-header; casualty fire-aft"}, 20.0)
    shown = {name: quantity_of(boat, name) for name in PLANT_QUANTITIES}

    whole = {name for name, value in shown.items() if value == 1.0}
    both = {"mode_rudder", "mode_stern"}  # of an X-tail
    assert whole == {"isolated_main", "bus_dead_port", "loads_shed"} | both
    assert 0.05 < shown["fire_aft"] < 0.1
    assert 0.0 < shown["smoke_aft"] < shown["fire_aft"]
    assert shown["oil_out_vital"] == float(boat.state.oil_spent_vital)
    assert shown["oil_tank_main"] == float(boat.state.tank_gain_main)


@pytest.mark.parametrize("name", PLANT_QUANTITIES)
def test_a_boat_without_a_plant_has_no_quantity_of_it(name: str) -> None:
    boat = make_boat("remus100")

    assert math.isnan(quantity_of(boat, name))
    seen = compile_condition(f"{name} > 0", Position("drill.toml", ""))
    with pytest.raises(ConfigError, match=f"remus100.toml has no {name}"):
        arm_casualty(boat, seen, boat.casualties["rudder-stuck"])


def test_every_order_to_the_plant_touches_it() -> None:
    boat = start_bb2()
    begin, end = PLANT_BEGIN, WRITTEN_COUNT
    found = [
        effect
        for effect in effects_of_boat(boat)
        if any(begin <= write.place < end for write in effect.writes)
    ]

    assert len(found) == 42
    for effect in found:
        assert any(write.place == offset_of("plant_touched") for write in effect.writes), effect


def test_a_shift_takes_an_automatic_surface_in_hand_where_it_stands() -> None:
    boat = start_bb2()
    boat.state.delta_b = 0.1
    told(boat, "bow planes emergency")
    assert boat.tick() == 0

    assert (boat.state.bow_by_hand, boat.state.ordered_b) == (1.0, 0.1)
    assert boat.state.bow_mode == 0.0
    for _ in range(3):
        boat.tick()
    assert boat.state.bow_mode == 1.0
    assert boat.state.stern_by_hand == 0.0


def test_a_surface_in_hand_keeps_its_order_when_it_is_shifted() -> None:
    boat = start_bb2()
    told(boat, "bow planes rise 12")
    ordered = float(boat.state.ordered_b)
    told(boat, "bow planes hand")
    for _ in range(120):
        assert boat.tick() == 0

    assert boat.state.ordered_b == ordered
    assert boat.state.bow_mode == 2.0


def test_the_planes_of_an_x_tail_are_shifted_together() -> None:
    boat = start_bb2()

    assert "X-tail" in str(told(boat, "rudder emergency"))
    assert (boat.state.rudder_mode_ordered, boat.state.stern_mode_ordered) == (1.0, 1.0)


def test_a_plant_that_is_well_is_all_zeros_but_for_what_the_battery_gave() -> None:
    boat = start_bb2()
    for _ in range(40):
        assert boat.tick() == 0

    numbers = boat.snapshot().view(float)
    numbers[offset_of("battery_spent")] -= float(boat.state.battery_spent)
    assert boat.state.battery_spent > 0.0
    assert not numbers[PLANT_BEGIN:WRITTEN_COUNT].any()


@pytest.mark.parametrize("touched", [False, True])
def test_a_boat_whose_plant_is_well_moves_to_the_bit_as_one_without(touched: bool) -> None:  # noqa: FBT001
    boat, bare = bb2_at(10.0, 60.0), bb2_at(10.0, 60.0)
    bare.vessel.battery_full = 0.0  # what makes a boat without [plant]
    if touched:
        told(boat, "loads shed")
    for each in (boat, bare):
        told(each, "depth 90")
        told(each, "course 040")
        for _ in range(240):
            assert each.tick() == 0

    one, other = (each.snapshot().view(float) for each in (boat, bare))
    late = {int(offset) for offset in LATE_OFFSETS}
    same = [i for i in range(one.size) if not PLANT_BEGIN <= i < WRITTEN_COUNT or i in late]
    same.remove(offset_of("battery_spent"))
    assert one[same].tobytes() == other[same].tobytes()
    assert boat.state.z > 80.0


def test_a_tick_that_fails_leaves_the_plant_as_it_was() -> None:
    boat = start_bb2()
    told(boat, "casualty fire-aft")
    boat.tick()
    before = boat.snapshot()
    boat.state.u = math.nan
    spoilt = boat.snapshot()

    assert boat.tick() != 0

    assert boat.snapshot().tobytes() == spoilt.tobytes()
    assert before.tobytes() != spoilt.tobytes()


def test_a_tick_that_fails_as_a_trigger_fires_leaves_the_plant_untouched() -> None:
    boat = start_bb2()
    deep = compile_condition("depth > 1", Position("my.toml", "casualties[0]"))
    arm_casualty(boat, deep, boat.casualties["fire-aft"])
    boat.state.u = math.nan
    spoilt = boat.snapshot()

    assert boat.tick() != 0

    assert boat.snapshot().tobytes() == spoilt.tobytes()


def test_a_boat_put_back_to_before_its_plant_was_touched_goes_on_well() -> None:
    boat, fresh = bb2_at(10.0, 60.0), bb2_at(10.0, 60.0)
    start = boat.snapshot()
    told(boat, "casualty oil-leak-header")
    told(boat, "breaker port open")
    flown(boat, {}, 20.0)
    boat.restore(start)
    for each in (boat, fresh):
        flown(each, {}, 20.0)

    assert boat.snapshot().tobytes() == fresh.snapshot().tobytes()


def test_a_moment_gone_back_to_has_the_plant_of_that_moment() -> None:
    boat = bb2_at(10.0, 60.0)
    flown(boat, {2.0: "casualty fire-aft; casualty oil-leak-stern; stern planes emergency"}, 30.0)
    kept = boat.snapshot()
    flown(boat, {}, 40.0)
    ended = boat.snapshot()

    boat.restore(kept)
    flown(boat, {}, 40.0)

    assert boat.snapshot().tobytes() == ended.tobytes()


def test_nobody_answers_a_telegraph_without_power() -> None:
    boat = bb2_at(10.0, 60.0)
    told(boat, "casualty bus-dc-lost")
    boat.tick()
    answer = float(boat.state.telegraph_answer)
    told(boat, "bell ahead full")
    flown(boat, {}, 60.0)

    assert boat.state.telegraph_answer == answer
    assert boat.state.u_c < 0.1 * 10.0 * KNOT  # its control has no power either


def test_gauges_stand_still_without_power_and_go_on_with_it() -> None:
    boat = bb2_at(10.0, 60.0)
    told(boat, "casualty bus-starboard-lost")
    told(boat, "bell ahead full")
    boat.tick()
    held = float(boat.state.log_held)
    flown(boat, {}, 60.0)
    readings = boat.records.scratch["reading"][0]
    from trainer.core.casualties import LOG, instruments  # noqa: PLC0415

    instruments(boat.records.state, boat.records.scratch)
    assert readings[LOG] == held != boat.state.u
    flown(boat, {60.0: "loads shed; bus tie shut"}, 62.0)
    instruments(boat.records.state, boat.records.scratch)
    assert readings[LOG] == boat.state.u


# --- the file


def changed(change: Callable[[dict], None]) -> VesselFile:  # type: ignore[type-arg]
    """Return BB2 with something of its [plant] changed."""
    boat = load_vessel("bb2")
    table = deepcopy(tomllib.loads(boat.text))
    change(table["plant"])
    return read_vessel(table, "", boat.path)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            lambda p: p["consumers"][0].update(buses=["prt"]),
            'buses = ["prt"]: must list some of port, starboard, dc; nearest is port',
        ),
        (lambda p: p["consumers"][0].update(name="oven"), '[plant.consumers[0]] name = "oven"'),
        (
            lambda p: p["consumers"][3].update(buses=[]),
            "[plant] consumers: trim has no bus: give it one of port, starboard, dc",
        ),
        (
            lambda p: p["main"].update(low_mpa=20.7),
            "[plant] main.low_mpa = 20.7: must be below full_mpa = 20.7",
        ),
        (
            lambda p: p["surfaces"].update(dead_mpa=15.0),
            "[plant] surfaces.dead_mpa = 15: must be below rated_mpa = 14",
        ),
        (lambda p: p["vital"].update(usable_m3=0.0), "usable_m3 = 0"),
        (lambda p: p["main"].update(tank_m3=-1.0), "tank_m3 = -1"),
        (
            lambda p: p["surfaces"].update(modes=["normal", "manual"]),
            "must list some of normal, emergency, hand",
        ),
        (lambda p: p["surfaces"].update(modes=["hand"]), "surfaces.modes = ['hand']: lacks"),
        (lambda p: p["burning"][0].update(compartment="galley"), 'compartment = "galley"'),
        (lambda p: p["consumers"].pop(), "consumers"),
        (lambda p: p["pumps"][1].update(name="1"), "[plant] pumps: 1 is given twice"),
        (
            lambda p: p["hotel"][0].update(shed_w=80e3),
            "[plant] hotel: port: shed_w = 80000: must be at most power_w = 75000",
        ),
        (lambda p: p["pumps"][0].update(start_mpa=25.0), "must be at most the system's full_mpa"),
    ],
)
def test_a_plant_that_cannot_be_is_refused(change: Callable[[dict], None], says: str) -> None:  # type: ignore[type-arg]
    with pytest.raises(ConfigError) as wrong:
        changed(change)

    assert says in str(wrong.value)
    assert "bb2.toml" in str(wrong.value)


def test_a_boat_without_hands_for_its_planes_refuses_the_mode() -> None:
    file = changed(lambda p: p["surfaces"].update(modes=["normal", "emergency"]))
    boat = Boat(file, start_bb2().method)
    boat.start(10.0 * KNOT, 60.0, 0.0)

    assert isinstance(told(boat, "stern planes hand"), Refused)
    assert isinstance(told(boat, "stern planes emergency"), str)


# --- chains, as the statement has flown them


@pytest.mark.slow
@pytest.mark.parametrize(
    ("after", "deepest", "settled"), [(6.0, 149.8, 70.5), (30.0, 153.2, 85.0), (60.0, None, 147.0)]
)
def test_a_burst_header_in_a_dive_is_answered_by_a_shift(
    after: float, deepest: float | None, settled: float
) -> None:
    boat = bb2_at(15.0, 60.0)
    shift = "stern planes emergency; bow planes emergency"
    events = {40.0: "casualty oil-leak-header", 40.0 + after: shift}
    depths = flown(boat, events, 400.0, Planesman(boat, 150.0, bubble=10.0))

    out = [tick for tick, depth in enumerate(depths, start=1) if abs(depth - 150.0) > 3.0]
    if deepest:
        assert max(depths) == pytest.approx(deepest, rel=0.05)
    assert out[-1] * boat.method.step == pytest.approx(settled, abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("after", "deepest"), [(4, 87.0), (6, 90.5), (12, 105.0), (40, 209.0)])
def test_a_stuck_servo_is_cured_by_a_shift(after: float, deepest: float) -> None:
    boat = bb2_at(15.0, 80.0)
    events = {20.0: "casualty stern-servo-stuck", 20.0 + after: "stern planes emergency"}

    depths = flown(boat, events, 420.0, Planesman(boat, 80.0))

    assert max(depths) == pytest.approx(deepest, rel=0.05)
    assert abs(depths[-1] - 80.0) < 3.0


@pytest.mark.slow
def test_a_mechanical_jam_is_not_cured_by_a_shift() -> None:
    boat = bb2_at(10.0, 80.0)
    events = {20.0: "casualty stern-hard-over -0.3333", 26.0: "stern planes emergency"}

    depths = flown(boat, events, 120.0, Planesman(boat, 80.0))

    assert max(depths) > 110.0


@pytest.mark.slow
def test_a_leaking_leg_is_isolated_and_the_oil_kept() -> None:
    boat = bb2_at(10.0, 60.0)
    shifted = {76.0: "stern planes emergency", 80.0: "isolate stern"}
    events = {20.0: "casualty oil-leak-stern", **shifted}
    flown(boat, events, 300.0, Planesman(boat, 60.0))

    kept = 320.0 - 1e3 * float(boat.state.oil_spent_main - boat.state.tank_gain_main)
    assert kept == pytest.approx(210.0, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lines", "out"),
    [
        (
            {35.0: "ventilation secure", 40.0: "breaker starboard open", 45.0: "fight fire aft"},
            248.0,
        ),
        ({35.0: "ventilation secure", 45.0: "fight fire aft"}, 1147.0),
    ],
)
def test_a_fire_aft_is_out_when_it_is_fought(lines: Events, out: float) -> None:
    boat = bb2_at(8.0, 60.0)
    flown(boat, {20.0: "casualty fire-aft", **lines}, 45.5)
    while boat.state.fire_aft > 0.0:
        flown(boat, {}, boat.time + 0.4)

    assert boat.time - 20.0 == pytest.approx(out, abs=1.0)


@pytest.mark.slow
def test_a_fire_that_nobody_fights_takes_one_thing_after_the_other() -> None:
    boat = bb2_at(8.0, 60.0)
    flown(boat, {20.0: "casualty fire-aft"}, 20.4)
    dose = []
    while boat.time < 400.0:
        flown(boat, {}, boat.time + 0.4)
        dose.append((boat.time - 20.0, float(boat.state.burnt[2])))

    moments = [next(time for time, had in dose if had >= most) for most in (20, 60, 90, 180)]
    assert moments == pytest.approx([131, 214, 256, 357], abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lines", "share", "dead"),
    [
        ({70.0: "loads shed", 75.0: "bus tie shut"}, 97.0, 0.0),
        ({70.0: "compressor on", 75.0: "bus tie shut"}, 0.0, 2.0),
    ],
)
def test_a_lost_bus_at_periscope_depth_wants_loads_shed_before_the_tie(
    lines: Events, share: float, dead: float
) -> None:
    boat = make_boat("bb2", "modified")
    boat.sea = load_sea("sea-state-4")
    boat.start(5.0 * KNOT, 17.5, 0.0, 1)
    first = "trim manual; flood auxiliary 4"
    depths = flown(boat, {0.0: first, 60.0: "casualty bus-port-lost", **lines}, 900.0)

    later = depths[120:]
    near = 100.0 * sum(abs(depth - 17.5) <= 1.5 for depth in later) / len(later)
    assert boat.state.port_dead + boat.state.starboard_dead == dead
    assert near >= share if share else near < 50.0
