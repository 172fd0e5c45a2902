"""The charts of a debrief: what was ordered against what came of it.

The time line: casualties as bars, and when orders, calls, marks and scores have their places.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.debrief.measures import LIMITED, limits_of
from trainer.analysis.debrief.trajectory import Trajectory
from trainer.analysis.report.svg import (
    ANGLES,
    LEFT,
    LETTER,
    RIGHT,
    WIDTH,
    Chart,
    Ground,
    Level,
    Line,
    backdrop,
    rect,
    rule,
    svg,
    text,
    time_axis,
)
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.units import KNOT

ACTUAL, ORDERED = "actual", "ordered"
SECOND, SECOND_ORDERED = "second", "second ordered"
LETTERS: Final = {"rudder": "r", "stern": "s", "bow": "b"}
USED: Final = 0.5  # [%] of air, from which on the banks are shown


def ground_of(dossier: DebriefData) -> Ground:
    """Return time, casualties and marks as every chart shows them."""
    seconds, step = dossier.passage.seconds, dossier.step
    last = float(seconds[-1])
    spans = tuple(
        (each.spell.begun * step, last if each.spell.ended is None else each.spell.ended * step)
        for each in dossier.casualties
    )
    return Ground(seconds, spans, tuple(each.tick * step for each in dossier.of_kind("mark")))


def charts_of(passage: Trajectory) -> Iterator[Chart]:
    """Yield the charts, those of parts that the boat lacks left out."""
    yield _depth(passage)
    yield _pitch(passage)
    if passage.has("stern") or passage.has("bow"):
        yield _planes(passage)
    yield _course(passage)
    if passage.has("rudder"):
        yield _rudder(passage)
    yield _speed(passage)
    yield from _air(passage)


def _depth(passage: Trajectory) -> Chart:
    lines = (
        Line("ordered", passage.columns["ordered_depth"], ORDERED),
        Line("actual", passage.columns["z"], ACTUAL),
    )
    return Chart("Depth", "m", lines, _limits(passage, "depth_m"), downwards=True, least=6.0)


def _pitch(passage: Trajectory) -> Chart:
    lines = (
        Line("heel, to starboard positive", np.degrees(passage.columns["phi"]), "second fine"),
        Line("pitch, bow up positive", np.degrees(passage.columns["theta"]), ACTUAL),
    )
    levels = (*_limits(passage, "pitch_deg"), *_limits(passage, "heel_deg"))
    both = tuple(Level(each.label, sign * each.value) for each in levels for sign in (1.0, -1.0))
    return Chart("Pitch and heel", "deg", lines, both, least=4.0)


def _planes(passage: Trajectory) -> Chart:
    styles = {"stern": (ORDERED, ACTUAL), "bow": (SECOND_ORDERED, SECOND)}
    lines = []
    for surface, (told, moved) in styles.items():
        if passage.has(surface):
            lines.append(Line(f"{surface} ordered", told_angle(passage, surface), told))
            lines.append(Line(surface, np.degrees(passage.series(surface)), moved))
    return Chart("Planes, rise positive", "deg", tuple(lines), least=10.0)


def _course(passage: Trajectory) -> Chart:
    heading = np.degrees(passage.columns["psi"])
    beside = np.degrees(passage.columns["ordered_psi"]) - heading
    ordered = heading + (beside + 180.0) % 360.0 - 180.0  # the short way round
    lines = (Line("ordered", ordered, ORDERED), Line("actual", heading, ACTUAL))
    return Chart("Course", "deg", lines, least=10.0, steps=ANGLES, number=_bearing)


def _bearing(angle: float) -> str:
    return f"{round(angle) % 360:03d}"


def _rudder(passage: Trajectory) -> Chart:
    lines = (
        Line("ordered", told_angle(passage, "rudder"), ORDERED),
        Line("actual", np.degrees(passage.series("rudder")), ACTUAL),
    )
    return Chart("Rudder, right positive", "deg", lines, least=10.0)


def _speed(passage: Trajectory) -> Chart:
    column = passage.columns
    kept = np.where(column["speed_by_hand"] == 0.0, column["ordered_speed"] / KNOT, np.nan)
    lines = (
        Line("ordered", kept, ORDERED),
        Line("turns for", column["u_c"] / KNOT, "second fine"),
        Line("actual", column["u"] / KNOT, ACTUAL),
    )
    return Chart("Speed", "kn", lines, _limits(passage, "speed_kn"), least=2.0)


def _air(passage: Trajectory) -> Iterator[Chart]:
    """Yield the air left, if any was used."""
    vessel = passage.boat.vessel
    lines = []
    for place, (bank, style) in enumerate(zip(BANKS, (ACTUAL, SECOND), strict=True)):
        if full := float(vessel.bank_full[place]):
            lines.append(Line(bank, 100.0 * passage.columns[f"bank_{bank}"] / full, style))
    if any(np.ptp(line.values) > USED for line in lines):
        yield Chart("Air banks, share of full", "%", tuple(lines), least=10.0)


def told_angle(passage: Trajectory, surface: str) -> Numbers:
    """Return the angle [deg] that a surface is told to take, by hand or by the autopilot."""
    column, letter = passage.columns, LETTERS[surface]
    by_hand = column[f"{surface}_by_hand"] != 0.0
    told = np.where(by_hand, column[f"ordered_{letter}"], column[f"command_{letter}"])
    return np.degrees(told) * passage.boat.toward[surface]


def _limits(passage: Trajectory, key: str) -> tuple[Level, ...]:
    """Return the limits of the exercise that are about one thing."""
    unit = LIMITED[key].unit
    return tuple(
        Level(f"limit {getattr(passage.limits, name):g} {unit}", getattr(passage.limits, name))
        for name in limits_of(passage)
        if name.startswith(key)
    )


ROW, TOP, BOTTOM = 20.0, 8.0, 24.0  # [px]
LABEL: Final = 24.0  # [px] that a score's label takes


def draw_timeline(dossier: DebriefData, ground: Ground) -> Markup:
    """Return the time line as an SVG element."""
    rows = [*_casualties(dossier, ground), _orders(dossier, ground)]
    rows += [_calls(dossier, ground), _marks(dossier, ground), *_scores(dossier, ground)]
    shown = [row for row in rows if row]
    bottom = TOP + ROW * len(shown)
    parts = [*backdrop(ground, TOP, bottom), *time_axis(ground, bottom)]
    for i, row in enumerate(shown):
        parts.append(f'<g transform="translate(0 {TOP + i * ROW:g})">{row}</g>')
    return svg("What happened when", (WIDTH, bottom + BOTTOM), parts)


def _casualties(dossier: DebriefData, ground: Ground) -> Iterator[str]:
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


def _orders(dossier: DebriefData, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * dossier.step) for each in dossier.crew]
    drawn = "".join(rule("order", x, 4.0, x, ROW - 4.0) for x in ticks)
    return drawn and drawn + _heading("crew")


def _calls(dossier: DebriefData, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * dossier.step) for each in dossier.of_kind("watch")]
    drawn = "".join(text("call middle", x, 14.0, "x") for x in ticks)
    return drawn and drawn + _heading("called")


def _marks(dossier: DebriefData, ground: Ground) -> str:
    places = [ground.across.at(each.tick * dossier.step) for each in dossier.of_kind("mark")]
    return _labels(places, "M") and _labels(places, "M") + _heading("mark")


def _scores(dossier: DebriefData, ground: Ground) -> Iterator[str]:
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
