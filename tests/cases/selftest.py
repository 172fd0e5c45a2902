"""The acceptance tests of identification by one command: simulate, identify, compare with ranges.

No recorded data of 1974 survive: each test simulates a ship of the report and is passed where the
estimates lie in the range of many such records.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple

import numpy as np

from cases.decca import by_lanes
from cases.ships import PROOFS, bent_hull
from trainer.core.kernel import Numbers
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.fitting.armax import Armax, fit_armax, without_wind

RUNS: Final = 40
# (6.3); its C is so that the deviations are those found from it
SONG: Final = Armax((-1.60, 0.61), (-0.161, -0.285), (-0.4, 0.05), (0.0, 0.0))
SONG_INTERVAL, SONG_SAMPLES, SONG_LOSS = 15.0, 80, 17.96  # [s], [-], V


class Outcome(NamedTuple):
    """One number of a test, and the range it must lie in."""

    test: str
    quantity: str
    low: float
    value: float
    high: float

    @property
    def passed(self) -> bool:
        """Return whether the number lies in its range."""
        return self.low <= self.value <= self.high

    def __str__(self) -> str:
        word = "ok  " if self.passed else "FAIL"
        bounds = f"{self.low:g} <= {self.value:.5g} <= {self.high:g}"
        return f"{word} {self.test:4} {self.quantity:28} {bounds}"


def atlantic_song() -> Iterator[Outcome]:
    """Yield S1: ARMAX of order 2 with initial states from 80 samples at 15 s."""
    deviation = np.sqrt(2.0 * SONG_LOSS / SONG_SAMPLES)
    u = np.tile(hold_bits(prbs(6), 5.0, 1), 2)[:SONG_SAMPLES]
    known, ships = [], []
    for seed in range(RUNS):
        stream = np.random.Generator(np.random.PCG64(seed))
        y = SONG.simulated(u, deviation * stream.standard_normal(SONG_SAMPLES))
        fit = fit_armax(y, u, 2)
        known.append(fit.deviations[:6])
        ships.append(without_wind(fit.model, SONG_INTERVAL)[:2])
    printed = np.array([0.03, 0.03, 0.014, 0.016, 0.14, 0.11])
    yield from _within(fit.names, np.mean(known, axis=0), printed)
    K, T = np.median(ships, axis=0)
    yield Outcome("S1", "K [1/s]", -0.079, float(K), -0.069)
    yield Outcome("S1", "T [s]", 26.0, float(T), 32.0)


def _within(names: tuple[str, ...], found: Numbers, printed: Numbers) -> Iterator[Outcome]:
    """Yield mean standard deviations, within 40 % of the printed ones."""
    for name, value, sd in zip(names, found, printed, strict=False):
        yield Outcome("S1", f"mean std dev of {name}", 0.6 * sd, float(value), 1.4 * sd)


def run_selftest(tell: Callable[[str], None]) -> bool:
    """Tell each outcome; return whether all lie in their ranges."""
    passed = True
    tests: list[Callable[[], Iterator[tuple[Any, ...]]]] = [
        atlantic_song,
        *PROOFS,
        bent_hull,
        by_lanes,
    ]
    for test in tests:
        begin = time.monotonic()
        for figure in test():
            outcome = Outcome(*figure)
            tell(str(outcome))
            passed = passed and outcome.passed
        tell(f"     {time.monotonic() - begin:.1f} s: {(test.__doc__ or '').split(':')[0][6:]}")
    return passed
