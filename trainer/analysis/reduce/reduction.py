"""A boat's compact set, from a search or from its file, and its worth.

``cli/workshop/vessel`` calls ``search`` and ``report_reduction`` for ``trainer boat reduce``. A
compact set is the full set's coefficients times factors, 0 for a term that is dropped. The leash is
the pull of each factor towards 1 (``search`` the module): a firm one keeps a coefficient near the
hull's data. An unfinished search is kept in a file, because a search takes long. The worth is how
far the set's flights differ, what a tick costs, and what each coefficient does: a set that passes
flies like the full one for a fraction of its work.
"""

import contextlib
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter_ns
from typing import Final

import numpy as np

from trainer import __version__
from trainer.analysis.guide import verdicts
from trainer.analysis.guide.programme import Leg, fly_all, guide_legs
from trainer.analysis.guide.reasons import DropEffect, MeasureNames, drop_effects, tasks_without
from trainer.analysis.guide.verdicts import BEYOND_TOLERANCE, NOT_DETERMINED, allowed_multiple
from trainer.analysis.manoeuvres.submarine import DEEP_WATER_M
from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT
from trainer.analysis.reduce.objective import (
    CONTROL_COEFFICIENTS,
    Candidate,
    CandidatePool,
    Yardstick,
    compact_terms,
    fixed_terms,
)
from trainer.analysis.reduce.programme import (
    fastest_legs,
    fit_legs,
    flyable_legs,
    holdout_legs,
    turn_legs,
)
from trainer.analysis.reduce.search import (
    FIT_LIMIT,
    FIT_STEPS,
    SLACKEST_LEASH,
    FactorPoint,
    Search,
    SearchAim,
    SearchState,
    Slopes,
    TermNeed,
    descend_slopes,
)
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, no_constant, renew_file
from trainer.core.digest import core_digest
from trainer.core.entry import LOOKOUT, ROW_COLUMNS, sail
from trainer.core.terms import COEFFICIENTS, COMPACT_TERMS
from trainer.units import KNOT

PART_TOLERANCES: Final = {  # [%] of change allowed, [s] of zero crossings
    "guide": ALLOWED_PERCENT,
    "steady turns": ALLOWED_PERCENT,
    "held out": 2.0 * ALLOWED_PERCENT,
}
TIMED_TICKS: Final = 2000  # [ticks] timed at once, long against the resolution of the clock
TIMING_REPEATS: Final = 7  # of which the fastest counts: other programs only add to the time
SENSITIVITY_MEASURES: Final[MeasureNames] = {
    "turn": ("steady diameter", "steady speed", "largest roll"),
    "meander": ("pitch peak 1", "damping ratio"),
    "overshoot": ("largest pitch", "depth change"),
    "roll-decay": ("period", "amplitude after cycle 1"),
}
PARTIAL_SUFFIX: Final = ".partial.json"
FACTOR_DIGITS: Final = 4  # of a factor in the file
# [-] of what is allowed: a set this far off at the top speed is searched for again, flying there
ASTRAY_RATIO: Final = 1.5
FIRM_LEASH: Final = 0.2  # [-] leash of that search: four times the usual, nearer to the hull's data
MAX_SEARCHES: Final = 2  # for one boat: with and without the top speed
BASIC_ROUNDS: Final = 6  # of fitting the basic set; it stops before where a round gains nothing
QUICK_ROUNDS: Final = 2  # of the same, of a quick search


@dataclass(frozen=True)
class LegVerdict:
    """One leg by the compact set."""

    part: str
    leg: str
    judged: int  # numbers; none where the full set cannot start or is lost
    beyond: int
    worst: float  # [-] of what is allowed
    quantity: str  # that is the worst
    undetermined: tuple[str, ...] = ()  # beyond, but not determined by the hull: not judged

    @property
    def passed(self) -> bool | None:
        """Return whether nothing judged is beyond what is allowed; None: nothing is judged."""
        return not self.beyond if self.judged else None


