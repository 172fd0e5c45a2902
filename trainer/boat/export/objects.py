"""The objects of all kernels that are called from outside the core, for each platform.

``trainer boat export-core trainer/boat/shipped --cpu shipped`` makes those that the package ships,
and their card. ``machine_code`` makes the one of this machine where none that is shipped fits. They
are lowered in a process of its own, for plain processors, so that the bytes do not depend on the
machine that makes them.

numba optimises nothing of those that are shipped. The compiler here would find loops unrolled that
it cannot roll up again, and a tick had 4 to 8 % more instructions.
"""

import gzip
import hashlib
import json
import platform
import tempfile
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
from llvmlite import binding

from trainer.boat.entries import Entry, digest_room, entries_of, entry_of
from trainer.boat.export.lowering import (
    BOAT_TICK,
    compile_for,
    constants_text,
    entry_text,
    kernel_text,
    lower_in_child,
)
from trainer.boat.export.targets import Effort
from trainer.boat.platforms import (
    CARD_FILE,
    CPU_TARGETS,
    ROOMS,
    SHIPPED_OBJECTS,
    UNIT_OBJECTS,
    Platform,
)
from trainer.core.casualties import begin, end, instruments
from trainer.core.digest import core_digest
from trainer.core.kernel import Record
from trainer.core.sea.sea import order_sea
from trainer.core.update import update
from trainer.io.outputs import replacing

UNIT_KERNELS: Final = (update, instruments, begin, end, order_sea)  # as ``unit.c`` declares them
SHIPPED_EFFORT: Final = Effort(2, vectors=True)  # level 3 is larger by 4 %, and slower by 1 %
UNIT_EFFORT: Final = SHIPPED_EFFORT._replace(unrolling=False)  # smaller by 13 %, slower by 20 %
CHILD_CODE: Final = (
    "from sys import argv; from trainer.boat.export import objects; objects.lower(*argv[1:])"
)
BOAT_CODE: Final = CHILD_CODE.replace(".lower", ".lower_boat")
OBJECT_FILE: Final = "boat.o"
# because each argument costs time to hand over
BLOCK_TEXT: Final = """
define i32 @{name}(ptr %block) {{
{loads}
  %status = call i32 @{entry}({words})
  ret i32 %status
}}
"""


def block_text(entry: Entry) -> str:
    """Return the LLVM text of an entry whose arguments are in one block of words."""
    loads, words = [], []
    kinds = ["double" if kind in (int, float) else "ptr" for kind in entry.kinds]
    kinds += ["double" for _ in entry.sizes]
    for i, kind in enumerate(kinds):
        loads.append(f"  %p{i} = getelementptr i64, ptr %block, i64 {i}")
        loads.append(f"  %x{i} = load {kind}, ptr %p{i}")
        words.append(f"{kind} %x{i}")
    return BLOCK_TEXT.format(
        name=entry.bound_name, loads="\n".join(loads), entry=entry.name, words=", ".join(words)
    )


def lower(folder: str, *names: str) -> None:
    """Write the objects of the platforms named into a folder; "host" is this machine's."""
    for room in ("", *ROOMS):
        own = [name for name in names if _room_in(name) == room]
        if own:
            _lower_room(folder, entries_of(room), own)


def _room_in(name: str) -> str:
    """Return the room that an object is of, by its name."""
    return next((room for room in ROOMS if name.startswith(f"{room}-")), "")


