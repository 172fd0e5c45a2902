"""A session in its own process, and a program at its socket that gives orders."""

import contextlib
import itertools
import json
import re
import socket
import subprocess
import sys
import threading
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Final, Self

import click
from helpers.places import tests_environment

from trainer.io.orders.sentences import Sentence, order_sentence, parse_sentence
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.run import run_boat
from trainer.session.time.ledger import SECOND_NS
from trainer.session.time.pacer import Clock, MonotonicClock

ANSWER: Final = 60.0  # [s] for an answer, or for a word
RESET: Final = b"\1\0\0\0\0\0\0\0"  # linger 0: the line is cut, not closed


class GoneError(Exception):
    """The session has closed the line, or does not answer."""


class Caller:
    """One line to a session on this machine."""

    def __init__(self, at: int | Path, patience: float = ANSWER, buffer: int = 0) -> None:
        """Dial a port of this machine, or a local socket; GoneError if nobody answers.

        ``buffer`` [bytes] is what the line holds of what is said; 0: what the system gives it.
        """
        self.shown: dict[str, tuple[str, ...]] = {}  # the latest values of each channel
        self.said: list[str] = []  # the lines of the last long answer
        self.news: list[Sentence] = []  # what has happened, until somebody takes it
        self._tags = itertools.cycle(range(1, 1_000_000))
        try:
            self.line = _dial(at, patience, buffer)
        except OSError as error:
            raise GoneError(str(error)) from None
        self._lines = self.line.makefile(encoding="ascii", errors="replace")

    @property
    def name(self) -> str:
        """Return what the session calls the line."""
        host, port = self.line.getsockname()
        return f"tcp {host}:{port}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.hang_up()

    def ask(self, words: str) -> tuple[bool, str]:
        """Give an order; return whether it was obeyed, and the answer."""
        tag = str(next(self._tags))
        self.said = []
        try:
            self.line.sendall(f"{order_sentence(words, tag)}\n".encode("ascii"))
            for text in self._lines:
                said = parse_sentence(text)
                if said and (said.kind, said.tag) == ("TRA", tag) and said.fields[0] != "say":
                    return said.fields[0] == "ok", said.fields[1]
                self._take(said, tag)
        except OSError as error:
            raise GoneError(str(error)) from None
        raise GoneError("the session has closed the line")

    def hear(self) -> None:
        """Wait for the next line that the session says by itself, and keep it."""
        try:
            text = self._lines.readline()
        except OSError as error:
            raise GoneError(str(error)) from None
        if not text:
            raise GoneError("the session has closed the line")
        self._take(parse_sentence(text), "")

    @property
    def tick(self) -> int:
        """Return the latest tick that the session has told."""
        return max((int(values[0]) for values in self.shown.values()), default=0)

    def hang_up(self) -> None:
        """Leave without a word."""
        self._lines.close()
        self.line.close()

    def cut(self) -> None:
        """Leave as a machine does that loses power: what is under way is lost."""
        with contextlib.suppress(OSError):
            self.line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
        self.hang_up()

    def _take(self, said: Sentence | None, tag: str) -> None:
        """Keep what the session says by itself, and the lines of the answer that is awaited."""
        if said and (said.kind, said.tag) == ("TRA", tag):
            self.said.append(said.fields[1])
        elif said and said.kind == "TRS":
            self.shown[said.fields[0]] = said.fields[1:]
        elif said and said.kind == "TRE":
            self.news.append(said)


def _dial(at: int | Path, patience: float, buffer: int) -> socket.socket:
    line = socket.socket(socket.AF_INET if isinstance(at, int) else socket.AF_UNIX)
    if buffer:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    line.settimeout(patience)
    try:
        line.connect(("127.0.0.1", at) if isinstance(at, int) else str(at))
    except OSError:
        line.close()
        raise
    return line


PATIENCE: Final = 120.0  # [s] to listen: a first start compiles
STATUS: Final = re.compile(r"VmRSS:\s+(\d+) kB")


class StartError(Exception):
    """A session that does not listen; the text is what it said."""


