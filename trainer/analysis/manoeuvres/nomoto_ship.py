"""A ship of Nomoto's form under helm: a vehicle for manoeuvres in a few numbers.

``trainer boat manoeuvre`` flies the file that ``trainer identify --write-nomoto`` writes. K, T1,
T2, T3 and the curve of steady turns give the turning; speed does not change.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from trainer.analysis.manoeuvres.vehicle import Control, LostError
from trainer.boat.world.nomoto import NomotoMotion, NomotoState
from trainer.config.files import ConfigError
from trainer.config.ship.nomoto import NomotoFile, load_nomoto
from trainer.units import KNOT

SHIP_COLUMNS: Final = ("t", "u", "v", "r", "x", "y", "psi", "delta_r")
MAX_YAW_RATE_RAD_S: Final = math.tau  # [rad/s] a ship that turns faster is lost
SPEED_TOLERANCE: Final = 0.05  # [-] from the file's own, beyond which its numbers do not hold
STRAIGHT_STATE: Final = NomotoState(0.0, 0.0, 0.0, 0.0, 0.0)


def steer_ship(path: Path, step: float | None) -> "NomotoShip":
    """Return a Nomoto file's ship. It is computed every ``step`` [s], or as the file says."""
    ship = load_nomoto(path)
    return NomotoShip(ship if step is None else replace(ship, step_s=step))


class NomotoShip:
    """A Nomoto ship under the orders of a manoeuvre."""

    columns = SHIP_COLUMNS

    def __init__(self, ship: NomotoFile) -> None:
        """Take the ship's numbers."""
        self.name = ship.name
        self.length = ship.length_m
        self.step = ship.step_s
        self._ship = ship
        self._motion = NomotoMotion(ship)
        self._limit = math.radians(ship.rudder_limit_deg)
        self._neutral = math.radians(ship.neutral_deg or 0.0)
        self._state = STRAIGHT_STATE
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
        if abs(speed / self._motion.speed - 1.0) > SPEED_TOLERANCE:
            raise ConfigError(
                f"{self.name}: was identified at {self._ship.speed_kn:g} kn, "
                f"not at {speed / KNOT:g} kn"
            )
        self._state = STRAIGHT_STATE
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
        motion = s.sway, s.turning, s.north, s.east, s.course
        return (self._time, self._motion.speed, *motion, self._rudder)

    def advance(self) -> None:
        """Advance by one step, the rudder moving; LostError if it spins."""
        h = self.step
        most = math.radians(self._ship.rudder_rate_deg_s) * h
        before = self._rudder
        self._rudder += min(max(self._ordered - before, -most), most)
        helm = 0.5 * (before + self._rudder) - self._neutral
        try:
            self._state = self._motion.after(self._state, helm, h)
        except (ZeroDivisionError, ValueError):  # no time constant; a course beyond all numbers
            self._state = STRAIGHT_STATE._replace(turning=math.inf)
        self._time += h
        if not abs(self._state.turning) < MAX_YAW_RATE_RAD_S:
            raise LostError(f"{self.name} spins after {self._time:g} s")
