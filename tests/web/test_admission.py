"""Who is connected to the pages' server: silence shuts nobody out, every machine has places."""

import asyncio
import contextlib
import gzip
import itertools
import socket
import ssl
import time
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import uvicorn
from helpers.pages import Served
from helpers.waiting import PATIENCE, await_that
from helpers.wire import Pages, dialled, make_certificate, pages, request
from websockets.exceptions import InvalidState, InvalidStatus

from trainer import __version__
from trainer.io.machine import THIS_MACHINE, machine_of
from trainer.web import admission, server
from trainer.web.admission import (
    MAX_CONNECTIONS,
    MAX_CONNECTIONS_OF_MACHINE,
    MAX_FAREWELLS,
    ConnectionRoom,
)
from trainer.web.bridge import MAX_PAGES_OF_MACHINE
from trainer.web.gate import SECURITY_HEADERS, Refusals
from trainer.web.server import Certificate, PageServer

ANOTHER = "127.0.0.2"  # stands for another machine, where `many_machines` is asked for
THIRD = "127.0.0.3"
FEW = ConnectionRoom(here=6, elsewhere=6, machine=4)
SHORT_S = 1.0


@pytest.fixture
def many_machines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take each address of this machine but the first for a machine of its own."""
    monkeypatch.setattr(admission, "machine_of", lambda peer, _own: peer)


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the time for a whole request, and for an answer."""
    monkeypatch.setattr(admission, "REQUEST_TIMEOUT_S", SHORT_S)
    monkeypatch.setattr(admission, "ANSWER_TIMEOUT_S", SHORT_S)


@contextlib.contextmanager
def connected(port: int, number: int, machine: str = THIS_MACHINE) -> Iterator[list[socket.socket]]:
    """Open connections that say nothing while the block lasts."""
    with contextlib.ExitStack() as stack:
        yield [
            stack.enter_context(
                socket.create_connection(("127.0.0.1", port), PATIENCE, (machine, 0))
            )
            for _ in range(number)
        ]


def got_from(end: socket.socket, port: int, path: str = "/") -> bytes:
    """Return all that comes back for a request, until the connection is closed."""
    host = f"Host: 127.0.0.1:{port}\r\n"
    end.sendall(f"GET {path} HTTP/1.1\r\n{host}Connection: close\r\n\r\n".encode())
    return rest_of(end)


def rest_of(end: socket.socket) -> bytes:
    """Return what still comes; a connection that is cut off has ended as well."""
    got = b""
    with contextlib.suppress(ConnectionError):
        while more := end.recv(65536):
            got += more
    return got


@contextlib.contextmanager
def upgraded(port: int, more: str = "") -> Iterator[socket.socket]:
    """Open a page's line by hand, with ``more`` headers; nothing reads or answers it."""
    with connected(port, 1) as (end,):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        end.sendall(
            f"GET /line?version={__version__} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
            f"Origin: http://127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {'A' * 22}==\r\n{more}\r\n".encode()
        )
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += end.recv(1)
        assert b" 101 " in head
        assert b"deflate" not in head
        yield end


