"""What a manoeuvre needs of a vehicle, and the form of what is measured.

``flight`` flies whatever has this form. Boats, Nomoto ships and fitted ships are vehicles: each can
start, take orders, advance and be read. So manoeuvres are written once, and know no submarine.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers

Side = Literal["starboard", "port"]
Direction = Literal["rise", "dive"]
STARBOARD: Final = "starboard"
PORT: Final = "port"
RISE: Final = "rise"
DIVE: Final = "dive"
# of an order of rudder or planes to that side, as ``Vehicle`` counts them
DIRECTION_SIGNS: Final[Mapping[Side | Direction, float]] = {
    STARBOARD: 1.0,
    PORT: -1.0,
    RISE: 1.0,
    DIVE: -1.0,
}
ALLOWED_PERCENT: Final = 5.0  # [%] by which two flights may differ
HEEL_ALLOWANCE_RAD: Final = math.radians(0.1)  # [rad] by which any heel may: none is read finer
ALLOWED_SECONDS: Final = 5.0  # [s] by which their zero crossings may
MAX_PEAKS: Final = 6  # peaks, and crossings, of one quantity
MIN_SWING_RATIO: Final = 2e-3  # [-] of the first swing: a smaller one is not reported
FAINT_SWING_RATIO: Final = 0.05  # [-] of the first swing: a smaller one is shown and not judged


class Control(NamedTuple):
    """The limits of one control."""

    low: float  # [rad], of the engine [m/s]
    high: float


class Watch(NamedTuple):
    """A quantity to watch until it passes its mark."""

    quantity: str  # a column, "size of theta" or "depth rate", which is without roll
    mark: float  # [rad] or [m/s]
    side: float = 1.0  # 1: at or above the mark is past it, -1: at or below


class LostError(Exception):
    """The vehicle's numbers are beyond all bounds; the text says which and when."""


