"""Random numbers of a sweep: each a pure function of seed, stream and member."""

import math

from trainer.core.elementary import logarithm
from trainer.core.kernel import Numbers, kernel
from trainer.core.noise import uniform

# M. Wichura, Algorithm AS 241, Appl. Statist. 37 (1988) 477: numerator
# and denominator near the middle, in the tails, and far out in them, each from its highest power
MIDDLE, MIDDLE_SQUARED, TAIL = 0.425, 0.180625, 5.0
MIDDLE_UP = (
    *(2509.0809287301226727, 33430.575583588128105, 67265.770927008700853),
    *(45921.953931549871457, 13731.693765509461125, 1971.5909503065514427),
    *(133.14166789178437745, 3.387132872796366608),
)
MIDDLE_DOWN = (
    *(5226.495278852545925, 28729.085735721942674, 39307.89580009271061),
    *(21213.794301586595867, 5394.1960214247511077, 687.1870074920579083),
    *(42.313330701600911252, 1.0),
)
TAIL_UP = (
    *(7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177),
    *(1.27045825245236838258, 3.64784832476320460504, 5.7694972214606914055),
    *(4.6303378461565452959, 1.42343711074968357734),
)
TAIL_DOWN = (
    *(1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966),
    *(0.14810397642748007459, 0.68976733498510000455, 1.6763848301838038494),
    *(2.05319162663775882187, 1.0),
)
FAR_UP = (
    *(2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386),
    *(0.026532189526576123093, 0.29656057182850489123, 1.7848265399172913358),
    *(5.4637849111641143699, 6.6579046435011037772),
)
FAR_DOWN = (
    *(2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5),
    *(7.868691311456132591e-4, 0.0148753612908506148525, 0.13692988092273580531),
    *(0.59983220655588793769, 1.0),
)


@kernel
def ratio(up: tuple[float, ...], down: tuple[float, ...], x: float) -> float:
    """Return the quotient [-] of two polynomials, highest powers first."""
    above, below = 0.0, 0.0
    for i in range(len(up)):
        above = above * x + up[i]
        below = below * x + down[i]
    return above / below


@kernel
def normal_quantile(share: float) -> float:
    """Return the normal deviate [-] below which ``share`` of them lie, 0 < share < 1."""
    away = share - 0.5
    if abs(away) <= MIDDLE:
        return away * ratio(MIDDLE_UP, MIDDLE_DOWN, MIDDLE_SQUARED - away * away)
    tail = share if away < 0.0 else 1.0 - share
    r = math.sqrt(-logarithm(tail))
    size = ratio(TAIL_UP, TAIL_DOWN, r - 1.6) if r <= TAIL else ratio(FAR_UP, FAR_DOWN, r - TAIL)
    return -size if away < 0.0 else size


@kernel
def fill_uniforms(seed: int, stream: int, first: int, out: Numbers) -> None:
    """Write the numbers [-] between 0 and 1 of the members from ``first`` on."""
    for i in range(out.size):
        out[i] = uniform(seed, stream, first + i)


@kernel
def fill_normals(shares: Numbers, out: Numbers) -> None:
    """Write the normal deviates [-] below which ``shares`` of them lie."""
    for i in range(out.size):
        out[i] = normal_quantile(shares[i])
