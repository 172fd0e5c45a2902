"""What follows from the sea in force: computed when it changes, read every tick.

All of it is a pure function of the state and the step, so that a snapshot need not hold it.
"""

from typing import Final

import numpy as np

from trainer.core.kernel import Field, Record, record_dtype
from trainer.core.state import SEA_COMPONENTS

DEGREE: Final = 9  # of the filter's denominator with the pole of the bilinear transform

SEA_FIELDS: Final[tuple[Field, ...]] = (
    # wave filter, and the frequency and step it is for
    "omega",  # [rad/s]
    "h",  # [s]
    "peak_number",  # [1/m] wave number of the peak
    ("low", ["low_a1", "low_a2"]),  # [-] section y = w ..., w = x - a1 w' - a2 w''
    ("high", ["high_a1", "high_a2"]),
    "elevation_gain",  # [-] from the low-pass section to an output of variance 1
    "quadrature_gain",
    # cosine sum, and the peakedness and seed it is for
    "gamma",  # [-]
    "seed",
    ("relative", (SEA_COMPONENTS,)),  # [-] frequency over that of the peak
    ("phase_start", (SEA_COMPONENTS,)),  # [rad]
    ("amplitude", (SEA_COMPONENTS,)),  # [-] for variance 1
    # work space of the wave forces
    "g",  # [m/s2]
    "depth",  # [m]
    "half_length",  # [m]
    ("pull", (7,)),  # [m/s2] of surge, sway, heave, pitch, yaw, and the envelope's two parts
    # work space of the variance of a filter's output
    ("a", (DEGREE + 1,)),
    ("b", (DEGREE + 1,)),
    ("d", (DEGREE + 1,)),
    "elevation_power",
    "quadrature_power",
)

SEA: Final = record_dtype(*SEA_FIELDS)


def new_sea() -> Record:
    """Return a record that fits no sea and is filled on first use."""
    return np.zeros(1, SEA)
