"""The limits of the pages' server on open connections, and on their silence.

They stop a client that opens connections and sends nothing (a slow-loris attack), because each open
connection takes a file descriptor, of which a process has few. The server's library (uvicorn) has
no such limits. So ``server`` accepts connections here, and hands each to the library afterwards.

A connection counts once it is accepted, before TLS and before its first byte, until its socket is
closed. It has 10 s to send a whole request, and 10 s after each answer to send the next one. A
WebSocket, once it is open, has its own limits (``bridge``).

If there is no room for one more, the one that has been silent for longest is closed to make it. If
none is silent, the newcomer gets an HTTP answer 503 with the reason. This machine and all others
are counted apart, so that neither can shut the other out. All connections of trusted proxies
(``front``) are counted among the others, with no limit of one machine: many browsers share them.
"""

import asyncio
import contextlib
import os
import socket
import ssl
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final, cast

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trainer.io.machine import THIS_MACHINE, machine_of
from trainer.io.orders.grammar import Refused
from trainer.web.front import Front
from trainer.web.gate import SECURITY_HEADERS, Refusals

# docs/threat-model.md says what these limits are against.
MAX_CONNECTIONS: Final = 500
MAX_CONNECTIONS_HERE: Final = 100  # of those; no other machine can take them
MAX_CONNECTIONS_OF_MACHINE: Final = 32  # of another one: a browser opens six, and a line a page
PROXY_MACHINES: Final = "proxies"  # all that are trusted
MAX_FAREWELLS: Final = 8  # newcomers that are being sent the reason; beyond it they are cut off
REQUEST_TIMEOUT_S: Final = 10.0  # from the first contact, or from an answer, to a whole request
ANSWER_TIMEOUT_S: Final = 60.0  # for an answer to be made and taken
FAREWELL_TIMEOUT_S: Final = 2.0
ACCEPT_PAUSE_S: Final = 1.0  # where the system has no room and nobody gives way
MAX_BODY_BYTES: Final = 4096  # of a request, that are waited for; its reader refuses what is longer

DESCRIPTORS_WANTED: Final = 4096
DESCRIPTORS_RESERVED: Final = 24  # for the server itself, and for farewells
DESCRIPTORS_OF_CONNECTION: Final = 2  # itself, and its file or its line to the session


