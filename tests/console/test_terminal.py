"""The console as its user has it: keystrokes in a real terminal, a session in its own process."""

import contextlib
import fcntl
import os
import pty
import re
import shutil
import signal
import struct
import subprocess
import sys
import termios
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.installation import run_program
from helpers.nursery import run_trainer, start_trainer
from helpers.places import environment
from helpers.screens import run_aside
from helpers.waiting import PATIENCE, await_begun, await_that, await_work, eventually
from soak.session_process import Caller
from textual import events

from trainer.console.app import Console
from trainer.console.client import Client
from trainer.console.journal import JournalEntry
from trainer.console.keys import KEYS, MoveAction, OrderAction
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.io import paths
from trainer.io.orders.grammar import Order, parse

pytestmark = [
    pytest.mark.clock,
    pytest.mark.process,
    pytest.mark.long,
    pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX"),
    pytest.mark.skipif(shutil.which("tmux") is None, reason="no tmux here"),
]
TRAINER = [sys.executable, "-m", "trainer"]
LOOK = 0.1  # [s]


class Terminal:
    """A real terminal of 100 columns and 30 rows, typed at and looked at through tmux."""

    def __init__(self, name: str, folder: Path) -> None:
        self._name = name
        size = ("-x", "100", "-y", "30")
        shell = "env COLUMNS=130 LINES=40 PS1=# sh"  # as if begun in a larger window
        self._tmux("-f", "/dev/null", "new-session", "-d", *size, "-c", str(folder), shell)

    def _tmux(self, *words: str) -> str:
        done = run_program(["tmux", "-L", self._name, *words])
        return done.stdout

    def type(self, *keys: str) -> None:
        self._tmux("send-keys", *keys)

    def text(self) -> str:
        return self._tmux("capture-pane", "-p")

    def wait(self, pattern: str) -> str:
        """Wait until the screen shows something; return what it shows."""
        await_work(
            int(self._tmux("display-message", "-p", "#{pid}")),
            lambda: re.search(pattern, self.text()),
            lambda: f"{pattern!r} is not shown:\n{self.text()}",
        )
        return self.text()

    def close(self) -> None:
        with contextlib.suppress(subprocess.CalledProcessError):
            self._tmux("kill-server")


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    if shutil.which("tmux") is None:
        pytest.skip("no tmux here")
    found = Terminal(f"trainer-{os.getpid()}-{tmp_path.name[:16]}", tmp_path)
    yield found
    found.close()
    assert gone(paths.socket_path()), "a session outlives its terminal"


@pytest.fixture
def ear() -> Iterator[Callable[[Path], Caller]]:
    """Return a function that attaches another station to a session: it hears every tick."""
    with contextlib.ExitStack() as opened:

        def listen(path: Path) -> Caller:
            caller = opened.enter_context(Caller(path))
            for words in ("role observer", "subscribe time"):
                assert caller.ask(words)[0]
            return caller

        yield listen


def next_ticks(caller: Caller, count: int) -> list[int]:
    """Return the ticks of the next states that a station is told."""
    found: list[int] = []
    while len(found) < count:
        caller.shown.clear()
        caller.hear()
        found += [caller.tick] if caller.shown else []
    return found


def gone(path: Path) -> bool:
    """Wait until a session has given up its socket; return whether it has."""
    return eventually(lambda: not path.exists())


def console_of(*words: str) -> int:
    """Return the one process at a terminal whose command line has all the words."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            line = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
            at_terminal = (folder / "stat").read_text().rpartition(")")[2].split()[4] != "0"
            if line[1:3] == ["-m", "trainer"] and at_terminal and set(words) <= set(line):
                found.append(int(folder.name))
    assert len(found) == 1, f"{found}: processes of {words}, and the session has no terminal"
    return found[0]


def running(word: str) -> list[str]:
    """Return the processes whose command line has a word."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if word.encode() in path.read_bytes().split(b"\0"):
                found.append(path.parent.name)
    return found


def command(*words: str) -> str:
    return " ".join([*TRAINER, *words])


