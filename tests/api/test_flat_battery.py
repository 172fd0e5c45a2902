"""A boat whose battery goes flat is lost by it, and whoever tells of the loss says so."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.nursery import run_trainer

import trainer
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.vehicle import LostError
from trainer.boat.assemble import Method
from trainer.boat.depths import collapse_of
from trainer.config.boat.vessel import load_vessel
from trainer.units import KNOT

CAPACITY = "capacity_kwh = 12000"
CAUSE = "after the battery went flat"
DRILL = """
schema = "exercise/1"
name = "Long"
briefing = "Keep the depth."

[[scores]]
name = "depth"
measure = "in-band"
quantity = "depth_m"
target = 60
band = 5
full = 100
zero = 0
part = "task"
"""
HOUR = 3600.0  # [s] 10 kn drain the small battery in 1.7


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """Return BB2 with an eighth of its battery."""
    text = load_vessel("bb2").text
    path = tmp_path / "small.toml"
    assert CAPACITY in text
    path.write_text(text.replace(CAPACITY, "capacity_kwh = 1500"), encoding="utf-8")
    return path


def test_a_boat_that_is_run_says_that_its_battery_went_flat(small: Path) -> None:
    boat = trainer.Boat(small, speed=10.0, depth=60.0)

    with pytest.raises(trainer.TrainerError, match=f"collapse at 450 m, {CAUSE}"):
        boat.run(3.0 * HOUR)

    called = [event["text"] for event in boat.events if event["kind"] == "plant"]
    assert [str(text).rpartition(" s): ")[2].partition(":")[0] for text in called[:2]] == [
        "BATTERY LOW",
        "BATTERY NEARLY FLAT",
    ]


def test_a_boat_with_an_endless_battery_sails_on_with_its_gauge_full(small: Path) -> None:
    boat = trainer.Boat(small, speed=10.0, depth=60.0, battery="endless")

    boat.run(3.0 * HOUR)
    boat.order("casualty cells-lost")
    boat.run(60.0)

    assert np.isfinite(list(boat.state.values())).all()
    assert abs(boat.state["z"] - 60.0) < 1.0
    assert not [event for event in boat.events if event["kind"] == "plant"]


def test_an_endless_battery_is_drained_by_nothing_and_moves_no_bit_of_the_boat() -> None:
    drained, endless = (trainer.Boat("bb2", battery=how) for how in ("drained", "endless"))
    for boat in (drained, endless):
        boat.run(300.0)

    same, other = drained.state, endless.state
    assert same.pop("battery_spent") == other.pop("battery_spent") > 0.0
    assert same == other


def test_boats_in_a_fleet_say_which_is_lost_and_why(small: Path) -> None:
    begun: Any = {"orders": ["rudder"], "reads": ["z"], "ticks": 10_800, "depth": 60.0}
    fleet = trainer.Fleet(small, 2, speed=10.0, **begun)
    endless = trainer.Fleet(small, 1, speed=10.0, battery="endless", **begun)
    assert fleet.why_lost(0) == ""

    for each in (fleet, endless):
        each.step(np.zeros((each.count, 1)))
        each.step(np.zeros((each.count, 1)))

    assert fleet.why_lost(1).endswith(CAUSE)
    assert endless.why_lost(0) == ""


def test_a_manoeuvre_says_why_its_boat_has_collapsed(small: Path) -> None:
    vehicle = Submarine(
        load_vessel(str(small)),
        Method("modified", "lagged", "exact", "adams2", 0.5),
        Rig(depth=60.0),
    )
    vehicle.start(10.0 * KNOT)
    vehicle.load(0.001)  # that the planes carry while there is way
    vehicle.keep("depth")

    rows = vehicle.sail(3.0 * HOUR, None)

    with pytest.raises(LostError, match=rf"collapse at 450 m after {rows[-1, 0]:g} s, {CAUSE}"):
        vehicle.sound()
    assert collapse_of(vehicle.boat)


@pytest.mark.process
def test_a_run_without_a_console_and_its_debrief_name_the_battery(
    small: Path, tmp_path: Path
) -> None:
    alone = ("run", "--headless", "--speed", "max", "--vessel", str(small))
    lasting = ("--duration", "3h", "--step", "1")
    page, drill = tmp_path / "lost.html", tmp_path / "drill.toml"
    drill.write_text(DRILL, encoding="utf-8")

    lost = run_trainer("run", str(drill), *alone[1:], *lasting, "--debrief", str(page))
    kept = ("--record", str(tmp_path / "on.trainer"))
    sailed = run_trainer(*alone, *lasting, "--battery", "endless", *kept, cwd=tmp_path)
    again = run_trainer("replay", "on.trainer", cwd=tmp_path)
    told = run_trainer("debrief", "on.trainer", "--html", "on.html", cwd=tmp_path)

    assert lost.returncode == 1
    assert f"collapse at 450 m, {CAUSE}" in lost.stderr
    assert f"hull collapsed at 450 m, {CAUSE}" in page.read_text(encoding="utf-8")
    assert sailed.returncode == again.returncode == told.returncode == 0, told.stderr
    assert "the same to the last bit" in again.stdout
    assert "endless: not drained" in (tmp_path / "on.html").read_text(encoding="utf-8")


def test_a_boat_by_numbers_stops_where_her_hull_collapses_and_goes_on_from_before() -> None:
    boat = trainer.Boat("bb2", depth=300)
    before = boat.snapshot()
    by_number = boat.by_number(["stern", "bow", "turns"], ["z"], ticks=50)
    dive = [-0.2, -0.2, 5.0]

    def go_down() -> None:
        for _ in range(30):
            by_number.step(dive)

    with pytest.raises(trainer.TrainerError, match=r"lost at .* s: collapse at 4.. m"):
        go_down()
    assert "collapse at" in boat.lost
    there = boat.state
    with pytest.raises(trainer.TrainerError, match="cannot go on: collapse"):
        by_number.step(dive)
    assert boat.state == there

    boat.restore(before)
    assert by_number.step(dive)[0] < 450.0
    assert boat.lost == ""
