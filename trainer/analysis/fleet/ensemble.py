"""Many boats in one call: every member of a fleet flown from its start to its end.

A member is the boat of ``update`` and ends in its bits. What the members are alike in is given
once: an array of one row or one record stands for all of them.

LANES members fly side by side from one order of theirs to the next: a stretch. A member that is
not ordinary, or strays, flies its stretch alone.

Many boats flown at once, each as it would fly alone, to the bit.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import config
from numpy.typing import ArrayLike, NDArray

from trainer.analysis.fleet.block import (
    follows,
    load_constants,
    load_state,
    make_ready,
    new_block,
    ordinary,
    store_state,
    under_way,
    work_in,
)
from trainer.analysis.fleet.lanes import LANES
from trainer.analysis.fleet.tick import tick_abreast
from trainer.boat.boat import PLACES
from trainer.core.kernel import Numbers, Record, kernel, unlocked
from trainer.core.state import new_scratch
from trainer.core.update import update

Places = NDArray[np.int64]

# else every member flies alone
COMPILED: Final = not config.DISABLE_JIT  # type: ignore[attr-defined]


class Fleet(NamedTuple):
    """What the members are: one record for all or one for each, but states for each."""

    vessels: Record
    compacts: Record
    scheme: Record  # of one element
    states: Record


class Schedule(NamedTuple):
    """Orders by member, or one row for all; by tick ascending.

    Before tick ``tick``, counted from the start of the flight, the place is given the value.
    """

    tick: Places
    place: Places
    value: NDArray[np.float64]


class Track(NamedTuple):
    """What is kept of a flight: places of the state, every so many ticks, the start first."""

    every: int
    places: Places
    rows: NDArray[np.float64]  # [member, row, place]
    lost: Places  # [ticks] done when a member's numbers were lost, -1: never


class Work(NamedTuple):
    """The work space of one thread."""

    scratch: Record
    block: Numbers
    next_order: Places  # by lane, in its row of the schedule
    alone: Places  # by lane, 1: this stretch is flown by ``update``


def new_work() -> Work:
    """Return a work space."""
    lanes = np.zeros(LANES, np.int64)
    return Work(new_scratch(), new_block(), lanes, lanes.copy())


@kernel
def span(records: Record, member: int) -> slice:
    """Return where a member's record is; the last serves all beyond it."""
    place = min(member, records.size - 1)
    return slice(place, place + 1)


@kernel
def note(out: Track, member: int, row: int, state: Record) -> None:
    """Write a row of the track."""
    for i in range(out.places.size):
        out.rows[member, row, i] = state[0].whole[out.places[i]]


