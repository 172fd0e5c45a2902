"""Straight level flight: the state in which all accelerations and the depth rate are zero.

A boat begins in it, and linear models are taken about it. Newton's method seeks seven unknowns for
seven rates.

``start`` seeks it for each run; ``analysis/programs/neutral`` takes it as the neutral point of a
speed.
"""

from trainer.core.kernel import Record, kernel
from trainer.core.rates import rates
from trainer.core.solve import solve

STERN_PLANES, BOTH_PLANES = (
    0,
    1,
)  # by stern planes and angle of attack; or level, by both pairs of planes

UNKNOWNS = 7  # and the column of the right side
MAX_ROUNDS = 50
NUDGE_SIZE = 1e-6  # [m/s] or [rad] for the difference quotients
TRIM_TOLERANCE = 1e-13  # [m/s2], [rad/s2], [m/s]


@kernel
def nudge(state: Record, by: int, unknown: int, amount: float) -> None:
    """Add ``amount`` to one of the seven unknowns.

    It is for a difference quotient, or a step of Newton's.
    """
    s = state[0]
    if unknown == 0:
        s.u_c += amount
    elif unknown == 1:
        s.v += amount
    elif unknown == 2:
        if by == STERN_PLANES:
            s.w += amount
        else:
            s.delta_b += amount
    elif unknown == 3:
        s.phi += amount
    elif unknown == 4:
        s.delta_s += amount
    elif unknown == 5:
        s.delta_r += amount
    else:
        s.theta += amount


@kernel
def residual(state: Record, unknown: int) -> float:
    """Return one of the seven rates that vanish in trim."""
    s = state[0]
    return s.zdot if unknown == 6 else s.rates[unknown]


@kernel
def trim(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, by: int
) -> int:
    """Bring ``state`` into trim at its speed u.

    Return 1 if Newton's method settled, else 0. It adjusts u_c, v, w (or delta_b), phi, theta,
    delta_s, delta_r. ``scheme`` must ask for the exact solve. This is the exact trim of the model
    document, section 6, in all six degrees of freedom.
    """
    work = scratch[0]
    jacobian, change = work.jacobian, work.change
    for _ in range(MAX_ROUNDS):
        for column in range(7):
            nudge(state, by, column, NUDGE_SIZE)
            rates(vessel, compact, scheme, state, scratch)
            for row in range(7):
                jacobian[row, column] = residual(state, row)
            nudge(state, by, column, -2.0 * NUDGE_SIZE)
            rates(vessel, compact, scheme, state, scratch)
            for row in range(7):
                jacobian[row, column] -= residual(state, row)
            nudge(state, by, column, NUDGE_SIZE)
        rates(vessel, compact, scheme, state, scratch)
        worst = 0.0
        for row in range(7):
            slope = 0.0
            for column in range(7):
                jacobian[row, column] /= 2.0 * NUDGE_SIZE
                slope += abs(jacobian[row, column])
            if slope == 0.0:  # masked: there is nothing to bring to zero
                jacobian[row, row] = 1.0
            jacobian[row, UNKNOWNS] = -residual(state, row)
            worst = max(worst, abs(jacobian[row, UNKNOWNS]))
        if worst < TRIM_TOLERANCE:
            return 1
        solve(jacobian, UNKNOWNS, change)
        for column in range(7):
            nudge(state, by, column, change[column])
    return 1 if worst < 1e3 * TRIM_TOLERANCE else 0
