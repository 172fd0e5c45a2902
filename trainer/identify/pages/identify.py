"""A fitted ship as a page for a terminal and as a plot."""

from typing import Final

import numpy as np

from trainer.analysis.report.plots import Curve, Panel
from trainer.analysis.report.text import INDENT, cut, figure, table, wrap
from trainer.identify.alternatives import Band, Rival, pulse_of, step_of
from trainer.identify.models import UNITS
from trainer.identify.nomoto import scale
from trainer.identify.pages.results import Identified, Report, carry_out, errors_of
from trainer.identify.residuals import Residuals
from trainer.identify.validation import alone
from trainer.units import KNOT

__all__ = ["carry_out", "panels", "render"]

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
        lines += [line for text in report.findings for line in wrap(f"- {text}")]
    lines += ["", *_parameter_table(report), "", *_ship_table(report)]
    lines += ["", f"{INDENT}The ship is {report.stability}."]
    if report.derivatives:
        lines += ["", *_derivative_table(report)]
    lines += ["", *_fit_lines(report)]
    if report.rivals:
        lines += ["", *rival_table(report)]
    if report.residuals:
        lines += ["", *residual_table(report.residuals)]
        lines += [line for text in report.verdicts for line in wrap(f"- {text}")]
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
        sizes = [
            {"s": x.time, "s^2": x.time**2, "1/s": 1.0 / x.time, "m/s": x.speed, "m": x.length}
            for x in units
        ]
        others = [f"{one.value / size[one.unit]:.4g}" for size in sizes]
        known = [figure(x, form) for x, form in ((one.deviation, ".2g"), (one.low, ".4g"))]
        known.append(figure(one.high, ".4g"))
        rows.append((one.name, one.unit, f"{one.value:.5g}", *known, *others))
    heads = ("ship", "unit", "value", "std dev", "95 %\nfrom", "\nto", "prime", "bis")
    return table(heads, rows)


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
    lines = wrap(report.doubt, INDENT, 2 * INDENT) if report.doubt else []
    lines += [
        f"{INDENT}Fit {state}: log L {report.log_likelihood:.4f}, AIC {report.aic:.2f}",
        f"{INDENT}V1 {report.loss_1:.4f} one step ahead, {report.loss_1_alone:.4f} by rudder alone",
    ]
    if report.screened:
        lines.append(f"{INDENT}{report.screened} samples were rejected as outliers")
    weakest = ", ".join(report.weakest)
    lines += wrap(
        f"Known least: {weakest} (scaled eigenvalue {report.eigenvalue:.2g})", INDENT, 2 * INDENT
    )
    return lines


def rival_table(report: Report) -> list[str]:
    """Return the model beside the simpler ones that it was tested against."""
    count = len(report.parameters)
    own = ("this", str(count), f"{report.log_likelihood:.2f}", f"{report.aic:.2f}", "", "", "")
    heads = ("order\ntests", "parameters", "log L", "AIC", "ratio", "freedom", "p")
    return table(heads, [own, *(_rival_row(one) for one in report.rivals)])


def _rival_row(one: Rival) -> tuple[str, ...]:
    fit = (str(one.parameters), f"{one.log_likelihood:.2f}", f"{one.aic:.2f}")
    return (one.name, *fit, f"{one.ratio:.2f}", str(one.freedom), f"{one.probability:.3f}")


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
        (name, UNITS[name][0], f"{rms:.4g}", *(f"{100.0 * one:.1f}" for one in shares))
        for name, rms, *shares in zip(
            check.outputs, check.rms, check.share, check.own, check.explained, strict=True
        )
    ]
    shares = ("% of the\nmotion", "% where\nfitted", "% variance\nexplained")
    heads = ("predicted by\nrudder alone", "\nunit", "\nrms error", *shares)
    return [f"{INDENT}{cut(check.source, 75)}", *table(heads, rows)]


def panels(identified: Identified) -> tuple[Panel, ...]:
    """Return helm, outputs with predictions and bands, residuals, responses."""
    fitted, report = identified.fitted, identified.report
    samples, t = fitted.problem.samples, fitted.problem.samples.t
    predicted = alone(fitted.problem, fitted.found.theta)
    run = errors_of(fitted)
    standard, others = run.standardised, identified.others.outputs
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
            *_edges(others, i),
            Curve("one step ahead, +95 %", t, run.predictions[:, i] + band),
            Curve("one step ahead, -95 %", t, run.predictions[:, i] - band),
        )
        found.append(Panel(output, "time [s]", f"[{UNITS[output][0]}]", curves))
        left = (Curve("residual", t, standard[:, i]),)
        title = f"residuals of {output}"
        found.append(Panel(title, "time [s]", "[std dev]", left, levels=(-BAND, 0.0, BAND)))
    return (*found, *_responses(identified), *correlation_panels(report.residuals))


def _edges(band: Band, output: int) -> tuple[Curve, ...]:
    """Return what 95 % of the ships stay between."""
    low, high = (edge[:, output] for edge in (band.low, band.high))
    return (Curve("allowed, lowest", band.t, low), Curve("allowed, highest", band.t, high))


def _responses(identified: Identified) -> tuple[Panel, ...]:
    """Return the answers to a step and to a pulse of the rudder, of all ships allowed."""
    fitted, others = identified.fitted, identified.others
    found = []
    lost = f" ({others.lost:.0%} of the draws are no model)" if others.lost else ""
    asked = ("step of 1 deg", step_of(fitted)), ("pulse of 1 deg s", pulse_of(fitted))
    for title, rudder in asked:
        band = others.response(rudder)
        for i, output in enumerate(identified.report.outputs):
            middle = Curve("middle", band.t, band.middle[:, i])
            curves = (middle, *_edges(band, i))
            unit = f"[{UNITS[output][0]}]"
            found.append(Panel(f"{output} by a {title}{lost}", "time [s]", unit, curves))
    return tuple(found)


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
