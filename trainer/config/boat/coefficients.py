"""The coefficients of a boat, read from the table [coefficients] of its vessel file.

``vessel`` reads a file's table by it. They are those of Report 2510, dimensionless. Names are
checked against the core's table of terms, so that a misspelt one is refused with the nearest that
exists.
"""

from collections.abc import Mapping

from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    nearest,
    raise_problems,
)
from trainer.config.schema import Quantity, within
from trainer.core.terms import COEFFICIENTS, LENGTH_POWERS

FORCE_AXES = ("X", "Y", "Z", "K", "M", "N")
COEFFICIENT_QUANTITY = Quantity("-", within(-10, 10), "coefficient, prime system, per radian")
FACTOR_QUANTITY = Quantity("-", within(-100, 100), "factor on a coefficient of the compact set")
EQUATION_SETS = ("modified", "basic")


def read_coefficients(table: object, position: Position) -> dict[str, float]:
    """Return the coefficients given under [coefficients] or its axes; ConfigError with all faults.

    Those not given are left out.
    """
    entries, problems = _flatten(as_table(table, position), position)
    known = list(LENGTH_POWERS)
    values: dict[str, float] = {}
    for axis, key, value in entries:
        with collecting(problems):
            values[key] = _coefficient(
                key, value, position.inside(axis) if axis else position, known
            )
    keys = [key for _, key, _ in entries]
    problems += [position.problem(f"{key} is given twice") for key in values if keys.count(key) > 1]
    raise_problems(problems)
    return values


def _coefficient(key: str, value: object, position: Position, known: list[str]) -> float:
    """Return the value [-] of one coefficient; ConfigError if it, or its axis, is wrong."""
    if key not in known:
        raise ConfigError(position.wrong(key, value, f"no such coefficient{nearest(key, known)}"))
    root, _, axis = position.table.rpartition(".")
    if root and axis != key[0]:
        raise ConfigError(position.wrong(key, value, f"belongs under [{root}.{key[0]}]"))
    return COEFFICIENT_QUANTITY.read(key, value, position)


def _flatten(
    table: Mapping[str, object], position: Position
) -> tuple[list[tuple[str, str, object]], list[str]]:
    """Return (axis or '', key, value) of each entry, and what is wrong with the axes."""
    entries: list[tuple[str, str, object]] = []
    problems = []
    for name, value in table.items():
        if name in FORCE_AXES and isinstance(value, Mapping):
            entries.extend((name, key, item) for key, item in value.items())
        elif name in FORCE_AXES or isinstance(value, Mapping):
            text = f"must be one of the tables {', '.join(FORCE_AXES)}, or a coefficient"
            problems.append(position.wrong(name, value, text))
        else:
            entries.append(("", name, value))
    return entries, problems


def read_compensation(
    table: object, position: Position, extra: tuple[str, ...]
) -> dict[str, dict[str, float]]:
    """Return factor [-] by coefficient for each compact equation set; ConfigError with all faults.

    Only coefficients the compact set keeps, or this hull adds (``extra``), can have a factor.
    """
    sets = as_table(table, position)
    problems = [
        position.wrong(name, value, f"no such equation set{nearest(name, EQUATION_SETS)}")
        for name, value in sets.items()
        if name not in EQUATION_SETS
    ]
    factors: dict[str, dict[str, float]] = {name: {} for name in EQUATION_SETS}
    for name in EQUATION_SETS:
        with collecting(problems):
            factors[name] = _factors(sets.get(name, {}), position.inside(name), extra)
    raise_problems(problems)
    return factors


def _factors(table: object, position: Position, extra: tuple[str, ...]) -> dict[str, float]:
    """Return factor [-] by coefficient; ConfigError with all that is wrong."""
    values = as_table(table, position)
    kept_keys = [term.key for term in COEFFICIENTS if term.kept or term.key in extra]
    problems = [
        position.wrong(
            key, value, f"the compact set keeps no such coefficient{nearest(key, kept_keys)}"
        )
        for key, value in values.items()
        if key not in kept_keys
    ]
    raise_problems(problems)
    return {key: FACTOR_QUANTITY.read(key, value, position) for key, value in values.items()}
