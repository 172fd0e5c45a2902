"""One fault after the other is tried in a copy of the tree."""

import contextlib
import importlib.util
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

from helpers.places import ROOT

from mutation.places import ROOMS, Place, files_of, places_in, with_fault_at

TOLD_PATH: Final = Path(__file__).with_name("equivalent.toml")
LEFT_OUT: Final = (".*", "__pycache__", "site", "node_modules", "*.egg-info", "build", "dist")
HUNT_TIME_S: Final = 180.0  # after which sessions hang
TESTS_TIME_S: Final = 900.0  # after which the tests of a room hang
NEAR_TESTS_TIME_S: Final = 120.0  # likewise, of few files
NO_TESTS_CODE: Final = 5  # of pytest, where it was given none to run
MAX_NEAR_FILES: Final = 3  # of tests, that are asked where few are
CANDIDATES: Final = 8  # places that are drawn for each one that sessions execute
TEST_OPTIONS: Final = (
    *("-q", "-x", "--tb=no", "-p", "no:cacheprovider"),
    *("-m", "not process and not slow and not long and not alone"),
)


class NotGreenError(Exception):
    """Something fails without any fault, so it says nothing of faults."""


class Told(NamedTuple):
    """A fault that changes nothing which anybody can see."""

    file: str
    function: str
    before: str
    after: str
    why: str


@dataclass(frozen=True)
class Trial:
    """What came of one fault."""

    file: str
    line: int
    function: str
    kind: str
    before: str
    after: str
    sessions: str  # what seeds were the first to see, "" for nothing
    tests: str  # the first test of its room that fails, "" for none or where sessions saw it
    equivalent: str  # why it changes nothing, "" where nobody has said so

    @property
    def unfound(self) -> bool:
        """Return whether nothing finds it, and nobody has said that it changes nothing."""
        return not (self.sessions or self.tests or self.equivalent)


class Drawn(NamedTuple):
    """The places of a draw, and among how many."""

    chosen: list[Place]
    executed: int  # of these places those on lines that sessions execute
    places: int  # that were drawn


@dataclass
class Copy:
    """A copy of the tree, with one fault at a time."""

    root: Path

    @contextlib.contextmanager
    def faulty(self, place: Place) -> Iterator[None]:
        """Have a fault in the copy inside the block."""
        path = self.root / place.file
        source = path.read_bytes()
        self._write(path, with_fault_at(source, place))
        try:
            yield
        finally:
            self._write(path, source)

    def lines(self, seeds: int, seconds: float, files: Iterable[str]) -> dict[str, set[int]]:
        """Return the lines of some modules that whole sessions execute.

        NotGreenError where they see something without a fault.
        """
        paths = {str(self.root / file): file for file in files}
        done = self._run("mutation.child", "lines", str(seeds), str(seconds), *paths)
        if done.returncode:
            raise NotGreenError(one_line(done.stderr.strip().rpartition("\n")[2]))
        executed, seen = json.loads(done.stdout)
        if seen:
            raise NotGreenError(one_line(seen))
        return {paths[path]: set(lines) for path, lines in executed.items()}

    def hunt(self, seeds: int, seconds: float) -> str:
        """Return what sessions are the first to see, "" for nothing."""
        words = ("mutation.child", "hunt", str(seeds), str(seconds))
        try:
            done = self._run(*words, timeout=HUNT_TIME_S)
        except subprocess.TimeoutExpired:
            return "hangs"
        if done.returncode:
            return one_line(done.stderr.strip().rpartition("\n")[2]) or "ends"
        found: str = json.loads(done.stdout.strip().rpartition("\n")[2])
        return one_line(found)

    def test(self, *paths: str, timeout: float = TESTS_TIME_S) -> str:
        """Return the first quick test of some files that fails in time [s], "" for none."""
        try:
            done = self._run("pytest", *TEST_OPTIONS, *paths, timeout=timeout)
        except subprocess.TimeoutExpired:
            return "hangs"
        if done.returncode in (0, NO_TESTS_CODE):
            return ""
        failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
        if not failed:
            return f"exit code {done.returncode}"
        return failed[0].partition(" ")[2].partition(" - ")[0]

    def check_green(self, test: str) -> None:
        """Raise NotGreenError where a test fails without a fault too."""
        if "::" in test and self._run("pytest", *TEST_OPTIONS, test).returncode:
            raise NotGreenError(test)

    def _write(self, path: Path, source: bytes) -> None:
        path.write_bytes(source)
        # it has the same second and perhaps the same length, by which stale bytecode would be taken
        Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)

    def _run(self, *words: str, timeout: float | None = None) -> subprocess.CompletedProcess[str]:
        """Run a module on the copy; TimeoutExpired where it lasts longer [s]."""
        paths = os.pathsep.join((str(self.root), str(self.root / "tests")))
        with subprocess.Popen(
            [sys.executable, "-m", *words],
            cwd=self.root,
            env=os.environ | {"PYTHONPATH": paths},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as process:
            try:
                out, errors = process.communicate(timeout=timeout)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)  # and what its tests have begun
                raise
        return subprocess.CompletedProcess(words, process.returncode, out, errors)


