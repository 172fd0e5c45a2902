"""The command ``trainer exercise validate`` says whether the marks of an exercise order skill.

Crews of graded skill fly it, each at some seeds, and silly crews do. Marks are worth something
where a better crew has more of them, and a silly one has few: docs/validation.md.
"""

import statistics
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from trainer.authoring.exercise_page import depends_on_seed, plan_exercise
from trainer.authoring.lateness import (
    LATENESS_S,
    MAX_URGENT_MARKS,
    STEEP_FALL,
    URGENT_LATE_S,
    Ladder,
    fly_ladders,
    is_urgent,
)
from trainer.authoring.trainees import (
    ALL_CREWS,
    GRADED_CREWS,
    LATE_CREWS,
    SILLY_POLICIES,
    SillyPolicy,
    Skill,
    Trainee,
    silly_orders,
)
from trainer.config.exercise.baseline import digest_of
from trainer.config.files import ConfigError, path_named, read_text
from trainer.core.digest import core_digest
from trainer.debrief.attainable.explorer import orders_beside_crew
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.rehearsal import Departure, Rehearsal, fly, fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.recording.recording import RecordedOrder
from trainer.report import html, text
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import Curve, Panel
from trainer.session.past.plan import Plan
from trainer.workers import map_tasks

MARK_DECIMALS: Final = 6  # of marks [%] that are ranked: a difference in the last bits is a tie
LEAST_CORRELATION: Final = 0.9  # [-] of marks with skill
MAX_SILLY_MARKS: Final = 40.0  # [%]
LEAST_REFERENCE_MARKS: Final = 97.0  # [%] at the exercise's own seed
SILLY_SEEDS: Final = 3  # at most; a silly crew draws nothing itself
SILLY_ROWS: Final = 5  # of the silly crews with most marks, in the text
POINT_SPREAD: Final = 0.3  # [grades] over which the runs of one grade are drawn
CREW_HEADS: Final = ("crew", "mean", "spread", "least", "most")
SUMMARY_HEADS: Final = (
    "exercise",
    "rank\ncorrelation",
    "lateness\nalone",
    "swapped",
    "most\nsilly",
    "",
)
RULE_TEXT: Final = (
    f"Marks order skill where Spearman's rank correlation of marks with grade is "
    f"{LEAST_CORRELATION:g} at least, no silly crew has more than {MAX_SILLY_MARKS:g}, nobody "
    f"aboard has 0, and the reference crew has {LEAST_REFERENCE_MARKS:g} at the exercise's own "
    f"seed. Where a hole or a jam is open, a crew {URGENT_LATE_S:g} s late has "
    f"{MAX_URGENT_MARKS:g} at most. The grades are late by 0, 5, 15, 30 and 60 s, and worse in all "
    "else; crews with one fault alone are told beside them and decide nothing, as are falls of "
    f"more than {STEEP_FALL:g} marks for 5 s."
)


@dataclass(frozen=True)
class SeedTrial:
    """The marks [%] of all crews at one seed; 0 where a run is void."""

    exercise: str
    seed: int
    skilled: Mapping[str, float]  # by the crew's name
    silly: Mapping[str, float]
    ladders: tuple[Ladder, ...] = ()  # of lateness, only at the exercise's own seed
    urgent: bool = False  # a hole or a jam is in it


@dataclass(frozen=True)
class Validation:
    """The marks of one exercise, by crew, and what they are worth."""

    exercise: str
    seeds: tuple[int, ...]  # its own first
    skilled: Mapping[str, tuple[float, ...]]  # [%] by the crew's name, for each seed
    silly: Mapping[str, float]  # [%] the most over the seeds flown
    correlation: float  # [-] of marks with skill, over the grades
    late_correlation: float  # [-] the same, of crews that are only late
    swapped: float  # [-] share of pairs of neighbouring grades in which the worse has more
    digest: str  # of the exercise's text
    ladders: tuple[Ladder, ...] = ()  # of lateness
    urgent: bool = False  # a hole or a jam is in it

    @property
    def best_silly(self) -> str:
        """Return the silly crew with the most marks."""
        return max(self.silly, key=lambda name: self.silly[name])

    @property
    def faults(self) -> tuple[str, ...]:
        """Return what is wrong with the marks, nothing if they order skill."""
        reference = self.skilled[GRADED_CREWS[0].name][0]
        nobody, silly = self.silly[SILLY_POLICIES[0].name], self.silly[self.best_silly]
        faults, best = [], self.best_silly
        if self.correlation < LEAST_CORRELATION:
            faults.append(f"rank correlation {self.correlation:.2f}, not {LEAST_CORRELATION:g}")
        if silly > MAX_SILLY_MARKS:
            faults.append(f"{best} has {silly:.0f} marks, not {MAX_SILLY_MARKS:g} at most")
        if nobody > 0.0:
            faults.append(f"nobody aboard has {nobody:.0f} marks, not 0")
        if reference < LEAST_REFERENCE_MARKS:
            few = f"{reference:.0f} marks, not {LEAST_REFERENCE_MARKS:g}"
            faults.append(f"the reference crew has {few}")
        for ladder in self.ladders if self.urgent else ():
            if (marks := ladder.at(URGENT_LATE_S)) > MAX_URGENT_MARKS:
                left = f"{marks:.0f} marks are left, not {MAX_URGENT_MARKS:g} at most"
                faults.append(f"{ladder.kind} by {URGENT_LATE_S} s, {left}")
        return tuple(faults)


