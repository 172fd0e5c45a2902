"""Writing a user's file so that it is replaced whole, or stays as it was.

Whoever writes a file for a user calls it. The new text goes to a temporary file beside it, which
then takes the name of the old one in one step of the system. So a full disk or a killed program
leaves no half of a file.
"""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield where to write; at the block's good end it becomes ``path``.

    A pipe or device is written directly, and so is a file in a folder where no new file can be
    made. A symbolic link stays; the file that it points to is replaced.
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
        # On the disk first: else lost power could leave the new name with no content.
        with made.open("rb") as file:
            os.fsync(file.fileno())
        made.replace(goal)


def write_whole(path: Path, text: str) -> None:
    """Write a text over a file, or leave that as it was. OSError if it cannot be written."""
    with replacing(path) as made:
        made.write_text(text, encoding="utf-8", newline="\n")
