"""The figures in an exercise's texts, and how each is flown: ``[[stated]]``.

A briefing that says "on the wall after 7 minutes" is right only if the boat is there then. A row
stands beside the text, and the check flies it.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from trainer.config.exercise.derived import Condition, compile_conditions
from trainer.config.exercise.score_rules import MeasuredQuantity, parse_quantity
from trainer.config.files import ConfigError, Position, collecting, quote, raise_problems
from trainer.config.schema import (
    Choice,
    Rows,
    Text,
    Texts,
    optional,
    required,
    with_default,
    within,
)
from trainer.io.orders.grammar import Refused
from trainer.io.orders.schedule import MAX_TIME_S, ScheduledOrder, parse_entry
from trainer.io.orders.words import BOAT_ORDERS

FLYER_KINDS: Final = ("nobody", "crew")
STATED_MEASURES: Final = ("value", "lowest", "highest")
DEFAULT_TOLERANCE: Final = 0.02  # of the stated value
# Kinds of figure that a row can state, by a field or by a flight.
JUDGED_KINDS: Final = ("time", "length", "speed", "turn")
ROUNDING_TOLERANCE: Final = 1e-3  # of a figure, where one unit is turned into another

# Units of texts: the kind of a quantity, and the size [SI].
TEXT_UNITS: Final[Mapping[str, tuple[str, float]]] = {
    **dict.fromkeys(("s", "second", "seconds"), ("time", 1.0)),
    **dict.fromkeys(("min", "minute", "minutes"), ("time", 60.0)),
    **dict.fromkeys(("h", "hour", "hours"), ("time", 3600.0)),
    **dict.fromkeys(("m", "metre", "metres"), ("length", 1.0)),
    **dict.fromkeys(("ft", "feet"), ("length", 0.3048)),
    **dict.fromkeys(("kn", "knot", "knots"), ("speed", 1852.0 / 3600.0)),
    "m/s": ("speed", 1.0),
    **dict.fromkeys(("deg", "degree", "degrees"), ("angle", math.radians(1.0))),
    "deg/s": ("turn", math.radians(1.0)),
    "t": ("mass", 1000.0),
}
# fmt: off
SMALL_NUMBERS: Final = (
    "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
    "twelve",
)
# fmt: on
NUMBER_WORDS: Final[Mapping[str, float]] = {
    **dict.fromkeys(("half", "half a", "half an"), 0.5),
    **dict.fromkeys(("a", "an"), 1.0),
    **{word: float(i) for i, word in enumerate(SMALL_NUMBERS, 1)},
    **dict(
        zip(
            ("fifteen", "twenty", "thirty", "forty", "sixty"),
            (15.0, 20.0, 30.0, 40.0, 60.0),
            strict=True,
        )
    ),
}
NUMBER_WORD_PATTERN: Final = "|".join(sorted(NUMBER_WORDS, key=len, reverse=True))
UNIT_WORD_PATTERN: Final = "|".join(sorted(map(re.escape, TEXT_UNITS), key=len, reverse=True))
FIGURE_PATTERN: Final = re.compile(
    rf"(?<![\w.])(?:(?P<minutes>\d+):(?P<seconds>\d\d)|(?P<number>\d+(?:\.\d+)?)|(?P<word>{NUMBER_WORD_PATTERN}))"
    rf"(?:(?:\s+|-)(?:to|or|and)\s+(?P<second>\d+(?:\.\d+)?))?"
    rf"(?:(?:\s+|-)(?P<unit>{UNIT_WORD_PATTERN}))?(?![\w/]|:\d|\.\d)",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class TextFigure:
    """A number of a text, with its kind "" where no unit stands behind it."""

    text: str
    number: float
    kind: str
    size: float  # [SI] of its unit

    def is_of(self, number: float, kind: str, size: float) -> bool:
        """Return whether it is this number, in whichever unit of its kind."""
        if self.kind and kind and self.kind != kind:
            return False
        own_number = self.number * self.size if self.kind and kind else self.number
        other = number * size if self.kind and kind else number
        return math.isclose(own_number, other, rel_tol=ROUNDING_TOLERANCE, abs_tol=1e-9)


def figures_of(text: str) -> Iterator[TextFigure]:
    """Yield the numbers of a text: "7 minutes", "2:30", "15 and 20 minutes", "10 in"."""
    for match in FIGURE_PATTERN.finditer(" ".join(text.split())):
        kind, size = TEXT_UNITS[match["unit"].lower()] if match["unit"] else ("", 1.0)
        if match["minutes"]:
            seconds = 60.0 * float(match["minutes"]) + float(match["seconds"])
            yield TextFigure(match[0], seconds, "time", 1.0)
        elif match["number"]:
            yield TextFigure(match[0], float(match["number"]), kind, size)
        elif kind:  # a word without a unit, such as "one", is no figure
            yield TextFigure(match[0], NUMBER_WORDS[match["word"].lower()], kind, size)
        if match["second"]:
            yield TextFigure(match[0], float(match["second"]), kind, size)


@dataclass(frozen=True, kw_only=True)
class StatedRow:
    """One figure of the texts, and how it is flown."""

    says: str = required(Text(79, "words of briefing or instructor with the figure, on one line"))
    by: str = with_default(
        "nobody", Choice(FLYER_KINDS, "who flies: nobody, or the reference crew")
    )
    orders: tuple[str, ...] | None = optional(
        Texts(Text(80, "more orders, as in a file of orders: 95 negative flood"), 8)
    )
    when: str | None = optional(Text(79, "conditions, with and, that first hold at at_s"))
    from_s: float | None = optional("s", within(0, MAX_TIME_S), "not before; else 0")
    to_s: float | None = optional("s", within(0, MAX_TIME_S), "not later; else the end")
    quantity: str | None = optional(Text(40, "instead of when: depth_m, speed_kn, as in scores"))
    measure: str | None = optional(
        Choice(STATED_MEASURES, "of the quantity: at at_s, or its least or greatest")
    )
    at_s: float | None = optional("s", within(0, MAX_TIME_S), "with when, or value")
    value: float | None = optional("-", within(-1e9, 1e9), "in the quantity's unit")
    within: float | None = optional(
        "-", within(0, 1e6), "s or the quantity's unit; else 2 % of it, a step at least"
    )


STATED_ROWS: Final = Rows(
    StatedRow, ("note",), 0, 40, "figures of the texts, and their flights, below"
)


@dataclass(frozen=True, kw_only=True)
class StatedValue:
    """One stated figure, its words understood."""

    row: StatedRow
    conditions: tuple[Condition, ...]
    measured: MeasuredQuantity | None
    orders: tuple[ScheduledOrder, ...]

    @property
    def target(self) -> float:
        """Return what is stated: a time [s], or a value in the quantity's unit."""
        return (self.row.at_s if self.measured is None else self.row.value) or 0.0

    @property
    def unit(self) -> str:
        """Return the unit of what is stated."""
        return "s" if self.measured is None else self.measured.unit

    @property
    def tolerance(self) -> float:
        """Return how far the flight may be off."""
        width = self.row.within
        return DEFAULT_TOLERANCE * abs(self.target) if width is None else width

    def states(self, figure: TextFigure) -> bool:
        """Return whether a figure of a text is this row's: its time, value or threshold."""
        numbers = [(self.row.at_s, "time", 1.0)]
        if self.measured is not None:
            numbers.append((self.row.value, *TEXT_UNITS.get(self.measured.unit, ("", 1.0))))
        for condition in self.conditions:
            quantity = parse_quantity(condition.quantity, condition.position)
            numbers.append(
                (condition.threshold / quantity.size, *TEXT_UNITS.get(quantity.unit, ("", 1.0)))
            )
        return any(
            number is not None and figure.is_of(number, kind, size)
            for number, kind, size in numbers
        )


