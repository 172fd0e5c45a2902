"""The boats of a class in one sea: each session is told of the others.

The class has one line more to each session, in a role of its own (``class``). It hears there where
the boat is, and tells it of the others by the order ``contact boat``, which the session journals as
any order to the world. So a recording is replayed without the others. A boat goes straight on as it
was told last, and is told again when it is elsewhere by PLACE_ERROR_M or DEPTH_ERROR_M.

Each session has its own time. What is told here is where the others are now, whatever their clocks
say. A boat that jumps in time, is resumed, begins anew or has run its time at another rate is not
shown to the others before it is PARTED_M off, nor are they to it, so that nobody is put into
another's hull.
"""

import itertools
import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.classroom.fleet import AnyBoat, Tell
from trainer.config.exercise.class_file import DEPTH_ERROR_M, PLACE_ERROR_M
from trainer.config.files import quote
from trainer.io import client
from trainer.io.line import Line
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.sentences import Sentence, order_sentence, parse_sentence
from trainer.io.serial_line import LinkError
from trainer.units import KNOT

LOOK_PERIOD_S: Final = 0.2  # between two looks at all boats
HEARD_HZ: Final = 5  # at which a session says where its boat is
PARTED_M: Final = 300.0  # between two boats that are shown to each other for the first time
FARTHEST_M: Final = 50_000.0  # between two boats that are shown to each other
LOST_AFTER_S: Final = 60.0  # that a boat without a line goes on as it went; then it is taken away
REDIAL_S: Final = 2.0
ROLE_TAG: Final = "1"  # of the order by which the class says who it is
MOST_LINES: Final = 256  # taken of a session at once
LEAST_WAY: Final = 0.1  # [m/s] below which a boat lies still, and its heading stands for its course


class Place(NamedTuple):
    """Where a boat is [m] in the class's sea, and how it goes [m/s], [deg]."""

    north: float
    east: float
    depth: float
    v_north: float = 0.0
    v_east: float = 0.0
    heading: float = 0.0

    def after(self, seconds: float) -> "Place":
        """Return where it is so much later [s], straight on at its depth."""
        north, east = self.north + self.v_north * seconds, self.east + self.v_east * seconds
        return self._replace(north=north, east=east)

    def apart(self, other: "Place") -> float:
        """Return the distance [m] of two boats, seen from above."""
        return math.hypot(self.north - other.north, self.east - other.east)


class Told(NamedTuple):
    """What a session was told last of another boat, and when [s]."""

    place: Place
    seconds: float


