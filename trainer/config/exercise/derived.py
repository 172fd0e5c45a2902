"""Conditions of an exercise, on quantities of the state and on others made from it.

Casualties, reference crews, marks and plans have such conditions: one quantity is compared with a
number, in a unit that its name may say (``speed_kn <= 4.5``).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.config.exercise.condition import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    MASS_UNITS,
    SPEED_UNITS,
    STATE_QUANTITIES,
    Quantity,
)
from trainer.config.files import ConfigError, Position, nearest, quote, raise_problems

NUMBER_PATTERN: Final = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"


CONDITION_PATTERN: Final = re.compile(
    rf"\s*([A-Za-z]\w*)\s*(<=|>=|<|>)\s*({NUMBER_PATTERN})\s*(\S*)\s*"
)


DERIVED_QUANTITIES: Final[Mapping[str, Quantity]] = {
    "course": Quantity("", ANGLE_UNITS, "where the bow points"),
    "heavy": Quantity("", MASS_UNITS, "weight less buoyancy"),
    "eye": Quantity("", LENGTH_UNITS, "height of the periscope's head above the sea"),
    "clearance": Quantity("", LENGTH_UNITS, "least height of the keel over the ground"),
    "speed_over_ground": Quantity("", SPEED_UNITS, "over the ground, whichever way"),
    "showing": Quantity("", LENGTH_UNITS, "height of sail or deck above the sea, the higher one"),
}


ALL_QUANTITIES: Final[Mapping[str, Quantity]] = {**STATE_QUANTITIES, **DERIVED_QUANTITIES}


AND_WORD: Final = re.compile(r"\s+and\s+")
LASTING_CONDITION: Final = re.compile(r"(.*\S)\s+for\s+([\d.]+)\s*s")


@dataclass(frozen=True)
class Condition:
    """A comparison of one quantity with a threshold [SI], and where it was written."""

    quantity: str
    sense: float  # 1 above, -1 below the threshold
    strict: bool  # the threshold itself does not count
    threshold: float
    text: str
    position: Position


def compile_conditions(text: str, position: Position) -> tuple[Condition, ...]:
    """Return the conditions that ``and`` joins, of any quantity; ConfigError as below."""
    return tuple(compile_condition(each, position, ALL_QUANTITIES) for each in AND_WORD.split(text))


def compile_condition(
    text: str, position: Position, known: Mapping[str, Quantity] = STATE_QUANTITIES
) -> Condition:
    """Return the condition written in ``text``; ConfigError if it is none, naming the nearest."""
    match = CONDITION_PATTERN.fullmatch(text)
    if match is None:
        alone = ', one alone, without "and"' if AND_WORD.search(text) else ""
        raise ConfigError(
            position.problem(
                f"condition {quote(text)}: write it as depth > 100, or as speed_kn <= 4.5{alone}"
            )
        )
    words, comparison, number, unit = match.groups()
    name, suffix = _split(words, text, position, known)
    units = known[name].units
    if suffix and unit and suffix != unit:
        raise ConfigError(position.problem(f"condition {quote(text)}: has two units"))
    unit_name = (suffix or unit or next(iter(units))).lower().replace("/", "_")
    if unit_name not in units:
        raise ConfigError(
            position.problem(
                f"condition {quote(text)}: {name} is in {' or '.join(units)}, "
                f"not {quote(unit_name)}"
            )
        )
    return Condition(
        quantity=name,
        sense=1.0 if comparison.startswith(">") else -1.0,
        strict="=" not in comparison,
        threshold=_number(number, text, position) * units[unit_name],
        text=text.strip(),
        position=position,
    )


def parse_name(
    words: str, known: Mapping[str, Quantity] = ALL_QUANTITIES
) -> tuple[str, str] | None:
    """Return the quantity and the unit in ``speed_kn``, the unit '' if there is none.

    None if there is no such quantity in such a unit.
    """
    words = words.lower()
    if words in known:
        return words, ""
    for name, quantity in known.items():
        for unit in quantity.units:
            if words == f"{name}_{unit}":
                return name, unit
    return None


def nearest_quantity(words: str, known: Mapping[str, Quantity] = ALL_QUANTITIES) -> str:
    """Return '. Nearest is ...' for the quantity most like ``words``, or '' if none is."""
    with_units = [f"{name}_{unit}" for name, q in known.items() for unit in q.units]
    return nearest(words, [*known, *with_units])


def _split(
    words: str, text: str, position: Position, known: Mapping[str, Quantity]
) -> tuple[str, str]:
    """Return the quantity and the unit in ``speed_kn``, which may be a wrong one."""
    name_and_unit = parse_name(words, known)
    if name_and_unit is not None:
        return name_and_unit
    words = words.lower()
    # The longest name first, and one word of unit: depth_rate_kn is of depth_rate, not of depth.
    for name in sorted(known, key=len, reverse=True):
        if words.startswith(f"{name}_") and "_" not in words.removeprefix(f"{name}_"):
            return name, words.removeprefix(f"{name}_")  # a wrong unit
    guess = nearest_quantity(words, known)
    raise ConfigError(position.problem(f"condition {quote(text)}: no quantity {words!r}{guess}"))


def _number(text: str, whole: str, position: Position) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(
            position.problem(f"condition {quote(whole)}: {quote(text)} is no number")
        ) from None


@dataclass(frozen=True, kw_only=True)
class Loss:
    """The conditions that lose an exercise, each held for so long [s]."""

    conditions: tuple[Condition, ...]
    seconds: float
    text: str


def compile_losses(texts: tuple[str, ...], position: Position) -> tuple[Loss, ...]:
    """Return the conditions that lose the exercise; ConfigError with all faults."""
    problems: list[str] = []
    losses = []
    for text in texts:
        lasting = LASTING_CONDITION.fullmatch(text.strip())
        words, seconds = (lasting[1], lasting[2]) if lasting else (text, "0")
        try:
            conditions = compile_conditions(words, position)
        except ConfigError as wrong:
            # The message about the list "lost" already quotes the condition, so only its reason
            # is taken over.
            reason = str(wrong).partition("condition ")[2].partition(": ")[2]
            problems.append(position.wrong("lost", text, reason))
        else:
            losses.append(Loss(conditions=conditions, seconds=float(seconds), text=text.strip()))
    raise_problems(problems)
    return tuple(losses)
