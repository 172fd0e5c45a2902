"""The road of an order, from a line that comes in to its answer.

1. **Heard.** A station reads a line, and the grammar of ``io/orders`` understands it. What concerns
   the line alone (``LINE`` below) it does itself, and an order that its role may not give it
   refuses itself, because a stranger's words go no further than his line.
2. **Asked.** All else comes to ``Dispatch.hear`` in the thread that ticks, one order at a time.
   ``refusal`` walks the gates in the order of ``ORDER_GATES``: who has command, whether it was
   meant (``quit``), the visitor's, a boat that is lost, the end of the exercise, time that runs,
   who is alone, what is worked by hand, a replay. The first gate that is shut answers. A call of
   the Python face, and a plan whose time has come, walk the same gates, but come from no station.
3. **What is due comes before.** The exercise's orders up to this tick are carried out, so that an
   order finds the boat as the exercise has it. They walk no gate: the exercise may order what it
   forbids its crew.
4. **Journalled** (``history.order``, and on the disk by ``io/recording/recording``). An order that
   moves the boat, the crew's words or the plans is written into the journal before it acts, with
   a number: what the state of a moment includes is told by that number alone. The tick does not
   wait for the disk (``io/recording/durability``).
5. **Obeyed** by who obeys it (``Obeyer``), at the present tick; it acts from the next tick on.
6. **Answered**: in the journal, then at the station, and to all others whose role hears of it.

``ORDERS`` says of each order word who obeys it and which gates it may pass. Nothing else decides
that: the roles say who may give it, the tables of ``io/orders`` how it is worded.

An order of a recording that is replayed goes in at 5: it was journalled when it was given.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import BOAT_ORDERS, CREW_TALK, ORDER_WORDS, Obeyer
from trainer.io.recording.facts import (
    NO_CREW_FACT,
    SCHEDULE_GIVER,
    CrewFact,
    Giver,
    GiverKind,
    plan_of,
)
from trainer.io.recording.recording import RecordingError
from trainer.session.crew.manning import unheard
from trainer.session.crew.messages import CrewMessage
from trainer.session.demonstration import Demonstration
from trainer.session.jump import end_replay, follow_jump
from trainer.session.parts import Parts
from trainer.session.past.journal import order_of
from trainer.session.past.run_modes import Due
from trainer.session.stations.event_log import CREW_KIND
from trainer.session.stations.roles import (
    CLASS_ROLE,
    INSTRUCTOR_ROLE,
    TRAINEE_ROLE,
    not_for_visitors,
)
from trainer.session.stations.roles import refusal as role_refusal
from trainer.session.stations.station import Duty, Fact, LongAnswer, Request, Saying, Station

Gate = Callable[[Order, Station | None, Parts], Refused | None]


# that everybody hears of
NEWS_KINDS: Final = {
    Obeyer.TIME: "time",
    Obeyer.PAST: "moment",
    Obeyer.AIDS: "shown",
    Obeyer.CHAIR: "station",
}
# what is the instructor's, if one is here, and not a trainee's
GUIDED_OBEYERS: Final = (Obeyer.TIME, Obeyer.PAST, Obeyer.EXERCISE, Obeyer.AIDS)
# who obeys while the reference crew shows the way
OPEN_OBEYERS: Final = (Obeyer.LINE, Obeyer.QUESTION, Obeyer.TIME, Obeyer.COMMAND)


# The gates: each says why it is shut, None where it is open.


def command_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return that another instructor has command.

    Without it an instructor watches, asks and marks.
    """
    if station is None or station.role is not INSTRUCTOR_ROLE or ORDER_WORDS[order.name].watching:
        return None
    return session.conduct.command.elsewhere(station)


def quit_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return that others are attached, for whom ``quit`` ends the session only when said twice."""
    quits = order.name == "quit"
    return session.conduct.muster.unconfirmed(station) if station and quits else None


def visitor_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return why a visitor may not begin this run again."""
    asked = order.name == "restart" and not session.conduct.muster.visitors
    return not_for_visitors(station.role) if station and asked else None


def lost_gate(order: Order, _station: Station | None, session: Parts) -> Refused | None:
    """Return how the boat was lost. It can go on from an earlier moment only."""
    failure = session.control.failure if order.name in ("run", "step") else ""
    return Refused(f"this boat cannot go on: {failure}; backtrack or reset") if failure else None


