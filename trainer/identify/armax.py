"""ARMAX models, section 9 of the model identification.

y_t + a1 y_(t-1) + ... = b1 u_(t-1) + ... + e_t + c1 e_(t-1) + ..., n coefficients each, and d1 to
dn in the first n equations where the initial state is estimated.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.armax import combined, filtered, simulated

KINDS: Final = ("a", "b", "c", "d")


@dataclass(frozen=True)
class Armax:
    """A model of order n; ``d`` is () where the initial state is taken as zero."""

    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    d: tuple[float, ...]

    @classmethod
    def of(cls, numbers: Numbers, order: int) -> "Armax":
        """Return the model of the coefficients in the order a, b, c, d."""
        parts = [tuple(map(float, numbers[i : i + order])) for i in range(0, 4 * order, order)]
        return cls(*parts)

    @property
    def order(self) -> int:
        """Return n."""
        return len(self.a)

    @property
    def poles(self) -> tuple[complex, ...]:
        """Return the zeros of z^n A."""
        return roots_of((1.0, *self.a))

    @property
    def zeros(self) -> tuple[complex, ...]:
        """Return the zeros of z^n B."""
        return roots_of(self.b)

    def residuals(self, y: Numbers, u: Numbers) -> Numbers:
        """Return the one-step errors eps (N,) of output y and input u, both (N,)."""
        a, b, c = (np.asarray(part) for part in (self.a, self.b, self.c))
        w, eps = np.empty_like(y), np.empty_like(y)
        combined(a, b, y, u, w)
        w[: len(self.d)] -= np.asarray(self.d)
        filtered(c, w, eps)
        return eps

    def simulated(self, u: Numbers, e: Numbers) -> Numbers:
        """Return the output (N,) to input u under white disturbance e, both (N,)."""
        a, b = np.asarray(self.a), np.asarray(self.b)
        disturbance = e.copy()
        for i, c in enumerate(self.c, start=1):
            disturbance[i:] += c * e[:-i]
        disturbance[: len(self.d)] += np.asarray(self.d)
        y = np.empty_like(u)
        simulated(a, b, u, disturbance, y)
        return y


def roots_of(polynomial: tuple[float, ...]) -> tuple[complex, ...]:
    """Return the roots, those furthest out first."""
    roots = np.roots(np.trim_zeros(np.array(polynomial), "f"))
    return tuple(complex(root) for root in sorted(roots, key=lambda root: -abs(root)))


def coefficient_names(order: int, *, initial: bool) -> tuple[str, ...]:
    """Return the names of the coefficients of that order, a1 first."""
    kinds = KINDS if initial else KINDS[:3]
    return tuple(f"{kind}{i}" for kind in kinds for i in range(1, order + 1))
