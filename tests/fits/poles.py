"""The poles of the wave filter, and its rows for the elevation.

White noise through eight poles, four of them and their partners, makes an elevation of the spectrum

    S(x) = N(x)^2 / prod_i ((w_i^2 - x^2)^2 + (2 zeta_i w_i x)^2),   N(x) = x^2 (x^2 - a) (x^2 - b),

x times the peak's frequency. The double zero at rest is there because a wave train has no mean. The
ten numbers w_i, zeta_i, a and b are searched so that the energy in bands of 0.1 is the wanted
spectrum's: the bands from 0.6 to 2 count fully, because a boat is moved by them, those beyond
less and less. The search begins with the numbers that stand in the core. They are the best of 400
searches from random numbers, as they were found once.

A pole P becomes the factor exp(P D) of an internal step of D. The residues of N over the poles are
the elevation's row. The row a quarter of a period later is fitted to -i times its response. Both
are scaled to an elevation of variance 1 between steps too, where it is interpolated: four steps and
their cubic, as ``read_outputs`` has it.
"""

from typing import Final

import numpy as np
from scipy.optimize import least_squares

from fits.force_rows import CUTOFF, PEAKEDNESS, Responses, mode_responses, noise_covariance
from trainer.core.kernel import Numbers
from trainer.core.sea.wave_filter import MODE_FACTORS, PHASE_STEP

GRID: Final = np.linspace(0.3, 8.0, 15401)  # [-] frequency over the peak's
GRID_STEP: Final = float(GRID[1] - GRID[0])
BAND_EDGES: Final = np.concatenate(
    [[0.3, 0.5, 0.55], np.arange(0.6, 2.0001, 0.1), [2.25, 2.5, 3.0, 4.0, 6.0]]
)
HALF_BAND_EDGES: Final = np.arange(0.6, 2.0001, 0.05)
FAR_WEIGHTS: Final = (0.6, 0.5, 0.4, 0.25, 0.12)  # of the bands beyond
LOW_WEIGHTS: Final = (0.0, 0.02, 0.1)  # of the bands below
HALF_BAND_WEIGHT: Final = 0.5
LEAST_ENERGY: Final = 1e-4  # [-] below the first band, that is not minded
LOW_ENERGY_WEIGHTS: Final = (0.05, 20.0)  # of its logarithm, and of all below 0.55
NUMERATOR_ZEROS: Final = (  # a and b, by bank, where the search ended
    (0.2818927984680812, -0.10644424270154655),
    (0.23471937648013103, -3.0),
)
ZERO_LIMIT: Final = 3.0  # of a and b: beyond, they do nothing in the bands
ROW_GRID: Final = np.linspace(0.02, np.pi / PHASE_STEP - 0.02, 4000)
QUADRATURE_RANGE: Final = (6.0, 0.03)  # [-] frequency, and weight beyond it
CUBIC_PLACES: Final = np.linspace(0.0, 1.0, 41)  # between two steps


def wanted_spectrum(bank: int, x: Numbers) -> Numbers:
    """Return the bank's spectrum [-]: Pierson-Moskowitz, or JONSWAP with the peak raised."""
    width = np.where(x <= 1.0, 0.07, 0.09)
    raised = PEAKEDNESS[bank] ** np.exp(-0.5 * ((x - 1.0) / width) ** 2)
    return np.asarray(5.0 * x**-5 * np.exp(-1.25 * x**-4) * raised)


def normalised(spectrum: Numbers) -> Numbers:
    """Return a spectrum on the grid with the energy 1."""
    return np.asarray(spectrum / (spectrum.sum() * GRID_STEP))


def band_energies(spectrum: Numbers, edges: Numbers) -> Numbers:
    """Return the energy in each band of a spectrum on the grid."""
    below = np.concatenate([[0.0], np.cumsum(spectrum) * GRID_STEP])
    return np.diff(below[np.searchsorted(GRID, edges)])


def stored_poles(bank: int) -> Responses:
    """Return the poles of the core's factors, over the peak's frequency."""
    return np.asarray(np.log(MODE_FACTORS[bank, 0] + 1j * MODE_FACTORS[bank, 1]) / PHASE_STEP)


def stored_numbers(bank: int) -> Numbers:
    """Return the ten numbers that the core's poles come from: ln w, ln zeta, a and b."""
    poles = stored_poles(bank)
    size = np.abs(poles)
    return np.concatenate([np.log(size), np.log(-poles.real / size), NUMERATOR_ZEROS[bank]])


