"""The charts of a debrief: what was ordered and done, the reference crew's run laid under."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.debrief.measures import LIMITED, limits_of
from trainer.analysis.debrief.trajectory import Rows, Trajectory
from trainer.analysis.report.svg import (
    ANGLES,
    Chart,
    Ground,
    Level,
    Line,
    clock,
)
from trainer.config.measures import COURSE
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.units import KNOT

ACTUAL, ORDERED, SECOND = "actual", "ordered", "second"
LETTERS: Final = {"rudder": "r", "stern": "s", "bow": "b"}
BESIDE, FROM_HERE = "beside", "from-here"
WRONG, TAKEN = "wrong", "taken"  # moments of the page
USED: Final = 0.5  # [%] of air, from which on the banks are shown
CHART_OF: Final = {  # where a quantity is drawn that has no chart of its own name
    "depth_rate": "depth",
    "heel": "pitch",
    "turn_rate": "course",
    "turns": "speed",
    "bank_main": "air",
    "bank_emergency": "air",
}
NAMES: Final = ("depth", "pitch", "stern", "bow", "course", "rudder", "speed", "air")


def chart_of(quantity: str) -> str:
    """Return the name of the drawing that shows a quantity, the time line's for others."""
    name = CHART_OF.get(quantity, quantity)
    return name if name in NAMES else "timeline"


@dataclass(frozen=True)
class Beside:
    """A run laid under that of the page: what it is called, and how it is drawn."""

    label: str
    trajectory: Trajectory
    style: str


def runs_beside(debrief: DebriefData) -> tuple[Beside, ...]:
    """Return the runs of the reference crew, as far as the recorded one goes."""
    found = debrief.compared
    if found is None:
        return ()
    runs = [Beside("reference", found.reference.trajectory, BESIDE)]
    if found.from_here is not None:
        label = f"reference from {clock(found.from_here.since or 0.0)}"
        runs.append(Beside(label, found.from_here.trajectory, FROM_HERE))
    return tuple(runs)


def ground_of(debrief: DebriefData) -> Ground:
    """Return time, casualties and marks as every chart shows them."""
    seconds, step = debrief.trajectory.seconds, debrief.step
    last = float(seconds[-1])
    spans = tuple(
        (
            each.episode.begun * step,
            last if each.episode.ended is None else each.episode.ended * step,
        )
        for each in debrief.casualties
    )
    marks = tuple(each.tick * step for each in debrief.of_kind("mark"))
    return Ground(seconds, spans, marks, tuple(_moments(debrief)))


def _moments(debrief: DebriefData) -> Iterator[tuple[str, float]]:
    """Yield when it went wrong, and when the reference crew took over."""
    found = debrief.compared
    if found and found.fault:
        yield WRONG, found.fault.tick * debrief.step
    if found and found.from_here:
        yield TAKEN, found.from_here.since or 0.0


def charts_of(trajectory: Trajectory, beside: tuple[Beside, ...] = ()) -> Iterator[Chart]:
    """Yield the charts, those of parts that the boat lacks left out, other runs laid under."""
    for make in (_depth, _pitch, _stern, _bow, _course, _rudder, _speed, _air):
        chart = make(trajectory)
        if chart is not None:
            end = float(trajectory.seconds[-1])
            under = [line for run in beside for line in _under(run, make(run.trajectory), end)]
            yield replace(chart, lines=(*under, *chart.lines))


def _under(run: Beside, chart: Chart | None, end: float) -> Iterator[Line]:
    """Yield what another run did, up to a time [s], as lines of one chart."""
    done = [line for line in chart.lines if line.style in (ACTUAL, SECOND)] if chart else []
    kept = run.trajectory.seconds <= end + 1e-6
    for line in done:
        which = "" if len(done) == 1 else f"{line.label}, "
        seconds = run.trajectory.seconds[kept]
        yield Line(f"{which}{run.label}", line.values[kept], run.style, seconds)


def _depth(trajectory: Trajectory) -> Chart:
    by_hand = trajectory.columns["stern_by_hand"] * trajectory.columns["bow_by_hand"] != 0.0
    lines = (
        Line("ordered", told_to_all(trajectory, "depth", "ordered_depth", by_hand), ORDERED),
        Line("actual", trajectory.columns["z"], ACTUAL),
    )
    limits = _limits(trajectory, "depth_m")
    return Chart("depth", "Depth", "m", lines, limits, downwards=True, least=6.0)


