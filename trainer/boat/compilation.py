"""The core is compiled or not, its machine code is kept or not.

A cache folder holds a mark once all that a run needs has been compiled into it. The mark is named
by what numba asks before it gives machine code back, so that it speaks for this Python, this numba,
this processor and these files only.
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
from typing import Final

from trainer.core.cache import cache_folder, sources
from trainer.io.file_lock import holding

KERNELS: Final = "trainer.core.kernel"  # once it is imported, how kernels run is settled
LOCK: Final = "compiling"
LOOK: Final = 0.5  # [s] between looks at whether that is done
COMPLAINTS: Final = "compiling.log"  # of a compilation beside a run; gone when it succeeds


def is_kept() -> bool:
    """Return whether everything that a run needs has been compiled on this machine before."""
    return mark("complete").exists()


def keep(name: str = "complete", *folders: str) -> None:
    """Note that everything that a run needs has been compiled; nothing where that cannot be."""
    with contextlib.suppress(OSError):
        mark(name, *folders).touch()


def is_settled() -> bool:
    """Return whether it is too late to choose between machine code and none."""
    return KERNELS in sys.modules


def do_without() -> None:
    """Set the interpreter to run the kernels, which must not have been imported yet."""
    import numba  # noqa: PLC0415

    numba.config.DISABLE_JIT = True  # type: ignore[attr-defined]


def is_needed() -> bool:
    """Return whether a boat has to be compiled before it can go to sea."""
    return not (is_interpreted() or is_kept())


def known_compiler() -> bool:
    """Return whether kernels are compiled, by a version that ``call`` and fleets know."""
    import numba  # noqa: PLC0415

    from trainer.core.kernel import is_tested  # noqa: PLC0415  settles how kernels run

    return is_tested(numba.__version__) and not is_interpreted()


def is_interpreted() -> bool:
    """Return whether the kernels are run by the interpreter."""
    import numba  # noqa: PLC0415

    return bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


@contextlib.contextmanager
def announced(
    what: str, tell: Callable[[str], None], name: str = "complete", *folders: str
) -> Iterator[None]:
    """Tell what is compiled in the block, where this machine has not kept it yet.

    ``name`` is that of the mark that a block leaves which succeeds, for the kernels in folders of
    the package; of the core, where none is named.
    """
    if is_interpreted() or mark(name, *folders).exists():
        yield
        return
    tell(f"compiling {what} ...")
    with interruptible():
        yield
    keep(name, *folders)


@contextlib.contextmanager
def machine_code() -> Iterator[None]:
    """Import machine code inside the block, though the core is interpreted.

    It has to lie on this machine: what calls kernels of the interpreter cannot be compiled.
    """
    import numba  # noqa: PLC0415

    numba.config.DISABLE_JIT = False  # type: ignore[attr-defined]
    try:
        yield
    finally:
        do_without()


def await_code(given_up: threading.Event) -> bool:
    """Return whether everything has been compiled, once another process has done it or failed.

    It is waited for until that is ``given_up``.
    """
    complete, complaints = mark("complete"), cache_folder() / COMPLAINTS
    while not complete.exists():
        if given_up.wait(LOOK):
            return False
        with compiling() as free:
            failed = free and complaints.exists() and complaints.stat().st_size > 0
        if failed:
            return complete.exists()
    return True


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

    kept = signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    except Exception:
        if not pressed:
            raise
    finally:
        signal.signal(signal.SIGINT, kept)
    if pressed:
        raise KeyboardInterrupt


@contextlib.contextmanager
def compiling() -> Iterator[bool]:
    """Yield whether this process alone compiles into the cache now, inside the block."""
    with holding(cache_folder() / LOCK) as other:
        yield not other


def mark(name: str, *folders: str) -> Path:
    """Return the path of a mark for the kernels in folders, else in the core."""
    import numba  # noqa: PLC0415
    from llvmlite import binding  # type: ignore[import-untyped]  # noqa: PLC0415

    asked = [numba.__version__, sys.version, binding.get_host_cpu_name()]
    asked += [os.environ.get(f"NUMBA_CPU_{name}", "") for name in ("NAME", "FEATURES")]
    for path in sources(*(folders or ("core",))):
        status = path.stat()
        asked.append(f"{path} {status.st_mtime_ns} {status.st_size}")
    return cache_folder() / f"{name}-{hashlib.sha256(repr(asked).encode()).hexdigest()[:16]}"
