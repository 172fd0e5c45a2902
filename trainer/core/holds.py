"""Partial freezes: depth or position stands still while all else goes on.

Tanks that are held are not advanced at all, see update. Position is nobody's input: a boat held in
place sails on unseen, so that every number but the place is that of a run without the hold, and
once released she goes on from where she was held. Depth is an input to nearly everything: it is
put back after every step, and what the boat feels is the depth held.
"""

from typing import Final

from trainer.core.kernel import Record, part
from trainer.core.state import HISTORY, MOTION

X: Final = MOTION.index("x")  # y follows
Z: Final = MOTION.index("z")


@part
def cast_off(state: Record) -> None:
    """Before a step: put a boat held in place to where it would be.

    One that is elsewhere without being held, as after a release, takes its past along.
    """
    s = state[0]
    for i in range(2):
        jump = s.motion[X + i] - s.sailed[i]
        if s.held_position != 0.0:
            s.motion[X + i] = s.sailed[i]
        elif jump != 0.0:
            for back in range(HISTORY):
                s.past_motion[back, X + i] += jump


@part
def make_fast(x: float, y: float, z: float, state: Record) -> None:
    """After a step: put what is held back to where it was before it [m]."""
    s = state[0]
    s.sailed_x, s.sailed_y = s.x, s.y
    if s.held_position != 0.0:
        s.x, s.y = x, y
    if s.held_depth != 0.0:
        descent = s.z - z
        s.z = z
        for back in range(HISTORY):
            s.past_motion[back, Z] -= descent
