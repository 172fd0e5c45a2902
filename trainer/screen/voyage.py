"""A session of one's own, and its console: `trainer run` on a terminal.

The session, which takes longest to start, is begun before anything of the screen is imported.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click

from trainer import places

PATIENCE: Final = 2.0  # [s] for a session that goes on to end all the same
SUMMARY: Final = 30.0  # [s] for a session that was ended to say its last words
LOOK: Final = 0.004  # [s] between looks at a session that starts
LISTENING: Final = "listening at "


def sail(words: Sequence[str], path: str | None, token: str | None) -> int:
    """Run a session of one's own, with the words of `trainer serve`, and show its console.

    It listens at ``path``, None for where stations look for it. It goes on only while somebody is
    attached. Return its exit code.
    """
    where = path or str(free_socket())
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        voyage = Voyage.begin([*words, "--socket", where, "--until-left"], Path(folder))
        try:
            from trainer.screen.launch import Visit, Voice  # noqa: PLC0415  while the session starts

            visit = Visit.prepare(Voice(where, "instructor", token or ""), own=True)
            listens = voyage.await_line(f"{LISTENING}{where}")
            if listens:
                visit.show()
        except BaseException:
            voyage.process.terminate()
            raise
        return voyage.account(SUMMARY if not listens or visit.sight.over else PATIENCE)


@dataclass
class Voyage:
    """A session of one's own, and what it says while the screen has the terminal."""

    process: "subprocess.Popen[bytes]"
    out: Path
    err: Path
    passed: int = 0  # lines that have been passed on

    @classmethod
    def begin(cls, words: Sequence[str], folder: Path) -> "Voyage":
        """Start a session that the terminal's keys do not reach."""
        out, err = folder / "out", folder / "err"
        with out.open("wb") as said, err.open("wb") as complained:
            process = subprocess.Popen(  # noqa: S603  our own program
                [sys.executable, "-m", "trainer", "serve", *words],
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=complained,
                start_new_session=True,
            )
        return cls(process, out, err)

    def await_line(self, awaited: str) -> bool:
        """Wait until the session says that line; return whether it lives and has done so."""
        while self.process.poll() is None:
            if awaited in self.pass_on():
                return True
            time.sleep(LOOK)
        return False

    def pass_on(self) -> list[str]:
        """Pass on what the session complains of; return all that it has said there."""
        said = self.err.read_text(encoding="utf-8", errors="replace").splitlines()
        for text in said[self.passed :]:
            if not text.startswith(LISTENING):
                click.echo(text, err=True)
        self.passed = len(said)
        return said

    def account(self, patience: float) -> int:
        """Say how the session ended, or that it goes on; return the exit code."""
        try:
            code = self.process.wait(patience)
        except subprocess.TimeoutExpired:
            click.echo("the session goes on for the others; trainer attach comes back to it")
            return 0
        click.echo(self.out.read_text(encoding="utf-8", errors="replace"), nl=False)
        self.pass_on()
        return code


def free_socket() -> Path:
    """Return where stations look for a session, or beside it where another one listens there."""
    usual = places.socket_path()
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
        taken = end.connect_ex(str(usual)) == 0
    return usual.with_name(f"session-{os.getpid()}.sock") if taken else usual
