"""Sockets that listen, at a TCP port or at a path of this machine."""

import contextlib
import errno
import os
import socket
import stat
from dataclasses import dataclass
from pathlib import Path

from trainer.io.serial_line import LinkError

WAITING = 128  # connections that the system keeps until they are taken
KNOCK = 1.0  # [s]  for a session that listens at a path to answer
HIGHEST = 65535


def listen_at(host: str, port: int) -> socket.socket:
    """Return a socket that listens at a TCP port, 0 for any free one; raises LinkError."""
    where = f"{host}:{port}"
    if not 0 <= port <= HIGHEST:
        raise LinkError(f"{where}: a port is 1 to {HIGHEST}, or 0 for any that is free")
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, _, _, _, address = found[0]
        return socket.create_server(address[:2], family=family, backlog=WAITING)
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
    return told(error)


def told(error: Exception) -> str:
    """Return what the system said."""
    return str(getattr(error, "strerror", None) or error)


@dataclass(frozen=True)
class LocalSocket:
    """A socket that listens at a path, and which file there is its own."""

    socket: socket.socket
    path: Path
    file: tuple[int, int]  # device and number

    def close(self) -> None:
        """Stop listening, and take the file away unless another has replaced it.

        The file goes first: who finds a dead one replaces it, and may be given its number.
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
        listener.listen(WAITING)
        return LocalSocket(listener, path, identity(path))
    except OSError as error:
        listener.close()
        raise LinkError(f"{path}: {why_not_here(error)}") from error


def private_folder(folder: Path) -> None:
    """Make a folder of this user's own; LinkError if what is there could be another's.

    In a folder shared by all, whoever comes first owns the name, and a link leads elsewhere.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        refuse_shared(folder)
    except OSError as error:
        raise LinkError(f"{folder}: {told(error)}") from None


def refuse_shared(folder: Path) -> None:
    """Raise LinkError unless a folder, and who could replace it, is this user's or the system's."""
    if not hasattr(os, "geteuid"):
        return
    found, above = os.lstat(folder), folder.parent.stat()
    own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid()
    if not own or found.st_mode & (stat.S_IRWXG | stat.S_IRWXO):
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
    if answers(path):
        raise LinkError(
            f"{path}: a session listens there; attach to it, or give this one another path"
        )
    with contextlib.suppress(OSError):
        path.unlink()


def answers(path: Path) -> bool:
    """Return whether anything listens at the socket `path`."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as knock:
        knock.settimeout(KNOCK)
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
    return f"{told(error)}; give another path"


def identity(path: Path) -> tuple[int, int]:
    """Return which file is at `path`."""
    found = os.lstat(path)
    return found.st_dev, found.st_ino
