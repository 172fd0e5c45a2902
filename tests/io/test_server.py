"""Sockets of a session: many clients, none of which can harm another or the boat."""

import math
import os
import random
import select
import socket
import struct
import threading
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from trainer.io import connection, lines
from trainer.io import server as server_module
from trainer.io.client import dial, over_serial
from trainer.io.connection import (
    MAX_OUTGOING_BYTES,
    MAX_OUTGOING_LINES,
    MAX_WAITING_LINES,
    WRITE_EVENT,
    Connection,
    carried_for,
)
from trainer.io.line import DirectSender, JoinedLine, Line
from trainer.io.lines import OverlongLine
from trainer.io.machine import machine_of
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.serial_line import LinkError, SerialLine
from trainer.io.server import MAX_CONNECTIONS, MAX_REFUSED_LINES, MAX_STRANGERS, Server

PATIENCE = 60.0  # [s]  far beyond what any wait here needs
needs_local = pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="no local sockets here")
needs_pty = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")


class Desk:
    """A hub with its port, and all the lines its clients have said."""

    def __init__(self) -> None:
        self.wake = threading.Event()
        self.hub = Server(self.wake)
        self.port = self.hub.listen("127.0.0.1", 0)
        self.attached: list[Connection] = []

    def wait(self, happened: Callable[[], object]) -> bool:
        """Return whether it happens within the patience, looking whenever the hub wakes us."""
        end = time.monotonic() + PATIENCE
        while not (found := happened()) and time.monotonic() < end:
            self.wake.wait(0.05)
            self.wake.clear()
        return bool(found)

    def arrivals(self, count: int) -> list[Connection]:
        """Return the next clients to arrive."""
        found: list[Connection] = []

        def enough() -> bool:
            found.extend(self.hub.newcomers())
            return len(found) >= count

        assert self.wait(enough)
        self.attached += found
        return found

    def heard(self, line: Line, count: int) -> list[str | OverlongLine]:
        """Return so many lines that a client says."""
        found: list[str | OverlongLine] = []

        def enough() -> bool:
            found.extend(line.take(count - len(found)))
            return len(found) >= count

        assert self.wait(enough)
        return found


@contextmanager
def control() -> Iterator[Desk]:
    made = Desk()
    try:
        yield made
    finally:
        made.hub.close(1.0)


@contextmanager
def client(to: Desk) -> Iterator[tuple[socket.socket, Connection]]:
    with socket.create_connection(("127.0.0.1", to.port), timeout=PATIENCE) as far:
        yield far, to.arrivals(1)[0]


def read_lines(far: socket.socket, count: int) -> list[bytes]:
    data = b""
    while data.count(b"\n") < count:
        more = far.recv(65536)
        assert more, data
        data += more
    return data.split(b"\r\n")[:-1]


# Lines both ways


def test_lines_go_both_ways_and_an_order_wakes_whoever_waits() -> None:
    with control() as here, client(here) as (far, line):
        assert line.name == f"tcp 127.0.0.1:{far.getsockname()[1]}"
        here.wake.clear()
        far.sendall(b"depth 80\r\nrudder left 15\nhal")
        assert here.wake.wait(PATIENCE)

        assert here.heard(line, 2) == ["depth 80", "rudder left 15"]
        far.sendall(b"f\n")
        assert here.heard(line, 1) == ["half"]
        line.send("keeping depth 80 m")
        line.send("caf\N{LATIN SMALL LETTER E WITH ACUTE}")
        assert read_lines(far, 2) == [b"keeping depth 80 m", b"caf?"]
        assert (line.ended, line.trouble, line.dropped) == (False, "", 0)


def test_a_newcomer_wakes_whoever_waits() -> None:
    with control() as here:
        here.wake.clear()
        with socket.create_connection(("127.0.0.1", here.port), timeout=PATIENCE):
            assert here.wake.wait(PATIENCE)
            assert len(here.hub.newcomers()) == 1


