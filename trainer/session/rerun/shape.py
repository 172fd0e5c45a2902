"""The boat as a shape: hull, sail and moving surfaces, by its vessel file.

``drawing`` shows it. It is a picture and no drawing of the hull. Lengths and heights are the
file's, or estimated from the displacement where it gives none. Surfaces stand where their lift acts
by the coefficients. Body axes: x forward, y starboard, z down, from the body's origin [m].
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Block

HULL_RINGS, RING_POINTS = 33, 32  # of the hull's mesh
NOSE_LENGTH, TAIL_LENGTH = 0.17, 0.36  # [-] of the length: the rounded nose, the tapering tail
PRISMATIC_COEFFICIENT: Final = 0.8  # [-] volume of a hull over that of its cylinder
SAIL_CHORD, SAIL_BREADTH = 0.15, 0.25  # [-] of the length, of the beam
MAST_CHORD: Final = 0.008  # [-] of the length: a mast with its fairing
FIN_CHORD, FIN_THICKNESS = 0.055, 0.12  # [-] of the length, of the chord
FOIL_POINTS: Final = 12  # points along each side of a foil
SQRT_HALF: Final = math.sqrt(0.5)
# where each fin of a tail points to, outward
CRUCIFORM_FINS: Final = {
    "rudder_upper": (0.0, 0.0, -1.0),
    "rudder_lower": (0.0, 0.0, 1.0),
    "stern_port": (0.0, -1.0, 0.0),
    "stern_starboard": (0.0, 1.0, 0.0),
}
X_TAIL_FINS: Final = {
    f"tail_{height}_{side}": (0.0, y * SQRT_HALF, z * SQRT_HALF)
    for height, z in (("upper", -1.0), ("lower", 1.0))
    for side, y in (("port", -1.0), ("starboard", 1.0))
}
BOW_FINS: Final = {"bow_port": (0.0, -1.0, 0.0), "bow_starboard": (0.0, 1.0, 0.0)}


class Mesh(NamedTuple):
    """A surface of triangles."""

    points: NDArray[np.float32]  # [m] three to a point
    triangles: NDArray[np.uint32]  # three points to a triangle

    def normals(self) -> NDArray[np.float32]:
        """Return at each point the mean direction outward of the triangles that meet there."""
        corner = self.points[self.triangles]
        across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        total = np.zeros_like(self.points)
        for k in range(3):
            np.add.at(total, self.triangles[:, k], across)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return (total / np.where(length > 0.0, length, 1.0)).astype(np.float32)


@dataclass(frozen=True)
class Sail:
    """Where the sail is [m]."""

    x: float  # of its middle
    top: float  # z
    chord: float
    breadth: float


@dataclass(frozen=True)
class Size:
    """How large the hull is and where it lies [m]."""

    length: float
    beam: float
    height: float
    nose: float  # x
    axis: float  # z
    sail: Sail | None

    @property
    def stern(self) -> float:
        """Return x of the end of the tail."""
        return self.nose - self.length


@dataclass(frozen=True, eq=False)
class Fin:
    """A moving surface: its shape about its own stock, and where that stands."""

    name: str
    mesh: Mesh
    stock: tuple[float, float, float]  # [m]
    outward: tuple[float, float, float]
    turn: tuple[float, float]  # trailing edge to port and down, a unit of delta_r and of the plane
    plane: str  # whose deflection turns it beside the rudder's

    def angle(self, block: Block) -> Numbers:
        """Return how far [rad] it is turned about its outward axis.

        Fins of an X-tail are turned by rudder and stern planes at once.
        """
        port, down = self.turn
        _, y, z = np.sign(self.outward)
        turned: Numbers = z * port * block["delta_r"] + y * down * block[self.plane]
        return turned


def size_of(boat: Boat) -> Size:
    """Return the size of the boat."""
    hull, c = boat.file.hull, boat.vessel
    displaced = float(c.buoyancy / (c.rho * c.g))
    round_hull = math.sqrt(4.0 * displaced / (math.pi * PRISMATIC_COEFFICIENT * hull.length))
    beam = hull.beam or hull.diameter or round_hull
    height = hull.height_to_deck or hull.diameter or beam
    nose = hull.cg[0] + (hull.cg_from_nose or 0.5 * hull.length)
    if hull.height_to_sail_top is None or hull.cg_below_sail_top is None:
        return Size(hull.length, beam, height, nose, 0.0, None)
    top = float(c.z_sail)
    axis = top + hull.height_to_sail_top - 0.5 * height
    chord = SAIL_CHORD * hull.length
    sail = Sail(float(c.x_sail), top, chord, SAIL_BREADTH * beam)
    return Size(hull.length, beam, height, nose, axis, sail)


def hull_mesh(size: Size) -> Mesh:
    """Return the hull: elliptical sections, a rounded nose, a tail that tapers to a point."""
    along = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, HULL_RINGS)))  # [-] from nose to stern
    ahead = np.clip(1.0 - along / NOSE_LENGTH, 0.0, 1.0)
    aft = np.clip((along - (1.0 - TAIL_LENGTH)) / TAIL_LENGTH, 0.0, 1.0)
    fullness = np.sqrt(1.0 - ahead**2) * (1.0 - aft**2)
    round_about = np.linspace(0.0, 2.0 * np.pi, RING_POINTS, endpoint=False)
    points = np.empty((HULL_RINGS, RING_POINTS, 3), np.float32)
    points[:, :, 0] = (size.nose - along * size.length)[:, None]
    points[:, :, 1] = 0.5 * size.beam * fullness[:, None] * np.cos(round_about)
    points[:, :, 2] = size.axis + 0.5 * size.height * fullness[:, None] * np.sin(round_about)
    return Mesh(points.reshape(-1, 3), _tube(HULL_RINGS, RING_POINTS))


def sail_mesh(size: Size, sail: Sail) -> Mesh:
    """Return the sail. Its foot is inside the hull."""
    return _foil(sail.chord, sail.breadth, size.axis - sail.top, sail.x, (0.0, 0.0, sail.top))


def mast_mesh(size: Size, extension: float) -> Mesh:
    """Return a periscope's mast of a length [m], its foot in the origin."""
    chord = MAST_CHORD * size.length
    return _foil(chord, 0.5 * chord, extension, 0.0, (0.0, 0.0, -extension))


