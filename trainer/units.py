"""Units in SI. This module imports nothing of the trainer, and every package may import it."""

from typing import Final

KNOT: Final = 1852.0 / 3600.0  # [m/s] exact: 1852 m in an hour
FOOT: Final = 0.3048  # [m] exact
DEGREE: Final = 0.017453292519943295  # [rad] pi / 180
