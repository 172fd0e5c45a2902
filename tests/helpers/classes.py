"""A class in a process of its own, and its boats' sessions."""

import contextlib
import http.client
import os
import re
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from soak.session_process import Caller

from helpers.nursery import start_trainer
from helpers.pages import free_port
from helpers.places import environment
from helpers.waiting import PATIENCE, await_begun, await_that


@dataclass
class Class:
    """A class, begun by ``trainer class``, with the folder that it keeps."""

    process: subprocess.Popen[str]
    folder: Path
    said: Path
    callers: list[Caller] = field(default_factory=list)

    @property
    def url(self) -> str:
        """Return where the pages are, without the slash at its end."""
        return str(re.findall(r"pages at (\S+)/", self.text())[0])

    @property
    def port(self) -> int:
        """Return the port of the pages."""
        return int(self.url.rpartition(":")[2])

    def text(self) -> str:
        """Return what the class has told its terminal."""
        return self.said.read_text(encoding="utf-8")

    def socket(self, boat: int) -> Path:
        """Return where a boat's session listens."""
        (found,) = re.findall(rf"boat {boat}\b.*: trainer attach --connect (\S+)", self.text())
        return Path(str(found))

    def log(self, boat: int) -> str:
        """Return what a boat's process has said."""
        return (self.folder / f"boat-{boat}.log").read_text(encoding="utf-8")

    def attach(self, boat: int, role: str = "instructor") -> Caller:
        """Return a program's line to a boat, with that role."""
        caller = Caller(self.socket(boat), PATIENCE)
        self.callers.append(caller)
        assert caller.ask(f"role {role}")[0]
        return caller

    def attach_with(self, boat: int, role: str, word: str) -> Caller:
        """Return a program's line to a boat that asks for a word."""
        return self.attach(boat, f"{role} {word}")

    def process_of(self, boat: int) -> int:
        """Return the number of a boat's process."""
        (found,) = [each for each in self.processes() if str(self.socket(boat)) in words_of(each)]
        return found

    def processes(self) -> list[int]:
        """Return the processes of all boats, also of a class that has gone."""
        numbers = [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]
        return [each for each in numbers if f"{self.said.parent}/trainer-class-" in words_of(each)]

    def end(self, number: int = signal.SIGINT) -> int:
        """End the class by a signal; return its exit code."""
        self.process.send_signal(number)
        return self.process.wait(PATIENCE)


def post(lesson: Class, path: str, body: str, cookies: str = "") -> tuple[int, str, str]:
    """Post as a page of the class does; return status, text and the cookies that are set."""
    line = http.client.HTTPConnection("127.0.0.1", lesson.port, timeout=PATIENCE)
    headers = {"Origin": lesson.url, "Cookie": cookies}
    line.request("POST", path, body.encode(), headers)
    got = line.getresponse()
    kept = [value.partition(";")[0] for name, value in got.getheaders() if name == "set-cookie"]
    text = got.read().decode()
    line.close()
    return got.status, text.strip(), "; ".join(kept)


def words_of(process: int) -> str:
    """Return the command of a process, "" where there is none."""
    with contextlib.suppress(OSError):
        return Path(f"/proc/{process}/cmdline").read_text().replace("\0", " ")
    return ""


@contextlib.contextmanager
def class_at_sea(*words: str, boats: int, folder: Path | None = None) -> Iterator[Class]:
    """Begin a class while the block lasts: ``trainer class WORDS``; its boats take lines."""
    with tempfile.TemporaryDirectory(prefix="class") as name:
        kept, said = folder or Path(name) / "kept", Path(name) / "said"
        line = [*words] if folder else [*words, "--folder", str(kept)]
        line += [] if "--web" in line else ["--web", f"127.0.0.1:{free_port()}"]
        own = {**environment(), "XDG_RUNTIME_DIR": name, "XDG_STATE_HOME": name, "TMPDIR": name}
        with said.open("w") as out:
            process = start_trainer("class", *line, env=own, stdout=out, stderr=out)
        begun = Class(process, kept, said)
        try:
            await_begun(process, lambda: "pages at" in begun.text(), begun.text)
            there = [begun.socket(number) for number in range(1, boats + 1)]
            await_begun(process, lambda: all(map(listens, there)), begun.text)
            yield begun
        finally:
            for caller in begun.callers:
                caller.hang_up()
            process.terminate()
            process.wait(PATIENCE)
            await_that(lambda: not begun.processes(), begun.processes)


def listens(path: Path) -> bool:
    """Return whether a session takes lines there."""
    with contextlib.suppress(Exception), Caller(path, PATIENCE):
        return True
    return False


def kill(process: int) -> None:
    """Have a process die at once."""
    os.kill(process, signal.SIGKILL)
