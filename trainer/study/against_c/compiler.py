"""The plain C tick compiled by whatever C compiler there is, and loaded."""

import ctypes
import os
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from trainer.exported.linking import NoCompilerError
from trainer.fitout import Records
from trainer.study.against_c.header import header

SOURCES: Final = Path(__file__).parent
COMMON: Final = ("-std=gnu11", "-fPIC", "-shared")

Ticks = Callable[[Records, int], int]  # so many ticks of a boat; the status of the last


class Build(NamedTuple):
    """One way to compile it."""

    name: str
    flags: tuple[str, ...]


# gcc 12 fuses a product and a sum in pairs that it finds by SLP, also where it is told not to
STRICT: Final = ("-O3", "-march=native", "-ffp-contract=off", "-fno-tree-slp-vectorize")
BUILDS: Final = (
    Build("gcc -O3", ("-O3",)),
    Build("strict, for this processor", STRICT),
    Build("contracted, for this processor", ("-O3", "-march=native", "-ffp-contract=fast")),
)
SAME_BITS: Final = BUILDS[:2]  # the third is another arithmetic


def compiler() -> list[str]:
    """Return the C compiler's command, CC or gcc or cc; NoCompilerError without one."""
    asked = os.environ.get("CC")
    for command in [asked] if asked else ["gcc", "cc"]:
        words = shlex.split(command)
        if words and shutil.which(words[0]):
            return words
    named = f"CC is {asked!r}, which is not here" if asked else "neither gcc nor cc is here"
    raise NoCompilerError(f"no C was compiled: {named}; install one, or name it by CC")


def version() -> str:
    """Return what the compiler calls itself."""
    done = subprocess.run(  # noqa: S603
        [*compiler(), "--version"], capture_output=True, text=True, check=False
    )
    return done.stdout.partition("\n")[0] or compiler()[0]


def compiled(source: Path, flags: Sequence[str]) -> ctypes.CDLL:
    """Return ``source`` compiled and loaded; NoCompilerError if that cannot be done."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        library = Path(folder) / "compiled.so"
        words = [*compiler(), *COMMON, *flags, str(source), "-o", str(library), "-lm"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
        if done.returncode != 0:
            raise NoCompilerError(f"{source.name} was not compiled: {done.stderr.strip()}")
        return ctypes.CDLL(str(library))  # which stays when its file goes


def build(way: Build) -> Ticks:
    """Return the tick in C, compiled and loaded; NoCompilerError if that cannot be done."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        (Path(folder) / "records.h").write_text(header(), encoding="ascii")
        take_ticks = compiled(SOURCES / "tick.c", [*way.flags, f"-I{folder}"]).take_ticks
    address, number = ctypes.c_void_p, ctypes.c_int64
    take_ticks.argtypes = [address, address, address, number, address, address]
    take_ticks.restype = number

    def ticks(records: Records, count: int) -> int:
        vessel, compact, scheme, state, scratch = (each.ctypes.data for each in records)
        return int(take_ticks(vessel, compact, scheme, count, state, scratch))

    return ticks
