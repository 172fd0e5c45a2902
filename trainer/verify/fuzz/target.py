"""A fuzzing target is one reader of others' data, with examples to begin from."""

import functools
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.files import SHIPPED, reading_recorded, shipped, shipped_names

MEMORY: Final = Path("/dev/shm")  # noqa: S108  a file system in memory, where there is one
TABLE: Final = re.compile(r"^\[+([\w.-]+)\]", re.MULTILINE)
KINDS: Final = ("", "vessels", "hulls", "ships", "seas", "casualties", "exercises", "trials")


@dataclass(frozen=True)
class Target:
    """A reader under proof: ``take`` hands it bytes and lets pass what it may raise."""

    name: str
    says: str  # what it reads
    take: Callable[[bytes], None]
    seeds: Callable[[], list[bytes]]
    longest: int = 256  # [bytes] of an input
    spared: tuple[str, ...] = ("tomllib",)  # not watched: slow, and another target's or Python's


def text_of(data: bytes) -> str:
    """Return bytes as text, as the readers of files and lines get it."""
    return data.decode("utf-8", errors="replace")


@functools.cache
def folder() -> "tempfile.TemporaryDirectory[str]":
    """Return a folder of this process, for what has to be a file. It goes with the process."""
    where = MEMORY if os.access(MEMORY, os.W_OK) else None
    return tempfile.TemporaryDirectory(prefix="trainer-fuzz-", dir=where)


def write_file(name: str, data: bytes) -> Path:
    """Return a file of that name that holds ``data``."""
    path = Path(folder().name) / name
    path.write_bytes(data)
    return path


@functools.cache
def shipped_texts() -> dict[str, str]:
    """Return every shipped file by its key."""
    return {
        f"{SHIPPED}{kind}/{name}.toml".replace("//", "/"): shipped(kind, name).read_text("utf-8")
        for kind in KINDS
        for name in shipped_names(kind)
    }


@contextmanager
def only(name: str, text: str) -> Iterator[Path]:
    """Offer the shipped files and this one to read. Nothing else is opened."""
    with reading_recorded({**shipped_texts(), name: text}):
        yield Path(name)


def shipped_seeds(kind: str) -> list[bytes]:
    """Return the shipped files of a kind, without their comments."""
    begin = f"{SHIPPED}{kind}/"
    return [bare(text).encode() for key, text in shipped_texts().items() if key.startswith(begin)]


def bare(text: str) -> str:
    """Return a TOML text without empty lines and lines of comment."""
    lines = (line for line in text.split("\n") if line.strip() and not line.startswith("#"))
    return "".join(f"{line}\n" for line in lines)


def pieces(text: str) -> list[str]:
    """Return a TOML text cut up by tables. Each is with those inside it, the top first."""
    found = [""]
    head = ""  # the table that the last piece begins with
    for line in bare(text).splitlines():
        table = TABLE.match(line)
        if table and not (head and table[1].startswith(f"{head}.")):
            head = table[1]
            found.append("")
        found[-1] += f"{line}\n"
    return found
