"""The commands ``trainer exercise new``, ``check_exercise`` and ``baseline``.

A check flies the exercise with nobody aboard and with its reference crew, and prints what a run
would refuse. A baseline is kept beside the exercise, with digests of its text and of the core,
because it holds for these alone. Its standard deviation over the seeds says how much of a mark the
sea makes.
"""

import json
import re
import statistics
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Final

import click

from trainer.authoring.stated import fly_stated, step_problems
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.exercise.baseline import (
    BASELINE_SCHEMA,
    Baseline,
    BaselineHeading,
    Totals,
    baseline_path,
    digest_of,
    write_baseline,
)
from trainer.config.exercise.exercise import load_exercise, parse_exercise
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.score_rules import ScoreRule
from trainer.config.files import (
    ConfigError,
    Position,
    as_typed,
    collecting,
    is_path,
    number_problems,
    parse_toml,
    path_named,
    quote,
    raise_problems,
    read_text,
    relative_name,
    renew_file,
    shipped_path,
    write_once,
)
from trainer.core.digest import core_digest
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.mark_numbers import MAX_NOBODY_PERCENT
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard, formula_of
from trainer.debrief.marks.tally_sheet import forbids_numbers
from trainer.debrief.passage.trajectory import missing_quantities
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.units import KNOT

SKELETON_NAME: Final = "exercise-skeleton"
TABLE_COMMENTS: Final = {
    "[initial]": "Where the boat starts; what is left out is the vessel file's.",
    "[sea]": "As in docs/seas.md; without it a calm.",
    "[[orders]]": "What is ordered, as it is typed: `order ...` and `tell ...` go to the crew.",
    "[[casualties]]": "What breaks: names by `trainer casualties`. within_s: later, by the seed.",
    "[limits]": "The gate: what must not be passed.",
    "[[scores]]": "How the crew is judged: measures in docs/measures.md; full marks at full.",
    "[[crew]]": "What the reference crew does: at_s, when, ordered, then; docs/exercise-files.md.",
    "[planesman]": "How it works the planes; all keys in docs/exercise-keys.md.",
    "[helmsman]": "How it steers.",
}
NAME_LINE: Final = re.compile(r'^name = "[^"]*"', re.MULTILINE)


@dataclass(frozen=True)
class FlownExercise:
    """One exercise at one seed, flown by nobody aboard and by the reference crew."""

    plan: Plan
    nobody_marks: Mapping[str, float]  # [%] p, by the name of the score
    nobody: Scorecard
    crew: Scorecard | None
    flights: Mapping[str, Rehearsal] = field(default_factory=dict)  # of "nobody" and "crew"


@dataclass(frozen=True)
class ExerciseStudy:
    """One exercise at some seeds, its own first."""

    path: Path
    seeds: tuple[int, ...]
    flown: tuple[FlownExercise, ...]


def fly_at(name: str, seed: int | None = None) -> FlownExercise:
    """Return an exercise flown at a seed, or at its own. ConfigError if it cannot be."""
    return fly_both(plan_exercise(name, seed))


def plan_exercise(name: str, seed: int | None = None) -> Plan:
    """Return the plan of an exercise at a seed, or at its own. ConfigError if it has no end."""
    options = RunOptions(exercise=name)
    if seed is not None:
        options = RunOptions(exercise=name, seed=seed, given=frozenset({"seed"}))
    plan = plan_run(options)
    if plan.duration is None:
        raise ConfigError(f"{name}: lacks duration_s: what has no end is not flown to it")
    return plan


def fly_both(plan: Plan) -> FlownExercise:
    """Return a plan flown by nobody, and by its reference crew if it has one."""
    flights = {"nobody": fly_rehearsal(plan)}
    if plan.crew.rules:
        flights["crew"] = fly_rehearsal(plan, plan.crew)
    marks = plain_marks(flights["nobody"].trajectory, plan)
    cards = {name: judge_run(flight.trajectory, plan, marks) for name, flight in flights.items()}
    return FlownExercise(plan, marks, cards["nobody"], cards.get("crew"), flights)


