"""ARMAX models of rising order, and which of them the record supports (MI 8.3, 9).

A higher order always fits the record better. Akaike's and Schwarz's criteria and the F test say
when the gain is no more than chance gives. ``pages/armax`` shows the table.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from trainer.core.kernel import Numbers
from trainer.identify.fitting.armax import Armax, fit_armax, rounding_poles
from trainer.identify.judge.residuals import (
    Residuals,
    aic_of_loss,
    bic_of_loss,
    examine_residuals,
    f_test,
)

BETTER_LEVEL: Final = 0.05  # [-] probability by chance, below which a larger model is better


@dataclass(frozen=True)
class ArmaxCoefficient:
    """One coefficient and its standard deviation, None where the record does not tell."""

    name: str
    value: float
    deviation: float | None


@dataclass(frozen=True)
class OrderTrial:
    """One order tried."""

    order: int
    parameters: int
    loss: float  # V
    deviation: float  # lambda, in the unit of the output
    aic: float
    bic: float
    f: float | None  # against the order before
    f_probability: float | None
    converged: bool
    coefficients: tuple[ArmaxCoefficient, ...]
    poles: tuple[tuple[float, float], ...]  # real and imaginary part
    zeros: tuple[tuple[float, float], ...]
    rounding: tuple[tuple[float, float], ...]  # negative poles that a zero cancels
    inseparable: tuple[str, ...]
    residuals: Residuals


class OrderComparison(NamedTuple):
    """All orders tried with their models, and which of them the criteria choose."""

    tried: tuple[OrderTrial, ...]
    models: tuple[Armax, ...]

    @property
    def by_aic(self) -> OrderTrial:
        """Return the order of the least AIC."""
        return min(self.tried, key=lambda order: order.aic)

    @property
    def by_bic(self) -> OrderTrial:
        """Return the order of the least Schwarz criterion."""
        return min(self.tried, key=lambda order: order.bic)

    @property
    def by_test(self) -> OrderTrial:
        """Return the first order whose successor is no improvement at the 5 % level."""
        for order, following in zip(self.tried, self.tried[1:], strict=False):
            if following.f_probability is not None and following.f_probability >= BETTER_LEVEL:
                return order
        return self.tried[-1]


def try_orders(y: Numbers, u: Numbers, most: int, *, initial: bool, lags: int) -> OrderComparison:
    """Return the models of order 1 to ``most``. Output y and input u are (N,)."""
    tried, models = list[OrderTrial](), list[Armax]()
    for n in range(1, most + 1):
        fit = fit_armax(y, u, n, initial=initial, lower=models[-1] if models else None)
        before, model = (tried[-1] if tried else None), fit.model
        sizes = fit.loss, fit.parameters
        better = None
        if before is not None:
            better = f_test((before.loss, before.parameters), sizes, len(y))
        known = zip(fit.names, fit.deviations, strict=True)
        models.append(model)
        tried.append(
            OrderTrial(
                order=n,
                parameters=fit.parameters,
                loss=fit.loss,
                deviation=fit.deviation,
                aic=aic_of_loss(fit.loss, len(y), fit.parameters),
                bic=bic_of_loss(fit.loss, len(y), fit.parameters),
                f=better.statistic if better else None,
                f_probability=better.probability if better else None,
                converged=fit.converged,
                coefficients=tuple(
                    ArmaxCoefficient(name, model.value(name), s if math.isfinite(s) else None)
                    for name, s in known
                ),
                poles=tuple((root.real, root.imag) for root in model.poles),
                zeros=tuple((root.real, root.imag) for root in model.zeros),
                rounding=rounding_poles(model),
                inseparable=fit.inseparable,
                residuals=examine_residuals("output", model.residuals(y, u), u, lags, fitted=2 * n),
            )
        )
    return OrderComparison(tuple(tried), tuple(models))
