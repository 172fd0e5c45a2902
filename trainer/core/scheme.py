"""How a boat is computed: equation set, accelerations, trigonometry, integrator, step.

A scheme is a record beside that of the boat, so that one boat can be flown by several methods and
compared. Triggers of casualties and the ground's friction stand in it too, because they are
constants of a run.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers, Record

FULL_EQUATIONS, COMPACT_EQUATIONS, LONGITUDINAL_EQUATIONS = 0, 1, 2
ADAMS, MULTISTEP, RUNGE_KUTTA, VARIABLE_RUNGE_KUTTA, PREDICTOR_CORRECTOR = 0, 1, 2, 3, 4
MULTISTEP_CODES: Final = (ADAMS, MULTISTEP)  # multistep methods; those of Adams need no past motion

MAX_TRIGGERS: Final = 8  # at most, of one run
MAX_CYCLES: Final = 4  # cycles a multistep method may use, the last one included; adams4 uses all
MAX_STAGES: Final = 4  # at most, of a Runge-Kutta method

SCHEME: Final = np.dtype(
    (
        np.record,
        [
            ("h", "f8"),  # [s] step
            ("equations", "i8"),
            ("exact", "i8"),  # 1 exact solve, 0 lagged sweep
            ("trig", "i8"),  # see kinematics
            ("envelope", "i8"),  # 1 the boat wherever it goes, 0 the equations of 1969 alone
            ("method", "i8"),
            ("depth", "i8"),  # cycles the multistep method uses
            ("a", "f8", (MAX_CYCLES,)),
            ("b", "f8", (MAX_CYCLES,)),
            # the corrector of what a and b predict: the same, with the predicted rate first
            ("closed_a", "f8", (MAX_CYCLES,)),
            ("closed_b", "f8", (1 + MAX_CYCLES,)),
            # Runge-Kutta: each stage begins at its share of the step along the last one
            ("stages", "i8"),
            ("weight", "f8", (MAX_STAGES,)),
            ("share", "f8", (MAX_STAGES,)),  # of the stage that follows
            ("weight_sum", "f8"),
            # triggers armed for the run: they fire when sense (state - threshold) is positive
            ("trigger_place", "f8", (MAX_TRIGGERS,)),  # of the quantity in the state
            ("trigger_sense", "f8", (MAX_TRIGGERS,)),  # 1 or -1
            ("trigger_threshold", "f8", (MAX_TRIGGERS,)),
            ("trigger_strict", "f8", (MAX_TRIGGERS,)),  # 0: also when it is zero
            ("trigger_kind", "f8", (MAX_TRIGGERS,)),  # casualty that then begins; 0: not armed
            ("trigger_amount", "f8", (MAX_TRIGGERS,)),
            ("trigger_ticks", "f8", (MAX_TRIGGERS,)),
            ("trigger_again", "f8", (MAX_TRIGGERS,)),  # 1: each time its condition becomes true
            # the ground
            ("friction", "f8"),  # [-] of a hull that slides on it
            ("breakout", "f8"),  # [N] lift up to which it holds a hull that lies on it
        ],
    )
)


class Multistep(NamedTuple):
    """A linear multistep formula: X_n = sum a_i X_n-i + h sum b_i X'_n-i.

    It is the report's I(z) as a rational function of 1/z.
    """

    a: tuple[float, ...]
    b: tuple[float, ...]


INTEGRATORS: Final[Mapping[str, Multistep]] = MappingProxyType(
    {
        # [ASSES] III-B: Euler, 2nd-order Adams, and its third option with interval (-4, 0), of
        # first order: "2nd order" there is the order of the difference equation (errata D5)
        "euler": Multistep((1.0,), (1.0,)),
        "adams2": Multistep((1.0,), (1.5, -0.5)),
        "best2": Multistep((1.0,), (0.75, 0.25)),
        # Adams and Bashforth
        "adams3": Multistep((1.0,), (23 / 12, -16 / 12, 5 / 12)),
        "adams4": Multistep((1.0,), (55 / 24, -59 / 24, 37 / 24, -9 / 24)),
    }
)


class PredictorCorrector(NamedTuple):
    """An open formula that predicts X_n, and a closed one that corrects it, once.

    X_n = sum closed.a_i X_n-i + h sum closed.b_i X'_n-i, where i of the second sum begins at 0: the
    rate of what was predicted. The rate of what was corrected is then the next cycle's.
    """

    open: Multistep
    closed: Multistep


def closed_of_three(a3: float) -> Multistep:
    """Return the closed formula of three positions and one rate.

    The formula is the report's "C31" (errata D6), of second order with any ``a3`` [-]. 0 gives
    backward differences of second order, 2/11 those of third.
    """
    return Multistep(((4 + 5 * a3) / 3, -(1 + 8 * a3) / 3, a3), ((2 - 2 * a3) / 3,))


PARABOLA: Final = Multistep((3.0, -3.0, 1.0), ())  # the report's "O30": through three positions
MILNE: Final = Multistep((0.0, 0.0, 0.0, 1.0), (8 / 3, -4 / 3, 8 / 3))
TRAPEZOID: Final = Multistep((1.0,), (0.5, 0.5))  # errata D3: closed, so it only corrects
PAIRS: Final[Mapping[str, PredictorCorrector]] = MappingProxyType(
    {
        "heun": PredictorCorrector(INTEGRATORS["euler"], TRAPEZOID),
        # Adams, Bashforth and Moulton
        "abm2": PredictorCorrector(INTEGRATORS["adams2"], TRAPEZOID),
        "abm3": PredictorCorrector(
            INTEGRATORS["adams3"], Multistep((1.0,), (5 / 12, 8 / 12, -1 / 12))
        ),
        "abm4": PredictorCorrector(
            INTEGRATORS["adams4"], Multistep((1.0,), (9 / 24, 19 / 24, -5 / 24, 1 / 24))
        ),
        # Hamming (1959), after Milne's predictor
        "hamming4": PredictorCorrector(
            MILNE, Multistep((9 / 8, 0.0, -1 / 8), (3 / 8, 6 / 8, -3 / 8))
        ),
        # [ASSES] Table 1 "O30 C31": a_3 solves -(4/7)(1 + 2 a_3)/(1 - a_3) = -0.82, the interval in
        # the table; the report does not give a_3, so it is not proved (errata D6)
        "o30c31": PredictorCorrector(PARABOLA, closed_of_three(0.1266)),
        "bdf2": PredictorCorrector(PARABOLA, closed_of_three(0.0)),
        "bdf3": PredictorCorrector(PARABOLA, closed_of_three(2 / 11)),
    }
)


class RungeKutta(NamedTuple):
    """A Runge-Kutta method in which each stage begins along the last one alone."""

    weights: tuple[float, ...]
    shares: tuple[float, ...]  # [-] of the step, to where the second stage begins and so on
    kind: int = RUNGE_KUTTA


CLASSICAL_STAGES: Final = RungeKutta((1.0, 2.0, 2.0, 1.0), (0.5, 0.5, 1.0))
RUNGE_KUTTAS: Final[Mapping[str, RungeKutta]] = MappingProxyType(
    {
        "rk2": RungeKutta((0.0, 1.0), (0.5,)),  # Runge: the midpoint rule
        "rk3": RungeKutta((1.0, 0.0, 3.0), (1 / 3, 2 / 3)),  # Heun
        "rk4": CLASSICAL_STAGES,
        "rkv": CLASSICAL_STAGES._replace(kind=VARIABLE_RUNGE_KUTTA),
    }
)
INTEGRATOR_NAMES: Final = (*INTEGRATORS, *PAIRS, *RUNGE_KUTTAS)


def new_scheme(h: float, equations: int, *, exact: bool, trig: int) -> Record:
    """Return a scheme of 2nd-order Adams at step ``h`` [s]."""
    scheme = np.zeros(1, SCHEME)
    scheme["h"], scheme["equations"], scheme["exact"], scheme["trig"] = h, equations, exact, trig
    scheme["envelope"] = 1
    set_multistep(scheme, INTEGRATORS["adams2"])
    return scheme


def equations_alone(scheme: Record) -> Record:
    """Return a copy that asks for the equations of 1969 alone, in deep water.

    Trim, linear models and the report's programs are of those equations.
    """
    alone = scheme.copy()
    alone["envelope"] = 0
    return alone


def require_consistent(method: Multistep, past: int) -> None:
    """Raise ValueError for a formula of too many cycles, or of less than first order.

    ``past`` is how many of its rates are of past cycles.
    """
    if not 1 <= max(len(method.a), past) <= MAX_CYCLES:
        raise ValueError(f"a multistep method looks back 1 to {MAX_CYCLES} cycles")
    if abs(sum(method.a) - 1.0) > 1e-12:
        raise ValueError(f"the a_i add up to {sum(method.a):g}; consistency needs 1")
    drift = sum(method.b) - sum(i * a for i, a in enumerate(method.a, start=1))
    if abs(drift) > 1e-9:
        raise ValueError(f"sum of b_i less sum of i a_i is {drift:g}; consistency needs 0")


def require_zero_stable(method: Multistep) -> None:
    """Raise ValueError for a formula that makes a boat at rest run away."""
    if max(abs(np.roots([1.0, *(-a for a in method.a)]))) > 1.0 + 1e-9:
        raise ValueError("the a_i alone make the solution grow: not zero-stable at any step")


def padded(numbers: tuple[float, ...], count: int) -> Numbers:
    """Return the numbers with zeros after them, (count,)."""
    return np.pad(np.array(numbers), (0, count - len(numbers)))


def set_multistep(scheme: Record, method: Multistep) -> None:
    """Make ``scheme`` integrate by ``method``; raise ValueError for one that cannot be used."""
    require_consistent(method, len(method.b))
    require_zero_stable(method)
    scheme["method"] = MULTISTEP if any(method.a[1:]) else ADAMS
    scheme["depth"] = max(len(method.a), len(method.b))
    scheme["a"], scheme["b"] = padded(method.a, MAX_CYCLES), padded(method.b, MAX_CYCLES)


def set_pair(scheme: Record, pair: PredictorCorrector) -> None:
    """Make ``scheme`` predict and correct; raise ValueError for a pair that cannot be used.

    The predictor alone may be unstable, since its error does not last.
    """
    for method, past in ((pair.open, len(pair.open.b)), (pair.closed, len(pair.closed.b) - 1)):
        require_consistent(method, past)
    require_zero_stable(pair.closed)
    lengths = (len(pair.open.a), len(pair.open.b), len(pair.closed.a), len(pair.closed.b) - 1)
    set_runge_kutta(scheme, CLASSICAL_STAGES)  # near the vertical, and for parts of a step
    scheme["method"], scheme["depth"] = PREDICTOR_CORRECTOR, max(lengths)
    scheme["a"], scheme["b"] = padded(pair.open.a, MAX_CYCLES), padded(pair.open.b, MAX_CYCLES)
    scheme["closed_a"] = padded(pair.closed.a, MAX_CYCLES)
    scheme["closed_b"] = padded(pair.closed.b, 1 + MAX_CYCLES)


def set_runge_kutta(scheme: Record, method: RungeKutta) -> None:
    """Make ``scheme`` integrate by a Runge-Kutta method."""
    scheme["method"], scheme["stages"] = method.kind, len(method.weights)
    scheme["weight"] = padded(method.weights, MAX_STAGES)
    scheme["share"] = padded(method.shares, MAX_STAGES)
    scheme["weight_sum"] = sum(method.weights)
