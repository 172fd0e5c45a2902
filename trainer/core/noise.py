"""Random numbers as a pure function of (seed, stream, tick).

There is no state, and the order of calls does not matter. Threefry-2x32 with 20 rounds: J. Salmon,
M. Moraes, R. Dror, D. Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11 (2011), section 4.2
and Table 2. The key is the seed, high half first. The counter is (tick, stream), each taken modulo
2^32, so that ticks may be negative. Words are kept in 64-bit integers and masked, so that Python's
own integers give the same bits. So a replay, or a run resumed in its middle, draws the same
numbers.
"""

import math
from typing import Final

from trainer.core.elementary import cosine_and_sine_of_any, cosine_of_size, logarithm_of_positive
from trainer.core.kernel import inline_kernel

WORD_MASK = 0xFFFFFFFF
KEY_PARITY = 0x1BD11BDA
ODD_TURNS, EVEN_TURNS = (13, 15, 26, 6), (17, 29, 16, 24)  # [bits] of four rounds, in turn

# Streams. Each user of randomness has its own.
SEA_FILTER: Final = 1
SEA_PHASE: Final = 2
SEA_FREQUENCY: Final = 3
GAUGE_NOISE: Final = 4  # and the next two
SEA_BANK: Final = 7  # of the standard spectrum, and the next of the peaked one
SOUNDER_NOISE: Final = 9


@inline_kernel
def _round(x: int, y: int, turn: int) -> tuple[int, int]:
    """Return two words [-] after a round."""
    x = (x + y) & WORD_MASK
    return x, (((y << turn) | (y >> (32 - turn))) & WORD_MASK) ^ x


@inline_kernel
def _four_rounds(
    x: int, y: int, turns: tuple[int, int, int, int], first: int, second: int
) -> tuple[int, int]:
    """Return two words [-] after four rounds and two words of the key."""
    turn_1, turn_2, turn_3, turn_4 = turns
    x, y = _round(x, y, turn_1)
    x, y = _round(x, y, turn_2)
    x, y = _round(x, y, turn_3)
    x, y = _round(x, y, turn_4)
    return (x + first) & WORD_MASK, (y + second) & WORD_MASK


@inline_kernel
def threefry(key_0: int, key_1: int, counter_0: int, counter_1: int) -> tuple[int, int]:
    """Return two random 32-bit words [-].

    The rounds are written out, because a turn by a constant is one instruction.
    """
    x, y = (counter_0 + key_0) & WORD_MASK, (counter_1 + key_1) & WORD_MASK
    parity = KEY_PARITY ^ key_0 ^ key_1
    x, y = _four_rounds(x, y, ODD_TURNS, key_1, parity + 1)
    x, y = _four_rounds(x, y, EVEN_TURNS, parity, key_0 + 2)
    x, y = _four_rounds(x, y, ODD_TURNS, key_0, key_1 + 3)
    x, y = _four_rounds(x, y, EVEN_TURNS, key_1, parity + 4)
    return _four_rounds(x, y, ODD_TURNS, parity, key_0 + 5)


@inline_kernel
def _words(seed: int, stream: int, tick: int) -> tuple[int, int]:
    """Return the two random 32-bit words [-] of a seed, a stream and a tick."""
    return threefry(
        (seed >> 32) & WORD_MASK, seed & WORD_MASK, tick & WORD_MASK, stream & WORD_MASK
    )


@inline_kernel
def uniform(seed: int, stream: int, tick: int) -> float:
    """Return a number [-] between 0 and 1 in steps of 2^-52.

    The ends are never reached.
    """
    x, y = _words(seed, stream, tick)
    return ((x >> 6) * 67108864.0 + (y >> 6) + 0.5) * 2.220446049250313e-16


@inline_kernel
def gaussian(seed: int, stream: int, tick: int) -> float:
    """Return a normal deviate [-] of mean 0 and variance 1.

    It is at most 6.8 in size. G. Box & M. Muller, Ann. Math. Stat. 29 (1958) 610; the sine of the
    pair is not used.
    """
    x, y = _words(seed, stream, tick)
    radius = math.sqrt(-2.0 * logarithm_of_positive((x + 0.5) * 2.3283064365386963e-10))
    return radius * cosine_of_size(y * 1.4629180792671596e-09)


@inline_kernel
def gaussian_pair(seed: int, stream: int, tick: int) -> tuple[float, float]:
    """Return the deviate of ``gaussian`` [-] and the other of its pair, which is independent."""
    x, y = _words(seed, stream, tick)
    radius = math.sqrt(-2.0 * logarithm_of_positive((x + 0.5) * 2.3283064365386963e-10))
    even, odd = cosine_and_sine_of_any(y * 1.4629180792671596e-09)
    return radius * even, radius * odd
