"""The pages' server (``web``) as a process, restarted when it dies or hangs.

It is a separate process, because many browsers would make the ticks late in this one. It writes a
byte each second as a sign of life. A thread here reads them, and starts another process when they
stop. The listening socket stays open meanwhile, so that browsers can connect again.
"""

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import IO, Final, cast

from trainer.io import paths
from trainer.io.serial_line import LinkError
from trainer.io.server import listen_at, parse_address
from trainer.session.doors.attach import offer_choice
from trainer.session.doors.ports import refusing
from trainer.session.past.options import RunOptions
from trainer.session.stations.roles import ANY_ROLE, TRAINEE_ROLE, read_tokens, refuse_open_door

# [s] until a dead server is begun again, twice as long each time after
FIRST_RESTART_S: Final = 0.25
MAX_WAIT_S: Final = 8.0  # [s] between two restarts
STEADY_TIME_S: Final = 30.0  # [s] after which a server has done well, and waits are short again
CLOSE_TIMEOUT_S: Final = 3.0  # [s] for the process to end by itself
SILENCE_TIMEOUT_S: Final = 10  # [s] without a sign of life, after which a process hangs
START_TIMEOUT_S: Final = 120  # [s] until the first sign of life: a slow machine imports for long
WRONG_INPUT: Final = 2  # the exit code of wrong options, which a restart cannot mend
INHERITS_SOCKETS: Final = os.name == "posix"  # else a process cannot be given a socket
EXAMPLE_ADDRESS: Final = f"{paths.DEFAULT_HOST}:{paths.PAGES_PORT}"


class ServerProcess:
    """A process that serves the pages, and writes bytes as signs of life."""

    def __init__(self, words: Sequence[str], inherited: tuple[int, ...]) -> None:
        """Start the process; OSError where the system has no room for it."""
        self._process = subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-P", "-m", "trainer", *words],
            stdin=subprocess.PIPE,  # it ends with this session, however that ends
            stdout=subprocess.PIPE,
            bufsize=0,
            pass_fds=inherited,
            start_new_session=True,
        )
        self._news = threading.Event()
        self._ended = threading.Event()
        threading.Thread(target=self._hear, name="pages-alive", daemon=True).start()

    def hangs(self) -> bool:
        """Wait until the process hangs or has ended; return whether it hangs.

        Only seconds in which this session was awake count as silence, because a suspended machine,
        which stops both, is no fault of the process.
        """
        silent_s, limit_s = 0, START_TIMEOUT_S
        while not self._ended.is_set():
            if self._news.wait(1.0):
                self._news.clear()
                silent_s, limit_s = 0, SILENCE_TIMEOUT_S
            else:
                silent_s += 1
            if silent_s >= limit_s:
                return True
        return False

    def ask_to_end(self) -> None:
        """Ask it to end."""
        with contextlib.suppress(OSError):
            self._process.terminate()

    def end(self, timeout_s: float) -> int:
        """Return the exit code, after the process has ended by itself or by force.

        It is killed if it has not ended within ``timeout_s`` [s].
        """
        if not self._ended.wait(timeout_s):
            self._process.kill()
        if self._process.stdin:
            self._process.stdin.close()
        return self._process.wait()  # without a limit, which would sleep in steps

    def _hear(self) -> None:
        """Note the time of each sign of life, until the process closes its output."""
        with cast("IO[bytes]", self._process.stdout) as pipe:
            while pipe.read(1):
                self._news.set()
        self._ended.set()
        self._news.set()


