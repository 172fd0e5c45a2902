"""Lines, the threads behind ports, serial lines and the plain console."""

import gc
import os
import random
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, cast

import pytest
from helpers.installation import installed
from helpers.pages import free_port
from helpers.waiting import PATIENCE, eventually
from hypothesis import given
from hypothesis import strategies as st

from trainer.config.files import ConfigError
from trainer.io import paths
from trainer.io.line import DirectSender, Inbox, Outbox, Sender, reader, writer
from trainer.io.lines import LineDecoder, OverlongLine
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.serial_line import LinkError, SerialLine
from trainer.io.server import Server
from trainer.io.status_line import StatusView, header, state_line
from trainer.session.doors.ports import Ports
from trainer.session.past.options import RunOptions

needs_pty = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")


# Lines


def test_a_line_ends_at_cr_lf_or_crlf_and_blank_lines_are_kept() -> None:
    assert LineDecoder().feed(b"a\nb\rc\r\n\r\n\nd") == ["a", "b", "c", "", ""]


@given(st.lists(st.binary(max_size=20), max_size=20))
def test_lines_do_not_depend_on_how_the_bytes_are_cut(pieces: list[bytes]) -> None:
    whole = LineDecoder().feed(b"".join(pieces))
    decoder = LineDecoder()

    assert [line for piece in pieces for line in decoder.feed(piece)] == whole


def test_an_endless_line_is_given_up_once_and_the_next_line_is_read() -> None:
    decoder = LineDecoder()

    found = [line for _ in range(1000) for line in decoder.feed(b"x" * 1000)]

    assert found == [OverlongLine(MAX_LINE_LETTERS)]
    assert decoder.held == 0
    assert decoder.feed(b"tail\ndepth 80\n") == ["depth 80"]


def test_a_line_of_the_longest_length_passes() -> None:
    assert LineDecoder().feed(b"x" * MAX_LINE_LETTERS + b"\n") == ["x" * MAX_LINE_LETTERS]


def test_random_bytes_keep_the_buffer_bounded() -> None:
    decoder = LineDecoder()
    source = random.Random(1967)  # noqa: S311  noise, not a secret

    for _ in range(10_000):
        decoder.feed(source.randbytes(7))
        assert decoder.held <= MAX_LINE_LETTERS
    # At most: ends a telnet command cut short, ends the line, then reads afresh.
    assert decoder.feed(b"\r\ndepth 80\r\n")[-1] == "depth 80"


def test_backspace_takes_back_a_character_and_ctrl_u_the_line() -> None:
    decoder = LineDecoder()

    assert decoder.feed(b"dex\x08pth 8\xc2\xb0\x7f0\n") == ["depth 80"]
    assert decoder.feed(b"\x08\x08run\n") == ["run"]
    assert decoder.feed(b"rudder left 3\x15freeze\n") == ["freeze"]


def test_telnet_commands_are_dropped() -> None:
    # IAC WILL ECHO, IAC SB NAWS ... IAC SE, IAC NOP; telnet ends lines with CR NUL or CR LF.
    data = b"\xff\xfb\x01dep\xff\xfa\x1f\0P\0\x18\xff\xf0th\xff\xf1 80\r\0run\r\n"

    assert LineDecoder().feed(data) == ["depth 80", "run"]


@pytest.mark.parametrize("data", [b"rudder", b"rudder left 5\r\n\xff\xfa\x1f"])
def test_a_decoder_leaves_nothing_to_be_collected(data: bytes) -> None:
    while gc.collect():  # what is collected may leave something else: ctypes' types of an array do
        pass
    gc.disable()
    LineDecoder().feed(data)
    left = gc.collect()
    gc.enable()

    assert left == 0


def test_noise_that_looks_like_telnet_cannot_jam_the_line() -> None:
    assert LineDecoder().feed(b"\xff\xfanoise\ndepth 80\n")[-1] == "depth 80"


# Threads behind ports


class Slow:
    """A port that takes nothing until it is let go."""

    def __init__(self) -> None:
        self.go = threading.Event()
        self.taken = b""

    def write(self, data: bytes) -> None:
        self.go.wait(PATIENCE)
        self.taken += data


