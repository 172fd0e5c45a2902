"""A line carries text in and out at any port. It never holds up the caller.

Threads behind each port do the waiting, because the session's tick cannot wait for a terminal.
A port is a `write` of bytes, or a `read` that waits for bytes: b"" when none have come for a while,
None at the end of the input. What a port raises (OSError; ValueError once it is closed) ends it.
"""

import os
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final, Protocol

from trainer.io.lines import LineDecoder, OverlongLine, line_bytes
from trainer.io.orders.grammar import MAX_LINE_LETTERS

CHUNK_BYTES = 4096  # [bytes]
# [s]  An inbox gets this long to notice that its port was closed, even if the outbox used up all
# of the patience.
MIN_CLOSE_WAIT_S = 0.2


class Sender(Protocol):
    """A place to send lines to."""

    @property
    def dropped(self) -> int:
        """Return how many lines were sent and did not get out."""

    @property
    def trouble(self) -> str:
        """Return why the port is dead. It is "" while it lives or after a proper end."""

    @property
    def room(self) -> bool:
        """Return whether little waits to go out; who has much to send waits for it."""

    def send(self, line: str) -> None:
        """Take one line, without its end."""

    def close(self, patience: float) -> None:
        """Write out what was sent, for at most `patience` [s], and end."""


class Outbox:
    """Write lines from a thread. When the port is slow, lines are dropped.

    It holds three of the longest answers (``casualties``, some 150 lines) with news beside them.
    """

    def __init__(
        self, write: Callable[[bytes], object], capacity: int = 512, line_end: bytes = b"\r\n"
    ) -> None:
        self.dropped = 0
        self.trouble = ""
        self._write = write
        self._capacity = capacity
        self._line_end = line_end
        self._lines: deque[bytes] = deque()
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="outbox", daemon=True)
        self._thread.start()

    @property
    def room(self) -> bool:
        """Return whether little waits to go out."""
        return len(self._lines) < self._capacity // 4

    def send(self, line: str) -> None:
        """Queue one line. A full queue or a dead port drops and counts it."""
        with self._change:
            if self.trouble or self._closing or len(self._lines) >= self._capacity:
                self.dropped += 1
                return
            self._lines.append(line_bytes(line) + self._line_end)
            self._change.notify()

    def close(self, patience: float) -> None:
        """Finish the queue, for at most `patience` [s]. The port stays open."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._thread.join(patience)

    def _run(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._lines or self._closing)
                if not self._lines:
                    return
                batch = list(self._lines)
                self._lines.clear()
            try:
                self._write(b"".join(batch))
            except (OSError, ValueError) as error:
                with self._change:
                    self.trouble = str(error) or type(error).__name__
                    self.dropped += len(batch) + len(self._lines)
                    self._lines.clear()
                return


class DirectSender:
    """Write lines at once in the caller's thread, for runs without a clock."""

    room: Final = True

    def __init__(self, write: Callable[[bytes], object], line_end: bytes = b"\r\n") -> None:
        self.dropped = 0
        self.trouble = ""
        self._write = write
        self._line_end = line_end

    def send(self, line: str) -> None:
        """Write one line, or count it as dropped once the port is dead."""
        if self.trouble:
            self.dropped += 1
            return
        try:
            self._write(line_bytes(line) + self._line_end)
        except (OSError, ValueError) as error:
            self.trouble = str(error) or type(error).__name__
            self.dropped += 1

    def close(self, patience: float) -> None:
        """Do nothing: every line is out already."""


class Inbox:
    """Read lines in a thread. `arrived` is set at every line and at the end of the input.

    When the queue is full the thread stops reading until there is room, so that a pipe loses
    nothing and a flood is held back at its source.
    """

    def __init__(
        self,
        read: Callable[[], bytes | None],
        arrived: threading.Event,
        capacity: int = 256,
        longest: int = MAX_LINE_LETTERS,
    ) -> None:
        self.arrived = arrived
        self.ended = False  # everything has been read; what is queued can still be taken
        self.trouble = ""  # why it ended, "" for a plain end of input
        self._read = read
        self._decoder = LineDecoder(longest)
        self._capacity = capacity
        self._lines: deque[str | OverlongLine] = deque()
        self._change = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="inbox", daemon=True)
        self._thread.start()

    @property
    def waiting(self) -> int:
        """Return how many lines have arrived and have not been taken."""
        return len(self._lines)

    def take(self, most: int | None = None) -> list[str | OverlongLine]:
        """Return the oldest lines that have arrived, at most so many, without waiting."""
        with self._change:
            count = len(self._lines) if most is None else min(most, len(self._lines))
            lines = [self._lines.popleft() for _ in range(count)]
            self._change.notify()
        return lines

    def close(self, patience: float) -> None:
        """Ask the thread to stop after its read. Wait at most `patience` [s]."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._thread.join(patience)

    def _run(self) -> None:
        try:
            while not self._closing and (data := self._read()) is not None:
                self._queue(self._decoder.feed(data))
            # A pipe's last line often lacks its end.
            self._queue(self._decoder.feed(b"\n") if self._decoder.held else [])
        except (OSError, ValueError) as error:
            self.trouble = str(error) or type(error).__name__
        self.ended = True
        self.arrived.set()

    def _queue(self, lines: list[str | OverlongLine]) -> None:
        for line in lines:
            with self._change:
                self._change.wait_for(lambda: len(self._lines) < self._capacity or self._closing)
                self._lines.append(line)
            self.arrived.set()


def reader(descriptor: int) -> Callable[[], bytes | None]:
    """Return a `read` of a file descriptor, such as that of standard input.

    It does not use Python's buffered files, because a thread that still waits at exit would hold
    their locks.
    """

    def read() -> bytes | None:
        return os.read(descriptor, CHUNK_BYTES) or None

    return read


def writer(descriptor: int) -> Callable[[bytes], None]:
    """Return a `write` to a file descriptor that takes all of its bytes."""

    def write(data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(descriptor, rest) :]

    return write


class Line(Sender, Protocol):
    """One attached end: a terminal, a serial panel, a client at a socket."""

    @property
    def name(self) -> str:
        """Return what the line is called in messages."""

    @property
    def ended(self) -> bool:
        """Return whether all that came has been taken, and nothing more can come."""

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the oldest lines that have come, at most so many."""


class Port(Protocol):
    """A port that an inbox reads and an outbox writes."""

    @property
    def unsent(self) -> int:
        """Return how many lines it was given and could not write whole."""

    def close(self) -> None:
        """End both directions: a read or a write that waits returns."""

    def release(self) -> None:
        """Give the port back, once nothing waits for it any more."""


class JoinedLine:
    """A line made of an optional inbox, and somewhere to send.

    A terminal has no port to close. So its inbox still waits for a key when the program ends.
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

    @property
    def room(self) -> bool:
        """Return whether little waits to go out."""
        return self._sender.room

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the oldest lines that have come, at most so many."""
        return self._inbox.take(most) if self._inbox else []

    def send(self, line: str) -> None:
        """Take one line, without its end."""
        self._sender.send(line)

    def close(self, patience: float) -> None:
        """Write out what was sent, for at most `patience` [s], and end the line."""
        end = time.monotonic() + patience
        # What was sent goes out before the port closes, since a closed port loses it.
        self._sender.close(patience)
        if self._port:
            self._port.close()
        if self._inbox:
            self._inbox.close(max(end - time.monotonic(), MIN_CLOSE_WAIT_S) if self._port else 0.0)
        if self._port:
            self._port.release()