def rank_correlation(first: Sequence[float], second: Sequence[float]) -> float:
    """Return Spearman's rank correlation of two rows; equal values share their mean rank.

    It is 0 where a row is all equal, because then nothing is ordered.
    """
    ranks = np.array([_ranks(np.asarray(row, float)) for row in (first, second)])
    off = ranks - ranks.mean(axis=1, keepdims=True)
    scale = float(np.sqrt(np.prod((off**2).sum(axis=1))))
    return float((off[0] * off[1]).sum()) / scale if scale else 0.0


def _ranks(values: np.ndarray) -> np.ndarray:
    """Return the rank of each value, from 0; of equal ones the mean of theirs."""
    below = (values[:, None] > values).sum(axis=1)
    alike = (values[:, None] == values).sum(axis=1)
    return np.asarray(below + 0.5 * (alike - 1))


def swapped_share(rows: Sequence[Sequence[float]]) -> float:
    """Return in what share of pairs of neighbouring rows, best first, the worse has more."""
    pairs = [worse > better for one, next_ in pairwise(rows) for better in one for worse in next_]
    return statistics.fmean(pairs) if pairs else 0.0


def validate_exercises(
    names: Sequence[str], count: int, cores: int, progress: Callable[[int], object]
) -> Iterator[Validation]:
    """Yield the validation of each exercise, flown at ``count`` seeds.

    ConfigError before the first flight if one cannot be validated.
    """
    tasks = [task for name in names for task in trial_seeds(name, count)]
    trials: dict[str, list[SeedTrial]] = defaultdict(list)
    for trial in map_tasks(fly_trial, tasks, cores):
        progress(1)
        trials[trial.exercise].append(trial)
        if len(trials[trial.exercise]) == count:
            yield validation_of(trials.pop(trial.exercise))


def trial_seeds(name: str, count: int) -> list[tuple[str, int, bool]]:
    """Return the exercise with its own seed and others, and whether silly crews fly there.

    ConfigError if it has no end, no reference crew or no marks.
    """
    plan = plan_exercise(name)
    if not plan.crew.rules:
        raise ConfigError(f"{name}: lacks a reference crew, [[crew]]: there is no skill to grade")
    if not plan.scores:
        raise ConfigError(f"{name}: lacks [[scores]]: there are no marks to validate")
    seeds = [plan.seed, *(seed for seed in range(1, count + 1) if seed != plan.seed)][:count]
    silly = SILLY_SEEDS if depends_on_seed(name, plan) else 1
    return [(name, seed, i < silly) for i, seed in enumerate(seeds)]


def fly_trial(name: str, seed: int, with_silly: bool) -> SeedTrial:  # noqa: FBT001 (of a task)
    """Return the marks of all crews at one seed."""
    own, plan = plan_exercise(name), plan_exercise(name, seed)
    alone = fly_rehearsal(plan)
    nobody = plain_marks(alone.trajectory, plan)

    def judge(flight: Rehearsal) -> Scorecard:
        return judge_run(flight.trajectory, plan, nobody)

    def marks(flight: Rehearsal) -> float:
        return round(judge(flight).total or 0.0, MARK_DECIMALS)

    skilled = {crew.name: marks(fly_skilled(plan, crew, seed)) for crew in ALL_CREWS}
    policies = SILLY_POLICIES if with_silly else ()
    silly = {each.name: marks(fly_silly(plan, each, alone)) for each in policies}
    ladders = fly_ladders(plan, judge) if seed == own.seed else ()
    return SeedTrial(name, seed, skilled, silly, ladders, is_urgent(own))


def fly_skilled(plan: Plan, skill: Skill, seed: int) -> Rehearsal:
    """Return an exercise flown by its reference crew with the faults of a skill."""
    return fly_rehearsal(plan, plan.crew, skill.reaction(seed), partial(Trainee, skill))


