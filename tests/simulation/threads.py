"""Threads, locks and events of the machine, by the names that ``threading`` has for them."""

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from simulation.machine import Machine, Task


class Event:
    """A flag that tasks wait for."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._flag = False

    def is_set(self) -> bool:
        return self._flag

    def set(self) -> None:
        self._flag = True
        self._machine.offer_turn()

    def clear(self) -> None:
        self._flag = False

    def wait(self, timeout: float | None = None) -> bool:
        return self._flag or self._machine.wait(self.is_set, timeout)


class Lock(contextlib.AbstractContextManager[None]):
    """A lock. Another task may come in before it is taken."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._held = False

    def locked(self) -> bool:
        return self._held

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:  # noqa: FBT001, FBT002
        self._machine.offer_turn()
        if self._held and not (blocking and self._machine.wait(lambda: not self._held, timeout)):
            return False
        self._held = True
        return True

    def release(self) -> None:
        if not self._held:
            raise RuntimeError("release unlocked lock")
        self._held = False

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


class Condition(Lock):
    """A lock, in which tasks wait until another tells them that something has changed."""

    def __init__(self, machine: Machine) -> None:
        super().__init__(machine)
        self._waiting: list[Event] = []

    def wait_for(self, is_so: Callable[[], object]) -> object:
        """Wait until something is so, looking whenever another has notified."""
        while not (found := is_so()):
            told = Event(self._machine)
            self._waiting.append(told)
            self.release()
            told.wait()
            self.acquire()
        return found

    def notify(self) -> None:
        """Tell the task that has waited longest."""
        if self._waiting:
            self._waiting.pop(0).set()


class Thread:
    """A task that is begun later."""

    def __init__(
        self,
        machine: Machine,
        target: Callable[..., object] | None,
        name: str,
        args: tuple[object, ...],
        kwargs: Mapping[str, object],
    ) -> None:
        self._machine, self.name = machine, name
        self._call = lambda: target(*args, **kwargs) if target else None
        self.ident: int | None = None
        self.daemon = True
        self._task: Task | None = None

    def start(self) -> None:
        self.ident = 1
        self._task = self._machine.begin(self._call, self.name)
        self._machine.offer_turn()

    def is_alive(self) -> bool:
        return self._task is not None and not self._task.done

    def join(self, timeout: float | None = None) -> None:
        if self.is_alive():
            self._machine.wait(lambda: not self.is_alive(), timeout)


class Timer(Thread):
    """A call after a time [s], unless it is taken back."""

    def __init__(self, machine: Machine, interval: float, function: Callable[[], object]) -> None:
        super().__init__(machine, self._wait, "timer", (), {})
        self._interval, self._function, self._cancelled = interval, function, False

    def cancel(self) -> None:
        self._cancelled = True

    def _wait(self) -> None:
        if not self._machine.wait(lambda: self._cancelled, self._interval):
            self._function()


@dataclass(frozen=True)
class Threading:
    """The module ``threading``, as far as a session uses it."""

    machine: Machine

    def Event(self) -> Event:
        return Event(self.machine)

    def Lock(self) -> Lock:
        return Lock(self.machine)

    def Condition(self) -> Condition:
        return Condition(self.machine)

    def Thread(
        self,
        target: Callable[..., object] | None = None,
        name: str = "thread",
        args: tuple[object, ...] = (),
        kwargs: Mapping[str, Any] = {},
        *,
        daemon: bool | None = None,  # noqa: ARG002  a process that is gone has none left
    ) -> Thread:
        return Thread(self.machine, target, name, args, kwargs)

    def Timer(self, interval: float, function: Callable[[], object]) -> Timer:
        return Timer(self.machine, interval, function)

    def current_thread(self) -> object:
        return self.machine.running

    def main_thread(self) -> object:
        """Return what no task is: signals are the script's."""
        return self
