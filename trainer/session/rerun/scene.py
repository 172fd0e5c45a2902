"""The scene: the boat, its moving parts, track, sea, ground, ships, depths that count.

The world is north, east and down [m], with its origin where the run's is. What surrounds the boat
follows the boat in whole squares of its grid, so that the boat is seen to move through it.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import Seen, contacts_in
from trainer.boat.world.scope import periscope_of
from trainer.config.bottom import Bottom, depths_at
from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Block, Changes, Subject, Track
from trainer.session.rerun.charts import depth_kept
from trainer.session.rerun.outlet import Outlet
from trainer.session.rerun.sdk import rr
from trainer.session.rerun.shape import Mesh, fins_of, hull_mesh, mast_mesh, sail_mesh, size_of
from trainer.units import KNOT

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


class Scene:
    """The boat in its world, written block by block."""

    def __init__(self, subject: Subject, outlet: Outlet) -> None:
        """Take what is shown and where; nothing is written yet."""
        self._subject, self._outlet = subject, outlet
        self._size = size_of(subject.boat)
        self._fins = fins_of(subject.boat, self._size)
        self._square = self._size.length
        self._changes = Changes()
        self._track = Track(self._size.length / FINE)
        self._ground = ground_under(subject.boat)
        self._scope = periscope_of(subject.boat)
        self._every = max(round(DRAWN / subject.step), 1)  # ticks

    def begin(self) -> None:
        """Write what is the same at all times."""
        fix, size = self._outlet.fix, self._size
        fix(WORLD, rr.ViewCoordinates.FRD)
        fix(FOLLOWER, rr.ViewCoordinates.FRD)
        fix(f"{BOAT}/hull", draw_mesh(hull_mesh(size), HULL))
        if size.sail is not None:
            fix(f"{BOAT}/sail", draw_mesh(sail_mesh(size, size.sail), SAIL))
        for fin in self._fins:
            fix(f"{BOAT}/{fin.name}/shape", draw_mesh(fin.mesh, MOVING))
        if self._scope and self._scope.fitted:
            extension = self._scope.fitted.extension_m
            fix(f"{MAST}/shape", draw_mesh(mast_mesh(size, extension), MOVING))
        self._begin_surroundings()

    def write(self, block: Block) -> None:
        """Write a block."""
        send, times = self._outlet.send, block.times
        place = block.several("x", "y", "z")
        turned = quaternions(block["phi"], block["theta"], block["psi"])
        send(FOLLOWER, times, rr.Transform3D.columns(translation=place))
        send(BOAT, times, rr.Transform3D.columns(translation=place, quaternion=turned))
        for fin in self._fins:
            angle = fin.angle(block)
            rows = self._changes.of(fin.name, angle)
            columns = rr.Transform3D.columns(
                translation=np.tile(fin.stock, (int(rows.sum()), 1)),
                quaternion=half_turned(fin.outward, angle[rows]),
            )
            self._send(f"{BOAT}/{fin.name}", block, rows, columns)
        self._write_mast(block)
        for times, strips in self._track.pieces(block):
            colours = np.full(len(strips), colour_code(WAKE), np.uint32)
            radii = np.full(len(strips), 0.004 * self._size.length)
            columns = rr.LineStrips3D.columns(strips=strips, colors=colours, radii=radii)
            send(TRACK, times, columns)
        self._write_surroundings(block, place)
        self._write_ships(block)

    def _write_mast(self, block: Block) -> None:
        """Show how far the periscope's mast is out of the sail."""
        if self._scope is None or self._scope.fitted is None:
            return
        ticks = block.times.ticks.tolist()
        heads = [self._scope.head(self._scope.at(tick)) for tick in ticks]
        extension = self._scope.fitted.extension_m
        feet = np.array([(x, 0.0, z + extension) for x, z in heads]).reshape(-1, 3)
        rows = self._changes.of(MAST, feet)
        self._send(MAST, block, rows, rr.Transform3D.columns(translation=feet[rows]))

    def _send(self, path: str, block: Block, rows: Any, columns: Any) -> None:
        if rows.any():
            self._outlet.send(path, block.times.at(rows), columns)

    def _begin_surroundings(self) -> None:
        """Write the sea about the boat, and the depths that are not to be passed."""
        fix, reach = self._outlet.fix, SQUARES * self._square
        fix(f"{SEA}/surface", draw_mesh(square(reach), WATER))
        if self._ground:
            triangles = level_triangles(2 * SQUARES + 1)
            fix(GROUND, rr.Mesh3D.from_fields(triangle_indices=triangles, albedo_factor=SAND))
        lines = grid(reach, self._square)
        fix(f"{SEA}/grid", rr.LineStrips3D(lines, colors=GRID, radii=0.0015 * self._square))
        for name, depth in depths(self._subject).items():
            frame = rr.LineStrips3D(
                [outline(reach, depth)],
                colors=FORBIDDEN,
                radii=0.006 * self._square,
                labels=f"{name} {depth:g} m",
            )
            fix(f"{NEAR}/{name.replace(' ', '_')}", frame)

    def _write_surroundings(self, block: Block, place: Numbers) -> None:
        """Let the surroundings follow it, the sea rise and fall, and the ordered depth show."""
        near = np.zeros_like(place)
        near[:, :2] = self._square * np.round(place[:, :2] / self._square)
        rows = self._changes.of(NEAR, near)
        self._send(NEAR, block, rows, rr.Transform3D.columns(translation=near[rows]))
        if self._ground and rows.any():
            self._send(GROUND, block, rows, self._grounds(self._ground, near[rows]))

        level = np.zeros_like(place)
        level[:, 2] = -block["eta_wave"]
        rows = self._changes.of(SEA, level)
        self._send(SEA, block, rows, rr.Transform3D.columns(translation=level[rows]))

        depth = np.where(depth_kept(block) > 0.0, block["ordered_depth"], -np.inf)
        rows = self._changes.of(ORDERED, depth)
        if rows.any():
            self._send(ORDERED, block, rows, self._ordered(depth[rows]))

    def _grounds(self, ground: Bottom, places: Numbers) -> Any:
        """Return the columns of the ground about each of the places."""
        offsets = np.linspace(-SQUARES, SQUARES, 2 * SQUARES + 1) * self._square
        triangles = level_triangles(offsets.size)
        north, east = (each.ravel() for each in np.meshgrid(offsets, offsets, indexing="ij"))
        meshes = [
            Mesh(
                np.column_stack((north, east, depths_at(ground, north + n, east + e))).astype(
                    np.float32
                ),
                triangles,
            )
            for n, e in places[:, :2].tolist()
        ]
        columns = rr.Mesh3D.columns(
            vertex_positions=np.concatenate([mesh.points for mesh in meshes]),
            vertex_normals=np.concatenate([mesh.normals() for mesh in meshes]),
        )
        return columns.partition(np.full(len(meshes), north.size, np.int32))

    def _write_ships(self, block: Block) -> None:
        """Show where ships were, and where they went."""
        contacts = contacts_in(self._subject.boat)
        if contacts is None or not contacts.any:
            return
        rows = block.times.ticks % self._every == 0
        seen = [contacts.seen(tick) for tick in block.times.ticks[rows].tolist()]
        if seen:
            for path, columns in ship_columns(seen):
                self._send(path, block, rows, columns)

    def _ordered(self, depths: Numbers) -> Any:
        """Return the columns of the ordered depth, empty where none is kept."""
        kept = np.isfinite(depths)
        reach = 0.5 * SQUARES * self._square
        strips = [outline(reach, float(depth)) for depth in depths[kept]]
        words = [f"ordered {depth:g} m" for depth in depths[kept]]
        count = len(strips)
        columns = rr.LineStrips3D.columns(
            strips=strips,
            labels=words,
            colors=np.full(count, colour_code(ASKED), np.uint32),
            radii=np.full(count, 0.006 * self._square),
        )
        return columns.partition(kept.astype(np.int32))


