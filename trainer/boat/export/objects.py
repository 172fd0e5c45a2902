"""The objects of all kernels that are called from outside the core, for each platform.

``trainer boat export-core trainer/boat/shipped --cpu shipped`` makes those that the package ships,
and their card. ``machine_code`` makes the one of this machine where none that is shipped fits. They
are lowered in a process of its own, for plain processors, so that the bytes do not depend on the
machine that makes them.
"""

import gzip
import hashlib
import json
import platform
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
from llvmlite import binding

from trainer.boat.entries import KERNEL_ENTRIES, TICK_NAME, entry_of
from trainer.boat.export.lowering import (
    BOAT_TICK,
    compile_for,
    constants_text,
    entry_text,
    kernel_text,
    lower_in_child,
)
from trainer.boat.platforms import CARD_FILE, CPU_TARGETS, SHIPPED_PLATFORMS, Platform
from trainer.core.digest import core_digest
from trainer.core.entry import tick
from trainer.core.kernel import Record
from trainer.core.update import update
from trainer.io.outputs import replacing

CHILD_CODE: Final = (
    "from sys import argv; from trainer.boat.export import objects; objects.lower(*argv[1:])"
)
BOAT_CODE: Final = CHILD_CODE.replace(".lower", ".lower_boat")
OBJECT_FILE: Final = "boat.o"
# because each argument costs time to hand over
BLOCK_TEXT: Final = """
define i32 @{name}(ptr %block) {{
{loads}
  %status = call i32 @{tick}({words})
  ret i32 %status
}}
"""


def block_text(tick_name: str, kinds: Iterable[str]) -> str:
    """Return the LLVM text of the tick whose arguments are in one block of words."""
    loads, words = [], []
    for i, kind in enumerate(kinds):
        loads.append(f"  %p{i} = getelementptr i64, ptr %block, i64 {i}")
        loads.append(f"  %x{i} = load {kind}, ptr %p{i}")
        words.append(f"{kind} %x{i}")
    return BLOCK_TEXT.format(
        name=TICK_NAME, loads="\n".join(loads), tick=tick_name, words=", ".join(words)
    )


def lower(folder: str, *names: str) -> None:
    """Write the objects of the platforms named into a folder; "host" is this machine's."""
    texts: list[str] = []
    for entry in KERNEL_ENTRIES:
        text, kernel = kernel_text(entry)
        texts += [text, entry_text(entry, kernel, entry.name)]
        if entry.kernel is tick:
            kinds = [*(["ptr"] * len(entry.kinds)), *("double" for _ in entry.sizes)]
            texts[-1] += block_text(entry.name, kinds)
    shown = {*(entry.name for entry in KERNEL_ENTRIES), TICK_NAME}
    for name in names:
        target = SHIPPED_PLATFORMS.get(name) or host_platform()
        Path(folder, f"{name}.o").write_bytes(compile_for(target, texts, shown))


def lower_boat(folder: str, name: str, *constants: str) -> None:
    """Write the object of one boat for a target into a folder.

    Its scheme and constants lie there, in files of their names.
    """
    entry = entry_of(update)
    text, kernel = kernel_text(entry)
    scheme = Path(folder, "scheme").read_bytes()
    given = {each: Path(folder, each).read_bytes() for each in constants}
    texts = (text, entry_text(entry, kernel, BOAT_TICK, scheme), constants_text(given))
    code = compile_for(CPU_TARGETS[name], texts, {BOAT_TICK, *constants})
    Path(folder, OBJECT_FILE).write_bytes(code)


def boat_object(name: str, scheme: Record, constants: Mapping[str, bytes]) -> bytes:
    """Return the object of one boat for a target; ConfigError where nothing makes it."""
    with tempfile.TemporaryDirectory() as folder:
        for file, data in {"scheme": np.asarray(scheme).tobytes(), **constants}.items():
            Path(folder, file).write_bytes(data)
        lower_in_child(BOAT_CODE, (folder, name, *constants))
        return Path(folder, OBJECT_FILE).read_bytes()


def host_platform() -> Platform:
    """Return the plain processor of this machine's kind."""
    return Platform(binding.get_process_triple(), "generic")


def make_objects(*names: str) -> dict[str, bytes]:
    """Return the objects of platforms by name; ConfigError where they cannot be made."""
    with tempfile.TemporaryDirectory() as folder:
        lower_in_child(CHILD_CODE, (folder, *names))
        return {name: Path(folder, f"{name}.o").read_bytes() for name in names}


def card_of(objects: dict[str, bytes]) -> dict[str, Any]:
    """Return what objects were made from, and what they are."""
    return {
        "core": core_digest(),
        "python": platform.python_version(),
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "objects": {
            name: {"bytes": len(code), "sha256": hashlib.sha256(code).hexdigest()}
            for name, code in objects.items()
        },
    }


def write_shipped(folder: Path) -> dict[str, Any]:
    """Write the objects of all platforms and their card into a folder; return the card."""
    objects = make_objects(*SHIPPED_PLATFORMS)
    card = card_of(objects)
    files = {f"{name}.o.gz": gzip.compress(code, 9, mtime=0) for name, code in objects.items()}
    files[CARD_FILE] = (json.dumps(card, indent=1) + "\n").encode()
    for name, data in files.items():
        with replacing(folder / name) as made:
            made.write_bytes(data)
    return card
