"""Whether the bands of a fit hold a truth that is known."""

from typing import Final, NamedTuple

import numpy as np

from helpers.bb2_trials import ERRORS
from trainer.core.kernel import Numbers
from trainer.identify.boat import search
from trainer.identify.boat.figures import FigureBand, figures_of
from trainer.identify.boat.filter import CHANNEL_NAMES
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.vessel import FittedVessel

SURE: Final = 1.96  # standard deviations: 95 %


class Told(NamedTuple):
    """A figure with its band, and the truth."""

    value: float
    sd: float
    low: float
    high: float
    truth: float


def told(bands: tuple[FigureBand, ...], truth: FittedVessel) -> dict[str, Told]:
    """Return the figures that boat and fit come to, by name."""
    figures, found = figures_of(truth.file), {}
    for one in bands:
        numbers = (one.value, one.sd, one.low, one.high, figures[one.name, one.unit])
        if None not in numbers:
            found[one.name] = Told(*map(float, numbers))  # type: ignore[arg-type]
    return found


def inside(bands: tuple[FigureBand, ...], truth: FittedVessel) -> list[bool]:
    """Return for each figure that boat and fit come to whether its band holds the truth."""
    return [one.low <= one.truth <= one.high for one in told(bands, truth).values()]


def scores(found: search.SearchEnd, truth: Numbers) -> Numbers:
    """Return how far each coefficient lies from the truth, in its own deviations."""
    moving = found.posterior.sd > 0.0
    return np.asarray((truth - found.posterior.values)[moving] / found.posterior.sd[moving])


def flies(trial: Trial) -> bool:
    """Return whether a boat sailed its trial to the end, pitched by less than 35 degrees."""
    read = trial.readings[:, : len(ERRORS)]
    pitch = trial.readings[:, CHANNEL_NAMES.index("pitch")]
    return bool(np.isfinite(read).all() and np.abs(pitch).max() < 0.6)
