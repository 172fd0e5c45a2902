"""The options with which every kernel of identification is compiled.

There are three kinds. A ``kernel`` may allocate, unlike those of the core, because a fit is over
whole records of any length and makes its own scratch; so it counts references. A ``lean_kernel``
allocates nothing and counts no references, which is faster. An ``inline_kernel`` is lean too, and
the compiler puts its code into that of its callers.
"""

from collections import namedtuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import LEAN_OPTIONS, compiled_with

kernel = compiled_with(cache=True, error_model="numpy")
lean_kernel = compiled_with(cache=True, error_model="numpy", **LEAN_OPTIONS)
inline_kernel = compiled_with(error_model="numpy", forceinline=True, **LEAN_OPTIONS)


Complexes = NDArray[np.complex128]
Entries = NDArray[Any]  # numbers, or complex ones whose imaginary parts are derivatives


def indices(names: str) -> Any:
    """Return the indices of numbers that are passed in one row, each by its name.

    Kernels take a ship's numbers as one array; ``ship[BENT.K]`` is then readable.
    """
    fields = names.split()
    return namedtuple("Indices", fields)(*range(len(fields)))  # noqa: PYI024 its fields are data


# arrays are copied entry by entry, because for each slice the compiler takes half a second


@inline_kernel
def put_vector(source: Entries, at: int, out: Entries) -> None:
    """Write the one-dimensional ``source`` to ``out`` from the index ``at`` on."""
    for i in range(source.size):
        out[at + i] = source[i]


@inline_kernel
def put_block(source: Entries, at: int, out: Entries) -> None:
    """Write the two-dimensional ``source`` to ``out`` from the column ``at`` on."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, at + j] = source[i, j]


@inline_kernel
def clear_array(out: Entries) -> None:
    """Write zeros to all of ``out``."""
    for i in range(out.size):
        out.flat[i] = 0.0
