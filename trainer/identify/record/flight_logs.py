"""Logs of autopilots and robots as columns: ArduPilot's dataflash, ULog of PX4, bags of ROS.

Sources: ArduPilot, libraries/AP_Logger and AP_AHRS/LogStructure.h; docs.px4.io, message reference;
ros.org, REP 103. What comes from a servo is no angle, and has no unit.
"""

import math
import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.record.log_columns import Log, LogColumn, Meant, begin_at_zero, log_column

# fmt: off
FIELD_CODES: Final = {  # of dataflash, as struct has them
    "a": "32h", "b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d",
    "n": "4s", "N": "16s", "Z": "64s", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "M": "B",
    "q": "q", "Q": "Q", "g": "e",
}
# fmt: on
Format = tuple[str, str, tuple[str, ...], int]  # name, letters of its fields, their names, bytes
LETTER_FACTORS: Final = {"c": 0.01, "C": 0.01, "e": 0.01, "E": 0.01, "L": 1e-7}
MESSAGE_HEAD: Final = b"\xa3\x95"
FORMAT_FIELDS: Final = ("Type", "Length", "Name", "Format", "Columns")
FORMAT_MESSAGE: Final[Format] = ("FMT", "BBnNZ", FORMAT_FIELDS, 89)
DATAFLASH: Final = {  # by field: channel, unit, sign
    "ATT.Yaw": ("heading", "deg", 1.0),
    "ATT.Pitch": ("pitch", "deg", 1.0),
    "ATT.Roll": ("roll", "deg", 1.0),
    "RATE.Y": ("yaw_rate", "deg/s", 1.0),
    "RATE.P": ("pitch_rate", "deg/s", 1.0),
    "RATE.R": ("roll_rate", "deg/s", 1.0),
    "CTUN.Alt": ("depth", "m", -1.0),  # of a submarine: up there
    "THR.Speed": ("speed", "m/s", 1.0),
    "GPS.Spd": ("ground_speed", "m/s", 1.0),
}
ULOG: Final = {  # likewise
    "vehicle_angular_velocity.xyz[0]": ("roll_rate", "rad/s", 1.0),
    "vehicle_angular_velocity.xyz[1]": ("pitch_rate", "rad/s", 1.0),
    "vehicle_angular_velocity.xyz[2]": ("yaw_rate", "rad/s", 1.0),
    "vehicle_local_position.z": ("depth", "m", 1.0),
}
ANGLES: Final = ("roll", "pitch", "heading")
BAG_HEADS: Final = (b"\x89MCAP", b"#ROSBAG", b"SQLite format 3\x00")


def is_bag(first: bytes) -> bool:
    """Return whether a file that begins so is a bag of ROS."""
    return first.startswith(BAG_HEADS)


def turned_angles(w: Numbers, x: Numbers, y: Numbers, z: Numbers) -> tuple[Numbers, ...]:
    """Return roll, pitch and yaw [rad] of quaternions that turn the body into the earth."""
    size = np.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = (one / np.where(size > 0.0, size, np.nan) for one in (w, x, y, z))
    return (
        np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)),
        np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def read_dataflash(path: Path) -> Log:
    """Return the columns of ArduPilot's binary log, which says its own messages.

    Of several sensors in one message the first counts, or the one that the GPS says it uses.
    """
    rows, instances = defaultdict[str, list[dict[str, Any]]](list), dict[str, str]()
    formats = {128: FORMAT_MESSAGE}
    for name, values in _messages(path.read_bytes(), formats):
        if name == "FMTU":
            of, letters = formats.get(values["FmtType"]), values["UnitIds"]
            if of and "#" in letters[: len(of[2])]:
                instances[of[0]] = of[2][letters.index("#")]
        elif "TimeUS" in values:
            rows[name].append(values)
    columns, told = dict[str, LogColumn](), list[str]()
    for name, sensors in rows.items():
        found = sensors
        if key := instances.get(name):
            used = [one for one in found if one.get("U", 1)]
            first = min(one[key] for one in used or found)
            others = {one[key] for one in found} - {first}
            found = [one for one in sensors if one[key] == first]
            told += [f"{name}: {key} {first} of {len(others) + 1}"] if others else []
        times = [1e-6 * one["TimeUS"] for one in found]
        for column, value in found[0].items():
            if column != "TimeUS" and isinstance(value, int | float):
                pairs = zip(times, (float(one[column]) for one in found), strict=True)
                unit = DATAFLASH.get(f"{name}.{column}", ("", ""))[1]
                columns[f"{name}.{column}"] = log_column(pairs, unit)
    return _meant(path, columns, DATAFLASH, told)


