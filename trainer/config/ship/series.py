"""Recorded time series: the columns of a CSV file, as ``trainer run --csv`` writes it.

Flights, exports and the programs of 1969 that read runs use it: one form for what was flown here
and for what comes from a file.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trainer.config.files import ConfigError, nearest, quote
from trainer.config.tables import read_table
from trainer.core.kernel import Numbers

MIN_ROWS = 2  # rows


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
    table = read_table(path)
    if not table.has("t"):
        raise ConfigError(f"{path}: the first line must name the columns, t [s] among them")
    if len(table.cells) < MIN_ROWS:
        raise ConfigError(
            f"{path}: has {len(table.cells)} rows of numbers; needs {MIN_ROWS} or more"
        )
    series = Series(path, {name: table.known(i) for i, name in enumerate(table.names)})
    if not (late := np.diff(series.t) > 0.0).all():
        row = int(np.argmin(late)) + 1
        raise ConfigError(f"{path}: row {table.lines[row]}: t = {series.t[row]:g} does not rise")
    return series
