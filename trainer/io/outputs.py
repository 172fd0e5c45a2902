"""What a command writes: no input is lost, and no file is half written.

Every output goes through ``replacing``, or through ``open_output`` where it grows while a run goes
on; both refuse what this process has read, by device and number on disk, so also by another name
or link. Readers tell their files to ``note_input``. The command line promises its outputs before it
reads or computes anything, so that a name that would cost an input is refused at once, whichever of
the two is named first. ``renewing`` is for what changes a file of its own that it has read.
"""

import contextlib
import errno
import os
import shutil
import stat
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

FILE_KINDS: Final = {  # what has an ending, also such as only somebody else writes
    ".trainer": "a recording",
    ".toml": "a file of settings",
    ".csv": "a table",
    ".parquet": "a Parquet table",
    ".rrd": "a file for Rerun",
    ".html": "a page",
    ".pdf": "a document",
    ".fmu": "a functional mock-up unit",
    ".png": "a picture",
    ".svg": "a picture",
    ".py": "a program",
    ".md": "a text",
    ".txt": "a text",
    ".rst": "a text",
    ".docx": "a text",
    ".odt": "a text",
    ".json": "a file of data",
    ".ipynb": "a notebook",
    ".xlsx": "a spreadsheet",
    ".ods": "a spreadsheet",
    ".zip": "an archive",
    ".jpg": "a picture",
}
FileId = tuple[int, int] | Path  # device and number on disk, or the path where no file is yet

_inputs: Final[dict[FileId, Path]] = {}  # what this process has read
_made: Final[dict[FileId, Path]] = {}  # what it has written itself: its own to read and write again
_promised: Final[dict[FileId, tuple[Path, str]]] = {}  # outputs to come, and who names each


class SameFileError(OSError):
    """An output that would cost an input or another output. ``strerror`` says what to do."""

    def __init__(self, path: Path, what_to_do: str) -> None:
        super().__init__(errno.EEXIST, what_to_do, str(path))

    def __str__(self) -> str:
        return f"{self.filename}: {self.strerror}"


def note_input(path: Path) -> None:
    """Remember a file as an input; SameFileError if an output to come would replace it."""
    key = _id_of(path)
    if isinstance(key, Path) or key is None or _made.get(key) == path.resolve():
        return
    if key in _promised and _id_of(_promised[key][0]) == key:  # else it is replaced already
        name = _promised[key][1]
        raise SameFileError(path, f"{name} would write over it; give {name} another name")
    _inputs[key] = path.absolute()


def refuse_input(path: Path) -> None:
    """Raise SameFileError if this process has read the file, under any name."""
    key = _id_of(path)
    # A number on disk is given again when its file is gone: so look whether it still has it.
    if key in _inputs and _id_of(_inputs[key]) == key:
        raise SameFileError(path, "is an input here; give another name")


@contextlib.contextmanager
def promising(path: Path, name: str) -> Iterator[None]:
    """Say that ``name``, such as --csv, will write a file inside the block.

    SameFileError if that is an input, or another's output. A pipe, device or folder is neither.
    """
    refuse_input(path)
    key = _id_of(path)
    if key in _promised:
        raise SameFileError(path, f"{_promised[key][1]} writes this file; give another name")
    if key is None:
        yield
        return
    _promised[key] = path.absolute(), name
    try:
        yield
    finally:
        del _promised[key]


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield where to write an output; at the block's good end it becomes ``path``.

    A pipe or device is written directly, and so is a file in a folder where no new file can be
    made. A symbolic link stays; the file that it points to is replaced. OSError, and nothing is
    changed, if it is an input.
    """
    refuse_input(path)
    with renewing(path) as made:
        yield made
    _keep_as_made(path)


@contextlib.contextmanager
def renewing(path: Path) -> Iterator[Path]:
    """Do as ``replacing`` for the program's own file, or one that is changed."""
    goal = path.resolve()
    alone = path.is_file() and not os.access(goal.parent, os.W_OK)
    if alone or (path.exists() and not path.is_file()):
        yield path
        return
    with tempfile.TemporaryDirectory(dir=goal.parent, prefix=f".{goal.name[:40]}.") as folder:
        made = Path(folder) / goal.name
        yield made
        if goal.exists():
            shutil.copymode(goal, made)
        # On the disk first: else lost power could leave the new name with no content.
        with made.open("rb") as file:
            os.fsync(file.fileno())
        made.replace(goal)


def open_output(path: Path) -> BinaryIO:
    """Return an output that grows while a run goes on, empty and unbuffered. OSError."""
    refuse_input(path)
    file: BinaryIO = path.open("wb", buffering=0)
    _keep_as_made(path)
    return file


def open_new(path: Path) -> BinaryIO:
    """Return a new file, unbuffered; FileExistsError if there is one. OSError."""
    file: BinaryIO = path.open("xb", buffering=0)
    _keep_as_made(path)
    return file


def write_whole(path: Path, content: str | bytes) -> None:
    """Write an output, or leave what was there. OSError if it cannot be written.

    A file of settings takes the place of its own kind alone: another may be somebody's work.
    """
    if path.suffix == ".toml" and path.is_file() and (other := _other_than(path, str(content))):
        raise SameFileError(path, f"{other} is there; give another name")
    with replacing(path) as made:
        made.write_bytes(content.encode() if isinstance(content, str) else content)


def _other_than(path: Path, text: str) -> str:
    """Return what a file of settings is where it is no earlier output like a text, else ""."""
    try:
        before, now = tomllib.loads(path.read_text("utf-8")), tomllib.loads(text)
    except (ValueError, RecursionError):  # what cannot be read was made by somebody else
        return "a file of another kind"
    if any(before.get(key) != now.get(key) for key in ("schema", "kind")):
        return "a file of another kind"
    # all exercises that a command writes tell their crew the same
    return "" if before.get("briefing") == now.get("briefing") else "an exercise of your own"


def renew_whole(path: Path, text: str) -> None:
    """Write a text over a file of the program's own, whole. OSError."""
    with renewing(path) as made:
        made.write_text(text, encoding="utf-8", newline="\n")


def _id_of(path: Path) -> FileId | None:
    """Return what tells a file from all others, None for what is no file or cannot be looked at."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return path.resolve()
    except (OSError, ValueError):  # ValueError: a NUL character in the path
        return None
    return (status.st_dev, status.st_ino) if stat.S_ISREG(status.st_mode) else None


def _keep_as_made(path: Path) -> None:
    """Remember a file that this process has just written."""
    key = _id_of(path)
    if key is not None:
        _made[key] = path.resolve()
        _inputs.pop(key, None)
