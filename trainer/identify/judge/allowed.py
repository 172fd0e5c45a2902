"""Ships that the record of a fit allows beside it, drawn and run (MI 8.5).

``pages/identify`` draws them as bands. Parameters are drawn from N(estimate, covariance). In place
of a lever arm its moment is drawn: a record determines force and moment of a rudder, and their
ratio is not normal. A draw that is no model is left out, and the page says how many of the draws
were.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import possible
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge.fitted import ModelFit
from trainer.identify.judge.uncertainty import TAIL_SHARE, Span, draw_parameters, span_draws
from trainer.identify.judge.validation import predict_alone
from trainer.identify.model.derived import quantities
from trainer.identify.record.measurements import Samples

DRAW_SEED: Final = 1  # fixed: the same fit gives the same bands
QUANTITY_DRAWS: Final = 1000  # draws that intervals of gains and time constants are of
MOTION_DRAWS: Final = 200  # of these draws that are run
RESPONSE_TIME_CONSTANTS: Final = 6.0  # time constants, that a response is shown for
MIN_RESPONSE_SAMPLES: Final = 20  # [samples] of it
BODE_OUTPUTS: Final = ("yaw_rate", "heading", "sway")  # to the rudder, in Bode figures
LEVER_FORCES: Final = {"l_delta": "Y_delta", "l_psi": "Y_psi"}  # lever arms and their forces
MIN_COMPLEX_SHARE: Final = 0.025  # [-] of complex pairs, from which T1 and T2 are not told apart


class ShipBand(NamedTuple):
    """The range of 95 % of the ships, lowest to highest, and the middle."""

    t: Numbers  # (n,) [s], or [rad/s]
    low: Numbers  # (n, y)
    middle: Numbers
    high: Numbers


@dataclass(frozen=True, eq=False)
class AllowedShips:
    """Ships drawn for a fit."""

    problem: Problem
    draws: Numbers  # (k, f)
    spans: Span  # of the fit's quantities
    paired: float  # share of all draws whose T1 and T2 are a complex pair

    @cached_property
    def sailing(self) -> Numbers:
        """Return those of the first MOTION_DRAWS draws that are models (k, f)."""
        tried = self.draws[:MOTION_DRAWS]
        sailing_rows = tried[[_sails(self.problem, one) for one in tried]]
        return sailing_rows if len(sailing_rows) else self.problem.start[None]

    @property
    def lost(self) -> float:
        """Return the share of draws that were no model [-]."""
        return 1.0 - len(self.sailing) / len(self.draws[:MOTION_DRAWS])

    @cached_property
    def outputs(self) -> ShipBand:
        """Return the outputs of these ships under the record's rudder.

        Each ship runs from its own initial state.
        """
        return self._band(self.problem, None)

    def response(self, inputs: Numbers) -> ShipBand:
        """Return the change of the outputs by ``inputs`` (n, u), a rudder [deg], every interval."""
        t = np.arange(len(inputs), dtype=np.float64) * self.problem.plant.period
        still = np.zeros((len(inputs), len(self.problem.plant.outputs)))
        under = self.problem.on(Samples(t, still, inputs))
        return self._band(under, under.on(Samples(t, still, np.zeros_like(inputs))))

    def bode(self, omega: Numbers) -> tuple[tuple[str, ...], ShipBand, ShipBand]:
        """Return outputs, gain [dB] and phase [deg] at ``omega`` (w,) [rad/s], rudder to starboard.

        The gain is of the models' units: 1/s of yaw rate, 1 of heading, kn/deg of sway.
        """
        plant = self.problem.plant
        outputs = tuple(name for name in BODE_OUTPUTS if name in plant.model.outputs)
        whole = np.array([self.problem.whole(theta) for theta in self.sailing])
        blocks, n = replace(plant, outputs=outputs).blocks(whole), plant.model.states
        A, C = blocks.drift[:, :n, :n], blocks.drift[:, n:, :n]
        b, d = blocks.drift[:, :n, n : n + 1], blocks.drift[:, n:, n : n + 1]
        s = 1j * omega[:, None, None, None]
        gain = -(C @ np.linalg.solve(s * np.eye(n) - A, b + 0j) + d)[..., 0]
        gain *= np.exp(-s[..., 0] * blocks.lag[:, None])
        phase = np.unwrap(np.degrees(np.angle(gain)), period=360.0, axis=0)
        phase -= 360.0 * np.ceil((phase[0] - 60.0) / 360.0)  # from +60 to -300 at first
        sizes = 20.0 * np.log10(np.maximum(np.abs(gain), 1e-300))
        return outputs, _spread(omega, sizes), _spread(omega, phase)

    def _band(self, under: Problem, without: Problem | None) -> ShipBand:
        """Return the band of the outputs ``under`` a rudder, less those ``without`` it."""
        runs = np.array([predict_alone(under, theta) for theta in self.sailing])
        if without is not None:
            runs -= np.array([predict_alone(without, theta) for theta in self.sailing])
        return _spread(under.samples.t, runs.swapaxes(0, 1))


def _spread(t: Numbers, found: Numbers) -> ShipBand:
    """Return the band of numbers (n, ships, y)."""
    return ShipBand(t, *np.quantile(found, (TAIL_SHARE, 0.5, 1.0 - TAIL_SHARE), axis=1))


def draw_allowed(fitted: ModelFit) -> AllowedShips:
    """Return the ships that the record of a fit allows.

    A parameter whose deviation is not known has its estimated value in all of them.
    """
    problem, plant = fitted.problem, fitted.problem.plant
    covariance = np.nan_to_num(fitted.known.covariance, nan=0.0)
    theta = fitted.found.theta
    every = _draw_parameters(problem.names, theta, covariance)
    numbers, spans = span_draws(lambda one: quantities(plant, problem.whole(one)), every)
    if np.isnan(fitted.quantity_spread.covariance).any():
        spans = Span(*(np.full_like(end, math.nan) for end in spans))
    swinging = "T_imag" in fitted.quantity_names
    swing = numbers[:, fitted.quantity_names.index("T_imag")] if swinging else np.zeros(1)
    return AllowedShips(problem, every, spans, float(np.mean(swing != 0.0)))


def _sails(problem: Problem, theta: Numbers) -> bool:
    """Return whether parameters are a possible model whose run stays finite."""
    with np.errstate(all="ignore"):  # kernels that are not compiled tell of what they lose
        return possible(problem.sampled(theta)) and bool(
            np.isfinite(predict_alone(problem, theta)).all()
        )


def _draw_parameters(names: tuple[str, ...], theta: Numbers, covariance: Numbers) -> Numbers:
    """Return parameter vectors (count, f); a lever arm is drawn as its force's moment."""
    pairs = [
        (names.index(arm), names.index(force))
        for arm, force in LEVER_FORCES.items()
        if arm in names and force in names
    ]
    middle, J = theta.copy(), np.eye(len(theta))
    for arm, force in pairs:
        middle[arm] = theta[arm] * theta[force]
        J[arm, arm], J[arm, force] = theta[force], theta[arm]
    draws = draw_parameters(middle, J @ covariance @ J.T, QUANTITY_DRAWS, DRAW_SEED)
    for arm, force in pairs:
        draws[:, arm] /= draws[:, force]
    return draws


def step_of(fitted: ModelFit) -> Numbers:
    """Return a rudder (n,) [deg] that goes to 1 degree, until the ship has settled."""
    plant, samples = fitted.problem.plant, fitted.problem.samples
    quantity_values = dict(zip(fitted.quantity_names, fitted.quantity_spread.values, strict=True))
    slowest = abs(quantity_values["T1"]) or plant.period
    count = math.ceil(min(RESPONSE_TIME_CONSTANTS * slowest / plant.period, 1e6))
    rudder = np.ones(max(MIN_RESPONSE_SAMPLES, min(count, len(samples.t))))
    rudder[0] = 0.0
    return rudder


def pulse_of(fitted: ModelFit) -> Numbers:
    """Return a rudder (n,) [deg] of one degree second, in the second interval."""
    rudder = np.zeros_like(step_of(fitted))
    rudder[1] = 1.0 / fitted.problem.plant.period
    return rudder
