"""Aground: what is called, what the exercise does, how it is judged, and its replay."""

import math
from datetime import UTC, datetime
from pathlib import Path

import pytest
from helpers.boats import start_boat, take_ticks
from helpers.crewed import Begin, Crewed
from helpers.sessions import begin_run, frame_of

from trainer.boat.ballast_orders import put_out_of_trim
from trainer.boat.boat import Boat
from trainer.boat.grounding import GroundMonitor, GroundTouch, clearance
from trainer.boat.limits import LimitMonitor
from trainer.boat.world.bottom import Ground, keel_of
from trainer.boat.world.world import World
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.files import Position
from trainer.config.world.bottom import Bottom, read_bottom
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.passage.groundings import groundings
from trainer.io.chart import DEFAULT_CHART
from trainer.session.jump import jump_to
from trainer.session.nmea.sentences import INSTRUMENTS, InstrumentSet, choose_instruments
from trainer.session.past.header import differences, plan_of
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.stations.channels import CHANNELS
from trainer.units import KNOT


def ground(**table: object) -> Bottom:
    """Return the ground of a table [bottom]."""
    return read_bottom(table, Position("x.toml", "bottom"), Path("x.toml"))


def put_on(boat: Boat, bottom: Bottom | None) -> None:
    """Put a ground under a boat, as an exercise would."""
    boat.world = World({"bottom": Ground(boat, bottom)})


def sinking(boat: Boat, above: float, rate: float, heavy: float = 20.0, **table: object) -> None:
    """Have a stopped boat sink [m/s] from so far [m] above the ground."""
    boat.start(1.0, 60.0, 0.0)
    s = boat.state
    s.by_hand[:] = s.speed_by_hand = s.trim_by_hand = 1.0
    s.u = s.u_c = s.ordered_u_c = s.theta = s.delta_s = s.delta_b = 0.0
    s.ordered[:], s.w = 0.0, rate
    assert put_out_of_trim(boat, 1000.0 * heavy, 0.0) == ""
    put_on(boat, ground(depth_m=60.0 + keel_of(boat.vessel) + above, **table))


def calls(boat: Boat, seconds: float) -> list[str]:
    """Return what is called of the ground."""
    monitor, told = GroundMonitor(boat), []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        told += [each.text for each in monitor.look()]
    return told


@pytest.fixture
def boat() -> Boat:
    return start_boat(5.0 * KNOT)


# Calls


def test_a_boat_that_sinks_onto_the_ground_is_aground_once(boat: Boat) -> None:
    sinking(boat, 2.0, 0.2)
    (told,) = calls(boat, 120.0)
    assert told.startswith("AGROUND: 0.")
    assert "into sand, way 0.0 kn, load" in told


@pytest.mark.parametrize(("seconds", "news"), [(10.0, 0), (40.0, 1)])
def test_touching_again_is_news_after_half_a_minute(boat: Boat, seconds: float, news: int) -> None:
    put_on(boat, ground(depth_m=100))
    monitor = GroundMonitor(boat)
    told: list[object] = []
    for aground in (2.0, 0.0, 2.0):
        for _ in range(round(seconds / boat.method.step)):
            boat.state.aground = aground
            boat.state.tick += 1.0
            told += monitor.look()
    assert len(told) == 1 + news


def test_a_fast_one_is_hard_aground(boat: Boat) -> None:
    sinking(boat, 2.0, 0.8)
    (told,) = calls(boat, 60.0)
    assert told.startswith("HARD AGROUND: 0.")


@pytest.mark.parametrize(
    ("touch", "kind", "hard"),
    [
        (GroundTouch(0.51, 0.0, 0.51, 0.0), "mud", True),
        (GroundTouch(0.49, 3.0, 0.49, 0.0), "sand", False),
        (GroundTouch(0.1, 2.1 * KNOT, 0.1, 0.0), "rock", True),
        (GroundTouch(0.1, 1.9 * KNOT, 0.1, 0.0), "rock", False),
    ],
)
def test_hard_is_fast_into_the_ground_or_way_over_rock(
    touch: GroundTouch, kind: str, *, hard: bool
) -> None:
    assert touch.is_hard(kind) is hard


