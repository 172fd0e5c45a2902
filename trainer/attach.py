"""A teletype on a session: what is typed goes to it, what it says is printed."""

import threading
from collections.abc import Iterable

from trainer.io.line import Line
from trainer.io.lines import Overlong
from trainer.io.outbox import Inbox, Outbox, Sender, reader, writer

PATIENCE = 0.5  # [s] for what is still to be printed at the end


def attach(
    line: Line, first: Iterable[str], inbox: Inbox, out: Sender, wake: threading.Event
) -> str:
    """Say ``first``, then carry lines both ways until the session closes; return why it did.

    The end of the input leaves the teletype listening; "detach" and Ctrl-C leave the session.
    """
    for words in first:
        line.send(words)
    while not line.ended:
        wake.wait()
        wake.clear()
        for said in line.take(1000):
            if not isinstance(said, Overlong):
                out.send(said)
        for typed in inbox.take():
            if not isinstance(typed, Overlong):
                line.send(typed)
    return line.trouble


def terminal(wake: threading.Event) -> tuple[Inbox, Outbox]:
    """Return the terminal's two sides."""
    return Inbox(reader(0), wake), Outbox(writer(1), line_end=b"\n")
