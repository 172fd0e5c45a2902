"""Conditions on the state are read from text. Examples are ``depth > 100`` and ``speed_kn < 4``."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.config.files import ConfigError, Place, nearest, quote, refuse
from trainer.core.ballast.tanks import BANKS, BLOWN, COMPARTMENTS, PUMPED

NUMBER: Final = r"[-+]?[\d.]+(?:[eE][-+]?\d+)?"
FORM: Final = re.compile(rf"\s*([A-Za-z]\w*)\s*(<=|>=|<|>)\s*({NUMBER})\s*(\S*)\s*")

# Units of a quantity [SI], its own first.
LENGTH: Final = {"m": 1.0, "ft": 0.3048}
RATE: Final = {"m_s": 1.0}
SPEED: Final = {"kn": 1852.0 / 3600.0, "m_s": 1.0}
ANGLE: Final = {"deg": math.radians(1.0)}
TURN: Final = {"deg_s": math.radians(1.0)}
MASS: Final = {"t": 1000.0, "kg": 1.0}
PRESSURE: Final = {"mpa": 1e6, "bar": 1e5}
TIME: Final = {"s": 1.0, "min": 60.0}
TURNS: Final = {"rpm": 1.0 / 60.0}


@dataclass(frozen=True)
class Quantity:
    """A quantity of conditions: its place in the state, its units, and its meaning."""

    place: str
    units: Mapping[str, float]
    meaning: str


QUANTITIES: Final[Mapping[str, Quantity]] = {
    "time": Quantity("tick", TIME, "since the start of the run"),
    "depth": Quantity("z", LENGTH, "of the boat's origin"),
    "depth_rate": Quantity("zdot", RATE, "positive going down"),
    "north": Quantity("x", LENGTH, "of the start"),
    "east": Quantity("y", LENGTH, "of the start"),
    "speed": Quantity("u", SPEED, "ahead through the water"),
    "pitch": Quantity("theta", ANGLE, "positive bow up"),
    "heel": Quantity("phi", ANGLE, "positive to starboard"),
    "turn_rate": Quantity("r", TURN, "positive to starboard"),
    "rudder": Quantity("delta_r", ANGLE, "positive right"),
    "stern": Quantity("delta_s", ANGLE, "stern planes, positive rise"),
    "bow": Quantity("delta_b", ANGLE, "bow planes, positive rise"),
    "turns": Quantity("u_c", TURNS, "propeller revolutions"),
    "wave": Quantity("eta_wave", LENGTH, "surface elevation above the boat"),
    **{
        f"water_{name}": Quantity(f"water_{name}", MASS, "water in that tank")
        for name in (*BLOWN, *PUMPED)
    },
    **{
        name.replace("compartment", "flood"): Quantity(
            name.replace("compartment", "flood"), MASS, "water in that compartment"
        )
        for name in COMPARTMENTS
    },
    **{
        f"bank_{name}": Quantity(f"bank_{name}", PRESSURE, "absolute pressure in that air bank")
        for name in BANKS
    },
}


# Quantities that no place of the state holds: judged and watched, but no trigger of a casualty.
DERIVED: Final[Mapping[str, Quantity]] = {
    "course": Quantity("", ANGLE, "where the bow points"),
    "heavy": Quantity("", MASS, "weight less buoyancy"),
    "eye": Quantity("", LENGTH, "height of the periscope's head above the sea"),
    "clearance": Quantity("", LENGTH, "least height of the keel over the ground"),
    "speed_over_ground": Quantity("", SPEED, "over the ground, whichever way"),
    "showing": Quantity("", LENGTH, "height of sail or deck above the sea, the higher one"),
}
EVERY: Final[Mapping[str, Quantity]] = {**QUANTITIES, **DERIVED}
AND: Final = re.compile(r"\s+and\s+")


@dataclass(frozen=True)
class Condition:
    """A comparison of one quantity with a threshold [SI], and where it was written."""

    quantity: str
    sense: float  # 1 above, -1 below the threshold
    strict: bool
    threshold: float
    text: str
    place: Place


def compile_conditions(text: str, place: Place) -> tuple[Condition, ...]:
    """Return the conditions that ``and`` joins, of any quantity; ConfigError as below."""
    return tuple(compile_condition(each, place, EVERY) for each in AND.split(text))


def compile_condition(
    text: str, place: Place, known: Mapping[str, Quantity] = QUANTITIES
) -> Condition:
    """Return the condition written in ``text``; ConfigError if it is none, naming the nearest."""
    found = FORM.fullmatch(text)
    if found is None:
        raise ConfigError(
            place.problem(f"condition {quote(text)}: write it as depth > 100 or speed_kn <= 4.5")
        )
    words, comparison, number, unit = found.groups()
    name, suffix = _split(words, text, place, known)
    units = known[name].units
    if suffix and unit and suffix != unit:
        raise ConfigError(place.problem(f"condition {quote(text)}: has two units"))
    given = (suffix or unit or next(iter(units))).lower().replace("/", "_")
    if given not in units:
        raise ConfigError(
            place.problem(
                f"condition {quote(text)}: {name} is in {' or '.join(units)}, not {quote(given)}"
            )
        )
    return Condition(
        quantity=name,
        sense=1.0 if comparison.startswith(">") else -1.0,
        strict="=" not in comparison,
        threshold=_number(number, text, place) * units[given],
        text=text.strip(),
        place=place,
    )


def parse_name(words: str, known: Mapping[str, Quantity] = EVERY) -> tuple[str, str] | None:
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


def nearest_quantity(words: str, known: Mapping[str, Quantity] = EVERY) -> str:
    """Return '. Nearest is ...' for the quantity most like ``words``, or '' if none is."""
    with_units = [f"{name}_{unit}" for name, q in known.items() for unit in q.units]
    return nearest(words, [*known, *with_units])


def _split(words: str, text: str, place: Place, known: Mapping[str, Quantity]) -> tuple[str, str]:
    """Return the quantity and the unit in ``speed_kn``, which may be a wrong one."""
    found = parse_name(words, known)
    if found is not None:
        return found
    words = words.lower()
    for name in sorted(known, key=len, reverse=True):
        if words.startswith(f"{name}_") and "_" not in words.removeprefix(f"{name}_"):
            return name, words.removeprefix(f"{name}_")  # a wrong unit
    guess = nearest_quantity(words, known)
    raise ConfigError(place.problem(f"condition {quote(text)}: no quantity {words!r}{guess}"))


def _number(text: str, whole: str, place: Place) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(
            place.problem(f"condition {quote(whole)}: {quote(text)} is no number")
        ) from None


def quantity_table() -> str:
    """Return the Markdown table of every quantity, as docs/casualties.md shows it."""
    rows = ["| quantity | units | is |", "|---|---|---|"]
    rows += [f"| `{name}` | {', '.join(q.units)} | {q.meaning} |" for name, q in QUANTITIES.items()]
    return "\n".join(rows) + "\n"


@dataclass(frozen=True, kw_only=True)
class Loss:
    """The conditions that lose an exercise, each held for so long [s]."""

    conditions: tuple[Condition, ...]
    seconds: float
    text: str


LASTING: Final = re.compile(r"(.*\S)\s+for\s+([\d.]+)\s*s")


def compile_losses(texts: tuple[str, ...], place: Place) -> tuple[Loss, ...]:
    """Return what loses the exercise; ConfigError with all that is no condition."""
    problems: list[str] = []
    found = []
    for text in texts:
        lasting = LASTING.fullmatch(text.strip())
        words, seconds = (lasting[1], lasting[2]) if lasting else (text, "0")
        try:
            conditions = compile_conditions(words, place)
        except ConfigError as wrong:
            reason = str(wrong).partition("condition ")[2].partition(": ")[2]
            problems.append(place.wrong("lost", text, reason))
        else:
            found.append(Loss(conditions=conditions, seconds=float(seconds), text=text.strip()))
    refuse(problems)
    return tuple(found)
