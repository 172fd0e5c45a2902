"""Closest approach and collision: what is foreseen, what is called, what was measured.

Foreseen along straight lines while these hold, else on the arcs that both are on. Measured from
tick to tick, on straight lines between: ranges are from the boat's origin to the ship's middle.
"""

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.contacts import Contacts, Ship, contacts_in
from trainer.boat.world.hulls import OwnHull, Pose, ships_overlap
from trainer.boat.world.tracks import Situation, situation
from trainer.config.contacts import Encounters
from trainer.config.files import raise_problems
from trainer.core.kernel import Numbers

MIN_RELATIVE_SPEED: Final = 0.1  # [m/s] below which it is the range now, without a time
ARC_DEVIATION_SHARE: Final = 0.1  # [-] of the limit: arcs that leave straight lines by more count
ARC_TIMES_S: Final = np.arange(5.0, 1201.0, 5.0)  # [s] ahead at which places on arcs are compared
MIN_TURN_RATE: Final = math.radians(0.1)  # [rad/s] of the boat; below, waves yaw it
MEAN_PERIOD_S: Final = 20.0  # [s] of the mean of the boat's course and turn, which waves swing
RECALL_CLEAR_S: Final = 30.0  # [s] without an approach to be called, after which one is news again
RECALL_CHANGE_SHARE: Final = 0.2  # [-] of the limit: change of closest approach called again


class OwnMotion(NamedTuple):
    """The boat's place, course and speed over the ground, and rate of turn [SI]."""

    north: float
    east: float
    course: float
    speed: float
    turning: float

    @classmethod
    def of(cls, state: Any) -> "OwnMotion":
        """Return the motion in a state; a boat whose place is held stands still."""
        if state["held_position"]:
            # without way there is no course over the ground: the heading stands for it
            return cls(float(state["x"]), float(state["y"]), float(state["psi"]), 0.0, 0.0)
        north, east = float(state["xdot"]), float(state["ydot"])
        speed, turning = math.hypot(north, east), float(state["psidot"])
        return cls(float(state["x"]), float(state["y"]), math.atan2(east, north), speed, turning)


class ShipPlot(NamedTuple):
    """All ships as they bear from the boat [SI], an array each."""

    bearing: Numbers
    range: Numbers
    closest: Numbers  # foreseen
    until: Numbers  # [s] from now; below zero: past, NaN: there is no such time
    turning: NDArray[np.bool_]  # whether straight lines do not hold


def refuse_touching(boat: Any) -> None:
    """Raise ConfigError if a ship starts in the boat's hull, or in another ship's."""
    contacts = contacts_in(boat)
    if contacts is None or not contacts.given:
        return
    hull, pose, start = OwnHull.of(boat), Pose.of(boat.state), contacts.at(0)
    rows = list(zip(*(each.tolist() for each in start[:3]), strict=True))
    lying = [(*row, each.type) for row, each in zip(rows, contacts.given, strict=True)]
    problems = []
    for i, (contact, (north, east, course, kind)) in enumerate(
        zip(contacts.given, lying, strict=True)
    ):
        problem = f"points[0] = [{north:g}, {east:g}]: {contact.row.name} starts in "
        if hull.touches(pose, kind, north, east, course):
            problems.append(contact.place.problem(f"{problem}the boat's own hull"))
        problems += [
            contact.place.problem(f"{problem}the hull of {other.row.name}")
            for other, its in zip(contacts.given[:i], lying[:i], strict=True)
            if ships_overlap((north, east, course, kind), its)
        ]
    raise_problems(problems)


def closest_approach(
    north: Numbers, east: Numbers, v_north: Numbers, v_east: Numbers
) -> tuple[Numbers, Numbers]:
    """Return closest approach [m] and time to it [s] along straight lines.

    Place and velocity are relative. Without relative speed it is the range, and the time is NaN.
    """
    square = v_north * v_north + v_east * v_east
    moves = square >= MIN_RELATIVE_SPEED * MIN_RELATIVE_SPEED
    until = np.where(moves, -(north * v_north + east * v_east) / np.where(moves, square, 1.0), 0.0)
    closest = np.hypot(north + v_north * until, east + v_east * until)
    return closest, np.where(moves, until, np.nan)


def plot_ships(own: OwnMotion, there: Situation, limit: float) -> ShipPlot:
    """Return how ships bear from the boat; ``limit`` [m] decides whether straight lines hold."""
    own = own if abs(own.turning) >= MIN_TURN_RATE else own._replace(turning=0.0)
    north, east = there.north - own.north, there.east - own.east
    v_north, v_east = there.velocity()
    v_north -= own.speed * math.cos(own.course)
    v_east -= own.speed * math.sin(own.course)
    closest, until = closest_approach(north, east, v_north, v_east)
    bend = 0.5 * (abs(own.speed * own.turning) + np.abs(there.speed * there.turning))
    turning = bend * until * until >= ARC_DEVIATION_SHARE * limit
    turning &= until > 0.0
    if turning.any():
        chosen = Situation(*(each[turning] for each in there))
        closest[turning], until[turning] = on_arcs(own, chosen)
    return ShipPlot(
        np.arctan2(east, north) % math.tau, np.hypot(north, east), closest, until, turning
    )