@kernel
def forget(out: Track, member: int, start: int, end: int) -> None:
    """Write that from tick ``start`` up to ``end`` there is nothing to tell."""
    for row in range(start // out.every + 1, end // out.every + 1):
        for i in range(out.places.size):
            out.rows[member, row, i] = np.nan


@kernel
def fly_alone(fleet: Fleet, member: int, start: int, end: int, scratch: Record, out: Track) -> None:
    """Advance a member from tick ``start`` to ``end``, or to where its numbers are lost."""
    vessel = fleet.vessels[span(fleet.vessels, member)]
    compact = fleet.compacts[span(fleet.compacts, member)]
    state = fleet.states[span(fleet.states, member)]
    if out.lost[member] >= 0:
        return
    for i in range(scratch[0].gains.size):
        scratch[0].gains[i] = 0.0  # where there is no schedule nobody writes them
    for tick in range(start, end):
        if update(vessel, compact, fleet.scheme, state, scratch) != 0:
            out.lost[member] = tick
            forget(out, member, tick, end)
            return
        if (tick + 1) % out.every == 0:
            note(out, member, (tick + 1) // out.every, state)


@kernel
def choose(fleet: Fleet, first: int, count: int, work: Work, out: Track) -> int:
    """Return how many of ``count`` members fly side by side; write which do not, ready the rest."""
    together = 0
    for lane in range(count):
        member = first + lane
        vessel = fleet.vessels[span(fleet.vessels, member)]
        state = fleet.states[span(fleet.states, member)]
        work.alone[lane] = 1
        if out.lost[member] < 0 and ordinary(vessel, state):
            make_ready(vessel, fleet.scheme[0].h, state)
            work.alone[lane] = 0
            together += 1
    return together


@kernel
def fly_abreast(fleet: Fleet, first: int, start: int, end: int, work: Work, out: Track) -> None:
    """Advance the lanes of the block from tick ``start`` to ``end``, and note their rows."""
    count = min(LANES, fleet.states.size - first)
    for lane in range(LANES):
        load_state(fleet.states[span(fleet.states, first + lane)], lane, work.block)
    for tick in range(start, end):
        tick_abreast(fleet.scheme, work.block)
        if (tick + 1) % out.every != 0:
            continue
        for i in range(out.places.size):
            place, row = out.places[i] * LANES, (tick + 1) // out.every
            for lane in range(count):
                if work.alone[lane] == 0:
                    out.rows[first + lane, row, i] = work.block[place + lane]


@kernel
def unsettled(fleet: Fleet, first: int, count: int) -> bool:
    """Return whether any of ``count`` members has no past yet to integrate from."""
    for member in range(first, first + count):
        if not under_way(fleet.states[span(fleet.states, member)]):
            return True
    return False


@kernel
def fly_stretch(fleet: Fleet, first: int, start: int, end: int, work: Work, out: Track) -> None:
    """Advance a block, the members from ``first`` on, from tick ``start`` to ``end``."""
    count = min(LANES, fleet.states.size - first)
    tick = start
    if not (COMPILED and follows(fleet.scheme)):
        for lane in range(count):
            fly_alone(fleet, first + lane, tick, end, work.scratch, out)
        return
    if unsettled(fleet, first, count):
        for lane in range(count):
            fly_alone(fleet, first + lane, tick, tick + 1, work.scratch, out)
        tick += 1
    if choose(fleet, first, count, work, out) > 0:
        fly_abreast(fleet, first, tick, end, work, out)
    for lane in range(count):
        if work.alone[lane] == 0 and work_in(work.block, lane)[0].strayed == 0.0:
            store_state(work.block, lane, fleet.states[span(fleet.states, first + lane)])
        else:
            fly_alone(fleet, first + lane, tick, end, work.scratch, out)


@kernel
def obey(schedule: Schedule, member: int, tick: int, next_order: int, state: Record) -> int:
    """Carry out the orders due before ``tick``, from ``next_order`` on; return the next one."""
    row = min(member, schedule.tick.shape[0] - 1)
    place = next_order
    while place < schedule.tick.shape[1] and schedule.tick[row, place] <= tick:
        state[0].whole[schedule.place[row, place]] = schedule.value[row, place]
        place += 1
    return place


@kernel
def due(schedule: Schedule, member: int, next_order: int, end: int) -> int:
    """Return the tick before which the next order acts, ``end`` if none does until then."""
    if next_order == schedule.tick.shape[1]:
        return end
    return min(schedule.tick[min(member, schedule.tick.shape[0] - 1), next_order], end)


@kernel
def begin(fleet: Fleet, first: int, work: Work, out: Track) -> None:
    """Write the first rows of a block's members, and what they are to the block."""
    for lane in range(LANES):
        member = first + lane
        work.next_order[lane] = 0
        if member < fleet.states.size:
            note(out, member, 0, fleet.states[span(fleet.states, member)])
        if first == 0 or fleet.vessels.size > 1 or fleet.compacts.size > 1:
            vessel = fleet.vessels[span(fleet.vessels, member)]
            compact = fleet.compacts[span(fleet.compacts, member)]
            load_constants(vessel, compact, lane, work.block)


@kernel
def fly_block(
    fleet: Fleet, schedule: Schedule, ticks: int, first: int, work: Work, out: Track
) -> None:
    """Advance the members from ``first`` on, as many as fly side by side, by ``ticks``."""
    begin(fleet, first, work, out)
    tick = min(ticks, 0)  # as a literal 0 it would have all below compiled twice
    while tick < ticks:
        end = ticks
        for lane in range(min(LANES, fleet.states.size - first)):
            member = first + lane
            if out.lost[member] < 0:
                given, state = work.next_order[lane], fleet.states[span(fleet.states, member)]
                given = obey(schedule, member, tick, given, state)
                end = due(schedule, member, given, end)
                work.next_order[lane] = given
        fly_stretch(fleet, first, tick, end, work, out)
        tick = end


@unlocked
def fly(fleet: Fleet, schedule: Schedule, ticks: int, work: Work, out: Track) -> None:
    """Advance every member by ``ticks``; the interpreter is free meanwhile."""
    for first in range(0, fleet.states.size, LANES):
        fly_block(fleet, schedule, ticks, first, work, out)


class Flown(NamedTuple):
    """What became of a fleet."""

    rows: Numbers  # [member, row, column], SI and radians; NaN from where a member was lost
    lost: NDArray[np.int64]  # [ticks] a member had done when its numbers were lost, -1: never


def orders(tick: ArrayLike, place: ArrayLike, value: ArrayLike) -> Schedule:
    """Return a schedule from arrays [order], alike for all, or [member, order].

    ``tick`` counts from the start of the flight: 0 acts before the first tick. ``place`` is
    that of a number in the state, see ``boat.PLACES``. Of two at one tick the later given acts
    later.
    """
    ticks, places, values = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(given)) for given in (tick, place, value))
    )
    by_time = np.argsort(ticks, axis=1, kind="stable")
    return Schedule(
        np.take_along_axis(ticks, by_time, 1).astype(np.int64),
        np.take_along_axis(places, by_time, 1).astype(np.int64),
        np.take_along_axis(values, by_time, 1).astype(np.float64),
    )


NO_ORDERS = orders([], [], [])


def fly_members(
    fleet: Fleet, schedule: Schedule, ticks: int, every: int, columns: tuple[str, ...]
) -> Flown:
    """Advance all members by ``ticks``, their states in place, and return what was asked for.

    ``columns`` are places of the state by name, kept at the start and after every ``every``
    ticks, before the orders of that tick. A member whose numbers are lost stays where it was.
    The interpreter is free meanwhile: fleets fly in threads beside each other.
    """
    count = fleet.states.size
    track = Track(
        every,
        np.array([PLACES[name] for name in columns], np.int64),
        np.full((count, ticks // every + 1, len(columns)), np.nan),
        np.full(count, -1, np.int64),
    )
    fly(fleet, schedule, ticks, new_work(), track)
    return Flown(track.rows, track.lost)
