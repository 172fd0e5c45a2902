"""The twelve rates of the boat by the scheme's equation set.

``integrators`` asks for them at each cycle or stage of a step. Forces from outside (sea, ground,
ships near) are computed once a tick and come in ready. The water's surface, stall and the wide set
change within a step, so they are added here.
"""

from trainer.core import compact as compact_set
from trainer.core import full as full_set
from trainer.core import wide
from trainer.core.current import carry_along, is_moving
from trainer.core.envelope import wide_share
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.kinematics import Attitude, attitude_of, kinematics
from trainer.core.scheme import COMPACT_EQUATIONS, LONGITUDINAL_EQUATIONS
from trainer.core.solve import exact, sweep
from trainer.core.stall import is_stalled, write_stalled
from trainer.core.surfaced import emerges, write_near


@inline_kernel
def compact_accelerations(
    compact: Record,
    scheme: Record,
    attitude: Attitude,
    state: Record,
    scratch: Record,
    outer: Numbers,
) -> None:
    """Write u' v' w' p' q' r' by the compact set.

    ``outer`` has the forces [N] and moments [N m] from outside.
    """
    how = scheme[0]
    work = scratch[0]
    acceleration = state[0].rates[:6]
    compact_set.forces(compact, attitude, state, work.force)
    if compact[0].extended != 0.0:
        compact_set.further_forces(compact, state, work.force)
    if compact[0].slipping != 0.0:
        compact_set.slip_forces(compact, state, work.force)
    off_centre = compact_set.off_centre(compact, state)
    if off_centre:
        compact_set.off_centre_forces(compact, attitude, state, work.force)
    compact_set.add_external(compact, outer, work.force)
    if how.exact == 0 and not off_centre:
        compact_set.lagged_rates(compact, work.force, state)
        return
    compact_set.inertia(compact, state, work.inertia)
    if off_centre:
        compact_set.off_centre_inertia(compact, state, work.inertia)
    if how.exact != 0:
        exact(work.inertia, work.force, work.system, acceleration)
    else:
        sweep(work.inertia, work.force, acceleration)


@inline_kernel
def full_accelerations(
    vessel: Record,
    scheme: Record,
    attitude: Attitude,
    state: Record,
    scratch: Record,
    outer: Numbers,
) -> None:
    """Write u' v' w' p' q' r' by the full set or its vertical plane.

    ``outer`` has the forces [N] and moments [N m] from outside.
    """
    how = scheme[0]
    work = scratch[0]
    acceleration = state[0].rates[:6]
    full_set.forces(vessel, attitude, state, work.force)
    for i in range(6):
        work.force[i] += outer[i]
    full_set.inertia(vessel, state, work.inertia)
    if how.equations == LONGITUDINAL_EQUATIONS:
        full_set.mask_lateral(work.force, work.inertia)
    if how.exact != 0:
        exact(work.inertia, work.force, work.system, acceleration)
    else:
        sweep(work.inertia, work.force, acceleration)


@kernel
def rates(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write all twelve rates for the state as it stands.

    With lagged accelerations, those in the record on entry are last cycle's. A scheme without the
    envelope has the equations of 1969 alone, in deep water, whatever the state is.
    """
    how = scheme[0]
    work = scratch[0]
    outer = work.external
    if how.envelope != 0 and emerges(vessel, state):
        write_near(vessel, scratch, state)
        outer = work.near
    felt = outer
    if how.envelope != 0 and is_stalled(vessel, state):
        write_stalled(vessel, outer, state, work.felt)
        felt = work.felt
    attitude = attitude_of(how.trig, state)
    if how.equations == COMPACT_EQUATIONS:
        compact_accelerations(compact, scheme, attitude, state, scratch, felt)
    else:
        full_accelerations(vessel, scheme, attitude, state, scratch, felt)
    if how.envelope != 0 and wide_share(vessel, state) > 0.0:
        wide.correct(vessel, how.equations, state, scratch, outer)
    kinematics(attitude, state)
    if is_moving(state):
        carry_along(state)
