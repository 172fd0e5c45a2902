"""The drawing of one run, by one table of what there is to see.

``request`` makes it for a viewer or a file. The world is north, east and down [m], with its origin
where the run's is. What surrounds the boat follows the boat in whole squares of its grid, so that
the boat is seen to move through it.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.readings import is_depth_kept
from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.boat.world.scope import Periscope, periscope_of
from trainer.config.world.bottom import Bottom, depths_at
from trainer.core.kernel import Numbers
from trainer.io.outputs import open_output
from trainer.session.rerun.batch import Batch, Block, Changes, NewsRows, Subject, Times, Track
from trainer.session.rerun.charts import (
    LEDGER_LABELS,
    LEDGER_PATH,
    Lane,
    casualty_lanes,
    charts_of,
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

APPLICATION_NAME: Final = "trainer"
TICK_TIMELINE, TIME_TIMELINE = "tick", "time"  # names of the time lines
MAIN_CHARTS: Final = ("depth", "heading", "surfaces")  # charts below one another; the rest are tabs
EYE_OFFSET: Final = (-1.0, -0.75, -0.3)  # [-] of its length: astern, to port and above
WHOLE_RANGE: Final = rr.TimeRange(
    start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.infinite()
)
WORLD_PATH, BOAT_PATH, FOLLOWER_PATH, TRACK_PATH = (
    "world",
    "world/boat",
    "world/follower",
    "world/track",
)
MAST_PATH = "world/boat/mast"
NEAR_PATH, SEA_PATH, ORDERED_PATH = "world/near", "world/near/sea", "world/near/ordered"
GROUND_PATH, SHIPS_PATH, COURSES_PATH = "world/near/ground", "world/ships", "world/ships/courses"
GRID_SQUARES: Final = 6  # of the grid, from the boat to the end of the sea
TRACK_PIECES: Final = 8  # pieces of the track to a length of the boat
SHIP_PERIOD_S: Final = 1.0  # [s] from one picture of the ships to the next
ARROW_TIME_S: Final = 60.0  # [s] of the way that a ship's arrow shows
Colour = tuple[int, int, int, int]
HULL_COLOUR: Final[Colour] = (96, 104, 112, 255)
SAIL_COLOUR: Final[Colour] = (80, 88, 96, 255)
MOVING_COLOUR: Final[Colour] = (213, 94, 0, 255)
WATER_COLOUR: Final[Colour] = (86, 180, 233, 40)
GRID_COLOUR: Final[Colour] = (86, 180, 233, 110)
ORDERED_COLOUR: Final[Colour] = (230, 159, 0, 255)
FORBIDDEN_COLOUR: Final[Colour] = (204, 121, 167, 255)
SAND_COLOUR: Final[Colour] = (148, 128, 96, 255)
SHIP_COLOUR: Final[Colour] = (0, 158, 115, 255)
WAKE_COLOUR: Final[Colour] = (240, 228, 66, 255)
# Okabe and Ito (2008), in the order of their contrast with a dark ground
CHART_COLOURS: Final = (
    (86, 180, 233),
    (230, 159, 0),
    (0, 158, 115),
    (240, 228, 66),
    (204, 121, 167),
    (213, 94, 0),
    (240, 240, 240),
    (0, 114, 178),
)
WARNING_KINDS: Final = ("watch", "pilot", "plant", "depth", "mark")  # kinds of news
LOG_LEVELS: Final = {"trouble": "ERROR"} | dict.fromkeys(WARNING_KINDS, "WARN")  # by kind of news

Columns = Any  # of the library, whose makers give no type


class Entity(NamedTuple):
    """A drawn thing: its path, the reader of its numbers, and its columns."""

    path: str
    read: Callable[[Block], Numbers] | None = None  # None: it is the same at all times
    draw: Callable[[Numbers], Columns] = lambda _: ()
    always: bool = False  # at every tick; otherwise where it changes
    fixed: Any = None  # what it is at all times


def shift_columns(shifts: Numbers) -> Columns:
    """Return the columns of a thing that has moved."""
    return rr.Transform3D.columns(translation=shifts)


def scalars(columns: Numbers) -> Columns:
    """Return one number for each line at each row."""
    rows, count = columns.shape
    whole = rr.Scalars.columns(scalars=np.ascontiguousarray(columns).reshape(-1))
    return whole.partition(np.full(rows, count))


def entities(subject: Subject, size: Size) -> Iterator[Entity]:
    """Yield all drawn things: the boat with its parts, its surroundings, charts."""
    boat, length, reach = subject.boat, size.length, GRID_SQUARES * size.length
    yield Entity(WORLD_PATH, fixed=rr.ViewCoordinates.FRD)
    yield Entity(FOLLOWER_PATH, origin_of, shift_columns, always=True, fixed=rr.ViewCoordinates.FRD)
    yield Entity(BOAT_PATH, pose_of, pose_columns, always=True)
    yield Entity(f"{BOAT_PATH}/hull", fixed=draw_mesh(hull_mesh(size), HULL_COLOUR))
    if size.sail is not None:
        yield Entity(f"{BOAT_PATH}/sail", fixed=draw_mesh(sail_mesh(size, size.sail), SAIL_COLOUR))
    for fin in fins_of(boat, size):
        yield Entity(f"{BOAT_PATH}/{fin.name}", fin.angle, partial(turn_columns, fin))
        yield Entity(f"{BOAT_PATH}/{fin.name}/shape", fixed=draw_mesh(fin.mesh, MOVING_COLOUR))
    scope = periscope_of(boat)
    if scope and scope.fitted:
        extension = scope.fitted.extension_m
        yield Entity(MAST_PATH, partial(feet_of, scope, extension), shift_columns)
        yield Entity(
            f"{MAST_PATH}/shape", fixed=draw_mesh(mast_mesh(size, extension), MOVING_COLOUR)
        )
    near = partial(square_of, length)
    yield Entity(NEAR_PATH, near, shift_columns)
    if ground := ground_under(boat):
        triangles = level_triangles(2 * GRID_SQUARES + 1)
        sand = rr.Mesh3D.from_fields(triangle_indices=triangles, albedo_factor=SAND_COLOUR)
        yield Entity(GROUND_PATH, near, partial(grounds, ground, size), fixed=sand)
    yield Entity(SEA_PATH, level_of, shift_columns)
    yield Entity(f"{SEA_PATH}/surface", fixed=draw_mesh(square(reach), WATER_COLOUR))
    squares = rr.LineStrips3D(grid(reach, length), colors=GRID_COLOUR, radii=0.0015 * length)
    yield Entity(f"{SEA_PATH}/grid", fixed=squares)
    depths = {
        "limit": subject.limits.depth_m_max,
        "upper limit": subject.limits.depth_m_min,
        "deepest allowed": boat.file.hull.max_depth_m,
    }
    for name, depth in depths.items():
        if depth is not None:
            strips, label, radius = [outline(reach, depth)], f"{name} {depth:g} m", 0.006 * length
            frame = rr.LineStrips3D(strips, colors=FORBIDDEN_COLOUR, radii=radius, labels=label)
            yield Entity(f"{NEAR_PATH}/{name.replace(' ', '_')}", fixed=frame)
    yield Entity(ORDERED_PATH, ordered_of, partial(frames, size))
    for chart in charts_of(boat):
        yield Entity(chart.path, chart.columns, scalars, always=True, fixed=lines(chart.labels))
    yield Entity(LEDGER_PATH, fixed=lines(LEDGER_LABELS))


def origin_of(block: Block) -> Numbers:
    """Return where the boat is [m]."""
    return block.several("x", "y", "z")


def square_of(length: float, block: Block) -> Numbers:
    """Return the middle of the grid's square in which the boat is [m]."""
    return length * np.round(origin_of(block) / length) * (1.0, 1.0, 0.0)