@contextlib.contextmanager
def copied_tree() -> Iterator[Copy]:
    """Copy the tree for the time of the block."""
    with tempfile.TemporaryDirectory(prefix="trainer-mutants-") as folder:
        root = Path(folder) / "tree"
        shutil.copytree(ROOT, root, ignore=shutil.ignore_patterns(*LEFT_OUT))
        yield Copy(root)


def draw(copy: Copy, count: int, seed: str, seeds: int, seconds: float) -> Drawn:
    """Draw places on lines that sessions execute, each as likely as any other.

    More are drawn than are wanted, and sessions are looked at in the modules of these alone.
    """
    places = [
        place for room in ROOMS for path in files_of(ROOT, room) for place in places_in(ROOT, path)
    ]
    dice = random.Random(f"{seed}/mutants")  # noqa: S311  no secrets
    candidates = dice.sample(places, min(CANDIDATES * count, len(places)))
    executed = copy.lines(seeds, seconds, dict.fromkeys(each.file for each in candidates))
    reached = [each for each in candidates if each.line in executed.get(each.file, ())]
    return Drawn(reached[:count], len(reached), len(candidates))


def near_tests(root: Path, place: Place) -> list[str]:
    """Return some files of tests that import the module of a place: its room's first, by size."""
    module = place.file.removesuffix(".py").replace("/", ".")
    own = root / "tests" / room_of(place.file)
    files = [
        path
        for path in sorted((root / "tests").rglob("test_*.py"))
        if re.search(
            rf"^from {re.escape(module)} import", path.read_text(encoding="utf-8"), re.MULTILINE
        )
    ]
    files.sort(key=lambda path: (own not in path.parents, path.stat().st_size))
    return [path.relative_to(root).as_posix() for path in files[:MAX_NEAR_FILES]]


def attempt(copy: Copy, place: Place, seeds: int, seconds: float, *, near: bool = False) -> Trial:
    """Try a fault; nothing of it remains in the copy.

    Tests are asked where sessions find nothing: those ``near`` that import its module, else all of
    its room. NotGreenError if that test fails without it too.
    """
    with copy.faulty(place):
        sessions = copy.hunt(seeds, seconds)
        asked = near_tests(copy.root, place) if near else [f"tests/{room_of(place.file)}"]
        timeout = NEAR_TESTS_TIME_S if near else TESTS_TIME_S
        tests = copy.test(*asked, timeout=timeout) if asked and not sessions else ""
    copy.check_green(tests)
    why = [each.why for each in read_told() if is_told(each, place)]
    told = (place.file, place.line, place.function, place.kind.value)
    return Trial(*told, place.before, place.after, sessions, tests, why[0] if why else "")


def one_line(text: str) -> str:
    """Return a text without the ends of its lines."""
    return " ".join(text.split())


def room_of(file: str) -> str:
    """Return the room of a module."""
    return file.split("/")[1]


def read_told() -> list[Told]:
    """Return the faults that change nothing which anybody can see."""
    table = tomllib.loads(TOLD_PATH.read_text(encoding="utf-8"))
    return [Told(**each) for each in table["fault"]]


def is_told(told: Told, place: Place) -> bool:
    """Return whether a fault that changes nothing is the one of a place."""
    return told[:4] == (place.file, place.function, place.before, place.after)
