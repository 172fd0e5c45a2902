"""The fading of the mean suction with depth: two integrals over the spectrum, as a formula.

The suction at a depth takes the integrals of S(x) x^n exp(-2 kappa x^2), n 4 and 6, S the
Pierson-Moskowitz spectrum and kappa = k_p z. The core has their logarithms as a sum of five
functions of kappa, found here by least squares on 40 depths.
"""

from typing import Final

import numpy as np
from scipy.integrate import quad

from trainer.core.kernel import Numbers

DEPTHS: Final = np.linspace(0.3, 8.0, 40)  # [-] kappa
SPECTRUM_RANGE: Final = (0.3, 12.0)  # [-] frequency over the peak's, with all of its energy


def fading_integral(power: int, kappa: float) -> float:
    """Return one of the integrals [-]."""

    def inner(x: float) -> float:
        spectrum = 5.0 * x**-5 * np.exp(-1.25 * x**-4)
        return float(x**power * np.exp(-2.0 * kappa * x * x) * spectrum)

    return float(quad(inner, *SPECTRUM_RANGE, limit=200)[0])


def fitted_fading() -> Numbers:
    """Return the factors of 1, ln kappa, its root, itself and its square; by n 4 and 6."""
    columns = np.stack([DEPTHS**0, np.log(DEPTHS), np.sqrt(DEPTHS), DEPTHS, DEPTHS**2], axis=1)
    logarithms = [np.log([fading_integral(n, kappa) for kappa in DEPTHS]) for n in (4, 6)]
    return np.array([np.linalg.lstsq(columns, values, rcond=None)[0] for values in logarithms])
