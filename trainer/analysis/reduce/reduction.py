"""A boat's compact set, from a search or from its file, and its worth.

``cli/vessel`` calls ``search`` and ``report_reduction`` for ``trainer boat reduce``. A compact set
is the full set's coefficients times factors, 0 for a term that is dropped. The leash is the pull of
each factor towards 1 (``search`` the module): a firm one keeps a coefficient near the hull's data.
An unfinished search is kept in a file, because a search takes long.
"""

import contextlib
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trainer import __version__
from trainer.analysis.guide.programme import Leg
from trainer.analysis.guide.reasons import DropEffect
from trainer.analysis.reduce.objective import (
    CONTROL_COEFFICIENTS,
    Candidate,
    CandidatePool,
    Yardstick,
    compact_terms,
    fixed_terms,
)
from trainer.analysis.reduce.programme import fastest_legs, fit_legs
from trainer.analysis.reduce.search import (
    FIT_LIMIT,
    FIT_STEPS,
    SLACKEST_LEASH,
    Search,
    SearchAim,
    SearchPoint,
    SearchState,
    Slopes,
    TermNeed,
    descend_slopes,
)
from trainer.analysis.reduce.verdict import (
    LegVerdict,
    TickCost,
    hull_coefficients,
    judge_legs,
    measure_cost,
    passes_legs,
)
from trainer.config.files import no_constant, renew_file
from trainer.config.vessel import VesselFile
from trainer.core.digest import core_digest
from trainer.core.terms import COMPACT_TERMS

PARTIAL_SUFFIX: Final = ".partial.json"
FACTOR_DIGITS: Final = 4  # of a factor in the file
# [-] of what is allowed: a set this far off at the top speed is searched for again, flying there
ASTRAY_RATIO: Final = 1.5
FIRM_LEASH: Final = 0.2  # [-] leash of that search: four times the usual, nearer to the hull's data
MAX_SEARCHES: Final = 2  # for one boat: with and without the top speed
BASIC_ROUNDS: Final = 6  # of fitting the basic set; it stops before where a round gains nothing
QUICK_ROUNDS: Final = 2  # of the same, of a quick search


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
    cost: TickCost | None
    passed: bool


@dataclass(frozen=True)
class SearchResult:
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
) -> SearchResult:
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
    return SearchResult({"modified": modified, "basic": basic}, standing.needed)


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
        here = SearchPoint(start, pool.differences([start])[0])
        for _ in range(QUICK_ROUNDS if aim.quick else BASIC_ROUNDS):
            table = pool.slopes(here.factors, free, here.differences)
            slopes = Slopes(table, free, leash)
            next_point = descend_slopes(pool.differences, slopes, here, FIT_STEPS, FIT_LIMIT)
            if next_point.cost >= here.cost:
                break
            here = next_point
    return dict(zip(names, map(round_factor, here.factors.tolist()), strict=True))
