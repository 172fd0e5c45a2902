"""What is estimated: some of a model's parameters, from some samples."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trainer.identify.discrete import Sampled, sample
from trainer.identify.models import Plant, aside
from trainer.identify.samples import Samples

Numbers = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Problem:
    """Estimate the parameters at the places ``free``; the others stay as in ``values``.

    ``scale`` (f,): a free parameter is its scale times the number that a minimiser moves. Readings
    are ``sampling``, one of discrete.SAMPLINGS.
    """

    plant: Plant
    samples: Samples
    values: Numbers  # (n,)
    free: tuple[int, ...]
    scale: Numbers  # (f,)
    sampling: str = "instantaneous"

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the free parameters."""
        names = self.plant.model.names
        return tuple(names[place] for place in self.free)

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """Return how each free parameter is bounded."""
        parameters = self.plant.model.parameters
        return tuple(parameters[place].kind for place in self.free)

    @property
    def start(self) -> Numbers:
        """Return the free parameters (f,) as they stand in ``values``, scaled."""
        return self.values[list(self.free)] / self.scale

    def whole(self, theta: Numbers) -> Numbers:
        """Return all parameters (n,), the free ones from ``theta`` (f,)."""
        values = self.values.copy()
        values[list(self.free)] = theta * self.scale
        return values

    def folded(self, theta: Numbers) -> Numbers:
        """Return ``theta`` (f,) with each number at the first place that means the same model.

        Variances and lags positive, angles between -pi/2 and pi/2.
        """
        values = theta * self.scale
        angles = np.arcsin(np.sin(values))
        kinds = np.array(self.kinds)
        values = np.where(kinds == "angle", angles, values)
        values = np.where(kinds == "lag", np.abs(angles), values)
        return np.where(kinds == "variance", np.abs(values), values) / self.scale

    def sampled(self, theta: Numbers) -> Sampled:
        """Return the sampled systems of ``theta`` (f,): one row."""
        return self._sample(self.whole(theta), ())

    def sloped(self, theta: Numbers) -> Sampled:
        """Return the sampled systems of ``theta`` and, in rows 1 on, their slopes by each."""
        return self._sample(self.whole(theta), self.free)

    def _sample(self, values: Numbers, free: Sequence[int]) -> Sampled:
        blocks = self.plant.blocks(aside(values, free))
        return sample(blocks, self.samples.steps[0], self.sampling)

    def on(self, samples: Samples) -> "Problem":
        """Return the same question to other samples."""
        return replace(self, samples=samples)


def problem_of(
    plant: Plant, samples: Samples, values: Numbers, free: Sequence[str | int]
) -> Problem:
    """Return the problem of estimating ``free``, by name or place, unscaled."""
    model = plant.model
    places = tuple(name if isinstance(name, int) else model.place(name) for name in free)
    return Problem(plant, samples, values, places, np.ones(len(places)))
