"""A pytest plugin: only a test that is marked `process` starts one.

The tests without the mark are the lane of every commit, which is quick and holds on any machine.
"""

import multiprocessing.util
import sys
from collections.abc import Generator, Sequence
from typing import Any, Final

import pytest

STARTING_EVENTS: Final = frozenset(
    {
        "subprocess.Popen",
        "os.fork",
        "os.forkpty",
        "os.exec",
        "os.posix_spawn",
        "os.spawn",
        "os.system",
    }
)
FONT_LIST: Final = "fc-list"  # matplotlib asks for it once, where it has no list of fonts yet
STARTING_FIXTURES: Final = frozenset({"browser", "serve", "shared"})  # of `helpers.browser`
BROWSER: Final = "browser"  # the fixture whose tests wait for pictures of a page
unmarked_tests: Final[list[str]] = []  # the test that runs now, if it may start none


@pytest.hookimpl(tryfirst=True)  # before `-m` chooses
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what starts processes by its fixtures, and what waits for a browser."""
    for item in filter(starts_processes, items):
        item.add_marker("process")
        if BROWSER in item.fixturenames:  # type: ignore[attr-defined]
            item.add_marker("clock")


def starts_processes(item: pytest.Item) -> bool:
    """Return whether a test uses a fixture that starts processes."""
    return not STARTING_FIXTURES.isdisjoint(getattr(item, "fixturenames", ()))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Let nothing start while a test runs that lacks the mark."""
    if item.get_closest_marker("process") is None:
        unmarked_tests.append(item.nodeid)
    try:
        return (yield)
    finally:
        unmarked_tests.clear()


def refuse_process(event: str, arguments: Sequence[object]) -> None:
    """Fail the test that starts a process without the mark."""
    if unmarked_tests and event in STARTING_EVENTS and arguments[:1] != (FONT_LIST,):
        pytest.fail(f"{unmarked_tests[0]} starts {arguments[:1]} ({event}): mark it process")


def pytest_configure() -> None:
    """Hear of every process that is started, by multiprocessing too, which tells no audit hook."""
    sys.addaudithook(refuse_process)
    spawn = multiprocessing.util.spawnv_passfds

    def spawn_heard(path: bytes, args: Sequence[Any], passfds: Sequence[int]) -> int:
        sys.audit("os.spawn", path, args)
        return spawn(path, args, passfds)

    multiprocessing.util.spawnv_passfds = spawn_heard
