"""Episodes of a passage: casualties and answers, orders and repeats, ships met, groundings.

A passage is what was flown to the end of a branch of a recording (``trajectory``). Measures, tables
and figures ask here. All from states and journal: a recording without orders to the crew has none
to tell.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Final

import numpy as np

from trainer.boat.casualties import kind_row
from trainer.config.boat.casualties import Casualty
from trainer.config.exercise.exercise import AIDS
from trainer.config.exercise.score_rules import ANSWER_ORDERS, COURSE_QUANTITY, HINT_ORDER
from trainer.config.files import ConfigError
from trainer.core.casualties import KINDS
from trainer.core.surfaces import SURFACES
from trainer.debrief.passage.controls import is_wrong_way
from trainer.debrief.passage.trajectory import (
    CASUALTY_AMOUNTS,
    CASUALTY_SLOTS,
    CREW_ORDERS,
    Trajectory,
    row_stretches,
)
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import CrewNews, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.report.svg import clock
from trainer.units import KNOT

INSTRUCTOR_ROLE: Final = "instructor"
KEPT_TOLERANCES: Final = {  # [SI] off an order within which it is kept
    "depth": 3.0,
    COURSE_QUANTITY: math.radians(3.0),
    "speed": 0.5 * KNOT,
    "pitch": math.radians(2.0),
}
MIN_DEFLECTION_RAD: Final = np.radians(2.0)  # [rad] by which a surface has been deflected
TAKEN_BACK_S: Final = 20.0  # [s] for which an answer has to stand; an estimate
WORDS_AXIS: Final = "words"  # the axis of an order in words


@dataclass(frozen=True)
class Episode:
    """One casualty, from the tick at which it began to the tick of its end."""

    kind: str
    begun: int  # [tick]
    ended: int | None  # [tick] None: it lasted to the end
    amount: float  # [SI] of its kind, the largest either way


@dataclass(frozen=True)
class Deflection:
    """The first surface that moved during a casualty."""

    surface: str
    tick: int


def casualty_episodes(trajectory: Trajectory) -> tuple[Episode, ...]:
    """Return the casualties in the order in which they began; ConfigError for an unknown one."""
    slots = np.array([trajectory.columns[name] for name in CASUALTY_SLOTS])
    codes = dict.fromkeys(slots[slots != 0.0].tolist())
    if unknown := [code for code in codes if code not in range(1, len(KINDS) + 1)]:
        raise ConfigError(f"recording: casualty {unknown[0]:g}: is none; it is damaged")
    amounts = np.array([trajectory.columns[name] for name in CASUALTY_AMOUNTS])
    episodes = [
        episode
        for code in sorted(map(int, codes))
        for episode in _of_kind(trajectory, slots == code, amounts, KINDS[code - 1])
    ]
    return tuple(sorted(episodes, key=lambda episode: episode.begun))


def first_spell(trajectory: Trajectory, casualty: Casualty | None) -> Episode | None:
    """Return the first time that a casualty came, None if it did not."""
    kind = casualty.kind if casualty else ""
    return next((each for each in casualty_episodes(trajectory) if each.kind == kind), None)


def _of_kind(
    trajectory: Trajectory, there: np.ndarray, amounts: np.ndarray, kind: str
) -> list[Episode]:
    """Return the spells of one kind, whose slots are those ``there``."""
    active = np.any(there, axis=0)
    episodes = []
    for first, after in row_stretches(active):
        held = np.where(there, amounts, 0.0)[:, first:after]
        amount = float(held.ravel()[np.argmax(np.abs(held))])
        lasted = after == trajectory.ticks.size
        # a state shows what acted in the tick that led to it
        begun = max(int(trajectory.ticks[first]) - 1, 0)
        episodes.append(
            Episode(kind, begun, None if lasted else int(trajectory.ticks[after]), amount)
        )
    return episodes


def crew_orders(trajectory: Trajectory) -> tuple[RecordedOrder, ...]:
    """Return what the crew ordered and the boat accepted.

    The crew is everybody but schedule and instructor. If nobody else has ordered anything, the
    instructor counts as the crew, because he is alone on board.
    """
    orders = [
        entry
        for entry in trajectory.orders
        if entry.giver.kind is not GiverKind.SCHEDULE and entry.accepted is not False
    ]
    stations = [each for each in orders if each.giver.role != INSTRUCTOR_ROLE]
    return tuple(each for each in stations or orders if each.name in ANSWER_ORDERS)


def hints_told(trajectory: Trajectory) -> tuple[RecordedOrder, ...]:
    """Return the hints that a run was told, each with its answer."""
    orders = (each for each in trajectory.orders if each.accepted is not False)
    return tuple(each for each in orders if each.name == HINT_ORDER)


def aids_used(trajectory: Trajectory) -> tuple[str, ...]:
    """Return the aids that were switched on in a run, and how many hints came."""
    orders = (parse(each.text) for each in trajectory.orders if each.accepted is not False)
    switched = {each.name for each in orders if isinstance(each, Order) and each.word != "off"}
    count = len(hints_told(trajectory))
    hints = (f"{count} hint{'s' if count > 1 else ''}",) if count else ()
    return (*(aid for aid in AIDS if aid in switched), *hints, *looks_as_instructor(trajectory))


def looks_as_instructor(trajectory: Trajectory) -> tuple[str, ...]:
    """Return since when, or until when, who trains alone saw what is hidden."""
    for entry in trajectory.orders:
        order = parse(entry.text)
        if not isinstance(order, Order) or order.name != "role" or entry.accepted is False:
            continue
        when = clock(entry.tick * trajectory.boat.method.step)
        if order.word == INSTRUCTOR_ROLE:
            return (f"a look as instructor from {when}",)
        if entry.giver.role == INSTRUCTOR_ROLE:
            return (f"a look as instructor until {when}",)
    return ()


def answer_to(
    trajectory: Trajectory, episode: Episode, names: tuple[str, ...] | None = None
) -> RecordedOrder | None:
    """Return the crew's first order after a casualty began, of ``names`` if given.

    An order that the crew turns round within TAKEN_BACK_S answers nothing.
    """
    caused = [
        order.id
        for order in trajectory.orders
        if order.tick == episode.begun and order.name == "casualty"
    ]
    orders = crew_orders(trajectory)
    for i, order in enumerate(orders):
        # at the tick itself only what was ordered after the casualty, in a freeze
        later = order.tick > episode.begun
        later = later or (order.tick == episode.begun and bool(caused) and order.id > caused[-1])
        named = later and (names is None or order.name in names)
        if named and not _is_taken_back(order, orders[i + 1 :], trajectory):
            return order
    return None


def _is_taken_back(
    order: RecordedOrder, later: Iterable[RecordedOrder], trajectory: Trajectory
) -> bool:
    """Return whether one of the later orders soon turns an order round."""
    last = order.tick + TAKEN_BACK_S / trajectory.boat.method.step + 1e-9
    return any(
        is_wrong_way(each.text, order.text)
        for each in takewhile(lambda each: each.tick <= last, later)
    )


def first_deflection(trajectory: Trajectory, episode: Episode) -> Deflection | None:
    """Return the first surface that moved since it began, except the failed one."""
    start = trajectory.row(episode.begun)
    first: list[Deflection] = []
    for surface in SURFACES:
        if kind_row(episode.kind).equipment == surface or not trajectory.has(surface):
            continue
        angle = trajectory.series(surface)[start:]
        moved = np.flatnonzero(np.abs(angle - angle[0]) >= MIN_DEFLECTION_RAD)
        if moved.size:
            first.append(Deflection(surface, int(trajectory.ticks[start + moved[0]])))
    return min(first, key=lambda each: each.tick, default=None)


# Orders to the crew

HANDS_BY_AXIS: Final = {"course": "helmsman", "depth": "planesman", "pitch": "planesman"}


def axis_of(order: Order) -> str:
    """Return the axis of an order to the crew."""
    axis = WORDS_AXIS if order.name == "tell" else order.word.partition("_")[0]
    return axis.replace("periscope", "depth")


def ordered_beyond(orders: Iterable[RecordedOrder]) -> tuple[RecordedOrder, ...]:
    """Return the instructor's orders to the crew that ask for something else than the exercise."""
    changed = (entry for axis, entry in changed_orders(orders) if axis in CREW_ORDERS)
    return tuple(entry for entry in changed if entry.giver.role == INSTRUCTOR_ROLE)


