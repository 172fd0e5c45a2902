"""Ships that answer their rudder: identified ships that a simple law steers to a course.

A ship is computed tick by tick from its last order on, whoever asks and in whatever order: the
numbers are the same.

A Nomoto ship goes by

    T1 T2 r'' + (T1 + T2) r' + K H(r) = K (delta + T3 delta')        delta to port, K < 0
    delta ordered = (psi - psi ordered) + 2 (T1 + T2) r, within the file's limits of angle and rate

K and 1/T grow with the speed, and so does H's bend, so that a rudder gives the same circle at every
speed. The law is this project's. Sway is left out. It is integrated by Runge and Kutta.
"""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple, Protocol

from trainer.config.contacts import ACCELERATION
from trainer.config.nomoto import NomotoFile
from trainer.units import KNOT

SUBSTEP: Final = 0.5  # [s] at most
DAMPING: Final = 2.0  # [-] of the law, times T1 + T2
FINE: Final = 4.0  # [-] substeps in the shortest time constant


class Course(NamedTuple):
    """Place, course, speed, rate of turn with its own rate, and rudder, all SI.

    The other numbers are those of a ship that is not linear.
    """

    north: float
    east: float
    course: float  # where it heads
    speed: float  # ahead
    turning: float
    change: float
    rudder: float
    sway: float = 0.0
    turns: float = 0.0  # [1/s] of the propeller
    rolling: tuple[float, ...] = ()  # roll rate and roll


class Helmed(Protocol):
    """A ship that can be steered."""

    def begin(self, north: float, east: float, course: float, speed: float) -> Course:
        """Return the ship straight ahead. ConfigError if it cannot go so."""

    def after(self, now: Course, ordered: float, speed: float, step: float) -> Course:
        """Return how it goes ``step`` [s] later, with a course [rad] and speed [m/s] ordered."""

    def unfit(self, now: Course, speed: float) -> str:
        """Return why it cannot go at a speed [m/s], "" if it can."""


@dataclass
class Steered:
    """A ship from an order on; ``step`` [s] is that of the boat's ticks."""

    ship: Helmed
    step: float
    begins: float  # [s]
    start: Course
    ordered: float  # [rad]
    ordered_speed: float  # [m/s]
    _known: list[Course] = field(default_factory=list, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def at(self, time: float) -> Course:
        """Return how it goes at a tick's time [s]; before it begins, as it begins."""
        ticks = max(round((time - self.begins) / self.step), 0)
        with self._lock:
            if not self._known:
                self._known.append(self.start)
            while len(self._known) <= ticks:
                self._known.append(self._after(self._known[-1]))
            return self._known[ticks]

    def then(self, time: float, course: float | None, speed: float | None) -> "Steered":
        """Return the ship steered otherwise from a time [s] on; None: as before."""
        now = self.at(time)
        return Steered(
            *(self.ship, self.step, max(time, self.begins), now),
            self.ordered if course is None else course,
            self.ordered_speed if speed is None else speed,
        )

    def moved(self, time: float, north: float, east: float) -> "Steered":
        """Return the ship put elsewhere at a time [s]."""
        then = self.then(time, None, None)
        return replace(then, start=then.start._replace(north=north, east=east), _known=[])

    def _after(self, now: Course) -> Course:
        """Return how it goes a tick later."""
        return self.ship.after(now, self.ordered, self.ordered_speed, self.step)


Rates = tuple[float, float, float, float, float]  # of all but speed and rudder


class SteeredNomoto:
    """A Nomoto ship under its law."""

    def __init__(self, ship: NomotoFile) -> None:
        """Take the numbers of its file."""
        self.ship = ship

    def begin(self, north: float, east: float, course: float, speed: float) -> Course:
        """Return the ship straight ahead."""
        return Course(north, east, course, speed, 0.0, 0.0, 0.0)

    def after(self, now: Course, ordered: float, speed: float, step: float) -> Course:
        """Return how it goes ``step`` [s] later, with a course [rad] and speed [m/s] ordered."""
        shortest = min(filter(None, (self.ship.T1_s, self.ship.T2_s)))
        count = math.ceil(step / min(SUBSTEP, shortest / FINE))
        for _ in range(count):
            now = self._substep(now, ordered, speed, step / count)
        return now

    def unfit(self, now: Course, speed: float) -> str:
        """Return "": a Nomoto ship goes at every speed."""
        del now, speed
        return ""

    def _substep(self, now: Course, ordered: float, speed: float, h: float) -> Course:
        """Return how it goes ``h`` [s] later, by Runge and Kutta; speed and rudder are held."""
        rate = self._rudder_rate(now, ordered, h)
        forces = self._forces(now.speed, now.rudder, rate)
        here: Rates = (now.north, now.east, now.course, now.turning, now.change)
        first = forces(here)
        second = forces(_along(here, first, 0.5 * h))
        third = forces(_along(here, second, 0.5 * h))
        last = forces(_along(here, third, h))
        north, east, course, turning, change = (
            x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            for x, a, b, c, d in zip(here, first, second, third, last, strict=True)
        )
        gained = min(max(speed - now.speed, -ACCELERATION * h), ACCELERATION * h)
        return Course(
            north, east, course, now.speed + gained, turning, change, now.rudder + rate * h
        )

    def _rudder_rate(self, now: Course, ordered: float, h: float) -> float:
        """Return how fast [rad/s] the rudder goes to where the law wants it."""
        ship = self.ship
        share = self._share(now.speed)
        lead = DAMPING * (ship.T1_s + ship.T2_s) / share if share else 0.0
        off = math.remainder(now.course - ordered, math.tau)
        limit, fastest = math.radians(ship.rudder_limit_deg), math.radians(ship.rudder_rate_deg_s)
        wanted = min(max(off + lead * now.turning, -limit), limit)
        return min(max((wanted - now.rudder) / h, -fastest), fastest)

    def _share(self, speed: float) -> float:
        """Return the speed over that at which the ship was identified [-]."""
        return speed / (self.ship.speed_kn * KNOT)

    def _forces(self, speed: float, rudder: float, rate: float) -> Callable[[Rates], Rates]:
        """Return what gives the rates of a ship at a speed with a rudder."""
        ship, share = self.ship, self._share(speed)
        bend = ship.bend

        def forces(now: Rates) -> Rates:
            _, _, course, turning, change = now
            ahead = speed * math.cos(course), speed * math.sin(course)
            if share <= 0.0:
                return (0.0, 0.0, 0.0, -turning, -change)
            r = turning / share  # as it would be at the speed of the file
            stiff = share * (bend[0] * r + bend[1] * abs(r) * r + bend[2] * r**3)
            K, T1, T2, T3 = (
                *(ship.K_per_s * share, ship.T1_s / share, ship.T2_s / share, ship.T3_s / share),
            )
            pushed = K * (rudder + T3 * rate) - stiff
            if T2 == 0.0:
                return (*ahead, turning, pushed / T1, 0.0)
            return (*ahead, turning, change, (pushed - (T1 + T2) * change) / (T1 * T2))

        return forces


def _along(here: Rates, slope: Rates, h: float) -> Rates:
    """Return the place a step along a slope."""
    a, b, c, d, e = (x + h * dx for x, dx in zip(here, slope, strict=True))
    return a, b, c, d, e
