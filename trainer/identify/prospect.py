"""What a record would tell before it is taken: standard deviations by the information matrix."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.identify.likelihood import Likelihood
from trainer.identify.models import MODELS, Plant, Ship
from trainer.identify.nomoto import Numbers
from trainer.identify.problem import problem_of
from trainer.identify.record import Record
from trainer.identify.samples import samples_of
from trainer.identify.spread import Spread, propagated
from trainer.identify.steering import Steering
from trainer.identify.told import quantities, quantity_names

LEVER: Final = 0.25  # [-] of the length: at which the sea's force makes its moment
FREE: Final = (
    *("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta", "Y_0", "N_0"),
    *("R1_Y", "R1_N", "R2_v1", "R2_r", "R2_psi", "x1_0", "x2_0", "x3_0"),
)
ERRORS: Final = {"sway": "R2_v1", "yaw_rate": "R2_r", "heading": "R2_psi"}


@dataclass(frozen=True)
class Sensors:
    """Standard deviations of what reads the ship, and of what the sea alone does to her."""

    sway_kn: float
    yaw_rate_deg_s: float
    heading_deg: float
    unrest_deg_s: float  # of the yaw rate, by the sea


@dataclass(frozen=True)
class Prospect:
    """Expected values and standard deviations by name, of parameters and what follows of them."""

    samples: int
    interval_s: float
    values: dict[str, float]
    deviations: dict[str, float]


def prospect(steering: Steering, record: Record, outputs: tuple[str, ...], sea: Sensors) -> Prospect:
    """Return what Model 1 would be known to, from a record such as this one of such a ship.

    ConfigError if the record cannot separate the parameters.
    """
    model = MODELS["1"]
    ship = Ship(steering.length, steering.speed)
    values = _truth(steering, sea)
    start = {"x1_0": record.sway, "x2_0": record.yaw_rate, "x3_0": record.heading}
    units = (3600.0 / 1852.0, 180.0 / math.pi, 180.0 / math.pi)
    for (name, column), unit in zip(start.items(), units, strict=True):
        values[name] = float(column[0]) * unit if column is not None else 0.0
    spare = {ERRORS[name] for name in ERRORS if name not in outputs}
    free = [name for name in FREE if name not in spare]
    plant = Plant(model, ship, outputs, record.interval)
    problem = problem_of(plant, samples_of(record, outputs), model.vector(**values), free)
    information = Likelihood(problem).information(problem.start)
    covariance = _inverse(information, problem.names)
    names = quantity_names(model)
    found: Spread = propagated(
        lambda theta: quantities(model, problem.whole(theta), ship), problem.start, covariance
    )
    return Prospect(
        samples=len(record.t),
        interval_s=record.interval,
        values=dict(zip(names, map(float, found.values), strict=True)),
        deviations=dict(zip(names, map(float, found.deviations), strict=True)),
    )


def _truth(steering: Steering, sea: Sensors) -> dict[str, float]:
    """Return Model 1's parameters of the ship, the sea and the sensors."""
    values = dict(steering.prime)
    noise = _unrest(steering, math.radians(sea.unrest_deg_s))
    values |= {"R1_N": noise, "R1_Y": noise / LEVER**2}
    values |= {"R2_v1": sea.sway_kn**2, "R2_r": sea.yaw_rate_deg_s**2}
    return values | {"R2_psi": sea.heading_deg**2}


def _unrest(steering: Steering, rate: float) -> float:
    """Return the density of the moment that keeps the yaw rate at ``rate`` [rad/s] rms.

    A force acts with it at LEVER. The variance is linear in the density, by Lyapunov's equation.
    """
    from scipy.linalg import solve_continuous_lyapunov  # noqa: PLC0415

    L, V = steering.length, steering.speed
    theta = steering.prime
    E = np.array(
        [
            [L / V**2 * theta["m11"], L**2 / V**2 * theta["m12"]],
            [L / V**2 * theta["m21"], L**2 / V**2 * theta["m22"]],
        ]
    )
    inverse = np.linalg.inv(E)
    density = inverse @ np.diag([1.0 / LEVER**2, 1.0]) @ inverse.T
    A = np.linalg.solve(steering.M, steering.F)
    if np.linalg.eigvals(A).real.max() >= 0.0:
        raise ConfigError("an unstable ship has no unrest of a size; say --unrest 0")
    variance = solve_continuous_lyapunov(A, -density)
    return float(rate**2 / variance[1, 1])


def _inverse(information: Numbers, names: tuple[str, ...]) -> Numbers:
    """Return the covariance; ConfigError naming parameters that the record cannot separate."""
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    if values[0] < 1e-10:
        lost = [name for name, part in zip(names, vectors[:, 0], strict=True) if abs(part) > 0.1]
        raise ConfigError(f"such a record cannot separate {', '.join(lost)}")
    return np.asarray((vectors / values) @ vectors.T / np.outer(size, size))

