"""Waves as the report has them, for comparison with the generators of the core.

Spectrum, bands and filter of [ASSES] with its errata (H), in any consistent units; also its cosine
series with half the variance, and its Euler form of the filter, both "as in the report".
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import polynomial

from trainer.core.kernel import Numbers

ALPHA: Final = 8.1e-3  # [-] of Pierson and Moskowitz
BETA: Final = 0.74  # [-]
ANGLES: Final = np.radians([-60.0, -30.0, 0.0, 30.0, 60.0])  # [rad] from the wind
# Shares of the energy, sum pi/2; and as Table 14 prints them, whose middle one is a slip.
WEIGHTS: Final = np.array(
    [
        (np.pi / 3.0 - np.sqrt(3.0) / 2.0) / 2.0,
        np.sqrt(3.0) / 4.0,
        np.pi / 6.0,
        np.sqrt(3.0) / 4.0,
        (np.pi / 3.0 - np.sqrt(3.0) / 2.0) / 2.0,
    ]
)
WEIGHTS_PRINTED: Final = np.array([0.0906, 0.433, 0.5325, 0.433, 0.0906])


@dataclass(frozen=True)
class FullSea:
    """A fully developed sea."""

    wind: float  # [m/s]
    g: float  # [m/s2]

    @property
    def variance(self) -> float:
        """Return m0 [m2]."""
        return ALPHA * self.wind**4 / (4.0 * BETA * self.g**2)

    @property
    def height(self) -> float:
        """Return the significant height [m]."""
        return float(4.0 * np.sqrt(self.variance))

    @property
    def peak(self) -> float:
        """Return the frequency of the spectrum's peak [rad/s]."""
        return float((0.8 * BETA) ** 0.25 * self.g / self.wind)

    def density(self, omega: Numbers) -> Numbers:
        """Return the one-sided variance density [m2 s]."""
        decay = np.exp(-BETA * (self.g / (self.wind * omega)) ** 4)
        return np.asarray(ALPHA * self.g**2 * omega**-5.0 * decay)

    def part_below(self, omega: Numbers) -> Numbers:
        """Return the part of the variance [-] below ``omega`` [rad/s]."""
        return np.asarray(np.exp(-BETA * (self.g / (self.wind * omega)) ** 4))

    def frequency(self, part: Numbers) -> Numbers:
        """Return the frequency [rad/s] below which ``part`` of the variance lies."""
        return np.asarray(self.g / self.wind * (BETA / -np.log(part)) ** 0.25)


@dataclass(frozen=True)
class Bands:
    """Ten bands of equal variance between 0.2 and 1.8 rad/s."""

    sea: FullSea
    edges: Numbers  # [rad/s]

    @property
    def middle(self) -> Numbers:
        """Return the middle of each band [rad/s]."""
        return np.asarray(0.5 * (self.edges[1:] + self.edges[:-1]))

    @property
    def variance(self) -> float:
        """Return the variance [m2] of each band."""
        low, high = self.sea.part_below(self.edges[[0, -1]])
        return float(self.sea.variance * (high - low) / (self.edges.size - 1))

    def amplitudes(self) -> Numbers:
        """Return amplitudes [m] by direction and band, with the whole variance."""
        by_direction = np.sqrt(2.0 * (2.0 / np.pi) * WEIGHTS * self.variance)
        return np.asarray(np.outer(by_direction, np.ones(self.edges.size - 1)))

    def amplitudes_report(self) -> Numbers:
        """Return amplitudes [m] as in the report: half the variance, density at mid-frequency."""
        energy = self.sea.density(self.middle) * np.diff(self.edges)
        return np.asarray(np.sqrt(2.0 / np.pi * np.outer(WEIGHTS_PRINTED, energy)))


def bands(sea: FullSea) -> Bands:
    """Return the ten bands of ``sea``."""
    low, high = sea.part_below(np.array([0.2, 1.8]))
    return Bands(sea, sea.frequency(low + (high - low) * np.arange(11) / 10.0))


