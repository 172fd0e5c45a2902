"""The drawings of a debrief against time: time line and charts, with the reference run.

``page`` shows them between the tables of ``sections``. All have one axis of time (``ChartGround``),
so that a cause and its effect stand one above the other. ``report/svg`` draws; here is decided
what.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from trainer.boat.readings import is_depth_kept
from trainer.config.exercise.score_rules import COURSE_QUANTITY
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.debrief.marks.measures import LIMIT_QUANTITIES, limits_of
from trainer.debrief.page.data import DebriefData
from trainer.debrief.passage.ships_met import shown_rows
from trainer.debrief.passage.trajectory import RowMask, Trajectory
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.recording.recording import RecordedEvent
from trainer.report.svg import (
    ANGLE_STEPS_DEG,
    CHART_WIDTH_PX,
    LEFT_MARGIN_PX,
    LETTER_WIDTH_PX,
    RIGHT_EDGE_PX,
    Chart,
    ChartGround,
    ChartMoment,
    CurveLine,
    Level,
    backdrop,
    clock,
    rect,
    rule,
    svg_element,
    text,
    time_axis,
)
from trainer.units import KNOT

ACTUAL_STYLE, ORDERED_STYLE, SECOND_STYLE = "actual", "ordered", "second"
MAX_MARKS_DRAWN: Final = 200  # marks or calls in a chart
SURFACE_CHARTS: Final = {  # their letters in the state, and the titles of their charts
    "rudder": ("r", "Rudder, right positive"),
    "stern": ("s", "Stern planes, rise positive"),
    "bow": ("b", "Bow planes, rise positive"),
}
BESIDE_STYLE, FROM_HERE_STYLE = "beside", "from-here"
CHANGE_STYLE, TAKEN_STYLE = "change", "taken"  # of moments of the page
ROUND_TURN_DEG: Final = 350.0  # [deg] from the ordered course: the boat has gone round
MIN_AIR_USED_PERCENT: Final = 0.5  # [%] of air, from which on the banks are shown
ROW_HEIGHT_PX, TIMELINE_TOP_PX, TIMELINE_BOTTOM_PX = 20.0, 8.0, 24.0  # [px]
LABEL_WIDTH_PX: Final = 24.0  # [px] that a label takes
WASHED_TIME_S: Final = 10.0  # [s] a wave over the periscope this long does not end a showing


def change_name(index: int) -> str:
    """Return the name, in links, of a change of the attainable marks."""
    return f"change{index}"


@dataclass(frozen=True)
class RunBeside:
    """A run drawn under that of the page: its name, and its lines."""

    label: str
    heading: str  # of its orders' row
    trajectory: Trajectory
    style: str


def runs_beside(debrief: DebriefData) -> tuple[RunBeside, ...]:
    """Return the runs of the reference crew, as far as the recorded one goes."""
    comparison = debrief.compared
    if comparison is None:
        return ()
    runs = [RunBeside("reference", "reference", comparison.reference.trajectory, BESIDE_STYLE)]
    if comparison.from_here is not None:
        run, since = comparison.from_here, f"from {clock(comparison.from_here.since or 0.0)}"
        runs.append(RunBeside(f"reference {since}", since, run.trajectory, FROM_HERE_STYLE))
    return tuple(runs)


def ground_of(debrief: DebriefData) -> ChartGround:
    """Return the common ground of all charts: time, casualties and marks."""
    seconds, step = debrief.trajectory.seconds, debrief.step
    last = float(seconds[-1])
    spans = tuple(
        (
            each.episode.begun * step,
            last if each.episode.ended is None else each.episode.ended * step,
        )
        for each in debrief.casualties
    )
    marks = tuple(each.tick * step for each in _drawn(debrief, "mark"))
    holes = debrief.trajectory.holes
    return ChartGround(seconds, spans, marks, tuple(_moments(debrief)), holes)


def _moments(debrief: DebriefData) -> Iterator[ChartMoment]:
    """Yield the moments of a page: changes of the attainable marks, and the reference crew's."""
    comparison, step = debrief.compared, debrief.step
    if comparison and comparison.curve:
        for i, change in enumerate(comparison.curve.changes):
            yield ChartMoment(change_name(i), CHANGE_STYLE, change.told_at * step)
    if comparison and comparison.from_here:
        yield ChartMoment(TAKEN_STYLE, TAKEN_STYLE, comparison.from_here.since or 0.0)


