"""The drawing of one run: a table of entities, and what walks it for a file or a viewer.

The world is north, east and down [m], with its origin where the run's is. What surrounds the boat
follows the boat in whole squares of its grid, so that the boat is seen to move through it.
"""

import functools
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import Seen, contacts_in
from trainer.boat.world.scope import Periscope, periscope_of
from trainer.config.bottom import Bottom, depths_at
from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Batch, Block, Changes, Subject, Times, Told, Track
from trainer.session.rerun.charts import (
    LEDGER,
    LEDGER_LABELS,
    Lane,
    casualty_lanes,
    charts_of,
    depth_kept,
    lanes_of,
    ledger_columns,
)
from trainer.session.rerun.sdk import rr, rrb
from trainer.session.rerun.shape import (
    Fin,
    Mesh,
    Size,
    fins_of,
    grid,
    half_turned,
    hull_mesh,
    level_triangles,
    mast_mesh,
    outline,
    quaternions,
    sail_mesh,
    size_of,
    square,
)
from trainer.units import KNOT

APPLICATION: Final = "trainer"
STEP, SECONDS = "tick", "time"  # names of the time lines
ALWAYS: Final = ("depth", "heading", "surfaces")  # charts below one another; the rest are tabs
EYE: Final = (-1.0, -0.75, -0.3)  # [-] of its length: astern, to port and above
WHOLE: Final = rr.TimeRange(
    start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.infinite()
)
WORLD, BOAT, FOLLOWER, TRACK = "world", "world/boat", "world/follower", "world/track"
MAST = "world/boat/mast"
NEAR, SEA, ORDERED = "world/near", "world/near/sea", "world/near/ordered"
GROUND, SHIPS, COURSES = "world/near/ground", "world/ships", "world/ships/courses"
SQUARES: Final = 6  # of the grid, from the boat to the end of the sea
FINE: Final = 8  # pieces of the track to a length of the boat
DRAWN: Final = 1.0  # [s] from one picture of the ships to the next
AHEAD: Final = 60.0  # [s] of the way that a ship's arrow shows
Colour = tuple[int, int, int, int]
HULL: Final[Colour] = (96, 104, 112, 255)
SAIL: Final[Colour] = (80, 88, 96, 255)
MOVING: Final[Colour] = (213, 94, 0, 255)
WATER: Final[Colour] = (86, 180, 233, 40)
GRID: Final[Colour] = (86, 180, 233, 110)
ASKED: Final[Colour] = (230, 159, 0, 255)
FORBIDDEN: Final[Colour] = (204, 121, 167, 255)
SAND: Final[Colour] = (148, 128, 96, 255)
SHIP: Final[Colour] = (0, 158, 115, 255)
WAKE: Final[Colour] = (240, 228, 66, 255)
# Okabe and Ito (2008), in the order of their contrast with a dark ground
COLOURS: Final = (
    *((86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66)),
    *((204, 121, 167), (213, 94, 0), (240, 240, 240), (0, 114, 178)),
)
WARNINGS: Final = ("watch", "pilot", "depth", "mark")  # kinds of news
LEVELS: Final = {"trouble": "ERROR"} | dict.fromkeys(WARNINGS, "WARN")  # by kind of news

Columns = Any  # of the library, whose makers give no type


class Entity(NamedTuple):
    """One thing drawn: where it is, its numbers in a block, and the columns made of some rows."""

    path: str
    read: Callable[[Block], Numbers]
    draw: Callable[[Numbers], Columns]
    always: bool = False  # at every tick; otherwise where it changes


def moved(places: Numbers) -> Columns:
    """Return the columns of what is somewhere else."""
    return rr.Transform3D.columns(translation=places)


def scalars(columns: Numbers) -> Columns:
    """Return one number for each line at each row."""
    rows, count = columns.shape
    whole = rr.Scalars.columns(scalars=np.ascontiguousarray(columns).reshape(-1))
    return whole.partition(np.full(rows, count))


def entities(subject: Subject, size: Size) -> Iterator[Entity]:
    """Yield all that is read off the state: the boat, what moves with it, charts."""
    yield Entity(FOLLOWER, place_of, moved, always=True)
    yield Entity(BOAT, pose_of, posed, always=True)
    for fin in fins_of(subject.boat, size):
        yield Entity(f"{BOAT}/{fin.name}", fin.angle, functools.partial(turned, fin))
    scope = periscope_of(subject.boat)
    if scope and scope.fitted:
        extension = scope.fitted.extension_m
        yield Entity(MAST, functools.partial(feet_of, scope, extension), moved)

    near = functools.partial(square_of, size.length)
    yield Entity(NEAR, near, moved)
    ground = ground_under(subject.boat)
    if ground:
        yield Entity(GROUND, near, functools.partial(grounds, ground, size))
    yield Entity(SEA, level_of, moved)
    yield Entity(ORDERED, ordered_of, functools.partial(frames, size))
    for chart in charts_of(subject.boat):
        yield Entity(chart.path, chart.columns, scalars, always=True)


