"""Boats of a class whose sessions run elsewhere: led to, neither begun nor resumed nor ended."""

import contextlib
import http.client
import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.classes import class_at_sea, kill
from helpers.nursery import start_trainer
from helpers.pages import free_port
from helpers.places import environment
from helpers.waiting import await_that
from helpers.wire import ask, dialled, request
from soak.session_process import Caller
from websockets.exceptions import ConnectionClosed

from trainer.cli.main import cli
from trainer.config.files import ConfigError

WORD, CHIEF = "anchor-42", "chief-17"
TOKENS = ("--token", WORD, "--token", f"instructor={CHIEF}")


@contextlib.contextmanager
def served(folder: Path, port: int) -> Iterator[subprocess.Popen[str]]:
    """Serve a boat at a port of this machine inside the block."""
    own = environment(XDG_STATE_HOME=str(folder), XDG_RUNTIME_DIR=str(folder))
    where = ("--listen", f"127.0.0.1:{port}", "--socket", str(folder / f"s{port}"))
    words = ("serve", "depth-changes", "--frozen", *where, *TOKENS)
    nothing = subprocess.DEVNULL
    process = start_trainer(*words, env=own, stdin=nothing, stdout=nothing, stderr=nothing)
    try:
        await_that(lambda: listens_at(port))
        yield process
    finally:
        process.kill()
        process.wait()


def listens_at(port: int) -> bool:
    """Return whether a session takes lines at a port."""
    with contextlib.suppress(Exception), Caller(port):
        return True
    return False


@pytest.mark.process
def test_boats_of_two_other_servers_are_led_to_and_one_that_is_lost_is_told(
    tmp_path: Path,
) -> None:
    ports = [free_port(), free_port()]
    elsewhere = [word for port in ports for word in ("--on", f"tcp://127.0.0.1:{port}")]
    with contextlib.ExitStack() as stack:
        first, second = (stack.enter_context(served(tmp_path, port)) for port in ports)
        words = ("depth-changes", "--boats", "1", *elsewhere, *TOKENS)
        lesson = stack.enter_context(class_at_sea(*words, boats=1))
        await_that(lambda: lesson.text().count(" answers") == 2, lesson.text)
        seat = sit(lesson.port, "/word", f"instructor {CHIEF}")
        for boat in (1, 2, 3):
            with dialled(lesson.port, cookies=seat, root=f"/boat/{boat}") as line:
                assert ask(line, f"role instructor {CHIEF}")[0] == "ok"
                assert ask(line, f"order depth {70 + boat}")[0] == "ok"
        crew = sit(lesson.port, "/seat", f"3\nplanes\n{WORD}\n")
        with dialled(lesson.port, cookies=crew, root="/boat/3") as line:
            assert ask(line, f"role planes {WORD}")[0] == "ok"

        kill(first.pid)
        first.wait()
        with (
            contextlib.suppress(ConnectionClosed),
            dialled(lesson.port, cookies=seat, root="/boat/2") as line,
        ):
            ask(line, "who")
        await_that(lambda: "boat 2 is lost: tcp://" in lesson.text(), lesson.text)
        assert states(lesson.port, seat) == ["at sea", "away", "at sea"]
        with served(tmp_path, ports[0]):  # its own machine begins it again
            with dialled(lesson.port, cookies=seat, root="/boat/2") as line:
                assert ask(line, f"role instructor {CHIEF}")[0] == "ok"
            assert states(lesson.port, seat) == ["at sea"] * 3
            assert lesson.end() == 0
            assert second.poll() is None
            assert not list(lesson.folder.glob("boat-[23]*"))
            with class_at_sea(
                *("--resume", str(lesson.folder), *TOKENS), boats=1, folder=lesson.folder
            ) as again:
                await_that(lambda: again.text().count(" answers") == 2, again.text)


def sit(port: int, path: str, body: str) -> str:
    """Take a seat; return the browser's cookies."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    line.request("POST", path, body.encode(), {"Origin": f"http://127.0.0.1:{port}"})
    got = line.getresponse()
    text = got.read().decode()
    assert got.status == 200, text
    kept = [value.partition(";")[0] for name, value in got.getheaders() if name == "set-cookie"]
    line.close()
    return "; ".join(kept)


def states(port: int, cookies: str) -> list[str]:
    """Return the states of the boats, as the class page gets them."""
    told = json.loads(request(port, "/boats", Cookie=cookies).body)
    return [boat["state"] for boat in told["boats"]]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--boats", "23", "--on", "tcp://a:1", "--on", "tcp://b:1"), "a class has 1 to 24 boats"),
        (("--boats", "0"), "a class has 1 to 24 boats"),
        (("--boats", "0", "--on", "tcp://a:99999"), "boat 1: on tcp://a:99999: a port is"),
    ],
)
def test_boats_elsewhere_are_refused_before_anything_begins(
    words: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    folder = tmp_path / "kept"
    typed = ["class", "depth-changes", *words, "--folder", str(folder)]

    with pytest.raises(ConfigError, match=told):
        cli(typed, standalone_mode=False)
    assert not folder.exists()