class Vehicle(Protocol):
    """A vehicle in numbers, advanced cycle by cycle.

    Columns are SI and radians, by the names of ``trainer run --csv``: t u v w p q r x y z phi theta
    psi delta_r ...; a vehicle has those that mean something to it, t u v r x y psi at least.

    Controls: ``rudder`` [rad] from its neutral angle, positive turns to starboard; ``planes`` [rad]
    from theirs, positive raises the bow; ``engine``, the ordered speed [m/s], negative astern.
    """

    @property
    def name(self) -> str:
        """Return what it is called."""

    @property
    def length(self) -> float:
        """Return its length [m]."""

    @property
    def step(self) -> float:
        """Return the length of a cycle [s]."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Return the names of what ``observe`` returns."""

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of its controls by name."""

    def start(self, speed: float) -> None:
        """Begin anew in steady, straight, level motion at ``speed`` [m/s]; at 0 lie still.

        Controls stand at neutral and stay there. ConfigError if that cannot be.
        """

    def incline(self, heel: float) -> None:
        """Heel it by ``heel`` [rad] as it is, without a rate."""

    def order(self, control: str, value: float) -> None:
        """Order a control; it acts from the coming cycle on."""

    def keep(self, quantity: str) -> None:
        """Leave "depth", "course" or "speed" as now to automatic control, where there is such."""

    def observe(self) -> tuple[float, ...]:
        """Return its columns as they stand."""

    def advance(self) -> None:
        """Advance by one cycle, controls held; LostError if its numbers go astray."""


@runtime_checkable
class FastVehicle(Protocol):
    """A vehicle that takes many cycles at once. Its numbers are those of single ones."""

    @property
    def swift(self) -> bool:
        """Return whether it can take many cycles at once as it is handled now."""

    def sail(self, end: float, watch: Watch | None) -> NDArray[np.float64]:
        """Advance to ``end`` [s], or until the watch passes. Return a row for each cycle."""

    def sound(self) -> None:
        """Check how the last ``sail`` ended; LostError if the numbers went astray in it."""


def surface_limit(vehicle: Vehicle, control: str) -> float:
    """Return how far [rad] a surface goes to both sides."""
    low, high = vehicle.controls[control]
    return min(-low, high)


def check_parts(vehicle: Vehicle, controls: tuple[str, ...], columns: tuple[str, ...]) -> None:
    """Check that the vehicle has controls and columns; ConfigError if it lacks one."""
    for words, wanted, known in (
        ("needs a control {!r}", controls, tuple(vehicle.controls)),
        ("is measured by {}", columns, vehicle.columns),
    ):
        for lacking in (name for name in wanted if name not in known):
            problem = f"the manoeuvre {words.format(lacking)}, and it has {', '.join(known)} alone"
            raise ConfigError(f"{vehicle.name}: {problem}")


@dataclass(frozen=True)
class Measure:
    """One number of a manoeuvre, SI and radians."""

    name: str
    unit: str  # "m", "s", "rad", ...; "-" of a ratio
    value: float | None  # None: it never came to that
    allowed: float | None = None  # difference allowed to another flight; None: shown, not judged


def share_measure(name: str, unit: str, value: float | None) -> Measure:
    """Return a measure that may differ by ALLOWED_PERCENT of itself."""
    return Measure(
        name, unit, value, None if value is None else abs(value) * ALLOWED_PERCENT / 100.0
    )


def part_measure(name: str, unit: str, value: float | None, whole: float) -> Measure:
    """Return a measure that may differ by ALLOWED_PERCENT of ``whole``, the largest of its kind."""
    return Measure(name, unit, value, abs(whole) * ALLOWED_PERCENT / 100.0)


def heel_measure(name: str, value: float | None) -> Measure:
    """Return a heel [rad] that may differ by ALLOWED_PERCENT of itself, or HEEL_ALLOWANCE_RAD."""
    size = 0.0 if value is None else abs(value)
    allowed = max(size * ALLOWED_PERCENT / 100.0, HEEL_ALLOWANCE_RAD)
    return Measure(name, "rad", value, None if value is None else allowed)


def show_only(name: str, unit: str, value: float | None) -> Measure:
    """Return a measure that is not judged."""
    return Measure(name, unit, value)


def first_time(t: Numbers, values: Numbers, level: float) -> float | None:
    """Return the time when ``values`` first pass ``level``, interpolated; None: never.

    They pass upwards if they begin below the level, else downwards.
    """
    above = values >= level if values[0] < level else values <= level
    index = int(np.argmax(above))
    if not above[index]:
        return None
    return _between(t, values, index, level)


def _between(t: Numbers, values: Numbers, index: int, level: float) -> float:
    """Return the time of ``level`` between ``index`` - 1 and ``index``."""
    if index == 0 or values[index] == values[index - 1]:
        return float(t[index])
    part = (level - values[index - 1]) / (values[index] - values[index - 1])
    return float(t[index - 1] + part * (t[index] - t[index - 1]))


def peaks_of(t: Numbers, values: Numbers) -> list[tuple[float, float]]:
    """Return (time, value) of each extreme in which ``values`` turn, in order.

    A flat top counts once, at its beginning; a level stretch on the way does not count.
    """
    steps = np.diff(values)
    moving = np.flatnonzero(steps)
    rising = steps[moving] > 0.0
    indices = moving[:-1][rising[:-1] != rising[1:]] + 1
    return list(zip(t[indices].tolist(), values[indices].tolist(), strict=True))


def zero_crossings(t: Numbers, values: Numbers) -> list[float]:
    """Return the times [s] at which ``values`` change sign, interpolated."""
    indices = np.flatnonzero((values[:-1] * values[1:] < 0.0) | (values[1:] == 0.0)) + 1
    return [_between(t, values, int(i), 0.0) for i in indices]


def swing_measures(name: str, unit: str, t: Numbers, values: Numbers) -> list[Measure]:
    """Return a swinging quantity's peaks, and its zero crossings from the first peak on.

    Peaks may differ by ALLOWED_PERCENT of the first, crossings by ALLOWED_SECONDS; a crossing is
    judged if a swing of more than FAINT_SWING_RATIO of the first follows it.
    """
    tops = peaks_of(t, values)
    if not tops:
        return [show_only(f"{name} peak 1", unit, None)]
    begin, first = tops[0]
    allowed = abs(first) * ALLOWED_PERCENT / 100.0
    faint = FAINT_SWING_RATIO * abs(first)
    measures = []
    for i, (when, value) in enumerate(tops[:MAX_PEAKS], start=1):
        if abs(value) < MIN_SWING_RATIO * abs(first):
            break
        measures.append(Measure(f"{name} peak {i}", unit, value, allowed))
        measures.append(show_only(f"time of {name} peak {i}", "s", when))
    zeros = [at for at in zero_crossings(t, values) if at > begin]
    for i, when in enumerate(zeros[:MAX_PEAKS], start=1):
        strong = any(abs(value) >= faint for at, value in tops if at > when)
        measures.append(Measure(f"{name} zero {i}", "s", when, ALLOWED_SECONDS if strong else None))
    return measures


def largest_value(values: Numbers) -> float:
    """Return the value farthest from zero, with its sign."""
    return float(values[int(np.argmax(np.abs(values)))])