def place_of(block: Block) -> Numbers:
    """Return where the boat is [m]."""
    return block.several("x", "y", "z")


def square_of(length: float, block: Block) -> Numbers:
    """Return the middle of the square of the grid that the boat is in [m]."""
    return length * np.round(place_of(block) / length) * (1.0, 1.0, 0.0)


def pose_of(block: Block) -> Numbers:
    """Return where the boat is [m], and the attitude as quaternions."""
    attitude = quaternions(block["phi"], block["theta"], block["psi"])
    return np.concatenate((place_of(block), attitude), axis=1)


def posed(poses: Numbers) -> Columns:
    """Return the columns of places and attitudes."""
    return rr.Transform3D.columns(translation=poses[:, :3], quaternion=poses[:, 3:])


def turned(fin: Fin, angle: Numbers) -> Columns:
    """Return the columns of a fin that is turned about its stock."""
    return posed(
        np.column_stack((np.tile(fin.stock, (angle.size, 1)), half_turned(fin.outward, angle)))
    )


def feet_of(scope: Periscope, extension: float, block: Block) -> Numbers:
    """Return how far the periscope's mast is out of the sail: its foot in the body's axes [m]."""
    heads = [scope.head(scope.at(tick)) for tick in block.times.ticks.tolist()]
    return np.array([(x, 0.0, z + extension) for x, z in heads]).reshape(-1, 3)


def level_of(block: Block) -> Numbers:
    """Return where the surface of the sea is about the boat [m]."""
    level = np.zeros((block.times.ticks.size, 3))
    level[:, 2] = -block["eta_wave"]
    return level


def ordered_of(block: Block) -> Numbers:
    """Return the ordered depth [m], minus infinity where none is kept."""
    return np.where(depth_kept(block) > 0.0, block["ordered_depth"], -np.inf)


def frames(size: Size, depths: Numbers) -> Columns:
    """Return the columns of the ordered depth, empty where none is kept."""
    kept = np.isfinite(depths)
    count = int(kept.sum())
    columns = rr.LineStrips3D.columns(
        strips=[outline(0.5 * SQUARES * size.length, float(depth)) for depth in depths[kept]],
        labels=[f"ordered {depth:g} m" for depth in depths[kept]],
        colors=np.full(count, colour_code(ASKED), np.uint32),
        radii=np.full(count, 0.006 * size.length),
    )
    return columns.partition(kept.astype(np.int32))


def grounds(ground: Bottom, size: Size, places: Numbers) -> Columns:
    """Return the columns of the ground about each of the places."""
    offsets = np.linspace(-SQUARES, SQUARES, 2 * SQUARES + 1) * size.length
    north, east = (each.ravel() for each in np.meshgrid(offsets, offsets, indexing="ij"))
    triangles = level_triangles(offsets.size)
    depths = [depths_at(ground, north + n, east + e) for n, e in places[:, :2].tolist()]
    points = [np.column_stack((north, east, each)).astype(np.float32) for each in depths]
    columns = rr.Mesh3D.columns(
        vertex_positions=np.concatenate(points),
        vertex_normals=np.concatenate([Mesh(each, triangles).normals() for each in points]),
    )
    return columns.partition(np.full(len(points), north.size, np.int32))


def constants(subject: Subject, size: Size) -> Iterator[tuple[str, Any]]:
    """Yield what is the same at all times: shapes, frames at depths, how lines are drawn."""
    yield WORLD, rr.ViewCoordinates.FRD
    yield FOLLOWER, rr.ViewCoordinates.FRD
    yield f"{BOAT}/hull", draw_mesh(hull_mesh(size), HULL)
    if size.sail is not None:
        yield f"{BOAT}/sail", draw_mesh(sail_mesh(size, size.sail), SAIL)
    for fin in fins_of(subject.boat, size):
        yield f"{BOAT}/{fin.name}/shape", draw_mesh(fin.mesh, MOVING)
    scope, reach, length = periscope_of(subject.boat), SQUARES * size.length, size.length
    if scope and scope.fitted:
        yield f"{MAST}/shape", draw_mesh(mast_mesh(size, scope.fitted.extension_m), MOVING)
    yield f"{SEA}/surface", draw_mesh(square(reach), WATER)
    if ground_under(subject.boat):
        triangles = level_triangles(2 * SQUARES + 1)
        yield GROUND, rr.Mesh3D.from_fields(triangle_indices=triangles, albedo_factor=SAND)
    squares = rr.LineStrips3D(grid(reach, length), colors=GRID, radii=0.0015 * length)
    yield f"{SEA}/grid", squares
    depths = {
        "limit": subject.limits.depth_m_max,
        "upper limit": subject.limits.depth_m_min,
        "deepest allowed": subject.boat.file.hull.max_depth_m,
    }
    for name, depth in depths.items():
        if depth is not None:
            strips, label, radius = [outline(reach, depth)], f"{name} {depth:g} m", 0.006 * length
            frame = rr.LineStrips3D(strips, colors=FORBIDDEN, radii=radius, labels=label)
            yield f"{NEAR}/{name.replace(' ', '_')}", frame
    for chart in charts_of(subject.boat):
        yield chart.path, lines(chart.labels)
    yield LEDGER, lines(LEDGER_LABELS)


