"""The tests of everybody, `-m "not process and not slow and not long"`, start no process."""

import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Callable

import pytest
from helpers import installation
from helpers.process_guard import STARTING_FIXTURES, starts_processes

STARTS: dict[str, Callable[[], object]] = {
    "a program": lambda: subprocess.run([sys.executable, "-c", ""], check=False),
    "a shell": lambda: os.system("true"),  # noqa: S605
    "a fork": lambda: os.fork(),  # noqa: PLW0108  it is not there on every system
    "a spawned worker": lambda: start_worker("spawn"),
    "a server of forks": lambda: start_worker("forkserver"),
}


def start_worker(way: str) -> None:
    """Start a process of multiprocessing in that way."""
    multiprocessing.get_context(way).Process(target=int).start()  # type: ignore[attr-defined]


@pytest.mark.parametrize("start", STARTS.values(), ids=STARTS)
@pytest.mark.skipif(os.name != "posix", reason="forks of POSIX")
def test_a_test_that_starts_a_process_unmarked_fails(start: Callable[[], object]) -> None:
    with pytest.raises(pytest.fail.Exception, match="mark it process"):
        start()


@pytest.mark.process
def test_a_test_that_is_marked_may_start_one() -> None:
    assert subprocess.run([sys.executable, "-c", ""], check=False).returncode == 0


def test_a_test_is_marked_by_a_fixture_that_starts_one(request: pytest.FixtureRequest) -> None:
    item = request.node
    unmarked = starts_processes(item)
    with pytest.MonkeyPatch.context() as names:
        for name in STARTING_FIXTURES:
            names.setattr(item, "fixturenames", [name])
            assert starts_processes(item)

    assert not unmarked


@pytest.mark.parametrize("failures", [0, 3])
def test_apt_is_called_until_the_network_is_there(
    failures: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    codes, waits = [100] * failures + [0], list[float]()

    def call(words: list[str], **_how: object) -> "subprocess.CompletedProcess[str]":
        return subprocess.CompletedProcess(words, codes.pop(0))

    monkeypatch.setattr(subprocess, "run", call)
    monkeypatch.setattr(time, "sleep", waits.append)
    installation.call_apt(["update"])

    assert not codes
    assert len(waits) == failures


def test_a_package_that_there_is_not_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(0, 10_000, 100))
    failed = subprocess.CompletedProcess[str]([], 100)
    monkeypatch.setattr(subprocess, "run", lambda *_words, **_how: failed)
    monkeypatch.setattr(time, "sleep", lambda _seconds: None)
    monkeypatch.setattr(time, "monotonic", lambda: float(next(clock)))
    installation.call_apt(["install", "no-such-package"])

    assert next(clock) > installation.OUTAGE_S
