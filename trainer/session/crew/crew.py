"""The talk aboard: orders to the crew, the repeats that acknowledge them, and reports.

Aboard, whoever gets an order repeats it, so that the giver hears whether it was understood: "depth
60" is answered by "depth 60 aye". ``CrewTalk`` knows which orders have been repeated, and whether
rightly; after 10 s without a repeat it sends the order once more. The numbers of the orders stand
in the boat's state (``boat/crew_orders``), because the panels show them.

``dispatch`` calls ``obey`` and then ``note`` for each order, so ``note`` alone changes the talk:
after a jump in time ``orders_in_force`` calls it again for the journalled orders. Nothing here
moves the boat. Where the watch itself gives an order, such as rudder amidships when a swing has
been met, ``due_by_hand`` returns it, and ``dispatch`` has it obeyed like any other.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

from trainer.boat.ballast_orders import PumpMonitor
from trainer.boat.boat import Boat
from trainer.boat.casualties import instrument_readings
from trainer.boat.crew_orders import ordered_fact, standing_order
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order, Refused, Reply, parse, to_the_crew
from trainer.io.orders.quantities import FEET, METRES
from trainer.io.orders.words import CREW_TALK, ORDER_WORDS
from trainer.io.recording.facts import (
    GUARD_GIVER,
    NO_CREW_FACT,
    SCHEDULE_GIVER,
    CrewFact,
    CrewNews,
    Giver,
    meeting,
)
from trainer.session.crew.manning import (
    REPEATING_ROLES,
    STEERING_ORDERS,
    WORDS_AXIS,
    HandWork,
    axis_of,
    in_order,
    refuse_taking,
)
from trainer.session.crew.messages import CrewMessage, pump_text, report_text
from trainer.session.crew.watch_bill import WatchBill
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Fact, Saying

REPEAT_TIMEOUT_S: Final = 10.0  # [s] without a repeat, after which the order is shown again
RUDDER_AMIDSHIPS: Final = Order(
    "rudder", 0.0, "amidships", "rudder amidships", words="rudder amidships"
)
# [rad], [m]: closer than this an order counts as carried out, and neither way is wrong.
REACHED_MARGINS: Final = {"course": math.radians(5.0), "depth": 1.0, "pitch": math.radians(1.0)}
RUDDER_ORDERS: Final = frozenset(  # by hand, and to the autopilot
    word.name for word in ORDER_WORDS.values() if "rudder" in (*word.works, *word.gives_up)
)
MOVING_ORDERS: Final = RUDDER_ORDERS.union(*STEERING_ORDERS.values())
PUMPED_ORDERS: Final = ("flood", "pump")  # whose end is reported
CREW_WORDS: Final = CREW_TALK | MOVING_ORDERS


class StationOrder(NamedTuple):
    """An order that somebody on watch gives: the reason, who gives it, the order."""

    why: str
    giver: Giver
    order: Order


@dataclass(frozen=True)
class CrewOrder:
    """An order to the crew, and whether it has been repeated."""

    axis: str
    told: str  # the order in words, as the crew reads it
    given: Order
    tick: int
    by: str  # the role that gave it
    repeated: bool = False
    reminded: bool = False
    begun: bool = False  # somebody has moved what carries it out

    @property
    def says(self) -> str:
        """Return the order as people say it."""
        return self.given.subject if self.axis == WORDS_AXIS else self.told


class Talk(NamedTuple):
    """The orders, words and freed axes that stand on board at one moment."""

    spoken: tuple[CrewOrder, ...] = ()  # the newest last
    freed: frozenset[str] = frozenset()
    meeting: Giver | None = None
    hands: tuple[tuple[str, Giver], ...] = ()  # the axes, and who has worked each last
    watch: tuple[tuple[str, str], ...] = ()  # the roles, and the person who has each watch


class Repeat(NamedTuple):
    """The words of a repeat, and whether they are those of the order."""

    spoken: CrewOrder
    right: bool


@dataclass
class CrewTalk:
    """The orders to the crew that stand now, and the repeats and reports about them."""

    boat: Boat
    work: HandWork
    due: float = math.inf  # [tick] at which a repeat is next found missing
    pumps: PumpMonitor = field(default_factory=PumpMonitor)  # what is to be reported of them
    meeting: Giver | None = None  # who has said "meet her", while the boat still swings
    bill: WatchBill = field(default_factory=WatchBill)
    _spoken: dict[str, CrewOrder] = field(default_factory=dict)  # by axis, the newest last

    @property
    def told(self) -> str:
        """Return the last words to the crew."""
        spoken = self._spoken.get(WORDS_AXIS)
        return spoken.given.subject if spoken else ""

    def standing(self) -> list[CrewMessage]:
        """Return the messages that tell a program the orders that stand."""
        messages = []
        for spoken in self._spoken.values():
            messages.append(CrewMessage("crew", "", Fact("crew-order", spoken.told)))
            if spoken.repeated:
                messages.append(CrewMessage("crew", "", Fact("repeated", spoken.told)))
        return messages + self.bill.standing()

    def unrepeated(self, role: str) -> list[tuple[int, Fact]]:
        """Return the orders of others that nobody has repeated yet, with their ticks."""
        own_role = "" if role == INSTRUCTOR_ROLE.name else role
        waiting = (
            each for each in self._spoken.values() if not each.repeated and each.by != own_role
        )
        return [(each.tick, Fact("crew-order", each.told)) for each in waiting]

    # Orders, repeats and reports

    def obey(self, order: Order, role: str) -> Reply:
        """Write an order to the crew into the boat's state, or answer a repeat."""
        answers: dict[str, Callable[[], Reply]] = {  # by order word
            "order": lambda: obey_order(self.boat, order),
            "belay": self._belay,
            "tell": lambda: f"told: {order.subject}",
            "report": lambda: "reported",
            "allow": lambda: self.work.allow(order.word),
            "relief": lambda: f"{order.subject} has the watch",
            "have": lambda: refuse_taking(order, role) or f"you have the {order.word}",
        }
        return answers.get(order.name, lambda: self._aye(order, role))()

    def _belay(self) -> Reply:
        return "belayed" if WORDS_AXIS in self._spoken else Refused("no words to the crew stand")

    def meant(self, order: Order) -> Order:
        """Return the order that ``belay`` stands for.

        Without an axis it is the newest order's. Only this talk knows which that is, because the
        boat's state has no sequence.
        """
        if order.name != "belay":
            return order
        axis = order.word or next(reversed(self._spoken), "all")
        clear = parse("belay words" if axis == WORDS_AXIS else f"order clear {axis}")
        return clear if isinstance(clear, Order) else order

    def fact_of(self, order: Order, role: str) -> CrewFact:
        """Return the crew fact of an order that was just obeyed."""
        if order.name == "aye":
            repeat = find_repeated(self.talk.spoken, order.subject, role)
            if isinstance(repeat, Refused):
                return NO_CREW_FACT
            news = CrewNews.REPEATED if repeat.right else CrewNews.WRONG_REPEAT
            return CrewFact(news, repeat.spoken.says)
        return ordered_fact(self.boat, order)

    def note(self, order: Order, giver: Giver, tick: int, fact: CrewFact) -> list[CrewMessage]:
        """Note an order or repeat with its fact; return the messages that follow."""
        return [*self.bill.take(order, giver), *self._said(order, giver, tick, fact)]

    def _said(self, order: Order, giver: Giver, tick: int, fact: CrewFact) -> list[CrewMessage]:
        """Note what an order or repeat means to the crew, or to the pumps."""
        role = giver.role
        # nobody reports on pumps that a schedule has set to work
        if order.name in PUMPED_ORDERS and giver != SCHEDULE_GIVER:
            self.pumps.note(self.boat, order, role)
            self._look_ahead()
        if order.name not in CREW_WORDS:
            return []
        if order.name in MOVING_ORDERS:
            return self._moved(order, role)
        if fact.news is CrewNews.ORDERED:
            return self._ordered(order, role, tick, fact.order)
        if order.name in ("order", "tell") and not order.word.startswith("clear"):
            return []  # it was never answered, as the program ended before
        notes: dict[str, Callable[[], list[CrewMessage]]] = {  # by order word
            "aye": lambda: self._repeated(order, role),
            "allow": lambda: self._freed(order.word),
            "report": lambda: report_text(order, role),
            "have": list,
            "relief": lambda: self.bill.relieve(role, order.subject),
        }
        return notes.get(order.name, lambda: self._belayed(order))()

    @property
    def talk(self) -> Talk:
        """Return a copy of the talk as it stands now."""
        freed, bill = frozenset(self.work.freed), self.bill
        hands, watch = tuple(bill.hands.items()), tuple(bill.watch.items())
        return Talk(tuple(self._spoken.values()), freed, self.meeting, hands, watch)

    def put_back(self, talk: Talk, tick: int) -> None:
        """Put back the talk of another moment, at its tick, because time has jumped."""
        self.work.put_back(talk.freed)
        self.meeting = talk.meeting
        self.bill.hands, self.bill.watch = dict(talk.hands), dict(talk.watch)
        self._spoken = {
            spoken.axis: replace(spoken, reminded=self._late_at(spoken) <= tick)
            for spoken in talk.spoken
        }
        self.pumps.asked.clear()
        self._look_ahead(tick)

    # Orders and repeats

    def _ordered(self, order: Order, role: str, tick: int, ordered: str) -> list[CrewMessage]:
        """Note an order, which replaces the older one on its axis."""
        axis = WORDS_AXIS if order.name == "tell" else axis_of(order)
        order_text = order.text if axis == WORDS_AXIS else ordered
        self._spoken.pop(axis, None)
        self._spoken[axis] = CrewOrder(axis, order_text, order, tick, role)
        self._look_ahead()
        by = "" if role == SCHEDULE_GIVER.role else f"{role}: "
        words = f"to the crew: {order.subject}" if axis == WORDS_AXIS else f"ordered: {order_text}"
        saying = Saying(role, words)
        return [CrewMessage("crew", f"{by}{words}", Fact("crew-order", order_text), saying)]

    def _belayed(self, order: Order) -> list[CrewMessage]:
        axis = order.word.removeprefix("clear_")
        gone = [each for each in self._spoken.values() if axis in (each.axis, "all")]
        for spoken in gone:
            del self._spoken[spoken.axis]
        self._look_ahead()
        return [
            CrewMessage("crew", f"belay: {spoken.says}", Fact("belayed", spoken.told))
            for spoken in gone
        ]

    def _aye(self, order: Order, role: str) -> Reply:
        """Answer a repeat."""
        spoken = find_repeated(self.talk.spoken, order.subject, role)
        if isinstance(spoken, Refused):
            return spoken
        if spoken.right:
            return f"{spoken.spoken.says} aye"
        return f"WRONG REPEAT: {order.subject}; ordered is {spoken.spoken.says}"

    def _repeated(self, order: Order, role: str) -> list[CrewMessage]:
        """Mark an order as repeated, or report that the repeat was wrong."""
        match = find_repeated(self.talk.spoken, order.subject, role)
        if isinstance(match, Refused):
            return []
        spoken, right = match
        if right:
            self._spoken[spoken.axis] = replace(spoken, repeated=True)
            self._look_ahead()
            saying = Saying(role, f"{spoken.says} aye")
            return [CrewMessage("crew", ": ".join(saying), Fact("repeated", spoken.told), saying)]
        words = f"{order.subject}; {spoken.told}"
        text = f"WRONG REPEAT: {role} says {order.subject}; ordered is {spoken.says}"
        return [CrewMessage("crew", text, Fact("wrong-repeat", words))]

    # What is missing or wrong

    def missing(self, tick: int, attends: Callable[[str], bool]) -> list[CrewMessage]:
        """Return the messages that are due after a tick.

        They are the orders that nobody has repeated in time, each once; the axes that the crew
        takes in hand; and what pumps have done. ``attends`` says whether a role is attended.
        """
        messages = []
        for spoken in [*self._spoken.values()]:
            if spoken.repeated or spoken.reminded or self._late_at(spoken) > tick:
                continue
            self._spoken[spoken.axis] = replace(spoken, reminded=True)
            if any(attends(role) for role in REPEATING_ROLES[spoken.axis] if role != spoken.by):
                text = f"NOT REPEATED in {REPEAT_TIMEOUT_S:g} s: {spoken.says}"
                messages.append(CrewMessage("crew", text, Fact("crew-order", spoken.told)))
        if self.work.taken_at == tick:
            axes = in_order(self.work.hand)
            words = f"by hand from now on: {', '.join(axes)}"
            messages.append(CrewMessage("crew", words, Fact("exercise", f"hand={','.join(axes)}")))
        messages += [pump_text(*each) for each in self.pumps.look(self.boat)]
        self._look_ahead(tick)
        return messages

    def wrong_way(self, order: Order, role: str) -> list[CrewMessage]:
        """Return the message that an order by hand goes the wrong way, or none.

        Only the first one within ``REPEAT_TIMEOUT_S`` is judged, because later ones may rightly
        go the other way, to stop the swing.
        """
        for axis, surfaces in STEERING_ORDERS.items():
            spoken = self._spoken.get(axis)
            if spoken is None or spoken.begun or order.name not in surfaces:
                continue
            to_go = left_to_go(self.boat, axis)
            if self._late_at(spoken) >= self.boat.ticks and to_go * order.value < 0.0:
                text = f"WRONG WAY: {role}: {order.text}; ordered is {spoken.told}"
                return [
                    CrewMessage("watch", text, Fact("wrong-way", f"{order.text}; {spoken.told}"))
                ]
        return []

    def _moved(self, order: Order, role: str) -> list[CrewMessage]:
        """Note that a surface was moved, and whether the helm now meets a swing."""
        for axis, surfaces in STEERING_ORDERS.items():
            if axis in self._spoken and order.name in surfaces:
                self._spoken[axis] = replace(self._spoken[axis], begun=True)
        if order.name in RUDDER_ORDERS:
            self.meeting = meeting(role) if order.word == "meet" else None
        return []

    def due_by_hand(self) -> StationOrder | None:
        """Return the order that is due after this tick: rudder amidships, or the guard's."""
        if self.meeting and is_swing_met(self.boat):
            return StationOrder(f"{self.meeting}: swing met", self.meeting, RUDDER_AMIDSHIPS)
        order = self.work.guard_depth()
        return StationOrder(GUARD_GIVER.words, GUARD_GIVER, order) if order else None

    def _late_at(self, spoken: CrewOrder) -> float:
        """Return the tick at which a missing repeat is reported."""
        return spoken.tick + self.boat.ticks_in(REPEAT_TIMEOUT_S)

    def _look_ahead(self, tick: int | None = None) -> None:
        """Set ``due``, the next tick at which ``missing`` has a message."""
        now = self.boat.ticks if tick is None else tick
        waiting = (each for each in self._spoken.values() if not (each.repeated or each.reminded))
        taken_at = self.work.taken_at
        ticks = [*map(self._late_at, waiting), *([taken_at] if taken_at > now else [])]
        ticks += [now + 1] if self.pumps.asked else []
        self.due = min(ticks, default=math.inf)

    def _freed(self, axis: str) -> list[CrewMessage]:
        self.work.free(axis)
        free = f"{axis} may be automatic: the run is free, flown without marks"
        return [
            CrewMessage("exercise", free, Fact("exercise", "free=yes")),
            CrewMessage(
                "crew",
                f"{axis} may be automatic",
                Fact("exercise", f"allowed={self.work.automatic}"),
            ),
        ]


