"""Trials of BB2 and of boats like it, sailed by laws that steer, and the estimate of its hull."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Final
from unittest.mock import patch

import numpy as np

from helpers.places import ROOT
from trainer.analysis.estimate import boat_file
from trainer.analysis.estimate.coefficients import coefficients
from trainer.analysis.estimate.uncertainty import Estimate, deviations, tables
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers, sail_controls
from trainer.identify.boat.motion import STATE, STATE_COUNT, BoatNumbers
from trainer.identify.boat.trial import Trial
from trainer.units import DEGREE, KNOT

HULL: Final = ROOT / "tests" / "data" / "bb2-hull.toml"
STEPS: Final = 2  # of Runge and Kutta in a second
RATE: Final = 7.1 * DEGREE  # [rad/s] of a surface
PUSHES: Final = np.array([3e-3, 3e-3, 3e-3, 1e-4, 5e-5, 3e-5])  # [m/s2, rad/s2 per root of Hz]
READ: Final = (STATE.U, STATE.PSI, STATE.THETA, STATE.PHI, STATE.Z)
ERRORS: Final = np.array([0.05, 0.2 * DEGREE, 0.1 * DEGREE, 0.2 * DEGREE, 0.1])
DAY: Final = np.array([5e-4, 5e-3])  # deviations of weight [-] and trim [m]
DEPTH: Final = 80.0  # [m]
Law = Callable[[float, Numbers], tuple[float, float, float, float]]


def estimated_bb2(folder: Path) -> Path:
    """Return the file of BB2's hull estimated by constants that were fitted without BB2."""
    hull, path = boat_file.open_hull(str(HULL)), folder / "own.toml"
    names = tables()["covariance"]["names"]
    constants = {name: tables()["without"]["BB2"][name] for name in names}
    rows = np.array(tables()["covariance"]["rows"])
    values, mass = coefficients(hull, constants), boat_file.mass_of(hull)
    made = Estimate(hull, mass, constants, rows, values, deviations(hull, values, mass))
    with patch.object(boat_file, "estimate_of", lambda _: made):
        path.write_text(boat_file.write_boat(hull, path).text, encoding="utf-8")
    return path


class _Swing:
    """An angle that goes over to the other side when a motion has followed it so far."""

    def __init__(self, angle: float, execute: float) -> None:
        self.angle, self.execute, self.side = angle * DEGREE, execute * DEGREE, 1.0

    def ordered(self, t: float, motion: float) -> float:
        """Return the angle; positive makes the motion fall."""
        if t < 10.0:
            return 0.0
        if self.side * motion <= -self.execute:
            self.side = -self.side
        return self.side * self.angle


def _keep_depth(x: Numbers) -> float:
    pitch = float(np.clip(0.02 * (x[STATE.Z] - DEPTH), -0.1, 0.1))
    return float(np.clip(-1.5 * (pitch - x[STATE.THETA]) + 4.0 * x[STATE.Q], -0.26, 0.26))


def _keep_course(x: Numbers) -> float:
    return float(np.clip(0.5 * x[STATE.PSI] + 6.0 * x[STATE.R], -0.17, 0.17))


def zigzag(angle: float, knots: float) -> Law:
    """Return a zig-zag, the depth kept by the stern planes."""
    swing = _Swing(angle, angle)
    return lambda t, x: (swing.ordered(t, x[STATE.PSI]), _keep_depth(x), 0.0, knots * KNOT)


def vertical(knots: float) -> Law:
    """Return a vertical zig-zag 8/5, after 300 s with steps of the bow planes, course kept."""
    swing = _Swing(8.0, 5.0)

    def law(t: float, x: Numbers) -> tuple[float, float, float, float]:
        bow = 5.0 * DEGREE * math.copysign(1.0, math.sin(2.0 * math.pi * t / 97.0))
        planes = swing.ordered(t, x[STATE.THETA])
        return _keep_course(x), planes, bow if t > 300.0 else 0.0, knots * KNOT

    return law


def acceleration(slow: float, fast: float) -> Law:
    """Return more revolutions after a minute [kn], course and depth kept."""
    return lambda t, x: (
        _keep_course(x),
        _keep_depth(x),
        0.0,
        (slow if t < 60.0 else fast) * KNOT,
    )


def sail(boat: BoatNumbers, law: Law, knots: float, seconds: int, seed: int, name: str) -> Trial:
    """Return a trial read each second by usual instruments, of a boat pushed at random."""
    stream, state = np.random.default_rng(seed), np.zeros(STATE_COUNT)
    state[STATE.U], state[STATE.Z] = knots * KNOT, DEPTH
    state[STATE.WEIGHT : STATE.TRIM + 1] = DAY * stream.standard_normal(2)
    most = np.array([RATE, RATE, RATE, 0.2])
    inputs, states = [np.array([0.0, 0.0, 0.0, state[STATE.U]])], [state]
    for k in range(seconds):
        change = np.clip(np.array(law(float(k), state)) - inputs[-1], -most, most)
        inputs.append(inputs[-1] + change)
        pair = np.array(inputs[-2:])
        record = RecordNumbers(np.zeros((0, len(CHANNEL_NAMES))), pair, 1.0, STEPS)
        state = sail_controls(boat, record, state)[1]
        state[: len(PUSHES)] += PUSHES * stream.standard_normal(len(PUSHES))
        states.append(state)
    read = np.array(states)[:, READ]
    readings = np.full((len(read), len(CHANNEL_NAMES)), np.nan)
    readings[:, : len(READ)] = read + ERRORS * stream.standard_normal(read.shape)
    return Trial(name, "", 1.0, STEPS, readings, np.array(inputs), (), ())


def four_trials(boat: BoatNumbers, seed: int, seconds: int = 900) -> list[Trial]:
    """Return zig-zags at 6 and 10 kn, a vertical zig-zag at 8 kn and an acceleration."""
    rows = (
        ("zigzag-6", zigzag(10.0, 6.0), 6.0),
        ("zigzag-10", zigzag(10.0, 10.0), 10.0),
        ("vertical-8", vertical(8.0), 8.0),
        ("acceleration", acceleration(5.0, 12.0), 5.0),
    )
    return [
        sail(boat, law, knots, seconds, 10 * seed + i, name)
        for i, (name, law, knots) in enumerate(rows)
    ]
