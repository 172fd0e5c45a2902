"""Closest approach of a ship, foreseen along straight lines or on arcs.

``encounters`` calls it out, and stations show it. Lines hold while arcs leave them by little; where
both keep turning for minutes, nobody knows better than the arcs do.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.readings import read_rates
from trainer.boat.world.tracks import ShipMotion, situation
from trainer.core.kernel import Numbers

MIN_RELATIVE_SPEED: Final = 0.1  # [m/s] below which it is the range now, without a time
ARC_DEVIATION_SHARE: Final = 0.1  # [-] of the limit: arcs that leave straight lines by more count
ARC_STEP_S: Final = 5.0
ARC_TIMES_S: Final = np.arange(ARC_STEP_S, 1201.0, ARC_STEP_S)  # ahead: points are compared there
ARC_ROUNDING_M: Final = 1e-3  # by which one point differs from the same one among many
MIN_TURN_RATE: Final = math.radians(0.1)  # [rad/s] of the boat; below, waves yaw it


class OwnMotion(NamedTuple):
    """The boat's location, course and speed over the ground, and rate of turn [SI].

    Closest approaches are foreseen from it.
    """

    north: float
    east: float
    course: float
    speed: float
    turning: float

    @classmethod
    def of(cls, state: Any) -> "OwnMotion":
        """Return the motion in a state; a boat whose position is held stands still."""
        if state["held_position"]:
            # without way there is no course over the ground: the heading stands for it
            return cls(float(state["x"]), float(state["y"]), float(state["psi"]), 0.0, 0.0)
        rates, (x, y) = read_rates(state.__getitem__), (float(state["x"]), float(state["y"]))
        course = math.atan2(rates.east, rates.north)
        return cls(x, y, course, float(rates.way), float(rates.heading))

    def velocity(self) -> tuple[float, float]:
        """Return the velocity [m/s] over the ground, north and east."""
        return self.speed * math.cos(self.course), self.speed * math.sin(self.course)


class ShipPlot(NamedTuple):
    """A ship as it bears from the boat [SI]."""

    north: float  # of the boat
    east: float
    closest: float  # foreseen
    until: float  # [s] from now; below zero: past, NaN: there is no such time
    turning: bool  # whether straight lines do not hold

    @property
    def bearing(self) -> float:
        """Return the true bearing [rad]."""
        return math.atan2(self.east, self.north) % math.tau

    @property
    def range(self) -> float:
        """Return the range [m]."""
        return math.hypot(self.north, self.east)


def closest_approach(
    north: float, east: float, v_north: float, v_east: float
) -> tuple[float, float]:
    """Return closest approach [m] and time to it [s] along straight lines.

    Location and velocity are relative. Without relative speed it is the range, and the time is NaN.
    """
    square = v_north * v_north + v_east * v_east
    if square < MIN_RELATIVE_SPEED * MIN_RELATIVE_SPEED:
        return math.hypot(north, east), math.nan
    until = -(north * v_north + east * v_east) / square
    return math.hypot(north + v_north * until, east + v_east * until), until


def plot_ship(own: OwnMotion, ship: ShipMotion, limit: float) -> ShipPlot:
    """Return how a ship bears from the boat; ``limit`` [m] decides whether straight lines hold."""
    own = own if abs(own.turning) >= MIN_TURN_RATE else own._replace(turning=0.0)
    north, east = ship.north - own.north, ship.east - own.east
    (v_north, v_east), by = ship.velocity(), own.velocity()
    closest, until = closest_approach(north, east, v_north - by[0], v_east - by[1])
    turning = leaves_lines(own, ship, until, limit)
    if turning:
        closest, until = on_arcs(own, ship)
    return ShipPlot(north, east, closest, until, turning)


def leaves_lines(own: OwnMotion, ship: ShipMotion, until: float, limit: float) -> bool:
    """Return whether straight lines do not hold until a time [s].

    Arcs leave them by then by a share of a limit [m].
    """
    bend = 0.5 * (abs(own.speed * own.turning) + abs(ship.speed * ship.turning))
    return until > 0.0 and bend * until * until >= ARC_DEVIATION_SHARE * limit


def nears_on_arcs(own: OwnMotion, ship: ShipMotion, limit: float, seconds: float) -> bool:
    """Return whether ``on_arcs`` may find a range below a limit [m] within some seconds.

    Most ships that turn are too far off, and a few ranges tell: none changes faster than both go.
    """
    fastest = own.speed + ship.speed + math.hypot(ship.set_north, ship.set_east)
    time = ARC_STEP_S
    while time < seconds:
        (north, east), theirs = _point_ahead(own, time), _point_ahead(ship, time)
        north = theirs[0] + ship.set_north * time - north
        east = theirs[1] + ship.set_east * time - east
        spare = math.hypot(north, east) - limit
        if spare < ARC_ROUNDING_M:
            return True
        time += max(spare // (fastest * ARC_STEP_S), 1.0) * ARC_STEP_S
    return False


def _point_ahead(now: OwnMotion | ShipMotion, time: float) -> tuple[float, float]:
    """Return where boat or ship will be at one time [s], as ``_ahead`` does."""
    half = 0.5 * now.turning * time
    chord = now.speed * time * (math.sin(half) / half if half else 1.0)
    course = now.course + half
    return now.north + chord * math.cos(course), now.east + chord * math.sin(course)


def on_arcs(own: OwnMotion, ship: ShipMotion) -> tuple[float, float]:
    """Return closest approach [m] and time to it [s], if boat and ship keep turning."""
    (north, east), theirs = _ahead(own), _ahead(ship)
    by_north, by_east = ship.set_north * ARC_TIMES_S, ship.set_east * ARC_TIMES_S
    apart = np.hypot(theirs[0] + by_north - north, theirs[1] + by_east - east)
    first = int(apart.argmin())
    return float(apart[first]), float(ARC_TIMES_S[first])


def _ahead(now: OwnMotion | ShipMotion) -> tuple[Numbers, Numbers]:
    """Return where boat or ship will be at each time of ARC_TIMES_S, through its water."""
    if now.turning == 0.0:
        way = now.speed * ARC_TIMES_S
        return now.north + way * math.cos(now.course), now.east + way * math.sin(now.course)
    curvature = now.turning / (now.speed if now.speed > 0.0 else 1.0)
    pieces = np.array([0.0, 0.0, *now[:3], curvature, now.speed, 0.0])
    return situation(pieces[:, None], ARC_TIMES_S)[:2]
