"""What is read off many states of a boat, and rates of the tick told.

``core/readings`` has all that is read off one state; ``read_states`` does it for many that are
whole. Where only some numbers of the ticks of a flight were kept, ``read_rates`` and
``is_depth_kept`` compute what is needed of them, in columns; a test holds them to the core's.

The rates in a state are those with which its last tick began, so whoever tells them is a tick late.
Here they follow from the motion as it stands, [ASSES] (7), and from the water as the last tick had
it, which changes within minutes.

Some read the rates of the tick before, and mean to: conditions on ``depth_rate``, which the core's
triggers and a debrief must find at the same tick; helm, crew and a kiosk's guard, whose orders
would else not be those of recordings made before; swell and the caution about a following sea,
which show no digit of it; and accelerations, because their forces are those of a tick.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from trainer.boat.boat import Boat
from trainer.core.kernel import Numbers
from trainer.core.kinematics import MIN_PITCH_COSINE
from trainer.core.readings import READINGS, new_readings, write_readings
from trainer.core.state import new_scratch, new_state

READING_OFFSETS = {
    name: offset // 8
    for name, (kind, offset, *_) in (READINGS.fields or {}).items()
    if not kind.shape
}
# a number of one state [SI] by its name, or those of many as an array
NumberReader = Callable[[str], Any]
MOTION_NAMES = ("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z")
WATER_NAMES = ("water_north", "water_east", "shear_north", "shear_east")


class MotionRates(NamedTuple):
    """Rates of heel, pitch and heading [rad/s], and of the location over the ground [m/s].

    What is held stands still: a held boat sails on unseen, which nobody is to be told.
    """

    heel: Any
    pitch: Any
    heading: Any
    north: Any
    east: Any
    down: Any

    @property
    def way(self) -> Any:
        """Return the speed [m/s] over the ground."""
        return np.hypot(self.north, self.east)


def read_rates(read: NumberReader) -> MotionRates:
    """Return the rates of one state, or of many."""
    u, v, w, p, q, r, phi, theta, psi, z = map(read, MOTION_NAMES)
    water_north, water_east, shear_north, shear_east = map(read, WATER_NAMES)
    sin_phi, cos_phi, sin_th, cos_th = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
    sin_psi, cos_psi = np.sin(psi), np.cos(psi)
    level = np.copysign(np.maximum(np.abs(cos_th), MIN_PITCH_COSINE), cos_th)
    turn = (q * sin_phi + r * cos_phi) / level
    across, downward = v * cos_phi - w * sin_phi, v * sin_phi + w * cos_phi
    along = u * cos_th + downward * sin_th
    moves, sinks = read("held_position") == 0.0, read("held_depth") == 0.0
    return MotionRates(
        heel=p + turn * sin_th,
        pitch=q * cos_phi - r * sin_phi,
        heading=turn,
        north=(along * cos_psi - across * sin_psi + water_north + shear_north * z) * moves,
        east=(along * sin_psi + across * cos_psi + water_east + shear_east * z) * moves,
        down=(downward * cos_th - u * sin_th) * sinks,
    )


def is_depth_kept(read: NumberReader) -> Any:
    """Return whether the ordered depth is kept, by a pair of planes or hovering."""
    in_hand = (read("stern_by_hand") != 0.0) & (read("bow_by_hand") != 0.0)
    return ~in_hand | (read("hover") != 0.0)


def read_states(boat: Boat, states: Numbers) -> Numbers:
    """Return the readings [n, READINGS] of many states [n, STATE] of a boat."""
    vessel, state, scratch, readings = (
        boat.records.vessel,
        new_state(),
        new_scratch(),
        new_readings(),
    )
    out = np.empty((len(states), READINGS.itemsize // 8))
    for row, numbers in zip(out, states, strict=True):
        state["whole"][0] = numbers
        write_readings(vessel, state, scratch, readings)
        row[:] = readings["whole"][0]
    return out
