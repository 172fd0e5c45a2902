"""What stands in for the loops of a fit's kernels where they are interpreted."""

import inspect

import numpy as np
import pytest
from numpy.testing import assert_allclose

from trainer import compilation
from trainer.identify.kernels import (
    adjoint,
    at_once,
    blocks,
    covariance_filter,
    likelihood,
    sampling,
    sensitivity,
)

X, Y, P, COLUMNS = 3, 2, 4, 6  # states, readings, parameters, columns of a mean
ROWS = X + Y
STREAM = np.random.default_rng(4)
IMAGINARY = 1e-100j  # a derivative's

pytestmark = pytest.mark.skipif(
    compilation.done_without(), reason="there are no loops to compare with"
)


def some(*shape):
    return STREAM.standard_normal(shape)


def spread(n):
    """Return a covariance (n, n)."""
    root = some(n, n)
    return root @ root.T + np.eye(n)


def swept():
    """Return J (rows, rows) with the readings swept out."""
    J = spread(ROWS)
    for pivot in range(X, ROWS):
        at_once.sweep(J, pivot)
    return J


def symmetric(*shape):
    """Return slopes (n, n, p) of a covariance."""
    half = some(*shape)
    return half + half.swapaxes(0, 1)


def stages():
    """Return what a stage leaves: swept J and the P before it, side by side."""
    joints = np.zeros((ROWS, ROWS + X))
    joints[:, :ROWS] = swept()
    joints[:X, ROWS:] = spread(X)
    return joints


def sums_of_stage():
    """Return sums (x+y, columns + y), those of s s' symmetric."""
    sums = some(ROWS, COLUMNS + Y)
    sums[X:, COLUMNS:] = spread(Y)
    return sums


ROOT = np.triu(some(Y, Y))
STABLE = 0.1 * some(X, X + 2)
CASES = {
    "put": (blocks, (some(3), 1, some(6))),
    "put_block": (blocks, (some(2, 3), 1, some(4, 6))),
    "clear": (blocks, (some(2, 3),)),
    "times": (sampling, (some(X, X + 2), some(X, X + 2), some(X, X + 2))),
    "mean_series": (sampling, (STABLE, 0.3, some(2, X, X + 2), some(X, X + 2))),
    "noise_series": (sampling, (STABLE, spread(X), 0.3, some(2, X, X), some(X, X))),
    "carry": (sampling, (some(X, X + 2), spread(X), some(X, X), spread(X))),
    "joint": (
        covariance_filter,
        (some(ROWS, COLUMNS), spread(ROWS), spread(X), some(ROWS, X), some(ROWS, ROWS)),
    ),
    "predict": (covariance_filter, (some(ROWS, COLUMNS), some(COLUMNS), some(ROWS))),
    "sweep": (covariance_filter, (spread(ROWS), ROWS - 1)),
    "stage": (adjoint, (some(ROWS, COLUMNS), stages(), some(X, X), some(X, X))),
    "collect": (
        adjoint,
        (some(ROWS, COLUMNS), some(COLUMNS + Y + 2), some(X), some(X), sums_of_stage()),
    ),
    "step_back": (
        adjoint,
        (some(X, X), spread(X), some(X), np.zeros((1 + X, X)), some(X), spread(X)),
    ),
    "sum_of_h": (
        adjoint,
        (stages(), sums_of_stage()[:, COLUMNS:], spread(X), 7.0, some(ROWS, ROWS)),
    ),
    "close_stage": (
        adjoint,
        (
            some(ROWS, COLUMNS),
            stages(),
            sums_of_stage(),
            spread(ROWS),
            some(ROWS, X),
            some(ROWS, COLUMNS + ROWS),
        ),
    ),
    "half_slopes": (
        sensitivity,
        (
            some(ROWS, COLUMNS),
            some(ROWS, COLUMNS, P),
            spread(X),
            symmetric(X, X, P),
            some(ROWS, X, P),
        ),
    ),
    "joint_slopes": (
        sensitivity,
        (some(ROWS, COLUMNS), some(ROWS, X, P), symmetric(ROWS, ROWS, P)),
    ),
    "conditioned": (
        sensitivity,
        (swept(), symmetric(ROWS, ROWS, P), some(3, P), symmetric(X, X, P)),
    ),
    "gain_slopes": (sensitivity, (swept(), symmetric(ROWS, ROWS, P), X, some(3, P))),
    "mean_slopes": (
        sensitivity,
        (some(ROWS, COLUMNS), some(ROWS, COLUMNS, P), some(COLUMNS), some(X, P), some(ROWS, P)),
    ),
    "standardised": (sensitivity, (ROOT, some(ROWS, P), X, some(Y, P))),
    "next_slopes": (
        sensitivity,
        (swept(), symmetric(ROWS, ROWS, P), some(Y), some(ROWS, P), some(X, P)),
    ),
    "covariance_rows": (sensitivity, (ROOT, symmetric(ROWS, ROWS, P), 5.0, some(Y * Y, P))),
}
SCRATCH = {"work", "room", "lines", "line", "product"}


def loops(module, name):
    """Return the part that a function stands in for."""
    return getattr(module, name, None) or getattr(module, f"_{name}")


def both(part, instead, arguments):
    """Return what the loops and what stands in for them return and write, scratch left out."""
    found = []
    for function in (part.py_func, instead):
        taken = [np.copy(a) if isinstance(a, np.ndarray) else a for a in arguments]
        returned = function(*taken)
        names = inspect.signature(part.py_func).parameters
        kept = [a for name, a in zip(names, taken, strict=True) if name not in SCRATCH]
        found.append((returned, kept))
    return found


@pytest.mark.parametrize("name", CASES)
def test_whole_arrays_are_what_the_loops_write(name):
    (returned, written), (other, by_arrays) = both(
        loops(CASES[name][0], name), getattr(at_once, name), CASES[name][1]
    )
    if name == "gain_slopes":  # which leaves the slopes of R as they were
        written, by_arrays = written[:2], by_arrays[:2]

    assert (returned is None) == (other is None)
    if returned is not None:
        assert other == pytest.approx(returned, rel=1e-12)
    for one, another in zip(written, by_arrays, strict=True):
        assert_allclose(another, one, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["times", "mean_series", "noise_series", "carry", "joint", "sweep"]
)
def test_whole_arrays_carry_derivatives_as_the_loops_do(name):
    aside = [a * (1.0 + IMAGINARY) if isinstance(a, np.ndarray) else a for a in CASES[name][1]]
    (_, written), (_, by_arrays) = both(loops(CASES[name][0], name), getattr(at_once, name), aside)
    for one, another in zip(written, by_arrays, strict=True):
        assert_allclose(np.imag(another) * 1e100, np.imag(one) * 1e100, rtol=1e-11, atol=1e-12)


def test_taking_a_reading_is_the_same_below_the_diagonal():
    J, v = spread(ROWS), some(ROWS)
    ours, others = (J.copy(), v.copy()), (J.copy(), v.copy())
    loops(likelihood, "take").py_func(ours[0], ROWS - 1, 0.7, ours[1])
    at_once.take(others[0], ROWS - 1, 0.7, others[1])

    assert_allclose(np.tril(others[0]), np.tril(ours[0]), rtol=1e-12)
    assert_allclose(others[1], ours[1], rtol=1e-12)


def test_every_stand_in_is_compared():
    functions = {name for name, _ in inspect.getmembers(at_once, inspect.isfunction)}
    assert functions == {*CASES, "take"}
