"""A boat's compact set, from a search or from its file, and its worth."""

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
from trainer.analysis.guide.reasons import Drop
from trainer.analysis.reduce.candidates import Crew
from trainer.analysis.reduce.objective import (
    ADDED_MASSES,
    CONTROLS,
    FIXED,
    Candidate,
    Yardstick,
    terms,
)
from trainer.analysis.reduce.programme import fastest, fit_legs
from trainer.analysis.reduce.search import (
    LEASH,
    LIMIT,
    STEPS,
    Aim,
    Need,
    Point,
    Search,
    Slopes,
    Standing,
    descend,
)
from trainer.analysis.reduce.verdict import Checked, Cost, coefficients, cost, passes, verdict
from trainer.config.files import ConfigError, no_constant
from trainer.config.vessel import VesselFile
from trainer.core.cache import core_digest
from trainer.core.terms import KEPT
from trainer.io.atomic_write import write_whole

ENDING: Final = ".partial.json"
DIGITS: Final = 4  # of a factor in the file
ASTRAY: Final = 1.5  # [-] of what is allowed, at the top speed: a second search flies there, with a
FIRM: Final = 0.2  # [-] leash that keeps closer to the hull's data, where it can be
SEARCHES: Final = 2  # at most
BASIC_ROUNDS: Final = 6
QUICK_ROUNDS: Final = 2  # of the same, of a quick search


def checkpoint_of(result: Path) -> Path:
    """Return where the search for that result is kept."""
    return result.with_name(result.name + ENDING)


def fingerprint(file: VesselFile) -> str:
    """Return what tells one search from another: the boat and the program."""
    text = f"{__version__}\n{core_digest()}\n{file.text}"
    return hashlib.sha256(text.encode()).hexdigest()


def save_standings(path: Path, file: VesselFile, standings: Mapping[str, Standing]) -> None:
    """Write the standings by equation set, whole or not at all. ConfigError if that cannot be."""
    found = {"of": fingerprint(file), **{name: asdict(one) for name, one in standings.items()}}
    try:
        write_whole(path, json.dumps(found))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None


def load_standings(path: Path, file: VesselFile) -> dict[str, Standing]:
    """Return the standings kept, none if there are none of this boat by this program."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"), parse_constant=no_constant)
        if found.pop("of") != fingerprint(file):
            return {}
        return {
            name: Standing(
                **{**one, "factors": tuple(one["factors"]), "kept": tuple(one["kept"])}
                | {"needed": tuple(Need(**need) for need in one["needed"])}
            )
            for name, one in found.items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


class Log:
    """How far the searches for one boat have come, by name. In a file, if there is one."""

    def __init__(self, file: VesselFile, path: Path | None) -> None:
        """Read what the file at ``path`` has of this boat."""
        self._file, self._path = file, path
        self._standings = load_standings(path, file) if path else {}

    def standing(self, name: str) -> Standing | None:
        """Return how far a search has come; None: it has not begun."""
        return self._standings.get(name)

    def enter(self, name: str, standing: Standing) -> None:
        """Keep how far a search has come; ConfigError if the file cannot be written."""
        self._standings[name] = standing
        if self._path:
            save_standings(self._path, self._file, self._standings)


def discard_checkpoint(path: Path) -> None:
    """Take the file away, if it is there."""
    with contextlib.suppress(OSError):
        path.unlink()


@dataclass(frozen=True)
class Kept:
    """One term of the compact set."""

    term: str
    coefficient: float  # [-] of the full set
    factor: float  # [-]
    in_1969: bool  # among the 60 that the report keeps


@dataclass(frozen=True)
class Reduction:
    """All that ``trainer reduce`` says about a boat."""

    vessel: str
    hull_terms: int  # coefficients that are not zero, besides thrust
    report_terms: int  # of them kept by the reduction of 1969
    kept: tuple[Kept, ...]
    dropped: tuple[str, ...]
    needs: tuple[Need, ...]  # why terms stay, of a search
    sensitivity: tuple[Drop, ...]
    checked: tuple[Checked, ...]
    cost: Cost | None
    passed: bool


@dataclass(frozen=True)
class Found:
    """The result of a search: factors by set and term, and why terms stay."""

    factors: dict[str, dict[str, float]]  # [-] 0: dropped
    needs: tuple[Need, ...]


def round_factor(value: float) -> float:
    """Return a factor as the file has it."""
    return float(f"{value:.{DIGITS}g}")


def as_filed(file: VesselFile) -> dict[str, float]:
    """Return the modified set's factors by term, from the file. 0: dropped."""
    factors = file.compensation["modified"]
    kept = {*KEPT, *file.compact.extra_terms}
    return {
        name: factors.get(name, 1.0) if name in kept else 0.0 for name in terms(file, "modified")
    }


