"""A session of one's own, and its console: `trainer run` on a terminal.

The session takes longest to start, so it begins before anything of the screen is imported. It is a
process forked from this one, because that has all imports already and starts a tenth of a second
sooner than a new one. The terminal's keys do not reach it, and its output is kept for the console.
"""

import contextlib
import gc
import os
import signal
import socket
import sys
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

import click

from trainer.config.files import ConfigError
from trainer.console.terminal import OWN_SESSION_VARIABLE
from trainer.io import paths
from trainer.io.lines import fit_terminal

POLL_PERIOD_S = 0.004  # [s] between looks at whether it has ended
END_TIMEOUT_S: Final = 2.0  # [s] for a session that goes on to end all the same
SUMMARY_TIMEOUT_S: Final = 30.0  # [s] for a session that was ended to say its last words
# A session that can start says one of these first.
FIRST_WORDS: Final = (paths.MAKING_READY, paths.LISTENING_TEXT)


class Process(ABC):
    """The process of a session, whose output is kept for the console."""

    @abstractmethod
    def written(self, stream: str) -> str:
        """Return what it has written to its standard output, "out", or to its errors, "err"."""

    @abstractmethod
    def ended(self) -> int | None:
        """Return its exit code, of a signal negative; None while it is at work."""

    @abstractmethod
    def terminate(self) -> None:
        """Ask it to end."""

    def wait(self, patience: float) -> int | None:
        """Return its exit code once it has ended. None if it has not in ``patience`` [s]."""
        end = time.monotonic() + patience
        while (code := self.ended()) is None and time.monotonic() < end:
            time.sleep(POLL_PERIOD_S)
        return code


class Program(Process):
    """A process started as a new program, where the system cannot fork."""

    def __init__(self, words: Sequence[str], environment: Mapping[str, str]) -> None:
        """Start ``trainer`` with these words."""
        import subprocess  # noqa: PLC0415  not where a process is forked

        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        with self._file("out").open("wb") as out, self._file("err").open("wb") as err:
            self._process = subprocess.Popen(  # noqa: S603  our own program
                [sys.executable, "-m", "trainer", *words],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                env=os.environ | dict(environment),
                start_new_session=True,
            )

    def _file(self, name: str) -> Path:
        return Path(self._folder.name) / name

    def written(self, stream: str) -> str:
        """Return what it has written to its standard output, or to its errors."""
        return self._file(stream).read_text(encoding="utf-8", errors="replace")

    def ended(self) -> int | None:
        """Return its exit code, None while it is at work."""
        return self._process.poll()

    def terminate(self) -> None:
        """Ask it to end."""
        self._process.terminate()


class Child(Process):
    """A process forked from this one."""

    def __init__(self, work: Callable[[], NoReturn]) -> None:
        """Fork, and do ``work`` in the child, which ends by SystemExit and does not return.

        It is called before there are threads, because a fork copies only the thread that calls it.
        """
        self._out, self._err = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        self._code: int | None = None
        self._asking = threading.Lock()
        sys.stdout.flush()
        sys.stderr.flush()
        self._process = os.fork()
        if not self._process:
            self._leave_home()
            work()

    def written(self, stream: str) -> str:
        """Return all output so far, without moving the place at which the child writes."""
        descriptor = (self._out if stream == "out" else self._err).fileno()
        size = os.fstat(descriptor).st_size
        return os.pread(descriptor, size, 0).decode("utf-8", errors="replace")

    def ended(self) -> int | None:
        """Return its exit code, of a signal negative; None while it is at work."""
        with self._asking:
            if self._code is None:
                process, status = os.waitpid(self._process, os.WNOHANG)
                if process:
                    self._code = os.waitstatus_to_exitcode(status)
        return self._code

    def terminate(self) -> None:
        """Ask it to end."""
        if self.ended() is None:
            os.kill(self._process, signal.SIGTERM)

    def _leave_home(self) -> None:
        """Leave the terminal, so that its keys do not reach this process."""
        os.setsid()
        nothing = os.open(os.devnull, os.O_RDWR)
        for ours, theirs in enumerate((nothing, self._out.fileno(), self._err.fileno())):
            os.dup2(theirs, ours)
        os.close(nothing)


