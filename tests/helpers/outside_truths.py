"""Trials of boats whose forces a fit does not know: waves, the surface near, a late vortex."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from helpers.bb2_trials import DAY, DEPTH, ERRORS, PUSHES, RATE, READ, STEPS, Law
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.world.sea import SeaFile, load_sea
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers, sail_controls
from trainer.identify.boat.motion import STATE, STATE_COUNT, STATE_NAMES
from trainer.identify.boat.regressors import PARAMETER_NAMES
from trainer.identify.boat.trial import MIN_DEPTH_DIAMETERS, Trial
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE, KNOT

BREADTH: Final = 9.6  # [m] of BB2
NEAR_DEPTH: Final = 3.0 * BREADTH  # [m] where waves and the calm surface are felt
LEAST_DEPTH: Final = MIN_DEPTH_DIAMETERS * BREADTH + 0.5  # [m] that a fit takes, and an error
CORE_STEP_S: Final = 0.25
# the force of the sail's vortex on the hull behind it, in the terms of drift and turning
VORTEX_TERMS: Final = ("Z_vv", "Z_vr", "Z_rr", "M_vv", "M_vr", "M_rr")
VORTEX_LENGTHS: Final = 0.5  # [L/u] from the sail to the middle of the hull behind it; an estimate
FACTORS: Final = {"v": STATE.V, "r": STATE.R}
MOTION_FIELDS: Final = tuple(STATE_NAMES[: STATE.Z + 1])


def vertical_at_depth(knots: float) -> Law:
    """Return a vertical zig-zag 8/5 about the pitch that brings the boat back to its depth."""
    side = [1.0]

    def law(t: float, x: Numbers) -> tuple[float, float, float, float]:
        wanted = float(np.clip(0.004 * (x[STATE.Z] - DEPTH), -0.08, 0.08))
        if side[0] * (x[STATE.THETA] - wanted) <= -5.0 * DEGREE:
            side[0] = -side[0]
        bow = 5.0 * DEGREE * math.copysign(1.0, math.sin(2.0 * math.pi * t / 97.0))
        rudder = float(np.clip(0.5 * x[STATE.PSI] + 6.0 * x[STATE.R], -0.17, 0.17))
        planes = side[0] * 8.0 * DEGREE if t > 10.0 else 0.0
        return rudder, planes, bow if t > 300.0 else 0.0, knots * KNOT

    return law


def sea_of(generator: str) -> SeaFile:
    """Return sea state 3 from that generator."""
    file = load_sea("sea-state-3")
    return replace(file, sea=replace(file.sea, generator=generator, direction_deg=40.0))


def under_the_surface(file: VesselFile) -> VesselFile:
    """Return a boat that feels the calm surface as BB2 does."""
    return replace(file, free_surface=load_vessel("bb2").free_surface)


def sail_core(
    file: VesselFile, law: Callable[[], Law], knots: float, seconds: int, seed: int, sea: str = ""
) -> Trial:
    """Return a trial of the trainer's own boat, pushed at random and by a sea.

    It begins at NEAR_DEPTH, or as much deeper as keeps it where a fit takes its readings.
    """
    boat = Boat(file, Method("full", "exact", "exact", "rk4", CORE_STEP_S))
    if sea:
        boat.sea = sea_of(sea)
    trial = _sail_core(boat, law(), knots, seconds, seed, NEAR_DEPTH)
    rise = LEAST_DEPTH - trial.readings[:, CHANNEL_NAMES.index("depth")].min()
    if rise > 0.0:
        trial = _sail_core(boat, law(), knots, seconds, seed, NEAR_DEPTH + rise)
    return trial


def _sail_core(boat: Boat, law: Law, knots: float, seconds: int, seed: int, depth: float) -> Trial:
    """Return the same from a depth [m] on."""
    stream = np.random.default_rng(seed)
    boat.start(knots * KNOT, depth, 0.0, seed)
    s, (heavier, moved) = boat.state, DAY * stream.standard_normal(2)
    boat.records.vessel["torque_limit"] = 0.0
    s.by_hand[:] = s.speed_by_hand = s.trim_by_hand = s.held_tanks = 1.0
    s.x_g += moved
    s.weight *= 1.0 + heavier
    inputs = [np.array([s.delta_r, s.delta_s, s.delta_b, s.u_c])]
    states = [np.array(boat.numbers(MOTION_FIELDS))]
    for k in range(seconds):
        seen = np.append(states[-1], np.zeros(STATE_COUNT - len(MOTION_FIELDS)))
        seen[STATE.Z] += DEPTH - depth
        s.ordered_r, s.ordered_s, s.ordered_b, s.ordered_u_c = law(float(k), seen)
        for _ in range(round(1.0 / CORE_STEP_S)):
            if boat.tick():
                return lost_trial(inputs, states)
        for name, push in zip(MOTION_FIELDS, PUSHES * stream.standard_normal(6), strict=False):
            s[name] += push
        inputs.append(np.array([s.delta_r, s.delta_s, s.delta_b, s.u_c]))
        states.append(np.array(boat.numbers(MOTION_FIELDS)))
    return read_trial(inputs, states, stream)


def sail_vortex(
    vessel: FittedVessel, values: Numbers, law: Law, knots: float, seconds: int, seed: int
) -> Trial:
    """Return a trial of a boat whose sail's vortex reaches the hull late, by a first-order lag."""
    stream, state, boat = np.random.default_rng(seed), np.zeros(STATE_COUNT), vessel.numbers(values)
    state[STATE.U], state[STATE.Z] = knots * KNOT, DEPTH
    state[STATE.WEIGHT : STATE.TRIM + 1] = DAY * stream.standard_normal(2)
    most, late = np.array([RATE, RATE, RATE, 0.2]), np.zeros(len(VORTEX_TERMS))
    none = np.zeros((0, len(CHANNEL_NAMES)))
    inputs, states = [np.array([0.0, 0.0, 0.0, state[STATE.U]])], [state]
    for k in range(seconds):
        change = np.clip(np.array(law(float(k), state)) - inputs[-1], -most, most)
        inputs.append(inputs[-1] + change)
        state = sail_controls(boat, RecordNumbers(none, np.array(inputs[-2:]), 1.0, STEPS), state)[
            1
        ]
        now = np.array([np.prod([state[FACTORS[one]] for one in key[2:]]) for key in VORTEX_TERMS])
        late += (1.0 - math.exp(-state[STATE.U] / (VORTEX_LENGTHS * vessel.length))) * (now - late)
        force = np.zeros(6)
        for key, behind in zip(VORTEX_TERMS, late - now, strict=True):
            force["XYZKMN".index(key[0])] += boat.forces[PARAMETER_NAMES.index(key)] * behind
        state[:6] += boat.inverse @ force + PUSHES * stream.standard_normal(6)
        states.append(state)
    return read_trial(inputs, states, stream)


def read_trial(inputs: list[Numbers], states: list[Numbers], stream: np.random.Generator) -> Trial:
    """Return what usual instruments read of a run."""
    read = np.array(states)[:, READ]
    readings = np.full((len(read), len(CHANNEL_NAMES)), np.nan)
    readings[:, : len(READ)] = read + ERRORS * stream.standard_normal(read.shape)
    return Trial("outside", "", 1.0, STEPS, readings, np.array(inputs), (), ())


def lost_trial(inputs: list[Numbers], states: list[Numbers]) -> Trial:
    """Return a trial without a reading, of a boat that was lost in it."""
    readings = np.full((len(states), len(CHANNEL_NAMES)), np.nan)
    return Trial("lost", "", 1.0, STEPS, readings, np.array(inputs), (), ())
