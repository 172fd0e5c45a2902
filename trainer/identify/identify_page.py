"""A fitted ship as a page for a terminal and as a plot."""

from typing import Final

import numpy as np

from trainer.fitout import KNOT
from trainer.identify.account import Report, carried_out, errors_of
from trainer.identify.fitting import Fitted
from trainer.identify.models import UNITS
from trainer.identify.nomoto import scale
from trainer.identify.prediction import alone
from trainer.identify.residuals import Residuals
from trainer.study.page import INDENT, cut, figure, table, wrapped
from trainer.study.plots import Curve, Panel

__all__ = ["carried_out", "panels", "render"]

BAND: Final = 1.96  # standard deviations


def render(report: Report) -> str:
    """Return the report as text."""
    lines = [
        f"IDENTIFICATION, model {report.model} (LISPID)",
        f"{INDENT}{cut(report.study, 70)}",
        f"{INDENT}{cut(report.source, 75)}",
        f"{INDENT}{report.length_m:g} m, {report.speed_kn:.2f} kn; {_samples(report)}",
        f"{INDENT}" + ", ".join(f"{name} {value}" for name, value in report.settings.items()),
    ]
    if report.findings:
        lines += ["", f"{INDENT}The record:"]
        lines += [line for text in report.findings for line in wrapped(f"- {text}")]
    lines += ["", *_parameter_table(report), "", *_ship_table(report)]
    lines += ["", f"{INDENT}She is {report.stability}."]
    if report.derivatives:
        lines += ["", *_derivative_table(report)]
    lines += ["", *_fit_lines(report)]
    if report.residuals:
        lines += ["", *residual_table(report.residuals)]
        lines += [line for text in report.verdicts for line in wrapped(f"- {text}")]
    if report.check is not None:
        lines += ["", *_check_lines(report)]
    if report.bend is not None:
        kappa, deviation = report.bend.ship.kappa, report.bend.deviation
        lines += ["", f"{INDENT}Large manoeuvres: kappa {kappa:.5g} +- {deviation:.2g} s^2"]
    return "\n".join(lines)


def _samples(report: Report) -> str:
    outputs = ", ".join(report.outputs)
    return f"{report.samples} samples every {report.interval_s:g} s of {outputs}"


def _parameter_table(report: Report) -> list[str]:
    rows = [
        (one.name, one.unit, f"{one.value:.5g}", figure(one.deviation, ".2g"))
        for one in report.parameters
    ]
    return table(("parameter", "unit", "estimate", "std dev"), rows)


def _ship_table(report: Report) -> list[str]:
    """Return gains and time constants in SI, prime and bis units."""
    units = [scale(name, report.length_m, report.speed_kn * KNOT) for name in ("prime", "bis")]
    rows = []
    for one in report.ship:
        others = [
            one.value * {"1/s": unit.time, "s": 1.0 / unit.time, "m/s": 1.0 / unit.speed}[one.unit]
            for unit in units
        ]
        known = figure(one.deviation, ".2g")
        rows.append((one.name, one.unit, f"{one.value:.5g}", known, *(f"{x:.4g}" for x in others)))
    return table(("ship", "unit", "value", "std dev", "prime", "bis"), rows)


def _derivative_table(report: Report) -> list[str]:
    """Return the derivatives, the deviation being of the system that was fitted."""
    rows = [
        (one.name, figure(one.prime, ".5g"), figure(one.bis, ".5g"), figure(one.deviation, ".2g"))
        for one in report.derivatives
    ]
    heads = ("derivative", "prime", "bis", f"std dev\n({report.settings['system']})")
    return table(heads, rows)


def _fit_lines(report: Report) -> list[str]:
    state = f"settled in {report.steps} steps" if report.converged else "DID NOT SETTLE"
    lines = [
        f"{INDENT}Fit {state}: log L {report.log_likelihood:.4f}, AIC {report.aic:.2f}",
        f"{INDENT}V1 {report.loss_1:.4f} one step ahead, {report.loss_1_alone:.4f} by rudder alone",
    ]
    if report.screened:
        lines.append(f"{INDENT}{report.screened} samples were rejected as outliers")
    weakest = ", ".join(report.weakest)
    lines += wrapped(
        f"Known least: {weakest} (scaled eigenvalue {report.eigenvalue:.2g})", INDENT, 2 * INDENT
    )
    return lines


