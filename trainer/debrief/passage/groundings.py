"""The groundings of a passage: when, how hard, and whether they were meant.

A passage is what was flown to the end of a branch of a recording (``trajectory``). ``measures``,
``gates`` and ``judgement`` ask here, because in some exercises a boat shall lie on the ground: then
only a hard or crooked landing is a fault.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from trainer.boat.grounding import (
    AGROUND_TICKS,
    RECALL_AFLOAT_S,
    SETTLING_TIME_S,
    GroundTouch,
    lies_well,
    touch_of,
)
from trainer.boat.world.bottom import ground_under
from trainer.config.world.bottom import Bottom
from trainer.debrief.passage.trajectory import (
    Trajectory,
)


class Grounding(NamedTuple):
    """One touch of the ground, until the boat is afloat for a while."""

    row: int  # at which it was aground
    touch: GroundTouch
    hard: bool
    at_fault: bool  # whether the boat was not meant to touch, or touched badly


def groundings(trajectory: Trajectory) -> list[Grounding]:
    """Return the groundings of a passage. A second touch soon after counts as the same one."""
    bottom = ground_under(trajectory.boat)
    if bottom is None:
        return []
    return [_grounding(trajectory, bottom, row) for row in _rows(trajectory)]


def _rows(trajectory: Trajectory) -> Iterator[int]:
    """Yield the rows at which the boat is aground, having been off the ground for a while."""
    ticks, seconds = trajectory.columns["aground"], trajectory.seconds
    last = -np.inf
    for row in np.flatnonzero(ticks >= AGROUND_TICKS):
        if row and seconds[row] - last > RECALL_AFLOAT_S:
            yield int(row)
        last = seconds[row]


def _grounding(trajectory: Trajectory, bottom: Bottom, row: int) -> Grounding:
    columns = trajectory.columns
    before = max(row - int(columns["aground"][row]), 0)
    touch = touch_of(lambda name: float(columns[name][before]), float(trajectory.boat.vessel.ell))
    hard = touch.is_hard(bottom.kind)
    well = bottom.bottoming and not hard and not touch.faults and _lies(trajectory, row)
    return Grounding(row, touch, hard, not well)


def _lies(trajectory: Trajectory, row: int) -> bool:
    """Return whether a boat comes to lie as it should, in time."""
    soon = np.flatnonzero(trajectory.seconds <= trajectory.seconds[row] + SETTLING_TIME_S)
    tonnes = trajectory.columns["bottom_load"] / float(trajectory.boat.vessel.g) / 1000.0
    screw = trajectory.columns["u_c"]
    return any(lies_well(float(tonnes[i]), float(screw[i])) for i in soon if i >= row)