def test_a_stuck_port_never_holds_up_the_caller_and_drops_are_counted() -> None:
    port = Slow()
    outbox = Outbox(port.write, capacity=10, line_end=b"\n")
    outbox.send("first")
    assert eventually(lambda: not outbox._lines)  # noqa: SLF001  the thread is now stuck with it

    start = time.monotonic()
    for i in range(1000):
        outbox.send(f"{i}")
    assert time.monotonic() - start < 0.1 * PATIENCE
    assert outbox.dropped == 990

    port.go.set()
    outbox.close(PATIENCE)
    assert port.taken == b"first\n" + b"".join(b"%d\n" % i for i in range(10))
    outbox.send("late")
    assert outbox.dropped == 991


def broken(_data: bytes) -> None:
    raise BrokenPipeError(32, "Broken pipe")


@pytest.mark.parametrize("kind", [Outbox, DirectSender])
def test_a_dead_port_is_remembered_with_its_reason(kind: type[Outbox] | type[DirectSender]) -> None:
    sender: Sender = kind(broken)

    sender.send("one")
    assert eventually(lambda: sender.trouble)
    sender.send("two")
    sender.close(PATIENCE)

    assert "Broken pipe" in sender.trouble
    assert sender.dropped == 2


@contextmanager
def pipe() -> Iterator[tuple[int, int]]:
    near, far = os.pipe()
    try:
        yield near, far
    finally:
        os.close(near)


def test_a_pipe_is_read_to_its_end_with_nothing_lost() -> None:
    with pipe() as (near, far):
        arrived = threading.Event()
        inbox = Inbox(reader(near), arrived, capacity=4)
        writer(far)(b"".join(b"depth %d\n" % i for i in range(500)) + b"quit")
        os.close(far)

        lines: list[str | OverlongLine] = []
        while not inbox.ended or inbox._lines:  # noqa: SLF001  take() would empty it
            assert arrived.wait(PATIENCE)
            lines += inbox.take()
        inbox.close(PATIENCE)

    assert lines == [*(f"depth {i}" for i in range(500)), "quit"]
    assert inbox.trouble == ""


def test_an_order_wakes_whoever_waits() -> None:
    with pipe() as (near, far):
        arrived = threading.Event()
        inbox = Inbox(reader(near), arrived)

        assert inbox.take() == []
        assert not arrived.is_set()
        os.write(far, b"depth 80\n")
        assert arrived.wait(PATIENCE)
        assert inbox.take() == ["depth 80"]
        assert not inbox.ended
        os.close(far)
        assert eventually(lambda: inbox.ended)
        inbox.close(PATIENCE)


def test_a_flood_that_nobody_takes_is_held_back_and_the_inbox_still_closes() -> None:
    reads = 0

    def flood() -> bytes:
        nonlocal reads
        reads += 1
        return b"run\n" * 100

    inbox = Inbox(flood, threading.Event(), capacity=50)
    assert eventually(lambda: inbox.waiting == 50)
    inbox.close(PATIENCE)

    assert inbox.ended
    assert reads == 1


def test_an_inbox_whose_port_fails_says_so() -> None:
    def gone() -> bytes:
        raise OSError(5, "Input/output error")

    arrived = threading.Event()
    inbox = Inbox(gone, arrived)

    assert arrived.wait(PATIENCE)
    assert inbox.ended
    assert "Input/output error" in inbox.trouble


