"""Pseudo-random binary sequences, by maximum-length shift registers (section 10)."""

from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers

TAPS: Final = {  # bits of the register whose sum modulo 2 comes in: periods of 2^n - 1
    2: (2, 1),
    3: (3, 2),
    4: (4, 3),
    5: (5, 3),
    6: (6, 5),
    7: (7, 6),
    8: (8, 6, 5, 4),
    9: (9, 5),
    10: (10, 7),
    11: (11, 9),
    12: (12, 11, 10, 4),
}


def prbs(bits: int, seed: int = 1) -> Numbers:
    """Return one period, (2^bits - 1,), of -1 and 1; ``seed`` is what the register begins with.

    The register's own bits come out first, the highest first. ConfigError if the register is of
    no known length or begins empty.
    """
    if bits not in TAPS:
        raise ConfigError(f"register of {bits} bits: must be {min(TAPS)} to {max(TAPS)}")
    if not 1 <= seed < 2**bits:
        raise ConfigError(f"seed {seed}: a register of {bits} bits takes 1 to {2**bits - 1}")
    register = [(seed >> (bits - 1 - i)) & 1 for i in range(bits)]
    out = []
    for _ in range(2**bits - 1):
        out.append(register[0])
        register = [*register[1:], sum(register[bits - tap] for tap in TAPS[bits]) % 2]
    return 2.0 * np.array(out) - 1.0


def held(sequence: Numbers, amplitude: float, samples: int) -> Numbers:
    """Return the sequence times ``amplitude``, each bit held for some samples."""
    return np.repeat(amplitude * sequence, samples)


def autocorrelation(sequence: Numbers) -> Numbers:
    """Return the periodic autocorrelation, 1 at lag 0, for each lag of a period."""
    spectrum = np.abs(np.fft.fft(sequence)) ** 2
    own = np.fft.ifft(spectrum).real
    return np.asarray(own / own[0])
