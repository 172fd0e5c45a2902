"""The sea above the boat: the ordered sea, its onset, and one tick of it.

A sea is a significant height, the frequency of its peak, the peakedness of its spectrum, the
direction in which it travels, and the generator that makes it. The state has each as it is and as
it is ordered, and ``sea_ramp`` is the time in which they become the same. Each generator makes an
elevation of variance 1. Three shares of the variance say how much comes from which: ``sea_cosines``
of all from the cosine sum, ``sea_1969`` of the rest from the filter of 1969, ``sea_peaked`` of what
is left from the peaked bank of the wave filter.
"""

import math
from typing import Final

from trainer.core.elementary import cosine_and_sine, exponential, logarithm
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.noise import SEA_FILTER, gaussian
from trainer.core.sea.cosine_sum import advance_sum, find_direction, prepare_sum, sum_elevation
from trainer.core.sea.filter_1969 import advance_filter, filter_noise, prepare_filter
from trainer.core.sea.wave_filter import advance_clock, begin_filter, read_outputs
from trainer.core.state import SEA_QUANTITIES

# indices of the SEA_QUANTITIES in an order, and of the taper after them
HEIGHT, OMEGA, GAMMA, DIRECTION, COSINES, SUCTION = range(6)
OLD, PEAKED, TAPER = range(6, len(SEA_QUANTITIES) + 1)
FULL_TURN: Final = 6.283185307179586
WARM_UP: Final = 100.0  # [s] at least; a period is two time constants of the slowest section
WARM_UP_PERIODS: Final = 10.0


@kernel
def begin_sea(g: float, h: float, scratch: Record, state: Record) -> None:
    """Start all generators at random, as after a long time of the sea in force.

    The filters are run on the steps before the first one, until they have forgotten how they
    started.
    """
    s = state[0]
    prepare_filter(g, s.sea_omega, h, scratch)
    s.sea_turned = s.sea_along = s.sea_across = 0.0
    for i in range(s.sea_memory.size):
        s.sea_memory[i] = 0.0
    s.sea_drift = 0.0
    longest = max(WARM_UP, WARM_UP_PERIODS * FULL_TURN / s.sea_omega)
    for back in range(math.ceil(longest / h), 0, -1):
        tick = int(s.tick) - back
        filter_noise(scratch, gaussian(int(s.seed), SEA_FILTER, tick), state)
    begin_filter(s.sea_omega * s.sea_omega / g * max(s.z, 0.0), scratch, state)


@kernel
def order_sea(
    vessel: Record, h: float, ramp: float, wanted: Numbers, scratch: Record, state: Record
) -> None:
    """Order the sea ``wanted`` to be in force after ``ramp`` [s].

    It has the SEA_QUANTITIES and the taper. A height of 0 makes the present sea die away. From a
    calm the ordered sea rises as it is. The taper acts at once.
    """
    s = state[0]
    s.sea_taper = wanted[TAPER]
    for i in range(s.sea.size):
        s.sea_target[i] = wanted[i]
    if wanted[HEIGHT] == 0.0:
        for i in range(1, s.sea.size):
            s.sea_target[i] = s.sea[i]
    turns = math.floor((s.sea_target[DIRECTION] - s.sea_direction) / FULL_TURN + 0.5)
    if s.sea_height == 0.0 and wanted[HEIGHT] != 0.0:
        turns = 0
        for i in range(1, s.sea.size):
            s.sea[i] = wanted[i]
        begin_sea(vessel[0].g, h, scratch, state)
    s.sea_target[DIRECTION] -= FULL_TURN * turns
    s.sea_ramp = ramp
    if ramp <= 0.0:
        for i in range(s.sea.size):
            s.sea[i] = s.sea_target[i]


@inline_kernel
def approach(h: float, state: Record) -> None:
    """Bring the sea in force ``h`` [s] nearer to the ordered one.

    The period changes by its logarithm.
    """
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


@inline_kernel
def wrap_angle(angle: float) -> float:
    """Return ``angle`` [rad] less the whole turns, from -pi to pi."""
    return angle - 6.283185307179586 * math.floor(angle * 0.15915494309189535 + 0.5)


@inline_kernel
def advance_filters(g: float, h: float, scratch: Record, state: Record) -> None:
    """Advance the filters in use by one tick.

    The boat's way turns their outputs.
    """
    s = state[0]
    number = s.sea_omega * s.sea_omega / g
    north, east = scratch[0].toward_north, scratch[0].toward_east
    run = h * (s.through_north * north + s.through_east * east)
    s.sea_drift = wrap_angle(s.sea_drift + number * run)
    turn_cos, turn_sin = cosine_and_sine(s.sea_drift)
    if s.sea_1969 > 0.0:
        prepare_filter(g, s.sea_omega, h, scratch)
        advance_filter(scratch, turn_cos, turn_sin, state)
    if s.sea_1969 < 1.0:
        advance_clock(number, run, h, scratch, state)
        read_outputs(turn_cos, turn_sin, state)


@inline_kernel
def filtered(state: Record) -> float:
    """Return the filters' elevation [-] above the boat, of variance 1."""
    s = state[0]
    unit = 0.0
    if s.sea_1969 > 0.0:
        unit += math.sqrt(s.sea_1969) * s.sea_elevation
    if s.sea_1969 < 1.0:
        unit += math.sqrt(1.0 - s.sea_1969) * s.wave_cos
    return unit


@inline_kernel
def advance_sea(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Advance the sea by one tick and write the elevation [m] above the boat.

    ``scratch`` is the boat's SEA record.
    """
    s = state[0]
    approach(h, state)
    if s.sea_height == 0.0:
        s.eta_wave = 0.0
        return
    find_direction(scratch, state)
    unit = 0.0
    if s.sea_cosines < 1.0:
        advance_filters(vessel[0].g, h, scratch, state)
        unit += math.sqrt(1.0 - s.sea_cosines) * filtered(state)
    if s.sea_cosines > 0.0:
        prepare_sum(s.sea_gamma, s.seed, scratch)
        advance_sum(vessel, h, scratch, state)
        unit += math.sqrt(s.sea_cosines) * sum_elevation(scratch, state)
    s.eta_wave = 0.25 * s.sea_height * unit


@kernel
def write_elevations(
    vessel: Record, h: float, scratch: Record, state: Record, out: Numbers
) -> None:
    """Advance the sea, and nothing else, tick by tick; write the elevations [m].

    ``analysis/seaway`` compares their spectrum with the ordered one.
    """
    s = state[0]
    for i in range(out.size):
        advance_sea(vessel, h, scratch, state)
        s.tick += 1.0
        out[i] = s.eta_wave
