"""A session in a process of its own, as a proof needs it: its port, its memory, its end."""

import contextlib
import re
import subprocess
import sys
import threading
from pathlib import Path
from typing import Final

from trainer.proving.caller import Caller
from trainer.proving.witness import PROGRAM

PATIENCE: Final = 120.0  # [s] to listen: a first start compiles
STATUS: Final = re.compile(r"VmRSS:\s+(\d+) kB")


class StartError(Exception):
    """A session that does not listen; the text is what it said."""


class Served:
    """One session, that is recorded and listens at a port of this machine."""

    def __init__(self, *words: str) -> None:
        """Start `trainer serve` with these words and wait until it listens; StartError."""
        listening = ("--listen", "127.0.0.1:0", "--socket", "none")
        self.process = subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-c", PROGRAM, *words, *listening],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.told: list[str] = []  # on stderr
        self.account: list[str] = []  # on stdout
        self.port = 0
        self._heard = threading.Event()
        self._readers = [
            threading.Thread(target=read, daemon=True) for read in (self._listen, self._keep)
        ]
        for reader in self._readers:
            reader.start()
        if not self._heard.wait(PATIENCE) or not self.port:
            code = self.process.poll()
            self.kill()
            raise StartError(
                "\n".join(self.told) or f"the session does not listen, exit code {code}"
            )

    def caller(self, role: str) -> Caller:
        """Return a line to it that has taken a role; GoneError if it has gone."""
        caller = Caller(self.port)
        with contextlib.ExitStack() as unless_good:
            unless_good.callback(caller.hang_up)
            caller.ask(f"role {role}")
            unless_good.pop_all()
        return caller

    @property
    def running(self) -> bool:
        """Return whether it has not ended."""
        return self.process.poll() is None

    def memory(self) -> int:
        """Return what it has in memory [kB], 0 where the system does not tell or it has ended."""
        try:
            text = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        except OSError:
            return 0
        found = STATUS.search(text)
        return int(found[1]) if found else 0

    def ended(self, patience: float) -> int:
        """Wait for its end; return its exit code, TimeoutExpired if it does not come."""
        code = self.process.wait(patience)
        for reader in self._readers:
            reader.join()
        self._close()
        return code

    def kill(self) -> None:
        """End it at this instant."""
        self.process.kill()
        self.ended(PATIENCE)

    def _close(self) -> None:
        for stream in (self.process.stdout, self.process.stderr):
            if stream:
                stream.close()

    def _listen(self) -> None:
        for line in self.process.stderr or ():
            self.told.append(line.rstrip())
            if "listening at tcp" in line:
                self.port = int(line.rpartition(":")[2])
                self._heard.set()
        self._heard.set()

    def _keep(self) -> None:
        for line in self.process.stdout or ():
            self.account.append(line.rstrip())
