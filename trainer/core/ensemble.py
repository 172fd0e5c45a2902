"""Many boats in one call: every member of a fleet flown from its start to its end.

A member is the boat of ``update`` and ends in its bits. What the members are alike in is given
once: an array of one row or one record stands for all of them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trainer.core.kernel import Record, kernel
from trainer.core.update import update

Places = NDArray[np.int64]

# for what runs long: other threads go on meanwhile
unlocked = njit(cache=True, error_model="numpy", nogil=True)


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


@kernel
def of(records: Record, member: int) -> Record:
    """Return the record of a member, of one element; the last serves all beyond it."""
    place = min(member, records.size - 1)
    return records[place : place + 1]


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
def note(out: Track, member: int, row: int, state: Record) -> None:
    """Write a row of the track."""
    for i in range(out.places.size):
        out.rows[member, row, i] = state[0].whole[out.places[i]]


@kernel
def fly_alone(
    fleet: Fleet, schedule: Schedule, ticks: int, member: int, scratch: Record, out: Track
) -> None:
    """Advance one member by ``ticks``, or to where its numbers are lost."""
    vessel, compact = of(fleet.vessels, member), of(fleet.compacts, member)
    state = of(fleet.states, member)
    next_order = 0
    note(out, member, 0, state)
    for tick in range(ticks):
        next_order = obey(schedule, member, tick, next_order, state)
        if update(vessel, compact, fleet.scheme, state, scratch) != 0:
            out.lost[member] = tick
            return
        if (tick + 1) % out.every == 0:
            note(out, member, (tick + 1) // out.every, state)


@unlocked
def fly(fleet: Fleet, schedule: Schedule, ticks: int, scratch: Record, out: Track) -> None:
    """Advance every member by ``ticks``; the interpreter is free meanwhile."""
    for member in range(fleet.states.size):
        fly_alone(fleet, schedule, ticks, member, scratch, out)
