"""Accelerations from forces: the exact solve (EVAL) and the lagged sweep (EVAL 1).

The names are those of [ASSES]. Each of the six equations has accelerations of the others in it. The
exact solve satisfies all at once. The sweep takes last cycle's value of an acceleration that is not
renewed yet, which saved time in 1969.

``rates`` and ``wide`` end each evaluation with one of the two; ``trim`` solves its Newton step
here.
"""

from typing import Final

from trainer.core.kernel import Numbers, kernel

EQUATIONS: Final = 6  # and the column of their right side


@kernel
def eliminate(system: Numbers, n: int) -> None:
    """Bring an n x n linear ``system`` to triangular form by rows.

    Its right side is in column n.
    """
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
    """Write the solution of an n x n linear ``system`` to ``out``.

    Its right side is in column n. Gaussian elimination with row pivoting; ``system`` is destroyed.
    A singular matrix gives numbers that are not finite, which the caller's check reports.
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
        system[i, EQUATIONS] = force[i]
    solve(system, EQUATIONS, out)


@kernel
def sweep(inertia: Numbers, force: Numbers, out: Numbers) -> None:
    """Write each acceleration from its own equation: EVAL 1.

    The order is u v w p q r. ``out`` holds last cycle's accelerations on entry; those already
    renewed are used as such (errata C25-C27).
    """
    for i in range(6):
        total = force[i]
        for j in range(6):
            if j != i:
                total -= inertia[i, j] * out[j]
        out[i] = total / inertia[i, i]
