"""Orders about tanks and air: what each sets, who refuses it, and where it brings the boat."""

import math
from dataclasses import replace
from typing import Any

import pytest
from helpers.boats import fly
from helpers.orders import answer_of, obey_all, read_order
from helpers.sessions import frame_of

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.calls import Rank
from trainer.boat.helm import obey_order
from trainer.boat.pilot import GIVEN_UP_TEXTS, PilotMonitor
from trainer.config.boat.vessel import load_vessel
from trainer.core.autopilot.ascent import ASCENT_AFLOAT, NO_ASCENT
from trainer.io.orders.grammar import Refused
from trainer.session.stations.panels import compressor
from trainer.session.stations.status import status_lines
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

SURFACING = {
    **dict.fromkeys(("blow_forward", "blow_mid", "blow_aft"), 1.0),
    **dict.fromkeys(("vent_aft", "ordered_depth", "hover"), 0.0),
}
DIVING = {
    "ascent": NO_ASCENT,
    **dict.fromkeys(("vent_forward", "vent_mid", "vent_aft"), 1.0),
    "blow_aft": 0.0,
    "ordered_depth": 17.5,
}


def under_way(vessel: str = "bb2", speed_kn: float = 10.0, equations: str = "modified") -> Boat:
    """Return a boat just started in trim at 60 m, everything automatic."""
    file = load_vessel(vessel)
    boat = Boat(file, Method(equations, "lagged", "exact", "adams2", file.run.step_s))
    boat.start(speed_kn * KNOT, 60.0, 0.0)
    return boat


@pytest.fixture
def boat() -> Boat:
    return under_way()


def answer(boat: Boat, line: str) -> str | Refused:
    return obey_order(boat, read_order(line))


@pytest.mark.parametrize(
    ("before", "line", "changes"),
    [
        ({}, "vent forward open", {"vent_forward": 1.0}),
        ({"vent_forward": 1.0}, "vent forward shut", {"vent_forward": 0.0}),
        ({}, "vent all open", {"vent_forward": 1.0, "vent_mid": 1.0, "vent_aft": 1.0}),
        ({"vent_aft": 1.0}, "blow aft", {"vent_aft": 0.0, "blow_aft": 1.0}),
        ({}, "blow all", {"blow_forward": 1.0, "blow_mid": 1.0, "blow_aft": 1.0}),
        (
            {"blow_mid": 1.0, "blow_negative": 1.0, "negative_flood": 1.0},
            "blow stop",
            {"blow_mid": 0.0, "blow_negative": 0.0, "negative_flood": 0.0},
        ),
        (
            {"vent_mid": 1.0},
            "emergency blow",
            {"blow_forward": 2.0, "blow_mid": 2.0, "blow_aft": 2.0, "vent_mid": 0.0},
        ),
        (
            {"blow_negative": 1.0},
            "negative flood",
            {"negative_flood": 1.0, "vent_negative": 1.0, "blow_negative": 0.0},
        ),
        (
            {"vent_negative": 1.0},
            "negative blow",
            {"negative_flood": 1.0, "vent_negative": 0.0, "blow_negative": 1.0},
        ),
        ({}, "flood auxiliary 2.5 t", {"move_auxiliary": 2500.0}),
        ({}, "pump auxiliary 2", {"move_auxiliary": -2000.0}),
        ({"hover": 1.0}, "flood depth-control 3", {"move_depth_control": 3000.0, "hover": 0.0}),
        ({}, "pump depth-control 3", {"move_depth_control": -3000.0}),
        ({}, "pump trim forward 4", {"move_trim": 4000.0}),
        ({}, "pump trim aft 4", {"move_trim": -4000.0}),
        ({}, "drain forward", {"drained": 1.0}),
        ({}, "drain centre", {"drained": 2.0}),
        ({}, "drain aft", {"drained": 3.0}),
        ({"drained": 3.0}, "drain stop", {"drained": 0.0}),
        ({}, "compressor on", {"compressor": 1.0}),
        ({"compressor": 1.0}, "compressor off", {"compressor": 0.0}),
        ({"ordered_depth": 80.0}, "hover on", {"hover": 1.0, "ordered_depth": 60.0}),
        ({}, "hover 65", {"hover": 1.0, "ordered_depth": 65.0}),
        (
            {"hover": 1.0, "move_depth_control": 9.0},
            "hover off",
            {"hover": 0.0, "move_depth_control": 0.0},
        ),
        ({"vent_aft": 1.0, "hover": 1.0}, "surface", SURFACING),
        ({"blow_aft": 2.0, "ordered_depth": 0.0, "ascent": ASCENT_AFLOAT}, "dive", DIVING),
        ({}, "periscope depth", {"ordered_depth": 17.5}),
    ],
)
def test_an_order_sets_its_fields_and_no_others(
    boat: Boat, before: dict[str, float], line: str, changes: dict[str, float]
) -> None:
    for name, value in before.items():
        boat.state[name] = value
    expected = boat.snapshot()

    obey_all(boat, line)

    for name, value in changes.items():
        expected[name] = value
    assert boat.records.state.tobytes() == expected.tobytes()