def pose_of(block: Block) -> Numbers:
    """Return where the boat is [m], and the attitude as quaternions."""
    attitude = quaternions(block["phi"], block["theta"], block["psi"])
    return np.concatenate((origin_of(block), attitude), axis=1)


def pose_columns(poses: Numbers) -> Columns:
    """Return the columns of locations and attitudes."""
    return rr.Transform3D.columns(translation=poses[:, :3], quaternion=poses[:, 3:])


def turn_columns(fin: Fin, angle: Numbers) -> Columns:
    """Return the columns of a fin that is turned about its stock."""
    return pose_columns(
        np.column_stack((np.tile(fin.stock, (angle.size, 1)), half_turned(fin.outward, angle)))
    )


def feet_of(scope: Periscope, extension: float, block: Block) -> Numbers:
    """Return where the foot of the periscope's mast is, in the body's axes [m]."""
    heads = [scope.head(scope.at(tick)) for tick in block.times.ticks.tolist()]
    return np.array([(x, 0.0, z + extension) for x, z in heads]).reshape(-1, 3)


def level_of(block: Block) -> Numbers:
    """Return where the surface of the sea is about the boat [m]."""
    level = np.zeros((block.times.ticks.size, 3))
    level[:, 2] = -block["eta_wave"]
    return level


