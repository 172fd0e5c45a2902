"""Boats that change while they manoeuvre, and boats that do not, in calm water and in a sea."""

import math
from typing import Final, NamedTuple

import numpy as np

from helpers.bb2_trials import DAY, DEPTH, ERRORS, PUSHES, RATE, READ, STEPS
from trainer.core.kernel import Numbers
from trainer.identify.boat.altered import ALTERED_PARTS, AlteredPart
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers, sail_controls
from trainer.identify.boat.motion import STATE, STATE_COUNT
from trainer.identify.boat.regressors import PARAMETER_NAMES
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.vessel import REFERENCE_LENGTH_M, FittedVessel
from trainer.units import DEGREE

# of a narrow band at 0.6 rad/s: rms of six accelerations [m/s2, rad/s2]
SEA_SIZES: Final = np.array([0.01, 0.02, 0.03, 2e-3, 8e-4, 3e-4])
SEA_RATE, SEA_DAMPING = 0.6, 0.1  # [rad/s], [-]
BY_NAME: Final = {part.name: part for part in ALTERED_PARTS}


class Alteration(NamedTuple):
    """A part that changes by an amount, in SI or as a share, at a time [s]."""

    name: str
    amount: float
    at: float


NEVER: Final = Alteration("weight", 0.0, math.inf)


def sea_pushes(seconds: int, stream: np.random.Generator) -> Numbers:
    """Return accelerations (n, 6) of a narrow band, each second."""
    root = math.exp(-SEA_DAMPING * SEA_RATE)
    angle = SEA_RATE * math.sqrt(1.0 - SEA_DAMPING**2)
    first, second = 2.0 * root * math.cos(angle), -root * root
    driven = stream.standard_normal((seconds + 200, 6))
    out = np.zeros_like(driven)
    for k in range(2, len(out)):
        out[k] = first * out[k - 1] + second * out[k - 2] + driven[k]
    out = out[200:]
    return np.asarray(SEA_SIZES * out / out.std(axis=0))


class Helm:
    """Orders of a boat that manoeuvres in both planes at once, and changes its speed."""

    def __init__(self, speed: float, still: tuple[str, ...]) -> None:
        self.speed, self.still = speed, still
        self.side, self.way = 1.0, 1.0

    def ordered(self, t: float, x: Numbers) -> Numbers:
        """Return rudder, stern planes, bow planes [rad] and command speed [m/s]."""
        if self.side * x[STATE.PSI] <= -10.0 * DEGREE:
            self.side = -self.side
        wanted = np.clip(0.003 * (x[STATE.Z] - DEPTH), -0.05, 0.05)
        if self.way * (x[STATE.THETA] - wanted) <= -4.0 * DEGREE:
            self.way = -self.way
        bow = 5.0 * DEGREE * _square(t, 97.0) * ("bow" not in self.still)
        speed = self.speed * (1.0 + 0.15 * _square(t, 240.0) * ("speed" not in self.still))
        return np.array([10.0 * DEGREE * self.side, 5.0 * DEGREE * self.way, bow, speed])


def _square(t: float, period: float) -> float:
    """Return 1 and -1 in turn."""
    return math.copysign(1.0, math.sin(2.0 * math.pi * t / period))


def sail_changed(
    vessel: FittedVessel,
    values: Numbers,
    seconds: int,
    seed: int,
    change: Alteration = NEVER,
    *,
    sea: bool = False,
    still: tuple[str, ...] = (),
) -> Trial:
    """Return what usual instruments read each second of a boat that changes on its way."""
    stream, state, part = np.random.default_rng(seed), np.zeros(STATE_COUNT), BY_NAME[change.name]
    helm = Helm(vessel.speed, still)
    state[STATE.U], state[STATE.Z] = vessel.speed, DEPTH
    state[STATE.WEIGHT : STATE.TRIM + 1] = DAY * stream.standard_normal(2)
    state[STATE.TRIM] *= vessel.length / REFERENCE_LENGTH_M
    most, boat = np.array([RATE, RATE, RATE, 0.2]), vessel.numbers(values)
    altered = vessel.numbers(altered_values(values, part, change.amount))
    waves = sea_pushes(seconds, stream) if sea else np.zeros((seconds, 6))
    pushes = PUSHES * stream.standard_normal((seconds, len(PUSHES)))
    inputs, states = [np.array([0.0, 0.0, 0.0, state[STATE.U]])], [state]
    off = np.zeros(4)
    none = np.zeros((0, len(CHANNEL_NAMES)))
    for k in range(seconds):
        if k == change.at:
            boat = altered
            if part.state >= 0:
                state = state.copy()
                state[part.state] += change.amount
            if part.control >= 0:
                off[part.control] = change.amount
        step = np.clip(helm.ordered(float(k), state) - inputs[-1], -most, most)
        inputs.append(inputs[-1] + step)
        record = RecordNumbers(none, np.array(inputs[-2:]) + off, 1.0, STEPS)
        state = sail_controls(boat, record, state)[1]
        state[:6] += pushes[k] + waves[k]
        states.append(state)
    path = np.array(states)
    read = path[:, READ]
    read[:, 0] *= 1.0 + path[:, STATE.LOG_ERROR]
    read[:, 2] += path[:, STATE.PITCH_ERROR]
    read[:, 3] += path[:, STATE.ROLL_ERROR]
    readings = np.full((len(read), len(CHANNEL_NAMES)), np.nan)
    readings[:, : len(READ)] = read + ERRORS * stream.standard_normal(read.shape)
    return Trial(f"seed {seed}", "", 1.0, STEPS, readings, np.array(inputs), (), ())


def altered_values(values: Numbers, part: AlteredPart, amount: float) -> Numbers:
    """Return the parameters of a boat with a part changed."""
    changed = values.copy()
    for name in part.terms:
        changed[PARAMETER_NAMES.index(name)] *= 1.0 + amount
    return changed
