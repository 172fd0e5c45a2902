"""One boat's trial written as the logs of other houses, each by its published form.

Attitude, rate and surfaces stand in each row, depth and log in each fourth. The rudder's servo goes
30 deg by 400 us, or by 1, plus to starboard; the stern planes' likewise, plus with the bow down.
"""

import json
import math
import struct
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Final

import numpy as np

from helpers.made_logs import MadeLog
from trainer.core.kernel import Numbers
from trainer.io.nmea import sentence

DEGREE: Final = math.pi / 180.0
SERVO_DEG, SERVO_US, TRIM_US = 30.0, 400.0, 1500.0
SLOW_ROWS: Final = 4
CODES: Final = {"Q": "Q", "B": "B", "b": "b", "n": "4s", "N": "16s", "Z": "64s", "c": "h"}
CODES_MORE: Final = {"C": "H", "f": "f", "H": "H", "h": "h", "d": "d"}
DATAFLASH: Final = {  # number, letters, names, units of UNIT
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns", ""),
    "UNIT": (129, "QbZ", "TimeUS,Id,Label", ""),
    "FMTU": (130, "QBNN", "TimeUS,FmtType,UnitIds,MultIds", ""),
    "ATT": (131, "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw", "sddddhh"),
    "RATE": (132, "Qfff", "TimeUS,R,P,Y", "skkk"),
    "RCOU": (133, "QHH", "TimeUS,C1,C2", "sYY"),
    "CTUN": (134, "Qff", "TimeUS,Alt,BAlt", "smm"),
    "THR": (135, "Qf", "TimeUS,Speed", "sn"),
    "GPS": (136, "QBBf", "TimeUS,I,U,Spd", "s#-n"),
}
ULOG: Final = {
    "vehicle_attitude": "uint64_t timestamp;uint64_t timestamp_sample;float[4] q;",
    "vehicle_angular_velocity": "uint64_t timestamp;float[3] xyz;",
    "vehicle_local_position": "uint64_t timestamp;float z;float vx;float vy;",
    "actuator_servos": "uint64_t timestamp;float[2] control;",
}


def channels_of(log: MadeLog) -> dict[str, Numbers]:
    """Return the channels that all of the logs have, in degrees, metres and seconds."""
    names = ("rudder", "stern", "heading", "yaw_rate", "pitch", "depth", "speed")
    return {name: log.channels[name] for name in names}


def quaternion(pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return w, x, y, z of an attitude without roll [rad]."""
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return cp * cy, -sp * sy, sp * cy, cp * sy


def write_dataflash(path: Path, log: MadeLog) -> None:
    """Write ArduPilot's binary log; a second receiver says another speed."""
    codes, data, c = CODES | CODES_MORE, bytearray(), channels_of(log)

    def put(name: str, *values: Any) -> None:
        number, letters, *_ = DATAFLASH[name]
        form = "<" + "".join(codes[letter] for letter in letters)
        data.extend(b"\xa3\x95" + bytes([number]) + struct.pack(form, *values))

    for name, (number, letters, columns, _) in DATAFLASH.items():
        size = 3 + struct.calcsize("<" + "".join(codes[letter] for letter in letters))
        put("FMT", number, size, name.encode(), letters.encode(), columns.encode())
    for number, _, _, units in DATAFLASH.values():
        if units:
            put("FMTU", 0, number, units.encode(), b"-" * len(units))
    for i, t in enumerate(log.t):
        us = round(1e6 * t) + 3_000_000
        hundredths = [round(100.0 * c[name][i]) for name in ("pitch", "heading")]
        put("ATT", us, 0, 0, 0, hundredths[0], 0, hundredths[1] % 36000)
        put("RATE", us + 700, 0.0, 0.0, c["yaw_rate"][i])
        servos = [SERVO_US / SERVO_DEG * sign * c[name][i] for name, sign in SERVOS]
        put("RCOU", us + 1500, *(round(TRIM_US + one) for one in servos))
        put("GPS", us + 1800, 0, 1, c["speed"][i])
        put("GPS", us + 1800, 1, 0, 9.0)
        if i % SLOW_ROWS == 0:
            put("CTUN", us + 2000, -c["depth"][i], 0.0)
            put("THR", us + 2200, c["speed"][i])
    path.write_bytes(data)


SERVOS: Final = (("rudder", -1.0), ("stern", 1.0))


def write_ulog(path: Path, log: MadeLog) -> None:
    """Write a log of PX4."""
    data = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 3_000_000))
    c, numbers = channels_of(log), {name: i for i, name in enumerate(ULOG)}

    def put(kind: str, body: bytes) -> None:
        data.extend(struct.pack("<HB", len(body), ord(kind)) + body)

    def say(name: str, *stamps: int, values: tuple[float, ...]) -> None:
        head = struct.pack(f"<H{len(stamps)}Q", numbers[name], *stamps)
        put("D", head + struct.pack(f"<{len(values)}f", *values))

    put("B", bytes(40))
    for name, form in ULOG.items():
        put("F", f"{name}:{form}".encode())
    for name, i in numbers.items():
        put("A", struct.pack("<BH", 0, i) + name.encode())
    for i, t in enumerate(log.t):
        us = round(1e6 * t) + 3_000_000
        pitch, heading = (c[name][i] * DEGREE for name in ("pitch", "heading"))
        say("vehicle_attitude", us + 9_000, us, values=quaternion(pitch, heading))
        say("vehicle_angular_velocity", us + 700, values=(0.0, 0.0, c["yaw_rate"][i] * DEGREE))
        servos = tuple(sign * c[name][i] / SERVO_DEG for name, sign in SERVOS)
        say("actuator_servos", us + 1500, values=servos)
        if i % SLOW_ROWS == 0:
            ahead, across = (c["speed"][i] * turn(heading) for turn in (math.cos, math.sin))
            say("vehicle_local_position", us + 2000, values=(c["depth"][i], ahead, across))
    path.write_bytes(data)