def _lower_room(folder: str, entries: Sequence[Entry], names: Sequence[str]) -> None:
    """Write objects that have these entries."""
    texts: dict[str, tuple[str, str]] = {}
    bound: set[str] = set()
    for entry in entries:
        text, kernel = kernel_text(entry)
        own = entry_text(entry, kernel, entry.name)
        if entry.bound:
            own += block_text(entry)
            bound.add(entry.bound_name)
        texts[entry.name] = text, own
    called = {entry_of(kernel).name for kernel in UNIT_KERNELS}
    for name in names:
        target = SHIPPED_OBJECTS.get(name) or Platform(binding.get_process_triple(), "generic")
        of_unit = name in UNIT_OBJECTS.values()
        shown = called if of_unit else {*texts, *bound}
        needed = chain.from_iterable(text for entry, text in texts.items() if entry in shown)
        code = compile_for(target, needed, shown, UNIT_EFFORT if of_unit else SHIPPED_EFFORT)
        Path(folder, f"{name}.o").write_bytes(code)


def lower_boat(folder: str, name: str, *constants: str) -> None:
    """Write the object of one boat for a target into a folder.

    Its scheme and constants lie there, in files of their names.
    """
    entry = entry_of(update)
    text, kernel = kernel_text(entry)
    scheme = Path(folder, "scheme").read_bytes()
    given = {each: Path(folder, each).read_bytes() for each in constants}
    texts = (text, entry_text(entry, kernel, BOAT_TICK, scheme), constants_text(given))
    target = CPU_TARGETS[name]
    effort = Effort(3 if target.bits == 64 else 2)  # where memory is short, size counts
    code = compile_for(target, texts, {BOAT_TICK, *constants}, effort)
    Path(folder, OBJECT_FILE).write_bytes(code)


def boat_object(name: str, scheme: Record, constants: Mapping[str, bytes]) -> bytes:
    """Return the object of one boat for a target; ConfigError where nothing makes it."""
    with tempfile.TemporaryDirectory() as folder:
        for file, data in {"scheme": np.asarray(scheme).tobytes(), **constants}.items():
            Path(folder, file).write_bytes(data)
        lower_in_child(BOAT_CODE, (folder, name, *constants))
        return Path(folder, OBJECT_FILE).read_bytes()


def make_objects(*names: str) -> dict[str, bytes]:
    """Return the objects of platforms by name; ConfigError where they cannot be made."""
    with tempfile.TemporaryDirectory() as folder:
        settings = {"NUMBA_OPT": "0", "NUMBA_CACHE_DIR": folder}  # what is cached is optimised
        if not SHIPPED_OBJECTS.keys() >= set(names):
            settings = {}  # because a user's machine may lack the 3 GB that this takes
        lower_in_child(CHILD_CODE, (folder, *names), settings)
        return {name: Path(folder, f"{name}.o").read_bytes() for name in names}


def card_of(objects: Mapping[str, Any]) -> dict[str, Any]:
    """Return what objects were made from, and what they are."""
    return {
        "core": core_digest(),
        **{room: digest_room(room) for room in ROOMS},
        "python": platform.python_version(),
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "objects": objects,
    }


def write_shipped(folder: Path) -> dict[str, Any]:
    """Write the objects of all platforms and their card into a folder; return the card.

    Those that the folder has are kept if their sources and compilers are the same.
    """
    card_path = folder / CARD_FILE
    known = json.loads(card_path.read_text("utf-8")) if card_path.is_file() else {"objects": {}}
    new = card_of({})
    changed = {key for key, value in new.items() if known.get(key) != value} - {"objects"}
    anew = bool(changed - {*ROOMS})
    kept = {
        name: said
        for name, said in known["objects"].items()
        if not anew and _room_in(name) not in changed
    }
    made = make_objects(*(name for name in SHIPPED_OBJECTS if name not in kept))
    said = kept | {
        name: {"bytes": len(code), "sha256": hashlib.sha256(code).hexdigest()}
        for name, code in made.items()
    }
    card = card_of({name: said[name] for name in SHIPPED_OBJECTS})
    files = {f"{name}.o.gz": gzip.compress(code, 9, mtime=0) for name, code in made.items()}
    files[CARD_FILE] = (json.dumps(card, indent=1) + "\n").encode()
    for name, data in files.items():
        with replacing(folder / name) as written:
            written.write_bytes(data)
    return card