def changed_orders(orders: Iterable[RecordedOrder]) -> Iterator[tuple[str, RecordedOrder]]:
    """Yield the orders to the crew that differ from what stands, each with its axis."""
    stands: dict[str, str] = {}
    for entry in orders:
        order = parse(entry.text)
        if entry.crew.news is not CrewNews.ORDERED or not isinstance(order, Order):
            continue
        axis = axis_of(order)
        if entry.crew.order != stands.get(axis):
            yield axis, entry
        stands[axis] = entry.crew.order


@dataclass(frozen=True)
class ReadBack:
    """One order to the crew, its repeats, and when it was carried out."""

    order: RecordedOrder
    axis: str
    told: str  # as the crew was told
    repeated: RecordedOrder | None = None
    wrong: tuple[str, ...] = ()  # words of wrong repeats
    wrong_by: tuple[RecordedOrder, ...] = ()  # those repeats
    carried_out: int | None = None  # [tick] from which it was kept until the next


def read_backs(trajectory: Trajectory) -> tuple[ReadBack, ...]:
    """Return a run's orders to the crew, each with its repeats and its end."""
    return tuple(_carried_out(spoken_orders(trajectory.orders), trajectory))


def spoken_orders(orders: Iterable[RecordedOrder]) -> list[ReadBack]:
    """Return the orders to the crew in a journal, each with its repeats."""
    read_back_list: list[ReadBack] = []
    for entry in orders:
        order = parse(entry.text)
        if not isinstance(order, Order) or entry.accepted is False:
            continue
        if entry.crew.news is CrewNews.ORDERED:
            read_back_list.append(ReadBack(entry, axis_of(order), entry.crew.order))
        elif entry.crew.news is not CrewNews.NOTHING:
            _repeat(read_back_list, entry, order.subject)
    return read_back_list


