"""One tick of the whole boat, with its partial freezes.

In a partial freeze depth, position or tanks stand still while all else goes on. Tanks that are held
are not advanced at all. Nothing depends on position: a boat held in place sails on unseen. So every
number but the location is that of a run without the hold, and once released the boat goes on from
where it was held. Nearly everything depends on depth: it is put back after every step, and the boat
feels the depth that is held.
"""

from typing import Final

import numpy as np

from trainer.core.actuators import move_surfaces
from trainer.core.autopilot.autopilot import autopilot
from trainer.core.ballast.ballast import advance_ballast
from trainer.core.ballast.buoyancy import add_compression
from trainer.core.bottom import bottom_forces
from trainer.core.casualties import advance_casualties, fire_triggers
from trainer.core.envelope import validity
from trainer.core.integrators import advance
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.plant.plant import advance_plant
from trainer.core.propulsion import kept_lag_share, turn_propeller
from trainer.core.sea.forces import wave_forces
from trainer.core.sea.free_surface import surface_forces
from trainer.core.sea.sea import advance_sea
from trainer.core.state import GROUND_DEPTH, MOTION, PAST_CYCLES, RATES, offset_of
from trainer.core.surfaced import is_cut, is_near_surface

X: Final = MOTION.index("x")  # y follows
Z: Final = MOTION.index("z")


@inline_kernel
def cast_off(state: Record) -> None:
    """Move a boat that is held in place to where it would be.

    This comes before a step. A boat that is no longer held, and not where it sailed, takes its past
    locations along, since a method that looks back would take the difference for motion.
    """
    s = state[0]
    for i in range(2):
        jump = s.motion[X + i] - s.sailed[i]
        if s.held_position != 0.0:
            s.motion[X + i] = s.sailed[i]
        elif jump != 0.0:
            for back in range(PAST_CYCLES):
                s.past_motion[back, X + i] += jump


@inline_kernel
def make_fast(x: float, y: float, z: float, state: Record) -> None:
    """Put what is held back to where it was [m].

    This comes after a step; ``x``, ``y`` and ``z`` are from before it.
    """
    s = state[0]
    s.sailed_x, s.sailed_y = s.x, s.y
    if s.held_position != 0.0:
        s.x, s.y = x, y
    if s.held_depth != 0.0:
        descent = s.z - z
        s.z = z
        for back in range(PAST_CYCLES):
            s.past_motion[back, Z] -= descent


WATCHED_NAMES = (*RATES, *MOTION)  # a failing status points into this list
# a tick writes the state up to the orders to the crew, and after them at these offsets alone
WRITTEN_COUNT: Final = offset_of("crew_order")
LATE_NAMES: Final = ("through_north", "through_east", "bottom_load", "aground", "battery_spent")
LATE_OFFSETS: Final = np.array([offset_of(name) for name in LATE_NAMES])
# of them, those that only waves write, so that a tick in a calm need not save them
MEMORY_BEGIN, MEMORY_END = offset_of("sea_memory"), offset_of("water")
FILTER_BEGIN, FILTER_END = offset_of("sea_modes"), offset_of("speed_followed")
PLANT_BEGIN: Final = offset_of("plant_touched")  # likewise a plant that nobody has touched
SEA_HEIGHT, SEA_RAMP = offset_of("sea_height"), offset_of("sea_ramp")
MAX_RATE = 1e6  # [m/s2], [rad/s2], [m/s] or [rad/s]
MAX_SPEED = 1e3  # [m/s] or [rad/s]
MAX_DISTANCE = 1e9  # [rad] or [m]


@inline_kernel
def lost(state: Record) -> int:
    """Return 1 + the index in WATCHED_NAMES of the first number out of range.

    It is 0 if there is none. The range is wider than any boat's; a number that is not finite is out
    of it.
    """
    s = state[0]
    found = 0
    for i in range(11, -1, -1):  # backwards, so that the first one is found last
        if not abs(s.motion[i]) < (MAX_SPEED if i < 6 else MAX_DISTANCE):
            found = 13 + i
    for i in range(11, -1, -1):
        if not abs(s.rates[i]) < MAX_RATE:
            found = 1 + i
    return found


