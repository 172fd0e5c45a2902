"""The core for WebAssembly: one module without imports, for any boat of one method.

``trainer boat export-core`` and ``trainer boat export-page`` take it. What the method settles is
constant in it; step, triggers, vessel and state are the host's. It is lowered in a process of its
own, for a plain processor, so that its bytes do not depend on the machine.
"""

import base64
import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np

from trainer import __version__
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.entries import Entry, entry_of
from trainer.boat.export.header import fields_of
from trainer.boat.export.lowering import (
    call_program,
    compile_for,
    entry_text,
    kernel_text,
    lower_in_child,
    quote_bytes,
)
from trainer.boat.export.orders import order_rows
from trainer.boat.export.targets import Effort
from trainer.boat.platforms import CPU_TARGETS
from trainer.boat.readings import READING_OFFSETS
from trainer.config.files import ConfigError
from trainer.core.casualties import begin, end, instruments
from trainer.core.digest import core_digest, same_core
from trainer.core.kernel import Record
from trainer.core.readings import READINGS, write_readings
from trainer.core.scheme import SCHEME
from trainer.core.sea.sea import TAPER, order_sea
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import update
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.orders.grammar import Refused

WASM32: Final = "wasm32"
MODULE_FILE: Final = "core.wasm"
SHIPPED_PATH: Final = Path(__file__).with_name(MODULE_FILE)
CARD_FILE: Final = "core.wasm.txt"  # what the module was made from
NUMBERS_FILE: Final = "boat.json"
HOST_FILE: Final = "host.mjs"
LINKER_NAME: Final = CPU_TARGETS[WASM32].compiler
LINKER_OPTIONS: Final = (
    "--no-entry",
    "--strip-all",
    "--no-check-features",
    "-z",
    "stack-size=65536",
    "--initial-memory=262144",
)
INSTALL_HINT: Final = (
    "Debian and Ubuntu: apt install lld; Fedora: dnf install lld; macOS: brew install lld; "
    "Windows: winget install LLVM.LLVM"
)
CHILD_CODE: Final = "import sys; from trainer.boat.export import wasm; wasm.lower(*sys.argv[1:])"
SETTLED_BYTES: Final = range(8, fields_of(SCHEME)["trigger_place"][0])  # all but step, triggers
# room for one boat, of zeros, in the order of the tick; a host may use memory of its own
ROOM_NAMES: Final = ("vessel", "compact", "scheme", "state", "scratch", "wanted", "readings")
ROOM_SIZES: Final = (
    *(kind.itemsize for kind in (VESSEL, COMPACT, SCHEME, STATE, SCRATCH)),
    8 * (TAPER + 1),
    READINGS.itemsize,
)


# rows of ``entries`` that hosts were written for, by their names there
HOST_FUNCTIONS: Final[Mapping[str, Entry]] = {
    "trainer_tick": entry_of(update),
    "trainer_read": entry_of(instruments),
    "trainer_show": entry_of(write_readings),
    "trainer_begin": entry_of(begin),
    "trainer_end": entry_of(end),
    "trainer_sea": entry_of(order_sea),
}


def settle_method(text: str, scheme: bytes) -> str:
    """Return the text of the tick, which reads from a constant what the method settles.

    The compiler can then drop what the method does not use. Where numba writes another text nothing
    is settled: the module is larger, and its results have the same bits.
    """
    match = re.search(r"^define[^\n]*core6update6update", text, re.MULTILINE)
    if not match:
        return text
    start = match.start()
    end = text.index("\n}", start)
    member = re.compile(r"(getelementptr [^%\n]*ptr )%arg\.scheme\.4, i64 (\d+)\b")  # its numbers

    def constant(use: re.Match[str]) -> str:
        return f"{use[1]}@settled, i64 {use[2]}" if int(use[2]) in SETTLED_BYTES else use[0]

    head = f'@settled = internal constant [{len(scheme)} x i8] c"{quote_bytes(scheme)}", align 8\n'
    return text[:start] + head + member.sub(constant, text[start:end]) + text[end:]


def lower(scheme: str, target: str) -> None:
    """Write the object of the module for the scheme in file ``scheme`` to file ``target``."""
    rooms = "".join(
        f"@trainer_{room} = global [{size} x i8] zeroinitializer, align 16\n"
        for room, size in zip(ROOM_NAMES, ROOM_SIZES, strict=True)
    )
    texts = [rooms]
    for name, entry in HOST_FUNCTIONS.items():
        text, kernel = kernel_text(entry)
        texts.append(settle_method(text, Path(scheme).read_bytes()))
        texts.append(entry_text(entry, kernel, name))
    shown = {*HOST_FUNCTIONS, *(f"trainer_{room}" for room in ROOM_NAMES)}
    Path(target).write_bytes(compile_for(CPU_TARGETS[WASM32], texts, shown, Effort(2)))


