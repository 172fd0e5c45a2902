"""A study's result as a page and as a plot: percentiles and tornado.

``cli/workshop/sweep`` prints it from the table of results. A tornado has a bar for each variable,
the widest first: what to measure better before anything else.
"""

import math
from collections import Counter
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.sweep.draws import GRID_SAMPLE
from trainer.analysis.sweep.job import COVERED_COLUMN, DEVIATION_COLUMN, OpenJob, Output
from trainer.analysis.sweep.sobol import SOBOL_SAMPLE, SobolIndex, sobol_indices
from trainer.analysis.sweep.study import Study
from trainer.analysis.sweep.sweep import TROUBLE_COLUMN
from trainer.config.files import ConfigError, offer_known, quote
from trainer.core.kernel import Numbers
from trainer.report.plots import Bar, BarGroup, Curve, Panel
from trainer.report.text import INDENT, table, wrap

SPREAD_PERCENTILES: Final = (5.0, 25.0, 50.0, 75.0, 95.0)  # [%] of members
END_SHARE: Final = 0.1  # of the members: what counts as a variable's low and high end
MIN_SPREAD_MEMBERS: Final = 2  # members that a spread can be told of
MAX_TROUBLES_SHOWN: Final = 5  # different troubles
MAX_CURVES: Final = 12  # of a panel over a grid
SPREAD_HEADS: Final = ("", "unit", "mean", "std dev", "5 %", "50 %", "95 %", "members")
SOBOL_HEADS: Final = ("", "alone", "95 %", "in all", "95 %")
SHOWN_PERCENTILES: Final = (5.0, 50.0, 95.0)  # [%] on the page and as marks of the plot


@dataclass(frozen=True)
class OutputSpread:
    """How one measure is spread over the members that came to it, SI and radians."""

    name: str
    unit: str
    count: int
    mean: float
    deviation: float
    percentiles: dict[str, float]  # by per cent


@dataclass(frozen=True)
class VariableEffect:
    """The effect of one variable on a measure: its mean at either end."""

    variable: str
    low: float | str  # mean of the variable there, or its word
    high: float | str
    at_low: float
    at_high: float

    @property
    def width(self) -> float:
        """Return how far the measure moves from end to end."""
        return abs(self.at_high - self.at_low)


@dataclass(frozen=True)
class SweepReport:
    """The figures of a result that ``trainer boat sweep`` prints."""

    study: str
    file: str
    plan: str
    seed: int
    members: int
    troubled: int
    troubles: dict[str, int]  # the most frequent ones
    spreads: tuple[OutputSpread, ...]
    effects: dict[str, tuple[VariableEffect, ...]]  # by measure, widest first
    indices: dict[str, tuple[SobolIndex, ...]]  # by measure, of the plan sobol


def numbers_of(table: Any, name: str) -> Numbers:
    """Return a column with NaN for what is null."""
    return np.asarray(table.column(name).to_numpy(zero_copy_only=False), float)


def report_of(opened: OpenJob, table: Any, file: str) -> SweepReport:
    """Return the report of a result."""
    study = opened.study
    troubles = Counter(text for text in table.column(TROUBLE_COLUMN).to_pylist() if text)
    most = sorted(troubles.items(), key=lambda item: (-item[1], item[0]))[:MAX_TROUBLES_SHOWN]
    columns = {output.name: numbers_of(table, output.name) for output in opened.subject.outputs}
    variables = [one.row.name for one in study.variables if one.draw is None]
    drawn = {name: np.array(table.column(name).to_pylist()) for name in variables}
    return SweepReport(
        study=study.heading.name,
        file=file,
        plan=study.draws.sample.plan,
        seed=study.draws.sample.seed,
        members=table.num_rows,
        troubled=troubles.total(),
        troubles=dict(most),
        spreads=tuple(spread_of(*one, columns[one.name]) for one in opened.subject.outputs),
        effects={name: effects_of(drawn, values) for name, values in columns.items()},
        indices=indices_of(study, columns),
    )


def indices_of(study: Study, columns: dict[str, Numbers]) -> dict[str, tuple[SobolIndex, ...]]:
    """Return the indices of each measure; empty for other plans."""
    sample = study.draws.sample
    if sample.plan != SOBOL_SAMPLE:
        return {}
    names = [row.name for row in study.draws.rows]
    return {name: sobol_indices(names, values, sample.seed) for name, values in columns.items()}


