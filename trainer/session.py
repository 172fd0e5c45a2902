"""A run: the boat, the clock and the ports, joined. One thread ticks; ports have their own."""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from trainer.boat import Boat
from trainer.clock import Clock, Event, Pacer, Policy, Unpaced, Waited
from trainer.console import Console, status_lines
from trainer.helm import ORDERS, obey
from trainer.io.lines import Overlong
from trainer.io.order_help import help_text
from trainer.io.orders import BadOrder, Order, parse
from trainer.io.schedule import Scheduled
from trainer.ledger import Ledger
from trainer.reply import Refused
from trainer.watch import Watch


class Recorder(Protocol):
    """Where each tick's state goes."""

    trouble: str

    def row(self, values: Sequence[float]) -> None:
        """Take the columns of one tick."""
        ...


def keeper(clock: Clock, ledger: Ledger, speed: float, policy: Policy) -> Pacer | Unpaced:
    """Return what paces ticks at ``speed``; an infinite speed is as fast as the machine allows."""
    if math.isinf(speed):
        return Unpaced(clock, ledger)
    return Pacer(clock, ledger, speed, policy)


@dataclass
class Timekeeping:
    """What paces the ticks, and may be changed while they run."""

    clock: Clock
    ledger: Ledger
    policy: Policy
    pacer: Pacer | Unpaced

    @classmethod
    def at(cls, clock: Clock, step: float, speed: float, policy: Policy) -> "Timekeeping":
        """Return the keeping of time at ``speed``, infinity for as fast as it goes."""
        ledger = Ledger(step)
        return cls(clock, ledger, policy, keeper(clock, ledger, speed, policy))

    def change(self, speed: float) -> None:
        """Let time go ``speed`` times as fast from now on."""
        if math.isfinite(speed) and isinstance(self.pacer, Pacer):
            self.pacer.set_speed(speed)
            return
        frozen = self.pacer.frozen
        self.pacer = keeper(self.clock, self.ledger, speed, self.policy)
        if not frozen:
            self.pacer.run()


