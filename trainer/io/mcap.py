"""A recording as an MCAP file, which Foxglove and other viewers of robots open.

Messages are JSON by the schemas of Foxglove where there is one: ``PoseInFrame``,
``FrameTransform``, ``Log`` (https://docs.foxglove.dev/docs/sdk/schemas). Axes are those of ROS REP
103: the world's x is east, y north and z up; the boat's x is ahead, y to port and z up. Twist and
gauges have a schema of their own, in SI units and degrees as its names say.
"""

import heapq
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from operator import itemgetter
from pathlib import Path
from typing import Any, Final

from trainer.io.outputs import replacing
from trainer.io.recording.recording import Recording, RecordingError
from trainer.io.tables import Layout
from trainer.units import DEGREE, KNOT

WORLD_FRAME, BOAT_FRAME = "world", "boat"
SECOND_NS: Final = 1_000_000_000
INFO_LEVEL, WARNING_LEVEL = 2, 3  # of Foxglove's Log
NUMBER_SCHEMA: Final = {"type": "number"}
TIME_SCHEMA: Final = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer"}},
}
# what a boat's own topic has of the state: name, column, and its size in the name's unit
MOTION_COLUMNS: Final = {
    "speed_kn": ("u", KNOT),
    "depth_m": ("z", 1.0),
    "heading_deg": ("psi", DEGREE),
    "pitch_up_deg": ("theta", DEGREE),
    "roll_starboard_deg": ("phi", DEGREE),
    "u_m_s": ("u", 1.0),
    "v_m_s": ("v", 1.0),
    "w_m_s": ("w", 1.0),
    "p_deg_s": ("p", DEGREE),
    "q_deg_s": ("q", DEGREE),
    "r_deg_s": ("r", DEGREE),
    "rudder_deg": ("delta_r", DEGREE),
    "stern_planes_deg": ("delta_s", DEGREE),
    "bow_planes_deg": ("delta_b", DEGREE),
}
POSE_COLUMNS: Final = ("x", "y", "z", "phi", "theta", "psi")

METADATA_NAMES: Final = ("trainer", "vessel", "seed", "core", "started", "method")  # of a header
UNITS_TEXT: Final = "metres, radians and quaternions; those of /boat/motion as its names end"
Message = dict[str, Any]


@dataclass(frozen=True)
class McapTopic:
    """A topic, and the schema of its messages."""

    name: str
    schema: str
    properties: Mapping[str, Any]

    @property
    def data(self) -> bytes:
        """Return the JSON schema."""
        return json.dumps(
            {"type": "object", "title": self.schema, "properties": self.properties}
        ).encode()


def numbers_of(*names: str) -> dict[str, Any]:
    """Return the schema of an object of numbers."""
    return {"type": "object", "properties": dict.fromkeys(names, NUMBER_SCHEMA)}


POSITION, QUATERNION = numbers_of("x", "y", "z"), numbers_of("x", "y", "z", "w")
STRING_SCHEMA: Final = {"type": "string"}
POSE_TOPIC: Final = McapTopic(
    "/boat/pose",
    "foxglove.PoseInFrame",
    {
        "timestamp": TIME_SCHEMA,
        "frame_id": STRING_SCHEMA,
        "pose": {
            "type": "object",
            "properties": {"position": POSITION, "orientation": QUATERNION},
        },
    },
)
FRAME_TOPIC: Final = McapTopic(
    "/tf",
    "foxglove.FrameTransform",
    {
        "timestamp": TIME_SCHEMA,
        "parent_frame_id": STRING_SCHEMA,
        "child_frame_id": STRING_SCHEMA,
        "translation": POSITION,
        "rotation": QUATERNION,
    },
)
MOTION_TOPIC: Final = McapTopic(
    "/boat/motion",
    "trainer.Motion",
    {"timestamp": TIME_SCHEMA, **dict.fromkeys(MOTION_COLUMNS, NUMBER_SCHEMA)},
)
LOG_PROPERTIES: Final = {
    "timestamp": TIME_SCHEMA,
    "level": {"type": "integer"},
    **dict.fromkeys(("message", "name", "file"), STRING_SCHEMA),
    "line": {"type": "integer"},
}
ORDERS_TOPIC, EVENTS_TOPIC = (
    McapTopic(name, "foxglove.Log", LOG_PROPERTIES) for name in ("/orders", "/events")
)
MCAP_TOPICS: Final = (POSE_TOPIC, FRAME_TOPIC, MOTION_TOPIC, ORDERS_TOPIC, EVENTS_TOPIC)


