"""The twelve rates of the boat by the scheme's equation set."""

from trainer.core import compact as compact_set
from trainer.core import full as full_set
from trainer.core import wide
from trainer.core.envelope import wide_share
from trainer.core.kernel import Record, kernel
from trainer.core.kinematics import kinematics
from trainer.core.scheme import COMPACT, LONGITUDINAL
from trainer.core.solve import exact, sweep
from trainer.core.stall import is_stalled, write_stalled
from trainer.core.surfaced import is_near_surface, write_near


@kernel
def rates(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write all twelve rates for the state as it stands.

    With lagged accelerations those in the record on entry are last cycle's. A scheme without the
    envelope has the equations of 1969 alone, in deep water, whatever the state.
    """
    how = scheme[0]
    s = state[0]
    work = scratch[0]
    acceleration = s.rates[:6]
    outer = work.external
    if how.envelope != 0 and is_near_surface(vessel, state):
        write_near(vessel, scratch, state)
        outer = work.near
    felt = outer
    if how.envelope != 0 and is_stalled(vessel, state):
        write_stalled(vessel, outer, state, work.felt)
        felt = work.felt
    if how.equations == COMPACT:
        compact_set.forces(compact, how.trig, state, work.force)
        if compact[0].extended != 0.0:
            compact_set.further_forces(compact, state, work.force)
        compact_set.add_external(compact, felt, work.force)
        if how.exact != 0:
            compact_set.inertia(compact, state, work.inertia)
            exact(work.inertia, work.force, work.system, acceleration)
        else:
            compact_set.lagged_rates(compact, work.force, state)
    else:
        full_set.forces(vessel, how.trig, state, work.force)
        for i in range(6):
            work.force[i] += felt[i]
        full_set.inertia(vessel, state, work.inertia)
        if how.equations == LONGITUDINAL:
            full_set.mask_lateral(work.force, work.inertia)
        if how.exact != 0:
            exact(work.inertia, work.force, work.system, acceleration)
        else:
            sweep(work.inertia, work.force, acceleration)
    if how.envelope != 0 and wide_share(vessel, state) > 0.0:
        wide.correct(vessel, how.equations, state, scratch, outer)
    kinematics(how.trig, state)