def trainee_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return that an instructor is here, whose time and exercise it is."""
    trains = station is not None and station.role is TRAINEE_ROLE
    word = ORDER_WORDS[order.name]
    guided = word.obeyer in GUIDED_OBEYERS
    if not (trains and guided and session.event_log.attended(INSTRUCTOR_ROLE.name)):
        return None
    if word.paced and session.conduct.between_runs:
        return None
    return Refused("an instructor is here: time and the exercise are the instructor's")


def end_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return that the exercise is over, after which the boat obeys nobody."""
    role = station.role if station else INSTRUCTOR_ROLE
    return session.conduct.ending.barred(order, role, after_end=ORDER_WORDS[order.name].after_end)


def chair_gate(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return that others are attached, where a line keeps its role."""
    takes = order.name == "role"
    return session.conduct.chair.barred(order, station) if station and takes else None


def frozen_gate(order: Order, _station: Station | None, session: Parts) -> Refused | None:
    """Return that time runs: ``what if`` is asked of a moment that stands still."""
    runs = order.name == "what-if" and not session.time.frozen
    return Refused("what if is asked of a moment that stands still: first freeze") if runs else None


def hand_gate(order: Order, _station: Station | None, session: Parts) -> Refused | None:
    """Return that the axis which an order makes automatic has to be worked by hand."""
    return session.crew.work.refuse(order)


def replay_gate(order: Order, _station: Station | None, session: Parts) -> Refused | None:
    """Return that a replay is running, or that the way is being shown.

    Only recorded orders, or the reference crew, move the boat then.
    """
    flown, word = session.history.flown, ORDER_WORDS[order.name]
    if flown.shows_way:
        stays_open = word.in_replay and word.obeyer in OPEN_OBEYERS
        return None if stays_open or order.name == "demonstrate" else flown.barred
    return None if word.in_replay else flown.barred


ORDER_GATES: Final[Sequence[Gate]] = (
    command_gate,
    quit_gate,
    visitor_gate,
    trainee_gate,
    lost_gate,
    end_gate,
    frozen_gate,
    chair_gate,
    hand_gate,
    replay_gate,
)


def refusal(order: Order, station: Station | None, session: Parts) -> Refused | None:
    """Return why an order is refused by the first gate that is shut, None without.

    ``station`` is None for what comes from no line: a plan, or a call of the Python face.
    """
    return next(filter(None, (gate(order, station, session) for gate in ORDER_GATES)), None)


@dataclass
class Dispatch:
    """The orders of one session, on their road."""

    session: Parts
    duties: Mapping[str, Duty]  # who answers what is not passed on
    refused: list[str] = field(default_factory=list)  # of the schedule, for the summary
    way: Demonstration = field(init=False)
    _acts: Mapping[Due, Callable[[], None]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.way = Demonstration(self.session, self.carry_out)
        self.duties = {**self.duties, "demonstrate": self.way.ask}
        self._acts = {
            Due.SCHEDULE: self.obey_schedule,
            Due.PLANS: self.obey_plans,
            Due.CREW: self.way.speak,
            Due.JOURNAL: self.obey_again,
            Due.END_OF_WAY: self.way.end_in_time,
            Due.END_OF_REPLAY: lambda: end_replay(self.session),
        }

    def hear(self, asked: Request) -> None:
        """Answer what a station has asked or ordered, and tell the others."""
        session, station = self.session, asked.station
        order = session.crew.meant(asked.order)
        shut = role_refusal(station.role, order) or refusal(order, station, session)
        if ORDER_WORDS[order.name].passed_on:
            answer = shut or self._carried_out(order, station.giver, station)
            kept_answer = session.event_log.as_kept(answer)
            station.answer(asked, kept_answer, *self._unheard(order, station, answer))
            if station.role is not CLASS_ROLE:  # it tells of the other boats all the time
                self._pass_on(order, answer, station)
            return
        try:
            reply = shut or self.duties[order.name](asked)
        except RecordingError as error:  # the past that is asked about cannot be read at present
            reply = Refused(str(error))
        if isinstance(reply, LongAnswer):
            station.answer(asked, reply.result, *reply.lines)
        elif reply is not None:
            station.answer(asked, reply)

    def give(self, order: Order, giver: Giver) -> Reply:
        """Carry out an order that comes from no station; return the answer.

        A plan that a gate refuses is journalled, too, because it is no longer ahead.
        """
        session, crew_order = self.session, self.session.crew.meant(order)
        shut = refusal(crew_order, None, session)
        if shut and giver.kind is GiverKind.PLAN:
            session.history.answered(session.history.order(giver, crew_order), shut)
            session.in_force.keep()
        return shut or self._carried_out(crew_order, giver)

    def carry_out(
        self, order: Order, giver: Giver, entry: int | None = None, speaker: Station | None = None
    ) -> Reply:
        """Journal an order if its rule says so, and have it obeyed; return the answer.

        ``entry`` is its index in the schedule, None if it is from elsewhere. ``speaker`` gave the
        order and gets the answer, and therefore not the news that all others get.
        """
        session, word = self.session, ORDER_WORDS[order.name]
        recorded = word.journalled or entry is not None or giver.kind is GiverKind.PLAN
        number = session.history.order(giver, order, entry) if recorded else None
        answer, fact = self._obeyed(order, giver, entry, speaker)
        if number is not None:
            session.history.answered(number, answer, fact)
            session.in_force.keep()
        if word.obeyer is Obeyer.PAST and not isinstance(answer, Refused):
            follow_jump(session)
        if word.obeyer in (Obeyer.PAST, Obeyer.TIME) or session.shown.behind:
            session.shown.show()
        return answer

    def answer_left_orders(self) -> None:
        """Carry out what the program before had journalled, and ended before it was answered."""
        session = self.session
        for left in session.history.unanswered:
            order = order_of(left, session.agenda.schedule)
            if order is not None:
                answer, fact = self._obeyed(order, left.giver, left.entry)
                session.history.answered(left.id, answer, fact)
                session.in_force.keep()

    def _obeyed(
        self, order: Order, giver: Giver, entry: int | None, speaker: Station | None = None
    ) -> tuple[Reply, CrewFact]:
        """Have an order obeyed by who obeys it; return the answer, and its crew fact."""
        if entry is not None and not ORDER_WORDS[order.name].scheduled:
            return Refused(f"{order.text} has no place in a schedule"), NO_CREW_FACT
        if ORDER_WORDS[order.name].journalled:
            return self.obey(order, giver, speaker)
        return self.session.control.obey(order, giver.words), NO_CREW_FACT

    def obey(
        self, order: Order, giver: Giver, speaker: Station | None = None
    ) -> tuple[Reply, CrewFact]:
        """Have the boat, the crew or the plans obey, and send the crew its messages.

        Return the answer, and the crew fact of the order.
        """
        session, role, fact = self.session, giver.role, NO_CREW_FACT
        obeyer = ORDER_WORDS[order.name].obeyer
        if obeyer is Obeyer.PLANS:
            return session.agenda.obey(order), fact
        if obeyer is Obeyer.AIDS:
            return session.conduct.aids.obey(order, giver), fact
        if obeyer is Obeyer.CHAIR:
            return session.conduct.chair.change(order, giver, speaker), fact
        talk = obeyer is Obeyer.CREW
        tellings = [] if talk else session.crew.wrong_way(order, role)
        answer = session.crew.obey(order, role) if talk else obey_order(session.boat, order)
        if not isinstance(answer, Refused):
            fact = session.crew.fact_of(order, role)
            tellings += session.crew.note(order, giver, session.history.tick, fact)
            self.say(tellings, speaker)
        session.shown.take_words()
        if session.time.frozen and not isinstance(answer, Refused):  # no tick comes to show it
            session.shown.show()
        return answer, fact

    def say(self, tellings: Sequence[CrewMessage], speaker: Station | None = None) -> None:
        """Send messages of the crew, those without words to programs alone.

        The speaker gets no text, because it has the answer, except of what it takes from another.
        """
        log = self.session.event_log
        for telling in tellings:
            if telling.text:
                answered = telling.kind == CREW_KIND and telling.fact.what != "has"
                by = speaker if answered else None
                log.tell(*telling[:2], by, telling.fact, telling.saying)
                continue
            for station in log.stations:
                log.note(station, [telling.fact])

    def obey_watch(self) -> None:
        """Carry out the order that the watch gives after this tick, the guard included."""
        if due := self.session.crew.due_by_hand():
            answer = self.carry_out(due.order, due.giver)
            self.session.event_log.tell("order", f"{due.why}: {answer}")

    # What is due

    def obey_due(self) -> bool:
        """Carry out what is due before a tick; return whether the run ends there."""
        due = None
        for due in self.session.history.flown.due():
            self._acts[due]()
        return due in (Due.END_OF_WAY, Due.END_OF_REPLAY)

    def obey_schedule(self) -> None:
        """Carry out the scheduled orders that act on the next tick or before it."""
        session, flown = self.session, self.session.history.flown
        for index, entry in flown.due_of_schedule(session.agenda.schedule):
            answer = self.carry_out(entry.order, SCHEDULE_GIVER, index)
            reason = self._tell_due(f"{entry.seconds:g} s", entry.order, answer)
            if isinstance(answer, Refused):
                self.refused.append(reason)
            if session.history.flown is not flown:  # it is over
                return

    def obey_step(self, order: Order) -> None:
        """Carry out an order with which a step of a lesson begins."""
        self._tell_due("lesson", order, self.carry_out(order, SCHEDULE_GIVER))

    def obey_plans(self) -> None:
        """Carry out the instructors' plans that act on the next tick."""
        for plan in self.session.agenda.due():
            answer = self.give(plan.order, plan_of(INSTRUCTOR_ROLE.name, plan.number))
            self._tell_due(plan.ahead.moment, plan.order, answer)
            self.tell_plans()

    def obey_again(self) -> None:
        """Obey the recorded orders of this tick again, in a replay."""
        session, before = self.session, self.session.history.after
        for order, giver in session.history.flown.recorded(session.agenda.schedule):
            if order.name in BOAT_ORDERS | CREW_TALK:
                self.obey(order, giver)
        if session.history.after != before:
            session.in_force.put_back_plans()

    def tell_plans(self, station: Station | None = None) -> None:
        """Send an instructor the orders ahead; without a station all of them, if changed."""
        session, entry = self.session, self.session.history.entry
        if station is None and not session.agenda.has_changed(entry):
            return
        for listener in [station] if station else session.event_log.stations:
            if listener.role is INSTRUCTOR_ROLE:
                session.event_log.note(listener, session.agenda.facts(entry))

    def _carried_out(self, order: Order, giver: Giver, speaker: Station | None = None) -> Reply:
        """Carry out an order that no gate refused, after the scheduled orders that are due."""
        try:
            if order.name in BOAT_ORDERS:  # 3 of the road above
                self.obey_schedule()
            if order.name in ("run", "step"):
                self.session.conduct.go_on(order)
            return self.carry_out(order, giver, speaker=speaker)
        except RecordingError as error:  # its past cannot be read at present
            return Refused(str(error))

    def _unheard(self, order: Order, station: Station, answer: Reply) -> list[str]:
        """Return the lines after an answer that say how to carry out an order nobody hears."""
        crew, log = self.session.crew, self.session.event_log
        if isinstance(answer, Refused):
            return []
        manned = log.attended_by_others(station)
        return list(filter(None, [unheard(order, crew.work.worked, crew.work.allowed, manned)]))

    def _pass_on(self, order: Order, answer: Reply, station: Station) -> None:
        """Tell the others of an order and its answer; after a jump also the orders that wait."""
        session, word = self.session, ORDER_WORDS[order.name]
        accepted = not isinstance(answer, Refused)
        if not (word.obeyer is Obeyer.CREW and accepted):  # ``say`` has announced those
            what = "back" if word.jumps else "order"
            session.event_log.pass_on(order, answer, station, NEWS_KINDS.get(word.obeyer), what)
        if word.jumps and accepted:
            session.event_log.recall(session.crew.unrepeated)
        self.tell_plans()
        session.event_log.tell_trouble()

    def _tell_due(self, when: str, order: Order, answer: Reply) -> str:
        """Announce the answer to an order that was due, unless ``say`` has announced the order."""
        wrong = f"{order.text}: refused: {answer.reason}" if isinstance(answer, Refused) else ""
        text = f"{when}: {wrong or answer}"
        if wrong or ORDER_WORDS[order.name].obeyer is not Obeyer.CREW:
            fact = None if wrong else Fact("order", order.text)
            saying = Saying("schedule", wrong or str(answer))
            self.session.event_log.tell("exercise", text, fact=fact, saying=saying)
        return text