def find_repeated(spoken: Sequence[CrewOrder], words: str, role: str) -> Repeat | Refused:
    """Return which of the orders words repeat, the newest where there are no words.

    An instructor who is alone on board repeats what the schedule has ordered.
    """
    new = [
        each
        for each in reversed(spoken)
        if not each.repeated
        and each.by != role
        and role in (*REPEATING_ROLES[each.axis], INSTRUCTOR_ROLE.name)
    ]
    if not new:
        return Refused("there is no new order to repeat")
    if not words:
        return Repeat(new[0], right=True)
    said = said_order(words)
    axis = axis_of(said) if said else WORDS_AXIS  # other words can only repeat words
    matches = [each for each in new if each.axis == axis]
    if not matches:
        return Refused(f'"{words}" repeats no order; the new order is {new[0].says}: say aye')
    return Repeat(matches[0], right=is_repeated(words, matches[0]))


def left_to_go(boat: Boat, axis: str) -> float:
    """Return what is to go [rad, m], right or rise positive; 0 if in doubt."""
    standing = standing_order(boat, axis)
    if standing is None:
        return 0.0
    shown = instrument_readings(boat)
    if axis == "course":
        to_go = standing.value - shown.heading
        to_go = to_go if standing.side else math.remainder(to_go, math.tau)
        # Without an ordered side a course nearly astern may be reached by either way round.
        clear = standing.side or abs(to_go) < math.pi - REACHED_MARGINS[axis]
        return to_go if clear and abs(to_go) > REACHED_MARGINS[axis] else 0.0
    now = -shown.depth if axis == "depth" else float(boat.state.theta)
    to_go = (-standing.value if axis == "depth" else standing.value) - now
    return to_go if abs(to_go) > REACHED_MARGINS[axis] else 0.0


