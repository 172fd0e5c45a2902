"""Waiting in tests: until something is to be seen, never for a time.

A machine that is busy with other work makes everything late and nothing wrong. So all who wait have
one bound, long for anything in a process. Whoever waits for another process to begin waits as long
as that one works.
"""

import contextlib
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

Made = TypeVar("Made")
PATIENCE: Final = 60.0  # [s] in which nothing that is waited for moves
LOOK: Final = 0.02  # [s] between two looks
MAX_WORK_S: Final = 30.0  # [s] of processor time, for what is waited for


def eventually(happened: Callable[[], object]) -> bool:
    """Return whether something happens in time."""
    end = time.monotonic() + PATIENCE
    while not happened():
        if time.monotonic() > end:
            return False
        time.sleep(LOOK)
    return True


def await_that(happened: Callable[[], object], told: Callable[[], object] = str) -> None:
    """Wait until something happens; where it does not, fail with what is told then."""
    assert eventually(happened), told()


def once_it_can(make: Callable[[], Made], *failures: type[Exception]) -> Made:
    """Return what is made, once it can be; where it cannot in time, its failure goes on."""
    made: list[Made] = []

    def is_made() -> bool:
        with contextlib.suppress(*failures):
            made.append(make())
        return bool(made)

    return made[0] if eventually(is_made) else make()


def await_begun(
    process: subprocess.Popen[str] | subprocess.Popen[bytes],
    has_begun: Callable[[], object],
    told: Callable[[], object] = str,
) -> None:
    """Wait until a process has begun, as long as it works; fail where it ends before."""

    def is_through() -> bool:
        assert process.poll() is None, told()
        return bool(has_begun())

    await_work(process.pid, is_through, told)


def stay_for(process: subprocess.Popen[str] | subprocess.Popen[bytes], seconds: float) -> None:
    """Let a process go on for a time [s]; fail where it ends."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        raise AssertionError(f"it has ended with {process.wait(seconds)}")


def await_work(
    process: int, happened: Callable[[], object], told: Callable[[], object] = str
) -> None:
    """Wait until something happens, as long as a process or its children work for it.

    Each time their processor time has grown the bound begins anew, until they have had MAX_WORK_S.
    """
    begun = moved = work_of_tree(process)
    end = time.monotonic() + PATIENCE
    while not happened():
        if (now := work_of_tree(process)) > moved:
            moved, end = now, time.monotonic() + PATIENCE
        assert time.monotonic() < end, f"nothing has moved for {PATIENCE:g} s: {told()}"
        assert moved - begun < MAX_WORK_S, f"{MAX_WORK_S:g} s of work, and in vain: {told()}"
        time.sleep(LOOK)


def work_of(process: int) -> float:
    """Return the processor time [s] that a process has had; 0 where the system does not tell."""
    with contextlib.suppress(OSError):
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")
    return 0.0


def work_of_tree(process: int) -> float:
    """Return the processor time [s] of a process and of all that it has started."""
    return work_of(process) + sum(map(work_of_tree, children_of(process)))


def children_of(process: int) -> list[int]:
    """Return the processes that a process has started; none where the system does not tell."""
    found: list[int] = []
    for each in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            found += map(int, each.read_text().split())
    return found
