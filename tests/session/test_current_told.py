"""The current as it is told at the stations, to programs and in a debrief, and taken over from."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import make_boat, start_boat, take_ticks
from helpers.sessions import frame_of, start_plan
from helpers.whole_passage import rows_beyond

from trainer.api.boat import Boat as Ship
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.limits import LimitMonitor, following_speed_ratio
from trainer.boat.quantities import is_met
from trainer.boat.world.world import World
from trainer.cli.export import boat_at_start
from trainer.config.exercise.derived import compile_conditions
from trainer.config.exercise.exercise import ExerciseLimits, parse_exercise
from trainer.config.files import ConfigError, Position
from trainer.config.world.sea import load_sea
from trainer.debrief.marks.rehearsal import Departure, fly, fly_rehearsal
from trainer.debrief.page.boat_page import boat_of
from trainer.io.chart import DEFAULT_CHART
from trainer.session.nmea.readings import read_fields
from trainer.session.nmea.sentences import USUAL_NAMES, choose_instruments
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.roles import ROLES
from trainer.session.stations.status import current_lines
from trainer.session.stations.view import Frame
from trainer.units import KNOT

START = datetime(2026, 1, 1, tzinfo=UTC)
EXERCISE = """
schema = "exercise/1"
name = "Adrift"
briefing = "A current that turns, and another by order."
duration_s = 60

[current]
tide = { major_kn = 2, minor_kn = 1, towards_deg = 30, period_h = 1 }

[limits]
speed_over_ground_kn_max = 11

