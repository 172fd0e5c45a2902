"""The options with which every kernel of the core is compiled.

Floating point is strict (no contraction, no reassociation), so that the bits of a run do not depend
on the processor. Division by zero gives infinity, which the finite check of a tick reports.
"""

import re
from typing import TYPE_CHECKING, Any, Final

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

Record = NDArray[Any]  # a one-element structured array; a kernel binds ``s = state[0]``
Numbers = NDArray[np.float64]

# a name, a name with a shape, or a block's name with the names in it
Field = str | tuple[str, tuple[int, ...]] | tuple[str, list[str]]

TESTED_NUMBA: Final = (
    (0, 68),
    (0, 68),
)  # first and last version of numba whose inner parts are known


def is_tested(version: str) -> bool:
    """Return whether a version of numba is one whose inner parts are known."""
    found = re.match(r"(\d+)\.(\d+)", version)
    return (
        found is not None and TESTED_NUMBA[0] <= (int(found[1]), int(found[2])) <= TESTED_NUMBA[1]
    )


# Kernels do not count references to the records, which their callers hold: that took half a tick.
# C cannot call them: that took a sixth of the time to compile them. These options are not among
# numba's published ones, so other versions do without them. A part is a kernel whose machine code
# is put into that of the kernels that call it: calling parts one by one took a third of the rest
# of the time. What is called seldom, or from many places, is no part, and says so: a kernel that is
# first compiled within a part would take over its forceinline, and the rates would be in the tick
# nine times over, for twice the time and memory of compiling. An unlocked kernel runs long
# and lets other threads go on. An inlined one is a part that each of its callers compiles anew.
LEAN_OPTIONS: Final[dict[str, Any]] = (
    {"_nrt": False, "no_cfunc_wrapper": True} if is_tested(numba.__version__) else {}
)
if TYPE_CHECKING:  # numba's published signature lacks some of its options
    kernel = part = njit(cache=True, error_model="numpy")
    unlocked = njit(cache=True, error_model="numpy", nogil=True)
    inlined = njit(error_model="numpy", forceinline=True)
else:
    kernel = njit(cache=True, error_model="numpy", forceinline=False, **LEAN_OPTIONS)
    part = njit(cache=True, error_model="numpy", forceinline=True, **LEAN_OPTIONS)
    unlocked = njit(cache=True, error_model="numpy", nogil=True, **LEAN_OPTIONS)
    inlined = njit(error_model="numpy", forceinline=True, **LEAN_OPTIONS)


def record_dtype(*fields: Field) -> np.dtype:
    """Return a structured dtype of float64 fields, in the order given.

    A field is a name, a name with a shape, or a block's name with a list of names. Names in a list
    are single numbers that share the block's place. ``whole`` is the record as one block.
    """
    names: list[str] = []
    formats: list[Any] = []
    offsets: list[int] = []
    offset = 0

    def place(name: str, shape: tuple[int, ...], at: int) -> int:
        names.append(name)
        formats.append(("f8", shape) if shape else "f8")
        offsets.append(at)
        return 8 * int(np.prod(shape, dtype=int))

    for field in fields:
        if isinstance(field, str):
            offset += place(field, (), offset)
        elif isinstance(field[1], list):
            for position, member in enumerate(field[1]):
                place(member, (), offset + 8 * position)
            offset += place(field[0], (len(field[1]),), offset)
        else:
            offset += place(field[0], field[1], offset)
    place("whole", (offset // 8,), 0)
    layout = {"names": names, "formats": formats, "offsets": offsets, "itemsize": offset}
    return np.dtype((np.record, layout))
