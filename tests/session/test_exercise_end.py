"""An exercise to its end and beyond, in a session of its own process with stations at sockets."""

import contextlib
import re
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from helpers.nursery import run_trainer, start_trainer
from helpers.places import environment
from helpers.sessions import TIME_TO_65_M
from helpers.waiting import once_it_can, stay_for
from soak.session_process import Caller, GoneError, SessionProcess

from trainer.debrief.page.page import DebriefRequest, debrief_file
from trainer.io.recording.recording import Recording

pytestmark = pytest.mark.process

PATIENCE = 120.0  # [s] until it listens, on a machine that is busy
JAM = "stern-hard-over"
EXERCISE = f"""
schema = "exercise/1"
name = "Down a little"
briefing = "Go to 65 m."
duration_s = 20
{TIME_TO_65_M}"""


def until(caller: Caller, text: str) -> str:
    """Return the news with some words once it has come, and ask for nothing meanwhile."""
    while not (found := [each.fields[3] for each in caller.news if text in each.fields[3]]):
        caller.hear()
    return found[0]


Serve = Callable[..., SessionProcess]
Attach = Callable[[SessionProcess, str], Caller]


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Serve]:
    """Return a function that starts a session, which listens at a local socket of its own."""
    own = environment(XDG_STATE_HOME=str(tmp_path), XDG_RUNTIME_DIR=str(tmp_path))
    with contextlib.ExitStack() as begun:

        def begin(*words: str) -> SessionProcess:
            where = [] if "--socket" in words else ["--socket", str(tmp_path / "s")]
            pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
            process = start_trainer(
                *words, *where, env=own, stderr=pipe, stdout=pipe, stdin=nothing
            )
            session = SessionProcess(process)
            begun.callback(session.kill)
            return session

        yield begin


@pytest.fixture
def attach() -> Iterator[Attach]:
    """Return a function that attaches a station to a session that ends, or to the next."""
    with contextlib.ExitStack() as lines:
        yield lambda session, role: lines.enter_context(
            once_it_can(lambda: session.caller(role), GoneError)
        )


def account_of(session: SessionProcess) -> str:
    """Return what it says when it has ended; where all its threads are, if it does not end."""
    with contextlib.suppress(subprocess.TimeoutExpired):
        session.process.wait(PATIENCE)
    session.process.send_signal(signal.SIGABRT)
    assert session.ended(PATIENCE) >= 0, "\n".join(session.told)
    return "\n".join(session.account)


@pytest.fixture
def exercise(tmp_path: Path) -> Path:
    path = tmp_path / "down.toml"
    path.write_text(EXERCISE, encoding="utf-8")
    return path


def test_an_exercise_ends_is_judged_flown_again_debriefed_and_followed(
    serve: Serve, attach: Attach, exercise: Path
) -> None:
    served = serve("serve", str(exercise), "--listen", "none", "--speed", "50", "--frozen")
    instructor, helm = attach(served, "instructor"), attach(served, "helm")
    assert instructor.ask("depth 65")[0]
    assert instructor.ask("run")[0]

    until(helm, "EXERCISE OVER: time is up at 20 s")
    until(instructor, "marks:")
    assert not any("marks" in news.fields[3] for news in helm.news)
    assert instructor.ask("release marks")[0]
    assert until(helm, "marks:") == until(instructor, "marks:")
    until(helm, "Time to 65 m:")

    instructor.news.clear()
    assert instructor.ask("again")[0]
    assert instructor.ask("run")[0]
    until(instructor, "EXERCISE OVER")
    assert instructor.ask("debrief")[0]
    page = Path(until(instructor, "debrief written:").partition(": ")[2])
    assert page.name.endswith(".branch2.html")
    (recording,) = exercise.parent.rglob("recordings/*.trainer")
    debrief_file(recording, exercise.parent / "same.html", None, DebriefRequest(2))
    assert page.read_bytes() == (exercise.parent / "same.html").read_bytes()

    assert instructor.ask("next depth-changes")[0]
    with contextlib.suppress(GoneError):
        until(instructor, "nothing of the kind")  # the line is closed
    again = attach(served, "instructor")
    assert again.ask("briefing")[0]
    assert "depth-changes" in again.said[0]
    assert again.ask("status")[0]
    assert any("tick 0" in line for line in again.said)
    assert again.ask("quit")[0]
    told = account_of(served)
    assert served.process.returncode == 0
    assert told.count("outcome") == 1  # nothing was flown of the other
    assert told.index("outcome") < told.index("simulated")
    assert re.search(r"outcome     time is up at 20 s; \d+ marks of 100\n +Time to 65 m: ", told)
    reasons = [line for line in told.splitlines() if line.startswith(" " * 12)]
    assert any(line.startswith(" " * 14) for line in reasons)
    assert max(map(len, reasons)) <= 80
    assert len(list(exercise.parent.rglob("recordings/*.trainer"))) == 2


