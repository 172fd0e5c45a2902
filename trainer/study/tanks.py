"""Weight and balance over all fillings of the tanks: program EC430 [ASSES], erratum F6."""

from collections.abc import Sequence
from typing import NamedTuple


class Weight(NamedTuple):
    """One weight and where it is: the boat without its tanks, or the contents of a tank."""

    weight: float  # [N]
    x: float  # [m]
    y: float
    z: float


class Balance(NamedTuple):
    """Weight, moments about the origin, and centre of gravity."""

    weight: float  # [N]
    moments: tuple[float, float, float]  # [N m] weight times x, y, z
    centre: tuple[float, float, float]  # [m]


class Range(NamedTuple):
    """Least and greatest value over all fillings."""

    least: float
    most: float


class Limits(NamedTuple):
    """What the tanks can do: weight [N] and centre of gravity [m], each by itself."""

    weight: Range
    x_g: Range
    y_g: Range
    z_g: Range


def balance(hull: Weight, tanks: Sequence[Weight]) -> Balance:
    """Return weight [N], moments [N m] and centre [m]: x_G = (W0 x0 + sum Wi xi)/W."""
    parts = (hull, *tanks)
    weight = sum(part.weight for part in parts)
    x, y, z = (sum(part.weight * part[axis] for part in parts) for axis in (1, 2, 3))
    return Balance(weight, (x, y, z), (x / weight, y / weight, z / weight))


def limits(hull: Weight, tanks: Sequence[Weight]) -> Limits:
    """Return the limits of weight [N] and centre [m], ``tanks`` being their full contents."""
    return Limits(
        Range(hull.weight, balance(hull, tanks).weight),
        *(Range(_extreme(hull, tanks, axis, -1), _extreme(hull, tanks, axis, 1)) for axis in _AXES),
    )


_AXES = (1, 2, 3)  # places of x, y, z in Weight


def _extreme(hull: Weight, tanks: Sequence[Weight], axis: int, sign: int) -> float:
    """Return the centre [m] furthest towards ``sign`` along an axis.

    Each tank is then full or empty: full if it lies beyond the centre of all the rest, so that
    tanks are filled from the outermost inwards until one would draw the centre back.
    """
    weight, moment = hull.weight, hull.weight * hull[axis]
    for tank in sorted(tanks, key=lambda tank: -sign * tank[axis]):
        if sign * (tank[axis] - moment / weight) <= 0.0:
            break
        weight += tank.weight
        moment += tank.weight * tank[axis]
    return moment / weight
