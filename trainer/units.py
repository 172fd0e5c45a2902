"""Units in SI. This module imports nothing of the trainer, and every package may import it."""

KNOT = 1852.0 / 3600.0  # [m/s] exact: 1852 m in an hour
FOOT = 0.3048  # [m] exact
DEGREE = 0.017453292519943295  # [rad] pi / 180
