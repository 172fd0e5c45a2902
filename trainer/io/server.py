"""The sockets of a session, local and TCP, served by one thread.

``session/doors/ports`` opens the server, and makes a station of each connection. The thread waits
for no single client. A client that does not read loses its own lines, one that sends too much is
read slowly, and the system's keepalive notices one that vanishes; none delays another. Sockets
listen at a TCP port, or at a path of this machine.
"""

import contextlib
import errno
import functools
import math
import os
import selectors
import socket
import stat
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from trainer.io import paths
from trainer.io.connection import (
    CHUNK_BYTES,
    MAX_OUTGOING_BYTES,
    READ_EVENT,
    WRITE_EVENT,
    Connection,
)
from trainer.io.machine import machine_of
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.serial_line import LinkError

LISTEN_BACKLOG = 128  # connections that the system keeps until they are taken
KNOCK_TIMEOUT_S = 1.0  # [s]  for a session that listens at a path to answer
MAX_PORT = 65535  # of TCP
MAX_CONNECTIONS = 32  # connections
RESERVED_CONNECTIONS = 8  # more, for lines of this machine and user
MAX_STRANGERS = 24  # that come by TCP and have not taken a role; the oldest gives way
MAX_REFUSED_LINES = 8  # clients that are being sent a refusal; others are cut off at once
REFUSAL_TIMEOUT_S = 1.0  # [s]  for a refused client to take the reason
FULL_PAUSE_S = 1.0  # [s]  without new connections after the system had no room for one
GATHER_TIME_S = 0.0005  # [s]  from the bell to a round, in which a burst of lines is queued
CLOSE_GRACE_S = 1.0  # [s]  beyond the patience, for the thread to end
NO_ROOM = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})
# A client whose machine has died is noticed after 30 + 3 * 10 s.
KEEPALIVE_OPTIONS = (("TCP_KEEPIDLE", 30), ("TCP_KEEPINTVL", 10), ("TCP_KEEPCNT", 3))


def parse_address(text: str, example: str) -> tuple[str, int]:
    """Return host and port of ``HOST:PORT`` or ``PORT``; LinkError if it is neither."""
    scheme, parted, rest = text.partition("://")
    if parted:
        raise LinkError(f"{text}: leave {scheme}:// out, say {rest.strip('/') or example}")
    host, _, port = text.rpartition(":")
    if not port.isdecimal():
        raise LinkError(f"{text}: say HOST:PORT, such as {example}")
    return host.strip("[]") or paths.DEFAULT_HOST, int(port)


def listen_at(host: str, port: int) -> socket.socket:
    """Return a socket that listens at a TCP port, 0 for any free one. Raises LinkError."""
    where = f"{host}:{port}"
    if not 0 <= port <= MAX_PORT:
        raise LinkError(f"{where}: a port is 1 to {MAX_PORT}, or 0 for any that is free")
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = addresses[0]
        return socket.create_server(address[:2], family=family, backlog=LISTEN_BACKLOG)
    except (OSError, UnicodeError) as error:
        raise LinkError(f"{where}: {why_not(error)}") from error


def why_not(error: Exception) -> str:
    """Return why a port cannot be listened at, and the next step."""
    if isinstance(error, socket.gaierror | UnicodeError):
        return "no such host; say 127.0.0.1 for this machine alone"
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return "in use already; give another port, or 0 for any that is free"
    if number == errno.EADDRNOTAVAIL:
        return "not an address of this machine; say 127.0.0.1, or 0.0.0.0 for all it has"
    if number == errno.EACCES:
        return "this port is the system's; give one above 1023"
    return system_message(error)


def system_message(error: Exception) -> str:
    """Return what the system said."""
    return str(getattr(error, "strerror", None) or error)


@dataclass(frozen=True)
class LocalSocket:
    """A socket that listens at a path, and the identity of its file there."""

    socket: socket.socket
    path: Path
    file: tuple[int, int]  # device and number

    def close(self) -> None:
        """Stop listening, and take the file away unless another has replaced it.

        The file goes first. Otherwise a new session could find the socket dead, replace its file,
        get the same file number from the system, and lose its own file here.
        """
        with contextlib.suppress(OSError):
            if identity(self.path) == self.file:
                self.path.unlink()
        self.socket.close()


def listen_here(path: Path) -> LocalSocket:
    """Return a socket that listens at `path`, for its owner only; raises LinkError."""
    if not hasattr(socket, "AF_UNIX"):
        raise LinkError(f"{path}: this system has no local sockets; listen at 127.0.0.1 instead")
    make_room(path)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        listener.bind(str(path))
        path.chmod(0o600)  # before it listens: until then nobody can connect
        listener.listen(LISTEN_BACKLOG)
        return LocalSocket(listener, path, identity(path))
    except OSError as error:
        listener.close()
        raise LinkError(f"{path}: {why_not_here(error)}") from error