@inline_kernel
def copy_written(source: Numbers, out: Numbers) -> None:
    """Copy what a tick may write from one state to another."""
    touched = source[PLANT_BEGIN] != 0.0 or out[PLANT_BEGIN] != 0.0
    for i in range(MEMORY_BEGIN):
        out[i] = source[i]
    for i in range(MEMORY_END, FILTER_BEGIN):
        out[i] = source[i]
    for i in range(FILTER_END, PLANT_BEGIN):
        out[i] = source[i]
    if touched:
        for i in range(PLANT_BEGIN, WRITTEN_COUNT):
            out[i] = source[i]
    if source[SEA_HEIGHT] != 0.0 or source[SEA_RAMP] > 0.0:
        for i in range(MEMORY_BEGIN, MEMORY_END):
            out[i] = source[i]
        for i in range(FILTER_BEGIN, FILTER_END):
            out[i] = source[i]
    for i in range(LATE_OFFSETS.size):
        out[LATE_OFFSETS[i]] = source[LATE_OFFSETS[i]]


@kernel
def put_back(state: Record, scratch: Record) -> None:
    """Put the state back to where it was saved."""
    copy_written(scratch[0].before, state[0].whole)


@inline_kernel
def is_sound(state: Record) -> bool:
    """Return whether even the sums of the sizes are in range.

    They are in nearly every tick. Then no number is ``lost``, which asks one by one.
    """
    s = state[0]
    speeds = distances = rates = 0.0
    for i in range(6):
        speeds += abs(s.motion[i])
        distances += abs(s.motion[6 + i])
    for i in range(12):
        rates += abs(s.rates[i])
    return speeds < MAX_SPEED and distances < MAX_DISTANCE and rates < MAX_RATE


@inline_kernel
def outside(vessel: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write the forces of sea, depth, ground and ships near for the tick.

    They are taken as constant in the tick. Near the surface, write the water's level along the hull
    too.
    """
    s, work = state[0], scratch[0]
    for i in range(6):
        work.external[i] = 0.0
    near = is_near_surface(vessel, scheme[0].h, state)
    if near or work.levels != 0.0:  # else they are 0, and stay so for rates within the tick
        for i in range(vessel[0].station_x.size):
            work.level[i] = work.rise[i] = 0.0
            work.station[i] = vessel[0].station_x[i]
    work.levels = 1.0 if near else 0.0
    wave_forces(vessel, scratch, state, work.external)
    surface_forces(vessel, state, work.external)
    add_compression(vessel, state, work.external)
    if s.bottom[GROUND_DEPTH, 0] != 0.0:
        bottom_forces(vessel, scheme, state, work.external)
    for i in range(6):
        if s.ship_force[i] != 0.0:
            work.external[i] += s.ship_force[i]
    work.cut = 1.0 if near and is_cut(vessel, scratch, state) else 0.0


@kernel
def update(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> int:
    """Advance ``state`` by one tick.

    Return 0, or 1 + the index in WATCHED_NAMES of what failed. A tick that fails leaves the state
    as it was. Forces see surfaces and propeller as they stand at the start of the tick, and all
    arrive together at its end. A surface moved before the forces would act one step early and take
    the order of the integration away.
    """
    h = scheme[0].h
    s = state[0]
    copy_written(s.whole, scratch[0].before)  # in case that the tick fails
    fire_triggers(scheme, state)
    advance_casualties(state)
    advance_plant(vessel, h, state)
    autopilot(vessel, h, state, scratch)
    if s.held_tanks == 0.0:
        advance_ballast(vessel, h, state)
    advance_sea(vessel, h, scratch, state)
    outside(vessel, scheme, state, scratch)
    x, y, z = s.x, s.y, s.z
    cast_off(state)
    advance(vessel, compact, scheme, state, scratch)
    make_fast(x, y, z, state)
    move_surfaces(vessel, h, state)
    turn_propeller(vessel, h, kept_lag_share(vessel, h, scratch), state)
    s.tick += 1.0
    s.validity = validity(vessel, state)

    failed = 0 if is_sound(state) else lost(state)
    if failed != 0:
        put_back(state, scratch)
    return failed
