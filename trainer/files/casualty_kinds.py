"""What the severity of each kind of casualty is, and within which limits."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.core.casualties import GAUGES, KINDS, SURFACES
from trainer.core.state import VALVES
from trainer.files.schema import Limits, above, within
from trainer.units import KNOT

SHARE: Final = above(0, 1)
SWITCH: Final = within(1, 1)  # there or not, at once
SIDE: Final = within(-1, 1)
TIMES: Final = above(0, 10)
SIGNED_TIMES: Final = within(-10, 10)


@dataclass(frozen=True)
class Measure:
    """What the severity of a kind is."""

    limits: Limits
    meaning: str
    parameter: str = ""  # key of what severity 1 is
    factor: float = 1.0  # [SI] of the parameter's unit

    @property
    def sudden(self) -> bool:
        """Return whether it is there or not, so that it has neither degrees nor ramps."""
        return self.limits == SWITCH


def _measures() -> dict[str, Measure]:
    """Return the measure of each kind."""
    stuck = Measure(SWITCH, "none: held as it stood")
    taken = Measure(SHARE, "share of the rate lost")
    found = {
        "propulsion-lost": Measure(SHARE, "share of turns lost"),
        "propulsion-stuck": stuck,
        "autopilot-failed": Measure(SWITCH, "none: its commands stay"),
    }
    for surface in SURFACES:
        side = "right" if surface == "rudder" else "rise"
        found |= {
            f"{surface}-slow": taken,
            f"{surface}-follow-up-lost": Measure(SWITCH, "none: on or off"),
            f"{surface}-free": Measure(SHARE, "share of its rate"),
            f"{surface}-hard-over": Measure(SIDE, f"of its limit, + {side}"),
            f"{surface}-stuck": stuck,
        }
    units = (("m", 1.0), ("deg", math.radians(1.0)), ("kn", KNOT))
    for gauge, (unit, factor) in zip(GAUGES, units, strict=True):
        found |= {
            f"{gauge}-noisy": Measure(TIMES, f"times noise_{unit}", f"noise_{unit}", factor),
            f"{gauge}-biased": Measure(SIGNED_TIMES, f"times bias_{unit}", f"bias_{unit}", factor),
            f"{gauge}-stuck": stuck,
        }
    hole = Measure(TIMES, "times hole_m2", "hole_m2")
    starts = {
        **dict.fromkeys(("leak-", "flooding-"), hole),
        **dict.fromkeys(("pump-", "bank-"), taken),
        "blow-": Measure(SHARE, "share of the opening lost"),
        "vent-": Measure(SHARE, "share of the opening lost"),
    }
    for name in KINDS:
        for start, measure in starts.items():
            if name.startswith(start):
                found[name] = measure
    for valve in VALVES:
        found[f"vent-{valve}-open"] = Measure(SHARE, "opening it is stuck at")
    return found


MEASURES: Final[Mapping[str, Measure]] = _measures()


def severity_rule(kind: str) -> str:
    """Return what the severity of a kind must be, in words."""
    measure = MEASURES[kind]
    if measure.sudden:
        return f"{kind} has no degrees: its severity is 1"
    return f"must be {measure.limits} for {kind} ({measure.meaning})"