@dataclass(frozen=True)
class ConnectionRoom:
    """The most connections: for this machine, for all others, for any one of them."""

    here: int = MAX_CONNECTIONS_HERE
    elsewhere: int = MAX_CONNECTIONS - MAX_CONNECTIONS_HERE
    machine: int = MAX_CONNECTIONS_OF_MACHINE

    @classmethod
    def of(cls, descriptors: int) -> "ConnectionRoom":
        """Return the most that so many descriptors of files allow."""
        most = (descriptors - DESCRIPTORS_RESERVED) // DESCRIPTORS_OF_CONNECTION
        if most >= MAX_CONNECTIONS:
            return cls()
        half = max(most // 2, 1)
        return cls(min(half, MAX_CONNECTIONS_HERE), half, min(half, MAX_CONNECTIONS_OF_MACHINE))


def allowed_descriptors() -> int:
    """Raise this process's limit of open files, and return it."""
    if os.name != "posix":
        return DESCRIPTORS_WANTED
    import resource  # noqa: PLC0415  not everywhere

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = DESCRIPTORS_WANTED if hard == resource.RLIM_INFINITY else min(hard, DESCRIPTORS_WANTED)
    if resource.RLIM_INFINITY != soft < wanted:
        with contextlib.suppress(OSError, ValueError):  # the system has a limit of its own
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
            return wanted
    return soft if soft != resource.RLIM_INFINITY else DESCRIPTORS_WANTED


class CountedSocket(socket.socket):
    """A socket that calls ``on_close`` when it is closed, by whichever library."""

    on_close: Callable[[], None] | None = None

    def close(self) -> None:
        """Close the socket, and call ``on_close`` the first time."""
        super().close()
        call, self.on_close = self.on_close, None
        if call is not None:
            call()


class Visit:
    """One open connection: the machine that it comes from, and its deadline for a request."""

    def __init__(self, machine: str, silent: dict["Visit", None]) -> None:
        """``silent`` has the connections that owe a request, the longest silent first."""
        self.machine = machine
        self.end: Callable[[], object] = lambda: None
        self.is_closing: Callable[[], bool] = lambda: False
        self._silent = silent
        self._deadline: asyncio.TimerHandle | None = None
        self._over = False

    def await_request(self) -> None:
        """Wait for a whole request, for REQUEST_TIMEOUT_S at most."""
        if not self._over:
            self._silent[self] = None
            self.set_deadline(REQUEST_TIMEOUT_S)

    @contextlib.contextmanager
    def answering(self) -> Iterator[None]:
        """Answer a request inside the block, in ANSWER_TIMEOUT_S; then wait for the next."""
        self._silent.pop(self, None)
        self.set_deadline(ANSWER_TIMEOUT_S)
        try:
            yield
        finally:
            self.await_request()

    @contextlib.contextmanager
    def carrying_line(self) -> Iterator[None]:
        """Carry a page's line inside the block, for as long as it is open."""
        self._silent.pop(self, None)
        self._watch_line()
        try:
            yield
        finally:
            self.await_request()

    def set_deadline(self, timeout_s: float) -> None:
        """Cut the connection off in ``timeout_s`` [s]. A later call replaces this one."""
        self._call_later(timeout_s, self.cut_off)

    def _watch_line(self) -> None:
        """Look every 10 s at an open WebSocket; cut it off once it is closing.

        A browser that does not read the rest would keep a closing connection, which counts.
        """
        call = self.cut_off if self.is_closing() else self._watch_line
        self._call_later(REQUEST_TIMEOUT_S, call)

    def _call_later(self, delay_s: float, call: Callable[[], None]) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        if not self._over:
            self._deadline = asyncio.get_running_loop().call_later(delay_s, call)

    def cut_off(self) -> None:
        """End the connection at once."""
        self.finish()
        self.end()

    def finish(self) -> None:
        """Stop waiting, because the connection has ended."""
        self._over = True
        self._silent.pop(self, None)
        if self._deadline is not None:
            self._deadline.cancel()


class WholeRequests:
    """The outermost layer of the application, which waits for a whole request.

    The deadline for a request ends only then, so that a body sent a byte at a time runs into it.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on a request when its body has come, a page's line at once."""
        visit: Visit = scope["state"]["visit"]
        if scope["type"] == "websocket":
            with visit.carrying_line():
                await self._app(scope, receive, send)
            return
        body = await whole_body(receive)
        with visit.answering():
            await self._app(scope, replay_parts(body, receive), end_where_unsure(scope, send))


def end_where_unsure(scope: Scope, send: Send) -> Send:
    """Return a ``send`` that closes the connection where a request's end is in doubt.

    A request that gives its length twice, by Transfer-Encoding and by Content-Length, may be read
    otherwise by what stands before this server (RFC 9112, 6.1).
    """
    names = {name for name, _ in scope["headers"]}

    async def send_last(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message)["Connection"] = "close"
        await send(message)

    return send_last if names >= {b"transfer-encoding", b"content-length"} else send


async def whole_body(receive: Receive) -> list[Message]:
    """Return the parts of a request's body, up to just over MAX_BODY_BYTES."""
    parts: list[Message] = []
    size = 0
    while size <= MAX_BODY_BYTES:
        part = await receive()
        parts.append(part)
        size += len(part.get("body", b""))
        if not part.get("more_body", False):
            break
    return parts


def replay_parts(parts: list[Message], receive: Receive) -> Receive:
    """Return a ``receive`` that gives these parts first, then those still to come."""
    waiting = iter(parts)

    async def receive_next() -> Message:
        for part in waiting:
            return part
        return await receive()

    return receive_next


class Farewell(asyncio.Protocol):
    """The connection of a newcomer without room, who gets the answer 503."""

    def __init__(self, why: str) -> None:
        self._answer = turned_away(why)
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport for the answer."""
        self._transport = cast("asyncio.Transport", transport)

    def data_received(self, _data: bytes) -> None:
        """Answer the first bytes.

        Later bytes are read and dropped, because closing over unread input would cut off the
        answer.
        """
        transport, self._transport = self._transport, None
        if transport is None:
            return
        transport.write(self._answer)
        if transport.can_write_eof():
            transport.write_eof()
        else:
            transport.close()


def turned_away(why: str) -> bytes:
    """Return the answer to a newcomer without room."""
    body = f"{why}\n".encode()
    headers = {
        "Content-Type": "text/plain; charset=utf-8",
        "Content-Length": str(len(body)),
        "Connection": "close",
        "Retry-After": f"{REQUEST_TIMEOUT_S:.0f}",
        **SECURITY_HEADERS,
    }
    head = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
    return f"HTTP/1.1 503 Service Unavailable\r\n{head}\r\n".encode() + body


Protocols = Callable[[Visit], asyncio.Protocol]


class Admission:
    """Counts connections, and refuses those that are too many."""

    def __init__(self, room: ConnectionRoom, refusals: Refusals, front: Front | None) -> None:
        self._room = room
        self._refusals = refusals
        self._front = front
        self.machines: Counter[str] = Counter()  # connections at once of each
        self._silent: dict[Visit, None] = {}
        self._farewells = 0
        self._starting: set[asyncio.Task[None]] = set()

    async def accept(
        self, listener: socket.socket, protocols: Protocols, context: ssl.SSLContext | None
    ) -> None:
        """Accept connections for ever, in TLS with a ``context``."""
        loop = asyncio.get_running_loop()
        listener.settimeout(0.0)
        while True:
            try:
                end, peer = await loop.sock_accept(listener)
                self._welcome(CountedSocket(fileno=end.detach()), peer, protocols, context)
            except ConnectionError:  # gone again
                pass
            except OSError as error:
                self._refusals.note(f"no room for a connection: {error.strerror}")
                if not give_way(self._silent):
                    await asyncio.sleep(ACCEPT_PAUSE_S)
            # Others get their turn: ``sock_accept`` does not yield while connections are waiting.
            await asyncio.sleep(0)

    def _welcome(
        self,
        end: CountedSocket,
        peer: tuple[str, int],
        protocols: Protocols,
        context: ssl.SSLContext | None,
    ) -> None:
        """Count a connection, or send the reason why it is refused."""
        end.settimeout(0.0)
        proxied = self._front is not None and self._front.trusts(peer[0])
        machine = PROXY_MACHINES if proxied else machine_of(peer[0], end.getsockname()[0])
        visit = Visit(machine, self._silent)
        if refused := self._refusal(visit.machine):
            self._refusals.add(peer[:2], f"turned away: {refused.reason}")
            self._part(end, refused.reason, context)
            return
        self.machines[visit.machine] += 1
        end.on_close = partial(self._leave, visit)
        visit.await_request()
        self._start(visit, end, partial(protocols, visit), context)

    def _refusal(self, machine: str) -> Refused | None:
        """Return why there is no room for one more, None if there is.

        A silent connection of the same kind is cut off for it.
        """
        count, here = self.machines[machine], self.machines[THIS_MACHINE]
        elsewhere = self.machines.total() - here
        same = [visit for visit in self._silent if visit.machine == machine]
        if machine == THIS_MACHINE:
            full = here >= self._room.here and not give_way(same)
            why = f"{here} connections of this machine are open: close one of its pages"
        elif count >= self._room.machine and machine != PROXY_MACHINES:
            full = not give_way(same)
            why = f"{count} connections of your machine are open: close one of its pages"
        else:
            others = [visit for visit in self._silent if visit.machine != THIS_MACHINE]
            full = elsewhere >= self._room.elsewhere and not give_way(others)
            why = f"no room: {elsewhere} connections of other machines are open"
        return Refused(why) if full else None

    def _leave(self, visit: Visit) -> None:
        """Count a connection that has closed no more."""
        visit.finish()
        self.machines[visit.machine] -= 1
        if not self.machines[visit.machine]:
            del self.machines[visit.machine]

    def _part(self, end: CountedSocket, why: str, context: ssl.SSLContext | None) -> None:
        """Send a newcomer the reason, unless MAX_FAREWELLS are being sent it."""
        if self._farewells >= MAX_FAREWELLS:
            end.close()
            return
        visit = Visit("", {})
        visit.set_deadline(FAREWELL_TIMEOUT_S)
        self._farewells += 1
        end.on_close = partial(self._end_farewell, visit)
        self._start(visit, end, partial(Farewell, why), context)

    def _end_farewell(self, visit: Visit) -> None:
        visit.finish()
        self._farewells -= 1

    def _start(
        self,
        visit: Visit,
        end: CountedSocket,
        protocol: Callable[[], asyncio.Protocol],
        context: ssl.SSLContext | None,
    ) -> None:
        """Begin to read a connection, and to do TLS with it."""
        starting = asyncio.create_task(connect_socket(visit, end, protocol, context))
        visit.end = starting.cancel  # until the handshake is over there is no transport to abort
        self._starting.add(starting)
        starting.add_done_callback(self._starting.discard)


async def connect_socket(
    visit: Visit,
    end: CountedSocket,
    protocol: Callable[[], asyncio.Protocol],
    context: ssl.SSLContext | None,
) -> None:
    """Connect a socket to its protocol, by TLS with a ``context``."""
    loop = asyncio.get_running_loop()
    try:
        transport, _ = await loop.connect_accepted_socket(protocol, end, ssl=context)
    except (OSError, asyncio.CancelledError):  # no TLS, gone, or cut off by its deadline
        end.close()
    else:
        visit.end, visit.is_closing = transport.abort, transport.is_closing


def give_way(silent: Iterable[Visit]) -> bool:
    """Cut off the connection that has been silent for longest; return whether there is one."""
    first = next(iter(silent), None)
    if first is not None:
        first.cut_off()
    return first is not None
