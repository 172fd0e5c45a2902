"""ARMAX models of one reading by the rudder, fitted by maximum likelihood (MI 9).

y_t + a1 y_(t-1) + ... = b1 u_(t-1) + ... + e_t + c1 e_(t-1) + ..., n coefficients each, and d1 to
dn in the first n equations where the initial state is estimated.

Such a model is a difference equation with noise and knows nothing of ships, so it shows which order
a record supports before a ship's model is chosen. ``pages/armax`` fits rising orders by it. A fit
minimises V = 1/2 sum eps^2 (9). A model of order 2 contains a first-order ship: see
``without_wind``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers

POLYNOMIAL_KINDS: Final = ("a", "b", "c", "d")
CANCELLED_DISTANCE: Final = 0.15  # [-] of a zero from a pole that it nearly cancels
MAX_ROUNDS: Final = 100  # rounds of a search, beyond which it has not settled
MAX_HALVINGS: Final = 25  # of a step that makes the errors larger
LOSS_TOLERANCE: Final = 1e-10  # [-] relative decrease of the loss expected from a further step
# [-] of the zeros of C: on the unit circle an error of the start would never die out
MAX_ZERO_RADIUS: Final = 0.9995
ROUNDING_TOLERANCE: Final = 1e-6  # [-] relative decrease expected that rounding may hide
FLAT_EIGENVALUE: Final = 1e-10  # [-] of the scaled information: a direction below it is not known
LONG_ORDER: Final = 10  # of the autoregression that the second start takes its residuals from
COMMON_FACTORS: Final = (0.0, 0.5, -0.5, 0.9)  # [-] common factors that a higher order starts from


@dataclass(frozen=True)
class Armax:
    """The coefficients of a model of order n.

    ``d`` is () where the initial state is taken as zero.
    """

    a: tuple[float, ...]
    b: tuple[float, ...]
    c: tuple[float, ...]
    d: tuple[float, ...]

    @classmethod
    def of(cls, numbers: Numbers, order: int) -> "Armax":
        """Return the model of the coefficients in the order a, b, c, d."""
        parts = [tuple(map(float, numbers[i : i + order])) for i in range(0, 4 * order, order)]
        return cls(*parts)

    @property
    def order(self) -> int:
        """Return n."""
        return len(self.a)

    @property
    def poles(self) -> tuple[complex, ...]:
        """Return the zeros of z^n A."""
        return roots_of((1.0, *self.a))

    @property
    def zeros(self) -> tuple[complex, ...]:
        """Return the zeros of z^n B."""
        return roots_of(self.b)

    def value(self, name: str) -> float:
        """Return a coefficient by its name, a1 or another."""
        number: float = getattr(self, name[0])[int(name[1:]) - 1]
        return number

    def residuals(self, y: Numbers, u: Numbers) -> Numbers:
        """Return the one-step errors eps (N,) of output y and input u, both (N,)."""
        difference = filter_series((1.0, *self.a), (1.0,), y) - filter_series(
            (0.0, *self.b), (1.0,), u
        )
        difference[: len(self.d)] -= self.d
        return filter_series((1.0,), (1.0, *self.c), difference)

    def simulated(self, u: Numbers, e: Numbers) -> Numbers:
        """Return the output (N,) to input u under white disturbance e, both (N,)."""
        moved = filter_series((0.0, *self.b), (1.0,), u) + filter_series((1.0, *self.c), (1.0,), e)
        moved[: len(self.d)] += self.d
        return filter_series((1.0,), (1.0, *self.a), moved)


def filter_series(over: Sequence[float], under: Sequence[float], series: Numbers) -> Numbers:
    """Return a series (N,) times a ratio of polynomials in q^-1, at rest before it."""
    from scipy.signal import lfilter  # noqa: PLC0415 - an extra, imported on use

    return np.asarray(lfilter(over, under, series))


def roots_of(polynomial: tuple[float, ...]) -> tuple[complex, ...]:
    """Return the roots, those furthest out first."""
    roots = np.roots(np.trim_zeros(np.array(polynomial), "f"))
    return tuple(complex(root) for root in sorted(roots, key=lambda root: -abs(root)))


@dataclass(frozen=True)
class ArmaxFit:
    """A fitted model, its coefficients' deviations, and whether the search settled."""

    model: Armax
    names: tuple[str, ...]  # of the coefficients
    deviations: tuple[float, ...]  # their standard deviations; infinite where not known
    loss: float  # V
    samples: int
    converged: bool
    inseparable: tuple[str, ...]  # coefficients that only their common factor moves

    @property
    def parameters(self) -> int:
        """Return how many coefficients were estimated, initial states among them."""
        return len(self.names)

    @property
    def deviation(self) -> float:
        """Return lambda, the standard deviation of the one-step error."""
        return float(np.sqrt(2.0 * self.loss / self.samples))