def await_cut_off(end: socket.socket, flood: bytes, allowed: int) -> None:
    """Send four times what is allowed, until that is ended from afar."""
    with contextlib.suppress(ConnectionError):
        for _ in range(4 * allowed // len(flood)):
            end.sendall(flood)
        while end.recv(65536):
            pass


# Silence


def test_505_silent_connections_and_half_requests_shut_nobody_out(shared: Served) -> None:
    for words in (b"", b"GET / HT"):
        with connected(shared.port, MAX_CONNECTIONS + 5) as ends:
            for end in ends:
                with contextlib.suppress(ConnectionError):  # it has given way already
                    end.sendall(words)
            assert request(shared.port, "/helm").status == 200
            with dialled(shared.port):
                pass


BEGINNINGS = {
    "nothing": b"",
    "half a line": b"GET / HT",
    "a head without an end": b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n",
    "a body that does not come": b"POST /word HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
    b"Origin: http://127.0.0.1:{port}\r\nContent-Length: 50\r\n\r\nhelm ",
    "an answered request": b"GET /none HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n",
}


@pytest.mark.long
@pytest.mark.usefixtures("hurried")
def test_who_sends_no_whole_request_is_cut_off() -> None:
    ways = list(itertools.product(BEGINNINGS.values(), (False, True)))
    with pages() as stub, connected(stub.port, len(ways)) as ends:
        still_open = {}
        for end, (beginning, trickles) in zip(ends, ways, strict=True):
            end.sendall(beginning.replace(b"{port}", str(stub.port).encode()))
            end.settimeout(0.01)
            still_open[end] = trickles
        give_up = time.monotonic() + PATIENCE
        while still_open and time.monotonic() < give_up:
            for end, trickles in list(still_open.items()):
                if has_ended(end, trickles=trickles):
                    del still_open[end]
        assert not still_open, [ways[ends.index(end)] for end in still_open]
        await_that(lambda: not stub.machines)


def has_ended(end: socket.socket, *, trickles: bool) -> bool:
    """Return whether a connection is cut off, to which one byte more may be sent."""
    try:
        with contextlib.suppress(TimeoutError):
            if not end.recv(65536):
                return True
        if trickles:
            end.sendall(b"x")
    except ConnectionError:
        return True
    return False


@pytest.mark.process
@pytest.mark.usefixtures("hurried")
def test_who_never_ends_a_handshake_of_tls_is_cut_off(tmp_path: Path) -> None:
    certificate = Certificate(*make_certificate(tmp_path))
    with pages(certificate=certificate) as stub, connected(stub.port, 1) as (end,):
        end.sendall(b"\x16\x03\x01")
        assert rest_of(end) == b""
        await_that(lambda: not stub.machines)


@pytest.mark.usefixtures("hurried")
def test_who_takes_no_answer_is_cut_off() -> None:
    with pages() as stub, connected(stub.port, 1) as (end,):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        asked = f"GET /instructor HTTP/1.1\r\nHost: 127.0.0.1:{stub.port}\r\n\r\n"
        with contextlib.suppress(ConnectionError):
            end.sendall(asked.encode() * 1000)
        assert b" 200 OK" in end.recv(100)
        await_that(lambda: not stub.machines)


@pytest.mark.usefixtures("hurried")
def test_an_open_line_may_be_silent() -> None:
    with pages(ws_ping_interval=0.1, ws_ping_timeout=2.0) as stub, dialled(stub.port) as line:
        await_that(lambda: stub.sessions)
        with contextlib.suppress(TimeoutError):
            line.recv(3.0 * SHORT_S)
        stub.sessions[0].sendall(b"still here\n")
        assert line.recv(PATIENCE) == "still here"


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize("told", [0, 100_000], ids=["told nothing", "told much"])
def test_a_line_that_answers_no_ping_is_closed_for_good(told: int) -> None:
    line = b"$TRE,1,0.5,order,%s*00\n" % (b"x" * 1000)
    with (
        pages(ws_ping_interval=0.1, ws_ping_timeout=0.5) as stub,
        upgraded(stub.port),
    ):
        await_that(lambda: stub.sessions)
        assert stub.sessions[0].recv(4096).startswith(b"PROXY TCP4 127.0.0.1 ")  # whose line it is
        with contextlib.suppress(OSError):  # the line is closed meanwhile
            for _ in range(told):
                stub.sessions[0].sendall(line)
        await_that(lambda: not stub.machines)


FLOODS = {
    "pings": b"\x89\xfd\0\0\0\0" + b"x" * 125,
    "empty frames of one message": b"\x00\x80\0\0\0\0",
}


@pytest.mark.parametrize("flood", FLOODS)
def test_a_flood_of_bytes_that_are_no_line_is_cut_off(
    flood: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "MAX_LINE_BYTES_AT_ONCE", allowed := 128 * 1024)
    with pages(ws_ping_interval=None) as stub, dialled(stub.port) as other:
        await_that(lambda: stub.sessions)  # a page is let in before its session is dialled
        (session_of_other,) = stub.sessions
        with upgraded(stub.port) as end:
            end.sendall(b"\x01\x80\0\0\0\0")  # the first frame of a text
            await_cut_off(end, FLOODS[flood] * 100, allowed)
            assert request(stub.port, "/helm").status == 200
            session_of_other.sendall(b"still here\n")
            assert other.recv(PATIENCE) == "still here"


def test_no_frame_and_no_body_is_ever_inflated() -> None:
    deflated = zlib.compressobj(wbits=-15)
    bomb = deflated.compress(bytes(3_000_000)) + deflated.flush()
    packed = gzip.compress(b"helm mast")  # would be a word
    with pages() as stub:
        with upgraded(stub.port, "Sec-WebSocket-Extensions: permessage-deflate\r\n") as end:
            end.sendall(b"\xc1\xfe" + len(bomb).to_bytes(2) + b"\0\0\0\0" + bomb)
            closed = rest_of(end)
        with connected(stub.port, 1) as (end,):
            here = f"127.0.0.1:{stub.port}"
            head = f"POST /word HTTP/1.1\r\nHost: {here}\r\nOrigin: http://{here}\r\n"
            head += f"Content-Encoding: gzip\r\nContent-Length: {len(packed)}\r\n"
            end.sendall(f"{head}Connection: close\r\n\r\n".encode() + packed)
            answer = rest_of(end)
    assert closed[2:4] == (1002).to_bytes(2)  # a protocol error: none was agreed on
    assert answer.startswith(b"HTTP/1.1 400 ")


@pytest.mark.usefixtures("many_machines")
def test_the_longest_silent_connection_of_a_full_machine_gives_way() -> None:
    with (
        pages(room=FEW) as stub,
        connected(stub.port, 1, THIRD) as (first,),
        connected(stub.port, FEW.machine, ANOTHER) as (second, third, *_),
        connected(stub.port, 1, ANOTHER) as (newcomer,),
    ):
        assert b" 200 OK" in got_from(newcomer, stub.port)
        assert rest_of(second) == b""
        for end in (first, third):
            assert b" 200 OK" in got_from(end, stub.port)


# Places


@contextlib.contextmanager
def lines_of(stub: Pages, number: int, machine: str) -> Iterator[None]:
    """Hold places by pages that are open, which do not give way."""
    with contextlib.ExitStack() as stack:
        for _ in range(number):
            stack.enter_context(dialled(stub.port, source_address=(machine, 0)))
        yield


@pytest.mark.usefixtures("many_machines")
def test_a_machine_without_a_place_is_told_why_and_the_others_are_not_shut_out() -> None:
    with pages(room=FEW) as stub, lines_of(stub, FEW.machine, ANOTHER):
        with connected(stub.port, 1, ANOTHER) as (end,):
            head, _, body = got_from(end, stub.port).decode().partition("\r\n\r\n")
        for machine in (THIRD, THIS_MACHINE):
            with connected(stub.port, 1, machine) as (end,):
                assert b" 200 OK" in got_from(end, stub.port)

    assert head.startswith("HTTP/1.1 503 ")
    assert "Retry-After: 10" in head
    assert all(f"{name}: {value}" in head for name, value in SECURITY_HEADERS.items())
    assert body == "4 connections of your machine are open: close one of its pages\n"
    assert any("turned away: 4 connections" in text for text in stub.told)


@pytest.mark.usefixtures("many_machines")
def test_all_other_machines_together_leave_this_one_its_places() -> None:
    with (
        pages(room=FEW) as stub,
        lines_of(stub, FEW.machine, ANOTHER),
        lines_of(stub, FEW.elsewhere - FEW.machine, THIRD),
    ):
        with connected(stub.port, 1, THIRD) as (end,):
            assert b"no room: 6 connections of other machines" in got_from(end, stub.port)
        assert request(stub.port, "/helm").status == 200


@pytest.mark.usefixtures("many_machines")
def test_this_machine_takes_no_place_of_others() -> None:
    with pages(room=FEW) as stub, lines_of(stub, FEW.here, THIS_MACHINE):
        with connected(stub.port, 1) as (end,):
            assert b"6 connections of this machine are open" in got_from(end, stub.port)
        with connected(stub.port, 1, ANOTHER) as (end,):
            assert b" 200 OK" in got_from(end, stub.port)


@pytest.mark.process
@pytest.mark.usefixtures("many_machines")
def test_a_page_that_is_turned_away_by_tls_is_told_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "FAREWELL_TIMEOUT_S", 30.0)  # a busy machine reads late
    cert, key = make_certificate(tmp_path)
    context = ssl.create_default_context(cafile=str(cert))
    room = ConnectionRoom(here=1, elsewhere=1, machine=1)
    with (
        pages(room=room, certificate=Certificate(cert, key)) as stub,
        dialled(stub.port, scheme="wss", ssl=context),
        pytest.raises(InvalidStatus, match="503"),
        dialled(stub.port, scheme="wss", ssl=context),
    ):
        pass


