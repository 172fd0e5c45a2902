"""A boat of another length: Froude's law for every key of a vessel file.

Two boats of one shape behave alike where gravity and water are the same: lengths as L, times and
speeds as the root of L, masses as L^3. The unit of a key tells its power of L; ``LAW_EXCEPTIONS``
names the keys with another law, and why. A number without a unit stays as it is.
"""

import re
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from trainer.config.schema import Kind, NamedNumbers, Quantities, Quantity, Rows, Table, kinds_of

SCALED_DIGITS: Final = 7  # [digits] of a scaled number
LENGTH_POWERS: Final = {  # of the length, by unit
    **dict.fromkeys(("-", "rad", "deg", "degC"), 0.0),
    **dict.fromkeys(("m", "cm", "mm"), 1.0),
    "s": 0.5,
    "kn": 0.5,
    "kg": 3.0,
    "N": 3.0,
    "MPa": 1.0,
    "W": 3.5,
}
UNIT_PATTERN: Final = re.compile(r"([A-Za-z-]+?)\^?(\d?)")
PRESSURE_REASON: Final = (
    "kept: a hull of the same shape and steel bears the same pressure; estimate"
)


class Law(NamedTuple):
    """The power [-] of the length that a key follows, and the reason."""

    power: float
    reason: str = ""


LAW_EXCEPTIONS: Final[Mapping[tuple[str, str], Law]] = {
    ("vessel", "max_depth_m"): Law(0.0, PRESSURE_REASON),
    ("vessel", "test_depth_m"): Law(0.0, PRESSURE_REASON),
    ("vessel", "collapse_depth_m"): Law(0.0, PRESSURE_REASON),
    ("ballast.banks", "pressure_mpa"): Law(0.0, "kept: what bottles bear; estimate"),
    ("ballast.pumps", "shutoff_depth_m"): Law(0.0, "kept, as the test depth is; estimate"),
    ("ballast.sea", "compressibility_kg_m"): Law(
        3.0, "as L^3: a metre presses the same share of the volume away; estimate"
    ),
    ("ballast.sea", "layer_depth_m"): Law(0.0, "kept: the sea's own"),
}


PLANT_LAW: Final = Law(0.0, "kept: plants follow no such law; estimate")


def power_of(unit: str) -> float:
    """Return the power of the length [-] that a unit follows. KeyError of an unknown unit.

    A unit is factors with spaces between, one slash at most: ``rad s/m``, ``kg/(m s)``.
    """
    above, _, below = unit.partition("/")
    return _product(above) - _product(below.strip("()"))


def _product(factors: str) -> float:
    """Return the power of a product of units."""
    total = 0.0
    for factor in factors.split():
        if factor == "1":
            continue
        match = UNIT_PATTERN.fullmatch(factor)
        if match is None:
            raise KeyError(factor)
        total += LENGTH_POWERS[match[1]] * int(match[2] or 1)
    return total


def law_of(table: str, key: str, kind: Kind) -> Law:
    """Return the law of a key of a table. It is that of its unit where it is no exception."""
    if (table, key) in LAW_EXCEPTIONS:
        return LAW_EXCEPTIONS[table, key]
    if table.partition(".")[0] == "plant":
        return PLANT_LAW
    quantity = _quantity(kind)
    return Law(power_of(quantity.unit)) if quantity else Law(0.0)


def _quantity(kind: Kind) -> Quantity | None:
    """Return the quantity of the numbers of a kind, None for words."""
    if isinstance(kind, Quantities | NamedNumbers):
        return kind.each
    return kind if isinstance(kind, Quantity) else None


def scaled_table(
    record: type[Any], table: Mapping[str, Any], name: str, factor: float
) -> dict[str, Any]:
    """Return a table scaled by ``factor`` [-], without the reader's own keys."""
    kinds = kinds_of(record)
    return {
        key: _scaled(kinds[key], value, name, key, factor)
        for key, value in table.items()
        if key in kinds
    }


def _scaled(kind: Kind, value: Any, table: str, key: str, factor: float) -> Any:
    """Return a value of the scaled boat."""
    inside = f"{table}.{key}"
    if isinstance(kind, Rows):
        return [scaled_table(kind.record, row, inside, factor) for row in value]
    if isinstance(kind, Table):
        return scaled_table(kind.record, value, inside, factor)
    power = law_of(table, key, kind).power
    return value if power == 0.0 else _multiplied(value, factor**power)


def _multiplied(value: Any, by: float) -> Any:
    """Return a number, or a list or table of numbers, times ``by`` [-]."""
    if isinstance(value, list):
        return [_multiplied(each, by) for each in value]
    if isinstance(value, Mapping):
        return {name: _multiplied(each, by) for name, each in value.items()}
    return float(f"{value * by:.{SCALED_DIGITS}g}")


def formula(power: float) -> str:
    """Return the law of a power as text; "as it is" for 0."""
    if power == 0.0:
        return "as it is"
    return "L" if power == 1.0 else f"L^{power:g}"