def cosine_series(
    split: Bands, eps: Numbers, time: Numbers, place: tuple[float, float], depth: float
) -> Numbers:
    """Return the elevation [m] at ``place``, x downwind, fading with ``depth`` [m] as the force.

    All directions share the middle frequencies; ``eps`` are phases [rad] by direction and band.
    """
    k = split.middle**2 / split.sea.g
    way = np.outer(np.cos(ANGLES) * place[0] + np.sin(ANGLES) * place[1], k)
    size = split.amplitudes() * np.exp(-k * depth)
    phase = np.multiply.outer(time, split.middle)[:, np.newaxis, :] - way + eps
    return np.asarray(np.sum(size * np.cos(phase), axis=(1, 2)))


@dataclass(frozen=True)
class Section:
    """(b0 + b1/z + b2/z^2)/(1 + a1/z + a2/z^2)."""

    b: tuple[float, float, float]
    a: tuple[float, float]

    @property
    def pole_radius(self) -> float:
        """Return the largest distance of a pole from zero [-]; stable below 1."""
        return float(np.max(np.abs(polynomial.polyroots([self.a[1], self.a[0], 1.0]))))

    def run(self, x: Numbers) -> Numbers:
        """Return the output for the input ``x``, from rest."""
        y = np.zeros(x.size)
        for n in range(x.size):
            y[n] = sum(self.b[i] * x[n - i] for i in range(min(n, 2) + 1))
            y[n] -= sum(self.a[i] * y[n - 1 - i] for i in range(min(n, 2)))
        return y


def euler_sections(low: tuple[float, float], high: tuple[float, float], h: float) -> list[Section]:
    """Return the filter by the report's Euler substitution, for comparison only (errata H7, H8).

    ``low`` and ``high`` are frequency [rad/s] and damping [-]. Stable for h < 2 d/w, and far off
    long before that.
    """

    def poles(omega: float, damping: float) -> tuple[float, float]:
        step = omega * h
        return -2.0 + 2.0 * damping * step, 1.0 - 2.0 * damping * step + step * step

    return [
        Section((0.0, 0.0, h * h), poles(*low)),
        *[Section((1.0, -2.0, 1.0), poles(*high))] * 3,
    ]


def bilinear_sections(
    low: tuple[float, float], high: tuple[float, float], h: float
) -> list[Section]:
    """Return the filter by the bilinear transform with pre-warping, the gain of 1/wL^2 kept."""

    def parts(omega: float, damping: float) -> tuple[float, float, tuple[float, float]]:
        c = float(np.tan(0.5 * omega * h))
        a0 = 1.0 + 2.0 * damping * c + c * c
        return c, a0, (2.0 * (c * c - 1.0) / a0, (1.0 - 2.0 * damping * c + c * c) / a0)

    c, a0, a = parts(*low)
    gain = (c / low[0]) ** 2 / a0
    _, high_a0, high_a = parts(*high)
    return [
        Section((gain, 2.0 * gain, gain), a),
        *[Section((1.0 / high_a0, -2.0 / high_a0, 1.0 / high_a0), high_a)] * 3,
    ]


def filter_shape(low: tuple[float, float], high: tuple[float, float], omega: Numbers) -> Numbers:
    """Return |H|^2 of the analogue filter at ``omega`` [rad/s]."""

    def denominator(corner: tuple[float, float]) -> Numbers:
        w, d = corner
        return np.asarray((w * w - omega**2) ** 2 + (2.0 * d * w * omega) ** 2)

    return np.asarray((omega**4 / denominator(high)) ** 3 / denominator(low))


def respond(sections: list[Section], x: Numbers) -> Numbers:
    """Return the output of the sections one after the other."""
    for section in sections:
        x = section.run(x)
    return x


def impulse_power(sections: list[Section]) -> float:
    """Return the sum of squares of the impulse response: variance for noise of variance 1.

    The response is followed until it has died away by 16 figures.
    """
    slowest = max(section.pole_radius for section in sections)
    impulse = np.zeros(int(np.ceil(-45.0 / np.log(slowest))))
    impulse[0] = 1.0
    return float(np.sum(respond(sections, impulse) ** 2))
