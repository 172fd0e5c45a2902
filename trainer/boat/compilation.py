"""Whether the core is compiled or interpreted, and what machine code is cached.

The first start of a version may fly by the interpreter while another process compiles
(``session/first_start`` decides that); these functions let the two agree through files. A cache
folder holds a mark once all that a run needs has been compiled into it. The mark is named by what
numba asks before it gives machine code back, so that it speaks for this Python, this numba, this
processor and these files only.
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

KERNEL_MODULE: Final = "trainer.core.kernel"  # once it is imported, how kernels run is settled
LOCK_NAME: Final = "compiling"
POLL_PERIOD_S: Final = 0.5  # [s] between looks at whether that is done
ERROR_LOG_NAME: Final = "compiling.log"  # of a compilation beside a run; gone when it succeeds
PROGRESS_NAME: Final = "compiling.percent"  # of the tick alone; gone when all is done
MAX_RESTARTS: Final = 3  # of a compilation beside a run that died without a word
_IMPORT_LOCK: Final = threading.Lock()  # numba's switch is one for all threads
_importing_threads: Final[set[int]] = set()  # those for which it is on at present


def is_kept() -> bool:
    """Return whether everything that a run needs has been compiled on this machine before."""
    return mark_path("complete").exists()


def is_tick_kept() -> bool:
    """Return whether the tick alone has been compiled: a boat at sea needs nothing else."""
    # the tick is compiled first and the rest after it, so that the second mark speaks for both
    return mark_path("tick").exists() or is_kept()


def mark_compiled(name: str = "complete", *folders: str) -> None:
    """Mark that all a run needs is compiled, where a file can be written."""
    with contextlib.suppress(OSError):
        mark_path(name, *folders).touch()


def is_settled() -> bool:
    """Return whether it is too late to choose between machine code and none."""
    return KERNEL_MODULE in sys.modules


def use_interpreter() -> None:
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
    """Return whether the kernels are run by the interpreter.

    They are in all other threads while one imports machine code.
    """
    import numba  # noqa: PLC0415

    elsewhere = _importing_threads - {threading.get_ident()}
    return bool(elsewhere or numba.config.DISABLE_JIT)  # type: ignore[attr-defined]


@contextlib.contextmanager
def announce_compiling(
    what: str, tell: Callable[[str], None], name: str = "complete", *folders: str
) -> Iterator[None]:
    """Announce what the block compiles, unless this machine's cache has it.

    A block that succeeds leaves the mark ``name``. It speaks for the kernels in ``folders`` of the
    package, or for those of the core where none is named.
    """
    if is_interpreted() or mark_path(name, *folders).exists():
        yield
        return
    tell(f"compiling {what} ...")
    with interruptible():
        yield
    mark_compiled(name, *folders)


@contextlib.contextmanager
def machine_code() -> Iterator[None]:
    """Import machine code inside the block, though the core is interpreted.

    The cache must have that code already, because code that calls kernels of the interpreter cannot
    be compiled. For all other threads the core stays interpreted.
    """
    import numba  # noqa: PLC0415

    with _IMPORT_LOCK:
        _importing_threads.add(threading.get_ident())
        numba.config.DISABLE_JIT = False  # type: ignore[attr-defined]
        try:
            yield
        finally:
            use_interpreter()
            _importing_threads.clear()


def await_tick(
    given_up: threading.Event, tell: Callable[[int], None], begin_again: Callable[[], object]
) -> bool:
    """Return whether the tick has been compiled, once another process has done it or failed.

    The wait ends when ``given_up`` is set. ``tell`` has the progress [%] as it grows. A process
    that died is begun again; one that failed and said why is not (docs/timing.md).
    """
    restarts = 0
    furthest = -1
    while not is_tick_kept():
        if given_up.wait(POLL_PERIOD_S):
            return False
        if tick_progress() > furthest:
            furthest = tick_progress()
            tell(furthest)
        with compilation_lock() as free:
            # a process holds the lock until it ends: free, and no mark, means that it died
            died = free and not is_tick_kept()
        if died and (has_complained() or restarts == MAX_RESTARTS):
            return False
        if died:
            restarts += 1
            begin_again()
    tell(100)
    return True


def has_complained() -> bool:
    """Return whether compiling beside a run has failed, and has said why."""
    path = cache_folder() / ERROR_LOG_NAME
    return path.exists() and path.stat().st_size > 0


def tick_progress() -> int:
    """Return how much of the tick has been compiled [%]."""
    try:
        return min(int((cache_folder() / PROGRESS_NAME).read_text(encoding="ascii") or 0), 100)
    except (OSError, ValueError):
        return 0


def write_progress(percent: int) -> None:
    """Note how much of the tick has been compiled [%]."""
    with contextlib.suppress(OSError):
        (cache_folder() / PROGRESS_NAME).write_text(f"{percent}", encoding="ascii")


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


@contextlib.contextmanager
def compilation_lock() -> Iterator[int | None]:
    """Yield the lock of whoever alone compiles into the cache, inside the block; else None.

    A process that inherits the lock holds it until it ends, however it ends.
    """
    import fcntl  # noqa: PLC0415  not everywhere

    with (cache_folder() / LOCK_NAME).open("wb") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield None
        else:
            yield lock.fileno()


def mark_path(name: str, *folders: str) -> Path:
    """Return the path of a mark for the kernels in folders, else in the core."""
    import numba  # noqa: PLC0415
    from llvmlite import binding  # type: ignore[import-untyped]  # noqa: PLC0415

    facts = [numba.__version__, sys.version, binding.get_host_cpu_name()]
    facts += [os.environ.get(f"NUMBA_CPU_{name}", "") for name in ("NAME", "FEATURES")]
    # numba asks a kernel's own file only; a mark speaks for all files (docs/architecture.md)
    for path in sources(*(folders or ("core",))):
        status = path.stat()
        facts.append(f"{path} {status.st_mtime_ns} {status.st_size}")
    return cache_folder() / f"{name}-{hashlib.sha256(repr(facts).encode()).hexdigest()[:16]}"
