"""How many parameters a record supports: F test, Akaike's criterion, likelihood ratio (8.3).

For a scalar output V = 1/2 sum eps^2 over N samples; p counts coefficients and estimated initial
states, the noise variance not.
"""

import math
from typing import NamedTuple

from trainer.config import ConfigError


class OrderTest(NamedTuple):
    """A model against a larger one: the statistic, and how probable one so large is by chance."""

    statistic: float
    freedom: tuple[int, ...]
    probability: float  # [-] small: the larger model is worth it

    @property
    def prefers_larger(self) -> bool:
        """Return whether the larger model is better at the 5 % level."""
        return self.probability < 0.05


def f_test(small: tuple[float, int], large: tuple[float, int], samples: int) -> OrderTest:
    """Return F of two (V, p), against F(p2 - p1, N - p2).

    ConfigError if the larger has no more parameters or leaves no samples over.
    """
    (v1, p1), (v2, p2) = small, large
    if p2 <= p1:
        raise ConfigError(f"F test: {p2} parameters are not more than {p1}")
    if samples <= p2:
        raise ConfigError(f"F test: {samples} samples are too few for {p2} parameters")
    from scipy.special import fdtrc  # noqa: PLC0415

    statistic = (v1 - v2) / v2 * (samples - p2) / (p2 - p1)
    freedom = (p2 - p1, samples - p2)
    return OrderTest(statistic, freedom, float(fdtrc(*freedom, max(statistic, 0.0))))


def aic_of_loss(loss: float, samples: int, parameters: int) -> float:
    """Return AIC = N ln(2V/N) + N(1 + ln 2 pi) + 2p of a scalar output."""
    spread = samples * math.log(2.0 * loss / samples)
    return spread + samples * (1.0 + math.log(2.0 * math.pi)) + 2.0 * parameters


def bic_of_loss(loss: float, samples: int, parameters: int) -> float:
    """Return Schwarz's criterion, AIC with p ln N in place of 2p."""
    return aic_of_loss(loss, samples, parameters) + parameters * (math.log(samples) - 2.0)


def aic_of_likelihood(log_likelihood: float, parameters: int) -> float:
    """Return AIC = -2 log L + 2p."""
    return -2.0 * log_likelihood + 2.0 * parameters


def ratio_test(small: tuple[float, int], large: tuple[float, int]) -> OrderTest:
    """Return 2(log L2 - log L1) of two (log L, p), against chi-square of p2 - p1.

    ConfigError if the larger has no more parameters.
    """
    (l1, p1), (l2, p2) = small, large
    if p2 <= p1:
        raise ConfigError(f"likelihood ratio: {p2} parameters are not more than {p1}")
    from scipy.special import chdtrc  # noqa: PLC0415

    statistic = 2.0 * (l2 - l1)
    return OrderTest(statistic, (p2 - p1,), float(chdtrc(p2 - p1, statistic)))
