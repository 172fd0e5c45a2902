"""Every fault on purpose, so many times each."""

import random
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from trainer.verify.faults.disk import damaged, full, full_disk, locked, relieved, vanished
from trainer.verify.faults.fork_server import ForkServer
from trainer.verify.faults.lines import unplugged
from trainer.verify.faults.processes import clock_set, console_killed, killed, stopped
from trainer.verify.faults.rig import Bench, Tried

Fault = Callable[[Bench, int], Tried]
# Of how many kills each of the others is tried once.
SHARES: Final[tuple[tuple[Fault, int], ...]] = (
    (killed, 1),
    (damaged, 1),
    (stopped, 10),
    (unplugged, 10),
    (full, 10),
    (full_disk, 10),
    (locked, 20),
    (relieved, 20),
    (vanished, 20),
    (clock_set, 20),
    (console_killed, 50),
)


def try_all(times: int, seed: int) -> Iterator[Tried]:
    """Yield what came of each fault; kills are tried ``times`` times, the others in proportion."""
    with ForkServer() as nursery, tempfile.TemporaryDirectory(prefix="trainer-f-") as folder:
        bench = Bench(nursery, Path(folder), random.Random(seed))  # noqa: S311  no secrets
        for fault, share in SHARES:
            yield fault(bench, -(-times // share))


HEAD: Final = f"{'fault':36}{'times':>6}{'orders':>8}  promise"
TOLD: Final = 20  # of what is wrong with one fault


def told(tried: Tried) -> str:
    """Return a row of what came of a fault, under ``HEAD``, and what was wrong."""
    verdict = f"{len(tried.wrong)} WRONG" if tried.wrong else "kept"
    seen = "; ".join(f"{count} {how}" for how, count in tried.seen.items())
    row = f"{tried.fault:36}{tried.times:6}{tried.orders:8}  {verdict:10}{seen}".rstrip()
    return "\n".join([row, *(f"  {text}" for text in tried.wrong[:TOLD])])
