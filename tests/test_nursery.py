"""A trainer that was forked is told from one that was started by nothing that tests look at."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.nursery import Child, run_trainer, start_trainer
from helpers.places import environment
from helpers.process_guard import unmarked_tests
from helpers.waiting import await_that

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(sys.platform != "linux", reason="trainers are forked on Linux"),
]
FLIGHT = ("run", "--headless", "--speed", "max", "--duration", "5", "--no-record")
SERVE = ("serve", "--listen", "127.0.0.1:0", "--socket", "none", "--no-record")


def is_running(process: int) -> bool:
    """Return whether there is such a process, which has not ended."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except (
        FileNotFoundError,
        ProcessLookupError,
    ):  # gone before it was opened, or before it was read
        return False
    return state != "Z"


@pytest.mark.parametrize(
    "words",
    [("boat", "vessels"), ("run", "--hedless"), (*FLIGHT, "--csv", "out.csv"), ("run", "no-such")],
)
def test_it_does_says_and_leaves_what_a_started_one_does(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    folders = [tmp_path / name for name in ("forked", "started")]
    for folder in folders:
        folder.mkdir()

    forked = run_trainer(*words, cwd=folders[0], env=environment())
    started = subprocess.run(
        [sys.executable, "-m", "trainer", *words],
        cwd=folders[1],
        env=environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )

    assert (forked.returncode, forked.stderr) == (started.returncode, started.stderr)
    assert forked.stdout.splitlines()[:1] == started.stdout.splitlines()[:1]
    assert [sorted(path.name for path in folder.iterdir()) for folder in folders] == 2 * [
        ["out.csv"] if "--csv" in words else []
    ]


def test_it_reads_what_is_typed_and_has_its_own_environment(tmp_path: Path) -> None:
    done = run_trainer("run", "--duration", "5", "--speed", "max", typed="depth 80\n")
    assert (done.returncode, done.stderr.count("\n")) == (0, 1)
    assert "keeping depth 80 m" in done.stdout

    looked = run_trainer("debrief", "--last", env=environment(XDG_STATE_HOME=str(tmp_path)))
    assert f"no recording is in {tmp_path}" in looked.stderr


@pytest.mark.parametrize(
    ("end", "code"),
    [
        (lambda process: process.kill(), -signal.SIGKILL),
        (lambda process: os.kill(process.pid, signal.SIGKILL), -signal.SIGKILL),
        (lambda process: process.send_signal(signal.SIGINT), 0),
    ],
)
def test_it_is_a_process_of_its_own(
    end: Callable[["subprocess.Popen[str]"], object], code: int
) -> None:
    with start_trainer(*SERVE, stderr=subprocess.PIPE) as process:
        assert process.poll() is None
        assert process.stderr
        assert next(line for line in process.stderr if "listening at" in line)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.0)

        end(process)

        assert process.wait(60.0) == code
    assert not is_running(process.pid)


def test_what_is_left_behind_ends_with_who_started_it() -> None:
    process = start_trainer(*SERVE, stderr=subprocess.PIPE)
    assert isinstance(process, Child)
    number, stream = process.pid, process.stderr
    assert stream
    assert next(line for line in stream if "listening at" in line)
    assert is_running(number)

    with stream:
        process.hang_up()

        await_that(lambda: not is_running(number))


@pytest.mark.parametrize(
    "name", ["PYTHONUTF8", "NUMBA_DISABLE_JIT", "XDG_CACHE_HOME", "LC_ALL", "LD_LIBRARY_PATH"]
)
def test_what_an_interpreter_reads_as_it_starts_is_asked_of_one_that_starts(
    name: str, tmp_path: Path
) -> None:
    with start_trainer(
        "--help", env=environment(**{name: str(tmp_path)}), stdout=subprocess.DEVNULL
    ) as process:
        assert isinstance(process, subprocess.Popen)


def test_a_test_that_is_not_marked_can_fork_none() -> None:
    run_trainer("--version")
    unmarked_tests.append("a test")
    try:
        with pytest.raises(pytest.fail.Exception, match="mark it process"):
            run_trainer("--version")
    finally:
        unmarked_tests.clear()