def lines(labels: Sequence[str]) -> Any:
    """Return how the lines of a chart are drawn."""
    colours = [COLOURS[i % len(COLOURS)] for i in range(len(labels))]
    return rr.SeriesLines(names=labels, colors=colours, widths=[1.5] * len(labels))


def draw_mesh(mesh: Mesh, colour: Colour) -> Any:
    """Return a mesh in a colour."""
    return rr.Mesh3D(
        vertex_positions=mesh.points,
        triangle_indices=mesh.triangles,
        vertex_normals=mesh.normals(),
        albedo_factor=colour,
    )


def colour_code(colour: Colour) -> int:
    """Return a colour as Rerun's columns take it."""
    return int.from_bytes(bytes(colour), "big")


class Drawing:
    """One recording of Rerun's on its way to a file or a viewer; for one thread only.

    A write raises what the library does; a viewer that hangs holds it up for as long.
    """

    def __init__(self, subject: Subject) -> None:
        """Take what is shown; nothing is written yet."""
        self._subject, self._size = subject, size_of(subject.boat)
        self._entities = tuple(entities(subject, self._size))
        self._lanes = {lane.path: lane for lane in lanes_of(subject.boat)}
        self._begun: set[str] = set()  # lanes that have had a word
        self._changes = Changes()
        self._track = Track(self._size.length / FINE)
        self._every = max(round(DRAWN / subject.step), 1)  # ticks from picture to picture of ships

    def save(self, path: Path) -> None:
        """Begin a file with what is the same at all times. The file is replaced."""
        path.open("wb").close()  # tells better than the library why it cannot be written
        self._open()
        rr.save(path, default_blueprint=blueprint(self._subject), recording=self._stream)
        self._begin()

    def connect(self, host: str, port: int) -> None:
        """Send a viewer what is the same at all times."""
        url, layout = f"rerun+http://{host}:{port}/proxy", blueprint(self._subject)
        self._open()
        rr.connect_grpc(url, default_blueprint=layout, recording=self._stream)
        self._begin()

    def _open(self) -> None:
        self._stream = rr.RecordingStream(APPLICATION)
        rr.send_recording_name(self._subject.title, recording=self._stream)

    def _begin(self) -> None:
        for path, archetype in constants(self._subject, self._size):
            self._fix(path, archetype)

    def write(self, batch: Batch) -> None:
        """Write a batch, and bring it out; RuntimeError if the viewer is gone."""
        block = batch.block
        if block.times.ticks.size:
            for entity in self._entities:
                values = entity.read(block)
                rows = entity.always | self._changes.of(entity.path, values)
                if rows.any():
                    self._send(entity.path, block.times.at(rows), entity.draw(values[rows]))
            for times, strips in self._track.pieces(block):
                self._send(TRACK, times, wake(strips, self._size))
            self._write_ships(block)
            for lane in casualty_lanes(block):
                self._lanes.setdefault(lane.path, lane)
            for lane in self._lanes.values():
                self._write_lane(lane, block)
        if batch.worked.times.ticks.size:
            self._send(LEDGER, batch.worked.times, scalars(ledger_columns(batch.worked)))
        self._write_news(batch.told)
        self._stream.flush()

    def close(self) -> None:
        """End the recording; a file is then complete, a viewer keeps what it has."""
        self._stream.disconnect()

    def _fix(self, path: str, archetype: Any) -> None:
        """Write what an entity is at all times."""
        rr.log(path, archetype, static=True, recording=self._stream, strict=True)

    def _send(self, path: str, times: Times, columns: Columns) -> None:
        """Write what an entity is at each of the times."""
        when = (
            rr.TimeColumn(STEP, sequence=times.ticks),
            rr.TimeColumn(SECONDS, duration=times.seconds),
        )
        rr.send_columns(path, when, columns, recording=self._stream, strict=True)

    def _write_ships(self, block: Block) -> None:
        """Show where ships were, and where they went."""
        contacts = contacts_in(self._subject.boat)
        rows = block.times.ticks % self._every == 0
        if contacts is not None and contacts.any and rows.any():
            times = block.times.at(rows)
            seen = [contacts.seen(tick) for tick in times.ticks.tolist()]
            for path, columns in ship_columns(seen):
                self._send(path, times, columns)

    def _write_lane(self, lane: Lane, block: Block) -> None:
        """Write where a lane has another word; it begins with its first."""
        codes = lane.codes(block)
        rows = self._changes.of(lane.path, codes)
        words = [lane.word(code) for code in codes[rows].tolist()]
        if lane.path not in self._begun:
            if not any(words):
                return
            self._begun.add(lane.path)
            if lane.colours:
                values, colours = list(lane.colours), list(lane.colours.values())
                look = rr.StateConfiguration(values=values, labels=values, colors=colours)
                self._fix(lane.path, look)
        if words:
            self._send(lane.path, block.times.at(rows), rr.StateChange.columns(state=words))

    def _write_news(self, told: Told) -> None:
        kinds = np.array(told.kinds)
        for kind in dict.fromkeys(told.kinds):
            rows = kinds == kind
            texts = [text for text, here in zip(told.texts, rows, strict=True) if here]
            levels = [LEVELS.get(kind, "INFO")] * len(texts)
            columns = rr.TextLog.columns(text=texts, level=levels)
            self._send(f"log/{kind}", told.times.at(rows), columns)


