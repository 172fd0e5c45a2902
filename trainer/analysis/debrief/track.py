"""The track of a debrief from above: the boat, the reference crew, the ships that it met."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.debrief.charts import Beside
from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.debrief.episodes import ShipWay, meet, place_of_ship, ways_of_ships
from trainer.analysis.report.svg import (
    WIDTH,
    Axis,
    Ground,
    clock,
    rule,
    step_of,
    svg,
    text,
)
from trainer.core.kernel import Numbers

TALL: Final = 420.0  # [px] of the track
SIDE, HEAD, FOOT = 10.0, 26.0, 30.0  # [px] about it
LEAST: Final = 400.0  # [m] across the shorter way
EVERY: Final = (10.0, 30.0, 60.0, 300.0, 600.0, 1800.0)  # [s] between its marks of time
TRACKED: Final = 1600  # points of it
TICKED: Final = 12  # of them at most
SCALE: Final = 0.2  # of the width, the longest rule
BESIDE: Final = 3000.0  # [m] from the boat, within which a ship's way widens the map


def draw_track(debrief: DebriefData, ground: Ground, beside: tuple[Beside, ...] = ()) -> Markup:
    """Return the track from above as an SVG element, north up, equal scales both ways."""
    column = debrief.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    north, east, seconds = column["x"][good], column["y"][good], ground.seconds[good]
    if not seconds.size:
        return Markup()
    others = [_way_of(run, float(seconds[-1])) for run in beside]
    ships = ways_of_ships(debrief.trajectory)
    shown = [*others, *(_near(ship, debrief) for ship in ships)]
    across, up = axes = _equal_axes(
        np.concatenate([east, *(way[0] for way in shown)]),
        np.concatenate([north, *(way[1] for way in shown)]),
    )
    x, y = across.places(east), up.places(north)
    parts = [text("title", SIDE, 16.0, "Track [m], north up")]
    for run, way in zip(beside, others, strict=True):
        parts.append(_path(run.style, across.places(way[0]), up.places(way[1])))
    step = next((s for s in EVERY if seconds[-1] / s <= TICKED), EVERY[-1])
    for ship in ships:
        parts += _ship(ship, axes, step)
    parts += _approaches(debrief, axes)
    parts.append(_path("actual", x, y))
    for begin, end in ground.spans:
        inside = (seconds >= begin) & (seconds <= end)
        if inside.any():
            parts.append(_path("broken", x[inside], y[inside]))
    for second in np.arange(0.0, float(seconds[-1]) + 1e-9, step):
        place = int(np.searchsorted(seconds, second))
        parts.append(f'<circle class="axis" cx="{x[place]:.1f}" cy="{y[place]:.1f}" r="2.5"/>')
        parts.append(text("tick", x[place] + 6.0, y[place] - 4.0, clock(float(second))))
    return svg("The track from above", (WIDTH, TALL), [*parts, *_rule_of(across)])


def _near(ship: ShipWay, debrief: DebriefData) -> tuple[Numbers, Numbers]:
    """Return the places of a ship, east and north [m], at which it was near the boat."""
    column = debrief.trajectory.columns
    off = np.hypot(ship.north - column["x"][ship.rows], ship.east - column["y"][ship.rows])
    near = off < BESIDE
    return ship.east[near], ship.north[near]


def _ship(ship: ShipWay, axes: tuple[Axis, Axis], step: float) -> Iterator[str]:
    """Yield the way of a ship as far as the map goes, its name, and its marks of time."""
    across, up = axes
    x, y = across.places(ship.east), up.places(ship.north)
    inside = (x > SIDE) & (x < WIDTH - SIDE) & (y > HEAD) & (y < TALL - FOOT)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(int)))
    for first, after in edges.reshape(-1, 2):
        yield _path("ship", x[first:after], y[first:after])
    if not inside.any():
        return
    last = int(np.flatnonzero(inside)[-1])
    side = "ship-name end" if x[last] > 0.8 * WIDTH else "ship-name"
    yield text(side, x[last] + (-6.0 if "end" in side else 6.0), y[last] + 12.0, ship.name)
    for second in np.arange(0.0, float(ship.seconds[-1]) + 1e-9, step):
        place = int(np.argmin(np.abs(ship.seconds - second)))
        if inside[place] and abs(ship.seconds[place] - second) < 0.5 * step:
            yield f'<circle class="ship-dot" cx="{x[place]:.1f}" cy="{y[place]:.1f}" r="2.5"/>'
            yield text("tick", x[place] + 6.0, y[place] - 4.0, clock(float(second)))


def _approaches(debrief: DebriefData, axes: tuple[Axis, Axis]) -> Iterator[str]:
    """Yield a line from the boat to each ship where it was nearest, within the map."""
    across, up = axes
    column = debrief.trajectory.columns
    for name, (apart, tick) in meet(debrief.trajectory).closest.items():
        row = debrief.trajectory.row(tick)
        ship = place_of_ship(debrief.trajectory, name, tick)
        if ship is None or apart > BESIDE:
            continue
        own = across.at(float(column["y"][row])), up.at(float(column["x"][row]))
        there = across.at(ship[1]), up.at(ship[0])
        yield rule("approach", *own, *there)
        middle = 0.5 * (own[0] + there[0]), 0.5 * (own[1] + there[1])
        yield text("tick middle", *middle, f"{apart:.0f} m")


def _way_of(run: Beside, end: float) -> tuple[Numbers, Numbers]:
    """Return the way of another run up to a time [s]: east and north [m]."""
    column = run.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    good &= run.trajectory.seconds <= end + 1e-6
    return column["y"][good], column["x"][good]


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