def fly_silly(plan: Plan, policy: SillyPolicy, alone: Rehearsal) -> Rehearsal:
    """Return an exercise flown by a silly crew. ``alone`` is it with nobody aboard."""
    boat = plan.launch_boat()
    beside = orders_beside_crew(alone.trajectory, plan)
    orders = {tick: list(given) for tick, given in beside.items()}
    for seconds, order in silly_orders(policy, plan):
        tick = round(seconds / plan.method.step)
        entry = RecordedOrder(0, 1, tick, REFERENCE_GIVER, order.text, None, None, "")
        orders.setdefault(tick, []).append(entry)
    return fly(plan, Departure(0, boat.records.state.copy()), orders)[0]


def validation_of(trials: Sequence[SeedTrial]) -> Validation:
    """Return what the trials of one exercise say, its own seed's first."""
    skilled = {name: tuple(each.skilled[name] for each in trials) for name in trials[0].skilled}
    name = trials[0].exercise
    return Validation(
        exercise=name,
        seeds=tuple(each.seed for each in trials),
        skilled=skilled,
        silly={
            policy.name: max(each.silly[policy.name] for each in trials if each.silly)
            for policy in SILLY_POLICIES
        },
        correlation=_order(skilled, GRADED_CREWS),
        late_correlation=_order(skilled, (GRADED_CREWS[0], *LATE_CREWS)),
        swapped=swapped_share([skilled[grade.name] for grade in GRADED_CREWS]),
        digest=digest_of(read_text(path_named(name, "exercises"))),
        ladders=trials[0].ladders,
        urgent=trials[0].urgent,
    )


def _order(skilled: Mapping[str, Sequence[float]], crews: Sequence[Skill]) -> float:
    """Return the rank correlation of marks with skill, of crews from the best to the worst."""
    pairs = [(-i, mark) for i, crew in enumerate(crews) for mark in skilled[crew.name]]
    skills, marks = zip(*pairs, strict=True)
    return rank_correlation(skills, marks)


def validation_data(found: Sequence[Validation]) -> dict[str, Any]:
    """Return validations as figures for JSON."""
    rows = [
        {
            **{key: value for key, value in vars(each).items() if key != "digest"},
            "ladders": [{"late_s": LATENESS_S, **ladder._asdict()} for ladder in each.ladders],
            "exercise_digest": each.digest,
            "best_silly": each.best_silly,
            "faults": each.faults,
        }
        for each in found
    ]
    return {"core": core_digest(), "exercises": rows}


def exercise_text(found: Validation) -> str:
    """Return the marks of one exercise by crew, and the verdict, for a terminal."""
    seeds = f"{len(found.seeds)} seed{'s' * (len(found.seeds) > 1)}"
    return "\n".join(
        [
            f"{found.exercise}, {seeds}, text {found.digest[:12]}",
            *text.table(CREW_HEADS, _crew_rows(found, ALL_CREWS)),
            "",
            *text.table(("silly crew", "marks"), _silly_rows(found)[:SILLY_ROWS]),
            "",
            *text.wrap(_figures(found)),
            *(line for said in _lateness(found) for line in text.wrap(said)),
            *text.wrap(_verdict(found)),
            "",
        ]
    )


def summary_text(found: Sequence[Validation]) -> str:
    """Return a row for each exercise, and what the verdict means, for a terminal."""
    table = text.table(SUMMARY_HEADS, map(_summary_row, found), "")
    return "\n".join([*table, "", *text.wrap(RULE_TEXT, "", ""), "", _conclusion(found)])


def _crew_rows(found: Validation, crews: Sequence[Skill]) -> Iterator[tuple[str, ...]]:
    for crew in crews:
        marks = found.skilled[crew.name]
        figures = (statistics.fmean(marks), statistics.pstdev(marks), min(marks), max(marks))
        yield (crew.name, *(f"{figure:.1f}" for figure in figures))


def _silly_rows(found: Validation) -> list[tuple[str, str]]:
    """Return the silly crews, that with most marks first."""
    most_first = sorted(found.silly.items(), key=lambda item: -item[1])
    return [(name, f"{mark:.1f}") for name, mark in most_first]


def _figures(found: Validation) -> str:
    return (
        f"rank correlation {found.correlation:.2f}, of lateness alone "
        f"{found.late_correlation:.2f}; swapped neighbours {100.0 * found.swapped:.0f} %"
    )


def _lateness(found: Validation) -> Iterator[str]:
    """Yield the marks of each ladder, and its steep falls and its rises."""
    for ladder in found.ladders:
        marks = " ".join(f"{each:.0f}" for each in ladder.marks)
        yield f"{ladder.kind}, by {LATENESS_S[0]} to {LATENESS_S[-1]} s: {marks}"
    for ladder in found.ladders:
        yield from (f"steep: {each}" for each in ladder.falls)
        yield from (f"more for later: {each}" for each in ladder.rises)