@pytest.mark.parametrize(
    "words",
    [
        ("serve", "--listen", "none"),
        ("run", "--headless"),
        ("serve", "--listen", "none", "--speed", "max"),
    ],
)
def test_a_duration_of_the_command_line_ends_the_session_as_ever(
    serve: Serve, exercise: Path, words: tuple[str, ...]
) -> None:
    given = ["--duration", "4"] if words[0] == "serve" and "max" not in words else []
    speed = [] if "max" in words else ["--speed", "50"]
    served = serve(words[0], str(exercise), *words[1:], *given, *speed, "--socket", "none")
    assert "simulated" in account_of(served)
    assert served.process.returncode == 0


def test_an_exercise_whose_end_nobody_awaits_ends_its_session(serve: Serve, exercise: Path) -> None:
    served = serve("run", str(exercise), "--teletype", "--speed", "50", "--socket", "none")
    told = account_of(served)
    assert served.process.returncode == 0
    assert "EXERCISE OVER: time is up at 20 s" in told


def test_a_frozen_session_waits_at_its_local_socket(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    home = str(tmp_path_factory.mktemp("xdg"))  # a short name: that of a socket has to be
    process = start_trainer(
        *("serve", "depth-changes", "--listen", "none", "--frozen"),
        env=environment(XDG_STATE_HOME=str(tmp_path), XDG_RUNTIME_DIR=home),
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
    )
    session = SessionProcess(process)
    session.where()
    stay_for(process, 1.5)  # longer than two looks at whether anybody can say run
    with session.caller("instructor") as caller:
        assert caller.ask("run") == (True, "running")
        assert caller.ask("quit")[0]
    assert session.ended(PATIENCE) == 0


@pytest.mark.parametrize(
    "wrong",
    [
        ("--listen", "127.0.0.1:99999"),
        pytest.param(("--line", "helm=/nowhere/tty"), marks=pytest.mark.slow),
        pytest.param(("--socket", f"{__file__}/s"), marks=pytest.mark.slow),
        ("--csv", f"{__file__}/it.csv"),
    ],
)
def test_a_run_that_is_refused_leaves_no_recording(tmp_path: Path, wrong: tuple[str, ...]) -> None:
    kept = tmp_path / "kept.trainer"
    for record in (["--record", str(kept)], []):
        done = run_trainer(
            "serve",
            *wrong,
            *record,
            env=environment(XDG_STATE_HOME=str(tmp_path)),
            timeout=PATIENCE,
        )
        assert done.returncode == 2, done.stderr
    assert not kept.exists()
    assert not list(tmp_path.rglob("*.trainer*"))


def test_what_is_resumed_at_its_exercise_s_end_is_over(
    serve: Serve, attach: Attach, exercise: Path, tmp_path: Path
) -> None:
    kept = tmp_path / "kept.trainer"
    orders = tmp_path / "orders.txt"
    orders.write_text("5 casualty rudder-stuck\n7 rudder left 5\n", encoding="utf-8")
    words = ("run", str(exercise), "--headless", "--speed", "max", "--record", str(kept))
    flown = serve(*words, "--orders", str(orders), "--socket", "none")
    assert "simulated" in account_of(flown)

    served = serve("resume", str(kept), "--teletype")
    instructor = attach(served, "instructor")
    ok, why = instructor.ask("run")
    assert not ok
    assert "the exercise is over" in why
    instructor.news.clear()
    assert instructor.ask("history events")[0]
    assert instructor.ask("who")[0]
    (told,) = [each.fields for each in instructor.news if each.fields[3] == "casualty rudder-stuck"]
    assert told[1] == "5.000"
    assert instructor.ask("backtrack 5 s")[0]
    assert instructor.ask("branches")[0]
    assert len(instructor.said) == 2
    assert instructor.ask("quit")[0]
    account_of(served)
    with contextlib.closing(Recording.look(kept)) as recording:
        assert len(recording.branches()) == 2


def test_a_plan_that_was_refused_is_refused_after_a_kill(
    serve: Serve, attach: Attach, exercise: Path, tmp_path: Path
) -> None:
    kept = tmp_path / "kept.trainer"
    first = serve("serve", str(exercise), "--frozen", "--record", str(kept))
    instructor = attach(first, "instructor")
    assert instructor.ask("step 10")[0]
    assert instructor.ask("at 60 s depth 70")[0]
    refused = [instructor.ask(f"at 1 s {order}") for order in ("emergency blow", f"casualty {JAM}")]
    first.kill()

    second = serve("resume", str(kept), "--frozen")
    instructor = attach(second, "instructor")
    instructor.said.clear()
    assert instructor.ask("plans")[0]
    plans = list(instructor.said)
    assert instructor.ask("step 10")[0]
    assert instructor.ask("quit")[0]
    account_of(second)
    assert [ok for ok, _ in refused] == [False, False]
    assert plans == ["1: at 00:01:00: depth 70 m"]
    with contextlib.closing(Recording.look(kept)) as recording:
        orders = [(each.text, each.accepted) for each in recording.orders(1)]
    assert orders == [
        ("at 60 s depth 70 m", True),
        ("at 1 s emergency blow", False),
        (f"at 1 s casualty {JAM}", False),
    ]
