"""Processes that work for this one, and end when it does, however it ends."""

import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, get_context, parent_process


def worker_pool(count: int) -> ProcessPoolExecutor:
    """Return a pool of ``count`` processes. They end with this one even if it is killed."""
    return ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_go_with)


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
