"""All that a screen knows of its session: values, news, its unanswered orders.

``app`` calls ``hear`` several times a second. It takes the sentences that have come since
(``io/orders/sentences`` has their kinds), and puts each into its place here. Drawings only read.
"""

# long: one screen's whole knowledge of a session, sentence by sentence
import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple, Protocol

from trainer.config.outcome import Outcome
from trainer.console.client import Greeting, Item, LineLoss, RoleRefusal, RoleTaken
from trainer.console.crew import CrewOrders
from trainer.console.journal import Journal, Sample, TimelineMoment, Trace, entry_of, plan_of
from trainer.console.past import EVENTS_CHANNEL, LATE_TIME_S, PastAnswers
from trainer.console.readings import ChannelReading, ChannelReadings
from trainer.io.orders.grammar import Order, name_of, parse
from trainer.io.orders.help import NO_ROLE_TEXT
from trainer.io.orders.sentences import Sentence

BELL_KINDS: Final = frozenset({"watch", "depth", "pilot", "trouble"})  # kinds with a bell
REPEATED_KEYS: Final = ("line", "wins", "lost")  # keys of an exercise that come again and again
LONG_ANSWER_LINES: Final = 4  # [lines] from which an answer is read in a window of its own
MAX_TRACK_PLACES: Final = 4000  # places of the track
TRACK_PERIOD_S: Final = 2.0  # [s] between them
NEXT_TIMEOUT_S: Final = 60.0  # [s] for the next exercise to be there
MAKING_READY: Final = "the next exercise is being made ready"
GHOST_CHANNEL: Final = "ghost"  # of an aid
WIDELY_KNOWN: Final = ("snapshots", "casualties")  # asked for on joining, by the instructor


def marks_in_words(fields: str) -> str:
    """Return outcome and total in words, as the session announced them."""
    outcome, total, *aids = (*fields.split(","), "")[: max(fields.count(",") + 1, 2)]
    with contextlib.suppress(ValueError):
        total = f"{float(total):.0f} marks of 100"
    told = (outcome, total or "no marks", *(f"with {aid}" for aid in aids))
    return ", ".join(filter(None, told))


def gives_crew(words: str) -> bool:
    """Return whether words give an order to the crew."""
    order = parse(words)
    return isinstance(order, Order) and order.name in ("order", "tell")


class Quantity(NamedTuple):
    """A quantity of a chart: name, unit, and the fields of value and order."""

    name: str
    unit: str
    actual: tuple[str, str]  # channel, field
    ordered: tuple[str, str] | None
    least: float  # shown range at least
    signs: tuple[str, str] = ("", "")  # before a positive and a negative value
    crew: str = ""  # the order to the crew that is shown in place of the autopilot's


class CasualtyOffer(NamedTuple):
    """A casualty that can be ordered: its usual order, and its meaning."""

    name: str
    degree: str
    says: str


class AttainablePoint(NamedTuple):
    """What a careful crew could still earn at a moment."""

    seconds: float
    marks: float  # [%]
    so_far: float  # [%] of a run that ended there
    outcome: Outcome  # WON, LOST or OPEN

    @classmethod
    def of(cls, fields: str) -> "AttainablePoint":
        """Return the point that a fact tells."""
        seconds, marks, so_far, outcome = fields.split(",")[:4]
        return cls(float(seconds), float(marks), float(so_far), Outcome(outcome))


class Talk(Protocol):
    """The line to the session, as the model needs it."""

    def order(self, words: str) -> str:
        """Send an order; return its tag, "" when there is no line."""

    def take(self) -> list[Item]:
        """Return what has come since the last call."""


@dataclass
class SentOrder:
    """An order without an answer yet. ``quiet`` ones are the screen's own."""

    words: str
    quiet: bool
    lines: list[str] = field(default_factory=list)


