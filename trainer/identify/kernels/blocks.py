"""Parts of arrays written entry by entry.

An assignment to a slice does the same, but the compiler takes half a second for each.
"""

from trainer.identify.kernels.kernel import Entries, part


@part
def put(source: Entries, at: int, out: Entries) -> None:
    """Write the one-dimensional ``source`` to ``out`` from the place ``at`` on."""
    for i in range(source.size):
        out[at + i] = source[i]


@part
def put_block(source: Entries, at: int, out: Entries) -> None:
    """Write the two-dimensional ``source`` to ``out`` from the column ``at`` on."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, at + j] = source[i, j]


@part
def clear(out: Entries) -> None:
    """Write zeros."""
    for i in range(out.size):
        out.flat[i] = 0.0