@pytest.mark.slow
def test_the_first_exercise_by_the_keys_that_help_names(
    terminal: Terminal, ear: Callable[[Path], Caller], tmp_path: Path
) -> None:
    record = tmp_path / "drill.trainer"
    terminal.type(
        command(
            *("run", "periscope-depth", "--duration", "12h"),  # no end of it in between
            *("--speed", "20", "--record", str(record)),
        ),
        "Enter",
    )
    terminal.wait("RUNNING x20")
    terminal.type("F1")
    terminal.wait("A first exercise")
    terminal.type("Escape")
    other = ear(paths.socket_path())

    terminal.wait("00:02:[1-5]|00:0[3-9]:")
    terminal.type("F4")
    terminal.wait("Choose what breaks")
    terminal.type("stern-stuck", "Enter")
    terminal.wait(r"broken  stern-stuck")
    terminal.type("C-s")  # no key of ours stops the terminal or ends the console
    terminal.type("C-q")
    assert len(next_ticks(other, 10)) == 10

    terminal.type("F6")
    terminal.wait("Go back to")
    terminal.type("2", "Enter")
    terminal.wait(r"back from \d+(\.5)? s to \d+")
    terminal.wait("FROZEN")
    terminal.type("F7")
    terminal.wait("Replay from")
    terminal.type("2", "Enter")
    terminal.wait(r"replay from \d+")
    terminal.wait("FROZEN")  # the replay has arrived, or is taken over by hand
    terminal.type("F2")
    terminal.wait("RUNNING")
    terminal.type("F9")
    terminal.wait("<words>")  # what may follow `mark`
    terminal.type("good recovery", "Enter")
    terminal.wait(r"marked at \d+")
    terminal.type("F10")
    terminal.wait("Leave\\?")
    terminal.type("q")
    terminal.wait(r"simulated   \d+\.\d s in \d+ ticks")
    assert record.exists()
    terminal.type("clear; ", command("debrief", "drill.trainer"), "Enter")
    terminal.wait(r"drill\.html")
    assert record.with_suffix(".html").exists()
    assert gone(paths.socket_path())


def test_a_recording_is_gone_on_with_on_the_console_and_its_branches_are_gone_back_to(
    terminal: Terminal, tmp_path: Path
) -> None:
    record = tmp_path / "drill.trainer"
    begin = ("run", "--headless", "--duration", "130", "--speed", "max", "--record", str(record))
    assert run_trainer(*begin).returncode == 0

    terminal.type(command("resume", "drill.trainer", "--speed", "20", "--duration", "1h"), "Enter")
    terminal.wait("FROZEN")
    terminal.wait("00:02:10")
    terminal.type("F2")
    terminal.wait("00:02:[2-5]|00:0[3-9]:")
    terminal.type("freeze", "Enter")
    terminal.wait("FROZEN")
    terminal.type("reset", "Enter")
    terminal.wait("branch 1 returns to where you were")
    terminal.type("branch 1", "Enter")
    terminal.wait("at the end of branch 1, 1[0-9][0-9]")
    terminal.type("F10")
    terminal.wait("Leave\\?")
    terminal.type("q")
    terminal.wait(r"simulated   \d+\.\d s in \d+ ticks")
    assert gone(paths.socket_path())


def test_a_console_fills_its_window_and_killed_leaves_the_session_to_who_is_left(
    terminal: Terminal, ear: Callable[[Path], Caller]
) -> None:
    terminal.type(command("run", "--speed", "10", "--no-record", "--seed", "90210"), "Enter")
    terminal.wait("RUNNING x10")
    *_, last = terminal.wait("F10 quit").rstrip("\n").split("\n")
    assert "F1 help" in last  # whatever size the environment says
    assert "F10 quit" in last
    where = paths.socket_path()
    other = ear(where)
    os.kill(console_of("run", "90210"), signal.SIGKILL)

    ticks = next_ticks(other, 10)
    assert ticks == sorted(set(ticks))  # a busy machine may leave one out
    assert where.exists()
    other.hang_up()
    assert gone(where)


STUCK = """
import os, signal, threading
from types import SimpleNamespace
from trainer.console.launch import Visit

client = SimpleNamespace(start=lambda: None, close=lambda _: None)
console = SimpleNamespace(run=threading.Event().wait, exit=lambda _: None)
threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGHUP)).start()
Visit(client, None, console).show()
"""


def test_a_screen_that_cannot_end_because_its_terminal_is_gone_is_left() -> None:
    done = subprocess.run([sys.executable, "-c", STUCK], timeout=PATIENCE, check=False)
    assert done.returncode == 1


