"""The twelve rates of the boat by the scheme's equation set."""

from trainer.core import compact as compact_set
from trainer.core import full as full_set
from trainer.core.kernel import Record, kernel
from trainer.core.kinematics import kinematics
from trainer.core.scheme import COMPACT, LONGITUDINAL
from trainer.core.solve import exact, sweep


@kernel
def rates(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write all twelve rates for the state as it stands.

    With lagged accelerations those in the record on entry are last cycle's.
    """
    how = scheme[0]
    s = state[0]
    work = scratch[0]
    acceleration = s.rates[:6]
    if how.equations == COMPACT:
        compact_set.forces(compact, how.trig, state, work.force)
        if compact[0].extended != 0.0:
            compact_set.further_forces(compact, state, work.force)
        compact_set.add_external(compact, work.external, work.force)
        if how.exact != 0:
            compact_set.inertia(compact, state, work.inertia)
            exact(work.inertia, work.force, work.system, acceleration)
        else:
            compact_set.lagged(compact, work.force, state)
    else:
        full_set.forces(vessel, how.trig, state, work.force)
        for i in range(6):
            work.force[i] += work.external[i]
        full_set.inertia(vessel, state, work.inertia)
        if how.equations == LONGITUDINAL:
            full_set.mask_lateral(work.force, work.inertia)
        if how.exact != 0:
            exact(work.inertia, work.force, work.system, acceleration)
        else:
            sweep(work.inertia, work.force, acceleration)
    kinematics(how.trig, state)
