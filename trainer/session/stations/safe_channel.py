"""The channel of the safe depth: how deep a danger would take the boat.

``boat/safe_depth`` flies ahead, in the thread that sends, and only while somebody looks.
"""

from collections.abc import Callable
from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.safe_depth import AFT_FLOODING, STERN_JAM, Danger, Flight
from trainer.io.orders.grammar import Refused
from trainer.session.stations.panels import Channel, Field, Value
from trainer.session.stations.view import Frame
from trainer.units import KNOT

FLIGHTS_A_SECOND: Final = 1.0  # [Hz]


def lack_of_test_depth(boat: Boat) -> Refused | None:
    """Return that a boat has no test depth, None where it has one."""
    if boat.file.hull.test_depth_m is None:
        return Refused(f"{boat.file.path.name} has no test_depth_m in its [hull]")
    return None


def deepest_after(danger: Danger) -> Callable[[Frame], Value]:
    """Return a reader of the depth [m] that a danger would reach now."""

    def depth(frame: Frame) -> Value:
        flight = Flight(frame.readings.speed, frame.readings.depth, frame["theta"])
        return frame.fit_ahead().find_deepest(flight, danger)

    return depth


def pack_limits(frame: Frame) -> Value:
    """Return the safe depths as one word: knots, then metres for each danger."""
    return ";".join(
        ":".join("" if value is None else f"{value:.1f}" for value in (speed / KNOT, jam, flooding))
        for speed, jam, flooding in frame.fit_ahead().safe_depths
    )


SAFE_CHANNEL: Final = Channel(
    "safe",
    "how deep a jam or a flooding would take the boat now; test depth; limits by speed",
    (
        Field("jam", "m", 0, deepest_after(STERN_JAM)),
        Field("flooding", "m", 0, deepest_after(AFT_FLOODING)),
        Field("test", "m", 0, lambda frame: frame.boat.file.hull.test_depth_m),
        Field("limits", "", 0, pack_limits, packed=True),
    ),
    fastest=FLIGHTS_A_SECOND,
    lack=lack_of_test_depth,
)
