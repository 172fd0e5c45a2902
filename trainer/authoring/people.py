"""``trainer exercise validate --people``: whether marks tell better persons from worse.

Model operators of five skills fly each exercise twice. From that come how well marks order them, by
exercise and by course, how much one person's mark changes from run to run, and whether exercises
ask for one skill. The operators are a model: docs/validation.md says what that leaves open.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final
from zlib import crc32

import numpy as np
from markupsafe import Markup

from trainer.authoring.exercise_page import plan_exercise
from trainer.authoring.operators import fly_person, person_of
from trainer.authoring.validation import MARK_DECIMALS, Validation, rank_correlation, trial_seeds
from trainer.config.exercise.baseline import (
    Baseline,
    PeopleFigures,
    baseline_path,
    kept_baseline,
    write_baseline,
)
from trainer.config.exercise.course import course
from trainer.config.files import ConfigError, path_named, read_text, renew_file
from trainer.core.digest import core_digest
from trainer.core.kernel import Numbers
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.report import html, text
from trainer.report.panels import draw_panel
from trainer.report.plots import Curve, Panel
from trainer.workers import map_tasks

SKILLS: Final = np.repeat((0.2, 0.4, 0.6, 0.8, 1.0), 8)  # [-] of the persons; estimates
SITTINGS: Final = 2  # runs of a person in an exercise: at its own seed, and at another
COURSE_SIZE: Final = 6  # exercises of a course
DRAWN_COURSES: Final = 200
LEAST_EXERCISE_ORDER: Final = 0.85  # [-] of rank correlation, and of pairs
LEAST_COURSE_ORDER: Final = 0.95  # [-] the same
LEAST_ALPHA: Final = 0.8  # [-]
CEILING_MARKS: Final = 95.0  # [%] with which one run is hardly told from a better one
MAX_CEILING: Final = 0.5  # [-] of runs
MAX_ERROR: Final = 20.0  # [%] with which two runs differ for sure only by more than half the marks
PEOPLE_HEADS: Final = (
    *("exercise", "\nmean", "95 or\nmore", "\ngrades", "\npeople", "better\nmore"),
    *("\nerror", "item\nrest"),
)
HEADS_TEXT: Final = (
    f"People: model operators, {len(SKILLS)} persons of five skills, each flying twice; easiest "
    "exercise first. Grades and people: rank correlation of marks with skill. Better more: of a "
    "better and a worse, how often the better has more. Error: standard error of a mark, by test "
    "and retest. Item rest: correlation of an exercise with the others' mean."
)


def fly_people(
    names: Sequence[str], cores: int, progress: Callable[[int], object]
) -> dict[str, Numbers]:
    """Return the marks [%] of all persons in each exercise, [sitting, person].

    ConfigError before the first flight if one cannot be validated.
    """
    tasks = [
        (name, seed, sitting)
        for name in names
        for sitting, (_, seed, _) in enumerate(trial_seeds(name, SITTINGS))
    ]
    rows: dict[str, list[list[float]]] = defaultdict(list)
    for (name, *_), marks in zip(tasks, map_tasks(fly_sitting, tasks, cores), strict=True):
        rows[name].append(marks)
        progress(1)
    return {name: np.array(each) for name, each in rows.items()}


def fly_sitting(name: str, seed: int, sitting: int) -> list[float]:
    """Return the marks [%] of all persons in one sitting; 0 of a void run."""
    plan, stem = plan_exercise(name, seed), path_named(name, "exercises").stem
    nobody = plain_marks(fly_rehearsal(plan).trajectory, plan)
    marks = []
    for number, skill in enumerate(SKILLS.tolist()):
        chance = crc32(f"{stem} {sitting} {number}".encode())
        flight = fly_person(plan, person_of(number, skill), chance)
        marks.append(judge_run(flight.trajectory, plan, nobody).total or 0.0)
    return [round(each, MARK_DECIMALS) for each in marks]


def figures_of(marks: Numbers) -> PeopleFigures:
    """Return what the marks of one exercise are worth, [sitting, person]."""
    skills = np.tile(SKILLS, len(marks))
    return PeopleFigures(
        core=core_digest(),
        persons=len(SKILLS),
        correlation=rank_correlation(skills.tolist(), marks.ravel().tolist()),
        better_has_more=better_share(skills, marks.ravel()),
        standard_error=standard_error(marks),
        ceiling=float((marks >= CEILING_MARKS).mean()),
        mean=float(marks.mean()),
    )


def better_share(skills: Numbers, marks: Numbers) -> float:
    """Return in what share of pairs the better has more; a tie is half."""
    wins = 0.5 + 0.5 * np.sign(marks[:, None] - marks)
    return float(wins[skills[:, None] > skills].mean())


def standard_error(marks: Numbers) -> float:
    """Return the standard deviation of one person's mark by chance, from two runs each.

    Bland and Altman, "Measurement error", BMJ 313 (1996) 744. ``marks`` are [sitting, person].
    """
    return float(np.sqrt(((marks[0] - marks[1]) ** 2).mean() / 2.0))


def cronbach_alpha(items: Numbers) -> float:
    """Return how far exercises measure one thing, [exercise, person].

    Cronbach, "Coefficient alpha and the internal structure of tests", Psychometrika 16 (1951) 297.
    """
    count, whole = len(items), float(items.sum(axis=0).var(ddof=1))
    if not whole:
        return 0.0
    return count / (count - 1) * (1.0 - float(items.var(axis=1, ddof=1).sum()) / whole)


def item_rests(marks: Mapping[str, Numbers]) -> dict[str, float | None]:
    """Return the correlation of each exercise with the mean of all others, by first runs.

    None where there is none: all marks are alike, or there are no others.
    """
    rests: dict[str, float | None] = dict.fromkeys(marks)
    for name, each in marks.items():
        others = [other[0] for key, other in marks.items() if key != name]
        if others and np.ptp(each[0]) and np.ptp(rest := np.mean(others, axis=0)):
            rests[name] = float(np.corrcoef(each[0], rest)[0, 1])
    return rests


def course_figures(marks: Mapping[str, Numbers]) -> dict[str, float] | None:
    """Return how well courses order persons by their mean mark, as means over courses drawn.

    ``shuffled`` is the correlation if skills are dealt to persons by chance. None without a course.
    """
    if len(marks) < 2:
        return None
    items = np.array([marks[name][0] for name in sorted(marks)])
    draws = np.random.default_rng(1)
    size, rows = min(COURSE_SIZE, len(items)), []
    for _ in range(DRAWN_COURSES):
        drawn = items[draws.choice(len(items), size, replace=False)]
        mean = drawn.mean(axis=0)
        orders = (
            rank_correlation(skills.tolist(), mean.tolist())
            for skills in (SKILLS, draws.permutation(SKILLS))
        )
        rows.append((*orders, better_share(SKILLS, mean), cronbach_alpha(drawn)))
    names = ("correlation", "shuffled", "better_has_more", "alpha")
    means = dict(zip(names, np.mean(rows, axis=0).tolist(), strict=True))
    return {"size": size, **means, "shuffled_spread": float(np.std(rows, axis=0)[1])}


def kept_baselines(names: Iterable[str]) -> dict[str, tuple[Path, Baseline]]:
    """Return each exercise's file and baseline. ConfigError if one has none of its text."""
    kept = {}
    for name in names:
        path = path_named(name, "exercises")
        baseline = kept_baseline(path)
        if baseline is None or not baseline.fits(read_text(path)):
            problem = "has no baseline of its text, in which --keep writes"
            raise ConfigError(f"{name}: {problem}; first: trainer exercise baseline {name}")
        kept[name] = path, baseline
    return kept