def fins_of(boat: Boat, size: Size) -> tuple[Fin, ...]:
    """Return the moving surfaces that the boat has."""
    toward, limit = boat.toward, boat.vessel.limit
    # a surface that turns the boat right has its trailing edge to starboard; one that makes its bow
    # rise from aft has it up, one that lifts its bow has it down
    tail = -toward["rudder"], -toward["stern"]
    outward = X_TAIL_FINS if boat.file.surfaces.tail == "x" else CRUCIFORM_FINS
    fins = [_tail_fin(boat, size, name, axis, tail) for name, axis in outward.items()]
    if toward["bow"] and limit[2] > 0.0:
        fins += [_bow_fin(boat, size, name, toward["bow"]) for name in BOW_FINS]
    return tuple(fins)


def _tail_fin(
    boat: Boat,
    size: Size,
    name: str,
    outward: tuple[float, float, float],
    turn: tuple[float, float],
) -> Fin:
    """Return a fin of the tail; it reaches as far out as the hull amidships."""
    chord = FIN_CHORD * size.length
    coefficient = boat.file.coefficients
    x = _lever(coefficient["N_dr"], coefficient["Y_dr"], size)
    x = min(max(x, size.stern + chord), size.stern + TAIL_LENGTH * size.length)
    mesh = _fin_mesh(chord, 0.5 * size.height, outward)
    return Fin(name, mesh, (x, 0.0, size.axis), outward, turn, "delta_s")


def _bow_fin(boat: Boat, size: Size, name: str, down: float) -> Fin:
    """Return a bow plane, on the sail where its lift acts there."""
    chord = FIN_CHORD * size.length
    coefficient = boat.file.coefficients
    x = _lever(-coefficient["M_db"], coefficient["Z_db"], size)
    x = min(max(x, 0.0), size.nose - NOSE_LENGTH * size.length)
    z, span = size.axis, 0.75 * size.beam
    sail = size.sail
    if sail is not None and abs(x - sail.x) < sail.chord:
        x = min(max(x, sail.x - 0.25 * sail.chord), sail.x + 0.25 * sail.chord)
        z = 0.5 * (sail.top + size.axis - 0.5 * size.height)
        span = 0.45 * size.beam
    outward = BOW_FINS[name]
    return Fin(name, _fin_mesh(chord, span, outward), (x, 0.0, z), outward, (0.0, down), "delta_b")


def _lever(moment: float, force: float, size: Size) -> float:
    """Return x [m] where a surface's lift acts, by its two coefficients; the stern without any."""
    return moment / force * size.length if force else size.stern


def _fin_mesh(chord: float, span: float, outward: tuple[float, float, float]) -> Mesh:
    """Return a fin from its foot on the axis out to its tip."""
    tip = tuple(span * part for part in outward)
    return _foil(chord, FIN_THICKNESS * chord, span, 0.0, (0.0, tip[1], tip[2]))


def _foil(
    chord: float, breadth: float, span: float, x: float, tip: tuple[float, float, float]
) -> Mesh:
    """Return a straight foil with its tip at y, z and its foot one span [m] inward, capped."""
    outward = np.array([0.0, tip[1], tip[2]])
    outward /= np.linalg.norm(outward) or 1.0
    across = np.array([0.0, -outward[2], outward[1]])
    turned = np.linspace(0.0, 2.0 * np.pi, 2 * FOIL_POINTS, endpoint=False)
    fore, side = 0.5 * np.cos(turned), 0.5 * np.sin(turned)
    taper = np.sqrt(0.5 + fore)  # round in front, sharp behind
    section = np.outer(breadth * side * taper, across)
    section[:, 0] = x + chord * fore
    outer = section + np.array([0.0, tip[1], tip[2]])
    inner = outer - span * outward
    middle = outer.mean(axis=0, keepdims=True)
    points = np.concatenate((inner, outer, middle)).astype(np.float32)
    count = 2 * FOIL_POINTS
    rim = np.arange(count, dtype=np.uint32)
    cap = np.stack((count + rim, count + (rim + 1) % count, np.full(count, 2 * count)), axis=1)
    return Mesh(points, np.concatenate((_tube(2, count), cap.astype(np.uint32))))


def _tube(rings: int, around: int) -> NDArray[np.uint32]:
    """Return the triangles between rings of points that follow one another."""
    ring, step = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    here, beside = ring * around + step, ring * around + (step + 1) % around
    one = np.stack((here, here + around, beside), axis=-1)
    other = np.stack((beside, here + around, beside + around), axis=-1)
    return np.concatenate((one.reshape(-1, 3), other.reshape(-1, 3))).astype(np.uint32)


# What surrounds the boat, and turns.


def square(reach: float) -> Mesh:
    """Return a level square about the origin, so far [m] to each side."""
    corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    points = (reach * np.array(corners)).astype(np.float32)
    return Mesh(points, np.array([(0, 1, 2), (0, 2, 3)], np.uint32))


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
    along = np.zeros((offsets.size, 2, 3), np.float32)
    along[:, :, 0], along[:, :, 1] = (-reach, reach), offsets[:, None]
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