def test_lines_are_taken_oldest_first_and_no_more_than_asked_for() -> None:
    with control() as here, client(here) as (far, line):
        far.sendall(b"a\nb\nc\nd\n" + b"x" * (MAX_LINE_LETTERS + 1) + b"\n")
        assert here.wait(lambda: len(line._heard) == 5)  # noqa: SLF001  take() would empty it

        assert line.take(2) == ["a", "b"]
        assert line.take(10) == ["c", "d", OverlongLine(MAX_LINE_LETTERS)]
        assert line.take(10) == []


def test_a_client_that_hangs_up_has_ended_once_its_lines_are_taken() -> None:
    with control() as here, client(here) as (far, line):
        far.sendall(b"run\nrudder le")
        far.shutdown(socket.SHUT_WR)

        assert here.wait(lambda: line._over)  # noqa: SLF001  ended waits for take()
        assert not line.ended
        assert line.take(10) == ["run"]  # and not the half order
        assert line.ended
        assert line.trouble == ""
        line.send("still heard")
        assert read_lines(far, 1) == [b"still heard"]


def test_a_closed_client_gets_what_was_sent_and_then_the_end() -> None:
    with control() as here, client(here) as (far, line):
        far.sendall(b"unread\n" * 10)
        for i in range(100):
            line.send(f"line {i}")
        line.close(1000.0)
        line.send("too late")

        assert read_lines(far, 100)[-1] == b"line 99"
        assert far.recv(100) == b""
        far.sendall(b"too late\n")
        far.close()
        assert here.wait(lambda: line.ended)
        assert line.dropped == 1


# Trouble


def test_a_hung_client_loses_its_own_lines_only_and_they_are_counted() -> None:
    with control() as here, client(here) as (_, hung), client(here) as (far, other):
        said = 40_000
        seen: list[bytes] = []
        for i in range(said):
            hung.send(f"state {i} " + 60 * "x")
            if i % 100 == 0:
                other.send(f"state {i}")
                seen += read_lines(far, 1)

        assert seen == [b"state %d" % i for i in range(0, said, 100)]
        assert other.dropped == 0
        assert hung.dropped > said / 2
        assert len(hung._said) <= MAX_OUTGOING_LINES  # noqa: SLF001  the bound itself
        assert hung._said_bytes <= MAX_OUTGOING_BYTES  # noqa: SLF001


def test_a_line_has_room_while_little_waits_to_go_out() -> None:
    with control() as here, client(here) as (far, line):
        sent = 0
        while line.room:
            line.send(f"{sent:060d}")
            sent += 1

        assert line.dropped == 0
        news = MAX_OUTGOING_LINES // 4
        for _ in range(news):  # all else still goes out
            line.send("news")
        assert line.dropped == 0
        assert read_lines(far, sent + news)[-1] == b"news"
        assert here.wait(lambda: line.room)


def test_what_a_slow_client_does_get_is_whole_lines_in_order() -> None:
    with control() as here, client(here) as (far, line):
        for i in range(20_000):
            line.send(f"{i:060d}")
        line.close(PATIENCE)
        data = b""
        while more := far.recv(1000):
            data += more

        numbers = [int(row) for row in data.split(b"\r\n")[:-1]]
        assert numbers == sorted(numbers)
        assert len(numbers) + line.dropped == 20_000
        assert 0 < line.dropped < 20_000


class Sipping:
    """A socket whose client takes a few bytes at a time."""

    def __init__(self) -> None:
        self.taken = b""

    def settimeout(self, seconds: float) -> None:
        pass

    def send(self, data: bytes) -> int:
        self.taken += data[:7]
        return min(len(data), 7)

    def close(self) -> None:
        pass


def test_a_line_sent_in_parts_arrives_whole_and_one_cut_off_is_counted() -> None:
    far: Any = Sipping()
    line = Connection(far, "sipping", threading.Event(), lambda: None)
    for i in range(10):
        line.send(f"line {i}")

    for _ in range(9):  # 63 of 80 bytes
        line.serve(connection.WRITE_EVENT)
    assert far.taken == b"".join(b"line %d\r\n" % i for i in range(7)) + b"line 7\r"
    line.dispose()
    assert line.dropped == 3


