"""Orders by NMEA 0183, as a heading controller, a wheel or a telegraph sends them.

    HTC  heading/track control command: rudder in steering modes R and M, heading in H and S
    HSC  heading steering command: a true heading
    ROR  rudder order, starboard or single
    ETL  engine telegraph, an order (O)
    PRC  propulsion remote control: revolutions a minute (R)

They become the words that a helmsman would type. Fields are those of IEC 61162-1. Other sentences
are counted and ignored.

``NmeaLine`` and ``ReaderLine`` are lines of such sentences for a station. They send no answers and
no news, because instruments would not understand them. Sets of sentences go to the line underneath,
by a subscription.
"""

import re
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from trainer.io import nmea
from trainer.io.line import Line
from trainer.io.lines import OverlongLine
from trainer.io.nmea import NmeaSentence
from trainer.io.server import Server

if TYPE_CHECKING:
    from trainer.io.connection import Connection

# Positions of the standard's telegraph and the bells of ours. The standard has more astern.
TELEGRAPH_BELLS: Final[Mapping[str, str]] = {
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
# the position sent for a bell; of the two of one astern bell it is the one that is not an extreme
BELL_POSITIONS: Final = {
    **{bell: position for position, bell in TELEGRAPH_BELLS.items()},
    "astern full": "14",
    "astern one-third": "12",
}

NUMBER_PATTERN: Final = re.compile(r"[+-]?[0-9]{1,6}(?:\.[0-9]*)?", re.ASCII)
STEERING_CONTROL, ENGINE_CONTROL = "steering", "engine"
# [s] after which a command that a controller repeats all the time is given again: it then takes the
# rudder back from a station that took it meanwhile (docs/nmea.md)
REPEAT_PERIOD_S: Final = 10.0
MAX_TOLD_KINDS: Final = 16  # kinds of ignored sentences that are announced; others are only counted
OWN_FORMATTERS: Final = frozenset({"ROR", "ETL"})  # the trainer sends these too: no echo may order
Log = Callable[[str, str], None]  # takes a kind of stations.roles.EVENT_KINDS and a text


@dataclass(frozen=True)
class Command:
    """An order in words, and the control that it is for. A later one replaces it."""

    control: str
    words: str


@dataclass(frozen=True)
class UnusableSentence:
    """Why a sentence orders nothing. The same fault has the same words, so it is logged once."""

    reason: str


Meaning = Command | UnusableSentence


def meaning(sentence: NmeaSentence) -> Meaning | None:
    """Return the order of a sentence, or its error. None: this kind never orders."""
    reader = SENTENCE_READERS.get(sentence.formatter)
    if reader is None or sentence.talker == "P":
        return None
    needed, read = reader
    if len(sentence.fields) < needed:
        return UnusableSentence(f"{sentence.formatter} with less than {needed} fields")
    return read(sentence.fields)


def heading_control(fields: tuple[str, ...]) -> Meaning:
    """Return the orders of HTC.

    Override and modes R, M order the rudder, modes H, S the heading.
    """
    if len(fields) > 13 and fields[13] != "C":
        return UnusableSentence("HTC that is a report, not a command (C)")
    override, angle, side, mode = fields[:4]
    if override == "A" or mode in ("R", "M"):
        sides = {"L": "left", "R": "right"}
        if side not in sides or not NUMBER_PATTERN.fullmatch(angle):
            return UnusableSentence("HTC of the rudder without its angle and L or R")
        return Command(STEERING_CONTROL, f"rudder {sides[side]} {angle}")
    if mode in ("H", "S"):
        return heading("HTC", fields[9], fields[12])
    return UnusableSentence("HTC in a mode other than R, M (rudder) and H, S (heading)")


def heading_steering(fields: tuple[str, ...]) -> Meaning:
    """Return what HSC orders."""
    if len(fields) > 4 and fields[4] != "C":
        return UnusableSentence("HSC that is a report, not a command (C)")
    return heading("HSC", fields[0], fields[1])


def heading(formatter: str, degrees: str, reference: str) -> Meaning:
    """Return the order to steer a heading, which must be a true one."""
    if not NUMBER_PATTERN.fullmatch(degrees):
        return UnusableSentence(f"{formatter} without a heading")
    if reference != "T":
        return UnusableSentence(
            f"{formatter} by magnetic north: only true headings (T) are steered"
        )
    return Command(STEERING_CONTROL, f"course {degrees}")


def rudder(fields: tuple[str, ...]) -> Meaning:
    """Return what ROR orders; minus turns the bow to port."""
    angle, status = fields[:2]
    if status != "A" or not NUMBER_PATTERN.fullmatch(angle):
        return UnusableSentence("ROR without a valid starboard or single rudder order")
    side = "left" if angle.startswith("-") else "right"
    return Command(STEERING_CONTROL, f"rudder {side} {angle.lstrip('+-')}")


def telegraph(fields: tuple[str, ...]) -> Meaning:
    """Return what ETL orders."""
    if fields[1] != "O":
        return UnusableSentence("ETL that is no order (O)")
    if fields[2] not in TELEGRAPH_BELLS:
        return UnusableSentence("ETL of no position of the telegraph, 00 to 05 and 11 to 15")
    return Command(ENGINE_CONTROL, f"bell {TELEGRAPH_BELLS[fields[2]]}")


def propulsion(fields: tuple[str, ...]) -> Meaning:
    """Return what PRC orders."""
    turns, how = fields[2:4]
    if how != "R" or not NUMBER_PATTERN.fullmatch(turns):
        return UnusableSentence("PRC without revolutions a minute (R)")
    return Command(ENGINE_CONTROL, f"rpm {turns}")


# By formatter: the least number of fields, and who reads them.
SENTENCE_READERS: Final[Mapping[str, tuple[int, Callable[[tuple[str, ...]], Meaning]]]] = {
    "HTC": (13, heading_control),
    "HSC": (2, heading_steering),
    "ROR": (2, rudder),
    "ETL": (3, telegraph),
    "PRC": (4, propulsion),
}


class NmeaLine:
    """A line of sentences, as a station takes it for a line of words.

    It makes orders of the sentences that come in, and drops what is sent for people.
    """

    def __init__(
        self,
        line: Line,
        wake: threading.Event,
        log: Log,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Hear ``line``. ``wake`` is set when more lines may wait than were taken."""
        self.name = line.name
        self.ignored = 0  # sentences that are no order
        self._line = line
        self._wake = wake
        self._log = log
        self._clock = clock
        self._told: set[str] = set()
        self._given: dict[str, tuple[str, float]] = {}  # words and time [s], by what they control

    @property
    def ended(self) -> bool:
        """Return whether all that came has been taken, and nothing more can come."""
        return self._line.ended

    @property
    def trouble(self) -> str:
        """Return why the line is dead."""
        return self._line.trouble

    @property
    def dropped(self) -> int:
        """Return how many sentences did not get out."""
        return self._line.dropped

    @property
    def room(self) -> bool:
        """Return whether little waits to go out."""
        return self._line.room

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the orders among the oldest lines that have come, and lines that are damaged."""
        lines = self._line.take(most)
        if len(lines) == most:
            self._wake.set()
        return [heard for line in lines if (heard := self._hear(line)) is not None]

    def send(self, line: str) -> None:
        """Drop a line for people."""

    def close(self, patience: float) -> None:
        """Get out what was sent, for at most `patience` [s], and end the line."""
        self._line.close(patience)

    def _hear(self, line: str | OverlongLine) -> str | OverlongLine | None:
        """Return the words of an order, a damaged line unchanged, or None for others."""
        if isinstance(line, OverlongLine):
            return line
        heard = nmea.parse_sentence(line)
        if isinstance(heard, nmea.DamagedSentence):
            return line
        if heard is None:
            self._ignore("what is no sentence")
            return None
        ordered = meaning(heard)
        if isinstance(ordered, Command) and not (
            heard.talker == "IN" and heard.formatter in OWN_FORMATTERS
        ):
            return self._give(ordered)
        kind = f"{heard.talker}{heard.formatter}"
        self._ignore(ordered.reason if isinstance(ordered, UnusableSentence) else kind)
        return None

    def _give(self, command: Command) -> str | None:
        """Return the words of a command, None while it only repeats the last one.

        A controller repeats its command several times a second; the journal must not fill with it.
        """
        now = self._clock()
        words, given_at = self._given.get(command.control, ("", now))
        if words == command.words and now - given_at < REPEAT_PERIOD_S:
            return None
        self._given[command.control] = command.words, now
        return command.words

    def _ignore(self, what: str) -> None:
        """Count an ignored sentence, and announce the first of its kind."""
        self.ignored += 1
        if what not in self._told and len(self._told) < MAX_TOLD_KINDS:
            self._told.add(what)
            self._log("refused", f"{self.name}: {what}: ignored, as all of them will be")


class ReaderLine:
    """All clients of a port as one line. Each gets every sentence, and any may order.

    ``take`` is for one thread, ``send`` for any.
    """

    ended = False
    trouble = ""
    room = True  # a slow reader holds up nobody

    def __init__(self, name: str, hub: Server, log: Log) -> None:
        self.name = name
        self._hub = hub
        self._log = log
        self._readers: tuple[Connection, ...] = ()  # replaced, never altered
        self._lost = 0  # by those that have gone

    @property
    def dropped(self) -> int:
        """Return how many sentences did not get out, over all readers."""
        return self._lost + sum(reader.dropped for reader in self._readers)

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the oldest lines that have come, at most so many. See who comes and goes."""
        self._see_who_is_there()
        lines: list[str | OverlongLine] = []
        for reader in self._readers:
            lines += reader.take(most - len(lines))
        self._readers = (*self._readers[1:], *self._readers[:1])  # another is first next time
        return lines

    def send(self, line: str) -> None:
        """Send one line to all; a slow reader loses its own."""
        for reader in self._readers:
            reader.send(line)

    def close(self, patience: float) -> None:
        """Stop listening, get out what was sent, for at most `patience` [s], and close all."""
        self._hub.close(patience)

    def _see_who_is_there(self) -> None:
        """Let newcomers read; forget those whose connection has failed.

        A client that has only ended its own side is kept, because it still reads.
        """
        for newcomer in self._hub.newcomers():
            self._readers = (*self._readers, newcomer)
            self._log("station", f"{newcomer.name} reads {self.name}")
        for reader in self._readers:
            if reader.trouble:
                self._readers = tuple(each for each in self._readers if each is not reader)
                self._lost += reader.dropped
                reader.close(0.0)
                self._log("station", f"{reader.name} no longer reads {self.name}: {reader.trouble}")
