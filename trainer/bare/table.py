"""The state of each tick as a row of a CSV file, to the byte as ``trainer run`` writes it."""

from trainer.bare.card import WrongError
from trainer.bare.core import Core


class Table:
    """Rows on their way to a file, or to none; trouble with the disk ends the file, not the run."""

    def __init__(self, path: str, core: Core, buffering: int) -> None:
        """Open ``path``, "" for none, with ``buffering`` as ``open`` takes it for lines of text.

        WrongError if it cannot be written.
        """
        self.path = path
        self.trouble = ""
        self._file = None
        self._places = list(core.card.columns.values())[1:]
        if not path:
            return
        try:
            self._file = open(path, "w", buffering, "ascii", newline="\n")  # noqa: SIM115
            heading = ",".join(("tick", "t", *list(core.card.columns)[1:]))
            self._file.write(f"{heading}\n")
        except OSError as error:
            raise WrongError(f"--csv {path}: {error.strerror}") from None

    def row(self, core: Core) -> None:
        """Write the state of ``core``: tick, time [s], then the columns."""
        if self._file is None or self.trouble:
            return
        s = core.state
        values = [s[0] * core.card.step, *[s[place] for place in self._places]]
        try:
            self._file.write(f"{s[0]:.0f},{','.join(map(repr, values))}\n")
        except OSError as error:
            self.trouble = f"--csv {self.path}: {error.strerror}"

    def close(self) -> str:
        """Close the file; return what went wrong with it."""
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                self.trouble = self.trouble or f"--csv {self.path}: {error.strerror}"
        return self.trouble