def on_arcs(own: OwnMotion, there: Situation) -> tuple[Numbers, Numbers]:
    """Return closest approach [m] and time to it [s], if boat and ships keep turning."""
    mine = _ahead(Situation(*(np.array([each]) for each in (*own, 0.0, 0.0))))
    theirs = _ahead(there)
    apart = np.hypot(theirs.north - mine.north, theirs.east - mine.east)
    first = apart.argmin(axis=1)
    return apart[np.arange(first.size), first], ARC_TIMES_S[first]


def _ahead(now: Situation) -> Situation:
    """Return where ships will be at each time of ARC_TIMES_S, a row each."""
    curvature = now.turning / np.where(now.speed > 0.0, now.speed, 1.0)
    none = np.zeros_like(now.north)
    pieces = np.array([none, none, *now[:3], curvature, now.speed, none])
    then = situation(pieces[:, :, None], ARC_TIMES_S)
    by_north, by_east = now.set_north[:, None] * ARC_TIMES_S, now.set_east[:, None] * ARC_TIMES_S
    return then._replace(north=then.north + by_north, east=then.east + by_east)


def passing_ranges(
    contacts: Contacts, tick: int, before: tuple[float, float], now: tuple[float, float]
) -> tuple[tuple[Ship, ...], Numbers]:
    """Return the ships and each one's least range [m] in the step to a tick.

    ``before`` and ``now`` are the boat's places; both move on straight lines in the step.
    """
    fleet = contacts.fleet(tick - 1)
    start, end = fleet.at((tick - 1) * contacts.step), fleet.at(tick * contacts.step)
    north, east = start.north - before[0], start.east - before[1]
    by_north, by_east = end.north - now[0] - north, end.east - now[1] - east
    square = by_north * by_north + by_east * by_east
    along = -(north * by_north + east * by_east) / np.where(square > 0.0, square, 1.0)
    share = np.clip(along, 0.0, 1.0)
    return fleet.order, np.hypot(north + share * by_north, east + share * by_east)


