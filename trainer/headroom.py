"""Memory that a run comes to use, there before its clock starts.

What is alive at once, orders, answers, pages of the recording, is now and then a little more than
it ever was. The process would then grow by a page: ever more seldom, but for days, and the thread
that ticks would wait until the system has found it. Headroom is found beforehand, and kept. C's
allocator (glibc's) is told to give nothing back from the end of its heap, and to have one heap for
all threads, since those of their own would each grow; Python's, for what is small, keeps a piece of
memory for as long as any object lies in it.
"""

import ctypes
import sys
from dataclasses import dataclass
from typing import Final

# The numbers of glibc's mallopt
TRIM_THRESHOLD: Final = -1
MMAP_THRESHOLD: Final = -3
ARENA_MAX: Final = -8

HEAP: Final = 4 << 20  # [bytes] half of it for the pages that SQLite keeps of the recording
SMALL: Final = 1 << 20  # [bytes] for objects of Python's own allocator
BLOCK: Final = 64_000  # [bytes] taken at once
SIZES: Final = range(48, 513, 16)  # [bytes] Python lays objects of each apart; beyond, they are C's
EMPTY: Final = sys.getsizeof(b"")
APART: Final = 128 << 10  # [bytes] blocks from here on come from the system, and go back to it
KEPT: Final = 64 << 20  # [bytes] free at the end of the heap before any is given back


@dataclass(frozen=True)
class Headroom:
    """What was taken."""

    one_heap: bool  # the allocator could be told
    anchors: list[object]  # of each size one that stays, so that what they lie in is kept

    def line(self) -> str:
        """Return it in one line."""
        heap = "one heap" if self.one_heap else "heaps as the system has them"
        return f"{heap}, {(HEAP + SMALL) >> 20} MB there ahead of need"


def one_heap() -> bool:
    """Have the heap keep what it has, for all threads yet to begin; return whether that can be."""
    if sys.platform != "linux":
        return False
    tell = getattr(ctypes.CDLL(None), "mallopt", None)
    if tell is None:
        return False
    wishes = ((TRIM_THRESHOLD, KEPT), (MMAP_THRESHOLD, APART), (ARENA_MAX, 1))
    told = [tell(*wish) for wish in wishes]  # all of them, whatever came of the first
    return all(told)


def take() -> Headroom:
    """Write to memory and leave it free, for what will be needed."""
    told = one_heap()
    blocks = [b"\xff" * BLOCK for _ in range(HEAP // BLOCK)]
    small = [_objects(size) for size in SIZES]
    numbers = [float(number) for number in range(SMALL // len(SIZES) // sys.getsizeof(0.0))]
    del blocks
    return Headroom(told, [numbers[-1], *(each[-1] for each in small)])


def _objects(size: int) -> list[bytes]:
    """Return objects of one size [bytes]."""
    return [b"\xff" * (size - EMPTY) for _ in range(SMALL // len(SIZES) // size)]
