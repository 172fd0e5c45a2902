"""The planesman in waves: it counts them, and leaves their own band alone.

Nobody tells the pilot the sea. The depth rate, less its slow part, shows by its strength that there
are waves. Its crossings of zero show how often the boat meets one, within 7 % of the peak where it
matters. Pitch would show it up to 27 % too often. In waves the law of each pair, without the
integral, passes two notches at 0.8 and 1.25 of the frequency met,

    N(s) = (s^2 + 0.2 w s + w^2)/(s^2 + 0.8 w s + w^2),    bilinear, c = tan(w h/2).

The nearer that frequency is to the loop's own, w_c = |M_ds| u^2 |K_q|/(I_y - M_qdot), the softer is
the law; from LEAST_RATIO down it is that of a calm. Laws, gains and times are this project's own,
flown on BB2; the times and the threshold are estimates. docs/autopilot.md has what they reach, and
what failed.
"""

from typing import Final

from trainer.core.autopilot.sections import OUTPUT, SECTION_SIZE, notch, pass_section, section_in
from trainer.core.autopilot.steering import STERN, first_gain
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.state import SECTION_NUMBERS
from trainer.core.vessel import PITCH_RATE_GAIN, STERN_GAINS

SLOW_FREQUENCY: Final = 0.3  # [rad/s] slower motion is the boat's own
WAVE_MEMORY_S: Final = 60.0  # [s] over which the strength of the waves is averaged
FELT_DEPTH_RATE: Final = 0.013  # [m/s] depth rate, rms, from which there are waves
MAX_QUIET_PERIODS: Final = 3.0  # [periods] without a crossing, after which there are no waves
FADE_TIME_S: Final = 30.0  # [s] in which the law changes over
AVERAGED_WAVES: Final = 12.0  # [-] waves over which the time between them is averaged
MIN_CROSSING_S: Final = 1.5  # [s] between two crossings that count
LOWER_NOTCH, UPPER_NOTCH = 0.8, 1.25  # [-] of the frequency met, where the notches are
ZERO_DAMPING, POLE_DAMPING = 0.1, 0.4  # [-] damping ratios of the notches
NOTCH_SIZE: Final = 2 * SECTION_SIZE  # numbers of a pair's notches in the state
LOWER, UPPER = 0, SECTION_SIZE  # their indices: the notch below the frequency met, and that above
# by the frequency met over the loop's own: limits, then gains above, between and below them
FREQUENCY_LIMITS: Final = (2.0, 1.2)
SOFT_GAINS: Final = (1.0, 0.7, 0.5)  # [-] on depth, its rate and pitch
PITCH_RATE_GAINS: Final = (1.0, 0.85, 0.7)  # [-] on the pitch rate
INTEGRAL_GAINS: Final = (1.5, 0.7, 0.5)  # [-] on the integral
LEAST_RATIO: Final = 1.1  # [-] frequency met over the loop's own, up to which nothing is changed
LIMIT_BLEND: Final = 0.1  # [-] of a limit, either way, over which the gains change


@inline_kernel
def count(h: float, band: float, state: Record) -> None:
    """Count an upward crossing of zero by ``band`` [m/s].

    Average the time between such crossings.
    """
    s = state[0]
    s.wave_since += h
    if s.wave_band < 0.0 <= band and s.wave_since >= MIN_CROSSING_S:
        if s.wave_count > 0.0:
            s.wave_period += (s.wave_since - s.wave_period) / s.wave_count
        s.wave_count = min(s.wave_count + 1.0, AVERAGED_WAVES)
        s.wave_since = 0.0


@inline_kernel
def are_counted(state: Record) -> bool:
    """Return whether enough waves came by lately for their period to be known."""
    s = state[0]
    return s.wave_count >= AVERAGED_WAVES and s.wave_since < MAX_QUIET_PERIODS * s.wave_period


@inline_kernel
def are_felt(state: Record) -> bool:
    """Return whether waves move the boat."""
    return state[0].wave_power > FELT_DEPTH_RATE * FELT_DEPTH_RATE


@inline_kernel
def frequency_met(state: Record) -> float:
    """Return the frequency [rad/s] at which the boat meets waves, as counted."""
    return 6.283185307179586 / state[0].wave_period


@inline_kernel
def between_limits(ratio: float, factor: tuple[float, float, float]) -> float:
    """Return a factor [-] on a gain, between its values at the limits.

    ``ratio`` [-] is the frequency met over the loop's own.
    """
    high, low = FREQUENCY_LIMITS
    above, between, below = factor
    upper = (ratio / high - 1.0 + LIMIT_BLEND) / (2.0 * LIMIT_BLEND)
    lower = (ratio / low - 1.0 + LIMIT_BLEND) / (2.0 * LIMIT_BLEND)
    rise = min(max(upper, 0.0), 1.0) * (above - between)
    return below + min(max(lower, 0.0), 1.0) * (between - below) + rise


