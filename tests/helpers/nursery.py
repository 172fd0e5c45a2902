"""Processes of the trainer that begin where their imports end.

Most of what a test of a process waits for is Python reading 250 modules, the same ones each time.
So each worker of pytest has a nursery: a process that has imported them, and forks for each start.
The fork gets its own arguments, folder, environment and standard streams, and runs ``trainer`` as
``python -m trainer`` does, to the exit of its own interpreter. It is a process of its own: killed,
stopped and waited for by its number, as one that ``subprocess`` started.

Two processes stand behind each start. The child is the trainer. Its parent, forked before it, tells
its number and its end over a socket of this start, and kills it where that socket closes: what a
test leaves behind ends with the test's process.

Who asks for what an interpreter reads as it starts, such as PYTHONUTF8, another cache or another
locale, gets an interpreter that starts (``is_forked``). So does every system but Linux. Tests about
the start itself, about memory or about a terminal use ``subprocess``.
"""

import atexit
import contextlib
import functools
import io
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any, Final, Self, TypeAlias, cast

from helpers.places import tests_environment

# What is read as an interpreter starts or as modules are imported.
READ_AT_START: Final = (
    "LD_",
    "PYTHON",
    "NUMBA_",
    "LC_",
    "LANG",
    "OPENBLAS",
    "OMP_",
    "HOME",
    "XDG_CACHE",
)
PRELOADED_MODULES: Final = (
    "trainer.cli.main",
    "trainer.session.run",
    "trainer.session.doors.page_server",
)
NO_LIMITS: Final[Mapping[str, int]] = MappingProxyType({})
MAX_REQUEST_BYTES: Final = 200_000
STREAM_COUNT: Final = 3
Stream: TypeAlias = io.TextIOWrapper


class Child:
    """A trainer that was forked, with the face of ``subprocess.Popen[str]``."""

    def __init__(self, args: list[str], line: socket.socket, streams: list[Stream | None]) -> None:
        self.args = args
        self.stdin, self.stdout, self.stderr = streams
        self.returncode: int | None = None
        self._line = line
        self._answers = line.makefile("r", encoding="ascii")
        self.pid = int(self._answers.readline())

    def poll(self) -> int | None:
        """Return the exit code, negative for a signal; None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.wait(0)
        return None

    def wait(self, timeout: float | None = None) -> int:
        """Return the exit code once it has ended; subprocess.TimeoutExpired after a time [s]."""
        if self.returncode is None:
            if not select.select([self._line], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
            self.returncode = int(self._answers.readline())
            self.hang_up()
        return self.returncode

    def hang_up(self) -> None:
        """Close its line, as the end of this process does."""
        self._answers.close()
        self._line.close()

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it still runs."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self.send_signal(signal.SIGKILL)

    def communicate(self, text: str | None = None, timeout: float | None = None) -> tuple[str, str]:
        """Write a text, read all that it writes to pipes, and wait for its end."""
        written: dict[int, str] = {}

        def read(number: int, stream: Stream) -> None:
            written[number] = stream.read()
            stream.close()

        readers = [
            threading.Thread(target=read, args=(number, stream), daemon=True)
            for number, stream in ((1, self.stdout), (2, self.stderr))
            if stream and not stream.closed
        ]
        for reader in readers:
            reader.start()
        if self.stdin:
            with contextlib.suppress(BrokenPipeError):
                self.stdin.write(text or "")
                self.stdin.close()
        self.wait(timeout)
        for reader in readers:
            reader.join(timeout)
        return written.get(1, ""), written.get(2, "")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for stream in (self.stdout, self.stderr, self.stdin):
            if stream:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()
        self.wait()


Done: TypeAlias = "subprocess.CompletedProcess[str]"
StreamWish: TypeAlias = Any  # a file, subprocess.PIPE, DEVNULL or STDOUT, or None


def start_trainer(
    *words: str,
    before: Sequence[str] = (),
    env: Mapping[str, str] | None = None,
    cwd: "Path | str | None" = None,
    stdin: StreamWish = subprocess.DEVNULL,
    stdout: StreamWish = None,
    stderr: StreamWish = None,
    limits: Mapping[str, int] = NO_LIMITS,
) -> "subprocess.Popen[str]":
    """Start ``trainer WORDS``, by another command ``before`` it; the rest is as Popen takes it.

    ``limits`` are numbers by their names in ``resource``, such as RLIMIT_FSIZE.
    """
    environment = dict(os.environ if env is None else env)
    if before or not is_forked(environment):
        return subprocess.Popen(
            [*before, sys.executable, "-m", "trainer", *words],
            env=environment,
            cwd=cwd,
            stdin=stdin,
            stdout=stdout,
            stderr=stderr,
            encoding="utf-8",
            errors="surrogateescape",
            preexec_fn=(  # noqa: PLW1509  which takes no lock
                functools.partial(limit_process, limits) if limits else None
            ),
        )
    sys.audit("os.fork")  # which the nursery does: `process_guard` hears of it
    theirs, ours = zip(
        *(open_stream(number, wish) for number, wish in enumerate((stdin, stdout, stderr))),
        strict=True,
    )
    numbers = [theirs[1] if each == subprocess.STDOUT else each for each in theirs]
    line, far_end = socket.socketpair()
    request = {"words": words, "env": environment, "cwd": str(cwd or Path.cwd())}
    request["limits"] = dict(limits)
    with far_end:
        socket.send_fds(own_nursery(), [json.dumps(request).encode()], [*numbers, far_end.fileno()])
    for number, wish in zip(theirs, (stdin, stdout, stderr), strict=True):
        if wish in (subprocess.PIPE, subprocess.DEVNULL):
            os.close(number)
    child = Child(["trainer", *words], line, list(ours))
    return cast("subprocess.Popen[str]", child)


def run_trainer(
    *words: str,
    typed: str = "",
    env: Mapping[str, str] | None = None,
    cwd: "Path | str | None" = None,
    timeout: float | None = None,
) -> Done:
    """Run ``trainer WORDS``, to which a text is typed, to its end; return what it did and wrote."""
    pipe = subprocess.PIPE
    with start_trainer(*words, env=env, cwd=cwd, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        try:
            out, err = process.communicate(typed, timeout)
        except BaseException:
            process.kill()
            raise
    return subprocess.CompletedProcess(process.args, process.wait(), out, err)


def open_stream(number: int, wish: StreamWish) -> tuple[int, Stream | None]:
    """Return the descriptor that a child gets as its standard stream, and the test's own end."""
    if wish == subprocess.PIPE:
        near, far = os.pipe()
        if number == 0:
            return near, os.fdopen(far, "w", encoding="utf-8", errors="surrogateescape")
        return far, os.fdopen(near, encoding="utf-8", errors="surrogateescape")
    if wish == subprocess.DEVNULL:
        return os.open(os.devnull, os.O_RDWR), None
    if wish is None:
        return number, None
    return (wish if isinstance(wish, int) else wish.fileno()), None


