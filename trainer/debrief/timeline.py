"""The time line: casualties as bars, and when orders, calls, marks and scores have their places."""

from collections.abc import Iterator
from typing import Final

from trainer.debrief.chart import (
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
from trainer.debrief.dossier import Dossier

ROW, TOP, BOTTOM = 20.0, 8.0, 24.0  # [px]
LABEL: Final = 24.0  # [px] that a score's label takes


def draw_timeline(dossier: Dossier, ground: Ground) -> str:
    """Return the time line as an SVG element."""
    rows = [*_casualties(dossier, ground), _orders(dossier, ground)]
    rows += [_calls(dossier, ground), _marks(dossier, ground), *_scores(dossier, ground)]
    shown = [row for row in rows if row]
    bottom = TOP + ROW * len(shown)
    parts = [*backdrop(ground, TOP, bottom), *time_axis(ground, bottom)]
    for i, row in enumerate(shown):
        parts.append(f'<g transform="translate(0 {TOP + i * ROW:g})">{row}</g>')
    return svg("What happened when", bottom + BOTTOM, parts)


def _casualties(dossier: Dossier, ground: Ground) -> Iterator[str]:
    """Yield a row for each casualty."""
    for i, each in enumerate(dossier.casualties):
        begin, end = (ground.across.at(second) for second in ground.spans[i])
        name = f"C{i + 1} {each.spell.kind}"
        bar = rect("bar", begin, 3.0, max(end - begin, 2.0), ROW - 6.0)
        fits = end + LETTER * len(name) < WIDTH - RIGHT
        words = (
            text("tick", end + 4.0, 14.0, name) if fits else text("tick", LEFT + 4.0, 14.0, name)
        )
        yield bar + words + _heading("casualty" if i == 0 else "")


def _orders(dossier: Dossier, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * dossier.step) for each in dossier.crew]
    drawn = "".join(rule("order", x, 4.0, x, ROW - 4.0) for x in ticks)
    return drawn and drawn + _heading("crew")


def _calls(dossier: Dossier, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * dossier.step) for each in dossier.of_kind("watch")]
    drawn = "".join(text("call middle", x, 14.0, "x") for x in ticks)
    return drawn and drawn + _heading("called")


def _marks(dossier: Dossier, ground: Ground) -> str:
    places = [ground.across.at(each.tick * dossier.step) for each in dossier.of_kind("mark")]
    return _labels(places, "M") and _labels(places, "M") + _heading("mark")


def _scores(dossier: Dossier, ground: Ground) -> Iterator[str]:
    """Yield as many rows as it takes for no label to lie on another."""
    scores = enumerate(dossier.card.scores, start=1)
    left = sorted(
        (ground.across.at(each.attained.tick * dossier.step), f"S{i}")
        for i, each in scores
        if each.attained.tick is not None
    )
    heading = _heading("score")
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