def verdict_legs(file: VesselFile, part: str) -> Sequence[Leg]:
    """Return the legs of a part of the verdict."""
    if part == "guide":
        return guide_legs(file)
    return flyable_legs(file, turn_legs(file)) if part == "steady turns" else holdout_legs(file)


def judge_legs(file: VesselFile, candidate: Candidate) -> tuple[LegVerdict, ...]:
    """Return every leg of every part judged."""
    return tuple(one for part in PART_TOLERANCES for one in _part(file, part, candidate))


def _part(file: VesselFile, part: str, candidate: Candidate) -> Iterator[LegVerdict]:
    """Yield the legs of one part."""
    share = PART_TOLERANCES[part] / ALLOWED_PERCENT
    wanted = verdict_legs(file, part)
    yardstick = Yardstick(file, wanted)
    for leg in wanted:
        if leg not in yardstick.legs:
            yield LegVerdict(part, leg.title, 0, 0, 0.0, "")
    for leg, judgements in yardstick.judged(candidate, share):
        if not judgements:
            yield LegVerdict(part, leg.title, 1, 1, float("inf"), "it cannot start")
            continue
        judged = [one for one in judgements if one.allowed]
        lost = [one for one in judgements if one.verdict == BEYOND_TOLERANCE and not one.allowed]
        sizes = {one.quantity: abs(allowed_multiple(one)) / share for one in judged}
        sizes |= {one.quantity: float("inf") for one in lost}
        worst = max(sizes, key=lambda name: sizes[name], default="")
        beyond = sum(size > 1.0 for size in sizes.values())
        apart = tuple(one.quantity for one in judgements if one.verdict == NOT_DETERMINED)
        yield LegVerdict(part, leg.title, len(sizes), beyond, sizes.get(worst, 0.0), worst, apart)


def passes_legs(checked: Sequence[LegVerdict]) -> bool:
    """Return whether something is judged, and nothing beyond what is allowed."""
    return verdicts.passes_all([one.passed for one in checked])


@dataclass(frozen=True)
class TermCost:
    """The least time of a tick, the whole boat's, back to back."""

    full_ns: float
    compact_ns: float

    @property
    def ratio(self) -> float:
        """Return the compact set's cost as a share of the full set's."""
        return self.compact_ns / self.full_ns


def measure_cost(file: VesselFile) -> TermCost | None:
    """Return the cost of a tick, full set exact, compact lagged. None of a boat that cannot start.

    Both sets are integrated by Adams, at the boat's own step and speed.
    """
    try:
        full, compact = (
            _nanoseconds(file, Method(equations, rates, "exact", "adams2", file.run.step_s))
            for equations, rates in (("full", "exact"), ("modified", "lagged"))
        )
    except ConfigError:
        return None
    return TermCost(full, compact)


def _nanoseconds(file: VesselFile, method: Method) -> float:
    """Return the least time [ns] of a tick."""
    boat = Boat(file, method)
    eye = np.zeros(1, LOOKOUT)
    eye["last"], eye["steepest"] = 1e18, 10.0
    rows = np.empty((TIMED_TICKS, ROW_COLUMNS))
    least = float("inf")
    for _ in range(TIMING_REPEATS):
        boat.start(file.run.start_speed_kn * KNOT, DEEP_WATER_M, 0.0)
        begin = perf_counter_ns()
        flown = sail(boat.records, eye, rows)
        least = min(least, (perf_counter_ns() - begin) / max(flown, 1))
    return least


