"""The channels of the aids, which are empty while these are off."""

import math
from collections.abc import Callable
from typing import Final

from trainer.session.stations.aids import GhostReading, PredictedPoint
from trainer.session.stations.panels import Channel, Field, Value, compass, word
from trainer.session.stations.view import Frame
from trainer.units import KNOT

PREDICTIONS_A_SECOND: Final = 1.0  # [Hz]


def of_ghost(read: Callable[[GhostReading, Frame], float]) -> Callable[[Frame], Value]:
    """Return a reader of something of the ghost. It reads None while there is none."""

    def value(frame: Frame) -> Value:
        ghost = frame.pace.aids.ghost
        return read(ghost[frame.tick], frame) if frame.tick < len(ghost) else None

    return value


def way_ahead(frame: Frame) -> list[PredictedPoint]:
    """Return the way ahead, flown once for all fields; [] while the predictor is off."""
    predictor = frame.pace.aids.predictor
    if predictor and "ahead" not in frame.kept:
        frame.kept["ahead"] = predictor.look_ahead(frame.numbers)
    ahead: list[PredictedPoint] = frame.kept.get("ahead", [])
    return ahead


def at_its_end(read: Callable[[PredictedPoint], float]) -> Callable[[Frame], Value]:
    """Return a reader of the last point of the way ahead."""

    def value(frame: Frame) -> Value:
        ahead = way_ahead(frame)
        return read(ahead[-1]) if ahead else None

    return value


def pack_way(frame: Frame) -> Value:
    """Return the way ahead as one word: seconds, depth, heading and pitch of each point."""
    return ";".join(
        f"{each.seconds:g}:{each.depth:.1f}:{compass(each.heading)}:{math.degrees(each.pitch):.1f}"
        for each in way_ahead(frame)
    )


def _heading_off(ghost: GhostReading, frame: Frame) -> float:
    return math.degrees(math.remainder(frame.readings.heading - ghost.heading, math.tau))


GHOST_CHANNEL: Final = Channel(
    "ghost",
    "the reference crew's run from the start, by the gauges; off: how far the boat is from it",
    (
        Field("depth", "m", 1, of_ghost(lambda ghost, _: ghost.depth)),
        Field("heading", "deg", 1, of_ghost(lambda ghost, _: compass(ghost.heading))),
        Field("speed", "kn", 1, of_ghost(lambda ghost, _: ghost.speed / KNOT)),
        Field("pitch", "deg", 1, of_ghost(lambda ghost, _: math.degrees(ghost.pitch))),
        Field("rudder", "deg", 1, of_ghost(lambda ghost, _: math.degrees(ghost.rudder))),
        Field("stern", "deg", 1, of_ghost(lambda ghost, _: math.degrees(ghost.stern))),
        Field("bow", "deg", 1, of_ghost(lambda ghost, _: math.degrees(ghost.bow))),
        Field("depth_off", "m", 1, of_ghost(lambda ghost, f: f.readings.depth - ghost.depth)),
        Field("heading_off", "deg", 1, of_ghost(_heading_off)),
        Field(
            "pitch_off", "deg", 1, of_ghost(lambda ghost, f: math.degrees(f["theta"] - ghost.pitch))
        ),
    ),
)
PREDICTOR_CHANNEL: Final = Channel(
    "predictor",
    "what the gauges will read, with the controls as they stand; way: s, depth, heading, pitch",
    (
        Field("seconds", "s", 0, at_its_end(lambda point: point.seconds)),
        Field("depth", "m", 1, at_its_end(lambda point: point.depth)),
        Field("heading", "deg", 1, at_its_end(lambda point: compass(point.heading))),
        Field("pitch", "deg", 1, at_its_end(lambda point: math.degrees(point.pitch))),
        word("way", pack_way),
    ),
    fastest=PREDICTIONS_A_SECOND,
)
AID_CHANNELS: Final = (GHOST_CHANNEL, PREDICTOR_CHANNEL)
