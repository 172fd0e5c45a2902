"""Logs of ships as columns: NMEA 0183, Signal K; and which front reads a file.

A log is told by its first bytes, not by its ending. Sources: manuals of Trimble's SPSx50 (table
A.15) and Furuno's RD-50 and AP-11, by whose note a rudder's angle is relative; Signal K's schemas,
github.com/SignalK/specification.
"""

import json
import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError
from trainer.identify.record.flight_logs import is_bag, read_bag, read_dataflash, read_ulog
from trainer.identify.record.log_columns import Log, LogColumn, Meant, begin_at_zero, log_column
from trainer.io.nmea import NmeaSentence, parse_sentence
from trainer.io.outputs import note_input

FIRST_BYTES: Final = 4096  # that tell a log
DAY_S: Final = 86400.0  # [s]
TAG_TIME: Final = re.compile(r"\\[^\\]*\bc:(\d{9,13})[^\\]*\\")  # of a TAG block
NMEA_LINE: Final = re.compile(rb"\s*(?:\\[^\\]*\\)?[$!][A-Z0-9]{4,6},")
SIGNAL_K_LINE: Final = re.compile(rb'\s*(?:\d{13};[A-Z];|\{\s*"(?:context|updates)")')


class Told(NamedTuple):
    """What a field of a sentence tells, and the field that says that it holds."""

    channel: str
    field: int
    unit: str
    sign: float = 1.0
    valid: tuple[int, str] = (-1, "")


SENTENCES: Final = {  # the first source of a channel is preferred
    "THS": (Told("heading", 0, "deg"),),
    "HDT": (Told("heading", 0, "deg"),),
    "HDG": (Told("heading", 0, "deg"),),
    "HDM": (Told("heading", 0, "deg"),),
    "RSA": (Told("rudder", 0, "deg", -1.0, (1, "A")),),  # minus turns to port there
    "ROT": (Told("yaw_rate", 0, "deg/min", 1.0, (1, "A")),),
    "VHW": (Told("speed", 4, "kn"),),
    "VBW": (Told("speed", 0, "kn", 1.0, (2, "A")),),
    "RMC": (Told("ground_speed", 6, "kn", 1.0, (1, "A")),),
    "RPM": (Told("revolutions", 2, "rpm", 1.0, (4, "A")),),
    "PASHR": (Told("roll", 3, "deg"), Told("pitch", 4, "deg")),
}
TIME_FIELDS: Final = {"RMC": 0, "GGA": 0, "ZDA": 0, "GLL": 4}
PLACE_FIELDS: Final = {"RMC": 2, "GGA": 1, "GLL": 0}
TRANSDUCERS: Final = {  # of XDR, by name: channel and sign
    "PITCH": ("pitch", 1.0),
    "ROLL": ("roll", 1.0),
    "DEPTH": ("depth", 1.0),
    "STERN": ("stern", -1.0),  # planes: rising there, bow down here
    "BOW": ("bow", 1.0),
}
SOUNDED: Final = ("DBT", "DPT", "environment.depth.")  # water below the transducer
SIGNAL_K: Final = {  # by path: channel, unit, sign
    "navigation.headingTrue": ("heading", "rad", 1.0),
    "navigation.headingMagnetic": ("heading", "rad", 1.0),
    "navigation.rateOfTurn": ("yaw_rate", "rad/s", 1.0),
    "steering.rudderAngle": ("rudder", "rad", -1.0),
    "navigation.speedThroughWater": ("speed", "m/s", 1.0),
    "navigation.speedOverGround": ("ground_speed", "m/s", 1.0),
    "navigation.attitude.roll": ("roll", "rad", 1.0),
    "navigation.attitude.pitch": ("pitch", "rad", 1.0),
    "navigation.position.latitude": ("latitude", "deg", 1.0),
    "navigation.position.longitude": ("longitude", "deg", 1.0),
}
REVOLUTIONS_PATH: Final = re.compile(r"propulsion\.[^.]+\.revolutions")


