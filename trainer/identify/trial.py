"""A boat flown under timed orders in a calm, without ports or clock, as a record."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from trainer.boat import Boat
from trainer.config import ConfigError
from trainer.files.vessel_file import VesselFile
from trainer.helm import obey
from trainer.identify.experiment import method_of
from trainer.identify.record import Record
from trainer.io.schedule import Scheduled
from trainer.reply import Refused
from trainer.units import KNOT

NAMES: Final = ("t", "delta_r", "psi", "r", "v", "u")


def flown(
    file: VesselFile, schedule: Iterable[Scheduled], speed: float, depth: float, seconds: float
) -> Record:
    """Return the record of a boat that begins at ``speed`` [m/s] and ``depth`` [m].

    ConfigError if it cannot, refuses an order, or its numbers are lost.
    """
    step = file.run.step_s
    boat = Boat(file, method_of(file))
    boat.start(speed, depth, 0.0)
    waiting = list(schedule)
    rows = []
    for _ in range(round(seconds / step) + 1):
        while waiting and waiting[0].seconds <= boat.time + 1e-9:
            _give(boat, waiting.pop(0))
        rows.append(boat.numbers(NAMES))
        status = boat.tick()
        if status:
            raise ConfigError(f"{file.path.name}: {boat.failure(status)}")
    table = np.array(rows).T
    return Record(
        source=f"{file.name} at {speed / KNOT:g} kn",
        t=table[0],
        rudder=table[1],
        heading=table[2],
        yaw_rate=table[3],
        sway=table[4],
        speed=table[5],
        rows=np.arange(len(rows)),
        names={},
    )


def _give(boat: Boat, entry: Scheduled) -> None:
    """Give an order; ConfigError with the boat's own words if it is refused."""
    answer = obey(boat, entry.order)
    if isinstance(answer, Refused):
        raise ConfigError(f"{entry.seconds:g} s: {entry.order.text}: {answer.reason}")
