"""A bare loop of the session's clock. ``on_time`` measures how late its ticks begin."""

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
    """Return what became of the ticks of an idle loop at every ``step`` [s]."""
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
    """Keep the interpreter busy by a thread of this process inside the block."""
    over = threading.Event()

    def work() -> None:
        while not over.is_set():
            sum(range(1000))

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def main(seconds: str, step: str, *words: str) -> None:
    """Print the lateness of a loop as JSON. ``realtime`` and ``busy`` may be among the words."""
    busy = busy_thread() if "busy" in words else contextlib.nullcontext()
    punctuality = Punctuality(realtime="realtime" in words)
    with busy:
        punctuality.keep()
        summary = run_idle_loop(float(seconds), float(step))
        punctuality.relax()
    print(
        json.dumps(
            {
                "granted": punctuality.granted and punctuality.granted.line(),
                **asdict(summary.lateness),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