class SessionProcess:
    """One session in a process of its own: what it tells, and lines to it."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        """Read what it writes to pipes; it has one for stderr."""
        self.process = process
        self.told: list[str] = []  # on stderr
        self.account: list[str] = []  # on stdout
        self._where: int | Path | None = None
        self._heard = threading.Event()
        self._readers = [
            threading.Thread(target=read, daemon=True) for read in (self._listen, self._keep)
        ]
        for reader in self._readers:
            reader.start()

    def where(self) -> int | Path:
        """Wait until it listens; return its port or local socket, StartError if there is none."""
        if not self._heard.wait(PATIENCE) or self._where is None:
            code = self.process.poll()
            self.kill()
            raise StartError(
                "\n".join(self.told) or f"the session does not listen, exit code {code}"
            )
        return self._where

    def caller(
        self, role: str = "", token: str = "", *, patience: float = ANSWER, buffer: int = 0
    ) -> Caller:
        """Return a line that has a role; GoneError if it has gone, or refuses."""
        with contextlib.ExitStack() as unless_good:
            caller = unless_good.enter_context(Caller(self.where(), patience, buffer))
            taken, why = caller.ask(f"role {role} {token}") if role else (True, "")
            if not taken:
                raise GoneError(why)
            unless_good.pop_all()
        return caller

    @property
    def running(self) -> bool:
        """Return whether it has not ended."""
        return self.process.poll() is None

    def memory(self) -> int:
        """Return its memory [kB]. 0: the system does not tell, or it has ended."""
        try:
            text = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        except OSError:
            return 0
        found = STATUS.search(text)
        return int(found[1]) if found else 0

    def ended(self, patience: float) -> int:
        """Wait for its end; return its exit code, TimeoutExpired if it does not come."""
        code = self.process.wait(patience)
        for reader in self._readers:
            reader.join()
        self._close()
        return code

    def kill(self) -> None:
        """End it at this instant."""
        self.process.kill()
        self.ended(PATIENCE)

    def _close(self) -> None:
        for stream in (self.process.stdout, self.process.stderr):
            if stream:
                stream.close()

    def _listen(self) -> None:
        for line in self.process.stderr or ():
            self.told.append(line.rstrip())
            if "listening at" in line:
                at = line.partition("listening at ")[2].strip()
                self._where = int(at.rpartition(":")[2]) if at.startswith("tcp://") else Path(at)
                self._heard.set()
        self._heard.set()

    def _keep(self) -> None:
        for line in self.process.stdout or ():
            self.account.append(line.rstrip())


def begin_watched(*words: str) -> SessionProcess:
    """Start `trainer serve` with these words and wait until it listens; StartError."""
    listening = ("--listen", "127.0.0.1:0", "--socket", "none", "--verbose")
    session = SessionProcess(
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM, *words, *listening],
            env=tests_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    )
    session.where()
    return session


# A session whose clock is watched by another: `trainer serve`, and what its deadlines were.
#
# It is given that command, since the proofs lie below the commands. The last line of its output is
# a JSON object: how many deadlines were waited for, how many of them were not a whole number of
# steps after the first, to the nanosecond, and the largest deviation.


@dataclass
class Deadlines:
    """The readings of a witness."""

    seen: int = 0  # deadlines that differ from the one before
    adrift: int = 0  # of them, not first + k h rounded down, for any whole k
    furthest_ns: int = 0


class WatchedClock:
    """A clock that notes every deadline it is asked to wait for; for one thread."""

    def __init__(self, clock: Clock, period: Fraction) -> None:
        """Watch ``clock``; deadlines are to be ``period`` [ns] apart."""
        self.deadlines = Deadlines()
        self._clock = clock
        self._period = period
        self._first: int | None = None
        self._last = 0

    def now(self) -> int:
        """Return the time [ns]."""
        return self._clock.now()

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""
        return self._clock.cpu()

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Wait as the clock does; note the deadline."""
        if deadline != self._last:
            self._note(deadline)
        return self._clock.wait_until(deadline, wake)

    def _note(self, deadline: int) -> None:
        self._first = deadline if self._first is None else self._first
        self._last = deadline
        self.deadlines.seen += 1
        cycles = round((deadline - self._first) / self._period)
        off = deadline - self._first - int(cycles * self._period)
        if off:
            self.deadlines.adrift += 1
            self.deadlines.furthest_ns = max(self.deadlines.furthest_ns, abs(off))


PROGRAM: Final = """
from trainer.cli.run import serve
from soak.session_process import attest
attest(serve)
"""


def options_of(serve: click.Command, words: list[str]) -> RunOptions:
    """Return the options that `trainer serve` makes of its words."""
    context = serve.make_context("serve", words)
    source = context.get_parameter_source
    default = click.core.ParameterSource.DEFAULT
    given = frozenset(name for name in context.params if source(name) is not default)
    context.params.pop("owned")  # the command obeys it before the run
    return RunOptions(**context.params, given=given - {"owned"}, headless=True, serve=True)


def attest(serve: click.Command) -> None:
    """Serve as the arguments say. Print what the clock was asked for; leave with its exit code."""
    options = options_of(serve, sys.argv[1:])
    period = Fraction(str(plan_run(options).method.step)) * SECOND_NS
    witness = WatchedClock(MonotonicClock(), period)
    code = run_boat(options, witness)
    click.echo(json.dumps(asdict(witness.deadlines)))
    sys.exit(code)
