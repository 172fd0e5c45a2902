"""Orders carried out on a boat, or refused and nothing changed."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from helpers.boats import calls_of, fly, start_boat
from helpers.orders import answer_of, obey_all, read_order
from helpers.places import ROOT
from hypothesis import given
from hypothesis import strategies as st

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.helm import COURSE_DUTIES, obey_order
from trainer.boat.pilot import GIVEN_UP_TEXTS, PilotMonitor
from trainer.config.boat.vessel import load_vessel
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

DEGREE = math.pi / 180.0
VESSELS = ("bb2", "sdv-mk9", "remus100")
STARTED: dict[str, Boat] = {}


def under_way(vessel: str = "bb2") -> Boat:
    """Return a boat just started in trim, as its file says, on everything automatic."""
    file = load_vessel(vessel)
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    return boat


@pytest.fixture
def boat() -> Boat:
    return under_way()


def without_autopilot() -> Boat:
    file = replace(load_vessel("bb2"), autopilot=None)
    boat = Boat(file, Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(10.0 * KNOT, 60.0, 0.0)
    return boat


# What an order changes


@pytest.mark.parametrize(
    ("line", "reply", "changes"),
    [
        ("depth 80", "keeping depth 80 m", {"ordered_depth": 80.0}),
        ("depth 260 ft", "keeping depth 79.248 m", {"ordered_depth": 79.248}),
        ("depth auto", "keeping depth 60 m", {}),
        ("course 090", "keeping course 090", {"ordered_psi": 90.0 * DEGREE}),
        ("course 270", "keeping course 270", {"ordered_psi": -90.0 * DEGREE}),
        ("course auto", "keeping course 000", {}),
        ("course left 30", "keeping course 330", {"ordered_psi": -30.0 * DEGREE}),
        ("course right 270", "keeping course 270", {"ordered_psi": 270.0 * DEGREE}),
        ("speed 12", "keeping speed 12 kn", {"ordered_speed": 12.0 * KNOT}),
        ("speed 6 m/s", "keeping speed 11.6631 kn", {"ordered_speed": 6.0}),
        ("speed auto", "keeping speed 10 kn", {}),
        ("turns 12", "turns for 12 kn", {"ordered_u_c": 12.0 * KNOT, "speed_by_hand": 1.0}),
        # 80 revolutions a minute, 0.22937 revolutions a second for each m/s
        ("rpm 80", "turns for 11.3 kn", {"ordered_u_c": 80 / 60 / 0.22937, "speed_by_hand": 1.0}),
        ("rpm -30", "for -4.24 kn", {"ordered_u_c": -0.5 / 0.22937, "speed_by_hand": 1.0}),
        ("ahead flank", "turns for 20 kn", {"ordered_u_c": 20.0 * KNOT, "speed_by_hand": 1.0}),
        ("bell astern 2/3", "for -5 kn", {"ordered_u_c": -5.0 * KNOT, "speed_by_hand": 1.0}),
        ("bell stop", "turns for 0 kn", {"ordered_u_c": 0.0, "speed_by_hand": 1.0}),
        # BB2's rudder is positive to port, its stern planes dive, its bow planes rise
        ("rudder left 15", "by hand", {"ordered_r": 15.0 * DEGREE, "rudder_by_hand": 1.0}),
        ("rudder right full", "by hand", {"ordered_r": -30.0 * DEGREE, "rudder_by_hand": 1.0}),
        ("rudder amidships", "by hand", {"ordered_r": 0.0, "rudder_by_hand": 1.0}),
        ("rudder manual", "rudder by hand", {"ordered_r": 0.125, "rudder_by_hand": 1.0}),
        ("rudder auto", "rudder automatic", {}),
        ("stern dive 10", "by hand", {"ordered_s": 10.0 * DEGREE, "stern_by_hand": 1.0}),
        ("stern rise 10", "by hand", {"ordered_s": -10.0 * DEGREE, "stern_by_hand": 1.0}),
        ("stern zero", "by hand", {"ordered_s": 0.0, "stern_by_hand": 1.0}),
        ("stern manual", "stern planes by hand", {"ordered_s": 0.25, "stern_by_hand": 1.0}),
        ("stern auto", "stern planes automatic", {}),
        ("sail planes rise 30", "by hand", {"ordered_b": 30.0 * DEGREE, "bow_by_hand": 1.0}),
        ("bow dive 5", "by hand", {"ordered_b": -5.0 * DEGREE, "bow_by_hand": 1.0}),
        ("bow manual", "bow planes by hand", {"ordered_b": -0.125, "bow_by_hand": 1.0}),
        ("bow auto", "bow planes automatic", {}),
        (
            "planes manual",
            "planes by hand",
            {"ordered_s": 0.25, "ordered_b": -0.125, "stern_by_hand": 1.0, "bow_by_hand": 1.0},
        ),
        ("planes auto", "stern planes and bow planes automatic", {}),
        ("autopilot report", "the report's law", {"depth_law": 1.0}),
        ("autopilot literal", "as it is printed", {"depth_law": 2.0}),
        ("autopilot trainer", "this trainer's own law", {}),
        ("autopilot on", "everything automatic", {}),
        (
            "autopilot off",
            "everything by hand",
            {
                "ordered_r": 0.125,
                "ordered_s": 0.25,
                "ordered_b": -0.125,
                "ordered_u_c": 4.5,
                "rudder_by_hand": 1.0,
                "stern_by_hand": 1.0,
                "bow_by_hand": 1.0,
                "speed_by_hand": 1.0,
                "trim_by_hand": 1.0,
            },
        ),
        ("trim manual", "trim by hand", {"trim_by_hand": 1.0}),
    ],
)
def test_an_order_changes_what_it_says_and_nothing_else(
    boat: Boat, line: str, reply: str, changes: dict[str, float]
) -> None:
    s = boat.state
    s.delta_r, s.delta_s, s.delta_b, s.u_c = 0.125, 0.25, -0.125, 4.5
    s.ordered_r, s.ordered_s, s.ordered_b, s.ordered_u_c = 0.5, 0.5, 0.5, 1.0
    expected = boat.snapshot()
    for name, value in changes.items():
        expected[name] = value

    (answer,) = obey_all(boat, line)

    assert reply in answer
    for name, value in changes.items():
        assert s[name] == pytest.approx(value, rel=1e-12)
        expected[name] = s[name]
    assert boat.records.state.tobytes() == expected.tobytes()


@pytest.mark.parametrize(
    ("hand", "automatic", "places"),
    [
        ("rudder left 15", "rudder auto", ["rudder_by_hand"]),
        ("stern rise 5", "stern auto", ["stern_by_hand"]),
        ("bow rise 5", "bow auto", ["bow_by_hand"]),
        ("planes manual", "planes auto", ["stern_by_hand", "bow_by_hand"]),
        ("planes manual", "depth auto", ["stern_by_hand", "bow_by_hand"]),
        ("planes manual", "depth 70", ["stern_by_hand", "bow_by_hand"]),
        ("rudder left 15", "course 010", ["rudder_by_hand"]),
        ("rudder left 15", "course right 10", ["rudder_by_hand"]),
        ("rudder left 15", "course auto", ["rudder_by_hand"]),
        ("bell stop", "speed 8", ["speed_by_hand"]),
        ("turns 4", "speed auto", ["speed_by_hand"]),
        ("autopilot off", "autopilot on", ["rudder_by_hand", "bow_by_hand", "speed_by_hand"]),
    ],
)
def test_what_was_taken_by_hand_is_given_back(
    boat: Boat, hand: str, automatic: str, places: list[str]
) -> None:
    obey_all(boat, hand)
    assert [boat.state[place] for place in places] == [1.0] * len(places)
    obey_all(boat, automatic)
    assert [boat.state[place] for place in places] == [0.0] * len(places)


# Refusals


@pytest.mark.parametrize(
    ("make", "line", "reason"),
    [
        (under_way, "rudder left 30.1", "the limit of the rudder is 30 degrees, not 30.1"),
        (under_way, "stern dive 45", "the limit of the stern planes is 30 degrees, not 45"),
        (under_way, "bow rise 31", "the limit of the bow planes is 30 degrees, not 31"),
        (under_way, "speed 20.5", "this boat's greatest speed is 20 kn, not 20.5"),
        (under_way, "turns 21", "turns must be -8 to 20 kn, -57 to 142 rpm"),
        (under_way, "turns -9", "turns must be -8 to 20 kn"),
        (under_way, "rpm 143", "-57 to 142 rpm"),
        (lambda: under_way("remus100"), "bow rise 5", "this boat has no bow planes"),
        (lambda: under_way("remus100"), "bow manual", "this boat has no bow planes"),
        (lambda: under_way("remus100"), "bow auto", "this boat has no bow planes"),
        *(
            (without_autopilot, line, "bb2.toml has no [autopilot] table: steer by hand")
            for line in (
                *("depth 80", "depth auto", "course 090", "course left 30", "course auto"),
                *("speed 8", "speed auto", "rudder auto", "stern auto", "planes auto"),
                *("autopilot on", "autopilot off", "autopilot report"),
            )
        ),
    ],
)
def test_an_order_that_cannot_be_obeyed_says_why_and_changes_nothing(
    make: Callable[[], Boat], line: str, reason: str
) -> None:
    boat = make()
    before = boat.records.state.tobytes()

    answer = obey_order(boat, read_order(line))

    assert isinstance(answer, Refused)
    assert reason in answer.reason
    assert boat.records.state.tobytes() == before


def test_a_depth_below_the_greatest_of_the_boat_is_refused(boat: Boat) -> None:
    boat.file = replace(boat.file, hull=replace(boat.file.hull, max_depth_m=300.0))
    before = boat.records.state.tobytes()

    assert obey_order(boat, read_order("depth 301")) == Refused(
        "this boat's greatest depth is 300 m, not 301 m"
    )
    assert boat.records.state.tobytes() == before
    obey_all(boat, "depth 300")


def test_a_bell_the_telegraph_lacks_is_refused_with_those_it_has(boat: Boat) -> None:
    bells = {"ahead_one_third": 4.0, "astern_full": -8.0}
    boat.file = replace(boat.file, propulsion=replace(boat.file.propulsion, bells_kn=bells))
    before = boat.records.state.tobytes()

    assert obey_order(boat, read_order("ahead flank")) == Refused(
        "this boat's telegraph has ahead one third, astern full and stop"
    )
    assert boat.records.state.tobytes() == before
    obey_all(boat, "astern full", "bell stop")


def test_a_boat_without_autopilot_is_steered_by_hand() -> None:
    boat = without_autopilot()
    obey_all(boat, "rudder right 10", "stern dive 5", "bow rise 5", "turns 12", "planes manual")
    fly(boat, 20.0)
    assert boat.state.psi > 0.1


def test_orders_for_both_planes_pass_over_a_pair_the_boat_lacks() -> None:
    boat = under_way("remus100")
    assert boat.state.bow_by_hand == 1.0  # nothing there to be automatic
    assert obey_all(boat, "planes manual", "planes auto") == [
        "planes by hand",
        "stern planes automatic",
    ]
    assert [boat.state.stern_by_hand, boat.state.bow_by_hand] == [0.0, 1.0]


# Which way


@pytest.mark.parametrize("vessel", VESSELS)
@pytest.mark.parametrize(("side", "sign"), [("right", 1.0), ("left", -1.0)])
def test_right_rudder_turns_right_and_left_rudder_left(vessel: str, side: str, sign: float) -> None:
    boat = under_way(vessel)
    obey_all(boat, f"rudder {side} 10")
    fly(boat, 20.0 if vessel == "bb2" else 3.0)
    assert sign * boat.state.psi > 0.045
    assert sign * boat.state.r > 0.0
    assert sign * boat.state.delta_r * boat.toward["rudder"] == pytest.approx(10.0 * DEGREE)


@pytest.mark.parametrize("vessel", VESSELS)
@pytest.mark.parametrize(("way", "sign"), [("dive", 1.0), ("rise", -1.0)])
def test_stern_planes_to_dive_put_the_bow_down_and_take_the_boat_deeper(
    vessel: str, way: str, sign: float
) -> None:
    boat = under_way(vessel)
    start, level = float(boat.state.z), float(boat.state.theta)
    obey_all(boat, "planes manual", f"stern planes {way} 12")  # REMUS 100 flies level at 8.7, rise
    fly(boat, 40.0 if vessel == "bb2" else 4.0)
    assert sign * (boat.state.theta - level) < -0.02
    assert sign * (boat.state.z - start) > 0.1


@pytest.mark.parametrize("vessel", ["bb2", "sdv-mk9"])
@pytest.mark.parametrize(("way", "sign"), [("dive", 1.0), ("rise", -1.0)])
def test_bow_planes_to_dive_take_the_boat_deeper(vessel: str, way: str, sign: float) -> None:
    boat = under_way(vessel)
    start = float(boat.state.z)
    obey_all(boat, "planes manual", f"bow planes {way} 10")
    fly(boat, 60.0 if vessel == "bb2" else 10.0)
    assert sign * (boat.state.z - start) > 0.1


@pytest.mark.parametrize("vessel", VESSELS)
def test_the_autopilot_goes_where_it_is_told(vessel: str) -> None:
    boat = under_way(vessel)
    depth = float(boat.state.z) + 5.0
    obey_all(boat, f"depth {depth}", "course 020")
    fly(boat, 400.0 if vessel == "bb2" else 120.0)
    assert boat.state.z == pytest.approx(depth, abs=0.5)
    assert boat.state.psi == pytest.approx(20.0 * DEGREE, abs=1.0 * DEGREE)


def test_turns_are_answered_with_more_speed_and_astern_bells_with_less() -> None:
    speeds = []
    for line in ("turns 15", "turns 10", "astern full"):
        boat = under_way()
        obey_all(boat, line)
        fly(boat, 60.0)
        speeds.append(float(boat.state.u))
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[0] > 11.0 * KNOT
    assert speeds[2] < 6.0 * KNOT


@pytest.mark.long
@given(st.floats(-60.0, 60.0), st.floats(0.0, 360.0), st.sampled_from(["course", "rudder"]))
def test_a_course_is_steered_the_short_way_however_often_the_boat_has_turned(
    heading: float, course: float, head: str
) -> None:
    boat = STARTED.setdefault("bb2", under_way())
    s = boat.state
    s.psi = heading
    if head == "course":
        obey_all(boat, f"course {course:.6f}")
    else:  # turned by hand since the course was ordered
        s.ordered_psi = course * DEGREE
        obey_all(boat, "rudder auto")

    assert abs(s.ordered_psi - heading) <= math.pi + 1e-9
    turns = (s.ordered_psi - course * DEGREE) / math.tau
    assert turns == pytest.approx(round(turns), abs=1e-7)


def test_a_change_of_course_is_steered_the_way_ordered_from_the_course_kept(boat: Boat) -> None:
    boat.state.psi, boat.state.ordered_psi = 20.0, 20.5
    obey_all(boat, "course left 350")
    assert boat.state.ordered_psi == pytest.approx(20.5 - 350.0 * DEGREE)

    obey_all(
        boat, "rudder right 5", "course right 10"
    )  # by hand there is no course: from the heading
    assert boat.state.ordered_psi == pytest.approx(20.0 + 10.0 * DEGREE)


# What goes by the rudder that is on, by the swing, or by the heading of this moment


def rudder(boat: Boat) -> float:
    """Return the rudder ordered by hand [deg], right positive."""
    assert boat.state.rudder_by_hand
    return math.degrees(float(boat.state.ordered_r) * boat.toward["rudder"])


@pytest.mark.parametrize(
    ("before", "line", "answer", "angle"),
    [
        ("rudder right 15", "rudder ease 5", "rudder right 5, by hand", 5.0),
        ("rudder left 15", "rudder ease 5", "rudder left 5, by hand", -5.0),
        ("rudder left 15", "rudder ease 15", "rudder left 15, by hand", -15.0),
        ("rudder left 15", "shift your rudder", "rudder right 15, by hand", 15.0),
        ("rudder right 7.5", "rudder shift", "rudder left 7.5, by hand", -7.5),
    ],
)
def test_the_rudder_is_eased_and_shifted_by_what_is_on(
    before: str, line: str, answer: str, angle: float
) -> None:
    for vessel in VESSELS[:2]:
        boat = under_way(vessel)
        obey_all(boat, before)
        assert obey_all(boat, line) == [answer]
        assert rudder(boat) == pytest.approx(angle)


@pytest.mark.parametrize(
    ("before", "line", "why"),
    [
        ("rudder amidships", "rudder ease 5", "the rudder is amidships: nothing to ease"),
        ("rudder amidships", "rudder shift", "the rudder is amidships: nothing to shift"),
        (
            "rudder right 3",
            "rudder ease 5",
            "the rudder is right 3: ease it to less than that, not 5",
        ),
        ("rudder amidships", "meet her", "the boat does not swing: there is nothing to meet"),
    ],
)
def test_what_the_rudder_cannot_do_as_it_is_is_refused(
    boat: Boat, before: str, line: str, why: str
) -> None:
    obey_all(boat, before)
    kept = boat.records.state.tobytes()
    assert obey_order(boat, read_order(line)) == Refused(why)
    assert boat.records.state.tobytes() == kept


@pytest.mark.parametrize(
    ("before", "angle"),
    [("rudder right 20", -20.0), ("rudder left 20", 20.0), ("rudder right 4", -10.0)],
)
def test_a_swing_is_met_by_opposite_rudder(boat: Boat, before: str, angle: float) -> None:
    obey_all(boat, before)
    fly(boat, 30.0)
    obey_all(boat, "meet her")
    assert rudder(boat) == pytest.approx(angle)


@pytest.mark.parametrize(
    ("line", "turned"),
    [
        ("course right to 010", 10.0),
        ("course left to 010", -350.0),
        ("course left to 000", 0.0),
        ("course right to 270", 270.0),
        ("come left to 350", -10.0),
    ],
)
def test_a_course_is_steered_the_way_that_is_said(boat: Boat, line: str, turned: float) -> None:
    boat.state.psi = 4.0 * math.pi
    obey_all(boat, line)
    assert math.degrees(float(boat.state.ordered_psi)) - 720.0 == pytest.approx(turned)


def test_steady_keeps_the_heading_of_this_moment(boat: Boat) -> None:
    boat.state.psi = 1.25
    assert obey_all(boat, "steady as she goes") == ["keeping course 072"]
    assert float(boat.state.ordered_psi) == pytest.approx(1.25)


def test_both_planes_go_to_zero_and_each_pair_as_far_as_it_goes(boat: Boat) -> None:
    obey_all(boat, "stern planes full rise", "bow planes full dive")
    toward, c = boat.toward, boat.vessel
    assert float(boat.state.ordered_s) * toward["stern"] == pytest.approx(float(c.limit_s))
    assert float(boat.state.ordered_b) * toward["bow"] == pytest.approx(-float(c.limit_b))
    assert obey_all(boat, "planes zero") == ["planes zero, by hand"]
    assert (boat.state.ordered_s, boat.state.ordered_b) == (0.0, 0.0)
    assert boat.state.stern_by_hand
    assert boat.state.bow_by_hand


@pytest.mark.parametrize("vessel", sorted(p.stem for p in (ROOT / "configs/vessels").iterdir()))
@pytest.mark.parametrize("share", [0.4, 0.7, 1.0])
@pytest.mark.parametrize("course", ["course 020", "course 270", "course left to 045"])
def test_a_course_is_kept_astern_or_refused_and_a_boat_that_swings_is_told(
    vessel: str, share: float, course: str
) -> None:
    boat = start_boat(1.5, vessel=vessel, step=load_vessel(vessel).run.step_s)
    pilot = PilotMonitor.over(boat)
    obey_all(boat, f"turns {share * boat.vessel.u_c_astern / KNOT:.2f}")
    fly(boat, 300.0)
    before, begun = boat.snapshot(), float(boat.state.psi)
    refused = answer_of(boat, course).startswith("going astern the rudder does not stop her swing")
    if refused:
        assert boat.snapshot().tobytes() == before.tobytes()
        COURSE_DUTIES[read_order(course).name](boat, read_order(course))
    kept = float(boat.state.ordered_psi)
    said = " ".join(call.text for call in calls_of(boat, pilot, 1200.0))

    left = abs(float(boat.state.psi) - kept)
    assert refused == (vessel != "bb2")
    assert refused == (left > math.tau)
    assert refused or left < abs(begun - kept)
    assert (GIVEN_UP_TEXTS["swinging"] in said) == refused


@pytest.mark.parametrize("vessel", sorted(p.stem for p in (ROOT / "configs/vessels").iterdir()))
@pytest.mark.parametrize("share", [0.5, 1.0])
@pytest.mark.parametrize("depth", [30, 55])
def test_a_depth_is_kept_astern_or_that_it_is_not_is_said(
    vessel: str, share: float, depth: int
) -> None:
    boat = start_boat(1.5, vessel=vessel, step=load_vessel(vessel).run.step_s)
    astern = answer_of(boat, f"turns {share * boat.vessel.u_c_astern / KNOT:.2f}")
    fly(boat, 300.0)
    before = boat.snapshot()
    answer = answer_of(boat, f"depth {depth}")
    if refused := answer != f"keeping depth {depth} m":
        assert answer.startswith("going astern the planes do not bring her to ")
        assert boat.snapshot().tobytes() == before.tobytes()
    fly(boat, 2400.0)

    left = abs(float(boat.state.z) - float(boat.state.ordered_depth))
    if refused:  # the depth ordered before is kept where that was said
        assert (left < 10.0) == (not astern.endswith("; astern no depth is kept"))
    else:
        assert left < 5.5
    assert refused != (vessel == "bb2" and share == 0.5) or vessel == "sdv-mk9"


@pytest.mark.parametrize("words", ["bell astern full", "astern full", "turns -8", "rpm -56"])
def test_each_wording_of_full_astern_says_that_no_depth_is_kept(words: str) -> None:
    boat = start_boat(10.0 * KNOT)
    assert answer_of(boat, words).endswith("; astern no depth is kept")
    fly(boat, 2400.0)
    assert abs(boat.state.z - 60.0) > 30.0


def test_an_astern_bell_that_keeps_the_depth_says_nothing_of_it() -> None:
    boat = start_boat(10.0 * KNOT)
    assert answer_of(boat, "bell astern 2/3").endswith("turns for -5 kn")
    fly(boat, 2400.0)
    assert abs(boat.state.z - 60.0) < 1.0
