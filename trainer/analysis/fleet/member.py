"""One member of a fleet, flown as it would be alone.

``update`` flies it from order to order. ``ensemble`` flies members by it one after the other, and
``side_by_side`` those that its lanes cannot compute. It is machine code, so that many members fly
without the interpreter.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.fleet.shipped import SoloWork, update_boat
from trainer.core.kernel import Record, kernel, unlocked

Integers = NDArray[np.int64]


class Ensemble(NamedTuple):
    """The members: one record for all or one for each, but states for each."""

    vessels: Record
    compacts: Record
    scheme: Record  # of one element
    states: Record


class Schedule(NamedTuple):
    """Orders by member, or one row for all; by tick ascending.

    Before tick ``tick``, counted from the start of the flight, the number at ``offset`` is written.
    """

    tick: Integers
    offset: Integers
    value: NDArray[np.float64]  # in the unit of that number


class FlightTrack(NamedTuple):
    """The part of a flight that is kept: numbers of the state by tick.

    They are kept every so many ticks, the start first.
    """

    every: int
    offsets: Integers
    rows: NDArray[np.float64]  # [member, row, offset]
    lost: Integers  # [ticks] done when a member's numbers were lost, -1: never


@kernel
def record_span(records: Record, member: int) -> slice:
    """Return where a member's record is. The last record serves all members beyond it."""
    index = min(member, records.size - 1)
    return slice(index, index + 1)


@kernel
def write_track_row(out: FlightTrack, member: int, row: int, state: Record) -> None:
    """Write a row of the track."""
    for i in range(out.offsets.size):
        out.rows[member, row, i] = state[0].whole[out.offsets[i]]


@kernel
def clear_track_rows(out: FlightTrack, member: int, start: int, end: int) -> None:
    """Write NaN to the rows from tick ``start`` to ``end``."""
    for row in range(start // out.every + 1, end // out.every + 1):
        for i in range(out.offsets.size):
            out.rows[member, row, i] = np.nan


@kernel
def fly_alone(
    fleet: Ensemble, member: int, start: int, end: int, solo: SoloWork, out: FlightTrack
) -> None:
    """Advance a member from tick ``start`` to ``end``, or to where its numbers are lost."""
    vessel = fleet.vessels[record_span(fleet.vessels, member)]
    compact = fleet.compacts[record_span(fleet.compacts, member)]
    state = fleet.states[record_span(fleet.states, member)]
    if out.lost[member] >= 0:
        return
    for i in range(solo.scratch[0].gains.size):
        solo.scratch[0].gains[i] = 0.0  # without a schedule nobody writes them
    for tick in range(start, end):
        if update_boat(solo.codes, vessel, compact, fleet.scheme, state, solo.scratch) != 0:
            out.lost[member] = tick
            clear_track_rows(out, member, tick, end)
            return
        if (tick + 1) % out.every == 0:
            write_track_row(out, member, (tick + 1) // out.every, state)


@kernel
def obey_orders(schedule: Schedule, member: int, tick: int, next_order: int, state: Record) -> int:
    """Carry out the orders due before ``tick``, from ``next_order`` on. Return the next one."""
    row = min(member, schedule.tick.shape[0] - 1)
    index = next_order
    while index < schedule.tick.shape[1] and schedule.tick[row, index] <= tick:
        state[0].whole[schedule.offset[row, index]] = schedule.value[row, index]
        index += 1
    return index


@kernel
def next_order_tick(schedule: Schedule, member: int, next_order: int, end: int) -> int:
    """Return the tick before which the next order acts.

    It is ``end`` if no order acts before that.
    """
    if next_order == schedule.tick.shape[1]:
        return end
    return min(schedule.tick[min(member, schedule.tick.shape[0] - 1), next_order], end)


@kernel
def fly_member(
    fleet: Ensemble, schedule: Schedule, ticks: int, member: int, solo: SoloWork, out: FlightTrack
) -> None:
    """Advance a member by ``ticks``, and obey its orders."""
    state = fleet.states[record_span(fleet.states, member)]
    write_track_row(out, member, 0, state)
    tick, next_order = min(ticks, 0), 0  # a literal 0 would make all below compile twice
    while tick < ticks and out.lost[member] < 0:
        next_order = obey_orders(schedule, member, tick, next_order, state)
        end = next_order_tick(schedule, member, next_order, ticks)
        fly_alone(fleet, member, tick, end, solo, out)
        tick = end


@unlocked
def fly_one_by_one(
    fleet: Ensemble, schedule: Schedule, ticks: int, solo: SoloWork, out: FlightTrack
) -> None:
    """Advance every member by ``ticks``; the interpreter is free meanwhile."""
    for member in range(fleet.states.size):
        fly_member(fleet, schedule, ticks, member, solo, out)
