"""The instructor's orders about time (freeze, run, step) and moments (snapshot, backtrack, replay).

``dispatch`` calls ``Control.obey`` for an order that no gate has refused. Whoever goes back in time
begins a new branch of the recording there: nothing that was flown is lost.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from trainer.boat.boat import Boat
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.recording import Moment
from trainer.session.past.history import History
from trainer.session.time.timekeeping import Timekeeping

PRESENT_MOMENT: Final = "here"  # the present moment, where one is named
Duty = Callable[[Order, str], Reply]  # takes who orders it


@dataclass
class Control:
    """Time and the past of one run, as the instructor's orders change them."""

    boat: Boat
    time: Timekeeping
    history: History
    schedule: Sequence[ScheduledOrder] = ()
    steps: int = 0  # ticks that a single-step order still allows
    ended: bool = False
    following: str = ""  # the exercise that begins when this session ends
    trains: bool = False  # it was chosen by who trains
    deserted: str = ""  # why the session ended before its time: nobody was left to say run
    failure: str = ""  # where the numbers were lost

    def obey(self, order: Order, who: str) -> Reply:
        """Carry out an order; return the answer, or why it is refused."""
        duties: dict[str, Duty] = {
            "freeze": self._freeze,
            "run": self._run,
            "step": self._step,
            "time": self._change_time,
            "quit": self._quit,
            "snapshot": self._snapshot,
            "restore": self._restore,
            "reset": self._reset,
            "backtrack": self._backtrack,
            "replay": self._replay,
            "take": self._take_over,
            "again": self._again,
            "restart": self._restart,
            "branch": self._return,
        }
        return duties[order.name](order, who)

    def _freeze(self, _order: Order, _who: str) -> Reply:
        self.time.pacer.freeze()
        return "frozen"

    def _run(self, _order: Order, _who: str) -> Reply:
        self.time.pacer.run()
        self.steps = 0
        return "running"

    def _step(self, order: Order, _who: str) -> Reply:
        self.time.pacer.freeze()
        self.steps += int(order.value)
        return f"{int(order.value)} tick{'s' if order.value > 1.0 else ''}, then frozen"

    def _change_time(self, order: Order, _who: str) -> Reply:
        fastest = order.word == "max"
        self.time.change(math.inf if fastest else order.value)
        return "time runs as fast as it can" if fastest else f"time x{order.value:g}"

    def _quit(self, _order: Order, _who: str) -> Reply:
        self.ended = True
        return "ending"

    def _snapshot(self, order: Order, _who: str) -> Reply:
        return self.history.keep(order.subject)

    def _restore(self, order: Order, who: str) -> Reply:
        snapshots = self.history.snapshots()
        if order.subject not in snapshots:
            return Refused(f"no snapshot {order.subject}; kept: {', '.join(snapshots) or 'none'}")
        return self._go_back(snapshots[order.subject], f"restore {order.subject}, by {who}")

    def _reset(self, _order: Order, who: str) -> Reply:
        return self._go_back(self.history.start(), f"reset, by {who}")

    def _backtrack(self, order: Order, who: str) -> Reply:
        return self._go_back(self.history.before(order.value), f"{order.text}, by {who}")

    def _go_back(self, moment: Moment | Refused, why: str) -> Reply:
        """Go back to a moment, frozen. A new branch begins; the answer names the old one."""
        if isinstance(moment, Refused):
            return moment
        left_time, abandoned = self.boat.time, self.history.recording.branch
        self.begin_branch(moment, why)
        way = f"back from {left_time:g} s to {self.boat.time:g} s, frozen; {self._branch}"
        return f"{way}, branch {abandoned} returns to where you were"

    def stop(self) -> None:
        """Freeze time, and forget the single steps that are left."""
        self.time.pacer.freeze()
        self.steps = 0

    def begin_branch(self, moment: Moment, why: str) -> None:
        """Begin a new branch at a moment, frozen."""
        self.history.fork_at(moment, why)
        self._begin_again()
        self.time.pacer.freeze()

    def _again(self, order: Order, who: str) -> Reply:
        """Begin the exercise again: from the start, a moment kept, so long ago, or here."""
        why = f"{order.text}, by {who}"
        if not order.word:
            return self._go_back(self.history.start(), why)
        if order.numbers:
            return self._go_back(self.history.before(order.value), why)
        snapshots = self.history.snapshots()
        if order.subject in snapshots:
            return self._go_back(snapshots[order.subject], why)
        if order.subject == PRESENT_MOMENT:
            return self._go_back(self.history.now(), why)
        names = ", ".join((PRESENT_MOMENT, *snapshots))
        return Refused(f"no snapshot {order.subject}; again from {names}, or from so long ago")

    def _restart(self, _order: Order, who: str) -> Reply:
        """Begin from the start, and let time run, because a visitor may not say run."""
        start = self.history.start()
        if isinstance(start, Refused):
            return start
        self.begin_branch(start, f"restart, by {who}")
        self.time.pacer.run()
        return f"from the start, running; {self._branch}"

    def _return(self, order: Order, who: str) -> Reply:
        """Go to the end of a branch that was left, the orders after its last tick included."""
        end = self.history.end_of(int(order.value))
        if isinstance(end, Refused):
            return end
        self.history.fork_at_end(end, f"{order.text}, by {who}", self.schedule)
        self._begin_again()
        self.time.pacer.freeze()
        return f"at the end of branch {int(order.value)}, {self.boat.time:g} s; {self._branch}"

    def _replay(self, order: Order, _who: str) -> Reply:
        if self.history.recording.trouble:
            return Refused(f"nothing to replay from: {self.history.recording.trouble}")
        moment = self.history.before(order.value)
        if isinstance(moment, Refused):
            return moment
        orders = self.history.show_again(moment)
        self._begin_again()
        self.time.pacer.run()
        until = self.history.flown.end().tick * self.boat.method.step
        return (
            f"replay from {self.boat.time:g} s to {until:g} s, {orders} orders; "
            "take over ends it at any moment"
        )

    def _take_over(self, _order: Order, who: str) -> Reply:
        if not self.history.flown.replaying:
            return Refused("no replay is running")
        self.history.take_over(f"take over, by {who}")
        return f"taken over at {self.boat.time:g} s; {self._branch}"

    @property
    def _branch(self) -> str:
        return f"branch {self.history.recording.branch} begins"

    def _begin_again(self) -> None:
        self.failure = ""
        self.steps = 0
