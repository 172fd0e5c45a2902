"""Members of a fleet side by side, LANE_COUNT of them at a time.

``ensemble`` flies a fleet by it, because lanes cost a fraction of boats one by one. They fly in
stretches, each from one order to the next. A member that lanes cannot compute, or that strays,
flies that stretch alone. So does one whose centres lie off the middle, or that has products of
inertia.
"""

import math
from typing import NamedTuple

import numpy as np

from trainer.analysis.fleet.block import (
    load_constants,
    load_state,
    make_ready,
    new_block,
    state_in,
    store_state,
    supports_boat,
    supports_scheme,
    under_way,
    work_in,
)
from trainer.analysis.fleet.lanes import LANE_COUNT
from trainer.analysis.fleet.member import (
    Ensemble,
    FlightTrack,
    Integers,
    Schedule,
    fly_alone,
    next_order_tick,
    obey_orders,
    record_span,
    write_track_row,
)
from trainer.analysis.fleet.shipped import SoloWork, new_solo
from trainer.analysis.fleet.tick import tick_abreast
from trainer.core.compact import off_centre
from trainer.core.kernel import Numbers, kernel, unlocked
from trainer.core.plant.plant import CALM_TICKS
from trainer.core.plant.power import drain_battery


class ThreadWork(NamedTuple):
    """The work space of one thread."""

    solo: SoloWork
    block: Numbers
    next_order: Integers  # by lane, in its row of the schedule
    alone: Integers  # by lane, 1: this stretch is flown by ``update``


def new_work() -> ThreadWork:
    """Return a work space."""
    lanes = np.zeros(LANE_COUNT, np.int64)
    return ThreadWork(new_solo(), new_block(), lanes, lanes.copy())


@kernel
def choose_members(
    fleet: Ensemble, first: int, count: int, work: ThreadWork, out: FlightTrack
) -> int:
    """Return how many of ``count`` members fly side by side.

    Write which do not, and make the others ready.
    """
    together = 0
    for lane in range(count):
        member = first + lane
        vessel = fleet.vessels[record_span(fleet.vessels, member)]
        compact = fleet.compacts[record_span(fleet.compacts, member)]
        state = fleet.states[record_span(fleet.states, member)]
        work.alone[lane] = 1
        if out.lost[member] < 0 and supports_boat(vessel, state):
            make_ready(vessel, fleet.scheme[0].h, state)
            if not off_centre(compact, state):
                work.alone[lane] = 0
                together += 1
    return together


@kernel
def drain_batteries(fleet: Ensemble, first: int, count: int, work: ThreadWork) -> None:
    """Drain the batteries of lanes that are due, as ``advance_plant`` does.

    Loads are those at the start of the stretch, because nothing that draws is touched within it.
    A lane whose battery is empty strays.
    """
    for lane in range(count):
        flown = state_in(work.block, lane)[0]
        due = flown.tick == CALM_TICKS * math.floor(flown.tick * (1.0 / CALM_TICKS))
        if work.alone[lane] != 0 or not due:
            continue
        state = fleet.states[record_span(fleet.states, first + lane)]
        s = state[0]
        u_c, spent = s.u_c, s.battery_spent
        s.u_c, s.battery_spent = flown.u_c, flown.battery_spent
        vessel = fleet.vessels[record_span(fleet.vessels, first + lane)]
        drain_battery(vessel, CALM_TICKS * fleet.scheme[0].h, state)
        flown.battery_spent = s.battery_spent
        work_in(work.block, lane)[0].strayed += s.plant_touched
        s.u_c, s.battery_spent, s.plant_touched = u_c, spent, 0.0


