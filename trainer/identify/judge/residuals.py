"""Residuals of a fit are tested (8.4), and how many parameters a record supports (8.3).

``pages`` shows the tests, so that a user sees what a model lacks. Numbers in brackets are of the
model document (MI). Residuals are (N,) of one output, standardised where there are several outputs.
NaN is a sample that did not count; pairs with such a sample are left out. For a scalar output V =
1/2 sum eps^2 over N samples; p counts coefficients and estimated initial states, but not the noise
variance: so the report's section 6 counts (MI 8.3).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.record.readings import RARE_ROWS, rows_between

DEFAULT_LAGS: Final = 10  # samples; as MAX_LAGS that of the report's program (MI 8.4, NOL)
MAX_LAGS: Final = 50  # samples
BAND_STANDARD_ERRORS: Final = 1.96  # standard errors, 95 %
MIN_PER_CLASS: Final = 5  # residuals expected in a class, usual for a chi-square test
MAX_CLASSES: Final = 30  # of a histogram: more are no better to read
SUSPECT_PROBABILITY: Final = 0.01  # [-] probability below which a test has found something


@dataclass(frozen=True)
class TestStatistic:
    """A statistic, its degrees of freedom, and the probability of one so large by chance.

    In a test against a larger model a small probability says that the larger model is worth it.
    """

    statistic: float
    freedom: int
    probability: float


@dataclass(frozen=True)
class Residuals:
    """The examination of one output's residuals."""

    output: str
    samples: int
    mean: float
    deviation: float
    correlation: tuple[float, ...]  # lags 0 to the last
    band: float
    whiteness: TestStatistic
    sign_changes: int
    sign_changes_expected: float
    sign_changes_deviation: float
    normality: TestStatistic
    cross: tuple[float, ...]  # with the input, lags -last to last; positive: input before
    cross_band: float
    missing_dynamics: TestStatistic  # of positive lags
    feedback: TestStatistic  # of negative lags


def examine_residuals(
    output: str, left: Numbers, rudder: Numbers, lags: int = DEFAULT_LAGS, fitted: int = 0
) -> Residuals:
    """Return the tests of residuals (N,) against themselves and the rudder (N,).

    ``fitted`` is the number of noise parameters, which the whiteness test takes off its degrees of
    freedom. ConfigError if there are too few residuals for the lags.
    """
    known = ~np.isnan(left)
    count = int(np.count_nonzero(known))
    if rows_between(left) >= RARE_ROWS:  # neighbours are readings, not rows
        left, rudder, known = left[known], rudder[known], known[known]
    if not 1 <= lags <= MAX_LAGS or count < 2 * lags + 2:
        raise ConfigError(f"residuals of {output}: {count} are too few for {lags} lags")
    centred = left - np.nanmean(left)
    autocorrelation = correlation(left, lags)
    cross = cross_correlation(centred, rudder - rudder.mean(), lags)
    input_own = correlation(rudder - rudder.mean(), lags)
    # correlated residuals and rudder scatter more (MI 8.4); 0.1, as estimates may sum below zero
    widening = math.sqrt(max(1.0 + 2.0 * float(autocorrelation[1:] @ input_own[1:]), 0.1))
    positive = left > 0.0
    both = known[1:] & known[:-1]  # neighbours, which may differ in sign
    pairs = int(np.sum(both))
    after, before = cross[lags:], cross[:lags]
    return Residuals(
        output=output,
        samples=count,
        mean=float(np.nanmean(left)),
        deviation=float(np.nanstd(left)),
        correlation=tuple(map(float, autocorrelation)),
        band=BAND_STANDARD_ERRORS / math.sqrt(count),
        whiteness=portmanteau(autocorrelation, count, max(lags - fitted, 1)),
        sign_changes=int(np.count_nonzero((positive[1:] != positive[:-1]) & both)),
        # white residuals change sign in half of the pairs, with variance pairs/4 (MI 8.4)
        sign_changes_expected=pairs / 2.0,
        sign_changes_deviation=math.sqrt(pairs) / 2.0,
        normality=goodness_of_fit(left),
        cross=tuple(map(float, cross)),
        cross_band=BAND_STANDARD_ERRORS / math.sqrt(count) * widening,
        missing_dynamics=_sum_test(after, input_own, count),
        feedback=_sum_test(before[::-1], input_own, count),
    )


def correlation(series: Numbers, lags: int) -> Numbers:
    """Return sum e_t e_(t+lag) / sum e^2 for lags 0 to ``lags``, (lags + 1,)."""
    values = np.nan_to_num(series)  # a missing value adds zero to each sum: its pairs are out
    power = float(values @ values)
    if power == 0.0:
        return np.concatenate([[1.0], np.zeros(lags)])
    sums = [float(values[: len(values) - lag] @ values[lag:]) for lag in range(lags + 1)]
    return np.array(sums) / power


