"""Many boats flown at once, each as it would fly alone, to the bit."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trainer.boat import PLACES
from trainer.core.ensemble import Fleet, Schedule, Track, fly, new_work
from trainer.core.kernel import Numbers


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
