"""A boat's own tanks in program EC430: its balance as filled, and all that fillings can make of it.

A flooded compartment is one more tank. Surfaces of the water in a tank are not counted.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError, nearest, shown
from trainer.files.vessel_file import VesselFile
from trainer.study.tanks import Balance, Limits, Weight, balance, limits

KINDS: Final = ("pumped", "blown", "compartments")  # tables of [ballast]
# What is free to be filled; the rest stays as it is.
GROUPS: Final = {
    "pumped tanks": ("pumped",),
    "all tanks": ("pumped", "blown"),
    "tanks and flooding": ("pumped", "blown", "compartments"),
}


@dataclass(frozen=True)
class Tank:
    """A tank or compartment of the boat."""

    name: str
    kind: str  # of KINDS
    full: Weight  # of what it holds when full
    fill: float  # [-] of it, now

    @property
    def contents(self) -> Weight:
        """Return what it holds now."""
        return self.full._replace(weight=self.fill * self.full.weight)


@dataclass(frozen=True)
class Ranges:
    """Limits over all fillings of some of the tanks, and the outline of weight and moment."""

    free: str  # which
    limits: Limits
    # corners of all that can be: W - B [N] and x_G W - x_B B [N m]
    outline: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Report:
    """All that ``trainer tanks`` says about a vessel."""

    vessel: str
    buoyancy_N: float
    x_b_m: float
    z_b_m: float
    hull: Weight  # the boat with its tanks empty
    tanks: tuple[Tank, ...]
    now: Balance
    ranges: tuple[Ranges, ...]


def tanks_of(file: VesselFile, fills: Mapping[str, float]) -> list[Tank]:
    """Return the tanks, filled as at the start or as ``fills`` [-] says by name.

    ConfigError if the boat has no tanks, none of that name, or a share is not within 0 and 1.
    """
    if file.ballast is None:
        raise ConfigError(f"{file.path.name}: has no table [ballast]: there are no tanks to fill")
    unit = file.fluid.rho * file.fluid.g
    rows = [(kind, row) for kind in KINDS for row in getattr(file.ballast, kind)]
    _check_fills(fills, [row.name for _, row in rows])
    return [
        Tank(
            row.name,
            kind,
            Weight(unit * row.capacity_m3, *row.centre_m),
            fills.get(row.name, getattr(row, "start_fill", 0.0)),
        )
        for kind, row in rows
    ]


def _check_fills(fills: Mapping[str, float], names: Sequence[str]) -> None:
    """Check names and shares; ConfigError with all that is wrong."""
    problems = []
    for name, share in fills.items():
        if name not in names:
            known = f"this boat has {', '.join(names)}"
            problems.append(f"--fill {shown(name)}: no such tank{nearest(name, names)}; {known}")
        elif not 0.0 <= share <= 1.0:
            problems.append(f"--fill {name}={share:g}: must be within 0 (empty) and 1 (full)")
    if problems:
        raise ConfigError(*problems)


def bare_hull(file: VesselFile) -> Weight:
    """Return weight [N] and centre [m] of the boat with every tank empty.

    [vessel] holds at the start fillings.
    """
    whole = Weight(file.hull.weight, *file.hull.cg)
    taken = [tank.contents for tank in tanks_of(file, {})]
    return Weight(*_moved(whole, [water._replace(weight=-water.weight) for water in taken]))


def _moved(hull: Weight, parts: Sequence[Weight]) -> tuple[float, float, float, float]:
    """Return weight [N] and centre [m] of ``hull`` with ``parts``."""
    whole = balance(hull, parts)
    return (whole.weight, *whole.centre)


def outline(file: VesselFile, fixed: Weight, free: Sequence[Weight]) -> NDArray[np.float64]:
    """Return the corners of all W - B [N] and x_G W - x_B B [N m], in order and closed, (n, 2).

    Each tank adds a line from empty to full; the outline of their sum has each line twice, in
    the order of their steepness.
    """
    hull = file.hull
    start = [fixed.weight - hull.buoyancy, fixed.weight * fixed.x - hull.cb[0] * hull.buoyancy]
    steps = sorted(
        ([tank.weight, tank.weight * tank.x] for tank in free),
        key=lambda step: math.atan2(step[1], step[0]),
    )
    backwards = [[-weight, -moment] for weight, moment in steps]
    return np.cumsum([start, *steps, *backwards], axis=0)


def _ranges(file: VesselFile, hull: Weight, tanks: Sequence[Tank], free: str) -> Ranges:
    """Return the limits with the tanks of one group free and the others as they are."""
    kept = [tank.contents for tank in tanks if tank.kind not in GROUPS[free]]
    fixed = Weight(*_moved(hull, kept))
    full = [tank.full for tank in tanks if tank.kind in GROUPS[free]]
    corners = tuple((float(w), float(m)) for w, m in outline(file, fixed, full))
    return Ranges(free, limits(fixed, full), corners)


def fillings(file: VesselFile, fills: Mapping[str, float]) -> Report:
    """Return balance and limits of the boat's tanks, filled as ``fills`` [-] says by name."""
    hull, tanks = bare_hull(file), tanks_of(file, fills)
    kinds = {tank.kind for tank in tanks}
    groups = [free for free, members in GROUPS.items() if members[-1] in kinds]
    return Report(
        vessel=file.name,
        buoyancy_N=file.hull.buoyancy,
        x_b_m=file.hull.cb[0],
        z_b_m=file.hull.cb[2],
        hull=hull,
        tanks=tuple(tanks),
        now=balance(hull, [tank.contents for tank in tanks]),
        ranges=tuple(_ranges(file, hull, tanks, free) for free in groups),
    )
