"""The work space of one boat's kernels; nothing in it is read from one tick to the next.

What the sea's part keeps is a pure function of the state, made again whenever it does not fit.
"""

from typing import Final

import numpy as np

from trainer.core.kernel import Record, record_dtype
from trainer.core.sea import SEA_FIELDS
from trainer.core.state import STATE

SCRATCH: Final = record_dtype(
    ("external", (6,)),  # forces [N] and moments [N m] of this tick from sea and surface
    ("force", (6,)),  # right sides of the six equations, less the accelerations
    ("inertia", (6, 6)),  # their coefficients on the left
    ("system", (6, 7)),  # work space of the linear solve
    ("jacobian", (7, 8)),  # of the trim, and its Newton step
    ("change", (7,)),
    ("start", (12,)),  # motion at the start of a Runge-Kutta step, and its weighted slopes
    ("slope", (12,)),
    ("origin", (12,)),  # motion and rates at the start of a variable step, to try it again from
    ("origin_rates", (12,)),
    ("coarse", (12,)),  # the variable step taken whole
    ("gains", (20,)),  # autopilot gains at the present speed
    ("reading", (3,)),  # of depth gauge [m], gyro [rad], log [m/s]
    *SEA_FIELDS,
    ("before", (STATE.itemsize // 8,)),  # the state before the tick
)


def new_scratch() -> Record:
    """Return a work space of zeros."""
    return np.zeros(1, SCRATCH)
