"""A script goes on from one point in children, which have all of its memory.

SQLite forbids connections in children, because the file changes under the parent's, and because
locks are a process's own (sqlite.org/howtocorrupt.html, 2.6). Here the parent stands still as long
as its child plays. Then the files are put back, the same bytes in the same inodes: what it has open
or mapped is what it was. It lets go of its locks, as POSIX does when any descriptor of a file is
closed: the connections of one process know of each other without them.
"""

import contextlib
import gc
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

FAILED: Final = 1  # exit code of a child that could not tell anything
_pens: list[int] = []  # by which this process tells its parent, after those of the parents


class ChildError(Exception):
    """A child has failed, and told why."""


class Shelf:
    """The files of the present folder as they are now."""

    def __init__(self) -> None:
        self._folder = Path.cwd()
        self._links = Path(tempfile.mkdtemp(prefix="trainer-f-", dir=self._folder.parent))
        self._kept: dict[Path, tuple[Path, bytes]] = {}
        self._all = set(self._folder.rglob("*"))
        for number, path in enumerate(path for path in self._all if path.is_file()):
            link = self._links / str(number)
            link.hardlink_to(path)
            self._kept[path] = link, path.read_bytes()

    def put_back(self) -> None:
        """Put back each file under its inode; take away what has come."""
        for path in sorted(self._folder.rglob("*"), reverse=True):
            if path.is_dir():
                if path not in self._all:
                    path.rmdir()
            elif path not in self._kept or not path.samefile(self._kept[path][0]):
                path.unlink()
        for path, (link, data) in self._kept.items():
            if not path.exists():
                path.hardlink_to(link)
            with path.open("r+b") as file:
                file.write(data)
                file.truncate()
        shutil.rmtree(self._links)


@contextlib.contextmanager
def garbage_kept() -> Iterator[None]:
    """Collect no garbage inside the block. A connection in it would take its file along."""
    gc.disable()
    yield
    gc.enable()


def fork() -> bytes | None:
    """Begin a child here. Return what it has told when it has ended, None in the child itself."""
    with garbage_kept():
        shelf = Shelf()
    ear, pen = os.pipe()
    child = os.fork()
    if not child:
        os.close(ear)
        _pens.append(pen)
        return None
    os.close(pen)
    with os.fdopen(ear, "rb") as told:
        text = told.read()
    _, status = os.waitpid(child, 0)
    if status:
        raise ChildError(text.decode(errors="replace") or f"it ended with {status}")
    shelf.put_back()
    return text


def end_child(text: bytes, code: int = 0) -> None:
    """Tell the parent something, and end this process without any farewell."""
    with os.fdopen(_pens[-1], "wb") as told:
        told.write(text)
    os._exit(code)
