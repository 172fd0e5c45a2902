"""Figures of manoeuvres that no record holds, with bands of drawn boats.

Each drawn boat sails the manoeuvres of ``trainer boat manoeuvre``, by the full equations. A band is
therefore what the deviations of the coefficients make of a turn or a zig-zag, and what a fit is
for is seen where the band of before stands beside it.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.analysis.check import critical_speed
from trainer.analysis.manoeuvres.catalogue import within_limits
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vertical import TrimChange
from trainer.analysis.manoeuvres.zigzag import VerticalZigZag, ZigZag
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.boat.prior import Knowledge
from trainer.identify.boat.vessel import FittedVessel

BAND_DRAWS: Final = 100
BAND_DEVIATIONS: Final = 1.96  # standard deviations either way: 95 %
BAND_PERCENT: Final = (2.5, 97.5)  # [%] likewise, where some draws cannot fly
QUARTER_PERCENT: Final = (25.0, 50.0, 75.0)  # [%] of draws: the middle half, and its middle
QUARTER_DEVIATIONS: Final = 0.6745  # standard deviations from the middle to a normal quarter
FAR_DEVIATIONS: Final = 4.0  # of the middle half: a draw counts as no further out (estimate)
MAX_LOST_SHARE: Final = 0.05  # [-] of draws: more, and the band is by percentiles
MIN_BAND_DRAWS: Final = 5  # fewer make no band
BEYOND_SHARE: Final = 0.1  # [-] of what was seen, by which a figure may go further
RANGE_WORDS: Final = {"u": "speed", "v/u": "drift", "w/u": "attack", "r L/u": "turning"}
Ranges = Mapping[str, tuple[float, float]]
CRITICAL_FIGURE: Final = "critical speed of the stern planes"


class Sailed(NamedTuple):
    """A manoeuvre, its length in lengths of the boat, and what is shown of it."""

    name: str
    manoeuvre: Manoeuvre
    lengths: float
    measures: Mapping[str, tuple[str, str]]  # measure: what it is called here, unit


TURN_MEASURES: Final = {
    "steady diameter": ("diameter", "m"),
    "steady speed": ("speed", "m/s"),
    "steady roll": ("heel", "rad"),
}
ZIGZAG_MEASURES: Final = {
    "heading overshoot 1": ("overshoot 1", "rad"),
    "heading overshoot 2": ("overshoot 2", "rad"),
    "time of heading zero 2": ("second crossing", "s"),
}
VERTICAL_MEASURES: Final = {f"pitch overshoot {i}": (f"overshoot {i}", "rad") for i in (1, 2)}
DIVE_MEASURES: Final = {"last change of depth": ("depth after {time:.3g} s", "m")}
VERTICAL: Final = VerticalZigZag(angle_deg=10.0, execute_deg=7.0)
SAILED: Final = (
    Sailed("turn at 15 deg", Turn(angle_deg=15.0), 60.0, TURN_MEASURES),
    Sailed("turn at 25 deg", Turn(angle_deg=25.0), 60.0, TURN_MEASURES),
    Sailed("zig-zag 20/20", ZigZag(angle_deg=20.0, execute_deg=20.0), 30.0, ZIGZAG_MEASURES),
    Sailed("vertical zig-zag 10/7", VERTICAL, 20.0, VERTICAL_MEASURES),
    Sailed("5 deg of planes", TrimChange(angle_deg=5.0, lead_s=0.0), 4.4, DIVE_MEASURES),
)


@dataclass(frozen=True)
class FigureBand:
    """A figure [SI, rad] of a boat, and the band of drawn boats."""

    name: str
    unit: str
    value: float | None  # None: the boat does not come to it
    sd: float | None  # of the draws, whereof none counts as far out
    low: float | None
    high: float | None
    lost: float  # [-] share of the draws that do not come to it


def figures_of(file: VesselFile) -> dict[tuple[str, str], float | None]:
    """Return the figures of a boat by name and unit, None for none."""
    found = dict[tuple[str, str], float | None]()
    for sailed, manoeuvre, flight in sail_figures(file):
        measured = {one.name: one.value for one in manoeuvre.measures(flight)} if flight else {}
        for measure, (words, unit) in sailed.measures.items():
            name = f"{sailed.name}: {words}".format(time=manoeuvre.duration_s)
            found[name, unit] = measured.get(measure)
    found[CRITICAL_FIGURE, "m/s"] = critical_speed(file, "stern")
    return found


def sail_figures(file: VesselFile) -> Iterator[tuple[Sailed, Any, Flight | None]]:
    """Yield each manoeuvre as a boat sails it; no flight where it is lost.

    A boat that lacks inertia, as a draw may, sails none.
    """
    method, vessel = (
        Method("full", "lagged", "exact", "adams2", file.run.step_s),
        FittedVessel(file),
    )
    sails = vessel.has_inertia(vessel.values)
    boat = Submarine(file, method, Rig("own", "own", "trainer")) if sails else None
    for sailed in SAILED:
        time = sailed.lengths * vessel.length / vessel.speed
        manoeuvre: Any = replace(sailed.manoeuvre, duration_s=time)  # type: ignore[call-arg]
        if boat is None:
            yield sailed, manoeuvre, None
            continue
        try:
            manoeuvre = within_limits(manoeuvre, boat)
            flight = fly_manoeuvre(boat, manoeuvre, vessel.speed)
        except ConfigError:
            yield sailed, manoeuvre, None
        else:
            yield sailed, manoeuvre, None if flight.lost else flight


def ranges_of(motion: Iterable[Numbers], length: float) -> Ranges:
    """Return least and greatest of u [m/s], v/u, w/u and r L/u [-].

    ``motion`` is u, v, w and r (n,).
    """
    u, v, w, r = motion
    ahead = np.where(u > 0.0, u, np.nan)
    ratios = {"u": u, "v/u": v / ahead, "w/u": w / ahead, "r L/u": r * length / ahead}
    return {name: (float(np.nanmin(one)), float(np.nanmax(one))) for name, one in ratios.items()}


def flown_outside(file: VesselFile, seen: Sequence[Ranges]) -> Iterator[str]:
    """Yield which manoeuvres of a boat go further than records, and in what."""
    for sailed, _, flight in sail_figures(file):
        if flight is None:
            continue
        flown = ranges_of(map(flight.column, "uvwr"), FittedVessel(file).length)
        further = [name for name, ends in flown.items() if _is_outside(name, ends, seen)]
        if further:
            yield f"{sailed.name} ({', '.join(RANGE_WORDS[name] for name in further)})"


def _is_outside(name: str, flown: tuple[float, float], seen: Sequence[Ranges]) -> bool:
    """Return whether a range goes beyond those seen; to port and to starboard are alike."""
    low, high = (fold(one[name][i] for one in seen) for i, fold in enumerate((min, max)))
    if name in ("v/u", "r L/u"):
        high = max(-low, high)
        low = -high
    room = BEYOND_SHARE * (high if name == "u" else high - low)
    return flown[0] < low - room or flown[1] > high + room


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
    """Return a figure with its band, as far as the draws give one.

    One draw that is far out would move a standard deviation as far as it likes, so none counts as
    further out than ``FAR_DEVIATIONS`` by the middle half (P. J. Huber, *Robust Statistics*, 1981).
    """
    values = np.array([one for one in drawn if one is not None and math.isfinite(one)])
    lost = 1.0 - len(values) / len(drawn) if drawn else 0.0
    if len(values) < MIN_BAND_DRAWS or value is None:
        return FigureBand(*key, value, None, None, None, lost)
    first, middle, third = np.percentile(values, QUARTER_PERCENT)
    far = FAR_DEVIATIONS * (third - first) / (2.0 * QUARTER_DEVIATIONS) or math.inf
    sd = float(np.std(values.clip(middle - far, middle + far)))
    low, high = value - BAND_DEVIATIONS * sd, value + BAND_DEVIATIONS * sd
    if lost > MAX_LOST_SHARE:
        low, high = map(float, np.percentile(values, BAND_PERCENT))
    return FigureBand(*key, value, sd, low, high, lost)
