"""Help with a price: ``hint`` tells what to order now, and what it is worth.

``evaluation`` finds it by flights from the present moment. What it tells is in the journal, so that
marks can charge for it: what an exercise file says under ``hint_marks``. Where nothing is missing,
and in a lesson, which has no marks, a hint costs nothing. Where a gauge is broken that the hands of
the reference crew would believe, a hint tells to compare gauges.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from trainer.config.exercise.score_rules import HINT_ORDER
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment
from trainer.session.exercise.aids import Aids
from trainer.session.exercise.evaluation import Evaluation
from trainer.session.exercise.step_guide import StepGuide
from trainer.session.past.history import History
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.station import Request

HINT_KIND = "shown"
NOTHING_TEXT = "nothing is missing: no order now keeps more than what comes in time"
NO_MORE_TEXT = "nothing can still be earned from here: go back, or end the exercise"
LEAST_MARKS = 1.0  # [%] that can still be earned, else there is nothing to hint at


@dataclass
class Hints:
    """The hints of one session."""

    history: History
    log: EventLog
    guide: StepGuide
    aids: Aids  # which knows the plan
    evaluation: Evaluation
    preparing: bool = False  # one is being found
    told: list[tuple[Order, Giver, str]] = field(default_factory=list)  # that cost marks

    def ask(self, asked: Request) -> Reply | None:
        """Answer the order ``hint``, later by what the reference crew knows."""
        if self.guide.steps:
            return self.guide.give_hint()
        if refused := self._barred():
            return refused
        heard = partial(self._tell, asked, self.history.now())
        if refused := self.evaluation.consult(heard, "hint"):
            return Refused(refused.reason.replace("no evaluation", "no hint"))
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
        return None

    def _answer(self, asked: Request, reply: Reply) -> None:
        self.preparing = False
        asked.station.answer(asked, reply)

    def _tell(self, asked: Request, moment: Moment, found: Mapping[str, Any] | Refused) -> None:
        """Tell everybody what to order, and journal that it was told."""
        plan, history, order = self.aids.plan, self.history, asked.order
        if isinstance(found, Refused):
            self._answer(asked, Refused(found.reason.replace("no evaluation", "no hint")))
            return
        if plan is None or history.recording.branch != moment.branch or history.flown.barred:
            self._answer(asked, Refused("time has gone elsewhere meanwhile: ask again"))
            return
        advice = found["hint"]
        if not advice:
            lost = found["marks"] < LEAST_MARKS
            self._answer(asked, NO_MORE_TEXT if lost else NOTHING_TEXT)
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
