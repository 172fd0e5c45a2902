"""What the instruments of a station read: depth, heading and speed through their casualties.

Only stations see this. The autopilot steers by the truth, and the instructor is shown it.
"""

from trainer.core.casualties import (
    BIASED,
    FIRST_GAUGE,
    GAUGE_FAULTS,
    GAUGE_STUCK,
    NOISY,
    slot_of,
)
from trainer.core.kernel import Record, kernel
from trainer.core.noise import GAUGES, gaussian

DEPTH_GAUGE, GYRO, LOG = 0, 1, 2


@kernel
def shown(gauge: int, state: Record) -> float:
    """Return depth [m], heading [rad] or speed [m/s], with the bias of its gauge."""
    s = state[0]
    value = s.z
    if gauge == GYRO:
        value = s.psi
    elif gauge == LOG:
        value = s.u
    slot = slot_of(FIRST_GAUGE + gauge * len(GAUGE_FAULTS) + BIASED, state)
    return value + s.casualty_amount[slot] if slot >= 0 else value


@kernel
def reading(gauge: int, state: Record) -> float:
    """Return what a gauge reads [m, rad or m/s]: stuck, or biased and noisy."""
    s = state[0]
    first = FIRST_GAUGE + gauge * len(GAUGE_FAULTS)
    slot = slot_of(first + GAUGE_STUCK, state)
    if slot >= 0:
        return s.casualty_amount[slot]
    value = shown(gauge, state)
    slot = slot_of(first + NOISY, state)
    if slot >= 0:
        value += s.casualty_amount[slot] * gaussian(int(s.seed), GAUGES + gauge, int(s.tick))
    return value


@kernel
def instruments(state: Record, scratch: Record) -> None:
    """Write what depth gauge [m], gyro [rad] and log [m/s] read at this tick."""
    for gauge in range(3):
        scratch[0].reading[gauge] = reading(gauge, state)
