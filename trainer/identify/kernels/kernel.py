"""The options with which every kernel of identification is compiled.

They are those of the core, but these kernels may allocate. A fit is over whole records of any
length; its kernels make their own scratch, and so count references. A lean kernel makes nothing and
counts none. Nor does a part, whose machine code is put into that of its callers.
"""

from typing import TYPE_CHECKING, Any

from numba import njit
from numpy.typing import NDArray

from trainer.core.kernel import LEAN

if TYPE_CHECKING:  # numba's published signature lacks some of its options
    kernel = lean = part = njit(cache=True, error_model="numpy")
else:
    kernel = njit(cache=True, error_model="numpy")
    lean = njit(cache=True, error_model="numpy", **LEAN)
    part = njit(error_model="numpy", forceinline=True, **LEAN)


Entries = NDArray[Any]  # numbers, or complex ones whose imaginary parts are derivatives