def study_exercise(name: str, count: int) -> ExerciseStudy:
    """Return an exercise flown at its own seed and others.

    There are ``count`` seeds where the exercise depends on the seed, else one.
    """
    own_run = replace(fly_at(name), flights={})
    seeds = [own_run.plan.seed]
    if depends_on_seed(name, own_run.plan):
        others = (seed for seed in range(1, count + 1) if seed != own_run.plan.seed)
        seeds += list(others)[: count - 1]
    flown = (own_run, *(replace(fly_at(name, seed), flights={}) for seed in seeds[1:]))
    return ExerciseStudy(path_named(name, "exercises"), tuple(seeds), flown)


def depends_on_seed(name: str, plan: Plan) -> bool:
    """Return whether a flight depends on the seed: by a sea, or by drawn numbers."""
    return plan.sea.path.stem != "calm" or bool(load_exercise(name).drawn)


def baseline_of(found: ExerciseStudy) -> Baseline:
    """Return the baseline to be kept."""
    crews = [each.crew for each in found.flown if each.crew is not None]
    heading = BaselineHeading(
        schema=BASELINE_SCHEMA,
        exercise=digest_of(read_text(found.path)),
        core=core_digest(),
        seed=found.seeds[0],
        seeds=len(found.seeds),
    )
    kept = found.flown[0].plan.baseline
    return Baseline(
        heading=heading,
        people=kept.people if kept and kept.heading.exercise == heading.exercise else None,
        nobody=totals([each.nobody for each in found.flown]),
        crew=totals(crews) if crews else None,
        marks=found.flown[0].nobody_marks,
    )


def totals(cards: list[Scorecard]) -> Totals:
    """Return the totals over seeds, the exercise's own first; a void run counts as 0."""
    marks = [card.total or 0.0 for card in cards]
    verdict = cards[0].verdict
    return Totals(
        total=marks[0],
        outcome=verdict.outcome if verdict else "-",
        mean=statistics.fmean(marks),
        deviation=statistics.stdev(marks) if len(marks) > 1 else 0.0,
        least=min(marks),
    )


def baseline_lines(found: ExerciseStudy) -> Iterator[str]:
    """Yield a baseline as lines of text."""
    baseline, own_run = baseline_of(found), found.flown[0]
    crew = {each.name: each.marks for each in own_run.crew.scores} if own_run.crew else {}
    width = max(len(name) for name in (*own_run.nobody_marks, "standard deviation"))
    yield f"{'marks at seed ' + str(found.seeds[0]):{width}}  nobody    crew"
    for name, mark in own_run.nobody_marks.items():
        yield f"{name:{width}}  {mark:6.0f}  {_number(crew.get(name))}"
    mean = f"mean of {len(found.seeds)} seed{'s' * (len(found.seeds) > 1)}"
    rows = {"total": "total", "mean": mean, "deviation": "standard deviation", "least": "least"}
    for row, name in rows.items():
        of_crew = getattr(baseline.crew, row) if baseline.crew else None
        yield f"{name:{width}}  {getattr(baseline.nobody, row):6.1f}  {_number(of_crew, 1)}"
    outcome = baseline.crew.outcome if baseline.crew else "-"
    yield f"{'outcome':{width}}  {baseline.nobody.outcome}; crew {outcome}"
    if len(found.seeds) == 1:
        yield "no sea, and nothing is drawn: every seed is the same"


def _number(value: float | None, digits: int = 0) -> str:
    return f"{'-':>6}" if value is None else f"{value:6.{digits}f}"


def save_baseline(found: ExerciseStudy) -> Path:
    """Write the baseline beside its exercise; return where. ConfigError if it cannot be."""
    path = baseline_path(found.path)
    renew_file(path, write_baseline(baseline_of(found)))
    return path


def write_new(path: Path, name: str | None, source: str | None) -> None:
    """Write a valid exercise to begin with, or a shipped one with comments.

    ConfigError if the file is there or cannot be made, or no exercise has that name.
    """
    text = _copy(source) if source else read_text(shipped_path("", SKELETON_NAME))
    if name is not None:
        line = f"name = {json.dumps(name, ensure_ascii=False)}"
        text = NAME_LINE.sub(lambda _: line, text, count=1)
    parse_exercise(text, path)
    write_once(path, text)
    click.echo(f"{path} written; next: trainer exercise check {as_typed(path)}")


