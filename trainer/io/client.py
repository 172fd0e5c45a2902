"""The far end of a session's line, by TCP, local socket or serial port.

The console, ``trainer attach`` and the pages' server use it. All three give the same ``Line``, so
that none of these has to know which it is.
"""

import contextlib
import errno
import os
import re
import socket
import struct
import threading
from pathlib import Path

from trainer.io.line import CHUNK_BYTES, Inbox, JoinedLine, Line, Outbox
from trainer.io.orders.sentences import MAX_ANSWER_LETTERS, parse_sentence
from trainer.io.serial_line import LinkError, SerialLine

ANSWER_TIMEOUT_S = 5.0  # [s]  for a session to answer
TCP_PATTERN = re.compile(r"(?:tcp|socket)://(?:\[([^\]]+)\]|([^:/]+)):([0-9]{1,5})/?")
OTHER_PATTERN = re.compile(r"/dev/|(?!local:)[a-z0-9+]{2,}:")  # no socket's
MAX_PORT = 65535  # of TCP
LOCAL_PREFIX = "local:"
PEER_STRUCT = struct.Struct("3i")  # process, user and group at the far end
OTHER_USER_TEXT = "that session is another user's; ask for a port of it"
NO_SESSION_TEXT = "no session listens there; start one: trainer run or trainer serve"
ABSENT_ERRORS = frozenset({errno.ECONNREFUSED, errno.ENOENT, errno.ENOTSOCK})


def dial(url: str, arrived: threading.Event, baud: int = 9600) -> Line:
    """Return a line to the session at `url`; raises LinkError with the next step.

    `tcp://HOST:PORT` or `socket://HOST:PORT`, `local:PATH` or the path of a socket, any other
    pyserial URL or device. `arrived` is set whenever lines have come, and at the end.
    """
    end = connect_socket(url)
    if end is not None:
        wire = Wire(end)
        inbox = Inbox(wire.read, arrived, longest=MAX_ANSWER_LETTERS)
        return JoinedLine(url, inbox, Outbox(wire.write), wire)
    return over_serial(url, SerialLine(url, baud), arrived, MAX_ANSWER_LETTERS)


def answer_of(line: Line, arrived: threading.Event, tag: str) -> tuple[str, str]:
    """Return "ok" or "no", and the text, by which a session answers an order; LinkError."""
    while arrived.wait(ANSWER_TIMEOUT_S) and not line.ended:
        arrived.clear()
        for said in line.take(1000):
            sentence = parse_sentence(said) if isinstance(said, str) else None
            if sentence and sentence.tag == tag and sentence.fields[0] in ("ok", "no"):
                return sentence.fields[0], sentence.fields[-1]
    raise LinkError(f"{line.name}: no answer: is that a session?")


def reach(url: str) -> socket.socket:
    """Return a socket connected to the session at `url`; raises LinkError with the next step."""
    end = connect_socket(url)
    if end is None:
        raise LinkError(f"{url}: say tcp://HOST:PORT or the path of a local socket")
    return end


def check(url: str) -> None:
    """Check that `url` can be that of a socket, even without a session there; LinkError."""
    address = TCP_PATTERN.fullmatch(url)
    if address and not 0 < int(address[3]) <= MAX_PORT:
        raise LinkError(f"{url}: a port is 1 to {MAX_PORT}")
    if not address and OTHER_PATTERN.match(url):
        raise LinkError(f"{url}: say tcp://HOST:PORT or the path of a local socket")


def connect_socket(url: str) -> socket.socket | None:
    """Return a socket connected to the session at `url`, None for a serial line."""
    address = TCP_PATTERN.fullmatch(url)
    if address:
        return reach_tcp(url, address[1] or address[2], int(address[3]))
    if url.startswith(("tcp:", "socket:")):
        raise LinkError(f"{url}: say tcp://HOST:PORT")
    path = Path(url.removeprefix(LOCAL_PREFIX))
    if url.startswith(LOCAL_PREFIX) or path.is_socket():
        return reach_local(path)
    if path.is_absolute() and not path.exists() and path.parts[1:2] != ("dev",):
        raise LinkError(f"{url}: {NO_SESSION_TEXT}")
    return None


def over_serial(name: str, port: SerialLine, arrived: threading.Event, longest: int) -> Line:
    """Return an open serial port as a line; lines in have `longest` characters at most."""
    return JoinedLine(name, Inbox(port.read, arrived, longest=longest), Outbox(port.write), port)


def reach_tcp(url: str, host: str, port: int) -> socket.socket:
    """Return a socket connected to a TCP port; LinkError."""
    if not 0 < port <= MAX_PORT:
        raise LinkError(f"{url}: a port is 1 to {MAX_PORT}")
    try:
        end = socket.create_connection((host, port), timeout=ANSWER_TIMEOUT_S)
    except (OSError, UnicodeError) as error:
        raise LinkError(f"{url}: {why_not(error)}") from error
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)  # an order goes out at once
    end.settimeout(None)
    return end


def reach_local(path: Path) -> socket.socket:
    """Return a socket connected to the local one at `path`; LinkError."""
    if not hasattr(socket, "AF_UNIX"):
        raise LinkError(f"{path}: this system has no local sockets; say tcp://HOST:PORT")
    end = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    end.settimeout(ANSWER_TIMEOUT_S)
    try:
        end.connect(str(path))
        refuse_another(end, path)
    except OSError as error:
        end.close()
        raise LinkError(f"{path}: {why_not(error)}") from error
    except LinkError:
        end.close()
        raise
    end.settimeout(None)
    return end


def refuse_another(end: socket.socket, path: Path) -> None:
    """Raise LinkError if another user's program listens there.

    It could have taken the path first, and must get no token and no order.
    """
    if not hasattr(os, "geteuid"):
        return
    owners = {path.stat().st_uid}
    if hasattr(socket, "SO_PEERCRED"):
        credentials = end.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, PEER_STRUCT.size)
        owners.add(PEER_STRUCT.unpack(credentials)[1])
    if owners != {os.geteuid()}:
        raise LinkError(f"{path}: {OTHER_USER_TEXT}")


def why_not(error: Exception) -> str:
    """Return why a session cannot be reached, and the next step."""
    if isinstance(error, socket.gaierror | UnicodeError):
        return "no such host; 127.0.0.1 is this machine"
    if isinstance(error, TimeoutError):
        return "no answer; is the address right, and nothing between that stops it?"
    if getattr(error, "errno", None) in ABSENT_ERRORS:
        return NO_SESSION_TEXT
    if getattr(error, "errno", None) == errno.EACCES:
        return OTHER_USER_TEXT
    return str(getattr(error, "strerror", None) or error)


class Wire:
    """A connected socket, which an inbox reads and an outbox writes, both waiting."""

    unsent = 0  # a write that fails ends the outbox, which counts

    def __init__(self, end: socket.socket) -> None:
        self._end = end

    def read(self) -> bytes | None:
        """Return what has come, None at the end; raises OSError when the line is lost."""
        return self._end.recv(CHUNK_BYTES) or None

    def write(self, data: bytes) -> None:
        """Write all of `data`."""
        self._end.sendall(data)

    def close(self) -> None:
        """End both directions; a read that waits returns."""
        with contextlib.suppress(OSError):
            self._end.shutdown(socket.SHUT_RDWR)

    def release(self) -> None:
        """Give the socket back."""
        self._end.close()
