"""A line: lines in and lines out, whatever the port, without ever holding up the caller."""

import time
from typing import Protocol

from trainer.io.lines import Overlong
from trainer.io.outbox import Inbox, Sender

SHORTEST = 0.2  # [s]  for an inbox to notice that its port was closed, whatever the outbox took


class Line(Protocol):
    """One attached end: a terminal, a serial panel, a client at a socket."""

    @property
    def name(self) -> str:
        """Return what the line is called in messages."""
        ...

    @property
    def ended(self) -> bool:
        """Return whether all that came has been taken, and nothing more can come."""
        ...

    @property
    def trouble(self) -> str:
        """Return why the line is dead, "" while it lives or when it ended in good order."""
        ...

    @property
    def dropped(self) -> int:
        """Return how many lines were sent and did not get out."""
        ...

    def take(self, most: int) -> list[str | Overlong]:
        """Return the oldest lines that have come, at most so many."""
        ...

    def send(self, line: str) -> None:
        """Take one line, without its end."""
        ...

    def close(self, patience: float) -> None:
        """Get out what was sent, for at most `patience` [s], and end the line."""
        ...


class Port(Protocol):
    """What an inbox reads and an outbox writes."""

    @property
    def unsent(self) -> int:
        """Return how many lines it was given to write and did not get out whole."""
        ...

    def close(self) -> None:
        """End both directions: a read or a write that waits returns."""
        ...

    def release(self) -> None:
        """Give the port back, once nothing waits for it any more."""
        ...


class Joined:
    """A line made of an inbox, or none where nothing is heard, and somewhere to send.

    A terminal has no port to close: its inbox is left waiting for a key that nobody will press.
    """

    def __init__(
        self, name: str, inbox: Inbox | None, sender: Sender, port: Port | None = None
    ) -> None:
        self.name = name
        self._inbox = inbox
        self._sender = sender
        self._port = port

    @property
    def ended(self) -> bool:
        """Return whether all that came has been taken, and nothing more can come."""
        return self._inbox is None or (self._inbox.ended and not self._inbox.waiting)

    @property
    def trouble(self) -> str:
        """Return why the port is dead for reading or for writing."""
        return (self._inbox.trouble if self._inbox else "") or self._sender.trouble

    @property
    def dropped(self) -> int:
        """Return how many lines were sent and did not get out."""
        return self._sender.dropped + (self._port.unsent if self._port else 0)

    def take(self, most: int) -> list[str | Overlong]:
        """Return the oldest lines that have come, at most so many."""
        return self._inbox.take(most) if self._inbox else []

    def send(self, line: str) -> None:
        """Take one line, without its end."""
        self._sender.send(line)

    def close(self, patience: float) -> None:
        """Get out what was sent, for at most `patience` [s], and end the line."""
        end = time.monotonic() + patience
        self._sender.close(patience)
        if self._port:
            self._port.close()
        if self._inbox:
            self._inbox.close(max(end - time.monotonic(), SHORTEST) if self._port else 0.0)
        if self._port:
            self._port.release()