def hull_coefficients(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients that this hull has."""
    return tuple(term.key for term in COEFFICIENTS if file.coefficients[term.key])


def flight_count(file: VesselFile) -> int:
    """Return how many flights the table takes."""
    return len(set(tasks_without(file, hull_coefficients(file), SENSITIVITY_MEASURES)))


def effect_table(file: VesselFile, cores: int, step: Callable[[], None]) -> tuple[DropEffect, ...]:
    """Return the effect [%] of each coefficient at zero in the full set, largest first."""
    wanted = tasks_without(file, hull_coefficients(file), SENSITIVITY_MEASURES)
    flown = fly_all(file.path, wanted, cores, step)
    return drop_effects(file, flown, hull_coefficients(file), SENSITIVITY_MEASURES)


def checkpoint_of(result: Path) -> Path:
    """Return the path at which an unfinished search for that result is kept."""
    return result.with_name(result.name + PARTIAL_SUFFIX)


def fingerprint(file: VesselFile) -> str:
    """Return what tells one search from another: the boat and the program."""
    text = f"{__version__}\n{core_digest()}\n{file.text}"
    return hashlib.sha256(text.encode()).hexdigest()


def save_standings(path: Path, file: VesselFile, standings: Mapping[str, SearchState]) -> None:
    """Write the standings by equation set, whole or not at all. ConfigError if that cannot be."""
    table = {"of": fingerprint(file), **{name: asdict(one) for name, one in standings.items()}}
    renew_file(path, json.dumps(table))


def load_standings(path: Path, file: VesselFile) -> dict[str, SearchState]:
    """Return the kept standings; none if they are of another boat or program."""
    try:
        table = json.loads(path.read_text(encoding="utf-8"), parse_constant=no_constant)
        if table.pop("of") != fingerprint(file):
            return {}
        return {
            name: SearchState(
                **{**one, "factors": tuple(one["factors"]), "kept": tuple(one["kept"])}
                | {"needed": tuple(TermNeed(**need) for need in one["needed"])}
            )
            for name, one in table.items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def discard_checkpoint(path: Path) -> None:
    """Take the file away, if it is there."""
    with contextlib.suppress(OSError):
        path.unlink()


@dataclass(frozen=True)
class KeptTerm:
    """One term of the compact set."""

    term: str
    coefficient: float  # [-] of the full set
    factor: float  # [-]
    in_1969: bool  # among the 60 that the report keeps


@dataclass(frozen=True)
class Reduction:
    """All that ``trainer boat reduce`` says about a boat."""

    vessel: str
    hull_terms: int  # coefficients that are not zero, besides thrust
    report_terms: int  # of them kept by the reduction of 1969
    kept: tuple[KeptTerm, ...]
    dropped: tuple[str, ...]
    needs: tuple[TermNeed, ...]  # why terms stay, of a search
    sensitivity: tuple[DropEffect, ...]
    checked: tuple[LegVerdict, ...]
    cost: TermCost | None
    passed: bool


@dataclass(frozen=True)
class ReductionEnd:
    """The result of a search: factors by set and term, and why terms stay."""

    factors: dict[str, dict[str, float]]  # [-] 0: dropped
    needs: tuple[TermNeed, ...]


def round_factor(value: float) -> float:
    """Return a factor as the file has it."""
    return float(f"{value:.{FACTOR_DIGITS}g}")


def as_filed(file: VesselFile) -> dict[str, float]:
    """Return the modified set's factors by term, from the file. 0: dropped."""
    factors = file.compensation["modified"]
    kept_terms = {*COMPACT_TERMS, *file.compact.extra_terms}
    return {
        name: factors.get(name, 1.0) if name in kept_terms else 0.0
        for name in compact_terms(file, "modified")
    }


def report_reduction(
    file: VesselFile,
    factors: Mapping[str, float],
    needs: tuple[TermNeed, ...],
    sensitivity: tuple[DropEffect, ...],
) -> Reduction:
    """Return the whole report on the boat's modified set with these factors."""
    candidate = Candidate(file, "modified")
    candidate.take([factors[name] for name in candidate.terms])
    checked = judge_legs(file, candidate)
    kept_rows = tuple(
        KeptTerm(name, file.coefficients[name], factor, name in COMPACT_TERMS)
        for name, factor in factors.items()
        if factor
    )
    hull = hull_coefficients(file)
    staying = {one.term for one in kept_rows}
    return Reduction(
        vessel=file.name,
        hull_terms=len(hull),
        report_terms=sum(name in COMPACT_TERMS for name in hull),
        kept=kept_rows,
        dropped=tuple(name for name in hull if name not in staying),
        needs=tuple(need for need in needs if need.term in staying),
        sensitivity=sensitivity,
        checked=checked,
        cost=measure_cost(file),
        passed=passes_legs(checked),
    )


def search(
    file: VesselFile,
    cores: int,
    partial: Path | None,
    step: Callable[[int], None],
    *,
    quick: bool = False,
) -> ReductionEnd:
    """Return the factors found; ``partial`` is the path that keeps an unfinished search.

    A ``quick`` search keeps a term whose loss takes long to make up for.

    The first search does not fly at the boat's top speed. If its set is astray there, a second
    search fits flights at that speed too. It has a firmer leash, if the flights can be met with
    one. ``step`` is called with the number of terms decided, which may reach MAX_SEARCHES times the
    number of terms.
    """
    fast = fastest_legs(file)
    stays = frozenset(CONTROL_COEFFICIENTS) | fixed_terms(file)
    aim = SearchAim(fit_legs(file), SLACKEST_LEASH, stays, quick)
    standing, modified = _run_search(file, aim, cores, partial, step)
    if largest_difference(file, fast, modified) > ASTRAY_RATIO:
        aim = SearchAim((*aim.legs, *fast), FIRM_LEASH, stays, quick)
        standing, modified = _run_search(file, aim, cores, partial, step)
    basic = _basic(file, aim, cores, modified, standing.leash)
    return ReductionEnd({"modified": modified, "basic": basic}, standing.needed)


def _run_search(
    file: VesselFile, aim: SearchAim, cores: int, partial: Path | None, step: Callable[[int], None]
) -> tuple[SearchState, dict[str, float]]:
    """Return how a search ends, and its factors by term. Each round is kept at ``partial``."""
    name = f"{len(aim.legs)} flights{', quick' * aim.quick}"
    standings = load_standings(partial, file) if partial else {}
    with CandidatePool(file.path, "modified", aim.legs, cores) as pool:
        at_work = Search(file, "modified", pool, aim)
        standing = standings.get(name) or at_work.begin()
        step(len(at_work.terms) - len(at_work.undecided(standing)))
        while not standing.done:
            standing = at_work.round(standing, lambda: step(1))
            if partial:
                save_standings(partial, file, {**standings, name: standing})
    return standing, dict(zip(at_work.terms, map(round_factor, standing.factors), strict=True))


def largest_difference(
    file: VesselFile, legs: Sequence[Leg], factors: Mapping[str, float]
) -> float:
    """Return the modified set's largest difference in some legs [-].

    It is a multiple of what is allowed; numbers that are not determined are left out.
    """
    candidate = Candidate(file, "modified")
    candidate.take([factors[name] for name in candidate.terms])
    yardstick = Yardstick(file, legs)
    return float(abs(yardstick.determined * yardstick.differences(candidate)).max(initial=0.0))


def _basic(
    file: VesselFile, aim: SearchAim, cores: int, modified: Mapping[str, float], leash: float
) -> dict[str, float]:
    """Return the factors of the basic set: those of the modified one, fitted to less."""
    names = compact_terms(file, "basic")
    start = np.array([modified[name] for name in names])
    with CandidatePool(file.path, "basic", aim.legs, cores) as pool:
        fixed = fixed_terms(file)
        free = [i for i, name in enumerate(names) if start[i] and name not in fixed]
        here = FactorPoint(start, pool.differences([start])[0])
        for _ in range(QUICK_ROUNDS if aim.quick else BASIC_ROUNDS):
            table = pool.slopes(here.factors, free, here.differences)
            slopes = Slopes(table, free, leash)
            next_point = descend_slopes(pool.differences, slopes, here, FIT_STEPS, FIT_LIMIT)
            if next_point.cost >= here.cost:
                break
            here = next_point
    return dict(zip(names, map(round_factor, here.factors.tolist()), strict=True))