@dataclass
class Session:
    """One run from its first tick to its end."""

    boat: Boat
    time: Timekeeping
    recorder: Recorder
    consoles: list[Console]
    columns: tuple[str, ...]
    schedule: list[Scheduled] = field(default_factory=list)
    watch: Watch = field(default_factory=Watch)
    last_tick: float = math.inf
    progress: Callable[[int], None] | None = None
    wake: threading.Event = field(default_factory=threading.Event)
    ended: bool = False
    failure: str = ""  # where the numbers were lost
    deserted: str = ""  # why it ended before its time
    _steps: int = 0  # ticks that a single-step order still allows
    _next: int = 0  # place in the schedule

    def run(self) -> None:
        """Run to the last tick, an order to quit, or until nobody can ever say run again."""
        self._record()
        self.time.pacer.run()
        while not self._over:
            if self._deserted():
                self.deserted = f"frozen at {self.boat.time:g} s, and nobody is left to say run"
                self._tell(self.deserted)
                return
            if self.time.pacer.wait(self.wake) is Waited.WOKEN:
                self.wake.clear()
                self.listen()
            else:
                self._tick()
            self._take_steps()  # those of the schedule

    def stop(self) -> None:
        """End the run after the present tick; may be called from another thread."""
        self.ended = True
        self.wake.set()

    def listen(self) -> None:
        """Take what the consoles have typed since the last time."""
        for console in self.consoles:
            for line in console.typed():
                self._hear(console, line)
                self._take_steps()

    @property
    def _over(self) -> bool:
        """Return whether the run has been ended or has reached its last tick."""
        return self.ended or bool(self.boat.state.tick >= self.last_tick)

    def _take_steps(self) -> None:
        """Take the single steps that were ordered, as long as time stands still."""
        while self._steps and self.time.pacer.frozen and not self._over:
            self._steps -= 1
            self._tick()

    def _deserted(self) -> bool:
        """Return whether time stands still and nobody can let it go on."""
        if not self.time.pacer.frozen:
            return False
        silent = all(console.silent for console in self.consoles)
        self.listen()  # what came before the silence
        return silent and self.time.pacer.frozen and not self._over

    def _tell(self, *lines: str) -> None:
        for console in self.consoles:
            console.say(*lines)

    def _record(self) -> None:
        """Hand the state to the recorder; tell at once when it is in trouble."""
        before = self.recorder.trouble
        self.recorder.row(self.boat.numbers(self.columns))
        if self.recorder.trouble != before:
            self._tell(f"NOT RECORDED: {self.recorder.trouble}")

    def _tick(self) -> None:
        """Carry out the orders that are due, and unless they stop time take a tick."""
        was_frozen = self.time.pacer.frozen
        self._obey_schedule()
        pacer = self.time.pacer
        if self._over or (pacer.frozen and not was_frozen):
            return
        pacer.begin()
        status = self.boat.tick()
        if status:
            self.failure = self.boat.failure(status)
            self._tell(f"FROZEN: {self.failure}")
        else:
            self._record()
            for console in self.consoles:
                console.show(self.boat, frozen=pacer.frozen)
            self._tell(*self.watch.look(self.boat))
        events: tuple[Event, ...] = pacer.end()
        if status:
            pacer.freeze()
            self._steps = 0
        for event in events:
            self._tell(str(event))
        if self.progress:
            self.progress(int(self.boat.state.tick))

    def _obey_schedule(self) -> None:
        """Carry out what is due by now: an order acts on the first tick not before its time."""
        step, tick = self.boat.method.step, self.boat.state.tick
        while self._next < len(self.schedule):
            entry = self.schedule[self._next]
            if math.ceil(entry.seconds / step - 1e-9) > tick:
                return
            self._next += 1
            answer = self._answer(entry.order)
            text = f"refused: {answer.reason}" if isinstance(answer, Refused) else answer
            self._tell(f"[{entry.seconds:g} s] {entry.order.text}: {text}")

    def _hear(self, console: Console, line: str | Overlong) -> None:
        """Carry out a line from ``console`` and answer it there."""
        if isinstance(line, Overlong):
            console.say(f"? longer than {line.limit} characters; nothing done")
            return
        order = parse(line)
        if order is None:
            return
        if isinstance(order, BadOrder):
            console.say(f"? {order.reason}")
        elif order.name == "help":
            console.say(*help_text(order.word))
        elif order.name == "status":
            console.say(*status_lines(self.boat, self.time.ledger.summary()))
        else:
            answer = self._answer(order)
            console.say(f"? {answer.reason}" if isinstance(answer, Refused) else answer)

    def _answer(self, order: Order) -> str | Refused:
        """Carry out an order about time or about the boat."""
        if order.name in ORDERS:
            return obey(self.boat, order)
        if self.failure and order.name in ("run", "step"):
            return Refused(f"this boat cannot go on: {self.failure}")
        duties: dict[str, Callable[[Order], str]] = {
            "freeze": self._freeze,
            "run": self._run_on,
            "step": self._step,
            "time": self._change_time,
            "quit": self._quit,
        }
        duty = duties.get(order.name)
        return duty(order) if duty else Refused(f"{order.text} has no place in a schedule")

    def _freeze(self, _order: Order) -> str:
        self.time.pacer.freeze()
        return "frozen"

    def _run_on(self, _order: Order) -> str:
        self.time.pacer.run()
        self._steps = 0
        return "running"

    def _step(self, order: Order) -> str:
        self.time.pacer.freeze()
        self._steps += int(order.value)
        return f"{int(order.value)} tick{'s' if order.value > 1.0 else ''}, then frozen"

    def _change_time(self, order: Order) -> str:
        self.time.change(math.inf if order.word == "max" else order.value)
        return "time as fast as it goes" if order.word == "max" else order.text

    def _quit(self, _order: Order) -> str:
        self.stop()
        return "ending"
