"""One tick of the whole boat."""

from trainer.core.actuators import move_surfaces
from trainer.core.autopilot import autopilot
from trainer.core.ballast import advance_ballast
from trainer.core.buoyancy import buoyancy_forces
from trainer.core.casualties import advance_casualties
from trainer.core.free_surface import surface_forces
from trainer.core.holds import cast_off, make_fast
from trainer.core.integrators import advance
from trainer.core.kernel import Record, kernel, part
from trainer.core.propulsion import answer_telegraph
from trainer.core.seaway import advance_sea
from trainer.core.state import MOTION, RATES
from trainer.core.triggers import fire_triggers
from trainer.core.wave_forces import wave_forces

WATCHED = (*RATES, *MOTION)  # what a failing status points into
FASTEST_RATE = 1e6  # [m/s2], [rad/s2], [m/s] or [rad/s]
FASTEST = 1e3  # [m/s] or [rad/s]
FURTHEST = 1e9  # [rad] or [m]


@part
def lost(state: Record) -> int:
    """Return 1 + the place in WATCHED of the first number beyond any boat's, 0 if none is.

    What is not finite is beyond too.
    """
    s = state[0]
    found = 0
    for i in range(11, -1, -1):  # the last to be found is the first
        if not abs(s.motion[i]) < (FASTEST if i < 6 else FURTHEST):
            found = 13 + i
    for i in range(11, -1, -1):
        if not abs(s.rates[i]) < FASTEST_RATE:
            found = 1 + i
    return found


@part
def outside(vessel: Record, state: Record, scratch: Record) -> None:
    """Write the forces of sea and surface, held over the tick."""
    work = scratch[0]
    for i in range(6):
        work.external[i] = 0.0
    wave_forces(vessel, scratch, state, work.external)
    surface_forces(vessel, state, work.external)
    buoyancy_forces(vessel, vessel, state, work.external)


@kernel
def update(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> int:
    """Advance ``state`` by one tick; return 0, or 1 + the place in WATCHED of what failed.

    A tick that fails leaves the state as it was. Forces see surfaces and propeller as they stand
    at the start of the tick, and all arrive together at its end: a surface moved before the
    forces would act one step early and take the order of the integration away.
    """
    h = scheme[0].h
    s = state[0]
    work = scratch[0]
    for i in range(s.whole.size):
        work.before[i] = s.whole[i]

    fire_triggers(scheme, state)
    advance_casualties(state)
    autopilot(vessel, h, state, work.gains)
    if s.held_tanks == 0.0:
        advance_ballast(vessel, vessel, h, state)
    advance_sea(vessel, h, scratch, state)
    outside(vessel, state, scratch)
    x, y, z = s.x, s.y, s.z
    cast_off(state)
    advance(vessel, compact, scheme, state, scratch)
    make_fast(x, y, z, state)
    move_surfaces(vessel, h, state)
    answer_telegraph(vessel, h, state)
    s.tick += 1.0

    failed = lost(state)
    if failed != 0:
        for i in range(s.whole.size):
            s.whole[i] = work.before[i]
    return failed