def is_swing_met(boat: Boat) -> bool:
    """Return whether the swing that is being met has stopped."""
    s = boat.state
    rudder = boat.toward["rudder"] * float(s.ordered_r)
    # The rudder is laid against the swing: once the boat turns the rudder's way, it is over.
    return rudder * float(s.psidot) >= 0.0


def said_order(words: str) -> Order | None:
    """Return the order to the crew that words give, with or without "order" before them."""
    plain = re.sub(r"\bto\b", " ", words)  # "come right to 090" is "come right 090"
    for text in (plain if plain.startswith("order ") else f"order {plain}", words):
        parsed = parse(text)
        crew_order = to_the_crew(parsed) if isinstance(parsed, Order) else parsed
        if isinstance(crew_order, Order) and crew_order.name == "order":
            return crew_order
    return None


def is_repeated(words: str, spoken: CrewOrder) -> bool:
    """Return whether words repeat an order as it was given or announced.

    A number without a unit is in the unit of the order. A side may be left out, but not be wrong.
    """
    if spoken.axis == WORDS_AXIS:
        return plain_words(words) == plain_words(spoken.given.subject)
    units = {*METRES.names, *FEET.names}
    if spoken.given.unit is FEET and not units & set(re.findall("[a-z]+", words)):
        words = f"{words} ft"
    said, ordered = said_order(words), said_order(spoken.told)
    if said is None or ordered is None:
        return False
    return said.text == spoken.given.text or means_the_same(said, ordered)


def means_the_same(said: Order, told: Order) -> bool:
    """Return whether two orders to the crew mean the same. A side may be left out."""
    off = said.value - told.value
    if axis_of(said) != "course":
        return said.word == told.word and abs(off) < 1e-9
    sides = {said.word, told.word} - {"course"}
    return len(sides) < 2 and abs(math.remainder(off, math.tau)) < 1e-9


def plain_words(words: str) -> list[str]:
    """Return words in small letters, without punctuation."""
    return re.findall(r"[a-z0-9.]+", words.lower())
