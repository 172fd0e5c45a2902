"""A Nomoto ship moves by one equation, in a manoeuvre or met at sea.

``steered`` sails contacts by it, and ``analysis`` manoeuvres. Such a ship is known by a gain K and
time constants alone, as identification finds them. Section 12.3 of the model identification,
without differentiating the rudder:

    r' = (lag - (T1 + T2) r + K T3 delta)/(T1 T2), lag' = K delta - K H(r)    delta to port, K < 0

By kappa K H(r) = r - kappa K |r| r. The sway filter has the same denominator. It is integrated by
Runge and Kutta with the mean of the rudder over the step: of second order in the rudder, where a
differentiated rudder that stands still within the step is of first order.
"""

import math
from typing import NamedTuple

from trainer.config.ship.nomoto import NomotoFile
from trainer.units import KNOT


class NomotoState(NamedTuple):
    """The motion of a Nomoto ship, SI and radians; courses turn to starboard."""

    lag: float  # [rad] what the rudder has done and the turn has not answered yet
    turning: float
    course: float
    north: float
    east: float
    sway: float = 0.0
    sway_lag: float = 0.0  # [m]


class NomotoMotion:
    """The motion of a Nomoto ship at the speed of its file."""

    def __init__(self, ship: NomotoFile) -> None:
        """Take the ship's numbers."""
        self.speed = ship.speed_kn * KNOT  # [m/s]
        self._ship, self._bend = ship, ship.bend

    def after(self, now: NomotoState, helm: float, h: float) -> NomotoState:
        """Return the motion ``h`` [s] later, the rudder at ``helm`` [rad] from neutral in mean."""
        k1 = self._rates(now, helm)
        k2 = self._rates(_along(now, 0.5 * h, k1), helm)
        k3 = self._rates(_along(now, 0.5 * h, k2), helm)
        k4 = self._rates(_along(now, h, k3), helm)
        slopes = zip(k1, k2, k3, k4, strict=True)
        return _along(now, h / 6.0, [a + 2.0 * b + 2.0 * c + d for a, b, c, d in slopes])

    def _rates(self, now: NomotoState, helm: float) -> tuple[float, ...]:
        """Return the rates of change of a motion under a rudder ``helm`` [rad]."""
        ship, r, u, v = self._ship, now.turning, self.speed, now.sway
        T1, T2, T3, K = ship.T1_s, ship.T2_s, ship.T3_s, ship.K_per_s
        K_v, T3v = ship.K_v_m_s or 0.0, ship.T3v_s or 0.0
        linear, square, cube = self._bend
        bent = r * (linear + square * abs(r) + cube * r * r)
        if T2 == 0.0:
            turning, lag_rate = (K * helm - bent) / T1, 0.0
            swaying, sway_lag_rate = (K_v * helm - v) / T1, 0.0
        else:
            turning = (now.lag - (T1 + T2) * r + K * T3 * helm) / (T1 * T2)
            lag_rate = K * helm - bent
            swaying = (now.sway_lag - (T1 + T2) * v + K_v * T3v * helm) / (T1 * T2)
            sway_lag_rate = K_v * helm - v
        sine, cosine = math.sin(now.course), math.cos(now.course)
        north, east = u * cosine - v * sine, u * sine + v * cosine
        return lag_rate, turning, r, north, east, swaying, sway_lag_rate


def _along(now: NomotoState, h: float, slopes: tuple[float, ...] | list[float]) -> NomotoState:
    """Return a motion ``h`` [s] later along its rates of change."""
    return NomotoState(*(x + h * slope for x, slope in zip(now, slopes, strict=True)))