@kernel
def fly_abreast(
    fleet: Ensemble, first: int, start: int, end: int, work: ThreadWork, out: FlightTrack
) -> None:
    """Advance the lanes of the block from tick ``start`` to ``end``, and note their rows."""
    count = min(LANE_COUNT, fleet.states.size - first)
    for lane in range(LANE_COUNT):
        load_state(fleet.states[record_span(fleet.states, first + lane)], lane, work.block)
    for tick in range(start, end):
        drain_batteries(fleet, first, count, work)
        tick_abreast(fleet.scheme, work.block)
        if (tick + 1) % out.every != 0:
            continue
        for i in range(out.offsets.size):
            first_lane, row = out.offsets[i] * LANE_COUNT, (tick + 1) // out.every
            for lane in range(count):
                if work.alone[lane] == 0:
                    out.rows[first + lane, row, i] = work.block[first_lane + lane]


@kernel
def any_without_past(fleet: Ensemble, first: int, count: int) -> bool:
    """Return whether any of ``count`` members has no past from which to integrate."""
    for member in range(first, first + count):
        if not under_way(fleet.states[record_span(fleet.states, member)]):
            return True
    return False


@kernel
def fly_stretch(
    fleet: Ensemble, first: int, start: int, end: int, work: ThreadWork, out: FlightTrack
) -> None:
    """Advance a block, the members from ``first`` on, from tick ``start`` to ``end``."""
    count = min(LANE_COUNT, fleet.states.size - first)
    tick = start
    if not supports_scheme(fleet.scheme):
        for lane in range(count):
            fly_alone(fleet, first + lane, tick, end, work.solo, out)
        return
    if any_without_past(fleet, first, count):
        for lane in range(count):
            fly_alone(fleet, first + lane, tick, tick + 1, work.solo, out)
        tick += 1
    if choose_members(fleet, first, count, work, out) > 0:
        fly_abreast(fleet, first, tick, end, work, out)
    for lane in range(count):
        if work.alone[lane] == 0 and work_in(work.block, lane)[0].strayed == 0.0:
            store_state(work.block, lane, fleet.states[record_span(fleet.states, first + lane)])
        else:
            fly_alone(fleet, first + lane, tick, end, work.solo, out)


@kernel
def begin_block(fleet: Ensemble, first: int, work: ThreadWork, out: FlightTrack) -> None:
    """Write the first rows of a block's members, and their constants to the block."""
    for lane in range(LANE_COUNT):
        member = first + lane
        work.next_order[lane] = 0
        if member < fleet.states.size:
            write_track_row(out, member, 0, fleet.states[record_span(fleet.states, member)])
        if first == 0 or fleet.vessels.size > 1 or fleet.compacts.size > 1:
            vessel = fleet.vessels[record_span(fleet.vessels, member)]
            compact = fleet.compacts[record_span(fleet.compacts, member)]
            load_constants(vessel, compact, lane, work.block)


@kernel
def fly_block(
    fleet: Ensemble, schedule: Schedule, ticks: int, first: int, work: ThreadWork, out: FlightTrack
) -> None:
    """Advance the members from ``first`` on by ``ticks``, as many as fly side by side."""
    begin_block(fleet, first, work, out)
    tick = min(ticks, 0)  # a literal 0 would make all below compile twice
    while tick < ticks:
        end = ticks
        for lane in range(min(LANE_COUNT, fleet.states.size - first)):
            member = first + lane
            if out.lost[member] < 0:
                next_order, state = (
                    work.next_order[lane],
                    fleet.states[record_span(fleet.states, member)],
                )
                next_order = obey_orders(schedule, member, tick, next_order, state)
                end = next_order_tick(schedule, member, next_order, end)
                work.next_order[lane] = next_order
        fly_stretch(fleet, first, tick, end, work, out)
        tick = end


@unlocked
def fly_members_by_block(
    fleet: Ensemble, schedule: Schedule, ticks: int, work: ThreadWork, out: FlightTrack
) -> None:
    """Advance every member by ``ticks``; the interpreter is free meanwhile."""
    for first in range(0, fleet.states.size, LANE_COUNT):
        fly_block(fleet, schedule, ticks, first, work, out)
