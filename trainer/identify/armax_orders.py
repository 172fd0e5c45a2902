"""The order of ARMAX that a record supports, and the ship of that model."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.armax import Armax, ArmaxFit, fit_armax
from trainer.identify.residuals import (
    OrderTest,
    Residuals,
    aic_of_loss,
    bic_of_loss,
    examine_residuals,
    f_test,
)

TREATMENTS: Final = ("none", "mean", "trend")
CANCELLED: Final = 0.15  # [-] distance of a zero from a pole that it nearly cancels


@dataclass(frozen=True)
class Order:
    """One order tried."""

    fit: ArmaxFit
    aic: float
    bic: float
    better: OrderTest | None  # than the order before
    residuals: Residuals


@dataclass(frozen=True)
class Orders:
    """All orders tried, and which of them the criteria choose."""

    tried: tuple[Order, ...]

    @property
    def by_aic(self) -> Order:
        """Return the order of the least AIC."""
        return min(self.tried, key=lambda order: order.aic)

    @property
    def by_bic(self) -> Order:
        """Return the order of the least Schwarz criterion."""
        return min(self.tried, key=lambda order: order.bic)

    @property
    def by_test(self) -> Order:
        """Return the first order whose successor is no improvement at the 5 % level."""
        for order, following in zip(self.tried, self.tried[1:], strict=False):
            if following.better is not None and not following.better.prefers_larger:
                return order
        return self.tried[-1]


def detrend(series: Numbers, treatment: str) -> Numbers:
    """Return the series less its mean or its straight line; ConfigError for another word."""
    if treatment == "none":
        return series
    if treatment == "mean":
        return np.asarray(series - series.mean())
    if treatment == "trend":
        t = np.arange(len(series), dtype=float)
        return np.asarray(series - np.polyval(np.polyfit(t, series, 1), t))
    raise ConfigError(f"remove {treatment!r}: must be {' or '.join(TREATMENTS)}")


def remove_delay(y: Numbers, u: Numbers, samples: int) -> tuple[Numbers, Numbers]:
    """Return output and input with a dead time taken out: y earlier by ``samples``."""
    if samples == 0:
        return y, u
    return y[samples:], u[:-samples]


def try_orders(y: Numbers, u: Numbers, most: int, *, initial: bool, lags: int) -> Orders:
    """Return the models of order 1 to ``most``. Output y and input u are (N,)."""
    tried: list[Order] = []
    for n in range(1, most + 1):
        before = tried[-1].fit if tried else None
        fit = fit_armax(y, u, n, initial=initial, lower=before.model if before else None)
        left = fit.model.residuals(y, u)
        better = None
        if before is not None:
            pair = (before.loss, before.parameters), (fit.loss, fit.parameters)
            better = f_test(*pair, len(y))
        tried.append(
            Order(
                fit=fit,
                aic=aic_of_loss(fit.loss, len(y), fit.parameters),
                bic=bic_of_loss(fit.loss, len(y), fit.parameters),
                better=better,
                residuals=examine_residuals("output", left, u, lags, fitted=2 * n),
            )
        )
    return Orders(tuple(tried))


class FirstOrder(NamedTuple):
    """The first-order Nomoto model K/(1 + T s) in a heading's second-order ARMAX model."""

    K: float  # [1/s]
    T: float  # [s]
    pole: float  # [-] per sample


def without_wind(model: Armax, interval: float) -> FirstOrder:
    """Return K and T of rudder to heading (9). A is replaced by (z - 1)(z - p), p = -a1 - 1.

    The other pole is that of heading: 1 without wind. ConfigError unless the order is 2 and p is
    between 0 and 1.
    """
    if model.order != 2:
        raise ConfigError(f"a first-order ship needs an ARMAX model of order 2, not {model.order}")
    p = -model.a[0] - 1.0
    if not 0.0 < p < 1.0:
        raise ConfigError(f"the pole {p:.3g} per sample is no time constant")
    gain = sum(model.b) / ((1.0 - p) * interval)
    return FirstOrder(gain, -interval / math.log(p), p)


def rounding_poles(model: Armax) -> tuple[tuple[float, float], ...]:
    """Return the negative real poles that a zero nearly cancels.

    They show a rounded reading, not a ship.
    """
    found = []
    for pole in model.poles:
        if abs(pole.imag) > 1e-9 or pole.real >= 0.0:
            continue
        near = min(model.zeros, key=lambda zero: abs(zero - pole), default=None)
        if near is not None and abs(near - pole) < CANCELLED:
            found.append((pole.real, near.real))
    return tuple(found)
