"""A ship that is not linear, steered to a course.

``contacts`` moves such a ship by it. The law is this project's:

    rudder = neutral - (psi - psi ordered) - 2 L/U r        to starboard, within the file's limits

The propeller goes to the revolutions that hold the speed ordered, from rest to those of the file in
a minute. Its equations hold for a ship under way ahead: one that has lost its way lies where it is.
"""

import functools
import math
from typing import Final

from trainer.boat.ship.motion import ShipMoment, ShipMotion
from trainer.boat.world.steered import SteeredState
from trainer.config.ship.ship import ShipFile
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

LAW_LEAD: Final = 2.0  # [L/U] of the law: an estimate
ENGINE_RISE_S: Final = 60.0  # [s] from rest to the file's revolutions: an estimate


class SteeredShip:
    """A ship that is not linear under its law."""

    def __init__(self, file: ShipFile) -> None:
        """Take the numbers of its file; ConfigError if no fit has written any."""
        self.motion = ShipMotion(file)
        self._straight = functools.cache(self.motion.straight)
        try_out = self.motion.after  # so that nothing compiles once the clock runs
        try_out(self._straight(self.motion.result.speed_kn * KNOT), 0.0, self.motion.step)

    def begin(self, north: float, east: float, course: float, speed: float) -> SteeredState:
        """Return the ship straight ahead. ConfigError if it cannot hold that speed."""
        return _course(self._straight(speed))._replace(north=north, east=east, course=course)

    def after(self, now: SteeredState, ordered: float, speed: float, step: float) -> SteeredState:
        """Return how it goes ``step`` [s] later, with a course [rad] and speed [m/s] ordered."""
        if now.speed == 0.0:
            return now
        neutral, turns = self._held(speed)
        count = math.ceil(step / self.motion.step - 1e-9)
        h = step / count
        for _ in range(count):
            then = self._substep(now, ordered, neutral, turns, h)
            if then is None:
                return now._replace(speed=0.0, turning=0.0, lag=0.0, sway=0.0, turns=0.0)
            now = then
        return now

    def unfit(self, now: SteeredState, speed: float) -> Refused | None:
        """Return why the ship cannot go at a speed [m/s], None if it can."""
        why = "it has lost its way, and its equations do not tell how it gathers any"
        return Refused(why) if now.speed == 0.0 < speed else None

    def _held(self, speed: float) -> tuple[float, float]:
        """Return the rudder [rad] and revolutions [1/s] that hold a speed [m/s]."""
        # nothing holds speed 0: the screw stops, the neutral rudder is that of the usual speed
        if speed == 0.0:
            return self._straight(self.motion.result.speed_kn * KNOT).rudder, 0.0
        held = self._straight(speed)
        return held.rudder, held.turns

    def _substep(
        self, now: SteeredState, ordered: float, neutral: float, turns: float, h: float
    ) -> SteeredState | None:
        """Return the ship ``h`` [s] later, None once it has lost its way."""
        lead = LAW_LEAD * self.motion.length / now.speed
        off = math.remainder(now.course - ordered, math.tau)
        most = abs(self.motion.result.revolutions_per_s) / ENGINE_RISE_S * h
        turned = now.turns + min(max(turns - now.turns, -most), most)
        state = (now.speed, now.sway, now.turning, now.course, *now.rolling)
        moment = ShipMoment(now.north, now.east, state, now.rudder, turned)
        then = self.motion.after(moment, neutral - off - lead * now.turning, h)
        return None if then is None else _course(then)


def _course(now: ShipMoment) -> SteeredState:
    """Return a ship's moment as that of a contact."""
    u, v, r, psi, *rolling = now.state
    return SteeredState(
        now.north, now.east, psi, u, r, 0.0, now.rudder, v, now.turns, tuple(rolling)
    )
