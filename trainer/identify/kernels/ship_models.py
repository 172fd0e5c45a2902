"""Matrices of the ship models by their parameters (MI 5), many parameter vectors at once.

Each kernel fills, for every row of ``theta``, the continuous blocks that ``sampling`` takes.
``ship`` is [L, V, l1, l2, T, output, output, ...] in m, m/s and s, with outputs by the places
below. Outputs are in knots, degrees and deg/s, the rudder in degrees, states in m/s, rad/s and rad.
Angles stand for lag and correlations (sine), and magnitudes for variances, so that every real theta
is allowed. An imaginary step goes through both.
"""

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import kernel
from trainer.identify.kernels.sampling import Complexes
from trainer.units import DEGREE

BOW, STERN, SWAY, RATE, HEADING = 0, 1, 2, 3, 4
L, V, L1, L2, T, OUTPUTS = 0, 1, 2, 3, 4, 5

KNOT = 3600.0 / 1852.0  # [kn/(m/s)] alpha 2


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
    """Return the time lag [s], T |sin|."""
    return period * magnitude(np.sin(angle))


@kernel
def _start_variances(theta: Complexes, start: Complexes) -> None:
    """Write P(t0) (3, 3) after the state of ``start`` from its six parameters."""
    for i in range(3):
        start[i, 1 + i] = magnitude(theta[i])
    start[0, 2] = start[1, 1] = theta[3]
    start[0, 3] = start[2, 1] = theta[4]
    start[1, 3] = start[2, 2] = theta[5]


@kernel
def _model_1_outputs(t: Complexes, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write the rows of the outputs of Model 1: bow and stern log, sway, yaw rate, heading."""
    for row in range(3, drift.shape[0]):
        output = int(ship[OUTPUTS + row - 3])
        if output == RATE:
            drift[row, 1] = 1.0 / DEGREE
            drift[row, 4] = t[16]
            noise[row, row] = magnitude(t[22])
        elif output == HEADING:
            drift[row, 2] = 1.0 / DEGREE
            noise[row, row] = magnitude(t[23])
        else:
            aft = output == STERN
            arm = 0.0 if output == SWAY else (-ship[L2] if aft else ship[L1])
            drift[row, 0] = KNOT
            drift[row, 1] = KNOT * arm
            drift[row, 4] = t[15] if aft else t[14]
            noise[row, row] = magnitude(t[21] if aft else t[20])


@kernel
def _model_1(t: Complexes, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write A, B, biases and R1 of Model 1, from the side of forces to that of motions."""
    speed = ship[V]
    arm = ship[L]
    e = arm / (speed * speed)
    e11, e12, e21, e22 = e * t[0], e * arm * t[1], e * t[2], e * arm * t[3]
    det = e11 * e22 - e12 * e21
    i11, i12, i21, i22 = e22 / det, -e12 / det, -e21 / det, e11 / det
    force = np.empty((2, 5), drift.dtype)
    force[0, 0], force[1, 0] = t[4] / speed, t[6] / speed
    force[0, 1], force[1, 1] = arm / speed * t[5], arm / speed * t[7]
    force[0, 2], force[1, 2] = t[8], t[8] * t[9]
    force[0, 3], force[1, 3] = DEGREE * t[10], -DEGREE * t[10] * t[11]
    force[0, 4], force[1, 4] = t[12], t[13]
    for j in range(5):
        drift[0, j] = i11 * force[0, j] + i12 * force[1, j]
        drift[1, j] = i21 * force[0, j] + i22 * force[1, j]
    drift[2, 1] = 1.0
    y, n = magnitude(t[17]), magnitude(t[18])
    q = _covariance(t[17], t[18], t[19])
    noise[0, 0] = i11 * i11 * y + 2.0 * i11 * i12 * q + i12 * i12 * n
    noise[1, 1] = i21 * i21 * y + 2.0 * i21 * i22 * q + i22 * i22 * n
    noise[0, 1] = i11 * i21 * y + (i11 * i22 + i12 * i21) * q + i12 * i22 * n
    noise[1, 0] = noise[0, 1]


@kernel
def model_1(
    theta: Complexes,
    ship: Numbers,
    drift: Complexes,
    noise: Complexes,
    start: Complexes,
    lag: Complexes,
) -> None:
    """Write the blocks of Model 1: sway and yaw with wind, 34 parameters (MI 5)."""
    for b in range(theta.shape[0]):
        t = theta[b]
        _model_1(t, ship, drift[b], noise[b])
        _model_1_outputs(t, ship, drift[b], noise[b])
        start[b, 0, 0] = t[24] / KNOT
        start[b, 1, 0] = DEGREE * t[25]
        start[b, 2, 0] = DEGREE * t[26]
        _start_variances(t[27:33], start[b])
        lag[b] = _lag(t[33], ship[T])


@kernel
def model_2(
    theta: Complexes,
    ship: Numbers,
    drift: Complexes,
    noise: Complexes,
    start: Complexes,
    lag: Complexes,
) -> None:
    """Write the blocks of Model 2: sway alone, 27 parameters (MI 5)."""
    k = ship[V] / ship[L]
    for b in range(theta.shape[0]):
        t = theta[b]
        power = 1.0
        for i in range(3):
            drift[b, i, 3] = DEGREE * ship[V] * k * power * t[3 + i]
            power *= k
            drift[b, i, 0] = -power * t[i]
            drift[b, i, 4] = t[6 + i]
            noise[b, i, i] = magnitude(t[10 + i])
            start[b, i, 0] = t[17 + i]
        drift[b, 0, 1] = drift[b, 1, 2] = 1.0
        drift[b, 3, 0] = KNOT
        drift[b, 3, 4] = t[9]
        noise[b, 0, 1] = noise[b, 1, 0] = _covariance(t[10], t[11], t[13])
        noise[b, 0, 2] = noise[b, 2, 0] = t[14]
        noise[b, 1, 2] = noise[b, 2, 1] = t[15]
        noise[b, 3, 3] = magnitude(t[16])
        start[b, 0, 0] /= KNOT
        _start_variances(t[20:26], start[b])
        lag[b] = _lag(t[26], ship[T])


@kernel
def _yaw_outputs(readings: Complexes, ship: Numbers, drift: Complexes, noise: Complexes) -> None:
    """Write yaw rate and heading from states 2 and 3.

    ``readings``: bias of the rate, variances of rate and heading, angle of their correlation.
    """
    for row in range(3, drift.shape[0]):
        if int(ship[OUTPUTS + row - 3]) == RATE:
            drift[row, 1] = 1.0 / DEGREE
            drift[row, 4] = readings[0]
            noise[row, row] = magnitude(readings[1])
        else:
            drift[row, 2] = 1.0 / DEGREE
            noise[row, row] = magnitude(readings[2])
    if drift.shape[0] == 5:
        noise[3, 4] = noise[4, 3] = _covariance(readings[1], readings[2], readings[3])


@kernel
def model_3(
    theta: Complexes,
    ship: Numbers,
    drift: Complexes,
    noise: Complexes,
    start: Complexes,
    lag: Complexes,
) -> None:
    """Write the blocks of Model 3: yaw alone, 24 parameters (MI 5)."""
    k = ship[V] / ship[L]
    readings = np.empty(4, drift.dtype)
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 2] = -k * k * k * t[2]
        drift[b, 0, 3] = DEGREE * k * k * k * t[4]
        drift[b, 0, 4] = t[5]
        drift[b, 1, 0] = drift[b, 2, 1] = 1.0
        drift[b, 1, 1] = -k * t[0]
        drift[b, 1, 2] = -k * k * t[1]
        drift[b, 1, 3] = DEGREE * k * k * t[3]
        drift[b, 1, 4] = t[6]
        noise[b, 0, 0], noise[b, 1, 1] = magnitude(t[8]), magnitude(t[9])
        noise[b, 0, 1] = noise[b, 1, 0] = _covariance(t[8], t[9], t[10])
        readings[0] = t[7]
        readings[1], readings[2], readings[3] = t[11], t[12], t[13]
        _yaw_outputs(readings, ship, drift[b], noise[b])
        start[b, 0, 0] = t[14]
        start[b, 1, 0], start[b, 2, 0] = DEGREE * t[15], DEGREE * t[16]
        _start_variances(t[17:23], start[b])
        lag[b] = _lag(t[23], ship[T])


