"""The boat's hull and sail as spheres, and ships as boxes: whether they touch.

``encounters`` and the debrief's rehearsals find collisions by it; ``contacts`` and ``ship_force``
take the pose from here, because a ship near pulls at the boat as it lies. The hull is eleven
spheres along its axis, the sail three above the deck. Of a ship the box is as long, wide and deep
as the ship, and as high as its house.
"""

import math
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.world.bottom import STATE_OFFSETS
from trainer.config.world.contacts import ShipType
from trainer.core.kernel import Numbers

POSE_NAMES: Final = ("x", "y", "z", "phi", "theta", "psi")
read_pose: Final = itemgetter(*(STATE_OFFSETS[name] for name in POSE_NAMES))
HULL_SPHERES: Final = 11  # spheres of the hull
SAIL_SPHERES: Final = 3  # of the sail
STEP_BEAM_SHARE: Final = 0.25  # [-] of a ship's beam: the most that is gone between two looks


ShipPose = tuple[float, float, float, ShipType]  # north, east [m], course [rad] and type of a ship


class Pose(NamedTuple):
    """Location [m] and attitude [rad] of the boat: north, east, depth, heel, pitch, heading."""

    north: float
    east: float
    depth: float
    heel: float
    pitch: float
    heading: float

    @classmethod
    def of(cls, state: Any) -> "Pose":
        """Return the pose in a state."""
        return cls(*(float(state[name]) for name in POSE_NAMES))

    def towards(self, other: "Pose", share: float) -> "Pose":
        """Return the pose at a share of the way to another."""
        return Pose(*(a + share * (b - a) for a, b in zip(self, other, strict=True)))


@dataclass(frozen=True)
class OwnHull:
    """Centres [m] in body axes, a row each, and radii [m] of the spheres."""

    centres: Numbers
    radii: Numbers
    reach: float  # [m] of anything from the origin

    @classmethod
    def of(cls, boat: Any) -> "OwnHull":
        """Return the hull of a boat."""
        vessel, hull = boat.vessel, boat.file.hull
        radius, axis = 0.5 * float(vessel.hull_diameter), float(vessel.hull_axis)
        nose = 0.5 * hull.length if hull.cg_from_nose is None else hull.cg[0] + hull.cg_from_nose
        xs = np.linspace(nose - radius, nose - hull.length + radius, HULL_SPHERES)
        centres = [(x, 0.0, axis) for x in xs.tolist()]
        radii = [radius] * HULL_SPHERES
        high = max(float(vessel.z_deck) - float(vessel.z_sail), 0.0)
        for i in range(SAIL_SPHERES if high else 0):
            share = (i + 0.5) / SAIL_SPHERES
            centres.append((float(vessel.x_sail), 0.0, float(vessel.z_deck) - share * high))
            radii.append(0.5 * high / SAIL_SPHERES)
        whole = np.array(centres)
        return cls(whole, np.array(radii), float((np.linalg.norm(whole, axis=1) + radii).max()))

    def centres_at(self, pose: Pose) -> Numbers:
        """Return the centres [m] north, east and down of the origin, a row each."""
        centres: Numbers = self.centres @ axes_of(pose).T + np.array(pose[:3])
        return centres

    def touches(self, pose: Pose, ship: ShipType, north: float, east: float, course: float) -> bool:
        """Return whether hull or sail touch a ship there."""
        off = self.centres_at(pose) - np.array((north, east, 0.0))
        ahead = off[:, 0] * math.cos(course) + off[:, 1] * math.sin(course)
        across = off[:, 1] * math.cos(course) - off[:, 0] * math.sin(course)
        beyond = (
            np.maximum(np.abs(ahead) - 0.5 * ship.length, 0.0),
            np.maximum(np.abs(across) - 0.5 * ship.beam, 0.0),
            np.maximum(np.maximum(off[:, 2] - ship.draught, -ship.height - off[:, 2]), 0.0),
        )
        return bool((sum(each * each for each in beyond) <= self.radii * self.radii).any())

    def looks(self, way: float, ship: ShipType) -> int:
        """Return how often to look on a relative way [m] to miss no ship.

        In one tick boat and ship may pass through each other.
        """
        return max(math.ceil(way / (STEP_BEAM_SHARE * ship.beam)), 1)

    def far(self, range_m: Any, depth: Any, ship: ShipType) -> Any:
        """Return whether range and depth [m], numbers or arrays, leave no chance of a touch."""
        return (depth - self.reach > ship.draught) | (range_m > self.reach + ship.half_diagonal)


def axes_of(pose: Pose) -> Numbers:
    """Return the matrix from body axes to north, east and down."""
    cos_h, sin_h = math.cos(pose.heel), math.sin(pose.heel)
    cos_p, sin_p = math.cos(pose.pitch), math.sin(pose.pitch)
    cos_y, sin_y = math.cos(pose.heading), math.sin(pose.heading)
    heel = np.array(((1.0, 0.0, 0.0), (0.0, cos_h, -sin_h), (0.0, sin_h, cos_h)))
    pitch = np.array(((cos_p, 0.0, sin_p), (0.0, 1.0, 0.0), (-sin_p, 0.0, cos_p)))
    heading = np.array(((cos_y, -sin_y, 0.0), (sin_y, cos_y, 0.0), (0.0, 0.0, 1.0)))
    whole: Numbers = heading @ pitch @ heel
    return whole


def ships_overlap(one: ShipPose, two: ShipPose) -> bool:
    """Return whether two ships lie in each other."""
    apart = np.array((two[0] - one[0], two[1] - one[1]))
    sides = [_sides(each) for each in (one, two)]
    for axis in (row for side in sides for row in side / np.linalg.norm(side, axis=1)[:, None]):
        reach = sum(float(np.abs(side @ axis).sum()) for side in sides)
        if abs(float(apart @ axis)) > reach:
            return False
    return True


def _sides(ship: ShipPose) -> Numbers:
    """Return half the length and half the beam as vectors north and east, a row each."""
    _, _, course, kind = ship
    ahead = np.array((math.cos(course), math.sin(course)))
    return np.array((0.5 * kind.length * ahead, 0.5 * kind.beam * ahead[::-1] * (-1.0, 1.0)))
