"""Many boats in one call: every member of a fleet flown from start to end.

A member is the boat of ``update`` and ends in the same bits. An array of one row, or one record,
stands for all members, where they are alike. Where the compiler is one on which the
vector code was tested, members fly side by side; else they fly one after another, to the same bits.
Only members whose trim is by hand (``trim_by_hand`` 1) fly side by side, because lanes do not
compute pumps at work.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trainer.analysis.fleet.member import Ensemble, FlightTrack, Schedule, fly_one_by_one
from trainer.analysis.fleet.shipped import new_solo
from trainer.boat.boat import STATE_OFFSETS
from trainer.boat.compilation import known_compiler
from trainer.core.kernel import Numbers

__all__ = ["NO_ORDERS", "Ensemble", "FleetFlight", "Schedule", "fly_members", "orders"]


class FleetFlight(NamedTuple):
    """The result of a fleet's flight."""

    rows: Numbers  # [member, row, column], SI and radians; NaN from where a member was lost
    lost: NDArray[np.int64]  # [ticks] a member had done when its numbers were lost, -1: never


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
    fleet: Ensemble, schedule: Schedule, ticks: int, every: int, columns: tuple[str, ...]
) -> FleetFlight:
    """Advance all members by ``ticks``, their states in place, and return the rows.

    ``columns`` are fields of the state by name. They are kept at the start and after every
    ``every`` ticks, before the orders of that tick. A member whose numbers are lost stays where it
    was. The interpreter is free meanwhile: fleets fly in threads beside each other.
    """
    count = fleet.states.size
    track = FlightTrack(
        every,
        np.array([STATE_OFFSETS[name] for name in columns], np.int64),
        np.full((count, ticks // every + 1, len(columns)), np.nan),
        np.full(count, -1, np.int64),
    )
    if known_compiler():
        from trainer.analysis.fleet import side_by_side  # noqa: PLC0415  only where it can be had

        side_by_side.fly_members_by_block(fleet, schedule, ticks, side_by_side.new_work(), track)
    else:
        fly_one_by_one(fleet, schedule, ticks, new_solo(), track)
    return FleetFlight(track.rows, track.lost)
