"""Standard deviations of parameters, of what follows from them, and what cannot be separated.

The covariance of the estimates is the inverse of the second derivatives of the cost. Its small
eigenvalues name the combinations that the record hardly determines. ``inseparable`` finds them
before any search, so that a fit that cannot succeed is refused with the reason (MI 3.7, 8.3, 8.5).

The delta method takes gains and time constants as linear in the parameters. Time constants near a
double root bend sharply, and there only draws give intervals that contain the truth
(docs/identification.md has the shares).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.minimise import Cost, curvature
from trainer.identify.fitting.problem import Problem

FLAT_EIGENVALUE: Final = 1e-10  # [-] eigenvalue of the information scaled to a unit diagonal
# parameters of noise and lag: they have bounds, and no gain or time constant follows from them
BOUNDED_PREFIXES: Final = ("R1_", "R2_", "lag")
HALF_INTERVAL_95: Final = 1.959963984540054  # [standard deviations] of half a 95 % interval
# coefficients whose products and ratios are gains and time constants
RATIO_COEFFICIENTS: Final = ("a1", "a2", "a3", "b1", "b2", "c1", "c2", "c3")
MIN_MEMBER_SHARE: Final = 1e-3  # [-] of a flat direction, from which on a parameter belongs to it

Derived = Callable[[Numbers], Numbers]
TAIL_SHARE: Final = 0.025  # [-] of the draws, left out at each end of an interval
DIFFERENCE_STEP: Final = 1e-4  # [standard deviations] of each parameter, for the quotients


@dataclass(frozen=True)
class Uncertainty:
    """Covariance of the estimates, and eigenvalues of the matrix that it is the inverse of.

    ``curvature`` (f, f) is that matrix. ``eigenvalues`` are of this matrix scaled to a unit
    diagonal, smallest first, and the columns of ``directions`` (f, f) are their vectors. Where the
    matrix is singular or indefinite, ``covariance`` is NaN and ``flat`` names the parameters that
    cannot be separated.
    """

    names: tuple[str, ...]
    curvature: Numbers
    covariance: Numbers
    eigenvalues: Numbers
    directions: Numbers
    flat: tuple[tuple[str, ...], ...]

    @property
    def deviations(self) -> Numbers:
        """Return the standard deviations (f,)."""
        return np.sqrt(np.diag(self.covariance))


def uncertainty(names: tuple[str, ...], curvature: Numbers) -> Uncertainty:
    """Return what the second derivatives of a cost (f, f) say about its parameters."""
    if not np.isfinite(curvature).all():
        unknown = np.full_like(curvature, np.nan)
        return Uncertainty(names, curvature, unknown, np.diag(unknown), unknown, ())
    width = np.sqrt(np.abs(np.diag(curvature)))
    unit = np.where(width > 0.0, width, 1.0)
    scaled = curvature / np.outer(unit, unit)
    eigenvalues, directions = np.linalg.eigh(0.5 * (scaled + scaled.T))
    covariance = np.full_like(curvature, np.nan)
    if eigenvalues[0] > FLAT_EIGENVALUE:
        covariance = (directions / eigenvalues) @ directions.T / np.outer(unit, unit)
    flat = _groups(names, directions[:, eigenvalues <= FLAT_EIGENVALUE])
    return Uncertainty(names, curvature, covariance, eigenvalues, directions, flat)


def _groups(names: tuple[str, ...], directions: Numbers) -> tuple[tuple[str, ...], ...]:
    """Return the parameters of each flat direction; directions that share one are one group."""
    if directions.shape[1] == 0:
        return ()
    projector = directions @ directions.T  # what of each parameter's motion is flat
    linked = np.abs(projector) > MIN_MEMBER_SHARE * np.max(np.abs(projector), axis=1, keepdims=True)
    members = np.diag(projector) > MIN_MEMBER_SHARE**2
    groups: list[set[int]] = []
    for index in map(int, np.flatnonzero(members)):
        new = {index, *map(int, np.flatnonzero(linked[index] & members))}
        for old in [group for group in groups if group & new]:
            groups.remove(old)
            new |= old
        groups.append(new)
    return tuple(tuple(names[i] for i in sorted(group)) for group in sorted(groups, key=min))


def beside_bounds(known: Uncertainty) -> Uncertainty:
    """Return the others' covariance where a noise parameter or lag is at a bound.

    There a variance of zero, its correlation, and a lag of zero or of a whole interval have no
    information: their own covariances stay NaN, and the others are taken as if these were known.
    """
    lost = {name for group in known.flat for name in group if name.startswith(BOUNDED_PREFIXES)}
    if not lost:
        return known
    kept_indices = [i for i, name in enumerate(known.names) if name not in lost]
    indices = np.ix_(kept_indices, kept_indices)
    rest = uncertainty(tuple(known.names[i] for i in kept_indices), known.curvature[indices])
    covariance = np.full_like(known.covariance, np.nan)
    covariance[indices] = rest.covariance
    return replace(known, covariance=covariance)


def inseparable(problem: Problem) -> tuple[tuple[str, ...], ...]:
    """Return groups of free parameters that the samples cannot separate, before any fitting.

    A group of one is a parameter without any effect. The information at the start values tells the
    groups; and P(t0) with x(t0) is a group if both are free, because one record cannot tell both.
    """
    information, free = Likelihood(problem).information(problem.start), set(problem.names)
    together = (pair for pair in problem.plant.model.paired if free.issuperset(pair))
    return (*together, *uncertainty(problem.names, information).flat)


def hessian(cost: Cost, theta: Numbers) -> Numbers:
    """Return the second derivatives of ``cost`` (f, f): differences of its exact gradient.

    Steps are 1/1000 of what each parameter alone is known to. Near zero a variance or a lag is
    stepped to one side only, because a change of its sign gives the same model again: the cost has
    a kink there.
    """
    size = np.diag(cost.information(theta))
    steps = 1e-3 / np.sqrt(np.maximum(size, 1e-300))
    folded = np.isin(cost.problem.kinds, ("variance", "error", "lag"))
    back = np.where(folded & (np.abs(theta) < steps), 0.0, 1.0)
    return curvature(lambda at: cost.slope(at)[1], theta, steps, back)


def intervals(problem: Problem, theta: Numbers, deviations: Numbers) -> Numbers:
    """Return 95 % intervals (f, 2) of parameters, some of them by the logarithm.

    A variance has its interval by the logarithm, because its deviation grows with it: two
    deviations to either side would hold too little above. If a variance is less than its deviation
    the record does not tell it from zero, and the interval begins at zero.

    Gains and time constants are products and ratios of coefficients such as a1. Where the sign of
    such a coefficient is sure, its interval has the wider end of both ways, because next to a
    double root coefficients scatter further to either side than their deviation says.
    """
    names = RATIO_COEFFICIENTS if problem.plant.model.system is None else ()
    ratio = np.isin(problem.names, names) & (np.abs(theta) > HALF_INTERVAL_95 * deviations)
    above = np.isin(problem.kinds, ("variance", "error"))
    scaled = ratio | (above & (np.abs(theta) > deviations))
    share = HALF_INTERVAL_95 * deviations / np.where(scaled, np.abs(theta), 1.0)
    ways = np.array([-1.0, 1.0])
    factors = theta[:, None] * np.exp(np.where(scaled, share, 0.0)[:, None] * ways)
    middle = np.where(above, np.abs(theta), theta)
    straight = middle[:, None] + HALF_INTERVAL_95 * deviations[:, None] * ways
    straight[above, 0] = np.maximum(straight[above, 0], 0.0)
    ends = np.sort(np.where(scaled[:, None], factors, straight), axis=1)
    both = np.sort(np.hstack([factors, straight]), axis=1)[:, [0, 3]]
    return np.where(ratio[:, None], both, ends)


class JointSpread(NamedTuple):
    """Numbers and their covariance."""

    values: Numbers  # (m,)
    covariance: Numbers  # (m, m)

    @property
    def deviations(self) -> Numbers:
        """Return the standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def propagate_covariance(derived: Derived, theta: Numbers, covariance: Numbers) -> JointSpread:
    """Return ``derived(theta)`` (m,) with J cov J^T, J from central differences (8.3).

    A step is a small part of the parameter's own standard deviation, because that is the scale on
    which the numbers matter, whatever the unit.
    """
    steps = DIFFERENCE_STEP * np.sqrt(np.diag(covariance))
    columns = []
    for i, step in enumerate(steps):
        if step == 0.0:
            columns.append(np.zeros_like(derived(theta)))
            continue
        aside = np.zeros_like(theta)
        aside[i] = step
        columns.append((derived(theta + aside) - derived(theta - aside)) / (2.0 * step))
    J = np.column_stack(columns)
    return JointSpread(derived(theta), J @ covariance @ J.T)


