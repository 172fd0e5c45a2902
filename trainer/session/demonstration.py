"""The reference crew shows the way from a frozen moment.

It does so on a branch that counts for no mark. ``evaluation`` finds the way that earns most: one
that loses, or goes past test depth, is not shown. A thread has the crew follow the run so far, mute
(``reference_flight``). Then it comes aboard and speaks: its orders go the road of all orders, are
told to everybody, and move the controls that all screens show. Afterwards the boat is back at the
moment, frozen.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import GivenOrder, ReferenceCrew
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS
from trainer.io.orders.grammar import Order, Refused, Reply, name_of, parse
from trainer.io.recording.facts import REFERENCE_GIVER, Giver
from trainer.io.recording.recording import SHOWN_REASON, Moment, RecordingError
from trainer.session.exercise.reference_flight import crew_so_far
from trainer.session.jump import jump_to
from trainer.session.parts import Parts
from trainer.session.past.run_modes import ShownRun
from trainer.session.stations.station import Fact, Request

SHOWN_KIND = "shown"
NO_WAY_TEXT = "the best that was found from here {}; go back further, and demonstrate again"


@dataclass
class Demonstration:
    """The showing of the way in one session."""

    session: Parts
    carry_out: Callable[[Order, Giver], Reply]
    origin: Moment | None = None  # where the crew goes on afterwards
    crew: ReferenceCrew | None = None
    preparing: bool = False  # the crew follows the run so far

    def ask(self, asked: Request) -> Reply:
        """Answer the order ``demonstrate``."""
        order = asked.order
        if order.word == "off":
            if self.origin is None:
                return Refused("the way is not being shown")
            self.end()
            return "back"
        if refused := self._barred():
            return refused
        history, moment = self.session.history, self.session.history.now()
        why = f"{order.text}, by {asked.station.giver.words}"
        until = moment.tick + round(order.value / self.session.boat.method.step)
        plan = self.session.conduct.terms.plan
        assert plan is not None  # noqa: S101 (else it is barred)
        follow = crew_so_far(plan, history)

        def come_aboard(found: Mapping[str, Any] | Refused) -> None:
            fault = found.reason if isinstance(found, Refused) else found["way"]["fault"]
            if fault or isinstance(found, Refused):
                self._give_up(f"the way is not shown: {NO_WAY_TEXT.format(fault)}")
                return
            way = found["way"]
            self.session.conduct.work.begin(
                "way",
                follow,
                lambda mute: self._begin(mute, way, moment, until, why),
                lambda e: self._give_up(f"the way cannot be shown: {type(e).__name__}: {e}"),
            )

        if refused := self.session.evaluation.consult(come_aboard, "way"):
            return refused
        self.preparing = True
        return f"the reference crew looks for the way, to show it for {order.value:g} s"

    def _barred(self) -> Refused | None:
        """Return why the way cannot be shown, None if it can."""
        session, flown = self.session, self.session.history.flown
        if flown.barred:
            return flown.barred
        if self.preparing:
            return Refused("the reference crew is coming aboard already")
        plan = session.conduct.terms.plan
        if plan is None or not plan.crew.rules:
            kind = "exercise" if plan and plan.title else "free run"
            return Refused(f"this {kind} has no reference crew to show the way")
        if not session.time.frozen or session.control.steps:
            return Refused("time runs: freeze first, or go back to a moment; then demonstrate")
        if session.control.failure:
            return Refused(f"this boat cannot go on: {session.control.failure}; backtrack or reset")
        return None

    def _give_up(self, why: str) -> None:
        self.preparing = False
        self.session.event_log.tell(SHOWN_KIND, why)

    def _begin(
        self, mute: MuteCrew, way: Mapping[str, Any], moment: Moment, until: int, why: str
    ) -> None:
        """Have the crew come aboard by the way that was found, unless time has gone elsewhere."""
        session = self.session
        history, time = session.history, session.time
        now = history.now()
        here, there = ((each.branch, each.tick, each.after) for each in (now, moment))
        if here != there or not time.frozen or session.conduct.ending.over:
            self._give_up("the way is not shown: something was ordered meanwhile")
            return
        self.preparing, self.origin = False, now
        last = int(min(until, session.conduct.ending.last_tick))
        history.show_way(why, ShownRun(history, last, session.monitors.limits.encounters))
        session.event_log.follow(now)
        branch = history.recording.branch
        text = f"THE WAY IS SHOWN by the reference crew until {last * session.boat.method.step:g} s"
        session.event_log.tell(SHOWN_KIND, f"{text}: branch {branch}, which counts for no mark")
        session.shown.show_lesson("the reference crew shows the way")
        mute = mute.aboard(session.boat)
        mute.pass_over(way["settled"], drops_late=way["drops_late"])
        first = [order for text in way["first"] if isinstance(order := parse(text), Order)]
        for order in first:
            self._tell_order(GivenOrder(order.text, self.carry_out(order, REFERENCE_GIVER)))
        if first:
            mute.follow(first)
        self.crew = mute.speak()
        self.crew.order = lambda order: self.carry_out(order, REFERENCE_GIVER)
        time.pacer.run()
        session.shown.show()

    def speak(self) -> None:
        """Have the crew look and order; tell everybody what it does."""
        for order in self.crew.look() if self.crew else ():
            self._tell_order(order)

    def _tell_order(self, order: GivenOrder) -> None:
        refused = f": refused: {order.reply.reason}" if isinstance(order.reply, Refused) else ""
        what = Fact(SHOWN_KIND, order.text)
        self.session.event_log.tell(SHOWN_KIND, f"shown: {order.text}{refused}", fact=what)
        if name_of(order.text) in (*CREW_HANDS, *SAID_ORDERS) or not refused:
            self.session.shown.show_lesson(f"shown: {order.text}")

    def end_in_time(self) -> None:
        """End it where it is over. While the recording cannot be read, ``run`` tries it again."""
        try:
            self.end()
        except RecordingError as error:
            self.session.control.stop()
            self.session.shown.show()
            text = f"the way has been shown, and the moment before is not to be had: {error}"
            self.session.event_log.tell("trouble", f"{text}; run tries it again")

    def end(self) -> None:
        """Go back to the moment before, frozen, if the way is being shown; RecordingError."""
        session, origin = self.session, self.origin
        if origin is None:
            return
        jump_to(session, origin, SHOWN_REASON)
        self.origin = self.crew = None
        session.shown.lesson = ""
        branch = session.history.recording.branch
        text = f"the way has been shown: back at {session.boat.time:g} s, frozen; branch {branch}"
        session.event_log.tell("moment", text, fact=Fact("back", "demonstrate off"))
        session.event_log.recall(session.crew.unrepeated)
