"""The core for WebAssembly: one module without imports, for any boat of one method.

What the method settles is constant in it; step, triggers, vessel and state are the host's. It is
lowered in a process of its own, for a plain processor, so that its bytes do not depend on the
machine.
"""

import base64
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
from llvmlite import binding
from numba import carray  # type: ignore[attr-defined]

from trainer import __version__
from trainer.boat.boat import PLACES, Boat
from trainer.boat.export.header import places_of
from trainer.boat.export.lowering import (
    LENT,
    Kind,
    freestanding_text,
    kernel_text,
    quote,
    sealed,
    tick,
)
from trainer.boat.export.orders import rows
from trainer.boat.export.targets import optimise
from trainer.config.files import ConfigError
from trainer.core.cache import core_digest, same_core
from trainer.core.casualties import begin, end, instruments
from trainer.core.kernel import Record
from trainer.core.scheme import SCHEME
from trainer.core.sea.sea import TAPER, order_sea
from trainer.core.state import SCRATCH, STATE
from trainer.core.vessel import COMPACT, VESSEL

WASM32: Final = "wasm32"
MODULE: Final = "core.wasm"
SHIPPED: Final = Path(__file__).with_name(MODULE)
CARD: Final = "core.wasm.txt"  # what the module was made from
NUMBERS: Final = "boat.json"
HOST: Final = "host.mjs"
TRIPLE: Final = "wasm32-unknown-unknown"
FEATURES: Final = "+bulk-memory,+bulk-memory-opt"  # in every browser since 2021
LINKER: Final = "wasm-ld"
LINKING: Final = (
    *("--no-entry", "--strip-all", "--no-check-features", "-z", "stack-size=65536"),
    "--initial-memory=262144",
)
INSTALL: Final = (
    "Debian and Ubuntu: apt install lld; Fedora: dnf install lld; macOS: brew install lld; "
    "Windows: winget install LLVM.LLVM"
)
# the machine that the kernels are lowered for: what it lacks is not in the text either
PLAIN: Final = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
CHILD: Final = "import sys; from trainer.boat.export import wasm; wasm.lower(*sys.argv[1:])"
WANTED: Final = np.dtype(np.float64)  # of a sea: its quantities and the taper
SETTLED: Final = range(8, places_of(SCHEME)["trigger_place"][0])  # all but step, triggers
# room for one boat, of zeros, in the order of the tick; a host may use memory of its own
ROOMS: Final = ("vessel", "compact", "scheme", "state", "scratch", "wanted")
ROOM_SIZES: Final = (
    *(kind.itemsize for kind in (VESSEL, COMPACT, SCHEME, STATE, SCRATCH)),
    8 * (TAPER + 1),
)


def read(state: Any, scratch: Any) -> int:
    """Write what the gauges read at this tick."""
    instruments(carray(state, 1), carray(scratch, 1))
    return 0


def insert(kind: float, amount: float, ticks: float, state: Any) -> int:
    """Begin a casualty; return what ``begin`` does."""
    return begin(int(kind), amount, ticks, carray(state, 1))


def clear(kind: float, ticks: float, state: Any) -> int:
    """End a casualty; return what ``end`` does."""
    return end(int(kind), ticks, carray(state, 1))


def sea(vessel: Any, step: float, ramp: float, wanted: Any, scratch: Any, state: Any) -> int:
    """Order the sea whose quantities and taper are at ``wanted``."""
    numbers = carray(wanted, TAPER + 1)
    order_sea(carray(vessel, 1), step, ramp, numbers, carray(scratch, 1), carray(state, 1))
    return 0


class Exported(NamedTuple):
    """A function of the module and the kinds of its parameters."""

    function: Callable[..., int]
    kinds: tuple[Kind, ...]


FUNCTIONS: Final[Mapping[str, Exported]] = {
    "trainer_tick": Exported(tick, LENT),
    "trainer_read": Exported(read, (STATE, SCRATCH)),
    "trainer_begin": Exported(insert, (float, float, float, STATE)),
    "trainer_end": Exported(clear, (float, float, STATE)),
    "trainer_sea": Exported(sea, (VESSEL, float, float, WANTED, SCRATCH, STATE)),
}


