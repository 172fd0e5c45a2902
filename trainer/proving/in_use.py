"""What a session has in use of its memory, as it tells itself while it runs.

Its resident memory has headroom, in which little things that are never given back would not show.
Here they do: what is alive in C's heap, and how many blocks Python's own allocator has given out.
"""

import contextlib
import ctypes
import re
import statistics
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from trainer.proving.audit import Check

EVERY: Final = 0.5  # [s]
TOLD: Final = re.compile(r"in use (\d+) kB (\d+) blocks")
FEWEST: Final = 20  # times told that can be judged
MORE_HEAP: Final = 512  # [kB] that medians may differ by: half of what is alive for a moment
MORE_BLOCKS: Final = 4000
PROMISE: Final = "nor does what is in use in it"


class Mallinfo(ctypes.Structure):
    """What glibc's mallinfo2 tells of its heap [bytes]."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "mapped", "usmblks", "fsmblks"),
            *("in_use", "free", "keepcost"),
        )
    ]


def heap() -> int:
    """Return what is alive in C's heap and beside it [kB], 0 where that is not told."""
    if sys.platform != "linux":
        return 0
    ask = getattr(ctypes.CDLL(None), "mallinfo2", None)
    if ask is None:
        return 0
    ask.restype = Mallinfo
    told = ask()
    return int(told.in_use + told.mapped) // 1024


@contextlib.contextmanager
def telling(say: Callable[[str], None]) -> Iterator[None]:
    """Have a line said every now and then, inside the block, by a thread of its own."""
    over = threading.Event()

    def tell() -> None:
        while not over.wait(EVERY):
            say(f"in use {heap()} kB {sys.getallocatedblocks()} blocks")

    thread = threading.Thread(target=tell, name="in use", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def level(lines: Sequence[str]) -> Check:
    """Return whether what was told after the first third stays as it was."""
    told = [found.groups() for found in map(TOLD.fullmatch, lines) if found]
    warm = [(int(heap), int(blocks)) for heap, blocks in told[len(told) // 3 :]]
    if len(warm) < FEWEST:
        return Check(PROMISE, kept=True, seen=f"not judged: told {len(warm)} times only")
    half = len(warm) // 2
    heaps, blocks = (
        [statistics.median_high(each) for each in (values[:half], values[half:])]
        for values in zip(*warm, strict=True)
    )
    more, others = heaps[1] - heaps[0], blocks[1] - blocks[0]
    seen = (
        f"median {heaps[0]} kB of C's heap and {blocks[0]} blocks of Python's, "
        f"then {more:+} kB and {others:+}"
    )
    return Check(PROMISE, kept=more <= MORE_HEAP and others <= MORE_BLOCKS, seen=seen)
