"""The words, repeats and plans that stand on board after each order of the journal.

``dispatch`` keeps them after each order. A jump in time puts back what stood after the last order
of its moment. The number of an order is enough to find that, because it also says which orders came
before, on any branch. What an earlier process was given is read and understood as a session begins,
on all branches, because a jump may come while the recording is out of reach.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import GiverKind
from trainer.io.recording.recording import Moment, RecordedOrder
from trainer.session.crew.agenda import Agenda, Plans
from trainer.session.crew.crew import CREW_WORDS, CrewTalk, Talk
from trainer.session.crew.manning import HandWork
from trainer.session.past.history import History

Stand = tuple[Talk, Plans]
EMPTY_STAND: Stand = Talk(), Plans()


@dataclass
class OrdersInForce:
    """The words and plans of one session, by the order that they stand after."""

    crew: CrewTalk
    agenda: Agenda
    history: History
    _latest: Stand = EMPTY_STAND
    _by_order: dict[int, Stand] = field(default_factory=lambda: {0: EMPTY_STAND}, repr=False)

    def keep(self) -> None:
        """Record the talk and plans after the last order. Most orders share an entry: no change."""
        now = self.crew.talk, self.agenda.plans
        if now != self._latest:
            self._latest = _sharing(now[0], self._latest[0]), now[1]
        self._by_order[self.history.after] = self._latest

    def follow(self, moment: Moment) -> None:
        """Put back what stood after the last order that a moment includes."""
        talk, plans = self._stand_after(moment.after)
        self.crew.put_back(talk, moment.tick)
        self.agenda.put_back(plans)

    def put_back_plans(self) -> None:
        """Put back the plans alone, as in a replay, which says its words itself."""
        self.agenda.put_back(self._stand_after(self.history.after)[1])

    def _stand_after(self, order: int) -> Stand:
        """Return what stood after an order: as after the one before, where it changed nothing."""
        while order not in self._by_order:
            order = self.history.before_order.get(order, order - 1)  # the latter: lost in a gap
        return self._by_order[order]

    def read_journal(self) -> None:
        """Understand what an earlier process was given, branch by branch."""
        recording = self.history.recording
        for branch in recording.branches():
            self.read(recording.orders(branch.id, branch.after), branch.tick, branch.after)

    def read(self, given: Iterable[RecordedOrder], tick: int = 0, after: int = 0) -> None:
        """Understand the orders of a branch, which begins at a tick, after an order."""
        boat = self.crew.boat
        talk, plans = self._stand_after(after)
        crew, agenda = CrewTalk(boat, HandWork(boat)), Agenda(boat)
        crew.put_back(talk, tick)
        agenda.put_back(plans)
        for entry in given:
            order = parse(entry.text)
            taken = bool(entry.accepted)
            if isinstance(order, Order) and taken:
                crew.bill.take(order, entry.giver)
            if isinstance(order, Order) and taken and order.name in CREW_WORDS:
                crew.note(order, entry.giver, entry.tick, entry.crew)  # but no report of pumps
            if isinstance(order, Order) and (taken or entry.giver.kind is GiverKind.PLAN):
                agenda.note(order, entry.giver, entry.tick * agenda.boat.method.step)
            self._by_order[entry.id] = crew.talk, agenda.plans


def _sharing(talk: Talk, before: Talk) -> Talk:
    """Return a talk with the equal parts of the one before: there is one for each order."""
    new = talk._asdict()
    return talk._replace(
        **{name: old for name, old in before._asdict().items() if old == new[name]}
    )
