"""``trainer identify`` of a ship that is not linear: text, plots, HTML and CSV.

``results`` has the figures; here they are only put into tables, curves and sentences.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from trainer.identify import sheet as sheets
from trainer.identify.record.measurements import Record
from trainer.identify.ships.records import readings_of
from trainer.identify.ships.results import (
    OUTPUT_NAMES,
    OUTPUT_SCALES,
    OUTPUT_UNITS,
    SUSPECT_PROBABILITY,
    TURNING_CAUSES,
    ShipFitReport,
    ShipIdentification,
    UnknownDirection,
    causes_of,
    residual_accelerations,
)
from trainer.report.plots import Curve, Panel, Screen
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap

NOISE_UNITS: Final = {
    **dict.fromkeys("uv", "m/s"),
    **dict.fromkeys("rp", "rad/s"),
    **dict.fromkeys(("psi", "phi"), "rad"),
}


def render(report: ShipFitReport) -> str:
    """Return the report as text."""
    lines = [
        f"IDENTIFICATION OF A SHIP, model {report.model}",
        f"{INDENT}{cut_text(report.ship, 70)}, {report.length_m:g} m",
    ]
    for source, samples in zip(report.sources, report.samples, strict=True):
        lines.append(
            f"{INDENT}{cut_text(source, 50)}: {samples} samples every {report.interval_s:g} s"
        )
    strength = f", widths times {report.prior_strength:g}" if report.prior_strength else ""
    lines += wrap(f"prior: {report.prior}{strength}")
    if report.findings:
        lines += ["", f"{INDENT}The record:"]
        lines += items(report.findings)
    rows = [
        (
            one.name,
            f"{one.value:.5g}",
            f"{one.deviation:.2g}",
            f"{one.low:.4g}",
            f"{one.high:.4g}",
            f"{100.0 * min(one.prior_share, 1.0):.0f} %",
        )
        for one in report.coefficients
    ]
    heads = ("coefficient", "estimate", "std dev", "95 %\nfrom", "\nto", "prior's\nshare")
    lines += ["", *table(heads, rows), "", *_noise_table(report), "", *_fit_lines(report)]
    lines += ["", *_untold_lines(report), "", *_prediction_table(report)]
    lines += ["", *_whiteness_lines(report)]
    lines += items(report.patterns)
    for test in report.tests:
        lines += wrap(
            f"Without {', '.join(test.without)}: 2 log L falls by {test.statistic:.2f}, "
            f"{test.freedom} of freedom, p {test.probability:.3f}"
        )
    return "\n".join(lines)


def _noise_table(report: ShipFitReport) -> list[str]:
    """Return disturbances and errors of readings."""
    rows = []
    for one in report.noises:
        _, kind, state = one.name.split("_")
        unit = NOISE_UNITS[state] + ("/rt(s)" if kind == "w" else "")
        rows.append((one.name, unit, *(f"{x:.3g}" for x in (one.value, one.low, one.high))))
    return table(("disturbance, error", "unit", "estimate", "95 %\nfrom", "\nto"), rows)


def _fit_lines(report: ShipFitReport) -> list[str]:
    """Return whether the search settled, and where the other starts ended."""
    state = f"settled in {report.steps} steps" if report.settled else "DID NOT SETTLE"
    lines = [f"{INDENT}Fit {state}: -log L with the prior {report.cost:.4f}"]
    if not report.settled:
        lines += wrap(f"{report.doubt[0].upper()}{report.doubt[1:]}: intervals do not hold.")
    if report.at_floor:
        lines += wrap(
            f"At their floor, about a ten-thousandth of the spread: {', '.join(report.at_floor)}. "
            "The readings are smoothed, or the model follows them by its disturbances."
        )
    ends = ", ".join(f"{end:.2f}" for end in report.other_starts)
    return lines + (wrap(f"Other starts ended at {ends}") if ends else [])


def _untold_lines(report: ShipFitReport) -> list[str]:
    """Return in words the combinations that the records do not determine."""
    lines = [f"{INDENT}What the record cannot tell"]
    if not report.untold:
        lines += wrap("- nothing: each coefficient is told by itself")
    lines += items(map(in_words, report.untold))
    if report.from_book:
        names = ", ".join(report.from_book)
        lines += wrap(f"- {names}: from the book, not from the record (prior's share above 90 %)")
    return lines


def in_words(one: UnknownDirection) -> str:
    """Return a combination in words."""
    names = sorted(one.parts, key=lambda name: -abs(one.parts[name]))
    if len(names) == 1:
        return f"{names[0]} by itself (eigenvalue {one.eigenvalue:.1g})"
    first = one.parts[names[0]]
    ways = [f"{name} {'rises' if one.parts[name] * first > 0.0 else 'falls'}" for name in names[1:]]
    return (
        f"{names[0]} may rise where {' and '.join(ways)}: the record fits as well "
        f"(eigenvalue {one.eigenvalue:.1g})"
    )


def _prediction_table(report: ShipFitReport) -> list[str]:
    """Return how well records are predicted by rudder, revolutions and wind alone."""
    rows = [
        (cut_text(one.source, 30), one.kind, *(format_number(x, ".1f") for x in one.explained))
        for one in report.predictions
    ]
    shown = OUTPUT_NAMES[: len(report.predictions[0].explained)]
    heads = ("predicted by inputs alone,\n% of the variance", "record", *shown)
    lines = table(heads, rows)
    if not any(one.kind != "fitted" for one in report.predictions):
        lines += wrap("No record was held back: --predict FILE predicts one that was not fitted.")
    return lines


def _whiteness_lines(report: ShipFitReport) -> list[str]:
    """Return the tests of the innovations, and what they mean for the intervals."""
    rows = [
        (
            one.output,
            f"{one.deviation:.2f}",
            f"{one.probability:.3f}",
            f"{one.next_one:+.2f}",
            f"{one.factor:.2f}" if one.factor > 1.0 else "-",
        )
        for one in report.whiteness
    ]
    heads = ("innovations\nof", "size, of\nexpected", "white\np", "to the\nnext", "factor")
    lines = table(heads, rows)
    if bad := [one for one in report.whiteness if one.probability < SUSPECT_PROBABILITY]:
        names = ", ".join(one.output for one in bad)
        lines += wrap(
            f"- innovations of {names} are not white: stated intervals are too narrow; take them "
            f"times {max(one.factor for one in bad):.1f} at least"
        )
    return lines


def panels(found: ShipIdentification) -> tuple[Panel, ...]:
    """Return the records with their predictions, and residual accelerations against causes."""
    return tuple(panel for screen in screens(found) for panel in screen.panels)


def screens(found: ShipIdentification) -> tuple[Screen, ...]:
    """Return all figures of a fit in groups, each for one screen."""
    groups: dict[str, Iterator[Panel]] = {}
    for what, trials in (("Record", found.fit.problem.trials), ("Held back", found.held)):
        for number, trial in enumerate(trials, 1):
            name = what if len(trials) == 1 else f"{what} {number}"
            groups[name] = _record_panels(found, trial)
    groups |= {f"Left over by {cause}": _residual_panels(found, cause) for cause in TURNING_CAUSES}
    return sheets.screens_of(groups)


def sheet(found: ShipIdentification) -> str:
    """Return the page of HTML; it needs no other file."""
    report = found.report
    return sheets.sheet(report.ship, render(report), screens(found), report)


def _record_panels(found: ShipIdentification, trial: Record) -> Iterator[Panel]:
    """Yield the readings of a record with what inputs alone predict."""
    sailed, readings = found.fit.problem.sail(found.fit.found.theta, trial), readings_of(trial)
    for i, output in enumerate(OUTPUT_NAMES[: sailed.shape[1]]):
        curves = (
            Curve("measured", trial.t, OUTPUT_SCALES[i] * readings[:, i], points=True),
            Curve("by inputs alone", trial.t, OUTPUT_SCALES[i] * sailed[:, i]),
        )
        title = f"{output}, {Path(trial.source).name}"
        yield Panel(title, "time [s]", f"[{OUTPUT_UNITS[i]}]", curves)


def _residual_panels(found: ShipIdentification, cause: str) -> Iterator[Panel]:
    """Yield the accelerations left over against v', r' or the rudder."""
    problem, a = found.fit.problem, found.fit.found.theta
    length, turn = float(problem.constants[0]), np.degrees if cause == "rudder" else np.asarray
    rows = [(trial, *residual_accelerations(problem, a, trial)) for trial in problem.trials]
    for i, state in enumerate(problem.model.driven):
        output = OUTPUT_NAMES[state]
        curves = tuple(
            Curve(
                Path(trial.source).name,
                turn(causes_of(trial, states, length)[cause]),
                residuals[:, i],
                points=True,
            )
            for trial, states, residuals in rows
        )
        unit = "[rad/s^2]" if i >= 2 else "[m/s^2]"
        label = f"{cause} [{'deg' if cause == 'rudder' else '-'}]"
        title = f"{output} acceleration left over, against {cause}"
        yield Panel(title, label, unit, curves, levels=(0.0,))


def coefficients_text(report: ShipFitReport) -> str:
    """Return coefficients, standard deviations and covariance as CSV."""
    p = len(report.coefficients)
    names = report.covariance_names[:p]
    lines = [",".join(("name", "value", "deviation", "prior_share", *names))]
    for one, row in zip(report.coefficients, report.covariance, strict=False):
        numbers = (one.value, one.deviation, min(one.prior_share, 1.0), *row[:p])
        lines.append(",".join((one.name, *(repr(x) if math.isfinite(x) else "" for x in numbers))))
    return "\n".join(lines) + "\n"