def test_a_console_whose_terminal_goes_without_a_signal_ends() -> None:
    far, near = pty.openpty()
    words = [*TRAINER, "run", "--no-record", "--speed", "10"]
    with subprocess.Popen(
        words, stdin=near, stdout=near, stderr=near, start_new_session=True
    ) as process:  # which the terminal does not control, as no shell began it there
        os.close(near)
        written = b""
        while OPENED not in written:
            written += os.read(far, 65536)
        os.close(far)
        await_work(process.pid, lambda: process.poll() is not None, lambda: "it lives on")
    assert process.returncode == 1
    assert gone(paths.socket_path())


OPENED, LEFT = b"\x1b[?1049h", b"\x1b[?1049l"  # the screen, over what was on the terminal


def told(*command: str, keys: bytes = b"") -> tuple[bytes, int]:
    """Return what a command writes to a terminal to its end, and its exit code.

    ``keys`` are typed once the screen is there.
    """
    far, near = pty.openpty()
    fcntl.ioctl(near, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 130, 0, 0))
    environment = os.environ | {"TERM": "xterm-256color"}
    with subprocess.Popen(
        command, stdin=near, stdout=near, stderr=near, env=environment, start_new_session=True
    ) as process:
        os.close(near)
        late = threading.Timer(PATIENCE, process.kill)
        late.start()
        written = b""
        with contextlib.suppress(OSError):  # the end of a terminal
            while some := os.read(far, 65536):
                written += some
                if keys and OPENED in written and b"making ready" in written:
                    os.write(far, keys)
                    keys = b""
        late.cancel()
    os.close(far)
    return written, process.returncode


@pytest.mark.parametrize("elsewhere", ["", "stdin", "stdout", "stderr"])
def test_a_screen_is_opened_only_where_all_three_streams_are_the_terminal(elsewhere: str) -> None:
    asks = "from trainer.console.terminal import has_terminal; raise SystemExit(has_terminal())"
    ours, theirs = pty.openpty()
    try:
        names = ("stdin", "stdout", "stderr")
        ends = [subprocess.DEVNULL if each == elsewhere else theirs for each in names]
        asked = subprocess.run(
            [sys.executable, "-c", asks],
            stdin=ends[0],
            stdout=ends[1],
            stderr=ends[2],
            env=environment(TERM="xterm", LC_ALL="C.UTF-8"),
            check=False,
        )
    finally:
        os.close(ours)
        os.close(theirs)
    assert asked.returncode == (not elsewhere)


def test_what_is_mistyped_is_told_once_where_it_was_typed_and_no_screen_is_opened() -> None:
    written, code = told(*TRAINER, "run", "periscop-depth")

    assert OPENED not in written
    assert written.count(b"trainer: ") == 1
    assert b"periscope-depth" in written
    assert code == 2


def test_what_a_session_fails_of_as_it_begins_is_told_once_the_screen_is_gone(
    tmp_path: Path,
) -> None:
    nowhere = tmp_path / "nowhere" / "drill.trainer"

    written, code = told(*TRAINER, "run", "--record", str(nowhere))

    assert b"--record" in written.rpartition(LEFT)[2]
    assert code == 2


ENDLESS = """
import sys, threading
from trainer.io import paths
from trainer.cli.main import leave_with
from trainer.console.own_session import sail
import click

def serve(where):
    print(paths.MAKING_READY, "a boat that never is", file=sys.stderr, flush=True)
    threading.Event().wait()

try:
    sail(serve, sys.argv[1], None)
except click.Abort:
    sys.exit(130)
"""


def test_a_screen_left_before_its_session_is_there_takes_it_along(tmp_path: Path) -> None:
    where = str(tmp_path / "s")

    written, code = told(sys.executable, "-c", ENDLESS, where, keys=b"\x1b[21~")

    assert LEFT in written
    assert code == 130
    await_that(lambda: not running(where))


