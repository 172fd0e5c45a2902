"""From lanes to sway velocity: program DECCON as one computation over a Decca study."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.decca import Fix, track
from trainer.identify.decca_file import DeccaFile, Readings
from trainer.identify.sway import along, derivative, even_interval, smoothed, sway_of_track
from trainer.io.whole_file import replacing
from trainer.units import KNOT

HEADS: Final = ("t", "east", "north", "psi", "r", "v", "u")


@dataclass(frozen=True)
class Sailed:
    """The track and what was read off it, SI and radians; NaN where lanes or neighbours lack."""

    source: str
    t: Numbers
    east: Numbers  # [m] of the antenna, in the grid
    north: Numbers
    heading: Numbers  # grid
    yaw_rate: Numbers
    sway: Numbers  # [m/s] through the water at the point wanted
    ahead: Numbers  # [m/s] likewise
    colours: tuple[str, ...]  # that each fix is by, "" for none

    @property
    def fixed(self) -> int:
        """Return how many rows have a fix."""
        return sum(1 for colours in self.colours if colours)


def sail(file: DeccaFile, readings: Readings, *, smooth: bool) -> Sailed:
    """Return the track and sway velocity of a study.

    ConfigError if too few rows have a fix, or times are not even.
    """
    t = np.array(readings.t)
    interval = even_interval(t, str(file.path.parent / file.heading.data))
    fixes = track(file.chain, readings.lanes, file.start)
    if sum(fix is not None for fix in fixes) < 5:
        raise ConfigError(f"{file.path.name}: fewer than 5 rows give a fix; is the start right?")
    east, north = (_coordinate(fixes, axis) for axis in (0, 1))
    heading = np.unwrap(np.array(readings.heading))
    heading -= math.radians(file.heading.convergence_deg or 0.0)
    rate = derivative(heading, interval)
    if readings.yaw_rate is not None:
        rate = np.array(readings.yaw_rate)
    scale = file.heading.grid_scale or 1.0
    course = float(heading[0])
    x0, y0 = along(east / scale, north / scale, course)
    if smooth:
        x0, y0 = smoothed(x0), smoothed(y0)
    over_ground = sway_of_track(x0, y0, heading - course, interval)
    turned = heading - course
    x_rate, y_rate = derivative(x0, interval), derivative(y0, interval)
    ahead = x_rate * np.cos(turned) + y_rate * np.sin(turned)
    current_ahead, current_aside = _current(file, heading)
    return Sailed(
        source=file.heading.name,
        t=t,
        east=east,
        north=north,
        heading=heading,
        yaw_rate=rate,
        sway=over_ground - rate * file.antenna - current_aside,
        ahead=ahead - current_ahead,
        colours=tuple("+".join(fix.colours) if fix else "" for fix in fixes),
    )


def _coordinate(fixes: list[Fix | None], axis: int) -> Numbers:
    """Return one coordinate [m] of the fixes, NaN where there is none."""
    return np.array([fix.place[axis] if fix else math.nan for fix in fixes])


def _current(file: DeccaFile, heading: Numbers) -> tuple[Numbers, Numbers]:
    """Return the current [m/s] ahead and to starboard of the ship."""
    east = KNOT * (file.heading.current_east_kn or 0.0)
    north = KNOT * (file.heading.current_north_kn or 0.0)
    s, c = np.sin(heading), np.cos(heading)
    return north * c + east * s, east * c - north * s


def write_track(sailed: Sailed, path: Path) -> None:
    """Write the track as CSV, SI and radians, a missing value empty; ConfigError if it cannot."""
    columns = (
        sailed.t,
        sailed.east,
        sailed.north,
        sailed.heading,
        sailed.yaw_rate,
        sailed.sway,
        sailed.ahead,
    )
    try:
        with replacing(path) as made, made.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(HEADS)
            for row in zip(*columns, strict=True):
                writer.writerow(["" if math.isnan(x) else repr(float(x)) for x in row])
    except OSError as error:
        raise ConfigError(f"--csv {path}: cannot be written: {error.strerror}") from error
