"""The random stream: its published answers, its distribution and its independence."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from trainer.core.noise import gaussian, threefry, uniform

pytestmark = pytest.mark.core

MANY = 10_000_000
SOME = 1_000_000
FEW = 200_000
TAILS = {  # the share of a normal distribution beyond so many standard deviations, on one side
    0.5: 0.3085375387259869,
    1.0: 0.15865525393145707,
    2.0: 0.022750131948179195,
    3.0: 0.0013498980316300933,
    4.0: 3.167124183311986e-05,
}


@njit(cache=False)
def deviates(seed: int, stream: int, first: int, count: int) -> np.ndarray:
    """Return ``count`` normal deviates of consecutive ticks."""
    out = np.empty(count)
    for i in range(count):
        out[i] = gaussian(seed, stream, first + i)
    return out


@njit(cache=False)
def fractions(seed: int, stream: int, first: int, count: int) -> np.ndarray:
    """Return ``count`` uniform numbers of consecutive ticks."""
    out = np.empty(count)
    for i in range(count):
        out[i] = uniform(seed, stream, first + i)
    return out


@pytest.fixture(scope="module")
def record() -> np.ndarray:
    """Return the deviates of one seed and stream, for what is compared with them."""
    return deviates(1, 1, 0, MANY)


@pytest.mark.laws
@pytest.mark.parametrize(
    ("counter", "key", "answer"),
    [
        ((0, 0), (0, 0), (0x6B200159, 0x99BA4EFE)),
        ((0xFFFFFFFF, 0xFFFFFFFF), (0xFFFFFFFF, 0xFFFFFFFF), (0x1CB996FC, 0xBB002BE7)),
        ((0x243F6A88, 0x85A308D3), (0x13198A2E, 0x03707344), (0xC4923A9C, 0x483DF7A0)),
    ],
)
def test_threefry_gives_the_known_answers_of_random123(
    counter: tuple[int, int], key: tuple[int, int], answer: tuple[int, int]
) -> None:
    assert threefry(*key, *counter) == answer


@given(st.integers(0, 2**53), st.integers(0, 2**31), st.integers(-(2**31), 2**31))
def test_every_number_is_finite_and_uniform_ones_lie_inside_0_and_1(
    seed: int, stream: int, tick: int
) -> None:
    assert 0.0 < uniform(seed, stream, tick) < 1.0
    assert abs(gaussian(seed, stream, tick)) < 6.8


def test_a_number_depends_on_seed_stream_and_tick_only() -> None:
    there = [gaussian(7, 3, tick) for tick in range(-5, 50)]
    back = [gaussian(7, 3, tick) for tick in range(49, -6, -1)]

    assert there == back[::-1]
    assert len({*there, *(gaussian(8, 3, t) for t in range(50))}) == 105
    assert gaussian(7, 3, 9) != gaussian(7, 4, 9)
    assert gaussian(7, 3, 9) != gaussian(7 + 2**32, 3, 9)


@pytest.mark.slow
def test_ten_million_deviates_have_the_moments_of_the_normal_distribution(
    record: np.ndarray,
) -> None:
    x = record
    mean, variance = float(np.mean(x)), float(np.var(x))
    skewness = float(np.mean((x - mean) ** 3)) / variance**1.5
    kurtosis = float(np.mean((x - mean) ** 4)) / variance**2

    # 5 standard errors: 1, sqrt 2, sqrt 6, sqrt 24 over the root of the number
    root = np.sqrt(MANY)
    assert abs(mean) < 5.0 / root
    assert abs(variance - 1.0) < 5.0 * np.sqrt(2.0) / root
    assert abs(skewness) < 5.0 * np.sqrt(6.0) / root
    assert abs(kurtosis - 3.0) < 5.0 * np.sqrt(24.0) / root


@pytest.mark.long
def test_ten_million_deviates_have_the_tails_of_the_normal_distribution() -> None:
    x = deviates(2, 1, 0, MANY)
    faults = [
        f"{count} beyond {limit}, not {MANY * beyond:.0f} within {spread:.0f}"
        for limit, beyond in TAILS.items()
        for spread in [5.0 * np.sqrt(MANY * beyond * (1.0 - beyond))]
        for count in (np.count_nonzero(x > limit), np.count_nonzero(x < -limit))
        if abs(count - MANY * beyond) >= spread
    ]

    assert not faults


@pytest.mark.parametrize(
    ("seed", "stream", "first"), [(1, 2, 0), (2, 1, 0), (1 + 2**32, 1, 0), (1, 1, 1), (1, 1, 2)]
)
def test_streams_ticks_and_seeds_are_uncorrelated(
    record: np.ndarray, seed: int, stream: int, first: int
) -> None:
    x = record[:SOME]
    y = deviates(seed, stream, first, SOME)

    assert abs(float(np.mean(x * y))) < 5.0 / np.sqrt(SOME)
    assert abs(float(np.mean((x * x - 1.0) * (y * y - 1.0)))) < 5.0 * 2.0 / np.sqrt(SOME)


@pytest.mark.parametrize(("seed", "stream", "first"), [(1, 2, 0), (2, 1, 0), (1, 1, 1), (1, 1, 7)])
def test_pairs_of_numbers_fill_the_unit_square_evenly(seed: int, stream: int, first: int) -> None:
    cells = 64
    x = (fractions(1, 1, 0, SOME) * cells).astype(np.int64)
    y = (fractions(seed, stream, first, SOME) * cells).astype(np.int64)
    counts = np.bincount(x * cells + y, minlength=cells * cells)
    expected = SOME / cells**2
    chi_square = float(np.sum((counts - expected) ** 2) / expected)

    # 4095 degrees of freedom; 5 standard deviations either way, so that too even fails as well
    assert abs(chi_square - 4095.0) < 5.0 * np.sqrt(2.0 * 4095.0)


def test_a_shorter_record_of_uniform_numbers_is_even() -> None:
    counts = np.bincount((fractions(3, 5, -100, FEW) * 100).astype(np.int64), minlength=100)

    chi_square = float(np.sum((counts - FEW / 100) ** 2) / (FEW / 100))
    assert abs(chi_square - 99.0) < 5.0 * np.sqrt(2.0 * 99.0)
