"""Many ships near, and what an instrument has to hear of them by AIS.

A fleet is drawn by a seed of its own: ships within reach and beyond it, at anchor and under way,
some without a transponder. Orders of the exercise and of a traffic master take ships away, bring
others, and move them over the horizon. docs/nmea.md has what is promised of their messages; the
numbers stand here once more, because a law that takes the product's own finds nothing.
"""

import math
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any, Final, NamedTuple

import pytest

from simulation.laws import Docket, Law
from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.config.world.contacts import SHIP_TYPES
from trainer.io.orders.sentences import checksum
from trainer.session.nmea.sentences import InstrumentSet
from trainer.session.nmea.transponders import MIN_TURN_RATE, antenna
from trainer.session.stations.subscriptions import Subscription
from trainer.session.stations.view import Frame, Picture
from trainer.units import KNOT

SHIPS: Final = 40
FIRST_MMSI: Final = 211_000_000
RANGES_M: Final = ((3e3, 15e3), (3e3, 15e3), (3e3, 15e3), (15e3, 40e3), (40e3, 150e3))
SILENT_SHARE: Final = 0.15  # [-] of ships have no transponder
DURATION_S: Final = 1500.0
HEAD: Final = """schema = "exercise/1"
name = "Many ships"
briefing = "Many ships."
duration_s = {duration}
[initial]
speed_kn = 4
depth_m = 17.5
[contacts]
collision = "call"
[[orders]]
at_s = 0
order = "scope raise"
"""
CHANGES: Final = (
    "remove",
    "course 090",
    "course 270",
    "speed 3",
    "move 4000 2000",
    "move 0 120000",
)
MOVES: Final = 12  # orders of the exercise to ships
# What is there more than once is said more often.
WORDS: Final = (
    *("scope raise", "scope raise", "scope lower", "depth 17", "depth 17", "time 20", "time 100"),
    *("freeze", "run", "run", "snapshot A", "restore A", "backtrack 30 s"),
    "contact add late tug at 4000 -500 course 090 speed 8",
)

# What docs/nmea.md promises.
REACH_M: Final = 4100.0  # [m] for the sum of the roots of both heights [m]
EDGE_M: Final = 1.0  # [m] within which a ship may be heard or not
NAME_PERIOD_S: Final = 360.0
MESSAGE_BITS: Final = {1: 168, 5: 424, 18: 168, 24: 168}
SMALL_KINDS: Final = (18, 24)  # of class B
SET_BEGINS: Final = "$INRMC,"
OWN_FIX: Final = "$INGGA,"
# ITU-R M.1371-5, table 45
STATUS_CODES: Final = {
    "under way": 0,
    "at anchor": 1,
    "adrift": 2,
    "fishing": 7,
    "trawling": 7,
    "sailing": 8,
}
DEGREE_M: Final = 111_195.0  # [m] of a degree on the sphere
FIX_M: Final = 5.0  # of both fixes
CHART_SHARE: Final = 0.01  # [-] by which a sphere and a plane are wrong, of the distance


def fleet_text(seed: int, duration: float) -> str:
    """Return the exercise with the fleet of a seed."""
    dice = Random(f"{seed}/fleet")  # noqa: S311  no secrets
    text = HEAD.format(duration=duration or DURATION_S)
    for _ in range(MOVES):
        order = f"contact {ship_name(dice)} {dice.choice(CHANGES)}"
        text += f'[[orders]]\nat_s = {dice.randrange(5, 600)}\norder = "{order}"\n'
    for number in range(SHIPS):
        kind = dice.choice(tuple(SHIP_TYPES))
        bearing = math.tau * (number + dice.uniform(-0.1, 0.1)) / SHIPS  # none in another's hull
        distance = dice.uniform(*dice.choice(RANGES_M))
        north, east = distance * math.cos(bearing), distance * math.sin(bearing)
        speed = dice.choice((0.0, 1.0, 5.0, 0.9 * SHIP_TYPES[kind].fastest_kn))
        text += f"""[[contact]]
name = "s{number}"
type = "{kind}"
points = [[{north:.0f}, {east:.0f}]]
course_deg = {dice.randrange(360)}
speed_kn = {speed:.2f}
"""
        if dice.random() >= SILENT_SHARE:
            text += f"mmsi = {FIRST_MMSI + number}\n"
    return text


