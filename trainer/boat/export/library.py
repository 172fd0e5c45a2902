"""The folder of an exported core: object, library, header, host and card.

``trainer boat export-core`` calls it, for a host that has no Python. The card says what the host's
programmer must know: sizes, times, and which boat it is.
"""

import gzip
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

from trainer import __version__
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.entries import entry_of
from trainer.boat.export.header import header_text
from trainer.boat.export.lowering import freestanding_module
from trainer.boat.export.objects import boat_object
from trainer.boat.export.targets import (
    Processor,
    code_words,
    find_processor,
    link_library,
    object_code,
    of_this_machine,
)
from trainer.boat.platforms import CPU_TARGETS
from trainer.config.files import ConfigError
from trainer.core.digest import core_digest
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import WATCHED_NAMES, update
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.outputs import refuse_input, replacing
from trainer.io.tables import MOTION_COLUMNS

CARD_HEADING: Final = "trainer-core 1"  # and the format of what follows
OBJECT_FILE: Final = "trainer_core.o"
LIBRARY_FILE: Final = "libtrainer_core.so"
HEADER_FILE: Final = "trainer_core.h"
HOST_FILE: Final = "host.c"


def card_text(boat: Boat, target: Processor) -> str:
    """Return the card of ``boat`` compiled for ``target``."""
    method = boat.method
    columns = " ".join(f"{name}={STATE_OFFSETS[name]}" for name in MOTION_COLUMNS if name != "t")
    lines = [
        CARD_HEADING,
        f"version {__version__}",
        f"core {core_digest()}",
        f"boat {boat.file.name}",
        f"computed {method.equations} set, {method.integrator} at {method.step:g} s",
        f"cpu {target.name}",
        f"needs {' '.join(target.needs)}",
        f"step {method.step.hex()}",
        f"places {STATE.itemsize // 8}",
        f"work {SCRATCH.itemsize // 8}",
        f"watched {' '.join(WATCHED_NAMES)}",
        f"columns {columns}",
    ]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class BoatSizes:
    """The size of one boat, in words of 16 bits."""

    code: int
    vessel: int
    compact: int
    state: int
    scratch: int


@dataclass(frozen=True)
class CoreExport:
    """The files and facts of a finished export."""

    boat: str
    cpu: str
    step_s: float
    files: tuple[str, ...]
    words_of_16_bits: BoatSizes


def constants_of(boat: Boat, card: str) -> dict[str, bytes]:
    """Return the constants of an exported core by their names in C."""
    return {
        "trainer_vessel": boat.records.vessel.tobytes(),
        "trainer_compact": boat.records.compact.tobytes(),
        "trainer_start": boat.records.state.tobytes(),
        "trainer_card": card.encode() + b"\0",
    }


def write_core(boat: Boat, folder: Path, cpu: str) -> CoreExport:
    """Write the core of ``boat`` as it stands into ``folder``, but for the library.

    ConfigError if the folder cannot be written, or nothing be compiled for ``cpu``.
    """
    make_folder(folder, OBJECT_FILE, LIBRARY_FILE, HEADER_FILE, HOST_FILE)
    target, scheme = find_processor(cpu), boat.records.scheme
    constants = constants_of(boat, card_text(boat, target))
    if of_this_machine(cpu):
        code = object_code(freestanding_module(entry_of(update), scheme, constants), target)
    else:
        code = boat_object(cpu, scheme, constants)
    sources = [HOST_FILE, *CPU_TARGETS[cpu].board]
    files = {
        OBJECT_FILE: code,
        HEADER_FILE: header_text(boat, target.name).encode(),
        **{name: Path(__file__).with_name(name).read_bytes() for name in sources},
    }
    with name_trouble(folder):
        for name, data in files.items():
            with replacing(folder / name) as made:
                made.write_bytes(data)
    step = boat.method.step
    return CoreExport(boat.file.name, target.name, step, tuple(files), boat_sizes(code))


def make_folder(folder: Path, *names: str) -> None:
    """Make an export's folder; ConfigError if one of these names is an input."""
    with name_trouble(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name in names:
            refuse_input(folder / name)


@contextmanager
def name_trouble(folder: Path) -> Iterator[None]:
    """Raise ConfigError for an OSError in the block, with the file's name, else the folder's.

    The user then reads which file could not be written, and no traceback.
    """
    try:
        yield
    except OSError as error:
        raise ConfigError(f"{error.filename or folder}: {error.strerror}") from None


def boat_sizes(code: bytes) -> BoatSizes:
    """Return what a boat takes whose tick is in the object ``code``."""
    kinds = (VESSEL, COMPACT, STATE, SCRATCH)
    return BoatSizes(code_words(code), *(kind.itemsize // 2 for kind in kinds))


def add_library(folder: Path, cpu: str) -> None:
    """Link the object in ``folder`` into a library; NoCompilerError if that cannot be done."""
    link_library(folder / OBJECT_FILE, folder / LIBRARY_FILE, CPU_TARGETS[cpu])


def render_export(exported: CoreExport, folder: Path, files: tuple[str, ...], cpu: str) -> str:
    """Return the account of an export for a target into ``folder``."""
    words = asdict(exported.words_of_16_bits)
    linked = [folder / name for name in (*CPU_TARGETS[cpu].board, HOST_FILE, OBJECT_FILE)]
    lines = [
        exported.boat,
        f"compiled for {exported.cpu}",
        *(f"  {folder / name}" for name in files),
        "",
        "16-bit words",
        *(f"  {name:10}{count:8,}" for name, count in words.items()),
        f"  {'together':10}{sum(words.values()):8,}",
        "",
        f"{CPU_TARGETS[cpu].compiler} -O2 -ffp-contract=off -o host {' '.join(map(str, linked))}",
    ]
    return "\n".join(lines)


@dataclass(frozen=True)
class WasmExport:
    """The files and sizes of a finished export for WebAssembly."""

    boat: str
    files: tuple[str, ...]
    module_bytes: int
    packed_bytes: int  # as a server sends it
    state_bytes: int


def export_wasm(boat: Boat, folder: Path) -> WasmExport:
    """Write the core for WebAssembly and the numbers of ``boat`` as it stands into ``folder``."""
    from trainer.boat.export import wasm  # noqa: PLC0415  it is for one processor of many

    make_folder(folder, wasm.MODULE_FILE, wasm.CARD_FILE, wasm.NUMBERS_FILE, wasm.HOST_FILE)
    files = wasm.files_of(boat)
    with name_trouble(folder):
        for name, data in files.items():
            with replacing(folder / name) as made:
                made.write_bytes(data)
    code = files[wasm.MODULE_FILE]
    packed = len(gzip.compress(code, 9))
    return WasmExport(boat.file.name, tuple(files), len(code), packed, STATE.itemsize)


def render_wasm(module: WasmExport, folder: Path) -> str:
    """Return the account of an export for WebAssembly into ``folder``."""
    lines = [
        module.boat,
        "compiled for wasm32",
        *(f"  {folder / name}" for name in module.files),
        "",
        f"{module.module_bytes:,} bytes of code, {module.packed_bytes:,} packed",
        f"{module.state_bytes:,} bytes a state",
        "",
        f"node {folder / 'host.mjs'} 7200",
    ]
    return "\n".join(lines)