@dataclass
class SeaBoat:
    """One boat, as the class hears of it and speaks to it."""

    boat: AnyBoat
    word: str  # the instructor's
    origin_east: float  # [m] of its start in the sea of the class
    tell: Tell
    clock: Callable[[], float]
    told: dict[int, Told] = field(default_factory=dict)  # by the numbers of the others
    parted: set[int] = field(default_factory=set)  # from whom it has been PARTED_M off
    jumped: bool = False  # since the class has looked last
    outdated: bool = False  # its session has boats of before a jump
    rate: float = 0.0  # of its time, as it was heard last: 0 stands, infinite as fast as it goes
    _line: Line | None = None
    _dialled: float = -math.inf
    _dialler: threading.Thread = field(default_factory=threading.Thread)
    _place: Place | None = None
    _at: tuple[float, float] = 0.0, 0.0  # its own time [s] and the class's, of its place
    _pace: tuple[str, ...] = ()  # time, speed, held, branch, replay, shown; () if it is not heard
    _last: tuple[str, int] = "", -1  # branch and tick
    _lost: float = 0.0  # [s] since when it is not heard
    _odd: float = -math.inf  # [s] when it was told last that it says what nobody can read

    @property
    def hears(self) -> bool:
        """Return whether its session takes what it is told now."""
        return bool(self._pace) and not self.shows_past

    @property
    def shows_past(self) -> bool:
        """Return whether its session replays, or shows the way: the boat itself stands still."""
        return bool(self._pace) and (self._pace[4], self._pace[5]) != ("no", "no")

    @property
    def there(self) -> bool:
        """Return whether it was heard, and is not lost for too long."""
        lost = not self._pace and self.clock() - self._lost > LOST_AFTER_S
        return self._place is not None and not lost and math.isfinite(self.rate)

    @property
    def place(self) -> Place:
        """Return where it is now."""
        assert self._place is not None  # noqa: S101  it is there
        now = self._place.after(self.rate * (self.clock() - self._at[1]))
        return now if self.rate else now._replace(v_north=0.0, v_east=0.0)

    @property
    def seconds(self) -> float:
        """Return its own time [s] now."""
        return self._at[0] + self.rate * (self.clock() - self._at[1])

    def listen(self) -> None:
        """Take what its session has said; dial it where there is no line."""
        if self._line is None:
            if self.clock() - self._dialled >= REDIAL_S and not self._dialler.is_alive():
                self._dialled = self.clock()
                self._dialler = threading.Thread(target=self._dial, daemon=True)
                self._dialler.start()
            return
        try:
            for text in self._line.take(MOST_LINES):
                if sentence := parse_sentence(str(text)):
                    self._hear(sentence)
        except (ValueError, IndexError):  # a number that is none, or too few
            odd = quote(str(text))
            if self.clock() - self._odd > LOST_AFTER_S:  # it may say so each time it is dialled
                self._odd = self.clock()
                self.tell(f"{self.boat.title} is lost in the sea of the others: it says {odd}")
        else:
            if not (self._line.ended or self._line.trouble):
                return
        self._line.close(0.0)
        if self._at[1] >= self._dialled:  # a line that has told no place makes it no less lost
            self._lost = self.clock()
        self._line, self._last, self._pace = None, ("", -1), ()

    def say(self, words: str) -> None:
        """Give its session an order."""
        if self._line is not None:
            self._line.send(order_sentence(words))

    def meet(self, number: int, other: "SeaBoat") -> None:
        """Tell its session where another boat is, if it has to be told."""
        place = other.place._replace(east=other.place.east - self.origin_east)
        told = self.told.get(number)
        if told is not None:
            taken = told.place.after(self.seconds - told.seconds)
            deeper = abs(taken.depth - place.depth)
            if not self.rate or (taken.apart(place) < PLACE_ERROR_M and deeper < DEPTH_ERROR_M):
                return
        self.told[number] = Told(place, self.seconds)
        self.say(boat_order(number, place))

    def part(self, number: int) -> None:
        """Show another boat no more, until it is PARTED_M off.

        A session that replays would refuse the order, so it is given when that goes on.
        """
        self.parted.discard(number)
        if self.hears and number in self.told:
            del self.told[number]
            self.say(f"contact boat-{number} remove")

    def forget(self) -> None:
        """Have no other boat near, after a jump that has brought back those of then."""
        self.jumped = False
        self.outdated = self._last[1] > 0 or bool(self.told)  # told in a freeze at the start
        self.told.clear()
        self.parted.clear()

    def clear_boats(self) -> None:
        """Take away the boats of then, once the session takes orders."""
        if self.outdated and self.hears:
            self.outdated = False
            self.say("contact boats gone")

    def end(self) -> None:
        """Leave the session."""
        if self._line is not None:
            self._line.close(0.0)

    def _dial(self) -> None:
        try:
            line = client.dial(self.boat.address, threading.Event())
        except LinkError:
            return  # the boat itself tells of it
        # time first: of a place it has to be known whether it is of the past
        asked = [f"subscribe {channel} at {HEARD_HZ} hz" for channel in ("time", "motion")]
        line.send(order_sentence(f"role class {self.word}".rstrip(), ROLE_TAG))
        for words in asked:
            line.send(order_sentence(words))
        self._line = line

    def _hear(self, said: Sentence) -> None:
        """Take a sentence; ValueError or IndexError, and nothing is taken, for an odd one."""
        if said.kind == "TRA" and (said.tag, said.fields[0]) == (ROLE_TAG, "no"):
            self._dialled = math.inf  # each wrong word is counted there, and makes others wait
            self.tell(f"{self.boat.title} is not in the sea of the others: {said.fields[1]}")
        elif said.kind == "TRS" and said.fields[0] == "time":
            state, speed, _, _, _, _ = said.fields[3:9]
            rate = math.inf if speed == "max" else finite(speed)
            self._pace = said.fields[3:]
            self.rate = rate if state == "running" and not self.shows_past else 0.0
            if self.shows_past and not self._last[0]:
                self._place = None  # a new line that begins in a replay: the boat is elsewhere now
            self._note_tick(int(said.fields[1]))
        elif said.kind == "TRS" and said.fields[0] == "motion" and not self.shows_past:
            place = Place(*(finite(said.fields[3 + i]) for i in (5, 6, 0, 12, 13, 1)))
            told = parse(boat_order(1, place._replace(north=0.0, east=0.0)))
            if not isinstance(told, Order):  # so fast or deep that nobody can be told
                raise ValueError
            self._note_tick(int(said.fields[1]))
            self._at = float(said.fields[2]), self.clock()
            self._place = place._replace(east=place.east + self.origin_east)

    def _note_tick(self, tick: int) -> None:
        """Note whether it has jumped: to an earlier tick, or to another branch."""
        if not self._pace or self.shows_past:
            return
        branch, before = self._last
        self.jumped |= branch != self._pace[3] or tick < before
        self._last = self._pace[3], tick