@pytest.mark.usefixtures("many_machines")
def test_a_crowd_that_comes_and_goes_leaves_nothing_behind() -> None:
    with pages(room=FEW) as stub:
        with lines_of(stub, FEW.machine, ANOTHER):
            for number in range(4, 60):
                with connected(stub.port, 2 * MAX_FAREWELLS, f"127.0.0.{number}"):
                    pass
                with connected(stub.port, 2 * MAX_FAREWELLS, ANOTHER):
                    pass
        await_that(lambda: not stub.machines)
        with connected(stub.port, 1, ANOTHER) as (end,):
            assert b" 200 OK" in got_from(end, stub.port)


def test_who_says_he_speaks_for_another_machine_is_counted_as_himself() -> None:
    forwarded = {"X-Forwarded-For": "192.0.2.1", "X-Forwarded-Proto": "https"}
    with pages() as stub, contextlib.ExitStack() as lines:
        for _ in range(MAX_PAGES_OF_MACHINE + 1):
            lines.enter_context(dialled(stub.port, headers=forwarded))
        await_that(lambda: len(stub.sessions) == MAX_PAGES_OF_MACHINE + 1)
        assert set(stub.machines) == {THIS_MACHINE}
        origin = f"http://127.0.0.1:{stub.port}"
        kept = request(
            stub.port, "/word", "POST", "helm mast", context=None, Origin=origin, **forwarded
        )
    assert kept.status == 200
    assert "Secure" not in kept.headers["set-cookie"]


