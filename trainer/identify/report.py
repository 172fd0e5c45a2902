"""All that ``trainer identify`` says about a model, as records that become page, JSON and sheet."""

from dataclasses import dataclass
from typing import Any

from trainer.identify.nonlinear import Bend
from trainer.identify.prediction import Check
from trainer.identify.residuals import Residuals
from trainer.identify.rivals import Rival


@dataclass(frozen=True)
class Estimate:
    """One number and its standard deviation, None where the record does not tell."""

    name: str
    unit: str
    value: float
    deviation: float | None


@dataclass(frozen=True)
class ShipNumber:
    """A gain or time constant, its standard deviation, and its 95 % interval by draws.

    None where the record does not tell. Where the two differ the interval is right: the number
    bends with the parameters.
    """

    name: str
    unit: str
    value: float
    deviation: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class MonteCarlo:
    """Ships drawn from what the record leaves open (8.5)."""

    draws: int
    paired: float  # [-] share whose T1 and T2 are a complex pair


@dataclass(frozen=True)
class Derivative:
    """A derivative in the study's system, and in the other one where the mass is known."""

    name: str
    prime: float | None
    bis: float | None
    deviation: float | None  # in the study's system


@dataclass(frozen=True)
class Direction:
    """An eigenvalue of the scaled second derivatives, and the parameters of its direction."""

    eigenvalue: float
    parts: dict[str, float]  # [-] of the unit vector, those above a tenth of the largest


@dataclass(frozen=True)
class Report:
    """All that ``trainer identify`` says about a model."""

    study: str
    source: str
    model: str
    settings: dict[str, Any]
    length_m: float
    speed_kn: float
    outputs: tuple[str, ...]
    samples: int
    interval_s: float
    findings: tuple[str, ...]
    converged: bool
    steps: int
    log_likelihood: float
    aic: float
    loss_1: float  # V1 of the one-step errors
    loss_1_alone: float  # V1 of the model by rudder alone
    screened: int
    parameters: tuple[Estimate, ...]
    ship: tuple[ShipNumber, ...]
    monte_carlo: MonteCarlo
    derivatives: tuple[Derivative, ...]
    stability: str
    eigenvalue: float  # smallest of the scaled information
    weakest: tuple[str, ...]  # parameters of that direction
    eigenvalues: tuple[Direction, ...]  # all, smallest first
    collapsed: tuple[str, ...]  # errors of readings that went to their floor
    residuals: tuple[Residuals, ...]
    verdicts: tuple[str, ...]
    rivals: tuple[Rival, ...] = ()
    check: Check | None = None
    bend: Bend | None = None
