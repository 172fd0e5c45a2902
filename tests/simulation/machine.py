"""The machine of one thread: whose turn it is, and what time it is.

A task stands for a thread of the product, or for a program at the far end of a line. One of them
runs at a time. It gives its turn back in ``wait`` and ``offer_turn``; the machine draws the next.
"""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from random import Random
from typing import Final

import greenlet

SECOND_NS: Final = 1_000_000_000
START_NS: Final = 5_000 * SECOND_NS  # a machine has been up for a while
TURN_NS: Final = 20_000  # that a turn takes, of the clock and of the processor
LADEN_TURN_NS: Final = 2_000_000  # the same where other programs slow it down
LOOK_NS: Final = 200  # that a look at the clock takes: who spins until a time gets there
SPIN_WINDOW_NS: Final = SECOND_NS // 5
# threads that fly ticks and rest after each: a tick takes no time here, so they are always awake
FLYING_TASKS: Final = ("hint", "way")
SPIN_TURNS: Final = 500  # in that window: five times the most that forty seeds have seen


class Killed(BaseException):
    """The process is gone: no task of it comes back from where it waits."""


class Task:
    """One thread of the machine."""

    def __init__(self, machine: "Machine", call: Callable[[], object], name: str) -> None:
        self.name = name
        self.is_ready: Callable[[], object] | None = None  # what it waits for, None: its turn
        self.deadline: int | None = None  # [ns] until when it waits
        self.done = False
        self.thread = greenlet.greenlet(lambda: self._run(machine, call))

    @property
    def is_idle(self) -> bool:
        """Return whether it waits for ever."""
        return not self.done and self.is_ready is not None and self.deadline is None

    def wake_at(self, since: int, seconds: float) -> None:
        """Let it go on so long [s] after a time [ns]."""
        self.deadline = since + math.ceil(max(seconds, 0.0) * SECOND_NS)

    def _run(self, machine: "Machine", call: Callable[[], object]) -> None:
        try:
            call()
        except Killed:
            pass
        except BaseException as error:  # noqa: BLE001  whatever ends a thread is a finding
            machine.deaths.append((self.name, error))
        finally:
            self.done = True


class Machine:
    """The scheduler of one machine, whose processes come and go."""

    def __init__(self) -> None:
        self.now = START_NS  # [ns]
        self.set_ahead = 0.0  # [s] that the time of day was set ahead of it
        self.dice = Random(0)  # noqa: S311  whose turn it is, no secret
        self.turn = TURN_NS  # [ns]
        self.interleaving = 0.0  # [-] the chance that another comes in between where one may
        self.turns = 0
        self.tasks: list[Task] = []
        self.running: Task | None = None
        self.held: Task | None = None  # who does not go on, whatever comes
        self.deaths: list[tuple[str, BaseException]] = []
        self.spinning: list[tuple[str, int]] = []  # the threads that spun, and when [ns]
        self._redrawn: list[tuple[int, int]] = []  # after so many turns, by which seed
        self._scheduler = greenlet.getcurrent()
        self._dead = False
        self._window = self.now  # [ns] when the present one began
        self._turns_of: Counter[str] = Counter()  # in that window

    @property
    def seconds(self) -> float:
        """Return the time [s]. A look at it takes a moment."""
        self.now += LOOK_NS
        return self.now / SECOND_NS

    def boot(self, seed: int, interleaving: float, redrawn: Sequence[tuple[int, int]] = ()) -> None:
        """Begin a process, whose turns are drawn by a seed, later perhaps by others."""
        self._redrawn = list(redrawn)
        self.dice, self.interleaving = Random(seed), interleaving  # noqa: S311
        self.tasks, self.deaths, self.spinning = [], [], []
        self.turns, self._dead, self.held = 0, False, None
        self._window, self._turns_of = self.now, Counter()

    def redraw(self, redrawn: Sequence[tuple[int, int]]) -> None:
        """Draw later turns by these seeds."""
        self._redrawn = [each for each in redrawn if each[0] >= self.turns]

    def begin(self, call: Callable[[], object], name: str) -> Task:
        """Begin a task."""
        task = Task(self, call, name)
        self.tasks.append(task)
        return task

    def run(self, until: int, stop: Callable[[], object] = lambda: False) -> None:
        """Let the tasks go on until a time [ns], or until ``stop``."""
        self._scheduler = greenlet.getcurrent()
        draw = self.dice.random
        while not stop():
            ready, soonest = self._ready(until)
            if ready:
                self._take_turn(ready[int(draw() * len(ready))] if len(ready) > 1 else ready[0])
            elif soonest < until:
                self.now = soonest
            else:
                self.now = max(self.now, until)
                return

    def wait(self, is_ready: Callable[[], object], timeout: float | None = None) -> bool:
        """Let others go on until something is ready. Return whether it is.

        It is waited for a time [s] at most, without one for ever.
        """
        task = self.running
        if task is None:  # who plays the script waits for nothing
            return bool(is_ready())
        forever = timeout is None or timeout < 0.0 or math.isinf(timeout)
        task.is_ready = is_ready
        task.deadline = None if forever else self.now + math.ceil((timeout or 0.0) * SECOND_NS)
        self._switch()
        task.is_ready, task.deadline = None, None
        return bool(is_ready())

    def sleep(self, seconds: float) -> None:
        """Let others go on for a time [s]."""
        self.wait(lambda: False, max(seconds, 0.0))

    def offer_turn(self) -> None:
        """Let another come in between here, now and then."""
        if self.running and self.dice.random() < self.interleaving:
            self.running.is_ready = self.running.deadline = None
            self._switch()

    def kill(self) -> None:
        """End all tasks where they stand, as SIGKILL does."""
        self._dead = True
        for task in self.tasks:
            if task.thread:  # it has begun, and has not ended
                self.running = task
                task.thread.parent = greenlet.getcurrent()
                task.thread.throw(Killed)
        self.tasks, self.running = [], None

    def _ready(self, until: int) -> tuple[list[Task], int]:
        """Return the tasks that can go on, and the next deadline [ns] of the others."""
        ready, soonest, now = [], until, self.now
        for task in self.tasks:
            if task is self.held:
                continue
            if task.is_ready is None or task.is_ready():
                ready.append(task)
            elif task.deadline is not None:
                if task.deadline <= now:
                    ready.append(task)
                elif task.deadline < soonest:
                    soonest = task.deadline
        return ready, soonest

    def _take_turn(self, task: Task) -> None:
        self.turns += 1
        if self._redrawn and self.turns > self._redrawn[0][0]:
            self.dice.seed(self._redrawn.pop(0)[1])
        self.now += self.turn
        if self.now - self._window > SPIN_WINDOW_NS:
            self._window, self._turns_of = self.now, Counter()
        self._turns_of[task.name] += 1
        if self._turns_of[task.name] == SPIN_TURNS and task.name not in FLYING_TASKS:
            self.spinning.append((task.name, self.now))
        self.running = task
        task.thread.parent = self._scheduler
        task.thread.switch()
        self.running = None
        if task.done:
            self.tasks.remove(task)

    def _switch(self) -> None:
        """Give the turn back; come back with the next one, if there is one."""
        if not self._dead:
            self._scheduler.switch()
        if self._dead:
            raise Killed
