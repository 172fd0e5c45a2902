"""What kernels of identification work on."""

from typing import Any

from numpy.typing import NDArray

Entries = NDArray[Any]  # numbers, or complex ones whose imaginary parts are derivatives
