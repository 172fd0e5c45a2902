"""Serial cables and datagrams: what goes to a station or an instrument past the sockets."""

from dataclasses import dataclass, field
from typing import Final

from simulation.machine import SECOND_NS, Machine
from simulation.network import Network, Socket
from trainer.io.serial_line import READ_TIMEOUT_S, WRITE_TIMEOUT_S, LinkError

UNPLUGGED_S: Final = 3.0  # [s] for which a cable that is pulled out is away


@dataclass
class Cable:
    """A serial cable. It can be pulled out, and what was in it is then lost."""

    network: Network
    near: Socket | None = None  # the session's end, while it has the port open
    back_at: int = 0  # [ns] until when it is unplugged

    def open(self, url: str) -> "Port":
        """Return the session's port; LinkError while the cable is out."""
        if self.network.machine.now < self.back_at:
            raise LinkError(f"{url}: No such file or directory")
        self.near, _ = self.network.pair()
        return Port(self.network.machine, self.near)

    def pull(self) -> None:
        """Pull the cable out for a while."""
        self.back_at = self.network.machine.now + int(UNPLUGGED_S * SECOND_NS)
        if self.near:
            self.near.reset = True
        self.near = None

    @property
    def far(self) -> Socket | None:
        """Return the end of the program, None where the session has no port open."""
        return self.near.peer if self.near and not self.near.closed else None


@dataclass
class Port:
    """The session's end of a cable, by the names that pyserial has for it."""

    machine: Machine
    end: Socket

    @property
    def in_waiting(self) -> int:
        """Return how many bytes can be read at once."""
        return len(self.end.came)

    def read(self, most: int) -> bytes:
        """Return what has come, b"" when nothing has for a while; OSError without a cable."""
        self.machine.wait(lambda: self.end.readable, READ_TIMEOUT_S)
        return self.end.recv(most) if self.end.readable else b""

    def write(self, data: bytes) -> None:
        """Write all, as fast as the far end reads; OSError where it does not."""
        while data:
            if not self.machine.wait(lambda: self.end.writable, WRITE_TIMEOUT_S):
                raise TimeoutError("Write timeout")
            data = data[self.end.send(data) :]

    def close(self) -> None:
        """Close the port."""
        self.end.closed = True


@dataclass
class Wires:
    """The cables of a machine, and the datagrams that leave it."""

    network: Network
    cables: dict[str, Cable] = field(default_factory=dict)  # by URL
    sent: list[str] = field(default_factory=list)  # lines of datagrams

    def boot(self) -> None:
        """Forget what a process before had."""
        self.cables, self.sent = {}, []

    def cable(self, url: str) -> Cable:
        """Return the cable of a URL."""
        return self.cables.setdefault(url, Cable(self.network))

    def open_port(self, url: str, _baud: int) -> Port:
        """Open a port, as ``trainer.io.serial_line.open_port`` does."""
        return self.cable(url).open(url)

    def datagrams(self, _host: str, _port: int) -> "Datagrams":
        """Return a sender of datagrams, as ``trainer.io.udp.Datagrams`` is."""
        return Datagrams(self.sent)


@dataclass
class Datagrams:
    """A sender whose lines are kept."""

    sent: list[str]
    dropped: int = 0
    trouble: str = ""
    room: bool = True

    def send(self, line: str) -> None:
        """Keep a line."""
        self.sent.append(line)

    def close(self, _patience: float) -> None:
        """Do nothing."""
