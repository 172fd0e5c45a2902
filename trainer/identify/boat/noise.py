"""How far a boat is disturbed, and its readings and first state are off.

Sizes are for a boat of 70 m at 10 kn, scaled by length and speed as accelerations are. They are on
the generous side: a fit that begins so keeps close to the readings, and then finds its own.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from trainer.analysis.estimate.uncertainty import SMALL_CRAFT_LENGTH_M
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, DRIVEN_COUNT, FilterStart
from trainer.identify.boat.motion import (
    CONTROL_PLACES,
    MOTION_COUNT,
    STATE,
    STATE_COUNT,
    STATE_NAMES,
    Indices,
)
from trainer.identify.boat.trial import USUAL_ERRORS, Trial
from trainer.identify.boat.vessel import REFERENCE_LENGTH_M, REFERENCE_SPEED_M_S, FittedVessel
from trainer.units import DEGREE

# [m/s2, rad/s2 per root of Hz] of six accelerations of BB2 at 10 kn
USUAL_DISTURBANCE: Final = np.array([4e-3, 6e-3, 6e-3, 4e-4, 1.5e-4, 1.5e-4])
DISTURBANCE_DEVIATION: Final = 2.0  # of the logarithm, before a fit
ERROR_DEVIATION: Final = 0.5
FLOW_NAMES: Final = ("north_flow", "east_flow")


class SlowKind(NamedTuple):
    """A slow state: its unit, and its usual deviation [SI], by size of boat."""

    unit: str
    usual: float
    small: float


SLOW_KINDS: Final = {
    "weight": SlowKind("-", 1e-3, 0.01),
    "trim": SlowKind("m", 0.01, 0.002),
    "pitch_error": SlowKind("rad", 0.2 * DEGREE, 0.5 * DEGREE),
    "roll_error": SlowKind("rad", 0.5 * DEGREE, 1.0 * DEGREE),
    "log_error": SlowKind("-", 0.02, 0.02),
    **dict.fromkeys(FLOW_NAMES, SlowKind("m/s", 0.3, 0.3)),  # seen where speed over ground is read
}


@dataclass(frozen=True, eq=False)
class Noise:
    """Logarithms of disturbances (6,) and of errors of readings (9,)."""

    logarithms: Numbers
    gate: float = math.inf  # [-] deviations, beyond which a reading is wild and moves nothing

    @property
    def disturbance(self) -> Numbers:
        """Return the densities of the disturbances."""
        return np.asarray(np.exp(self.logarithms[:DRIVEN_COUNT]))

    @property
    def errors(self) -> Numbers:
        """Return the standard deviations of readings."""
        return np.asarray(np.exp(self.logarithms[DRIVEN_COUNT:]))

    def moved(self, indices: Indices, step: Numbers | float) -> "Noise":
        """Return the noise with some logarithms changed."""
        logarithms = self.logarithms.copy()
        logarithms[indices] += step
        return replace(self, logarithms=logarithms)


def usual_noise(vessel: FittedVessel) -> Noise:
    """Return the noise from which a fit begins."""
    fast = (vessel.speed / REFERENCE_SPEED_M_S) ** 1.5
    small = REFERENCE_LENGTH_M / vessel.length
    scale = fast * np.where(np.arange(DRIVEN_COUNT) < 3, small**0.5, small**1.5)
    sizes = [*(scale * USUAL_DISTURBANCE), *(USUAL_ERRORS[name] for name in CHANNEL_NAMES)]
    return Noise(np.log(sizes))


def noise_deviations() -> Numbers:
    """Return the standard deviation of each logarithm before a fit (15,)."""
    parts = [DISTURBANCE_DEVIATION] * DRIVEN_COUNT, [ERROR_DEVIATION] * len(CHANNEL_NAMES)
    return np.array([*parts[0], *parts[1]])


def slow_deviations(vessel: FittedVessel, trial: Trial) -> Numbers:
    """Return the standard deviations of the slow states (7,) at a record's start."""
    small, sizes = vessel.length < SMALL_CRAFT_LENGTH_M, dict[str, float]()
    for name, kind in SLOW_KINDS.items():
        long = vessel.length / REFERENCE_LENGTH_M if name == "trim" else 1.0
        usual = kind.small if small else kind.usual * long
        seen = name not in FLOW_NAMES or trial.has("ground_speed")
        sizes[name] = trial.biases.get(name, usual) if seen else 0.0
    return np.array([sizes[name] for name in STATE_NAMES[MOTION_COUNT:]])


def start_of(trial: Trial, vessel: FittedVessel, noise: Noise) -> FilterStart:
    """Return the state at a record's first readings, and how far it may be off."""
    state, fast = np.zeros(STATE_COUNT), vessel.speed / REFERENCE_SPEED_M_S
    state[STATE.U] = trial.first(
        "speed", trial.first("ground_speed", trial.inputs[0, CONTROL_PLACES.UC])
    )
    for name, index in (("heading", STATE.PSI), ("pitch", STATE.THETA), ("roll", STATE.PHI)):
        state[index] = trial.first(name, 0.0)
    state[STATE.Z] = trial.first("depth", 0.0)
    for name, index in (("p", STATE.P), ("q", STATE.Q), ("r", STATE.R)):
        state[index] = trial.first(name, 0.0)
    motion = [0.3 * fast, 0.2 * fast, 0.2 * fast, *[0.005 * vessel.pace] * 3, *[DEGREE] * 3, 1.0]
    sd = np.array([*motion, *slow_deviations(vessel, trial)])
    walk = np.zeros(STATE_COUNT - MOTION_COUNT)
    return FilterStart(state, np.diag(sd**2), noise.disturbance, walk, noise.errors, noise.gate)
