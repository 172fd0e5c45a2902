"""Episodes of a passage: casualties and answers, orders and repeats, ships met, groundings.

All from states and journal: a recording without orders to the crew has none to tell.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.grounding import AFLOAT, AGROUND, LAID, Touch, lies_well, touch_of
from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.hulls import OwnHull, Pose
from trainer.boat.world.scope import Periscope, periscope_of
from trainer.config.bottom import Bottom
from trainer.config.casualties import Casualty
from trainer.config.files import ConfigError
from trainer.config.score_rules import COURSE, INSTRUCTING
from trainer.core.casualties import KINDS
from trainer.core.kernel import Numbers
from trainer.core.surfaces import SURFACES
from trainer.debrief.trajectory import (
    AMOUNTS,
    CREW_ORDERS,
    SLOTS,
    Rows,
    Trajectory,
    eye_heights,
    stretches,
)
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Journalled
from trainer.units import KNOT

SCHEDULE: Final = "schedule"  # who gives the orders of the exercise
INSTRUCTOR: Final = "instructor"
KEPT: Final = {  # [SI] off an order within which it is kept
    "depth": 3.0,
    COURSE: math.radians(3.0),
    "speed": 0.5 * KNOT,
    "pitch": math.radians(2.0),
}
MOVED: Final = np.radians(2.0)  # [rad] by which a surface has been deflected


@dataclass(frozen=True)
class Episode:
    """One casualty, from the tick at which it began to the tick of its end."""

    kind: str
    begun: int  # [tick]
    ended: int | None  # [tick] None: it lasted to the end
    amount: float  # [SI] of its kind, the largest either way


@dataclass(frozen=True)
class Deflection:
    """The first surface to have moved during a casualty."""

    surface: str
    tick: int


def spells(trajectory: Trajectory) -> tuple[Episode, ...]:
    """Return the casualties in the order in which they began. ConfigError if one is unheard of."""
    slots = np.array([trajectory.columns[name] for name in SLOTS])
    known = np.isin(slots, range(len(KINDS) + 1))
    if not known.all():
        raise ConfigError(f"recording: casualty {slots[~known][0]:g}: is none; it is damaged")
    amounts = np.array([trajectory.columns[name] for name in AMOUNTS])
    found = [
        episode
        for code in sorted({int(code) for code in np.unique(slots)} - {0})
        for episode in _of_kind(trajectory, slots == code, amounts, KINDS[code - 1])
    ]
    return tuple(sorted(found, key=lambda episode: episode.begun))


def first_spell(trajectory: Trajectory, casualty: Casualty | None) -> Episode | None:
    """Return the first time that a casualty came, None if it did not."""
    kind = casualty.kind if casualty else ""
    return next((each for each in spells(trajectory) if each.kind == kind), None)


def _of_kind(
    trajectory: Trajectory, there: np.ndarray, amounts: np.ndarray, kind: str
) -> list[Episode]:
    """Return the spells of one kind, whose slots are those ``there``."""
    active = np.any(there, axis=0)
    found = []
    for first, after in stretches(active):
        held = np.where(there, amounts, 0.0)[:, first:after]
        amount = float(held.ravel()[np.argmax(np.abs(held))])
        lasted = after == trajectory.ticks.size
        # a state shows what acted in the tick that led to it
        begun = max(int(trajectory.ticks[first]) - 1, 0)
        found.append(Episode(kind, begun, None if lasted else int(trajectory.ticks[after]), amount))
    return found


def crew_orders(trajectory: Trajectory) -> tuple[Journalled, ...]:
    """Return what the crew ordered and the boat accepted.

    The crew is everybody but schedule and instructor; when nobody else has ordered anything the
    instructor is alone on board, and is the crew.
    """
    given = [
        each for each in trajectory.orders if each.who != SCHEDULE and each.accepted is not False
    ]
    stations = [each for each in given if not each.who.startswith(INSTRUCTOR)]
    return tuple(each for each in stations or given if name_of(each) not in INSTRUCTING)


def name_of(entry: Journalled) -> str:
    """Return the order's name in the grammar, '' if this version does not know it."""
    order = parse(entry.text)
    return order.name if isinstance(order, Order) else ""


def answer_to(
    trajectory: Trajectory, episode: Episode, names: tuple[str, ...] | None = None
) -> Journalled | None:
    """Return the crew's first order after a casualty began, of ``names`` if given."""
    caused = [
        each.id
        for each in trajectory.orders
        if each.tick == episode.begun and name_of(each) == "casualty"
    ]
    for each in crew_orders(trajectory):
        # at the tick itself only what was ordered after the casualty, in a freeze
        later = each.tick > episode.begun
        later = later or (each.tick == episode.begun and bool(caused) and each.id > caused[-1])
        if later and (names is None or name_of(each) in names):
            return each
    return None


