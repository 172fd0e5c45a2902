"""Lines as UDP datagrams, to one host or to all of a network.

NMEA outlets send by it (``session/nmea/outlets``). UDP needs no receiver, so nothing here waits or
fails while nobody listens.
"""

import socket
from typing import Final

from trainer.io.lines import line_bytes
from trainer.io.serial_line import LinkError

MAX_PORT: Final = 65535  # of UDP


class Datagrams:
    """A Sender of trainer.io.line, a datagram for each line. It never waits."""

    room: Final = True

    def __init__(self, host: str, port: int) -> None:
        """Look the host up once; LinkError if there is no such host or port."""
        self.dropped = 0
        self.trouble = ""  # of the last datagram
        if not 0 < port <= MAX_PORT:
            raise LinkError(f"a port is 1 to {MAX_PORT}")
        try:
            addresses = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError) as error:
            raise LinkError("no such host; say an address, such as 127.0.0.1") from error
        family, kind, protocol, _, to = addresses[0]
        self._to: tuple[str | int | bytes, ...] = to
        self._end = socket.socket(family, kind, protocol)
        self._end.setblocking(False)  # noqa: FBT003
        self._end.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)

    def send(self, line: str) -> None:
        """Send one line with its end, or count it as dropped."""
        try:
            self._end.sendto(line_bytes(line) + b"\r\n", self._to)
        except OSError as error:
            self.dropped += 1
            self.trouble = error.strerror or str(error)
        else:
            self.trouble = ""

    def close(self, _patience: float) -> None:
        """Close the socket. What was sent is on its way; a second call does nothing."""
        self._end.close()
