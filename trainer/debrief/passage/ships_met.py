"""The ships that a run met: how near each came, and collisions.

A recording holds the boat's states and no ship, so the ships are moved again by the functions of
the run, which gives the same locations. Measures, marks, charts and
tables ask here. A passage is what was flown to the end of a branch of a recording (``trajectory``).
"""

import functools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.contacts import Contacts, contacts_in
from trainer.boat.world.encounters import collisions_in, passed_ships
from trainer.boat.world.hulls import POSE_NAMES, OwnHull
from trainer.boat.world.scope import OPTICS_SHOWING_M, Periscope, periscope_of
from trainer.config.exercise.reference_crew import REPORT_ORDER
from trainer.core.kernel import Numbers
from trainer.debrief.passage.episodes import INSTRUCTOR_ROLE
from trainer.debrief.passage.trajectory import RowMask, Trajectory, eye_heights
from trainer.io.recording.recording import RecordedEvent, RecordedOrder

WAY_ROWS: Final = 400  # rows at which the ways of ships are looked at


BEARING_MARK: Final = re.compile(r"contact\b.*?(\d{1,3}(?:\.\d+)?)\s*", re.IGNORECASE)


BEARING_TOLERANCE_RAD: Final = math.radians(3.0)  # [rad] between a mark's bearing and the ship's


CONTACT_REPORT: Final = re.compile(r"\bcontacts?\b", re.IGNORECASE)


# "no close contacts", but not "contact 045, no others"
NO_CONTACT_REPORT: Final = re.compile(r"\D*\b(no|none)\b\D*", re.IGNORECASE)


LOOKOUT_ROLE: Final = "scope"  # the role whose marks of ships count


LOOK_PERIOD_S: Final = 10.0  # [s] from look to look, for what a raised mast would have shown


MISSED_SIGHT_S: Final = 120.0  # [s] that a ship would have been in sight for, to be missed


MISSED_LOOKS: Final = math.ceil(MISSED_SIGHT_S / LOOK_PERIOD_S)


# tick and bearing [rad] of a mark, and the true bearing [rad] of each ship near
BearingMark = tuple[int, float, Sequence[tuple[str, float]]]


@dataclass(frozen=True)
class ShipEncounters:
    """Every ship's closest approach, and the nearest ship's range at each tick."""

    nearest: Numbers  # [m] in the step to each tick, infinity without ships
    closest: dict[str, tuple[float, int]] = field(default_factory=dict)  # [m] and tick, by name
    collisions: tuple[tuple[int, str], ...] = ()  # ticks and names
    collision: str = "call"  # what the exercise has one do


@dataclass(frozen=True)
class ShipWay:
    """The way of a ship [m], at rows of the passage and their times [s]."""

    name: str
    rows: NDArray[np.int64]
    seconds: Numbers
    north: Numbers
    east: Numbers


