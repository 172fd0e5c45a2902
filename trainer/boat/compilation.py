"""What numba compiles on this machine, announced once and marked in the cache.

A boat needs none of it (``machine_code``); fits and ships do. A cache folder holds a mark
once all that they need has been compiled into it. The mark is named by what numba asks before it
gives machine code back, so that it speaks for this Python, this numba, this processor and these
files only.
"""

import contextlib
import hashlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

from trainer.core.digest import PACKAGE_FOLDER, imported_sources
from trainer.core.kernel import INTERPRETED


@contextlib.contextmanager
def announce_compiling(
    what: str, tell: Callable[[str], None], name: str = "complete", *folders: str
) -> Iterator[None]:
    """Announce what the block compiles, unless this machine's cache has it.

    A block that succeeds leaves the mark ``name``. It speaks for the kernels in ``folders`` of the
    package, or for those of the core where none is named.
    """
    if INTERPRETED or mark_path(name, *folders).exists():
        yield
        return
    tell(f"compiling {what} ...")
    with interruptible():
        yield
    with contextlib.suppress(OSError):
        mark_path(name, *folders).touch()


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """End the block by Ctrl-C, also where the compiler's own code loses Python's exception."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        pressed.append(number)
        signal.default_int_handler(number, frame)

    old_handler = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    except Exception:  # after Ctrl-C, what the compiler has made of KeyboardInterrupt
        if not pressed:
            raise
    finally:
        signal.signal(signal.SIGINT, old_handler)
    if pressed:
        raise KeyboardInterrupt


def mark_path(name: str, *folders: str) -> Path:
    """Return the path of a mark for the kernels in folders, else in the core."""
    from importlib import metadata  # noqa: PLC0415  what is shipped does without

    from llvmlite import binding  # type: ignore[import-untyped]  # noqa: PLC0415

    from trainer.core.cache import cache_folder  # noqa: PLC0415  it claims the folder

    facts = [metadata.version("numba"), sys.version, binding.get_host_cpu_name()]
    facts += [os.environ.get(f"NUMBA_CPU_{name}", "") for name in ("NAME", "FEATURES")]
    # numba asks a kernel's own file only; a mark speaks for all that is imported there
    for path in imported_sources(*(PACKAGE_FOLDER / each for each in folders or ("core",))):
        status = path.stat()
        facts.append(f"{path} {status.st_mtime_ns} {status.st_size}")
    return cache_folder() / f"{name}-{hashlib.sha256(repr(facts).encode()).hexdigest()[:16]}"