def deflection(trajectory: Trajectory, episode: Episode) -> Deflection | None:
    """Return the first surface that moved by MOVED since it began, except the failed one."""
    start = trajectory.row(episode.begun)
    first: list[Deflection] = []
    for surface in SURFACES:
        if episode.kind.startswith(surface) or not trajectory.has(surface):
            continue
        angle = trajectory.series(surface)[start:]
        moved = np.flatnonzero(np.abs(angle - angle[0]) >= MOVED)
        if moved.size:
            first.append(Deflection(surface, int(trajectory.ticks[start + moved[0]])))
    return min(first, key=lambda each: each.tick, default=None)


# Orders to the crew


ORDERED: Final = "ordered: "  # begins the answer to an order to the crew
AYE: Final = " aye"  # ends that to a repeat
TELL: Final = "tell "  # began it in recordings of before
WRONG: Final = "WRONG REPEAT: "
WORDS: Final = "words"  # the axis of an order in words


@dataclass(frozen=True)
class ReadBack:
    """One order to the crew, and what came of it."""

    order: Journalled
    axis: str
    told: str  # as the crew was told
    repeated: Journalled | None = None
    wrong: tuple[str, ...] = ()  # words of wrong repeats
    carried_out: int | None = None  # [tick] from which it was kept until the next


def read_backs(trajectory: Trajectory) -> tuple[ReadBack, ...]:
    """Return a run's orders to the crew, with their repeats and their ends."""
    found: list[ReadBack] = []
    for entry in trajectory.orders:
        order = parse(entry.text)
        if not isinstance(order, Order) or entry.accepted is False:
            continue
        if order.name in ("order", "tell"):
            found += _ordered(entry, order)
        elif order.name == "aye":
            _repeat(found, entry)
    return tuple(_carried_out(found, trajectory))


def _ordered(entry: Journalled, order: Order) -> Iterator[ReadBack]:
    """Yield what an order to the crew begins; nothing where it ends one."""
    if order.name == "tell":
        yield ReadBack(entry, WORDS, order.subject)
    elif entry.answer.startswith(ORDERED) or not order.word.startswith("clear"):
        axis = order.word.partition("_")[0].replace("periscope", "depth")
        yield ReadBack(entry, axis, entry.answer.removeprefix(ORDERED) or entry.text)


def _repeat(found: list[ReadBack], entry: Journalled) -> None:
    """Note a repeat, right or wrong, with the newest order that it is about."""
    wrong = entry.answer.startswith(WRONG)
    said, _, meant = entry.answer.removeprefix(WRONG).partition("; ordered is ")
    told = meant if wrong else entry.answer.removesuffix(AYE)
    for i in range(len(found) - 1, -1, -1):
        if found[i].told == told.removeprefix(TELL) and found[i].repeated is None:
            changed = {"wrong": (*found[i].wrong, said)} if wrong else {"repeated": entry}
            found[i] = replace(found[i], **changed)
            return


def _carried_out(found: list[ReadBack], trajectory: Trajectory) -> Iterator[ReadBack]:
    """Yield the orders with the tick from which each was kept until the next of its axis."""
    for i, each in enumerate(found):
        later = (other.order.tick for other in found[i + 1 :] if other.axis == each.axis)
        end = next(later, int(trajectory.ticks[-1]))
        known = each.axis in CREW_ORDERS and trajectory.has(each.axis)
        yield replace(each, carried_out=_kept_from(each, end, trajectory) if known else None)


def _kept_from(each: ReadBack, end: int, trajectory: Trajectory) -> int | None:
    """Return the first tick from which an order is kept, None if it is not at the end."""
    rows = (trajectory.ticks > each.order.tick) & (trajectory.ticks <= end)
    if not rows.any():
        return None
    off = trajectory.series(each.axis)[rows] - trajectory.ordered(each.axis)[rows][0]
    if each.axis == COURSE:
        off = (off + math.pi) % math.tau - math.pi
    beyond = np.flatnonzero(~(np.abs(off) <= KEPT[each.axis]))
    first = int(beyond[-1]) + 1 if beyond.size else 0
    ticks = trajectory.ticks[rows]
    return int(ticks[first]) if first < ticks.size else None


# The ships that a run met: how near each came, and collisions.


