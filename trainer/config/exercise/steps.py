"""The steps of a lesson: what to do, and the conditions that end it.

An exercise with ``[[steps]]`` leads who trains by himself, one step after the other. Orders in
backquotes in a text are what he types, so a check can do exactly what the text says.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from trainer.config.exercise.derived import ALL_QUANTITIES, Condition, compile_condition
from trainer.config.files import ConfigError, Position, collecting, raise_problems
from trainer.config.schema import (
    Choice,
    Rows,
    Text,
    Texts,
    above,
    optional,
    required,
    with_default,
    within,
)
from trainer.config.world.sound_rows import Readers, sound_rows
from trainer.io.orders.grammar import Order, parse, to_the_crew
from trainer.io.orders.words import ORDER_WORDS

LIGHTED_INSTRUMENTS: Final = (  # that a step may light up
    *("depth", "heading", "speed", "pitch", "rudder", "stern", "bow", "bell", "tanks"),
)
MISSED_AGAIN, MISSED_ON = "again", "on"
GIVEN_ORDERS: Final = frozenset(  # by the exercise
    name for name, word in ORDER_WORDS.items() if word.planned and word.journalled
)
TYPED_ORDER: Final = re.compile(r"`([^`]+)`")


@dataclass(frozen=True, kw_only=True)
class StepRow:
    """One step as it stands in the file."""

    text: str = required(Text(300, "what to do; what is to be typed stands in backquotes"))
    when: tuple[str, ...] = required(
        Texts(Text(79, "conditions that end it, all at once: stern_deg > 4"), 8)
    )
    for_s: float = with_default(0.0, "s", within(0, 600), "how long they have to hold")
    within_s: float = with_default(90.0, "s", above(0, 3600), "after this time it is missed")
    missed: str | None = optional(
        Choice((MISSED_AGAIN, MISSED_ON), "back to its beginning, twice at most, or on; else on")
    )
    hint: str | None = optional(Text(200, "what helps, if it takes long"))
    hint_after_s: float = with_default(20.0, "s", within(0, 3600), "when the hint comes")
    light: str | None = optional(Choice(LIGHTED_INSTRUMENTS, "the instrument to look at"))
    orders: tuple[str, ...] | None = optional(
        Texts(Text(80, "given as it begins: order course 020, casualty stern-stuck"), 8)
    )


STEP_ROWS: Final = Rows(StepRow, ("note",), 0, 60, "steps that lead a trainee, below")


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step, its words understood."""

    row: StepRow
    conditions: tuple[Condition, ...]
    typed: tuple[Order, ...]  # by the trainee, if he does what the text says
    given: tuple[Order, ...]  # by the exercise, as the step begins


def read_steps(table: Mapping[str, object], position: Position) -> tuple[Step, ...]:
    """Return the steps of an exercise file; ConfigError with all that is wrong."""
    problems: list[str] = []
    steps: list[Step] = []
    readers: Readers = {}
    array = position.inside("steps")
    for _, inside, row in sound_rows(STEP_ROWS, table.get("steps", []), array, readers, problems):
        with collecting(problems):
            steps.append(_read_step(row, inside))
    raise_problems(problems)
    return tuple(steps)


def _read_step(row: StepRow, position: Position) -> Step:
    """Return one step; ConfigError with all that is wrong in it."""
    problems: list[str] = []
    conditions: list[Condition] = []
    for text in row.when:
        with collecting(problems):
            conditions.append(compile_condition(text, position, ALL_QUANTITIES))
    problems += [
        position.problem(f'when = "{one.text}", "{other.text}": cannot hold at once: it never ends')
        for one, other in combinations(conditions, 2)
        if _exclude(one, other)
    ]
    if row.for_s >= row.within_s:
        problems.append(
            position.wrong("for_s", row.for_s, "is not less than within_s: it never ends")
        )
    if row.hint and row.hint_after_s >= row.within_s:
        problems.append(position.wrong("hint_after_s", row.hint_after_s, "is not before within_s"))
    orders: dict[str, list[Order]] = {"text": [], "orders": []}
    for key, texts in (("text", TYPED_ORDER.findall(row.text)), ("orders", row.orders or ())):
        for text in texts:
            with collecting(problems):
                orders[key].append(_read_order(key, text, position))
    raise_problems(problems)
    return Step(
        row=row,
        conditions=tuple(conditions),
        typed=tuple(orders["text"]),
        given=tuple(map(to_the_crew, orders["orders"])),
    )


def _exclude(one: Condition, other: Condition) -> bool:
    """Return whether two conditions on one quantity leave no value."""
    if one.quantity != other.quantity or one.sense == other.sense:
        return False
    low, high = (one, other) if one.sense > 0.0 else (other, one)
    if low.threshold == high.threshold:
        return low.strict or high.strict
    return low.threshold > high.threshold


def _read_order(key: str, text: str, position: Position) -> Order:
    """Return an order of a step; ConfigError if it is none, or none of a schedule."""
    order = parse(text)
    if not isinstance(order, Order):
        raise ConfigError(position.wrong(key, text, order.reason if order else "is no order"))
    if key == "orders" and order.name not in GIVEN_ORDERS:
        raise ConfigError(position.wrong(key, text, "has no place in a step"))
    return order