def spread_of(name: str, unit: str, values: Numbers) -> OutputSpread:
    """Return how a measure is spread; NaN counts as no member."""
    present = values[~np.isnan(values)]
    if len(present) < MIN_SPREAD_MEMBERS:
        mean = float(present[0]) if len(present) else float("nan")
        return OutputSpread(name, unit, len(present), mean, float("nan"), {})
    at = np.percentile(present, SPREAD_PERCENTILES)
    percentiles = {f"{p:g}": float(x) for p, x in zip(SPREAD_PERCENTILES, at, strict=True)}
    deviation = float(present.std(ddof=1))
    return OutputSpread(name, unit, len(present), float(present.mean()), deviation, percentiles)


def effects_of(drawn: dict[str, NDArray[Any]], values: Numbers) -> tuple[VariableEffect, ...]:
    """Return the effect of each variable on a measure, the widest first."""
    present = ~np.isnan(values)
    if present.sum() < MIN_SPREAD_MEMBERS:
        return ()
    effects = [_effect(name, numbers[present], values[present]) for name, numbers in drawn.items()]
    return tuple(sorted(effects, key=lambda effect: -effect.width))


def _effect(name: str, of: NDArray[Any], values: Numbers) -> VariableEffect:
    """Return the mean ``values`` at both ends of a variable, or by its extreme words.

    An end is the tenth of members where the variable is lowest, or highest.
    """
    if of.dtype.kind in "fiu":
        low = of <= np.quantile(of, END_SHARE, method="inverted_cdf")
        high = of >= -np.quantile(-of, END_SHARE, method="inverted_cdf")
        ends = (of[low], of[high], values[low], values[high])
        return VariableEffect(name, *(float(end.mean()) for end in ends))
    means = {str(word): float(values[of == word].mean()) for word in np.unique(of)}
    least, most = min(means, key=means.__getitem__), max(means, key=means.__getitem__)
    return VariableEffect(name, least, most, means[least], means[most])


def on_page(unit: str) -> tuple[float, str]:
    """Return the factor to the page's unit of a measure, and that unit."""
    if not unit.startswith("rad"):
        return 1.0, unit
    return math.degrees(1.0), unit.replace("rad", "deg", 1)


def render(report: SweepReport) -> str:
    """Return the report as text."""
    lines = [
        *wrap(report.study, "", ""),
        f"{INDENT}{report.plan}, {report.members} members, seed {report.seed}",
        *wrap(f"result: {report.file}"),
        "",
    ]
    rows = []
    for spread in report.spreads:
        factor, unit = on_page(spread.unit)
        at = [spread.percentiles.get(f"{percent:g}", math.nan) for percent in SHOWN_PERCENTILES]
        numbers = [factor * x for x in (spread.mean, spread.deviation, *at)]
        texts = ["-" if math.isnan(x) else f"{x:.4g}" for x in numbers]
        rows.append((spread.name, unit, *texts, str(spread.count)))
    covered = coverage(report)
    lines += covered or table(SPREAD_HEADS, rows)
    for spread in () if covered else report.spreads[:1]:
        lines += _indices(report, spread) or _effects(report, spread)
    if report.troubled:
        lines += ["", f"{INDENT}{report.troubled} of {report.members} came to nothing:"]
        for text, count in report.troubles.items():
            times = "once" if count == 1 else f"{count} times"
            lines += wrap(f"{times}: {text}", 2 * INDENT, 3 * INDENT)
    return "\n".join(lines)


def _indices(report: SweepReport, spread: OutputSpread) -> list[str]:
    """Return how much of a measure's variance each variable makes, as lines."""
    rows = [
        (
            *(index.variable, f"{index.first:.3f}", _interval(index.first_interval)),
            *(f"{index.total:.3f}", _interval(index.total_interval)),
        )
        for index in report.indices.get(spread.name, ())
    ]
    title = f"{spread.name}: shares of the variance that a variable makes alone, and in all"
    return ["", *wrap(title), *table(SOBOL_HEADS, rows)] if rows else []


def _interval(ends: tuple[float, float]) -> str:
    """Return an interval as text."""
    return f"{ends[0]:.3f} to {ends[1]:.3f}"


def _effects(report: SweepReport, spread: OutputSpread) -> list[str]:
    """Return the variables with the widest effects, as lines."""
    effects = report.effects[spread.name]
    if not effects:
        return []
    factor, unit = on_page(spread.unit)
    rows = []
    for effect in effects:
        ends = (f"{factor * at:.4g}" for at in (effect.at_low, effect.at_high))
        rows.append((effect.variable, _format(effect.low), _format(effect.high), *ends))
    heads = ("", "from", "to", f"{unit}\nat that", f"{unit}\nat that")
    title = f"{spread.name}: mean where a variable is in its lowest and highest tenth"
    return ["", *wrap(title), *table(heads, rows)]


def _format(number: float | str) -> str:
    return number if isinstance(number, str) else f"{number:.3g}"