def test_an_answer_goes_out_at_once_and_what_comes_after_by_the_hub() -> None:
    near, far = socket.socketpair()
    stirred: list[str] = []
    line = Connection(far, "asking", threading.Event(), lambda: stirred.append("stirred"))
    with near:
        near.settimeout(PATIENCE)
        near.sendall(b"who\r\n")
        line.serve(connection.READ_EVENT)
        assert line.take(1) == ["who"]
        line.send("answer")
        assert near.recv(100) == b"answer\r\n"
        assert not stirred

        line.send("news")
        assert stirred
        line.take(1)  # nothing has come: nobody asks
        line.send("more")
        line.serve(connection.WRITE_EVENT)
        assert near.recv(100) == b"news\r\nmore\r\n"
        line.dispose()


def test_a_flood_is_held_back_at_its_source_and_nothing_of_it_is_lost() -> None:
    with control() as here, client(here) as (far, line), client(here) as (calm, other):
        count = 3000
        flood = threading.Thread(target=far.sendall, args=(b"depth 80\n" * count,))
        flood.start()
        assert here.wait(lambda: len(line._heard) >= MAX_WAITING_LINES)  # noqa: SLF001
        calm.sendall(b"run\n")
        assert here.heard(other, 1) == ["run"]

        assert len(line._heard) < MAX_WAITING_LINES + connection.CHUNK_BYTES / 9  # noqa: SLF001
        assert here.heard(line, count) == ["depth 80"] * count
        flood.join(PATIENCE)


def test_a_flood_is_read_no_faster_than_the_pace() -> None:
    with control() as here, client(here) as (far, line):
        far.settimeout(0.0)
        start = time.monotonic()
        with suppress(BlockingIOError):
            while True:
                far.send(b"x" * 65536)
        pause = connection.BURST_BYTES / connection.MAX_READ_RATE
        assert here.wait(lambda: line._read_until > start + pause)  # noqa: SLF001

        due = line._read_until - start  # noqa: SLF001  what was read, in seconds at the pace
        assert (
            due
            < time.monotonic()
            - start
            + (connection.BURST_BYTES + connection.CHUNK_BYTES) / connection.MAX_READ_RATE
        )
        assert line.take(10) == [OverlongLine(MAX_LINE_LETTERS)]


def test_noise_on_a_socket_keeps_memory_flat(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "MAX_READ_RATE", 1e9)
    source = random.Random(1967)  # noqa: S311  noise, not a secret

    with control() as here, client(here) as (far, line):

        def babble(times: int) -> None:
            for _ in range(times):
                far.sendall(source.randbytes(9_999) + b"\n")
                line.take(1000)
                line.send("? no order")
            far.sendall(b"\ndepth 80\n")
            assert here.wait(lambda: "depth 80" in line.take(1000))

        babble(20)
        tracemalloc.start()
        held = []
        for _ in range(10):
            babble(20)
            held.append(memory_of(connection, lines))
        tracemalloc.stop()

    assert max(held) < 100_000


def memory_of(*modules: ModuleType) -> int:
    """Return how much memory [bytes] lines of modules have taken, since tracing began, and hold.

    Other threads of this process, of tests before, may take some as well.
    """
    ours = [tracemalloc.Filter(inclusive=True, filename_pattern=str(m.__file__)) for m in modules]
    traced = tracemalloc.take_snapshot().filter_traces(ours)
    return sum(each.size for each in traced.statistics("filename"))


def test_a_client_that_is_reset_is_let_go_with_its_reason() -> None:
    with control() as here, client(here) as (far, line), client(here) as (other_far, other):
        far.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        far.close()  # with a reset

        assert here.wait(lambda: line.ended)
        assert "reset" in line.trouble.lower()
        line.send("to nobody")
        assert line.dropped == 1
        other.send("still here")
        assert read_lines(other_far, 1) == [b"still here"]


def test_a_client_that_vanished_without_a_word_is_probed_by_the_system() -> None:
    with control() as here, client(here) as (_, line):
        end = line._end  # noqa: SLF001  whether the system keeps it alive shows nowhere else

        assert end.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert end.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        if hasattr(socket, "TCP_KEEPIDLE"):
            assert end.getsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE) == 30


