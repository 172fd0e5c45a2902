"""The instructor's orders about time and moments, and which of several instructors gives them."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from trainer.boat.boat import Boat
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.schedule import Scheduled
from trainer.io.recording.recording import Moment
from trainer.session.event_log import EventLog
from trainer.session.history import History
from trainer.session.stations.roles import INSTRUCTOR
from trainer.session.stations.station import Asked, Fact, Station
from trainer.session.time.timekeeping import Timekeeping

HERE: Final = "here"  # the present moment, where one is named
ANSWER_WITHIN: Final = 10.0  # [s] for whoever has command to keep it
WATCHING: Final = frozenset(  # what an instructor without command may say
    {
        *("role", "help", "status", "briefing", "log", "who", "subscribe", "unsubscribe", "detach"),
        *("history", "mark", "branches", "snapshots", "casualties", "plans", "command", "ack"),
    }
)
Duty = Callable[[Order, str], Reply]  # takes who orders it


@dataclass
class Control:
    """The parts under the instructor's control, beside the boat."""

    boat: Boat
    time: Timekeeping
    history: History
    schedule: Sequence[Scheduled] = ()
    steps: int = 0  # ticks that a single-step order still allows
    ended: bool = False
    following: str = ""  # the exercise that begins when this session ends
    failure: str = ""  # where the numbers were lost

    def obey(self, order: Order, who: str) -> Reply:
        """Carry out an order; return what now holds, or why it was refused."""
        duties: dict[str, Duty] = {
            "freeze": self._freeze,
            "run": self._run,
            "step": self._step,
            "time": self._change_time,
            "quit": self._quit,
            "snapshot": self._snapshot,
            "snapshots": self._snapshots,
            "restore": self._restore,
            "reset": self._reset,
            "backtrack": self._backtrack,
            "replay": self._replay,
            "take": self._take_over,
            "again": self._again,
            "restart": self._restart,
            "branch": self._return,
        }
        duty = duties.get(order.name)
        if duty is None:
            return Refused(f"{order.text} has no place in a schedule")
        return duty(order, who)

    def _freeze(self, _order: Order, _who: str) -> Reply:
        self.time.pacer.freeze()
        return "frozen"

    def _run(self, _order: Order, _who: str) -> Reply:
        if self.failure:
            return self._lost()
        self.time.pacer.run()
        self.steps = 0
        return "running"

    def _step(self, order: Order, _who: str) -> Reply:
        if self.failure:
            return self._lost()
        self.time.pacer.freeze()
        self.steps += int(order.value)
        return f"{int(order.value)} tick{'s' if order.value > 1.0 else ''}, then frozen"

    def _lost(self) -> Refused:
        return Refused(f"this boat cannot go on: {self.failure}; backtrack or reset")

    def _change_time(self, order: Order, _who: str) -> Reply:
        fastest = order.word == "max"
        self.time.change(math.inf if fastest else order.value)
        return "time runs as fast as it can" if fastest else f"time x{order.value:g}"

    def _quit(self, _order: Order, _who: str) -> Reply:
        self.ended = True
        return "ending"

    def _snapshot(self, order: Order, _who: str) -> Reply:
        return self.history.keep(order.subject)

    def _snapshots(self, _order: Order, _who: str) -> Reply:
        step = self.boat.method.step
        kept = [
            f"{name} ({moment.tick * step:g} s)"
            for name, moment in self.history.snapshots().items()
        ]
        return f"snapshots: {', '.join(kept) or 'none by name'}; backtrack reaches any tick"

    def _restore(self, order: Order, who: str) -> Reply:
        kept = self.history.snapshots()
        if order.subject not in kept:
            return Refused(f"no snapshot {order.subject}; kept: {', '.join(kept) or 'none'}")
        return self._go_back(kept[order.subject], f"restore {order.subject}, by {who}")

    def _reset(self, _order: Order, who: str) -> Reply:
        return self._go_back(self.history.start(), f"reset, by {who}")

    def _backtrack(self, order: Order, who: str) -> Reply:
        return self._go_back(self.history.before(order.value), f"{order.text}, by {who}")

    def _go_back(self, moment: Moment | Refused, why: str) -> Reply:
        """Go back to a moment, frozen: a new branch begins."""
        if isinstance(moment, Refused):
            return moment
        left, abandoned = self.boat.time, self.history.recording.branch
        self.go_to(moment, why)
        way = f"back from {left:g} s to {self.boat.time:g} s, frozen; {self._branch}"
        return f"{way}, branch {abandoned} returns to where you were"

    def go_to(self, moment: Moment, why: str) -> None:
        """Go to a moment, frozen: a new branch begins there."""
        self.history.go_to(moment, why)
        self._begin_again()
        self.time.pacer.freeze()

    def _again(self, order: Order, who: str) -> Reply:
        """Begin the exercise again: from the start, a moment kept, so long ago, or here."""
        why = f"{order.text}, by {who}"
        if not order.word:
            return self._go_back(self.history.start(), why)
        if order.numbers:
            return self._go_back(self.history.before(order.value), why)
        kept = self.history.snapshots()
        if order.subject in kept:
            return self._go_back(kept[order.subject], why)
        if order.subject == HERE:
            return self._go_back(self.history.now(), why)
        there = ", ".join((HERE, *kept))
        return Refused(f"no snapshot {order.subject}; again from {there}, or from so long ago")

    def _restart(self, _order: Order, who: str) -> Reply:
        """Begin from the start, and let time go on: what a visitor may do with it."""
        start = self.history.start()
        if isinstance(start, Refused):
            return start
        self.go_to(start, f"restart, by {who}")
        self.time.pacer.run()
        return f"from the start, running; {self._branch}"

    def _return(self, order: Order, who: str) -> Reply:
        """Go to the end of a branch that was left, what was ordered there included."""
        end = self.history.end_of(int(order.value))
        if isinstance(end, Refused):
            return end
        self.history.return_to(end, f"{order.text}, by {who}", self.schedule)
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
        rerun = self.history.rerun
        until = rerun.end.tick * self.boat.method.step if rerun else 0.0
        return (
            f"replay from {self.boat.time:g} s to {until:g} s, {orders} orders; "
            "take over ends it at any moment"
        )

    def _take_over(self, _order: Order, who: str) -> Reply:
        if self.history.rerun is None:
            return Refused("no replay is running")
        self.history.take_over(f"take over, by {who}")
        return f"taken over at {self.boat.time:g} s; {self._branch}"

    @property
    def _branch(self) -> str:
        return f"branch {self.history.recording.branch} begins"

    def _begin_again(self) -> None:
        self.failure = ""
        self.steps = 0