WAYS: Final = 400  # rows at which the ways of ships are looked at
POSE: Final = ("x", "y", "z", "phi", "theta", "psi")
MARKED: Final = re.compile(r"contact\b.*?(\d{1,3}(?:\.\d+)?)\s*", re.IGNORECASE)
AIMED: Final = math.radians(3.0)  # [rad] between a mark's bearing and the ship's
LOOKOUT: Final = "scope"  # the role whose marks of ships count
LOOK: Final = 10.0  # [s] from look to look, for what a raised mast would have shown
MISSED: Final = 120.0  # [s] that a ship would have been in sight for, to be missed


@dataclass(frozen=True)
class Met:
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
    """Return the ways of all ships of a passage, at some WAYS rows each."""
    contacts = contacts_in(trajectory.boat)
    every = max(trajectory.ticks.size // WAYS, 1)
    found: dict[str, list[tuple[float, ...]]] = {}
    for row in range(0, trajectory.ticks.size, every):
        for ship in contacts.seen(int(trajectory.ticks[row])) if contacts else ():
            found.setdefault(ship.name, []).append((row, ship.north, ship.east))
    ways = []
    for name, places in found.items():
        rows, north, east = np.array(places).T
        whole = rows.astype(np.int64)
        ways.append(ShipWay(name, whole, trajectory.seconds[whole], north, east))
    return ways


def place_of_ship(trajectory: Trajectory, name: str, tick: int) -> tuple[float, float] | None:
    """Return where a ship was at a tick, north and east [m]. None: it was not there."""
    contacts = contacts_in(trajectory.boat)
    ships = contacts.seen(tick) if contacts else ()
    return next(((each.north, each.east) for each in ships if each.name == name), None)


def meet(trajectory: Trajectory) -> Met:
    """Return the ships that were met on a passage."""
    contacts = contacts_in(trajectory.boat)
    nearest = np.full(trajectory.ticks.size, np.inf)
    if contacts is None or not contacts.any:
        return Met(nearest)
    monitor = EncounterMonitor(contacts, OwnHull.of(trajectory.boat))
    rows = zip(*(trajectory.columns[name].tolist() for name in POSE), strict=True)
    poses = [Pose(*row) for row in rows]
    collisions = []
    for row in range(1, len(poses)):
        tick = int(trajectory.ticks[row])
        monitor.step(contacts, tick, poses[row - 1], poses[row])
        nearest[row] = monitor.nearest[1]
        if monitor.struck:
            collisions.append((tick, monitor.struck))
    return Met(nearest, monitor.closest, tuple(collisions), contacts.encounters.collision)


@dataclass(frozen=True)
class Detection:
    """A ship, and when it was in sight and was marked.

    It was in sight, or would have been of a mast that is up.
    """

    name: str
    there: int  # tick from which a mast that is up shows it
    seen: int | None  # tick at which it came in sight; None: nobody looked
    marked: int | None


@dataclass(frozen=True)
class LookOut:
    """The ships of a look-out, and the ticks of marks that meant none."""

    ships: tuple[Detection, ...] = ()
    false: tuple[int, ...] = ()


def shown(trajectory: Trajectory) -> tuple[Rows, Numbers]:
    """Return at which ticks the head was out of the water, and at which raise."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return np.zeros(trajectory.ticks.size, bool), np.zeros(trajectory.ticks.size)
    stood = [scope.at(tick) for tick in trajectory.ticks.tolist()]
    out = np.array([mast.out > 0.0 for mast in stood])
    return out & (eye_heights(trajectory) > 0.0), np.array([float(mast.raised) for mast in stood])


def look_out(trajectory: Trajectory) -> LookOut:
    """Return the ships in sight, or that could have been for MISSED, with marks."""
    scope = periscope_of(trajectory.boat)
    if scope is None:
        return LookOut()
    rows = np.flatnonzero(shown(trajectory)[0]).tolist()
    seen: dict[str, int] = {}
    for row, name in _sights(trajectory, scope, rows, eye_heights(trajectory), up=False):
        seen.setdefault(name, int(trajectory.ticks[row]))
    there = {**_could_be_seen(trajectory, scope), **seen}
    marks, false = _marks(trajectory, scope, seen)
    ships = (Detection(name, at, seen.get(name), marks.get(name)) for name, at in there.items())
    return LookOut(tuple(sorted(ships, key=lambda each: each.there)), false)


def _could_be_seen(trajectory: Trajectory, scope: Periscope) -> dict[str, int]:
    """Return the ships that a raised mast shows for MISSED, with the tick at which that began."""
    every = max(round(LOOK / trajectory.boat.method.step), 1)
    rows = list(range(0, trajectory.ticks.size, every))
    found: dict[str, list[int]] = {}
    for row, name in _sights(trajectory, scope, rows, eye_heights(trajectory, up=True), up=True):
        found.setdefault(name, []).append(int(trajectory.ticks[row]))
    return {name: ticks[0] for name, ticks in found.items() if len(ticks) * LOOK >= MISSED}


def _sights(
    trajectory: Trajectory, scope: Periscope, rows: list[int], heights: Numbers, *, up: bool
) -> Iterator[tuple[int, str]]:
    """Yield each row with the name of each ship in sight then. ``up``: of a mast all out."""
    for row in rows:
        mast = scope.at(int(trajectory.ticks[row]))
        mast = scope.raised(mast) if up else mast
        eye = scope.place(state_of(trajectory, row), mast, float(heights[row]))
        yield from ((row, sight.name) for sight in scope.sights(eye, mast))


def state_of(trajectory: Trajectory, row: int) -> dict[str, float]:
    """Return place and attitude at a row, by their names in the core."""
    return {name: float(trajectory.columns[name][row]) for name in ("x", "y", "psi", "theta")}


def _marks(
    trajectory: Trajectory, scope: Periscope, seen: Mapping[str, int]
) -> tuple[dict[str, int], tuple[int, ...]]:
    """Return the tick of each ship's first mark, and those of marks that mean no ship seen."""
    marks: dict[str, int] = {}
    false = []
    for tick, bearing in _bearings_marked(trajectory):
        state = state_of(trajectory, trajectory.row(tick))
        off = {
            name: abs(math.remainder(true - bearing, math.tau))
            for name, true in scope.near(state, tick)
            if seen.get(name, math.inf) <= tick
        }
        nearest = min(off, key=lambda name: off[name], default="")
        if off.get(nearest, math.inf) <= AIMED:
            marks.setdefault(nearest, tick)
        else:
            false.append(tick)
    return marks, tuple(false)


def _bearings_marked(trajectory: Trajectory) -> Iterator[tuple[int, float]]:
    """Yield tick and bearing [rad] of each ship that the crew has marked.

    Marks are the periscope's; the instructor's count where nobody else has made any.
    """
    said = [(each, MARKED.match(each.text)) for each in trajectory.marks]
    crew = [(mark, found) for mark, found in said if mark.who.startswith(LOOKOUT)]
    for mark, found in crew or said:
        if found:
            yield mark.tick, math.radians(float(found[1]))


# The groundings of a passage: when, how hard, and whether they were meant.


class Grounding(NamedTuple):
    """One time that the ground carried the boat."""

    row: int  # at which it was aground
    touch: Touch
    hard: bool
    at_fault: bool  # it was not meant, or not done well


def groundings(trajectory: Trajectory) -> list[Grounding]:
    """Return the groundings of a passage. Touching it again soon after is the same one."""
    bottom = ground_under(trajectory.boat)
    if bottom is None:
        return []
    return [_grounding(trajectory, bottom, row) for row in _rows(trajectory)]


def _rows(trajectory: Trajectory) -> Iterator[int]:
    """Yield the rows at which the boat is aground, having been off the ground for a while."""
    ticks, seconds = trajectory.columns["aground"], trajectory.seconds
    last = -np.inf
    for row in np.flatnonzero(ticks >= AGROUND):
        if row and seconds[row] - last > AFLOAT:
            yield int(row)
        last = seconds[row]


def _grounding(trajectory: Trajectory, bottom: Bottom, row: int) -> Grounding:
    columns = trajectory.columns
    before = max(row - int(columns["aground"][row]), 0)
    touch = touch_of(lambda name: float(columns[name][before]), float(trajectory.boat.vessel.ell))
    hard = touch.is_hard(bottom.kind)
    well = bottom.bottoming and not hard and not touch.faults and _lies(trajectory, row)
    return Grounding(row, touch, hard, not well)


def _lies(trajectory: Trajectory, row: int) -> bool:
    """Return whether a boat comes to lie as it should, in time."""
    soon = np.flatnonzero(trajectory.seconds <= trajectory.seconds[row] + LAID)
    tonnes = trajectory.columns["bottom_load"] / float(trajectory.boat.vessel.g) / 1000.0
    screw = trajectory.columns["u_c"]
    return any(lies_well(float(tonnes[i]), float(screw[i])) for i in soon if i >= row)