# Whose a connection is


@pytest.mark.parametrize(
    ("peer", "own", "machine"),
    [
        ("127.0.0.1", "127.0.0.1", THIS_MACHINE),
        ("127.8.9.10", "127.0.0.1", THIS_MACHINE),
        ("::1", "::1", THIS_MACHINE),
        ("::ffff:127.0.0.1", "::ffff:127.0.0.1", THIS_MACHINE),
        ("192.0.2.7", "192.0.2.7", THIS_MACHINE),
        ("192.0.2.8", "192.0.2.7", "192.0.2.8"),
        ("::ffff:192.0.2.8", "::ffff:192.0.2.7", "192.0.2.8"),
        ("fe80::8%eth0", "fe80::7%eth0", "fe80::8"),
        ("2001:db8::8", "2001:db8::7", "2001:db8::8"),
        ("2001:db8:0:1:2:3:4:5", "2001:db8::7", "2001:db8:0:1::/64"),
        ("2001:db8:0:1::9", "2001:db8::7", "2001:db8:0:1::/64"),
        ("999.1.1.1", "127.0.0.1", "999.1.1.1"),
    ],
)
def test_a_machine_is_counted_once_under_whichever_address(
    peer: str, own: str, machine: str
) -> None:
    assert machine_of(peer, own) == machine


def test_few_descriptors_make_few_places_and_many_make_no_more_than_are_meant() -> None:
    assert ConnectionRoom.of(100_000) == ConnectionRoom()
    for descriptors in (0, 64, 256, 1023):
        room = ConnectionRoom.of(descriptors)
        assert 1 <= room.machine <= MAX_CONNECTIONS_OF_MACHINE
        assert 2 * (room.here + room.elsewhere) <= max(descriptors, 4)


class LeavingPage:
    """A connection that closes its line just as the server ends."""

    def __init__(self, server: PageServer) -> None:
        self._server = server
        self.asked = 0

    def shutdown(self) -> None:
        self.asked += 1
        if self.asked == 1:
            raise InvalidState("connection is closing")
        self._server.server_state.connections.clear()


def test_a_page_that_closes_its_line_as_the_server_ends_does_not_hold_it() -> None:
    with socket.socket() as listener:
        entrance = admission.Admission(FEW, Refusals(lambda _: None), None)
        server = PageServer(uvicorn.Config(lambda: None), listener, entrance, lambda: None)
        server.servers, server.force_exit = [], True
        page = LeavingPage(server)
        server.server_state.connections = {page}  # type: ignore[arg-type]

        # in a thread, because a browser's loop may run in this one
        with ThreadPoolExecutor(1) as thread:
            thread.submit(lambda: asyncio.run(server.shutdown())).result()

    assert page.asked == 2


def test_a_request_that_gives_its_length_twice_ends_its_connection() -> None:
    # what stands before a server may read such a request otherwise (RFC 9112, 6.1)
    with pages() as stub, connected(stub.port, 2) as ends:
        head = f"POST /word HTTP/1.1\r\nHost: 127.0.0.1:{stub.port}\r\nContent-Length: 3\r\n"
        twice = f"{head}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n"
        for end, words in zip(ends, (twice, f"{head}\r\nabc"), strict=True):
            end.sendall(words.encode())
        answers = [end.recv(65536).lower() for end in ends]
    assert [b"connection: close" in answer for answer in answers] == [True, False]
    assert all(answer.startswith(b"http/1.1 ") for answer in answers)