def test_hovering_deeper_than_the_boat_may_go_is_refused(boat: Boat) -> None:
    before = boat.snapshot()
    order = read_order("hover 900")
    reply = obey_order(boat, order)
    assert isinstance(reply, Refused)
    assert "greatest depth is " in reply.reason
    assert boat.records.state.tobytes() == before.tobytes()


def test_a_dive_keeps_a_depth_that_is_deeper_than_the_periscope_allows(boat: Boat) -> None:
    obey_all(boat, "dive")
    assert boat.state.ordered_depth == 60.0


@pytest.mark.parametrize(
    "line",
    [
        *("surface", "dive", "blow all", "emergency blow", "vent mid open", "negative flood"),
        *("flood auxiliary 1", "pump trim aft 1", "drain stop", "hover on", "compressor on"),
    ],
)
def test_a_boat_without_tanks_refuses_and_says_why(line: str) -> None:
    boat = under_way("remus100", 3.0)
    before = boat.snapshot()

    refused = answer(boat, line)

    assert isinstance(refused, Refused)
    assert refused.reason == "remus100.toml has no [ballast] table: this boat has no tanks"
    assert boat.records.state.tobytes() == before.tobytes()


@pytest.mark.parametrize(
    ("kind", "place", "line", "lacking"),
    [
        ("blown", 3, "negative blow", "negative"),
        ("blown", 1, "vent mid open", "mid"),
        ("blown", 0, "blow forward", "forward"),
        ("pumped", 2, "pump auxiliary 1", "auxiliary tank"),
        ("pumped", 3, "hover on", "depth control tank"),
        ("pumped", 3, "flood depth-control 1", "depth control tank"),
        ("pumped", 1, "pump trim forward 1", "trim aft tank"),
        ("compartments", 2, "drain aft", "compartment aft"),
    ],
)
def test_an_order_about_a_tank_that_is_not_there_is_refused(
    kind: str, place: int, line: str, lacking: str
) -> None:
    file = load_vessel("bb2")
    assert file.ballast
    rows = getattr(file.ballast, kind)
    fewer: dict[str, Any] = {kind: (*rows[:place], *rows[place + 1 :])}
    ballast = replace(file.ballast, **fewer)
    boat = Boat(
        replace(file, ballast=ballast), Method("modified", "lagged", "exact", "adams2", 0.5)
    )
    boat.start(10.0 * KNOT, 60.0, 0.0)

    refused = answer(boat, line)

    assert isinstance(refused, Refused)
    assert refused.reason == f"this boat has no {lacking}"


def test_a_boat_without_a_periscope_depth_asks_for_a_depth() -> None:
    refused = answer(under_way("sdv-mk9", 3.0), "periscope depth")
    assert isinstance(refused, Refused)
    assert "order a depth" in refused.reason