def attainable_chart(debrief: DebriefData) -> Chart | None:
    """Return the chart of the marks that could still be earned, None without any."""
    curve = debrief.compared.curve if debrief.compared else None
    if curve is None:
        return None
    seconds = np.array([point.tick * debrief.step for point in curve.points])
    marks = np.array([point.marks for point in curve.points])
    line = CurveLine("by a careful crew from here", marks, ACTUAL_STYLE, seconds)
    figures = sorted((each.told_at * debrief.step, f"{each.marks:+.0f}") for each in curve.changes)
    title = "What could still be earned"
    return Chart("attainable", title, "marks", (line,), least=100.0, figures=tuple(figures))


def charts_of(trajectory: Trajectory, beside: tuple[RunBeside, ...] = ()) -> Iterator[Chart]:
    """Yield the charts, other runs drawn under this one.

    A chart of a part that the boat lacks is left out.
    """
    stern, bow, rudder = (partial(_surface, surface=name) for name in ("stern", "bow", "rudder"))
    for make in (_depth, _clearance, _pitch, stern, bow, _course, rudder, _speed, _air):
        chart = make(trajectory)
        if chart is not None:
            end = float(trajectory.seconds[-1])
            under = [line for run in beside for line in _under(run, make(run.trajectory), end)]
            yield replace(chart, lines=(*under, *chart.lines))


def _under(run: RunBeside, chart: Chart | None, end: float) -> Iterator[CurveLine]:
    """Yield what another run did, up to a time [s], as lines of one chart."""
    done = (
        [line for line in chart.lines if line.style in (ACTUAL_STYLE, SECOND_STYLE)]
        if chart
        else []
    )
    rows = run.trajectory.seconds <= end + 1e-6
    for line in done:
        which = "" if len(done) == 1 else f"{line.label}, "
        seconds = run.trajectory.seconds[rows]
        yield CurveLine(f"{which}{run.label}", line.values[rows], run.style, seconds)


def _depth(trajectory: Trajectory) -> Chart:
    by_hand = ~is_depth_kept(trajectory.columns.__getitem__)
    lines = (
        CurveLine(
            "ordered", order_in_force(trajectory, "depth", "ordered_depth", by_hand), ORDERED_STYLE
        ),
        CurveLine("actual", trajectory.columns["z"], ACTUAL_STYLE),
    )
    limits = _limits(trajectory, "depth_m")
    return Chart("depth", "Depth", "m", lines, limits, downwards=True, least=6.0)


def _clearance(trajectory: Trajectory) -> Chart | None:
    """Return the chart of the water under the keel, None where there is no ground."""
    if not trajectory.has("clearance"):
        return None
    under = trajectory.series("clearance")
    lines = (CurveLine("actual", np.where(np.isfinite(under), under, np.nan), ACTUAL_STYLE),)
    limits = _limits(trajectory, "clearance_m")
    return Chart("clearance", "Water under the keel", "m", lines, limits, least=10.0)


def order_in_force(trajectory: Trajectory, axis: str, field: str, by_hand: RowMask) -> Numbers:
    """Return the order [SI] in force at each tick, NaN where none is.

    It is the order to the crew; where none stands, the autopilot's, unless the controls are
    ``by_hand``, when it does nothing. In a run without orders to the crew it counts all through.
    """
    crew, by_boat = trajectory.ordered(axis), trajectory.columns[field]
    if np.isnan(crew).all():
        return by_boat
    return np.where(np.isnan(crew), np.where(by_hand, np.nan, by_boat), crew)


def _pitch(trajectory: Trajectory) -> Chart:
    ordered = np.degrees(trajectory.ordered("pitch"))
    lines = (
        CurveLine("heel, to starboard", np.degrees(trajectory.columns["phi"]), "second fine"),
        *(() if np.isnan(ordered).all() else (CurveLine("ordered", ordered, ORDERED_STYLE),)),
        CurveLine("pitch, bow up", np.degrees(trajectory.columns["theta"]), ACTUAL_STYLE),
    )
    levels = (*_limits(trajectory, "pitch_deg"), *_limits(trajectory, "heel_deg"))
    both = tuple(Level(each.label, sign * each.value) for each in levels for sign in (1.0, -1.0))
    return Chart("pitch", "Pitch and heel", "deg", lines, both, least=4.0)


def _surface(trajectory: Trajectory, surface: str) -> Chart | None:
    """Return the chart of a surface, its order by hand or by the autopilot.

    None of one that the boat lacks.
    """
    if not trajectory.has(surface):
        return None
    column, (letter, title) = trajectory.columns, SURFACE_CHARTS[surface]
    by_hand = column[f"{surface}_by_hand"] != 0.0
    ordered = np.where(by_hand, column[f"ordered_{letter}"], column[f"command_{letter}"])
    lines = (
        CurveLine("ordered", np.degrees(ordered) * trajectory.boat.toward[surface], ORDERED_STYLE),
        CurveLine("actual", np.degrees(trajectory.series(surface)), ACTUAL_STYLE),
    )
    return Chart(surface, title, "deg", lines, least=10.0)