class Alarm:
    """Wakes whoever waits, once, at the earliest of the times asked for."""

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._timer = threading.Timer(0.0, wake)
        self._due = 0.0  # [s] on the machine's clock

    def set(self, after: float) -> None:
        """Wake after a time [s], infinity for never, unless that is done before then anyway.

        Whoever wakes asks again, because an earlier time replaces a later one.
        """
        now = time.monotonic()
        if now < self._due <= now + after or math.isinf(after):
            return
        self._timer.cancel()
        self._due = now + after
        self._timer = threading.Timer(after, self._wake)
        self._timer.daemon = True
        self._timer.start()


@dataclass
class Command:
    """Which of several instructors orders; the others watch and mark."""

    log: EventLog
    wake: Callable[[], object]  # has the session's thread listen
    clock: Callable[[], float] = time.monotonic
    holder: Station | None = None
    asker: Station | None = None
    until: float = 0.0  # [s] on the clock, to answer who asks

    def __post_init__(self) -> None:
        self._alarm = Alarm(self.wake)

    def tend(self) -> None:
        """Pass command on if its holder has left, or has not answered in time."""
        if self.asker and self.asker not in self.log.stations:
            self.asker = None
        if self.holder and self.holder not in self.log.stations:
            self._pass_to(next(iter(self._instructors()), None))
        elif self.asker and self.clock() >= self.until:
            self._pass_to(self.asker)
        elif self.asker:
            self._alarm.set(self.until - self.clock())

    def barred(self, asked: Asked) -> str:
        """Return why an instructor may not order this now, "" if anybody may."""
        station = asked.station
        if station.role is not INSTRUCTOR or asked.order.name in WATCHING:
            return ""
        self._settle(station)
        if self.holder is station or self.holder is None:
            return ""
        return f"{self.holder.line.name} has command: take command asks for it"

    def ask(self, asked: Asked) -> bool:
        """Ask whoever has command for it; who does not answer in time has lost it."""
        station = asked.station
        self._settle(station)
        if self.holder is None or self.holder is station:
            station.answer(asked, "you have command")
            return True
        if self.asker not in (None, station):
            station.answer(asked, Refused(f"{self.asker.line.name} has asked for it already"))
            return True
        self.asker, self.until = station, self.clock() + ANSWER_WITHIN
        self._alarm.set(ANSWER_WITHIN)
        name = station.line.name
        within = f"within {ANSWER_WITHIN:g} s"
        text = f"{name} asks for command: give command, or keep command, {within}"
        self.log.tell("exercise", text, station, Fact("asked", name))
        holder = self.holder.line.name
        station.answer(asked, f"{holder} is asked; without an answer {within} you have command")
        return True

    def give(self, asked: Asked) -> bool:
        """Give command to who asked for it, else to another instructor."""
        taker = self.asker
        if taker is None:
            others = [each for each in self._instructors() if each is not asked.station]
            taker = others[0] if others else None
        if taker is None:
            asked.station.answer(asked, Refused("there is no other instructor"))
            return True
        self._pass_to(taker)
        asked.station.answer(asked, f"{taker.line.name} has command")
        return True

    def keep(self, asked: Asked) -> bool:
        """Keep command, which somebody asks for."""
        asker, self.asker = self.asker, None
        if asker is None:
            asked.station.answer(asked, Refused("nobody has asked for command"))
            return True
        holder = asked.station
        kept = f"{holder.line.name} keeps command"
        self.log.tell("exercise", kept, holder, Fact("command", holder.line.name))
        holder.answer(asked, "you keep command")
        return True

    def _instructors(self) -> list[Station]:
        there = [each for each in self.log.stations if each.role is INSTRUCTOR]
        return [each for each in there if not each.line.ended and not each.leaving]

    def _settle(self, station: Station) -> None:
        """Give command to who came first of the instructors, if nobody has it."""
        there = self._instructors()
        if self.holder not in there:
            self.holder = next(iter(there), station)

    def _pass_to(self, taker: Station | None) -> None:
        self.holder, self.asker = taker, None
        if taker is not None:
            name = taker.line.name
            self.log.tell("exercise", f"{name} has command", fact=Fact("command", name))
