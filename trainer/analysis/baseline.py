"""``trainer exercise baseline``: an exercise flown by nobody and by its reference crew.

What they give is kept beside the exercise, with digests of its text and of the core. The standard
deviation over the seeds says how much of a mark is the sea's.
"""

import statistics
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from trainer.analysis.debrief.judgement import judge, plain_marks
from trainer.analysis.debrief.scoring import Scorecard
from trainer.analysis.rehearsal import fly
from trainer.boat.reference_crew import Reaction
from trainer.config.baseline import (
    SCHEMA,
    Baseline,
    Heading,
    Totals,
    baseline_path,
    digest_of,
    write_baseline,
)
from trainer.config.exercise import load_exercise
from trainer.config.files import ConfigError, path_named, read_text
from trainer.config.reference_crew import Crew
from trainer.core.cache import core_digest
from trainer.io.atomic_write import write_whole
from trainer.session.options import RunOptions
from trainer.session.plan import Plan, plan_run


@dataclass(frozen=True)
class Flown:
    """One exercise at one seed: what nobody aboard and the reference crew get."""

    plan: Plan
    nobody_marks: Mapping[str, float]  # [%] p, by the name of the score
    nobody: Scorecard
    crew: Scorecard | None


@dataclass(frozen=True)
class Study:
    """One exercise at some seeds, its own first."""

    path: Path
    seeds: tuple[int, ...]
    flown: tuple[Flown, ...]

    @property
    def own(self) -> Flown:
        """Return what was flown at the exercise's own seed."""
        return self.flown[0]


def fly_at(name: str, seed: int | None = None) -> Flown:
    """Return an exercise flown at a seed, or at its own. ConfigError if it cannot be."""
    return fly_both(planned(name, seed))


def planned(name: str, seed: int | None = None) -> Plan:
    """Return the plan of an exercise at a seed, or at its own. ConfigError if it has no end."""
    options = RunOptions(exercise=name)
    if seed is not None:
        options = RunOptions(exercise=name, seed=seed, given=frozenset({"seed"}))
    plan = plan_run(options)
    if plan.duration is None:
        raise ConfigError(f"{name}: lacks duration_s: what has no end is not flown to it")
    return plan


def fly_both(plan: Plan) -> Flown:
    """Return a plan flown by nobody, and by its reference crew if it has one."""
    alone = fly(plan).trajectory
    marks = plain_marks(alone, plan)
    crew = crew_card(plan, marks, plan.crew) if plan.crew.rules else None
    return Flown(plan, marks, judge(alone, plan, marks), crew)


def crew_card(
    plan: Plan, nobody: Mapping[str, float], crew: Crew, reaction: Reaction | None = None
) -> Scorecard:
    """Return the marks of a crew that follows rules; ``nobody`` has those of nobody aboard."""
    return judge(fly(plan, crew, reaction).trajectory, plan, nobody)


def study(name: str, count: int) -> Study:
    """Return an exercise flown at its own seed and others.

    There are ``count`` where seeds matter.
    """
    own = fly_at(name)
    seeds = [own.plan.seed]
    if varies(name, own.plan):
        others = (seed for seed in range(1, count + 1) if seed != own.plan.seed)
        seeds += list(others)[: count - 1]
    flown = (own, *(fly_at(name, seed) for seed in seeds[1:]))
    return Study(path_named(name, "exercises"), tuple(seeds), flown)


def varies(name: str, plan: Plan) -> bool:
    """Return whether anything depends on the seed: a sea, or what it draws."""
    return plan.sea.path.stem != "calm" or bool(load_exercise(name).drawn)


def baseline_of(found: Study) -> Baseline:
    """Return the baseline to be kept."""
    crews = [each.crew for each in found.flown if each.crew is not None]
    heading = Heading(
        schema=SCHEMA,
        exercise=digest_of(read_text(found.path)),
        core=core_digest(),
        seed=found.seeds[0],
        seeds=len(found.seeds),
    )
    return Baseline(
        heading=heading,
        nobody=totals([each.nobody for each in found.flown]),
        crew=totals(crews) if crews else None,
        marks=found.own.nobody_marks,
    )


def totals(cards: list[Scorecard]) -> Totals:
    """Return the totals over seeds, the exercise's own first; void counts as nothing."""
    found = [card.total or 0.0 for card in cards]
    verdict = cards[0].verdict
    return Totals(
        total=found[0],
        outcome=verdict.outcome if verdict else "-",
        mean=statistics.fmean(found),
        deviation=statistics.stdev(found) if len(found) > 1 else 0.0,
        least=min(found),
    )


def table(found: Study) -> Iterator[str]:
    """Yield the lines that tell a baseline."""
    kept, own = baseline_of(found), found.own
    crew = {each.name: each.marks for each in own.crew.scores} if own.crew else {}
    width = max(len(name) for name in (*own.nobody_marks, "standard deviation"))
    yield f"{'marks at seed ' + str(found.seeds[0]):{width}}  nobody    crew"
    for name, mark in own.nobody_marks.items():
        yield f"{name:{width}}  {mark:6.0f}  {_number(crew.get(name))}"
    rows = ("total", "mean", "deviation", "least")
    called = {"mean": f"mean of {len(found.seeds)} seeds", "deviation": "standard deviation"}
    for row in rows:
        of_crew = getattr(kept.crew, row) if kept.crew else None
        name = called.get(row, row)
        yield f"{name:{width}}  {getattr(kept.nobody, row):6.1f}  {_number(of_crew, 1)}"
    outcome = kept.crew.outcome if kept.crew else "-"
    yield f"{'outcome':{width}}  {kept.nobody.outcome}; crew {outcome}"
    if len(found.seeds) == 1:
        yield "no sea, and nothing is drawn: every seed is the same"


def _number(value: float | None, digits: int = 0) -> str:
    return f"{'-':>6}" if value is None else f"{value:6.{digits}f}"


def keep(found: Study) -> Path:
    """Write the baseline beside its exercise; return where. ConfigError if it cannot be."""
    path = baseline_path(found.path)
    try:
        write_whole(path, write_baseline(baseline_of(found)))
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}") from None
    return path
