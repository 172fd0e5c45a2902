"""The seam between the product and the machine it runs on.

``played_on`` replaces, in all modules of ``trainer/session`` and ``trainer/io``, what the product
has of the outer world. ``NAMES`` is all that it may use of it; ``test_seam`` holds that.
"""

import contextlib
import copy
import functools
import os
import selectors
import socket
import sys
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, tzinfo
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, Final

import pytest

from simulation.disk import Disk
from simulation.machine import Machine
from simulation.network import Network
from simulation.threads import Threading
from simulation.wires import Wires
from trainer.io import serial_line, server
from trainer.io.recording import durability, file
from trainer.io.recording.durability import Syncer
from trainer.session import resume, run
from trainer.session.exercise import evaluation
from trainer.session.exercise.evaluation import Evaluation, Question
from trainer.session.nmea import outlets
from trainer.session.time.pacer import MonotonicClock

PACKAGES: Final = ("trainer.session", "trainer.io")
EVALUATOR_TIMES_S: Final = (0.05, 0.5, 4.0)  # that an answer of the evaluator takes
DEAD_SHARE: Final = 0.05  # [-] of its answers never come; of as many moments none has marks
BIRTHDAY: Final = datetime(2026, 1, 1, tzinfo=UTC)  # the machine's time of day, when it came up
# What of a module the machine has. A module of the product that uses more of it goes past the seam.
NAMES: Final[Mapping[str, frozenset[str]]] = {
    "threading": frozenset(
        {"Event", "Lock", "Condition", "Thread", "Timer", "current_thread", "main_thread"}
    ),
    "time": frozenset({"monotonic", "sleep"}),
    "datetime": frozenset({"now"}),
    "selectors": frozenset({"DefaultSelector", "EVENT_READ", "EVENT_WRITE"}),
    "socket": frozenset({"socketpair"}),
}


@dataclass(frozen=True)
class MachineClock:
    """The clock by which ticks are paced; see ``trainer.session.time.pacer.Clock``."""

    machine: Machine

    def now(self) -> int:
        """Return the time [ns]."""
        return self.machine.now

    def cpu(self) -> int:
        """Return the processor time [ns]: a thread works as long as it does not wait."""
        return self.machine.now

    def wait_until(self, deadline: int, wake: Any) -> int:
        """Return the time [ns] once ``deadline`` is past, 0 if ``wake`` is set before."""
        machine = self.machine
        if machine.now < deadline:
            machine.wait(wake.is_set, (deadline - machine.now) / 1e9)
        return machine.now if machine.now >= deadline else 0


@dataclass
class Evaluator:
    """What stands for the evaluator's process: it finds some marks, refuses, or dies."""

    machine: Machine
    words: Sequence[str]

    def ask(self, question: Question) -> Mapping[str, Any] | None:
        """Return an answer after a time, None where the process has died."""
        dice = self.machine.dice
        self.machine.sleep(dice.choice(EVALUATOR_TIMES_S))
        if dice.random() < DEAD_SHARE:
            return None
        if dice.random() < DEAD_SHARE:
            return {"free": "the crew sails freely"}
        if question.wants == "way":
            fault = dice.choice(("", "loses (the boat was lost)"))
            return {"way": {"first": [], "settled": [], "drops_late": False, "fault": fault}}
        if question.wants == "hint":
            return {"hint": dice.choice(("", "bell astern full: all")), "marks": 50.0}
        marks = {"marks": dice.uniform(0.0, 100.0), "so_far": 0.0, "lost": False, "won": False}
        return {**marks, "with": 50.0} if question.order else marks

    def end(self) -> int:
        """Return the exit code of a process that was killed."""
        return -9


