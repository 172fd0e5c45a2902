"""What a watch of a boat says, as text and as one HTML page."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer import __version__
from trainer.identify.boat.sheet import SURFACES
from trainer.identify.boat.watch import BoatChange, BoatWatch, Moment, WatchedPart, WatchFiles
from trainer.identify.sheet import draw_screen, fill_sheet, listing, screens_of
from trainer.report import html
from trainer.report.plots import Curve, Panel
from trainer.report.text import ascii_text, items, titled_table, wrap
from trainer.units import DEGREE

PART_HEADS: Final = ("", "most [sd]", "if it alone", "sd", "told from")
PART_NOTE: Final = (
    "most: of all times, in standard deviations; beyond {limit:g} a change is told. if it alone: "
    "the change that explains the records best if nothing else has changed. told from: the least "
    "change that these records would show; - or a large one: nothing moves that shows it."
)
SHOWN_CURVES: Final = 5  # parts in the plot, those of the largest statistic
UNSEEN_SHARE: Final = 1.0  # [-] of a lift, drag or thrust: only more than the whole would be told


def render(report: BoatWatch) -> str:
    """Return the page for a terminal."""
    lines = [ascii_text(f"WATCH: {report.vessel}"), ""]
    lines += wrap(f"fitted: {report.fitted}")
    for one in report.records:
        lines += wrap(f"record: {one.source}, {one.rows} rows, {one.interval_s:g} s apart")
        lines += items(one.told)
    lines += ["", *(line for text in verdict_texts(report) for line in wrap(text))]
    lines += titled_table("PARTS", PART_HEADS, map(part_row, report.parts))
    lines += wrap(PART_NOTE.format(limit=report.limit))
    if report.warnings:
        lines += ["", "WARNINGS", *items(report.warnings)]
    return "\n".join(lines)


def verdict_texts(report: BoatWatch) -> Iterator[str]:
    """Yield whether the boat has changed, which parts explain it, and what to do."""
    change = report.change
    if change is None:
        yield "Nothing told: these records are of the boat that was fitted, as far as they show."
        unseen = [one.name for one in report.parts if is_unseen(one)]
        if unseen:
            yield f"They cannot show: {', '.join(unseen)}. Move that surface, or change the speed."
        return
    yield (
        f"CHANGED: from {_since_words(change)} on it is no longer the boat that was fitted (told "
        f"at {_clock(change.told)})."
    )
    first, *others = change.parts
    yield f"{first.name}: {_change_words(first)}; {first.advice}."
    for one in others:
        yield f"or {one.name}: {_change_words(one)}; {one.advice}."
    if others:
        yield (
            "These cannot be told apart by this record. Fly more speeds, and every surface by "
            "itself."
        )
    yield "Fit the boat anew by records from then on: trainer boat fit RECORD... --prior FILE."


def _since_words(change: BoatChange) -> str:
    """Return when a boat has changed, as far as the records tell."""
    if change.earliest == change.latest:
        return f"about {_clock(change.earliest)}"
    return f"some time between {_clock(change.earliest)} and {_clock(change.latest)}"


def _clock(moment: Moment) -> str:
    """Return a time in a record."""
    return f"{clock_words(moment.seconds)} of {Path(moment.source).name}"


def clock_words(seconds: float) -> str:
    """Return a time as hours, minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"


def _change_words(part: WatchedPart) -> str:
    """Return by how much a part has changed."""
    if part.value is None or part.sd is None:
        return "not known by how much"
    return (
        f"{amount_words(part.value, part.unit, sign=True)} (sd {amount_words(part.sd, part.unit)})"
    )


def amount_words(value: float | None, unit: str, *, sign: bool = False) -> str:
    """Return a change with its unit: per cent for shares, degrees for radians."""
    if value is None or not math.isfinite(value):
        return "-"
    factor, word = {"-": (100.0, " %"), "rad": (1.0 / DEGREE, " deg")}.get(unit, (1.0, f" {unit}"))
    return f"{factor * value:{'+' if sign else ''}.2g}{word}"


def is_unseen(part: WatchedPart) -> bool:
    """Return whether not even the loss of the whole part would be told."""
    if part.least is None:
        return True
    return part.unit == "-" and part.least > UNSEEN_SHARE


def part_row(part: WatchedPart) -> tuple[str, ...]:
    """Return a part as cells."""
    numbers = (
        amount_words(part.value, part.unit, sign=True),
        amount_words(part.sd, part.unit),
        amount_words(part.least, part.unit),
    )
    return (part.name, f"{part.deviations:.1f}", *numbers)


def html_page(files: WatchFiles, report: BoatWatch) -> str:
    """Return the page; the same watch gives the same bytes."""
    groups = {"Statistic": _panels(files, report)}
    screens = [
        ("Verdict", Markup().join(_verdict(report))),
        *map(draw_screen, screens_of(groups)),
        ("Numbers", listing(render(report).partition("\n")[2])),
    ]
    heading = f"Watched by trainer boat watch, version {__version__}"
    return fill_sheet(report.vessel, heading, screens, report)


def _verdict(report: BoatWatch) -> Iterator[Markup]:
    """Yield the verdict, then the parts."""
    first, *others = verdict_texts(report)
    yield html.paragraph(first, "good" if report.change is None else "bad")
    for text in others:
        yield html.paragraph(text)
    for text in report.warnings:
        yield html.paragraph(text, "bad")
    yield html.table(("part", *PART_HEADS[1:]), map(part_row, report.parts))
    yield html.paragraph(PART_NOTE.format(limit=report.limit), "soft")


def _panels(files: WatchFiles, report: BoatWatch) -> Iterator[Panel]:
    """Yield the statistic of the parts over time with its limit, and what moved the boat."""
    t = np.array(report.t)
    order = sorted(range(len(report.parts)), key=lambda i: -report.parts[i].deviations)
    curves = tuple(
        Curve(report.parts[i].name, t, np.array(report.deviations[i])) for i in order[:SHOWN_CURVES]
    )
    change = report.change
    marks = () if change is None else (("told", change.told.t),)
    yield Panel(
        "how far from the boat that was fitted",
        "time [s]",
        "[standard deviations]",
        curves,
        marks,
        (report.limit,),
    )
    inputs = np.vstack([one.inputs for one in files.trials])
    begins = np.cumsum([0.0, *((len(one.inputs) - 1) * one.interval for one in files.trials)])
    times = np.concatenate(
        [
            begin + np.arange(len(one.inputs)) * one.interval
            for begin, one in zip(begins, files.trials, strict=False)
        ]
    )
    moved = tuple(Curve(name, times, inputs[:, at] / DEGREE) for name, at in SURFACES.items())
    yield Panel("surfaces", "time [s]", "[deg]", moved, marks)