@dataclass
class EncounterMonitor:
    """The watch on ships that come near: what is called, and the least ranges."""

    contacts: Contacts | None = None
    hull: OwnHull | None = None
    struck: str = ""  # the ship that was run into in the last tick
    nearest: tuple[str, float] = "", math.inf  # ship and range [m] in the last tick
    closest: dict[str, tuple[float, int]] = field(default_factory=dict)  # [m] and tick, by name
    called: dict[str, float] = field(default_factory=dict)  # [m] as it was called last
    clear_since: dict[str, float] = field(default_factory=dict)  # [s] since when none is, by name
    touching: set[str] = field(default_factory=set)
    _pose: Pose | None = None  # of the boat in the tick before
    _past: list[Pose] = field(default_factory=list, repr=False)  # of the last MEAN_PERIOD_S

    @classmethod
    def over(cls, boat: Any) -> "EncounterMonitor":
        """Return the watch over a boat."""
        contacts = contacts_in(boat)
        monitor = cls(contacts, OwnHull.of(boat) if contacts else None)
        monitor.settle(boat)
        return monitor

    @property
    def rules(self) -> Encounters:
        """Return the exercise's rules about ships that come near."""
        return self.contacts.encounters if self.contacts else Encounters()

    def settle(self, boat: Any) -> None:
        """Take the boat as it is, after a jump in time. No range is measured over the jump."""
        self.struck, self.nearest = "", ("", math.inf)
        self._pose = Pose.of(boat.state) if self.contacts else None
        for memory in (self.closest, self.called, self.clear_since, self.touching, self._past):
            memory.clear()

    def look(self, boat: Any) -> list[str]:
        """Return what there is to call out after a tick."""
        self.struck, self.nearest = "", ("", math.inf)
        contacts, before, tick = self.contacts, self._pose, boat.ticks
        if contacts is None or not contacts.fleet(tick).order:
            self._pose = None
            return []
        now = self._pose = Pose.of(boat.state)
        news = [] if before is None else self.step(contacts, tick, before, now)
        news += self._calls(boat, contacts)
        return [f"tick {tick} ({boat.time:g} s): {text}" for text in news]

    def ended_by(self, boat: Any) -> str:
        """Return by what collision the exercise ends after a tick, "" if it goes on."""
        self.look(boat)
        ends = self.struck and self.rules.collision == "end"
        return f"collision with {self.struck}" if ends else ""

    def step(self, contacts: Contacts, tick: int, before: Pose, now: Pose) -> list[str]:
        """Keep each ship's least range in the step to a tick. Return new collisions."""
        self.struck, self.nearest = "", ("", math.inf)
        ships, ranges = passing_ranges(contacts, tick, before[:2], now[:2])
        for ship, apart in zip(ships, ranges.tolist(), strict=True):
            if apart < self.closest.get(ship.name, (math.inf, 0))[0]:
                self.closest[ship.name] = apart, tick
            if apart < self.nearest[1]:
                self.nearest = ship.name, apart
        # a collision is news once, until the hulls part
        struck = self._struck(contacts, tick, before, now, ranges)
        news = [f"COLLISION with {name}, {_words(ships, name)}" for name in struck - self.touching]
        self.struck = min(struck - self.touching, default="")
        self.touching = struck
        return sorted(news)

    def _struck(
        self, contacts: Contacts, tick: int, before: Pose, now: Pose, ranges: Numbers
    ) -> set[str]:
        """Return the ships that the boat touches in the step to a tick."""
        hull, fleet = self.hull, contacts.fleet(tick - 1)
        if hull is None:
            return set()
        depth = min(before.depth, now.depth)
        near = [
            (i, ship)
            for i, ship in enumerate(fleet.order)
            if not hull.far(float(ranges[i]), depth, ship.type, 0.0)
        ]
        if not near:
            return set()
        times = (tick - 1) * contacts.step, tick * contacts.step
        start, end = (np.array(fleet.at(time)[:3]) for time in times)
        return {
            ship.name
            for i, ship in near
            if _meets(hull, ship, (before, now), (start[:, i], end[:, i]))
        }

    def _calls(self, boat: Any, contacts: Contacts) -> list[str]:
        """Return each closest approach that is to be called now."""
        rules, tick = self.rules, boat.ticks
        fleet, boat_motion = contacts.fleet(tick), self._own(boat)
        seen = plot_ships(boat_motion, contacts.at(tick), rules.cpa_m)
        ahead = (seen.until >= 0.0) & (seen.until < rules.warn_s)
        soon = ahead & (seen.closest < rules.cpa_m)
        over = ~ahead | (seen.closest > (1.0 + RECALL_CHANGE_SHARE) * rules.cpa_m)
        self._forget([ship.name for i, ship in enumerate(fleet.order) if over[i]], boat.time)
        news = []
        for i in np.flatnonzero(soon).tolist():
            name, closest = fleet.order[i].name, float(seen.closest[i])
            # whether a closest approach [m] has not been called yet, or has changed
            before = self.called.get(name)
            if before is None or abs(closest - before) > RECALL_CHANGE_SHARE * self.rules.cpa_m:
                self.called[name] = closest
                news.append(_call(fleet.order[i], ShipPlot(*(each[i] for each in seen))))
        return news

    def _forget(self, over: list[str], time: float) -> None:
        """Let approaches be news again that have been over for long enough at a time [s]."""
        self.clear_since = {name: self.clear_since.get(name, time) for name in over}
        for name, since in self.clear_since.items():
            if time - since >= RECALL_CLEAR_S:
                self.called.pop(name, None)

    def _own(self, boat: Any) -> OwnMotion:
        """Return the boat's mean motion of the last MEAN_PERIOD_S, because waves swing it."""
        motion = OwnMotion.of(boat.state)._replace(turning=0.0)
        self._past.append(Pose.of(boat.state))
        count = round(MEAN_PERIOD_S / boat.method.step)
        if boat.state["held_position"] or len(self._past) <= count:
            return motion
        first, last = self._past[-count - 1], self._past[-1]
        self._past = self._past[-count:]
        seconds = count * boat.method.step
        north, east = (last.north - first.north) / seconds, (last.east - first.east) / seconds
        turned = math.remainder(last.heading - first.heading, math.tau)
        course, speed = math.atan2(east, north), math.hypot(north, east)
        return motion._replace(course=course, speed=speed, turning=turned / seconds)

    def account(self) -> str:
        """Return the closest that each ship has been, in words."""
        ranges = sorted(self.closest.items(), key=lambda item: item[1])
        step = self.contacts.step if self.contacts else 1.0
        return ", ".join(f"{name} {m:.0f} m (at {tick * step:g} s)" for name, (m, tick) in ranges)


def _meets(
    hull: OwnHull, ship: Ship, poses: tuple[Pose, Pose], places: tuple[Numbers, Numbers]
) -> bool:
    """Return whether the boat touches a ship between two poses, and two places of the ship."""
    (before, now), (start, end) = poses, places
    way = np.array(now[:3]) - np.array(before[:3])
    way[:2] -= end[:2] - start[:2]
    # in steps of a share of the ship's beam, so that no ship is jumped over
    looks = hull.looks(float(np.linalg.norm(way)), ship.type)
    for share in ((i + 1) / looks for i in range(looks)):
        place = (start + share * (end - start)).tolist()
        if hull.touches(before.towards(now, share), ship.type, *place):
            return True
    return False


def _words(ships: tuple[Ship, ...], name: str) -> str:
    """Return what kind of ship has a name."""
    return next(f"a {ship.kind}" for ship in ships if ship.name == name)


def _call(ship: Ship, seen: ShipPlot) -> str:
    """Return the words of a closest approach foreseen."""
    minutes, seconds = divmod(round(float(seen.until)), 60)
    time_text = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    bearing = round(math.degrees(float(seen.bearing))) % 360
    turning = ", turning" if seen.turning else ""
    return (
        f"CLOSEST APPROACH: {ship.name} {float(seen.closest):.0f} m in {time_text}{turning}; "
        f"now {bearing:03d} at {float(seen.range):.0f} m"
    )
