"""An exported boat in its shared library, as a host program has it, and the rows of its orders."""

import ctypes
import subprocess
from pathlib import Path
from typing import Any

from trainer.boat.entries import Entry, entry_of
from trainer.boat.export.targets import Processor, object_code
from trainer.boat.machine_code import shipped_object
from trainer.core.state import SCRATCH, STATE
from trainer.core.update import update

ARRAY_WORDS = "ptr, ptr, i64, i64, ptr %x{}, i64, i64"  # as numba takes one of one dimension


def shipped_kernel(entry: Entry) -> tuple[str, str]:
    """Return what ``lowering.kernel_text`` does; the kernel calls the shipped one of its name."""
    given = range(len(entry.kinds))
    taken = ", ".join(ARRAY_WORDS.format(i) for i in given)
    words = ", ".join(f"ptr %x{i}" for i in given)
    return (
        f"""declare i32 @{entry.name}({words})
        define i32 @kernel(ptr %answer, ptr %error, {taken}) {{
          %status = call i32 @{entry.name}({words})
          %whole = zext i32 %status to i64
          store i64 %whole, ptr %answer
          ret i32 0
        }}""",
        "kernel",
    )


def link_shipped(folder: Path, module: Any, target: Processor) -> bytes:
    """Return the object of a module and of the shipped kernels, whose names it hides."""
    own, shipped, linked = (folder / name for name in ("own.o", "shipped.o", "linked.o"))
    code = shipped_object()
    assert code, "no object of this core is shipped: trainer boat export-core --help"
    own.write_bytes(object_code(module, target))
    shipped.write_bytes(code)
    kernel = entry_of(update).name
    subprocess.run(["objcopy", f"--keep-global-symbol={kernel}", shipped], check=True)
    subprocess.run(["ld", "-r", "-o", linked, own, shipped], check=True)
    subprocess.run(["objcopy", f"--localize-symbol={kernel}", linked], check=True)
    return linked.read_bytes()


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
