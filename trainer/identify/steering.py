"""Steering of a boat by its vessel file, in Model 1's terms. Such a file is rewritten too.

The rudder of a vessel file and that of the models have one sign: positive turns to port. Roll is
left out of the models: what it does to sway and yaw is small.

A ship in a few numbers as a vehicle for manoeuvres: a Nomoto file under helm.

Section 12.3, without differentiating the rudder: r' = (z - (T1 + T2) r + K T3 delta)/(T1 T2),
z' = K delta - K H(r), by kappa K H(r) = r - kappa K |r| r. The sway filter has the same
denominator. Speed does not change.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.analysis.characteristic import HORIZONTAL, Means, dimensional, horizontal
from trainer.analysis.manoeuvres.vehicle import Control, LostError
from trainer.config.files import ConfigError
from trainer.config.nomoto import NomotoFile, load_nomoto
from trainer.config.vessel import VesselFile
from trainer.core.kernel import Numbers
from trainer.identify.measurements import Record
from trainer.identify.nomoto import Levers, Nomoto, levers, nomoto, solve_motion, transfer
from trainer.units import KNOT

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


COLUMNS: Final = ("t", "u", "v", "r", "x", "y", "psi", "delta_r")
FASTEST: Final = math.tau  # [rad/s] a ship that turns faster is lost
OTHER_SPEED: Final = 0.05  # [-] from the file's own, beyond which its numbers do not hold
Z, R, PSI, X, Y, SWAY, SWAY_RATE = range(7)


def steer_ship(path: Path, step: float | None) -> "Steered":
    """Return a Nomoto file's ship. It is computed every ``step`` [s], or as the file says."""
    ship = load_nomoto(path)
    return Steered(ship if step is None else replace(ship, step_s=step))


class Steered:
    """A Nomoto ship under the orders of a manoeuvre."""

    columns = COLUMNS

    def __init__(self, ship: NomotoFile) -> None:
        """Take the ship's numbers."""
        self.name = ship.name
        self.length = ship.length_m
        self.step = ship.step_s
        self._ship = ship
        self._speed = ship.speed_kn * KNOT
        self._limit = math.radians(ship.rudder_limit_deg)
        self._neutral = math.radians(ship.neutral_deg or 0.0)
        self._bend = ship.bend
        self._state = np.zeros(7)
        self._rudder = self._ordered = self._neutral
        self._time = 0.0

    @property
    def speed_kn(self) -> float:
        """Return the speed [kn] that the ship was identified at."""
        return self._ship.speed_kn

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of the rudder."""
        return {"rudder": Control(-self._limit, self._limit)}

    def start(self, speed: float) -> None:
        """Begin anew, straight ahead at ``speed`` [m/s]; ConfigError far from the file's own."""
        if abs(speed / self._speed - 1.0) > OTHER_SPEED:
            raise ConfigError(
                f"{self.name}: was identified at {self._ship.speed_kn:g} kn, "
                f"not at {speed / KNOT:g} kn"
            )
        self._state[:] = 0.0
        self._rudder = self._ordered = self._neutral
        self._time = 0.0

    def incline(self, heel: float) -> None:
        """Do nothing: these ships do not heel."""

    def order(self, control: str, value: float) -> None:
        """Order the rudder [rad], positive to starboard, from its neutral angle."""
        del control
        self._ordered = min(max(self._neutral - value, -self._limit), self._limit)

    def keep(self, quantity: str) -> None:
        """Do nothing: speed does not change, and there is no depth."""

    def observe(self) -> tuple[float, ...]:
        """Return the columns as they stand, SI and radians."""
        s = self._state
        own = (s[SWAY], s[R], s[X], s[Y], s[PSI])
        return (self._time, self._speed, *map(float, own), self._rudder)

    def advance(self) -> None:
        """Advance by one step of Runge and Kutta, the rudder moving; LostError if it spins."""
        h = self.step
        most = math.radians(self._ship.rudder_rate_deg_s) * h
        before = self._rudder
        self._rudder += min(max(self._ordered - before, -most), most)
        helm = 0.5 * (before + self._rudder) - self._neutral
        s = self._state
        k1 = self._rates(s, helm)
        k2 = self._rates(s + 0.5 * h * k1, helm)
        k3 = self._rates(s + 0.5 * h * k2, helm)
        k4 = self._rates(s + h * k3, helm)
        self._state = s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        self._time += h
        if not abs(self._state[R]) < FASTEST:
            raise LostError(f"{self.name} spins after {self._time:g} s")

    def _rates(self, s: Numbers, helm: float) -> Numbers:
        """Return the rates of change of the state under a rudder ``helm`` [rad]."""
        ship, r = self._ship, s[R]
        T1, T2, T3, K = ship.T1_s, ship.T2_s, ship.T3_s, ship.K_per_s
        K_v, T3v = ship.K_v_m_s or 0.0, ship.T3v_s or 0.0
        linear, square, cube = self._bend
        bent = r * (linear + square * abs(r) + cube * r * r)
        if T2 == 0.0:
            turning, z_rate = (K * helm - bent) / T1, 0.0
            swaying, sway_z = (K_v * helm - s[SWAY]) / T1, 0.0
        else:
            turning = (s[Z] - (T1 + T2) * r + K * T3 * helm) / (T1 * T2)
            z_rate = K * helm - bent
            swaying = (s[SWAY_RATE] - (T1 + T2) * s[SWAY] + K_v * T3v * helm) / (T1 * T2)
            sway_z = K_v * helm - s[SWAY]
        u, v = self._speed, s[SWAY]
        north = u * math.cos(s[PSI]) - v * math.sin(s[PSI])
        east = u * math.sin(s[PSI]) + v * math.cos(s[PSI])
        return np.array([z_rate, turning, r, north, east, swaying, sway_z])
