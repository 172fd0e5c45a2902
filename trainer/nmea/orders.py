"""Sentences of NMEA 0183 that order: what a heading controller, a wheel or a telegraph sends.

    HTC  heading/track control command: rudder in steering modes R and M, heading in H and S
    HSC  heading steering command: a true heading
    ROR  rudder order, starboard or single
    ETL  engine telegraph, an order (O)
    PRC  propulsion remote control: revolutions a minute (R)

They become the words of the same orders typed at a station. Fields as IEC 61162-1 has them.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from trainer.io.nmea import Sentence

# Positions of the standard's telegraph and the bells of ours. The standard has more astern.
TELEGRAPH: Final[Mapping[str, str]] = {
    "00": "stop",
    "01": "ahead one-third",  # dead slow
    "02": "ahead two-thirds",  # slow
    "03": "ahead standard",  # half
    "04": "ahead full",
    "05": "ahead flank",  # navigation full
    "11": "astern one-third",  # dead slow
    "12": "astern one-third",  # slow
    "13": "astern two-thirds",  # half
    "14": "astern full",
    "15": "astern full",  # crash
}
POSITIONS: Final = {
    **{bell: position for position, bell in TELEGRAPH.items()},
    "astern full": "14",
    "astern one-third": "12",
}

PLAIN: Final = re.compile(r"[+-]?[0-9]{1,6}(?:\.[0-9]*)?", re.ASCII)
STEERING, ENGINE = "steering", "engine"


@dataclass(frozen=True)
class Command:
    """An order in words, and what it is for: a later one for the same takes its place."""

    control: str
    words: str


@dataclass(frozen=True)
class Useless:
    """Why a sentence orders nothing; the same words for the same fault."""

    reason: str


Meaning = Command | Useless


def meaning(sentence: Sentence) -> Meaning | None:
    """Return what a sentence orders, why it does not, or None when its kind never does."""
    reader = READERS.get(sentence.formatter)
    if reader is None or sentence.talker == "P":
        return None
    needed, read = reader
    if len(sentence.fields) < needed:
        return Useless(f"{sentence.formatter} with less than {needed} fields")
    return read(sentence.fields)


def heading_control(fields: tuple[str, ...]) -> Meaning:
    """Return what HTC orders: override and modes R, M the rudder, modes H, S the heading."""
    if len(fields) > 13 and fields[13] != "C":
        return Useless("HTC that is a report, not a command (C)")
    override, angle, side, mode = fields[:4]
    if override == "A" or mode in ("R", "M"):
        sides = {"L": "left", "R": "right"}
        if side not in sides or not PLAIN.fullmatch(angle):
            return Useless("HTC of the rudder without its angle and L or R")
        return Command(STEERING, f"rudder {sides[side]} {angle}")
    if mode in ("H", "S"):
        return heading("HTC", fields[9], fields[12])
    return Useless("HTC in a mode other than R, M (rudder) and H, S (heading)")


def heading_steering(fields: tuple[str, ...]) -> Meaning:
    """Return what HSC orders."""
    if len(fields) > 4 and fields[4] != "C":
        return Useless("HSC that is a report, not a command (C)")
    return heading("HSC", fields[0], fields[1])


def heading(formatter: str, degrees: str, reference: str) -> Meaning:
    """Return the order to steer a heading, which must be a true one."""
    if not PLAIN.fullmatch(degrees):
        return Useless(f"{formatter} without a heading")
    if reference != "T":
        return Useless(f"{formatter} by magnetic north: only true headings (T) are steered")
    return Command(STEERING, f"course {degrees}")


def rudder(fields: tuple[str, ...]) -> Meaning:
    """Return what ROR orders; minus turns the bow to port."""
    angle, status = fields[:2]
    if status != "A" or not PLAIN.fullmatch(angle):
        return Useless("ROR without a valid starboard or single rudder order")
    side = "left" if angle.startswith("-") else "right"
    return Command(STEERING, f"rudder {side} {angle.lstrip('+-')}")


def telegraph(fields: tuple[str, ...]) -> Meaning:
    """Return what ETL orders."""
    if fields[1] != "O":
        return Useless("ETL that is no order (O)")
    if fields[2] not in TELEGRAPH:
        return Useless("ETL of no position of the telegraph, 00 to 05 and 11 to 15")
    return Command(ENGINE, f"bell {TELEGRAPH[fields[2]]}")


def propulsion(fields: tuple[str, ...]) -> Meaning:
    """Return what PRC orders."""
    turns, how = fields[2:4]
    if how != "R" or not PLAIN.fullmatch(turns):
        return Useless("PRC without revolutions a minute (R)")
    return Command(ENGINE, f"rpm {turns}")


# By formatter: the least number of fields, and who reads them.
READERS: Final[Mapping[str, tuple[int, Callable[[tuple[str, ...]], Meaning]]]] = {
    "HTC": (13, heading_control),
    "HSC": (2, heading_steering),
    "ROR": (2, rudder),
    "ETL": (3, telegraph),
    "PRC": (4, propulsion),
}
