"""The first fit of a version: interpreted at once, while another process compiles.

Compiling the kernels takes up to a minute, a fit by the interpreter two to five seconds. Whichever
process comes first has the say: the interpreted fit its answer, or the compiler, and then the fit
is begun anew with machine code. The numbers are the same, to rounding. It is decided before a
kernel is imported.
"""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from typing import Final

from trainer import compilation
from trainer.machine_code import cache_folder, cache_lasts

KERNELS: Final = "identify/kernels"
LOOK: Final = 0.05  # [s] between looks at the two


def kept() -> bool:
    """Return whether the kernels of a fit have been compiled on this machine before."""
    return compilation.mark("fits", KERNELS).exists()


def keep() -> None:
    """Note that the kernels of a fit have been compiled; nothing where that cannot be."""
    with contextlib.suppress(OSError):
        compilation.mark("fits", KERNELS).touch()


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Let one process at a time compile; the others wait for it."""
    import fcntl  # noqa: PLC0415  not everywhere

    with (cache_folder() / "compiling-fits").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def wanted() -> bool:
    """Return whether a fit is to begin by the interpreter."""
    if os.name != "posix" or compilation.settled() or compilation.done_without():
        return False
    return not kept() and cache_lasts()


def raced(words: Sequence[str]) -> int | None:
    """Return the exit code of ``trainer`` with these words, if it ends before the compiler does.

    None where the machine code is there now, and nothing has been said.
    """
    compiler = subprocess.Popen(
        [sys.executable, "-m", "trainer.identify.compiling"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # it goes on when this process is done, and ends by itself
    )
    with subprocess.Popen(  # noqa: S603  our own program
        [sys.executable, "-m", "trainer", *words],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        stdout=subprocess.PIPE,
    ) as fit:
        told = _answer(fit, compiler)
    if told is not None:
        sys.stdout.write(told)
        sys.stdout.flush()
        return fit.returncode
    return None


def _answer(fit: "subprocess.Popen[bytes]", compiler: "subprocess.Popen[bytes]") -> str | None:
    """Return what the interpreted fit prints; None, and it is ended, if the compiler is first."""
    while True:
        try:
            return fit.communicate(timeout=LOOK)[0].decode()
        except subprocess.TimeoutExpired:
            if compiler.poll() is not None or kept():
                fit.terminate()
                fit.communicate()
                return None
