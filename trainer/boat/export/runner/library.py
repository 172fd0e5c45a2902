"""An exported core at work: the library, the boat's state, its ticks.

What an exported core says about itself: lines of text inside the library.

    trainer-core FORMAT
    KEY VALUE                one line each of version, core, boat, computed, cpu, needs, step,
                             places, work, columns, watched
    order ROW                one line for each wording, see trainer.boat.export.runner.orders

Lines of other keys, of a later trainer, are passed over.
"""

import ctypes
import os

from trainer import __version__

FORMAT = 1
HEADING = "trainer-core"


class WrongError(Exception):
    """The user gave something that cannot be used. The text says what to do. Exit code 2."""


class Card:
    """The origin of a core, and where its state has the numbers of a run."""

    def __init__(self, text: str) -> None:
        """Read the card; WrongError if it is of another format."""
        heading, _, rest = text.partition("\n")
        name, _, number = heading.partition(" ")
        if name != HEADING or number != str(FORMAT):
            raise WrongError(
                f"its card is of format {number or 'none'}, this trainer reads {FORMAT}: "
                "export again"
            )
        values = {}
        self.orders = []
        for line in rest.splitlines():
            key, _, value = line.partition(" ")
            if key == "order":
                self.orders.append(value)
            else:
                values[key] = value
        self.version = values["version"]
        self.core = values["core"]
        self.boat = values["boat"]
        self.computed = values["computed"]
        self.cpu = values["cpu"]
        self.needs = values["needs"].split()
        self.step = float.fromhex(values["step"])  # [s]
        self.places = int(values["places"])  # [-] numbers in a state
        self.work = int(values["work"])  # [-] numbers in a work space
        self.watched = values["watched"].split()
        pairs = (item.split("=") for item in values["columns"].split())
        self.columns = {name: int(place) for name, place in pairs}  # of the state; t is its step's


BASE = 3  # [features] every processor that the portable core is for has these
LISTING = "/proc/cpuinfo"


class Core:
    """One boat in a shared library. ``state`` is all that evolves, ``card`` what it is."""

    def __init__(self, path: str) -> None:
        """Load the library and begin at its start; WrongError if that cannot be done."""
        if not os.path.exists(path):
            raise WrongError(f"--core {path}: no such file; trainer export-core makes one")
        try:
            library = ctypes.CDLL(os.path.abspath(path))
            text = ctypes.cast(library.trainer_card, ctypes.c_char_p).value or b""
        except (OSError, AttributeError):
            raise WrongError(
                f"--core {path}: not an exported core for this machine; "
                "trainer export-core makes one, give its libtrainer_core.so"
            ) from None
        try:
            self.card = Card(text.decode())
        except WrongError as wrong:
            raise WrongError(f"--core {path}: {wrong}") from None
        if self.card.version != __version__:
            raise WrongError(
                f"--core {path}: exported by trainer {self.card.version}, this is {__version__}: "
                "export again"
            )
        _refuse_lacking(path, self.card)
        numbers = ctypes.c_double * self.card.places
        self.state = numbers.from_buffer_copy(numbers.in_dll(library, "trainer_start"))
        self._records = (
            ctypes.byref(ctypes.c_char.in_dll(library, "trainer_vessel")),
            ctypes.byref(ctypes.c_char.in_dll(library, "trainer_compact")),
            self.state,
            (ctypes.c_double * self.card.work)(),
        )
        self._tick = library.trainer_tick

    def tick(self) -> int:
        """Advance by one step. Return 0, or a status for ``failure`` with the state as it was."""
        return int(self._tick(*self._records))

    def failure(self, status: int) -> str:
        """Return what a failing tick lost, in words."""
        watched = self.card.watched
        lost = watched[status - 1] if 0 < status <= len(watched) else "the tick"
        return f"{lost} is out of all bounds after tick {self.state[0]:.0f}"


def _refuse_lacking(path: str, card: Card) -> None:
    """Raise WrongError if this processor lacks what the core was compiled for, where it tells."""
    if len(card.needs) <= BASE or not os.path.exists(LISTING):
        return
    with open(LISTING, encoding="ascii", errors="replace") as listing:
        flags = next((line.split() for line in listing if line.startswith("flags")), card.needs)
    lacking = [need for need in card.needs if need not in flags]
    if lacking:
        raise WrongError(
            f"--core {path}: compiled for {card.cpu}; this processor lacks {', '.join(lacking)}: "
            "export again with --cpu x86-64-v2"
        )
