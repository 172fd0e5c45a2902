"""Which boats can be computed side by side: in calm deep water, with sound gear and tanks at rest.

Whether the water is deep enough is seen at every tick, by ``abreast``.
"""

from typing import Final

from trainer.core.air import at_work
from trainer.core.autopilot import OWN
from trainer.core.ballast import advance_ballast
from trainer.core.kernel import Record, kernel
from trainer.core.scheme import ADAMS
from trainer.core.scheme import COMPACT as COMPACT_SET
from trainer.core.state import HISTORY
from trainer.core.tanks import END, NEGATIVE, TRIM_FORWARD

TERMS = 2  # of Adams' method
KNOWN: Final = {"depth_law": float(OWN)}  # of the state


@kernel
def follows(scheme: Record) -> bool:
    """Return whether boats are computed as they are here."""
    how = scheme[0]
    lagged_compact = how.equations == COMPACT_SET and how.exact == 0
    two_terms = how.method == ADAMS and how.depth == TERMS
    return lagged_compact and two_terms and how.trigger_kind[0] == 0.0


@kernel
def tanks_rest(vessel: Record, state: Record) -> bool:
    """Return whether no water and no air can move."""
    c = vessel[0]
    s = state[0]
    if c.fitted == 0.0:
        return True
    if s.hover > 0.0 or s.drained > 0.0 or s.compressor > 0.0:
        return False
    for i in range(s.to_move.size):
        if s.to_move[i] != 0.0:
            return False
    for i in range(END - TRIM_FORWARD):
        if s.breach[i] > 0.0:
            return False
    at_rest = True
    for i in range(NEGATIVE + 1):
        at_rest = at_rest and not at_work(vessel, i, state)
    return at_rest


@kernel
def ordinary(vessel: Record, state: Record) -> bool:
    """Return whether a boat is one that is computed here, as long as it stays deep."""
    c = vessel[0]
    s = state[0]
    constant_buoyancy = c.compressibility == 0.0 and c.layers == 0.0
    calm = s.sea_height == 0.0 and s.sea_ramp <= 0.0
    free = s.held_depth == 0.0 and s.held_position == 0.0 and s.held_tanks == 0.0
    sound = s.casualty[0] == 0.0 and s.depth_law == OWN
    return constant_buoyancy and calm and free and sound and tanks_rest(vessel, state)


@kernel
def under_way(state: Record) -> bool:
    """Return whether the past of the integration is that of this very flight."""
    s = state[0]
    return s.history == HISTORY and s.x == s.sailed_x and s.y == s.sailed_y


@kernel
def make_ready(vessel: Record, h: float, state: Record) -> None:
    """Write what every tick of an ordinary boat writes alike."""
    advance_ballast(vessel, vessel, h, state)
    state[0].eta_wave = 0.0
