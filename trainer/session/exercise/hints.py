"""Help with a price: ``hint`` tells what is overdue, and why.

It is what the reference crew would have ordered by now. A thread has that crew follow the run so
far, mute (``reference_flight``). What it tells is in the journal, so that marks can charge for it:
what an exercise file says under ``hint_marks``. Where nothing is overdue, and in a lesson, which
has no marks, a hint costs nothing. The hands of that crew believe their gauges: where one of these
is broken, a hint tells to compare them, and never what the hand would order.
"""

from dataclasses import dataclass, field

from trainer.boat.casualties import broken_gauges
from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import RuleProgress
from trainer.config.exercise.score_rules import HINT_ORDER
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment
from trainer.io.status_line import clock
from trainer.session.aside import BackgroundTask
from trainer.session.exercise.aids import Aids
from trainer.session.exercise.reference_flight import crew_so_far
from trainer.session.exercise.step_guide import StepGuide
from trainer.session.past.history import History
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.station import Request

HINT_KIND = "shown"
NOTHING_TEXT = "nothing is overdue, and the reference crew would steer as you do: no marks lost"
COMPARE_TEXT = "compare your gauges, for one is wrong"
AXIS_TEXTS = {"pitch": "an angle"}  # of an order to the crew


@dataclass
class Hints:
    """The hints of one session."""

    history: History
    log: EventLog
    work: BackgroundTask
    guide: StepGuide
    aids: Aids  # which knows the plan
    preparing: bool = False  # the crew follows the run so far
    told: list[tuple[Order, Giver, str]] = field(default_factory=list)  # that cost marks

    def ask(self, asked: Request) -> Reply | None:
        """Answer the order ``hint``, later by what the reference crew knows."""
        if self.guide.steps:
            return self.guide.give_hint()
        plan = self.aids.plan
        if refused := self._barred():
            return refused
        moment = self.history.now()
        assert plan is not None  # noqa: S101 (else it is barred)
        self.work.begin(
            "hint",
            crew_so_far(plan, self.history),
            lambda mute: self._tell(asked, moment, mute),
            lambda e: self._answer(asked, Refused(f"no hint: {type(e).__name__}: {e}")),
        )
        self.preparing = True
        return None

    def follow(self, moment: Moment) -> None:
        """Journal again what was told, because a new branch may begin before it.

        A run that begins anew begins without.
        """
        if not self.told or self.history.flown.barred:
            return
        if not moment.tick:
            self.told.clear()
        known = [each for each in self.history.said() if each.name == HINT_ORDER]
        for order, giver, text in self.told[len(known) :]:
            self.history.answered(self.history.order(giver, order), text)

    def _barred(self) -> Refused | None:
        """Return why there can be no hint, None if there can."""
        plan = self.aids.plan
        if self.preparing:
            return Refused("a hint is being found already")
        if plan is None or not plan.crew.rules:
            kind = "exercise" if plan and plan.title else "free run"
            return Refused(f"this {kind} has no reference crew, which a hint is from")
        trouble = self.history.recording.trouble
        return Refused(f"the run so far cannot be read: {trouble}") if trouble else None

    def _answer(self, asked: Request, reply: Reply) -> None:
        self.preparing = False
        asked.station.answer(asked, reply)

    def _tell(self, asked: Request, moment: Moment, mute: MuteCrew) -> None:
        """Tell everybody what is overdue, and journal that it was told."""
        plan, history, order = self.aids.plan, self.history, asked.order
        if plan is None or history.recording.branch != moment.branch or history.flown.barred:
            self._answer(asked, Refused("time has gone elsewhere meanwhile: ask again"))
            return
        advice = overdue_text(mute)
        if not advice:
            self._answer(asked, NOTHING_TEXT)
            return
        cost = f"{plan.hint_marks:g} mark{'' if plan.hint_marks == 1.0 else 's'}"
        text = f"hint, {cost}: {advice}"
        if any(text == known for _, _, known in self.told):
            self._answer(asked, f"{text} (told before: no marks more)")
            return
        giver = asked.station.giver
        history.answered(history.order(giver, order), text)
        self.told.append((order, giver, text))
        self.log.tell(HINT_KIND, text, asked.station)
        self._answer(asked, text)


def overdue_text(mute: MuteCrew) -> str:
    """Return the order of the reference crew that is overdue, and why; "" for none.

    Where no rule is, it is what its hands would order now.
    """
    crew = mute.crew
    if late := mute.pending(crew.boat.time):
        return f"{late[0].rule.order.text}, due since {clock(late[0].due or 0.0)}: {_why(late[0])}"
    broken = broken_gauges(crew.boat)
    if any(hand.gauge in broken for hand in crew.hands.values()):
        return COMPARE_TEXT
    for name, orders in mute.hand_orders():
        if orders:
            return f"{orders[0]}: so its {name} would steer now"
    return ""


def _why(progress: RuleProgress) -> str:
    """Return what a rule of the reference crew waited for, in words."""
    row = progress.rule.row
    if progress.undone:
        return "another order has undone it"
    if row.ordered is not None:
        return f"{AXIS_TEXTS.get(row.ordered, f'a {row.ordered}')} was ordered"
    if row.when is not None:
        return f"the gauges show {row.when}"
    return "it follows the order before" if row.at_s is None else f"it is {clock(row.at_s)}"