def test_a_silent_client_costs_nothing_and_is_kept() -> None:
    with control() as here, client(here) as (far, line), client(here) as (other_far, other):
        for i in range(100):
            other_far.sendall(b"depth %d\n" % i)
            assert here.heard(other, 1) == [f"depth {i}"]

        assert not line.ended
        far.sendall(b"run\n")
        assert here.heard(line, 1) == ["run"]


def guest(here: Desk, guests: ExitStack) -> tuple[socket.socket, Connection]:
    """Return a client that has said something, and its line."""
    far, line = guests.enter_context(client(here))
    far.sendall(b"hello\n")
    assert here.heard(line, 1) == ["hello"]
    return far, line


def test_silent_strangers_give_way_and_keep_nobody_out_of_the_local_socket(
    tmp_path: Path,
) -> None:
    with control() as here, ExitStack() as guests:
        here.hub.listen_here(tmp_path / "s")
        talking = guest(here, guests)
        silent = [guests.enter_context(client(here)) for _ in range(MAX_STRANGERS + 5)]
        for far, _ in silent[:5]:
            assert b"your place is needed" in read_lines(far, 1)[0]
        with socket.socket(socket.AF_UNIX) as own:
            own.settimeout(PATIENCE)
            own.connect(str(tmp_path / "s"))
            own.sendall(b"freeze\n")
            assert here.wait(lambda: bool(here.hub._newcomers))  # noqa: SLF001
            (line,) = here.hub.newcomers()
            assert here.heard(line, 1) == ["freeze"]
        talking[0].sendall(b"run\n")
        assert here.heard(talking[1], 1) == ["run"]


def test_strangers_who_have_hung_up_or_guessed_wrong_give_way_before_the_oldest() -> None:
    with control() as here, ExitStack() as guests:
        here.hub._introduction = 600.0  # noqa: SLF001  who they are is asked for
        came = [guests.enter_context(client(here)) for _ in range(MAX_STRANGERS)]
        guesser, gone = came[-1], came[-2]
        guesser[1].grant(0.0)
        gone[0].shutdown(socket.SHUT_WR)
        assert here.wait(lambda: gone[1].ended)

        for leaver in (gone, guesser, came[0]):
            guests.enter_context(client(here))
            assert b"your place is needed" in read_lines(leaver[0], 1)[0]
            assert leaver[1].leaving
        assert not any(line.leaving for _, line in came[1:-2])


def test_what_a_late_server_still_has_to_send_goes_out_before_the_end() -> None:
    near, far = socket.socketpair()
    connection = Connection(near, "late", threading.Event(), lambda: None)
    connection.send("said before the end")
    connection.close(0.0)

    with far:
        assert connection.finished(time.monotonic())
        connection.dispose()
        assert far.recv(100) == b"said before the end\r\n"
    assert connection.dropped == 0


def test_who_does_not_say_who_he_is_in_time_is_told_and_closed() -> None:
    wake = threading.Event()
    hub = Server(wake, introduction=0.2)
    with closing_hub(hub) as port, socket.create_connection(("127.0.0.1", port), PATIENCE) as far:
        assert read_lines(far, 1) == [b"? closed: nobody said who is here: role NAME TOKEN"]
        assert far.recv(100) == b""
    hub = Server(wake, introduction=0.2)
    with closing_hub(hub) as port, socket.create_connection(("127.0.0.1", port), PATIENCE) as far:
        while not (newcomers := hub.newcomers()):
            wake.wait(PATIENCE)
        newcomers[0].introduce()
        time.sleep(0.5)  # longer than the time to introduce oneself
        newcomers[0].send("welcome")
        assert read_lines(far, 1) == [b"welcome"]


@contextmanager
def closing_hub(hub: Server) -> Iterator[int]:
    """Yield a port that a hub listens at, and close it."""
    try:
        yield hub.listen("127.0.0.1", 0)
    finally:
        hub.close(0.0)


