"""One client of a session, at a socket. Nobody waits for its lines.

Both queues have a limit, because a client may be slow, or send without end. Any thread may take,
send and close. All else is called by the server's thread alone (``server``), which waits for many
sockets at once and calls a connection when its socket is ready.
"""

import math
import re
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable

from trainer.io.lines import LineDecoder, OverlongLine, line_bytes
from trainer.io.machine import machine_of
from trainer.io.orders.grammar import MAX_LINE_LETTERS

CHUNK_BYTES = 4096  # [bytes]  read at once
MAX_WAITING_LINES = 256  # [lines]  waiting to be taken; beyond it the socket is not read
# Waiting to be sent; beyond it lines are dropped. A newcomer is sent all kept events at once, which
# the limit holds.
MAX_OUTGOING_LINES = 2048  # [lines]
MAX_OUTGOING_BYTES = 262_144  # [bytes]
MAX_READ_RATE = 65536.0  # [bytes/s]  read at most, so that a flood costs the boat's thread nothing
BURST_BYTES = 16384.0  # [bytes]  read at once before the pace is kept

# The first line of a program of this user that carries a line of somebody else's, such as a page's:
# which machine that is, as the PROXY protocol has it, version 1.
PROXY_PATTERN = re.compile(r"PROXY TCP[46] ([0-9A-Fa-f:.]+) .*")
OWN_MACHINE = "here"  # the machine of a program of this user

# A page in a browser can post orders to a port of its own machine, where no token is asked for.
BROWSER_PATTERN = re.compile(rb"(?:GET|HEAD|POST|PUT|PATCH|DELETE|OPTIONS|CONNECT|TRACE) ")

READ_EVENT, WRITE_EVENT = selectors.EVENT_READ, selectors.EVENT_WRITE


def carried_for(host: str) -> str:
    """Return the line that names the machine whose lines follow; see PROXY_PATTERN."""
    family = "TCP6" if ":" in host else "TCP4"
    return f"PROXY {family} {host.partition('%')[0]} 127.0.0.1 0 0"