def ship_columns(seen: Sequence[Sequence[Seen]]) -> Iterator[tuple[str, Any]]:
    """Yield columns of points and arrows for the ships at some ticks, by paths."""
    counts = np.array([len(each) for each in seen], np.int32)
    ships = [ship for each in seen for ship in each]
    places = np.array([(ship.north, ship.east, 0.0) for ship in ships]).reshape(-1, 3)
    sailed = [AHEAD * ship.speed for ship in ships]
    ways = [
        (way * math.cos(ship.course), way * math.sin(ship.course), 0.0)
        for way, ship in zip(sailed, ships, strict=True)
    ]
    colours = np.full(len(ships), colour_code(SHIP), np.uint32)
    points = rr.Points3D.columns(
        positions=places,
        labels=[ship_label(ship) for ship in ships],
        radii=[0.25 * ship.length for ship in ships],
        colors=colours,
    )
    yield SHIPS, points.partition(counts)
    arrows = rr.Arrows3D.columns(
        origins=places, vectors=np.array(ways).reshape(-1, 3), colors=colours
    )
    yield COURSES, arrows.partition(counts)


def ship_label(ship: Seen) -> str:
    """Return what a ship is called, with its course and speed over the ground."""
    course = round(math.degrees(ship.course)) % 360
    return f"{ship.name} {course:03d} {ship.speed / KNOT:.1f} kn"


