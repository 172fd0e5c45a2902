"""The charts of a debrief: what was ordered against what came of it."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.core.tanks import BANKS
from trainer.debrief.axes import ANGLES
from trainer.debrief.chart import Chart, Ground, Level, Line
from trainer.debrief.dossier import Dossier
from trainer.scores.measures import LIMITED, limits_of
from trainer.scores.passage import Passage
from trainer.units import KNOT

ACTUAL, ORDERED = "actual", "ordered"
SECOND, SECOND_ORDERED = "second", "second ordered"
LETTERS: Final = {"rudder": "r", "stern": "s", "bow": "b"}
USED: Final = 0.5  # [%] of air, from which on the banks are shown


def ground_of(dossier: Dossier) -> Ground:
    """Return time, casualties and marks as every chart shows them."""
    seconds, step = dossier.passage.seconds, dossier.step
    last = float(seconds[-1])
    spans = tuple(
        (each.spell.begun * step, last if each.spell.ended is None else each.spell.ended * step)
        for each in dossier.casualties
    )
    return Ground(seconds, spans, tuple(each.tick * step for each in dossier.of_kind("mark")))


def charts_of(passage: Passage) -> Iterator[Chart]:
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


def _depth(passage: Passage) -> Chart:
    lines = (
        Line("ordered", passage.columns["ordered_depth"], ORDERED),
        Line("actual", passage.columns["z"], ACTUAL),
    )
    return Chart("Depth", "m", lines, _limits(passage, "depth_m"), downwards=True, least=6.0)


def _pitch(passage: Passage) -> Chart:
    lines = (
        Line("heel, to starboard positive", np.degrees(passage.columns["phi"]), "second fine"),
        Line("pitch, bow up positive", np.degrees(passage.columns["theta"]), ACTUAL),
    )
    levels = (*_limits(passage, "pitch_deg"), *_limits(passage, "heel_deg"))
    both = tuple(Level(each.label, sign * each.value) for each in levels for sign in (1.0, -1.0))
    return Chart("Pitch and heel", "deg", lines, both, least=4.0)


def _planes(passage: Passage) -> Chart:
    styles = {"stern": (ORDERED, ACTUAL), "bow": (SECOND_ORDERED, SECOND)}
    lines = []
    for surface, (told, moved) in styles.items():
        if passage.has(surface):
            lines.append(Line(f"{surface} ordered", told_angle(passage, surface), told))
            lines.append(Line(surface, np.degrees(passage.series(surface)), moved))
    return Chart("Planes, rise positive", "deg", tuple(lines), least=10.0)


def _course(passage: Passage) -> Chart:
    heading = np.degrees(passage.columns["psi"])
    beside = np.degrees(passage.columns["ordered_psi"]) - heading
    ordered = heading + (beside + 180.0) % 360.0 - 180.0  # the short way round
    lines = (Line("ordered", ordered, ORDERED), Line("actual", heading, ACTUAL))
    return Chart("Course", "deg", lines, least=10.0, steps=ANGLES, number=_bearing)


def _bearing(angle: float) -> str:
    return f"{round(angle) % 360:03d}"


def _rudder(passage: Passage) -> Chart:
    lines = (
        Line("ordered", told_angle(passage, "rudder"), ORDERED),
        Line("actual", np.degrees(passage.series("rudder")), ACTUAL),
    )
    return Chart("Rudder, right positive", "deg", lines, least=10.0)


def _speed(passage: Passage) -> Chart:
    column = passage.columns
    kept = np.where(column["speed_by_hand"] == 0.0, column["ordered_speed"] / KNOT, np.nan)
    lines = (
        Line("ordered", kept, ORDERED),
        Line("turns for", column["u_c"] / KNOT, "second fine"),
        Line("actual", column["u"] / KNOT, ACTUAL),
    )
    return Chart("Speed", "kn", lines, _limits(passage, "speed_kn"), least=2.0)


def _air(passage: Passage) -> Iterator[Chart]:
    """Yield the air left, if any was used."""
    vessel = passage.boat.vessel
    lines = []
    for place, (bank, style) in enumerate(zip(BANKS, (ACTUAL, SECOND), strict=True)):
        if full := float(vessel.bank_full[place]):
            lines.append(Line(bank, 100.0 * passage.columns[f"bank_{bank}"] / full, style))
    if any(np.ptp(line.values) > USED for line in lines):
        yield Chart("Air banks, share of full", "%", tuple(lines), least=10.0)


def told_angle(passage: Passage, surface: str) -> Numbers:
    """Return the angle [deg] that a surface is told to take, by hand or by the autopilot."""
    column, letter = passage.columns, LETTERS[surface]
    by_hand = column[f"{surface}_by_hand"] != 0.0
    told = np.where(by_hand, column[f"ordered_{letter}"], column[f"command_{letter}"])
    return np.degrees(told) * passage.boat.toward[surface]


def _limits(passage: Passage, key: str) -> tuple[Level, ...]:
    """Return the limits of the exercise that are about one thing."""
    unit = LIMITED[key].unit
    return tuple(
        Level(f"limit {getattr(passage.limits, name):g} {unit}", getattr(passage.limits, name))
        for name in limits_of(passage)
        if name.startswith(key)
    )
