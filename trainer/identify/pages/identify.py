"""``trainer identify``: a fit of a linear model as text, plots and HTML.

``results`` has the figures; here they are only put into tables, curves and sentences.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.core.kernel import Numbers
from trainer.identify import sheet as sheets
from trainer.identify.fitting.nonlinear import BendEstimate, predict_turning
from trainer.identify.judge.allowed import ShipBand, pulse_of, step_of
from trainer.identify.judge.residuals import Residuals
from trainer.identify.judge.validation import ValidationCheck, predict_alone
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.model.nomoto import scale
from trainer.identify.pages.results import Direction, FitNumber, Identification, IdentifyReport
from trainer.identify.pages.series import LARGE_MANOEUVRE, Matrices, errors_of
from trainer.identify.sheet import input_curve, listing, screens_of
from trainer.report import html
from trainer.report.plots import Curve, Panel, Screen
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap
from trainer.units import DEGREE, KNOT

SIGN_TEXT: Final = "A positive rudder turns to port here, so K of a stable ship is negative."
OUTPUTS_ABREAST: Final = 2  # on a screen
BAND_DEVIATIONS: Final = 1.96  # standard deviations
MAX_OUTLIERS_SHOWN: Final = 10  # outliers that a page lists
MATRICES_TITLE: Final = "Matrices"
BODE_FREQUENCIES: Final = 80  # of a Bode figure
BEND_UNITS: Final = {"T1": "s", "T2": "s", "T3": "s", "K": "1/s", "kappa": "s^2"} | {
    "H1": "s",
    "H2": "s^2",
    "H3": "s^3",
    "delta_0": "rad",
}


def render(report: IdentifyReport) -> str:
    """Return the report as text."""
    samples, ship = f"{report.samples} samples every {report.interval_s:g} s", ""
    if report.length_m is not None and report.speed_kn is not None:
        speed = "" if report.runs else f", {report.speed_kn:.2f} kn"
        ship = f"{report.length_m:g} m{speed}; "
    lines = [
        f"IDENTIFICATION, model {report.model} (LISPID)",
        f"{INDENT}{cut_text(report.study, 70)}",
        f"{INDENT}{cut_text(report.source, 75)}",
        f"{INDENT}{ship}{samples} of {', '.join(report.outputs)}",
        f"{INDENT}" + ", ".join(f"{name} {value}" for name, value in report.settings.items()),
    ]
    what = "ship" if report.length_m else "system"
    blocks = [
        [f"{INDENT}The record:", *items(report.findings)] if report.findings else [],
        _parameter_table(report),
        _ship_table(report),
        [f"{INDENT}The {what} is {report.stability}.", f"{INDENT}{SIGN_TEXT}"],
        _derivative_table(report) if report.derivatives else [],
        _fit_lines(report),
        _run_table(report) if report.runs else [],
        rival_table(report) if report.rivals else [],
        [*residual_table(report.residuals), *items(report.verdicts)] if report.residuals else [],
        _check_lines(report.check, report.units) if report.check else [],
        _bend_lines(report.bend) if report.bend else [],
        _term_table(report) if report.terms else [],
        *map(_matrix_lines, report.matrices),
    ]
    return "\n".join([*lines, *(line for block in blocks if block for line in ("", *block))])


def _bend_lines(bend: BendEstimate) -> list[str]:
    """Return the kappa or H(r) of large manoeuvres, and the loop of an unstable ship."""
    numbers_by_name = dict(zip(("H1", "H2", "H3"), bend.ship.curve, strict=True)) | vars(bend.ship)
    rows = [
        (name, BEND_UNITS[name], f"{numbers_by_name[name]:.5g}", f"{deviation:.2g}")
        for name, deviation in bend.deviations.items()
    ]
    of = "helm" if bend.rate_0 is None else "yaw rate"
    unit = "deg" if bend.rate_0 is None else "deg/s"
    lines = [f"{INDENT}{cut_text(bend.source, 75)}"]
    lines.append(f"{INDENT}rms error of {of} {bend.rms / DEGREE:.4g} {unit}")
    lines += table(("large\nmanoeuvres", "unit", "value", "std dev"), rows)
    if bend.ship.loop is not None:
        rate, fold, helm = (value / DEGREE for value in bend.ship.loop)
        words = f"Loop: turns {rate:.3g} deg/s with no helm, to {fold:.3g} deg/s against {helm:.3g}"
        lines += wrap(f"{words} deg of helm", INDENT)
    return lines


def _term_table(report: IdentifyReport) -> list[str]:
    """Return how large the terms of the equations of motion are."""
    rows, before = [], ""
    for one in report.terms:
        first, before = "" if one.equation == before else one.equation, one.equation
        sizes = (f"{one.rms:.3g}", f"{one.largest:.3g}", f"{100.0 * one.share:.0f}")
        rows.append((first, one.name, one.unit, *sizes))
    heads = ("contributions\nto the", "by", "unit", "rms", "largest", "% of\nall rms")
    return table(heads, rows)


def _matrix_lines(found: Matrices) -> list[str]:
    """Return the matrices row by row."""
    states, outputs = ", ".join(found.states), ", ".join(found.outputs)
    lines = [f"{INDENT}{MATRICES_TITLE}, {found.of}; states {states}, SI; outputs {outputs}"]
    for part in ("continuous", "sampled", "initial", "final"):
        lines.append(f"{INDENT}{part}:")
        for name, value in getattr(found, part).items():
            rows = np.atleast_2d(value)
            for i, row in enumerate(rows):
                numbers = " ".join(f"{x:11.4g}" for x in row)
                lines.append(f"{2 * INDENT}{name if i == 0 else '':10}{numbers}")
    return lines


def _run_table(report: IdentifyReport) -> list[str]:
    """Return how well the model follows each run."""
    rows = []
    for number, run in enumerate(report.runs, 1):
        speed = "-" if run.speed_kn is None else f"{run.speed_kn:.2f}"
        first = (f"{number} {cut_text(run.source.rpartition('/')[2], 18)}", speed, str(run.samples))
        columns = zip(report.outputs, report.units, run.rms, run.alone, run.explained, strict=True)
        for name, unit, rms, alone_rms, explained in columns:
            numbers = (f"{rms:.4g}", f"{alone_rms:.4g}", f"{100.0 * explained:.1f}")
            rows.append((*first, name, unit, *numbers))
            first = ("", "", "")
    ahead, alone_head = "rms error\none ahead", "\nalone"
    heads = ("run", "kn", "samples", "output", "unit", ahead, alone_head, "% variance\nexplained")
    return table(heads, rows)


def _parameter_table(report: IdentifyReport) -> list[str]:
    rows = [
        (one.name, one.unit, f"{one.value:.5g}", format_number(one.deviation, ".2g"), *_span(one))
        for one in report.parameters
    ]
    heads = ("parameter", "unit", "estimate", "std dev", "95 %\nfrom", "\nto")
    return table(heads, rows)


def _span(one: FitNumber) -> tuple[str, str]:
    """Return the ends of an interval."""
    return format_number(one.low, ".4g"), format_number(one.high, ".4g")


def _ship_table(report: IdentifyReport) -> list[str]:
    """Return gains and time constants in SI, prime and bis units."""
    units, rows = [], []
    if report.length_m is not None and report.speed_kn is not None:
        speed = report.speed_kn * KNOT
        units = [scale(name, report.length_m, speed) for name in ("prime", "bis")]
    for one in report.ship:
        sizes = [
            {"s": x.time, "s^2": x.time**2, "1/s": 1.0 / x.time, "m/s": x.speed, "m": x.length}
            for x in units
        ]
        others = [f"{one.value / size[one.unit]:.4g}" for size in sizes]
        known = (f"{one.value:.5g}", format_number(one.deviation, ".2g"), *_span(one))
        rows.append((one.name, one.unit, *known, *others))
    what = "ship" if units else "system"
    shown = ("prime", "bis")[: len(units)]
    heads = (what, "unit", "value", "std dev", "95 %\nfrom", "\nto", *shown)
    return table(heads, rows)


def _derivative_table(report: IdentifyReport) -> list[str]:
    """Return the derivatives; deviations are of the system that was fitted."""
    rows = [
        (
            one.name,
            format_number(one.prime, ".5g"),
            format_number(one.bis, ".5g"),
            format_number(one.deviation, ".2g"),
        )
        for one in report.derivatives
    ]
    heads = ("derivative", "prime", "bis", f"std dev\n({report.settings['system']})")
    return table(heads, rows)


def _fit_lines(report: IdentifyReport) -> list[str]:
    state = f"Fit settled in {report.steps} steps"
    state = state if report.converged else "Fit DID NOT SETTLE"
    if report.simulated:
        state = "Nothing was estimated"
    lines = wrap(report.doubt, INDENT, 2 * INDENT) if report.doubt else []
    lines += [
        f"{INDENT}{state}: log L {report.log_likelihood:.4f}, AIC {report.aic:.2f}",
        f"{INDENT}V1 {report.loss_1:.4f} one step ahead, {report.loss_1_alone:.4f} by rudder alone",
    ]
    if report.screened:
        several = bool(report.runs)
        fit_lines = [
            (f"run {one.run} " if several else "") + f"row {one.row} ({one.t_s:g} s)"
            for one in report.screened[:MAX_OUTLIERS_SHOWN]
        ]
        more = len(report.screened) - len(fit_lines)
        rest = f" and {more} more" if more else ""
        verb = "was" if len(report.screened) == 1 else "were"
        lines += wrap(
            f"{len(report.screened)} {verb} rejected as outliers: {', '.join(fit_lines)}{rest}",
            INDENT,
            2 * INDENT,
        )
    weakest = ", ".join(report.weakest)
    lines += wrap(
        f"Known least: {weakest} (scaled eigenvalue {report.eigenvalue:.2g})", INDENT, 2 * INDENT
    )
    return lines


def rival_table(report: IdentifyReport) -> list[str]:
    """Return the model beside the simpler ones that it was tested against."""
    count = len(report.parameters)
    rows = [("this", str(count), f"{report.log_likelihood:.2f}", f"{report.aic:.2f}", "", "", "")]
    for one in report.rivals:
        fit = (str(one.parameters), f"{one.log_likelihood:.2f}", f"{one.aic:.2f}")
        test = (f"{one.ratio:.2f}", str(one.freedom), f"{one.probability:.3f}")
        rows.append((one.name, *fit, *test))
    heads = ("order\ntests", "parameters", "log L", "AIC", "ratio", "freedom", "p")
    return table(heads, rows)


def residual_table(residuals: tuple[Residuals, ...]) -> list[str]:
    """Return the tests of residuals, each with the probability of so large a statistic."""
    rows = []
    for one in residuals:
        tests = one.whiteness, one.missing_dynamics, one.feedback, one.normality
        usual = f"{one.sign_changes_expected:.0f} +- {one.sign_changes_deviation:.0f}"
        probabilities = (f"{test.probability:.3f}" for test in tests)
        rows.append((one.output, *probabilities, f"{one.sign_changes} of {usual}"))
    heads = ("white\np", "by rudder\np", "feedback\np", "normal\np", "sign\nchanges")
    return table(("residuals\nof", *heads), rows)


def _check_lines(check: ValidationCheck, units: tuple[str, ...]) -> list[str]:
    """Return how well another record is predicted."""
    columns = check.outputs, units, check.rms, check.share, check.own, check.explained
    rows = [
        (name, unit, f"{rms:.4g}", *(f"{100.0 * one:.1f}" for one in shares))
        for name, unit, rms, *shares in zip(*columns, strict=True)
    ]
    shares = ("% of the\nmotion", "% where\nfitted", "% variance\nexplained")
    heads = ("predicted by\nrudder alone", "\nunit", "\nrms error", *shares)
    return [f"{INDENT}{cut_text(check.source, 75)}", *table(heads, rows)]


def screens(identified: Identification) -> tuple[Screen, ...]:
    """Return all figures of a fit in groups, each for one screen."""
    of = " deg" if identified.report.length_m else ""
    responses = (f"step of 1{of}", step_of), (f"pulse of 1{of} s", pulse_of)
    groups: dict[str, Iterable[Panel]] = {
        "Fit": _fit(identified),
        "Record": _record(identified),
    }
    for number in range(1, len(identified.report.runs)):
        groups[f"Run {number + 1}"] = _record(identified, number)
    groups["Correlations"] = correlation_panels(identified.report.residuals)
    for title, shape in responses:
        name = title.split()[0].capitalize()
        groups[name] = _responses(identified, title, shape(identified.fitted))
    groups |= {"Bode": _bode(identified), "Terms": _terms(identified)}
    return screens_of(groups | {"Large manoeuvre": _large(identified)})


def _fit(identified: Identification) -> Iterator[Panel]:
    """Yield outputs as measured and by the model alone, below two of them their residuals."""
    fitted, report = identified.fitted, identified.report
    problem, at = fitted.problem.runs[0]
    measured, t = problem.samples.outputs, problem.samples.t
    alone = predict_alone(problem, fitted.found.theta[at])
    by_model = "by rudder alone" if report.length_m else "alone"
    levels = (-BAND_DEVIATIONS, 0.0, BAND_DEVIATIONS)
    for first in range(0, len(report.outputs), OUTPUTS_ABREAST):
        pair = list(enumerate(report.outputs))[first : first + OUTPUTS_ABREAST]
        for i, output in pair:
            dots = Curve("measured", t, measured[:, i], points=True)
            curves = (dots, Curve(by_model, t, alone[:, i]))
            unit = f"[{report.units[i]}]"
            yield Panel(f"{output}, measured and modelled", "time [s]", unit, curves)
        for i, output in pair:
            residuals = (Curve("residual", t, identified.run.standardised[:, i]),)
            title = f"residuals of {output}"
            yield Panel(title, "time [s]", "[std dev]", residuals, levels=levels)


def _record(identified: Identification, number: int = 0) -> Iterator[Panel]:
    """Yield the inputs of a run, then outputs with predictions.

    The first run has the bands of the allowed ships too.
    """
    fitted, report = identified.fitted, identified.report
    problem, at = fitted.problem.runs[number]
    run = errors_of(fitted, number) if number else identified.run
    samples, t = problem.samples, problem.samples.t
    predicted = predict_alone(problem, fitted.found.theta[at])
    for name, values in zip(report.inputs, samples.inputs.T, strict=True):
        curve = (input_curve(name, t, values, samples.between_readings),)
        words = ("rudder, positive to port", "[deg]") if report.length_m else (name, "[-]")
        yield Panel(words[0], "time [s]", words[1], curve)
    for i, output in enumerate(report.outputs):
        band = BAND_DEVIATIONS * float(np.nanstd(run.errors[:, i]))
        curves = (
            Curve("measured", t, samples.outputs[:, i], points=True),
            Curve("by rudder alone" if report.length_m else "alone", t, predicted[:, i]),
            *(() if number else _edges(identified.others.outputs, i)),
            Curve("one step ahead, +95 %", t, run.predictions[:, i] + band),
            Curve("one step ahead, -95 %", t, run.predictions[:, i] - band),
        )
        yield Panel(output, "time [s]", f"[{report.units[i]}]", curves)


def _edges(band: ShipBand, output: int) -> tuple[Curve, ...]:
    """Return the two edges of a band, between which 95 % of the ships stay."""
    low, high = (edge[:, output] for edge in (band.low, band.high))
    return (Curve("allowed, lowest", band.t, low), Curve("allowed, highest", band.t, high))


def _responses(identified: Identification, title: str, shape: Numbers) -> Iterator[Panel]:
    """Yield the responses of all allowed ships to a rudder, or to each input."""
    others, report = identified.others, identified.report
    lost = f" ({others.lost:.0%} of the draws are no model)" if others.lost else ""
    for k, name in enumerate(report.inputs):
        inputs = np.zeros((len(shape), len(report.inputs)))
        inputs[:, k] = shape
        band = others.response(inputs)
        of = "" if report.length_m else f" of {name}"
        for i, output in enumerate(report.outputs):
            middle = Curve("middle", band.t, band.middle[:, i])
            curves = (middle, *_edges(band, i))
            panel = f"{output} by a {title}{of}{lost}"
            yield Panel(panel, "time [s]", f"[{report.units[i]}]", curves)


def _bode(identified: Identification) -> Iterator[Panel]:
    """Yield gain and phase of each output by a rudder to starboard.

    They go from one period of the record's length to two samples a period, which is all that the
    record can show.
    """
    if identified.report.length_m is None:
        return
    samples, period = identified.fitted.problem.samples, identified.fitted.problem.plant.period
    ends = 2.0 * np.pi / (samples.t[-1] - samples.t[0]), np.pi / period
    outputs, gain, phase = identified.others.bode(np.geomspace(*ends, BODE_FREQUENCIES))
    for i, output in enumerate(outputs):
        unit = f"({OUTPUT_UNITS[output][0]})/deg".replace("(deg)", "deg").replace("(kn)", "kn")
        for kind, band, y in (("gain", gain, f"[dB of {unit}]"), ("phase", phase, "[deg]")):
            curves = (Curve("middle", band.t, band.middle[:, i]), *_edges(band, i))
            title = f"rudder to {output}, {kind}"
            yield Panel(title, "frequency [rad/s]", y, curves, decades=True)


def _terms(identified: Identification) -> Iterator[Panel]:
    """Yield the terms of each equation of motion over its record."""
    t, turned = identified.fitted.problem.samples.t, identified.turned
    for equation, unit in dict.fromkeys((key[0], key[2]) for key in identified.terms):
        parts = {key[1]: part for key, part in identified.terms.items() if key[0] == equation}
        times = t if turned is None or equation != LARGE_MANOEUVRE else turned.t
        curves = tuple(Curve(name, times, part) for name, part in parts.items())
        yield Panel(f"{equation}, by its terms", "time [s]", f"[{unit}]", curves)


def _large(identified: Identification) -> Iterator[Panel]:
    """Yield the helm of steady turns, and the yaw rate of a large manoeuvre."""
    bend, turned = identified.report.bend, identified.turned
    if bend is None or turned is None:
        return
    rate, rudder = turned.column("yaw_rate"), turned.column("rudder")
    most = float(np.nanmax(np.abs(rate)))
    across = np.linspace(-most, most, 101)
    curves = [Curve("steady turn", bend.ship.helm(across) / DEGREE, across / DEGREE)]
    if bend.rate_0 is None:
        curves.append(Curve("measured", rudder / DEGREE, rate / DEGREE, points=True))
    linear = bend.ship.K * (bend.ship.helm(across) - bend.ship.delta_0)
    curves.append(Curve("linear", curves[0].x, linear / DEGREE))
    yield Panel("steady turns", "rudder, positive to port [deg]", "yaw rate [deg/s]", tuple(curves))
    if bend.rate_0 is not None:
        run = predict_turning(bend.ship, turned, np.array([bend.rate_0, 0.0]))[:, 0]
        both = (
            Curve("measured", turned.t, rate / DEGREE, points=True),
            Curve("by rudder alone", turned.t, run / DEGREE),
        )
        yield Panel("yaw rate of the large manoeuvre", "time [s]", "[deg/s]", both)


def correlation_panels(residuals: tuple[Residuals, ...]) -> tuple[Panel, ...]:
    """Return the residuals' own correlations, then those with the rudder."""

    def panel(title: str, output: str, values: Sequence[float], first: int, band: float) -> Panel:
        lags = np.arange(len(values), dtype=float) + first
        curve = (Curve(output, lags, np.array(values), points=True),)
        return Panel(f"{title} {output}", "lag [samples]", "[-]", curve, levels=(-band, band))

    own_title, crossed = "correlation of the residuals of", "rudder with the residuals of"
    return (
        *(panel(own_title, one.output, one.correlation, 0, one.band) for one in residuals),
        *(
            panel(crossed, one.output, one.cross, -(len(one.cross) // 2), one.cross_band)
            for one in residuals
        ),
    )


def sheet(found: Identification) -> str:
    """Return the page of HTML; it needs no other file."""
    report = found.report
    text, *matrices = render(report).split(f"\n\n{INDENT}{MATRICES_TITLE}, ")
    further = [(f"{MATRICES_TITLE} {i}", listing(words)) for i, words in enumerate(matrices, 1)]
    further.append(("Known least", _directions(report.eigenvalues)))
    return sheets.sheet(report.study, text, screens(found), report, further)


def _directions(directions: tuple[Direction, ...]) -> Markup:
    """Return the eigenvalues of the second derivatives, and the parameters of each direction."""
    rows = []
    for one in directions:
        order = sorted(one.parts.items(), key=lambda part: -abs(part[1]))
        parts = ", ".join(f"{name} {value:+.2f}" for name, value in order)
        rows.append((f"{one.eigenvalue:.3g}", parts))
    words = (
        "Eigenvalues of the second derivatives of -log L, scaled to a unit diagonal, smallest "
        "first. The record tells least of the combination of parameters beside a small one."
    )
    heads = ("eigenvalue", "parts of the unit vector")
    return html.paragraph(words) + html.table(heads, rows, "facts")