def entry_text(name: str, kernel: str, kinds: tuple[Kind, ...]) -> str:
    """Return the LLVM text of a function that calls a kernel of numba's."""
    taken = ", ".join(
        f"{'double' if kind is float else 'ptr'} %x{i}" for i, kind in enumerate(kinds)
    )
    wanted = ", ".join("double" if kind is float else "ptr" for kind in kinds)
    return f"""
declare i32 @"{kernel}"(ptr, ptr, {wanted})
define i32 @{name}({taken}) {{
  %answer = alloca i64
  %error = alloca ptr
  store i64 -1, ptr %answer
  %raised = call i32 @"{kernel}"(ptr %answer, ptr %error, {taken})
  %sound = icmp eq i32 %raised, 0
  %wide = load i64, ptr %answer
  %said = trunc i64 %wide to i32
  %status = select i1 %sound, i32 %said, i32 -1
  ret i32 %status
}}
"""


def settled(text: str, scheme: bytes) -> str:
    """Return the text of the tick with what the method settles read from a constant.

    Where numba writes another text nothing is settled: the module is larger, its bits are the same.
    """
    found = re.search(r"^define[^\n]*core6update6update", text, re.MULTILINE)
    if not found:
        return text
    start = found.start()
    end = text.index("\n}", start)
    place = re.compile(r"(getelementptr [^%\n]*ptr )%arg\.scheme\.4, i64 (\d+)\b")  # its numbers

    def constant(use: re.Match[str]) -> str:
        return f"{use[1]}@settled, i64 {use[2]}" if int(use[2]) in SETTLED else use[0]

    head = f'@settled = internal constant [{len(scheme)} x i8] c"{quote(scheme)}", align 8\n'
    return text[:start] + head + place.sub(constant, text[start:end]) + text[end:]


def lower(scheme: str, target: str) -> None:
    """Write the object of the module, for the scheme in a file, to another."""
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine = binding.Target.from_triple(TRIPLE).create_target_machine(
        cpu="mvp", features=FEATURES, opt=2, reloc="static", codemodel="small"
    )
    head = f'target datalayout = "{machine.target_data}"\ntarget triple = "{TRIPLE}"\n'
    rooms = "".join(
        f"@trainer_{room} = global [{size} x i8] zeroinitializer, align 16\n"
        for room, size in zip(ROOMS, ROOM_SIZES, strict=True)
    )
    module = binding.parse_assembly(head + freestanding_text(32) + rooms)
    for name, (function, kinds) in FUNCTIONS.items():
        text, kernel = kernel_text(function, kinds)
        text = re.sub(r"^target .*$", "", text, flags=re.MULTILINE)
        text = settled(text, Path(scheme).read_bytes())
        for part in (text, entry_text(name, kernel, kinds)):
            module.link_in(binding.parse_assembly(head + part))
    sealed(module, {*FUNCTIONS, *(f"trainer_{room}" for room in ROOMS)})
    optimise(module, machine, 2)
    Path(target).write_bytes(machine.emit_object(module))


def build(scheme: Record) -> bytes:
    """Return the module for the method of ``scheme``; ConfigError where it cannot be linked."""
    linker = shutil.which(LINKER)
    if linker is None:
        raise ConfigError(f"--cpu {WASM32}: there is no linker {LINKER} here. {INSTALL}")
    with tempfile.TemporaryDirectory() as folder:
        code, module = Path(folder) / "core.o", Path(folder) / MODULE
        _lowered(np.asarray(scheme).tobytes(), code)
        shown = [
            f"--export={name}" for name in (*FUNCTIONS, *(f"trainer_{room}" for room in ROOMS))
        ]
        _call([linker, *LINKING, *shown, "-o", str(module), str(code)], dict(os.environ))
        return module.read_bytes()


