"""What the machine code of 1969 did, put together from the core's kernels: for counting its words.

The program UPDATE of 1969 was one cycle of the modified set: forces, accelerations, attitude,
integration. The whole tick had autopilot, control surfaces, propulsion, tanks and the sea's noise
besides. Neither had casualties, orders by hand, air, pumps, holds or the surface.
"""

from typing import Any

from numba import carray  # type: ignore[attr-defined]

from trainer.core.actuators import moved
from trainer.core.autopilot import (
    BOW,
    PLANE_GAINS,
    RUDDER,
    RUDDER_GAINS,
    STERN,
    course_law,
    depth_error,
    drive,
    plane_law,
    scheduled_gains,
    steer,
)
from trainer.core.ballast import balance
from trainer.core.compact import forces, lagged
from trainer.core.integrators import adams
from trainer.core.kinematics import kinematics
from trainer.core.noise import SEA_FILTER, gaussian
from trainer.core.reference import COURSE, DEPTH, move_reference
from trainer.core.wave_filter import filter_noise


def update_of_1969(vessel: Any, compact: Any, scheme: Any, state: Any, scratch: Any) -> int:  # noqa: ARG001 as all
    """Advance the motion at these addresses by one cycle, controls held; return 0."""
    few, how, now, work = (
        carray(compact, 1),
        carray(scheme, 1),
        carray(state, 1),
        carray(scratch, 1),
    )
    forces(few, how[0].trig, now, work[0].force)
    lagged(few, work[0].force, now)
    kinematics(how[0].trig, now)
    adams(how, now)
    return 0


def tick_of_1969(vessel: Any, compact: Any, scheme: Any, state: Any, scratch: Any) -> int:
    """Advance boat, autopilot, surfaces, propeller, tanks and noise by one cycle; return 0."""
    boat, few, how = carray(vessel, 1), carray(compact, 1), carray(scheme, 1)
    now, work = carray(state, 1), carray(scratch, 1)
    c, s, gains, h = boat[0], now[0], work[0].gains, how[0].h
    filter_noise(work, gaussian(int(s.seed), SEA_FILTER, int(s.tick)), now)
    scheduled_gains(boat, s.u, gains)
    for axis in range(COURSE + 1):
        here = s.z if axis == DEPTH else s.psi
        move_reference(axis, here, h, gains, now)
    for surface in range(BOW + 1):
        if surface == RUDDER:
            law = course_law(now, gains)
            step = h * gains[RUDDER_GAINS + 3] * (s.psi_reference - s.psi)
        else:
            first = PLANE_GAINS * (surface - STERN)
            law = plane_law(now, gains, first)
            step = h * gains[first + 4] * depth_error(gains, now)
        steer(boat, now, surface, law, step)
    drive(boat, h, now)
    balance(boat, boat, now)
    forces(few, how[0].trig, now, work[0].force)
    lagged(few, work[0].force, now)
    kinematics(how[0].trig, now)
    adams(how, now)
    for i in range(3):
        s.surface[i] = moved(s.surface[i], s.command[i], c.limit[i], c.surface_rate * h, 1.0)
    s.u_c += h / c.propulsion_lag * (s.command_u_c - s.u_c)
    s.tick += 1.0
    return 0
