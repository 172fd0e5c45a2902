"""The ships that a run met: how near each came, and collisions."""

import math
import re
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.analysis.debrief.trajectory import Rows, Trajectory, eye_heights
from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.hulls import OwnHull, Pose
from trainer.boat.world.scope import Mast, Periscope, periscope_of
from trainer.core.kernel import Numbers

POSE: Final = ("x", "y", "z", "phi", "theta", "psi")
MARKED: Final = re.compile(r"contact\b.*?(\d{1,3}(?:\.\d+)?)\s*", re.IGNORECASE)
AIMED: Final = math.radians(3.0)  # [rad] between a mark's bearing and the ship's


@dataclass(frozen=True)
class Met:
    """Every ship's closest approach, and the nearest ship's range at each tick."""

    nearest: Numbers  # [m] in the step to each tick, infinity without ships
    closest: dict[str, tuple[float, int]] = field(default_factory=dict)  # [m] and tick, by name
    collisions: tuple[tuple[int, str], ...] = ()  # ticks and names
    collision: str = "call"  # what the exercise has one do


def meet(trajectory: Trajectory) -> Met:
    """Return the ships that were met on a passage."""
    contacts = contacts_in(trajectory.boat)
    nearest = np.full(trajectory.ticks.size, np.inf)
    if contacts is None or not contacts.any:
        return Met(nearest)
    monitor = EncounterMonitor(contacts, OwnHull.of(trajectory.boat))
    rows = zip(*(trajectory.columns[name].tolist() for name in POSE), strict=True)
    poses = [Pose(*row) for row in rows]
    collisions = []
    for row in range(1, len(poses)):
        tick = int(trajectory.ticks[row])
        monitor.step(contacts, tick, poses[row - 1], poses[row])
        nearest[row] = monitor.nearest[1]
        if monitor.struck:
            collisions.append((tick, monitor.struck))
    return Met(nearest, monitor.closest, tuple(collisions), contacts.encounters.collision)


@dataclass(frozen=True)
class Detection:
    """A ship that came in sight, and when it was marked, if ever."""

    name: str
    seen: int  # tick
    marked: int | None


def masts(trajectory: Trajectory, scope: Periscope) -> list[Mast]:
    """Return how the mast stood at each tick."""
    return [scope.at(tick) for tick in trajectory.ticks.tolist()]


def shown(trajectory: Trajectory) -> tuple[Rows, Numbers]:
    """Return at which ticks the head was out of the water, and at which raise."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return np.zeros(trajectory.ticks.size, bool), np.zeros(trajectory.ticks.size)
    stood = masts(trajectory, scope)
    out = np.array([mast.out > 0.0 for mast in stood])
    return out & (eye_heights(trajectory) > 0.0), np.array([float(mast.raised) for mast in stood])


def detections(trajectory: Trajectory) -> list[Detection]:
    """Return the ships that came in sight, in that order, each with its mark."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return []
    first: dict[str, int] = {}
    heights, rows = eye_heights(trajectory), shown(trajectory)[0]
    for row in np.flatnonzero(rows).tolist():
        tick = int(trajectory.ticks[row])
        eye = scope.place(state_of(trajectory, row), scope.at(tick), float(heights[row]))
        for sight in scope.sights(eye, scope.at(tick)):
            first.setdefault(sight.name, tick)
    marks = marked(trajectory, scope)
    return [
        Detection(name, seen, next((t for t, names in marks if t >= seen and name in names), None))
        for name, seen in first.items()
    ]


def state_of(trajectory: Trajectory, row: int) -> dict[str, float]:
    """Return place and attitude at a row, by their names in the core."""
    return {name: float(trajectory.columns[name][row]) for name in ("x", "y", "psi", "theta")}


def marked(trajectory: Trajectory, scope: Periscope) -> list[tuple[int, list[str]]]:
    """Return the tick of each mark, and the ships that it may mean."""
    found = []
    for mark in trajectory.marks:
        said = MARKED.match(mark.text)
        if said:
            bearing = math.radians(float(said[1]))
            state = state_of(trajectory, trajectory.row(mark.tick))
            near = scope.near(state, mark.tick)
            names = [
                n for n, true in near if abs(math.remainder(true - bearing, math.tau)) <= AIMED
            ]
            found.append((mark.tick, names))
    return found
