"""The validation of exercises, for a terminal and as a page of evidence."""

import statistics
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.trainees import ALL_CREWS, GRADED_CREWS, LATE_CREWS, Skill
from trainer.analysis.validation import (
    LEAST_CORRELATION,
    LEAST_REFERENCE_MARKS,
    MAX_SILLY_MARKS,
    Validation,
    validation_data,
)
from trainer.core.digest import core_digest
from trainer.report import html, text
from trainer.report.panels import draw_panel, legend
from trainer.report.plots import Curve, Panel

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
    "seed. The grades are late by 0, 5, 15, 30 and 60 s, and worse in all else; crews with one "
    "fault alone are told beside them and decide nothing."
)


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


def validation_page(found: Sequence[Validation]) -> str:
    """Return the page of HTML."""
    failed = any(each.faults for each in found)
    return html.fill_page(
        "validation.html",
        "guide.css",
        verdict=html.Cell(_conclusion(found), "bad" if failed else "good"),
        contents=[each.exercise for each in found],
        parts=[_overview(found), *map(_exercise_section, found)],
        data=html.embed_json(validation_data(found)),
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
        html.paragraph(_figures(found)),
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
    )
    levels = (0.0, MAX_SILLY_MARKS, 100.0)
    return (
        Panel(found.exercise, "grade, 0 is the reference crew", "marks [%]", graded, levels=levels),
        Panel(found.exercise, "delay [s], the only fault", "marks [%]", alone, levels=levels),
    )