def keep_people(marks: Mapping[str, Numbers]) -> None:
    """Keep the figures of exercises in their baselines, for debriefs. ConfigError."""
    for name, (path, baseline) in kept_baselines(marks).items():
        people = replace(baseline, people=figures_of(marks[name]))
        renew_file(baseline_path(path), write_baseline(people))


def people_data(marks: Mapping[str, Numbers]) -> dict[str, Any]:
    """Return the figures for JSON, the easiest exercise first."""
    rests = item_rests(marks)
    exercises = {
        name: asdict(figures_of(each)) | {"item_rest": rests[name], "marks": each.tolist()}
        for name, each in sorted(marks.items(), key=lambda item: -float(item[1].mean()))
    }
    return {"skills": SKILLS.tolist(), "exercises": exercises, "course": course_figures(marks)}


def _rows(found: Sequence[Validation], data: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the row of each exercise, beside the correlation of today's grades."""
    grades = {each.exercise: each.correlation for each in found}
    return [
        (
            *(name, f"{each['mean']:.0f}", f"{100.0 * each['ceiling']:.0f} %"),
            *(f"{grades[name]:.2f}", f"{each['correlation']:.2f}"),
            *(f"{each['better_has_more']:.2f}", f"{each['standard_error']:.0f}"),
            text.format_number(each["item_rest"], ".2f"),
        )
        for name, each in data["exercises"].items()
    ]


def _sentences(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what the figures say against the bars, and why those fail that do."""
    exercises, whole = data["exercises"], data["course"]
    below = {
        name: each
        for name, each in exercises.items()
        if round(min(each["correlation"], each["better_has_more"]), 2) < LEAST_EXERCISE_ORDER
    }
    easy = [name for name, each in below.items() if each["ceiling"] > MAX_CEILING]
    loose = [
        name for name in below if below[name]["standard_error"] > MAX_ERROR or name not in easy
    ]
    held = f"{len(exercises) - len(below)} of {len(exercises)} exercises order people"
    yield f"{held} by {LEAST_EXERCISE_ORDER} or more, in correlation and in pairs."
    if easy:
        yield f"Too easy, most runs have {CEILING_MARKS:g} marks or more: {', '.join(easy)}."
    if loose:
        yield f"Decided too much by the chances of one run: {', '.join(loose)}."
    if whole is not None:
        yield (
            f"A course of {whole['size']}, by the mean mark: rank correlation "
            f"{whole['correlation']:.2f}, better more {whole['better_has_more']:.2f} (bars "
            f"{LEAST_COURSE_ORDER}); Cronbach's alpha {whole['alpha']:.2f} (bar {LEAST_ALPHA})."
        )
        yield (
            f"A control: with skills dealt by chance its correlation is {whole['shuffled']:+.2f}, "
            f"with a standard deviation of {whole['shuffled_spread']:.2f} from deal to deal."
        )
    numbers = {each.name: each.number for each in course() if each.name in exercises}
    if len(numbers) > 1:
        order = rank_correlation(
            [*numbers.values()], [-exercises[name]["mean"] for name in numbers]
        )
        yield f"Rank correlation of the place in the course with the marks lost there: {order:.2f}."


def people_text(found: Sequence[Validation], data: Mapping[str, Any]) -> str:
    """Return a row for each exercise, and what they say, for a terminal."""
    table = text.table(PEOPLE_HEADS, _rows(found, data), "")
    said = (HEADS_TEXT, *_sentences(data))
    return "\n".join([*table, "", *(line for each in said for line in text.wrap(each, ""))])


def people_section(found: Sequence[Validation], data: Mapping[str, Any]) -> Markup:
    """Return the chapter of HTML: the rows, what they say, and each person's mean mark."""
    means = np.mean([each["marks"][0] for each in data["exercises"].values()], axis=0)
    persons = Curve("a person", SKILLS + np.linspace(-0.05, 0.05, SKILLS.size), means, points=True)
    panel = Panel("mean of all exercises", "skill of a model operator", "marks [%]", (persons,))
    return html.section(
        *("people", "Model people"),
        html.table([head.strip().replace("\n", " ") for head in PEOPLE_HEADS], _rows(found, data)),
        *map(html.paragraph, (HEADS_TEXT, *_sentences(data))),
        html.charts([draw_panel(panel)]),
    )
