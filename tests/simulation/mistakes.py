"""Small mistakes of the product, which the model of a session has to see.

Each is what a careless hand would make; somebody else than who wrote the model chose their kinds.
``mutants`` has the faults that the other laws find.
"""

# ruff: noqa: SLF001  a fault lies in private parts

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

import pytest

from simulation.mutants import Fault, gather
from trainer.boat.boat import Boat
from trainer.io.orders.grammar import Order, Reply
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.recording import Moment, Recording
from trainer.session.crew.agenda import Agenda, PlannedOrder
from trainer.session.crew.orders_in_force import OrdersInForce
from trainer.session.dispatch import Dispatch
from trainer.session.nmea.sentences import InstrumentSet
from trainer.session.past.control import Control
from trainer.session.past.history import History
from trainer.session.past.run_modes import LiveRun
from trainer.session.people.command import Command
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.alerts import AlertBook
from trainer.session.stations.station import Request, Station
from trainer.session.stations.view import Frame


def gather_snapshots(patch: pytest.MonkeyPatch) -> None:
    """Answer a snapshot, and let it wait until others are written."""
    gather(patch, "snapshot")


def show_before(patch: pytest.MonkeyPatch) -> None:
    """Go on showing what was before a jump, until the next tick or order."""
    show = ScreenOutput.show

    def show_unless_jumped(self: ScreenOutput) -> None:
        branch = self.history.recording.branch
        if self._pace.branch not in (branch, 1):
            self._pace = self._pace._replace(branch=branch)
        else:
            show(self)

    patch.setattr(ScreenOutput, "show", show_unless_jumped)


def say_last_tick(patch: pytest.MonkeyPatch) -> None:
    """Send instruments the values of the tick before."""
    lines = InstrumentSet.lines
    last: dict[InstrumentSet, Frame] = {}

    def lines_of_last(self: InstrumentSet, frame: Frame) -> list[str]:
        before, last[self] = last.get(self, frame), frame
        return lines(self, before)

    patch.setattr(InstrumentSet, "lines", lines_of_last)


def keep_alerts(patch: pytest.MonkeyPatch) -> None:
    """Take alerts of any moment to the one to which time has jumped."""
    follow = AlertBook.follow
    patch.setattr(AlertBook, "follow", lambda self, _stands: follow(self, lambda _: True))


def keep_plans(patch: pytest.MonkeyPatch) -> None:
    """Leave the plans as they are where time jumps."""

    def follow(self: OrdersInForce, moment: Moment) -> None:
        self.crew.put_back(self._stand_after(moment.after)[0], moment.tick)

    patch.setattr(OrdersInForce, "follow", follow)


def let_time_run(patch: pytest.MonkeyPatch) -> None:
    """Let time run on after a jump."""

    def begin_branch(self: Control, moment: Moment, why: str) -> None:
        self.history.fork_at(moment, why)
        self._begin_again()

    patch.setattr(Control, "begin_branch", begin_branch)


def plan_late(patch: pytest.MonkeyPatch) -> None:
    """Give a plan a tick late."""
    is_due = PlannedOrder.is_due

    def is_due_late(self: PlannedOrder, boat: Boat) -> bool:
        if self.condition:
            return is_due(self, boat)
        return bool(boat.ticks_in(self.seconds) < boat.ticks)

    patch.setattr(PlannedOrder, "is_due", is_due_late)


def schedule_late(patch: pytest.MonkeyPatch) -> None:
    """Give the orders of an exercise a tick late."""

    def due_late(
        self: LiveRun, schedule: Sequence[ScheduledOrder]
    ) -> Iterator[tuple[int, ScheduledOrder]]:
        while self.next_due(schedule) < self._journal.tick:
            yield self._journal.entry, schedule[self._journal.entry]

    patch.setattr(LiveRun, "due_of_schedule", due_late)


def take_command(patch: pytest.MonkeyPatch) -> None:
    """Give command to who asks for it, without waiting for an answer."""
    ask = Command.ask

    def ask_and_take(self: Command, asked: Request) -> Reply:
        reply = ask(self, asked)
        if self.asker is asked.station:
            self._pass_to(self.asker)
        return reply

    patch.setattr(Command, "ask", ask_and_take)


def write_on_first(patch: pytest.MonkeyPatch) -> None:
    """Write events on the first branch."""
    event = Recording.event

    def event_on_first(self: Recording, *given: str, **more: str) -> None:
        branch, self.branch = self.branch, 1
        event(self, *given, **more)  # type: ignore[arg-type]
        self.branch = branch

    patch.setattr(Recording, "event", event_on_first)


def tell_all(patch: pytest.MonkeyPatch) -> None:
    """Tell every station what is ahead."""

    def tell_plans(self: Dispatch, station: Station | None = None) -> None:
        session, entry = self.session, self.session.history.entry
        if station is None and not session.agenda.has_changed(entry):
            return
        for listener in [station] if station else session.event_log.stations:
            session.event_log.note(listener, session.agenda.facts(entry))

    patch.setattr(Dispatch, "tell_plans", tell_plans)


def go_back_short(patch: pytest.MonkeyPatch) -> None:
    """Go back a tick less than was ordered."""
    before = History.before

    def before_but_one(self: History, seconds: float) -> object:
        return before(self, max(seconds - self.boat.method.step, 0.0))

    patch.setattr(History, "before", before_but_one)


def plan_from_start(patch: pytest.MonkeyPatch) -> None:
    """Count `in 10 s` from the start of the run."""
    made = Agenda._made
    patch.setattr(Agenda, "_made", lambda self, order, _now: made(self, order, 0.0))


def cancel_first(patch: pytest.MonkeyPatch) -> None:
    """Cancel the first plan alone where all are meant."""
    drop = Agenda._drop

    def drop_first(self: Agenda, order: Order) -> list[PlannedOrder]:
        if order.word == "all" and self.planned:
            order = replace(order, word="", value=float(min(self.planned)))
        return drop(self, order)

    patch.setattr(Agenda, "_drop", drop_first)


MISTAKES: Final[Mapping[str, Fault]] = {
    "snapshot-waiting": gather_snapshots,
    "picture-of-before": show_before,
    "instruments-a-tick-late": say_last_tick,
    "alerts-of-later": keep_alerts,
    "plans-of-later": keep_plans,
    "jump-lets-time-run": let_time_run,
    "plan-a-tick-late": plan_late,
    "schedule-a-tick-late": schedule_late,
    "command-at-once": take_command,
    "events-on-the-first-branch": write_on_first,
    "plans-told-to-all": tell_all,
    "back-a-tick-short": go_back_short,
    "plan-from-the-start": plan_from_start,
    "cancel-the-first": cancel_first,
}
