"""The pull of ships near on the boat, an estimate within a factor of two.

``contacts`` writes it into the state before each tick. A ship under way is a slender body, a line
of sources along its length on the surface, after S. Wang, "Dynamic effects of ship passage on
moored vessels" (1975), as W. Seelig gives it (NFESC TR-6027-OCN, 2001); the surface is a rigid
wall, which doubles its section. The water's own acceleration where the boat is pushes on the boat's
displaced and added mass. What the boat's own way and the ship's waves add is left out, and no
measurement with a submarine was found: hence the factor.

The nearest MAX_PULLING_SHIPS ships pull, within PULL_REACH of their mean length and the boat's,
less and less over the last third.
"""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from trainer.boat.world.hulls import Pose, axes_of
from trainer.config.world.contacts import ShipType
from trainer.core.kernel import Numbers

SOURCE_COUNT: Final = 24  # along a ship
STATION_COUNT: Final = 11  # along the boat's axis
PULL_REACH: Final = 1.5  # [-] mean lengths
FULL_PULL_REACH: Final = 1.0  # [-] mean lengths, up to which the pull is whole
MAX_PULLING_SHIPS: Final = 4  # ships that pull the boat at once, the nearest
EVEN_SOURCES: Final = (np.arange(SOURCE_COUNT) + 0.5) / SOURCE_COUNT - 0.5  # [-] of a ship's length
EVEN_STATIONS: Final = np.linspace(-0.5, 0.5, STATION_COUNT)  # [-] of the boat's length
STATION_WEIGHTS: Final = (1.0 - 4.0 * EVEN_STATIONS * EVEN_STATIONS) / float(
    np.sum(1.0 - 4.0 * EVEN_STATIONS * EVEN_STATIONS)
)

PassingShip = tuple[ShipType, float, float, float, float]  # type, north, east, course, speed [SI]


def water_acceleration(ship: PassingShip, points: Numbers) -> Numbers:
    """Return the water's acceleration [m/s2], north, east and down, at points [m], a row each."""
    kind, north, east, course, speed = ship
    ahead = np.array((math.cos(course), math.sin(course), 0.0))
    along = EVEN_SOURCES * kind.length
    section = 3.0 * kind.block * kind.beam * kind.draught  # [m2] amidships, of the double body
    strength = 8.0 * speed * section * along / kind.length**2 * (kind.length / SOURCE_COUNT)
    sources = np.array((north, east, 0.0)) + along[:, None] * ahead
    away = points[:, None, :] - sources[None, :, :]
    least = 0.5 * kind.beam
    r = np.maximum(np.sqrt(np.sum(away * away, axis=2)), least)[:, :, None]
    way = speed * ahead
    along_way = np.sum(away * way, axis=2)[:, :, None]
    source_flow = 3.0 * away * along_way / r**5 - way / r**3
    flow: Numbers = np.sum(strength[None, :, None] * source_flow, axis=1) / (4.0 * math.pi)
    return flow


def pull_share(distance: float, ship: ShipType, length: float) -> float:
    """Return the share of the pull at a distance [m] [-]."""
    mean = 0.5 * (ship.length + length)
    return min(max((PULL_REACH - distance / mean) / (PULL_REACH - FULL_PULL_REACH), 0.0), 1.0)


class ShipPull:
    """The forces of ships on one boat."""

    def __init__(self, boat: Any) -> None:
        """Take the boat's masses and its axis."""
        c = boat.vessel
        displaced = float(c.buoyancy) / float(c.g)
        added = [float(c[name]) for name in ("X_udot", "Y_vdot", "Z_wdot")]
        self._masses = np.array([displaced - each for each in added])
        self._length = float(boat.file.hull.length)
        self._axis = EVEN_STATIONS * self._length

    def on(self, pose: Pose, ships: Sequence[PassingShip]) -> Numbers:
        """Return X, Y, Z [N] and K, M, N [N m] in body axes."""
        force = np.zeros(6)
        apart = [
            (math.hypot(ship[1] - pose.north, ship[2] - pose.east), i)
            for i, ship in enumerate(ships)
        ]
        for distance, i in sorted(apart)[:MAX_PULLING_SHIPS]:
            share = pull_share(distance, ships[i][0], self._length)
            if share > 0.0:
                force += share * self.whole(pose, ships[i])
        return force

    def whole(self, pose: Pose, ship: PassingShip) -> Numbers:
        """Return the forces of one ship at its full pull."""
        body = axes_of(pose)
        points = self._axis[:, None] * body[:, 0] + np.array(pose[:3])
        pushed = water_acceleration(ship, points) @ body * self._masses  # [N] a station, body axes
        force = STATION_WEIGHTS @ pushed
        moment = (STATION_WEIGHTS * self._axis) @ pushed
        return np.array((*force, 0.0, -moment[2], moment[1]))
