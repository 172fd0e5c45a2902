"""The five linear ship models: a kernel for each makes its matrices (MI 5).

``model/models.py`` names the parameters and calls these kernels for every cost of a fit, with many
parameter vectors at once. Each kernel fills, for every row of ``theta``, the continuous blocks that
``model/sampled`` takes.

``ship`` is [L, V, l1, l2, T, output, output, ...] in m, m/s and s; an output is one of the numbers
below. Outputs are in knots, degrees and deg/s, the rudder in degrees, states in m/s, rad/s and rad.
A lag and a correlation are the sine of their parameter, a variance is the magnitude of its own,
because then every real theta is a model, and a search needs no bounds (MI 5). Sine and magnitude
let an imaginary step pass, because it carries the derivative by a parameter.
"""

from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Complexes, indices, kernel
from trainer.units import DEGREE

STERN_SWAY, SWAY, YAW_RATE, HEADING = 1, 2, 3, 4  # outputs; 0 is the bow log
L, V, L1, L2, T, FIRST_OUTPUT = 0, 1, 2, 3, 4, 5  # indices in ``ship``
STATES, FEWER_STATES = 3, 2  # of all models but one, and of that of first order

# indices of the parameters of each model
MODEL_1: Final = indices(
    "m11 m12 m21 m22 Y_v Y_r N_v N_r Y_psi l_psi Y_delta l_delta Y_0 N_0 v1_0 v2_0 r_0 "
    "R1_Y R1_N R1_YN R2_v1 R2_v2 R2_r R2_psi x1_0 x2_0 x3_0 P11 P22 P33 P12 P13 P23 lag"
)
MODEL_2: Final = indices(
    "a1 a2 a3 c1 c2 c3 f1 f2 f3 v_0 R1_1 R1_2 R1_3 R1_12 R1_13 R1_23 R2_v "
    "x1_0 x2_0 x3_0 P11 P22 P33 P12 P13 P23 lag"
)
MODEL_3: Final = indices(
    "a1 a2 a3 b1 b2 f1 f2 r_0 R1_1 R1_2 R1_12 R2_r R2_psi R2_rpsi "
    "x1_0 x2_0 x3_0 P11 P22 P33 P12 P13 P23 lag"
)
NOMOTO_1: Final = indices("K T delta_0 r_0 R1_r R2_r R2_psi x1_0 x2_0 P11 P22 lag")
NOMOTO_2: Final = indices(
    "a1 a2 b1 b2 delta_0 r_0 R1_1 R1_2 R2_r R2_psi x1_0 x2_0 x3_0 P11 P22 P33 lag"
)
START: Final = indices("P11 P22 P33 P12 P13 P23")  # of the first covariance

KNOTS_PER_M_S = 3600.0 / 1852.0  # [kn/(m/s)] alpha 2


class ModelBlocks(NamedTuple):
    """The systems that a kernel fills, one for each parameter vector, from zeros."""

    drift: Complexes  # (b, x+y, x+u+1): [A B f; C D d]
    noise: Complexes  # (b, x+y, x+y)
    start: Complexes  # (b, x, 1+x) the first state and its covariance
    lag: Complexes  # (b,) [s]


class YawReadings(NamedTuple):
    """Bias of the rate, variances of rate and heading, angle of their correlation."""

    r_0: complex
    R2_r: complex
    R2_psi: complex
    R2_rpsi: complex


@kernel
def magnitude(x: complex) -> complex:
    """Return |x| of a number whose imaginary part is a derivative."""
    return x if x.real >= 0.0 else -x


@kernel
def _covariance(first: complex, second: complex, angle: complex) -> complex:
    """Return a covariance from two variances and the angle whose sine is their correlation."""
    return np.sqrt(magnitude(first) * magnitude(second)) * np.sin(angle)


@kernel
def _lag(angle: complex, period: float) -> complex:
    """Return the time lag [s] of the rudder, T |sin|, between 0 and one interval."""
    return period * magnitude(np.sin(angle))


