"""A bare loop of the session's clock, in a process of its own.

``on_time`` starts it. It has no boat and no ports, so that its lateness is the machine's alone.
"""

import contextlib
import json
import sys
import threading
from collections.abc import Iterator
from dataclasses import asdict

from trainer.session.time.ledger import Ledger, Summary
from trainer.session.time.pacer import MonotonicClock, Pacer, Policy
from trainer.session.time.timekeeping import Punctuality


def run_idle_loop(seconds: float, step: float) -> Summary:
    """Return the account of an idle loop that ticks every ``step`` [s].

    The loop has the session's own pacer and ledger, so that only the boat's work is missing.
    """
    pacer = Pacer(MonotonicClock(), Ledger(step), 1.0, Policy.CATCH_UP)
    wake = threading.Event()
    pacer.run()
    for _ in range(round(seconds / step)):
        pacer.wait(wake)
        pacer.begin()
        pacer.end()
    return pacer.ledger.summary()


@contextlib.contextmanager
def busy_thread() -> Iterator[None]:
    """Run a thread inside the block that competes with the loop for the interpreter."""
    over = threading.Event()

    def work() -> None:
        while not over.is_set():
            sum(range(1000))  # short, so that the thread sees the end of the block at once

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def main(seconds: str, step: str, *words: str) -> None:
    """Print the lateness of a loop as JSON.

    The word ``realtime`` asks the system for a real-time priority, ``busy`` for a busy thread.
    """
    busy = busy_thread() if "busy" in words else contextlib.nullcontext()
    punctuality = Punctuality(realtime="realtime" in words)
    with busy:
        punctuality.keep()
        summary = run_idle_loop(float(seconds), float(step))
        punctuality.relax()
    # a system may refuse the priority: the page then says what was granted
    granted = punctuality.granted and punctuality.granted.line()
    print(json.dumps({"granted": granted, **asdict(summary.lateness)}))


if __name__ == "__main__":
    main(*sys.argv[1:])
