"""The waves round the boat: the same sea that moves it, in space.

``session/stations/plot`` sends them to the periscope's view; nothing here moves the boat. The core
has the sea at one point, above the boat, from two sources. The cosine sum is exact everywhere. The
filters (a bank of resonators, driven by noise) give the elevation above the boat alone. At a point
d [m] further along the waves' way, it is what the bank gave 2 k d radians of the peak wave earlier,
turned by k d, where k is the wave's number: groups then travel at half the speed of their waves, as
in deep water. What is to come is known too, since noise is a function of the step.
"""

import math
from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import STATE_OFFSETS
from trainer.core.kernel import Numbers
from trainer.core.noise import SEA_BANK, gaussian_pair
from trainer.core.sea.cosine_sum import ANGLE_COS, ANGLE_SIN, BAND_COUNT, prepare_sum
from trainer.core.sea.wave_filter import MODE_FACTORS, PHASE_STEP, WAVE_ROWS
from trainer.core.state import new_scratch

Waves = NDArray[np.complex128]  # real parts: elevations; imaginary ones: a quarter of a period ago

REACH_STEPS: Final = 160  # internal steps of the filter before the boat and behind it
MEMORY_STEPS: Final = 900  # of them, after which e^-18 of the slowest mode is left
BLOCK_SIZE: Final = 64  # outputs that are found at once
MAX_OUTPUT: Final = 6.0  # [-] of an output of variance 1, as it is packed
PACKING_DIGITS: Final = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
MAX_FREQUENCY_RATIO: Final = 8.0  # [-] frequency over the peak's, as it is packed
NOISE_PAIRS: Final = (MEMORY_STEPS + BLOCK_SIZE) // 2  # pairs of noise that a block needs
WAVE_COSINES: Final = np.repeat(ANGLE_COS, BAND_COUNT)
WAVE_SINES: Final = np.repeat(ANGLE_SIN, BAND_COUNT)


class Swell(NamedTuple):
    """The waves at a tick. A wave's phase at the boat, its number over the peak's, its height."""

    height: float  # [m] significant
    number: float  # [1/m] of the peak wave
    omega: float  # [rad/s]
    towards: float  # [rad] off the bow, where the waves go
    ahead: float  # [m/s] of the boat through the water
    right: float  # [m/s]
    clock: float  # [-] internal steps since the middle one of the groups
    drift: float  # [rad] by which the groups' outputs have been turned
    groups: Waves  # outputs [-] of the filters by internal step
    phases: Numbers  # [rad] of the cosines
    relative: Numbers  # [-] their frequencies over the peak's
    amplitudes: Numbers  # [-]

    def level(self, ahead: float, right: float) -> float:
        """Return the level [m] at a point so far [m] ahead and to the right."""
        along = ahead * math.cos(self.towards) + right * math.sin(self.towards)
        across = right * math.cos(self.towards) - ahead * math.sin(self.towards)
        return 0.25 * self.height * (self._of_groups(along) + self._of_cosines(along, across))

    def _of_groups(self, along: float) -> float:
        """Return the filters' elevation [-] so far [m] along the waves' way."""
        if not self.groups.size:
            return 0.0
        phase = self.number * along
        at = self.clock - 2.0 * phase / PHASE_STEP + REACH_STEPS
        turned = interpolate_values(self.groups, at) * np.exp(1j * (self.drift + phase))
        return float(turned.real)

    def _of_cosines(self, along: float, across: float) -> float:
        """Return the cosine sum's elevation [-] at a point [m] along and across."""
        met = self.number * (along * WAVE_COSINES + across * WAVE_SINES)
        phases = self.phases - self.relative**2 * met if self.phases.size else self.phases
        return float(np.sum(self.amplitudes * np.cos(phases)))

    def packed_groups(self) -> str | None:
        """Return the groups, two numbers of two digits each."""
        parts = np.stack([self.groups.real, self.groups.imag], axis=1).ravel()
        return pack_numbers(parts / MAX_OUTPUT, 2) or None

    def packed_waves(self) -> str | None:
        """Return phase, frequency and amplitude of each cosine in three digits each."""
        turns = np.remainder(self.phases / math.tau, 1.0)
        rows = np.stack([turns, self.relative / MAX_FREQUENCY_RATIO, self.amplitudes], axis=1)
        return pack_numbers(rows.ravel(), 3) or None