class Span(NamedTuple):
    """95 % intervals of numbers, from draws of the parameters that they follow from."""

    low: Numbers  # (m,)
    high: Numbers  # (m,)


def span_draws(derived: Derived, draws: Numbers) -> tuple[Numbers, Span]:
    """Return ``derived`` of each of the ``draws`` (count, n), and its intervals.

    A draw may lack one number (NaN); its other numbers still count.
    """
    values = np.array([derived(draw) for draw in draws])
    known_values = np.where(np.isnan(values).all(axis=0), 0.0, values)  # no quantile of nothing
    low, high = np.nanquantile(known_values, (TAIL_SHARE, 1.0 - TAIL_SHARE), axis=0)
    nothing = np.isnan(values).all(axis=0)
    return values, Span(np.where(nothing, np.nan, low), np.where(nothing, np.nan, high))


def draw_parameters(theta: Numbers, covariance: Numbers, count: int, seed: int) -> Numbers:
    """Return ``count`` parameter vectors (count, n) from N(theta, covariance) (8.5)."""
    stream = np.random.Generator(np.random.PCG64(seed))
    return np.asarray(
        theta + stream.standard_normal((count, len(theta))) @ covariance_root(covariance).T
    )


def covariance_root(covariance: Numbers) -> Numbers:
    """Return C with C C' = ``covariance`` (..., n, n), which may be singular.

    Rows are scaled to a unit diagonal first, because units differ by many powers of ten; negative
    eigenvalues are rounding and are taken as zero.
    """
    width = np.sqrt(np.maximum(np.einsum("...ii->...i", covariance), 0.0))
    unit = np.where(width > 0.0, width, 1.0)
    sizes, vectors = np.linalg.eigh(covariance / (unit[..., None] * unit[..., None, :]))
    return np.asarray(
        width[..., None] * vectors * np.sqrt(np.maximum(sizes, 0.0))[..., None, :], float
    )