@kernel
def _start_variances(theta: Complexes, start: Complexes) -> None:
    """Write P(t0) (3, 3) after the state of ``start`` from its six parameters."""
    for i in range(3):
        start[i, 1 + i] = magnitude(theta[i])
    start[0, 2] = start[1, 1] = theta[START.P12]
    start[0, 3] = start[2, 1] = theta[START.P13]
    start[1, 3] = start[2, 2] = theta[START.P23]


@kernel
def _model_1_outputs(t: Complexes, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write the rows of the outputs of Model 1: bow and stern log, sway, yaw rate, heading."""
    for row in range(STATES, drift.shape[0]):
        output = int(ship[FIRST_OUTPUT + row - STATES])
        if output == YAW_RATE:
            drift[row, 1] = 1.0 / DEGREE
            drift[row, 4] = t[MODEL_1.r_0]
            noise[row, row] = magnitude(t[MODEL_1.R2_r])
        elif output == HEADING:
            drift[row, 2] = 1.0 / DEGREE
            noise[row, row] = magnitude(t[MODEL_1.R2_psi])
        else:
            aft = output == STERN_SWAY
            arm = 0.0 if output == SWAY else (-ship[L2] if aft else ship[L1])
            drift[row, 0] = KNOTS_PER_M_S
            drift[row, 1] = KNOTS_PER_M_S * arm
            drift[row, 4] = t[MODEL_1.v2_0] if aft else t[MODEL_1.v1_0]
            noise[row, row] = magnitude(t[MODEL_1.R2_v2] if aft else t[MODEL_1.R2_v1])


@kernel
def _model_1(t: Complexes, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write A, B, biases and R1 of Model 1, from the side of forces to that of motions."""
    speed = ship[V]
    arm = ship[L]
    e = arm / (speed * speed)
    e11, e12 = e * t[MODEL_1.m11], e * arm * t[MODEL_1.m12]
    e21, e22 = e * t[MODEL_1.m21], e * arm * t[MODEL_1.m22]
    det = e11 * e22 - e12 * e21
    i11, i12, i21, i22 = e22 / det, -e12 / det, -e21 / det, e11 / det
    force = np.empty((2, 5), drift.dtype)
    force[0, 0], force[1, 0] = t[MODEL_1.Y_v] / speed, t[MODEL_1.N_v] / speed
    force[0, 1], force[1, 1] = arm / speed * t[MODEL_1.Y_r], arm / speed * t[MODEL_1.N_r]
    force[0, 2], force[1, 2] = t[MODEL_1.Y_psi], t[MODEL_1.Y_psi] * t[MODEL_1.l_psi]
    helm = DEGREE * t[MODEL_1.Y_delta]
    force[0, 3], force[1, 3] = helm, -helm * t[MODEL_1.l_delta]
    force[0, 4], force[1, 4] = t[MODEL_1.Y_0], t[MODEL_1.N_0]
    for j in range(5):
        drift[0, j] = i11 * force[0, j] + i12 * force[1, j]
        drift[1, j] = i21 * force[0, j] + i22 * force[1, j]
    drift[2, 1] = 1.0
    y, n = magnitude(t[MODEL_1.R1_Y]), magnitude(t[MODEL_1.R1_N])
    q = _covariance(t[MODEL_1.R1_Y], t[MODEL_1.R1_N], t[MODEL_1.R1_YN])
    noise[0, 0] = i11 * i11 * y + 2.0 * i11 * i12 * q + i12 * i12 * n
    noise[1, 1] = i21 * i21 * y + 2.0 * i21 * i22 * q + i22 * i22 * n
    noise[0, 1] = i11 * i21 * y + (i11 * i22 + i12 * i21) * q + i12 * i22 * n
    noise[1, 0] = noise[0, 1]


@kernel
def model_1(theta: Complexes, ship: Numbers, out: ModelBlocks) -> None:
    """Write the blocks of Model 1: sway and yaw with wind, 34 parameters (MI 5)."""
    drift, noise, start, lag = out
    for b in range(theta.shape[0]):
        t = theta[b]
        _model_1(t, ship, drift[b], noise[b])
        _model_1_outputs(t, ship, drift[b], noise[b])
        start[b, 0, 0] = t[MODEL_1.x1_0] / KNOTS_PER_M_S
        start[b, 1, 0] = DEGREE * t[MODEL_1.x2_0]
        start[b, 2, 0] = DEGREE * t[MODEL_1.x3_0]
        _start_variances(t[MODEL_1.P11 : MODEL_1.lag], start[b])
        lag[b] = _lag(t[MODEL_1.lag], ship[T])


@kernel
def model_2(theta: Complexes, ship: Numbers, out: ModelBlocks) -> None:
    """Write the blocks of Model 2: sway alone, 27 parameters (MI 5)."""
    drift, noise, start, lag = out
    k = ship[V] / ship[L]
    for b in range(theta.shape[0]):
        t = theta[b]
        power = 1.0
        for i in range(3):
            drift[b, i, 3] = DEGREE * ship[V] * k * power * t[MODEL_2.c1 + i]
            power *= k
            drift[b, i, 0] = -power * t[MODEL_2.a1 + i]
            drift[b, i, 4] = t[MODEL_2.f1 + i]
            noise[b, i, i] = magnitude(t[MODEL_2.R1_1 + i])
            start[b, i, 0] = t[MODEL_2.x1_0 + i]
        drift[b, 0, 1] = drift[b, 1, 2] = 1.0
        drift[b, 3, 0] = KNOTS_PER_M_S
        drift[b, 3, 4] = t[MODEL_2.v_0]
        noise[b, 0, 1] = _covariance(t[MODEL_2.R1_1], t[MODEL_2.R1_2], t[MODEL_2.R1_12])
        noise[b, 1, 0] = noise[b, 0, 1]
        noise[b, 0, 2] = noise[b, 2, 0] = t[MODEL_2.R1_13]
        noise[b, 1, 2] = noise[b, 2, 1] = t[MODEL_2.R1_23]
        noise[b, 3, 3] = magnitude(t[MODEL_2.R2_v])
        start[b, 0, 0] /= KNOTS_PER_M_S
        _start_variances(t[MODEL_2.P11 : MODEL_2.lag], start[b])
        lag[b] = _lag(t[MODEL_2.lag], ship[T])


@kernel
def _yaw_outputs(readings: YawReadings, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write yaw rate and heading from states 2 and 3."""
    for row in range(STATES, drift.shape[0]):
        if int(ship[FIRST_OUTPUT + row - STATES]) == YAW_RATE:
            drift[row, 1] = 1.0 / DEGREE
            drift[row, 4] = readings.r_0
            noise[row, row] = magnitude(readings.R2_r)
        else:
            drift[row, 2] = 1.0 / DEGREE
            noise[row, row] = magnitude(readings.R2_psi)
    if drift.shape[0] == 5:  # both are read
        noise[3, 4] = _covariance(readings.R2_r, readings.R2_psi, readings.R2_rpsi)
        noise[4, 3] = noise[3, 4]


@kernel
def model_3(theta: Complexes, ship: Numbers, out: ModelBlocks) -> None:
    """Write the blocks of Model 3: yaw alone, 24 parameters (MI 5)."""
    drift, noise, start, lag = out
    k = ship[V] / ship[L]
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 2] = -k * k * k * t[MODEL_3.a3]
        drift[b, 0, 3] = DEGREE * k * k * k * t[MODEL_3.b2]
        drift[b, 0, 4] = t[MODEL_3.f1]
        drift[b, 1, 0] = drift[b, 2, 1] = 1.0
        drift[b, 1, 1] = -k * t[MODEL_3.a1]
        drift[b, 1, 2] = -k * k * t[MODEL_3.a2]
        drift[b, 1, 3] = DEGREE * k * k * t[MODEL_3.b1]
        drift[b, 1, 4] = t[MODEL_3.f2]
        noise[b, 0, 0], noise[b, 1, 1] = magnitude(t[MODEL_3.R1_1]), magnitude(t[MODEL_3.R1_2])
        noise[b, 0, 1] = _covariance(t[MODEL_3.R1_1], t[MODEL_3.R1_2], t[MODEL_3.R1_12])
        noise[b, 1, 0] = noise[b, 0, 1]
        errors = t[MODEL_3.R2_r], t[MODEL_3.R2_psi], t[MODEL_3.R2_rpsi]
        _yaw_outputs(YawReadings(t[MODEL_3.r_0], *errors), ship, drift[b], noise[b])
        start[b, 0, 0] = t[MODEL_3.x1_0]
        start[b, 1, 0], start[b, 2, 0] = DEGREE * t[MODEL_3.x2_0], DEGREE * t[MODEL_3.x3_0]
        _start_variances(t[MODEL_3.P11 : MODEL_3.lag], start[b])
        lag[b] = _lag(t[MODEL_3.lag], ship[T])


@kernel
def nomoto(theta: Complexes, ship: Numbers, out: ModelBlocks) -> None:
    """Write the blocks of Nomoto's second-order model, 17 parameters (MI 3.3, rate fed back).

    (b1 s + b2)/(s^2 + a1 s + a2), rudder to yaw rate, has no end where the ship is neutral. State 1
    is what the yaw rate still has to gain [rad/s^2]. The rudder acts from its residual helm.
    """
    drift, noise, start, lag = out
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 1] = -t[NOMOTO_2.a2]
        drift[b, 1, 0] = drift[b, 2, 1] = 1.0
        drift[b, 1, 1] = -t[NOMOTO_2.a1]
        drift[b, 0, 3] = DEGREE * t[NOMOTO_2.b2]
        drift[b, 1, 3] = DEGREE * t[NOMOTO_2.b1]
        drift[b, 0, 4] = -drift[b, 0, 3] * t[NOMOTO_2.delta_0]
        drift[b, 1, 4] = -drift[b, 1, 3] * t[NOMOTO_2.delta_0]
        noise[b, 0, 0], noise[b, 1, 1] = magnitude(t[NOMOTO_2.R1_1]), magnitude(t[NOMOTO_2.R1_2])
        errors = t[NOMOTO_2.R2_r], t[NOMOTO_2.R2_psi], 0.0  # not correlated
        _yaw_outputs(YawReadings(t[NOMOTO_2.r_0], *errors), ship, drift[b], noise[b])
        for i in range(3):
            start[b, i, 0] = DEGREE * t[NOMOTO_2.x1_0 + i]
            start[b, i, 1 + i] = magnitude(t[NOMOTO_2.P11 + i])
        lag[b] = _lag(t[NOMOTO_2.lag], ship[T])


@kernel
def nomoto_first(theta: Complexes, ship: Numbers, out: ModelBlocks) -> None:
    """Write the blocks of Nomoto's first-order model K/(1 + T s), 12 parameters (MI 3.3)."""
    drift, noise, start, lag = out
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 0] = -1.0 / t[NOMOTO_1.T]
        drift[b, 0, 2] = DEGREE * t[NOMOTO_1.K] / t[NOMOTO_1.T]
        drift[b, 0, 3] = -drift[b, 0, 2] * t[NOMOTO_1.delta_0]
        drift[b, 1, 0] = 1.0
        noise[b, 0, 0] = magnitude(t[NOMOTO_1.R1_r])
        for row in range(FEWER_STATES, drift.shape[1]):
            rate = int(ship[FIRST_OUTPUT + row - FEWER_STATES]) == YAW_RATE
            drift[b, row, 0 if rate else 1] = 1.0 / DEGREE
            drift[b, row, 3] = t[NOMOTO_1.r_0] if rate else 0.0
            noise[b, row, row] = magnitude(t[NOMOTO_1.R2_r if rate else NOMOTO_1.R2_psi])
        for i in range(2):
            start[b, i, 0] = DEGREE * t[NOMOTO_1.x1_0 + i]
            start[b, i, 1 + i] = magnitude(t[NOMOTO_1.P11 + i])
        lag[b] = _lag(t[NOMOTO_1.lag], ship[T])
