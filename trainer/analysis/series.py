"""Recorded time series: the columns of a CSV file, as ``trainer run --csv`` writes it."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trainer.config.files import ConfigError, nearest, quote
from trainer.core.kernel import Numbers

FEWEST = 2  # rows


@dataclass(frozen=True)
class Series:
    """Columns of numbers by name; ``t`` [s] rises."""

    path: Path
    columns: dict[str, Numbers]

    @property
    def t(self) -> Numbers:
        """Return the times [s]."""
        return self.columns["t"]

    def column(self, name: str) -> Numbers:
        """Return the column of that name; ConfigError if there is none."""
        if name not in self.columns:
            known = ", ".join(self.columns)
            raise ConfigError(
                f"{self.path}: no column {quote(name)}{nearest(name, self.columns)}; it has {known}"
            )
        return self.columns[name]


def load_series(path: Path) -> Series:
    """Return the columns of a CSV file whose first line names them. ConfigError if it is wrong."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = csv.reader(file)
            names = [name.strip() for name in next(rows, [])]
            _check_names(path, names)
            numbers = [_numbers(path, rows.line_num, names, row) for row in rows if row]
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: is not a CSV text: {error}") from error
    if len(numbers) < FEWEST:
        raise ConfigError(f"{path}: has {len(numbers)} rows of numbers; needs {FEWEST} or more")
    table = np.array(numbers)
    series = Series(path, {name: table[:, i] for i, name in enumerate(names)})
    if not (late := np.diff(series.t) > 0.0).all():
        row = int(np.argmin(late)) + 2
        raise ConfigError(f"{path}: row {row}: t = {series.t[row - 1]:g} does not rise")
    return series


def _check_names(path: Path, names: list[str]) -> None:
    """Check the heading; ConfigError if it lacks ``t`` or names a column twice."""
    if "t" not in names:
        raise ConfigError(f"{path}: the first line must name the columns, t [s] among them")
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise ConfigError(f"{path}: column {quote(twice[0])} is given twice")


def _numbers(path: Path, line: int, names: list[str], row: list[str]) -> list[float]:
    """Return one row; ConfigError naming the line if it is not one finite number a column."""
    if len(row) != len(names):
        raise ConfigError(f"{path}: line {line}: has {len(row)} fields, the heading {len(names)}")
    numbers = []
    for name, text in zip(names, row, strict=True):
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise ConfigError(f"{path}: line {line}: {name} = {quote(text)}: must be a number")
        numbers.append(number)
    return numbers
