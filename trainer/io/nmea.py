"""Sentences of NMEA 0183 (IEC 61162-1): fields framed with a checksum, and read again.

``session/nmea`` sends and takes them.

    sentence  = "$" address { "," field } "*" checksum CR LF     at most 82 characters in all
    address   = talker, two letters, and formatter, three; or "P" and a maker's letters
    checksum  = two hexadecimal digits, the exclusive or of every character between "$" and "*"

An empty field has no value at present. Other modules know what the fields mean.
"""

import re
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from trainer.io.orders.sentences import checksum

MAX_SENTENCE_LETTERS: Final = 82  # [characters] of a sentence, its line end included
# [characters] of a sentence with the head of IEC 61162-450 and a TAG block before it
MAX_HEADED_LETTERS: Final = 6 + 80 + MAX_SENTENCE_LETTERS
LINE_END: Final = 2  # [characters]
SENTENCE_PATTERN: Final = re.compile(r"[$!]([^$*]*)\*([0-9A-Fa-f]{2})")  # AIS begins with "!"
ADDRESS_PATTERN: Final = re.compile(r"P[A-Z0-9]{2,5}|[A-Z0-9]{5}")
MINUTE_PARTS: Final = 10**5  # parts of a minute of arc that a position is given in: 2 cm


@dataclass(frozen=True)
class NmeaSentence:
    """A sentence received, its checksum right; a maker's own has the talker P."""

    talker: str
    formatter: str
    fields: tuple[str, ...]


@dataclass(frozen=True)
class DamagedSentence:
    """A line that begins like a sentence and is damaged."""

    reason: str


def sentence(address: str, *fields: str) -> str:
    """Return a sentence without its line end. ValueError when it is too long to be one."""
    body = ",".join((address, *fields))
    framed = f"${body}*{checksum(body):02X}"
    if len(framed) > MAX_SENTENCE_LETTERS - LINE_END:
        raise ValueError(
            f"{framed}: {len(framed)} characters; {MAX_SENTENCE_LETTERS - LINE_END} at most"
        )
    return framed


def parse_sentence(line: str) -> NmeaSentence | DamagedSentence | None:
    """Return the last sentence on `line`, None when it holds none. Never raises.

    What stands before it is passed over: a TAG block, the head of IEC 61162-450, a time stamp.
    """
    text = line.strip()
    damage = None
    if text.startswith("$"):
        damage = DamagedSentence("not framed by $ and *, with two digits of checksum")
    for index in reversed([index for index, letter in enumerate(text) if letter in "$!"]):
        match = SENTENCE_PATTERN.fullmatch(text, index)
        if not (match and match[0].isascii() and match[0].isprintable()):
            continue
        body, sum_digits = match.groups()
        if int(sum_digits, 16) == checksum(body):
            return parse_body(body)
        damage = DamagedSentence(
            f"wrong checksum {sum_digits.upper()}; this sentence's is {checksum(body):02X}"
        )
    return damage


def parse_body(body: str) -> NmeaSentence | DamagedSentence:
    """Return the sentence of what stood between its frame."""
    address, *fields = body.split(",")
    if not ADDRESS_PATTERN.fullmatch(address):
        return DamagedSentence("no talker and formatter")
    letters = 1 if address.startswith("P") else 2
    return NmeaSentence(address[:letters], address[letters:], tuple(fields))


def number(value: float | None, decimals: int) -> str:
    """Return a number with so many decimals, "" for none; never a minus before zero."""
    return "" if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"


def latitude(degrees: float) -> tuple[str, str]:
    """Return a latitude [deg] as ddmm.mmmmm and N or S."""
    return arc(degrees, 2), "N" if degrees >= 0.0 else "S"


def longitude(degrees: float) -> tuple[str, str]:
    """Return a longitude [deg] as dddmm.mmmmm and E or W."""
    return arc(degrees, 3), "E" if degrees >= 0.0 else "W"


def arc(degrees: float, digits: int) -> str:
    """Return the size of an angle as whole degrees, in so many digits, and minutes."""
    whole, parts = divmod(round(abs(degrees) * 60 * MINUTE_PARTS), 60 * MINUTE_PARTS)
    minutes, parts = divmod(parts, MINUTE_PARTS)
    return f"{whole:0{digits}d}{minutes:02d}.{parts:05d}"


def time_of_day(at: datetime) -> str:
    """Return hours, minutes, seconds and hundredths."""
    return f"{at:%H%M%S}.{at.microsecond // 10000:02d}"


def date(at: datetime) -> str:
    """Return day, month and the last two digits of the year."""
    return f"{at:%d%m%y}"
