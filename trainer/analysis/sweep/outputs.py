"""The outputs of a member: measures of the manoeuvre library, or a column's extremes."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from trainer.analysis.manoeuvres.flight import Flight
from trainer.analysis.manoeuvres.vehicle import Measure, largest
from trainer.config.files import ConfigError, nearest, quote
from trainer.core.kernel import Numbers

if TYPE_CHECKING:
    from trainer.analysis.sweep.study import Study

# columns of a study of identifications, by the parameter's name
DEVIATION: Final = "std dev of {}"
COVERED: Final = "{} covered"


class Output(NamedTuple):
    """One number kept of each member, SI and radians."""

    name: str
    unit: str


WAYS: Final[Mapping[str, Callable[[Numbers], float]]] = {
    "first": lambda values: float(values[0]),
    "last": lambda values: float(values[-1]),
    "lowest": lambda values: float(values.min()),
    "highest": lambda values: float(values.max()),
    "largest": largest,
}
UNITS: Final = {
    "t": "s",
    **dict.fromkeys(("u", "v", "w", "u_c"), "m/s"),
    **dict.fromkeys(("p", "q", "r"), "rad/s"),
    **dict.fromkeys(("x", "y", "z", "x_g", "z_g", "eta_wave"), "m"),
    **dict.fromkeys(("phi", "theta", "psi", "delta_r", "delta_s", "delta_b"), "rad"),
    "weight": "N",
}


def of_column(name: str, flight: Flight) -> Measure | None:
    """Return a measure such as "largest phi" or "last z"; None if that is none."""
    way, _, column = name.partition(" ")
    if way not in WAYS or not flight.has(column):
        return None
    return Measure(name, UNITS.get(column, "-"), WAYS[way](flight.column(column)))


def asked_of(study: "Study", flight: Flight, measures: Sequence[Measure]) -> tuple[Output, ...]:
    """Return what a study keeps of each member. ConfigError if it asks for what is not."""
    try:
        return choose_outputs(study.heading.measures, flight, measures)
    except ConfigError as wrong:
        raise ConfigError(f"{study.path.name}: {wrong}") from None


def choose_outputs(
    names: Sequence[str] | None, flight: Flight, measures: Sequence[Measure]
) -> tuple[Output, ...]:
    """Return what is kept: what ``names`` ask for, or all; ConfigError if one is nothing."""
    known = {one.name: one for one in measures}
    if names is None:
        if not known:
            ways = ", ".join(WAYS)
            raise ConfigError(f"lacks measures: such as 'last z', by {ways} and a column")
        return tuple(Output(one.name, one.unit) for one in known.values())
    found = []
    for name in names:
        one = known.get(name) or of_column(name, flight)
        if one is None:
            columns = ", ".join(flight.series.columns)
            has = f"; there are {', '.join(known)}" if known else ""
            raise ConfigError(
                f"no measure {quote(name)}{nearest(name, known)}{has}; and "
                f"{', '.join(WAYS)} of {columns}"
            )
        found.append(Output(one.name, one.unit))
    return tuple(found)


def read_off(outputs: Sequence[Output], flight: Flight, measures: Sequence[Measure]) -> list[float]:
    """Return the numbers kept of a flight, NaN for what it never came to."""
    known = {one.name: one for one in measures}
    found = []
    for output in outputs:
        one = known.get(output.name) or of_column(output.name, flight)
        value = None if one is None else one.value
        found.append(math.nan if value is None or not np.isfinite(value) else float(value))
    return found