def is_forked(environment: Mapping[str, str]) -> bool:
    """Return whether a start in that environment differs in nothing from a fork of the nursery."""
    if sys.platform != "linux":
        return False
    own = tests_environment()
    return all(
        environment.get(name) == own.get(name)
        for name in environment.keys() | own.keys()
        if name.startswith(READ_AT_START) and name != "PYTHONPATH"
    )


@functools.cache
def own_nursery() -> socket.socket:
    """Return the socket of this process's nursery, which ends with this process."""
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with far:
        process = subprocess.Popen(
            [sys.executable, "-m", "helpers.nursery", str(far.fileno())],
            env=tests_environment(),
            pass_fds=[far.fileno()],
            stdin=subprocess.DEVNULL,
        )
    atexit.register(process.wait)  # called last first
    atexit.register(near.close)
    return near


def limit_process(limits: Mapping[str, int]) -> None:
    """Let this process have no more of something."""
    import resource  # noqa: PLC0415  not everywhere

    for name, most in limits.items():
        resource.setrlimit(getattr(resource, name), (most, resource.RLIM_INFINITY))


def raise_children(requests: socket.socket) -> None:
    """Fork a trainer for each request, until the test's process has gone."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # whoever has ended leaves nothing to wait for
    while True:
        data, descriptors, _, _ = socket.recv_fds(requests, MAX_REQUEST_BYTES, STREAM_COUNT + 1)
        if not data:
            return
        if os.fork() == 0:
            requests.close()
            look_after(json.loads(data), descriptors)
            return
        for each in descriptors:
            os.close(each)


def look_after(request: dict[str, Any], descriptors: list[int]) -> None:
    """Fork the trainer, tell its number and its end; return in the trainer's own process alone."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    child = os.fork()
    if child == 0:
        grow_up(request, descriptors)
        return
    *streams, line = descriptors
    for each in streams:
        os.close(each)
    os.write(line, f"{child}\n".encode())
    ended = os.pidfd_open(child)
    if line in select.select([line, ended], [], [])[0]:
        os.kill(child, signal.SIGKILL)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    with contextlib.suppress(OSError):
        os.write(line, f"{code}\n".encode())
    os._exit(0)


def grow_up(request: dict[str, Any], descriptors: list[int]) -> None:
    """Become the process that was asked for: its streams, folder, environment and arguments."""
    for number, each in enumerate(descriptors[:STREAM_COUNT]):
        os.dup2(each, number)
    for each in descriptors:
        os.close(each)
    os.chdir(request["cwd"])
    limit_process(request["limits"])
    imported = {name: text for name, text in os.environ.items() if name not in born_with}
    os.environ.clear()
    os.environ.update(imported | request["env"])
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        stream = open(  # noqa: SIM115  as long as the process
            number,
            "w" if number else "r",
            encoding="utf-8",
            errors="backslashreplace" if number == 2 else "strict",
            closefd=False,
        )
        stream.reconfigure(line_buffering=number == 2 or stream.isatty())
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)
    sys.argv = ["trainer", *request["words"]]
    runpy.run_module("trainer", run_name="__main__", alter_sys=True)


born_with: Final = frozenset(os.environ)

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    gate = socket.socket(fileno=int(sys.argv[1]))
    for module in PRELOADED_MODULES:
        __import__(module)
    raise_children(gate)
