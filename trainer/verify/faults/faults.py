"""Every fault on purpose, so many times each."""

import random
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from trainer.verify.faults.disk import (
    damage_last_page,
    full,
    full_disk,
    lock_recording,
    relieve_disk,
    take_disk_away,
)
from trainer.verify.faults.fork_server import ForkServer
from trainer.verify.faults.lines import unplug
from trainer.verify.faults.processes import clock_set, console_killed, kill_sessions, stop_session
from trainer.verify.faults.rig import Bench, Tried

Fault = Callable[[Bench, int], Tried]
# Of how many kills each of the others is tried once.
SHARES: Final[tuple[tuple[Fault, int], ...]] = (
    (kill_sessions, 1),
    (damage_last_page, 1),
    (stop_session, 10),
    (unplug, 10),
    (full, 10),
    (full_disk, 10),
    (lock_recording, 20),
    (relieve_disk, 20),
    (take_disk_away, 20),
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


def fault_row(tried: Tried) -> str:
    """Return a row of what came of a fault, under ``HEAD``, and what was wrong."""
    verdict = f"{len(tried.wrong)} WRONG" if tried.wrong else "kept"
    seen = "; ".join(f"{count} {how}" for how, count in tried.seen.items())
    row = f"{tried.fault:36}{tried.times:6}{tried.orders:8}  {verdict:10}{seen}".rstrip()
    return "\n".join([row, *(f"  {text}" for text in tried.wrong[:TOLD])])