@inline_kernel
def frequency_ratio(vessel: Record, gains: Numbers, state: Record) -> float:
    """Return the frequency met over the loop's own [-]."""
    c = vessel[0]
    s = state[0]
    pace = abs(c.M_ds) * s.u * s.u * abs(gains[STERN_GAINS + PITCH_RATE_GAIN]) / (c.I_y - c.M_qdot)
    return frequency_met(state) / max(pace, 1e-6)


@inline_kernel
def sense_waves(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Follow for ``h`` [s] what the depth rate shows of waves.

    In a calm there is nothing to follow. Where the loop itself is as fast as the waves it is left
    as it is: softened about its own frequency it would swing by itself, and take that for waves.
    """
    s = state[0]
    if s.sea_height == 0.0 and s.wave_share == 0.0:
        s.wave_count = s.wave_power = 0.0
        return
    s.wave_slow += h * SLOW_FREQUENCY / (1.0 + h * SLOW_FREQUENCY) * (s.zdot - s.wave_slow)
    band = s.zdot - s.wave_slow
    count(h, band, state)
    s.wave_band = band
    s.wave_power += h / (WAVE_MEMORY_S + h) * (band * band - s.wave_power)
    there = are_felt(state) and are_counted(state)
    there = there and frequency_ratio(vessel, gains, state) > LEAST_RATIO
    step = h / FADE_TIME_S if there else -h / FADE_TIME_S
    s.wave_share = min(max(s.wave_share + step, 0.0), 1.0)


@kernel
def write_notches(h: float, scratch: Record, state: Record) -> None:
    """Write both notches at the waves that are met, for a step ``h`` [s]."""
    work = scratch[0]
    work.notch_period, work.notch_h = state[0].wave_period, h
    omega = frequency_met(state)
    lower = notch(LOWER_NOTCH * omega, h, ZERO_DAMPING, POLE_DAMPING)
    upper = notch(UPPER_NOTCH * omega, h, ZERO_DAMPING, POLE_DAMPING)
    for i in range(SECTION_NUMBERS):
        work.lower_notch[i], work.upper_notch[i] = lower[i], upper[i]


@inline_kernel
def soften(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Write factors [-] and notches for the waves that are felt, if there are any.

    The notches change with the period met, so at a crossing only. Most ticks find them made.
    """
    s, work = state[0], scratch[0]
    if s.wave_share == 0.0:
        return
    if work.notch_period != s.wave_period or work.notch_h != h:
        write_notches(h, scratch, state)
    ratio = frequency_ratio(vessel, work.gains, state)
    work.law_factor = between_limits(ratio, SOFT_GAINS)
    work.pitch_rate_factor = between_limits(ratio, PITCH_RATE_GAINS)
    work.learning = 1.0 + s.wave_share * (between_limits(ratio, INTEGRAL_GAINS) - 1.0)


@inline_kernel
def pass_notches(h: float, scratch: Record, state: Record, surface: int, law: float) -> None:
    """Pass the softened ``law`` [rad] of a pair through its notches.

    The notches lie at the waves that are felt.
    """
    s, work = state[0], scratch[0]
    if s.wave_share == 0.0:
        return
    first = NOTCH_SIZE * (surface - STERN)
    damping = work.gains[first_gain(surface) + PITCH_RATE_GAIN] * s.q
    x = work.law_factor * (law - damping) + work.pitch_rate_factor * damping
    fresh = s.wave_share <= h / FADE_TIME_S
    pass_section(section_in(work.lower_notch), x, fresh, first + LOWER, s.notch)
    x = s.notch[first + LOWER + OUTPUT]
    pass_section(section_in(work.upper_notch), x, fresh, first + UPPER, s.notch)


@inline_kernel
def law_in_waves(state: Record, surface: int, law: float) -> float:
    """Return the angle [rad] that ``law`` [rad] becomes in the waves that are felt."""
    s = state[0]
    if s.wave_share == 0.0:
        return law
    past = s.notch[NOTCH_SIZE * (surface - STERN) + UPPER + OUTPUT]
    return law + s.wave_share * (past - law)


@inline_kernel
def learning_in_waves(scratch: Record, state: Record) -> float:
    """Return the factor [-] on what the integrals learn in the waves that are felt."""
    return 1.0 if state[0].wave_share == 0.0 else float(scratch[0].learning)
