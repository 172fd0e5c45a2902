"""Rates that are told are those of the tick that is told, not of the tick before."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from helpers.boats import start_boat, take_ticks
from helpers.orders import obey_all
from helpers.sessions import frame_of

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.flown_ticks import FlownTicks
from trainer.boat.grounding import touch_of
from trainer.boat.limits import LIMIT_READERS
from trainer.boat.quantities import quantity_of
from trainer.boat.readings import read_rates
from trainer.boat.world.approach import OwnMotion
from trainer.core.rates import rates
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.rerun import charts
from trainer.session.rerun.batch import Block, Times
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.status import status_lines
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

TICKS: Final = 60
DEGREE: Final = math.radians(1.0)
Teller = Callable[[Boat], Any]

EXERCISE = """
schema = "exercise/1"
name = "Adrift"
briefing = "A turn in a current."
duration_s = 40

[current]
set_deg = 30
drift_kn = 2

[[orders]]
at_s = 2
order = "rudder right 20"
"""


def numbers(boat: Boat) -> Callable[[str], float]:
    """Return a reader of the numbers of a boat's state, over level ground."""
    return lambda name: 0.0 if name.startswith("bottom") else boat.plain[STATE_OFFSETS[name]]


def of_channel(channel: str, field: str, unit: float = 1.0) -> Teller:
    """Return who tells a field of a channel, before it is rounded, in a unit of that size [SI]."""
    (found,) = (each for each in CHANNELS[channel].fields if each.name == field)
    return lambda boat: float(found.read(frame_of(boat)) or 0.0) * unit


def of_status(first: str, unit: float) -> Teller:
    """Return who tells the rate in a line of the order ``status``."""

    def told(boat: Boat) -> float:
        lines = status_lines(boat, Ledger(boat.method.step).summary())
        (line,) = (each for each in lines if each.startswith(first))
        return float(line.partition("rate ")[2].split()[0]) * unit

    return told


def block(boat: Boat) -> Block:
    """Return the present tick as Rerun takes it."""
    whole = boat.records.state.view(np.float64)[None].copy()
    one = np.ones(1, np.int64)
    return Block(Times(one, np.zeros(1)), whole, one, np.zeros(1, np.bool_))


def flown(boat: Boat) -> FlownTicks:
    """Return the present tick as those flown at once."""
    return FlownTicks(boat.records.state.view(np.float64)[None].copy(), boat.method.step)


def limited(read: Callable[[str], Any]) -> Any:
    """Return the speed over the ground that a limit bounds [m/s]."""
    return LIMIT_READERS["speed_over_ground_kn"](read) * KNOT


# who tells, what changes in the state, and how far the rate may be off [SI]
TELLERS: Final[dict[str, tuple[Teller, str, float]]] = {
    "motion turn_rate": (of_channel("motion", "turn_rate", DEGREE), "psi", 1e-4),
    "motion pitch_rate": (of_channel("motion", "pitch_rate", DEGREE), "theta", 1e-4),
    "motion heel_rate": (of_channel("motion", "heel_rate", DEGREE), "phi", 5e-5),
    "motion depth_rate": (of_channel("motion", "depth_rate"), "z", 0.001),
    "motion north_rate": (of_channel("motion", "north_rate"), "x", 0.002),
    "motion east_rate": (of_channel("motion", "east_rate"), "y", 0.002),
    "status depth": (of_status("depth", 1.0), "z", 0.006),  # it has two decimals
    "status heading": (of_status("heading", DEGREE), "psi", 2e-4),
    "contacts": (lambda boat: OwnMotion.of(boat.state).turning, "psi", 1e-4),
    "ground": (lambda boat: touch_of(numbers(boat), 67.0).sink, "z", 0.001),
    **{
        f"{name} over the ground": (teller, "speed", 0.002)
        for name, teller in {
            "current": of_channel("current", "speed_over_ground", KNOT),
            "limit": lambda boat: limited(numbers(boat)),
            "limit of many ticks": lambda boat: limited(flown(boat).__getitem__)[0],
            "condition": lambda boat: quantity_of(boat, "speed_over_ground"),
            "contacts": lambda boat: OwnMotion.of(boat.state).speed,
            "contacts of a frame": lambda boat: OwnMotion.of(frame_of(boat)).speed,
            "ground": lambda boat: touch_of(numbers(boat), 67.0).way,
            "Rerun": lambda boat: charts.BlockReadings(boat).read(block(boat), "way")[0],
        }.items()
    },
}


