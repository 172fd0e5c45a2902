"""What every front makes of a log: columns, each with its own times."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from trainer.config.files import ConfigError, nearest, quote
from trainer.core.kernel import Numbers


class LogColumn(NamedTuple):
    """The numbers of one field of a log, as they stand there."""

    t: Numbers  # [s] of the log's own clock
    values: Numbers
    unit: str = ""  # as the format says it; "" where it says none


class Meant(NamedTuple):
    """A channel's field, by the format."""

    column: str
    sign: float = 1.0  # -1 where the format's is the other way


@dataclass(frozen=True)
class Log:
    """A log whose columns are called as its format calls them."""

    path: Path
    columns: Mapping[str, LogColumn]
    meant: Mapping[str, Meant] = field(default_factory=dict)  # by channel
    told: tuple[str, ...] = ()

    def column(self, name: str, channel: str) -> LogColumn:
        """Return a column; ConfigError with the nearest name if there is none."""
        if name in self.columns:
            return self.columns[name]
        raise ConfigError(
            f"{self.path}: no column {quote(name)} for {channel}{nearest(name, self.columns)}; "
            f"it has {', '.join(self.columns)}"
        )


def log_column(readings: Iterable[tuple[float, float]], unit: str = "") -> LogColumn:
    """Return a column in the order of its times [s], of equal ones the last."""
    rows = np.array([*readings], float).reshape(-1, 2)
    t, values = rows[np.argsort(rows[:, 0], kind="stable")].T
    kept = np.isfinite(values) & np.append(np.diff(t) > 0.0, True)[: len(t)]
    return LogColumn(t[kept], values[kept], unit)


def begin_at_zero(columns: Mapping[str, LogColumn]) -> dict[str, LogColumn]:
    """Return the columns with their times from the first reading of all."""
    some = {name: one for name, one in columns.items() if len(one.t) > 1}
    start = min((float(one.t[0]) for one in some.values()), default=0.0)
    return {name: one._replace(t=one.t - start) for name, one in some.items()}
