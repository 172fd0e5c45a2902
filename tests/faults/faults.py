"""Every fault on purpose, so many times each; the faults of lines."""

import contextlib
import os
import random
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from helpers.waiting import eventually
from soak.audit import same_bits

from faults.disk import (
    damage_last_page,
    full,
    full_disk,
    lock_recording,
    relieve_disk,
    take_disk_away,
)
from faults.processes import (
    clock_set,
    console_killed,
    kill_sessions,
    remove,
    stop_session,
)
from faults.rig import Bench, Tried
from trainer.io.recording.recording import Recording

SIDES: Final = 20  # [deg] the largest of the angles ordered before a plug is pulled
LAST: Final = 25  # [deg] ordered after the last
HALF: Final = b"rudder right 3"  # an order within which the plug is pulled


def unplug(bench: Bench, times: int) -> Tried:
    """Pull the plug of a panel within an order, and plug it in again."""
    tried = Tried("serial line unplugged and replugged", "no half order acts; the panel goes on")
    port, path = bench.folder / "ttyHELM", bench.folder / "serial.trainer"
    ends = plug(port)
    session = bench.serve(path, "depth-changes", "--speed", "10", "--line", f"helm={port}")
    with session.instructed() as by:
        for number in range(times):
            tried.times += 1
            left = 1 + number % SIDES
            tried.must(order_until_answered(ends[0], left), "the panel is not answered")
            os.write(ends[0], HALF)
            tried.must(is_read(ends[1]), "the half order was not read")
            ends = replug(port, ends)
        tried.must(order_until_answered(ends[0], LAST), "the panel is not answered")
        by.ask("quit")
    tried.must(session.process.wait() == 0, bench.told())
    close(ends)
    with contextlib.closing(Recording.look(path)) as recording:
        given = [order.text for order in recording.orders(1) if order.who.startswith("helm")]
        once = list(dict.fromkeys(given))
        wanted = list(dict.fromkeys(f"rudder left {1 + i % SIDES}" for i in range(times)))
        tried.must(once == [*wanted, f"rudder left {LAST}"], f"orders were {once}")
        tried.must(same_bits(recording).kept, "not the same bits")
    tried.orders = len(given)
    remove(path)
    return tried


def is_read(end: int) -> bool:
    """Return whether all that was sent to this end is read before long."""
    import fcntl  # noqa: PLC0415  not everywhere
    import termios  # noqa: PLC0415

    return eventually(lambda: not any(fcntl.ioctl(end, termios.FIONREAD, bytes(4))))


def plug(port: Path) -> tuple[int, int]:
    """Return both ends of a new line that stands at ``port``."""
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    port.symlink_to(os.ttyname(theirs))
    return ours, theirs


def replug(port: Path, ends: tuple[int, int]) -> tuple[int, int]:
    """Pull the plug and put another line there; return its ends."""
    port.unlink()
    close(ends)
    return plug(port)


def close(ends: tuple[int, int]) -> None:
    """Close both ends."""
    for end in ends:
        os.close(end)


def order_until_answered(end: int, degrees: int) -> bool:
    """Give an order until it is answered; return whether it is before long."""
    said, asked = b"", 0.0

    def is_answered() -> bool:
        nonlocal said, asked
        if time.monotonic() > asked:
            os.write(end, b"\rrudder left %d\r" % degrees)
            asked = time.monotonic() + 1.0
        with contextlib.suppress(BlockingIOError):
            said = said[-1000:] + os.read(end, 65536)
        return b"left %d, by hand" % degrees in said

    return eventually(is_answered)


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
    with tempfile.TemporaryDirectory(prefix="trainer-f-") as folder:
        bench = Bench(Path(folder), random.Random(seed))  # noqa: S311  no secrets
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