def read_log(path: Path) -> Log | None:
    """Return a log; None for a file that is none, such as a table. ConfigError."""
    if path.is_dir():
        return read_bag(path) if (path / "metadata.yaml").exists() else None
    try:
        note_input(path)
        with path.open("rb") as file:
            first = file.read(FIRST_BYTES)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    read: Callable[[Path], Log] | None = None
    if first.startswith(b"ULog\x01\x12\x35"):
        read = read_ulog
    elif first.startswith(b"\xa3\x95"):
        read = read_dataflash
    elif is_bag(first):
        read = read_bag
    elif NMEA_LINE.match(first):
        read = read_nmea
    elif SIGNAL_K_LINE.match(first):
        read = read_signal_k
    return None if read is None else read(path)


def read_nmea(path: Path) -> Log:
    """Return the columns of sentences; ConfigError where none has a time.

    A sentence has the time of the last RMC, GGA, ZDA or GLL before it, or of its own TAG block.
    Several of one kind between two times are spread evenly, because they come in a burst.
    """
    found = defaultdict[tuple[str, Told], list[tuple[int, float]]](list)
    clock, own, damaged, sounded = list[tuple[int, float]](), list[tuple[int, float]](), 0, set()
    for line, text in enumerate(_lines(path)):
        sentence = parse_sentence(text)
        if not isinstance(sentence, NmeaSentence):
            damaged += sentence is not None
            continue
        if tag := TAG_TIME.search(text):
            stamp = float(tag[1])
            own.append((line, stamp / 1e3 if len(tag[1]) == 13 else stamp))
        if (stamp_at := _time_of(sentence)) is not None:
            days = DAY_S * round((clock[-1][1] - stamp_at) / DAY_S) if clock else 0.0
            clock.append((line, stamp_at + days))
        if sentence.formatter in SOUNDED:
            sounded.add(sentence.formatter)
        for name, told, value in _values(sentence):
            found[name, told].append((line, value))
    clock = clock if len({stamp for _, stamp in clock}) > 1 else own
    if len({stamp for _, stamp in clock}) < 2:
        raise ConfigError(f"{path}: no sentence has a time: RMC, GGA, ZDA or GLL beside the others")
    columns = {
        name: log_column(_timed(rows, clock), told.unit) for (name, told), rows in found.items()
    }
    remarks = [f"{damaged} damaged sentences left out"] if damaged else []
    remarks += [f"{one}: the water below, not a boat's depth: left out" for one in sorted(sounded)]
    meant = dict[str, Meant]()
    order = [*SENTENCES, *(name for name, _ in found)]
    for (name, told), _ in sorted(found.items(), key=lambda one: order.index(_kind(one[0][0]))):
        meant.setdefault(told.channel, Meant(name, told.sign))
    return Log(path, begin_at_zero(columns), meant, tuple(remarks))


def _kind(name: str) -> str:
    return name[2:5] if name[2:5] in SENTENCES else name


def _lines(path: Path) -> Iterator[str]:
    with path.open(encoding="latin-1", newline="") as file:
        yield from file


def _number(fields: Sequence[str], index: int) -> float:
    try:
        return float(fields[index])
    except (IndexError, ValueError):
        return math.nan


def _time_of(sentence: NmeaSentence) -> float | None:
    """Return the time of day [s] that a sentence says; None if it says none."""
    index = TIME_FIELDS.get(sentence.formatter)
    stamp = "" if index is None else sentence.fields[index : index + 1]
    text = stamp[0] if stamp else ""
    if not re.fullmatch(r"\d{6}(?:\.\d*)?", text):
        return None
    return 3600.0 * int(text[:2]) + 60.0 * int(text[2:4]) + float(text[4:])


