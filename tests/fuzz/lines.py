"""The targets that read lines: orders, sentences, and a session's answers."""

import functools
import itertools
import threading
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np
from helpers.boats import start_boat
from numpy.typing import NDArray

from fuzz.fuzz import Target, text_of
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.console.charts import Quantity
from trainer.console.client import Item
from trainer.console.model import SessionModel
from trainer.io import nmea
from trainer.io.lines import LineDecoder, OverlongLine
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import parse_schedule
from trainer.io.orders.table import FORMS
from trainer.io.orders.words import BOAT_ORDERS
from trainer.session.nmea.orders import Command, NmeaLine, meaning
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import PromptSender, Roster
from trainer.session.stations.view import Pace, StateReader
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

TOKEN: Final = "proving-1969"  # noqa: S105  a word of the proof
ENOUGH: Final = 64  # [lines] of one input
FEW: Final = 3  # [lines] of an example
GRAMMAR: Final = "tomllib", "trainer.io.orders.grammar"  # `orders` looks into it
SPOKEN: Final = (
    "rudder left 15",
    "depth 60 m",
    "course right 30",
    "speed 8.5 kn",
    "bell ahead two thirds",
    "planes rise 5",
    "blow all",
    "vent main ballast",
    "pump trim forward 3 t",
    "casualty flooding-aft 0.1 ramp 25 s",
    "clear all",
    "sea state 5",
    "sea 3.5 m from 045 in 2 min",
    "snapshot a-1",
    "backtrack 8 min",
    "subscribe gauges at 5 hz",
    "unsubscribe all",
    "role helm proving-1969",
    "mark so far # good",
    "help rudder",
    "hover on",
    "time x10",
    "freeze tanks",
    "release tanks",
    "step 3",
    "replay 20 s",
    "log 5",
)
INSTRUMENTS: Final = (
    ("IIHTC", "V", "10.0", "L", "M", "T", "15.0", "10.0", "10", "15.0", "90.0", "0.5", "90", "T"),
    ("IIHTC", "A", "5", "R", "S", "R", "", "", "", "", "", "", "", "T", "C", ""),
    ("IIHSC", "75.0", "T", "80.0", "M", "C"),
    ("IIROR", "-12.5", "A", "", "V", "B"),
    ("IIETL", "120000", "O", "04", "30", "B", "0"),
    ("IIPRC", "50", "A", "90.5", "R", "10", "P", "B", "1"),
)
CHART: Final = Quantity("depth", "m", ("motion", "depth"), ("motion", "ordered_depth"), 1.0)


def order(data: bytes) -> None:
    """Read a line of words. An order reads back from its own wording as the same one."""
    found = parse(text_of(data))
    if isinstance(found, Order) and found.name != "role" and len(found.text) <= 80:
        again = parse(found.text)
        if again != found:
            raise AssertionError(f"{found!r} reads back as {again!r}")


def sentence(data: bytes) -> None:
    """Hear a line as a session and as a program do."""
    text = text_of(data)
    sentences.parse_line(text)
    sentences.parse_sentence(text)


def stream(data: bytes) -> None:
    """Cut bytes into lines, wherever they come apart. Never more than a line is held."""
    whole, pieces = LineDecoder(), LineDecoder()
    cut = data[0] % len(data) if data else 0
    lines = whole.feed(data)
    parts = [*pieces.feed(data[:cut]), *pieces.feed(data[cut:])]
    if lines != parts or whole.held > whole.limit:
        raise AssertionError(f"cut at {cut}: {parts!r}, whole: {lines!r}")


def instrument(data: bytes) -> None:
    """Read a sentence of NMEA 0183. What it orders is in the words of the grammar."""
    heard = nmea.parse_sentence(text_of(data))
    ordered = meaning(heard) if isinstance(heard, nmea.NmeaSentence) else None
    if isinstance(ordered, Command) and parse(ordered.words) is None:
        raise AssertionError(f"{ordered.words!r} is no line")


def schedule(data: bytes) -> None:
    """Read a file of orders at set times."""
    parse_schedule(text_of(data), "orders.txt")


