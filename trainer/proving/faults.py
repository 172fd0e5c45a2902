"""Every fault on purpose, so many times each."""

import random
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from trainer.proving.bench_of_faults import Bench, Tried
from trainer.proving.disk_faults import damaged, full, full_disk, vanished
from trainer.proving.line_faults import unplugged
from trainer.proving.nursery import Nursery
from trainer.proving.page import table
from trainer.proving.process_faults import clock_set, console_killed, killed, stopped

Fault = Callable[[Bench, int], Tried]
# Of how many kills each of the others is tried once.
SHARES: Final[tuple[tuple[Fault, int], ...]] = (
    (killed, 1),
    (damaged, 1),
    (stopped, 10),
    (unplugged, 10),
    (full, 10),
    (full_disk, 10),
    (vanished, 20),
    (clock_set, 20),
    (console_killed, 50),
)


def try_all(times: int, seed: int, progress: Callable[[str, int], None]) -> Iterator[Tried]:
    """Yield what came of each fault; kills are tried ``times`` times, the others in proportion."""
    with Nursery() as nursery, tempfile.TemporaryDirectory(prefix="trainer-f-") as folder:
        bench = Bench(nursery, Path(folder), random.Random(seed))  # noqa: S311  no secrets
        for number, (fault, share) in enumerate(SHARES, start=1):
            yield fault(bench, -(-times // share))
            progress("faults", number)


def faults_page(found: list[Tried]) -> str:
    """Return a table of what came of them, and all that was wrong."""
    rows = [
        (
            *(tried.fault, tried.times, tried.orders),
            f"{len(tried.wrong)} WRONG" if tried.wrong else "kept",
            "; ".join(f"{count} {how}" for how, count in tried.seen.items()),
        )
        for tried in found
    ]
    wrong = [f"{tried.fault}: {text}" for tried in found for text in tried.wrong[:20]]
    head = ("fault", "times", "orders", "promise", "seen")
    return "\n".join([table(head, rows), *wrong])