def told_to_all(trajectory: Trajectory, axis: str, place: str, by_hand: Rows) -> Numbers:
    """Return what is ordered [SI]: to the crew, else to the autopilot where that is at work.

    A run without orders to the crew has what the autopilot is told all through.
    """
    crew, own = trajectory.ordered(axis), trajectory.columns[place]
    if np.isnan(crew).all():
        return own
    return np.where(np.isnan(crew), np.where(by_hand, np.nan, own), crew)


def _pitch(trajectory: Trajectory) -> Chart:
    ordered = np.degrees(trajectory.ordered("pitch"))
    lines = (
        Line("heel, to starboard", np.degrees(trajectory.columns["phi"]), "second fine"),
        *(() if np.isnan(ordered).all() else (Line("ordered", ordered, ORDERED),)),
        Line("pitch, bow up", np.degrees(trajectory.columns["theta"]), ACTUAL),
    )
    levels = (*_limits(trajectory, "pitch_deg"), *_limits(trajectory, "heel_deg"))
    both = tuple(Level(each.label, sign * each.value) for each in levels for sign in (1.0, -1.0))
    return Chart("pitch", "Pitch and heel", "deg", lines, both, least=4.0)


def _stern(trajectory: Trajectory) -> Chart | None:
    return _surface(trajectory, "stern", "Stern planes, rise positive")


def _bow(trajectory: Trajectory) -> Chart | None:
    return _surface(trajectory, "bow", "Bow planes, rise positive")


def _rudder(trajectory: Trajectory) -> Chart | None:
    return _surface(trajectory, "rudder", "Rudder, right positive")


def _surface(trajectory: Trajectory, surface: str, title: str) -> Chart | None:
    """Return the chart of a surface, None of one that the boat lacks."""
    if not trajectory.has(surface):
        return None
    lines = (
        Line("ordered", commanded_angle(trajectory, surface), ORDERED),
        Line("actual", np.degrees(trajectory.series(surface)), ACTUAL),
    )
    return Chart(surface, title, "deg", lines, least=10.0)


def _course(trajectory: Trajectory) -> Chart:
    heading = np.degrees(trajectory.columns["psi"])
    by_hand = trajectory.columns["rudder_by_hand"] != 0.0
    told = told_to_all(trajectory, COURSE, "ordered_psi", by_hand)
    beside = np.degrees(told) - heading
    ordered = heading + (beside + 180.0) % 360.0 - 180.0  # the short way round
    lines = (Line("ordered", ordered, ORDERED), Line("actual", heading, ACTUAL))
    steps: dict[str, Any] = {"least": 10.0, "steps": ANGLES, "number": _bearing}
    return Chart("course", "Heading", "deg", lines, **steps)


def _bearing(angle: float) -> str:
    return f"{round(angle) % 360:03d}"


def _speed(trajectory: Trajectory) -> Chart:
    column = trajectory.columns
    kept = np.where(column["speed_by_hand"] == 0.0, column["ordered_speed"], np.nan)
    crew = trajectory.ordered("speed")
    kept = np.where(np.isnan(crew), kept, crew) / KNOT
    lines = (
        Line("ordered", kept, ORDERED),
        Line("turns for", column["u_c"] / KNOT, "second fine"),
        Line("actual", column["u"] / KNOT, ACTUAL),
    )
    return Chart("speed", "Speed", "kn", lines, _limits(trajectory, "speed_kn"), least=2.0)


def _air(trajectory: Trajectory) -> Chart | None:
    """Return the air left, if any was used."""
    vessel = trajectory.boat.vessel
    lines = []
    for place, (bank, style) in enumerate(zip(BANKS, (ACTUAL, SECOND), strict=True)):
        if full := float(vessel.bank_full[place]):
            lines.append(Line(bank, 100.0 * trajectory.columns[f"bank_{bank}"] / full, style))
    if not any(np.ptp(line.values) > USED for line in lines):
        return None
    return Chart("air", "Air banks, share of full", "%", tuple(lines), least=10.0)


def commanded_angle(trajectory: Trajectory, surface: str) -> Numbers:
    """Return the angle [deg] that a surface is told to take, by hand or by the autopilot."""
    column, letter = trajectory.columns, LETTERS[surface]
    by_hand = column[f"{surface}_by_hand"] != 0.0
    told = np.where(by_hand, column[f"ordered_{letter}"], column[f"command_{letter}"])
    return np.degrees(told) * trajectory.boat.toward[surface]


def _limits(trajectory: Trajectory, key: str) -> tuple[Level, ...]:
    """Return the limits of the exercise that are about one thing."""
    unit = LIMITED[key].unit
    return tuple(
        Level(
            f"limit {getattr(trajectory.limits, name):g} {unit}", getattr(trajectory.limits, name)
        )
        for name in limits_of(trajectory)
        if name.startswith(key)
    )