def _copy(source: str) -> str:
    """Return the text of a shipped exercise, with what each part is for above it."""
    text = read_text(shipped_path("exercises", source))
    lines = [f"# Copied from {source}. Try it with: trainer exercise check FILE"]
    copied_heads: set[str] = set()
    for line in text.splitlines():
        if line.startswith("lesson = "):  # its place among the shipped ones
            continue
        head = line.split("#")[0].strip()
        if head in TABLE_COMMENTS and head not in copied_heads:
            copied_heads.add(head)
            lines.append(f"# {TABLE_COMMENTS[head]}")
        lines.append(line)
    return "\n".join(lines) + "\n"


def check_exercise(name: str) -> list[str]:
    """Return what an exercise is, a line each. ConfigError with all that is wrong in it."""
    problems: list[str] = []
    with collecting(problems):
        plan = plan_run(RunOptions(exercise=name))
    if problems:
        with collecting(problems):  # a boat that cannot be read, too
            path = path_named(name, "exercises")
            vessel = parse_toml(read_text(path), path.name).get("vessel")
            if isinstance(vessel, str) and is_path(vessel):  # a name is told with its line
                load_vessel(relative_name(path, vessel))
        raise ConfigError(*dict.fromkeys(problems))
    boat = plan.launch_boat()
    checked = None if plan.duration is None else fly_both(plan)
    path = path_named(name, "exercises")
    position = Position(path.name, "")
    problems = [*step_problems(plan, position)]
    raise_problems(number_problems(problems, read_text(path), path.name))
    if checked is not None:
        problems = [*_refused(checked, position), *_lost_at_start(checked, position)]
        for i, figure in enumerate(fly_stated(plan, load_exercise(name).stated, checked.flights)):
            if not figure.holds:
                said = figure.stated.row.says
                problems.append(
                    position.inside(f"stated[{i}]").wrong("says", said, figure.difference)
                )
        raise_problems(number_problems(problems, read_text(path), path.name))
    return [f"{word:8}{text}" for word, text in _lines(plan, boat, checked)]


def _refused(checked: FlownExercise, position: Position) -> Iterator[str]:
    """Yield the orders that a run would refuse, and the reasons why marks would be worthless."""
    plan = checked.plan
    for each in checked.flights["nobody"].refused:
        entry = plan.schedule[each.entry or 0]
        if not entry.line_number:
            problem = f"begins with {quote(each.text)}, and a run refuses that: {each.answer}"
            yield position.wrong("hand", [*plan.hand], problem)
            continue
        broken = entry.order.name in ("casualty", "clear")
        inside = position.inside(f"{'casualties' if broken else 'orders'}[{entry.line_number - 1}]")
        key = "name" if broken else "order"
        yield inside.wrong(
            key, entry.order.subject or each.text, f"a run refuses it: {each.answer}"
        )
    crew = checked.flights["crew"].refused if checked.crew else ()
    refused = {each.text: each.answer for each in crew if each.giver == REFERENCE_GIVER}
    for i, reaction in enumerate(plan.crew.rules):
        if reaction.order.text in refused:
            problem = f"the boat refuses it: {refused[reaction.order.text]}"
            yield position.inside(f"crew[{i}]").wrong("order", reaction.row.order, problem)
    if not plan.judged_by_tasks:
        return
    for i, rule in enumerate(plan.scores):
        free = checked.nobody_marks.get(rule.score.name, 0.0)
        if not _kept(rule) and free > MAX_NOBODY_PERCENT:
            marks = f"gives {free:.0f} marks with nobody aboard, {MAX_NOBODY_PERCENT:.0f} at most"
            problem = f'{marks}: let it earn less without a crew, or write part = "keeping"'
            yield position.inside(f"scores[{i}]").wrong("name", rule.score.name, problem)
    if plan.scores and all(each.earned is None for each in checked.nobody.scores):
        yield position.problem("[[scores]]: this exercise is won by standing still")


def _lost_at_start(checked: FlownExercise, position: Position) -> Iterator[str]:
    """Yield the conditions that nobody can keep from losing the exercise."""
    begun = checked.flights["nobody"].trajectory
    for loss in checked.plan.lost:
        if not loss.seconds and all(begun.holds(each)[0] for each in loss.conditions):
            yield position.wrong("lost", [loss.text], "it is lost at its start, whoever is aboard")


