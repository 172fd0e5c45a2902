"""Programs under proof, started by the thousand: a process with all loaded, which forks them.

It is given the command line's main function, since the proofs lie below it. It reads jobs, a JSON
object a line, and answers each with a line: a process id, or an exit code.
"""

import json
import os
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any, Final, Self

PROGRAM: Final = """
from trainer.cli.main import main
from trainer.verify.faults.fork_server import open_for
open_for(main)
"""
LIMITS: Final = {
    "largest_file": "RLIMIT_FSIZE",
    "seconds": "RLIMIT_CPU",
    "memory": "RLIMIT_DATA",
}
FIRST: Final = ("run", "--headless", "--speed", "max", "--duration", "5", "--record")


Main = Callable[[], None]


@dataclass(frozen=True)
class Job:
    """A program to be started: the words of `trainer`, where it tells what it tells."""

    words: tuple[str, ...]
    told: str  # path of a file
    largest_file: int = 0  # [bytes] 0 for no limit
    seconds: int = 0  # [s] of the processor, 0 for no limit
    memory: int = 0  # [bytes] 0 for no limit


class ForkServer:
    """The process that starts programs; a context."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str]

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-c", PROGRAM],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        for stream in (self._process.stdin, self._process.stdout):
            if stream:
                stream.close()
        self._process.wait()

    def start(self, job: Job) -> int:
        """Start a program; return its process id."""
        return self._ask(asdict(job))

    def wait(self, child: int) -> int:
        """Wait for a program's end; return its exit code, of a signal negative."""
        return self._ask({"wait": child})

    def done(self, job: Job) -> int:
        """Run a program to its end. Return its exit code."""
        return self.wait(self.start(job))

    def _ask(self, what: dict[str, Any]) -> int:
        stdin, stdout = self._process.stdin, self._process.stdout
        if not (stdin and stdout):
            raise RuntimeError("the nursery is closed")
        stdin.write(json.dumps(what) + "\n")
        stdin.flush()
        return int(stdout.readline())


def run(main: Main, words: tuple[str, ...]) -> int:
    """Run the command line with these words; return the exit code."""
    sys.argv = ["trainer", *words]
    try:
        main()
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else 0
    return 0


def grow_up(main: Main, job: dict[str, Any]) -> None:
    """Be the program; never returns."""
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    told = os.open(job["told"], os.O_CREAT | os.O_APPEND | os.O_WRONLY)
    os.dup2(told, 1)
    os.dup2(told, 2)
    import resource  # noqa: PLC0415  not everywhere

    for name, limit in LIMITS.items():
        if job[name]:
            resource.setrlimit(getattr(resource, limit), (job[name], resource.RLIM_INFINITY))
    code = 1
    try:
        code = run(main, tuple(job["words"]))
    except BaseException:  # noqa: BLE001  what a program of its own would end with
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def tend(main: Main, jobs: IO[str], answers: IO[str]) -> None:
    """Start and wait for programs, one job a line, to the end of the jobs."""
    for line in jobs:
        job = json.loads(line)
        if "wait" in job:
            answer = os.waitstatus_to_exitcode(os.waitpid(job["wait"], 0)[1])
        else:
            answer = os.fork()
            if not answer:
                grow_up(main, job)
        answers.write(f"{answer}\n")
        answers.flush()


def open_for(main: Main) -> None:
    """Load everything by a first run, then tend the nursery."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with tempfile.TemporaryDirectory() as folder:
        run(main, (*FIRST, str(Path(folder) / "first.trainer")))
    tend(main, sys.stdin, answers)
