"""The laws of a class in one sea, judged by where its boats are.

``Sea`` looks at the sessions from outside, ten times a second, and at each word that the class
says to one. It reckons for itself where each boat lies for the others: a boat that replays lies
where it was, one that has died goes straight on.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple

from simulation.class_script import BOATS
from simulation.machine import SECOND_NS, Machine
from trainer.boat.world.contacts import contacts_in
from trainer.io.orders.sentences import parse_line
from trainer.session.session import Session
from trainer.units import KNOT

# What docs/classroom.md promises; a law that takes the product's own finds nothing.
PARTED_M: Final = 300.0
ERROR_M, DEEPER_M = 5.0, 2.0
GONE_AFTER_S: Final = 60.0
LATE_S: Final = 2.0  # [s] after a change of how a boat goes, in which the class may not know of it
REDIAL_S: Final = 4.0  # [s] after its process has begun
LATEST_S: Final = 0.8  # [s] of a boat's way that may be gone since it was heard
LOOK_S: Final = 0.3  # [s] of a boat's way that may be gone when it is told: a look, and a turn
ROUNDED_M: Final = 2.0
KEEL_M: Final = 5.0  # under the middle of the usual boat, about
TOLD: Final = re.compile(
    r"contact boat (?P<boat>\d+) at (?P<north>\S+) (?P<east>\S+) d (?P<depth>\S+) c \S+ s \S+"
)
REMOVED: Final = re.compile(r"contact boat-(?P<boat>\d+) remove")
GONE: Final = "contact boats gone"
OWN: Final = re.compile(r"role class|subscribe (?:time|motion) at 5 hz")


class ClassLaw(Enum):
    """What must hold in a class, whatever its script."""

    APART = "C1: of another boat a session hears its place by `contact boat`, and nothing else"
    PLACED = "C2: a boat is told where it is, to boats whose time runs alike"
    PARTED = "C3: boats are shown to each other for the first time once they are 300 m apart"
    ALONE = "C4: each recording is replayed alone to the same bits"
    QUIET = "C5: when all is quiet, each has the others where they are"
    LIVES = "C6: no thread dies"


class Breach(NamedTuple):
    """A broken law."""

    law: ClassLaw
    text: str

    def __str__(self) -> str:
        return f"{self.law.value}\n    {self.text}"


class Spot(NamedTuple):
    """Where a boat is [m] and how it goes [m/s], at a time [s]."""

    north: float
    east: float
    depth: float
    v_north: float
    v_east: float
    rate: float
    seconds: float

    def at(self, seconds: float) -> "Spot":
        """Return where it lies for the others at a time."""
        gone = self.rate * (seconds - self.seconds) if math.isfinite(self.rate) else 0.0
        north, east = self.north + self.v_north * gone, self.east + self.v_east * gone
        return self._replace(north=north, east=east, seconds=seconds)

    @property
    def way(self) -> float:
        """Return how fast it goes [m/s] by the class's clock."""
        return self.rate * math.hypot(self.v_north, self.v_east)

    def apart(self, other: "Spot") -> float:
        """Return the distance [m] of two boats, seen from above."""
        return math.hypot(self.north - other.north, self.east - other.east)


@dataclass
class Watched:
    """One boat of the class."""

    session: Session | None = None
    spot: Spot | None = None
    before: Spot | None = None  # the last change of how it goes
    changed: float = -math.inf  # [s] when that was
    past: bool = False  # as it was seen last
    pace: float = 0.0  # [m/s] at which it went last, outside its past
    begun: float = 0.0  # [s] its process
    heard: bool = False  # since then outside its past, beyond doubt
    reached: bool = False  # the class has a word of where it is since then
    lost: Spot | None = None  # where it died: it goes straight on until the class hears it again
    last: tuple[int, int] = (0, 0)  # branch and tick, outside replays
    shown: set[int] = field(default_factory=set)  # that its session was told of
    been_apart: set[int] = field(default_factory=set)  # beyond doubt, since they came into one sea