def ordered_of(block: Block) -> Numbers:
    """Return the ordered depth [m], minus infinity where none is kept."""
    return np.where(is_depth_kept(block.__getitem__), block["ordered_depth"], -np.inf)


def frames(size: Size, depths: Numbers) -> Columns:
    """Return the columns of the ordered depth, empty where none is kept."""
    is_ordered = np.isfinite(depths)
    count = int(is_ordered.sum())
    columns = rr.LineStrips3D.columns(
        strips=[
            outline(0.5 * GRID_SQUARES * size.length, float(depth)) for depth in depths[is_ordered]
        ],
        labels=[f"ordered {depth:g} m" for depth in depths[is_ordered]],
        colors=np.full(count, colour_code(ORDERED_COLOUR), np.uint32),
        radii=np.full(count, 0.006 * size.length),
    )
    return columns.partition(is_ordered.astype(np.int32))


def grounds(ground: Bottom, size: Size, locations: Numbers) -> Columns:
    """Return the columns of the ground about each of the locations."""
    offsets = np.linspace(-GRID_SQUARES, GRID_SQUARES, 2 * GRID_SQUARES + 1) * size.length
    north, east = (each.ravel() for each in np.meshgrid(offsets, offsets, indexing="ij"))
    triangles = level_triangles(offsets.size)
    depths = [depths_at(ground, north + n, east + e) for n, e in locations[:, :2].tolist()]
    points = [np.column_stack((north, east, each)).astype(np.float32) for each in depths]
    columns = rr.Mesh3D.columns(
        vertex_positions=np.concatenate(points),
        vertex_normals=np.concatenate([Mesh(each, triangles).normals() for each in points]),
    )
    return columns.partition(np.full(len(points), north.size, np.int32))


def lines(labels: Sequence[str]) -> Any:
    """Return the style of a chart's lines."""
    colours = [CHART_COLOURS[i % len(CHART_COLOURS)] for i in range(len(labels))]
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
    """One recording of Rerun's on its way out; for one thread only.

    A write raises the library's errors. A viewer that hangs holds a write up for as long.
    """

    def __init__(self, subject: Subject) -> None:
        """Take what is shown; nothing is written yet."""
        self._subject, self._size = subject, size_of(subject.boat)
        self._entities = tuple(entities(subject, self._size))
        self._lanes = {lane.path: lane for lane in lanes_of(subject.boat)}
        self._begun: set[str] = set()  # lanes that have had a word
        self._changes = Changes()
        self._track = Track(self._size.length / TRACK_PIECES)
        # ticks from picture to picture of ships
        self._every = max(round(SHIP_PERIOD_S / subject.step), 1)

    def save(self, path: Path) -> None:
        """Begin a file with what is the same at all times. The file is replaced."""
        open_output(path).close()  # tells better than the library why it cannot be written
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
        self._stream = rr.RecordingStream(APPLICATION_NAME)
        rr.send_recording_name(self._subject.title, recording=self._stream)

    def _begin(self) -> None:
        for entity in self._entities:
            if entity.fixed is not None:
                self._fix(entity.path, entity.fixed)

    def write(self, batch: Batch) -> None:
        """Write a batch, and bring it out; RuntimeError if the viewer is gone."""
        block = batch.block
        if block.times.ticks.size:
            for entity in self._entities:
                if entity.read is None:
                    continue
                values = entity.read(block)
                rows = entity.always | self._changes.of(entity.path, values)
                if rows.any():
                    self._send(entity.path, block.times.at(rows), entity.draw(values[rows]))
            for times, strips in self._track.pieces(block):
                self._send(TRACK_PATH, times, wake(strips, self._size))
            self._write_ships(block)
            for lane in casualty_lanes(block):
                self._lanes.setdefault(lane.path, lane)
            for lane in self._lanes.values():
                self._write_lane(lane, block)
        if batch.worked.times.ticks.size:
            self._send(LEDGER_PATH, batch.worked.times, scalars(ledger_columns(batch.worked)))
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
            rr.TimeColumn(TICK_TIMELINE, sequence=times.ticks),
            rr.TimeColumn(TIME_TIMELINE, duration=times.seconds),
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
        """Write the ticks at which the word of a lane changes."""
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

    def _write_news(self, told: NewsRows) -> None:
        kinds = np.array(told.kinds)
        for kind in dict.fromkeys(told.kinds):
            rows = kinds == kind
            texts = [text for text, here in zip(told.texts, rows, strict=True) if here]
            levels = [LOG_LEVELS.get(kind, "INFO")] * len(texts)
            columns = rr.TextLog.columns(text=texts, level=levels)
            self._send(f"log/{kind}", told.times.at(rows), columns)


