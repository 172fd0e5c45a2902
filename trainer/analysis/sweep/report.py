"""A study's result as a page and as a plot: percentiles and tornado."""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.sweep.draws import GRID
from trainer.analysis.sweep.job import COVERED, DEVIATION, Opened, Output
from trainer.analysis.sweep.results import TROUBLE
from trainer.config.files import ConfigError, nearest, quote
from trainer.core.kernel import Numbers
from trainer.report.plots import Bar, Bars, Curve, Panel
from trainer.report.text import INDENT, table, wrap

PERCENTILES: Final = (5.0, 25.0, 50.0, 75.0, 95.0)
TENTH: Final = 0.1  # of the members: what counts as a variable's low and high end
FEWEST: Final = 2  # members that a spread can be told of
TOLD: Final = 5  # different troubles
MOST_CURVES: Final = 12  # of a panel over a grid


@dataclass(frozen=True)
class Spread:
    """How one measure is spread over the members that came to it, SI and radians."""

    name: str
    unit: str
    count: int
    mean: float
    deviation: float
    percentiles: dict[str, float]  # by per cent


@dataclass(frozen=True)
class Effect:
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
class Report:
    """All that ``trainer sweep`` prints of a result."""

    study: str
    file: str
    plan: str
    seed: int
    members: int
    troubled: int
    troubles: dict[str, int]  # the most frequent ones
    spreads: tuple[Spread, ...]
    effects: dict[str, tuple[Effect, ...]]  # by measure, widest first


def report_of(opened: Opened, table: Any, file: str) -> Report:
    """Return what a result says."""
    study = opened.study
    troubles = [text for text in table.column(TROUBLE).to_pylist() if text]
    each: dict[str, int] = {}
    for text in troubles:
        each[text] = each.get(text, 0) + 1
    most = sorted(each.items(), key=lambda item: (-item[1], item[0]))[:TOLD]
    columns = {output.name: _numbers(table, output.name) for output in opened.subject.outputs}
    variables = [one.row.name for one in study.variables if one.draw is None]
    drawn = {name: np.array(table.column(name).to_pylist()) for name in variables}
    return Report(
        study=study.heading.name,
        file=file,
        plan=study.draws.sample.plan,
        seed=study.draws.sample.seed,
        members=table.num_rows,
        troubled=len(troubles),
        troubles=dict(most),
        spreads=tuple(
            spread_of(output.name, output.unit, columns[output.name])
            for output in opened.subject.outputs
        ),
        effects={name: effects_of(drawn, values) for name, values in columns.items()},
    )


def _numbers(table: Any, name: str) -> Numbers:
    """Return a column with NaN for what is null."""
    column = table.column(name).to_numpy(zero_copy_only=False)
    return np.asarray(column, float)


def spread_of(name: str, unit: str, values: Numbers) -> Spread:
    """Return how a measure is spread; NaN counts as no member."""
    there = values[~np.isnan(values)]
    if len(there) < FEWEST:
        mean = float(there[0]) if len(there) else float("nan")
        return Spread(name, unit, len(there), mean, float("nan"), {})
    at = np.percentile(there, PERCENTILES)
    percentiles = {f"{p:g}": float(x) for p, x in zip(PERCENTILES, at, strict=True)}
    deviation = float(there.std(ddof=1))
    return Spread(name, unit, len(there), float(there.mean()), deviation, percentiles)


def effects_of(drawn: dict[str, NDArray[Any]], values: Numbers) -> tuple[Effect, ...]:
    """Return what each variable does to a measure, the widest first."""
    there = ~np.isnan(values)
    if there.sum() < FEWEST:
        return ()
    found = []
    for name, numbers in drawn.items():
        of = numbers[there]
        words = of.dtype.kind not in "fiu"
        one = _by_word(name, of, values[there]) if words else _by_end(name, of, values[there])
        found.append(one)
    return tuple(sorted(found, key=lambda effect: -effect.width))


def _by_end(name: str, numbers: Numbers, values: Numbers) -> Effect:
    """Return the means over the tenth of members where a variable is lowest and highest."""
    low = numbers <= np.quantile(numbers, TENTH, method="inverted_cdf")
    high = numbers >= -np.quantile(-numbers, TENTH, method="inverted_cdf")
    ends = [(float(numbers[end].mean()), float(values[end].mean())) for end in (low, high)]
    return Effect(name, ends[0][0], ends[1][0], ends[0][1], ends[1][1])