@dataclass(frozen=True)
class _Orders:
    """One search: the record, and the order of the model."""

    y: Numbers
    u: Numbers
    order: int

    def model(self, theta: Numbers) -> Armax:
        """Return the model of these coefficients."""
        return Armax.of(theta, self.order)

    def stable(self, theta: Numbers) -> Numbers:
        """Return the coefficients with the zeros of C mirrored into the unit circle.

        A zero z and its mirror image 1/z give the disturbance the same spectrum.
        """
        n = self.order
        zeros = np.array(roots_of((1.0, *self.model(theta).c)))
        size = np.abs(zeros)
        if not (size > MAX_ZERO_RADIUS).any():
            return theta
        inside = np.where(size > 1.0, zeros / size**2, zeros)  # 1/z, conjugate: C stays real
        inside *= np.minimum(1.0, MAX_ZERO_RADIUS / np.maximum(np.abs(inside), 1e-300))
        stable_theta = theta.copy()
        polynomial = np.poly(np.append(inside, np.zeros(n - len(inside))))
        stable_theta[2 * n : 3 * n] = polynomial.real[1:]
        return stable_theta

    def radius(self, theta: Numbers) -> float:
        """Return the largest magnitude of a zero of C."""
        return max(abs(root) for root in (0.0, *roots_of((1.0, *self.model(theta).c))))

    def loss(self, theta: Numbers) -> float:
        """Return V; infinite where a zero of C lies beyond MAX_ZERO_RADIUS."""
        if self.radius(theta) > MAX_ZERO_RADIUS + 1e-9:
            return math.inf
        eps = self.model(theta).residuals(self.y, self.u)
        value = 0.5 * float(eps @ eps)
        return value if math.isfinite(value) else math.inf

    def at_rim(self, theta: Numbers) -> bool:
        """Return whether a zero of C is held at MAX_ZERO_RADIUS.

        The loss may fall further beyond it, so that the search cannot reach a point without slope.
        """
        return self.radius(theta) > MAX_ZERO_RADIUS - 1e-6

    def jacobian(self, theta: Numbers) -> tuple[Numbers, Numbers]:
        """Return eps (N,) and its derivatives (N, coefficients)."""
        model = self.model(theta)
        eps, under = model.residuals(self.y, self.u), (1.0, *model.c)
        return eps, self.regressors(eps, len(theta), lambda x: filter_series((1.0,), under, x))

    def regressors(
        self, errors: Numbers, count: int, filtered: Callable[[Numbers], Numbers]
    ) -> Numbers:
        """Return what each of ``count`` coefficients multiplies (N, count), ``errors`` for e."""
        impulse = np.zeros_like(self.y)
        impulse[0] = -1.0  # a first state acts in its own sample, all else from the next one on
        bases = [filtered(source) for source in (self.y, -self.u, -errors, impulse)]
        kinds = (divmod(index, self.order) for index in range(count))
        return np.column_stack([_later(bases[kind], lag + (kind < 3)) for kind, lag in kinds])


def _later(series: Numbers, samples: int) -> Numbers:
    """Return the series, later by some samples, zeros before."""
    return np.concatenate([np.zeros(samples), series[: len(series) - samples]])


def fit_armax(
    y: Numbers, u: Numbers, order: int, *, initial: bool = True, lower: Armax | None = None
) -> ArmaxFit:
    """Return the maximum likelihood model of that order. Output y and input u are (N,).

    Gauss and Newton's steps are halved until the loss falls. V has several minima, so the search
    has several starts: least squares, Hannan and Rissanen's method, and the model of the order
    below times common factors (``lower`` is that model, if it is known). The lowest end is taken.
    ConfigError if the record is too short or has gaps.
    """
    kinds = POLYNOMIAL_KINDS if initial else POLYNOMIAL_KINDS[:3]
    names = tuple(f"{kind}{i}" for kind in kinds for i in range(1, order + 1))
    if len(y) < 2 * len(names) + order:
        raise ConfigError(f"{len(y)} samples are too few for {len(names)} coefficients")
    if np.isnan(y).any() or np.isnan(u).any():
        raise ConfigError("ARMAX needs a record without missing values; give a part without any")
    search = _Orders(y, u, order)
    starts = _starts(search, len(names))
    if order > 1:
        below = lower or fit_armax(y, u, order - 1, initial=initial).model
        starts += [_raise_order(below, factor, initial=initial) for factor in COMMON_FACTORS]
    ends = [_descend(search, theta) for theta in starts]
    theta, settled = min(ends, key=lambda end: search.loss(end[0]))
    return _account(search, names, theta, settled=settled)


def _raise_order(model: Armax, factor: float, *, initial: bool) -> Numbers:
    """Return the coefficients of the order above. A, B and C are times 1 - factor q^-1.

    The common factor cancels, so that this start is as good as the fit of the order below.
    """
    a, b, c = (
        np.convolve((1.0, -factor), head)[1:]
        for head in ((1.0, *model.a), (0.0, *model.b), (1.0, *model.c))
    )
    d = np.convolve((1.0, -factor), model.d) if initial else np.empty(0)
    return np.concatenate([a, b, c, d])


