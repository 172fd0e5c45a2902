"""Sockets in memory, by the names that ``socket`` and ``selectors`` have for them."""

import errno
import itertools
import selectors
import socket
from collections.abc import Hashable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from simulation.machine import Machine

ROOM_BYTES: Final = 65_536  # that an end takes before who sends has to wait
SHORT_WRITE_CHANCE: Final = 0.05  # [-] that less is taken than there would be room for
FIRST_PORT: Final = 10_000
FIRST_CLIENT_PORT: Final = 40_000
OWN_ADDRESS: Final = "127.0.0.1"


class Socket:
    """One end of a connection."""

    family: int = socket.AF_INET

    def __init__(self, network: "Network", room: int = ROOM_BYTES) -> None:
        self._network = network
        self._number = next(network.numbers)
        self.came = bytearray()
        self.room = room
        self.peer = self
        self.closed = self.shut = self.reset = False

    @property
    def readable(self) -> bool:
        """Return whether ``recv`` has something to say."""
        return bool(self.came) or self.peer.closed or self.peer.shut or self.reset

    @property
    def writable(self) -> bool:
        """Return whether ``send`` has something to do."""
        return self.peer.closed or len(self.peer.came) < self.peer.room

    def fileno(self) -> int:
        return self._number

    def settimeout(self, _seconds: float) -> None:
        """Do nothing: no end waits by itself."""

    def setsockopt(self, *_: int) -> None:
        """Do nothing: there is no wire."""

    def getsockname(self) -> tuple[str, int]:
        return OWN_ADDRESS, self._number

    def send(self, data: bytes) -> int:
        machine = self._network.machine
        machine.offer_turn()
        if self.closed or self.shut:
            raise OSError(errno.EBADF, "Bad file descriptor")
        if self.reset or self.peer.closed:
            raise BrokenPipeError(errno.EPIPE, "Broken pipe")
        count = min(self.peer.room - len(self.peer.came), len(data))
        if count <= 0:
            raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
        if count > 1 and machine.dice.random() < SHORT_WRITE_CHANCE:
            count = machine.dice.randrange(1, count)
        self.peer.came += data[:count]
        return count

    def recv(self, most: int) -> bytes:
        if self.closed:
            raise OSError(errno.EBADF, "Bad file descriptor")
        if self.reset:
            raise ConnectionResetError(errno.ECONNRESET, "Connection reset by peer")
        if not (self.came or self.peer.closed or self.peer.shut):
            raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
        data = bytes(self.came[:most])
        del self.came[:most]
        return data

    def shutdown(self, _how: int) -> None:
        if self.peer.closed:
            raise OSError(errno.ENOTCONN, "Transport endpoint is not connected")
        self.shut = True

    def close(self) -> None:
        self.closed = True


class Listener:
    """A socket that listens at a port, or at a path of this machine."""

    writable = False

    def __init__(self, network: "Network", port: int, family: int = socket.AF_INET) -> None:
        self._network, self.port, self.family = network, port, family
        self._number = next(network.numbers)
        self.backlog: list[Socket] = []
        self.closed = False

    @property
    def readable(self) -> bool:
        """Return whether somebody has called."""
        return bool(self.backlog)

    def fileno(self) -> int:
        return self._number

    def settimeout(self, _seconds: float) -> None:
        """Do nothing: no end waits by itself."""

    def getsockname(self) -> tuple[str, int]:
        return OWN_ADDRESS, self.port

    def accept(self) -> tuple[Socket, tuple[str, int] | str]:
        if not self.backlog:
            raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
        end = self.backlog.pop(0)
        if self.family == socket.AF_UNIX:
            return end, ""
        return end, (OWN_ADDRESS, FIRST_CLIENT_PORT + next(self._network.numbers))

    def close(self) -> None:
        self.closed = True


@dataclass
class LocalDoor:
    """A socket that listens at a path, as ``trainer.io.server.LocalSocket`` is."""

    socket: Listener

    def close(self) -> None:
        """Stop listening."""
        self.socket.close()


@dataclass
class Key:
    """What a selector knows of a socket."""

    fileobj: Any  # a socket, or a connection that has one
    events: int
    data: Any
    end: Socket | Listener

    def ready(self) -> int:
        """Return which of the events there are."""
        reads = self.events & selectors.EVENT_READ and self.end.readable
        writes = self.events & selectors.EVENT_WRITE and self.end.writable
        return selectors.EVENT_READ * bool(reads) | selectors.EVENT_WRITE * bool(writes)


class Selector:
    """A selector, which has what is ready in any order."""

    def __init__(self, network: "Network") -> None:
        self._network = network
        self._keys: dict[Hashable, Key] = {}

    def register(self, fileobj: Any, events: int, data: object = None) -> None:
        self._keys[fileobj] = Key(fileobj, events, data, self._network.ends[fileobj.fileno()])

    modify = register

    def unregister(self, fileobj: Hashable) -> None:
        del self._keys[fileobj]

    def get_map(self) -> dict[Hashable, Key]:
        return self._keys

    def select(self, timeout: float | None = None) -> list[tuple[Key, int]]:
        machine = self._network.machine
        machine.wait(lambda: any(key.ready() for key in self._keys.values()), timeout)
        found = [(key, ready) for key in self._keys.values() if (ready := key.ready())]
        machine.dice.shuffle(found)
        return found

    def close(self) -> None:
        self._keys = {}


@dataclass
class Network:
    """The sockets of a machine."""

    machine: Machine
    numbers: "itertools.count[int]" = field(default_factory=lambda: itertools.count(1))
    ends: dict[int, Socket | Listener] = field(default_factory=dict)  # by descriptor
    doors: dict[int, Listener] = field(default_factory=dict)  # of the session, by family

    def boot(self) -> None:
        """Forget what a process before had."""
        self.numbers, self.ends, self.doors = itertools.count(1), {}, {}

    def pair(self) -> tuple[Socket, Socket]:
        """Return two ends that are connected."""
        one, other = self._end(), self._end()
        one.peer, other.peer = other, one
        return one, other

    def listen(self, _host: str, port: int) -> Listener:
        """Listen at a port, 0 for any."""
        return self._open(Listener(self, port or FIRST_PORT))

    def listen_here(self, _path: Path) -> "LocalDoor":
        """Listen at a path of this machine."""
        return LocalDoor(self._open(Listener(self, 0, socket.AF_UNIX)))

    def call(self, room: int, family: int = socket.AF_INET) -> Socket | None:
        """Return a connection to the session, which keeps so many bytes; None if nobody listens."""
        door = self.doors.get(family)
        if door is None or door.closed:
            return None
        ours, theirs = self.pair()
        ours.room, theirs.family = room, family
        door.backlog.append(theirs)
        return ours

    def _open(self, door: Listener) -> Listener:
        self.doors[door.family] = door
        self.ends[door.fileno()] = door
        return door

    def selector(self) -> Selector:
        """Return a selector."""
        return Selector(self)

    def _end(self) -> Socket:
        end = Socket(self)
        self.ends[end.fileno()] = end
        return end