def poles_of(numbers: Numbers) -> Responses:
    """Return the poles of ten numbers."""
    w, zeta = np.exp(numbers[:4]), np.exp(numbers[4:8])
    return np.asarray(w * (-zeta + 1j * np.sqrt(1.0 - zeta * zeta)))


def filter_spectrum(numbers: Numbers) -> Numbers:
    """Return the spectrum that ten numbers make, on the grid."""
    w, zeta, square = np.exp(numbers[:4]), np.exp(numbers[4:8]), GRID * GRID
    below = np.ones_like(GRID)
    for one, damping in zip(w, zeta, strict=True):
        below = below * ((one**2 - square) ** 2 + (2.0 * damping * one) ** 2 * square)
    above = square * (square - numbers[8]) * (square - numbers[9])
    return normalised(above * above / below)


def spectrum_errors(numbers: Numbers, bank: int) -> Numbers:
    """Return what the search makes small: logarithms of the bands' energies over the wanted."""
    wanted = normalised(wanted_spectrum(bank, GRID))
    made = filter_spectrum(numbers)
    bands = band_energies(made, BAND_EDGES)
    weights = np.concatenate([LOW_WEIGHTS, np.ones(14), FAR_WEIGHTS])
    wide = weights * np.log(bands / (band_energies(wanted, BAND_EDGES) + 1e-12))
    narrow = HALF_BAND_WEIGHT * np.log(
        band_energies(made, HALF_BAND_EDGES) / (band_energies(wanted, HALF_BAND_EDGES) + 1e-12)
    )
    by_log, by_energy = LOW_ENERGY_WEIGHTS
    low = by_log * np.log((bands[0] + LEAST_ENERGY) / LEAST_ENERGY)
    return np.concatenate([wide, narrow, [low, by_energy * (bands[0] + bands[1])]])


def searched_numbers(bank: int) -> Numbers:
    """Return the ten numbers at which the search from the stored ones ends.

    It goes 4e-5 on from them, where they were rounded or the first search stopped; no band of the
    spectrum changes by more than 2e-5 on that way.
    """
    low = np.concatenate([[-1.0] * 4, [-4.5] * 4, [-ZERO_LIMIT] * 2])
    high = np.concatenate([[1.5] * 4, [0.3] * 4, [ZERO_LIMIT] * 2])
    start = np.clip(stored_numbers(bank), low + 1e-12, high - 1e-12)
    found = least_squares(spectrum_errors, start, args=(bank,), bounds=(low, high))
    return np.asarray(found.x)


def elevation_row(bank: int) -> Numbers:
    """Return the row of the elevation, of variance 1 at the steps."""
    poles = stored_poles(bank)
    a, b = NUMERATOR_ZEROS[bank]
    every = np.concatenate([poles, poles.conj()])
    residues = []
    for i, pole in enumerate(poles):
        others = np.delete(every, i)
        above = -(pole**2) * (pole**2 + a) * (pole**2 + b)
        residues.append(2.0 * above / np.prod(pole - others))
    row = np.concatenate([np.real(residues), -np.imag(residues)])
    return np.asarray(row / np.sqrt(row @ noise_covariance(bank) @ row))


def wave_rows(bank: int) -> Numbers:
    """Return the rows of elevation and quadrature, of variance 1 where they are interpolated."""
    responses = mode_responses(bank, ROW_GRID)
    elevation = elevation_row(bank)
    response = responses @ elevation
    beyond, doubt = QUADRATURE_RANGE
    weight = np.where(beyond > ROW_GRID, 1.0, doubt)
    matrix, target = responses * weight[:, None], -1j * response * weight
    quadrature, *_ = np.linalg.lstsq(
        np.vstack([matrix.real, matrix.imag]),
        np.concatenate([target.real, target.imag]),
        rcond=CUTOFF,
    )
    return np.asarray(np.array([elevation, quadrature]) / np.sqrt(interpolated_share(response)))


def interpolated_share(response: Responses) -> float:
    """Return the share of the variance that is left, on the mean, between two steps."""
    power = np.abs(response) ** 2
    q = CUBIC_PLACES[:, None]
    cubic = (
        -q * (q - 1.0) * (q - 2.0) / 6.0,
        (q + 1.0) * (q - 1.0) * (q - 2.0) / 2.0,
        -(q + 1.0) * q * (q - 2.0) / 2.0,
        (q + 1.0) * q * (q - 1.0) / 6.0,
    )
    phase = ROW_GRID * PHASE_STEP
    gain = np.abs(sum(w * np.exp(1j * (i - 1) * phase) for i, w in enumerate(cubic))) ** 2
    return float(np.sum(power * gain.mean(axis=0)) / np.sum(power))
