"""The words, repeats and plans that stand on board after each order of the journal.

``dispatch`` keeps them after each order. A jump in time puts back what stood after the last order
of its moment. The number of an order is enough to find that, because it also says which orders came
before, on any branch. The journal is read, and its orders are understood anew, only where another
process gave them.
"""

from dataclasses import dataclass, field

from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import GiverKind
from trainer.io.recording.recording import Moment
from trainer.session.crew.agenda import Agenda, Plans
from trainer.session.crew.crew import CREW_WORDS, CrewTalk, Talk
from trainer.session.crew.manning import HandWork
from trainer.session.past.history import History

Stand = tuple[Talk, Plans]
EMPTY_STAND: Stand = Talk(), Plans()


@dataclass
class StandRecord:
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
            self._latest = now
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
        if order not in self._by_order:
            self._read()
        return self._by_order.get(order, EMPTY_STAND)

    def _read(self) -> None:
        """Understand the journal's orders again, up to the last that the state includes."""
        boat = self.crew.boat
        crew, agenda = CrewTalk(boat, HandWork(boat)), Agenda(boat)
        for entry in self.history.said():
            order = parse(entry.text)
            taken = bool(entry.accepted)
            if isinstance(order, Order) and taken and order.name in CREW_WORDS:
                crew.note(order, entry.giver, entry.tick, entry.crew)  # but no report of pumps
            if isinstance(order, Order) and (taken or entry.giver.kind is GiverKind.PLAN):
                agenda.note(order, entry.giver, entry.tick * agenda.boat.method.step)
            self._by_order[entry.id] = crew.talk, agenda.plans