def day_of(machine: Machine) -> type[datetime]:
    """Return the class whose ``now`` is the machine's time of day."""

    class Day(datetime):
        @classmethod
        def now(cls, _tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            up = timedelta(microseconds=machine.now // 1000)
            return BIRTHDAY + up + timedelta(seconds=machine.set_ahead)

    return Day


def beside(real: ModuleType, **fakes: object) -> SimpleNamespace:
    """Return a module with some of its names replaced."""
    return SimpleNamespace(**{**vars(real), **fakes})


@contextlib.contextmanager
def played_on(
    machine: Machine, network: Network, disk: Disk, wires: Wires
) -> Iterator[pytest.MonkeyPatch]:
    """Run the product on a machine inside the block."""
    with pytest.MonkeyPatch.context() as patch:
        replace_clocks(patch, machine)
        clock = MachineClock(machine)
        patch.setattr(MonotonicClock, "__init__", lambda self: setattr(self, "now", clock.now))
        patch.setattr(MonotonicClock, "cpu", lambda _: clock.cpu())
        patch.setattr(MonotonicClock, "wait_until", lambda _, *given: clock.wait_until(*given))
        selecting = beside(selectors, DefaultSelector=network.selector)
        patch.setattr(server, "selectors", selecting)
        patch.setattr(server, "socket", beside(socket, socketpair=network.pair))
        patch.setattr(server, "listen_at", network.listen)
        patch.setattr(server, "listen_here", network.listen_here)
        patch.setattr(serial_line, "open_port", wires.open_port)
        patch.setattr(outlets, "Datagrams", wires.datagrams)
        patch.setattr(durability, "os", beside(os, fsync=disk.fsync))
        patch.setattr(file, "BUSY_TIMEOUT_S", 0.0)  # nobody goes on while SQLite waits
        watch_file(patch, disk)
        for module in (run, resume):  # it would put aside what this process collects
            patch.setattr(module, "set_garbage_aside", lambda: None)
        made: Any = Evaluation.__init__  # whose factory of events was bound before the seam
        patch.setattr(
            Evaluation,
            "__init__",
            lambda self, *given, **named: made(
                self, *given, **named, _news=Threading(machine).Event()
            ),
        )
        patch.setattr(evaluation, "EvaluatorProcess", functools.partial(Evaluator, machine))
        patch.setattr(tomllib, "loads", read_once(tomllib.loads))
        yield patch


def replace_clocks(patch: pytest.MonkeyPatch, machine: Machine) -> None:
    """Replace threads, the clock and the time of day in all modules of the product."""
    fakes = {
        "threading": Threading(machine),
        "time": beside(time, monotonic=lambda: machine.seconds, sleep=machine.sleep),
        "datetime": day_of(machine),
    }
    reals = {"threading": sys.modules["threading"], "time": time, "datetime": datetime}
    for module in modules():
        for name, real in reals.items():
            if getattr(module, name, None) is real:
                patch.setattr(module, name, fakes[name])
        for function in functions_of(module):
            if time.monotonic in (function.__defaults__ or ()):
                replaced = tuple(
                    fakes["time"].monotonic if each is time.monotonic else each  # type: ignore[attr-defined]
                    for each in function.__defaults__ or ()
                )
                patch.setattr(function, "__defaults__", replaced)


def modules() -> list[ModuleType]:
    """Return the modules of the product that are replaced in."""
    return [sys.modules[name] for name in sorted(sys.modules) if name.startswith(PACKAGES)]


def functions_of(module: ModuleType) -> Iterator[FunctionType]:
    """Yield the functions of a module, and those of its classes."""
    for thing in list(vars(module).values()):
        if isinstance(thing, FunctionType):
            yield thing
        elif isinstance(thing, type):
            yield from (each for each in vars(thing).values() if isinstance(each, FunctionType))


def watch_file(patch: pytest.MonkeyPatch, disk: Disk) -> None:
    """Let the disk know the connections of a recording, and when it is all there."""
    reopen, beside_writer, forgive = file.reopen, file.open_beside_writer, Syncer.forgive

    def forgive_and_keep(self: Syncer, failure: OSError | None) -> None:
        disk.keep()
        forgive(self, failure)

    patch.setattr(file, "reopen", lambda path: disk.writes_by(reopen(path)))
    patch.setattr(file, "open_beside_writer", lambda path: disk.reads_by(beside_writer(path)))
    patch.setattr(Syncer, "forgive", forgive_and_keep)


def read_once(loads: Callable[[str], dict[str, Any]]) -> Callable[[str], dict[str, Any]]:
    """Return a reader of TOML that reads each text once: each process reads all exercises."""
    read = functools.cache(loads)
    return lambda text: copy.deepcopy(read(text))
