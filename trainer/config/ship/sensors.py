"""The errors of the instruments that read an exact record: the table [sensors].

Identification studies and ship files have it, because a recording of the trainer has no errors.
"""

import math
from dataclasses import dataclass
from typing import Final

from trainer.config.schema import optional, within
from trainer.units import KNOT

DEVIATION_LIMITS: Final = within(0, 100)


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Standard deviations of white errors added to an exact record; none where not said."""

    sway_kn: float | None = optional("kn", DEVIATION_LIMITS, "of each log")
    yaw_rate_deg_s: float | None = optional("deg/s", DEVIATION_LIMITS, "of the rate gyro")
    heading_deg: float | None = optional("deg", DEVIATION_LIMITS, "of the compass")
    seed: float | None = optional("-", within(0, 1e15), "of the errors; else 1")

    def error(self, channel: str) -> float:
        """Return the standard deviation of a channel, SI."""
        if channel == "yaw_rate":
            return math.radians(self.yaw_rate_deg_s or 0.0)
        if channel == "heading":
            return math.radians(self.heading_deg or 0.0)
        return KNOT * (self.sway_kn or 0.0)
