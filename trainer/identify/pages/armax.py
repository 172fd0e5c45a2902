"""``trainer identify --armax``: models of rising order, as text and as a plot.

``cli/identify`` prints it. ``fitting/armax`` estimates the models; a user compares orders here, and
takes the least that leaves white residuals.
"""

from contextlib import suppress
from dataclasses import dataclass

from trainer.config.files import ConfigError
from trainer.identify.fitting.armax import FirstOrder, detrend, remove_delay, without_wind
from trainer.identify.judge.orders import OrderComparison, OrderTrial, try_orders
from trainer.identify.judge.residuals import describe_tests
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.pages.identify import correlation_panels, residual_table
from trainer.identify.record.measurements import check_count, samples_of
from trainer.identify.record.study import Study, observe_record
from trainer.identify.sheet import screens_of
from trainer.report.plots import Screen
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap


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
