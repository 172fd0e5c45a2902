"""How a casualty begins and is cleared, by an order or by a trigger."""

from trainer.core.casualties import (
    FIRST_GAUGE,
    GAUGE_FAULTS,
    GAUGE_STUCK,
    HARD_OVER,
    PROPULSION_STUCK,
    STUCK,
    SURFACE_FAULTS,
    SURFACES,
    slot_of,
)
from trainer.core.instruments import shown
from trainer.core.kernel import Record, kernel

SURFACE_KINDS = len(SURFACES) * len(SURFACE_FAULTS)


@kernel
def is_stuck(kind: int) -> bool:
    """Return whether a casualty holds what it finds, whatever amount it is given."""
    if kind <= SURFACE_KINDS:
        return (kind - 1) % len(SURFACE_FAULTS) == STUCK
    if kind >= FIRST_GAUGE:
        return (kind - FIRST_GAUGE) % len(GAUGE_FAULTS) == GAUGE_STUCK
    return kind == PROPULSION_STUCK


@kernel
def onset(kind: int, state: Record) -> float:
    """Return the amount [SI] from which a casualty sets out: what it holds or drives as it stands.

    A stuck gauge holds its bias with it.
    """
    s = state[0]
    if kind <= SURFACE_KINDS and (kind - 1) % len(SURFACE_FAULTS) >= HARD_OVER:
        return s.surface[(kind - 1) // len(SURFACE_FAULTS)]
    if kind == PROPULSION_STUCK:
        return s.u_c
    if kind >= FIRST_GAUGE and is_stuck(kind):
        return shown((kind - FIRST_GAUGE) // len(GAUGE_FAULTS), state)
    return 0.0


@kernel
def begin(kind: int, amount: float, ticks: float, state: Record) -> int:
    """Let a casualty run to ``amount`` [SI] within ``ticks``; return 1, or 0 if no slot is free.

    One that is there already goes on from where it is; what is stuck stays as it stuck.
    """
    s = state[0]
    slot = slot_of(kind, state)
    if slot < 0:
        slot = slot_of(0, state)
        if slot < 0:
            return 0
        s.casualty[slot] = kind
        s.casualty_amount[slot] = onset(kind, state)
    s.casualty_ticks[slot] = ticks
    s.casualty_target[slot] = amount
    if is_stuck(kind):
        s.casualty_ticks[slot] = 0.0
        s.casualty_target[slot] = s.casualty_amount[slot]
    elif ticks == 0.0:
        s.casualty_amount[slot] = amount
    return 1


@kernel
def end(kind: int, ticks: float, state: Record) -> int:
    """Let a casualty go back to nothing within ``ticks``; return 1, or 0 if there is none."""
    s = state[0]
    slot = slot_of(kind, state)
    if slot < 0:
        return 0
    s.casualty_ticks[slot] = -1.0 if is_stuck(kind) else -max(ticks, 1.0)
    return 1
