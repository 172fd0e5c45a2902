"""Instruments between a ship and her record: a recording of the trainer has her exact state."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.files.schema import Quantity, optional, within
from trainer.identify.record import Record
from trainer.units import KNOT

DEVIATION: Final = within(0, 100)
STREAMS: Final = ("sway", "bow_sway", "stern_sway", "yaw_rate", "heading")


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Standard deviations of white errors added to an exact record; none where not said."""

    sway_kn: float | None = optional(Quantity("kn", DEVIATION, "of each log"))
    yaw_rate_deg_s: float | None = optional(Quantity("deg/s", DEVIATION, "of the rate gyro"))
    heading_deg: float | None = optional(Quantity("deg", DEVIATION, "of the compass"))
    seed: float | None = optional(Quantity("-", within(0, 1e15), "of the errors; else 1"))

    def error(self, channel: str) -> float:
        """Return the standard deviation of a channel, SI."""
        if channel == "yaw_rate":
            return math.radians(self.yaw_rate_deg_s or 0.0)
        if channel == "heading":
            return math.radians(self.heading_deg or 0.0)
        return KNOT * (self.sway_kn or 0.0)


USUAL: Final = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.02, heading_deg=0.1)


def read_by(record: Record, sensors: Sensors) -> Record:
    """Return what instruments would have read; each channel has a stream of its own."""
    columns = {}
    for place, channel in enumerate(STREAMS):
        values = getattr(record, channel)
        if values is not None:
            seed = np.random.SeedSequence((int(sensors.seed or 1), place))
            stream = np.random.Generator(np.random.PCG64(seed))
            columns[channel] = values + sensors.error(channel) * stream.standard_normal(len(values))
    return replace(record, **columns)