def private_folder(folder: Path) -> None:
    """Make a folder of this user's own; LinkError if what is there could be another's.

    In a folder shared by all users, another user may have made the name first, or a link of it.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        refuse_shared(folder)
    except OSError as error:
        raise LinkError(f"{folder}: {system_message(error)}") from None


def refuse_shared(folder: Path) -> None:
    """Raise LinkError unless a folder is this user's alone.

    Its parent must belong to this user or the system, because its owner could replace the folder.
    """
    if not hasattr(os, "geteuid"):
        return
    status, above = os.lstat(folder), folder.parent.stat()
    is_private = stat.S_ISDIR(status.st_mode) and status.st_uid == os.geteuid()
    if not is_private or status.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise LinkError(
            f"{folder}: is not a folder of yours alone; remove it, or set XDG_RUNTIME_DIR to a "
            "folder that is"
        )
    shared = above.st_mode & stat.S_IWOTH and not above.st_mode & stat.S_ISVTX
    if shared or above.st_uid not in (0, os.geteuid()):
        raise LinkError(
            f"{folder.parent}: belongs to another user, or anybody may write there; set "
            "XDG_RUNTIME_DIR to a folder of yours"
        )


def make_room(path: Path) -> None:
    """Take away the socket of a dead session; refuse where something else is at `path`."""
    try:
        kind = path.lstat().st_mode
    except OSError:
        return  # nothing there, or bind will say what
    if not stat.S_ISSOCK(kind):
        raise LinkError(f"{path}: is there and is no socket; give another path")
    if socket_answers(path):
        raise LinkError(
            f"{path}: a session listens there; attach to it, or give this one another by --socket"
        )
    with contextlib.suppress(OSError):
        path.unlink()


def socket_answers(path: Path) -> bool:
    """Return whether anything listens at the socket `path`."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as knock:
        knock.settimeout(KNOCK_TIMEOUT_S)
        try:
            knock.connect(str(path))
        except (ConnectionRefusedError, FileNotFoundError):
            return False
        except OSError:
            return True  # too busy to answer, or another user's
        return True


def why_not_here(error: OSError) -> str:
    """Return why a path cannot be listened at, and the next step."""
    if error.errno is None:  # Python's own check of its length
        return "the path is too long for a socket; give a shorter one, of 100 bytes at most"
    if error.errno == errno.ENOENT:
        return "no such folder; make it, or give another path"
    return f"{system_message(error)}; give another path"


def identity(path: Path) -> tuple[int, int]:
    """Return device and number of the file at `path`, which no other file has."""
    status = os.lstat(path)
    return status.st_dev, status.st_ino