def pack_numbers(values: Numbers, count: int) -> str:
    """Return numbers from -1 to 1 in so many digits each.

    Such a text is short enough to be sent to a station's page many times a second.
    """
    most = len(PACKING_DIGITS) ** count
    whole = np.clip(np.floor((values + 1.0) * 0.5 * most), 0, most - 1).astype(int)
    weights = [len(PACKING_DIGITS) ** digit for digit in reversed(range(count))]
    return "".join(
        PACKING_DIGITS[each // weight % len(PACKING_DIGITS)] for each in whole for weight in weights
    )


def interpolate_values(values: Waves, step: float) -> complex:
    """Return what lies between two of the values, by the core's cubic.

    Another one would make waves beside the boat that do not fit those that move it.
    """
    first = min(max(math.floor(step), 1), values.size - 3)
    f = step - first
    before, after, beyond = f + 1.0, f - 1.0, f - 2.0
    early = -f * after * beyond / 6.0 * values[first - 1]
    early += before * after * beyond / 2.0 * values[first]
    late = -before * f * beyond / 2.0 * values[first + 1]
    return complex(early + late + before * f * after / 6.0 * values[first + 2])


def swell_round(numbers: Sequence[float], g: float) -> Swell:
    """Return the waves round the boat whose state has these numbers, by their STATE_OFFSETS."""

    def at(name: str) -> float:
        return numbers[STATE_OFFSETS[name]]

    number = at("sea_omega") ** 2 / g
    heading = at("psi")
    north, east = at("through_north"), at("through_east")
    return Swell(
        at("sea_height"),
        number,
        at("sea_omega"),
        at("sea_direction") - heading,
        north * math.cos(heading) + east * math.sin(heading),
        east * math.cos(heading) - north * math.sin(heading),
        at("sea_clock") if at("sea_1969") < 1.0 else 0.0,
        at("sea_drift"),
        _groups(numbers, at),
        *_cosines(at),
    )


def _cosines(at: Callable[[str], float]) -> tuple[Numbers, Numbers, Numbers]:
    """Return phases above the boat, frequencies and amplitudes of the cosine sum, if it is used."""
    share = at("sea_cosines")
    if share <= 0.0:
        return np.empty(0), np.empty(0), np.empty(0)
    start, relative, amplitudes = cosine_components(at("sea_gamma"), at("seed"))
    met = at("sea_along") * WAVE_COSINES + at("sea_across") * WAVE_SINES
    phases = start + relative * at("sea_turned") - relative**2 * met
    return phases, relative, math.sqrt(share) * amplitudes


@lru_cache(4)
def cosine_components(gamma: float, seed: float) -> tuple[Numbers, Numbers, Numbers]:
    """Return starting phases, frequencies and amplitudes of the cosine sum."""
    record = new_scratch()
    prepare_sum(gamma, seed, record)
    work = record[0]
    return work.phase_start.copy(), work.relative.copy(), work.amplitude.copy()


def _groups(numbers: Sequence[float], at: Callable[[str], float]) -> Waves:
    """Return the filters' outputs by internal step, on either side of the boat."""
    filtered_share = 1.0 - at("sea_cosines")
    if filtered_share <= 0.0:
        return np.empty(0, complex)
    old = at("sea_1969")
    waves = math.sqrt(filtered_share * old) * _endless(at)
    if old < 1.0:
        waves = waves + math.sqrt(filtered_share * (1.0 - old)) * _of_banks(numbers, at)
    return waves


def _endless(at: Callable[[str], float]) -> Waves:
    """Return the outputs of 1969's filter as those of an endless swell, which the forces take."""
    here = complex(at("sea_elevation"), at("sea_quadrature"))
    steps = np.arange(-REACH_STEPS, REACH_STEPS)
    return np.asarray(here * np.exp(1j * (PHASE_STEP * steps - at("sea_drift"))))


def _of_banks(numbers: Sequence[float], at: Callable[[str], float]) -> Waves:
    """Return the outputs of both banks of filters round the present step.

    The four steps next to it are copied from the state, where the core has them with all that came
    before; further ones are computed from the noise of MEMORY_STEPS.
    """
    middle = int(at("sea_steps")) - 3
    peaked, seed = at("sea_peaked"), int(at("seed"))
    shares = math.sqrt(1.0 - peaked), math.sqrt(peaked)
    waves = np.zeros(2 * REACH_STEPS, complex)
    for bank, share in enumerate(shares):
        if share > 0.0:
            waves += share * bank_outputs(seed, bank, middle - REACH_STEPS, middle + REACH_STEPS)
    for step in range(middle - 1, middle + 3):
        first = STATE_OFFSETS["sea_past"] + 4 * (step & 3)
        waves[step - middle + REACH_STEPS] = complex(numbers[first], numbers[first + 1])
    return waves


def bank_outputs(seed: int, bank: int, first: int, last: int) -> Waves:
    """Return the outputs of a bank at the internal steps from ``first`` to before ``last``."""
    blocks = range(first // BLOCK_SIZE, -(-last // BLOCK_SIZE))
    whole = np.concatenate([_block(seed, bank, block) for block in blocks])
    return whole[first - blocks[0] * BLOCK_SIZE :][: last - first]


@lru_cache(64)
def _block(seed: int, bank: int, block: int) -> Waves:
    """Return the outputs of a bank at BLOCK_SIZE internal steps."""
    first = block * BLOCK_SIZE - MEMORY_STEPS
    noise = np.array(
        [
            gaussian_pair(seed, SEA_BANK + bank, pair)
            for pair in range(first // 2, first // 2 + NOISE_PAIRS)
        ]
    ).ravel()
    return np.convolve(noise, _response(bank), "valid")


@cache
def _response(bank: int) -> Waves:
    """Return the outputs of a bank by the steps since a single noise of 1."""
    factors = MODE_FACTORS[bank, 0] + 1j * MODE_FACTORS[bank, 1]
    powers = factors ** np.arange(MEMORY_STEPS + 1)[:, None]
    parts = np.concatenate([powers.real, powers.imag], axis=1)
    rows = WAVE_ROWS[bank]
    return np.asarray(parts @ rows[:, 0] + 1j * (parts @ rows[:, 1]))
