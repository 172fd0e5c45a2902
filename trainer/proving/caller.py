"""A program at a session's socket: it gives orders, and gets on when they are answered."""

import contextlib
import itertools
import socket
from pathlib import Path
from typing import Final

from trainer.io.sentences import Sentence, order_sentence, read

PATIENCE: Final = 30.0  # [s] for an answer
RESET: Final = b"\1\0\0\0\0\0\0\0"  # linger 0: the line is cut, not closed


class GoneError(Exception):
    """The session has closed the line, or does not answer."""


class Caller:
    """One line to a session on this machine."""

    def __init__(self, at: int | Path, patience: float = PATIENCE) -> None:
        """Dial a port of this machine, or a local socket; GoneError if nobody answers."""
        self.shown: dict[str, tuple[str, ...]] = {}  # the latest values of each channel
        self.said: list[str] = []  # the lines of the last long answer
        self.news: list[Sentence] = []  # what has happened, until somebody takes it
        self._tags = itertools.cycle(range(1, 1_000_000))
        try:
            self._line = _dialled(at, patience)
        except OSError as error:
            raise GoneError(str(error)) from None
        self._lines = self._line.makefile(encoding="ascii", errors="replace")

    @property
    def name(self) -> str:
        """Return what the session calls the line."""
        host, port = self._line.getsockname()
        return f"tcp {host}:{port}"

    def ask(self, words: str) -> tuple[bool, str]:
        """Give an order; return whether it was obeyed, and the answer."""
        tag = str(next(self._tags))
        self.said = []
        try:
            self._line.sendall(f"{order_sentence(words, tag)}\n".encode("ascii"))
            for text in self._lines:
                said = read(text)
                if said and (said.kind, said.tag) == ("TRA", tag) and said.fields[0] != "say":
                    return said.fields[0] == "ok", said.fields[1]
                self._take(said, tag)
        except OSError as error:
            raise GoneError(str(error)) from None
        raise GoneError("the session has closed the line")

    @property
    def tick(self) -> int:
        """Return the latest tick that the session has told."""
        return max((int(values[0]) for values in self.shown.values()), default=0)

    def hang_up(self) -> None:
        """Leave without a word."""
        self._lines.close()
        self._line.close()

    def cut(self) -> None:
        """Leave as a machine does that loses power: what is under way is lost."""
        with contextlib.suppress(OSError):
            self._line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
        self.hang_up()

    def _take(self, said: Sentence | None, tag: str) -> None:
        """Keep what the session says by itself, and the lines of the answer that is awaited."""
        if said and (said.kind, said.tag) == ("TRA", tag):
            self.said.append(said.fields[1])
        elif said and said.kind == "TRS":
            self.shown[said.fields[0]] = said.fields[1:]
        elif said and said.kind == "TRE":
            self.news.append(said)


def _dialled(at: int | Path, patience: float) -> socket.socket:
    if isinstance(at, int):
        return socket.create_connection(("127.0.0.1", at), timeout=patience)
    line = socket.socket(socket.AF_UNIX)
    line.settimeout(patience)
    try:
        line.connect(str(at))
    except OSError:
        line.close()
        raise
    return line
