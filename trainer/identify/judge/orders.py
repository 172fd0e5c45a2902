"""ARMAX models of rising order, and which of them the record supports (MI 8.3, 9)."""

from dataclasses import dataclass

from trainer.core.kernel import Numbers
from trainer.identify.fitting.armax import ArmaxFit, fit_armax
from trainer.identify.judge.residuals import (
    OrderTest,
    Residuals,
    aic_of_loss,
    bic_of_loss,
    examine_residuals,
    f_test,
)


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