@dataclass
class PageServer:
    """The server of the pages, whose process a thread keeps alive.

    It serves one exercise after another. The socket for browsers is opened here and stays open,
    because a browser that comes during a restart then waits a moment at the same address.
    """

    host: str  # as it was asked for
    listener: socket.socket
    port: int
    options: RunOptions
    _url: str = ""  # of the session
    _tell: Callable[[str], None] = print
    _process: ServerProcess | None = None
    _thread: threading.Thread | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)  # of the process's beginning
    _closing: threading.Event = field(default_factory=threading.Event)

    def attend(self, url: str, tell: Callable[[str], None]) -> None:
        """Serve the session at ``url``. Another thread calls ``tell`` with each trouble."""
        before, self._url, self._tell = self._url, url, tell
        if self._thread is None:
            if not INHERITS_SOCKETS:
                self.listener.close()  # it was to see that the address is free
            self._begin(opens=self.options.browse)
            self._thread = threading.Thread(target=self._keep, name="pages", daemon=True)
            self._thread.start()
            if self.options.browse and "duration" not in self.options.given:
                words = read_tokens(self.options.token)
                token = words.get(TRAINEE_ROLE.name, words.get(ANY_ROLE, ""))
                offer_choice(lambda: self._url, token)
        elif url != before and self._process is not None:
            self._process.ask_to_end()  # and it is begun again, for this one

    def close(self) -> None:
        """End the process, whatever it still has to send, and free the address."""
        with self._lock:
            self._closing.set()
        if self._process is not None:
            self._process.ask_to_end()
            self._process.end(CLOSE_TIMEOUT_S)
        if self._thread is not None:
            self._thread.join()
        self.listener.close()

    def _begin(self, *, opens: bool) -> None:
        """Start a process, unless the session ends; announce it if the system has no room."""
        inherited = (self.listener.fileno(),) if INHERITS_SOCKETS else ()
        self._process = None
        try:
            with self._lock:
                if not self._closing.is_set():
                    self._process = ServerProcess(self._words(opens=opens), inherited)
        except OSError as error:
            self._tell(f"the pages' server cannot begin: {error.strerror}; it is tried again")

    def _words(self, *, opens: bool) -> Sequence[str]:
        """Return the command of the process."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        words = ["web", "--connect", self._url, "--web", f"{host}:{self.port}"]
        words += ["--owner", str(self.listener.fileno() if INHERITS_SOCKETS else -1)]
        words += ["--open" if opens else "--no-open"]
        for name in ("cert", "key", "public_url"):
            value = getattr(self.options, name)
            words += [f"--{name.replace('_', '-')}", str(value)] if value else []
        for address in self.options.proxy:
            words += ["--proxy", address]
        return words

    def _keep(self) -> None:
        """Start the process again whenever it has died or hangs."""
        wait = FIRST_RESTART_S
        while True:
            begun = time.monotonic()
            trouble = self._await_trouble()
            wait = FIRST_RESTART_S if time.monotonic() - begun >= STEADY_TIME_S else wait
            if self._closing.wait(wait):
                return
            if trouble is None:
                self._tell("there are no pages: their server was refused")
                return
            self._tell(trouble)
            wait = min(2.0 * wait, MAX_WAIT_S)
            self._begin(opens=False)

    def _await_trouble(self) -> str | None:
        """Return how the process ended, None if a restart would end likewise."""
        if self._process is None:
            return "the pages' server is tried again"
        hangs = self._process.hangs()
        code = self._process.end(0.0 if hangs else CLOSE_TIMEOUT_S)
        if hangs:
            return f"the pages' server hangs: silent for {SILENCE_TIMEOUT_S} s; it begins again"
        if code == WRONG_INPUT:
            return None
        return f"the pages' server has ended with {code}, and begins again"


@contextlib.contextmanager
def serving_pages(options: RunOptions) -> Iterator[PageServer | None]:
    """Yield the server of the pages, None where none are asked for; ConfigError."""
    if not (options.browse or options.web):
        yield None
        return
    option = "--web-at" if options.browse else "--web"
    with refusing(option):
        host, port = parse_address(options.web or EXAMPLE_ADDRESS, EXAMPLE_ADDRESS)
    refuse_open_door(option, host, read_tokens(options.token))
    listener = listen_for_browsers(option, host, port, insists=options.web is not None)
    server = PageServer(host, listener, listener.getsockname()[1], options)
    try:
        yield server
    finally:
        server.close()


def listen_for_browsers(option: str, host: str, port: int, *, insists: bool) -> socket.socket:
    """Return a socket that listens for browsers; ConfigError if the named port is taken.

    If the default port is taken, it listens at any free one.
    """
    if not insists:
        with contextlib.suppress(LinkError):
            return listen_at(host, port)
    with refusing(option):
        return listen_at(host, port if insists else 0)
