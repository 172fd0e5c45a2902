"""Rerun as the command line asks for it: a file, a viewer. No failure stops a run."""

import gc
import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from trainer.config.extras import advise_install
from trainer.config.files import ConfigError
from trainer.io.paths import HOST
from trainer.session.options import RunOptions
from trainer.session.rerun.batch import Subject
from trainer.session.rerun.feed import Feed, Log, Sink
from trainer.session.stations.subscriptions import Promptly, Publisher
from trainer.session.time.ledger import Ledger

if TYPE_CHECKING:
    from trainer.session.rerun.sinks import Viewer

PORT: Final = 9876  # where Rerun's viewer listens by custom
START: Final = 20.0  # [s] that a viewer has to open its window
LOOK: Final = 0.1  # [s] between looks whether it has


def open_log(
    sending: Publisher | Promptly, ledger: Ledger, subject: Subject, options: RunOptions
) -> Log | None:
    """Return what feeds the file and the viewer asked for, None if there is neither.

    What is missing is told in a line. ConfigError for an address that is none, or a file that
    cannot be written.
    """
    path, wanted = options.rrd, options.rerun or options.rerun_at
    host, port = parse_place(options.rerun_at or "")
    if path is None and not wanted:
        return None
    if find_spec("rerun") is None:
        told = advise_install("rerun", "--rerun" if wanted else "--rrd")
        click.echo(f"trainer: {told}", err=True)
        return None

    from trainer.session.rerun.sinks import RrdFile, Viewer, listens  # noqa: PLC0415  rerun itself

    gc.freeze()  # or the library's objects would be looked through again and again
    sinks: list[Sink] = []
    if path is not None:
        refuse_unwritable(path)
        sinks.append(RrdFile(path, subject))
    if wanted:
        viewer = Viewer(host, port, subject)
        if listens(host, port):
            sinks.append(viewer)
        elif host == HOST and has_window():
            sinks.append(Opened(viewer, port))
        else:
            where = f"there is no Rerun viewer at {host}:{port}"
            click.echo(f"trainer: {where}; start one: rerun --bind {host} --port {port}", err=True)
    return Log(sending, ledger, [Feed(sink, subject.step) for sink in sinks])


class Opened:
    """A viewer that is opened first, for this machine alone. It stays when the run is over."""

    def __init__(self, viewer: "Viewer", port: int) -> None:
        """Take the viewer to come, and where it is to listen."""
        self.name, self.period, self.patience = viewer.name, viewer.period, viewer.patience
        self.needed = viewer.needed
        self.write, self.close = viewer.write, viewer.close
        self._viewer, self._port = viewer, port

    def open(self) -> None:
        """Open its window, wait until it listens, and send all that is constant."""
        from trainer.session.rerun.sinks import listens  # noqa: PLC0415  rerun itself

        words = ["--bind", HOST, "--port", str(self._port), "--expect-data-soon"]
        process = subprocess.Popen(  # noqa: S603  the viewer that comes with the library
            [sys.executable, "-m", "rerun_cli", *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        until = time.monotonic() + START
        while not listens(HOST, self._port):
            if process.poll() is not None or time.monotonic() > until:
                raise OSError("the viewer has not opened; does `rerun` alone open it?")
            time.sleep(LOOK)
        self._viewer.open()


def parse_place(text: str) -> tuple[str, int]:
    """Return host and port of ``HOST[:PORT]`` or ``:PORT``; ConfigError if it is neither."""
    host, colon, port = text.rpartition(":")
    if not colon:
        return text or HOST, PORT
    if not port.isdecimal() or not 0 < int(port) < 65536:
        raise ConfigError(f"--rerun-at {text}: say HOST:PORT, such as {HOST}:{PORT}")
    return host.strip("[]") or HOST, int(port)


def refuse_unwritable(path: Path) -> None:
    """Raise ConfigError if the file cannot be written; it is emptied."""
    try:
        path.open("wb").close()
    except OSError as error:
        raise ConfigError(f"--rrd {path}: {error.strerror}") from None


def has_window() -> bool:
    """Return whether there is a screen to open a window on."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
