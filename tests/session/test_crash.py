"""A session killed at any instant: no order is lost, and it goes on to the same bits."""

import contextlib
import csv
import itertools
import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.places import environment
from helpers.sessions import TROUBLED_SEA

from trainer.io.recording.recording import Recording

pytestmark = pytest.mark.skipif(os.name != "posix", reason="kills and forks of POSIX")

SECONDS = 900  # [s] of the exercise
MAX = ("--headless", "--speed", "max")

# Everything at work: a sea, tanks, casualties at set times and by a trigger, the autopilot.
TROUBLED = f"""{TROUBLED_SEA}
[[casualties]]
when = "depth > 42"
name = "rudder-slow"
"""
ORDERS = (  # as they are journalled
    "casualty depth-gauge-noisy",
    "course right 60",
    "casualty flooding-aft 0.1 ramp 25 s",
    "pump trim forward 3 t",
    "depth 60 m",
    "freeze tanks",
    "casualty gyro-biased 0.5 ramp 40 s",
    "release tanks",
    "speed 50 kn",  # refused
    "drain aft",
    "clear flooding-aft",
    "hover on",
    "sea state 3",
    "hover off",
    "freeze depth",
    "rudder left 10",
    "release depth",
    "course 010",
    "clear all",
)
ENDS = (0, 1)  # codes of a run to its end: 1, an order of the schedule was refused
# Starts programs that are told to it, each with imports done and the boat loaded, and kills them:
# after a time, or once SQLite has taken so many instructions for the run, in the midst of a write.
NURSERY = """
import json, os, signal, sys, time
from trainer.debrief.passage import recording_export
from trainer.cli import main as cli
from trainer.io.recording import checkpoint, file as recording_file, recording
from trainer.session import replay

checkpoint.MIN_CHECKPOINT_BYTES = 200_000  # a kill may hit these too
checkpoint.LOOK_PERIOD_S = 0.05
recording.BATCH_ROWS = 20  # and there is something after the last order more often
connect = recording_file.connect

def counting(most):
    left = most

    def count():
        nonlocal left
        left -= 1
        if not left:
            os.kill(os.getpid(), signal.SIGKILL)

    def watched(path, options):
        connection = connect(path, options)
        connection.set_progress_handler(count, 1)
        return connection

    recording_file.connect = watched
    return lambda: most - left

def run(words):
    sys.argv = ["trainer", *words]
    try:
        cli.main()
    except SystemExit as left:
        return left.code or 0

def grow_up(job):
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    told = os.open(job["told"], os.O_CREAT | os.O_APPEND | os.O_WRONLY)
    os.dup2(told, 1), os.dup2(told, 2)
    taken = counting(job["instructions"] or 2**60)
    code = run(job["words"])
    print("instructions", taken(), flush=True)
    sys.stderr.flush()
    os._exit(code)

kept = os.dup(1)
os.dup2(2, 1)
run(sys.argv[1:])  # loads the compiled boat, once for all
os.dup2(kept, 1)
for line in sys.stdin:
    job = json.loads(line)
    child = os.fork()
    if not child:
        grow_up(job)
    begun = time.monotonic()
    if job["seconds"] is not None:
        time.sleep(job["seconds"])
        os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    print(json.dumps([os.waitstatus_to_exitcode(status), time.monotonic() - begun]), flush=True)
"""


class Nursery:
    """A process that has done the imports, and starts and kills the programs under test."""

    def __init__(self, process: "subprocess.Popen[str]", folder: Path) -> None:
        self._process = process
        self._told = folder / "told.txt"

    def start(self, *words: str, seconds: float | None = None, instructions: int = 0) -> None:
        """Start a program, to be killed after a time or so many instructions."""
        job = {
            "words": words,
            "seconds": seconds,
            "instructions": instructions,
            "told": str(self._told),
        }
        assert self._process.stdin
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()

    def ended(self) -> tuple[int, float]:
        """Return the exit code of the program and how long [s] it ran."""
        code, seconds = json.loads(self._line())
        return code, seconds

    def done(self, *words: str) -> float:
        """Let a program run to its good end; return how long [s] it took."""
        self._told.unlink(missing_ok=True)
        self.start(*words)
        code, seconds = self.ended()
        assert code in ENDS, self._told.read_text()
        return seconds

    def instructions(self) -> int:
        """Return how many instructions SQLite took for the last program."""
        return int(self._told.read_text().rpartition("instructions ")[2])

    def _line(self) -> str:
        assert self._process.stdout
        return self._process.stdout.readline()


