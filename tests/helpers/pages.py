"""Sessions with pages, and a browser that looks at them."""

import contextlib
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from soak.session_process import Caller

from helpers.installation import installed
from helpers.lanes import sample_cases
from helpers.nursery import start_trainer
from helpers.places import environment
from helpers.waiting import PATIENCE, await_begun
from trainer.report.pdf import find_browser

SIZES: Final = {
    "phone": (360, 640),
    "phone-side": (640, 360),
    "tablet": (768, 1024),
    "laptop": (1280, 720),
    "desk": (1920, 1080),
    "4k": (3840, 2160),
}
OFTEN: Final = ("phone", "laptop")  # the sizes of the short run
IN_SHORT: Final = sample_cases(SIZES, *OFTEN)
PALETTES: Final = ("dusk", "day", "bright", "night")
QUIET: Final = (  # nothing but the page asks for anything
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--autoplay-policy=no-user-gesture-required", "--hide-scrollbars"),
)
HEADLESS: Final = "chromium-headless-shell"  # Chromium without windows: a quarter less to compute


def find_chromium() -> str:
    """Return the path of Chromium; where there is none the test is skipped, and says so."""
    return shutil.which(HEADLESS) or find_browser() or installed("chromium", "chromium")


def free_port() -> int:
    """Return a port that is free now."""
    with socket.create_server(("127.0.0.1", 0)) as end:
        return int(end.getsockname()[1])


@dataclass
class Served:
    """A session with pages, in a process of its own."""

    process: subprocess.Popen[str]
    port: int
    folder: Path
    callers: list[Caller] = field(default_factory=list)

    @property
    def url(self) -> str:
        """Return where the pages are."""
        return f"http://127.0.0.1:{self.port}"

    @property
    def socket(self) -> Path:
        """Return the local socket of the session."""
        return self.folder / "s.sock"

    def attach(self, role: str = "instructor") -> Caller:
        """Return a program's line to the session, with that role."""
        caller = Caller(self.socket, PATIENCE)
        taken, why = caller.ask(f"role {role}")
        assert taken, why
        self.callers.append(caller)
        return caller


@contextlib.contextmanager
def served(*words: str, frozen: bool = True, port: int = 0) -> Iterator[Served]:
    """Serve a session with pages while the block lasts: ``trainer serve WORDS --web ...``."""
    with tempfile.TemporaryDirectory(prefix="web") as name:
        folder, port = Path(name), port or free_port()
        own = {"XDG_RUNTIME_DIR": str(folder), "XDG_STATE_HOME": str(folder)}
        line = [*words, "--verbose", "--listen", "none", "--socket", str(folder / "s.sock")]
        line += ["--web", f"127.0.0.1:{port}", *(["--frozen"] if frozen else [])]
        with (folder / "said").open("w") as said:
            own = {**environment(), **own}
            process = start_trainer("serve", *line, env=own, cwd=folder, stdout=said, stderr=said)
        try:
            await_pages(process, port, folder / "said")
            session = Served(process, port, folder)
            yield session
            for caller in session.callers:
                caller.hang_up()
        finally:
            process.terminate()
            process.wait(PATIENCE)


def await_pages(process: subprocess.Popen[str], port: int, said: Path) -> None:
    """Wait until the pages are served."""

    def are_served() -> bool:
        if "pages at http" in said.read_text():
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1):
                return True
        return False

    await_begun(process, are_served, said.read_text)


@dataclass
class Heard:
    """What a page has said on the console, and where it has sent requests."""

    console: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def foreign(self, url: str) -> list[str]:
        """Return the requests that left the server."""
        own = (url, url.replace("http", "ws"), "data:", "blob:")
        return [each for each in self.requests if not each.startswith(own)]
