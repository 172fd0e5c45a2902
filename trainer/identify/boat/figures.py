"""Figures of manoeuvres that no record holds, with bands of drawn boats.

Each drawn boat sails the manoeuvres of ``trainer boat manoeuvre``, by the full equations. A band is
therefore what the deviations of the coefficients make of a turn or a zig-zag, and what a fit is
for is seen where the band of before stands beside it.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from trainer.analysis.check import critical_speed
from trainer.analysis.manoeuvres.catalogue import within_limits
from trainer.analysis.manoeuvres.flight import Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vertical import TrimChange
from trainer.analysis.manoeuvres.zigzag import VerticalZigZag, ZigZag
from trainer.boat.assemble import Method
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.identify.boat.prior import Knowledge
from trainer.identify.boat.vessel import FittedVessel

BAND_DRAWS: Final = 100
BAND_DEVIATIONS: Final = 1.96  # standard deviations either way: 95 %
BAND_PERCENT: Final = (2.5, 97.5)  # [%] likewise, where some draws cannot fly
MAX_LOST_SHARE: Final = 0.05  # [-] of draws: more, and the band is by percentiles
MIN_BAND_DRAWS: Final = 5  # fewer make no band
CRITICAL_FIGURE: Final = "critical speed of the stern planes"


class Sailed(NamedTuple):
    """A manoeuvre, its length in lengths of the boat, and the measures shown of it."""

    manoeuvre: Manoeuvre
    lengths: float
    measures: Mapping[str, str]  # measure: what it is called here


SAILED: Final = (
    Sailed(
        Turn(angle_deg=15.0),
        60.0,
        {
            "steady diameter": "turn at 15 deg: diameter",
            "steady speed": "turn at 15 deg: speed",
            "steady roll": "turn at 15 deg: heel",
        },
    ),
    Sailed(
        Turn(angle_deg=25.0),
        60.0,
        {
            "steady diameter": "turn at 25 deg: diameter",
            "steady speed": "turn at 25 deg: speed",
            "steady roll": "turn at 25 deg: heel",
        },
    ),
    Sailed(
        ZigZag(angle_deg=20.0, execute_deg=20.0),
        30.0,
        {
            "heading overshoot 1": "zig-zag 20/20: overshoot 1",
            "heading overshoot 2": "zig-zag 20/20: overshoot 2",
            "time of heading zero 2": "zig-zag 20/20: second crossing",
        },
    ),
    Sailed(
        VerticalZigZag(angle_deg=10.0, execute_deg=7.0),
        20.0,
        {
            "pitch overshoot 1": "vertical zig-zag 10/7: overshoot 1",
            "pitch overshoot 2": "vertical zig-zag 10/7: overshoot 2",
        },
    ),
    Sailed(
        TrimChange(angle_deg=5.0, lead_s=0.0),
        4.4,
        {"last change of depth": "5 deg of planes: depth after {time:.3g} s"},
    ),
)


@dataclass(frozen=True)
class FigureBand:
    """A figure [SI, rad] of a boat, and the band of drawn boats."""

    name: str
    unit: str
    value: float | None  # None: the boat does not come to it
    sd: float | None  # of the draws
    low: float | None
    high: float | None
    lost: float  # [-] share of the draws that do not come to it


def figures_of(file: VesselFile) -> dict[tuple[str, str], float | None]:
    """Return the figures of a boat by name and unit, None for none."""
    method = Method("full", "lagged", "exact", "adams2", file.run.step_s)
    vessel, found = FittedVessel(file), dict[tuple[str, str], float | None]()
    boat = Submarine(file, method, Rig("own", "own", "trainer"))
    for sailed in SAILED:
        time = sailed.lengths * vessel.length / vessel.speed
        timed: Manoeuvre = replace(sailed.manoeuvre, duration_s=time)  # type: ignore[call-arg]
        measured = _measured(boat, timed, vessel.speed)
        for measure, name in sailed.measures.items():
            unit, value = measured.get(measure, (_UNITS[measure], None))
            found[name.format(time=time), unit] = value
    found[CRITICAL_FIGURE, "m/s"] = critical_speed(file, "stern")
    return found


_UNITS: Final = {
    "steady diameter": "m",
    "steady speed": "m/s",
    "steady roll": "rad",
    "time of heading zero 2": "s",
    "last change of depth": "m",
    **dict.fromkeys((f"heading overshoot {n}" for n in (1, 2)), "rad"),
    **dict.fromkeys((f"pitch overshoot {n}" for n in (1, 2)), "rad"),
}


def _measured(
    boat: Submarine, manoeuvre: Manoeuvre, speed: float
) -> dict[str, tuple[str, float | None]]:
    """Return unit and value of each measure; none where the boat is lost on the way."""
    try:
        manoeuvre = within_limits(manoeuvre, boat)
        flight = fly_manoeuvre(boat, manoeuvre, speed)
    except ConfigError:
        return {}
    if flight.lost:
        return {}
    return {one.name: (one.unit, one.value) for one in manoeuvre.measures(flight)}


def figure_bands(
    vessel: FittedVessel, known: Knowledge, draws: int, heard: Callable[[int], object]
) -> tuple[FigureBand, ...]:
    """Return the figures of a boat with the bands of ``draws`` of its parameters.

    ``heard`` is called with the number of boats sailed since its last call.
    """
    rows = []
    for number in range(draws + 1):
        rows.append(figures_of(vessel.with_values(known.draw(number))))
        heard(1)
    own, drawn = rows[0], rows[1:]
    return tuple(_band(key, own[key], [row[key] for row in drawn]) for key in own)


def _band(key: tuple[str, str], value: float | None, drawn: list[float | None]) -> FigureBand:
    """Return a figure with its band, as far as the draws give one."""
    values = np.array([one for one in drawn if one is not None and math.isfinite(one)])
    lost = 1.0 - len(values) / len(drawn) if drawn else 0.0
    if len(values) < MIN_BAND_DRAWS or value is None:
        return FigureBand(*key, value, None, None, None, lost)
    sd = float(np.std(values))
    low, high = value - BAND_DEVIATIONS * sd, value + BAND_DEVIATIONS * sd
    if lost > MAX_LOST_SHARE:
        low, high = map(float, np.percentile(values, BAND_PERCENT))
    return FigureBand(*key, value, sd, low, high, lost)