def export_mcap(recording: Recording, layout: Layout, path: Path, branch: int | None) -> list[Path]:
    """Write a branch, the past that led to it and all events.

    Return the file's name. Times count from when the recording was begun, or from 1970 where the
    clock stood earlier, because the format has none before. RecordingError if it cannot be written
    whole.
    """
    from mcap.writer import IndexType, Writer  # noqa: PLC0415  of an extra

    header = recording.header()
    texts: Mapping[str, str] = json.loads(header.get("texts", "{}"))
    kept = IndexType.ATTACHMENT if texts else IndexType.NONE  # indexes of what is there alone
    chosen = recording.branch if branch is None else branch
    started = datetime.fromisoformat(header["started"]).timestamp()
    begun = round(max(started, 0.0) * SECOND_NS)
    lines = sorted(_log_messages(recording, layout, chosen), key=itemgetter(0))
    messages = heapq.merge(lines, _motion_messages(recording, layout, chosen), key=itemgetter(0))
    try:
        with replacing(path) as made, made.open("wb") as file:
            index = IndexType.CHUNK | IndexType.MESSAGE | IndexType.METADATA | kept
            writer = Writer(file, index_types=index)
            writer.start(profile="", library=f"trainer {header['trainer']}")
            writer.add_metadata("recording", _metadata(header, chosen))
            for name, text in texts.items():
                writer.add_attachment(begun, begun, name, "application/toml", text.encode())
            channels, counts = {}, dict.fromkeys((topic.name for topic in MCAP_TOPICS), 0)
            for topic in MCAP_TOPICS:
                schema = writer.register_schema(topic.schema, "jsonschema", topic.data)
                channels[topic.name] = writer.register_channel(topic.name, "json", schema)
            for seconds, topic, message in messages:
                at = begun + round(seconds * SECOND_NS)
                stamp = {"sec": at // SECOND_NS, "nsec": at % SECOND_NS}
                data = json.dumps({"timestamp": stamp, **message}).encode()
                writer.add_message(channels[topic.name], at, data, at, counts[topic.name])
                counts[topic.name] += 1
            writer.finish()  # type: ignore[no-untyped-call]
    except OSError as error:
        reason = error.strerror or str(error)
        raise RecordingError(f"{path} cannot be written whole: {reason}") from None
    return [path]


def _metadata(header: Mapping[str, str], branch: int) -> dict[str, str]:
    """Return what the file is of, and the units of its numbers, as words."""
    exercise = json.loads(header.get("options", "{}")).get("exercise")
    names = {name: header.get(name, "").strip('"') for name in METADATA_NAMES}
    return {**names, "exercise": exercise or "", "branch": str(branch), "units": UNITS_TEXT}


def _motion_messages(
    recording: Recording, layout: Layout, branch: int
) -> Iterator[tuple[float, McapTopic, Message]]:
    """Yield pose, frame and motion of each recorded state, with its time [s]."""
    names = {*POSE_COLUMNS, *(column for column, _ in MOTION_COLUMNS.values())}
    places = {name: layout.columns.index(name) for name in names}
    for flown in recording.flown(branch):
        numbers = layout.numbers(flown.state)
        state = {name: numbers[place] for name, place in places.items()}
        seconds = flown.tick * layout.step
        position = {"x": state["y"], "y": state["x"], "z": -state["z"]}
        turned = quaternion_of(state["phi"], state["theta"], state["psi"])
        pose = {"position": position, "orientation": turned}
        yield seconds, POSE_TOPIC, {"frame_id": WORLD_FRAME, "pose": pose}
        frames = {"parent_frame_id": WORLD_FRAME, "child_frame_id": BOAT_FRAME}
        yield seconds, FRAME_TOPIC, {**frames, "translation": position, "rotation": turned}
        motion = {name: state[column] / size for name, (column, size) in MOTION_COLUMNS.items()}
        yield seconds, MOTION_TOPIC, {**motion, "heading_deg": motion["heading_deg"] % 360.0}


def _log_messages(
    recording: Recording, layout: Layout, branch: int
) -> Iterator[tuple[float, McapTopic, Message]]:
    """Yield orders with their answers, and events, as lines of a log with their times [s]."""
    for order in recording.orders(branch):
        refused = order.accepted is False
        text = f"{order.text}: {order.answer}" if order.answer else order.text
        line = _log_line(order.who, text, WARNING_LEVEL if refused else INFO_LEVEL)
        yield order.tick * layout.step, ORDERS_TOPIC, line
    for event in recording.first_events():
        text = f"{event.kind} {event.text}".strip()
        yield event.tick * layout.step, EVENTS_TOPIC, _log_line(event.who, text, INFO_LEVEL)


def _log_line(who: str, text: str, level: int) -> Message:
    """Return a line of Foxglove's log."""
    return {"level": level, "message": text, "name": who, "file": "", "line": 0}


def quaternion_of(phi: float, theta: float, psi: float) -> dict[str, float]:
    """Return the boat's attitude in axes of REP 103.

    The angles [rad] are those of the state. Roll stays, pitch and yaw change their signs, and yaw
    counts from east.
    """
    halves = (0.5 * phi, -0.5 * theta, 0.5 * (0.5 * math.pi - psi))
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(half), math.sin(half)) for half in halves)
    return {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }
