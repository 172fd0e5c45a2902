"""A record as the models read it: knots and degrees, one row a sample, and what lies between."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.models import UNITS
from trainer.identify.record import Record
from trainer.units import DEGREE

Places = NDArray[np.int64]


@dataclass(frozen=True)
class Samples:
    """Readings and inputs at each time; NaN is a missing reading.

    ``inputs[k]`` acts from ``t[k]`` to ``t[k+1]``; before the first sample it acted as at it.
    """

    t: Numbers  # (n,) [s] rising
    outputs: Numbers  # (n, y)
    inputs: Numbers  # (n, u)

    @cached_property
    def steps(self) -> tuple[Numbers, Places]:
        """Return the different intervals (m,) [s] and which of them follows each sample (n,).

        After the last sample comes an interval like the one before it.
        """
        if len(self.t) < 2:
            raise ConfigError("a record of fewer than two samples has no interval")
        gaps = np.diff(self.t)
        usual = float(np.median(gaps))
        intervals, which = np.unique(np.round(gaps / usual, 9), return_inverse=True)
        return intervals * usual, np.append(which, which[-1]).astype(np.int64)

    @cached_property
    def table(self) -> Numbers:
        """Return readings, inputs of the sample before, inputs (n, y+2u)."""
        before = np.vstack([self.inputs[:1], self.inputs[:-1]])
        return np.ascontiguousarray(np.hstack([self.outputs, before, self.inputs]))

    @property
    def counted(self) -> int:
        """Return how many samples have a reading."""
        return int(np.count_nonzero(~np.all(np.isnan(self.outputs), axis=1)))

    @property
    def whole(self) -> bool:
        """Return whether no reading is missing."""
        return not np.isnan(self.outputs).any()

    def without(self, excluded: NDArray[np.bool_]) -> "Samples":
        """Return the samples with the readings of some (n,), or single readings (n, y), missing."""
        outputs = self.outputs.copy()
        outputs[excluded] = np.nan
        return replace(self, outputs=outputs)


def samples_of(record: Record, outputs: tuple[str, ...]) -> Samples:
    """Return the channels ``outputs`` of a record and its rudder, in the models' units."""
    columns = [UNITS[channel][1] * record.column(channel) for channel in outputs]
    rudder = record.column("rudder") / DEGREE
    return Samples(record.t, np.column_stack(columns), rudder[:, None])
