"""A teletype on a session: what is typed goes to it, what it says is printed."""

import os
import signal
import threading
from typing import Final

import click

from trainer.config.files import ConfigError
from trainer.io import paths
from trainer.io.client import dial
from trainer.io.line import Inbox, Line, Outbox, reader, writer
from trainer.io.lines import Overlong
from trainer.io.serial_line import LinkError

OVER: Final = "the session is over"  # its last words
BYE: Final = "bye"  # its last words to one that detaches
PATIENCE: Final = 2.0  # [s] for what is still to be said at the end


def attach_to(url: str | None, role: str, token: str | None) -> int:
    """Be a teletype of that role until the session or the user ends it; return the exit code."""
    wake = threading.Event()
    try:
        line = dial(url or paths.nearest_session(), wake)
    except LinkError as error:
        raise ConfigError(str(error)) from None
    first = [f"role {role}{f' {token}' if token else ''}"]
    if os.isatty(0):
        first.append("subscribe teletype")
    for words in first:
        line.send(words)
    inbox, out = Inbox(reader(0), wake), Outbox(writer(1), line_end=b"\n")
    last = carry(line, inbox, out, wake)
    line.close(PATIENCE)
    out.close(PATIENCE)
    if last in (OVER, BYE):
        return 0
    click.echo(f"trainer: {line.name}: the session is gone: {line.trouble or 'closed'}", err=True)
    return 1


def carry(line: Line, inbox: Inbox, out: Outbox, wake: threading.Event) -> str:
    """Carry lines both ways until the session closes; return the last that it said.

    Ctrl-C, and the end of an input that nobody types, leave the session.
    """
    last = ""
    left = False
    kept = signal.signal(signal.SIGINT, lambda *_: line.send("detach"))
    try:
        while not line.ended:
            wake.wait()
            wake.clear()
            for typed in inbox.take():
                if not isinstance(typed, Overlong):
                    line.send(typed)
            if inbox.ended and not inbox.waiting and not left and not os.isatty(0):
                left = True
                line.send("detach")
            for said in line.take(1000):
                if not isinstance(said, Overlong):
                    out.send(said)
                    last = said
    finally:
        signal.signal(signal.SIGINT, kept)
    return last
