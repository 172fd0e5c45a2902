"""The search for the fewest terms begins with all and drops one after another.

``reduction`` calls it for ``trainer boat reduce``. A round takes the slopes of all differences by
all factors and drops, with those, what costs least, the factors of the rest fitted anew each time;
a term whose loss cannot be made up for is needed. Nothing in it is random, and a round depends on
its first state alone, so that a search that is broken off and continued ends in the same bits.

Factors are fitted by Gauss and Newton: the sum of |difference|^p is brought down for growing p, by
weights |difference|^(p - 2) on a linear least-squares problem; a leash, which is a penalty, pulls
every factor towards 1, so that a coefficient is what the hull's data say unless the flights ask
otherwise. docs/reduction.md tells the steps of a search, and what they found.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from trainer.analysis.guide.programme import Leg
from trainer.analysis.reduce.objective import Candidate, CandidatePool, Yardstick, fixed_terms
from trainer.analysis.reduce.programme import legs_of_guide
from trainer.config.boat.vessel import VesselFile
from trainer.core.kernel import Numbers

MIN_FACTOR, MAX_FACTOR = 0.5, 2.0  # [-] factors
MIN_WEIGHTED_DIFFERENCE: Final = 0.2  # [-] smaller differences weigh as this
COST_POWERS: Final = (2, 6)  # of a step: the growing p above
# added to the normal matrix (Levenberg): a large one makes a step short, and down the steepest way
STEP_DAMPINGS: Final = (0.01, 0.3, 10.0, 300.0)
DROP_POWER: Final = 4  # of the weighted squares by which a drop is foreseen: between COST_POWERS
MIN_COST_GAIN: Final = 0.995  # [-] of the cost: a step that brings less is the last
COST_NORM: Final = 8  # the power of the norm by which points are compared

FlyCandidates = Callable[[Sequence[Numbers]], list[Numbers]]
FIT_LIMIT: Final = 0.9  # [-] of what is allowed, in the flights fitted to
PROOF_LIMIT: Final = 0.97  # [-] in those of the guide, unseen by the fit
FIT_STOP_SHARE: Final = 0.8  # [-] of the limit, at which a fit stops
SLACKEST_LEASH: Final = 0.05  # [-] as in Slopes, the slackest
LEASH_FACTOR: Final = 4.0  # [-] by which a leash is let out that keeps the set from the limit
MAX_START_ROUNDS: Final = 4  # rounds that may bring the set with all terms into the limit
FIRST_BATCH_TERMS: Final = 8  # terms dropped at once, to begin with
MAX_SLOPE_USES: Final = 6  # terms dropped, or found needed, by the same slopes
FIT_STEPS: Final = 3  # of a fit by the same slopes
SURE_NEED: Final = 2.0  # [-] a need below this is doubtful: its term is tried once more at the end
LAST_FIT_ROUNDS: Final = 3  # rounds of a last fit, when the terms are chosen
HOPELESS_DIFFERENCE: Final = 4.0  # [-] a difference that new slopes will not mend
# [-] the same as slopes foresee it; a quick search does not fly to see it
FORESEEN_DIFFERENCE: Final = 3.0


class FactorPoint(NamedTuple):
    """Factors by term, and the differences by row that flights with them have."""

    factors: Numbers
    differences: Numbers

    @property
    def worst(self) -> float:
        """Return the largest difference [-] of what is allowed."""
        return float(abs(self.differences).max())

    @property
    def departure(self) -> float:
        """Return how far the factors of what is kept are from 1 [-], squared."""
        kept_factors = self.factors[self.factors != 0.0]
        return float(np.sum((kept_factors - 1.0) ** 2))

    @property
    def cost(self) -> float:
        """Return the differences as one number, in which the largest ones weigh most."""
        return float(np.sum(abs(self.differences) ** COST_NORM) ** (1.0 / COST_NORM))


class Slopes(NamedTuple):
    """The slopes of the differences by the factors, and the leash on the factors."""

    table: Numbers  # (rows, all factors)
    free: list[int]  # indices of the factors that may change
    leash: float  # [-] weight of (factor - 1)^2 beside the largest difference's square


def normal_matrix(slopes: Slopes, differences: Numbers, power: int) -> tuple[Numbers, Numbers]:
    """Return the weighted normal matrix, leash included, and the weights by row."""
    weights = np.maximum(abs(differences), MIN_WEIGHTED_DIFFERENCE) ** (power - 2)
    weights /= weights.max()
    table = slopes.table[:, slopes.free]
    return table.T @ (weights[:, None] * table) + slopes.leash * np.eye(table.shape[1]), weights


def take_step(slopes: Slopes, here: FactorPoint, power: int, damping: float) -> Numbers:
    """Return the factors after one damped step of Gauss and Newton, within their limits."""
    indices = slopes.free
    matrix, weights = normal_matrix(slopes, here.differences, power)
    downhill = -slopes.table[:, indices].T @ (weights * here.differences)
    downhill -= slopes.leash * (here.factors[indices] - 1.0)
    factors = here.factors.copy()
    factors[indices] += np.linalg.solve(matrix + damping * np.eye(len(indices)), downhill)
    factors[indices] = np.clip(factors[indices], MIN_FACTOR, MAX_FACTOR)
    return factors


def descend_slopes(
    fly: FlyCandidates, slopes: Slopes, here: FactorPoint, rounds: int, goal: float
) -> FactorPoint:
    """Return the best point of ``rounds`` steps by the same slopes.

    Among points within the goal the best is the nearest to the hull's own coefficients. Without
    such a point it is the one of the least cost.
    """
    for _ in range(rounds):
        if here.worst <= goal:
            break
        # every power with every damping: the flights show which pair helps most
        tried = [take_step(slopes, here, *pair) for pair in product(COST_POWERS, STEP_DAMPINGS)]
        points = [FactorPoint(*pair) for pair in zip(tried, fly(tried), strict=True)]
        reached = [one for one in points if one.worst <= goal]
        if reached:
            return min(reached, key=lambda one: one.departure)
        best = min(points, key=lambda one: one.cost)
        if best.cost >= MIN_COST_GAIN * here.cost:
            break
        here = best
    return here


def without_terms(slopes: Slopes, here: FactorPoint, gone: Sequence[int]) -> Numbers:
    """Return the factors with those ``gone`` at zero. The others make up for it.

    The quadratic cost at this point says how: its minimum under the constraint that the factors
    gone are zero.
    """
    indices = slopes.free
    matrix, _ = normal_matrix(slopes, here.differences, DROP_POWER)
    inverse = np.linalg.inv(matrix)
    which = [indices.index(index) for index in gone]
    pull = np.linalg.solve(inverse[np.ix_(which, which)], here.factors[list(gone)])
    factors = here.factors.copy()
    factors[indices] = np.clip(factors[indices] - inverse[:, which] @ pull, MIN_FACTOR, MAX_FACTOR)
    factors[list(gone)] = 0.0
    return factors


def cost_rises(slopes: Slopes, here: FactorPoint) -> Numbers:
    """Return the rise [-] of the weighted squares for each free factor alone at zero."""
    matrix, _ = normal_matrix(slopes, here.differences, DROP_POWER)
    return np.asarray(here.factors[slopes.free] ** 2 / np.diag(np.linalg.inv(matrix)))


@dataclass(frozen=True)
class TermNeed:
    """Why a term stays: what would be off without it, the others fitted anew."""

    term: str
    worst: float  # [-] of what is allowed
    leg: str
    quantity: str


@dataclass(frozen=True)
class SearchState:
    """The state of a search; a round depends on this alone."""

    factors: tuple[float, ...]  # [-] by term, 0: dropped
    kept: tuple[int, ...]  # indices of the terms
    needed: tuple[TermNeed, ...] = ()
    batch: int = FIRST_BATCH_TERMS
    starts: int = 0  # rounds that the set with all terms has been fitted in
    limit: float = 0.0  # [-] 0: not begun to drop
    proof: float = 0.0
    again: bool = False  # whether doubtful terms have been tried a second time
    settled: int = 0  # rounds of the last fit
    leash: float = SLACKEST_LEASH  # [-] as in Slopes

    @property
    def done(self) -> bool:
        """Return whether nothing is left to do."""
        return self.settled >= LAST_FIT_ROUNDS


class SearchAim(NamedTuple):
    """The task of a search, and how closely it keeps to the hull's data."""

    legs: tuple[Leg, ...]
    leash: float  # [-] as in Slopes, to begin with
    stays: frozenset[str]  # terms that are not dropped
    quick: bool = False  # whether a term is kept whose loss takes long to make up for