def test_a_boat_laid_down_well_is_told_so_and_that_it_lies(boat: Boat) -> None:
    sinking(boat, 0.5, 0.05, 10.0, bottoming=True)
    told = calls(boat, 120.0)
    assert len(told) == 2
    assert told[0].endswith("well done")
    assert told[1] == "lies on the ground: 9 t on the ground, screw stopped"


def test_a_boat_laid_down_badly_or_too_light_is_told_what_was_wrong(boat: Boat) -> None:
    sinking(boat, 2.0, 0.3, 10.0, bottoming=True)
    (told,) = calls(boat, 400.0)
    assert "sinking 0." in told
    assert "0.15 at most" in told
    sinking(boat, 0.2, 0.05, 2.0, bottoming=True)
    well, light = calls(boat, 400.0)
    assert well.endswith("well done")
    assert light.startswith("does not lie on the ground within 5 min: 2 t")


def test_off_the_chart_is_called_once_each_time(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    head = "ncols 2\nnrows 2\nxllcenter -50\nyllcenter -50\ncellsize 100\n"
    path.write_text(head + "300 300 310 320")
    boat = start_boat(5.0 * KNOT)
    position = Position("x.toml", "bottom")
    put_on(boat, read_bottom({"grid": path.name, "values": "depth"}, position, tmp_path / "x.toml"))
    assert calls(boat, 60.0) == ["BEYOND THE CHART: the ground is taken as at its edge"]


def test_clearance_is_the_keel_s_and_a_limit(boat: Boat) -> None:
    assert clearance(boat) == math.inf
    put_on(boat, ground(depth_m=100))
    s = boat.state
    s.theta = s.phi = 0.0
    level = 40.0 - keel_of(boat.vessel)
    assert clearance(boat) == pytest.approx(level)
    monitor = LimitMonitor.over(boat, ExerciseLimits(clearance_m_min=level - 3.0))
    assert monitor.look(boat) == []
    s.theta = math.radians(-10.0)  # bow down
    assert clearance(boat) == pytest.approx(level - 0.45 * 70.2 * math.sin(0.17453), abs=0.2)
    (told,) = monitor.look(boat)
    assert "m of water under the keel" in told.text


# In a session


@pytest.mark.parametrize(("how", "over"), [("free", False), ("freeze", False), ("end", True)])
def test_grounding_does_what_the_exercise_says(crewed: Begin, how: str, *, over: bool) -> None:
    ship = crewed(seconds=600.0)
    sinking(ship.boat, 1.0, 0.3, grounding=how)
    ship.conduct.damage_watch.ground = GroundMonitor(ship.boat)
    ship.fly(100)
    stands = ship.boat.ticks < 100
    assert stands is (how != "free")
    assert bool(ship.conduct.ending.over) is over
    assert ship.conduct.ending.outcome == ("lost" if over else "")
    assert any("AGROUND" in line for line in ship.events(ship.instructor, "depth"))


def test_a_grounding_is_called_again_after_a_jump_to_before_it(ship: Crewed) -> None:
    sinking(ship.boat, 1.0, 0.3, grounding="free")
    ship.conduct.damage_watch.ground = GroundMonitor(ship.boat)
    moment = ship.session.history.now()
    for times in (1, 2):
        ship.fly(20)
        told = ship.events(ship.instructor, "depth")
        assert sum("AGROUND" in line for line in told) == times
        jump_to(ship.session, moment, "again")


# What is shown


def sentences(boat: Boat) -> dict[str, str]:
    """Return the sentences of depths of a boat by their beginning."""
    chosen = choose_instruments(["DBT", "DPT", "XDR"])
    lines = InstrumentSet(chosen, DEFAULT_CHART, datetime(2026, 1, 1, tzinfo=UTC)).lines(
        frame_of(boat)
    )
    return {line[1:8]: line for line in lines}


def test_with_a_ground_the_bus_has_soundings_and_the_depth_moves(boat: Boat) -> None:
    put_on(boat, None)
    deep = sentences(boat)
    assert deep["INXDR,D"].startswith("$INXDR,D,60.00,M,DEPTH*")
    assert not any(name[2:5] in ("DBT", "DPT") for name in deep)

    put_on(boat, ground(depth_m=100))
    told = sentences(boat)
    assert told["SDDBT,1"].startswith("$SDDBT,131.2,f,40.00,M,21.9,F*")
    assert told["SDDPT,4"].startswith(f"$SDDPT,40.00,{-keel_of(boat.vessel):.1f},600.0*")
    assert told["INXDR,D"].startswith("$INXDR,D,60.00,M,DEPTH*")
    assert not any(name.startswith(("INDBT", "INDPT")) for name in told)

    put_on(boat, ground(depth_m=5000))
    assert sentences(boat)["SDDBT,,"].startswith("$SDDBT,,f,,M,,F*")
    assert len(INSTRUMENTS) > len(told)


def test_crew_sees_the_sounder_and_the_instructor_the_clearance(boat: Boat) -> None:
    put_on(boat, ground(depth_m=100))
    seen = frame_of(boat)
    shown = {
        (name, field.name): field.text(seen)
        for name in ("diving", "motion")
        for field in CHANNELS[name].fields
    }
    assert shown["diving", "sounding"] == "40.0"
    assert float(shown["motion", "clearance"]) == pytest.approx(clearance(boat), abs=0.06)
    assert ("diving", "clearance") not in shown


# Judged, and flown again


DRILL = """
schema = "exercise/1"
name = "A shoal"
briefing = "Go ahead."
duration_s = 100
[initial]
speed_kn = 8
depth_m = 60
[bottom]
grid = "shoal.asc"
values = "depth"
kind = "{kind}"
[[scores]]
name = "Off the ground"
measure = "aground"
full = 0
zero = 1
part = "task"
"""


def drill(folder: Path, kind: str) -> Path:
    """Write an exercise that ends on a shoal; return its path."""
    rows = [" ".join([f"{90 - 10 * max(north, 0)}"] * 4) for north in range(8, -8, -1)]
    head = "ncols 4\nnrows 16\nxllcenter -100\nyllcenter -700\ncellsize 100\nNODATA_value -1\n"
    (folder / "shoal.asc").write_text(head + "\n".join(rows))
    path = folder / "drill.toml"
    path.write_text(DRILL.format(kind=kind))
    return path


def flown(folder: Path, kind: str) -> tuple[Plan, Rehearsal]:
    """Return the drill flown by nobody."""
    plan = plan_run(RunOptions(exercise=str(drill(folder, kind))))
    return plan, fly_rehearsal(plan)


@pytest.mark.parametrize(("kind", "hard"), [("sand", False), ("rock", True)])
def test_a_grounding_is_counted_and_a_hard_one_leaves_no_marks(
    tmp_path: Path, kind: str, *, hard: bool
) -> None:
    plan, nobody = flown(tmp_path, kind)
    (found,) = groundings(nobody.trajectory)
    assert found.hard is hard
    assert found.at_fault
    assert found.touch.way > 2.0 * KNOT
    assert plain_marks(nobody.trajectory, plan) == {"Off the ground": 0.0}
    verdict = judge_run(nobody.trajectory, plan, {}).verdict
    assert verdict is not None
    assert verdict.cap == (0.0 if hard else None)
    assert verdict.outcome == ("lost" if hard else "not reached")


def recorded(path: Path) -> tuple[Plan, Boat, dict[str, str]]:
    """Return a run of an exercise at its start, and the header of its recording."""
    return begin_run(RunOptions(exercise=str(path), given=frozenset({"exercise"})))


def test_a_recorded_run_over_a_grid_is_flown_again_to_the_bit_without_it(tmp_path: Path) -> None:
    path = drill(tmp_path, "sand")
    plan, boat, header = recorded(path)
    ends = []
    for each in (plan, plan_of(header)):
        again = Boat(each.file, each.method)
        each.start(again)
        take_ticks(again, 200)
        ends.append(again.snapshot().tobytes())
        (tmp_path / "shoal.asc").unlink(missing_ok=True)
        path.unlink(missing_ok=True)
    assert boat.state.bottom[0, 2] == 90.0
    assert ends[0] == ends[1]


def test_another_grid_than_recorded_is_told(tmp_path: Path) -> None:
    header = recorded(drill(tmp_path, "sand"))[-1]
    assert differences(header) == []
    grid = tmp_path / "shoal.asc"
    grid.write_text(grid.read_text().replace("NODATA_value -1", "NODATA_value 10"))
    assert any("shoal.asc" in each for each in differences(header))