@dataclass
class SessionModel:
    """The session as the screen of one station knows it."""

    talk: Talk
    role: str
    charts: tuple[Quantity, ...]
    clock: Callable[[], float] = time.monotonic
    picture: ChannelReadings = field(default_factory=ChannelReadings)
    journal: Journal = field(default_factory=Journal)
    greeted: bool = False  # the session has taken the role once
    joined: bool = False
    trouble: str = ""  # with the line
    barred: RoleRefusal | None = None
    over: bool = False
    ended: bool = False  # by an order of this screen
    briefing: list[str] = field(default_factory=list)
    casualties: list[CasualtyOffer] = field(default_factory=list)
    snapshots: list[TimelineMoment] = field(default_factory=list)
    marks: list[TimelineMoment] = field(default_factory=list)
    plans: list[TimelineMoment] = field(default_factory=list)  # orders that are to come at a time
    furthest: float = 0.0  # [s] that time has reached on this branch
    refused: int = 0  # orders of this screen
    crew: CrewOrders = field(default_factory=CrewOrders)
    ranges: dict[str, float] = field(default_factory=dict)  # of the vessel, and its bells [kn]
    exercise: dict[str, str] = field(default_factory=dict)  # what is to be done, by its keys
    told: dict[str, list[str]] = field(default_factory=dict)  # its repeated keys
    outcome: str = ""  # of an exercise that is over
    endings: int = 0  # of exercises
    marks_told: list[str] = field(default_factory=list)  # the marks and their reasons
    releases: int = 0  # of marks to the crew
    debriefing: str = ""  # how much of a debrief is written, while it is
    wrong_at: float | None = None  # [s] of the reason that cost most
    attainable: list[AttainablePoint] = field(default_factory=list)  # for the instructor alone
    unevaluated: str = ""  # why there are none
    step: tuple[str, str, str, str] = ("", "", "", "")  # number, how many, instrument, text
    step_hint: str = ""
    lesson_done: bool = False  # its last step is over
    rings: int = 0  # how often the bell has been due
    past: PastAnswers = field(default_factory=PastAnswers)
    answers: list[tuple[str, list[str]]] = field(default_factory=list)  # long ones, to be read
    chair: str = ""  # the role that this line has taken in place of ``role``
    unread: list[Item] = field(default_factory=list)  # what came since, for that role's model
    trace: Trace = field(init=False)

    def __post_init__(self) -> None:
        self.trace = Trace(len(self.charts))
        self._asked: dict[str, SentOrder] = {}
        self._track: deque[tuple[float, float, float]] = deque(maxlen=MAX_TRACK_PLACES)  # [s, m, m]
        self._awaited = -math.inf  # [s] on the clock, until which the next exercise may take
        self._caught_up = False  # with what was shown before the line was there
        self._greeted = 0  # lines of the briefing that came before the line was lost last
        self._over_at = 0.0  # [s] when the exercise was over
        self._early: list[str] = []  # orders that wait for the first line
        self._own = 0  # orders to the crew that were given here and have not come back as facts yet
        self._snapshots: list[TimelineMoment] = []  # facts so far of an answer that is still coming
        self._casualties: list[CasualtyOffer] = []
        self._ghost = False  # it is shown

    @property
    def instructs(self) -> bool:
        """Return whether this is the instructor's screen, who sees the truth."""
        return self.role == "instructor"

    @property
    def trains(self) -> bool:
        """Return whether this is the screen of who trains alone."""
        return self.role == "trainee"

    @property
    def by_hand(self) -> list[str]:
        """Return what the exercise has worked by hand."""
        return list(filter(None, self.exercise.get("hand", "").split(",")))

    @property
    def waiting(self) -> int:
        """Return how many orders have not been answered yet."""
        return len(self._asked)

    @property
    def follows(self) -> bool:
        """Return whether the line is missing because the next exercise is being made ready."""
        return not self.joined and self.clock() < self._awaited

    @property
    def gauges(self) -> str:
        """Return the channel of depth, heading, speed and attitude."""
        return "motion" if self.instructs else "gauges"

    @property
    def track(self) -> list[tuple[float, float]]:
        """Return where the boat has been [m] north and east, oldest first."""
        reading = self.picture.reading("motion")
        north, east = reading.number("north"), reading.number("east")
        now = [] if north is None or east is None else [(north, east)]
        return [(n, e) for _, n, e in self._track] + now

    @property
    def bells(self) -> int:
        """Return how often the bell was due, for alerts and orders to the crew."""
        return self.rings + self.crew.rings

    @property
    def left(self) -> float | None:
        """Return how much of the exercise is left [s], None where it has no end."""
        try:
            return max(float(self.exercise["duration"]) - self.picture.seconds, 0.0)
        except (KeyError, ValueError):
            return None

    def order(self, words: str) -> None:
        """Send an order and show it. It waits where no line has been there yet."""
        if self.greeted or self.trouble or self.barred:
            self._send(words, quiet=False)
        else:
            self._early.append(words)
            self.journal.add(None, "station", f"{words}: sent as soon as the boat is ready")

    def ask(self, words: str) -> bool:
        """Send an order of the screen's own, which is not shown."""
        return self._send(words, quiet=True)

    def hear(self) -> None:
        """Take what the session has sent since the last call."""
        self.unread += self.talk.take()
        while self.unread and not self.chair:
            item = self.unread.pop(0)
            if isinstance(item, Sentence):
                self._read(item)
            elif isinstance(item, Greeting) and item.text != NO_ROLE_TEXT:
                # the session sends its briefing again after each new connection
                if item.text not in self.briefing:
                    self.briefing.append(item.text)
                    self.journal.add(None, "briefing", item.text)
            elif isinstance(item, RoleTaken):
                self._join()
            elif isinstance(item, LineLoss):
                self._lose(item.why)
            elif isinstance(item, RoleRefusal):
                self.joined, self.barred, self.trouble = False, item, item.reason

    def _send(self, words: str, *, quiet: bool) -> bool:
        if not quiet:
            self.journal.add(self.picture.seconds, "sent", words)
        tag = self.talk.order(words)
        if tag:
            self._asked[tag] = SentOrder(words, quiet)
            self._own += gives_crew(words) and not self.instructs
        elif not quiet:
            why = MAKING_READY if self.follows else self.trouble or "no connection"
            self.journal.add(None, "refused", f"not sent: {why}")
        return bool(tag)

    # the line

    def _join(self) -> None:
        if self.greeted:
            back = "the next exercise is ready" if self.follows else "the connection is back"
            self.journal.add(None, "station", back)
        self._awaited = -math.inf
        self.joined, self.trouble, self.over, self.greeted = True, "", False, True
        self._caught_up = False
        for words in WIDELY_KNOWN if self.instructs else ():
            self.ask(words)
        while self._early:
            self.order(self._early.pop(0))

    def _lose(self, why: str) -> None:
        was, self.joined = self.joined, False
        if not (self.over or self.follows) and (was or why != self.trouble):
            self.journal.add(None, "lost", f"no connection: {why}")
        self.trouble = "" if self.follows else why
        self._asked.clear()
        self.crew = CrewOrders(rings=self.crew.rings)  # the session sends those that stand again
        self.told.clear()
        self._greeted = len(self.briefing)
        self.picture.forget()

    # what the session says

    def _read(self, sentence: Sentence) -> None:
        if sentence.kind == "TRF" and sentence.fields[2] == "past":
            self._recall(self.past.mark(sentence.fields[3]))
        elif self.past.takes(sentence, self.picture.names.get(sentence.fields[0], ())):
            return
        elif sentence.kind == "TRA":
            self._answered(sentence)
        elif sentence.kind == "TRE":
            _, seconds, kind, text = sentence.fields
            self.journal.add(float(seconds), kind, text)
            self.rings += kind in BELL_KINDS
            self.releases += kind == "marks"
        elif sentence.kind == "TRF":
            self._note(sentence)
        elif self.picture.take(sentence, self.clock()) == self.gauges:
            self._sample()

    def _sample(self) -> None:
        """Add the present values to the charts."""
        reading = self.picture.reading(self.gauges)
        if reading.seconds < self._over_at:  # it is flown again, or another is
            self._go_on()
        self._catch_up(reading.seconds)
        self._follow(reading)
        ghost = self.picture.number(GHOST_CHANNEL, "depth") is not None
        if ghost and not self._ghost:  # its past was not shown while it was off
            self.ask(f"history {GHOST_CHANNEL} 60 min")
        self._ghost = ghost
        if self.trace.times[-1:] != [reading.seconds]:
            number = self.picture.number
            samples = [
                Sample(number(*each.actual), self.ordered(each), number(GHOST_CHANNEL, each.name))
                for each in self.charts
            ]
            self.trace.add(reading.seconds, samples)
        self.furthest = max(self.furthest, reading.seconds)

    def _catch_up(self, seconds: float) -> None:
        """Ask for the past that a late or returning screen has not seen."""
        missed, self._caught_up = not self._caught_up, True
        seen = self.trace.times[-1] if self.trace.times else 0.0
        if missed and seconds - seen > LATE_TIME_S:
            self.past.ask(self._charted(), self.ask)

    def _charted(self) -> set[str]:
        """Return the channels from which the charts are drawn."""
        channels = {self.gauges}
        for quantity in self.charts:
            channels |= {quantity.actual[0], *([quantity.ordered[0]] if quantity.ordered else [])}
            channels |= {"orders"} if quantity.crew else set()
        return channels & set(self.picture.names)  # those that this role is shown

    def _recall(self, channel: str) -> None:
        """Put a past that has come whole before the present."""
        past = self.past
        if channel == EVENTS_CHANNEL:
            entries = [entry_of(each) for each in past.events if each.kind == "TRE"]
            self.journal.recall(entries)
            for sentence in past.events:
                self._remember_past(sentence)
        elif channel == GHOST_CHANNEL:
            names = [each.name for each in self.charts]
            ghosts = sorted(past.rows.get(GHOST_CHANNEL, {}).items())
            self.trace.recall_ghost([(s, [row.number(n) for n in names]) for s, row in ghosts])
        elif channel and not past.wanted - {EVENTS_CHANNEL}:
            rows = past.rows.get(self.gauges, {})
            self.trace.recall([(s, self._sampled(s)) for s in sorted(rows)])
            self._recall_track(rows)

    def _sampled(self, seconds: float) -> list[Sample]:
        """Return the samples of the charts at a past time [s]."""
        number, samples = self.past.number, []
        for quantity in self.charts:
            ordered = number("orders", quantity.crew, seconds) if quantity.crew else None
            if ordered is None and quantity.ordered:
                ordered = number(*quantity.ordered, seconds)
            samples.append(Sample(number(*quantity.actual, seconds), ordered))
        return samples

    def _recall_track(self, rows: Mapping[float, ChannelReading]) -> None:
        first = self._track[0][0] if self._track else math.inf
        places = [(s, r.number("north"), r.number("east")) for s, r in rows.items() if s < first]
        earlier = [(s, n, e) for s, n, e in sorted(places) if n is not None and e is not None]
        self._track.extendleft(reversed(earlier[-(MAX_TRACK_PLACES - len(self._track)) :]))

    def _remember_past(self, sentence: Sentence) -> None:
        """Put marks and casualties from before this screen came on the time line."""
        if sentence.kind != "TRF":
            return
        _, time_text, what, subject = sentence.fields
        moment = TimelineMoment(float(time_text), "M", subject or "marked")
        if what == "order" and subject.startswith("casualty "):
            moment = TimelineMoment(float(time_text), "C", subject)
        elif what != "mark":
            return
        self.marks += [moment] if moment not in self.marks else []

    def ordered(self, drawn: Quantity) -> float | None:
        """Return the order to the crew for a quantity, else the autopilot's."""
        value = self.picture.number("orders", drawn.crew) if drawn.crew else None
        if value is None and drawn.ordered:
            return self.picture.number(*drawn.ordered)
        return value

    def _follow(self, reading: ChannelReading) -> None:
        """Add the boat's place to its track. Later places are dropped: time has gone back."""
        north, east = reading.number("north"), reading.number("east")
        if north is None or east is None:
            return
        while self._track and self._track[-1][0] > reading.seconds:
            self._track.pop()
        if not self._track or reading.seconds - self._track[-1][0] >= TRACK_PERIOD_S:
            self._track.append((reading.seconds, north, east))

    def _note(self, sentence: Sentence) -> None:
        """Take a fact: an event, or an entry of a list, in fields."""
        _, time_text, what, subject = sentence.fields
        seconds = float(time_text)
        if what in ("over", "next"):
            self.over = what == "over"
            self._awaited = -math.inf if self.over else self.clock() + NEXT_TIMEOUT_S
        elif what == "back":
            # forget what lies after a moment gone back to
            self.marks = [kept for kept in self.marks if kept.seconds <= seconds]
            self.crew.go_back()
            self.attainable = [each for each in self.attainable if each.seconds <= seconds]
            self._go_on()
            self.furthest = seconds
            if self.instructs:
                self.ask("snapshots")
        elif what == "chair":
            self.chair = subject
        elif what == "mark":
            self.marks.append(TimelineMoment(seconds, "M", subject or "marked"))
        elif what == "order":
            self._remember(seconds, subject)
        elif what in CrewOrders.FACTS:
            self._order_crew(seconds, what, subject)
        elif what in ("step", "step-hint"):
            self._lead(what, subject)
        elif what in ("exercise", "exercise-over", "marks", "reason", "debriefing"):
            self._brief(seconds, what, subject)
        else:
            self._list(seconds, what, subject)

    def _lead(self, what: str, subject: str) -> None:
        """Take a step of a lesson, or its hint."""
        self.rings += 1
        if what == "step-hint":
            self.step_hint = subject
            return
        number, count, light, text = (*subject.split(",", 3), "", "", "")[:4]
        self.lesson_done = number == "0"
        self.step, self.step_hint = ("" if self.lesson_done else number, count, light, text), ""

    def _list(self, seconds: float, what: str, subject: str) -> None:
        """Take an entry of a list: ranges, snapshots, casualties on offer, plans, evaluations."""
        if what == "range":
            # keep a range of the vessel: "rudder=30", "bell=ahead full:12" as "ahead full"
            key, _, value = subject.partition("=")
            name, colon, size = value.rpartition(":")
            with contextlib.suppress(ValueError):
                self.ranges[name if colon else key] = float(size)
        elif what == "snapshot":
            self._snapshots.append(TimelineMoment(seconds, "S", subject))
        elif what == "casualty":
            name, degree, says = (*subject.split(",", 2), "", "")[:3]
            self._casualties.append(CasualtyOffer(name, degree, says))
        elif what == "plans":  # the whole list comes anew
            self.plans.clear()
        elif what == "planned":
            self.plans += plan_of(subject)
        elif what == "attainable":
            self.attainable.append(AttainablePoint.of(subject))
        elif what == "no-attainable":
            self.unevaluated = subject

    def _order_crew(self, seconds: float, what: str, subject: str) -> None:
        """Take an order to the crew, or its repeat. The giver of an order does not repeat it."""
        self.crew.take(seconds, what, subject)
        if what == "crew-order" and self._own:
            self._own -= 1
            self.crew.settle(subject)

    def _brief(self, seconds: float, what: str, subject: str) -> None:
        """Keep the briefing of the exercise, its end, and the marks."""
        key, equals, value = subject.partition("=")
        if what == "exercise-over":
            if self.outcome:
                return  # sent again, because the line was lost meanwhile
            self.outcome, self._over_at = subject or Outcome.ENDED, seconds
            self.marks_told.clear()
            self.rings += 1
            self.endings += 1
        elif what == "marks":
            self.marks_told, self.wrong_at = [marks_in_words(subject)], None
        elif what == "reason":  # its time [s] comes first
            time_text, _, reason = subject.partition(",")
            if time_text and self.wrong_at is None:
                self.wrong_at = float(time_text)
            self.marks_told += [reason] if reason not in self.marks_told else []
        elif what == "debriefing":
            self.debriefing = f"{float(subject):.0%}" if subject else ""
        elif equals:
            if key == "title" and value != self.exercise.get("title"):
                self._forget_exercise()
            if key in REPEATED_KEYS:
                lines = self.told.setdefault(key, [])
                lines.extend([value] if value not in lines else [])
            else:
                self.exercise[key] = value

    def _forget_exercise(self) -> None:
        """Forget an exercise but its file's name, which comes before the other facts."""
        name = self.exercise.get("name")
        self.exercise.clear()
        self.step, self.step_hint, self.lesson_done = ("", "", "", ""), "", False
        self.attainable.clear()
        self.unevaluated = ""
        self.marks.clear()
        self.furthest = 0.0
        del self.briefing[: self._greeted]
        self.told.clear()
        self.marks_told.clear()
        self.outcome = ""
        if name:
            self.exercise["name"] = name

    def _answered(self, sentence: Sentence) -> None:
        kind, text = sentence.fields
        order = self._asked.get(sentence.tag)
        if order is None:
            if kind == "no":
                self.journal.add(None, "refused", text)
            return
        if kind == "say":
            order.lines.append(text)
            return
        del self._asked[sentence.tag]
        if not order.quiet:
            self._show_answer(order, kind, text)
        if kind == "ok":
            self.ended = self.ended or order.words == "quit"
            # the facts before this answer are the whole list
            if order.words == "snapshots":
                self.snapshots, self._snapshots = self._snapshots, []
            elif order.words == "casualties":
                self.casualties, self._casualties = self._casualties, []
        else:
            self.refused += 1
            self._own -= min(self._own, gives_crew(order.words))

    def _show_answer(self, asked: SentOrder, kind: str, text: str) -> None:
        for answer_line in asked.lines:
            self.journal.add(None, "answer", answer_line)
        if len(asked.lines) >= LONG_ANSWER_LINES:
            self.answers.append((asked.words, [*asked.lines, text]))
        if text:
            self.journal.add(None, "answer" if kind == "ok" else "refused", text)

    def _remember(self, seconds: float, words: str) -> None:
        """Put an event to which one may want to return on the time line."""
        name = name_of(words)
        if name == "snapshot" and self.instructs:
            self.ask("snapshots")
        elif name == "casualty":
            self.marks.append(TimelineMoment(seconds, "C", words))
            self.rings += 1

    def _go_on(self) -> None:
        """Forget the end of an exercise, because it or another one is flown now."""
        self.outcome, self._over_at = "", 0.0
        self.marks_told.clear()
