"""Rerun as the command line asks for it: a file, a viewer, a recording's file.

``run`` opens the log of a run here, and ``trainer export --rrd`` writes that of a recording. No
failure stops a run, because a picture is never worth an exercise.
"""

import gc
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from trainer.boat.boat import Boat
from trainer.boat.world.world import world_of
from trainer.config.extras import advise_install
from trainer.config.files import ConfigError
from trainer.io.outputs import open_output, replacing
from trainer.io.paths import DEFAULT_HOST
from trainer.io.recording.recording import Recording
from trainer.session.past.header import layout_of, plan_of
from trainer.session.past.journal import restore_world
from trainer.session.past.options import RunOptions
from trainer.session.rerun.batch import Batch, Subject, TakenNews, TakenPicture, TimedRows, batch_of
from trainer.session.rerun.feed import Feed, Log, Sink
from trainer.session.stations.subscriptions import PromptSender, Publisher
from trainer.session.stations.view import Pace
from trainer.session.time.ledger import Ledger

if TYPE_CHECKING:
    from trainer.session.rerun.drawing import Drawing

VIEWER_PORT: Final = 9876  # where Rerun's viewer listens by custom
PROBE_TIMEOUT_S: Final = 0.5  # [s] that a viewer has to answer
START_TIMEOUT_S: Final = 20.0  # [s] that a viewer has to open its window
POLL_PERIOD_S: Final = 0.1  # [s] between looks whether it has
BATCH_TICKS: Final = 4096  # [ticks] of a recording written at a time


def open_log(
    sending: Publisher | PromptSender, ledger: Ledger, subject: Subject, options: RunOptions
) -> Log | None:
    """Return the feeds of the file and viewer asked for, None without either.

    A line says what the viewer lacks. ConfigError for a bad address, or a file that cannot be
    written or made.
    """
    path, wanted = options.rrd, options.rerun or options.rerun_at
    host, port = parse_address(options.rerun_at or "")
    if path is None and not wanted:
        return None
    if find_spec("rerun") is None:
        click.echo(f"trainer: {advise_install('rerun', '--rerun')}", err=True)
        return None

    from trainer.session.rerun.drawing import Drawing  # noqa: PLC0415  rerun itself

    gc.freeze()  # or the library's objects would be looked through again and again
    sinks: list[Sink] = []
    if path is not None:
        try:
            open_output(path).close()
        except OSError as error:
            raise ConfigError(f"--rrd {path}: {error.strerror}") from None
        sinks.append(RrdFile(path, Drawing(subject)))
    if wanted:
        viewer_is_open = viewer_listens(host, port)
        if viewer_is_open or (host == DEFAULT_HOST and has_window()):
            sinks.append(Viewer(host, port, Drawing(subject), there=viewer_is_open))
        else:
            where = f"there is no Rerun viewer at {host}:{port}"
            click.echo(f"trainer: {where}; start one: rerun --bind {host} --port {port}", err=True)
    return Log(sending, ledger, [Feed(sink, subject.step) for sink in sinks])


class RrdFile:
    """A file for the viewer. Its pieces are few and large, because each has a head."""

    period = 20.0  # [s] between two pieces
    patience = 30.0  # [s] for the rest at the end
    needed = True

    def __init__(self, path: Path, drawing: "Drawing") -> None:
        """Take the file's name; it is replaced when opened."""
        self.name = str(path)
        self.write, self.close = drawing.write, drawing.close
        self._path, self._drawing = path, drawing

    def open(self) -> None:
        """Begin the file with what is the same at all times."""
        self._drawing.save(self._path)


class Viewer:
    """A viewer that listens already, or is opened. It stays open after the run."""

    period = 1.0  # [s] between two batches
    patience = 2.0  # [s] for the rest at the end
    needed = False

    def __init__(self, host: str, port: int, drawing: "Drawing", *, there: bool) -> None:
        """Take where it listens, and whether it is there already."""
        self.name = f"viewer at {host}:{port}"
        self.close = drawing.close
        self._host, self._port, self._drawing, self._there = host, port, drawing, there

    def open(self) -> None:
        """Send what is the same at all times. Its window is opened if need be."""
        if not self._there:
            open_window(self._port)
        self._drawing.connect(self._host, self._port)

    def write(self, batch: Batch) -> None:
        """Send a batch; ConnectionError if the viewer has gone."""
        try:
            self._drawing.write(batch)
        except RuntimeError:
            raise ConnectionError("it has gone") from None


