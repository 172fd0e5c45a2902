"""A user's file is replaced at once and whole, or stays as it was."""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield where to write a file. It has the name ``path`` once the block has ended well.

    What is no file, such as a pipe, or lies where no other can be made, is written as it is. A
    link stays one: its file is replaced.
    """
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
        with made.open("rb") as file:
            os.fsync(file.fileno())
        made.replace(goal)


def write_whole(path: Path, text: str) -> None:
    """Write a text over a file, or leave that as it was. OSError if it cannot be written."""
    with replacing(path) as made:
        made.write_text(text, encoding="utf-8", newline="\n")
