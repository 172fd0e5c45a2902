"""The other boats of a class, as ships of ``contacts``: their sizes at their depths.

The class gives each session the places of the others (``classroom/one_sea``), as orders. A boat is
taken to have the hull of the session's own boat, as a box upright in the water.
"""

from dataclasses import replace
from typing import Any, Final

from trainer.config.world.contacts import SHIP_TYPES, ShipType

BOAT_NAME: Final = "boat-{}"  # as orders name it
BOAT_TYPE: Final = "submarine"
BOATS_MMSI: Final = 200_000_000  # and its number; no country has the digits 200
FASTEST_KN: Final = 60.0  # that an order can say


def hull_at(boat: Any, depth: float) -> ShipType:
    """Return the sizes of a boat like this one at a depth [m].

    The depth is that of its origin. Height and masthead are those of the sail's top over the
    water, below zero if it is under.
    """
    vessel = boat.vessel
    over = -(depth + float(vessel.z_sail))
    return replace(
        SHIP_TYPES[BOAT_TYPE],
        length=float(boat.file.hull.length),
        beam=float(vessel.hull_diameter),
        draught=depth + float(vessel.hull_axis) + 0.5 * float(vessel.hull_diameter),
        height=over,
        mast=over,
        fastest_kn=FASTEST_KN,
    )


def body_of(hull: ShipType) -> ShipType:
    """Return a hull that is larger by the errors of its place.

    So two boats that touch are told of it both, though each has the other a little elsewhere.
    """
    from trainer.config.exercise import class_file  # noqa: PLC0415  of classes alone

    return replace(
        hull,
        length=hull.length + 2.0 * class_file.PLACE_ERROR_M,
        beam=hull.beam + 2.0 * class_file.PLACE_ERROR_M,
        draught=hull.draught + class_file.DEPTH_ERROR_M,
        height=hull.height + class_file.DEPTH_ERROR_M,
    )