def test_one_client_too_many_is_told_so_and_room_is_made_when_one_leaves() -> None:
    with control() as here, ExitStack() as guests:
        where = ("127.0.0.1", here.port)
        first = guest(here, guests)
        for _ in range(MAX_CONNECTIONS - 1):
            guest(here, guests)
        with socket.create_connection(where, timeout=PATIENCE) as late:
            late.sendall(b"run\n")
            assert read_lines(late, 2) == [
                b"? no room: 32 stations are attached; one of them must detach",
                sentences.fact(0, 0.0, "no-room", "32").encode(),
            ]
            assert late.recv(100) == b""
        assert here.hub.newcomers() == []

        first[1].close(0.0)
        with client(here) as (far, line):
            far.sendall(b"run\n")
            assert here.heard(line, 1) == ["run"]


def test_a_crowd_at_the_door_is_cut_off_and_the_clients_are_still_served(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("trainer.io.server.REFUSAL_TIMEOUT_S", PATIENCE)
    with control() as here, ExitStack() as guests:
        far, line = guest(here, guests)
        for _ in range(MAX_CONNECTIONS - 1):
            guest(here, guests)
        crowd = [
            guests.enter_context(
                socket.create_connection(("127.0.0.1", here.port), timeout=PATIENCE)
            )
            for _ in range(100)
        ]

        assert sum(late.recv(100) != b"" for late in crowd) == MAX_REFUSED_LINES
        far.sendall(b"run\n")
        assert here.heard(line, 1) == ["run"]
        assert here.hub.newcomers() == []


def test_a_page_in_a_browser_gives_no_orders() -> None:
    with control() as here, client(here) as (far, line):
        far.sendall(b"POST /" + b"x" * 100 + b" HTTP/1.1\r\nHost: localhost\r\n\r\nblow all\r\n")

        assert here.wait(lambda: line.ended)
        assert line.take(10) == []
        assert line.trouble == "a web browser, not a station"


def test_a_system_without_room_for_a_connection_is_asked_again_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("trainer.io.server.FULL_PAUSE_S", 0.02)
    asked: list[float] = []

    class Full:
        """A door that the system opens at the third knock."""

        def __init__(self, access: socket.socket) -> None:
            self.access, self.left = access, 2

        def fileno(self) -> int:
            return self.access.fileno()

        def settimeout(self, seconds: float) -> None:
            self.access.settimeout(seconds)

        def getsockname(self) -> tuple[str, int]:
            return self.access.getsockname()  # type: ignore[no-any-return]

        def close(self) -> None:
            self.access.close()

        def accept(self) -> tuple[socket.socket, tuple[str, int]]:
            asked.append(time.monotonic())
            if self.left:
                self.left -= 1
                raise OSError(24, "Too many open files")
            return self.access.accept()

    real = server_module.listen_at
    monkeypatch.setattr("trainer.io.server.listen_at", lambda *at: Full(real(*at)))
    with control() as here, client(here) as (far, line):
        far.sendall(b"run\n")
        assert here.heard(line, 1) == ["run"]
    first, second, third = asked
    assert min(second - first, third - second) > 0.019


def test_a_closed_hub_has_sent_everything_and_leaves_no_thread_and_no_descriptor(
    tmp_path: Path,
) -> None:
    def descriptors() -> int:
        own = Path("/proc/self/fd")
        return len(list(own.iterdir())) if own.exists() else 0

    before, threads = descriptors(), set(threading.enumerate())
    here = Desk()
    if hasattr(socket, "AF_UNIX"):
        here.hub.listen_here(tmp_path / "session")
    with client(here) as (far, line), client(here):
        for i in range(200):
            line.send(f"line {i}")
        reading = threading.Thread(target=lambda: far.recv(1) and far.close())  # type: ignore[func-returns-value]
        reading.start()
        here.hub.close(0.5)
        reading.join(PATIENCE)

    assert set(threading.enumerate()) == threads
    assert descriptors() == before
    assert not (tmp_path / "session").exists()
    assert line.ended
    line.send("after the end")
    line.close(0.0)
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", here.port), timeout=PATIENCE)


def test_a_port_opened_while_the_hub_looks_at_its_ports_is_heard_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with control() as here:
        watch, opened = here.hub._watch, list[int]()  # noqa: SLF001  the very moment

        def open_another(*what: Any) -> None:
            if not opened:
                opened.append(0)
                opened[0] = here.hub.listen("127.0.0.1", 0)
            watch(*what)

        monkeypatch.setattr(here.hub, "_watch", open_another)
        here.hub.listen("127.0.0.1", 0)
        assert here.wait(lambda: opened and opened[0])
        with socket.create_connection(("127.0.0.1", opened[0]), timeout=PATIENCE):
            assert len(here.arrivals(1)) == 1


def test_a_hub_asks_the_system_for_those_alone_whose_wishes_have_changed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = Counter[str]()
    watch = Server._watch  # noqa: SLF001  its questions

    def counted(server: Server, end: Any, events: int, call: Any) -> None:
        asked[getattr(end, "name", "a port")] += 1
        watch(server, end, events, call)

    monkeypatch.setattr(Server, "_watch", counted)
    with control() as here, client(here) as (far, busy), client(here) as (_, idle):
        said = 0
        while not busy.watched & WRITE_EVENT:  # until some wait for room in its socket
            said += 1
            busy.send(f"{said:060d}")
        said -= busy.dropped
        while said:
            said -= far.recv(4096).count(b"\n")

    assert asked[busy.name] > asked[idle.name]
    assert asked[idle.name] <= 2  # as it comes and as it goes


def test_a_burst_of_lines_goes_out_in_one_round_where_there_is_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    calls = Counter[str]()

    def count(name: str) -> None:
        method = getattr(Server, name)

        def counted(*arguments: Any) -> None:
            calls[name] += 1
            method(*arguments)

        monkeypatch.setattr(Server, name, counted)

    with control() as here, ExitStack() as clients:
        attached = [clients.enter_context(client(here)) for _ in range(10)]
        for name in ("_tend_connections", "_watch"):  # a round; a question to the system
            count(name)
        monkeypatch.setattr(server_module, "GATHER_TIME_S", 0.3)  # beyond any pause of this thread
        for _, line in attached:
            line.send("a line")
            time.sleep(0.001)  # so that the hub could take its turn
        for far, _ in attached:
            assert read_lines(far, 1) == [b"a line"]
        assert calls["_tend_connections"] <= 2  # as it is rung, and one that was on its way
        assert calls["_watch"] <= 4  # of the port alone, in each round


def test_a_hub_that_closes_waits_for_its_clients_asleep(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = 0
    tend = Server._tend_connections  # noqa: SLF001  its rounds

    def counted(server: Server, now: float) -> None:
        nonlocal rounds
        rounds += 1
        tend(server, now)

    monkeypatch.setattr(Server, "_tend_connections", counted)
    with control() as here, client(here) as (_, first), client(here):  # none of which hangs up
        first.send("a line")
        before = rounds
        here.hub.close(0.3)

    assert 0 < rounds - before < 30


def test_a_hub_that_closes_gets_out_what_is_queued() -> None:
    here = Desk()
    with client(here) as (far, line):
        said = 0
        while select.select([], [line], [], 0.1)[1]:  # until the client's side is full too
            said += 1
            line.send(f"{said:060d}")
        for _ in range(100):
            line.send("last")
        said, dropped = said + 100, line.dropped
        closing = threading.Thread(target=here.hub.close, args=(PATIENCE,))
        closing.start()

        data = b""
        while more := far.recv(65536):
            data += more
        far.close()
        closing.join(PATIENCE)
        assert len(data.split()) == said - dropped
        assert line.dropped == dropped


# Where it listens


def test_a_port_in_use_is_told_with_the_next_step() -> None:
    with (
        control() as here,
        pytest.raises(LinkError, match=f"127.0.0.1:{here.port}: in use already"),
    ):
        here.hub.listen("127.0.0.1", here.port)


@pytest.mark.parametrize(
    ("host", "port", "reason"),
    [
        ("127.0.0.1", 65536, "a port is 1 to 65535, or 0"),
        ("127.0.0.1", -1, "a port is 1 to 65535, or 0"),
        ("no.such.host.invalid", 0, "no such host; say 127.0.0.1"),
        ("a" * 70 + ".example", 0, "no such host"),
        ("203.0.113.7", 0, "not an address of this machine"),
    ],
)
def test_an_impossible_place_to_listen_is_told(host: str, port: int, reason: str) -> None:
    with pytest.raises(LinkError, match=reason):
        server_module.listen_at(host, port)


@needs_local
@pytest.mark.parametrize("address", ["192.168.1.5", "2001:db8:1111:2222:3333:4444:5555:6666"])
def test_a_program_of_this_user_may_say_for_which_machine_it_carries_lines(
    tmp_path: Path, address: str
) -> None:
    with control() as desk:
        desk.hub.listen_here(tmp_path / "s.sock")
        for said, machine in (
            (f"{carried_for(address)}\nrole helm\n", machine_of(address)),
            (f"role helm\n{carried_for(address)}\n", "here"),
        ):
            with socket.socket(socket.AF_UNIX) as far:
                far.connect(str(tmp_path / "s.sock"))
                far.sendall(said.encode("ascii"))
                (line,) = desk.arrivals(1)
                assert desk.heard(line, 1) == ["role helm"]
                assert line.machine == machine


def test_nobody_at_a_port_says_for_which_machine_he_carries_lines() -> None:
    with control() as desk, client(desk) as (far, line):
        far.sendall(f"{carried_for('192.168.1.5')}\n".encode("ascii"))
        assert desk.heard(line, 1) == [carried_for("192.168.1.5")]
        assert line.machine == "127.0.0.1"


def test_who_waits_for_an_answer_is_given_as_much_longer_to_say_who_is_here() -> None:
    with control() as desk, client(desk) as (_, line):
        line.introduce_by = 100.0
        line.grant(30.0)
        assert line.introduce_by == 130.0
        line.introduce_by = math.inf
        line.grant(30.0)
        assert line.introduce_by == math.inf


@needs_local
def test_a_local_socket_carries_lines_for_its_owner_only(tmp_path: Path) -> None:
    path = tmp_path / "session"
    with control() as here:
        here.hub.listen_here(path)
        assert path.stat().st_mode & 0o777 == 0o600
        with socket.socket(socket.AF_UNIX) as far:
            far.settimeout(PATIENCE)
            far.connect(str(path))
            (line,) = here.arrivals(1)
            far.sendall(b"run\n")
            assert here.heard(line, 1) == ["run"]
            line.send("running")
            assert read_lines(far, 1) == [b"running"]
            assert line.name == "local 1"
    assert not path.exists()


@needs_local
def test_the_socket_of_a_dead_session_is_replaced_and_that_of_a_live_one_refused(
    tmp_path: Path,
) -> None:
    path = tmp_path / "session"
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(path))
    dead.listen()
    dead.close()

    with control() as here, control() as other:
        here.hub.listen_here(path)
        with pytest.raises(LinkError, match="a session listens there; attach to it, or give"):
            other.hub.listen_here(path)
        with socket.socket(socket.AF_UNIX) as far:
            far.connect(str(path))
            assert here.arrivals(2)  # the knock of the other, and this


@needs_local
def test_a_socket_that_another_session_has_taken_over_is_left_to_it(tmp_path: Path) -> None:
    path = tmp_path / "session"
    with control() as here:
        here.hub.listen_here(path)
        path.unlink()
        path.write_text("another's")

    assert path.read_text() == "another's"


@needs_local
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("file", "is there and is no socket; give another path"),
        ("missing/session", "no such folder; make it, or give another path"),
        ("x" * 120, "too long for a socket; give a shorter one"),
    ],
)
def test_an_impossible_path_is_told(tmp_path: Path, name: str, reason: str) -> None:
    (tmp_path / "file").write_text("")

    with pytest.raises(LinkError, match=reason):
        server_module.listen_here(tmp_path / name)
    assert (tmp_path / "file").exists()