def ways_of_ships(trajectory: Trajectory) -> list[ShipWay]:
    """Return the ways of all ships of a passage, at some WAY_ROWS rows each."""
    contacts = contacts_in(trajectory.boat)
    every = max(trajectory.ticks.size // WAY_ROWS, 1)
    ship_rows: dict[str, list[tuple[float, ...]]] = {}
    for row in range(0, trajectory.ticks.size, every):
        for ship in contacts.seen(int(trajectory.ticks[row])) if contacts else ():
            ship_rows.setdefault(ship.name, []).append((row, ship.north, ship.east))
    ways = []
    for name, seen in ship_rows.items():
        rows, north, east = np.array(seen).T
        whole = rows.astype(np.int64)
        ways.append(ShipWay(name, whole, trajectory.seconds[whole], north, east))
    return ways


def locate_ship(trajectory: Trajectory, name: str, tick: int) -> tuple[float, float] | None:
    """Return where a ship was at a tick, north and east [m]. None: it was not there."""
    contacts = contacts_in(trajectory.boat)
    ships = contacts.seen(tick) if contacts else ()
    return next(((each.north, each.east) for each in ships if each.name == name), None)


def meet_ships(trajectory: Trajectory) -> ShipEncounters:
    """Return the ships that were met on a passage."""
    contacts = contacts_in(trajectory.boat)
    nearest = np.full(trajectory.ticks.size, np.inf)
    if contacts is None or not contacts.any:
        return ShipEncounters(nearest)
    ticks, poses = trajectory.ticks, np.array([trajectory.columns[name] for name in POSE_NAMES])
    passed = list(passed_ships(contacts, ticks, poses))
    closest: dict[str, tuple[float, int]] = {}
    for ship, rows, ranges, *_ in passed:
        nearest[rows] = np.minimum(nearest[rows], ranges)
        index = int(ranges.argmin())
        least = float(ranges[index]), int(ticks[rows[index]])
        closest[ship.name] = min(least, closest.get(ship.name, least))
    struck = collisions_in(passed, OwnHull.of(trajectory.boat), poses)
    collisions = tuple((int(ticks[row]), name) for row, name in struck)
    return ShipEncounters(nearest, closest, collisions, contacts.encounters.collision)


@dataclass(frozen=True)
class Detection:
    """A ship, and when it was in sight and was marked.

    A ship that a raised mast would have shown counts too, because nobody looked.
    """

    name: str
    there: int  # tick from which a mast that is up shows it
    seen: int | None  # tick at which it came in sight; None: nobody looked
    marked: int | None


@dataclass(frozen=True)
class LookOut:
    """The ships that a look-out saw or missed, and ticks of marks without a ship."""

    ships: tuple[Detection, ...] = ()
    false: tuple[int, ...] = ()


def shown_rows(trajectory: Trajectory) -> tuple[RowMask, Numbers]:
    """Return at which ticks the periscope's head was out, and in which raise."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return np.zeros(trajectory.ticks.size, bool), np.zeros(trajectory.ticks.size)
    out, raised = scope.over(trajectory.ticks)
    return (out > 0.0) & (eye_heights(trajectory) > 0.0), raised


def look_out(trajectory: Trajectory) -> LookOut:
    """Return the ships seen, and those missed for MISSED_SIGHT_S, with their marks."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return LookOut()
    out = scope.over(trajectory.ticks)[0] >= OPTICS_SHOWING_M
    rows = np.flatnonzero(shown_rows(trajectory)[0] & out)
    sights = _sights(trajectory, scope, rows, eye_heights(trajectory))
    seen = {name: ticks[0] for name, ticks in sights.items()}
    near = [
        (tick, bearing, scope.near(state_of(trajectory, trajectory.row(tick)), tick))
        for _, tick, bearing in bearings_marked(trajectory.marks)
    ]
    return judge_look_out(_could_be_seen(trajectory, scope), seen, near)


def judge_look_out(
    chances: Mapping[str, int], seen: Mapping[str, int], marked: Iterable[BearingMark]
) -> LookOut:
    """Return what a look-out saw, missed and marked.

    ``chances`` and ``seen`` have the ticks from which a ship could be seen, and was, by its name.
    """
    marks, false = _marks(marked, seen)
    ships = (
        Detection(name, at, seen.get(name), marks.get(name))
        for name, at in {**chances, **seen}.items()
    )
    return LookOut(tuple(sorted(ships, key=lambda each: each.there)), false)


def _could_be_seen(trajectory: Trajectory, scope: Periscope) -> dict[str, int]:
    """Return the ships that a raised mast would have shown for MISSED_SIGHT_S, by first tick."""
    rows = np.arange(0, trajectory.ticks.size, look_period(trajectory.boat.method.step))
    sights = _sights(trajectory, scope, rows, eye_heights(trajectory, up=True))
    return {name: ticks[0] for name, ticks in sights.items() if len(ticks) >= MISSED_LOOKS}


def look_period(step: float) -> int:
    """Return the ticks from look to look, of ``step`` [s] each."""
    return max(round(LOOK_PERIOD_S / step), 1)


def _sights(
    trajectory: Trajectory, scope: Periscope, rows: NDArray[np.int64], heights: Numbers
) -> dict[str, list[int]]:
    """Return the ticks, among some rows, at which each ship is in sight, by its name.

    What is seen first comes first, and at one tick the nearest.
    """
    contacts = contacts_in(trajectory.boat)
    sights: dict[str, list[tuple[int, float]]] = {}
    ticks = trajectory.ticks[rows]
    for indices, fleet in contacts.stretches(ticks) if contacts else ():
        chosen = rows[indices]
        column = functools.partial(_column_at, trajectory, chosen)
        ranges = scope.distances_in_sight(fleet, ticks[indices], column, heights[chosen])
        for ship, its in zip(fleet.order, ranges, strict=True):
            there = np.flatnonzero(np.isfinite(its))
            pairs = zip(ticks[indices][there].tolist(), its[there].tolist(), strict=True)
            sights.setdefault(ship.name, []).extend(pairs)
    found = sorted((pairs[0], name) for name, pairs in sights.items() if pairs)
    return {name: [tick for tick, _ in sights[name]] for _, name in found}


def _column_at(trajectory: Trajectory, rows: NDArray[np.int64], name: str) -> Numbers:
    """Return a field of the state at some rows."""
    return trajectory.columns[name][rows]


def state_of(trajectory: Trajectory, row: int) -> dict[str, float]:
    """Return location and attitude at a row, by their names in the core."""
    return {name: float(trajectory.columns[name][row]) for name in ("x", "y", "psi", "theta")}


class ContactReport(NamedTuple):
    """What a crew reported of ships near."""

    tick: int
    none: bool  # that none is close


def contact_reports(orders: Iterable[RecordedOrder]) -> list[ContactReport]:
    """Return the reports of contacts among a run's orders.

    They are the crew's. If it made none, those of the instructor count, who is alone aboard.
    """
    said = [
        (order.giver.role, ContactReport(order.tick, bool(NO_CONTACT_REPORT.fullmatch(order.text))))
        for order in orders
        if order.name == REPORT_ORDER
        and order.accepted is not False
        and CONTACT_REPORT.search(order.text)
    ]
    crew = [report for role, report in said if role != INSTRUCTOR_ROLE]
    return crew or [report for _, report in said]


def reports_near_ships(trajectory: Trajectory) -> list[tuple[ContactReport, bool]]:
    """Return the reports of contacts of a run, each with whether a ship was close."""
    contacts, column = contacts_in(trajectory.boat), trajectory.columns
    reports = contact_reports(trajectory.orders)
    rows = [trajectory.row(each.tick) for each in reports]
    return [
        (each, is_ship_close(contacts, each.tick, column["x"][row], column["y"][row]))
        for each, row in zip(reports, rows, strict=True)
    ]


def is_ship_close(contacts: Contacts | None, tick: int, north: float, east: float) -> bool:
    """Return whether a ship was within ``cpa_m`` of a place [m] at a tick."""
    if contacts is None:
        return False
    now = contacts.at(tick)
    ranges = np.hypot(now.north - north, now.east - east)
    return bool((ranges <= contacts.encounters.cpa_m).any())


def _marks(
    marked: Iterable[BearingMark], seen: Mapping[str, int]
) -> tuple[dict[str, int], tuple[int, ...]]:
    """Return the tick of each ship's first mark, and those of marks that mean no ship seen."""
    marks: dict[str, int] = {}
    false = []
    for tick, bearing, near in marked:
        off = {
            name: abs(math.remainder(true - bearing, math.tau))
            for name, true in near
            if seen.get(name, math.inf) <= tick
        }
        nearest = min(off, key=lambda name: off[name], default="")
        if off.get(nearest, math.inf) <= BEARING_TOLERANCE_RAD:
            marks.setdefault(nearest, tick)
        else:
            false.append(tick)
    return marks, tuple(false)


def bearings_marked(
    marks: Sequence[RecordedEvent],
) -> Iterator[tuple[RecordedEvent, int, float]]:
    """Yield each mark of a ship by the crew, its tick and its bearing [rad].

    The marks are those of the periscope's station. If it made none, all other marks count.
    """
    said = [(each, BEARING_MARK.match(each.text)) for each in marks]
    crew = [(mark, found) for mark, found in said if mark.role == LOOKOUT_ROLE]
    for mark, match in crew or said:
        if match:
            yield mark, mark.tick, math.radians(float(match[1]))
