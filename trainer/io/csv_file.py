"""The state of each tick as a row of a CSV file: SI and radians, every digit that counts."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Protocol

COLUMNS: Final = (
    *("tick", "t", "u", "v", "w", "p", "q", "r", "x", "y", "z", "phi", "theta", "psi"),
    *("delta_r", "delta_s", "delta_b", "u_c", "weight", "x_g", "z_g", "eta_wave"),
)


class Columns(Protocol):
    """Where each tick's columns go."""

    trouble: str

    def row(self, values: Sequence[float]) -> None:
        """Take the columns of one tick."""
        ...


class CsvFile:
    """Rows on their way to a file; trouble with the disk is kept, not raised."""

    def __init__(self, path: Path, batch: int = 1) -> None:
        """Open ``path``, to be written ``batch`` rows at once; OSError if it cannot be."""
        self.path = path
        self.trouble = ""  # why no more are written
        self._batch = batch
        self._file = path.open("wb", buffering=0)
        self._lines = [",".join(COLUMNS) + "\n"]
        self._written = 0  # lines on disk, the heading among them

    def row(self, values: Sequence[float]) -> None:
        """Take one row: the tick, then the other columns."""
        numbers = ",".join(map(repr, values[1:]))
        self._lines.append(f"{values[0]:.0f},{numbers}\n")
        if len(self._lines) >= self._batch:
            self.flush()

    def flush(self) -> None:
        """Write what has been taken."""
        data = "".join(self._lines).encode("ascii")
        self._lines.clear()
        if self.trouble:
            return
        done = 0
        try:
            while done < len(data):
                done += self._file.write(data[done:])
        except OSError as error:
            self._written += data.count(b"\n", 0, done)
            rows = max(self._written - 1, 0)
            self.trouble = f"{self.path}: {error.strerror}; {rows} rows are whole"
        else:
            self._written += data.count(b"\n")

    def close(self) -> None:
        """Write what is left and close."""
        self.flush()
        self._file.close()


class NoFile:
    """Keeps nothing: a run needs no ``if``."""

    trouble = ""

    def row(self, values: Sequence[float]) -> None:
        """Drop it."""

    def flush(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""
