"""Ships that answer their rudder: identified ships that a simple law steers to a course.

A ship is computed tick by tick from its last order on, whoever asks and in whatever order: the
numbers are the same.

A Nomoto ship moves by ``nomoto``, its rudder to port by this project's law:

    delta ordered = (psi - psi ordered) + 2 (T1 + T2) r, within the file's limits of angle and rate

At another speed than the file's its clock goes slower or faster in proportion, so that K, 1/T and
H's bend grow with the speed, and a rudder gives the same circle at every speed. Sway is left out.
"""

import math
import threading
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple, Protocol

from trainer.boat.world.nomoto import NomotoMotion, NomotoState
from trainer.config.ship.nomoto import NomotoFile
from trainer.config.world.contacts import SHIP_ACCELERATION_M_S2
from trainer.io.orders.grammar import Refused

MAX_SUBSTEP_S: Final = 0.5  # [s] at most
LAW_DAMPING: Final = 2.0  # [-] of the law, times T1 + T2
SUBSTEPS_PER_TIME: Final = 4.0  # [-] substeps in the shortest time constant


class SteeredState(NamedTuple):
    """Location, course, speed, rate of turn with its lag, and rudder, all SI.

    The other numbers are those of a ship that is not linear.
    """

    north: float
    east: float
    course: float  # where it heads
    speed: float  # ahead
    turning: float
    lag: float
    rudder: float
    sway: float = 0.0
    turns: float = 0.0  # [1/s] of the propeller
    rolling: tuple[float, ...] = ()  # roll rate and roll


class SteerableShip(Protocol):
    """A ship that can be steered."""

    def begin(self, north: float, east: float, course: float, speed: float) -> SteeredState:
        """Return the ship straight ahead. ConfigError if it cannot go so."""

    def after(self, now: SteeredState, ordered: float, speed: float, step: float) -> SteeredState:
        """Return how it goes ``step`` [s] later, with a course [rad] and speed [m/s] ordered."""

    def unfit(self, now: SteeredState, speed: float) -> Refused | None:
        """Return why it cannot go at a speed [m/s], None if it can."""


@dataclass
class SteeredContact:
    """A ship from an order on; ``step`` [s] is that of the boat's ticks."""

    ship: SteerableShip
    step: float
    begins: float  # [s]
    start: SteeredState
    ordered: float  # [rad]
    ordered_speed: float  # [m/s]
    _known: list[SteeredState] = field(default_factory=list, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def at(self, time: float) -> SteeredState:
        """Return how it goes at a tick's time [s]; before it begins, as it begins."""
        ticks = max(round((time - self.begins) / self.step), 0)
        with self._lock:
            if not self._known:
                self._known.append(self.start)
            while len(self._known) <= ticks:
                now, ship = self._known[-1], self.ship
                self._known.append(ship.after(now, self.ordered, self.ordered_speed, self.step))
            return self._known[ticks]

    def then(self, time: float, course: float | None, speed: float | None) -> "SteeredContact":
        """Return the ship steered otherwise from a time [s] on; None: as before."""
        now = self.at(time)
        return SteeredContact(
            self.ship,
            self.step,
            max(time, self.begins),
            now,
            self.ordered if course is None else course,
            self.ordered_speed if speed is None else speed,
        )

    def moved(self, time: float, north: float, east: float) -> "SteeredContact":
        """Return the ship put elsewhere at a time [s]."""
        then = self.then(time, None, None)
        return replace(then, start=then.start._replace(north=north, east=east), _known=[])


class SteeredNomoto:
    """A Nomoto ship under its law."""

    def __init__(self, ship: NomotoFile) -> None:
        """Take the numbers of its file."""
        self.ship = ship
        self._motion = NomotoMotion(replace(ship, K_v_m_s=None))

    def begin(self, north: float, east: float, course: float, speed: float) -> SteeredState:
        """Return the ship straight ahead."""
        return SteeredState(north, east, course, speed, 0.0, 0.0, 0.0)

    def after(self, now: SteeredState, ordered: float, speed: float, step: float) -> SteeredState:
        """Return how it goes ``step`` [s] later, with a course [rad] and speed [m/s] ordered."""
        shortest = min(filter(None, (self.ship.T1_s, self.ship.T2_s)))
        count = math.ceil(step / min(MAX_SUBSTEP_S, shortest / SUBSTEPS_PER_TIME))
        for _ in range(count):
            now = self._substep(now, ordered, speed, step / count)
        return now

    def unfit(self, now: SteeredState, speed: float) -> None:
        """Refuse nothing: a Nomoto ship goes at every speed."""

    def _substep(self, now: SteeredState, ordered: float, speed: float, h: float) -> SteeredState:
        """Return how it goes ``h`` [s] later, its clock as fast as it is at the beginning.

        A ship that lies still has lost its turn.
        """
        gained = min(
            max(speed - now.speed, -SHIP_ACCELERATION_M_S2 * h), SHIP_ACCELERATION_M_S2 * h
        )
        faster = now.speed + gained
        clock = now.speed / self._motion.speed
        if clock <= 0.0:
            return now._replace(speed=faster, turning=0.0, lag=0.0)
        rudder = now.rudder + h * self._rudder_rate(now, ordered, clock, h)
        here = NomotoState(now.lag, now.turning / clock, now.course, now.north, now.east)
        after = self._motion.after(here, 0.5 * (now.rudder + rudder), clock * h)
        turning = after.turning * faster / self._motion.speed
        return SteeredState(
            after.north,
            after.east,
            after.course,
            faster,
            turning,
            after.lag,
            rudder,
        )

    def _rudder_rate(self, now: SteeredState, ordered: float, clock: float, h: float) -> float:
        """Return how fast [rad/s] the rudder goes to where the law wants it."""
        ship = self.ship
        lead = LAW_DAMPING * (ship.T1_s + ship.T2_s) / clock
        off = math.remainder(now.course - ordered, math.tau)
        limit, fastest = math.radians(ship.rudder_limit_deg), math.radians(ship.rudder_rate_deg_s)
        wanted = min(max(off + lead * now.turning, -limit), limit)
        return min(max((wanted - now.rudder) / h, -fastest), fastest)
