"""What a user does needs no numba: by command, by three lines of a session, and by call."""

import json
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import places
from helpers.installation import run_program
from helpers.waiting import PATIENCE

import trainer
from trainer.boat import machine_code
from trainer.config.files import shipped_names

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(
        machine_code.way_name() != "shipped", reason="settings of numba ask for other code"
    ),
]
STATE_LINE = (
    '{"u": 5, "v": 0, "w": 0, "p": 0, "q": 0, "r": 0.01, "phi": 0, "theta": 0, "psi": 0, '
    '"z": 60, "delta_r": 0, "delta_s": 0, "delta_b": 0, "u_c": 5}\n'
)
SAILED_S = 300.0  # [s]
TELLING = ("crossing-traffic", "canyon", "flooding-aft")  # of every commit
# by call, in a process without numba
CALL = f"""
import hashlib
from helpers.without_numba import refuse_numba
refuse_numba()
from trainer import Boat
boat = Boat(sea="sea-state-5", depth=18)
boat.order("course 090")
kept = boat.snapshot()
boat.run({SAILED_S})
boat.restore(kept)
boat.run({SAILED_S})
print(repr(boat.state))
"""


def commands(folder: Path, seconds: str) -> list[list[str]]:
    """Return commands that a user's session is made of."""
    run = ["run", "--headless", "--speed", "max"]
    kept = str(folder / "kept.trainer")
    flown = [
        [run[0], name, *run[1:], "--duration", seconds, "--no-record"]
        for name in (TELLING if seconds == "20" else shipped_names("exercises"))
    ]
    return [
        [*run, "--duration", "90", "--sea", "sea-state-5", "--csv", str(folder / "run.csv")],
        ["run", "stern-plane-jam", *run[1:], "--duration", "2m", "--record", kept],
        ["debrief", kept, "--text"],
        ["debrief", kept, "--html", str(folder / "debrief.html")],
        ["replay", kept],
        ["resume", kept, "--headless", "--speed", "max", "--duration", "3m"],
        ["export", kept, "--csv", str(folder / "kept.csv")],
        ["manoeuvre", "zigzag-20", "bb2", "--equations", "modified"],
        ["manoeuvre", "turning-circle", "sdv-mk9"],
        ["exercise", "check", "stern-plane-jam"],
        ["sea", "sea-state-5", "--depth", "20"],
        ["neutral", "bb2", "--depth", "20"],
        ["vessels"],
        ["evaluate", "bb2"],
        ["evaluate", "bb2", "--wide"],
        *flown,
    ]


def bare_environment(folder: Path) -> dict[str, str]:
    """Return the environment of a process whose cache is a folder that is not there yet."""
    return places.tests_environment(XDG_CACHE_HOME=str(folder / "cache"), NUMBA_CACHE_DIR="")


@pytest.mark.parametrize("seconds", ["20", pytest.param("30m", marks=pytest.mark.slow)])
def test_a_user_s_session_needs_no_numba(tmp_path: Path, seconds: str) -> None:
    listed = tmp_path / "commands.json"
    listed.write_text(json.dumps(commands(tmp_path, seconds)))
    done = run_program(
        [sys.executable, "-m", "helpers.without_numba", str(listed)],
        env=bare_environment(tmp_path),
        input=STATE_LINE,
    )
    told = [json.loads(line) for line in done.stdout.splitlines()]

    assert len(told) == len(commands(tmp_path, seconds))
    for each in told:
        assert (each["raised"], each["code"]) in {("", 0), ("", 1)}, each
        assert "Traceback" not in each["said"]
        assert ('"udot"' in each["said"]) == (each["words"][0] == "evaluate")
    assert not (tmp_path / "cache").exists()


def test_what_is_typed_into_a_session_needs_no_numba(tmp_path: Path) -> None:
    words = ["run", "--speed", "max", "--duration", "20", "--no-record"]
    done = run_program(
        [sys.executable, "-m", "helpers.without_numba", *words],
        env=bare_environment(tmp_path),
        input="depth 70\n",
    )

    assert "keeping depth 70 m" in done.stdout
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "cache").exists()


class SerialStation:
    """A panel at a line of a session, by TCP."""

    def __init__(self, role: str, stack: ExitStack) -> None:
        self._server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        self._server.settimeout(PATIENCE)
        self._stack = stack
        self.option = f"--line={role}=socket://127.0.0.1:{self._server.getsockname()[1]}"

    def connect(self) -> None:
        """Wait until the session opens the line."""
        line, _ = self._server.accept()
        line.settimeout(PATIENCE)
        self._line = self._stack.enter_context(line)
        self._said = self._stack.enter_context(line.makefile(encoding="utf-8"))

    def order(self, words: str, answer: str) -> None:
        """Give an order, and wait for its answer."""
        self._line.sendall(f"{words}\n".encode())
        self.await_line(answer)

    def await_line(self, text: str) -> None:
        """Wait until a line of the session begins with a text."""
        said = []
        for line in self._said:
            said.append(line)
            if line.startswith(text):
                return
        raise AssertionError(said)


def test_a_session_of_three_lines_needs_no_numba_and_has_the_bits_of_a_call(
    tmp_path: Path,
) -> None:
    kept = tmp_path / "kept.trainer"
    where = ["--listen", "none", "--socket", "none", "--record", str(kept)]
    how = ["--frozen", "--speed", "max", "--duration", str(SAILED_S), "--sea", "sea-state-3"]
    with ExitStack() as stack:
        stations = [SerialStation(role, stack) for role in ("helm", "planes", "instructor")]
        helm, planes, instructor = stations
        lines = [station.option for station in stations]
        process = stack.enter_context(
            subprocess.Popen(
                [sys.executable, "-m", "helpers.without_numba", "serve", *how, *where, *lines],
                env=bare_environment(tmp_path),
                stdin=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
        )
        stack.callback(process.kill)  # where the test fails before the session's end
        for station in stations:
            station.connect()
        helm.order("rudder right 10", "rudder right 10, by hand")
        planes.order("depth 80", "keeping depth 80 m")
        instructor.order("run", "running")
        _, said = process.communicate()
    boat = trainer.Boat(sea="sea-state-3")
    boat.order("rudder right 10")
    boat.order("depth 80")
    boat.run(SAILED_S)
    recorded = trainer.read_recording(kept).columns

    assert process.returncode == 0, said
    assert "Traceback" not in said
    assert not (tmp_path / "cache").exists()
    for name, values in boat.columns.items():
        assert np.array_equal(recorded[name], values), name
    assert recorded["z"][-1] > 70.0
    assert boat.state["delta_r"] != 0.0


def test_a_boat_by_call_needs_no_numba_and_has_the_same_state(tmp_path: Path) -> None:
    done = run_program([sys.executable, "-c", CALL], env=bare_environment(tmp_path))
    boat: Any = trainer.Boat(sea="sea-state-5", depth=18)
    boat.order("course 090")
    boat.run(SAILED_S)

    assert done.stdout.strip() == repr(boat.state)
    assert not (tmp_path / "cache").exists()
