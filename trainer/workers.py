"""Worker processes that end when the process that started them does, however it ends.

Guides, reductions and sweeps fly in them, one for each processor unless a user says how many. A
pool of Python's own goes on working when its parent is killed, so each worker watches for the
parent's end.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, get_context, parent_process
from typing import Any, TypeVar

Result = TypeVar("Result")


def processor_count() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def worker_pool(count: int) -> ProcessPoolExecutor:
    """Return a pool of ``count`` processes. They end with this one even if it is killed."""
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_go_with)


def map_tasks(
    work: Callable[..., Result], tasks: Sequence[tuple[Any, ...]], cores: int
) -> Iterator[Result]:
    """Yield the result of each task, in their order; one core works in this process."""
    if min(cores, len(tasks)) < 2:
        yield from (work(*task) for task in tasks)
        return
    with worker_pool(min(cores, len(tasks))) as pool:
        yield from pool.map(work, *zip(*tasks, strict=True))


def _go_with() -> None:
    """Ignore interrupts, which the starting process handles, and end when it is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(sentinel: int) -> None:
    """Wait for the end of the process that started this one, then end at once."""
    connection.wait([sentinel])
    os._exit(1)
