"""The sea above the boat: what is ordered, how it comes about, and one tick of it.

A sea is a significant height, the frequency of its peak, the peakedness of its spectrum, where it
travels to and the generator that makes it; the state has each as it is and as it is ordered, and
``sea_ramp`` is the time in which they become the same. Both generators make an elevation of
variance 1; ``sea_cosines`` is the share of the variance that comes from the cosine sum.
"""

import math
from typing import Final

from trainer.core.elementary import exponential, logarithm
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.noise import SEA_FILTER, gaussian
from trainer.core.sea.cosine_sum import advance_sum, prepare_sum, sum_elevation
from trainer.core.sea.wave_filter import advance_filter, filter_noise, prepare_filter
from trainer.core.state import SEA_QUANTITIES

HEIGHT, OMEGA, GAMMA, DIRECTION, COSINES, SUCTION, TAPER = range(len(SEA_QUANTITIES) + 1)
TURN: Final = 6.283185307179586
WARM_UP: Final = 100.0  # [s] at least; two of the slowest section's time constants a period
WARM_UP_PERIODS: Final = 10.0


@kernel
def begin_sea(g: float, h: float, scratch: Record, state: Record) -> None:
    """Start both generators at random, as after a long time of the sea in force.

    The filter is run on the ticks before the first, until what it held at the
    start is forgotten.
    """
    s = state[0]
    prepare_filter(g, s.sea_omega, h, scratch)
    s.sea_turned = s.sea_along = s.sea_across = 0.0
    for i in range(s.sea_memory.size):
        s.sea_memory[i] = 0.0
    s.sea_drift = 0.0
    longest = max(WARM_UP, WARM_UP_PERIODS * TURN / s.sea_omega)
    for back in range(math.ceil(longest / h), 0, -1):
        tick = int(s.tick) - back
        filter_noise(scratch, gaussian(int(s.seed), SEA_FILTER, tick), state)


@kernel
def order_sea(
    vessel: Record, h: float, ramp: float, wanted: Numbers, scratch: Record, state: Record
) -> None:
    """Order the sea ``wanted``, SEA_QUANTITIES and the taper, to be in force after ``ramp`` [s].

    A height of 0 lets the present sea die away. From a calm the ordered sea rises as it is. The
    taper acts at once.
    """
    s = state[0]
    s.sea_taper = wanted[TAPER]
    for i in range(s.sea.size):
        s.sea_target[i] = wanted[i]
    if wanted[HEIGHT] == 0.0:
        for i in range(1, s.sea.size):
            s.sea_target[i] = s.sea[i]
    turns = math.floor((s.sea_target[DIRECTION] - s.sea_direction) / TURN + 0.5)
    if s.sea_height == 0.0 and wanted[HEIGHT] != 0.0:
        turns = 0
        for i in range(1, s.sea.size):
            s.sea[i] = wanted[i]
        begin_sea(vessel[0].g, h, scratch, state)
    s.sea_target[DIRECTION] -= TURN * turns
    s.sea_ramp = ramp
    if ramp <= 0.0:
        for i in range(s.sea.size):
            s.sea[i] = s.sea_target[i]


@part
def approach(h: float, state: Record) -> None:
    """Bring the sea in force ``h`` [s] nearer to the ordered one, the period by its logarithm."""
    s = state[0]
    if s.sea_ramp <= 0.0:
        return
    omega = s.sea_target[OMEGA]
    if s.sea_ramp <= h:
        s.sea_ramp = 0.0
        for i in range(s.sea_target.size):
            s.sea[i] = s.sea_target[i]
        return
    share = h / s.sea_ramp
    s.sea_ramp -= h
    if omega != s.sea_omega:
        omega = s.sea_omega * exponential(share * logarithm(omega / s.sea_omega))
    for i in range(s.sea_target.size):
        s.sea[i] += share * (s.sea_target[i] - s.sea[i])
    s.sea_omega = omega


@part
def advance_sea(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Advance the sea by one tick and write the elevation [m] above the boat.

    ``scratch`` is the boat's SEA record.
    """
    s = state[0]
    approach(h, state)
    if s.sea_height == 0.0:
        s.eta_wave = 0.0
        return
    unit = 0.0
    if s.sea_cosines < 1.0:
        g = vessel[0].g
        prepare_filter(g, s.sea_omega, h, scratch)
        advance_filter(scratch, h, state)
        unit += math.sqrt(1.0 - s.sea_cosines) * s.sea_elevation
    if s.sea_cosines > 0.0:
        prepare_sum(s.sea_gamma, s.seed, scratch)
        advance_sum(vessel, h, state)
        unit += math.sqrt(s.sea_cosines) * sum_elevation(scratch, state)
    s.eta_wave = 0.25 * s.sea_height * unit
