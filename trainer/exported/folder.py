"""The folder of an exported core: object, library, header, host, and how large they are."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.boat import Boat
from trainer.config import ConfigError
from trainer.core.scratch import SCRATCH
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.exported.card import card_text
from trainer.exported.header import header_text
from trainer.exported.linking import link
from trainer.exported.lowering import freestanding_module, tick
from trainer.exported.targets import code_words, object_code, processor

OBJECT: Final = "trainer_core.o"
LIBRARY: Final = "libtrainer_core.so"
HEADER: Final = "trainer_core.h"
HOST: Final = "host.c"


@dataclass(frozen=True)
class Sizes:
    """What one boat takes, in words of 16 bits."""

    code: int
    vessel: int
    compact: int
    state: int
    scratch: int


@dataclass(frozen=True)
class Exported:
    """What was written."""

    boat: str
    cpu: str
    step_s: float
    files: tuple[str, ...]
    words_of_16_bits: Sizes


def constants_of(boat: Boat, card: str) -> dict[str, bytes]:
    """Return the constants of an exported core by their names in C."""
    return {
        "trainer_vessel": boat.records.vessel.tobytes(),
        "trainer_compact": boat.records.compact.tobytes(),
        "trainer_start": boat.records.state.tobytes(),
        "trainer_card": card.encode() + b"\0",
    }


def export(boat: Boat, folder: Path, cpu: str) -> Exported:
    """Write the core of ``boat`` as it stands into ``folder``, but for the library.

    ConfigError if the folder cannot be written, or nothing be compiled for ``cpu``.
    """
    with told():
        folder.mkdir(parents=True, exist_ok=True)
    target = processor(cpu)
    constants = constants_of(boat, card_text(boat, target))
    code = object_code(freestanding_module(tick, boat.records.scheme, constants), target)
    host = (Path(__file__).parent / HOST).read_bytes()
    files = {OBJECT: code, HEADER: header_text(boat, target.name).encode(), HOST: host}
    with told():
        for name, data in files.items():
            (folder / name).write_bytes(data)
    step = boat.method.step
    return Exported(boat.file.name, target.name, step, tuple(files), sizes(code))


@contextmanager
def told() -> Iterator[None]:
    """Tell trouble with the folder as the user's."""
    try:
        yield
    except OSError as error:
        raise ConfigError(f"{error.filename}: {error.strerror}") from None


def sizes(code: bytes) -> Sizes:
    """Return what a boat takes whose tick is in the object ``code``."""
    kinds = (VESSEL, COMPACT, STATE, SCRATCH)
    return Sizes(code_words(code), *(kind.itemsize // 2 for kind in kinds))


def add_library(folder: Path) -> None:
    """Link the object in ``folder`` into a library; NoCompilerError if that cannot be done."""
    link(folder / OBJECT, folder / LIBRARY)