def wake(strips: NDArray[np.float32], size: Size) -> Columns:
    """Return the columns of pieces of the track."""
    return rr.LineStrips3D.columns(
        strips=strips,
        colors=np.full(len(strips), colour_code(WAKE), np.uint32),
        radii=np.full(len(strips), 0.004 * size.length),
    )


def ship_columns(seen: Sequence[Sequence[Seen]]) -> Iterator[tuple[str, Columns]]:
    """Yield columns of points and arrows for the ships at some ticks, by paths.

    A ship's label is its name with its course and speed over the ground.
    """
    counts = np.array([len(each) for each in seen], np.int32)
    ships = [ship for each in seen for ship in each]
    places = np.array([(ship.north, ship.east, 0.0) for ship in ships]).reshape(-1, 3)
    sailed = [(AHEAD * ship.speed, ship.course) for ship in ships]
    ways = [(way * math.cos(course), way * math.sin(course), 0.0) for way, course in sailed]
    colours = np.full(len(ships), colour_code(SHIP), np.uint32)
    courses = [round(math.degrees(ship.course)) % 360 for ship in ships]
    labels = [
        f"{ship.name} {course:03d} {ship.speed / KNOT:.1f} kn"
        for ship, course in zip(ships, courses, strict=True)
    ]
    radii = [0.25 * ship.length for ship in ships]
    points = rr.Points3D.columns(positions=places, labels=labels, radii=radii, colors=colours)
    yield SHIPS, points.partition(counts)
    vectors = np.array(ways).reshape(-1, 3)
    arrows = rr.Arrows3D.columns(origins=places, vectors=vectors, colors=colours)
    yield COURSES, arrows.partition(counts)


def blueprint(subject: Subject) -> Any:
    """Return the layout of the viewer's panes."""
    shown = {chart.name: view(chart.path, chart.title) for chart in charts_of(subject.boat)}
    above = [shown.pop(name) for name in ALWAYS]
    others = rrb.Tabs(*shown.values(), view(LEDGER, "ticks [us]"))
    log_columns = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
    happened = rrb.Horizontal(
        rrb.TextLogView(origin="/log", name="log", columns=log_columns),
        rrb.StateTimelineView(
            origin="/lanes", name="state", time_view=rrb.TimeAxis(view_range=WHOLE)
        ),
        column_shares=[1, 1],
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene(subject.length), happened, row_shares=[3, 2]),
            rrb.Vertical(*above, others),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=SECONDS, play_state="following"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )


def view(path: str, name: str) -> Any:
    """Return the view of a chart."""
    return rrb.TimeSeriesView(
        origin=path,
        name=name,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        axis_x=rrb.TimeAxis(view_range=WHOLE),
    )


def scene(length: float) -> Any:
    """Return the view of the boat, by an eye that follows it."""
    sailed = rrb.VisibleTimeRanges(
        rrb.VisibleTimeRange(
            SECONDS,
            start=rrb.TimeRangeBoundary.infinite(),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        )
    )
    return rrb.Spatial3DView(
        origin=FOLLOWER,  # seen from there, all else moves past
        contents=f"/{WORLD}/**",
        name="boat",
        overrides={TRACK: sailed},
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=tuple(length * part for part in EYE),
            look_target=(0.0, 0.0, 0.0),
            eye_up=(0.0, 0.0, -1.0),
        ),
        line_grid=False,
        background=(8, 16, 28, 255),
    )