def test_pages_of_a_second_session_are_told_to_use_another_socket(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was told to leave out `--socket none`, which nobody had given."""
    monkeypatch.setattr(paths, "socket_path", lambda: tmp_path / "trainer" / "session")
    first = Server(threading.Event())
    (tmp_path / "trainer").mkdir(mode=0o700)
    first.listen_here(paths.socket_path())
    remedies = {None: "give another --socket", "none": "leave out --socket none"}
    try:
        for socket_option, remedy in remedies.items():
            options = RunOptions(serve=True, headless=True, socket=socket_option)
            with ExitStack() as stack:
                sending = cast("Any", None)
                ports = Ports(threading.Event(), sending, lambda *_: None, stack, print)
                ports.lobby(options)
                with pytest.raises(ConfigError, match=f"{remedy}$"):
                    ports.nearest(options)
    finally:
        first.close(0.0)


# Serial lines


@contextmanager
def serving(line: SerialLine) -> Iterator[tuple[Inbox, Outbox]]:
    inbox, outbox = Inbox(line.read, threading.Event()), Outbox(line.write)
    try:
        yield inbox, outbox
    finally:
        outbox.close(PATIENCE)
        line.close()
        inbox.close(PATIENCE)


def taken(inbox: Inbox, count: int) -> list[str | OverlongLine]:
    lines: list[str | OverlongLine] = []

    def enough() -> bool:
        lines.extend(inbox.take())
        return len(lines) >= count

    assert eventually(enough)
    return lines


@needs_pty
def test_a_terminal_line_carries_lines_both_ways_and_its_loss_harms_nobody() -> None:
    import tty  # noqa: PLC0415  absent where there are no pseudo-terminals

    near, far = os.openpty()
    tty.setraw(far)
    line = SerialLine(os.ttyname(far))
    os.close(far)
    with serving(line) as (inbox, outbox):
        os.write(near, b"rudder left 15\rru")
        assert taken(inbox, 1) == ["rudder left 15"]
        outbox.send("state")
        assert os.read(near, 100) == b"state\r\n"

        os.close(near)  # unplugged
        assert eventually(lambda: line.losses == 1)
        assert eventually(lambda: not line.up)
        outbox.send("state")
        assert eventually(lambda: line.unsent == 1)
        assert not inbox.ended
        assert outbox.trouble == ""


def test_a_socket_line_comes_back_after_a_loss_without_completing_half_an_order() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(PATIENCE)
        told: list[str] = []
        line = SerialLine(f"socket://127.0.0.1:{server.getsockname()[1]}", tell=told.append)
        with serving(line) as (inbox, outbox):
            first, _ = server.accept()
            first.sendall(b"depth 80\nrudder le")
            assert taken(inbox, 1) == ["depth 80"]
            first.close()

            second, _ = server.accept()
            with second:
                second.settimeout(PATIENCE)
                # pyserial forgets what comes before its open() is done.
                assert eventually(lambda: line.up)
                second.sendall(b"freeze\n")
                assert taken(inbox, 1) == ["freeze"]
                outbox.send("state")
                assert second.recv(100) == b"state\r\n"
                assert line.losses == 1  # before this end is lost too
                assert [text.split(" (")[0].split(": ")[1] for text in told] == [
                    "the line is lost",
                    "the line is back",
                ]


@contextmanager
def ser2net(device: str, port: int, folder: Path) -> Iterator[None]:
    """Serve a device by RFC 2217 at a port, by Debian's own server, inside the block."""
    settings = folder / "ser2net.yaml"
    settings.write_text(
        "%YAML 1.1\n---\nconnection: &line\n"
        f"  accepter: telnet(rfc2217),tcp,127.0.0.1,{port}\n"
        f"  connector: serialdev,{device},9600n81,local\n"
    )
    words = [installed("ser2net", "ser2net"), "-n", "-c", str(settings), "-u"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as server:
        try:
            assert eventually(lambda: server.poll() is not None or listens(port))
            assert server.poll() is None, server.communicate()[1]
            yield
        finally:
            server.terminate()


def listens(port: int) -> bool:
    with socket.socket() as end:
        return end.connect_ex(("127.0.0.1", port)) == 0


@needs_pty
@pytest.mark.process
@pytest.mark.clock
@pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning")  # pyserial's own
def test_a_line_by_rfc_2217_carries_lines_both_ways_and_comes_back(tmp_path: Path) -> None:
    import tty  # noqa: PLC0415  absent where there are no pseudo-terminals

    near, far = os.openpty()
    tty.setraw(far)
    port, told = free_port(), list[str]()
    with ExitStack() as lines:
        with ser2net(os.ttyname(far), port, tmp_path):
            url = f"rfc2217://127.0.0.1:{port}"
            with pytest.raises(LinkError, match=r"add \?ign_set_control to its address$"):
                SerialLine(url)
            line = SerialLine(f"{url}?ign_set_control", tell=told.append)
            inbox, outbox = lines.enter_context(serving(line))
            os.write(near, b"depth 80\rrudder le")
            assert taken(inbox, 1) == ["depth 80"]
            outbox.send("state")
            assert os.read(near, 100) == b"state\r\n"
        assert eventually(lambda: line.losses == 1)
        with ser2net(os.ttyname(far), port, tmp_path):
            assert eventually(lambda: told and told[-1].endswith("the line is back"))
            os.write(near, b"freeze\r")  # and half an order is not completed by it
            assert taken(inbox, 1) == ["freeze"]
            outbox.send("state")
            assert os.read(near, 100) == b"state\r\n"
    os.close(near)
    os.close(far)


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("sokcet://localhost:1", "did you mean socket?"),
        ("socket://localhost", "say socket://HOST:PORT"),
        ("socket://localhost:99999", "say socket://HOST:PORT"),
        ("no-such-device", "no-such-device: .*there"),
        ("hwgrep://no such port", "no ports found"),
        ("hwgrep://[", "unterminated character set"),
        ("loop://?option=1", "loop://"),
        (".", r"\.: "),
    ],
)
def test_a_line_that_cannot_be_opened_gives_one_clear_message(url: str, reason: str) -> None:
    with pytest.raises(LinkError, match=reason) as caught:
        SerialLine(url)

    assert "\n" not in str(caught.value)


