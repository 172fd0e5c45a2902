"""A session of one's own, and its console: `trainer run` on a terminal.

The session, which takes longest to start, is begun before anything of the screen is imported.
"""

import gc
import os
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

import click

from trainer import places
from trainer.config import ConfigError
from trainer.screen.child import LOOK, Child

PATIENCE: Final = 2.0  # [s] for a session that goes on to end all the same
SUMMARY: Final = 30.0  # [s] for a session that was ended to say its last words
SOON: Final = (places.MAKING_READY, places.LISTENING)  # a session's first words, if it is to be


def sail(serve: Callable[[str], NoReturn], path: str | None, token: str | None) -> int:
    """Show the console of a session of one's own, which ``serve`` runs at a socket.

    It listens at ``path``, None for where stations look for it. It goes on only while somebody is
    attached. Return its exit code.
    """
    where = path or str(free_socket())
    voyage = Voyage(Child(lambda: serve(where)))
    gc.disable()  # what is imported is no garbage; the session wants the processor
    try:
        from trainer.screen.launch import Visit  # noqa: PLC0415  while the session starts

        visit = Visit.prepare(lambda: voyage.address(where), "instructor", token, own=True)
        gc.freeze()
        gc.enable()
        why = visit.show() if voyage.await_word(*SOON) else ""
    except BaseException:
        voyage.session.terminate()
        raise
    begun = visit.sight.greeted
    if not begun and voyage.session.ended() is None:
        voyage.session.terminate()
        raise ConfigError(why) if why else click.Abort
    return voyage.account(PATIENCE if begun and not visit.sight.over else SUMMARY)


@dataclass
class Voyage:
    """A session of one's own, and what it says while the screen has the terminal."""

    session: Child
    passed: int = 0  # lines that have been passed on

    def await_word(self, *words: str) -> bool:
        """Pass on what the session says until a line begins so; return whether one did."""
        while self.session.ended() is None:
            if any(text.startswith(words) for text in self.pass_on()):
                return True
            time.sleep(LOOK)
        return False

    def address(self, where: str) -> str:
        """Return ``where`` the session listens, once it does; NeverBegunError if it has ended."""
        while f"{places.LISTENING} {where}" not in self.session.err.splitlines():
            if self.session.ended() is not None:
                from trainer.screen.client import NeverBegunError  # noqa: PLC0415  long imported

                raise NeverBegunError("the session has ended")
            time.sleep(LOOK)
        return where

    def pass_on(self) -> list[str]:
        """Pass on what the session complains of; return all that it has said there."""
        said = self.session.err.splitlines()
        for text in said[self.passed :]:
            if not text.startswith(SOON):
                click.echo(text, err=True)
        self.passed = len(said)
        return said

    def account(self, patience: float) -> int:
        """Say how the session ended, or that it goes on; return the exit code."""
        code = self.session.wait(patience)
        if code is None:
            click.echo("the session goes on for the others; trainer attach comes back to it")
            return 0
        click.echo(self.session.out, nl=False)
        self.pass_on()
        return code


def free_socket() -> Path:
    """Return where stations look for a session, or beside it where another one listens there."""
    usual = places.socket_path()
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as end:
        taken = end.connect_ex(str(usual)) == 0
    return usual.with_name(f"session-{os.getpid()}.sock") if taken else usual