def test_a_system_without_local_sockets_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delattr(socket, "AF_UNIX", raising=False)

    with pytest.raises(LinkError, match=r"no local sockets; listen at 127.0.0.1"):
        server_module.listen_here(tmp_path / "session")
    with pytest.raises(LinkError, match=r"no local sockets; say tcp://HOST:PORT"):
        dial(f"local:{tmp_path}", threading.Event())


# The far end


@contextmanager
def dialled(url: str) -> Iterator[tuple[Line, threading.Event]]:
    arrived = threading.Event()
    line = dial(url, arrived)
    try:
        yield line, arrived
    finally:
        line.close(1.0)


def test_a_client_dials_a_port_and_a_long_line_reaches_it_whole() -> None:
    threads = set(threading.enumerate())
    with control() as here:
        for scheme in ("tcp", "socket"):
            with dialled(f"{scheme}://127.0.0.1:{here.port}") as (far, arrived):
                (line,) = here.arrivals(1)
                far.send("subscribe diving")
                assert here.heard(line, 1) == ["subscribe diving"]
                line.send("$TRS," + 1000 * "x")
                assert arrived.wait(PATIENCE)
                assert here.heard(far, 1) == ["$TRS," + 1000 * "x"]
            assert here.wait(lambda line=line: line.ended)  # type: ignore[misc]
    assert set(threading.enumerate()) == threads


