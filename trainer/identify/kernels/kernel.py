"""What every kernel of identification is compiled with: as the core's, but they may allocate.

A fit is over whole records of any length; its kernels make their own scratch, and so count
references. What is lean makes nothing and counts none, nor does a part, whose machine code is put
into its callers'. Where kernels are interpreted (``first_fit``) a part's loops may be left to
another function, which does the same by whole arrays.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from numba import njit

from trainer import compilation
from trainer import machine_code as _machine_code  # noqa: F401 (numba is told its folder)

if TYPE_CHECKING:  # the options are numba's own, though not in its published signature
    kernel = lean = part = njit(cache=True, error_model="numpy")
else:
    kernel = njit(cache=True, error_model="numpy")
    lean = njit(cache=True, error_model="numpy", _nrt=False)
    part = njit(error_model="numpy", _nrt=False, forceinline=True)


def part_or(at_once: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return what makes a part of loops, or ``at_once`` in its place where they are interpreted."""

    def decorated(loops: Callable[..., Any]) -> Callable[..., Any]:
        return at_once if compilation.done_without() else part(loops)

    return decorated
