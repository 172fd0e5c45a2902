"""An exported boat in its shared library, as a host program has it, and the rows of its orders."""

import ctypes
from pathlib import Path

from trainer.core.state import SCRATCH, STATE


class Core:
    """One boat in a library: ``state`` is all that evolves, ``card`` the facts of its export."""

    def __init__(self, path: Path) -> None:
        """Load the library. The boat lies at its start."""
        library = ctypes.CDLL(str(path))
        text = ctypes.cast(library.trainer_card, ctypes.c_char_p).value or b""
        self.card = dict(line.split(" ", 1) for line in text.decode().splitlines())
        numbers = ctypes.c_double * (STATE.itemsize // 8)
        self.state = numbers.from_buffer_copy(numbers.in_dll(library, "trainer_start"))
        self._records = (
            ctypes.byref(ctypes.c_char.in_dll(library, "trainer_vessel")),
            ctypes.byref(ctypes.c_char.in_dll(library, "trainer_compact")),
            self.state,
            (ctypes.c_double * (SCRATCH.itemsize // 8))(),
        )
        self._tick = library.trainer_tick

    def tick(self) -> int:
        """Advance by one step. Return 0, or the status of a tick that failed."""
        return int(self._tick(*self._records))


class Row:
    """One wording of an order that writes numbers, see ``trainer.boat.export.orders``."""

    def __init__(self, text: str) -> None:
        """Read a row."""
        self.words, low, high, factor, _, _ = text.split(";")
        self.takes_number = bool(low)
        ends = (float(end or 0.0) / float(factor or 1.0) + 0.0 for end in (low, high))
        self.typed = sorted(ends)  # the limits as they are typed
