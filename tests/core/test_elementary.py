"""The core's own sine, cosine, exponential and logarithm against a wider format."""

import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from trainer.core.elementary import (
    ROUNDER,
    _power_of_two,
    cosine,
    cosine_and_sine,
    cosine_and_sine_of_any,
    exponential,
    logarithm,
    sine,
)

pytestmark = pytest.mark.core

wider = np.finfo(np.longdouble).nmant > np.finfo(np.float64).nmant


def worst(function: Any, reference: Any, arguments: Any) -> Any:
    """Return the largest error in units in the last place."""
    ours = np.array([function(x) for x in arguments])
    true = reference(arguments.astype(np.longdouble))
    return float(np.max(np.abs(ours - true) / np.spacing(np.abs(true.astype(float)))))


@pytest.mark.skipif(not wider, reason="this machine has no wider format to compare with")
@pytest.mark.parametrize("reach", [0.8, 3.2, 100.0, 1e4])
def test_sine_and_cosine_err_by_at_most_two_units_in_the_last_place(reach: float) -> None:
    angles = np.random.default_rng(1).uniform(-reach, reach, 4000)

    assert worst(sine, np.sin, angles) <= 2.0
    assert worst(cosine, np.cos, angles) <= 2.0


@pytest.mark.skipif(not wider, reason="this machine has no wider format to compare with")
def test_exponential_errs_by_at_most_two_units_in_the_last_place() -> None:
    exponents = np.random.default_rng(2).uniform(-700.0, 700.0, 4000)

    assert worst(exponential, np.exp, exponents) <= 2.0


@pytest.mark.skipif(not wider, reason="this machine has no wider format to compare with")
@pytest.mark.parametrize(("low", "high"), [(-745.0, 709.0), (-0.4, 0.4), (-1e-6, 1e-6)])
def test_logarithm_errs_by_at_most_two_units_in_the_last_place(low: float, high: float) -> None:
    arguments = np.exp(np.random.default_rng(4).uniform(low, high, 4000))

    assert worst(logarithm, np.log, arguments[arguments > 0.0]) <= 2.0


def test_sine_is_odd_and_cosine_even_to_the_bit() -> None:
    for x in np.random.default_rng(3).uniform(0.0, 1e4, 500):
        assert sine(-x) == -sine(x)
        assert cosine(-x) == cosine(x)


def test_cosine_and_sine_together_are_the_same_to_the_bit() -> None:
    for reach in (20.0, 0.8, 1e-9):  # 0.78 rad is small
        for x in np.random.default_rng(5).uniform(-reach, reach, 500):
            assert cosine_and_sine(x) == (cosine(x), sine(x))
            assert cosine_and_sine(x) == cosine_and_sine_of_any(x)
    assert cosine_and_sine(-1e12) == (cosine(-1e12), sine(-1e12))


def test_a_power_of_two_has_the_bits_of_ldexp() -> None:
    for k in range(-1022, 1024):
        assert _power_of_two(ROUNDER + k) == math.ldexp(1.0, k)


def test_values_at_the_corners() -> None:
    assert sine(0.0) == 0.0
    assert cosine(0.0) == 1.0
    assert exponential(0.0) == 1.0
    assert sine(np.pi / 6) == pytest.approx(0.5, rel=3e-16)
    assert exponential(-1e300) == exponential(-700.0)
    assert logarithm(1.0) == 0.0
    assert logarithm(2.0) == pytest.approx(0.6931471805599453, rel=3e-16)
    assert logarithm(0.0) == -np.inf
    assert logarithm(np.inf) == np.inf
    assert np.isnan(logarithm(-1.0))
    assert np.isnan(logarithm(np.nan))


@pytest.mark.parametrize("function", [sine, cosine])
def test_what_is_not_finite_stays_so(function: Any) -> None:
    with np.errstate(invalid="ignore"):
        assert np.isnan(function(np.float64("nan")))
        assert np.isnan(function(np.float64("inf")))


@pytest.mark.process
def test_a_compiler_of_another_version_is_not_given_options_of_its_own() -> None:
    code = (
        "import numba\n"
        "numba.__version__ = '1.2.0'\n"
        "from trainer.core import kernel\n"
        "decorate = kernel.compiled_with(error_model='numpy', **kernel.LEAN_OPTIONS)\n"
        "twice = decorate(lambda x: x + x)\n"
        "assert not set(kernel.LEAN_OPTIONS) & set(twice.dispatcher.targetoptions)\n"
        "assert twice(1.5) == 3.0\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
