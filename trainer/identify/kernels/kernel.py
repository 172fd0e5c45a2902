"""What every kernel of identification is compiled with: as the core's, but they may allocate.

A fit is over whole records of any length; its kernels make their own scratch, and so count
references. What is lean makes nothing and counts none, nor does a part, whose machine code is put
into its callers'.
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