def finite(text: str) -> float:
    """Return the number of a field; ValueError if it is none, or not finite."""
    if not math.isfinite(number := float(text)):
        raise ValueError
    return number


def boat_order(number: int, place: Place) -> str:
    """Return the order that tells a session where another boat is, its words cut short.

    A line has 80 letters at most, and so has the order as it is journalled.
    """
    way = math.hypot(place.v_north, place.v_east)
    course = math.degrees(math.atan2(place.v_east, place.v_north)) % 360.0
    course, way = (course, way) if way >= LEAST_WAY else (place.heading % 360.0, 0.0)
    return (
        f"contact boat {number} at {place.north:.0f} {place.east:.0f} "
        f"d {max(place.depth, 0.0):.1f} c {course:.1f} s {way / KNOT:.2f}"
    )


class OneSea:
    """All boats of a class in one sea."""

    def __init__(
        self,
        boats: Mapping[int, AnyBoat],
        spacing: float,
        word: str,
        tell: Tell,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Have each boat start ``spacing`` [m] east of the one before."""
        self.boats = {
            number: SeaBoat(boat, word, (number - 1) * spacing, tell, clock)
            for number, boat in boats.items()
        }
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="one sea", daemon=True)

    def begin(self) -> None:
        """Keep all boats told of each other, from a thread."""
        self._thread.start()

    def end(self) -> None:
        """Leave all sessions."""
        self._ended.set()
        if self._thread.ident is not None:  # it has begun
            self._thread.join()
        for boat in self.boats.values():
            boat.end()

    def look(self) -> None:
        """Hear all sessions, and tell each what it has to be told."""
        for boat in self.boats.values():
            boat.listen()
        for number, boat in self.boats.items():
            if boat.jumped:
                boat.forget()
                for other in self.boats.values():
                    other.part(number)
            boat.clear_boats()
        for one, two in itertools.permutations(self.boats, 2):
            self._meet(self.boats[one], two)

    def _meet(self, boat: SeaBoat, number: int) -> None:
        """Tell a boat of another, if both are in one sea and their times run alike."""
        other = self.boats[number]
        if not boat.hears:
            return
        alike = not boat.rate or not other.rate or boat.rate == other.rate
        near = boat.there and other.there and boat.place.apart(other.place) < FARTHEST_M
        if not (near and alike):
            boat.part(number)
            return
        if number not in boat.parted and boat.place.apart(other.place) >= PARTED_M:
            boat.parted.add(number)
        if number in boat.parted:
            boat.meet(number, other)
        else:
            boat.part(number)

    def _run(self) -> None:
        while not self._ended.wait(LOOK_PERIOD_S):
            self.look()
