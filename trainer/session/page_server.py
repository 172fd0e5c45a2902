"""The server of the pages, a program beside the session, begun again whenever it dies."""

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.config.files import ConfigError
from trainer.io import paths
from trainer.io.serial_line import LinkError
from trainer.io.server import listen_at, parse_address
from trainer.session.options import RunOptions
from trainer.session.stations.roles import read_tokens, refuse_open_door

FIRST: Final = 0.25  # [s] until a dead server is begun again, twice as long each time after
LONGEST_WAIT: Final = 8.0  # [s]
GOOD: Final = 30.0  # [s] after which a server has done well, and waits are short again
PATIENCE: Final = 3.0  # [s] for it to end
WRONG_INPUT: Final = 2  # an exit code: again would be no better
INHERITS: Final = os.name == "posix"  # else a process cannot be given a socket
EXAMPLE: Final = f"{paths.HOST}:{paths.PAGES}"


@dataclass
class PageServer:
    """A process that serves the pages, kept alive by a thread.

    It serves one exercise after another.

    The socket for browsers is opened here and stays open. Who comes while the process is begun
    again waits a moment, and finds the same address.
    """

    host: str  # as it was asked for
    listener: socket.socket
    port: int
    options: RunOptions
    _url: str = ""  # of the session
    _tell: Callable[[str], None] = print
    _process: subprocess.Popen[bytes] | None = None
    _thread: threading.Thread | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)  # of the process's beginning
    _closing: threading.Event = field(default_factory=threading.Event)

    def attend(self, url: str, tell: Callable[[str], None]) -> None:
        """Serve the session at ``url``. ``tell`` is called by another thread, with a trouble."""
        before, self._url, self._tell = self._url, url, tell
        if self._process is None:
            if not INHERITS:
                self.listener.close()  # it was to see that the address is free
            self._process = self._begin(opens=self.options.browse)
            self._thread = threading.Thread(target=self._keep, name="pages", daemon=True)
            self._thread.start()
        elif url != before:
            self._process.terminate()  # and it is begun again, for this one

    def close(self) -> None:
        """End the process, and whatever it has not sent by then; free the address."""
        with self._lock:
            self._closing.set()
        if self._process is not None:
            end(self._process)
        if self._thread is not None:
            self._thread.join()
        self.listener.close()

    def _begin(self, *, opens: bool) -> subprocess.Popen[bytes]:
        return subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-P", "-m", "trainer", *self._words(opens=opens)],
            stdin=subprocess.PIPE,  # it ends with this session, however that ends
            stdout=subprocess.DEVNULL,
            pass_fds=(self.listener.fileno(),) if INHERITS else (),
            start_new_session=True,
        )

    def _words(self, *, opens: bool) -> Sequence[str]:
        """Return the command of the process."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        words = ["web", "--connect", self._url, "--web", f"{host}:{self.port}"]
        words += ["--owner", str(self.listener.fileno() if INHERITS else -1)]
        words += ["--open" if opens else "--no-open"]
        for name in ("cert", "key"):
            path = getattr(self.options, name)
            words += [f"--{name}", str(path)] if path else []
        return words

    def _keep(self) -> None:
        """Begin the process again whenever it has died."""
        wait = FIRST
        while self._process is not None:
            begun = time.monotonic()
            code = self._process.wait()
            if self._process.stdin:
                self._process.stdin.close()
            wait = FIRST if time.monotonic() - begun >= GOOD else wait
            if self._closing.wait(wait):
                return
            if code == WRONG_INPUT:
                self._tell("there are no pages: their server was refused")
                return
            self._tell(f"the pages' server has ended with {code}, and begins again")
            wait = min(2.0 * wait, LONGEST_WAIT)
            with self._lock:
                if self._closing.is_set():
                    return
                self._process = self._begin(opens=False)


def end(process: subprocess.Popen[bytes]) -> None:
    """End a process, by force where it takes too long."""
    with contextlib.suppress(OSError):
        process.terminate()
    try:
        process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@contextlib.contextmanager
def serving_pages(options: RunOptions) -> Iterator[PageServer | None]:
    """Yield the server of the pages, None where none are asked for; ConfigError."""
    if not (options.browse or options.web):
        yield None
        return
    option = "--web-at" if options.browse else "--web"
    host, port = address_of(option, options.web) if options.web else (paths.HOST, paths.PAGES)
    refuse_open_door(option, host, read_tokens(options.token))
    listener = listen(option, host, port, insists=options.web is not None)
    server = PageServer(host, listener, listener.getsockname()[1], options)
    try:
        yield server
    finally:
        server.close()


def address_of(option: str, text: str) -> tuple[str, int]:
    """Return host and port of ``HOST:PORT``; ConfigError."""
    try:
        return parse_address(text, EXAMPLE)
    except LinkError as error:
        raise ConfigError(f"{option} {error}") from None


def listen(option: str, host: str, port: int, *, insists: bool) -> socket.socket:
    """Return a socket that listens for browsers; ConfigError.

    Unless it insists on a port that is taken, it is any that is free.
    """
    try:
        return listen_at(host, port)
    except LinkError as error:
        if insists:
            raise ConfigError(f"{option} {error}") from None
    return listen(option, host, 0, insists=True)
