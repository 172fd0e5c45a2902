"""Many boats flown by orders that are known before, in few calls.

A member ends in the bits that it has alone. From order to order it flies in machine code, without
the interpreter, so that ensembles fly in threads beside each other.
"""

from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trainer.boat.boat import STATE_OFFSETS
from trainer.boat.machine_code import EMPTY_CHART
from trainer.core.entry import fly
from trainer.core.kernel import Numbers, Record
from trainer.core.state import new_scratch

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
    value: Numbers  # in the unit of that number


class EnsembleFlight(NamedTuple):
    """The result of an ensemble's flight."""

    rows: Numbers  # [member, tick, column], SI and radians; NaN from where a member was lost
    lost: Integers  # [ticks] a member had done when its numbers were lost, -1: never


def orders(tick: ArrayLike, offset: ArrayLike, value: ArrayLike) -> Schedule:
    """Return a schedule from arrays [order], alike for all, or [member, order].

    ``tick`` counts from the start of the flight: 0 acts before the first tick. ``offset`` is that
    of a number in the state, see ``boat.STATE_OFFSETS``. Of two orders at one tick the one given
    later acts later.
    """
    ticks, offsets, values = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(given)) for given in (tick, offset, value))
    )
    by_time = np.argsort(ticks, axis=1, kind="stable")
    return Schedule(
        np.take_along_axis(ticks, by_time, 1).astype(np.int64),
        np.take_along_axis(offsets, by_time, 1).astype(np.int64),
        np.take_along_axis(values, by_time, 1).astype(np.float64),
    )


NO_ORDERS = orders([], [], [])


def fly_members(
    ensemble: Ensemble, schedule: Schedule, ticks: int, columns: tuple[str, ...]
) -> EnsembleFlight:
    """Advance all members by ``ticks``, their states in place, and return the rows.

    ``columns`` are fields of the state by name, kept at the start and after every tick, before the
    orders of the next. A member whose numbers are lost stays where it was.
    """
    count = ensemble.states.size
    rows = np.full((count, ticks + 1, len(columns)), np.nan)
    lost = np.full(count, -1, np.int64)
    places = [STATE_OFFSETS[name] for name in columns]
    offsets = np.array(places, float)
    for member in range(count):
        boat = boat_of(ensemble, member)
        s = boat[3][0]
        begun = float(s.tick)
        rows[member, 0] = s.whole[places]
        for begin, end, writes in stretches_of(schedule, member, ticks):
            for offset, value in writes:
                s.whole[offset] = value
            if fly(boat, EMPTY_CHART, offsets, rows[member, begin + 1 : end + 1]) != 0:
                lost[member] = int(s.tick - begun)
                break
    return EnsembleFlight(rows, lost)


def boat_of(ensemble: Ensemble, member: int) -> tuple[Record, ...]:
    """Return the records of ``update`` of a member, the state that of the ensemble."""
    vessel, compact, state = (
        records[min(member, records.size - 1) :][:1]
        for records in (ensemble.vessels, ensemble.compacts, ensemble.states)
    )
    return vessel, compact, ensemble.scheme, state, new_scratch()


def stretches_of(
    schedule: Schedule, member: int, ticks: int
) -> Iterator[tuple[int, int, list[tuple[int, float]]]]:
    """Yield begin and end of each stretch, and what is written at its begin."""
    row = min(member, len(schedule.tick) - 1)
    due = schedule.tick[row].tolist()
    writes = list(zip(schedule.offset[row].tolist(), schedule.value[row].tolist(), strict=True))
    ends = [*sorted({tick for tick in due if 0 < tick < ticks}), ticks]
    done = 0
    for begin, end in pairwise([0, *ends]):
        first, done = done, bisect_right(due, begin)
        yield begin, end, writes[first:done]
