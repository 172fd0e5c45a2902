"""The options with which every kernel of the core is compiled, and when it is.

A kernel that is called is machine code that is there already, if CODE_MODULE has some, or else
numba compiles it. So numba is imported only by what compiles. Under NUMBA_DISABLE_JIT a kernel is
the plain function.

Floating point is strict (no contraction, no reassociation), so that the bits of a run do not depend
on the processor. Division by zero gives infinity, which the finite check of a tick reports.
"""

import os
import re
from collections.abc import Callable
from functools import cached_property, update_wrapper
from importlib import import_module
from typing import Any, Final, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Record = NDArray[Any]  # a one-element structured array; a kernel binds ``s = state[0]``
Numbers = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., Any])

# a name, a name with a shape, or a block's name with the names in it
Field = str | tuple[str, tuple[int, ...]] | tuple[str, list[str]]

INTERPRETED: Final = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")
# what finds a kernel's code: named, not imported, because the core depends on nothing above it
CODE_MODULE: Final = "trainer.boat.machine_code"
TESTED_NUMBA: Final = (
    (0, 68),
    (0, 68),
)  # first and last version of numba whose inner parts are known
# Kernels do not count references to the records, which their callers hold: that took half a tick.
# C cannot call them: that took a sixth of the time to compile them. These options are not among
# numba's published ones, so other versions do without them.
LEAN_OPTIONS: Final = {"_nrt": False, "no_cfunc_wrapper": True}


def is_tested(version: str) -> bool:
    """Return whether a version of numba is one whose inner parts are known."""
    found = re.match(r"(\d+)\.(\d+)", version)
    return (
        found is not None and TESTED_NUMBA[0] <= (int(found[1]), int(found[2])) <= TESTED_NUMBA[1]
    )


class Kernel:
    """A function that machine code computes, once it is called.

    Where CODE_MODULE has none, numba compiles ``py_func`` with ``options``.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.options = options

    def __call__(self, *given: Any) -> Any:
        """Compute the function."""
        return self._code(*given)

    @cached_property
    def _code(self) -> Callable[..., Any]:
        found: Callable[..., Any] | None = import_module(CODE_MODULE).find_code(self)
        return found or self.dispatcher

    @cached_property
    def dispatcher(self) -> Any:
        """Return numba's own object of the kernel, which compiles it."""
        import numba  # noqa: PLC0415  what does not compile does without

        from trainer.core.cache import keep_by_sources  # noqa: PLC0415  it claims the folder

        known = is_tested(numba.__version__)
        lean = {name for name in LEAN_OPTIONS if not known}
        options = {name: value for name, value in self.options.items() if name not in lean}
        with keep_by_sources(self.py_func):
            return numba.njit(**options)(self.py_func)

    @property
    def _numba_type_(self) -> Any:
        """Return the type by which numba knows the kernel where another one calls it."""
        import numba  # noqa: PLC0415

        return numba.typeof(self.dispatcher)  # type: ignore[no-untyped-call]


def compiled_with(**options: Any) -> Callable[[Function], Function]:
    """Return a decorator for kernels that are compiled with these options of numba."""

    def decorate(function: Function) -> Function:
        return function if INTERPRETED else cast("Function", Kernel(function, **options))

    return decorate


# The machine code of an inline kernel is put into that of the kernels that call it: calling them
# one by one took a third of the rest of the time. What is called seldom, or from many places, is
# not inline, and says so: a kernel that is first compiled within an inline one would take over its
# forceinline, and the rates would be in the tick nine times over, for twice the time and memory of
# compiling. An unlocked kernel runs long and lets other threads go on.
kernel = compiled_with(cache=True, error_model="numpy", forceinline=False, **LEAN_OPTIONS)
inline_kernel = compiled_with(cache=True, error_model="numpy", forceinline=True, **LEAN_OPTIONS)
unlocked = compiled_with(cache=True, error_model="numpy", nogil=True, **LEAN_OPTIONS)


def record_dtype(*fields: Field) -> np.dtype:
    """Return a structured dtype of float64 fields, in the order given.

    A field is a name, a name with a shape, or a block's name with a list of names. Names in a list
    are single numbers that share the block's room. ``whole`` is the record as one block.
    """
    names: list[str] = []
    formats: list[Any] = []
    offsets: list[int] = []
    offset = 0

    def lay(name: str, shape: tuple[int, ...], at: int) -> int:
        names.append(name)
        formats.append(("f8", shape) if shape else "f8")
        offsets.append(at)
        return 8 * int(np.prod(shape, dtype=int))

    for field in fields:
        if isinstance(field, str):
            offset += lay(field, (), offset)
        elif isinstance(field[1], list):
            for position, member in enumerate(field[1]):
                lay(member, (), offset + 8 * position)
            offset += lay(field[0], (len(field[1]),), offset)
        else:
            offset += lay(field[0], field[1], offset)
    lay("whole", (offset // 8,), 0)
    layout = {"names": names, "formats": formats, "offsets": offsets, "itemsize": offset}
    return np.dtype((np.record, layout))