def sail(
    serve: Callable[[str], NoReturn], path: str | None, token: str | None, role: str = "instructor"
) -> int:
    """Show the console of a session of one's own, which ``serve`` runs at a socket.

    It listens at ``path``, None for where stations look for it. It goes on only while somebody is
    attached. Return its exit code.
    """
    where = path or str(free_socket())
    return show_console(OwnSession(Child(lambda: serve(where))), where, token, role)


def sail_beside(words: Sequence[str], token: str | None, role: str = "instructor") -> int:
    """Show the console of one's own session, which is a separate program.

    It is `trainer` and ``words``.

    For systems without fork and local sockets: it listens at a port of this machine, and asks for a
    token. Return its exit code.
    """
    import secrets  # noqa: PLC0415  not where a process is forked

    word = token or secrets.token_hex(8)
    variables = {OWN_SESSION_VARIABLE: f"{paths.DEFAULT_HOST}:0 {word}"}
    try:
        return show_console(
            OwnSession(Program(words, variables)), f"tcp://{paths.DEFAULT_HOST}:", word, role
        )
    finally:
        paths.address_path().unlink(missing_ok=True)


def can_fork() -> bool:
    """Return whether this system has what ``sail`` needs."""
    return hasattr(os, "fork") and hasattr(socket, "AF_UNIX")


def show_console(
    voyage: "OwnSession", where: str, token: str | None, role: str = "instructor"
) -> int:
    """Show the console of a session that is being started; return its exit code."""
    gc.disable()  # what is imported is no garbage; the session wants the processor
    try:
        from trainer.console.launch import Visit  # noqa: PLC0415  while the session starts

        def reach() -> str:
            address = voyage.address(where)
            if address != where and token:
                paths.leave_address(address, token)  # for this user's stations
            return address

        visit = Visit.prepare(reach, role, token, own=True)
        gc.freeze()
        gc.enable()
        refused = visit.show() if voyage.await_word(*FIRST_WORDS) else None
    except BaseException:
        voyage.session.terminate()
        raise
    begun = visit.model.greeted
    if not begun and voyage.session.ended() is None:
        voyage.session.terminate()
        raise ConfigError(refused.reason) if refused else click.Abort
    return voyage.account(END_TIMEOUT_S if begun and not visit.model.over else SUMMARY_TIMEOUT_S)


@dataclass
class OwnSession:
    """A session of one's own, and what it says while the screen has the terminal."""

    session: Process
    passed: int = 0  # lines that have been passed on

    def await_word(self, *words: str) -> bool:
        """Print the session's lines until one begins with a word; return whether one did."""
        while self.session.ended() is None:
            if any(text.startswith(words) for text in self.pass_on()):
                return True
            time.sleep(POLL_PERIOD_S)
        return False

    def address(self, where: str) -> str:
        """Return ``where`` once the session listens there; NeverBegunError if it has ended."""
        while not (listening_at := self._listens(where)):
            if self.session.ended() is not None:
                from trainer.console.client import NeverBegunError  # noqa: PLC0415  long imported

                raise NeverBegunError("the session has ended")
            time.sleep(POLL_PERIOD_S)
        return listening_at

    def _listens(self, where: str) -> str:
        """Return the address that the session listens at if it begins so, "" before."""
        for text in self.session.written("err").splitlines():
            listening_at = text.removeprefix(f"{paths.LISTENING_TEXT} ")
            if listening_at == where or (where.endswith(":") and listening_at.startswith(where)):
                return listening_at
        return ""

    def pass_on(self) -> list[str]:
        """Print the session's new errors; return all its errors."""
        said = self.session.written("err").splitlines()
        for text in said[self.passed :]:
            if not text.startswith(FIRST_WORDS):
                click.echo(fit_terminal(text), err=True)
        self.passed = len(said)
        return said

    def account(self, patience: float) -> int:
        """Say how the session ended, or that it goes on; return the exit code."""
        code = self.session.wait(patience)
        if code is None:
            click.echo("the session goes on for the others; `trainer attach` joins it again")
            return 0
        click.echo(self.session.written("out"), nl=False)
        self.pass_on()
        return code


def free_socket() -> Path:
    """Return where stations look for a session, or beside it where another one listens there."""
    usual = paths.socket_path()
    taken = False
    with (
        socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end,
        contextlib.suppress(OSError),  # a path that is too long is told by who listens there
    ):
        taken = end.connect_ex(str(usual)) == 0
    return usual.with_name(f"session-{os.getpid()}.sock") if taken else usual
