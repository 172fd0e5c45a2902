"""Processes that work for another: none outlives it."""

import ast
import contextlib
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.places import ROOT
from helpers.syntax import nodes_of

from trainer.workers import map_tasks, worker_pool

POOL = """
import multiprocessing, signal, sys
from trainer.workers import worker_pool

if __name__ == "__main__":
    with worker_pool(2) as pool:
        started = pool.map(abs, range(2))
        list(started)
        for _ in range(2):
            pool.submit(signal.pause)
        print(*(child.pid for child in multiprocessing.active_children()), flush=True)
        sys.stdin.read()
"""
SEARCH = """
import multiprocessing, sys
from trainer.analysis.reduce.objective import CandidatePool
from trainer.config.boat.vessel import load_vessel

if __name__ == "__main__":
    with CandidatePool(load_vessel("bb2").path, "modified", (), 2) as crew:
        try:
            crew.differences([[1.0], [1.0]])
        except Exception:
            pass  # that they were asked is enough
        print(*(child.pid for child in multiprocessing.active_children()), flush=True)
        sys.stdin.read()
"""
pytestmark = pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="needs handles of processes")


@contextmanager
def handles(script: str, folder: Path) -> Iterator[tuple[subprocess.Popen[str], Sequence[int]]]:
    """Run a script that prints its workers' numbers; give it, and handles of the workers."""
    path = folder / "captain.py"
    path.write_text(script, encoding="utf-8")
    program = subprocess.Popen(
        [sys.executable, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert program.stdout
    pids = [int(word) for word in program.stdout.readline().split()]
    found = [os.pidfd_open(pid) for pid in pids]
    try:
        yield program, found
    finally:
        for handle in found:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(handle, signal.SIGKILL)
            os.close(handle)
        program.kill()
        program.communicate()


def ended(several: Sequence[int], seconds: float) -> int:
    """Return how many processes end within so many seconds."""
    waiting, poll = set(several), select.poll()
    for handle in several:
        poll.register(handle, select.POLLIN)
    while waiting:
        events = poll.poll(1000.0 * seconds)
        if not events:
            break
        for handle, _ in events:
            poll.unregister(handle)
            waiting.discard(handle)
    return len(several) - len(waiting)


@pytest.mark.process
@pytest.mark.parametrize("script", [POOL, SEARCH], ids=["at work", "of a search"])
def test_workers_end_with_the_process_that_started_them_though_it_is_killed(
    script: str, tmp_path: Path
) -> None:
    with handles(script, tmp_path) as (program, several):
        assert len(several) == 2
        assert ended(several, 0.0) == 0

        program.kill()

        assert ended(several, 10.0) == 2


@pytest.mark.process
def test_an_interrupt_is_left_to_the_process_that_started_them() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # none inherits another
    try:
        with worker_pool(1) as pool:
            number = pool.submit(os.getpid).result()
            os.kill(number, signal.SIGINT)

            assert pool.submit(os.getpid).result() == number
    finally:
        signal.signal(signal.SIGINT, before)


def test_every_pool_of_processes_is_made_in_the_one_place() -> None:
    makers = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "trainer").rglob("*.py")
        if "Pool" in path.read_text(encoding="utf-8")
        for node in nodes_of(path)
        if isinstance(node, ast.Call)
        and ast.unparse(node.func).rpartition(".")[2] in ("ProcessPoolExecutor", "Pool")
    }

    assert makers == {"trainer/workers.py"}


@pytest.mark.process
def test_tasks_give_their_results_in_order_however_many_work() -> None:
    tasks = [(base, 2) for base in (5, 3, 4)]
    assert [list(map_tasks(pow, tasks, cores)) for cores in (1, 2)] == [[25, 9, 16]] * 2
