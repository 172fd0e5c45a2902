"""Lines of NMEA 0183 as a station has them: sentences that order become words, others are counted.

What a station is answered and told is not sent: instruments would not understand it. The sets of
sentences go to the line underneath, by a subscription.
"""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from trainer.io import nmea
from trainer.io.hub import Hub
from trainer.io.line import Line
from trainer.io.lines import Overlong
from trainer.nmea.orders import Command, Useless, meaning

if TYPE_CHECKING:
    from trainer.io.connection import Connection

AGAIN: Final = 10.0  # [s] after which the same command, sent all the time, is given anew
KINDS_TOLD: Final = 16  # of sentences ignored: the others are only counted
OWN: Final = frozenset({"ROR", "ETL"})  # sent here too: an echo of them is no order

Log = Callable[[str, str], None]  # takes a kind of trainer.stations.roles.KINDS and a text


class NmeaLine:
    """A line of sentences, for a station."""

    def __init__(
        self,
        line: Line,
        wake: threading.Event,
        log: Log,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Hear ``line``; ``wake`` is set when it has more to take than was asked for."""
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

    def take(self, most: int) -> list[str | Overlong]:
        """Return the orders among the oldest lines that have come, and lines that are damaged."""
        lines = self._line.take(most)
        if len(lines) == most:
            self._wake.set()
        return [heard for line in lines if (heard := self._hear(line)) is not None]

    def send(self, line: str) -> None:
        """Drop what is for people."""

    def close(self, patience: float) -> None:
        """Get out what was sent, for at most `patience` [s], and end the line."""
        self._line.close(patience)

    def _hear(self, line: str | Overlong) -> str | Overlong | None:
        """Return the words of an order, a line that is damaged as it is, or None."""
        if isinstance(line, Overlong):
            return line
        heard = nmea.hear(line)
        if isinstance(heard, nmea.Damaged):
            return line
        if heard is None:
            self._ignore("what is no sentence")
            return None
        ordered = meaning(heard)
        if isinstance(ordered, Command) and not (heard.talker == "IN" and heard.formatter in OWN):
            return self._give(ordered)
        kind = f"{heard.talker}{heard.formatter}"
        self._ignore(ordered.reason if isinstance(ordered, Useless) else kind)
        return None

    def _give(self, command: Command) -> str | None:
        """Return the words of a command, None while it is the one given last."""
        now = self._clock()
        words, given = self._given.get(command.control, ("", now))
        if words == command.words and now - given < AGAIN:
            return None
        self._given[command.control] = command.words, now
        return command.words

    def _ignore(self, what: str) -> None:
        """Count a sentence; tell of the first of its kind."""
        self.ignored += 1
        if what not in self._told and len(self._told) < KINDS_TOLD:
            self._told.add(what)
            self._log("refused", f"{self.name}: {what}: ignored, as all of them will be")


class Readers:
    """All that are connected to a port, as one line: each is sent everything, any may order.

    ``take`` is for one thread, ``send`` for any.
    """

    ended = False
    trouble = ""

    def __init__(self, name: str, hub: Hub, log: Log) -> None:
        self.name = name
        self._hub = hub
        self._log = log
        self._readers: tuple[Connection, ...] = ()  # replaced, never altered
        self._lost = 0  # by those that have gone

    @property
    def dropped(self) -> int:
        """Return how many sentences did not get out, over all readers."""
        return self._lost + sum(reader.dropped for reader in self._readers)

    def take(self, most: int) -> list[str | Overlong]:
        """Return the oldest lines that have come, at most so many, and see who comes and goes."""
        self._see_who_is_there()
        lines: list[str | Overlong] = []
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

        One that has only ended its own side still reads, as a program without a keyboard does.
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