class Sea:
    """What looks on a class."""

    def __init__(self, machine: Machine, spacing: float) -> None:
        self.machine, self.spacing = machine, spacing
        self.boats = {number: Watched() for number in BOATS}
        self.breaches: list[Breach] = []
        self.told: dict[str, int] = defaultdict(int)  # how often each kind of word was said

    @property
    def now(self) -> float:
        """Return the time [s]."""
        return self.machine.now / SECOND_NS

    def enter(self, law: ClassLaw, text: str) -> None:
        """Enter a breach of a law, now."""
        self.breaches.append(Breach(law, f"{self.now:.3f} s: {text}"))

    def begin(self, number: int, session: Session) -> None:
        """Note the session of a boat's process."""
        boat = self.boats[number]
        boat.session, boat.begun, boat.past = session, self.now, False
        boat.heard = boat.reached = False
        self._jump(number)
        boat.spot = None
        self._look_at(number, boat, session)

    def end(self, number: int) -> None:
        """Note that a boat's process is killed."""
        self.look()
        boat = self.boats[number]
        boat.session = None
        if boat.reached:  # else the class has it going on from where its process before has died
            boat.lost = boat.spot

    def reach(self, number: int, lines: Sequence[str]) -> None:
        """Note what the class takes from a session's line."""
        if any(line.startswith("$TRS,motion") for line in lines):
            self.boats[number].reached = True

    def look(self) -> None:
        """Look where all boats are."""
        for number, boat in self.boats.items():
            if boat.session:
                self._look_at(number, boat, boat.session)
                boat.heard = boat.heard or (not boat.past and self._is_settled(boat))
        for number, boat in self.boats.items():
            for other in BOATS:
                if other != number:
                    self._note_apart(boat, other)

    def _note_apart(self, boat: Watched, other: int) -> None:
        """Note whether another boat has been far off, since their times began to run alike."""
        there = self.boats[other]
        if boat.spot and there.spot and not alike_rates(boat.spot.rate, there.spot.rate):
            boat.been_apart.discard(other)
        elif self._far(boat, there):
            boat.been_apart.add(other)

    def _far(self, one: Watched, two: Watched) -> bool:
        """Return whether two boats have been heard in one sea, beyond doubt PARTED_M apart."""
        if not (one.spot and two.spot and one.session and two.session):
            return False
        settled = all(each.heard and self._is_settled(each) for each in (one, two))
        alike = alike_rates(one.spot.rate, two.spot.rate)
        hears = not is_past(one.session)
        return settled and alike and hears and one.spot.apart(two.spot) > PARTED_M + 20.0

    def _is_settled(self, boat: Watched) -> bool:
        """Return whether the class knows by now how a boat goes."""
        return self.now - boat.changed > LATE_S and self.now - boat.begun > REDIAL_S

    def _look_at(self, number: int, boat: Watched, session: Session) -> None:
        past = is_past(session)
        rate = 0.0 if past or session.time.frozen else float(session.time.speed)
        if boat.spot and (boat.spot.rate != rate or boat.past != past):
            boat.before, boat.changed = boat.spot.at(self.now), self.now
        boat.past = past
        if past:
            if boat.spot:
                boat.spot = boat.spot.at(self.now)._replace(rate=0.0)
            return
        state, here = session.boat.state, (session.history.recording.branch, session.history.tick)
        if rate and here == boat.last and boat.spot and boat.spot.rate == rate:
            return  # it goes straight on to the next tick
        if boat.last[0] not in (0, here[0]) or here[1] < boat.last[1]:
            self._jump(number)
        boat.last = here
        cos, sin = math.cos(state.psi), math.sin(state.psi)
        along, across = float(state.u) * math.cos(state.theta), float(state.v)
        boat.spot = Spot(
            float(state.x),
            float(state.y) + (number - 1) * self.spacing,
            float(state.z),
            along * cos - across * sin,
            along * sin + across * cos,
            rate,
            self.now,
        )
        boat.pace = boat.spot.way or boat.pace

    def _jump(self, number: int) -> None:
        """Note that a boat is elsewhere at once."""
        boat = self.boats[number]
        boat.before, boat.changed = boat.spot and boat.spot.at(self.now), self.now
        boat.shown.clear()
        boat.been_apart.clear()
        for other in self.boats.values():
            other.shown.discard(number)
            other.been_apart.discard(number)

    def hear(self, number: int, text: str) -> None:
        """Hear what the class says to a session: C1 to C3."""
        self.look()
        message = parse_line(text)
        words = text.partition(",")[2].rpartition("*")[0].lstrip("0123456789,") if message else text
        boat = self.boats[number]
        if found := TOLD.fullmatch(words):
            self.told["boat"] += 1
            self._hear_place(number, int(found["boat"]), words, found)
        elif found := REMOVED.fullmatch(words):
            self.told["remove"] += 1
            boat.shown.discard(int(found["boat"]))
        elif words == GONE:
            self.told["gone"] += 1
            boat.shown.clear()
        elif not OWN.fullmatch(words):
            self.enter(ClassLaw.APART, f"boat {number} is told {words!r}")

    def _hear_place(self, number: int, other: int, words: str, found: re.Match[str]) -> None:
        boat, there = self.boats[number], self.boats.get(other)
        if other == number or there is None or there.spot is None or boat.spot is None:
            self.enter(ClassLaw.APART, f"boat {number} is told {words!r}, of no other boat")
            return
        told = Spot(
            float(found["north"]),
            float(found["east"]) + (number - 1) * self.spacing,
            float(found["depth"]),
            *(0.0, 0.0, 0.0, self.now),
        )
        where = f"boat {number} is told {words!r}"
        if fits(told, there.spot.at(self.now), self._way(there)):
            if self.now - max(there.changed, boat.changed) > LATE_S and not alike_rates(
                there.spot.rate, boat.spot.rate
            ):
                self.enter(ClassLaw.PLACED, f"{where}, whose time runs otherwise")
            if other not in boat.shown:
                self._show(number, other, where)
        elif not any(
            fits(told, each.at(self.now), max(each.way, there.pace)) for each in self._known(there)
        ):
            self.enter(ClassLaw.PLACED, f"{where}, which is at {there.spot.at(self.now)}")

    def _known(self, boat: Watched) -> Iterator[Spot]:
        """Yield where the class may still take a boat to be, which is elsewhere by now."""
        if boat.before and self.now - boat.changed < LATE_S:
            yield boat.before
        if boat.lost and self.now - boat.begun < REDIAL_S:
            yield boat.lost

    def _way(self, boat: Watched) -> float:
        """Return how fast a boat goes [m/s]; in its past, how fast it went when it was heard."""
        assert boat.spot
        return boat.pace if boat.past else boat.spot.way

    def _show(self, number: int, other: int, where: str) -> None:
        """Note that a boat is shown to another for the first time."""
        boat, there = self.boats[number], self.boats[other]
        assert boat.spot
        assert there.spot
        boat.shown.add(other)
        apart = boat.spot.at(self.now).apart(there.spot.at(self.now))
        slack = ROUNDED_M + LOOK_S * (boat.spot.way + there.spot.way)
        stale = self.now - boat.changed < LATE_S  # it has just jumped: the class will see it
        if apart < PARTED_M - slack and other not in boat.been_apart and not stale:
            self.enter(ClassLaw.PARTED, f"{where}, {apart:.0f} m off, for the first time")

    def check_quiet(self) -> None:
        """C5: look where each session has the others, when nothing has happened for a while."""
        self.look()
        for number, boat in self.boats.items():
            if not boat.session or boat.session.time.frozen or is_past(boat.session):
                continue
            for other in BOATS:
                if other != number:
                    self._check_contact(number, other)

    def _check_contact(self, number: int, other: int) -> None:
        boat, there = self.boats[number], self.boats[other]
        assert boat.session
        assert there.spot
        contacts = contacts_in(boat.session.boat)
        found = contacts.seen(boat.session.boat.ticks) if contacts else ()
        seen = next((each for each in found if each.name == f"boat-{other}"), None)
        if seen is None:
            if other in boat.been_apart:
                self.enter(ClassLaw.QUIET, f"boat {number} has not boat {other}, once far off")
            return
        spot = there.spot.at(self.now)
        east = seen.east + (number - 1) * self.spacing
        off = math.hypot(seen.north - spot.north, east - spot.east)
        deeper = abs(seen.draught - KEEL_M - spot.depth)
        most = ERROR_M + ROUNDED_M + spot.rate * (10.0 * KNOT)  # a tick of both
        if off > most or deeper > DEEPER_M + ROUNDED_M:
            self.enter(
                ClassLaw.QUIET,
                f"boat {number} has boat {other} {off:.1f} m off, and {deeper:.1f} m in depth",
            )


def fits(told: Spot, true: Spot, way: float) -> bool:
    """Return whether a boat, which goes so fast [m/s], is told where it is."""
    most = ROUNDED_M + LATEST_S * way
    return told.apart(true) <= most and abs(told.depth - max(true.depth, 0.0)) <= DEEPER_M


def alike_rates(one: float, two: float) -> bool:
    """Return whether two boats are in one sea by how their times run."""
    finite = math.isfinite(one) and math.isfinite(two)
    return finite and (not one or not two or one == two)


def is_past(session: Session) -> bool:
    """Return whether a session shows its past, or what could be."""
    flown = session.history.flown
    return bool(flown.replaying or flown.shows_way)