@pytest.mark.parametrize(("depth", "time", "bow_down"), [(60.0, 120.0, 8.0), (300.0, 500.0, 22.0)])
def test_surfacing_at_speed_holds_the_boat_level_and_lays_the_planes_amidships_afloat(
    boat: Boat, depth: float, time: float, bow_down: float
) -> None:
    boat.start(10.0 * KNOT, depth, 0.0)
    pilot = PilotMonitor.over(boat)
    obey_all(boat, "surface")
    s = boat.state
    said, lowest = [], 0.0
    for _ in range(round((time + 60.0) / boat.method.step)):
        assert boat.tick() == 0
        said += pilot.look(boat)
        lowest = min(lowest, s.theta)
    assert math.degrees(lowest) > -bow_down  # 23 by planes that kept depth 0
    assert s.z < 4.5
    assert (s.command_s, s.command_b) == (0.0, 0.0)
    (afloat,) = [call for call in said if "autopilot: " in call.text]
    assert afloat.text.endswith(GIVEN_UP_TEXTS["afloat"])
    assert afloat.rank is Rank.CAUTION, "what was ordered rings no bell"

    obey_all(boat, "dive")
    fly(boat, 300.0)
    assert s.z == pytest.approx(17.5, abs=3.0)


def test_the_depth_that_is_kept_after_an_ascent_is_called_as_it_was_ordered(boat: Boat) -> None:
    pilot = PilotMonitor.over(boat)
    obey_all(boat, "emergency blow")
    fly(boat, 1.0)
    (rising,) = pilot.look(boat)
    assert GIVEN_UP_TEXTS["emergency ascent"] in rising.text
    assert rising.rank is Rank.WARNING
    obey_all(boat, "dive")
    fly(boat, 1.0)
    (over,) = pilot.look(boat)
    assert over.text.endswith("autopilot: the ascent is over: keeping depth 17.5 m")
    assert over.rank is Rank.CAUTION


def test_open_vents_below_open_blow_valves_do_not_bring_a_boat_down(boat: Boat) -> None:
    obey_all(boat, "emergency blow")
    fly(boat, 200.0)
    obey_all(boat, "vent all open")

    assert "is not kept" in answer_of(boat, "depth 60")
    obey_all(boat, "blow stop")
    assert answer_of(boat, "depth 60") == "keeping depth 60 m"
    fly(boat, 900.0)
    assert boat.state.z == pytest.approx(60.0, abs=1.0)


def test_with_the_planes_in_hand_no_depth_is_said_to_be_kept_after_an_ascent(boat: Boat) -> None:
    obey_all(boat, "emergency blow")
    fly(boat, 1.0)
    pilot = PilotMonitor.over(boat)
    obey_all(boat, "autopilot off")
    fly(boat, 1.0)
    (over,) = pilot.look(boat)
    assert over.text.endswith("autopilot: the ascent is over")


@pytest.mark.parametrize("equations", ["modified", "full"])
def test_from_60_m_up_and_down_again_by_orders(equations: str) -> None:
    boat = under_way(equations=equations)
    s = boat.state

    obey_all(boat, "trim manual", "surface")
    fly(boat, 240.0)
    obey_all(boat, "blow stop")
    fly(boat, 240.0)
    # Surfaced she floats with 10 % of her mass in the air: the deck is out, the keel 9 m deep.
    assert s.z == pytest.approx(4.1, abs=0.3)
    assert abs(s.theta) < math.radians(2.0)
    assert s.weight < 0.9 * boat.vessel.weight
    assert 0.1 < s.bank_main / boat.vessel.bank_full[0] < 0.5

    obey_all(boat, "dive")
    fly(boat, 300.0)
    assert s.weight == pytest.approx(boat.vessel.weight, rel=1e-9)
    assert s.z == pytest.approx(17.5, abs=3.0)

    obey_all(boat, "depth 60")
    fly(boat, 300.0)
    assert s.z == pytest.approx(60.0, abs=0.5)

    obey_all(boat, "periscope depth")
    fly(boat, 400.0)
    assert s.z == pytest.approx(17.5, abs=0.5)