def depths(subject: Subject) -> dict[str, float]:
    """Return the depths [m] that are not to be passed, by what they are."""
    named = {
        "limit": subject.limits.depth_m_max,
        "upper limit": subject.limits.depth_m_min,
        "deepest allowed": subject.boat.file.hull.max_depth_m,
    }
    return {name: depth for name, depth in named.items() if depth is not None}


def draw_mesh(mesh: Mesh, colour: Colour) -> Any:
    """Return a mesh in a colour."""
    return rr.Mesh3D(
        vertex_positions=mesh.points,
        triangle_indices=mesh.triangles,
        vertex_normals=mesh.normals(),
        albedo_factor=colour,
    )


def square(reach: float) -> Mesh:
    """Return a level square about the origin, so far [m] to each side."""
    corners = [
        (-reach, -reach, 0.0),
        (reach, -reach, 0.0),
        (reach, reach, 0.0),
        (-reach, reach, 0.0),
    ]
    return Mesh(np.array(corners, np.float32), np.array([(0, 1, 2), (0, 2, 3)], np.uint32))


def level_triangles(count: int) -> NDArray[np.uint32]:
    """Return the triangles of a square lattice, by its points to a side."""
    corner = np.arange(count * (count - 1), dtype=np.uint32).reshape(-1, count)[:, :-1].ravel()
    north, east = corner + count, corner + 1
    pairs = ((corner, east, north), (east, north + 1, north))
    return np.concatenate([np.stack(each, axis=1) for each in pairs]).astype(np.uint32)


def outline(reach: float, depth: float) -> Numbers:
    """Return the outline of a level square at a depth [m]."""
    sides = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * reach
    return np.column_stack((sides, np.full(len(sides), depth)))


def grid(reach: float, step: float) -> NDArray[np.float32]:
    """Return the lines of a level grid about the origin."""
    offsets = np.arange(-reach, reach + 0.5 * step, step)
    ends = np.array([-reach, reach])
    along = np.zeros((offsets.size, 2, 3), np.float32)
    along[:, :, 0], along[:, :, 1] = ends, offsets[:, None]
    return np.concatenate((along, along[:, :, [1, 0, 2]]))


def quaternions(phi: Numbers, theta: Numbers, psi: Numbers) -> Numbers:
    """Return the attitude as quaternions x, y, z, w: heading, then pitch, then heel [rad]."""
    c_r, s_r = np.cos(0.5 * phi), np.sin(0.5 * phi)
    c_p, s_p = np.cos(0.5 * theta), np.sin(0.5 * theta)
    c_y, s_y = np.cos(0.5 * psi), np.sin(0.5 * psi)
    return np.stack(
        (
            s_r * c_p * c_y - c_r * s_p * s_y,
            c_r * s_p * c_y + s_r * c_p * s_y,
            c_r * c_p * s_y - s_r * s_p * c_y,
            c_r * c_p * c_y + s_r * s_p * s_y,
        ),
        axis=1,
    )


def half_turned(axis: tuple[float, float, float], angle: Numbers) -> Numbers:
    """Return turns [rad] about a unit axis as quaternions x, y, z, w."""
    return np.column_stack((np.outer(np.sin(0.5 * angle), axis), np.cos(0.5 * angle)))


def colour_code(colour: Colour) -> int:
    """Return a colour as Rerun's columns take it."""
    return int.from_bytes(bytes(colour), "big")