def _by_word(name: str, words: NDArray[Any], values: Numbers) -> Effect:
    """Return the words with the lowest and the highest mean."""
    means = {str(word): float(values[words == word].mean()) for word in np.unique(words)}
    low, high = min(means, key=means.__getitem__), max(means, key=means.__getitem__)
    return Effect(name, low, high, means[low], means[high])


def choose_measure(report: Report, name: str | None) -> Spread:
    """Return the measure of that name, or the first; ConfigError if there is none."""
    known = {spread.name: spread for spread in report.spreads}
    if name is not None and name not in known:
        raise ConfigError(
            f"--measure {quote(name)}: no such measure{nearest(name, known)}; "
            f"there are {', '.join(known)}"
        )
    return report.spreads[0] if name is None else known[name]


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
        *wrap(report.study, "", ""),
        f"{INDENT}{report.plan}, {report.members} members, seed {report.seed}",
        *wrap(f"result: {report.file}"),
        "",
    ]
    covered = coverage(report)
    lines += covered or table(HEADS, [_row(spread) for spread in report.spreads])
    for spread in () if covered else report.spreads[:1]:
        lines += _effects(report, spread)
    if report.troubled:
        lines += ["", f"{INDENT}{report.troubled} of {report.members} came to nothing:"]
        for text, count in report.troubles.items():
            lines += wrap(f"{count} times: {text}", 2 * INDENT, 3 * INDENT)
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
            *(_format(x) for x in (effect.low, effect.high)),
            f"{factor * effect.at_low:.4g}",
            f"{factor * effect.at_high:.4g}",
        )
        for effect in effects
    ]
    heads = ("", "from", "to", f"{unit}\nat that", f"{unit}\nat that")
    title = f"{spread.name}: mean where a variable is in its lowest and highest tenth"
    return ["", *wrap(title), *table(heads, rows)]


def _format(number: float | str) -> str:
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
    """Return one member as text: its seed, its numbers, its result, every digit."""
    units = {output.name: output.unit for output in outputs}
    rows = [
        (name, "-" if value is None else repr(value).strip("'"), units.get(name, ""))
        for name, value in told.items()
    ]
    return "\n".join([f"{study}: member {member}", *table(("", "", ""), rows)])


def panels(report: Report, result: Any, measure: str | None) -> tuple[Panel | Bars, ...]:
    """Return how one measure is spread, what moves it most, and over a grid how."""
    spread = choose_measure(report, measure)
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
    tornado = Bars(about, along, bars, factor * spread.mean)
    return below, tornado, *grid_panels(report, result, spread)


def grid_panels(report: Report, result: Any, spread: Spread) -> tuple[Panel, ...]:
    """Return a measure over each variable of a grid. Each setting of the others has a curve.

    None of other plans, of one variable alone, and where there would be too many curves.
    """
    varied = {effect.variable for effect in report.effects[spread.name]}
    names = [name for name in result.column_names if name in varied]
    if report.plan != GRID or len(names) < FEWEST:
        return ()
    drawn = {name: result.column(name).to_pylist() for name in names}
    values = on_page(spread.unit)[0] * _numbers(result, spread.name)
    found = []
    for name in names:
        others = [other for other in names if other != name]
        settings = list(zip(*(drawn[other] for other in others), strict=True))
        several = len(set(settings)) <= MOST_CURVES and not isinstance(drawn[name][0], str)
        if several:
            curves = tuple(
                _over(np.array(drawn[name]), values, settings, setting, others)
                for setting in dict.fromkeys(settings)
            )
            title = f"{spread.name} over {name}"
            found.append(Panel(title, name, f"{spread.name} [{on_page(spread.unit)[1]}]", curves))
    return tuple(found)


def _over(
    along: Numbers, values: Numbers, settings: list[Any], setting: Any, others: list[str]
) -> Curve:
    """Return the members of one setting of the other variables, by the one along."""
    here = np.array([one == setting for one in settings])
    order = np.argsort(along[here])
    label = ", ".join(
        f"{name} {_format(value)}" for name, value in zip(others, setting, strict=True)
    )
    return Curve(label, along[here][order], values[here][order])


def _bar(effect: Effect, factor: float) -> Bar:
    """Return one variable as a bar of the tornado."""
    ends = factor * effect.at_low, factor * effect.at_high
    return Bar(effect.variable, ends, (_format(effect.low), _format(effect.high)))
