"""All that a screen knows of its session, by subject, and its unanswered orders.

``app`` calls ``hear`` several times a second. It takes the sentences that have come since
(``io/orders/sentences`` has their kinds). The table ``facts`` says which subject takes which fact;
the other facts are for pages and programs. Drawings only read.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Protocol

from trainer.console.alerts import AlertList
from trainer.console.charts import Charts, Quantity
from trainer.console.client import Greeting, Item, LineLoss, RoleRefusal, RoleTaken
from trainer.console.crew import CrewOrders
from trainer.console.exercise import Exercise
from trainer.console.journal import Journal, Timeline, TimelineMoment, entry_of
from trainer.console.past import EVENTS_CHANNEL, PAST_FACT, PastAnswers
from trainer.console.readings import ChannelReadings
from trainer.console.vessel import CasualtyOffer, Vessel
from trainer.io.orders.grammar import describe_sign, name_of
from trainer.io.orders.help import NO_ROLE_TEXT
from trainer.io.orders.sentences import Sentence, unsendable_sign

BELL_KINDS: Final = frozenset({"watch", "depth", "pilot", "plant", "trouble"})  # kinds with a bell
LONG_ANSWER_LINES: Final = 4  # [lines] from which an answer is read in a window of its own
NEXT_TIMEOUT_S: Final = 60.0  # [s] for the next exercise to be there
MAKING_READY: Final = "the next exercise is being made ready"
WIDELY_KNOWN: Final = ("snapshots", "casualties")  # asked for on joining, by the instructor


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
class SentOrders:
    """The orders of a screen, until they are answered."""

    journal: Journal
    asked: dict[str, SentOrder] = field(default_factory=dict)  # without an answer yet, by tag
    answers: list[tuple[str, list[str]]] = field(default_factory=list)  # long ones, to be read
    refused: int = 0

    def take_answer(self, tag: str, kind: str, text: str) -> str:
        """Take a line of an answer; return an order that was carried out, else ""."""
        order = self.asked.get(tag)
        if order is None:
            if kind == "no":
                self.journal.add(None, "refused", text)
            return ""
        if kind == "say":
            order.lines.append(text)
            return ""
        del self.asked[tag]
        if not order.quiet:
            self._show(order, kind, text)
        self.refused += kind != "ok"
        return order.words if kind == "ok" else ""

    def _show(self, asked: SentOrder, kind: str, text: str) -> None:
        for answer_line in asked.lines:
            self.journal.add(None, "answer", answer_line)
        if len(asked.lines) >= LONG_ANSWER_LINES:
            self.answers.append((asked.words, [*asked.lines, text]))
        if text:
            self.journal.add(None, "answer" if kind == "ok" else "refused", text)


@dataclass
class SessionModel:
    """The session as the screen of one station knows it."""

    talk: Talk
    role: str
    quantities: tuple[Quantity, ...]  # of its charts
    clock: Callable[[], float] = time.monotonic
    unread: list[Item] = field(default_factory=list)  # what came for this role before its model
    # the line, and its orders
    greeted: bool = False  # the session has taken the role once
    joined: bool = False
    trouble: str = ""  # with the line
    barred: RoleRefusal | None = None
    chair: str = ""  # the role that this line has taken in place of ``role``
    over: bool = False
    ended: bool = False  # by an order of this screen
    rings: int = 0  # how often the bell has been due for an alert or a casualty
    # what the session tells, by subject
    picture: ChannelReadings = field(default_factory=ChannelReadings)
    journal: Journal = field(default_factory=Journal)
    timeline: Timeline = field(default_factory=Timeline)
    past: PastAnswers = field(default_factory=PastAnswers)
    vessel: Vessel = field(default_factory=Vessel)
    crew: CrewOrders = field(default_factory=CrewOrders)
    exercise: Exercise = field(default_factory=Exercise)
    alerts: AlertList = field(init=False)
    charts: Charts = field(init=False)
    sent: SentOrders = field(init=False)

    def __post_init__(self) -> None:
        self.sent = SentOrders(self.journal)
        self.alerts = AlertList(self.clock)
        self.charts = Charts(self.quantities, self.gauges, self.picture, self.past, self.ask)
        self._awaited = -math.inf  # [s] on the clock, until which the next exercise may take
        self._early: list[str] = []  # orders that wait for the first line
        timeline, vessel, crew, exercise = self.timeline, self.vessel, self.crew, self.exercise
        # each fact that a screen shows, and what takes its time [s] and its subject
        self.facts: dict[str, Callable[[float, str], None]] = {
            "over": self._take_end,
            "next": self._await_next,
            "chair": self._change_chair,
            PAST_FACT: self._take_past,
            "back": self._go_back,
            "order": self._take_order,
            "mark": timeline.take_mark,
            "snapshot": lambda s, name: timeline.coming.append(TimelineMoment(s, "S", name)),
            "plans": lambda *_: timeline.plans.clear(),  # the whole list comes anew
            "planned": timeline.take_plan,
            "attainable": timeline.take_attainable,
            "no-attainable": timeline.take_unevaluated,
            "alerts": self.alerts.begin,
            "alert-rank": self.alerts.take_rank,
            "alert": self.alerts.take,
            "alert-state": self.alerts.take_state,
            "range": vessel.take_range,
            "casualty": lambda _, text: vessel.coming.append(CasualtyOffer(*text.split(",", 2))),
            "crew-order": self._take_crew_order,
            "own-order": self._take_own_order,
            "repeated": crew.settle,
            "belayed": crew.settle,
            "wrong-repeat": crew.mishear,
            "exercise": self._take_exercise,
            "step": exercise.take_step,
            "step-hint": exercise.take_hint,
            "steps-undone": exercise.take_undone,
            "exercise-over": self._end_exercise,
            "marks": exercise.take_marks,
            "reason": exercise.take_reason,
            "debriefing": exercise.take_debriefing,
            "debrief": exercise.take_page,
        }

    @property
    def instructs(self) -> bool:
        """Return whether this is the instructor's screen, who sees the truth."""
        return self.role == "instructor"

    @property
    def trains(self) -> bool:
        """Return whether this is the screen of who trains alone."""
        return self.role == "trainee"

    @property
    def follows(self) -> bool:
        """Return whether the line is missing because the next exercise is being made ready."""
        return not self.joined and self.clock() < self._awaited

    @property
    def gauges(self) -> str:
        """Return the channel of depth, heading, speed and attitude."""
        return "motion" if self.instructs else "gauges"

    @property
    def bells(self) -> int:
        """Return how often the bell was due."""
        return self.rings + self.crew.rings + self.exercise.rings

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
                if item.text not in self.exercise.briefing:
                    self.exercise.briefing.append(item.text)
                    self.journal.add(None, "briefing", item.text)
            elif isinstance(item, RoleTaken):
                self._join()
            elif isinstance(item, LineLoss):
                self._lose(item.why)
            elif isinstance(item, RoleRefusal):
                self.joined, self.barred, self.trouble = False, item, item.reason

    # the line

    def _send(self, words: str, *, quiet: bool) -> bool:
        if not quiet:
            self.journal.add(self.picture.seconds, "sent", words)
        if sign := unsendable_sign(words):
            self.journal.add(None, "refused", describe_sign(sign))
            return False
        tag = self.talk.order(words)
        if tag:
            self.sent.asked[tag] = SentOrder(words, quiet)
        elif not quiet:
            why = MAKING_READY if self.follows else self.trouble or "no connection"
            self.journal.add(None, "refused", f"not sent: {why}")
        return bool(tag)

    def _join(self) -> None:
        if self.greeted:
            back = "the next exercise is ready" if self.follows else "the connection is back"
            self.journal.add(None, "station", back)
        self._awaited = -math.inf
        self.joined, self.trouble, self.over, self.greeted = True, "", False, True
        self.charts.caught_up = False
        for words in WIDELY_KNOWN if self.instructs else ():
            self.ask(words)
        while self._early:
            self.order(self._early.pop(0))

    def _lose(self, why: str) -> None:
        was, self.joined = self.joined, False
        if not (self.over or self.follows) and (was or why != self.trouble):
            self.journal.add(None, "lost", f"no connection: {why}")
        self.trouble = "" if self.follows else why
        self.sent.asked.clear()
        self.crew.forget_waiting()
        self.exercise.lose_line()
        self.picture.forget()

    # what the session says

    def _read(self, sentence: Sentence) -> None:
        if self.past.takes(sentence, self.picture.names.get(sentence.fields[0], ())):
            return
        if sentence.kind == "TRA":
            self._answered(sentence)
        elif sentence.kind == "TRE":
            _, seconds, kind, text = sentence.fields
            self.journal.add(float(seconds), kind, text)
            self.rings += kind in BELL_KINDS
            self.exercise.releases += kind == "marks"
        elif sentence.kind == "TRF":
            _, seconds, what, subject = sentence.fields
            if what in self.facts:
                self.facts[what](float(seconds), subject)
        elif self.picture.take(sentence, self.clock()) == self.gauges:
            seconds_shown = self.picture.reading(self.gauges).seconds
            if seconds_shown < self.exercise.over_at:  # it is flown again, or another is
                self.exercise.go_on()
            self.charts.sample()
            self.timeline.furthest = max(self.timeline.furthest, seconds_shown)

    def _answered(self, sentence: Sentence) -> None:
        words = self.sent.take_answer(sentence.tag, *sentence.fields)
        if name_of(words) == "quit":
            self.ended = True
        elif words == "snapshots":
            self.timeline.snapshots, self.timeline.coming = self.timeline.coming, []
        elif words == "casualties":
            self.vessel.casualties, self.vessel.coming = self.vessel.coming, []

    # facts about more than one subject

    def _take_end(self, _seconds: float, _nothing: str) -> None:
        self.over, self._awaited = True, -math.inf

    def _await_next(self, _seconds: float, _file: str) -> None:
        self.over, self._awaited = False, self.clock() + NEXT_TIMEOUT_S

    def _change_chair(self, _seconds: float, role: str) -> None:
        self.chair = role

    def _take_order(self, seconds: float, words: str) -> None:
        """Show an event to which one may want to return on the time line."""
        name = name_of(words)
        if name == "snapshot" and self.instructs:
            self.ask("snapshots")
        elif name == "casualty":
            self.timeline.take_casualty(seconds, words)
            self.rings += 1

    def _take_crew_order(self, seconds: float, subject: str) -> None:
        """Take an order to the crew, which nobody can repeat once the exercise is over."""
        if not self.exercise.outcome:
            self.crew.give(seconds, subject)

    def _end_exercise(self, seconds: float, outcome: str) -> None:
        self.exercise.take_end(seconds, outcome)
        self.crew.forget_waiting()

    def _take_own_order(self, seconds: float, subject: str) -> None:
        """Settle an order to the crew, because its giver does not repeat it."""
        if not self.instructs:  # who waits for the crew to repeat it
            self.crew.settle(seconds, subject)

    def _go_back(self, seconds: float, _order: str) -> None:
        self.timeline.go_back(seconds)
        self.crew.forget_waiting()
        self.exercise.go_on()
        if self.instructs:
            self.ask("snapshots")

    def _take_past(self, _seconds: float, subject: str) -> None:
        """Put a past that has come whole before the present."""
        channel = self.past.mark(subject)
        if channel == EVENTS_CHANNEL:
            events = self.past.events
            self.journal.recall([entry_of(each) for each in events if each.kind == "TRE"])
            self.timeline.recall(each.fields for each in events if each.kind == "TRF")
        elif channel:
            self.charts.recall(channel)

    def _take_exercise(self, seconds: float, subject: str) -> None:
        """Take a key of the exercise. The title of another one ends what is known of the last."""
        key, _, value = subject.partition("=")
        if key == "title" and value != self.exercise.values.get(key):
            self.exercise.forget()
            self.timeline.forget()
        self.exercise.take_value(seconds, subject)
