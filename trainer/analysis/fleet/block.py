"""Blocks of boats: their layout, and the way of records in and out.

It also says which boats can be computed side by side: those in calm deep water, with sound gear and
tanks at rest. Whether the water is deep enough is checked at every tick, by ``tick``.
"""

from typing import Final

import numpy as np

from trainer.analysis.fleet.lanes import LANE_COUNT, a_view
from trainer.core.autopilot.steering import GAIN_COUNT, OWN_LAW
from trainer.core.ballast.air import at_work
from trainer.core.ballast.ballast import advance_ballast
from trainer.core.ballast.tanks import NEGATIVE_TANK, TANKS_END, TRIM_FORWARD
from trainer.core.casualties import FIRST_SLOT
from trainer.core.current import is_moving
from trainer.core.kernel import Numbers, Record, kernel, part, record_dtype
from trainer.core.scheme import ADAMS
from trainer.core.scheme import COMPACT_EQUATIONS as COMPACT_SET
from trainer.core.state import GROUND_DEPTH, STATE
from trainer.core.vessel import COMPACT, VESSEL

ADAMS_TERMS = 2  # of Adams' method
FIXED_STATE: Final = {"depth_law": float(OWN_LAW)}  # of the state


@kernel
def supports_scheme(scheme: Record) -> bool:
    """Return whether lanes can compute the scheme: compact, lagged, two-term Adams."""
    how = scheme[0]
    lagged_compact = how.equations == COMPACT_SET and how.exact == 0
    two_terms = how.method == ADAMS and how.depth == ADAMS_TERMS
    return lagged_compact and two_terms and how.trigger_kind[0] == 0.0


@kernel
def tanks_rest(vessel: Record, state: Record) -> bool:
    """Return whether no water and no air can move in the tanks."""
    c = vessel[0]
    s = state[0]
    if c.fitted == 0.0:
        return True
    if s.hover > 0.0 or s.drained > 0.0 or s.compressor > 0.0:
        return False
    for i in range(s.to_move.size):
        if s.to_move[i] != 0.0:
            return False
    for i in range(TANKS_END - TRIM_FORWARD):
        if s.breach[i] > 0.0:
            return False
    at_rest = True
    for i in range(NEGATIVE_TANK + 1):
        at_rest = at_rest and not at_work(vessel, i, state)
    return at_rest


@part
def alone_in_the_world(state: Record) -> bool:
    """Return whether neither current nor ground nor ships act on a boat."""
    s = state[0]
    acting = 1 if is_moving(state) or s.bottom[GROUND_DEPTH, 0] != 0.0 else 0
    for i in range(6):
        acting += 1 if s.ship_force[i] != 0.0 else 0
    return acting == 0


@kernel
def supports_boat(vessel: Record, state: Record) -> bool:
    """Return whether a boat can be computed here as long as it stays deep."""
    c = vessel[0]
    s = state[0]
    constant_buoyancy = c.compressibility == 0.0 and c.layers == 0.0
    calm = s.sea_height == 0.0 and s.sea_ramp <= 0.0
    steady = s.trim_by_hand != 0.0 and s.wave_share == 0.0 and s.wave_count == 0.0
    steady = steady and s.ascent == 0.0 and s.trim_flood == 0.0 and s.trim_forward == 0.0
    free = s.held_depth == 0.0 and s.held_position == 0.0 and s.held_tanks == 0.0
    sound = s.casualty[FIRST_SLOT] == 0.0 and s.depth_law == OWN_LAW
    return (
        constant_buoyancy
        and calm
        and steady
        and free
        and sound
        and s.polar == 0.0
        and s.plant_touched == 0.0
        and alone_in_the_world(state)
        and tanks_rest(vessel, state)
    )


@kernel
def under_way(state: Record) -> bool:
    """Return whether the past of the integration belongs to this very flight."""
    s = state[0]
    return s.history > 0.0 and s.x == s.sailed_x and s.y == s.sailed_y


@kernel
def make_ready(vessel: Record, h: float, state: Record) -> None:
    """Write the numbers that every tick of an ordinary boat writes alike."""
    advance_ballast(vessel, h, state)
    state[0].eta_wave = 0.0


# indices in the gains of a lane: those in force, and those between which they are interpolated
LOW_GAINS, GAIN_RISES = GAIN_COUNT, 2 * GAIN_COUNT
LOW_SPEED, SPEED_RISE = 3 * GAIN_COUNT, 3 * GAIN_COUNT + 1
BRACKET_BELOW, BRACKET_TOP = 3 * GAIN_COUNT + 2, 3 * GAIN_COUNT + 3