def cross_correlation(left: Numbers, rudder: Numbers, lags: int) -> Numbers:
    """Return the normalised sum of rudder_t left_(t+lag) for lags -``lags`` to ``lags``."""
    e, u = np.nan_to_num(left), np.nan_to_num(rudder)
    size = math.sqrt(float(e @ e) * float(u @ u))
    if size == 0.0:
        return np.zeros(2 * lags + 1)
    later = [u[: len(u) - lag] @ e[lag:] for lag in range(lags + 1)]
    earlier = [e[: len(e) - lag] @ u[lag:] for lag in range(lags, 0, -1)]
    return np.array([*earlier, *later]) / size


def portmanteau(own: Numbers, count: int, freedom: int) -> TestStatistic:
    """Return Q = N(N + 2) sum r^2/(N - lag) against chi-square. Lags are from 1."""
    from scipy.special import chdtrc  # noqa: PLC0415

    lag = np.arange(1, len(own))
    statistic = float(count * (count + 2.0) * np.sum(own[1:] ** 2 / (count - lag)))
    return TestStatistic(statistic, freedom, float(chdtrc(freedom, statistic)))


def _sum_test(cross: Numbers, input_own: Numbers, count: int) -> TestStatistic:
    """Return N c^T R^-1 c of cross correlations at consecutive lags, against chi-square.

    R is the Toeplitz matrix of the input's own correlation, because the covariance of these cross
    correlations is R/N if the residuals are white.
    """
    from scipy.linalg import toeplitz  # noqa: PLC0415
    from scipy.special import chdtrc  # noqa: PLC0415

    # 1e-9 keeps R regular, which is singular for a rudder of few sines
    R = toeplitz(input_own[: len(cross)]) + 1e-9 * np.eye(len(cross))
    statistic = float(count * cross @ np.linalg.solve(R, cross))
    return TestStatistic(statistic, len(cross), float(chdtrc(len(cross), statistic)))


def goodness_of_fit(left: Numbers) -> TestStatistic:
    """Return chi-square of the residuals in classes that a normal one fills equally."""
    from scipy.special import chdtrc, ndtr  # noqa: PLC0415

    values = left[~np.isnan(left)]
    deviation = float(np.std(values))
    classes = int(min(max(len(values) // MIN_PER_CLASS, 4), MAX_CLASSES))
    # degrees of freedom: less 1 for the sum, and 2 for mean and deviation, which are estimated
    if deviation == 0.0:
        return TestStatistic(0.0, classes - 3, 1.0)
    index = ndtr((values - np.mean(values)) / deviation)
    counts = np.bincount(np.minimum((index * classes).astype(int), classes - 1), minlength=classes)
    expected = len(values) / classes
    statistic = float(np.sum((counts - expected) ** 2) / expected)
    return TestStatistic(statistic, classes - 3, float(chdtrc(classes - 3, statistic)))


def describe_tests(found: Residuals) -> list[str]:
    """Return in words what the tests reject; an empty list if they reject nothing."""
    texts = {
        "residuals are not white: the noise model or the order is too small": found.whiteness,
        "residuals follow the rudder: dynamics are missing from the model": found.missing_dynamics,
        "the rudder follows the residuals: the record is of a closed loop": found.feedback,
        "residuals are not normal: outliers, or a sensor of few steps": found.normality,
    }
    suspect = (text for text, test in texts.items() if test.probability < SUSPECT_PROBABILITY)
    return [f"{found.output}: {text}" for text in suspect]


def f_test(small: tuple[float, int], large: tuple[float, int], samples: int) -> TestStatistic:
    """Return F of two (V, p), against F(p2 - p1, N - p2)."""
    (v1, p1), (v2, p2) = small, large
    from scipy.special import fdtrc  # noqa: PLC0415

    statistic = (v1 - v2) / v2 * (samples - p2) / (p2 - p1)
    chance = float(fdtrc(p2 - p1, samples - p2, max(statistic, 0.0)))
    return TestStatistic(statistic, p2 - p1, chance)


def aic_of_loss(loss: float, samples: int, parameters: int) -> float:
    """Return AIC = N ln(2V/N) + N(1 + ln 2 pi) + 2p. The output is scalar."""
    spread = samples * math.log(2.0 * loss / samples)
    return spread + samples * (1.0 + math.log(2.0 * math.pi)) + 2.0 * parameters


def bic_of_loss(loss: float, samples: int, parameters: int) -> float:
    """Return Schwarz's criterion, AIC with p ln N in place of 2p."""
    return aic_of_loss(loss, samples, parameters) + parameters * (math.log(samples) - 2.0)


def aic_of_likelihood(log_likelihood: float, parameters: int) -> float:
    """Return AIC = -2 log L + 2p."""
    return -2.0 * log_likelihood + 2.0 * parameters


def ratio_test(small: tuple[float, int], large: tuple[float, int]) -> TestStatistic:
    """Return 2(log L2 - log L1) against chi-square of p2 - p1. Each model is (log L, p).

    ConfigError if the larger has no more parameters.
    """
    (l1, p1), (l2, p2) = small, large
    if p2 <= p1:
        raise ConfigError(f"likelihood ratio: {p2} parameters are not more than {p1}")
    from scipy.special import chdtrc  # noqa: PLC0415

    statistic = 2.0 * (l2 - l1)
    return TestStatistic(statistic, p2 - p1, float(chdtrc(p2 - p1, statistic)))
