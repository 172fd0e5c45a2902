"""``trainer identify --armax``: models of rising order, as text and as a plot.

``cli/workshop/identify`` prints it. ``fitting/armax`` estimates the models; a user compares orders
here, and takes the least that leaves white residuals. A higher order always fits the record better:
Akaike's and Schwarz's criteria and the F test say when the gain is no more than chance gives (MI
8.3, 9).
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, NamedTuple

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.armax import (
    Armax,
    FirstOrder,
    detrend,
    fit_armax,
    remove_delay,
    rounding_poles,
    without_wind,
)
from trainer.identify.judge.residuals import (
    Residuals,
    aic_of_loss,
    bic_of_loss,
    describe_tests,
    examine_residuals,
    f_test,
)
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.pages.identify import correlation_panels, residual_table
from trainer.identify.record.measurements import check_count, samples_of
from trainer.identify.record.study import Study, observe_record
from trainer.identify.sheet import screens_of
from trainer.report.plots import Screen
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap

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


@dataclass(frozen=True)
class ArmaxReport:
    """All that ``trainer identify --armax`` says."""

    study: str
    source: str
    output: str
    unit: str
    samples: int
    interval_s: float
    removed: str
    dead_time: int
    findings: tuple[str, ...]
    orders: tuple[OrderTrial, ...]
    by_aic: int
    by_bic: int
    by_test: int
    first_order: FirstOrder | None  # of heading, from order 2
    verdicts: tuple[str, ...]  # on the order of least AIC


def carry_out(study: Study) -> tuple[ArmaxReport, OrderComparison]:
    """Return the models of a study. ConfigError if its record has gaps or is too short."""
    settings = study.armax
    if settings is None:
        raise ConfigError(f"{study.path.name}: lacks [armax]")
    record = observe_record(study)
    if settings.output not in record.channels:
        known = " or ".join(name for name in OUTPUT_UNITS if name in record.channels)
        remedy = f": say --output {known}" if known else ""
        raise ConfigError(f"{record.source}: no {settings.output} was recorded{remedy}")
    samples = samples_of(record, (settings.output,))
    if len(samples.steps[0]) > 1:
        raise ConfigError(f"{record.source}: ARMAX needs one interval; this record has more")
    how, dead = settings.remove, int(settings.dead_time)
    if not samples.whole:
        raise ConfigError(f"{record.source}: ARMAX needs a record without missing values; cut it")
    most, initial = int(settings.most), settings.initial != "no"
    check_count(record, samples.counted, (4 if initial else 3) * most)
    y, u = remove_delay(
        detrend(samples.outputs[:, 0], how), detrend(samples.inputs[:, 0], how), dead
    )
    orders = try_orders(y, u, most, initial=initial, lags=int(settings.lags))
    ship = None
    if settings.output == "heading" and most > 1:
        with suppress(ConfigError):  # it may have none
            ship = without_wind(orders.models[1], record.interval)
    report = ArmaxReport(
        study=study.heading.name,
        source=record.source,
        output=settings.output,
        unit=OUTPUT_UNITS[settings.output][0],
        samples=len(y),
        interval_s=record.interval,
        removed=how,
        dead_time=dead,
        findings=tuple(map(str, record.findings)),
        orders=orders.tried,
        by_aic=orders.by_aic.order,
        by_bic=orders.by_bic.order,
        by_test=orders.by_test.order,
        first_order=ship,
        verdicts=tuple(describe_tests(orders.by_aic.residuals)),
    )
    return report, orders


def render(report: ArmaxReport) -> str:
    """Return the report as text."""
    lines = [
        f"ARMAX MODELS of {report.output} by rudder (IDPAC)",
        f"{INDENT}{cut_text(report.study, 70)}",
        f"{INDENT}{cut_text(report.source, 75)}",
        f"{INDENT}{report.samples} samples every {report.interval_s:g} s",
        f"{INDENT}removed: {report.removed}; dead time {report.dead_time} samples",
    ]
    if report.findings:
        lines += ["", *items(report.findings)]
    rows = [
        (
            str(row.order),
            str(row.parameters),
            f"{row.loss:.6g}",
            f"{row.deviation:.4g}",
            f"{row.aic:.2f}",
            f"{row.bic:.2f}",
            format_number(row.f, ".2f"),
            format_number(row.f_probability, ".3f"),
            f"{row.residuals.whiteness.probability:.3f}",
            f"{row.residuals.feedback.probability:.3f}",
        )
        for row in report.orders
    ]
    heads = ("order", "p", "V", "lambda", "AIC", "BIC", "F", "p(F)", "white\np", "feedback\np")
    chosen_by = f"Order by AIC {report.by_aic}, by BIC {report.by_bic}, by F {report.by_test}"
    lines += ["", *table(heads, rows), "", f"{INDENT}{chosen_by}"]
    chosen = next(row for row in report.orders if row.order == report.by_aic)
    lines += ["", *_coefficient_table(chosen), "", *_root_lines(chosen)]
    if report.first_order is not None:
        ship = report.first_order
        lines += ["", f"{INDENT}Order 2 without wind: K {ship.K:.4g} 1/s, T {ship.T:.4g} s"]
    lines += ["", *residual_table((chosen.residuals,))]
    lines += items(report.verdicts)
    return "\n".join(lines)


def _coefficient_table(row: OrderTrial) -> list[str]:
    rows = [
        (one.name, f"{one.value:.5g}", format_number(one.deviation, ".2g"))
        for one in row.coefficients
    ]
    return table((f"order {row.order}", "estimate", "std dev"), rows)


def _root_lines(row: OrderTrial) -> list[str]:
    """Return poles and zeros in the z plane."""
    lines = wrap(f"Poles {_roots(row.poles)}", INDENT, 2 * INDENT)
    lines += wrap(f"Zeros {_roots(row.zeros)}", INDENT, 2 * INDENT)
    lines += items(
        f"the pole {pole:.2f} beside the zero {zero:.2f} is of rounded readings, not a ship"
        for pole, zero in row.rounding
    )
    if row.inseparable:
        lines += wrap(f"- the record cannot separate {', '.join(row.inseparable)}")
    return lines


def _roots(roots: tuple[tuple[float, float], ...]) -> str:
    """Return roots as text, of a pair the one above the axis."""
    shown = [(real, imag) for real, imag in roots if imag >= 0.0]
    texts = (f"{real:+.3f}" + (f" +-{imag:.3f}i" if imag else "") for real, imag in shown)
    return ", ".join(texts) or "none"


def screens(orders: OrderComparison) -> tuple[Screen, ...]:
    """Return the correlations of the residuals of the order of least AIC."""
    return screens_of({"Correlations": correlation_panels((orders.by_aic.residuals,))})