@kernel
def nomoto(
    theta: Complexes,
    ship: Numbers,
    drift: Complexes,
    noise: Complexes,
    start: Complexes,
    lag: Complexes,
) -> None:
    """Write the blocks of Nomoto's second-order model, 17 parameters (MI 3.3, rate fed back).

    (b1 s + b2)/(s^2 + a1 s + a2), rudder to yaw rate, has no end where the ship is neutral. State 1
    is what the yaw rate still has to gain [rad/s^2]. The rudder acts from its residual helm.
    """
    readings = np.empty(4, drift.dtype)
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 1] = -t[1]
        drift[b, 1, 0] = drift[b, 2, 1] = 1.0
        drift[b, 1, 1] = -t[0]
        drift[b, 0, 3] = DEGREE * t[3]
        drift[b, 1, 3] = DEGREE * t[2]
        drift[b, 0, 4] = -drift[b, 0, 3] * t[4]
        drift[b, 1, 4] = -drift[b, 1, 3] * t[4]
        noise[b, 0, 0], noise[b, 1, 1] = magnitude(t[6]), magnitude(t[7])
        readings[0] = t[5]
        readings[1], readings[2], readings[3] = t[8], t[9], 0.0
        _yaw_outputs(readings, ship, drift[b], noise[b])
        for i in range(3):
            start[b, i, 0] = DEGREE * t[10 + i]
            start[b, i, 1 + i] = magnitude(t[13 + i])
        lag[b] = _lag(t[16], ship[T])


@kernel
def nomoto_first(
    theta: Complexes,
    ship: Numbers,
    drift: Complexes,
    noise: Complexes,
    start: Complexes,
    lag: Complexes,
) -> None:
    """Write the blocks of Nomoto's first-order model K/(1 + T s), 12 parameters (MI 3.3)."""
    for b in range(theta.shape[0]):
        t = theta[b]
        drift[b, 0, 0] = -1.0 / t[1]
        drift[b, 0, 2] = DEGREE * t[0] / t[1]
        drift[b, 0, 3] = -drift[b, 0, 2] * t[2]
        drift[b, 1, 0] = 1.0
        noise[b, 0, 0] = magnitude(t[4])
        for row in range(2, drift.shape[1]):
            rate = int(ship[OUTPUTS + row - 2]) == RATE
            drift[b, row, 0 if rate else 1] = 1.0 / DEGREE
            drift[b, row, 3] = t[3] if rate else 0.0
            noise[b, row, row] = magnitude(t[5 if rate else 6])
        for i in range(2):
            start[b, i, 0] = DEGREE * t[7 + i]
            start[b, i, 1 + i] = magnitude(t[9 + i])
        lag[b] = _lag(t[11], ship[T])
