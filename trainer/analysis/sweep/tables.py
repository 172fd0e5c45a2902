"""The tables that a study varies, and one number in them replaced by another.

A key is a path through them: words with dots between, ``vessel.fluid.rho``, and places in
lists in brackets, ``exercise.orders[2].at_s``. The vessel's coefficients stand there all of them,
by name, and of its compensation the factors of all that the compact set keeps.
"""

import re
from collections.abc import Mapping
from typing import Any, Final

from trainer.config.coefficients import EQUATION_SETS
from trainer.config.files import ConfigError, nearest, parse_toml
from trainer.config.vessel import VesselFile, with_defaults
from trainer.core.terms import COEFFICIENTS

Tables = Mapping[str, Any]
Step = str | int

WORD: Final = re.compile(r"([A-Za-z0-9_-]+)((?:\[\d{1,4}\])*)")
BLANK: Final = "{}"  # in a text: where the number goes
DECIMALS: Final = 9  # of a number in a text


def vessel_tables(file: VesselFile) -> dict[str, Any]:
    """Return a vessel's tables with all coefficients and all factors of compensation."""
    tables, _ = with_defaults(parse_toml(file.text, file.path.name))
    kept = [term.key for term in COEFFICIENTS if term.kept or term.key in file.compact.extra_terms]
    factors = {
        name: dict.fromkeys(kept, 1.0) | dict(file.compensation[name]) for name in EQUATION_SETS
    }
    return {**tables, "coefficients": dict(file.coefficients), "compensation": factors}


def steps_of(key: str) -> tuple[Step, ...]:
    """Return the words and places of a key; ConfigError if it is none."""
    found: list[Step] = []
    for part in key.split("."):
        match = WORD.fullmatch(part)
        if match is None:
            raise ConfigError(f"{part!r} is no word of a key")
        found.append(match[1])
        found += [int(place) for place in re.findall(r"\d+", match[2])]
    return tuple(found)


def value_at(tables: Any, steps: tuple[Step, ...]) -> Any:
    """Return what stands there, None if nothing does; ConfigError naming the nearest table."""
    here = tables
    for depth, step in enumerate(steps):
        last = depth == len(steps) - 1
        if isinstance(here, Mapping) and isinstance(step, str):
            if step not in here and not last:
                raise ConfigError(f"there is no table {step!r}{nearest(step, here)}")
            here = here.get(step)
        elif isinstance(here, list) and isinstance(step, int) and step < len(here):
            here = here[step]
        else:
            raise ConfigError(f"{step!r} has no place there: {_holds(here)}")
    return here


def _holds(here: Any) -> str:
    """Return in words what can be stepped into."""
    if isinstance(here, list):
        return f"it is a list of {len(here)}, counted from 0"
    if isinstance(here, Mapping):
        return "it is a table"
    return "it is no table and no list"


def change_value(tables: Any, steps: tuple[Step, ...], value: Any) -> Any:
    """Return the tables with another value there; those given stay as they are."""
    if not steps:
        return _fill_in(tables, value)
    step, rest = steps[0], steps[1:]
    if isinstance(step, int):
        return [
            change_value(item, rest, value) if i == step else item for i, item in enumerate(tables)
        ]
    return {**tables, step: change_value(tables.get(step), rest, value)}


def _fill_in(text: Any, value: Any) -> Any:
    """Return the value, or where a text has a blank the text with the value in it."""
    if not isinstance(text, str) or BLANK not in text:
        return value
    if not isinstance(value, str):
        value = f"{value:.{DECIMALS}f}".rstrip("0").rstrip(".")
    return text.replace(BLANK, value)