def coverage(report: SweepReport) -> list[str]:
    """Return as lines how often intervals held the truth; none without identification."""
    known = {spread.name: spread for spread in report.spreads}
    names = [name for name in known if COVERED_COLUMN.format(name) in known]
    if not names:
        return []
    rows = []
    for name in names:
        spread, deviations = known[name], known[DEVIATION_COLUMN.format(name)]
        inside = 100.0 * known[COVERED_COLUMN.format(name)].mean
        numbers = (spread.mean, spread.deviation, deviations.percentiles.get("50", deviations.mean))
        rows.append((name, spread.unit, *(f"{x:.4g}" for x in numbers), f"{inside:.1f}"))
    heads = ("", "unit", "mean", "std dev\nfound", "std dev\ntold", "% inside\n95 %")
    shares = [known[COVERED_COLUMN.format(name)] for name in names]
    pooled = 100.0 * sum(one.mean * one.count for one in shares) / sum(one.count for one in shares)
    told = f"{INDENT}{pooled:.2f} % of all 95 % intervals hold the truth"
    return [*table(heads, rows), "", told]


def member_page(study: str, member: int, told: dict[str, Any], outputs: tuple[Output, ...]) -> str:
    """Return one member as text: its seed, its numbers, its result, every digit."""
    units = {output.name: output.unit for output in outputs}
    rows = [
        (name, "-" if value is None else repr(value).strip("'"), units.get(name, ""))
        for name, value in told.items()
    ]
    return "\n".join([f"{study}: member {member}", *table(("", "", ""), rows)])


def panels(report: SweepReport, result: Any, measure: str | None) -> tuple[Panel | BarGroup, ...]:
    """Return the panels of one measure: its spread, the widest effects, curves over a grid."""
    known = {spread.name: spread for spread in report.spreads}
    if measure is not None and measure not in known:
        told = f"{quote(measure)}: no such measure{offer_known(measure, known)}"
        raise ConfigError(f"--measure {told}")
    spread = report.spreads[0] if measure is None else known[measure]
    factor, unit = on_page(spread.unit)
    values = numbers_of(result, spread.name)
    values = np.sort(values[~np.isnan(values)]) * factor
    share = 100.0 * (np.arange(len(values)) + 0.5) / max(len(values), 1)
    shown = {f"{percent:g}" for percent in SHOWN_PERCENTILES}
    at = [(name, factor * x) for name, x in spread.percentiles.items() if name in shown]
    marks = tuple((f"{percent} %: {value:.4g}", value) for percent, value in at)
    along = f"{spread.name} [{unit}]"
    title = f"{spread.name} of {spread.count} members"
    below = Panel(title, along, "members below [%]", (Curve(spread.name, values, share),), marks)
    effects = report.effects[spread.name]
    if not effects:
        return (below,)
    bars = []
    for effect in effects:
        ends = factor * effect.at_low, factor * effect.at_high
        bars.append(Bar(effect.variable, ends, (_format(effect.low), _format(effect.high))))
    about = "mean where a variable is in its lowest (filled) and highest (hatched) tenth"
    tornado = BarGroup(about, along, tuple(bars), factor * spread.mean)
    return below, tornado, *grid_panels(report, result, spread)


def grid_panels(report: SweepReport, result: Any, spread: OutputSpread) -> tuple[Panel, ...]:
    """Return a measure over each variable of a grid. Each setting of the others has a curve.

    None of other plans, of one variable alone, and where there would be too many curves.
    """
    varied = {effect.variable for effect in report.effects[spread.name]}
    names = [name for name in result.column_names if name in varied]
    if report.plan != GRID_SAMPLE or len(names) < MIN_SPREAD_MEMBERS:
        return ()
    drawn = {name: result.column(name).to_pylist() for name in names}
    factor, unit = on_page(spread.unit)
    values = factor * numbers_of(result, spread.name)
    panel_list = []
    for name in names:
        others = [other for other in names if other != name]
        settings = list(zip(*(drawn[other] for other in others), strict=True))
        if len(set(settings)) > MAX_CURVES or isinstance(drawn[name][0], str):
            continue
        curves = []
        for setting in dict.fromkeys(settings):
            here = np.array([one == setting for one in settings])
            along = np.array(drawn[name])[here]
            order = np.argsort(along)
            fixed_values = zip(others, map(_format, setting), strict=True)
            label = ", ".join(f"{other} {value}" for other, value in fixed_values)
            curves.append(Curve(label, along[order], values[here][order]))
        title = f"{spread.name} over {name}"
        panel_list.append(Panel(title, name, f"{spread.name} [{unit}]", tuple(curves)))
    return tuple(panel_list)