def test_a_client_hears_that_the_session_is_gone() -> None:
    with control() as here, dialled(f"tcp://127.0.0.1:{here.port}") as (far, _):
        (line,) = here.arrivals(1)
        line.send("ending")
        line.close(PATIENCE)
        assert here.heard(far, 1) == ["ending"]
        assert here.wait(lambda: far.ended)
        assert far.trouble == ""


@needs_local
@pytest.mark.parametrize("prefix", ["", "local:"])
def test_a_client_dials_a_local_socket(tmp_path: Path, prefix: str) -> None:
    with control() as here:
        here.hub.listen_here(tmp_path / "session")
        with dialled(f"{prefix}{tmp_path / 'session'}") as (far, _):
            (line,) = here.arrivals(1)
            far.send("run")
            assert here.heard(line, 1) == ["run"]


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        (
            "tcp://127.0.0.1:{free}",
            "no session listens there; start one: trainer run or trainer serve",
        ),
        ("tcp://127.0.0.1:99999", "a port is 1 to 65535"),
        ("tcp://127.0.0.1", r"say tcp://HOST:PORT"),
        ("tcp://no.such.host.invalid:1", "no such host; 127.0.0.1 is this machine"),
        ("/no/such/session", "no session listens there; start one: trainer run or trainer serve"),
        ("sokcet://localhost:1", "did you mean socket"),
    ],
)
def test_a_session_that_cannot_be_reached_is_told_with_the_next_step(url: str, reason: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = server.getsockname()[1]
    with pytest.raises(LinkError, match=reason) as caught:
        dial(url.format(free=free), threading.Event())

    assert str(caught.value).startswith(url.format(free=free))


@needs_local
def test_a_dead_local_socket_is_told(tmp_path: Path) -> None:
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(tmp_path / "session"))
    dead.close()

    with pytest.raises(LinkError, match="no session listens there"):
        dial(str(tmp_path / "session"), threading.Event())


