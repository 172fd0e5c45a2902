"""Steering of a boat by its vessel file, in Model 1's terms. Such a file is rewritten too.

The rudder of a vessel file and that of the models have one sign: positive turns to port. Roll is
left out of the models: what it does to sway and yaw is small.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.characteristic import HORIZONTAL, Means, dimensional, horizontal
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.core.kernel import Numbers
from trainer.identify.measurements import Record
from trainer.identify.nomoto import Levers, Nomoto, levers, nomoto, solve_motion, transfer

STEERED: Final = ("v", "r")
NUMBER: Final = r"[-+]?(?:\d[\d_]*)?\.?\d+(?:[eE][-+]?\d+)?"


@dataclass(frozen=True)
class Steering:
    """M d(v, r)/dt = F (v, r) + g delta at a speed [m/s], SI."""

    M: Numbers
    F: Numbers
    g: Numbers
    speed: float
    length: float
    density: float

    @property
    def nomoto(self) -> Nomoto:
        """Return gains and time constants, SI."""
        return nomoto(transfer(*solve_motion(self.M, self.F, self.g)))

    @property
    def levers(self) -> Levers:
        """Return the lever arms and the margin of stability [m]."""
        return levers(self.F, self.g)

    @property
    def prime(self) -> dict[str, float]:
        """Return Model 1's twelve parameters but the wind's, prime system."""
        mass = 0.5 * self.density * self.length**3
        L, V = self.length, self.speed
        Y, N = self.g / (mass * V**2 / np.array([L, 1.0]))
        return {
            "m11": self.M[0, 0] / mass,
            "m12": self.M[0, 1] / (mass * L),
            "m21": self.M[1, 0] / (mass * L),
            "m22": self.M[1, 1] / (mass * L**2),
            "Y_v": self.F[0, 0] * L / (mass * V),
            "Y_r": self.F[0, 1] / (mass * V),
            "N_v": self.F[1, 0] / (mass * V),
            "N_r": self.F[1, 1] / (mass * V * L),
            "Y_delta": float(Y),
            "l_delta": float(-N / Y),
        }


def steering(file: VesselFile, speed: float, means: Means = Means()) -> Steering:  # noqa: B008
    """Return the steering of a boat at ``speed`` [m/s], ``means`` averaged in. Roll is left out."""
    linear = horizontal(file, speed, means)
    places = [HORIZONTAL.index(name) for name in STEERED]
    pick = np.ix_(places, places)
    c = dimensional(file)
    g = speed**2 * np.array([c.Y_dr, c.N_dr])
    length, density = file.hull.length, file.fluid.rho
    return Steering(linear.E[pick], linear.F[pick], g, speed, length, density)


def averages(record: Record) -> Means:
    """Return the mean |v| [m/s] and |r| [rad/s] for a record's quadratic terms.

    E|x|^3/E x^2, by which a |x| x is in the mean square nearest to a line.
    """
    sizes = []
    for values in (record.sway, record.yaw_rate):
        known = np.abs(values[~np.isnan(values)]) if values is not None else np.zeros(1)
        power = float(np.mean(known**2))
        sizes.append(float(np.mean(known**3)) / power if power > 0.0 else 0.0)
    return Means(v=sizes[0], r=sizes[1])


def coefficients(
    file: VesselFile, found: dict[str, float], speed: float, means: Means
) -> dict[str, float]:
    """Return the vessel file's coefficients [-] for Model 1's in prime units.

    What the file's own quadratic terms contributed at the record's ``means`` is taken off, since
    they stay in the file.
    """
    c, hull = file.coefficients, file.hull
    mass = hull.mass / (0.5 * file.fluid.rho * hull.length**3)
    v, r = means.v / speed, means.r * hull.length / speed
    x_g = hull.cg[0] / hull.length
    return {
        "Y_v": found["Y_v"] - c["Y_vav"] * v - c["Y_var"] * r,
        "Y_r": found["Y_r"] + mass,
        "N_v": found["N_v"] - c["N_vav"] * v,
        "N_r": found["N_r"] + mass * x_g - c["N_avr"] * v - c["N_rar"] * r,
        "Y_dr": found["Y_delta"],
        "N_dr": -found["Y_delta"] * found["l_delta"],
    }


def rewritten(text: str, values: dict[str, float], remark: str) -> str:
    """Return the text of a vessel file with these coefficients, and a remark on each.

    ConfigError if the file does not give one on a line of its own.
    """
    for key, value in values.items():
        line = re.compile(rf"(\s*{re.escape(key)}\s*=\s*){NUMBER}.*")
        rows = text.split("\n")
        for i in _coefficient_rows(rows):
            if found := line.fullmatch(rows[i]):
                rows[i] = f"{found[1]}{value:.6g}  # {remark}"
                break
        else:
            told = f"the vessel file has no line {key} = ...: add one, such as {key} = 0"
            raise ConfigError(told)
        text = "\n".join(rows)
    return text


def _coefficient_rows(rows: Sequence[str]) -> Iterator[int]:
    """Yield the places of the lines inside the tables of coefficients."""
    inside = False
    for i, row in enumerate(rows):
        if row.lstrip().startswith("["):
            inside = row.lstrip().startswith("[coefficients")
        elif inside:
            yield i


def limits(file: VesselFile) -> tuple[float, float]:
    """Return limit [rad] and rate [rad/s] of the rudder."""
    surfaces = file.surfaces
    return math.radians(surfaces.rudder_limit_deg), math.radians(surfaces.rate_deg_s)
