"""A shared library from one object, by whatever C compiler there is."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

# what is not in the object is in nobody's: it would be missed when the library is loaded
STRICT = ["-Wl,-z,defs", "-s"] if sys.platform.startswith("linux") else []


class NoCompilerError(Exception):
    """There is no C compiler, or it cannot link; the text says what would."""


def link(code: Path, library: Path) -> None:
    """Link the object ``code`` into ``library``; NoCompilerError if that cannot be done here."""
    compiler = shlex.split(os.environ.get("CC") or "cc")
    words = [*compiler, "-shared", "-nostdlib", *STRICT, "-o", str(library), str(code)]
    if not shutil.which(compiler[0]):
        raise NoCompilerError(
            f"{library}: not made, there is no C compiler {compiler[0]!r} here (CC names another); "
            f"the object is whole: {' '.join(words)}"
        )
    done = subprocess.run(words, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        raise NoCompilerError(f"{library}: not made by {' '.join(words)}: {done.stderr.strip()}")