def _lines(plan: Plan, boat: Boat, checked: FlownExercise | None) -> Iterator[tuple[str, str]]:
    """Yield what an exercise is, a word and a text each."""
    s, method = boat.state, plan.method
    yield "name", plan.title
    yield "boat", f"{boat.file.name}; {method.equations} set, step {method.step:g} s"
    yield "start", f"{s.u / KNOT:.3g} kn, {s.z:g} m; sea: {plan.sea.name}"
    yield "lasts", "until quit" if plan.duration is None else f"{plan.duration:g} s"
    if plan.hand:
        since = f" from {plan.hand_from:g} s" if plan.hand_from else ""
        yield "hand", f"{', '.join(plan.hand)}{since}"
    if plan.allowed:
        yield "allowed", ", ".join(plan.allowed)
    yield from (("at", f"{entry.seconds:g} s: {entry.order.text}") for entry in plan.schedule)
    yield from (("when", f"{each.condition.text}: {each.casualty.name}") for each in plan.armed)
    for item in fields(plan.limits):
        if (limit := getattr(plan.limits, item.name)) is not None:
            yield "limit", f"{item.name} {limit:g}"
    yield from (("lost", loss.text) for loss in plan.lost)
    yield from (("step", each.row.text) for each in plan.steps)
    yield from (("score", text) for text in _scores(plan))
    if checked is not None and plan.judged_by_tasks:
        yield from _marks(checked)
    if plan.judged_by_tasks and (refused := forbids_numbers(plan)):
        yield "numbers", f"none, so that programs that learn cannot fly it: {refused.reason}"
    yield from (("note", text) for text in _notes(plan, boat))


def _marks(checked: FlownExercise) -> Iterator[tuple[str, str]]:
    """Yield the marks of nobody aboard and of the reference crew."""
    plan = checked.plan
    for word, card in (("nobody", checked.nobody), ("crew", checked.crew)):
        if card is None:
            yield "note", "there is no reference crew: nothing to lay under a crew's own run"
            continue
        total = "void" if card.total is None else f"{card.total:.0f} marks"
        why = f": {card.verdict.reason}" if card.verdict and card.verdict.reason else ""
        yield word, f"{total}, {card.verdict.outcome if card.verdict else '-'}{why}"
    if checked.crew is not None:
        verdict = checked.crew.verdict
        if verdict and verdict.outcome != Outcome.WON:
            yield "note", "the reference crew does not win; a debrief draws what it does"
        given = checked.flights["crew"].rules_given
        for i, rule in enumerate(plan.crew.rules):
            if i not in given:
                yield "note", f"crew[{i}] {rule.row.order}: was not to be given at this seed"


def _scores(plan: Plan) -> Iterator[str]:
    by_tasks = plan.judged_by_tasks
    for rule in plan.scores:
        of = [other for other in plan.scores if not by_tasks or _kept(other) == _kept(rule)]
        share = 100.0 * rule.weight / sum(each.weight for each in of)
        part = f" of {'keeping' if _kept(rule) else 'tasks'}" if by_tasks else ""
        yield f"{share:.0f} %{part} {rule.score.name}: {formula_of(rule)}"


def _kept(rule: ScoreRule) -> bool:
    return rule.part == "keeping"


def _notes(plan: Plan, boat: Boat) -> Iterator[str]:
    """Yield warnings: what is allowed but may be a mistake."""
    end = plan.duration
    broken = {entry.order.subject for entry in plan.schedule if entry.order.name == "casualty"}
    broken |= {each.casualty.name for each in plan.armed}
    broken |= {part.name for name in broken for part in plan.casualties[name].broken}
    if not plan.scores:
        yield "nothing is scored: trainer debrief will give no marks"
    for rule in plan.scores:
        if end is not None and (rule.score.from_s or 0.0) > end:
            yield f"score {rule.score.name}: begins after the end"
        waits = {rule.score.casualty, rule.score.since}
        for name in sorted(plan.casualties.keys() & (waits - broken)):
            yield f"score {rule.score.name}: nothing here breaks {name}: it counts if you do"
        for name in missing_quantities(boat, rule):
            yield f"score {rule.score.name}: this boat has no {name}; it will not count"
    for entry in plan.schedule:
        if end is not None and entry.seconds >= end:
            yield f"{entry.order.text}: comes when the exercise is over"