def _course(trajectory: Trajectory) -> Chart:
    heading = np.degrees(trajectory.columns["psi"])
    by_hand = trajectory.columns["rudder_by_hand"] != 0.0
    ordered = order_in_force(trajectory, COURSE_QUANTITY, "ordered_psi", by_hand)
    lines = (
        CurveLine("ordered", unwrap_ordered_courses(np.degrees(ordered), heading), ORDERED_STYLE),
        CurveLine("actual", heading, ACTUAL_STYLE),
    )
    steps: dict[str, Any] = {"least": 10.0, "steps": ANGLE_STEPS_DEG, "number": _bearing}
    return Chart("course", "Heading", "deg", lines, **steps)


def unwrap_ordered_courses(ordered: Numbers, heading: Numbers) -> Numbers:
    """Return ordered courses [deg], each by whole turns near the heading at its end.

    The heading counts on past 360 degrees. After a full circle it would else be drawn a whole turn
    away from an order that the boat has met.
    """
    same = (ordered[1:] == ordered[:-1]) | (np.isnan(ordered[1:]) & np.isnan(ordered[:-1]))
    ends = np.append(np.flatnonzero(~same), ordered.size - 1)
    run = np.searchsorted(ends, np.arange(ordered.size))
    off = (heading - ordered)[ends]
    turns = np.where(np.abs(off) > ROUND_TURN_DEG, 360.0 * np.round(off / 360.0), 0.0)
    return ordered + turns[run]


def _bearing(angle: float) -> str:
    return f"{round(angle) % 360:03d}"


def _speed(trajectory: Trajectory) -> Chart:
    column = trajectory.columns
    ordered = np.where(column["speed_by_hand"] == 0.0, column["ordered_speed"], np.nan)
    crew = trajectory.ordered("speed")
    ordered = np.where(np.isnan(crew), ordered, crew) / KNOT
    lines = (
        CurveLine("ordered", ordered, ORDERED_STYLE),
        CurveLine("turns for", column["u_c"] / KNOT, "second fine"),
        CurveLine("actual", column["u"] / KNOT, ACTUAL_STYLE),
    )
    return Chart("speed", "Speed", "kn", lines, _limits(trajectory, "speed_kn"), least=2.0)


def _air(trajectory: Trajectory) -> Chart | None:
    """Return the air left, if any was used."""
    vessel = trajectory.boat.vessel
    lines = []
    for index, (bank, style) in enumerate(zip(BANKS, (ACTUAL_STYLE, SECOND_STYLE), strict=True)):
        if full := float(vessel.bank_full[index]):
            lines.append(CurveLine(bank, 100.0 * trajectory.columns[f"bank_{bank}"] / full, style))
    if not any(np.ptp(line.values) > MIN_AIR_USED_PERCENT for line in lines):
        return None
    return Chart("air", "Air banks, share of full", "%", tuple(lines), least=10.0)


def _limits(trajectory: Trajectory, key: str) -> tuple[Level, ...]:
    """Return the limits of the exercise that are about one thing."""
    unit = LIMIT_QUANTITIES[key].unit
    return tuple(
        Level(
            f"limit {getattr(trajectory.limits, name):g} {unit}", getattr(trajectory.limits, name)
        )
        for name in limits_of(trajectory.limits)
        if name.startswith(key)
    )


# The time line


def draw_timeline(debrief: DebriefData, ground: ChartGround) -> Markup:
    """Return the time line as an SVG element."""
    ticks = [each.order.tick for each in debrief.read_backs]
    numbered = [(tick, f"O{i}") for i, tick in enumerate(ticks, start=1)]
    crew = [each.tick * debrief.step for each in debrief.crew]
    rows = [*_casualties(debrief, ground), *_labelled(numbered, "ordered", debrief, ground)]
    rows += [_strokes(crew, "crew", "order", ground), *_reference(debrief, ground)]
    rows.append(_shown(debrief, ground))
    rows += [_calls(debrief, ground), _marks(debrief, ground)]
    scores = enumerate((each.attained.tick for each in debrief.card.scores), start=1)
    scored = [(tick, f"S{i}") for i, tick in scores if tick is not None]
    rows += _labelled(scored, "score", debrief, ground)
    shown = [row for row in rows if row]
    bottom = TIMELINE_TOP_PX + ROW_HEIGHT_PX * len(shown)
    parts = [*backdrop(ground, TIMELINE_TOP_PX, bottom, "timeline"), *time_axis(ground, bottom)]
    for i, row in enumerate(shown):
        parts.append(
            f'<g transform="translate(0 {TIMELINE_TOP_PX + i * ROW_HEIGHT_PX:g})">{row}</g>'
        )
    return svg_element("What happened when", (CHART_WIDTH_PX, bottom + TIMELINE_BOTTOM_PX), parts)


