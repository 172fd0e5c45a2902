"""The product takes threads, time and sockets by names that a machine of one thread can replace."""

import ast
import datetime as dt
import itertools
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from helpers.places import ROOT
from helpers.syntax import nodes_of

from simulation.disk import Disk
from simulation.machine import Machine
from simulation.network import Network
from simulation.seam import NAMES, functions_of, modules, played_on
from simulation.wires import Wires

ROOMS: Final = ("trainer/session", "trainer/io")
SOURCES: Final = sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
# What a session that is played has not: its own console, pages, other processes.
UNPLAYED: Final = frozenset(
    {
        "trainer/io/client.py",  # the far end of a line
        "trainer/io/udp.py",  # replaced whole: Datagrams
        "trainer/session/doors/attach.py",  # a console
        "trainer/session/doors/page_server.py",  # a process of its own
        "trainer/session/rerun/feed.py",  # a viewer of another program
        "trainer/session/rerun/request.py",
    }
)
# What is used otherwise, and why that is no matter.
EXCEPTED: Final = {
    ("trainer/session/time/pacer.py", "time"): "replaced whole: MonotonicClock",
    ("trainer/io/server.py", "socket"): "replaced whole where it listens: listen_at, socketpair",
    ("trainer/io/connection.py", "socket"): "a constant: SHUT_WR",
    ("trainer/io/connection.py", "selectors"): "constants",
}
# A parameter that makes an object of the real module, which nobody waits for in a played session.
BOUND_EARLY: Final = frozenset(
    {
        ("trainer/session/exercise/evaluation.py", "threading.Event"),  # of another process
        ("trainer/session/aside.py", "threading.Event"),  # only set and looked at
        ("trainer/session/parts.py", "threading.Event"),  # a session is given its own
    }
)
# Modules by which the outer world is reached in ways that the machine has nothing for.
FOREIGN: Final = frozenset(
    {"_thread", "asyncio", "concurrent", "multiprocessing", "queue", "sched", "select", "signal"}
)
# Who starts processes or hears signals, beside those that are not played.
FOREIGN_USERS: Final = frozenset(
    {
        ("trainer/session/run.py", "signal"),  # in the main thread alone
        ("trainer/session/doors/owner.py", "signal"),  # which a played session has not
    }
)


def past_the_seam(path: Path, name: str) -> Iterator[str]:
    """Yield what a source file takes of the outer world that cannot be replaced."""
    imported = set()
    for node in nodes_of(path):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imported |= {each.name for each in node.names}
            if past_by_import(node, name):
                yield f"{name}:{node.lineno}: {ast.unparse(node)}"
    for node in nodes_of(path):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = node.value.id
            if module in imported and (name, module) not in EXCEPTED and past_by_use(node, module):
                yield f"{name}:{node.lineno}: {ast.unparse(node)}"


def past_by_import(node: ast.Import | ast.ImportFrom, name: str) -> bool:
    """Return whether an import gives things other names, or has what nothing stands for."""
    if isinstance(node, ast.ImportFrom):
        module = (node.module or "").partition(".")[0]
        as_another = any(each.name == "datetime" and each.asname for each in node.names)
        return as_another or module in FOREIGN or module in NAMES.keys() - {"datetime"}
    tops = [each.name.partition(".")[0] for each in node.names]
    foreign = any(top in FOREIGN and (name, top) not in FOREIGN_USERS for top in tops)
    return foreign or any(each.name in NAMES and each.asname for each in node.names)


def past_by_use(node: ast.Attribute, module: str) -> bool:
    """Return whether a module has no such name where it is replaced."""
    if module == "datetime":  # the class: what does not ask for the time is a sum
        return node.attr in ("utcnow", "today")
    return module in NAMES and node.attr not in NAMES[module]


def bound_early(path: Path, name: str) -> Iterator[tuple[str, str]]:
    """Yield the names that a source file takes when it is imported, as a factory of a field."""
    for node in nodes_of(path):
        if isinstance(node, ast.keyword) and node.arg == "default_factory":
            text = ast.unparse(node.value)
            if text.partition(".")[0] in NAMES:
                yield name, text


def played_sources() -> list[tuple[Path, str]]:
    named = [(path, path.relative_to(ROOT).as_posix()) for path in SOURCES]
    return [(path, name) for path, name in named if name not in UNPLAYED]


def test_no_clock_thread_or_socket_goes_past_the_seam() -> None:
    """What is new here belongs into ``NAMES`` and the machine, or is not played, with a reason."""
    assert not [text for path, name in played_sources() for text in past_the_seam(path, name)]


def test_no_field_makes_a_thread_s_object_when_it_is_imported() -> None:
    found = {each for path, name in played_sources() for each in bound_early(path, name)}

    assert found == BOUND_EARLY


def test_what_is_excepted_is_there() -> None:
    names = set(UNPLAYED) | {name for name, _ in EXCEPTED}

    assert not [name for name in names if not (ROOT / name).is_file()]


@pytest.mark.parametrize(
    "source",
    [
        "from time import monotonic",
        "import time as clock",
        "import threading\nthreading.Barrier(2)",
        "import time\ntime.time()",
        "import socket\nsocket.create_connection(('', 1))",
        "import queue",
        "from concurrent.futures import ThreadPoolExecutor",
        "from datetime import datetime\ndatetime.utcnow()",
    ],
)
def test_what_goes_past_the_seam_is_seen(source: str, tmp_path: Path) -> None:
    path = tmp_path / "new.py"
    path.write_text(source, encoding="utf-8")

    assert list(past_the_seam(path, "trainer/session/new.py"))


def test_no_module_keeps_the_real_clock_while_it_is_played() -> None:
    machine = Machine()
    network = Network(machine)
    with played_on(machine, network, Disk(machine), Wires(network)):
        kept = [
            (module.__name__, name)
            for module, name in itertools.product(modules(), ("time", "datetime", "threading"))
            if getattr(module, name, None) in (time, dt.datetime)
        ]
        bound = [
            (function.__module__, function.__name__)
            for module in modules()
            for function in functions_of(module)
            if time.monotonic in (function.__defaults__ or ())
        ]

    assert not kept
    assert not bound


def test_the_real_clock_is_back_afterwards() -> None:
    machine = Machine()
    network = Network(machine)
    with played_on(machine, network, Disk(machine), Wires(network)):
        pass

    bound = [
        function.__name__
        for module in modules()
        for function in functions_of(module)
        if time.monotonic in (function.__defaults__ or ())
    ]
    assert "__init__" in bound