def report(
    file: VesselFile,
    factors: Mapping[str, float],
    needs: tuple[Need, ...],
    sensitivity: tuple[Drop, ...],
) -> Reduction:
    """Return all that is to be said about the boat's modified set with these factors."""
    candidate = Candidate(file, "modified")
    candidate.take([factors[name] for name in candidate.terms])
    checked = verdict(file, candidate)
    kept = tuple(
        Kept(name, file.coefficients[name], factor, name in KEPT)
        for name, factor in factors.items()
        if factor
    )
    hull = coefficients(file)
    staying = {one.term for one in kept}
    return Reduction(
        vessel=file.name,
        hull_terms=len(hull),
        report_terms=sum(name in KEPT for name in hull),
        kept=kept,
        dropped=tuple(name for name in hull if name not in staying),
        needs=tuple(need for need in needs if need.term in staying),
        sensitivity=sensitivity,
        checked=checked,
        cost=cost(file),
        passed=passes(checked),
    )


def search(
    file: VesselFile,
    cores: int,
    partial: Path | None,
    step: Callable[[int], None],
    *,
    quick: bool = False,
) -> Found:
    """Return the factors found; ``partial`` is where to keep, and find, an unfinished search.

    A ``quick`` one keeps a term whose loss takes long to make up for.

    If what is found is astray at the boat's top speed, another is searched for, fitted to flights
    there too, on a firmer leash if that will do, each direction's own added mass kept. ``step`` is
    called with the number of terms decided, of up to SEARCHES times those that there are.
    """
    log, fast = Log(file, partial), fastest(file)
    aim = Aim(fit_legs(file), LEASH, CONTROLS, quick)
    standing, modified = _run_search(file, aim, cores, log, step)
    if furthest(file, fast, modified) > ASTRAY:
        aim = Aim((*aim.legs, *fast), FIRM, (*CONTROLS, *ADDED_MASSES), quick)
        standing, modified = _run_search(file, aim, cores, log, step)
    basic = _basic(file, aim, cores, modified, standing.leash)
    return Found({"modified": modified, "basic": basic}, standing.needed)


def _run_search(
    file: VesselFile, aim: Aim, cores: int, log: Log, step: Callable[[int], None]
) -> tuple[Standing, dict[str, float]]:
    """Return how a search ends, and its factors by term."""
    name = f"{len(aim.legs)} flights{', quick' * aim.quick}"
    with Crew(file.path, "modified", aim.legs, cores) as crew:
        at_work = Search(file, "modified", crew, aim)
        standing = log.standing(name) or at_work.begin()
        step(len(at_work.terms) - len(at_work.undecided(standing)))
        while not standing.done:
            standing = at_work.round(standing, lambda: step(1))
            log.enter(name, standing)
    return standing, dict(zip(at_work.terms, map(round_factor, standing.factors), strict=True))


def furthest(file: VesselFile, legs: Sequence[Leg], factors: Mapping[str, float]) -> float:
    """Return the modified set's largest difference in some legs [-].

    It is a multiple of what is allowed.
    """
    candidate = Candidate(file, "modified")
    candidate.take([factors[name] for name in candidate.terms])
    return float(abs(Yardstick(file, legs).differences(candidate)).max(initial=0.0))


def _basic(
    file: VesselFile, aim: Aim, cores: int, modified: Mapping[str, float], leash: float
) -> dict[str, float]:
    """Return the factors of the basic set: those of the modified one, fitted to less."""
    names = terms(file, "basic")
    start = np.array([modified[name] for name in names])
    with Crew(file.path, "basic", aim.legs, cores) as crew:
        free = [i for i, name in enumerate(names) if start[i] and name not in FIXED]
        here = Point(start, crew.differences([start])[0])
        for _ in range(QUICK_ROUNDS if aim.quick else BASIC_ROUNDS):
            table = crew.slopes(here.factors, free, here.differences)
            slopes = Slopes(table, free, leash)
            there = descend(crew.differences, slopes, here, STEPS, LIMIT)
            if there.cost >= here.cost:
                break
            here = there
    return dict(zip(names, map(round_factor, here.factors.tolist()), strict=True))