def _verdict(found: Validation) -> str:
    return f"FAILS: {'; '.join(found.faults)}" if found.faults else "the marks order skill"


def _summary_row(found: Validation) -> tuple[str, ...]:
    best = found.best_silly
    return (
        found.exercise,
        f"{found.correlation:.2f}",
        f"{found.late_correlation:.2f}",
        f"{100.0 * found.swapped:.0f} %",
        f"{found.silly[best]:.0f}",
        "FAILS" if found.faults else "",
    )


def _conclusion(found: Sequence[Validation]) -> str:
    failed = sum(bool(each.faults) for each in found)
    of = f"{len(found)} exercise{'s' * (len(found) > 1)}"
    return f"{failed} of {of} FAIL." if failed else f"The marks order skill in {of}."


def validation_page(
    found: Sequence[Validation], data: Mapping[str, Any], people: Sequence[Markup] = ()
) -> str:
    """Return the page of HTML, with chapters about model people if there are any."""
    failed = any(each.faults for each in found)
    return html.fill_page(
        "validation.html",
        "guide.css",
        verdict=html.Cell(_conclusion(found), "bad" if failed else "good"),
        contents=[*("people" for _ in people), *(each.exercise for each in found)],
        parts=[_overview(found), *people, *map(_exercise_section, found)],
        data=html.embed_json(data),
    )


def _overview(found: Sequence[Validation]) -> Markup:
    """Return the chapter with a row for each exercise."""
    figures = ("rank correlation", "lateness alone", "swapped", "most silly", "verdict")
    heads = ("exercise", *(grade.name for grade in GRADED_CREWS), *figures)
    rows: list[tuple[str | html.Cell, ...]] = []
    for each in found:
        _, correlation, late, swapped, silly, _ = _summary_row(each)
        means = [f"{statistics.fmean(each.skilled[grade.name]):.0f}" for grade in GRADED_CREWS]
        verdict = html.Cell("fails", "bad") if each.faults else html.Cell("orders skill", "good")
        best = f"{each.best_silly}, {silly}"
        rows.append((each.exercise, *means, correlation, late, swapped, best, verdict))
    core = f"Flown with the core {core_digest()}. Marks are means over the seeds."
    return html.section(
        "overview",
        "All exercises",
        html.table(heads, rows),
        *map(html.paragraph, (RULE_TEXT, core)),
    )


def _exercise_section(found: Validation) -> Markup:
    """Return the chapter of one exercise: a chart, its crews, its silly crews."""
    panels = _panels(found)
    return html.section(
        found.exercise,
        found.exercise,
        html.paragraph(_verdict(found), "bad" if found.faults else "good"),
        *map(html.paragraph, (_figures(found), *_lateness(found))),
        html.charts(map(draw_panel, panels)),
        legend(panels[0].curves),
        html.table(CREW_HEADS, _crew_rows(found, ALL_CREWS), "narrow"),
        html.table(("silly crew", "marks"), _silly_rows(found), "narrow"),
        html.paragraph(f"Seeds {', '.join(map(str, found.seeds))}; text {found.digest}.", "soft"),
    )


def _panels(found: Validation) -> tuple[Panel, Panel]:
    """Return the marks against the grade, and against the delay where that is the only fault."""
    grades = np.arange(float(len(GRADED_CREWS)))
    runs = np.array([found.skilled[grade.name] for grade in GRADED_CREWS])
    spread = np.linspace(-0.5, 0.5, runs.shape[1]) * POINT_SPREAD
    silly = np.array([*found.silly.values()])
    beside = np.full(silly.size, len(GRADED_CREWS))
    graded = (
        Curve("a run", (grades[:, None] + spread).ravel(), runs.ravel(), points=True),
        Curve("the mean", grades, runs.mean(axis=1)),
        Curve("a silly crew, beside the grades", beside, silly, points=True),
    )
    crews = (GRADED_CREWS[0], *LATE_CREWS)
    delays = np.array([crew.late_s for crew in crews])
    late = np.array([found.skilled[crew.name] for crew in crews])
    alone = (
        Curve("a run", np.repeat(delays, late.shape[1]), late.ravel(), points=True),
        Curve("the mean", delays, late.mean(axis=1)),
        *(Curve(each.kind, np.array(LATENESS_S), np.array(each.marks)) for each in found.ladders),
    )
    levels = (0.0, MAX_SILLY_MARKS, 100.0)
    return (
        Panel(found.exercise, "grade, 0 is the reference crew", "marks [%]", graded, levels=levels),
        Panel(found.exercise, "delay [s], the only fault", "marks [%]", alone, levels=levels),
    )
