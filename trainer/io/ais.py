"""Messages of AIS (ITU-R M.1371) in the sentences VDM and VDO of NMEA 0183.

``session/nmea/transponders`` sends them.

    sentence  = "!AIVDM," parts "," part "," [ sequence ] "," channel "," payload "," fill "*" hh
    payload   = characters of six bits each, the most significant bit first
    fill      = the bits, 0 to 5, that fill up the last character

Numbers are two's complement where they have a sign. A value that is not available is sent as a
number that the standard reserves for it. A field is a value and its size in bits, in the
standard's order. ITU-R M.1371-5, annex 8, has the tables of the messages.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

from trainer.io.orders.sentences import checksum

CHARACTER_BITS: Final = 6  # [bits]
AIS_CHANNELS: Final = "AB"
MAX_PAYLOAD_LETTERS: Final = 60  # [characters] of the payload of one sentence
POSITION_A, STATIC_A, POSITION_B, STATIC_B = 1, 5, 18, 24
MAX_AIS_SPEED: Final = 1022  # [0.1 kn] this speed or above; 1023 is "not available"
TURN_FACTOR: Final = 4.733  # times the root of the rate [deg/min], by the standard
MAX_AIS_TURN: Final = 126  # stands for 708 deg/min or more
STATUS_CODES: Final = {  # navigational status by what a ship does
    "under way": 0,
    "at anchor": 1,
    "adrift": 2,  # not under command
    "fishing": 7,
    "trawling": 7,
    "sailing": 8,
}

Field = tuple[int, int]  # value and bits


class PositionReport(NamedTuple):
    """A position report; in degrees, knots, and degrees a minute."""

    mmsi: int
    latitude: float
    longitude: float
    speed: float
    course: float
    heading: float
    turning: float
    second: int  # of the minute, UTC
    status: int = 0


class ShipParticulars(NamedTuple):
    """Name, kind and sizes of a ship; lengths in metres from the antenna."""

    mmsi: int
    name: str
    kind: int
    bow: int
    stern: int
    port: int
    starboard: int
    draught: float = 0.0
    call_sign: str = ""


def payload(fields: Iterable[Field]) -> tuple[str, int]:
    """Return the characters of fields, and the bits that fill up the last one."""
    bits = "".join(f"{value & (1 << size) - 1:0{size}b}" for value, size in fields)
    fill = -len(bits) % CHARACTER_BITS
    bits += "0" * fill
    sixes = (int(bits[i : i + CHARACTER_BITS], 2) for i in range(0, len(bits), CHARACTER_BITS))
    return "".join(chr(six + 48 if six < 40 else six + 56) for six in sixes), fill


def text(words: str, characters: int) -> list[Field]:
    """Return a text of so many characters, padded with @. Unknown ones become blanks."""
    known = [c if " " <= c <= "_" else " " for c in words.upper()[:characters]]
    return [(ord(c) & 63, CHARACTER_BITS) for c in "".join(known).ljust(characters, "@")]


def sentences(fields: Iterable[Field], channel: str, sequence: int, kind: str = "VDM") -> list[str]:
    """Return the sentences of a message; ``sequence`` (0 to 9) joins its parts."""
    characters, fill = payload(fields)
    parts = [
        characters[i : i + MAX_PAYLOAD_LETTERS]
        for i in range(0, len(characters), MAX_PAYLOAD_LETTERS)
    ]
    joined = str(sequence) if len(parts) > 1 else ""
    lines = []
    for i, part in enumerate(parts, start=1):
        fill_bits = fill if i == len(parts) else 0
        body = f"AI{kind},{len(parts)},{i},{joined},{channel},{part},{fill_bits}"
        lines.append(f"!{body}*{checksum(body):02X}")
    return lines


def position_a(seen: PositionReport) -> list[Field]:
    """Return message 1, the position report of a ship with class A."""
    return [
        *_head(POSITION_A, seen.mmsi),
        (seen.status, 4),
        (rate_of_turn(seen.turning), 8),
        (_speed(seen.speed), 10),
        (0, 1),
        *_location(seen),
        (round(seen.heading) % 360, 9),
        (seen.second, 6),
        (0, 2),
        (0, 3),
        (0, 1),
        (0, 19),
    ]


def position_b(seen: PositionReport) -> list[Field]:
    """Return message 18, the position report of a small ship with class B."""
    return [
        *_head(POSITION_B, seen.mmsi),
        (0, 8),
        (_speed(seen.speed), 10),
        (0, 1),
        *_location(seen),
        (round(seen.heading) % 360, 9),
        (seen.second, 6),
        (0, 2),
        # carrier sense, no display, no selective calling, whole band, message 22, not assigned
        (1, 1),
        (0, 1),
        (0, 1),
        (1, 1),
        (1, 1),
        (0, 1),
        (0, 1),
        (0, 20),
    ]


def static_a(ship: ShipParticulars) -> list[Field]:
    """Return message 5, name, kind and sizes of a ship with class A."""
    return [
        *_head(STATIC_A, ship.mmsi),
        (2, 2),
        (0, 30),
        *text(ship.call_sign, 7),
        *text(ship.name, 20),
        (ship.kind, 8),
        *_sizes(ship),
        (1, 4),
        (0, 4),
        (0, 5),
        (24, 5),
        (60, 6),
        (min(round(10.0 * ship.draught), 255), 8),
        *text("", 20),
        (0, 1),
        (0, 1),
    ]


def static_b(ship: ShipParticulars) -> tuple[list[Field], list[Field]]:
    """Return messages 24 A and B: name, kind and sizes of class B."""
    head = _head(STATIC_B, ship.mmsi)
    part_a = [*head, (0, 2), *text(ship.name, 20), (0, 8)]
    vendor = [*text("", 3), (0, 4), (0, 20)]
    part_b = [*head, (1, 2), (ship.kind, 8), *vendor, *text(ship.call_sign, 7), *_sizes(ship)]
    return part_a, [*part_b, (0, 6)]


def rate_of_turn(degrees_a_minute: float) -> int:
    """Return a rate of turn in the standard's code: a root with its sign."""
    size: int = min(round(TURN_FACTOR * math.sqrt(abs(degrees_a_minute))), MAX_AIS_TURN)
    return -size if degrees_a_minute < 0.0 else size


def _head(kind: int, mmsi: int) -> Sequence[Field]:
    """Return type, repeat indicator and number."""
    return (kind, 6), (0, 2), (mmsi, 30)


def _location(seen: PositionReport) -> Sequence[Field]:
    """Return longitude, latitude and course."""
    longitude, latitude = round(seen.longitude * 600_000), round(seen.latitude * 600_000)
    return (longitude, 28), (latitude, 27), (round(10.0 * seen.course) % 3600, 12)


def _speed(knots: float) -> int:
    return min(round(10.0 * knots), MAX_AIS_SPEED)


def _sizes(ship: ShipParticulars) -> Sequence[Field]:
    """Return how far bow, stern and sides are from the antenna."""
    ends = (min(ship.bow, 511), 9), (min(ship.stern, 511), 9)
    return *ends, (min(ship.port, 63), 6), (min(ship.starboard, 63), 6)