def ship_name(dice: Random) -> str:
    """Return the name of any ship of a fleet."""
    return f"s{dice.randrange(SHIPS)}"


def traffic_words(dice: Random) -> str:
    """Return what the master of the traffic says next."""
    words = dice.choice((*WORDS, *CHANGES))
    return f"contact {ship_name(dice)} {words}" if words in CHANGES else words


class Audible(NamedTuple):
    """A ship within reach, and how often [s] its place is promised."""

    small: bool
    period: float
    ship: ContactState | None = None
    north: float = 0.0  # [m] of the boat
    east: float = 0.0


@dataclass(frozen=True)
class Moment:
    """What there was to be heard when a set of sentences was made."""

    tick: int
    time: float  # [s] of the boat
    ships: dict[int, Audible]  # by their numbers
    doubtful: frozenset[int]  # at the very edge
    dropped: int  # sentences before this set
    lines: list[str] = field(default_factory=list)  # that go out

    @classmethod
    def of(cls, frame: Frame, dropped: int) -> "Moment":
        """Return the moment of a frame."""
        contacts, height = contacts_in(frame.boat), antenna(frame)
        ships, doubtful = {}, set()
        for ship in contacts.seen(frame.tick) if contacts and height > 0.0 else ():
            away = math.hypot(ship.north - frame["x"], ship.east - frame["y"])
            beyond = away - REACH_M * (math.sqrt(height) + math.sqrt(ship.mast))
            if ship.mmsi is None or beyond > EDGE_M:
                continue
            if beyond > -EDGE_M:
                doubtful.add(ship.mmsi)
            else:
                ships[ship.mmsi] = Audible(
                    SHIP_TYPES[ship.type].small,
                    promised_period(ship),
                    *(ship, ship.north - frame["x"], ship.east - frame["y"]),
                )
        return cls(frame.tick, frame.seconds, ships, frozenset(doubtful), dropped)


def promised_period(ship: ContactState) -> float:
    """Return how often [s] the place of a ship is promised."""
    knots, turns = ship.speed / KNOT, abs(ship.turning) > MIN_TURN_RATE
    if SHIP_TYPES[ship.type].small:
        return 180.0 if knots < 2.0 else 30.0
    if ship.status == "at anchor":
        return 180.0
    if knots <= 14.0:
        return 10.0 / 3.0 if turns else 10.0
    return 6.0 if knots <= 23.0 and not turns else 2.0


def number_in(bits: str, begin: int, size: int, *, signed: bool = False) -> int:
    """Return a number of a message."""
    value = int(bits[begin : begin + size], 2)
    return value - (1 << size) if signed and bits[begin] == "1" else value


def text_in(bits: str, begin: int, end: int) -> str:
    """Return a text of a message, without what fills it up."""
    sixes = (int(bits[i : i + 6], 2) for i in range(begin, end, 6))
    return "".join(chr(six + 64 if six < 32 else six) for six in sixes).rstrip("@ ")


def untrue_words(bits: str, ship: ContactState) -> Iterator[str]:
    """Yield what a message says of name, kind and size that is not the ship's."""
    kind, part = int(bits[:6], 2), bits[38:40]
    if kind == 5 or (kind == 24 and part == "00"):
        name = text_in(bits, *((112, 232) if kind == 5 else (40, 160)))
        if name != ship.name.replace("-", " ").upper()[:20].rstrip():
            yield f"the name {name!r}, and it is {ship.name!r}"
    if kind == 5 or (kind == 24 and part == "01"):
        type_at, sizes_at = (232, 240) if kind == 5 else (40, 132)
        if (code := number_in(bits, type_at, 8)) != SHIP_TYPES[ship.type].ais:
            yield f"the kind {code}, and it is a {ship.type}"
        ends = (number_in(bits, sizes_at + at, 9) for at in (0, 9))
        sides = (number_in(bits, sizes_at + at, 6) for at in (18, 24))
        for told, true in zip((sum(ends), sum(sides)), (ship.length, ship.beam), strict=True):
            if abs(told - true) > 1.01:
                yield f"a size of {told} m, and it is {true:.1f} m"
    if kind == 5 and abs(0.1 * number_in(bits, 294, 8) - min(ship.draught, 25.5)) > 0.051:
        yield f"another draught than {ship.draught:.1f} m"