def _repeat(found: list[ReadBack], entry: RecordedOrder, words: str) -> None:
    """Note a repeat, right or wrong, with the newest order that it is about."""
    wrong = entry.crew.news is CrewNews.WRONG_REPEAT
    for i in range(len(found) - 1, -1, -1):
        if found[i].told == entry.crew.order and found[i].repeated is None:
            said, by = (*found[i].wrong, words), (*found[i].wrong_by, entry)
            changed = {"wrong": said, "wrong_by": by} if wrong else {"repeated": entry}
            found[i] = replace(found[i], **changed)
            return


def _carried_out(found: list[ReadBack], trajectory: Trajectory) -> Iterator[ReadBack]:
    """Yield the orders with the tick from which each was kept until the next of its axis."""
    for i, read_back in enumerate(found):
        later = (other.order.tick for other in found[i + 1 :] if other.axis == read_back.axis)
        end = next(later, int(trajectory.ticks[-1]))
        known = read_back.axis in CREW_ORDERS and trajectory.has(read_back.axis)
        yield replace(
            read_back, carried_out=_kept_from(read_back, end, trajectory) if known else None
        )


def _kept_from(each: ReadBack, end: int, trajectory: Trajectory) -> int | None:
    """Return the first tick from which an order is kept to its end, None if it is not."""
    rows = (trajectory.ticks > each.order.tick) & (trajectory.ticks <= end)
    if not rows.any():
        return None
    off = trajectory.series(each.axis)[rows] - trajectory.ordered(each.axis)[rows][0]
    if each.axis == COURSE_QUANTITY:
        off = (off + math.pi) % math.tau - math.pi
    beyond = np.flatnonzero(~(np.abs(off) <= KEPT_TOLERANCES[each.axis]))
    first = int(beyond[-1]) + 1 if beyond.size else 0
    ticks = trajectory.ticks[rows]
    return int(ticks[first]) if first < ticks.size else None
