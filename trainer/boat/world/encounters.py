"""Closest approach and collision: what is foreseen, what is called, what was measured.

``limits`` calls them out in a run, and debriefs ask again. Foreseen along straight lines while
these hold, else on the arcs that both are on. Measured from tick to tick, on straight lines
between: ranges are from the boat's origin to the ship's middle.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.world.approach import (
    ARC_DEVIATION_SHARE,
    MIN_RELATIVE_SPEED,
    MIN_TURN_RATE,
    OwnMotion,
    ShipPlot,
    closest_approach,
    leaves_lines,
    nears_on_arcs,
    on_arcs,
    plot_ship,
)
from trainer.boat.world.bottom import STATE_OFFSETS
from trainer.boat.world.contact_fleet import Ship, Ticks
from trainer.boat.world.contacts import Contacts, contacts_in
from trainer.boat.world.hulls import POSE_NAMES, OwnHull, Pose, read_pose, ships_overlap
from trainer.boat.world.tracks import ShipMotion, Situation
from trainer.config.files import raise_problems
from trainer.config.world.contacts import Encounters
from trainer.core.kernel import Numbers

MEAN_PERIOD_S: Final = 20.0  # [s] of the mean of the boat's course and turn, which waves swing
RECALL_CLEAR_S: Final = 30.0  # [s] without an approach to be called, after which one is news again
HELD_OFFSET: Final = STATE_OFFSETS["held_position"]
FAR_MARGIN: Final = 1.01  # [-] on how far ships can come near in the time of a warning
RECALL_CHANGE_SHARE: Final = 0.2  # [-] of the limit: change of closest approach called again


class TickColumns(Protocol):
    """The states after ticks in a row, by the names of their numbers.

    ``flown_ticks.FlownTicks`` is one; the world does not import the boat, which imports the world.
    """

    ticks: Ticks

    def __getitem__(self, name: str) -> Numbers:
        """Return a number of the state at each tick."""

    def __len__(self) -> int:
        """Return how many there are."""


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
            problems.append(contact.position.problem(f"{problem}the boat's own hull"))
        problems += [
            contact.position.problem(f"{problem}the hull of {other.row.name}")
            for other, its in zip(contacts.given[:i], lying[:i], strict=True)
            if ships_overlap((north, east, course, kind), its)
        ]
    raise_problems(problems)


class PassedShip(NamedTuple):
    """One ship, and its least ranges in the steps to some rows of a passage."""

    ship: Ship
    rows: Ticks
    ranges: Numbers  # [m]
    starts: Numbers  # north, east [m] and course [rad] of the ship where each step begins
    ends: Numbers


def passed_ships(contacts: Contacts, ticks: Ticks, poses: Numbers) -> Iterator[PassedShip]:
    """Yield the ships that there were in a passage, by their fleets.

    ``poses`` [6, ticks] are the boat's. Boat and ships move on straight lines in a step.
    """
    for indices, fleet in contacts.stretches(ticks[1:] - 1):
        rows = indices + 1
        start, end = (fleet.over(ticks[rows - back]) for back in (1, 0))
        ranges = passing_ranges(start, end, poses[:2, rows - 1], poses[:2, rows])
        starts, ends = (np.array(each[:3]) for each in (start, end))
        for i, ship in enumerate(fleet.order):
            yield PassedShip(ship, rows, ranges[i], starts[:, i], ends[:, i])


def collisions_in(
    passed: Iterable[PassedShip], hull: OwnHull, poses: Numbers
) -> list[tuple[int, str]]:
    """Return each collision of a passage: its row and the ship. It is one until the hulls part."""
    touched: dict[int, set[str]] = {}
    for each in passed:
        depth = np.minimum(poses[2, each.rows - 1], poses[2, each.rows])
        for k in np.flatnonzero(~hull.far(each.ranges, depth, each.ship.body)).tolist():
            row = int(each.rows[k])
            both = Pose(*poses[:, row - 1].tolist()), Pose(*poses[:, row].tolist())
            if _meets(hull, each.ship, both, (each.starts[:, k], each.ends[:, k])):
                touched.setdefault(row, set()).add(each.ship.name)
    new = {row: touched[row] - touched.get(row - 1, set()) for row in sorted(touched)}
    return [(row, min(names)) for row, names in new.items() if names]


def passing_ranges(start: Situation, end: Situation, before: Numbers, now: Numbers) -> Numbers:
    """Return the least ranges [m] of ships in steps, a row each.

    ``before`` and ``now`` are where the boat is [m], north and east, as the steps begin and end.
    """
    north, east = start.north - before[0], start.east - before[1]
    by_north, by_east = end.north - now[0] - north, end.east - now[1] - east
    square = by_north * by_north + by_east * by_east
    along = -(north * by_north + east * by_east) / np.where(square > 0.0, square, 1.0)
    share = np.clip(along, 0.0, 1.0)
    north, east = north + share * by_north, east + share * by_east
    ranges: Numbers = np.sqrt(north * north + east * east)
    return ranges


def passing_range(start: ShipMotion, end: ShipMotion, before: Pose, now: Pose) -> float:
    """Return the least range [m] of a ship in one step, as ``passing_ranges`` does."""
    north, east = start[0] - before[0], start[1] - before[1]
    by_north, by_east = end[0] - now[0] - north, end[1] - now[1] - east
    square = by_north * by_north + by_east * by_east
    along = -(north * by_north + east * by_east) / (square if square > 0.0 else 1.0)
    share = 0.0 if along < 0.0 else min(along, 1.0)
    north, east = north + share * by_north, east + share * by_east
    return math.sqrt(north * north + east * east)


Named = tuple[str, str]  # a ship, and what is called of it


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
    mean_ticks: int = field(init=False)  # in MEAN_PERIOD_S

    def __post_init__(self) -> None:
        self.mean_ticks = round(MEAN_PERIOD_S / self.contacts.step) if self.contacts else 0

    @classmethod
    def over(cls, boat: Any) -> "EncounterMonitor":
        """Return the watch over a boat."""
        contacts = contacts_in(boat)
        monitor = cls(contacts, OwnHull.of(boat) if contacts else None)
        monitor.reset_to(boat)
        return monitor

    @property
    def rules(self) -> Encounters:
        """Return the exercise's rules about ships that come near."""
        return self.contacts.encounters if self.contacts else Encounters()

    def reset_to(self, boat: Any) -> None:
        """Take the boat as it is. No range is measured from where it was before."""
        self.struck, self.nearest = "", ("", math.inf)
        self._pose = Pose(*boat.numbers(POSE_NAMES)) if self.contacts else None
        for memory in (self.closest, self.called, self.clear_since, self.touching, self._past):
            memory.clear()

    def look(self, boat: Any) -> list[MonitorCall]:
        """Return what there is to call out after a tick."""
        self.struck, self.nearest = "", ("", math.inf)
        contacts, before = self.contacts, self._pose
        if contacts is None:
            return []
        tick = boat.ticks
        fleet = contacts.fleet(tick)
        if not fleet.order:
            self._pose = None
            return []
        now = self._pose = Pose(*read_pose(boat.plain))
        struck = [] if before is None else self.step(contacts, tick, before, now)
        near = self._calls(boat, fleet.order, fleet.motions(tick), now)
        if not (struck or near):
            return []
        now_text = f"tick {tick} ({boat.time:g} s)"
        calls = [MonitorCall(text, Rank.EMERGENCY, f"collision: {name}") for name, text in struck]
        calls += [MonitorCall(text, key=f"approach: {name}") for name, text in near]
        return [call._replace(text=f"{now_text}: {call.text}") for call in calls]

    @property
    def holding(self) -> set[str]:
        """Return the keys of the alerts called that hold still."""
        touching = {f"collision: {name}" for name in self.touching}
        return touching | {f"approach: {name}" for name in self.called}

    def ranges(self, flown: TickColumns) -> Numbers:
        """Return the least ranges [m] of the ships at some ticks, a row each."""
        if self.contacts is None or self._pose is None:
            return np.empty((0, len(flown)))
        way, before = self._ways(self.contacts, flown), self._pose
        start = Situation(*(column[:, :-1] for column in way))
        end = Situation(*(column[:, 1:] for column in way))
        here = np.array((flown["x"], flown["y"]))
        return passing_ranges(start, end, np.column_stack((before[:2], here[:, :-1])), here)

    def _ways(self, contacts: Contacts, flown: TickColumns) -> Situation:
        """Return how the ships go at some ticks, and at the tick before them."""
        begun = int(flown.ticks[0]) - 1
        return contacts.fleet(begun).over(np.append(begun, flown.ticks))

    def quiet_ticks(self, flown: TickColumns, ranges: Numbers) -> int:
        """Return after how many ticks there may be something to call, or all of them.

        ``ranges`` [m] are those of the ships in these ticks.
        """
        contacts, hull, before = self.contacts, self.hull, self._pose
        if contacts is None or hull is None or not contacts.fleet(int(flown.ticks[0]) - 1).order:
            return len(flown)
        unready = len(self._past) != self.mean_ticks or flown["held_position"].any()
        if before is None or unready or self.called or self.touching:
            return 0
        depths = np.minimum(flown["z"], np.append(before.depth, flown["z"][:-1]))
        fleet = contacts.fleet(int(flown.ticks[0]) - 1)
        mask = self._may_call(flown, self._ways(contacts, flown), self.mean_ticks * contacts.step)
        for ship, its in zip(fleet.order, ranges, strict=True):
            mask |= ~hull.far(its, depths, ship.body)
        return int(mask.argmax()) if mask.any() else len(flown)

    def _may_call(self, flown: TickColumns, way: Situation, seconds: float) -> NDArray[np.bool_]:
        """Return at which ticks a closest approach may have to be called.

        ``seconds`` [s] are those of the boat's mean motion.
        """
        rules = self.rules
        past = np.array(self._past)[:, (0, 1, 5)].T
        now = np.array((flown["x"], flown["y"], flown["psi"]))
        north, east, turned = (now - np.hstack((past, now))[:, : len(flown)]) / seconds
        theirs = Situation(*(column[:, 1:] for column in way))
        v_north, v_east = theirs.velocity()
        v_north, v_east = v_north - north, v_east - east
        off_north, off_east = theirs.north - now[0], theirs.east - now[1]
        square = np.maximum(v_north * v_north + v_east * v_east, MIN_RELATIVE_SPEED**2)
        until = -(off_north * v_north + off_east * v_east) / square
        apart = np.hypot(off_north + v_north * until, off_east + v_east * until)
        spin = np.abs(np.remainder(turned * seconds + math.pi, math.tau) - math.pi) / seconds
        spin = np.where(spin < 0.999 * MIN_TURN_RATE, 0.0, spin)
        bend = 0.5 * (np.hypot(north, east) * spin + np.abs(theirs.speed * theirs.turning))
        # a little sooner than the words of one tick, because these numbers are rounded otherwise
        turning = bend * until * until >= 0.999 * ARC_DEVIATION_SHARE * rules.cpa_m
        near = (until < 1.001 * rules.warn_s) & (apart < 1.001 * rules.cpa_m)
        result: NDArray[np.bool_] = ((until > -1e-6) & (turning | near)).any(axis=0)
        return result

    def pass_over(self, flown: TickColumns) -> None:
        """Take these ticks as seen, in which there was nothing to call."""
        contacts = self.contacts
        if contacts is None or self._pose is None:
            return
        fleet, ranges = contacts.fleet(int(flown.ticks[0]) - 1), self.ranges(flown)
        if not fleet.order:
            self._pose = None
            return
        for ship, its in zip(fleet.order, ranges, strict=True):
            first = int(its.argmin())
            if its[first] < self.closest.get(ship.name, (math.inf, 0))[0]:
                self.closest[ship.name] = float(its[first]), int(flown.ticks[first])
        last = int(ranges[:, -1].argmin())
        self.nearest = fleet.order[last].name, float(ranges[last, -1])
        poses = np.array([flown[name] for name in POSE_NAMES]).T[-len(self._past) :]
        self._past = [*self._past, *(Pose(*row) for row in poses.tolist())][-len(self._past) :]
        self._pose = self._past[-1]

    def step(self, contacts: Contacts, tick: int, before: Pose, now: Pose) -> list[Named]:
        """Keep each ship's least range in the step to a tick. Return new collisions by ship."""
        self.struck, self.nearest = "", ("", math.inf)
        fleet, hull, closest = contacts.fleet(tick - 1), self.hull, self.closest
        depth, struck = min(before.depth, now.depth), set()
        ways = zip(fleet.order, fleet.motions(tick - 1), fleet.motions(tick), strict=True)
        for ship, start, end in ways:
            apart, name = passing_range(start, end, before, now), ship.name
            if name not in closest or apart < closest[name][0]:
                closest[name] = apart, tick
            if apart < self.nearest[1]:
                self.nearest = name, apart
            if hull is None or hull.far(apart, depth, ship.body):
                continue
            if _meets(hull, ship, (before, now), (np.array(start[:3]), np.array(end[:3]))):
                struck.add(name)
        if not (struck or self.touching):
            return []
        # a collision is news once, until the hulls part
        new = struck - self.touching
        self.struck, self.touching = min(new, default=""), struck
        return [
            (name, f"COLLISION with {name}, a {fleet.ships[name].kind}") for name in sorted(new)
        ]

    def _calls(
        self, boat: Any, ships: Sequence[Ship], motions: Sequence[ShipMotion], now: Pose
    ) -> list[Named]:
        """Return each closest approach that is to be called now, by its ship."""
        rules, soon = self.rules, []
        own_north, own_east, turning = self._mean_motion(boat, now)
        speed, own = math.hypot(own_north, own_east), None
        recall = (1.0 + RECALL_CHANGE_SHARE) * rules.cpa_m
        over = []  # of the ships called, because only those can be news again
        for ship, motion in zip(ships, motions, strict=True):
            north, east = motion[0] - now[0], motion[1] - now[1]
            called = ship.name in self.called
            fastest = speed + motion.speed + abs(motion.set_north) + abs(motion.set_east)
            if math.hypot(north, east) > FAR_MARGIN * (recall + fastest * rules.warn_s):
                over += [ship.name] if called else []
                continue
            v_north, v_east = motion.velocity()
            v_north, v_east = v_north - own_north, v_east - own_east
            if north * v_north + east * v_east > 0.0:  # it goes away
                over += [ship.name] if called else []
                continue
            way = math.atan2(own_east, own_north), speed, turning
            own = own or OwnMotion(now.north, now.east, *way)
            closest, until = closest_approach(north, east, v_north, v_east)
            if leaves_lines(own, motion, until, rules.cpa_m):
                near = nears_on_arcs(own, motion, recall, rules.warn_s)
                closest, until = on_arcs(own, motion) if near else (math.inf, math.inf)
            ahead = 0.0 <= until < rules.warn_s
            if called and not (ahead and closest <= recall):
                over.append(ship.name)
            if ahead and closest < rules.cpa_m:
                soon.append((ship, plot_ship(own, motion, rules.cpa_m)))
        if self.clear_since or over:
            self._forget(over, boat.time)
        news = []
        for ship, plot in soon:
            # whether a closest approach [m] has not been called yet, or has changed
            before = self.called.get(ship.name)
            change = math.inf if before is None else abs(plot.closest - before)
            if change > RECALL_CHANGE_SHARE * rules.cpa_m:
                self.called[ship.name] = plot.closest
                news.append((ship.name, _call(ship, plot)))
        return news

    def _forget(self, over: list[str], time: float) -> None:
        """Let approaches be news again that have been over for long enough at a time [s]."""
        self.clear_since = {name: self.clear_since.get(name, time) for name in over}
        for name, since in self.clear_since.items():
            if time - since >= RECALL_CLEAR_S:
                self.called.pop(name, None)

    def _mean_motion(self, boat: Any, now: Pose) -> tuple[float, float, float]:
        """Return the boat's mean velocity north and east [m/s], and its mean turn [rad/s].

        They are those of the last MEAN_PERIOD_S, because waves swing the boat.
        """
        self._past.append(now)
        count = self.mean_ticks
        if boat.plain[HELD_OFFSET] or len(self._past) <= count:
            return *OwnMotion.of(boat.state).velocity(), 0.0
        first = self._past[-count - 1]
        del self._past[:-count]
        seconds = count * boat.method.step
        north, east = (now.north - first.north) / seconds, (now.east - first.east) / seconds
        turning = math.remainder(now.heading - first.heading, math.tau) / seconds
        return north, east, turning if abs(turning) >= MIN_TURN_RATE else 0.0

    def account(self) -> str:
        """Return the closest that each ship has been, in words."""
        ranges = sorted(self.closest.items(), key=lambda item: item[1])
        step = self.contacts.step if self.contacts else 1.0
        return ", ".join(f"{name} {m:.0f} m (at {tick * step:g} s)" for name, (m, tick) in ranges)


def _meets(
    hull: OwnHull, ship: Ship, poses: tuple[Pose, Pose], ends: tuple[Numbers, Numbers]
) -> bool:
    """Return whether the boat touches a ship between two poses, and two locations of the ship."""
    (before, now), (start, end) = poses, ends
    way = np.array(now[:3]) - np.array(before[:3])
    way[:2] -= end[:2] - start[:2]
    # in steps of a share of the ship's beam, so that no ship is jumped over
    looks = hull.looks(float(np.linalg.norm(way)), ship.body)
    for share in ((i + 1) / looks for i in range(looks)):
        location = (start + share * (end - start)).tolist()
        if hull.touches(before.towards(now, share), ship.body, *location):
            return True
    return False


def _call(ship: Ship, seen: ShipPlot) -> str:
    """Return the words of a closest approach foreseen."""
    minutes, seconds = divmod(round(seen.until), 60)
    time_text = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    bearing = round(math.degrees(seen.bearing)) % 360
    turning = ", turning" if seen.turning else ""
    return (
        f"CLOSEST APPROACH: {ship.name} {seen.closest:.0f} m in {time_text}{turning}; "
        f"now {bearing:03d} at {seen.range:.0f} m"
    )