def _messages(data: bytes, formats: dict[int, Format]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield messages by name, their fields by theirs; formats are learned on the way."""
    at = 0
    while (at := data.find(MESSAGE_HEAD, at)) >= 0 and at + 3 <= len(data):
        known = formats.get(data[at + 2])
        if known is None or at + known[3] > len(data):
            at += 2
            continue
        name, letters, columns, size = known
        fields = struct.unpack_from(
            "<" + "".join(map(FIELD_CODES.__getitem__, letters)), data, at + 3
        )
        at += size
        values: dict[str, Any] = {
            column: value.split(b"\0")[0].decode("latin-1")
            if isinstance(value, bytes)
            else value * LETTER_FACTORS.get(letter, 1)
            for column, letter, value in zip(columns, letters, fields, strict=False)
        }
        if name == "FMT":
            kind, length = int(values["Type"]), values["Length"]
            codes = "".join(FIELD_CODES.get(letter, "x") for letter in values["Format"])
            if 3 + struct.calcsize("<" + codes) == length and "a" not in values["Format"]:
                heads = tuple(values["Columns"].split(","))
                formats[kind] = (values["Name"], values["Format"], heads, length)
        yield name, values


def read_ulog(path: Path) -> Log:
    """Return the columns of a ULog of PX4. ConfigError without pyulog, or if it cannot be read."""
    require_library("pyulog", f"{path}, a ULog,")
    from pyulog import ULog  # type: ignore[import-untyped]  # noqa: PLC0415 - on use

    try:
        topics = [one for one in ULog(str(path)).data_list if one.multi_id == 0]
    except Exception as error:
        raise ConfigError(f"{path}: cannot be read as ULog: {error}") from error
    columns = dict[str, LogColumn]()
    for topic in topics:
        measured = topic.data.get("timestamp_sample", topic.data["timestamp"])
        t = 1e-6 * np.asarray(measured, float)
        for name, values in topic.data.items():
            if not name.startswith(("timestamp", "_padding")):
                unit = ULOG.get(f"{topic.name}.{name}", ("", ""))[1]
                pairs = zip(t, np.asarray(values, float), strict=True)
                columns[f"{topic.name}.{name}"] = log_column(pairs, unit)
        if topic.name == "vehicle_attitude":
            angles = turned_angles(*(np.asarray(topic.data[f"q[{i}]"], float) for i in range(4)))
            for name, values in zip(ANGLES, angles, strict=True):
                columns[f"{topic.name}.{name}"] = log_column(zip(t, values, strict=True), "rad")
        if topic.name == "vehicle_local_position":
            speed = np.hypot(topic.data["vx"], topic.data["vy"])
            columns[f"{topic.name}.vx, vy"] = log_column(zip(t, speed, strict=True), "m/s")
    meant = {**ULOG, "vehicle_local_position.vx, vy": ("ground_speed", "m/s", 1.0)}
    meant |= {f"vehicle_attitude.{name}": (name, "rad", 1.0) for name in ANGLES}
    return _meant(path, columns, meant, [])


def read_bag(path: Path) -> Log:
    """Return the columns of a bag of ROS. ConfigError.

    Orientations are taken as REP 103 has them, x ahead, y to port, z up, from east; their columns
    that end in _ned are the same numbers of a driver with north, east, down.
    """
    require_library("rosbags", f"{path}, a bag,")
    from rosbags.highlevel import AnyReader  # noqa: PLC0415 - likewise
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    rows = defaultdict[str, list[tuple[float, float]]](list)
    turned = defaultdict[str, list[Sequence[float]]](list)
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            for connection, stamp, raw in reader.messages():
                message = reader.deserialize(raw, connection.msgtype)
                head = getattr(getattr(message, "header", None), "stamp", None)
                own = head.sec + 1e-9 * head.nanosec if head is not None else 0.0
                t, topic = own if own > 0.0 else 1e-9 * stamp, connection.topic
                if hasattr(message, "orientation"):
                    q = message.orientation
                    turned[topic].append((t, q.w, q.x, q.y, q.z))
                for name, value in _numbers_of(message):
                    rows[f"{topic}{name}"].append((t, value))
    except Exception as error:
        cut = ": cut short? recover it first" if "magic" in str(error) else ""
        raise ConfigError(f"{path}: cannot be read as a bag: {error}{cut}") from error
    columns = {name: log_column(pairs) for name, pairs in rows.items()}
    meant = dict[str, tuple[str, str, float]]()
    for topic, quaternions in turned.items():
        t, *parts = np.array(quaternions).T
        roll, pitch, yaw = turned_angles(*parts)
        found = {"heading": 0.5 * math.pi - yaw, "heading_ned": yaw, "roll": roll}
        found |= {"pitch": -pitch, "pitch_ned": pitch}
        for name, values in found.items():
            columns[f"{topic}.{name}"] = log_column(zip(t, values, strict=True), "rad")
        meant |= {f"{topic}.{name}": (name, "rad", 1.0) for name in ANGLES}
        for axis, name, sign in (("x", "roll", 1.0), ("y", "pitch", -1.0), ("z", "yaw", -1.0)):
            rate = f"{topic}.angular_velocity.{axis}"
            if rate in columns:
                columns[rate] = columns[rate]._replace(unit="rad/s")
                meant[rate] = (f"{name}_rate", "rad/s", sign)
    told = [
        f"{topic}: from east, y to port, z up, by REP 103; else name .heading_ned, .pitch_ned"
        for topic in turned
    ]
    return _meant(path, columns, meant, told)


def _numbers_of(message: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers of a message by their path; those of joints by the joint's name."""
    if isinstance(message, bool | int | float | np.number):
        yield name, float(message)
        return
    joints = getattr(message, "name", None)
    if isinstance(joints, list) and hasattr(message, "position"):
        for joint, position in zip(joints, message.position, strict=False):
            yield f"{name}.{joint}", float(position)
        return
    for key in getattr(message, "__dataclass_fields__", ()):
        if key not in ("header", "__msgtype__", "orientation"):
            yield from _numbers_of(getattr(message, key), f"{name}.{key}")


def _meant(
    path: Path,
    columns: Mapping[str, LogColumn],
    by_field: Mapping[str, tuple[str, str, float]],
    told: Sequence[str],
) -> Log:
    """Return the log, its fields taken for channels as the format has them."""
    kept = begin_at_zero(columns)
    meant = dict[str, Meant]()
    for name, (channel, _, sign) in by_field.items():
        if name in kept:
            meant.setdefault(channel, Meant(name, sign))
    return Log(path, kept, meant, tuple(told))
