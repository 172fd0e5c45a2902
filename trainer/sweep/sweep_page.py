"""The result of a study as a page for a terminal and as a plot: percentiles and tornado."""

import math
from typing import Any, Final

import numpy as np

from trainer.study.page import INDENT, table, wrapped
from trainer.study.plots import Bar, Bars, Curve, Panel
from trainer.sweep.identifying import COVERED, DEVIATION
from trainer.sweep.outputs import Output
from trainer.sweep.report import Effect, Report, Spread, chosen_measure

HEADS: Final = ("", "unit", "mean", "std dev", "5 %", "50 %", "95 %", "members")
SHOWN: Final = (5.0, 50.0, 95.0)  # [%] on the page and as marks of the plot


def on_page(unit: str) -> tuple[float, str]:
    """Return the factor to the page's unit of a measure, and that unit."""
    if not unit.startswith("rad"):
        return 1.0, unit
    return math.degrees(1.0), unit.replace("rad", "deg", 1)


def render(report: Report) -> str:
    """Return the report as text."""
    lines = [
        *wrapped(report.study, "", ""),
        f"{INDENT}{report.plan}, {report.members} members, seed {report.seed}",
        *wrapped(f"result: {report.file}"),
        "",
    ]
    covered = coverage(report)
    lines += covered or table(HEADS, [_row(spread) for spread in report.spreads])
    for spread in () if covered else report.spreads[:1]:
        lines += _effects(report, spread)
    if report.troubled:
        lines += ["", f"{INDENT}{report.troubled} of {report.members} came to nothing:"]
        for text, count in report.troubles.items():
            lines += wrapped(f"{count} times: {text}", 2 * INDENT, 3 * INDENT)
    return "\n".join(lines)


def _row(spread: Spread) -> tuple[str, ...]:
    """Return one measure as a line of the table."""
    factor, unit = on_page(spread.unit)
    at = [spread.percentiles.get(f"{percent:g}", math.nan) for percent in SHOWN]
    numbers = [factor * x for x in (spread.mean, spread.deviation, *at)]
    texts = ["-" if math.isnan(x) else f"{x:.4g}" for x in numbers]
    return (spread.name, unit, *texts, str(spread.count))


def _effects(report: Report, spread: Spread) -> list[str]:
    """Return what moves a measure most, as lines."""
    effects = report.effects[spread.name]
    if not effects:
        return []
    factor, unit = on_page(spread.unit)
    rows = [
        (
            effect.variable,
            *(_told(x) for x in (effect.low, effect.high)),
            f"{factor * effect.at_low:.4g}",
            f"{factor * effect.at_high:.4g}",
        )
        for effect in effects
    ]
    heads = ("", "from", "to", f"{unit}\nat that", f"{unit}\nat that")
    title = f"{spread.name}: mean where a variable is in its lowest and highest tenth"
    return ["", *wrapped(title), *table(heads, rows)]


def _told(number: float | str) -> str:
    return number if isinstance(number, str) else f"{number:.3g}"


def coverage(report: Report) -> list[str]:
    """Return how often intervals held the truth, as lines; none where nothing is identified."""
    known = {spread.name: spread for spread in report.spreads}
    names = [name for name in known if COVERED.format(name) in known]
    if not names:
        return []
    rows = []
    for name in names:
        spread, told = known[name], known[DEVIATION.format(name)]
        inside = 100.0 * known[COVERED.format(name)].mean
        numbers = (spread.mean, spread.deviation, told.percentiles.get("50", told.mean))
        rows.append((name, spread.unit, *(f"{x:.4g}" for x in numbers), f"{inside:.1f}"))
    heads = ("", "unit", "mean", "std dev\nfound", "std dev\ntold", "% inside\n95 %")
    shares = [known[COVERED.format(name)] for name in names]
    pooled = 100.0 * sum(one.mean * one.count for one in shares) / sum(one.count for one in shares)
    return [
        *table(heads, rows),
        "",
        f"{INDENT}{pooled:.2f} % of all 95 % intervals hold the truth",
    ]


def member_page(study: str, member: int, told: dict[str, Any], outputs: tuple[Output, ...]) -> str:
    """Return one member as text: its seed, its numbers, and what became of it, every digit."""
    units = {output.name: output.unit for output in outputs}
    rows = [
        (name, "-" if value is None else repr(value).strip("'"), units.get(name, ""))
        for name, value in told.items()
    ]
    return "\n".join([f"{study}: member {member}", *table(("", "", ""), rows)])


def panels(report: Report, result: Any, measure: str | None) -> tuple[Panel | Bars, ...]:
    """Return how one measure is spread, and what moves it most."""
    spread = chosen_measure(report, measure)
    factor, unit = on_page(spread.unit)
    values = np.asarray(result.column(spread.name).to_numpy(zero_copy_only=False), float)
    values = np.sort(values[~np.isnan(values)]) * factor
    share = 100.0 * (np.arange(len(values)) + 0.5) / max(len(values), 1)
    marks = tuple(
        (
            f"{percent:g} %: {factor * spread.percentiles[f'{percent:g}']:.4g}",
            factor * spread.percentiles[f"{percent:g}"],
        )
        for percent in SHOWN
        if spread.percentiles
    )
    along = f"{spread.name} [{unit}]"
    title = f"{spread.name} of {spread.count} members"
    below = Panel(title, along, "members below [%]", (Curve(spread.name, values, share),), marks)
    effects = report.effects[spread.name]
    if not effects:
        return (below,)
    bars = tuple(_bar(effect, factor) for effect in effects)
    about = "mean where a variable is in its lowest (filled) and highest (hatched) tenth"
    return below, Bars(about, along, bars, factor * spread.mean)


def _bar(effect: Effect, factor: float) -> Bar:
    """Return one variable as a bar of the tornado."""
    ends = factor * effect.at_low, factor * effect.at_high
    return Bar(effect.variable, ends, (_told(effect.low), _told(effect.high)))