[[orders]]
at_s = 5
order = "current set 270 drift 3"
"""


def carried(boat: Boat) -> Frame:
    """Return what is seen of a boat that heads 045 at 10 kn, slips to port, in 2 kn towards 090."""
    boat.start(10.0 * KNOT, 60.0, math.radians(45.0))
    s = boat.state
    s.u, s.v, s.w, s.psi = 10.0 * KNOT, -0.3 * KNOT, 0.0, math.radians(45.0)
    s.phi = s.theta = 0.0  # the trim of a level boat
    s.current[:] = 0.0, 2.0 * KNOT, 0.0, 0.0
    return frame_of(boat)


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    path = tmp_path / "adrift.toml"
    path.write_text(EXERCISE)
    return plan_run(RunOptions(exercise=str(path)))


# What is shown


def test_programs_are_told_set_drift_and_both_ways() -> None:
    seen = read_fields(carried(make_boat()), DEFAULT_CHART, START)
    vtg, vdr, vbw = choose_instruments(("VDR", "VBW", "VTG"))
    assert vtg.sentence(seen).startswith("$INVTG,50.58,T,,M,11.47,N,")
    assert vdr.sentence(seen) == "$INVDR,90.0,T,,M,2.00,N*1B"
    assert vbw.sentence(seen) == "$INVBW,10.00,-0.30,A,11.41,1.11,A,,V,,V*6F"


def test_what_a_trainee_is_to_find_is_sent_only_where_it_is_named() -> None:
    assert "VTG" in USUAL_NAMES
    assert {"VDR", "VBW"}.isdisjoint(USUAL_NAMES)


def test_the_instructor_alone_sees_the_current_and_the_way_over_the_ground() -> None:
    boat = make_boat()
    shown = CHANNELS["current"].values(carried(boat))
    assert shown == ["90.0", "2.00", "50.6", "11.47"]
    boat.state.held_position = 1.0
    assert CHANNELS["current"].values(frame_of(boat)) == ["90.0", "2.00", "45.0", "0.00"]
    boat.state.current[:] = 0.0
    assert CHANNELS["current"].values(frame_of(boat))[:2] == ["", "0.00"]
    assert [name for name, role in ROLES.items() if "current" in role.channels] == ["instructor"]


def test_the_set_shown_is_that_of_the_water_at_the_boat() -> None:
    boat = make_boat()
    carried(boat)
    boat.state.current[:] = 2.0 * KNOT, 0.0, -4.0 * KNOT / 60.0, 0.0  # 2 kn north above, south here
    assert CHANNELS["current"].values(frame_of(boat))[:2] == ["180.0", "2.00"]


def test_the_status_has_a_line_of_it_where_there_is_any(plan: Plan) -> None:
    boat = start_plan(plan)
    (line,) = current_lines(frame_of(boat), boat)
    assert line == "current towards 030 at 2.00 kn; over ground 004.9 at 11.78 kn"
    boat.world = World()
    assert current_lines(frame_of(boat), boat) == []


# What is judged


def test_speed_over_the_ground_is_a_quantity_and_a_limit() -> None:
    boat = make_boat()
    carried(boat)
    for text, holds in (
        ("speed_over_ground > 11.4 kn", True),
        ("speed_over_ground_kn > 11.5", False),
    ):
        (condition,) = compile_conditions(text, Position("my.toml", ""))
        assert is_met(condition, boat) is holds
    monitor = LimitMonitor(ExerciseLimits(speed_over_ground_kn_max=11.4))
    assert "LIMIT: faster than 11.4 kn over the ground" in monitor.look(boat)[0].text
    boat.state.held_position = 1.0
    (condition,) = compile_conditions("speed_over_ground < 0.1", Position("my.toml", ""))
    assert is_met(condition, boat)


def test_a_debrief_has_the_speed_over_the_ground_of_each_tick(plan: Plan) -> None:
    flown = fly_rehearsal(plan).trajectory
    speed = flown.series("speed_over_ground")
    step = plan.method.step
    north, east = flown.columns["x"], flown.columns["y"]
    way = np.hypot(north[2:] - north[:-2], east[2:] - east[:-2]) / (2.0 * step)
    # the water is that of when a tick begins, and by its order changes by 4 cm/s each second
    assert speed[1:-1] == pytest.approx(way, abs=0.01)
    beyond = rows_beyond(flown, "speed_over_ground_kn_max")
    assert np.array_equal(beyond, speed > 11.0 * KNOT)
    assert beyond.any()
    assert not beyond.all()


def test_no_casualty_and_no_reference_crew_can_wait_for_what_no_gauge_shows() -> None:
    rows = {
        '[[casualties]]\nname = "rudder-slow"\nwhen = "speed_over_ground > 3"': "no quantity",
        '[[crew]]\nwhen = "speed_over_ground > 3"\norder = "bell stop"': "no gauge shows",
    }
    for row, told in rows.items():
        with pytest.raises(ConfigError, match=told):
            parse_exercise(f"{EXERCISE}\n{row}\n", Path("my.toml"))


def test_a_boat_carried_along_is_not_chased_by_the_waves() -> None:
    boat = start_boat(3.0 * KNOT, 17.5, math.pi)
    boat.put_to_sea(load_sea("sea-state-5"))
    boat.tick()
    slow = following_speed_ratio(boat)
    assert slow > 0.1
    boat.state.current[0] = -8.0 * KNOT
    take_ticks(boat, 2)
    assert boat.state.xdot < -10.0 * KNOT
    assert following_speed_ratio(boat) == pytest.approx(slow, rel=0.1)


# Taken over from


def test_who_takes_over_finds_the_current_as_it_was_ordered(plan: Plan) -> None:
    whole = fly_rehearsal(plan).trajectory
    boat, order = Boat(plan.file, plan.method), plan.schedule[0].order
    plan.start(boat)
    for tick in range(40):
        if tick == 10:
            obey_order(boat, order)
        boat.tick()
    since = Departure(40, boat.records.state.copy(), ((10, order),))
    taken = fly(plan, since, {})[0].trajectory
    for name, column in whole.columns.items():
        assert np.array_equal(column[40:], taken.columns[name]), name
    forgotten = fly(plan, replace(since, to_world=()), {})[0].trajectory
    assert not np.array_equal(forgotten.columns["x"], taken.columns["x"])


@pytest.mark.parametrize(
    ("exercise", "order", "what"),
    [
        ("[current]\nset_deg = 90\ndrift_kn = 1\n", "rudder left 5", r"\[current\]"),
        ("", "current set 090 drift 1", "current set 090 drift 1 kn"),
    ],
)
def test_a_page_refuses_a_recording_in_which_the_water_moved(
    exercise: str, order: str, what: str, tmp_path: Path
) -> None:
    own, path = tmp_path / "adrift.toml", tmp_path / "adrift.trainer"
    head = 'schema = "exercise/1"\nname = "Adrift"\nbriefing = "A current."\nduration_s = 5\n'
    own.write_text(f'{head}{exercise}[[orders]]\nat_s = 1\norder = "{order}"\n')
    with Ship(exercise=str(own), record=str(path)) as ship:
        ship.run(5)
    with pytest.raises(ConfigError, match=f"adrift.trainer: has a world around the boat, {what}"):
        boat_of(path)


def test_an_exported_boat_refuses_a_sea_that_moves(tmp_path: Path) -> None:
    sea = tmp_path / "stream.toml"
    sea.write_text("[sea]\nsea_state = 0\n[current]\nset_deg = 90\ndrift_kn = 2\n")
    with pytest.raises(ConfigError, match=r"stream.toml: \[current\]: an exported boat and a page"):
        boat_at_start(RunOptions(vessel="bb2", sea=str(sea)))
