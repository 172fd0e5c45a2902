"""``trainer run`` as its user has it: a process with pipes, files, lines and signals."""

import contextlib
import csv
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.lanes import sample_cases
from helpers.nursery import start_trainer
from helpers.places import environment
from helpers.waiting import stay_for

from trainer.cli import run as run_command
from trainer.cli.main import main
from trainer.config.boat.vessel import load_vessel
from trainer.session.doors.ports import Ports
from trainer.session.past.options import RunOptions
from trainer.session.run import run_boat

pytestmark = pytest.mark.process

PATIENCE = 120.0  # [s] a first run compiles
HEADLESS = ("run", "--headless", "--speed", "max")
ORDERS = "1 rudder right 15\n3 depth 70\n6 bell ahead full\n12 rudder left 10\n"

Start = Callable[..., "subprocess.Popen[str]"]

posix = pytest.mark.skipif(os.name != "posix", reason="signals and shells of POSIX")


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Return a function that starts the command in an empty folder; what still runs is killed."""
    with contextlib.ExitStack() as started:

        def begin(*words: str, before: tuple[str, ...] = (), **more: str) -> object:
            pipe = subprocess.PIPE
            own = environment(**more)
            process = start_trainer(
                *words, before=before, cwd=tmp_path, env=own, stdin=pipe, stdout=pipe, stderr=pipe
            )
            started.enter_context(process)
            started.callback(process.kill)
            return process

        yield begin  # type: ignore[misc]  # the type of its keywords is loose


class Run:
    """What a finished command has said."""

    def __init__(self, process: "subprocess.Popen[str]", typed: str = "") -> None:
        self.out, self.err = process.communicate(typed, timeout=PATIENCE)
        self.code = process.returncode
        self.shown = [line for line in self.out.splitlines() if re.match(r"\d\d:\d\d:\d\d", line)]


def rows(path: Path) -> list[dict[str, float]]:
    with path.open(newline="") as stream:
        return [{name: float(text) for name, text in row.items()} for row in csv.DictReader(stream)]


def heard(process: "subprocess.Popen[str]", words: str) -> str:
    """Return the next line of output that holds the words."""
    assert process.stdout
    for line in process.stdout:
        if words in line:
            return line
    raise AssertionError(f"{words!r} was never said")


def reached(process: "subprocess.Popen[str]", clock: str) -> str:
    """Return the next line of that clock or a later one: a run that was held up leaves some out."""
    assert process.stdout
    for line in process.stdout:
        if re.match(r"\d\d:\d\d:\d\d", line) and line >= clock:
            return line
    raise AssertionError(f"{clock} was never reached")


def say(process: "subprocess.Popen[str]", words: str) -> None:
    assert process.stdin
    process.stdin.write(words)
    process.stdin.flush()


# The newcomer's run


def test_a_pipe_steers_the_boat_and_its_end_does_not_end_the_run(
    start: Start, tmp_path: Path
) -> None:
    ran = Run(start("run", "--duration", "120", "--speed", "max"), "depth 80\n")

    assert ran.code == 0
    assert "keeping depth 80 m" in ran.out
    assert len(ran.shown) == 1 + 240  # the start and every tick
    assert ran.shown[-1].startswith("00:02:00")
    assert float(ran.shown[-1][9:15]) > 75.0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("option", "role"), [("--train", "trainee"), ("--instruct", "instructor")])
def test_a_script_says_who_it_is(start: Start, option: str, role: str) -> None:
    words = "casualties\nquit\n"
    ran = Run(start("run", "heavy-boat", option, "--speed", "max"), words)

    assert ran.code == 0
    assert ("you are a trainee; who is alone may, after `role instructor`" in ran.out) == (
        role == "trainee"
    )
    assert ("stern-stuck" in ran.out) == (role == "instructor")
    assert ("Trim (heavy-boat)" in ran.out) == (role == "instructor")


def test_orders_wait_for_no_line_end_and_quit_ends_the_run(start: Start) -> None:
    ran = Run(start("run", "--speed", "max"), "freeze\nstep 3\nrudder right 10\nquit")
    assert ran.code == 0
    assert "in 3 ticks" in ran.err
    assert ran.shown[-1].startswith("00:00:01F")
    assert "rudder right 10, by hand" in ran.out


def test_the_summary_counts_what_was_simulated(start: Start, tmp_path: Path) -> None:
    (tmp_path / "orders.txt").write_text("0 trim manual\n")
    plain = Run(start(*HEADLESS, "--duration", "2m", "--orders", "orders.txt"))
    ran = Run(start(*HEADLESS, "--duration", "2m", "--orders", "orders.txt", "--verbose"))

    assert plain.code == ran.code == 0
    assert plain.out == "simulated   120.0 s in 240 ticks, all on time\n"
    assert ran.out.startswith(plain.out)
    assert max(map(len, ran.out.splitlines())) <= 79
    assert re.search(r"duty cycle  0\.\d+ %   \(1969: 38 % at 0.5 s, 19 % at 1 s\)", ran.out)
    assert "overruns 0, caught up 0, slipped 0, gaps 0 (0.0 s)" in ran.out
    assert "the boat    60 m, course 000.0, 10 kn" in ran.out
    assert len(ran.out.splitlines()) <= 24


# The recording


def test_the_csv_has_a_row_for_the_start_and_each_tick_and_loses_no_digit(
    start: Start, tmp_path: Path
) -> None:
    ran = Run(start(*HEADLESS, "--duration", "30", "--step", "0.3", "--csv", "out.csv"))
    assert ran.code == 0

    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert lines[0] == (
        "tick,t,u,v,w,p,q,r,x,y,z,phi,theta,psi,"
        "delta_r,delta_s,delta_b,u_c,weight,x_g,z_g,eta_wave,validity"
    )
    assert len(lines) == 102
    for tick, line in enumerate(lines[1:]):
        cells = line.split(",")
        assert len(cells) == 23
        assert (cells[0], float(cells[1])) == (str(tick), tick * 0.3)
        assert [repr(float(cell)) for cell in cells[1:]] == cells[1:]


def test_psi_is_not_wrapped(start: Start, tmp_path: Path) -> None:
    (tmp_path / "orders.txt").write_text("0 rudder right 20\n")
    files = ("--orders", "orders.txt", "--csv", "out.csv")
    assert Run(start(*HEADLESS, "--duration", "10m", *files)).code == 0
    assert rows(tmp_path / "out.csv")[-1]["psi"] > 7.0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("speed", ["max", "100"])
def test_a_full_disk_is_told_and_the_run_still_finishes(start: Start, speed: str) -> None:
    ran = Run(start("run", "--speed", speed, "--duration", "20", "--csv", "/dev/full"))

    assert ran.code == 1
    assert "trainer: /dev/full: No space left on device; 0 rows are whole" in ran.err
    assert ran.out.count("NOT RECORDED: /dev/full") == (speed == "100")  # at once, not at the end
    assert "in 40 ticks" in ran.err
    assert ran.shown[-1].startswith("00:00:20")


@posix
def test_a_disk_that_fills_up_keeps_the_rows_that_are_said_to_be_whole(
    start: Start, tmp_path: Path
) -> None:
    limit = ("sh", "-c", 'ulimit -f 100; exec "$@"', "sh")
    Run(start(*HEADLESS, "--duration", "10"))  # compiled now: the cache has no room either
    ran = Run(start(*HEADLESS, "--duration", "10m", "--csv", "out.csv", before=limit))

    assert ran.code == 1
    told = re.search(r"out.csv: File too large; (\d+) rows are whole", ran.err)
    assert told
    text = (tmp_path / "out.csv").read_text()
    assert int(told[1]) == text.count("\n") - 1 > 100
    assert "in 1200 ticks" in ran.out


@posix
def test_what_a_full_disk_loses_of_sentences_and_the_recording_is_told_and_no_debrief_promised(
    start: Start,
) -> None:
    limit = ("sh", "-c", 'ulimit -f 1200; exec "$@"', "sh")
    kept = ("--record", "kept.trainer", "--nmea-record", "out.nmea")
    Run(start(*HEADLESS, "--duration", "10"))  # compiled now: the cache has no room either
    ran = Run(start(*HEADLESS, "--duration", "1h", *kept, before=limit))

    assert ran.code == 1
    assert re.search(r"lines were not read there: .*File too large", ran.err)
    assert "trainer: NOT RECORDED: " in ran.err
    assert "shows how it went" not in ran.out


# The same inputs, the same bits


def recorded(start: Start, folder: Path, *words: str, typed: str = "") -> bytes:
    """Return the CSV bytes of a run under scheduled orders."""
    (folder / "orders.txt").write_text(ORDERS)
    files = ("--orders", "orders.txt", "--csv", "out.csv")
    ran = Run(start("run", *words, "--duration", "15", *files), typed)
    assert ran.code == 0, ran.err
    return (folder / "out.csv").read_bytes()


@pytest.mark.parametrize("equations", ["modified", pytest.param("full", marks=pytest.mark.slow)])
def test_the_same_inputs_give_the_same_bits(start: Start, tmp_path: Path, equations: str) -> None:
    here = ("--equations", equations)
    reference = recorded(start, tmp_path, *here, "--headless", "--speed", "max")

    assert reference.count(b"\n") == 32
    again = {
        "a console": recorded(start, tmp_path, *here, "--speed", "max"),
        "real time": recorded(start, tmp_path, *here, "--speed", "50"),
        "frozen": recorded(
            start, tmp_path, *here, "--speed", "max", typed="freeze\nstep 5\nfreeze\nstep\nrun\n"
        ),
    }
    assert [name for name, found in again.items() if found != reference] == []


@posix
def test_a_killed_run_leaves_whole_rows_and_run_again_gives_the_same_bits(
    start: Start, tmp_path: Path
) -> None:
    reference = recorded(start, tmp_path, "--headless", "--speed", "max")
    files = ("--orders", "orders.txt", "--csv", "out.csv")
    process = start("run", "--speed", "10", "--duration", "15", *files)
    reached(process, "00:00:04")
    process.kill()
    process.wait(PATIENCE)

    left = (tmp_path / "out.csv").read_bytes()
    assert left.count(b"\n") >= 9
    assert reference.startswith(left)
    assert left.endswith(b"\n")
    assert recorded(start, tmp_path, "--headless", "--speed", "max") == reference


# Signals and broken pipes


@posix
@pytest.mark.parametrize(
    ("number", "words"),
    [(signal.SIGINT, ""), (signal.SIGTERM, "freeze\n"), (signal.SIGINT, "time max\n")],
)
def test_a_signal_ends_the_run_cleanly_with_its_recording_complete(
    start: Start, tmp_path: Path, number: int, words: str
) -> None:
    process = start("run", "--speed", "20", "--csv", "out.csv")
    reached(process, "00:00:02")
    if words:
        say(process, words)
        heard(process, {"freeze\n": "frozen", "time max\n": "time runs as fast"}[words])
    process.send_signal(number)
    ran = Run(process)

    assert ran.code == 0, ran.err
    told = re.search(r"in (\d+) ticks", ran.err)
    assert told
    found = rows(tmp_path / "out.csv")
    assert [row["tick"] for row in found] == list(range(int(told[1]) + 1))
    assert (tmp_path / "out.csv").read_text().endswith("\n")


@posix
def test_ctrl_c_as_soon_as_a_session_listens_ends_it_with_its_summary(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def open_and_interrupt(ports: Ports, options: RunOptions) -> None:
        del ports, options
        with contextlib.suppress(KeyboardInterrupt):  # lost, as in a call back from C
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Ports, "lobby", open_and_interrupt)

    code = run_boat(RunOptions(headless=True, serve=True, no_record=True, frozen=True))

    assert code == 0
    assert "simulated   0.0 s" in capsys.readouterr().out


@posix
@pytest.mark.parametrize("kept", [False, True])
def test_a_reader_that_goes_away_costs_its_output_and_nothing_else(
    start: Start, tmp_path: Path, *, kept: bool
) -> None:
    record = ("--record", "kept.trainer") if kept else ("--no-record",)
    process = start("run", "--speed", "max", "--duration", "5m", "--csv", "out.csv", *record)
    assert process.stdin
    assert process.stdout
    process.stdin.close()
    for _ in range(3):
        process.stdout.readline()
    process.stdout.close()
    assert process.stderr
    told = process.stderr.read()

    assert process.wait(PATIENCE) == 0
    whole = "; the recording has all that happened" if kept else ""
    assert re.search(
        r"trainer: instructor at console: \d+ lines were not read there: .*Broken pipe"
        rf"{whole}\n",
        told,
    )
    assert "Traceback" not in told
    assert len(rows(tmp_path / "out.csv")) == 601


@posix
@pytest.mark.parametrize("closed", sample_cases(["<&-", ">&-", "<&- >&- 2>&-"], "<&- >&- 2>&-"))
def test_closed_streams_do_not_disturb_the_run_or_get_into_its_recording(
    start: Start, tmp_path: Path, closed: str
) -> None:
    shell = ("sh", "-c", f'exec "$@" {closed}', "sh")
    process = start("run", "--speed", "max", "--duration", "20", "--csv", "out.csv", before=shell)
    ran = Run(process)

    assert ran.code == 0, ran.err
    assert "Traceback" not in ran.err
    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert [line.count(",") for line in lines] == [22] * 42


@pytest.mark.clock
@posix
def test_a_stopped_process_goes_on_without_a_burst_and_the_gap_is_told(start: Start) -> None:
    process = start("run", "--speed", "20", "--verbose")  # 40 lines a second
    reached(process, "00:00:02")
    process.send_signal(signal.SIGSTOP)
    stopped = time.monotonic()
    stay_for(process, 1.0)  # the gap
    process.send_signal(signal.SIGCONT)
    gap = time.monotonic() - stopped  # [s] longer where this process was held up too
    told = heard(process, "the process was not running for")
    resumed = time.monotonic()
    at = int(told.split()[1].rstrip(":"))
    lines = [heard(process, ":") for _ in range(20)]
    taken = time.monotonic() - resumed
    say(process, "quit\n")
    ran = Run(process)

    assert float(told.split()[-2]) == pytest.approx(gap, abs=0.5)
    assert taken > 0.25  # a burst is over at once; 20 ticks take 0.475 s
    assert len(lines) == 20
    assert at < 20  # 40 ticks were due meanwhile
    assert ran.code == 0
    assert re.search(r"simulated .* not running for \d+\.\d s", ran.err)
    found = re.search(r"caught up (\d+), slipped (\d+), gaps (\d+) \(([\d.]+) s\)", ran.err)
    assert found
    assert int(found[1]) + int(found[2]) < 15
    assert int(found[3]) >= 1
    assert float(found[4]) > gap - 0.5


# The console on a line


def dialogue(line: socket.socket) -> str:
    """Return what the console says until it has answered an order and shown the boat."""
    said = b""
    end = time.monotonic() + PATIENCE
    for order, answer in (
        (b"", b"help   quit\r\n"),  # a line that opens may drop what came before
        (b"rudder right 10\r\n", b"rudder right 10, by hand\r\n"),
        (b"", b" R10.0* "),
        (b"quit\r\n", b"ending\r\n"),
    ):
        line.sendall(order)
        while answer not in said and time.monotonic() < end:
            said += line.recv(4096)
        assert answer in said
    return said.decode("ascii")


def test_a_socket_is_a_console(start: Start) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        process = start("run", "--speed", "20", "--serial", f"socket://127.0.0.1:{port}")
        server.settimeout(PATIENCE)
        line, _ = server.accept()
        with line:
            line.settimeout(PATIENCE)
            said = dialogue(line)
            ran = Run(process)

    assert said.startswith("Joubert BB2")
    assert ran.code == 0
    assert "simulated" in ran.err


# Wrong input: one line that helps, exit code 2


Refuse = Callable[..., str]


@pytest.fixture
def refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Refuse:
    """Return a function that runs the command in this process and returns what it refuses with."""
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        monkeypatch.setattr(sys, "argv", ["trainer", *words])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        assert left.value.code == 2, said.err
        assert said.out == ""
        told = said.err.splitlines()
        assert [line for line in told if not line.startswith("trainer: ")] == []
        return "\n".join(told)

    return run


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("--vessel bb3", 'no vessel "bb3"; nearest is bb2; shipped: bb2, remus100, sdv-mk9'),
        ("--vessel ./boat.toml", "boat.toml: there is no such file"),
        ("--step 0", "--step 0: a step is 0.001 to 2 s"),
        ("--step=-1", "--step -1: a step is 0.001 to 2 s"),
        ("--step 3", "--step 3: a step is 0.001 to 2 s"),
        ("--step nan", "--step nan: a step is 0.001 to 2 s"),
        ("--step x", "'x' is not a valid float"),
        ("--speed 0", "'0' is not a speed of time: 0.1 to 100, or max"),
        ("--speed nan", "'nan' is not a speed of time"),
        ("--speed 1000", "'1000' is not a speed of time"),
        ("--duration x", "'x' is not a time such as 90, 10m or 1h30m"),
        ("--duration 1hour", "'1hour' is not a time such as 90, 10m or 1h30m; did you mean 1h?"),
        ("--duration 1,5hrs,5min", "or 1h30m; did you mean 1.5h5m?"),
        ("--duration 0", "a run lasts longer than 0 s"),
        ("--duration=-5", "is not a time"),
        ("--integrator rk5", "--integrator 'rk5': give one of euler, adams2, best2, "),
        ("--integrator a=1;b=2", "--integrator a=1;b=2: "),
        ("--equations ful", "'ful' is not one of 'full', 'modified', 'basic', 'longitudinal'"),
        ("--csv no/such/out.csv", "no/such/out.csv: there is no folder no/such"),
        ("--csv .", "--csv .: Is a directory"),
        ("--orders none.txt", "--orders none.txt: there is no such file"),
        ("--serial ./ttyNONE", "--serial ./ttyNONE: No such file or directory"),
        ("--serial socket://127.0.0.1:1", "--serial socket://127.0.0.1:1: Connection refused"),
        ("--serial sockt://x", "did you mean socket"),
        ("--vesel bb2", "No such option '--vesel'"),
        ("--train --instruct", "--train and --instruct exclude each other: say who you are"),
        ("extra", 'no exercise "extra"; shipped: air-bank-failure, '),
        ("bb2", 'no exercise "bb2"; that is a vessel (--vessel bb2); shipped: air-bank-failure, '),
        ("bb3", 'no exercise "bb3"; nearest is the vessel bb2 (--vessel bb2); shipped: air-'),
        ("calm", 'no exercise "calm"; that is a sea (--sea calm); shipped: air-bank-failure, '),
        ("detph", 'no exercise "detph"; nearest is depth-changes; shipped: air-bank-failure, '),
        ("heavy-boat extra", "unexpected extra argument"),
    ],
)
def test_a_wrong_option_is_told_in_one_line(refused: Refuse, words: str, told: str) -> None:
    line = refused("run", "--headless", "--speed", "max", "--duration", "1", *words.split())
    assert told in line
    assert "\n" not in line


def test_a_wrong_option_or_command_is_told_the_nearest(refused: Refuse) -> None:
    assert "did you mean run?" in refused("rnu")
    assert "--vessel" in refused("run", "--vesel", "bb2").replace("'--vesel'", "")
    assert refused("run", "--stp", "1").endswith("(trainer run --help says more)")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("5 rudder right 10\n10 ruder left 5\n", "orders.txt:2: "),
        ("1 freeze\n2 help\n", "orders.txt:2: help has no place in a schedule"),
        ("\udcff\udcfe\n", "--orders orders.txt: is not UTF-8 text (byte 0 is wrong)"),
        ("# \n" * 400_000, "--orders orders.txt: is larger than the limit of 1000000 bytes"),
    ],
)
def test_a_wrong_schedule_is_told_by_file_and_line(
    refused: Refuse, tmp_path: Path, text: str, told: str
) -> None:
    (tmp_path / "orders.txt").write_bytes(text.encode("utf-8", errors="surrogateescape"))
    assert told in refused(*HEADLESS, "--duration", "1", "--orders", "orders.txt")


def test_a_wrong_vessel_is_told_by_file_table_and_key(refused: Refuse, tmp_path: Path) -> None:
    text = load_vessel("bb2").path.read_text()
    assert text.count("\nIx = 5.23e7") == 1
    (tmp_path / "boat.toml").write_text(text.replace("\nIx = 5.23e7", "\nIx = 0.0"))

    line = refused(*HEADLESS, "--duration", "1", "--vessel", "./boat.toml")

    assert line.startswith("trainer: boat.toml: [vessel] Ix = 0")


# Steps that are not stable, and what becomes of a boat that is driven with one all the same


def test_an_unstable_step_is_refused_with_the_largest_stable_one(
    refused: Refuse, start: Start
) -> None:
    line = refused(*HEADLESS, "--duration", "1", "--step", "2", "--integrator", "euler")

    assert "--step 2 s is not stable with euler" in line
    largest = re.search(r"the largest stable step is ([\d.]+) s \(--unsafe-step runs it", line)
    assert largest
    below = f"{0.98 * float(largest[1]):.3f}"
    ran = Run(start(*HEADLESS, "--duration", "10", "--step", below, "--integrator", "euler"))
    assert ran.code == 0, ran.err
    above = f"{1.02 * float(largest[1]):.3f}"
    assert "is not stable" in refused(*HEADLESS, "--step", above, "--integrator", "euler")


@pytest.mark.parametrize(("equations", "integrator"), [("full", "euler"), ("modified", "adams3")])
def test_a_boat_driven_to_divergence_freezes_and_says_where(
    start: Start, tmp_path: Path, equations: str, integrator: str
) -> None:
    (tmp_path / "orders.txt").write_text("10 rudder right 25\n10 stern dive 20\n10 turns 20\n")
    bottomless = load_vessel("bb2").text.replace("collapse_depth_m", "# collapse_depth_m")
    bottomless, rolling = re.subn(r"(?m)^K_p    = .*", "K_p = 0.01  # feeds her roll", bottomless)
    assert rolling == 1
    (tmp_path / "bottomless.toml").write_text(bottomless)
    ran = Run(
        start(
            *("run", "--speed", "max", "--duration", "2h", "--step", "2", "--unsafe-step"),
            *("--equations", equations, "--integrator", integrator),
            *("--vessel", "./bottomless.toml", "--orders", "orders.txt", "--csv", "out.csv"),
        )
    )

    assert ran.code == 1
    told = re.search(
        r"trainer: frozen: (\w+) is out of all bounds after tick (\d+) \((\d+) s\); "
        r"last good state: u (\S+) m/s, pitch (\S+) deg, heel (\S+) deg, depth (\S+) m",
        ran.err,
    )
    assert told
    assert f"FROZEN: {told[1]} is out of all bounds after tick {told[2]}" in ran.out
    text = (tmp_path / "out.csv").read_text()
    assert "nan" not in text
    assert "inf" not in text
    last = rows(tmp_path / "out.csv")[-1]
    assert last["tick"] == float(told[2])
    assert last["t"] == 2.0 * last["tick"] == float(told[3])
    assert last["u"] == pytest.approx(float(told[4]), rel=1e-3)
    assert max(map(len, ran.err.splitlines())) < 300


# The command itself


def test_the_bare_command_says_what_it_can_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["trainer"])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
    out = capsys.readouterr().out
    assert re.search(r"^  run +Run a boat in real time", out, re.MULTILINE)
    assert "Usage: trainer" in out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_summary_that_cannot_be_written_is_told_without_a_traceback(start: Start) -> None:
    shell = ("sh", "-c", 'exec "$@" >/dev/full', "sh")
    ran = Run(start(*HEADLESS, "--duration", "5", before=shell))
    assert ran.code != 0
    assert "trainer: No space left on device" in ran.err
    assert "Traceback" not in ran.err


@posix
@pytest.mark.parametrize(("piped", "told"), [("depth 80\n", 1), ("", 0)])
def test_a_headless_run_says_once_that_it_does_not_hear_what_is_piped(
    start: Start, piped: str, told: int
) -> None:
    ran = Run(start(*HEADLESS, "--duration", "60"), piped)

    assert ran.code == 0, ran.err
    assert ran.err.count("not heard by --headless: leave it out\n") == told


def test_orders_that_are_piped_during_a_headless_run_are_told_at_its_end(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    waiting = iter([False, True])
    monkeypatch.setattr(run_command, "input_waits", lambda: next(waiting))
    monkeypatch.setattr(sys, "argv", ["trainer", *HEADLESS, "--duration", "1"])

    with pytest.raises(SystemExit) as left:
        main()

    assert left.value.code == 0
    assert capsys.readouterr().err.count("not heard by --headless") == 1
