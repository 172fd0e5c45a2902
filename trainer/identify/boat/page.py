"""A fit of a boat as text of 79 columns."""

import math
from collections.abc import Iterator
from typing import Final

from trainer.identify.boat.figures import FigureBand
from trainer.identify.boat.report import VERDICT_WORDS, BoatFit, ParameterChange, RecordFit
from trainer.report.columns import figure
from trainer.report.text import ascii_text, items, table, titled_table, wrap

BAND_NOTE = (
    "Bands hold 95 of 100 drawn boats; about 93 of 100 true figures lie inside. Clean innovations "
    "do not prove them: hold out a trial of another kind (--hold-out)."
)

FIGURE_HEADS: Final = ("", "before", "95 %", "after", "95 %")
COEFFICIENT_HEADS: Final = ("", "before", "sd", "after", "sd", "left", "")


def render(report: BoatFit) -> str:
    """Return the page for a terminal."""
    counts = dict.fromkeys(VERDICT_WORDS, 0)
    for row in report.coefficients:
        counts[row.verdict] += row.prior_sd > 0.0
    end = "settled" if report.settled else f"NOT settled: {report.doubt}"
    told = ", ".join(f"{count} {word}" for word, count in counts.items())
    lines = [ascii_text(f"FIT: {report.vessel}"), ""]
    lines += wrap(f"prior: {report.prior}; {end} after {report.steps} steps")
    lines += wrap(f"parameters: {told}")
    lines += wrap(f"distance from the prior, of what it should be: {report.conflict:.2f}")
    for one in report.records:
        lines += ["", ascii_text(f"RECORD {one.source}"), *_record_lines(one)]
    for one in report.held_out:
        lines += ["", ascii_text(f"HELD OUT {one.source}"), *_record_lines(one)]
        lines += _explained(one)
    rows = map(figure_row, report.before, report.after)
    lines += titled_table("FIGURES", FIGURE_HEADS, rows)
    lines += [*wrap(BAND_NOTE)]
    told_rows = [row for row in report.coefficients if row.verdict != VERDICT_WORDS[-1]]
    rows_told = map(coefficient_row, sorted(told_rows, key=lambda row: row.learned))
    lines += titled_table("COEFFICIENTS THAT THE RECORDS TOLD", COEFFICIENT_HEADS, rows_told)
    if report.warnings:
        lines += ["", "WARNINGS", *items(report.warnings)]
    return "\n".join(lines)


def _record_lines(one: RecordFit) -> Iterator[str]:
    """Yield what a record is, and how the fit follows it."""
    yield from wrap(f"{one.rows} rows, {one.interval_s:g} s apart")
    if one.columns:
        yield from wrap(f"columns: {', '.join(one.columns)}")
    yield from items(one.told)
    rows = [
        (row.channel, f"{row.readings}", f"{row.wild}", f"{row.chi:.3f}", f"{row.lag:+.2f}")
        for row in one.channels
    ]
    yield from table(("", "readings", "wild", "chi", "lag"), rows)
    slow = [
        (row.name.replace("_", " "), _amount(row.value, row.unit), _amount(row.sd, row.unit))
        for row in one.slow
    ]
    yield from table(("", "of the day", "sd"), slow)


def _explained(one: RecordFit) -> list[str]:
    """Return how much of a held-out record its controls alone foretell."""
    rows = [
        (name, _percent(after), _percent(before)) for name, (after, before) in one.explained.items()
    ]
    return table(("foretold [%]", "fit", "prior"), rows)


def _percent(share: float) -> str:
    """Return a share [%] as text."""
    return f"{share:.2f}" if math.isfinite(share) else "lost"


def _amount(value: float, unit: str) -> str:
    """Return a number with its unit, degrees for radians."""
    words = {"-": "", "rad": " deg"}.get(unit, f" {unit}")
    return f"{figure(value, unit)}{words}"


def figure_row(before: FigureBand, after: FigureBand) -> tuple[str, ...]:
    """Return a figure with its bands as cells."""
    unit = {"rad": "deg", "-": ""}.get(before.unit, before.unit)
    cells = [f"{before.name} [{unit}]"]
    for one in (before, after):
        band = (
            "-"
            if one.low is None
            else f"{_short(one.low, one.unit)} to {_short(one.high, one.unit)}"
        )
        cells += [_short(one.value, one.unit), band]
    return tuple(cells)


def _short(value: float | None, unit: str) -> str:
    """Return a number in three digits, degrees for radians."""
    if value is None:
        return "-"
    return f"{math.degrees(value) if unit == 'rad' else value:.3g}"


def coefficient_row(row: ParameterChange) -> tuple[str, ...]:
    """Return a coefficient before and after as cells."""
    numbers = (f"{row.prior:.4g}", f"{row.prior_sd:.2g}", f"{row.value:.4g}", f"{row.sd:.2g}")
    return (row.name, *numbers, f"{row.learned:.2f}", row.verdict)