def untrue_place(bits: str, heard: Audible, own: str) -> Iterator[str]:
    """Yield what a report says of a ship's place and way that is not so, by the boat's own fix."""
    kind, ship = int(bits[:6], 2), heard.ship
    if kind not in (1, 18) or ship is None:
        return
    at = 61 if kind == 1 else 57  # of the longitude, before which the speed stands
    knots = number_in(bits, at - 11, 10) / 10
    if abs(knots - min(ship.speed / KNOT, 102.2)) > 0.051:
        yield f"a speed of {knots} kn, and it is {ship.speed / KNOT:.2f} kn"
    for what, told, true in (
        ("course", number_in(bits, at + 55, 12) / 10, ship.course),
        ("heading", number_in(bits, at + 67, 9), ship.heading),
    ):
        if abs((told - math.degrees(true) + 180.0) % 360.0 - 180.0) > 0.51:
            yield f"a {what} of {told} deg, and it is {math.degrees(true) % 360.0:.1f} deg"
    if kind == 1:
        turn, code = 60.0 * math.degrees(ship.turning), number_in(bits, 42, 8, signed=True)
        true_code = math.copysign(min(4.733 * math.sqrt(abs(turn)), 126.0), turn)
        if abs(code - true_code) > 0.51:
            yield f"a rate of turn {code}, and it turns {turn:.2f} deg/min"
        if (code := number_in(bits, 38, 4)) != STATUS_CODES[ship.status]:
            yield f"the status {code}, and it is {ship.status}"
    time, latitude, northern, longitude, eastern = own.split(",")[1:6]
    if number_in(bits, at + 76, 6) != int(time[4:6]):
        yield f"the second {number_in(bits, at + 76, 6)}, and its fix is {own!r}"
    there = [number_in(bits, at + i, size, signed=True) / 6e5 for i, size in ((28, 27), (0, 28))]
    here = [degrees_of(latitude, 2, northern == "S"), degrees_of(longitude, 3, eastern == "W")]
    north = (there[0] - here[0]) * DEGREE_M
    east = (there[1] - here[1]) * DEGREE_M * math.cos(math.radians(there[0]))
    off = math.hypot(north - heard.north, east - heard.east)
    if off > FIX_M + CHART_SHARE * math.hypot(heard.north, heard.east):
        yield f"a place {off:.0f} m from where it is"


def degrees_of(text: str, digits: int, negative: bool) -> float:  # noqa: FBT001
    """Return an angle [deg] of degrees and minutes."""
    degrees = float(text[:digits]) + float(text[digits:]) / 60.0
    return -degrees if negative else degrees


@dataclass
class Air:
    """What there is to be heard, beside each set that goes to an outlet."""

    moments: dict[str, deque[Moment]] = field(default_factory=lambda: defaultdict(deque))

    def watch(self, patch: pytest.MonkeyPatch) -> None:
        """Note each moment, and what is said of it. Nothing of the product is changed."""
        show, lines = Subscription.show, InstrumentSet.lines
        shown: list[Moment] = []

        def show_noted(self_: Subscription, frame: Frame, picture: Picture, now: float) -> None:
            if self_.channel == "nmea":
                to: Any = self_.to
                shown[:] = [Moment.of(frame, to.dropped)]
                self.moments[to.name].append(shown[0])
            show(self_, frame, picture, now)

        def lines_noted(self_: InstrumentSet, frame: Frame) -> list[str]:
            shown[0].lines.extend(said := lines(self_, frame))
            return said

        patch.setattr(Subscription, "show", show_noted)
        patch.setattr(InstrumentSet, "lines", lines_noted)

    def boot(self) -> None:
        """Forget what a process before had."""
        self.moments.clear()