@pytest.fixture(scope="module")
def nursery(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Nursery]:
    folder = tmp_path_factory.mktemp("nursery")
    first = folder / "first.toml"
    first.write_text(TROUBLED)
    words = ("run", str(first), *MAX, "--duration", "5", "--record", str(folder / "first.trainer"))
    with subprocess.Popen(
        [sys.executable, "-c", NURSERY, *words],
        env=environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        yield Nursery(process, folder)
        assert process.stdin
        process.stdin.close()


@pytest.fixture
def exercise(tmp_path: Path) -> Path:
    """Return an exercise under orders all the time."""
    path = tmp_path / "all.toml"
    seconds = itertools.chain(range(1, 20, 2), itertools.count(27.3, 29.0))
    orders = itertools.islice(itertools.cycle(ORDERS), 60)
    tables = [
        f'[[orders]]\nat_s = {at:g}\norder = "{order}"\n'
        for at, order in zip(seconds, orders, strict=False)
    ]
    path.write_text(TROUBLED + "\n".join(tables))
    return path


Told = tuple[list[tuple[int, bytes]], list[tuple[Any, ...]]]


def story(path: Path) -> Told:
    """Return what a recording tells: its states, and its orders with their answers."""
    with contextlib.closing(Recording.look(path)) as recording:
        assert recording.branch == 1
        orders = [
            (each.tick, each.who, each.text, each.entry, each.accepted, each.answer)
            for each in recording.orders(1)
        ]
        return list(recording.states(1)), orders


def table(nursery: Nursery, path: Path) -> list[list[str]]:
    """Return the states as they are exported, without the timings."""
    out = path.with_suffix(".csv")
    nursery.done("export", str(path), "--csv", str(out))
    with out.open(newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[0][-2:] == ["lateness_ns", "work_ns"]
    return [row[:-2] for row in rows]


def kill_often(nursery: Nursery, exercise: Path, kills: int) -> None:
    """Kill a run again and again, until so many kills have left something to go on with."""
    folder, dice = exercise.parent, random.Random(1969)  # noqa: S311  instants, not secrets
    run = ("run", str(exercise), *MAX, "--duration", str(SECONDS), "--record")
    whole = folder / "whole.trainer"
    took = nursery.done(*run, str(whole))
    instructions = nursery.instructions()
    expected = story(whole)
    assert len(expected[0]) == 2 * SECONDS + 1

    inside = killed = 0
    for number in itertools.count():
        path = folder / f"{number}.trainer"
        words = (*run, str(path))
        while True:  # a run that has been gone on with is killed as well
            where = dice.randrange(1, instructions) if dice.random() < 0.5 else 0
            nursery.start(
                *words,
                seconds=None if where else dice.uniform(0.0, took),
                instructions=where,
            )
            code, _ = nursery.ended()
            if not path.exists():
                break
            assert code in (*ENDS, -signal.SIGKILL)
            killed += code not in ENDS
            inside += code not in ENDS and where > 0
            words = ("resume", str(path), *MAX)  # type: ignore[assignment]
            if code in ENDS or dice.random() < 0.7:
                break
        if not path.exists():  # killed before it was begun
            continue
        nursery.done("resume", str(path), *MAX)
        assert story(path) == expected
        if killed >= kills:
            break
        path.unlink()
    assert inside > 0
    assert table(nursery, path) == table(nursery, whole)


@pytest.mark.process
def test_a_run_killed_at_any_instant_goes_on_to_the_same_bits(
    nursery: Nursery, exercise: Path
) -> None:
    kill_often(nursery, exercise, int(os.environ.get("TRAINER_KILLS", "2")))
