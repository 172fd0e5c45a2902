"""Sinks: a file, and a viewer on this machine or another."""

import socket
from pathlib import Path
from typing import Final

from trainer.session.rerun.batch import Batch
from trainer.session.rerun.blueprint import blueprint
from trainer.session.rerun.charts import charts_of
from trainer.session.rerun.outlet import Outlet
from trainer.session.rerun.subject import Subject
from trainer.session.rerun.writer import Writer

PROBE: Final = 0.5  # [s] that a viewer has to answer


class RrdFile:
    """A file for the viewer. Few large pieces, since each has a head of its own."""

    period = 20.0
    patience = 30.0
    needed = True

    def __init__(self, path: Path, subject: Subject) -> None:
        """Take the file's name; it is replaced when opened."""
        self.name = str(path)
        self._path, self._subject = path, subject

    def open(self) -> None:
        """Begin the file with what is the same at all times."""
        self._path.open("wb").close()  # tells better than the library why it cannot be written
        self._outlet = Outlet(self._subject.title)
        self._outlet.save(
            self._path, blueprint(charts_of(self._subject.boat), self._subject.length)
        )
        self._writer = Writer(self._subject, self._outlet)
        self._writer.begin()

    def write(self, batch: Batch) -> None:
        """Write a batch to the file."""
        self._writer.write(batch)
        self._outlet.flush()

    def close(self) -> None:
        """Complete the file."""
        self._outlet.close()


class Viewer:
    """A viewer that listens already."""

    period = 1.0
    patience = 2.0
    needed = False

    def __init__(self, host: str, port: int, subject: Subject) -> None:
        """Take where it listens."""
        self.name = f"viewer at {host}:{port}"
        self._host, self._port, self._subject = host, port, subject

    def open(self) -> None:
        """Send what is the same at all times."""
        layout = blueprint(charts_of(self._subject.boat), self._subject.length)
        self._outlet = Outlet(self._subject.title)
        self._outlet.connect(self._host, self._port, layout)
        self._writer = Writer(self._subject, self._outlet)
        self._writer.begin()

    def write(self, batch: Batch) -> None:
        """Send a batch; ConnectionError if the viewer has gone."""
        self._writer.write(batch)
        try:
            self._outlet.flush()
        except RuntimeError:
            raise ConnectionError("it has gone") from None

    def close(self) -> None:
        """End the recording; the viewer keeps what it has."""
        self._outlet.close()


def listens(host: str, port: int) -> bool:
    """Return whether something listens there: without it the library waits for ever."""
    try:
        socket.create_connection((host, port), PROBE).close()
    except OSError:
        return False
    return True
