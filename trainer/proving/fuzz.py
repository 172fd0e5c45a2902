"""Fuzzing: a million inputs for each reader, those kept that found a new path through it.

Each target is fuzzed by atheris in processes of its own; what is read here is what they tell.
"""

import hashlib
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from trainer.config import ConfigError
from trainer.proving.target import Target

MISSING: Final = "fuzzing needs atheris: pip install 'submarine-trainer[fuzz]'"
SLOWEST: Final = 20  # [s] for one input; a reader that takes longer hangs
MOST_MEMORY: Final = 2000  # [MB]
SHORTEST: Final = 256  # [bytes] of an input at most, or four of its longest seed
LONGEST: Final = 20_000  # [bytes]
DONE: Final = re.compile(r"^#(\d+)\s.*?cov: (\d+) .*?corp: (\d+)")
COUNT: Final = re.compile(r"^#(\d+)\s")
SAVED: Final = re.compile(r"Test unit written to (.+)")
FAILED: Final = re.compile(r"(?:=+ Uncaught Python exception: =+|ERROR: libFuzzer: .+)")
TOLD: Final = 40  # [lines] of a failure that are kept


@dataclass(frozen=True)
class Effort:
    """How much is to be done for each target."""

    inputs: int
    seconds: int  # at most, 0 for as long as it takes
    seed: int


@dataclass
class Found:
    """What came of fuzzing one target."""

    target: str
    says: str
    inputs: int = 0
    paths: int = 0  # edges of its readers that were reached
    kept: int = 0  # inputs in its corpus
    seconds: float = 0.0
    failure: str = ""  # what was raised that is not declared
    saved: str = ""  # the input that did it


Progress = Callable[[str, int], None]  # takes a target's name and the inputs done


def fuzz(
    targets: list[Target], folder: Path, effort: Effort, jobs: int, progress: Progress
) -> Iterator[Found]:
    """Yield what came of each target, so many at a time; ConfigError if atheris is missing."""
    if find_spec("atheris") is None:
        raise ConfigError(MISSING)
    for target in targets:
        _warm(target)
    with ThreadPoolExecutor(jobs) as pool:
        yield from pool.map(lambda target: _fuzz(target, folder, effort, progress), targets)


def _warm(target: Target) -> None:
    """Let all that a target computes with be compiled and kept: it cannot be while watched."""
    for seed in target.seeds():
        target.take(seed)


def _fuzz(target: Target, folder: Path, effort: Effort, progress: Progress) -> Found:
    """Fuzz one target in a process of its own."""
    kept = folder / target.name
    seeds = target.seeds()
    _plant(kept, seeds)
    words = folder / f"{target.name}.words"
    words.write_text(dictionary(seeds), encoding="ascii")
    longest = min(max(4 * max(map(len, seeds)), SHORTEST), LONGEST)
    command = [
        *(sys.executable, "-m", "trainer.proving.fuzz_child", target.name),
        *(f"-runs={effort.inputs}", f"-max_total_time={effort.seconds}", f"-seed={effort.seed}"),
        *(f"-max_len={longest}", f"-dict={words}", f"-timeout={SLOWEST}"),
        *(f"-rss_limit_mb={MOST_MEMORY}", f"-artifact_prefix={folder}/{target.name}-", str(kept)),
    ]
    found = Found(target.name, target.says)
    begun = time.monotonic()
    with subprocess.Popen(  # noqa: S603  our own program
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
    ) as child:
        told = _listen(child, found, progress)
    found.seconds = time.monotonic() - begun
    found.kept = sum(1 for _ in kept.iterdir())
    if child.returncode and not found.failure:
        found.failure = "\n".join(told[-TOLD:]) or f"exit code {child.returncode}"
    return found


def _listen(child: "subprocess.Popen[str]", found: Found, progress: Progress) -> list[str]:
    """Take what the fuzzer tells to its end; return the last of it."""
    told: list[str] = []
    failing: list[str] = []
    for line in child.stderr or ():
        if count := COUNT.match(line):
            found.inputs = int(count[1])
            progress(found.target, found.inputs)
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
    words = sorted({word for seed in seeds for word in re.findall(rb"[A-Za-z_][\w-]{1,30}", seed)})
    return "".join(f'"{word.decode("ascii")}"\n' for word in words)
