"""What a study's result says: how each measure is spread, and what moves it most."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError, nearest, shown
from trainer.core.kernel import Numbers
from trainer.sweep.job import Opened
from trainer.sweep.table import TROUBLE

PERCENTILES: Final = (5.0, 25.0, 50.0, 75.0, 95.0)
TENTH: Final = 0.1  # of the members: what counts as a variable's low and high end
FEWEST: Final = 2  # members that a spread can be told of
TOLD: Final = 5  # different troubles


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
    """What one variable does to a measure: its mean over members at either end of the variable."""

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
    variables = [variable.row.name for variable in study.variables]
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


def chosen_measure(report: Report, name: str | None) -> Spread:
    """Return the measure of that name, or the first; ConfigError if there is none."""
    known = {spread.name: spread for spread in report.spreads}
    if name is not None and name not in known:
        raise ConfigError(
            f"--measure {shown(name)}: no such measure{nearest(name, known)}; "
            f"there are {', '.join(known)}"
        )
    return report.spreads[0] if name is None else known[name]
