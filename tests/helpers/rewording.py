"""A session's lines with every text in other words: what is decided on facts alone stays."""

import contextlib
import socket
import threading
from pathlib import Path
from typing import Final

from trainer.io.orders import sentences

OTHER: Final = "in other words"


def reworded(line: str) -> str:
    """Return a line of a session, its text in other words."""
    sentence = sentences.parse_sentence(line)
    if sentence is None:
        return line if line.startswith("$") else OTHER
    if sentence.kind == "TRA":
        status, _ = sentence.fields
        if status == "say":
            return sentences.say(sentence.tag, OTHER)
        return sentences.answer(sentence.tag, accepted=status == "ok", text=OTHER)
    if sentence.kind == "TRE":
        tick, seconds, kind, _ = sentence.fields
        return sentences.event(int(tick), float(seconds), kind, OTHER)
    return line


class Rewording:
    """A port before a session's, that passes all on, what the session says in other words."""

    def __init__(self, session: Path) -> None:
        self.session = session
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                near, _ = self.listener.accept()
                far = socket.socket(socket.AF_UNIX)
                far.connect(str(self.session))
                threading.Thread(target=self._pass, args=(near, far), daemon=True).start()
                threading.Thread(target=self._reword, args=(far, near), daemon=True).start()

    def _pass(self, near: socket.socket, far: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := near.recv(4096):
                far.sendall(data)
            far.shutdown(socket.SHUT_WR)

    def _reword(self, far: socket.socket, near: socket.socket) -> None:
        with contextlib.suppress(OSError):
            for line in far.makefile(encoding="ascii", newline="\n"):
                near.sendall(reworded(line.rstrip("\r\n")).encode() + b"\r\n")
            near.shutdown(socket.SHUT_WR)
