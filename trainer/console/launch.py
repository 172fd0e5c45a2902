"""The start of a screen on a session that runs: ``trainer attach`` and ``trainer run``.

The line to the session is tried first, so that an error is told on a plain terminal and not under a
screen that closes.
"""

import gc
import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from trainer.config.files import ConfigError
from trainer.console.app import Console
from trainer.console.client import Client, Item, RoleTaken
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.io import paths
from trainer.io.orders.grammar import Refused
from trainer.io.serial_line import LinkError

CLOSE_TIMEOUT_S: Final = 2.0  # [s] for the line to be closed
LEAVE_TIMEOUT_S: Final = 3.0  # [s] for a screen that is asked to end


def attend_session(url: str | None, role: str, token: str | None) -> int:
    """Show the screen of a role until its user leaves; return the exit code."""
    token = token or paths.left_token(url)  # where the system has no local sockets
    visit = Visit.prepare(lambda: url or paths.nearest_session(), role, token)
    try:
        visit.client.dial()
    except LinkError as error:
        raise ConfigError(str(error)) from None
    if refused := visit.show():
        raise ConfigError(refused.reason)
    return 0 if visit.model.joined or visit.model.over else 1


@dataclass
class Visit:
    """A screen and its line to a session, ready before there need be one."""

    client: Client
    model: SessionModel
    console: Console

    @classmethod
    def prepare(
        cls, url: Callable[[], str], role: str, token: str | None, *, own: bool = False
    ) -> "Visit":
        """Return the screen of a role at ``url()``. A session of its ``own`` ends with it."""
        post = LAYOUTS[role]
        client = Client(url, f"{role} {token or ''}".rstrip(), wishes(post))
        model = SessionModel(client, role, post.charts)
        forget_size()
        return cls(client, model, Console(model, own=own))

    def show(self) -> Refused | None:
        """Show the screen until its user leaves. Return why the session did not let it in."""
        self.client.start()
        gc.freeze()  # the first picture waits for nobody to look through what draws it
        # With its terminal gone the screen may wait for ever to write what ends it.
        last = threading.Timer(LEAVE_TIMEOUT_S, os._exit, (1,))
        last.daemon = True

        def end(*_: object) -> None:
            self.console.exit()
            if not last.ident:
                last.start()

        handlers = {number: signal.signal(number, end) for number in ending_signals()}
        threading.Thread(target=watch_terminal, daemon=True).start()
        try:
            refused = self.console.run()
            while self.model.chair:
                self._change_chair()
                refused = self.console.run()
        finally:
            last.cancel()
            for number, handler in handlers.items():
                signal.signal(number, handler)
            self.client.close(CLOSE_TIMEOUT_S)
        return refused

    def _change_chair(self) -> None:
        """Make the screen of the role that the line has taken, which has seen nothing yet."""
        old, post = self.model, LAYOUTS[self.model.chair]
        self.client.take_chair(post.role, wishes(post))
        unread: list[Item] = [RoleTaken(), *old.unread]
        self.model = SessionModel(self.client, post.role, post.charts, unread=unread)
        self.console = Console(self.model, own=self.console.own)


def forget_size() -> None:
    """Take no size from the environment. It may be that of another window, or of an earlier one.

    Shells, and whoever reads lines typed, leave it there for the programs that they start.
    """
    for name in ("COLUMNS", "LINES"):
        os.environ.pop(name, None)


def watch_terminal() -> None:
    """Hang this process up when the terminal at its input goes.

    The system does so itself only where that terminal is the one that controls the process. Without
    it the screen would wait for ever to write, and read nothing again and again.
    """
    if not hasattr(select, "poll"):
        return
    terminal = select.poll()
    terminal.register(sys.stdin.fileno(), 0)  # no event but that it hangs up, or is no terminal
    if any(event & select.POLLHUP for _, event in terminal.poll()):
        os.kill(os.getpid(), signal.SIGHUP)


def ending_signals() -> tuple[int, ...]:
    """Return the signals that ask the console to end."""
    return tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
