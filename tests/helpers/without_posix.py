"""A system that is not POSIX, as far as the trainer's own modules can see. Run what is given.

python tests/helpers/without_posix.py FILE [WORD]...
"""

import contextlib
import importlib
import importlib.abc
import importlib.util
import os
import runpy
import socket
import sys
from pathlib import Path
from types import ModuleType

LACKING = ("fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty")
FOUND = importlib.util.find_spec("trainer")
assert FOUND
assert FOUND.origin
OURS = str(Path(FOUND.origin).parent)


class Lacking(importlib.abc.MetaPathFinder):
    """Say that there is no such module, to modules of the trainer; others have their own ways."""

    def find_spec(self, name: str, _path: object = None, _target: ModuleType | None = None) -> None:
        """Raise what the import of a module that is not there raises."""
        if name in LACKING and OURS in importer():
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def importer() -> str:
    """Return the file of the module that imports."""
    frame = sys._getframe(2)  # noqa: SLF001  there is no other way to it
    while frame.f_back and ("importlib" in frame.f_code.co_filename):
        frame = frame.f_back
    return frame.f_code.co_filename


def lack() -> None:
    """Take away what only POSIX has."""
    with contextlib.suppress(ImportError):
        importlib.import_module("psutil")  # by rerun; the one for Linux knows local sockets
    for name in LACKING:
        sys.modules.pop(name, None)
    sys.meta_path.insert(0, Lacking())
    pair, local = socket.socketpair, socket.AF_UNIX
    # elsewhere Python makes a pair of another kind, which it does not here
    socket.socketpair = lambda *_: pair(local)
    for module, name in ((socket, "AF_UNIX"), (os, "fork"), (os, "setsid"), (os, "pread")):
        delattr(module, name)


if __name__ == "__main__":
    lack()
    sys.argv = sys.argv[1:]
    here = str(Path(__file__).parent)
    sys.path[:] = [each for each in sys.path if each != here]
    runpy.run_path(sys.argv[0], run_name="__main__")