class Server:
    """The sockets of a session: those that listen and those connected."""

    def __init__(
        self,
        wake: threading.Event,
        introduction: float = math.inf,
        longest: int = MAX_LINE_LETTERS,
    ) -> None:
        """Close newcomers that do not say within ``introduction`` [s] who they are.

        ``wake`` is set at every newcomer, and whenever a connection has lines or ends. Lines of
        more than ``longest`` characters are dropped.
        """
        self._longest = longest
        self._wake = wake
        self._introduction = introduction
        self._selector = selectors.DefaultSelector()
        # ``select`` waits for sockets alone, so other threads wake it by a byte from bell to ear.
        self._bell, self._ear = socket.socketpair()
        for end in (self._bell, self._ear):
            end.settimeout(0.0)
        self._rung = False
        self._listeners: deque[tuple[socket.socket, socket.socket | LocalSocket]] = deque()
        self._connections: list[Connection] = []
        self._newcomers: deque[Connection] = deque()
        self._count = 0  # of local connections ever, for their names
        self._paused_until = 0.0  # [s]
        self._leave_at = math.inf  # [s]
        self._thread = threading.Thread(target=self._run, name="hub", daemon=True)
        self._thread.start()

    def listen(self, host: str, port: int) -> int:
        """Listen at a TCP port, 0 for any free one; return which, or raise LinkError."""
        access = listen_at(host, port)
        self._open(access, access)
        return int(access.getsockname()[1])

    def listen_here(self, path: Path) -> None:
        """Listen at a path of this machine, for its owner only; raises LinkError."""
        local: LocalSocket = listen_here(path)
        self._open(local.socket, local)

    def newcomers(self) -> list[Connection]:
        """Return the connections made since the last call."""
        return [self._newcomers.popleft() for _ in range(len(self._newcomers))]

    def close(self, patience: float) -> None:
        """Stop listening, send what is queued for at most `patience` [s], close all."""
        self._leave_at = time.monotonic() + patience
        self._stir()
        self._thread.join(patience + CLOSE_GRACE_S)

    def _open(self, access: socket.socket, listener: socket.socket | LocalSocket) -> None:
        access.settimeout(0.0)
        self._listeners.append((access, listener))
        self._stir()

    def _stir(self) -> None:
        """Wake the thread to look at all sockets again. Any thread may call this."""
        if not self._rung:
            self._rung = True
            with contextlib.suppress(OSError):  # closed: nothing is left to do
                self._bell.send(b"!")

    def _run(self) -> None:
        self._selector.register(self._ear, READ_EVENT, self._hear_bell)
        while True:
            now = time.monotonic()
            self._tend_listeners(now)
            self._tend_connections(now)
            if not self._connections and self._leave_at < math.inf:
                break
            for key, ready in self._selector.select(self._pause(now)):
                key.data(ready)
        while self._listeners:
            self._listeners.popleft()[1].close()
        self._selector.close()
        self._bell.close()
        self._ear.close()

    def _hear_bell(self, _ready: int) -> None:
        # An order is told to each station in turn. Without the wait a round of all sockets would
        # come between any two of them; the answer itself is not queued (``Connection.send``).
        time.sleep(GATHER_TIME_S)
        self._ear.recv(CHUNK_BYTES)
        self._rung = False

    def _tend_listeners(self, now: float) -> None:
        opened = now >= self._paused_until and math.isinf(self._leave_at)
        for access, _ in tuple(self._listeners):  # another thread may open one
            self._watch(access, READ_EVENT * opened, functools.partial(self._admit, access))

    def _tend_connections(self, now: float) -> None:
        for connection in list(self._connections):
            if self._leave_at < math.inf:
                connection.close(self._leave_at - now)
            if connection.overdue(now):
                connection.send("? closed: nobody said who is here: role NAME TOKEN")
                connection.close(REFUSAL_TIMEOUT_S)
            if not connection.watched & WRITE_EVENT:  # most sockets have room
                connection.serve(WRITE_EVENT)
            finished = connection.finished(now)
            wanted = 0 if finished else connection.wants(now)
            if connection.watched != wanted:  # asking the selector takes most of a round
                self._watch(connection, wanted, connection.serve)
                connection.watched = wanted
            if finished:
                connection.dispose()
                self._connections.remove(connection)

    def _watch(
        self, end: socket.socket | Connection, events: int, call: Callable[[int], None]
    ) -> None:
        """Have `call` called at these events, or not at all when there are none."""
        key = self._selector.get_map().get(end)
        if key is None and events:
            self._selector.register(end, events, call)
        elif key is not None and not events:
            self._selector.unregister(end)
        elif key is not None and key.events != events:
            self._selector.modify(end, events, call)

    def _pause(self, now: float) -> float | None:
        """Return how long [s] to wait for events at most, None without end."""
        due = [connection.due(now) for connection in self._connections]
        due += [self._paused_until] if self._paused_until > now else []
        earliest = min(due, default=math.inf)
        return max(earliest - now, 0.0) if earliest < math.inf else None

    def _admit(self, access: socket.socket, _ready: int) -> None:
        try:
            end, address = access.accept()
        except OSError as error:  # the client is gone again, or the system has no descriptor left
            if error.errno in NO_ROOM:
                self._paused_until = time.monotonic() + FULL_PAUSE_S
            return
        local = end.family not in (socket.AF_INET, socket.AF_INET6)
        room = MAX_CONNECTIONS + RESERVED_CONNECTIONS * local
        if len(self._connections) >= room + MAX_REFUSED_LINES:
            end.close()
            return
        if not local:
            self._make_room()
        full = sum(not connection.leaving for connection in self._connections) >= room
        prepare_socket(end)
        connection = Connection(end, self._name(address), self._wake, self._stir, self._longest)
        connection.local = local
        connection.machine = "" if local else machine_of(address[0], end.getsockname()[0])
        connection.introduce_by = time.monotonic() + self._introduction
        self._connections.append(connection)
        if full:
            connection.send(f"? no room: {room} stations are attached; one of them must detach")
            connection.send(sentences.fact(0, 0.0, "no-room", str(room)))
            connection.close(REFUSAL_TIMEOUT_S)
            return
        self._newcomers.append(connection)
        self._wake.set()

    def _make_room(self) -> None:
        """Close one stranger if there are too many: the oldest of those that rank lowest.

        So strangers never take the places of stations that have said who they are.
        """
        strangers = [each for each in self._connections if each.stranger and not each.leaving]
        if len(strangers) >= MAX_STRANGERS:
            leaver = min(strangers, key=lambda each: each.worth)
            leaver.send("? your place is needed: say who you are at once when you come")
            leaver.close(REFUSAL_TIMEOUT_S)

    def _name(self, address: tuple[str, int] | str) -> str:
        if isinstance(address, tuple):
            return f"tcp {address[0]}:{address[1]}"
        self._count += 1
        return f"local {self._count}"


def prepare_socket(end: socket.socket) -> None:
    """Set the options of a new connection."""
    end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MAX_OUTGOING_BYTES)
    if end.family not in (socket.AF_INET, socket.AF_INET6):
        return
    with contextlib.suppress(OSError):  # it has gone already: the first read will find that out
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in KEEPALIVE_OPTIONS:
            if hasattr(socket, name):
                end.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
