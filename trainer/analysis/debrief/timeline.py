"""The time line of a debrief: what broke, was ordered, called out, marked and judged, and when."""

from collections.abc import Iterator
from typing import Final

from markupsafe import Markup

from trainer.analysis.debrief.charts import runs_beside
from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.rehearsal import CREW
from trainer.analysis.report.svg import (
    LEFT,
    LETTER,
    RIGHT,
    WIDTH,
    Ground,
    backdrop,
    rect,
    rule,
    svg,
    text,
    time_axis,
)

ROW, TOP, BOTTOM = 20.0, 8.0, 24.0  # [px]
LABEL: Final = 24.0  # [px] that a label takes


def draw_timeline(debrief: DebriefData, ground: Ground) -> Markup:
    """Return the time line as an SVG element."""
    rows = [*_casualties(debrief, ground), *_to_crew(debrief, ground), _orders(debrief, ground)]
    rows += [*_reference(debrief, ground), _calls(debrief, ground), _marks(debrief, ground)]
    rows += _scores(debrief, ground)
    shown = [row for row in rows if row]
    bottom = TOP + ROW * len(shown)
    parts = [*backdrop(ground, TOP, bottom, "timeline"), *time_axis(ground, bottom)]
    for i, row in enumerate(shown):
        parts.append(f'<g transform="translate(0 {TOP + i * ROW:g})">{row}</g>')
    return svg("What happened when", (WIDTH, bottom + BOTTOM), parts)


def _casualties(debrief: DebriefData, ground: Ground) -> Iterator[str]:
    """Yield a row for each casualty."""
    for i, each in enumerate(debrief.casualties):
        begin, end = (ground.across.at(second) for second in ground.spans[i])
        name = f"C{i + 1} {each.episode.kind}"
        bar = rect("bar", begin, 3.0, max(end - begin, 2.0), ROW - 6.0)
        fits = end + LETTER * len(name) < WIDTH - RIGHT
        words = (
            text("tick", end + 4.0, 14.0, name) if fits else text("tick", LEFT + 4.0, 14.0, name)
        )
        yield bar + words + _heading("casualty" if i == 0 else "")


def _orders(debrief: DebriefData, ground: Ground) -> str:
    return _strokes([each.tick * debrief.step for each in debrief.crew], "crew", ground)


def _reference(debrief: DebriefData, ground: Ground) -> Iterator[str]:
    """Yield the orders of the reference crew, a row for each of its runs."""
    for run in runs_beside(debrief):
        given = (each for each in run.trajectory.orders if each.who == CREW)
        heading = run.label.removeprefix("reference ")
        yield _strokes([each.tick * debrief.step for each in given], heading, ground)


def _strokes(seconds: list[float], heading: str, ground: Ground) -> str:
    """Return a row with a stroke for each moment of the run."""
    style = "order" if heading == "crew" else "order-beside"
    places = [ground.across.at(each) for each in seconds if each <= ground.across.high]
    drawn = "".join(rule(style, x, 4.0, x, ROW - 4.0) for x in places)
    return drawn and drawn + _heading(heading)


def _to_crew(debrief: DebriefData, ground: Ground) -> Iterator[str]:
    """Yield the orders to the crew by their numbers in the table."""
    ticks = [each.order.tick for each in debrief.read_backs]
    named = [(tick, f"O{i}") for i, tick in enumerate(ticks, start=1)]
    yield from _labelled(named, "ordered", debrief, ground)


def _calls(debrief: DebriefData, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * debrief.step) for each in debrief.of_kind("watch")]
    drawn = "".join(text("call middle", x, 14.0, "x") for x in ticks)
    return drawn and drawn + _heading("called")


def _marks(debrief: DebriefData, ground: Ground) -> str:
    places = [ground.across.at(each.tick * debrief.step) for each in debrief.of_kind("mark")]
    return _labels(places, "M") and _labels(places, "M") + _heading("mark")


def _scores(debrief: DebriefData, ground: Ground) -> Iterator[str]:
    """Yield the places of the scores by their numbers in the table."""
    ticks = [
        (each.attained.tick, f"S{i}")
        for i, each in enumerate(debrief.card.scores, start=1)
        if each.attained.tick is not None
    ]
    yield from _labelled(ticks, "score", debrief, ground)


def _labelled(
    ticks: list[tuple[int, str]], heading: str, debrief: DebriefData, ground: Ground
) -> Iterator[str]:
    """Yield as many rows as it takes for no label to lie on another."""
    left = sorted((ground.across.at(tick * debrief.step), name) for tick, name in ticks)
    heading = _heading(heading)
    while left:
        row, rest, end = "", [], 0.0
        for x, name in left:
            if x - end < LABEL:
                rest.append((x, name))
                continue
            row, end = row + text("tick middle", x, 14.0, name), x
        yield row + heading
        left, heading = rest, ""


def _labels(places: list[float], letter: str) -> str:
    return "".join(
        text("tick middle", x, 14.0, f"{letter}{i}") for i, x in enumerate(places, start=1)
    )


def _heading(words: str) -> str:
    return text("tick end", LEFT - 6.0, 14.0, words)