def wake(strips: NDArray[np.float32], size: Size) -> Columns:
    """Return the columns of pieces of the track."""
    return rr.LineStrips3D.columns(
        strips=strips,
        colors=np.full(len(strips), colour_code(WAKE_COLOUR), np.uint32),
        radii=np.full(len(strips), 0.004 * size.length),
    )


def ship_columns(seen: Sequence[Sequence[ContactState]]) -> Iterator[tuple[str, Columns]]:
    """Yield columns of points and arrows for the ships at some ticks, by paths.

    A ship's label is its name with its course and speed over the ground.
    """
    counts = np.array([len(each) for each in seen], np.int32)
    ships = [ship for each in seen for ship in each]
    origins = np.array([(ship.north, ship.east, 0.0) for ship in ships]).reshape(-1, 3)
    sailed = [(ARROW_TIME_S * ship.speed, ship.course) for ship in ships]
    ways = [(way * math.cos(course), way * math.sin(course), 0.0) for way, course in sailed]
    colours = np.full(len(ships), colour_code(SHIP_COLOUR), np.uint32)
    courses = [round(math.degrees(ship.course)) % 360 for ship in ships]
    labels = [
        f"{ship.name} {course:03d} {ship.speed / KNOT:.1f} kn"
        for ship, course in zip(ships, courses, strict=True)
    ]
    radii = [0.25 * ship.length for ship in ships]
    points = rr.Points3D.columns(positions=origins, labels=labels, radii=radii, colors=colours)
    yield SHIPS_PATH, points.partition(counts)
    vectors = np.array(ways).reshape(-1, 3)
    arrows = rr.Arrows3D.columns(origins=origins, vectors=vectors, colors=colours)
    yield COURSES_PATH, arrows.partition(counts)


def blueprint(subject: Subject) -> Any:
    """Return the layout of the viewer's panes."""
    shown = {chart.name: view(chart.path, chart.title) for chart in charts_of(subject.boat)}
    above = [shown.pop(name) for name in MAIN_CHARTS]
    others = rrb.Tabs(*shown.values(), view(LEDGER_PATH, "ticks [us]"))
    log_columns = rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"])
    happened = rrb.Horizontal(
        rrb.TextLogView(origin="/log", name="log", columns=log_columns),
        rrb.StateTimelineView(
            origin="/lanes", name="state", time_view=rrb.TimeAxis(view_range=WHOLE_RANGE)
        ),
        column_shares=[1, 1],
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(scene(subject.length), happened, row_shares=[3, 2]),
            rrb.Vertical(*above, others),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIME_TIMELINE, play_state="following"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )


def view(path: str, name: str) -> Any:
    """Return the view of a chart."""
    return rrb.TimeSeriesView(
        origin=path,
        name=name,
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop),
        axis_x=rrb.TimeAxis(view_range=WHOLE_RANGE),
    )


def scene(length: float) -> Any:
    """Return the view of the boat, by an eye that follows it."""
    sailed = rrb.VisibleTimeRanges(
        rrb.VisibleTimeRange(
            TIME_TIMELINE,
            start=rrb.TimeRangeBoundary.infinite(),
            end=rrb.TimeRangeBoundary.cursor_relative(),
        )
    )
    return rrb.Spatial3DView(
        origin=FOLLOWER_PATH,  # seen from there, all else moves past
        contents=f"/{WORLD_PATH}/**",
        name="boat",
        overrides={TRACK_PATH: sailed},
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=tuple(length * part for part in EYE_OFFSET),
            look_target=(0.0, 0.0, 0.0),
            eye_up=(0.0, 0.0, -1.0),
        ),
        line_grid=False,
        background=(8, 16, 28, 255),
    )