def test_afloat_after_a_blow_no_depth_is_said_to_be_kept_until_the_boat_dives(boat: Boat) -> None:
    obey_all(boat, "emergency blow")
    fly(boat, 120.0)
    blowing = answer(boat, "depth 60")
    obey_all(boat, "blow stop")
    fly(boat, 30.0)
    before = boat.snapshot().tobytes()

    for line in ("depth 60", "periscope depth", "hover 30"):
        refused = answer(boat, line)
        assert isinstance(refused, Refused)
        assert refused.reason.startswith("main ballast is blown: the boat is 4")
        assert refused.reason.endswith(" m; dive first")
    assert boat.snapshot().tobytes() == before
    assert isinstance(blowing, Refused)
    assert answer(boat, "depth 0") == "keeping depth 0 m"
    obey_all(boat, "dive")
    assert answer(boat, "depth 60") == "keeping depth 60 m"
    fly(boat, 600.0)
    assert float(boat.state.z) == pytest.approx(60.0, abs=1.0)


def test_while_main_ballast_is_being_blown_no_depth_is_said_to_be_kept(boat: Boat) -> None:
    obey_all(boat, "emergency blow")
    fly(boat, 1.5)
    for line in ("depth 60", "depth 80"):
        refused = answer(boat, line)
        assert isinstance(refused, Refused)
        assert refused.reason.startswith("main ballast is being blown: ")
    obey_all(boat, "dive")
    assert answer(boat, "depth 60") == "keeping depth 60 m"


def test_a_boat_that_is_a_little_light_keeps_a_depth_if_it_is_fast_enough() -> None:
    kept = []
    for speed_kn in (5.0, 12.0):
        boat = under_way(speed_kn=speed_kn)
        obey_all(boat, "emergency blow")
        fly(boat, 8.0)
        obey_all(boat, "blow stop")
        said = isinstance(answer(boat, "depth 60"), str)
        fly(boat, 600.0)
        kept.append((said, abs(float(boat.state.z) - 60.0) < 1.0))
    assert kept == [(False, False), (True, True)]


def test_hovering_by_orders_keeps_the_boat_where_she_stops() -> None:
    boat = under_way(speed_kn=3.0)
    obey_all(boat, "bell stop", "planes manual", "flood depth-control 2", "hover on")
    fly(boat, 1200.0)
    assert boat.state.u < 1.0
    assert boat.state.z == pytest.approx(60.0, abs=0.5)

    obey_all(boat, "depth 65", "planes manual")
    fly(boat, 900.0)
    assert boat.state.z == pytest.approx(65.0, abs=0.5)


def test_a_compressor_without_air_says_where_it_has_some(boat: Boat) -> None:
    boat.state.z = 60.0
    assert obey_order(boat, read_order("compressor on")) == (
        "compressor on; it has air at 17.5 m or less"
    )
    frame = frame_of(boat)
    assert compressor(frame) == "no air"
    boat.state.z = 17.5
    assert compressor(frame_of(boat)) == "on"
    assert obey_order(boat, read_order("compressor on")) == "compressor on"


def test_status_tells_of_tanks_air_and_sea_in_79_columns(boat: Boat) -> None:
    obey_all(
        boat,
        "trim manual",
        "hover on",
        "blow aft",
        "compressor on",
        "sea height 11.75",
        "flood auxiliary 5",
    )
    boat.state.breach_forward = boat.state.breach_centre = boat.state.breach_aft = 0.05
    fly(boat, 30.0)
    lines = status_lines(boat, Ledger(0.5).summary())

    assert max(map(len, lines)) <= 79
    for words in (
        *(
            "main ballast forward 100, mid 100, aft",
            "trim by hand forward 10.2, aft 10.2",
            "auxiliary 31",
        ),
        *("air banks main 2", "emergency 25.0 MPa; on: hover, compressor", "flooded forward"),
        *("sea ordered 11.8 m, peak at 17.1 s, from 000, in 30 s", "sea 5."),
    ):
        assert any(words in line for line in lines), (words, lines)


def test_status_of_a_boat_in_trim_names_nothing_that_is_off() -> None:
    lines = status_lines(under_way(), Ledger(0.5).summary())
    assert "air banks main 25.0, emergency 25.0 MPa" in lines
    assert not any(line.startswith(("flooded", "sea ordered")) for line in lines)


def test_status_of_a_boat_without_tanks_tells_of_none() -> None:
    lines = status_lines(under_way("remus100", 3.0), Ledger(0.1).summary())
    assert not any("ballast" in line or "banks" in line for line in lines)
    assert "sea calm" in lines
