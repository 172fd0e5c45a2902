"""How a boat is computed: equation set, accelerations, trigonometry, integrator, step."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Record

FULL, COMPACT, LONGITUDINAL = 0, 1, 2
ADAMS, MULTISTEP, RUNGE_KUTTA, VARIABLE_RUNGE_KUTTA = 0, 1, 2, 3
MULTISTEPS: Final = (ADAMS, MULTISTEP)  # multistep methods; those of Adams ask for no past motion

TRIGGERS: Final = 8  # at most, of one run
DEPTH: Final = 3  # cycles a multistep method may use, the last one included

SCHEME: Final = np.dtype(
    (
        np.record,
        [
            ("h", "f8"),  # [s] step
            ("equations", "i8"),
            ("exact", "i8"),  # 1 exact solve, 0 lagged sweep
            ("trig", "i8"),  # see kinematics
            ("envelope", "i8"),  # 1 the boat wherever it is taken, 0 the equations of 1969 alone
            ("method", "i8"),
            ("depth", "i8"),  # cycles the multistep method uses
            ("a", "f8", (DEPTH,)),
            ("b", "f8", (DEPTH,)),
            # triggers armed for the run: when sense times (state less threshold) is positive
            ("trigger_place", "f8", (TRIGGERS,)),  # of the quantity in the state
            ("trigger_sense", "f8", (TRIGGERS,)),  # 1 or -1
            ("trigger_threshold", "f8", (TRIGGERS,)),
            ("trigger_strict", "f8", (TRIGGERS,)),  # 0: or zero
            ("trigger_kind", "f8", (TRIGGERS,)),  # casualty that then begins; 0: not armed
            ("trigger_amount", "f8", (TRIGGERS,)),
            ("trigger_ticks", "f8", (TRIGGERS,)),
            ("trigger_again", "f8", (TRIGGERS,)),  # 1: whenever its condition comes true anew
        ],
    )
)


class Multistep(NamedTuple):
    """X_n = sum a_i X_n-i + h sum b_i X'_n-i, the report's I(z) as a rational function of 1/z."""

    a: tuple[float, ...]
    b: tuple[float, ...]


INTEGRATORS: Final[Mapping[str, Multistep]] = MappingProxyType(
    {
        # [ASSES] III-B: Euler, 2nd-order Adams, and its third option with interval (-4, 0)
        "euler": Multistep((1.0,), (1.0,)),
        "adams2": Multistep((1.0,), (1.5, -0.5)),
        "best2": Multistep((1.0,), (0.75, 0.25)),
        "adams3": Multistep((1.0,), (23 / 12, -16 / 12, 5 / 12)),
    }
)
RUNGE_KUTTAS: Final[Mapping[str, int]] = MappingProxyType(
    {"rk4": RUNGE_KUTTA, "rkv": VARIABLE_RUNGE_KUTTA}
)


def new_scheme(h: float, equations: int, *, exact: bool, trig: int) -> Record:
    """Return a scheme of 2nd-order Adams at step ``h`` [s]."""
    scheme = np.zeros(1, SCHEME)
    scheme["h"], scheme["equations"], scheme["exact"], scheme["trig"] = h, equations, exact, trig
    scheme["envelope"] = 1
    set_multistep(scheme, INTEGRATORS["adams2"])
    return scheme


def equations_alone(scheme: Record) -> Record:
    """Return a copy that asks for the equations of 1969 alone, in deep water."""
    alone = scheme.copy()
    alone["envelope"] = 0
    return alone


def set_multistep(scheme: Record, method: Multistep) -> None:
    """Make ``scheme`` integrate by ``method``; raise ValueError for one that cannot be used."""
    if not 1 <= max(len(method.a), len(method.b)) <= DEPTH:
        raise ValueError(f"a multistep method looks back 1 to {DEPTH} cycles")
    if abs(sum(method.a) - 1.0) > 1e-12:
        raise ValueError(f"the a_i add up to {sum(method.a):g}; consistency needs 1")
    drift = sum(method.b) - sum(i * a for i, a in enumerate(method.a, start=1))
    if abs(drift) > 1e-9:
        raise ValueError(f"sum of b_i less sum of i a_i is {drift:g}; consistency needs 0")
    if max(abs(np.roots([1.0, *(-a for a in method.a)]))) > 1.0 + 1e-9:
        raise ValueError("the a_i alone make the solution grow: not zero-stable at any step")
    scheme["method"] = MULTISTEP if any(method.a[1:]) else ADAMS
    scheme["depth"] = max(len(method.a), len(method.b))
    scheme["a"] = np.pad(method.a, (0, DEPTH - len(method.a)))
    scheme["b"] = np.pad(method.b, (0, DEPTH - len(method.b)))


def set_runge_kutta(scheme: Record, kind: int) -> None:
    """Make ``scheme`` integrate by the Runge-Kutta method of ``kind``."""
    scheme["method"] = kind