class Wire:
    """A line that brings what it was given, and drops what is sent."""

    name = "wire"
    trouble = ""
    dropped = 0
    room = True

    def __init__(self, lines: Iterable[str | OverlongLine]) -> None:
        self._lines = list(lines)

    @property
    def ended(self) -> bool:
        """Return whether all has been taken."""
        return not self._lines

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the oldest lines."""
        taken, self._lines = self._lines[:most], self._lines[most:]
        return taken

    def send(self, _line: str) -> None:
        """Drop a line."""

    def close(self, _patience: float) -> None:
        """Do nothing."""


@functools.cache
def boat() -> tuple[Boat, NDArray[np.void]]:
    """Return a boat with everything fitted, and how it starts."""
    made = start_boat(8 * KNOT, 40.0, equations="modified")
    return made, made.snapshot()


def attend(lines: list[str | OverlongLine], door: Access, one: Boat) -> Station:
    """Return a station that has these lines to say. It is sent what it asks for at once."""
    sending = PromptSender(Roster(StateReader(one, Ledger(one.method.step).summary)))
    sending.offer(0, one.records.state.tobytes(), Pace())
    return Station(
        Wire(lines), door, sending, take_log if door.tokens else take_plain_log, lambda: 0.0
    )


def take_log(_kind: str, text: str) -> None:
    """Take what a station logs, which never has the token."""
    if TOKEN in text:
        raise AssertionError(f"the token is logged: {text!r}")


def take_plain_log(_kind: str, _text: str) -> None:
    """Take what a station logs that was asked for no token."""


def station(data: bytes) -> None:
    """Attend as a stranger with these bytes, then as an instructor with the rest.

    The instructor is obeyed.
    """
    lines = LineDecoder().feed(data)[:ENOUGH]
    one, start = boat()
    one.restore(start)
    for door in (Access(tokens={"": TOKEN}), Access("instructor")):
        attending = attend(lines, door, one)
        for asked in attending.take(ENOUGH):
            if asked.order.name in BOAT_ORDERS:
                attending.answer(asked, obey_order(one, asked.order))
        attending.account()
        attending.leave()


def panel(data: bytes) -> None:
    """Be instruments that order."""
    wire = Wire(LineDecoder().feed(data)[:ENOUGH])
    line = NmeaLine(wire, threading.Event(), take_log, lambda: 0.0)
    for heard in line.take(ENOUGH):
        if isinstance(heard, str):
            sentences.parse_line(heard)


class Said:
    """A session that has said these lines and answers no more."""

    def __init__(self, items: list[Item]) -> None:
        self._items = items
        self._tags = itertools.count(10)

    def order(self, _words: str) -> str:
        """Return the tag of an order."""
        return str(next(self._tags))

    def take(self) -> list[Item]:
        """Return all that was said."""
        items, self._items = self._items, []
        return items


def session(data: bytes) -> None:
    """See what a session says as the instructor's screen does."""
    lines = LineDecoder(sentences.MAX_ANSWER_LETTERS).feed(data)[:ENOUGH]
    heard = [sentences.parse_sentence(line) for line in lines if isinstance(line, str)]
    model = SessionModel(
        Said([each for each in heard if each]), "instructor", (CHART,), lambda: 1.0
    )
    for words in ("snapshots", "casualties", "depth 80"):
        model.ask(words)
    model.hear()
    for channel in ("motion", "time"):
        model.picture.smooth(channel, "depth", 2.0)


def words() -> Iterator[str]:
    """Yield examples of every order."""
    yield from SPOKEN
    for form in FORMS:
        yield form.pattern.replace("[", "").replace("]", "").replace("|", " ").replace("NUM", "5")


def each_line() -> list[bytes]:
    """Return each example as an input."""
    return [text.encode() for text in words()]


def frame_examples() -> list[bytes]:
    """Return the examples as programs send them, and answers."""
    said = [
        sentences.order_sentence("rudder left 15", "7"),
        sentences.answer("12", accepted=True, text="back from 40 s to 20 s, frozen"),
        sentences.say("11", "flooding-aft 0.1"),
        sentences.answer("10", accepted=True, text="snapshots: a (20 s); b (1e+03 s)"),
        sentences.names("motion", [("depth", "m"), ("ordered_depth", "m")]),
        sentences.state("motion", 3, 1.5, ["41.5", "60"]),
        sentences.event(3, 1.5, "time", "the session is over"),
        sentences.event(3, 1.5, "mark", "helm: mark here: marked at 2 s"),
        sentences.fact(3, 1.5, "casualty", "flooding-aft,0.1 ramp 5,The sea enters"),
        sentences.fact(3, 1.5, "back", "backtrack 2 min"),
        sentences.fact(3, 1.5, "snapshot", "before-jam"),
        sentences.fact(3, 1.5, "over", ""),
    ]
    return [text.encode() for text in said]


def instruments() -> list[bytes]:
    """Return sentences of instruments that order."""
    return [nmea.sentence(*fields).encode() for fields in INSTRUMENTS]


def together(lines: list[bytes]) -> list[bytes]:
    """Return inputs of a few lines each."""
    groups = (lines[i : i + FEW] for i in range(0, len(lines), FEW))
    return [b"\r\n".join(group) + b"\r\n" for group in groups]


def time_examples() -> list[bytes]:
    """Return files of orders."""
    lines = [b"%d %s" % (i, line) for i, line in enumerate(each_line())]
    return [line.replace(b"\r\n", b"\n") for line in together(lines)]


TARGETS: Final = (
    Target("orders", "a line of words, one order", order, each_line, 96),
    Target("sentences", "a line of a program, either way", sentence, frame_examples, 128),
    Target("lines", "bytes of a serial line or a socket", stream, lambda: together(each_line())),
    Target("nmea", "a sentence of an instrument that orders", instrument, instruments, 128),
    Target(
        "panel", "instruments at the helm", panel, lambda: together(instruments()), 256, GRAMMAR
    ),
    Target("schedule", "a file of orders at set times", schedule, time_examples, 256, GRAMMAR),
    Target(
        "station",
        "lines at a station, its wishes, its orders obeyed",
        station,
        lambda: together([*each_line(), *frame_examples()]),
        192,
        GRAMMAR,
    ),
    Target(
        "session", "what a session says, at a screen", session, lambda: together(frame_examples())
    ),
)
