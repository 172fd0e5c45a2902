"""``trainer class debrief``: the folder of a class in, its page, table and figures out.

The page lays the boats' curves over one another, eight boats a chart, and leads to each boat's own
debrief beside it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click
import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.config.files import json_text, write_over
from trainer.debrief.page.page import PAGE_BADGE
from trainer.debrief.trainees.class_debrief import (
    CLASS_HEADER,
    BoatRun,
    ClassDebrief,
    ClassExercise,
    class_figures,
    class_table,
    class_text,
    counted,
    gather_class,
    lesson_lines,
    marks_words,
)
from trainer.debrief.trainees.progress_words import write_table
from trainer.report.html import charts, fill_page, paragraph, section, table
from trainer.report.svg import Chart, ChartGround, ChartMoment, CurveLine, draw_chart

PAGES_FOLDER: Final = "debrief"  # in the folder of a class
INDEX_NAME: Final = "index.html"
CHART_BOATS: Final = 8  # in one chart: as many as there are styles of lines
BOAT_HEADS: Final = (
    *("Boat", "Trainee", "Marks", "Own marks", "Outcome", "Lost most", "Runs", "Debrief"),
)
PLACE_HEADS: Final = ("Boat", "Place in the course")


@dataclass(frozen=True)
class ClassRequest:
    """What is wanted of the debrief of a class."""

    html: Path | None = None  # a folder
    csv: Path | None = None
    json: bool = False


def debrief_class(folder: Path, asked: ClassRequest, cores: int) -> None:
    """Write the pages and the table of a class, and print it; ConfigError.

    Asked for neither a folder of pages nor a table nor figures, the pages go into its own folder.
    """
    pages = asked.html
    if not (pages or asked.csv or asked.json):
        pages = folder / PAGES_FOLDER
    debrief = gather_class(folder, pages, cores)
    if asked.csv is not None:
        write_table(asked.csv, CLASS_HEADER, class_table(debrief))
    if pages is not None:
        write_over(pages / INDEX_NAME, render_class(debrief))
    if asked.json:
        click.echo(json_text(class_figures(debrief), indent=1))
        return
    click.echo(class_text(debrief))
    for path in filter(None, (asked.csv, pages and pages / INDEX_NAME)):
        click.echo(str(path))


def render_class(debrief: ClassDebrief) -> str:
    """Return the page of a class."""
    boats = {each.boat for exercise in debrief.exercises for each in exercise.runs}
    chapters = [
        (f"exercise-{number}", each.title, _chapter(each))
        for number, each in enumerate(debrief.exercises, 1)
    ]
    if debrief.places:
        chapters.append(("course", "Where each boat is in the course", places_table(debrief)))
    troubles = [paragraph(each) for each in debrief.troubles]
    parts = [section(*each) for each in chapters]
    parts += [section("troubles", "What could not be judged", *troubles)] if troubles else []
    return fill_page(
        "debrief.html",
        "debrief.css",
        badge=PAGE_BADGE,
        title=debrief.name,
        under=counted(len(boats), "boat"),
        verdict="",
        briefing="",
        contents=[(name, title) for name, title, _ in chapters],
        parts=parts,
        boat="",
        version=__version__,
        source=debrief.name,
    )


def places_table(debrief: ClassDebrief) -> Markup:
    """Return where each boat is, and its marks of those to go on."""
    rows = ([f"{each.boat} {each.name}".rstrip(), each.told] for each in debrief.places)
    return table(PLACE_HEADS, rows, "places")


def _chapter(exercise: ClassExercise) -> Markup:
    """Return what the class has lost together, its curves, and a row for each trainee."""
    mean = [] if exercise.mean is None else [f"The mean of the marks is {exercise.mean:.0f}."]
    words = [paragraph(each) for each in (*lesson_lines(exercise), *mean)]
    rows = [row for each in exercise.runs for row in _rows(each)]
    drawn = charts(draw_curves(exercise))
    return Markup().join([*words, drawn, table(BOAT_HEADS, rows, "class")])


def draw_curves(exercise: ClassExercise) -> Iterator[Markup]:
    """Yield the charts of what the boats could still earn, and where several lost marks."""
    curved = [each for each in exercise.runs if each.summary.points]
    if not curved:
        return
    end = max(each.summary.points[-1][0] for each in curved)
    moments = (ChartMoment("lesson", "change", each.begin) for each in exercise.lessons)
    ground = ChartGround(np.array([0.0, end]), (), (), tuple(moments))
    for first in range(0, len(curved), CHART_BOATS):
        part = curved[first : first + CHART_BOATS]
        title = f"Boats {part[0].boat} to {part[-1].boat}" if len(part) > 1 else "Boat"
        name = f"{exercise.exercise}-{first}"
        yield draw_chart(
            Chart(name, f"{title}: still to be earned", "marks", curve_lines(part), least=100.0),
            ground,
        )


def curve_lines(runs: Sequence[BoatRun]) -> tuple[CurveLine, ...]:
    """Return the curves of some boats, each in a style of its own."""
    lines = []
    for style, each in enumerate(runs, 1):
        seconds, marks = np.array(each.summary.points).T
        lines.append(CurveLine(str(each.boat), marks, f"boat-{style}", seconds))
    return tuple(lines)


def _rows(each: BoatRun) -> Iterator[list[str]]:
    """Yield the row of each trainee of a boat; one where nobody has a name."""
    summary = each.summary
    run, dearest = summary.run, max(summary.losses, key=lambda one: one.marks, default=None)
    link = Markup('<a href="{}">boat {}</a>').format(each.page, each.boat) if each.page else ""
    for place, name in enumerate(summary.trainees or ("-",)):
        own = summary.own_marks[place] if summary.trainees else None
        yield [
            f"{each.boat} {each.name}".rstrip(),
            name,
            marks_words(run),
            "" if own is None else f"{own:.0f}",
            run.outcome or "-",
            dearest.told if dearest else "",
            str(each.attempts),
            link,
        ]