@dataclass
class Receiver:
    """An instrument that hears sets, and ships between them: L16."""

    outlet: str
    air: Air
    docket: Docket
    _set: list[str] = field(default_factory=list)  # that is heard now
    _moment: Moment | None = None  # of the set that was heard last
    _told: set[tuple[int, str]] = field(default_factory=set)  # ships, and what of them, in a set
    _parts: list[list[str]] = field(default_factory=list)  # of a message, as fields
    _since: dict[tuple[int, str], tuple[float, float]] = field(default_factory=dict)

    def hear(self, line: str) -> None:
        """Hear a sentence whose checksum is right."""
        if line.startswith(SET_BEGINS):
            if self._set:
                self._hear_set()
            self._set = [line]
        elif self._set:
            self._set.append(line)

    def lose(self) -> None:
        """Hear nothing for a while: what comes next is the first."""
        self._set, self._moment = [], None

    def _hear_set(self) -> None:
        """Take a set, and what follows it; compare it with what went out."""
        moments, before = self.air.moments[self.outlet], self._moment
        if not moments:
            return self._breaks(f"a set that was not made: {self._set[0]}")
        gone = next((i for i, each in enumerate(moments) if each.lines == self._set), None)
        for _ in range(gone or 0):
            moments.popleft()
        now = self._moment = moments.popleft()
        complete = gone == 0
        if not complete and not (moments or [now])[0].dropped:
            self._breaks(f"sentences are lost, and not counted: {self._set[0]}")
        self._told, self._parts = set(), []
        for line in self._set:
            if line.startswith("!"):
                self._hear_part(line)
        if complete:
            if self._parts:
                self._breaks(f"parts of a message are missing: {self._parts}")
            self._judge(now, before)
        else:
            self._since = {}
        return None

    def _hear_part(self, line: str) -> None:
        """Take a sentence; read the message that it completes."""
        body, _, end = line[1:].partition("*")
        kind, count, number, joined, channel, letters, fill = body.split(",")
        whole = kind == "AIVDM" and f"{checksum(body):02X}" == end and channel in ("A", "B")
        self._parts.append([count, number, joined, channel, letters, fill])
        follows = all(
            (part[0], part[2], part[3]) == (count, joined, channel) and part[1] == str(i)
            for i, part in enumerate(self._parts, 1)
        )
        if not (whole and follows and (joined != "") == (count != "1")):
            self._breaks(f"no part of a message: {line!r} in {self._parts}")
        if number == count:
            letters = "".join(part[4] for part in self._parts)
            self._parts = []
            self._hear_message(letters, int(fill))

    def _hear_message(self, letters: str, fill: int) -> None:
        sixes = (code - 48 if code < 88 else code - 56 for code in letters.encode())
        bits = "".join(f"{six:06b}" for six in sixes)
        bits = bits[: len(bits) - fill]
        kind, mmsi = int(bits[:6], 2), int(bits[8:38], 2)
        if len(bits) != MESSAGE_BITS.get(kind):
            self._breaks(f"a message {kind} of {len(bits)} bits")
        what = {5: "name", 24: "sizes" if bits[38:40] == "01" else "name"}.get(kind, "place")
        self._told.add((mmsi, what))
        assert self._moment
        ship = self._moment.ships.get(mmsi)
        if ship is None and mmsi not in self._moment.doubtful:
            self._breaks(f"{mmsi} is heard, which is gone or beyond reach")
        if ship and ship.small != (kind in SMALL_KINDS):
            self._breaks(f"{mmsi} is of another class than message {kind}")
        elif ship and ship.ship:
            own = next((each for each in self._set if each.startswith(OWN_FIX)), "")
            for told in [*untrue_words(bits, ship.ship), *untrue_place(bits, ship, own)]:
                self._breaks(f"of {mmsi} is told {told}")

    def _judge(self, now: Moment, before: Moment | None) -> None:
        """Look whether each ship within reach is heard as often as is promised."""
        goes_on = before is not None and now.time > before.time
        if before and not goes_on and self._told:
            self._breaks(f"ships are heard while time stands still: {sorted(self._told)}")
        known, self._since = self._since if goes_on else {}, {}
        for mmsi, ship in now.ships.items():
            periods = {"place": ship.period, "name": NAME_PERIOD_S}
            if ship.small:
                periods["sizes"] = NAME_PERIOD_S
            for what, period in periods.items():
                since, promised = known.get((mmsi, what), (now.time, period))
                if (mmsi, what) in self._told or promised != period:
                    since = now.time
                elif now.time - since >= period:
                    self._breaks(f"the {what} of {mmsi} is not heard for {now.time - since:g} s")
                self._since[mmsi, what] = since, period

    def _breaks(self, text: str) -> None:
        tick = self._moment.tick if self._moment else 0
        self.docket.enter(Law.AIS, f"{self.outlet}, tick {tick}: {text}")
