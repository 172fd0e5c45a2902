"""The drawings of a debrief: its charts, and the time line above them."""

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
    Axis,
    Chart,
    Ground,
    Level,
    Line,
    backdrop,
    clock,
    rect,
    rule,
    step_of,
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
    return Ground(seconds, spans, tuple(each.tick * step for each in debrief.of_kind("mark")))


def charts_of(trajectory: Trajectory) -> Iterator[Chart]:
    """Yield the charts, those of parts that the boat lacks left out."""
    yield _depth(trajectory)
    yield _pitch(trajectory)
    if trajectory.has("stern") or trajectory.has("bow"):
        yield _planes(trajectory)
    yield _course(trajectory)
    if trajectory.has("rudder"):
        yield _rudder(trajectory)
    yield _speed(trajectory)
    yield from _air(trajectory)


def _depth(trajectory: Trajectory) -> Chart:
    lines = (
        Line("ordered", trajectory.columns["ordered_depth"], ORDERED),
        Line("actual", trajectory.columns["z"], ACTUAL),
    )
    return Chart("Depth", "m", lines, _limits(trajectory, "depth_m"), downwards=True, least=6.0)


def _pitch(trajectory: Trajectory) -> Chart:
    lines = (
        Line("heel, to starboard positive", np.degrees(trajectory.columns["phi"]), "second fine"),
        Line("pitch, bow up positive", np.degrees(trajectory.columns["theta"]), ACTUAL),
    )
    levels = (*_limits(trajectory, "pitch_deg"), *_limits(trajectory, "heel_deg"))
    both = tuple(Level(each.label, sign * each.value) for each in levels for sign in (1.0, -1.0))
    return Chart("Pitch and heel", "deg", lines, both, least=4.0)


def _planes(trajectory: Trajectory) -> Chart:
    styles = {"stern": (ORDERED, ACTUAL), "bow": (SECOND_ORDERED, SECOND)}
    lines = []
    for surface, (told, moved) in styles.items():
        if trajectory.has(surface):
            lines.append(Line(f"{surface} ordered", commanded_angle(trajectory, surface), told))
            lines.append(Line(surface, np.degrees(trajectory.series(surface)), moved))
    return Chart("Planes, rise positive", "deg", tuple(lines), least=10.0)


def _course(trajectory: Trajectory) -> Chart:
    heading = np.degrees(trajectory.columns["psi"])
    beside = np.degrees(trajectory.columns["ordered_psi"]) - heading
    ordered = heading + (beside + 180.0) % 360.0 - 180.0  # the short way round
    lines = (Line("ordered", ordered, ORDERED), Line("actual", heading, ACTUAL))
    return Chart("Heading", "deg", lines, least=10.0, steps=ANGLES, number=_bearing)


def _bearing(angle: float) -> str:
    return f"{round(angle) % 360:03d}"


def _rudder(trajectory: Trajectory) -> Chart:
    lines = (
        Line("ordered", commanded_angle(trajectory, "rudder"), ORDERED),
        Line("actual", np.degrees(trajectory.series("rudder")), ACTUAL),
    )
    return Chart("Rudder, right positive", "deg", lines, least=10.0)


def _speed(trajectory: Trajectory) -> Chart:
    column = trajectory.columns
    kept = np.where(column["speed_by_hand"] == 0.0, column["ordered_speed"] / KNOT, np.nan)
    lines = (
        Line("ordered", kept, ORDERED),
        Line("turns for", column["u_c"] / KNOT, "second fine"),
        Line("actual", column["u"] / KNOT, ACTUAL),
    )
    return Chart("Speed", "kn", lines, _limits(trajectory, "speed_kn"), least=2.0)


def _air(trajectory: Trajectory) -> Iterator[Chart]:
    """Yield the air left, if any was used."""
    vessel = trajectory.boat.vessel
    lines = []
    for place, (bank, style) in enumerate(zip(BANKS, (ACTUAL, SECOND), strict=True)):
        if full := float(vessel.bank_full[place]):
            lines.append(Line(bank, 100.0 * trajectory.columns[f"bank_{bank}"] / full, style))
    if any(np.ptp(line.values) > USED for line in lines):
        yield Chart("Air banks, share of full", "%", tuple(lines), least=10.0)


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


ROW, TOP, BOTTOM = 20.0, 8.0, 24.0  # [px]
LABEL: Final = 24.0  # [px] that a score's label takes


def draw_timeline(debrief: DebriefData, ground: Ground) -> Markup:
    """Return the time line as an SVG element."""
    rows = [*_casualties(debrief, ground), _orders(debrief, ground)]
    rows += [_calls(debrief, ground), _marks(debrief, ground), *_scores(debrief, ground)]
    shown = [row for row in rows if row]
    bottom = TOP + ROW * len(shown)
    parts = [*backdrop(ground, TOP, bottom), *time_axis(ground, bottom)]
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
    ticks = [ground.across.at(each.tick * debrief.step) for each in debrief.crew]
    drawn = "".join(rule("order", x, 4.0, x, ROW - 4.0) for x in ticks)
    return drawn and drawn + _heading("crew")