def write_nmea(path: Path, log: MadeLog, *, tagged: bool = False) -> None:
    """Write sentences, a clock's before each burst, or each line with a TAG block of its own."""
    c, lines = channels_of(log), list[str]()
    for i, t in enumerate(log.t):
        at = datetime(2026, 11, 30, 23, 59, tzinfo=UTC) + timedelta(seconds=float(t))
        clock = f"{at:%H%M%S}.{at.microsecond // 10000:02d}"
        burst = [
            sentence("IIRSA", f"{-c['rudder'][i]:.1f}", "A", "", "V"),
            sentence("HEHDT", f"{c['heading'][i] % 360.0:.2f}", "T"),
            sentence("HEROT", f"{60.0 * c['yaw_rate'][i]:.1f}", "A"),
            sentence("SDDPT", "12.0", "0.0", ""),
            sentence("IIXDR", "A", f"{c['pitch'][i]:.2f}", "D", "PITCH"),
        ]
        if i % SLOW_ROWS == 0:
            knots = f"{c['speed'][i] * 3600.0 / 1852.0:.3f}"
            burst.append(sentence("IIVHW", "", "T", "", "M", knots, "N", "", "K"))
            burst.append(sentence("IIXDR", "D", f"{c['depth'][i]:.2f}", "M", "DEPTH"))
        if tagged:
            head = f"\\c:{round(1e3 * at.timestamp())}*00\\"
            lines += [head + one for one in burst]
        else:
            date = (f"{at:%d}", f"{at:%m}", f"{at:%Y}", "00", "00")
            lines += [sentence("GPZDA", clock, *date), *burst]
    lines.insert(4, "$HEHDT,99.9,T*00")  # damaged
    path.write_text("\r\n".join(lines) + "\r\n", encoding="ascii", newline="")


def write_signal_k(path: Path, log: MadeLog) -> None:
    """Write deltas as a server logs them; a second compass speaks more rarely."""
    c, lines = channels_of(log), list[str]()
    begun = datetime(2026, 11, 30, 10, tzinfo=UTC)

    def delta(at: datetime, source: str, values: Mapping[str, Any]) -> None:
        stamp = at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
        pairs = [{"path": path, "value": value} for path, value in values.items()]
        update = {"$source": source, "timestamp": stamp, "values": pairs}
        text = json.dumps({"context": "vessels.self", "updates": [update]})
        lines.append(f"{round(1e3 * at.timestamp())};I;{text}")

    for i, t in enumerate(log.t):
        at = begun + timedelta(seconds=float(t))
        values: dict[str, Any] = {
            "navigation.headingTrue": c["heading"][i] * DEGREE,
            "navigation.rateOfTurn": c["yaw_rate"][i] * DEGREE,
            "steering.rudderAngle": -c["rudder"][i] * DEGREE,
            "navigation.attitude": {"pitch": c["pitch"][i] * DEGREE, "yaw": None},
            "environment.depth.belowTransducer": 12.0,
        }
        if i % SLOW_ROWS == 0:
            values["navigation.speedThroughWater"] = c["speed"][i]
            delta(at, "old.compass", {"navigation.headingTrue": 0.0})
        delta(at, "n2k.35", values)
    lines.insert(3, f"{round(1e3 * begun.timestamp())};N;$HEHDT,12.0,T*1C")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_bag(path: Path, log: MadeLog, *, mcap: bool) -> None:
    """Write a bag of ROS 2 as REP 103 has it: from east, x ahead, y to port, z up."""
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 - an extra
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds, c = store.types, channels_of(log)
    Imu, Joints = kinds["sensor_msgs/msg/Imu"], kinds["sensor_msgs/msg/JointState"]
    Number, Header = kinds["std_msgs/msg/Float64"], kinds["std_msgs/msg/Header"]
    Stamp, Turned = kinds["builtin_interfaces/msg/Time"], kinds["geometry_msgs/msg/Quaternion"]
    Vector = kinds["geometry_msgs/msg/Vector3"]
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        links = {
            name: writer.add_connection(name, kind.__msgtype__, typestore=store)
            for name, kind in (
                ("/imu", Imu),
                ("/fins", Joints),
                ("/depth", Number),
                ("/log", Number),
            )
        }

        def put(name: str, at: int, message: Any) -> None:
            writer.write(links[name], at, store.serialize_cdr(message, message.__msgtype__))

        for i, t in enumerate(log.t):
            at = 1_796_000_000_000_000_000 + round(1e9 * t)
            head = Header(stamp=Stamp(sec=at // 10**9, nanosec=at % 10**9), frame_id="base")
            w, x, y, z = quaternion(
                -c["pitch"][i] * DEGREE, 0.5 * math.pi - c["heading"][i] * DEGREE
            )
            attitude, none = Turned(x=x, y=y, z=z, w=w), np.zeros(9)
            rate = Vector(x=0.0, y=0.0, z=-float(c["yaw_rate"][i] * DEGREE))
            still = Vector(x=0.0, y=0.0, z=9.81)
            put("/imu", at + 5_000_000, Imu(head, attitude, none, rate, none, still, none))
            angles = np.array([c[name][i] * DEGREE for name in ("rudder", "stern")])
            put("/fins", at, Joints(head, ["rudder", "stern"], angles, np.zeros(0), np.zeros(0)))
            if i % SLOW_ROWS == 0:
                put("/depth", at, Number(data=float(c["depth"][i])))
                put("/log", at, Number(data=float(c["speed"][i])))
