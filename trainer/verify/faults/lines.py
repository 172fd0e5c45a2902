"""Faults of lines: a serial line unplugged and plugged in again."""

import contextlib
import os
import time
from pathlib import Path
from typing import Final

from trainer.io.recording.recording import Recording
from trainer.verify.faults.processes import remove
from trainer.verify.faults.rig import LOOK, PATIENCE, Bench, Tried
from trainer.verify.soak.audit import same_bits

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
    tried.must(bench.nursery.wait(session.process) == 0, bench.told())
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

    patience = time.monotonic() + PATIENCE
    while time.monotonic() < patience:
        if not any(fcntl.ioctl(end, termios.FIONREAD, bytes(4))):
            return True
        time.sleep(LOOK)
    return False


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
    patience = time.monotonic() + PATIENCE
    said, asked = b"", 0.0
    while time.monotonic() < patience:
        if time.monotonic() > asked:
            os.write(end, b"\rrudder left %d\r" % degrees)
            asked = time.monotonic() + 1.0
        with contextlib.suppress(BlockingIOError):
            said = said[-1000:] + os.read(end, 65536)
        if b"left %d, by hand" % degrees in said:
            return True
        time.sleep(LOOK)
    return False