class Connection:
    """One client; a line of trainer.io.line.

    Half a line at the end of the input is not obeyed, because the client may have died within an
    order.
    """

    def __init__(
        self,
        end: socket.socket,
        name: str,
        arrived: threading.Event,
        stir: Callable[[], None],
        longest: int = MAX_LINE_LETTERS,
    ) -> None:
        self.name = name
        self.trouble = ""
        self.dropped = 0
        self.known = False  # it has taken a role, with its token where one is needed
        self.guessed = False  # it has given a wrong token
        self.local = False  # it is of this machine and this user
        self.machine = ""  # where it comes from, once that is known
        self.introduce_by = math.inf  # [s]  when that has to be said
        self.watched = 0  # the events that the server waits for at its socket
        end.settimeout(0.0)
        self._end = end
        self._arrived = arrived  # set when there is something to take, and at the end
        self._stir = stir  # makes the hub ask again
        self._lock = threading.Lock()
        self._decoder = LineDecoder(longest)
        self._heard: deque[str | OverlongLine] = deque()
        self._said: deque[bytes] = deque()
        self._said_bytes = 0
        self._asks = False  # a line was taken, and no answer was sent since
        self._over = False  # no more input
        self._gone = False  # no more output either
        self._leave_at = math.inf  # [s]  when it is closed, all sent or not
        self._said_goodbye = False
        self._read_until = 0.0  # [s]  when all that has been read would have come at the pace

    @property
    def ended(self) -> bool:
        """Return whether all that came has been taken, and nothing more can come."""
        return self._over and not self._heard

    @property
    def leaving(self) -> bool:
        """Return whether ``close`` was called. Lines may still be on their way."""
        return self._leave_at < math.inf

    @property
    def stranger(self) -> bool:
        """Return whether it came by TCP and has not yet said who it is."""
        return not (self.known or self.local)

    @property
    def worth(self) -> tuple[bool, bool]:
        """Return the rank of a stranger; the lowest gives way when places are full.

        A client that has hung up ranks lowest, because it needs no place. One that has given a
        wrong token ranks below one that has not tried yet.
        """
        return not self._over, not self.guessed

    @property
    def room(self) -> bool:
        """Return whether little waits to go out."""
        return (
            len(self._said) < MAX_OUTGOING_LINES // 4 and self._said_bytes < MAX_OUTGOING_BYTES // 4
        )

    def introduce(self) -> None:
        """Note that the client has said who it is."""
        self.known = True

    def grant(self, seconds: float) -> None:
        """Give the client some seconds more, because its token was wrong."""
        self.introduce_by += seconds
        self.guessed = True

    def take(self, most: int) -> list[str | OverlongLine]:
        """Return the oldest lines that have come, at most so many."""
        with self._lock:
            held_back = len(self._heard) >= MAX_WAITING_LINES
            lines = [self._heard.popleft() for _ in range(min(most, len(self._heard)))]
            self._asks = self._asks or bool(lines)
        if held_back:
            self._stir()
        return lines

    def send(self, line: str) -> None:
        """Queue one line, or drop and count it when the client is slow or gone.

        The first line after one was taken is most likely its answer. It goes out at once, because
        the server's thread may be busy with other clients.
        """
        data = line_bytes(line) + b"\r\n"
        with self._lock:
            full = (
                len(self._said) >= MAX_OUTGOING_LINES
                or self._said_bytes + len(data) > MAX_OUTGOING_BYTES
            )
            if self._gone or full or self.leaving:
                self.dropped += 1
                return
            quiet = not self._said
            if quiet and self._asks:
                data = data[self._send_now(data) :]
            self._asks = False
            if data:
                self._said.append(data)
                self._said_bytes += len(data)
        if quiet and data:
            self._stir()

    def close(self, patience: float) -> None:
        """End the connection once all is sent, after `patience` [s] at most; returns at once."""
        leave_at = time.monotonic() + patience
        with self._lock:
            sooner = leave_at < self._leave_at
            self._leave_at = min(self._leave_at, leave_at)
            self._heard.clear()
        if sooner:  # the hub closes all in each round: it would ring its own bell without end
            self._stir()

    # The server's thread alone calls what follows.

    def wants(self, now: float) -> int:
        """Return the events to wait for at `now` [s]: READ_EVENT, WRITE_EVENT, both or 0."""
        reads = not self._over and len(self._heard) < MAX_WAITING_LINES and now >= self._rested
        return READ_EVENT * reads | WRITE_EVENT * bool(self._said)

    def due(self, now: float) -> float:
        """Return when [s] to look again without any event, infinity for never."""
        silent = math.inf if self.known or self.leaving else self.introduce_by
        return min(self._leave_at, silent, self._rested if now < self._rested else math.inf)

    def overdue(self, now: float) -> bool:
        """Return whether the time to say who it is has run out."""
        return now >= self.introduce_by and not (self.known or self.leaving)

    def finished(self, now: float) -> bool:
        """Return whether the socket can be closed; say goodbye to the client first."""
        if self._gone:
            return True
        if now >= self._leave_at:
            self.serve(WRITE_EVENT)  # a server that had no processor may not have tried before
            return True
        if self._said or not self.leaving:
            return False
        if not self._said_goodbye:
            self._said_goodbye = True
            self._shut_down()
        # The client's own end is awaited: closing over unread input would cut off what was sent.
        return self._over

    def serve(self, ready: int) -> None:
        """Read and write as much as is possible without waiting."""
        try:
            if ready & READ_EVENT:
                self._read()
            if ready & WRITE_EVENT:
                self._write()
        except BlockingIOError:
            return
        except OSError as error:
            self._die(error.strerror or str(error))

    def dispose(self) -> None:
        """Close the socket, counting what was not sent."""
        self._die(self.trouble)
        self._end.close()

    def fileno(self) -> int:
        """Return the socket's descriptor."""
        return self._end.fileno()

    @property
    def _rested(self) -> float:
        """Return when [s] it may be read again, by MAX_READ_RATE."""
        return self._read_until - BURST_BYTES / MAX_READ_RATE

    def _send_now(self, data: bytes) -> int:
        """Return how many bytes went out at once. The caller holds the lock; the queue is empty."""
        try:
            return self._end.send(data)
        except OSError:
            return 0  # the server's thread meets the same error, and ends the connection

    def _read(self) -> None:
        data = self._end.recv(CHUNK_BYTES)
        if not self._read_until and BROWSER_PATTERN.match(data):
            self._die("a web browser, not a station")
            return
        self._read_until = max(self._read_until, time.monotonic()) + len(data) / MAX_READ_RATE
        lines = self._decoder.feed(data)
        if self.local and lines and not self.machine:
            lines = self._learn_machine(lines)
        if lines and self.introduce_by == math.inf:  # nobody asks who it is
            self.known = True
        with self._lock:
            if not self.leaving:
                self._heard.extend(lines)
            self._over = self._over or not data
        if lines or not data:
            self._arrived.set()

    def _learn_machine(self, lines: list[str | OverlongLine]) -> list[str | OverlongLine]:
        """Return lines without a first one that names their machine, which is noted."""
        first = lines[0]
        carried = PROXY_PATTERN.fullmatch(first) if isinstance(first, str) else None
        self.machine = machine_of(carried[1]) if carried else OWN_MACHINE
        return lines[1:] if carried else lines

    def _write(self) -> None:
        if not self._said:
            return
        with self._lock:
            batch = b"".join(self._said)
        sent = self._end.send(batch)
        with self._lock:
            self._said_bytes -= sent
            while sent:
                line = self._said.popleft()
                if sent < len(line):
                    self._said.appendleft(line[sent:])
                sent -= min(sent, len(line))

    def _shut_down(self) -> None:
        try:
            self._end.shutdown(socket.SHUT_WR)
        except OSError as error:
            self._die(error.strerror or str(error))

    def _die(self, trouble: str) -> None:
        with self._lock:
            self.trouble = trouble
            self._over = self._gone = True
            self.dropped += len(self._said)
            self._said.clear()
            self._said_bytes = 0
        self._arrived.set()
