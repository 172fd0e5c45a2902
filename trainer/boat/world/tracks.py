"""The ways of ships in closed form: straights, turn circles, even acceleration.

``contacts`` moves ships without a rudder of their own by it. A way is cut into pieces that each
have one curvature and one acceleration. Where a ship is at a time follows from the piece of that
time alone, so there is no state to keep.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.config.world.contacts import SHIP_ACCELERATION_M_S2
from trainer.core.kernel import Numbers

MIN_TURN: Final = 1e-9  # [rad] change of course that needs no turn


class Stretch(NamedTuple):
    """A part of a path, and the speed [m/s] ordered from its beginning on. None: as before."""

    curvature: float  # [1/m] to starboard positive
    length: float  # [m]
    speed: float | None = None


class Piece(NamedTuple):
    """A part of a way [SI] with one curvature and one acceleration."""

    begins: float
    ends: float
    north: float
    east: float
    course: float
    curvature: float
    speed: float
    acceleration: float
    stretch: float = 0.0  # which of the path
    along: float = 0.0  # of that stretch, where it begins


class Way(NamedTuple):
    """A way: its path, and the pieces of time."""

    path: tuple[Stretch, ...]
    pieces: tuple[Piece, ...]

    def at(self, time: float) -> Piece:
        """Return the piece of a time [s]; the first before it begins."""
        for piece in self.pieces:
            if time < piece.ends:
                return piece
        return self.pieces[-1]

    def over(self, times: Numbers) -> Numbers:
        """Return the pieces of times [s], a column each."""
        table = np.array(self.pieces)
        indices = np.searchsorted(table[:, 1], times, side="right")  # by their ends
        return table[np.minimum(indices, len(table) - 1)].T


class ShipMotion(NamedTuple):
    """One ship at one moment, as a situation has many."""

    north: float  # [m]
    east: float  # [m]
    course: float  # [rad] through the water
    speed: float  # [m/s] through the water
    turning: float  # [rad/s]
    set_north: float  # [m/s] of the current that carries it
    set_east: float  # [m/s]

    def velocity(self) -> tuple[float, float]:
        """Return the velocity [m/s] over the ground, north and east."""
        north, east = self.speed * math.cos(self.course), self.speed * math.sin(self.course)
        return north + self.set_north, east + self.set_east


class Situation(NamedTuple):
    """Location, course, speed and rate of turn [SI] of many ships, an array each.

    Course and speed are through the water of those that it carries, else over the ground.
    """

    north: Numbers
    east: Numbers
    course: Numbers
    speed: Numbers
    turning: Numbers
    set_north: Numbers  # [m/s] of the water that carries them
    set_east: Numbers

    def velocity(self) -> tuple[Numbers, Numbers]:
        """Return the velocities [m/s] over the ground, north and east."""
        north, east = self.speed * np.cos(self.course), self.speed * np.sin(self.course)
        return north + self.set_north, east + self.set_east

    def over_ground(self) -> tuple[Numbers, Numbers]:
        """Return the courses [rad] and speeds [m/s] over the ground."""
        carried = (self.set_north != 0.0) | (self.set_east != 0.0)
        if not carried.any():
            return self.course, self.speed
        north, east = self.velocity()
        course = np.where(carried, np.arctan2(east, north), self.course)
        return course, np.where(carried, np.hypot(north, east), self.speed)


def situation(pieces: Numbers, time: float | Numbers) -> Situation:
    """Return where ships are at a time [s], by their pieces as columns."""
    begins, _, north, east, course, curvature, speed, acceleration = pieces[:8]
    passed = np.maximum(time - begins, 0.0)
    way = (speed + 0.5 * acceleration * passed) * passed
    half = 0.5 * curvature * way
    bent = np.abs(half) > MIN_TURN
    chord = way * np.where(bent, np.sin(half) / np.where(bent, half, 1.0), 1.0)
    now = speed + acceleration * passed
    still = np.zeros_like(now)
    return Situation(
        north + chord * np.cos(course + half),
        east + chord * np.sin(course + half),
        course + 2.0 * half,
        now,
        now * curvature,
        still,
        still,
    )


def piece_column(piece: Piece) -> Numbers:
    """Return a piece as the column of one ship."""
    return np.array(piece, float).reshape(-1, 1)


def lay_way(begins: float, start: Piece, path: Sequence[Stretch]) -> Way:
    """Return the way along a path from a time [s] on. It starts as a piece does."""
    pieces: list[Piece] = []
    now, ordered = start._replace(begins=begins), start.speed
    for i, stretch in enumerate(path):
        ordered = ordered if stretch.speed is None else stretch.speed
        for length, acceleration in _shares(now.speed, ordered, stretch.length):
            lasts = _lasting(now.speed, acceleration, length)
            piece = now._replace(
                ends=now.begins + lasts, curvature=stretch.curvature, acceleration=acceleration
            )
            along = now.along if pieces and pieces[-1].stretch == i else 0.0
            pieces.append(piece._replace(stretch=float(i), along=along))
            now = _end(pieces[-1], length, ordered)
    return Way(tuple(path), tuple(pieces))


def _shares(speed: float, ordered: float, length: float) -> Iterator[tuple[float, float]]:
    """Yield length [m] and acceleration of the parts of a stretch: changing speed, then even."""
    if speed != ordered:
        rate = math.copysign(SHIP_ACCELERATION_M_S2, ordered - speed)
        needs = (ordered * ordered - speed * speed) / (2.0 * rate)
        yield min(needs, length), rate
        length -= needs
    if length > 0.0:
        yield length, 0.0


def _lasting(speed: float, acceleration: float, length: float) -> float:
    """Return the time [s] that a length takes; for ever at rest."""
    if acceleration == 0.0:
        return length / speed if speed > 0.0 else math.inf
    last = math.sqrt(max(speed * speed + 2.0 * acceleration * length, 0.0))
    return (last - speed) / acceleration


def _end(piece: Piece, length: float, ordered: float) -> Piece:
    """Return how the next piece begins. A speed that is reached is the one ordered."""
    if not math.isfinite(piece.ends):
        return piece
    end = situation(piece_column(piece), piece.ends)
    speed = float(end.speed[0])
    return piece._replace(
        begins=piece.ends,
        north=float(end.north[0]),
        east=float(end.east[0]),
        course=float(end.course[0]),
        speed=ordered if abs(speed - ordered) < 1e-9 else speed,
        along=piece.along + length,
    )


def path_along(
    points: Sequence[tuple[float, float]], speeds: Sequence[float], radius: float
) -> tuple[float, list[Stretch]]:
    """Return first course [rad] and path along way points, then straight on.

    ValueError tells which leg is too short for its turns.
    """
    legs = [_leg(start, end) for start, end in itertools.pairwise(points)]
    if still := [i for i, (_, length) in enumerate(legs) if length < 1.0]:
        raise ValueError(f"leg {still[0] + 1} has no length")
    changes = [
        math.remainder(after - before, math.tau)
        for (before, _), (after, _) in itertools.pairwise(legs)
    ]
    tangents = [0.0, *(radius * math.tan(0.5 * abs(change)) for change in changes), 0.0]
    path: list[Stretch] = []
    for i, ((_, length), speed) in enumerate(zip(legs, speeds, strict=True)):
        straight = length - tangents[i] - tangents[i + 1]
        if straight < 0.0:
            turns = tangents[i] + tangents[i + 1]
            raise ValueError(
                f"leg {i + 1} is {length:.0f} m: "
                f"its turns of radius {radius:g} m take {turns:.0f} m"
            )
        path.append(Stretch(0.0, straight, speed))
        if i < len(changes):
            path += turn_stretch(changes[i], radius)
    return legs[0][0], [*path, Stretch(0.0, math.inf)]


def turn_stretch(change: float, radius: float) -> list[Stretch]:
    """Return the stretch that changes the course by so much [rad], if any."""
    if abs(change) <= MIN_TURN:
        return []
    return [Stretch(math.copysign(1.0 / radius, change), radius * abs(change))]


def _leg(start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """Return course [rad] and length [m] between two points."""
    north, east = end[0] - start[0], end[1] - start[1]
    return math.atan2(east, north), math.hypot(north, east)


def unreached_stretch(way: Way) -> int | None:
    """Return the first stretch on which its ordered speed is not reached."""
    for i, stretch in enumerate(way.path):
        last = [piece for piece in way.pieces if piece.stretch == i]
        if stretch.speed is not None and last and last[-1].acceleration != 0.0:
            end = situation(piece_column(last[-1]), last[-1].ends)
            if abs(float(end.speed[0]) - stretch.speed) > 1e-6:
                return i
    return None


def rest_of(way: Way, time: float) -> tuple[Piece, list[Stretch]]:
    """Return a ship's location at a time [s] as a piece, and its further path."""
    piece = way.at(time)
    there = situation(piece_column(piece), time)
    now = piece._replace(
        begins=time,
        north=float(there.north[0]),
        east=float(there.east[0]),
        course=float(there.course[0]),
        speed=float(there.speed[0]),
        stretch=0.0,
        along=0.0,
    )
    first = int(piece.stretch)
    passed = max(time - piece.begins, 0.0)
    gone = piece.along + (piece.speed + 0.5 * piece.acceleration * passed) * passed
    here = way.path[first]
    remaining = max(here.length - gone, 0.0)
    return now, [
        here._replace(length=remaining, speed=ordered_at(way, first)),
        *way.path[first + 1 :],
    ]


def ordered_at(way: Way, stretch: int) -> float:
    """Return the speed [m/s] that is ordered on a stretch."""
    speeds = [each.speed for each in way.path[: stretch + 1] if each.speed is not None]
    return speeds[-1] if speeds else way.pieces[0].speed