def read_stated(table: Mapping[str, object], position: Position) -> tuple[StatedValue, ...]:
    """Return the stated figures of an exercise file; ConfigError with all that is wrong."""
    problems: list[str] = []
    stated: list[StatedValue] = []
    texts = [table.get("briefing"), table.get("instructor")]
    page = " ".join(" ".join(text.split()) for text in texts if isinstance(text, str))
    with collecting(problems):
        for i, row in enumerate(STATED_ROWS.read("stated", table.get("stated", []), position)):
            with collecting(problems):
                stated.append(_read_row(row, page, position.inside(f"stated[{i}]")))
    raise_problems(problems)
    return tuple(stated)


def _read_row(row: StatedRow, page: str, position: Position) -> StatedValue:
    """Return one stated figure; ConfigError with all that is wrong in it."""
    problems = [*_lacking(row, position)]
    if " ".join(row.says.split()) not in page:
        message = "neither briefing nor instructor says so: copy its words, or correct them"
        problems.append(position.wrong("says", row.says, message))
    conditions: tuple[Condition, ...] = ()
    with collecting(problems):
        conditions = compile_conditions(row.when, position) if row.when else ()
    measured = None
    orders: tuple[ScheduledOrder, ...] = ()
    with collecting(problems):
        measured = parse_quantity(row.quantity, position) if row.quantity else None
    with collecting(problems):
        # the orders that a flight has besides; ConfigError with the first that is none
        entries = []
        for i, line in enumerate(row.orders or ()):
            entry = parse_entry(line, 0)
            if not isinstance(entry, ScheduledOrder):
                raise ConfigError(position.wrong(f"orders[{i}]", line, entry or "is no order"))
            if entry.order.name not in BOAT_ORDERS:
                raise ConfigError(position.wrong(f"orders[{i}]", line, "moves no boat"))
            entries.append(entry)
        orders = tuple(entries)
    raise_problems(problems)
    stated = StatedValue(row=row, conditions=conditions, measured=measured, orders=orders)
    if refused := _unlike(stated):
        raise ConfigError(position.wrong("says", row.says, refused.reason))
    return stated


def _unlike(stated: StatedValue) -> Refused | None:
    """Return a problem if the words of a row differ from its numbers, None if not."""
    figures = [*figures_of(stated.row.says)]
    kind, size = TEXT_UNITS.get(stated.unit, ("", 1.0))
    if not any(figure.is_of(stated.target, kind, size) for figure in figures):
        return Refused(f"has no figure that is {stated.target:g} {stated.unit}")
    strange = [
        each.text for each in figures if each.kind in JUDGED_KINDS and not stated.states(each)
    ]
    return Refused(f"{quote(strange[0])} is no number of this row") if strange else None


def _lacking(row: StatedRow, position: Position) -> Iterator[str]:
    """Yield the keys that a row lacks, and those that do not go together."""
    if (row.when is None) == (row.quantity is None):
        yield position.problem("give one of when, quantity")
    elif row.when is not None and row.at_s is None:
        yield position.problem("lacks at_s: the moment that when first holds")
    elif row.when is not None and (row.measure or row.value is not None):
        yield position.problem("measure and value go with quantity")
    elif row.quantity is not None and (row.measure is None or row.value is None):
        yield position.problem("lacks measure, value: quantity goes with both")
    elif row.quantity is not None and (row.measure == "value") != (row.at_s is not None):
        yield position.problem('at_s goes with when, or with measure = "value"')