def _starts(search: _Orders, count: int) -> list[Numbers]:
    """Return coefficients to start from: least squares with c = 0, and with estimated errors."""
    zero, n = np.zeros(count), search.order
    eps, J = search.jacobian(zero)
    plain = zero - np.linalg.lstsq(J, eps, rcond=None)[0]
    plain[2 * n : 3 * n] = 0.0
    # Hannan and Rissanen: residuals of a long autoregression stand for the errors e
    lags = range(1, min(LONG_ORDER + n, len(search.y) // 4) + 1)
    long = np.column_stack([_later(series, i) for series in (search.y, search.u) for i in lags])
    errors = search.y - long @ np.linalg.lstsq(long, search.y, rcond=None)[0]
    columns = search.regressors(errors, count, lambda source: source)
    starts = [plain, np.linalg.lstsq(columns, -search.y, rcond=None)[0]]
    return [theta for theta in starts if np.isfinite(search.loss(theta))] or [zero]


def _descend(search: _Orders, theta: Numbers) -> tuple[Numbers, bool]:
    """Return the coefficients where the loss no longer falls, and whether it has settled there."""
    loss = search.loss(theta)
    for _ in range(MAX_ROUNDS):
        eps, J = search.jacobian(theta)
        step = np.asarray(-np.linalg.lstsq(J, eps, rcond=1e-12)[0], float)
        expected = -float((J.T @ eps) @ step)
        if expected < LOSS_TOLERANCE * loss:
            return theta, True
        halved = (search.stable(theta + 0.5**halving * step) for halving in range(MAX_HALVINGS))
        tried = ((there, search.loss(there)) for there in halved)
        nearer = next((one for one in tried if one[1] < loss), None)
        if nearer is None:
            return theta, search.at_rim(theta) or expected < ROUNDING_TOLERANCE * loss
        before, (theta, loss) = loss, nearer
        if search.at_rim(theta) and before - loss < LOSS_TOLERANCE * loss:
            return theta, True
    return theta, False


def _account(search: _Orders, names: tuple[str, ...], theta: Numbers, *, settled: bool) -> ArmaxFit:
    """Return the fit with deviations by its covariance lambda^2 (J^T J)^-1."""
    eps, J = search.jacobian(theta)
    size = np.sqrt(np.maximum(np.einsum("ij,ij->j", J, J), 1e-300))
    values, vectors = np.linalg.eigh((J / size).T @ (J / size))
    flat = values < FLAT_EIGENVALUE * values[-1]
    share = float(eps @ eps) / len(eps)
    inverse = (vectors / np.where(flat, np.inf, values)) @ vectors.T
    covariance = share * inverse / np.outer(size, size)
    # a coefficient with a share in a flat direction is not known, whatever the others tell
    unknown = (np.abs(vectors[:, flat]) > 0.05).any(axis=1)
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return ArmaxFit(
        model=search.model(theta),
        names=names,
        deviations=tuple(float(x) for x in np.where(unknown, np.inf, deviations)),
        loss=0.5 * float(eps @ eps),
        samples=len(eps),
        converged=settled,
        inseparable=tuple(name for name, lost in zip(names, unknown, strict=True) if lost),
    )


def detrend(series: Numbers, treatment: str) -> Numbers:
    """Return the series as it is, or less its mean or its straight line.

    The model has no constant term, so that a mean that stays in would look like dynamics.
    """
    if treatment == "none":
        return series
    if treatment == "mean":
        return np.asarray(series - series.mean())
    t = np.arange(len(series), dtype=float)
    return np.asarray(series - np.polyval(np.polyfit(t, series, 1), t))


def remove_delay(y: Numbers, u: Numbers, samples: int) -> tuple[Numbers, Numbers]:
    """Return output and input with a dead time taken out: y earlier by ``samples``.

    The model itself has a delay of one sample only.
    """
    if samples == 0:
        return y, u
    return y[samples:], u[:-samples]


class FirstOrder(NamedTuple):
    """The first-order Nomoto model K/(1 + T s) in a heading's second-order ARMAX model."""

    K: float  # [1/s]
    T: float  # [s]
    pole: float  # [-] per sample


def without_wind(model: Armax, interval: float) -> FirstOrder:
    """Return K and T of rudder to heading (9). A is replaced by (z - 1)(z - p), p = -a1 - 1.

    One of the two poles is that of heading, which is 1 without wind; p is the other. ConfigError
    unless the order is 2 and p is between 0 and 1.
    """
    if model.order != 2:
        raise ConfigError(f"a first-order ship needs an ARMAX model of order 2, not {model.order}")
    p = -model.a[0] - 1.0
    if not 0.0 < p < 1.0:
        raise ConfigError(f"the pole {p:.3g} per sample is no time constant")
    gain = sum(model.b) / ((1.0 - p) * interval)
    return FirstOrder(gain, -interval / math.log(p), p)


def rounding_poles(model: Armax) -> tuple[tuple[float, float], ...]:
    """Return the negative real poles that a zero nearly cancels.

    They show a rounded reading, not a ship.
    """
    poles = []
    for pole in model.poles:
        if abs(pole.imag) > 1e-9 or pole.real >= 0.0:
            continue
        near = min(model.zeros, key=lambda zero: abs(zero - pole), default=None)
        if near is not None and abs(near - pole) < CANCELLED_DISTANCE:
            poles.append((pole.real, near.real))
    return tuple(poles)