def build_module(scheme: Record) -> bytes:
    """Return the module for the method of ``scheme``; ConfigError where it cannot be linked."""
    linker = shutil.which(LINKER_NAME)
    if linker is None:
        raise ConfigError(f"--cpu {WASM32}: there is no linker {LINKER_NAME} here. {INSTALL_HINT}")
    with tempfile.TemporaryDirectory() as folder:
        code, module = Path(folder) / "core.o", Path(folder) / MODULE_FILE
        _lowered(np.asarray(scheme).tobytes(), code)
        shown = [
            f"--export={name}"
            for name in (*HOST_FUNCTIONS, *(f"trainer_{room}" for room in ROOM_NAMES))
        ]
        call_program([linker, *LINKER_OPTIONS, *shown, "-o", str(module), str(code)], os.environ)
        return module.read_bytes()


def _lowered(scheme: bytes, code: Path) -> None:
    """Write the object of the module to ``code``, made by a process of its own."""
    method = code.with_name("scheme")
    method.write_bytes(scheme)
    lower_in_child(CHILD_CODE, (str(method), str(code)))


def card_text(module: bytes, boat: Boat) -> str:
    """Return the card of a module: digest, core, method, and what built it."""
    linker = subprocess.run([LINKER_NAME, "--version"], capture_output=True, text=True, check=True)  # noqa: S603
    versions = f"numba {numba.__version__}, llvmlite {llvmlite.__version__}"
    lines = [
        f"sha256 {hashlib.sha256(module).hexdigest()}",
        f"core {core_digest()}",
        f"method {method_of(boat)}",
        f"built by {versions}, {linker.stdout.strip()}",
    ]
    return "\n".join(lines) + "\n"


def method_of(boat: Boat) -> str:
    """Return what the module settles, in words."""
    m = boat.method
    return f"{m.equations} set, {m.rates} rates, {m.trig} angles, {m.integrator}"


def shipped_card() -> dict[str, str]:
    """Return the card of the trainer's module."""
    return dict(
        line.split(" ", 1) for line in SHIPPED_PATH.with_name(CARD_FILE).read_text().splitlines()
    )


def shipped_module(boat: Boat) -> bytes:
    """Return the module of the trainer; ConfigError where it is not for this boat."""
    card = shipped_card()
    if not same_core(card["core"]):
        raise ConfigError(
            f"{SHIPPED_PATH}: of core {card['core']}, not {core_digest()}: trainer boat "
            f"export-core DIR --cpu {WASM32} builds it; copy {MODULE_FILE} and {CARD_FILE} from DIR"
        )
    if method_of(boat) != card["method"]:
        raise ConfigError(
            f"{boat.file.path.name}: {method_of(boat)}; a page's boat has the {card['method']}"
        )
    return SHIPPED_PATH.read_bytes()


def boat_misfit(boat: Boat) -> Refused | None:
    """Return why the trainer's own module is not for this boat, None if it is.

    A module has its method fixed, so another equation set needs another module.
    """
    card = shipped_card()
    if not same_core(card["core"]):
        return Refused(f"of core {card['core']}, not {core_digest()}")
    of_card, method = card["method"], method_of(boat)
    return None if method == of_card else Refused(f"for the {of_card}, not the {method}")


def numbers_of(boat: Boat) -> dict[str, Any]:
    """Return records and orders of a boat as it stands, and the state's offsets."""
    r = boat.records
    records = {"vessel": r.vessel, "compact": r.compact, "scheme": r.scheme, "state": r.state}
    packed = {room: base64.b64encode(record.tobytes()).decode() for room, record in records.items()}
    return {
        "version": __version__,
        "core": core_digest(),
        "boat": boat.file.name,
        "step_s": boat.method.step,
        "state_doubles": STATE.itemsize // 8,
        "places": STATE_OFFSETS,
        "readings": READING_OFFSETS,
        "orders": order_rows(boat),
        "records": packed,
    }


def module_of(boat: Boat) -> tuple[bytes, bytes]:
    """Return a module for a boat's method, and its card.

    It is built here, or else is the trainer's own. ConfigError where nothing links it here, and
    the trainer's is for another core or method.
    """
    if shutil.which(LINKER_NAME):
        module = build_module(boat.records.scheme)
        return module, card_text(module, boat).encode()
    if refused := boat_misfit(boat):
        raise ConfigError(
            f"--cpu {WASM32}: there is no linker {LINKER_NAME} here, and the {MODULE_FILE} "
            f"that comes with the trainer is {refused.reason}. {INSTALL_HINT}"
        )
    return SHIPPED_PATH.read_bytes(), SHIPPED_PATH.with_name(CARD_FILE).read_bytes()


def files_of(boat: Boat) -> dict[str, bytes]:
    """Return the files of an export for WebAssembly, by name."""
    module, card = module_of(boat)
    return {
        MODULE_FILE: module,
        CARD_FILE: card,
        NUMBERS_FILE: json.dumps(numbers_of(boat)).encode(),
        HOST_FILE: Path(__file__).with_name(HOST_FILE).read_bytes(),
    }