@pytest.fixture
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the socket of a session at ten times the clock's speed."""
    where = tmp_path_factory.mktemp("s") / "s"
    words = ["serve", "--socket", str(where), "--listen", "none", "--no-record", "--speed", "10"]
    with start_trainer(*words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        await_begun(process, where.exists)
        yield where
        process.terminate()


class Screen:
    """A console on a terminal of ours, which reads what it shows only when asked to."""

    def __init__(self, where: Path, columns: int, rows: int) -> None:
        self._far, near = pty.openpty()
        fcntl.ioctl(near, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.process = subprocess.Popen(
            [*TRAINER, "attach", "--connect", str(where)],
            stdin=near, stdout=near, stderr=near, start_new_session=True,
            env=os.environ | {"TERM": "xterm-256color"},
        )  # fmt: skip
        os.close(near)

    def resize(self, columns: int, rows: int) -> None:
        fcntl.ioctl(self._far, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        os.kill(self.process.pid, signal.SIGWINCH)

    def type(self, keys: bytes) -> None:
        os.write(self._far, keys)

    def wait(self, pattern: bytes) -> None:
        """Read until a pattern is shown."""
        shown, done = b"", threading.Timer(PATIENCE, self.process.kill)
        done.start()
        try:
            while not re.search(pattern, shown):
                shown = shown[-20_000:] + os.read(self._far, 65536)
        except OSError:
            raise AssertionError(f"{pattern!r} is not shown") from None
        finally:
            done.cancel()

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._far)


def test_a_blocked_terminal_and_any_size_leave_the_session_undisturbed(
    served: Path, ear: Callable[[Path], Caller]
) -> None:
    other = ear(served)
    with contextlib.closing(Screen(served, 160, 48)) as screen:
        screen.wait(b"RUNNING")
        ticks = next_ticks(other, 40)  # two seconds in which nobody reads the screen
        assert ticks == sorted(set(ticks))
        assert ticks[-1] - ticks[0] < 60  # a busy machine may show two at once
        for columns, rows in ((20, 5), (300, 100), (80, 24)):
            screen.resize(columns, rows)
            screen.wait(b"\x1b")
        screen.type(b"freeze\r")
        screen.wait(b"FROZEN")
        screen.type(b"detach\r")
        screen.wait(b"\\x1b\\[\\?1049l")  # the terminal is as it was before
        screen.process.wait(PATIENCE)
        assert screen.process.returncode == 0


def test_the_session_takes_every_key_of_the_crew_for_an_order_of_theirs(served: Path) -> None:
    for role in ("helm", "planes", "ballast", "diving"):
        post = LAYOUTS[role]
        client = Client(lambda: str(served), role, wishes(post))
        client.start()
        app = Console(SessionModel(client, role, post.charts))
        keys = [key for key in KEYS[role] if isinstance(key.act, OrderAction | MoveAction)]
        log = run_aside(typed(app, [key.names[0] for key in keys]))
        client.close(5.0)

        assert len([entry for entry in log if entry.kind == "sent"]) == len(keys) + 1
        account = next(entry.text for entry in log if "refused, " in entry.text)
        assert "0 refused, 0 bad lines" in account


async def typed(app: Console, keys: list[str]) -> list[JournalEntry]:
    """Return the log of a screen at which keys are pressed, once all is answered."""
    wanted = set(LAYOUTS[app.model.role].channels)
    async with app.run_test() as pilot:
        while not app.model.picture.seconds or not wanted <= set(app.model.picture.last):
            await pilot.pause(LOOK)
        for key in keys:  # at once: a press by the pilot waits for a screen that moves
            app.post_message(events.Key(key, key if len(key) == 1 else None))
        await pilot.pause()
        app.model.order("who")
        while app.model.sent.asked:
            await pilot.pause(LOOK)
    return list(app.model.journal.entries)


def test_the_session_lists_what_can_break_as_it_is_ordered(served: Path) -> None:
    client = Client(lambda: str(served), "instructor", {})
    client.start()
    model = SessionModel(client, "instructor", ())
    waited = threading.Event()
    while not model.vessel.casualties:
        model.hear()
        waited.wait(LOOK)
    client.close(5.0)

    assert {"stern-stuck", "flooding-aft", "propulsion-lost"} <= {
        c.name for c in model.vessel.casualties
    }
    for each in model.vessel.casualties:
        assert isinstance(parse(f"casualty {each.name} {each.degree}"), Order)
        assert each.says


def test_a_console_asked_to_end_gives_the_terminal_back(served: Path) -> None:
    with contextlib.closing(Screen(served, 80, 24)) as screen:
        screen.wait(b"RUNNING")
        os.kill(screen.process.pid, signal.SIGTERM)
        screen.wait(b"\\x1b\\[\\?1049l")
        screen.process.wait(PATIENCE)
        assert screen.process.returncode == 0
