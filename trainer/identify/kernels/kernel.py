"""What every kernel of identification is compiled with: as the core's, but they may allocate.

A fit is over whole records of any length; its kernels make their own scratch, and so count
references.
"""

from numba import njit

from trainer import machine_code as _machine_code  # noqa: F401 (numba is told its folder)

kernel = njit(cache=True, error_model="numpy")
