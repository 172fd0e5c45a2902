"""A Nomoto ship under helm: a vehicle for manoeuvres in a few numbers.

Section 12.3 of the model identification, without differentiating the rudder:
r' = (z - (T1 + T2) r + K T3 delta)/(T1 T2), z' = K delta - K H(r), by kappa
K H(r) = r - kappa K |r| r. The sway filter has the same denominator. Speed does not change.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.analysis.manoeuvres.vehicle import Control, LostError
from trainer.config.files import ConfigError
from trainer.config.nomoto import NomotoFile, load_nomoto
from trainer.core.kernel import Numbers
from trainer.units import KNOT

COLUMNS: Final = ("t", "u", "v", "r", "x", "y", "psi", "delta_r")
FASTEST: Final = math.tau  # [rad/s] a ship that turns faster is lost
OTHER_SPEED: Final = 0.05  # [-] from the file's own, beyond which its numbers do not hold
Z, R, PSI, X, Y, SWAY, SWAY_RATE = range(7)


def steer_ship(path: Path, step: float | None) -> "NomotoShip":
    """Return a Nomoto file's ship. It is computed every ``step`` [s], or as the file says."""
    ship = load_nomoto(path)
    return NomotoShip(ship if step is None else replace(ship, step_s=step))


class NomotoShip:
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
