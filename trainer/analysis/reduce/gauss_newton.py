"""Factors that bring the largest difference down: Gauss and Newton with weights and a leash.

The sum of |difference|^p is brought down for growing p, by weights |difference|^(p - 2) on a
linear least-squares problem; a leash pulls every factor towards 1, so that a coefficient is what
the hull's data say unless the flights ask otherwise.
"""

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers

LOWEST, HIGHEST = 0.5, 2.0  # [-] factors
FLOOR: Final = 0.2  # [-] smaller differences weigh as this
POWERS: Final = (2, 6)
DAMPINGS: Final = (0.01, 0.3, 10.0, 300.0)
GAIN: Final = 0.995  # [-] of the cost: a step that brings less is the last
NORM: Final = 8

Fly = Callable[[Sequence[Numbers]], list[Numbers]]


class Point(NamedTuple):
    """Factors, and the differences that they lead to, both by place."""

    factors: Numbers
    differences: Numbers

    @property
    def worst(self) -> float:
        """Return the largest difference [-] of what is allowed."""
        return float(abs(self.differences).max())

    @property
    def departure(self) -> float:
        """Return how far the factors of what is kept are from 1 [-], squared."""
        kept = self.factors[self.factors != 0.0]
        return float(np.sum((kept - 1.0) ** 2))

    @property
    def cost(self) -> float:
        """Return the differences as one number that the largest rule."""
        return float(np.sum(abs(self.differences) ** NORM) ** (1.0 / NORM))


class Slopes(NamedTuple):
    """How the differences change with the factors, and what holds these."""

    table: Numbers  # (rows, all factors)
    free: list[int]  # places of the factors that may change
    leash: float  # [-] weight of (factor - 1)^2 beside the largest difference's square


def normal_matrix(slopes: Slopes, differences: Numbers, power: int) -> tuple[Numbers, Numbers]:
    """Return the weighted normal matrix, leash included, and the weights by row."""
    weights = np.maximum(abs(differences), FLOOR) ** (power - 2)
    weights /= weights.max()
    table = slopes.table[:, slopes.free]
    return table.T @ (weights[:, None] * table) + slopes.leash * np.eye(table.shape[1]), weights


def take_step(slopes: Slopes, here: Point, power: int, damping: float) -> Numbers:
    """Return the factors after one step."""
    places = slopes.free
    matrix, weights = normal_matrix(slopes, here.differences, power)
    downhill = -slopes.table[:, places].T @ (weights * here.differences)
    downhill -= slopes.leash * (here.factors[places] - 1.0)
    there = here.factors.copy()
    there[places] += np.linalg.solve(matrix + damping * np.eye(len(places)), downhill)
    there[places] = np.clip(there[places], LOWEST, HIGHEST)
    return there


def descend(fly: Fly, slopes: Slopes, here: Point, rounds: int, goal: float) -> Point:
    """Return the best point of ``rounds`` steps by the same slopes.

    If some are in the goal, the one of them that departs least from the hull's own coefficients.
    """
    for _ in range(rounds):
        if here.worst <= goal:
            break
        tried = [
            take_step(slopes, here, power, damping) for power in POWERS for damping in DAMPINGS
        ]
        points = [Point(*pair) for pair in zip(tried, fly(tried), strict=True)]
        reached = [one for one in points if one.worst <= goal]
        if reached:
            return min(reached, key=lambda one: one.departure)
        best = min(points, key=lambda one: one.cost)
        if best.cost >= GAIN * here.cost:
            break
        here = best
    return here


def without(slopes: Slopes, here: Point, gone: Sequence[int]) -> Numbers:
    """Return the factors with those ``gone`` at zero. The others make up for it."""
    places = slopes.free
    matrix, _ = normal_matrix(slopes, here.differences, 4)
    inverse = np.linalg.inv(matrix)
    which = [places.index(place) for place in gone]
    pull = np.linalg.solve(inverse[np.ix_(which, which)], here.factors[list(gone)])
    there = here.factors.copy()
    there[places] = np.clip(there[places] - inverse[:, which] @ pull, LOWEST, HIGHEST)
    there[list(gone)] = 0.0
    return there


def rises(slopes: Slopes, here: Point) -> Numbers:
    """Return the rise [-] of the weighted squares for each free factor alone at zero."""
    matrix, _ = normal_matrix(slopes, here.differences, 4)
    return np.asarray(here.factors[slopes.free] ** 2 / np.diag(np.linalg.inv(matrix)))