def places(boat: Boat) -> dict[str, float]:
    """Return attitude and location of a boat [SI]."""
    return {name: float(boat.state[name]) for name in ("phi", "theta", "psi", "x", "y", "z")}


def changing(boat: Boat) -> tuple[dict[str, float], dict[str, float]]:
    """Return the rates by which attitude and location change about a tick, and those in its state.

    The boat is one tick on then.
    """
    before, step = places(boat), boat.method.step
    boat.tick()
    late = {name: float(boat.state[f"{name}dot"]) for name in before}
    here = boat.snapshot()
    boat.tick()
    after = places(boat)
    boat.restore(here)
    true = {name: (after[name] - before[name]) / (2.0 * step) for name in before}
    for found in (true, late):
        found["speed"] = math.hypot(found["x"], found["y"])
    return true, late


@pytest.mark.parametrize("who", TELLERS)
def test_a_rate_told_is_the_change_about_the_tick_not_before_it(who: str) -> None:
    teller, what, bound = TELLERS[who]
    boat = start_boat(10.0 * KNOT, 60.0, 2.0, rates="exact")
    boat.state.current[:] = 0.4, 1.0, 0.01, 0.0
    obey_all(boat, "rudder right 20", "stern dive 15")
    off, late_off = [], []
    for _ in range(TICKS):
        true, late = changing(boat)
        off.append(abs(teller(boat) - true[what]))
        late_off.append(abs(late[what] - true[what]))

    assert max(off[3:]) < bound  # the change of an order itself is of no order
    assert max(late_off[3:]) > 2.0 * bound


def test_a_debrief_tells_the_speed_over_the_ground_of_each_tick(tmp_path: Path) -> None:
    path = tmp_path / "adrift.toml"
    path.write_text(EXERCISE)
    plan = plan_run(RunOptions(exercise=str(path), rates="exact"))
    trajectory = fly_rehearsal(plan).trajectory
    x, y = trajectory.columns["x"], trajectory.columns["y"]
    true = np.hypot(x[2:] - x[:-2], y[2:] - y[:-2]) / (2.0 * plan.method.step)
    told = trajectory.series("speed_over_ground")

    assert np.abs(told[1:-1] - true).max() < 0.002
    assert np.abs(told[:-2] - true).max() > 0.004  # that of the tick before


def test_rates_of_what_is_held_are_zero_and_the_others_are_not() -> None:
    boat = start_boat(10.0 * KNOT, 60.0, 2.0)
    obey_all(boat, "rudder right 20", "stern dive 15")
    take_ticks(boat, 20)
    boat.state.held_position = 1.0
    told = read_rates(numbers(boat))
    assert (told.north, told.east, told.way) == (0.0, 0.0, 0.0)
    assert abs(told.down) > 0.005
    boat.state.held_position, boat.state.held_depth = 0.0, 1.0
    told = read_rates(numbers(boat))
    assert told.down == 0.0
    assert told.way > 1.0


@pytest.mark.parametrize("pitch", [math.radians(89.9), math.radians(90.1)])
def test_near_the_vertical_the_turn_is_that_of_the_core(pitch: float) -> None:
    boat = start_boat(10.0 * KNOT, 60.0, 2.0)
    s = boat.state
    s.theta, s.phi, s.p, s.q, s.r = pitch, 0.2, 0.01, 0.02, 0.03
    told = read_rates(numbers(boat))
    records = boat.records
    rates(*(getattr(records, name) for name in ("vessel", "compact", "scheme", "state", "scratch")))

    assert told.heading == pytest.approx(s.psidot, rel=1e-12)
    assert told.heel == pytest.approx(s.phidot, rel=1e-12)
    assert abs(told.heading) > 1.0