def open_window(port: int) -> None:
    """Open a viewer for this machine alone; OSError if it does not listen in time."""
    words = ["--bind", DEFAULT_HOST, "--port", str(port), "--expect-data-soon"]
    process = subprocess.Popen(  # noqa: S603  the viewer that comes with the library
        [sys.executable, "-m", "rerun_cli", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    until = time.monotonic() + START_TIMEOUT_S
    while not viewer_listens(DEFAULT_HOST, port):
        if process.poll() is not None or time.monotonic() > until:
            raise OSError("the viewer has not opened; does `rerun` alone open it?")
        time.sleep(POLL_PERIOD_S)


def viewer_listens(host: str, port: int) -> bool:
    """Return whether something listens there. The library would wait for it for ever."""
    try:
        socket.create_connection((host, port), PROBE_TIMEOUT_S).close()
    except OSError:
        return False
    return True


def parse_address(text: str) -> tuple[str, int]:
    """Return host and port of ``HOST[:PORT]`` or ``:PORT``; ConfigError if it is neither."""
    host, colon, port = text.rpartition(":")
    if not colon:
        return text or DEFAULT_HOST, VIEWER_PORT
    if not port.isdecimal() or not 0 < int(port) < 65536:
        raise ConfigError(f"--rerun-at {text}: say HOST:PORT, such as {DEFAULT_HOST}:{VIEWER_PORT}")
    return host.strip("[]") or DEFAULT_HOST, int(port)


def has_window() -> bool:
    """Return whether there is a screen to open a window on."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def write_record(recording: Recording, path: Path, branch: int) -> None:
    """Write a branch, the past that led to it, and its events. A file is replaced.

    ConfigError or RecordingError if it cannot be read, OSError if the file cannot be written.
    """
    from trainer.session.rerun.drawing import Drawing  # noqa: PLC0415  rerun itself

    header = recording.header()
    plan = plan_of(header)
    boat = Boat(plan.file, plan.method)
    boat.world = world_of(boat, plan.around)
    restore_world(boat, recording, branch, sys.maxsize)
    subject = Subject.of(plan, boat)
    parts = batches(recording, branch, layout_of(header), subject.step)
    first = next(parts)  # nothing is replaced where there is nothing to write
    with replacing(path) as made:
        drawing = Drawing(subject)
        drawing.save(made)
        try:
            for batch in chain((first,), parts):
                drawing.write(batch)
        finally:
            drawing.close()


def batches(
    recording: Recording, branch: int, layout: tuple[str, ...], step: float
) -> Iterator[Batch]:
    """Yield the ticks that led to the end of a branch. The last batch has the events."""
    flown = recording.flown(branch)
    ends: dict[int, int] = {}
    while part := list(islice(flown, BATCH_TICKS)):
        ends |= {each.branch: each.tick for each in part}
        pictures, timed = TimedRows(), TimedRows()
        for flown_tick in part:
            times = flown_tick.lateness or 0, flown_tick.work or 0
            taken = TakenPicture(
                flown_tick.tick, flown_tick.state, Pace(branch=flown_tick.branch), 0, *times
            )
            pictures.add(taken, flown_tick.tick, flown_tick.tick * step)
            if flown_tick.work is not None:
                timed.add(taken, flown_tick.tick, flown_tick.tick * step)
        yield batch_of(pictures, timed, TimedRows(), layout)
    news = TimedRows()
    for event in recording.first_events():
        if event.tick <= ends.get(event.branch, -2) + 1:
            news.add(TakenNews(event.tick, event.kind, event.text), event.tick, event.tick * step)
    yield batch_of(TimedRows(), TimedRows(), news, layout)
