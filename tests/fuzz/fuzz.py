"""Fuzzing gives each target a million inputs. It keeps those that found a new path.

Each target is fuzzed by atheris in processes of its own; what is read here is what they tell.
"""

import functools
import hashlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from helpers.places import tests_environment

from trainer.config.files import (
    SHIPPED_PREFIX,
    ConfigError,
    reading_recorded,
    shipped_names,
    shipped_path,
)

MEMORY: Final = Path("/dev/shm")  # noqa: S108  a file system in memory, where there is one
TABLE: Final = re.compile(r"^\[+([\w.-]+)\]", re.MULTILINE)
KINDS: Final = (
    "",
    "vessels",
    "hulls",
    "ships",
    "seas",
    "casualties",
    "exercises",
    "trials",
    "check-cases",
)


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
        f"{SHIPPED_PREFIX}{kind}/{name}.toml".replace("//", "/"): shipped_path(
            kind, name
        ).read_text("utf-8")
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
    begin = f"{SHIPPED_PREFIX}{kind}/"
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


SLOWEST: Final = 20  # [s] for one input; a reader that takes longer hangs
MOST_MEMORY: Final = 2000  # [MB]
DONE: Final = re.compile(r"^#(\d+)\s.*?cov: (\d+) .*?corp: (\d+)")
COUNT: Final = re.compile(r"^#(\d+)\s")
SAVED: Final = re.compile(r"Test unit written to (.+)")
FAILED: Final = re.compile(r"(?:=+ Uncaught Python exception: =+|ERROR: libFuzzer: .+)")
ROUND: Final = 1_000_000  # [inputs] of one process
MOST_SEED: Final = 2**31 - 1
TOLD: Final = 40  # [lines] of a failure that are kept


@dataclass(frozen=True)
class Effort:
    """How much is to be done for each target."""

    inputs: int  # with those of earlier runs that kept theirs in the same folder
    seconds: int  # at most, 0 for as long as it takes
    seed: int


@dataclass
class Found:
    """The result of fuzzing one target."""

    target: str
    says: str
    inputs: int = 0  # those of earlier runs among them
    earlier: int = 0
    paths: int = 0  # edges of its readers that were reached
    kept: int = 0  # inputs in its corpus
    seconds: float = 0.0  # of this run
    failure: str = ""  # what was raised that is not declared, or how the process ended
    saved: str = ""  # the input that did it


Progress = Callable[[str, int], None]  # takes a target's name and the inputs done


def fuzz(
    targets: list[Target], folder: Path, effort: Effort, jobs: int, progress: Progress
) -> Iterator[Found]:
    """Yield what came of each target, so many at a time. ConfigError if atheris is missing.

    A target that was interrupted goes on from the inputs that ``folder`` says it has had.
    """
    if find_spec("atheris") is None:
        raise ConfigError("tests.fuzz needs atheris: pip install --group fuzz (pip 25.1 or newer)")
    with ThreadPoolExecutor(jobs) as pool:
        yield from pool.map(lambda target: _fuzz(target, folder, effort, progress), targets)


def _fuzz(target: Target, folder: Path, effort: Effort, progress: Progress) -> Found:
    """Fuzz one target, a process after the other, to its end or its first failure."""
    kept = folder / target.name
    seeds = target.seeds()
    _plant(kept, seeds)
    (folder / f"{target.name}.words").write_text(dictionary(seeds), encoding="ascii")
    tally = Tally(folder / f"{target.name}.inputs")
    had = tally.read()
    found = Found(target.name, target.says, had, had)
    begun = time.monotonic()
    while not found.failure and found.inputs < effort.inputs:
        spent = int(time.monotonic() - begun)
        if effort.seconds and spent >= effort.seconds:
            break
        left = max(effort.seconds - spent, 0)  # 0: no end
        runs = min(effort.inputs - found.inputs, ROUND)
        seed = (effort.seed + found.inputs) % MOST_SEED + 1
        options = (f"-runs={runs}", f"-max_total_time={left}", f"-seed={seed}")
        run_round(_command(target, folder, options), found, tally, progress)
    found.seconds = time.monotonic() - begun
    found.kept = sum(1 for _ in kept.iterdir())
    return found


def _command(target: Target, folder: Path, options: tuple[str, ...]) -> list[str]:
    """Return what fuzzes a target in a process of its own."""
    return [
        *(sys.executable, "-m", "fuzz.child", target.name),
        ",".join(target.spared),
        *options,
        *(f"-max_len={target.longest}", f"-dict={folder}/{target.name}.words"),
        *(f"-timeout={SLOWEST}", f"-rss_limit_mb={MOST_MEMORY}"),
        *(f"-artifact_prefix={folder}/{target.name}-", str(folder / target.name)),
    ]


class Tally:
    """The inputs that a target has had, in a small file. Another run goes on from there."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> int:
        """Return the inputs had; ConfigError if the file holds no number."""
        try:
            return int(self._path.read_text(encoding="ascii"))
        except FileNotFoundError:
            return 0
        except ValueError:
            raise ConfigError(
                f"{self._path}: must hold a number; remove it to begin at 0"
            ) from None

    def write(self, inputs: int) -> None:
        """Keep the number."""
        self._path.write_text(f"{inputs}\n", encoding="ascii")


def run_round(command: list[str], found: Found, tally: Tally, progress: Progress) -> None:
    """Run one process of the fuzzer and take what it tells into ``found``."""
    before = found.inputs

    def count(inputs: int) -> None:
        found.inputs = before + inputs
        tally.write(found.inputs)
        progress(found.target, found.inputs)

    with subprocess.Popen(
        command,
        env=tests_environment(),
        stdout=subprocess.PIPE,  # where atheris tells of an exception
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    ) as child:
        told = listen(child.stdout or (), found, count)
    if child.returncode and not found.failure:
        found.failure = "\n".join([*told[-TOLD:], describe_end(child.returncode)])
    if not child.returncode and found.inputs == before:
        found.failure = "\n".join([*told[-TOLD:], "it ended without an input"])


def describe_end(code: int) -> str:
    """Return in words how a process ended."""
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"


def listen(lines: Iterable[str], found: Found, count: Callable[[int], None]) -> list[str]:
    """Take what the fuzzer tells to its end; return the last of it."""
    told: list[str] = []
    failing: list[str] = []
    for line in lines:
        if counted := COUNT.match(line):
            count(int(counted[1]))
        if done := DONE.match(line):
            found.paths = int(done[2])
        if saved := SAVED.search(line):
            found.saved = saved[1].strip()
        if failing or FAILED.search(line):
            failing.append(line.rstrip())
        told = [*told[-TOLD:], line.rstrip()]
    found.failure = "\n".join(failing[:TOLD])
    return told


def _plant(folder: Path, seeds: list[bytes]) -> None:
    """Put the seeds among the inputs kept."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed in seeds:
        (folder / hashlib.sha1(seed, usedforsecurity=False).hexdigest()).write_bytes(seed)


def dictionary(seeds: list[bytes]) -> str:
    """Return the words of the seeds as a fuzzer's dictionary."""
    words = {word for seed in seeds for word in re.findall(rb"[A-Za-z_][\w-]{1,30}", seed)}
    return "".join(f'"{word.decode("ascii")}"\n' for word in sorted(words or {b"0"}))