def _casualties(debrief: DebriefData, ground: ChartGround) -> Iterator[str]:
    """Yield a row for each casualty."""
    for i, casualty in enumerate(debrief.casualties):
        begin, end = (ground.across.at(second) for second in ground.spans[i])
        name = f"C{i + 1} {casualty.episode.kind}"
        bar = rect("bar", begin, 3.0, max(end - begin, 2.0), ROW_HEIGHT_PX - 6.0)
        fits = end + LETTER_WIDTH_PX * len(name) < RIGHT_EDGE_PX
        words = (
            text("tick", end + 4.0, 14.0, name)
            if fits
            else text("tick", LEFT_MARGIN_PX + 4.0, 14.0, name)
        )
        yield bar + words + _heading("casualty" if i == 0 else "")


def _reference(debrief: DebriefData, ground: ChartGround) -> Iterator[str]:
    """Yield the orders of the reference crew, a row for each of its runs."""
    for run in runs_beside(debrief):
        orders = (each for each in run.trajectory.orders if each.giver == REFERENCE_GIVER)
        seconds = [each.tick * debrief.step for each in orders]
        yield _strokes(seconds, run.heading, "order-beside", ground)


def _strokes(seconds: list[float], heading: str, style: str, ground: ChartGround) -> str:
    """Return a row with a stroke for each of some times [s]."""
    strokes = [ground.across.at(each) for each in seconds if each <= ground.across.high]
    drawn = "".join(rule(style, x, 4.0, x, ROW_HEIGHT_PX - 4.0) for x in strokes)
    return drawn and drawn + _heading(heading)


def _shown(debrief: DebriefData, ground: ChartGround) -> str:
    """Return a row with a bar for each time that the periscope showed."""
    seconds = debrief.trajectory.seconds[shown_rows(debrief.trajectory)[0]]
    if not seconds.size:
        return ""
    breaks = np.flatnonzero(np.diff(seconds) > WASHED_TIME_S) + 1
    ends = ((each[0], each[-1] + debrief.step) for each in np.split(seconds, breaks))
    spans = [(ground.across.at(begin), ground.across.at(end)) for begin, end in ends]
    bars = (
        rect("shown", begin, 5.0, max(end - begin, 2.0), ROW_HEIGHT_PX - 10.0)
        for begin, end in spans
    )
    return "".join(bars) + _heading("scope")


def _calls(debrief: DebriefData, ground: ChartGround) -> str:
    ticks = [ground.across.at(each.tick * debrief.step) for each in _drawn(debrief, "watch")]
    drawn = "".join(text("call middle", x, 14.0, "x") for x in ticks)
    return drawn and drawn + _heading("called")


def _drawn(debrief: DebriefData, kind: str) -> tuple[RecordedEvent, ...]:
    """Return the first events of a kind, no more than a chart has room for."""
    return debrief.of_kind(kind)[:MAX_MARKS_DRAWN]


def _marks(debrief: DebriefData, ground: ChartGround) -> str:
    marks = [ground.across.at(each.tick * debrief.step) for each in _drawn(debrief, "mark")]
    drawn = (text("tick middle", x, 14.0, f"M{i}") for i, x in enumerate(marks, start=1))
    return "".join(drawn) + _heading("mark") if marks else ""


def _labelled(
    ticks: list[tuple[int, str]], heading: str, debrief: DebriefData, ground: ChartGround
) -> Iterator[str]:
    """Yield as many rows as the labels need so that none lies on another."""
    labels = sorted((ground.across.at(tick * debrief.step), name) for tick, name in ticks)
    heading = _heading(heading)
    while labels:
        row, rest, end = "", [], 0.0
        for x, name in labels:
            if x - end < LABEL_WIDTH_PX:
                rest.append((x, name))
                continue
            row, end = row + text("tick middle", x, 14.0, name), x
        yield row + heading
        labels, heading = rest, ""


def _heading(words: str) -> str:
    return text("tick end", LEFT_MARGIN_PX - 6.0, 14.0, words)