def _values(sentence: NmeaSentence) -> Iterator[tuple[str, Told, float]]:
    """Yield the columns that a sentence tells, what each is, and its number."""
    kind, fields = sentence.formatter, sentence.fields
    name = f"{sentence.talker}{kind}"
    for told in SENTENCES.get(name if sentence.talker == "P" else kind, ()):
        index, word = told.valid
        if index < 0 or fields[index : index + 1] == (word,):
            yield f"{name}.{told.channel}", told, _number(fields, told.field)
    if kind == "XDR":
        for i in range(0, len(fields) - 3, 4):
            value, unit, transducer = _number(fields, i + 1), fields[i + 2], fields[i + 3].upper()
            if transducer in TRANSDUCERS:
                channel, sign = TRANSDUCERS[transducer]
                unit = {"D": "deg", "M": "m"}.get(unit, unit)
                yield f"{name}.{transducer}", Told(channel, i, unit, sign), value
    place = PLACE_FIELDS.get(kind, -1)
    if 0 <= place <= len(fields) - 4 and "V" not in fields[:7]:
        for channel, at in (("latitude", place), ("longitude", place + 2)):
            whole, minutes = divmod(_number(fields, at), 100.0)
            half = -1.0 if fields[at + 1] in ("S", "W") else 1.0
            yield f"{name}.{channel}", Told(channel, at, "deg"), half * (whole + minutes / 60.0)


def _timed(
    rows: Sequence[tuple[int, float]], clock: Sequence[tuple[int, float]]
) -> Iterator[tuple[float, float]]:
    """Yield times [s] and numbers of a column's lines; what stands before the first time is out."""
    lines, stamps = np.array(clock, float).T
    new = np.append(True, np.diff(stamps) > 0.0)
    lines, stamps = lines[new], stamps[new]
    at, values = np.array(rows, float).T
    burst = np.searchsorted(lines, at, side="right") - 1
    for each in np.unique(burst[burst >= 0]):
        inside = np.flatnonzero(burst == each)
        begin = float(stamps[each])
        length = float(stamps[each + 1]) - begin if each + 1 < len(stamps) else 0.0
        for i, index in enumerate(inside):
            if length or not i:
                yield begin + length * i / len(inside), float(values[index])


def read_signal_k(path: Path) -> Log:
    """Return the columns of deltas, one a line, each source its own; ConfigError."""
    rows = defaultdict[tuple[str, str], list[tuple[float, float]]](list)
    remarks, wrong, sounded = list[str](), 0, False
    for text in _lines(path):
        start = text.find("{")
        if start < 0:
            continue
        try:
            delta = json.loads(text[start:])
            updates = [one for one in delta.get("updates", ()) if one.get("timestamp")]
            for update in updates:
                t = datetime.fromisoformat(update["timestamp"]).timestamp()
                source = str(update.get("$source") or update.get("source", {}).get("label", ""))
                for name, value in _leaves(update.get("values", ())):
                    sounded |= name.startswith(SOUNDED)
                    rows[name, source].append((t, value))
        except (ValueError, AttributeError, TypeError, KeyError):
            wrong += 1
    columns, meant = dict[str, LogColumn](), dict[str, Meant]()
    for (name, source), pairs in sorted(rows.items(), key=lambda one: -len(one[1])):
        channel, unit, sign = SIGNAL_K.get(name, ("", "", 1.0))
        if REVOLUTIONS_PATH.fullmatch(name):
            channel, unit = "revolutions", "1/s"
        one = f"{name} of {source}" if f"{name}" in columns else name
        columns[one] = log_column(pairs, unit)
        if channel and channel not in meant:
            meant[channel] = Meant(one, sign)
        elif channel:
            remarks.append(f"{channel}: {meant[channel].column}, which speaks oftener than {one}")
    remarks += [f"{wrong} lines that are no delta left out"] if wrong else []
    remarks += ["depth: the water below, not a boat's depth: left out"] if sounded else []
    return Log(path, begin_at_zero(columns), meant, tuple(remarks))


def _leaves(values: Sequence[Any]) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a delta's values by path, those of an object by its keys too."""
    for one in values:
        value = one["value"]
        parts = value.items() if isinstance(value, dict) else ((None, value),)
        for key, number in parts:
            if isinstance(number, int | float) and not isinstance(number, bool):
                yield one["path"] + (f".{key}" if key else ""), float(number)
