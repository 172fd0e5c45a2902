"""A line between a browser and its server that is slow, loses packets, and counts what is asked."""

import asyncio
import contextlib
import random
import re
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

AGAIN_S: Final = 0.3  # [s] until a lost packet is sent again, as TCP does; what follows waits
READ_BYTES: Final = 1448  # [bytes] of a packet
ASKED: Final = re.compile(rb"(?:GET|POST) (\S+) HTTP/1\.1\r\n")


@dataclass
class SlowLine:
    """A proxy on this machine; ``delay_s`` is one way, ``loss`` a share of all packets."""

    port: int  # where the server is
    delay_s: float = 0.0
    loss: float = 0.0
    own_port: int = 0
    asked: list[str] = field(default_factory=list)  # the paths of requests
    lost: int = 0  # packets
    _chance: random.Random = field(default_factory=lambda: random.Random(48))  # noqa: S311
    _ends: list[asyncio.StreamWriter] = field(default_factory=list)
    loop: asyncio.AbstractEventLoop | None = None

    @property
    def url(self) -> str:
        """Return where the pages are, seen through this line."""
        return f"http://127.0.0.1:{self.own_port}"

    async def carry(self, near: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        """Carry one connection, both ways."""
        self._ends.append(back)
        far, there = await asyncio.open_connection("127.0.0.1", self.port)
        self._ends.append(there)
        await asyncio.gather(self.pass_on(near, there, counts=True), self.pass_on(far, back))

    async def pass_on(
        self, source: asyncio.StreamReader, to: asyncio.StreamWriter, *, counts: bool = False
    ) -> None:
        """Pass on what comes, each packet as late as the line is, and later where it is lost."""
        now = asyncio.get_running_loop().time
        packets: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        writing = asyncio.create_task(self.write(packets, to))
        with contextlib.suppress(ConnectionError):
            while data := await source.read(READ_BYTES):
                if counts:
                    self.asked += [path.decode() for path in ASKED.findall(data)]
                packets.put_nowait((now() + self.delay_s, data))
        packets.put_nowait((0.0, b""))
        await writing

    async def write(
        self, packets: "asyncio.Queue[tuple[float, bytes]]", to: asyncio.StreamWriter
    ) -> None:
        """Write packets in their order, when they are due."""
        now = asyncio.get_running_loop().time
        with contextlib.suppress(ConnectionError):
            while True:
                due, data = await packets.get()
                if not data:
                    break
                await asyncio.sleep(max(due - now(), 0.0))
                while self._chance.random() < self.loss:
                    self.lost += 1
                    await asyncio.sleep(AGAIN_S)
                to.write(data)
                await to.drain()
        to.close()

    def cut(self) -> None:
        """Break all connections that there are."""
        assert self.loop
        self.loop.call_soon_threadsafe(self._break)

    def _break(self) -> None:
        for end in self._ends:
            end.transport.abort()
        self._ends.clear()

    async def serve(self, ready: threading.Event, over: asyncio.Event) -> None:
        """Take connections until it is over."""
        self.loop = asyncio.get_running_loop()
        async with await asyncio.start_server(self.carry, "127.0.0.1", 0) as serving:
            self.own_port = serving.sockets[0].getsockname()[1]
            ready.set()
            await over.wait()
            serving.close()
            for _ in range(2):  # once more for what was being connected
                self._break()
                await asyncio.sleep(0.05)  # in which each end hears of it


@contextlib.contextmanager
def slow_line(port: int, delay_s: float = 0.0, loss: float = 0.0) -> Iterator[SlowLine]:
    """Yield a line to the server at a port, in a thread of its own."""
    line, ready, over = SlowLine(port, delay_s, loss), threading.Event(), asyncio.Event()
    thread = threading.Thread(target=lambda: asyncio.run(line.serve(ready, over)))
    thread.start()
    assert ready.wait(10.0)
    try:
        yield line
    finally:
        assert line.loop
        line.loop.call_soon_threadsafe(over.set)
        thread.join(10.0)