LANE_WORK: Final = record_dtype(
    ("external", (6,)),
    ("force", (6,)),
    ("gains", (3 * GAIN_COUNT + 4,)),  # see above
    "hull_clear",  # [m] depth, below which not even a vertical hull reaches the surface
    "tables_clear",  # [m] depth from which on the tables of the calm surface have no effect
    "strayed",  # [-] ticks at which this boat could not be computed here
)


def _count(layout: np.dtype) -> int:
    """Return how many numbers a record has."""
    return layout.itemsize // 8


VESSEL_FIRST: Final = _count(STATE)
COMPACT_FIRST: Final = VESSEL_FIRST + _count(VESSEL)
WORK_FIRST: Final = COMPACT_FIRST + _count(COMPACT)
LANE_NUMBERS: Final = WORK_FIRST + _count(LANE_WORK)

state_in = a_view("state", STATE, 0, FIXED_STATE)
vessel_in = a_view("vessel", VESSEL, VESSEL_FIRST, {})
compact_in = a_view("compact", COMPACT, COMPACT_FIRST, {})
work_in = a_view("work", LANE_WORK, WORK_FIRST, {})


def new_block() -> Numbers:
    """Return room for LANE_COUNT boats, on a boundary of the processor's cache lines."""
    room = np.zeros(LANE_NUMBERS * LANE_COUNT + 8)
    skipped = -room.ctypes.data % 64 // 8
    return room[skipped : skipped + LANE_NUMBERS * LANE_COUNT]


@kernel
def bracket_gains(lane: int, out: Numbers) -> None:
    """Write the gains between which those of a lane are interpolated at its speed.

    Without a schedule they are zeros. ``autopilot.scheduled_gains`` looks them up at every tick. A
    lane keeps them until the boat leaves the bracket, which holds the speeds above BRACKET_BELOW up
    to BRACKET_TOP.
    """
    u = state_in(out, lane)[0].u
    c = vessel_in(out, lane)[0]
    work = work_in(out, lane)[0].gains
    work[BRACKET_BELOW], work[BRACKET_TOP] = -np.inf, np.inf
    work[SPEED_RISE] = 1.0
    last = int(c.gain_count) - 1
    if last < 0:
        for i in range(LOW_SPEED):
            work[i] = 0.0
        return
    upper = 1
    while upper < last and c.gain_speed[upper] < u:
        upper += 1
    lower = upper - 1
    if upper > 1:
        work[BRACKET_BELOW] = c.gain_speed[lower]
    if upper < last:
        work[BRACKET_TOP] = c.gain_speed[upper]
    work[LOW_SPEED] = c.gain_speed[lower]
    work[SPEED_RISE] = c.gain_speed[upper] - c.gain_speed[lower]
    for i in range(GAIN_COUNT):
        work[LOW_GAINS + i] = c.gain[lower, i]
        work[GAIN_RISES + i] = c.gain[upper, i] - c.gain[lower, i]


@kernel
def load_constants(vessel: Record, compact: Record, lane: int, out: Numbers) -> None:
    """Write the constants of a boat to its lane of the block ``out``."""
    c = vessel[0]
    for i in range(c.whole.size):
        out[(VESSEL_FIRST + i) * LANE_COUNT + lane] = c.whole[i]
    for i in range(compact[0].whole.size):
        out[(COMPACT_FIRST + i) * LANE_COUNT + lane] = compact[0].whole[i]
    work = work_in(out, lane)[0]
    depths, stations = int(c.surface_depths), c.station_x.size
    work.tables_clear = c.surface_depth[depths - 1] if depths > 0 else -np.inf
    work.hull_clear = max(c.station_x[stations - 1], -c.station_x[0]) + c.hull_diameter


@kernel
def load_state(state: Record, lane: int, out: Numbers) -> None:
    """Write a boat's state to its lane of the block ``out``."""
    for i in range(state[0].whole.size):
        out[i * LANE_COUNT + lane] = state[0].whole[i]
    work_in(out, lane)[0].strayed = 0.0
    bracket_gains(lane, out)


@kernel
def store_state(block: Numbers, lane: int, state: Record) -> None:
    """Write the state in a lane to its record."""
    for i in range(state[0].whole.size):
        state[0].whole[i] = block[i * LANE_COUNT + lane]
