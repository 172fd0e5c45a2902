"""The worth of a record before it is taken: standard deviations by the information matrix.

``trainer ship prbs`` shows them beside the experiment that it proposes. The inverse of the expected
information is the smallest covariance that any estimate can have (Cramer and Rao), and maximum
likelihood reaches it in long records. So no record need be simulated.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.sensors import Sensors
from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.problem import problem_of
from trainer.identify.fitting.start_values import ERROR_NAMES, INITIAL_STATE_NAMES, free_names
from trainer.identify.judge.propagation import propagate_covariance
from trainer.identify.judge.uncertainty import uncertainty
from trainer.identify.model.derived import quantities, quantity_units
from trainer.identify.model.models import MODELS, OUTPUT_UNITS, Plant, Ship
from trainer.identify.model.steering import SteeringModel
from trainer.identify.record.measurements import Record, samples_of

MAX_SPREAD: Final = 100.0  # times a parameter's size: known no better, it is not known at all
SEA_LEVER_LENGTHS: Final = 0.25  # [-] of the length: at which the sea's force makes its moment


@dataclass(frozen=True)
class Prospect:
    """Expected values and standard deviations of a record, by name, in SI and prime.

    They are of Model 1 where sway is read. Without sway only rudder to yaw can be determined.
    """

    model: str
    samples: int
    interval_s: float
    values: dict[str, float]
    deviations: dict[str, float]


def prospect(
    steering: SteeringModel,
    record: Record,
    outputs: tuple[str, ...],
    sensors: Sensors,
    unrest: float,
) -> Prospect:
    """Return what would be known from such a record of such a ship.

    ``unrest`` [deg/s] is the rms yaw rate that the sea alone makes. ConfigError if the record
    cannot separate the parameters.
    """
    kind = "1" if "sway" in outputs else "nomoto2"
    model = MODELS[kind]
    plant = Plant(model, Ship(steering.length, steering.speed), outputs, record.interval)
    errors = {
        name: (sensors.error(channel) * OUTPUT_UNITS[channel][1]) ** 2
        for channel, name in ERROR_NAMES[kind].items()
    }
    values = model.vector(**_ship(steering, kind), **errors)
    for name, channel in INITIAL_STATE_NAMES[kind]:
        if channel:
            values[model.index(name)] = float(record.column(channel)[0]) * OUTPUT_UNITS[channel][1]
    # the ratio of the densities of disturbance; their size follows from the unrest
    sea = {"R1_N": 1.0, "R1_Y": SEA_LEVER_LENGTHS**-2}
    if kind != "1":  # the moment acts on yaw at once and, through sway, by the rate 1/T3
        sea = {"R1_2": 1.0, "R1_1": steering.nomoto.T3**-2}
    for name, share in sea.items():
        values[model.index(name)] = share
    density = _density(plant, values, math.radians(unrest))
    for name in sea:
        values[model.index(name)] *= density
    free = [name for name in free_names(plant, ()) if name not in sea or density > 0.0]
    problem = problem_of(plant, samples_of(record, outputs), values, free)
    known = uncertainty(problem.names, Likelihood(problem).information(problem.start))
    spread = np.sqrt(np.diag(known.covariance)) / np.maximum(np.abs(problem.start), 1.0)
    vague = [(name,) for name, one in zip(problem.names, spread, strict=True) if one > MAX_SPREAD]
    if lost := known.flat or vague:
        groups_text = "; ".join(" with ".join(group) for group in lost)
        raise ConfigError(f"such a record cannot separate {groups_text}")
    expected_spread = propagate_covariance(
        lambda theta: quantities(plant, problem.whole(theta)), problem.start, known.covariance
    )
    names = quantity_units(model)
    return Prospect(
        model=kind,
        samples=len(record.t),
        interval_s=record.interval,
        values=dict(zip(names, map(float, expected_spread.values), strict=True)),
        deviations=dict(zip(names, map(float, expected_spread.deviations), strict=True)),
    )


def _ship(steering: SteeringModel, kind: str) -> dict[str, float]:
    """Return the model's parameters of the ship.

    ConfigError if it has a pair of complex roots, and so no T1 and T2.
    """
    if kind == "1":
        return steering.prime
    form = steering.nomoto
    if form.T1.imag:
        raise ConfigError("sway and yaw swing together: rudder to yaw alone has no T1 and T2")
    return {"K": form.K, "T1": form.T1.real, "T2": form.T2.real, "T3": form.T3}


def _density(plant: Plant, values: Numbers, rate: float) -> float:
    """Return by what to multiply the densities for a yaw rate of ``rate`` [rad/s] rms.

    The sea alone makes that yaw rate. Its variance is linear in the densities, by Lyapunov's
    equation for the states without heading.
    """
    from scipy.linalg import solve_continuous_lyapunov  # noqa: PLC0415

    if rate == 0.0:
        return 0.0
    blocks = plant.blocks(values[None])
    A, noise = blocks.drift[0, :2, :2], blocks.noise[0, :2, :2]
    if np.linalg.eigvals(A).real.max() >= 0.0:
        raise ConfigError("an unstable ship has no unrest of a size; say --unrest 0")
    return float(rate**2 / solve_continuous_lyapunov(A, -noise)[1, 1])