# Serial lines and terminals as lines


@needs_pty
def test_a_serial_line_is_a_line_whose_losses_are_counted() -> None:
    import tty  # noqa: PLC0415  absent where there are no pseudo-terminals

    near, far = os.openpty()
    tty.setraw(far)
    wake = threading.Event()
    line = over_serial("panel", SerialLine(os.ttyname(far)), wake, MAX_LINE_LETTERS)
    os.close(far)
    os.write(near, b"rudder left 15\rrun\r" + b"x" * 81)
    assert wake.wait(PATIENCE)
    with control() as here:
        assert here.heard(line, 1) == ["rudder left 15"]
        assert here.heard(line, 2) == ["run", OverlongLine(MAX_LINE_LETTERS)]
        line.send("state")
        assert os.read(near, 100) == b"state\r\n"

        os.close(near)  # unplugged
        line.send("lost")
        line.send("lost")
        assert here.wait(lambda: line.dropped == 2)
        assert not line.ended
        line.close(1.0)
        assert line.ended


def test_a_line_that_hears_nothing_has_ended_and_still_speaks() -> None:
    said: list[bytes] = []
    line = JoinedLine("printer", None, DirectSender(said.append, b"\n"))

    line.send("depth 80")
    assert line.take(10) == []
    line.close(0.0)
    assert line.ended
    assert said == [b"depth 80\n"]
