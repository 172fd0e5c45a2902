"""The state of each tick as a row of a CSV file: SI and radians, every digit that counts."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

COLUMNS: Final = (
    *("tick", "t", "u", "v", "w", "p", "q", "r", "x", "y", "z", "phi", "theta", "psi"),
    *("delta_r", "delta_s", "delta_b", "u_c", "weight", "x_g", "z_g", "eta_wave"),
)
BATCH: Final = 200  # [rows] written at once; every batch ends with a whole row


class CsvFile:
    """Rows on their way to a file; trouble with the disk is kept, not raised."""

    def __init__(self, path: Path) -> None:
        """Open ``path`` and write the heading; OSError if it cannot be."""
        self.path = path
        self.rows = 0  # on disk
        self.trouble = ""  # why no more are written
        self._file = path.open("wb", buffering=0)
        self._lines: list[str] = []
        self._write(",".join(COLUMNS) + "\n")

    def row(self, values: Sequence[float]) -> None:
        """Take one row: the tick, then the other columns."""
        numbers = ",".join(map(repr, values[1:]))
        self._lines.append(f"{values[0]:.0f},{numbers}\n")
        if len(self._lines) >= BATCH:
            self.flush()

    def flush(self) -> None:
        """Write what has been taken."""
        count = len(self._lines)
        self._write("".join(self._lines))
        self._lines.clear()
        self.rows += 0 if self.trouble else count

    def close(self) -> None:
        """Write what is left and close."""
        self.flush()
        self._file.close()

    def _write(self, text: str) -> None:
        if self.trouble:
            return
        rest = memoryview(text.encode("ascii"))
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self.trouble = f"{self.path}: {error.strerror}; {self.rows} rows are whole"


class NoFile:
    """Keeps nothing: a run needs no ``if``."""

    trouble = ""

    def row(self, values: Sequence[float]) -> None:
        """Drop it."""

    def flush(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""
