"""The force rows of the wave filter, and the wave numbers that are left, by depth.

A row turns the eight numbers of a bank's modes into one output. Its response to the white noise, at
x times the peak's frequency, is B(x) v, where v is the row and B(x) the responses of the eight
numbers. That of the elevation is H(x). The force at kappa = k_p z is to be

    H(x) F(x),    F(x) = x^2 exp(-kappa (x^2 - 1)),

and its partner a quarter of a period later. Waves push no boat at frequency zero, and hardly near
it. Least squares alone leave 6 to 9 % of the largest response there, which is a slow random force.
So each row is found by least squares among those with B(0) v = 0 and B'(0) v = 0. Then it is scaled
to the variance of H F. Nearer to the surface than kappa = 0.2 that variance hangs on the shortest
waves, and the row stays as it is found.

At the surface itself the force nearly cancels what the water's level does to a boat afloat, and
what is left over near the boat's own period makes it heave. In a swell of 16 to 20 s that is the
period of waves of 1.7 to 2.5 times the peak's frequency. An error there counts three times. This
was chosen by flying: if it counts once, BB2 heaves 9 to 16 % more at 20 s than in the cosine sum.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space, solve_discrete_lyapunov

from trainer.core.kernel import Numbers
from trainer.core.sea.wave_filter import FORCE_DEPTHS, MODE_FACTORS, PHASE_STEP, WAVE_ROWS

Responses = NDArray[np.complex128]

GRID: Final = np.linspace(0.02, 8.0, 4000)  # [-] frequency over the peak's
SHALLOW_KAPPA: Final = 0.2  # [-] below it short waves rule
SHORTEST_WAVE: Final = 6.0  # [-] frequency over the peak's, from which no wave pushes
SHALLOW_SHORTEST_WAVE: Final = 3.5  # [-]
KNOWN_RANGE: Final = (4.0, 0.3)  # [-] frequency, and weight beyond it
SHALLOW_KNOWN_RANGE: Final = (2.5, 0.05)  # [-]
AFLOAT_PERIOD: Final = (1.7, 3.0)  # [-] frequency from which a boat afloat answers, and weight
PEAKEDNESS: Final = (1.0, 3.3)  # [-] by bank
SLOPE_STEP: Final = 1e-4  # [-] frequency over the peak's, by which the slope at rest is found
CUTOFF: Final = 1e-13  # [-] of the largest singular value


def mode_responses(bank: int, x: Numbers) -> Responses:
    """Return the responses [-] of a bank's eight numbers, by frequency over the peak's."""
    factors = (MODE_FACTORS[bank, 0] + 1j * MODE_FACTORS[bank, 1])[:, None]
    turn = np.exp(1j * x * PHASE_STEP)
    above, below = 1.0 / (1.0 - factors / turn), 1.0 / (1.0 - factors.conj() / turn)
    return np.asarray(np.concatenate([0.5 * (above + below), -0.5j * (above - below)]).T)


def noise_covariance(bank: int) -> Numbers:
    """Return the covariance [-] of a bank's eight numbers under white noise of variance 1."""
    along, across = np.diag(MODE_FACTORS[bank, 0]), np.diag(MODE_FACTORS[bank, 1])
    step = np.block([[along, -across], [across, along]])
    noise = np.repeat([1.0, 0.0], 4)
    return np.asarray(solve_discrete_lyapunov(step, np.outer(noise, noise)))


def resting_rows(bank: int) -> Numbers:
    """Return a basis of the rows whose response has a double zero at rest."""
    value = mode_responses(bank, np.zeros(1))[0].real
    slope = mode_responses(bank, np.array([SLOPE_STEP]))[0].imag / SLOPE_STEP
    return np.asarray(null_space(np.vstack([value, slope])))


def fading(kappa: float, shortest: float) -> Numbers:
    """Return F [-] on the grid, up to the shortest wave that pushes."""
    return np.asarray(np.where(shortest > GRID, GRID**2 * np.exp(-kappa * (GRID**2 - 1.0)), 0.0))


def weights(kappa: float) -> Numbers:
    """Return how much an error counts [-], on the grid."""
    beyond, doubt = SHALLOW_KNOWN_RANGE if kappa < SHALLOW_KAPPA else KNOWN_RANGE
    start, much = AFLOAT_PERIOD
    inside = np.where((kappa == 0.0) & (start <= GRID), much, 1.0)
    return np.asarray(np.where(beyond > GRID, inside, doubt))


def force_rows(bank: int, kappa: float) -> Numbers:
    """Return the two rows [-] of a bank's force at a depth."""
    shallow = kappa < SHALLOW_KAPPA
    elevation = mode_responses(bank, GRID) @ WAVE_ROWS[bank, :, 0]
    faded = fading(kappa, SHALLOW_SHORTEST_WAVE if shallow else SHORTEST_WAVE)
    rows = [fitted_row(bank, turn * elevation * faded, weights(kappa)) for turn in (1.0, -1j)]
    if not shallow:
        power = np.abs(elevation) ** 2
        left = float(np.sum(power * faded**2) / np.sum(power))
        rows = [scaled_row(bank, row, left) for row in rows]
    return np.array(rows)


def fitted_row(bank: int, wanted: Responses, weight: Numbers) -> Numbers:
    """Return the row with a double zero at rest that is nearest to the wanted response."""
    basis = resting_rows(bank)
    matrix = (mode_responses(bank, GRID) @ basis) * weight[:, None]
    target = wanted * weight
    place, *_ = np.linalg.lstsq(
        np.vstack([matrix.real, matrix.imag]),
        np.concatenate([target.real, target.imag]),
        rcond=CUTOFF,
    )
    return np.asarray(basis @ place)


def scaled_row(bank: int, row: Numbers, left: float) -> Numbers:
    """Return the row scaled to a variance, over the elevation's."""
    covariance, wave = noise_covariance(bank), WAVE_ROWS[bank, :, 0]
    have = (row @ covariance @ row) / (wave @ covariance @ wave)
    return np.asarray(row * np.sqrt(left / have))


def spectrum(bank: int) -> Numbers:
    """Return the bank's spectrum on the grid, up to a factor."""
    width = np.where(GRID <= 1.0, 0.07, 0.09)
    raised = PEAKEDNESS[bank] ** np.exp(-0.5 * ((GRID - 1.0) / width) ** 2)
    return np.asarray(GRID**-5.0 * np.exp(-1.25 * GRID**-4.0) * raised)


def left_number(bank: int, kappa: float) -> float:
    """Return the wave number of the waves left at a depth, over the peak's [-].

    Of an endless spectrum at the surface it would be endless.
    """
    push = fading(kappa, SHORTEST_WAVE if kappa > 0.0 else SHALLOW_SHORTEST_WAVE) ** 2
    power = push * spectrum(bank)
    return float(np.sum(GRID**2 * power) / np.sum(power))


def all_rows() -> Numbers:
    """Return the rows by bank, depth and output."""
    return np.array([[force_rows(bank, kappa) for kappa in FORCE_DEPTHS] for bank in range(2)])


def all_numbers() -> Numbers:
    """Return the wave numbers that are left [-], by bank and depth."""
    return np.array([[left_number(bank, kappa) for kappa in FORCE_DEPTHS] for bank in range(2)])
