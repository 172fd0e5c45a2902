"""What the aids show: the ghost's gauges, and where the boat goes as it stands.

``session/exercise/aids`` switches them. The present ones are part of each picture's ``Pace``. The
thread that sends reads them, and flies the predictor's boat, so that no tick waits for that.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import InstrumentReadings

PREDICTED_POINTS: Final = 12  # of the way ahead, evenly spaced
FLOWN_AT_ONCE: Final = 60  # [ticks] before other threads have their turn
PITCH_OFFSET: Final = np.array([STATE_OFFSETS["theta"]], np.int64)
READ_DEPTH, READ_HEADING = (1 + InstrumentReadings._fields.index(x) for x in ("depth", "heading"))


class GhostReading(NamedTuple):
    """What the gauges read on the reference crew's run at one tick [SI, rad]."""

    depth: float
    heading: float
    speed: float
    pitch: float
    rudder: float
    stern: float
    bow: float


class PredictedPoint(NamedTuple):
    """What the gauges will read after so many seconds [SI, rad]."""

    seconds: float
    depth: float
    heading: float
    pitch: float


class Predictor:
    """A boat of its own, flown ahead of the present.

    The controls stay as they stand. Nothing breaks that is not broken already. Water and ships near
    are as the exercise has them.
    """

    def __init__(self, boat: Boat, seconds: float = 60.0) -> None:
        self.seconds = seconds
        self._boat = boat
        boat.records.scheme["trigger_kind"] = 0.0

    def look_ahead(self, numbers: Sequence[float]) -> list[PredictedPoint]:
        """Return the way ahead of a state, as far as the boat can be flown."""
        boat, step = self._boat, self._boat.method.step
        ticks = max(round(self.seconds / step), 1)
        rows = np.empty((ticks, PITCH_OFFSET.size + len(InstrumentReadings._fields)))
        boat.records.state.view(np.float64)[:] = numbers
        flown = 0
        with np.errstate(all="ignore"):
            while flown < ticks and not boat.fly(PITCH_OFFSET, rows[flown : flown + FLOWN_AT_ONCE]):
                flown = min(flown + FLOWN_AT_ONCE, ticks)
                time.sleep(0)
        points = (
            max(round(ticks * k / PREDICTED_POINTS), 1) for k in range(1, PREDICTED_POINTS + 1)
        )
        return [
            PredictedPoint(
                tick * step,
                float(rows[tick - 1, READ_DEPTH]),
                float(rows[tick - 1, READ_HEADING]),
                float(rows[tick - 1, 0]),
            )
            for tick in points
            if tick <= flown
        ]


@dataclass(frozen=True, eq=False)
class ShownAids:
    """The aids that are on. A change makes another one, which is shown at once."""

    ghost: Sequence[GhostReading] = ()  # by tick
    predictor: Predictor | None = None


NO_AIDS: Final = ShownAids()
