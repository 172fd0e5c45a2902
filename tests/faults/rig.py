"""The rig of the faults: programs forked by the thousand, sessions, their orders, the results."""

import json
import os
import random
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import IO, Any, Final, Self

from helpers.places import tests_environment
from helpers.waiting import eventually, once_it_can
from soak.audit import Answered, Check, journal, lost_marks
from soak.operators import Orders
from soak.session_process import Caller, GoneError

from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Recording
from trainer.session.stations.roles import INSTRUCTOR_ROLE, Role

PROGRAM: Final = """
from trainer.cli.main import main
from faults.rig import open_for
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
        self._process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM],
            env=tests_environment(),
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


MARKS: Final = 0.2  # [-] of a mark after an order


@dataclass
class Tried:
    """The result of one kind of fault."""

    fault: str
    promise: str
    times: int = 0
    orders: int = 0  # answered before, between and after
    wrong: list[str] = field(default_factory=list)
    seen: dict[str, int] = field(default_factory=dict)  # how it ended, and how often

    def note(self, how: str) -> None:
        """Count one way that it ended."""
        self.seen[how] = self.seen.get(how, 0) + 1

    def must(self, held: object, otherwise: str) -> None:
        """Note what is wrong unless it held."""
        if not held:
            self.wrong.append(f"{self.times}: {otherwise}")


@dataclass(frozen=True)
class Bench:
    """A nursery, a folder to work in, and the dice."""

    nursery: ForkServer
    folder: Path
    dice: random.Random

    def told(self) -> str:
        """Return what programs have told since the last call."""
        path = self.folder / "told.txt"
        text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
        path.unlink(missing_ok=True)
        return text

    def run(self, *words: str) -> int:
        """Run a program of `trainer` to its end. Return its exit code."""
        return self.nursery.done(Job(words, str(self.folder / "told.txt")))

    def serve(self, path: Path, *words: str, largest_file: int = 0) -> "Session":
        """Start a session that records to ``path`` and listens in the folder."""
        door = self.folder / "door.sock"
        door.unlink(missing_ok=True)
        ports = ("--listen", "none", "--socket", str(door))
        job = Job(
            ("serve", *words, *ports, "--verbose", "--record", str(path)),
            str(self.folder / "told.txt"),
            largest_file,
        )
        return Session(self.nursery.start(job), path, door)


@dataclass
class Session:
    """A session under a fault."""

    process: int
    path: Path
    door: Path
    answered: list[Answered] = field(default_factory=list)

    @contextmanager
    def instructed(self) -> Iterator[Caller]:
        """Yield a line of the instructor, once the session listens; GoneError if it does not."""
        by = once_it_can(lambda: Caller(self.door), GoneError)
        try:
            by.ask("role instructor")
            yield by
        finally:
            by.hang_up()

    def order(self, by: Caller, words: str) -> str:
        """Give an order to the boat and note that it was obeyed; return the answer."""
        obeyed, answer = by.ask(words)
        order = parse(words)
        if obeyed and isinstance(order, Order):
            self.answered.append(Answered("", order.text))
        return answer

    def order_some(
        self, by: Caller, dice: random.Random, count: int, role: Role = INSTRUCTOR_ROLE
    ) -> None:
        """Give random orders, of those that a role may give."""
        orders = Orders(role, dice)
        for _ in range(count):
            self.order(by, orders.next())
            if dice.random() < MARKS:
                self.mark(by, f"mark-{dice.randrange(10**9)}")

    def mark(self, by: Caller, remark: str) -> None:
        """Mark a moment and note that it was answered."""
        if by.ask(f"mark {remark}")[0]:
            self.answered.append(Answered("", remark, mark=True))


def is_journalled(recording: Recording, session: Session) -> Check:
    """Return whether what was answered is in the journal, beside what came of itself."""
    written = [order.text for order in journal(recording) if order.accepted is not False]
    wanted = [order.text for order in session.answered if not order.mark]
    missing = lost_marks(recording, session.answered)
    rest = iter(written)
    held = all(text in rest for text in wanted) and not missing
    told = f"{len(written)} written, {len(wanted)} answered, {len(missing)} marks lost"
    return Check("answered orders", held, told)


def is_told(by: Caller, words: str) -> bool:
    """Return whether the session tells of it before long. What it has told is then forgotten."""

    def is_come() -> bool:
        by.ask("snapshots")  # brings what has been told meanwhile
        return any(words in news.fields[3] for news in by.news)

    told = eventually(is_come)
    if told:
        by.news.clear()
    return told


def is_logged(by: Caller, words: str) -> bool:
    """Return whether it is in the session's log before long. It may be older than the line."""

    def is_there() -> bool:
        by.ask("log 100")
        return any(words in text for text in by.said)

    return eventually(is_there)
