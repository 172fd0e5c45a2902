"""The twelve rates of the boat by the scheme's equation set.

Accelerations from forces: the exact solve (EVAL) and the lagged sweep (EVAL 1).
"""

from trainer.core import compact as compact_set
from trainer.core import full as full_set
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.kinematics import kinematics
from trainer.core.scheme import COMPACT, LONGITUDINAL


@kernel
def eliminate(system: Numbers, n: int) -> None:
    """Bring the n x n linear ``system``, right side in column n, to triangular form by rows."""
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(system[i, k]) > abs(system[pivot, k]):
                pivot = i
        for j in range(k, n + 1):
            system[k, j], system[pivot, j] = system[pivot, j], system[k, j]
        for i in range(k + 1, n):
            factor = system[i, k] / system[k, k]
            for j in range(k + 1, n + 1):
                system[i, j] -= factor * system[k, j]


@kernel
def solve(system: Numbers, n: int, out: Numbers) -> None:
    """Write the solution of the n x n linear ``system`` (right side in column n) to ``out``.

    Gaussian elimination with row pivoting; destroys ``system``. A singular matrix gives numbers
    that are not finite, which the caller's check reports.
    """
    eliminate(system, n)
    for k in range(n - 1, -1, -1):
        total = system[k, n]
        for j in range(k + 1, n):
            total -= system[k, j] * out[j]
        out[k] = total / system[k, k]


@kernel
def exact(inertia: Numbers, force: Numbers, system: Numbers, out: Numbers) -> None:
    """Write the accelerations that satisfy all six equations at once: EVAL."""
    for i in range(6):
        for j in range(6):
            system[i, j] = inertia[i, j]
        system[i, 6] = force[i]
    solve(system, 6, out)


@kernel
def sweep(inertia: Numbers, force: Numbers, out: Numbers) -> None:
    """Write each acceleration from its own equation in the order u v w p q r: EVAL 1.

    ``out`` holds the last cycle's accelerations on entry; one already renewed is used as such
    (errata C25-C27).
    """
    for i in range(6):
        total = force[i]
        for j in range(6):
            if j != i:
                total -= inertia[i, j] * out[j]
        out[i] = total / inertia[i, i]


@part
def compact_accelerations(compact: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write u' v' w' p' q' r' by the compact set."""
    how = scheme[0]
    work = scratch[0]
    acceleration = state[0].rates[:6]
    compact_set.forces(compact, how.trig, state, work.force)
    if compact[0].extended != 0.0:
        compact_set.further_forces(compact, state, work.force)
    off_centre = compact_set.off_centre(compact, state)
    if off_centre:
        compact_set.off_centre_forces(compact, how.trig, state, work.force)
    compact_set.add_external(compact, work.external, work.force)
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


@part
def full_accelerations(vessel: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write u' v' w' p' q' r' by the full set, or by its vertical plane."""
    how = scheme[0]
    work = scratch[0]
    acceleration = state[0].rates[:6]
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


@kernel
def rates(vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record) -> None:
    """Write all twelve rates for the state as it stands.

    With lagged accelerations those in the record on entry are last cycle's.
    """
    if scheme[0].equations == COMPACT:
        compact_accelerations(compact, scheme, state, scratch)
    else:
        full_accelerations(vessel, scheme, state, scratch)
    kinematics(scheme[0].trig, state)