class Search:
    """A boat's compact set on its way to fewer terms."""

    def __init__(
        self, file: VesselFile, equations: str, pool: CandidatePool, aim: SearchAim
    ) -> None:
        """Begin with all terms, each with the full set's coefficient."""
        self.candidate = Candidate(file, equations)
        self.terms = self.candidate.terms
        self._pool, self._aim = pool, aim
        self._fixed = fixed_terms(file)
        self._proven = np.empty(0), np.empty(0)  # factors, and their differences in the guide
        self._proof = Yardstick(file, legs_of_guide(file))
        self._rows = pool.rows

    def begin(self) -> SearchState:
        """Return the state of a search that has not begun."""
        return self._begin(self._aim.leash)

    def _begin(self, leash: float) -> SearchState:
        """Return the state before anything is fitted or dropped."""
        everything = tuple(range(len(self.terms)))
        standing = SearchState((1.0,) * len(self.terms), everything, leash=leash)
        if self._aim.quick:
            return replace(standing, again=True, settled=LAST_FIT_ROUNDS - 1)
        return standing

    def undecided(self, standing: SearchState) -> list[int]:
        """Return the indices of the terms that may still be dropped."""
        decided = {*(need.term for need in standing.needed), *self._aim.stays}
        return [i for i in standing.kept if self.terms[i] not in decided]

    def round(self, standing: SearchState, step: Callable[[], None]) -> SearchState:
        """Return the state after one round; ``step`` is called after each term decided."""
        if standing.limit and not self.undecided(standing) and not standing.again:
            # terms whose loss was nearly made up for are tried again: docs/reduction.md, step 6
            sure = tuple(need for need in standing.needed if need.worst >= SURE_NEED)
            return replace(standing, needed=sure, again=True)
        here = self._point(np.array(standing.factors))
        slopes = self._slopes(here, standing.kept, standing.leash)
        if not standing.limit:
            return self._start(standing, here, slopes)
        if not self.undecided(standing):
            return self._settle(standing, here, slopes)
        return self._drop(standing, here, slopes, step)

    def _point(self, factors: Numbers) -> FactorPoint:
        """Return factors with the differences of flights with them."""
        return FactorPoint(factors, self._pool.differences([factors])[0])

    def _free(self, kept: Sequence[int]) -> list[int]:
        """Return the indices of the factors that may change."""
        return [i for i in kept if self.terms[i] not in self._fixed]

    def _slopes(self, here: FactorPoint, kept: Sequence[int], leash: float) -> Slopes:
        """Return the slopes at a point."""
        free = self._free(kept)
        return Slopes(self._pool.slopes(here.factors, free, here.differences), free, leash)

    def _among(self, slopes: Slopes, kept: Sequence[int]) -> Slopes:
        """Return the same slopes with fewer factors free."""
        return slopes._replace(free=self._free(kept))

    def _fit(
        self, slopes: Slopes, here: FactorPoint, kept: Sequence[int], goal: float
    ) -> FactorPoint:
        """Return the point that a fit by these slopes leads to."""
        among = self._among(slopes, kept)
        return descend_slopes(self._pool.differences, among, here, FIT_STEPS, goal)

    def proof(self, factors: Numbers) -> Numbers:
        """Return the differences in the guide's flights."""
        if not np.array_equal(factors, self._proven[0]):
            self.candidate.take(factors)
            differences = self._proof.determined * self._proof.differences(self.candidate)
            self._proven = factors.copy(), differences
        return self._proven[1]

    def _start(self, standing: SearchState, here: FactorPoint, slopes: Slopes) -> SearchState:
        """Return the state after a fit of the set with all terms.

        If the leash keeps the set from the limit, the search begins anew with a slacker one.
        """
        begun, here = here, self._fit(slopes, here, standing.kept, FIT_STOP_SHARE * FIT_LIMIT)
        proof = float(abs(self.proof(here.factors)).max())
        moved = not np.array_equal(begun.factors, here.factors)  # else one more would do the same
        tried = replace(standing, factors=tuple(here.factors.tolist()), starts=standing.starts + 1)
        if (
            moved
            and tried.starts < MAX_START_ROUNDS
            and (here.worst > FIT_STOP_SHARE * FIT_LIMIT or proof > PROOF_LIMIT)
        ):
            return tried
        if standing.leash > SLACKEST_LEASH and (here.worst > FIT_LIMIT or proof > PROOF_LIMIT):
            return self._begin(max(SLACKEST_LEASH, standing.leash / LEASH_FACTOR))
        return replace(tried, limit=max(FIT_LIMIT, here.worst), proof=max(PROOF_LIMIT, proof))

    def _settle(self, standing: SearchState, here: FactorPoint, slopes: Slopes) -> SearchState:
        """Return the state after the best fit, unless the guide's flights become worse by it."""
        next_point = self._fit(slopes, here, standing.kept, 0.0)
        worse = abs(self.proof(next_point.factors)).max() > standing.proof
        if worse or next_point.cost >= here.cost:
            return replace(standing, settled=LAST_FIT_ROUNDS)
        factors = tuple(next_point.factors.tolist())
        return replace(standing, factors=factors, settled=standing.settled + 1)

    def _drop(
        self, standing: SearchState, here: FactorPoint, slopes: Slopes, step: Callable[[], None]
    ) -> SearchState:
        """Return the state after up to MAX_SLOPE_USES decisions by the same slopes.

        New slopes cost a flight of every leg for each factor; old ones are less true with each
        term that goes.
        """
        decided = 0
        if self._aim.quick:
            standing = self._foresee(standing, here, slopes, step)
        while decided < MAX_SLOPE_USES:
            order = self._order(standing, here, slopes)[: standing.batch]
            if not order:
                break
            next_point, passed = self._try(standing, here, slopes, order)
            if passed is not None and len(order) > 1:
                # one of several terms is needed: fewer at once show which
                standing = replace(standing, batch=standing.batch // 2)
                continue
            decided += len(order)
            for _ in order:
                step()
            if passed is None:
                kept_indices = tuple(i for i in standing.kept if i not in order)
                standing = self._tighten(replace(standing, kept=kept_indices), next_point)
                here = next_point
            else:
                standing = replace(standing, needed=(*standing.needed, passed))
        return standing

    def _foresee(
        self, standing: SearchState, here: FactorPoint, slopes: Slopes, step: Callable[[], None]
    ) -> SearchState:
        """Return the state with the terms marked as needed that slopes alone show to be."""
        among = self._among(slopes, standing.kept)
        for index in self.undecided(standing):
            change = without_terms(among, here, [index]) - here.factors
            foreseen = abs(here.differences + slopes.table @ change)
            if foreseen.max() > FORESEEN_DIFFERENCE * standing.limit:
                row = self._rows[int(np.argmax(foreseen))]
                need = TermNeed(self.terms[index], float(foreseen.max()), row.leg, row.quantity)
                standing = replace(standing, needed=(*standing.needed, need))
                step()
        return standing

    def _tighten(self, standing: SearchState, there: FactorPoint) -> SearchState:
        """Return the state at a point with fewer terms, with the limits that this point keeps.

        The set with all terms may be beyond the limit because of a term that is now gone, such as
        one of two accelerations of the last cycle that drive each other. The limit then follows.
        """
        proof = float(abs(self.proof(there.factors)).max())
        return replace(
            standing,
            factors=tuple(there.factors.tolist()),
            limit=max(FIT_LIMIT, min(standing.limit, there.worst)),
            proof=max(PROOF_LIMIT, min(standing.proof, proof)),
        )

    def _order(self, standing: SearchState, here: FactorPoint, slopes: Slopes) -> list[int]:
        """Return the indices of the terms that may be dropped, the cheapest first."""
        among = self._among(slopes, standing.kept)
        cost = dict(zip(among.free, cost_rises(among, here), strict=True))
        return sorted(self.undecided(standing), key=lambda i: float(cost[i]))

    def _try(
        self, standing: SearchState, here: FactorPoint, slopes: Slopes, gone: Sequence[int]
    ) -> tuple[FactorPoint, TermNeed | None]:
        """Return the point without the terms ``gone``, and their need; None if they can go."""
        kept_indices = tuple(i for i in standing.kept if i not in gone)
        factors = without_terms(self._among(slopes, standing.kept), here, gone)
        point = self._point(factors)
        if self._aim.quick and point.worst > HOPELESS_DIFFERENCE * standing.limit:
            return point, self._need(standing, point, gone)
        goal = FIT_STOP_SHARE * standing.limit
        point = self._fit(slopes, point, kept_indices, goal)
        need = self._need(standing, point, gone)
        if need and not self._aim.quick and len(gone) == 1 and need.worst < HOPELESS_DIFFERENCE:
            anew = self._slopes(point, kept_indices, standing.leash)
            point = self._fit(anew, point, kept_indices, 0.0)
            need = self._need(standing, point, gone)
        return point, need

    def _need(
        self, standing: SearchState, there: FactorPoint, gone: Sequence[int]
    ) -> TermNeed | None:
        """Return the worst number without the terms ``gone``; None if all are within limits."""
        term = self.terms[gone[0]]
        if there.worst > standing.limit:
            row = self._rows[int(np.argmax(abs(there.differences)))]
            return TermNeed(term, there.worst, row.leg, row.quantity)
        proof = abs(self.proof(there.factors))
        if proof.max() > standing.proof:
            row = self._proof.rows[int(np.argmax(proof))]
            return TermNeed(term, float(proof.max()), row.leg, row.quantity)
        return None