def _calls(debrief: DebriefData, ground: Ground) -> str:
    ticks = [ground.across.at(each.tick * debrief.step) for each in debrief.of_kind("watch")]
    drawn = "".join(text("call middle", x, 14.0, "x") for x in ticks)
    return drawn and drawn + _heading("called")


def _marks(debrief: DebriefData, ground: Ground) -> str:
    places = [ground.across.at(each.tick * debrief.step) for each in debrief.of_kind("mark")]
    return _labels(places, "M") and _labels(places, "M") + _heading("mark")


def _scores(debrief: DebriefData, ground: Ground) -> Iterator[str]:
    """Yield as many rows as it takes for no label to lie on another."""
    scores = enumerate(debrief.card.scores, start=1)
    left = sorted(
        (ground.across.at(each.attained.tick * debrief.step), f"S{i}")
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


TALL: Final = 420.0  # [px] of the track
SIDE, HEAD, FOOT = 10.0, 26.0, 30.0  # [px] about it
LEAST: Final = 400.0  # [m] across the shorter way
EVERY: Final = (10.0, 30.0, 60.0, 300.0, 600.0, 1800.0)  # [s] between its marks of time
TRACKED: Final = 1600  # points of it
TICKED: Final = 12  # of them at most
SCALE: Final = 0.2  # of the width, the longest rule


def draw_track(debrief: DebriefData, ground: Ground) -> Markup:
    """Return the track from above as an SVG element, north up, equal scales both ways."""
    column = debrief.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    north, east, seconds = column["x"][good], column["y"][good], ground.seconds[good]
    if not seconds.size:
        return Markup()
    across, up = _equal_axes(east, north)
    x, y = across.places(east), up.places(north)
    parts = [text("title", SIDE, 16.0, "Track [m], north up"), _path("actual", x, y)]
    for begin, end in ground.spans:
        inside = (seconds >= begin) & (seconds <= end)
        if inside.any():
            parts.append(_path("broken", x[inside], y[inside]))
    step = next((s for s in EVERY if seconds[-1] / s <= TICKED), EVERY[-1])
    for second in np.arange(0.0, float(seconds[-1]) + 1e-9, step):
        place = int(np.searchsorted(seconds, second))
        parts.append(f'<circle class="axis" cx="{x[place]:.1f}" cy="{y[place]:.1f}" r="2.5"/>')
        parts.append(text("tick", x[place] + 6.0, y[place] - 4.0, clock(float(second))))
    return svg("The track from above", (WIDTH, TALL), [*parts, *_rule_of(across)])


def _equal_axes(east: Numbers, north: Numbers) -> tuple[Axis, Axis]:
    """Return axes of one scale about the whole track: a turning circle is round."""
    wide, high = WIDTH - 2.0 * SIDE, TALL - HEAD - FOOT
    metres = 1.12 * max(float(np.ptp(east)) / wide, float(np.ptp(north)) / high)
    metres = max(metres, LEAST / min(wide, high))
    middle_e = 0.5 * (float(east.min()) + float(east.max()))
    middle_n = 0.5 * (float(north.min()) + float(north.max()))
    half_e, half_n = 0.5 * metres * wide, 0.5 * metres * high
    return (
        Axis(middle_e - half_e, middle_e + half_e, SIDE, WIDTH - SIDE),
        Axis(middle_n - half_n, middle_n + half_n, TALL - FOOT, HEAD),
    )


def _path(style: str, x: Numbers, y: Numbers) -> str:
    """Return a line through places [px], about one point in so many as can be told apart."""
    every = max(x.size // TRACKED, 1)
    rows = [*range(0, x.size, every), x.size - 1]
    told = "L".join(f"{x[i]:.1f} {y[i]:.1f}" for i in rows)
    return f'<path class="line {style}" d="M{told}"/>'


def _rule_of(across: Axis) -> Iterator[str]:
    """Yield a rule of a round length, with that length."""
    pixels = (across.end - across.begin) / (across.high - across.low)  # [px/m]
    length = step_of(SCALE * WIDTH / pixels, 1)
    length = length if length * pixels <= 2.0 * SCALE * WIDTH else 0.5 * length
    bottom = TALL - 10.0
    yield rule("axis", SIDE, bottom, SIDE + length * pixels, bottom)
    for end in (SIDE, SIDE + length * pixels):
        yield rule("axis", end, bottom - 4.0, end, bottom + 4.0)
    yield text("tick", SIDE + length * pixels + 8.0, bottom + 4.0, f"{length:g} m")