def residual_table(residuals: tuple[Residuals, ...]) -> list[str]:
    """Return the tests of residuals, each with the probability of so large a statistic."""
    rows = [
        (
            one.output,
            f"{one.whiteness.probability:.3f}",
            f"{one.missing_dynamics.probability:.3f}",
            f"{one.feedback.probability:.3f}",
            f"{one.normality.probability:.3f}",
            _sign_changes(one),
        )
        for one in residuals
    ]
    tests = ("white\np", "by rudder\np", "feedback\np", "normal\np", "sign\nchanges")
    heads = ("residuals\nof", *tests)
    return table(heads, rows)


def _sign_changes(one: Residuals) -> str:
    usual = f"{one.sign_changes_expected:.0f} +- {one.sign_changes_deviation:.0f}"
    return f"{one.sign_changes} of {usual}"


def _check_lines(report: Report) -> list[str]:
    check = report.check
    if check is None:
        return []
    rows = [
        (name, UNITS[name][0], f"{rms:.4g}", f"{100.0 * share:.1f}", f"{100.0 * own:.1f}")
        for name, rms, share, own in zip(
            check.outputs, check.rms, check.share, check.own, strict=True
        )
    ]
    shares = ("% of the\nmotion", "% where\nfitted")
    heads = ("predicted by\nrudder alone", "\nunit", "\nrms error", *shares)
    return [f"{INDENT}{cut(check.source, 75)}", *table(heads, rows)]


def panels(fitted: Fitted, report: Report) -> tuple[Panel, ...]:
    """Return helm, outputs with their predictions and bands, and the residuals' correlations."""
    samples, t = fitted.problem.samples, fitted.problem.samples.t
    predicted = alone(fitted.problem, fitted.found.theta)
    run = errors_of(fitted)
    standard = run.standardised
    found = [
        Panel(
            "rudder, positive to port",
            "time [s]",
            "[deg]",
            (Curve("rudder", t, samples.inputs[:, 0]),),
        )
    ]
    for i, output in enumerate(report.outputs):
        deviation = float(np.nanstd(run.errors[:, i]))
        band = BAND * deviation
        curves = (
            Curve("measured", t, samples.outputs[:, i], points=True),
            Curve("by rudder alone", t, predicted[:, i]),
            Curve("one step ahead, +95 %", t, run.predictions[:, i] + band),
            Curve("one step ahead, -95 %", t, run.predictions[:, i] - band),
        )
        found.append(Panel(output, "time [s]", f"[{UNITS[output][0]}]", curves))
        left = (Curve("residual", t, standard[:, i]),)
        title = f"residuals of {output}"
        found.append(Panel(title, "time [s]", "[std dev]", left, levels=(-BAND, 0.0, BAND)))
    return (*found, *correlation_panels(report.residuals))


def correlation_panels(residuals: tuple[Residuals, ...]) -> tuple[Panel, ...]:
    """Return the residuals' own correlations and those with the rudder."""
    found = []
    for one in residuals:
        own = np.array(one.correlation)
        lags = np.arange(len(own), dtype=float)
        curve = (Curve(one.output, lags, own, points=True),)
        title = f"correlation of the residuals of {one.output}"
        found.append(Panel(title, "lag [samples]", "[-]", curve, levels=(-one.band, one.band)))
        cross = np.array(one.cross)
        lags = np.arange(len(cross), dtype=float) - len(cross) // 2
        curve = (Curve(one.output, lags, cross, points=True),)
        title = f"rudder with the residuals of {one.output}"
        levels = (-one.cross_band, one.cross_band)
        found.append(Panel(title, "lag [samples]", "[-]", curve, levels=levels))
    return tuple(found)