def test_a_refused_connection_and_a_silly_baud_rate_are_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = server.getsockname()[1]
    with pytest.raises(LinkError, match=f"127.0.0.1:{free}: "):
        SerialLine(f"socket://127.0.0.1:{free}")
    with pytest.raises(LinkError, match="0 baud: a line runs at 1 to 4000000 baud"):
        SerialLine("loop://", baud=0)


# The plain console

VIEW = StatusView(
    time_s=83.0,
    depth_m=60.02,
    course_deg=0.0,
    speed_kn=10.0,
    pitch_deg=0.5,
    heel_deg=-0.3,
    rudder_deg=15.0,
    stern_deg=-0.1,
    bow_deg=2.0,
    rpm=80.4,
    ordered_depth_m=80.0,
    ordered_course_deg=90.0,
    frozen=False,
    rudder_manual=True,
    stern_manual=False,
    bow_manual=False,
)


def test_the_state_stands_under_its_headings() -> None:
    assert [header(), state_line(VIEW)] == [
        "time      depth>order hdg>course speed pitch  heel  rudder  stern    bow    rpm",
        "00:01:23   60.0>80.0   000.0>090  10.0  +0.5  -0.3  R15.0* D 0.1  R 2.0    80.4",
    ]


def test_a_frozen_boat_without_orders_shows_so() -> None:
    view = VIEW._replace(frozen=True, ordered_depth_m=None, ordered_course_deg=None)

    assert state_line(view).startswith("00:01:23F  60.0        000.0      10.0")


@pytest.mark.parametrize(
    ("fields", "shown"),
    [
        ({"course_deg": 359.97}, " 000.0>"),
        ({"ordered_course_deg": 359.6}, ">000 "),
        ({"rudder_deg": -0.04, "rudder_manual": False}, "   0.0  D"),
        ({"pitch_deg": -0.04}, " +0.0 "),
        ({"heel_deg": -179.9}, " -180 "),
        ({"time_s": 7325.9}, "02:02:05 "),
        ({"time_s": 1e6}, "  277:46 "),
        ({"time_s": 1e300}, "+####### "),
        ({"depth_m": -1e9}, "-#####>"),
        ({"speed_kn": -3.2}, " -3.2 "),
        ({"stern_deg": -25.0, "stern_manual": True}, "D25.0*"),
    ],
)
def test_a_quantity_is_shown_readably(fields: dict[str, Any], shown: str) -> None:
    assert shown in state_line(VIEW._replace(**fields))


ANY = st.floats(allow_nan=True, allow_infinity=True)


@given(st.builds(StatusView, *[ANY] * 10, *[st.none() | ANY] * 2, *[st.booleans()] * 4))
def test_no_value_breaks_the_columns(view: StatusView) -> None:
    line = state_line(view)

    assert len(line) == len(header()) == 79
    assert line.isascii()
    assert line.isprintable()
