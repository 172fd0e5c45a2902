"""Steering with a bent spiral curve (MI 12).

T1 T2 r'' + (T1 + T2) r' + K H(r) = K (delta + T3 delta'), H(r) = H1 r + H2 |r| r + H3 r^3. The
state z takes the place of r', so that delta is not differentiated. Numbers are complex, because an
imaginary step carries a derivative. ``fitting/nonlinear`` finds kappa or H(r) by these runs.
"""

from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Complexes, indices, kernel
from trainer.identify.kernels.ship_models import magnitude

BENT: Final = indices("K T1 T2 T3 H1 H2 H3 delta_0")  # of a ship's numbers, SI
Z, YAW_RATE, HEADING = 0, 1, 2  # indices in the state
ANGLE, ANGLE_RATE = 0, 1  # of the rudder, in each row of the helm


@kernel
def bent_rates(ship: Complexes, delta: float, s: Complexes, out: Complexes) -> None:
    """Write d(z, r, psi)/dt."""
    K, T1, T2, T3 = ship[BENT.K], ship[BENT.T1], ship[BENT.T2], ship[BENT.T3]
    H1, H2, H3 = ship[BENT.H1], ship[BENT.H2], ship[BENT.H3]
    r = s[YAW_RATE]
    helm = delta - ship[BENT.delta_0]
    out[Z] = K * (helm - r * (H1 + H2 * magnitude(r) + H3 * r * r))
    out[YAW_RATE] = (s[Z] - (T1 + T2) * r + K * T3 * helm) / (T1 * T2)
    out[HEADING] = r


@kernel
def run_bent(
    ship: Complexes, start: Complexes, helm: Numbers, step: float, parts: int, out: Complexes
) -> None:
    """Write (z, r, psi) at each sample (n, 3), by Runge and Kutta.

    ``step`` [s] is the time from sample to sample, ``parts`` the number of steps of integration in
    it. ``helm`` (n, 2) has the rudder at each sample [rad] and its rate from there to the next.
    """
    s, stage = start.copy(), np.empty(3, np.complex128)
    rate, slope = np.empty(3, np.complex128), np.empty(3, np.complex128)
    h = step / parts
    weights = (1.0, 2.0, 2.0, 1.0)
    reach = (0.0, 0.5, 0.5, 1.0)
    for k in range(helm.shape[0]):
        for i in range(3):
            out[k, i] = s[i]
        for part in range(parts):
            for i in range(3):
                slope[i] = 0j
                rate[i] = 0j
            for turn in range(4):
                for i in range(3):
                    stage[i] = s[i] + reach[turn] * h * rate[i]
                delta = helm[k, ANGLE] + helm[k, ANGLE_RATE] * (part + reach[turn]) * h
                bent_rates(ship, delta, stage, rate)
                for i in range(3):
                    slope[i] += weights[turn] * rate[i]
            for i in range(3):
                s[i] += h / 6.0 * slope[i]
