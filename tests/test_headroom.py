"""Headroom: what a run comes to use is in its memory before its clock starts."""

import re
import subprocess
import sys

import pytest

from trainer import headroom

linux = pytest.mark.skipif(sys.platform != "linux", reason="as Linux has it")

# What follows is done in a process of its own: the allocator cannot be told to forget it.
FAULTS = """
import resource
from trainer import headroom

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

def live(sizes):
    return [b"x" * size for size in sizes]

taken = {take}
begun = faults()
for _ in range(3):
    pages = live([9_000] * 350)
    small = live([100, 200, 300, 400] * 600)
    del pages, small
print(faults() - begun)
"""
RESERVED = """
import threading
from pathlib import Path
from trainer import headroom

def reserved():
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmSize:")[2].split()[0])

"""
LARGE = """
large = b"x" * 8_000_000
del large  # glibc would henceforth have what is smaller than this in the heap
{told}
begun = reserved()
large = b"x" * 4_000_000
del large
print(reserved() - begun)
"""
HEAPS = """
{told}
held, over = [], threading.Event()

def work():
    held.append("x" * 2000)
    over.wait()

begun = reserved()
thread = threading.Thread(target=work)
thread.start()
print(reserved() - begun)
over.set()
thread.join()
"""


def found(program: str) -> int:
    """Return the number that a program prints."""
    ran = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    return int(ran.stdout)


@linux
def test_memory_used_after_headroom_was_taken_needs_no_new_page() -> None:
    assert found(FAULTS.format(take="headroom.take()")) < 40
    assert found(FAULTS.format(take="None")) > 400  # so many pages it is, seen in this way


@linux
def test_a_thread_has_no_heap_of_its_own() -> None:
    own = 64 * 1024  # [kB] of addresses that glibc sets aside for a heap
    assert found(RESERVED + HEAPS.format(told="headroom.one_heap()")) < own
    assert found(RESERVED + HEAPS.format(told="")) > own


@linux
def test_what_is_large_takes_no_room_in_the_heap_and_goes_back_to_the_system() -> None:
    assert found(RESERVED + LARGE.format(told="headroom.one_heap()")) < 1000  # [kB]


def test_where_the_allocator_cannot_be_told_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(headroom.ctypes, "CDLL", lambda _name: object())

    assert headroom.take().line() == "heaps as the system has them, 5 MB there ahead of need"


def test_of_every_size_of_small_objects_one_keeps_what_they_lie_in() -> None:
    kept = {-(-sys.getsizeof(each) // 16) * 16 for each in headroom.take().anchors}

    assert kept == set(range(32, 513, 16))


def test_a_run_that_keeps_time_accounts_for_its_headroom() -> None:
    words = ("run", "--headless", "--speed", "20", "--duration", "1")
    ran = subprocess.run(
        [sys.executable, "-m", "trainer", *words], check=True, capture_output=True, text=True
    )
    assert re.search(r"^memory      .*heap.*, 5 MB there ahead of need$", ran.stdout, re.MULTILINE)
