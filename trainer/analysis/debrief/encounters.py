"""The ships that a run met: how near each came, and collisions."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.analysis.debrief.trajectory import Trajectory
from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.hulls import OwnHull, Pose
from trainer.core.kernel import Numbers

POSE: Final = ("x", "y", "z", "phi", "theta", "psi")


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