def _lowered(scheme: bytes, code: Path) -> None:
    """Write the object of the module to ``code``, made by a process of its own."""
    method = code.with_name("scheme")
    method.write_bytes(scheme)
    _call([sys.executable, "-c", CHILD, str(method), str(code)], _plain_environment())


def _plain_environment() -> dict[str, str]:
    """Return the environment without what chooses how numba compiles, but for its cache."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    if "NUMBA_CACHE_DIR" in os.environ:
        kept["NUMBA_CACHE_DIR"] = os.environ["NUMBA_CACHE_DIR"]
    root = str(Path(__file__).parents[3])
    return kept | PLAIN | {"PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])}


def _call(words: list[str], environment: dict[str, str]) -> None:
    """Call another program; ConfigError with what it says where it fails."""
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or ["no word"])[-1]
        raise ConfigError(f"--cpu {WASM32}: {Path(words[0]).name} failed: {said}")


def card_text(module: bytes, boat: Boat) -> str:
    """Return the card of a module: digest, core, method, and what built it."""
    linker = subprocess.run([LINKER, "--version"], capture_output=True, text=True, check=True)  # noqa: S603
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


def card_shipped() -> dict[str, str]:
    """Return the card of the trainer's module."""
    return dict(line.split(" ", 1) for line in SHIPPED.with_name(CARD).read_text().splitlines())


def shipped(boat: Boat) -> bytes:
    """Return the module of the trainer; ConfigError where it is not for this boat."""
    card = card_shipped()
    if not same_core(card["core"]):
        raise ConfigError(
            f"{SHIPPED}: of core {card['core']}, not {core_digest()}: trainer export-core DIR "
            f"--cpu {WASM32} builds it again; copy {MODULE} and {CARD} from DIR"
        )
    if method_of(boat) != card["method"]:
        raise ConfigError(
            f"{boat.file.path.name}: {method_of(boat)}; a page's boat has the {card['method']}"
        )
    return SHIPPED.read_bytes()


def misfit(boat: Boat) -> str:
    """Return why the trainer's module is not for this boat, "" if it is."""
    card = card_shipped()
    if not same_core(card["core"]):
        return f"of core {card['core']}, not {core_digest()}"
    own = method_of(boat)
    return "" if own == card["method"] else f"for the {card['method']}, not the {own}"


def numbers_of(boat: Boat) -> dict[str, Any]:
    """Return records and orders of a boat as it stands, and the state's places."""
    r = boat.records
    records = {"vessel": r.vessel, "compact": r.compact, "scheme": r.scheme, "state": r.state}
    packed = {room: base64.b64encode(record.tobytes()).decode() for room, record in records.items()}
    return {
        "version": __version__,
        "core": core_digest(),
        "boat": boat.file.name,
        "step_s": boat.method.step,
        "state_doubles": STATE.itemsize // 8,
        "places": PLACES,
        "orders": rows(boat),
        "records": packed,
    }


def module_of(boat: Boat) -> tuple[bytes, bytes]:
    """Return a module for a boat's method, and its card.

    It is built here, or else is the trainer's own. ConfigError where nothing links it here, and
    the trainer's is for another core or method.
    """
    if shutil.which(LINKER):
        module = build(boat.records.scheme)
        return module, card_text(module, boat).encode()
    if why := misfit(boat):
        raise ConfigError(
            f"--cpu {WASM32}: there is no linker {LINKER} here, and the {MODULE} that comes with "
            f"the trainer is {why}. {INSTALL}"
        )
    return SHIPPED.read_bytes(), SHIPPED.with_name(CARD).read_bytes()


def files_of(boat: Boat) -> dict[str, bytes]:
    """Return the files of an export for WebAssembly, by name."""
    module, card = module_of(boat)
    return {
        MODULE: module,
        CARD: card,
        NUMBERS: json.dumps(numbers_of(boat)).encode(),
        HOST: Path(__file__).with_name(HOST).read_bytes(),
    }
