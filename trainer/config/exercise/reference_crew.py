"""The reference crew of an exercise: its rules ``[[crew]]``, and how its hands steer.

A rule has a condition and an order. The crew sees only what its gauges show.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from trainer.config.exercise.derived import Condition, compile_conditions
from trainer.config.exercise.score_rules import ANSWER_ORDERS
from trainer.config.files import ConfigError, Position, collecting, nearest, raise_problems
from trainer.config.schema import (
    Choice,
    Flag,
    Rows,
    Text,
    above,
    optional,
    read_record,
    required,
    with_default,
    within,
)
from trainer.config.world.sound_rows import Readers, sound_rows
from trainer.core.plant.parts import PLACE_NAMES
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import MAX_TIME_S

MARK_ORDER: Final = "mark"  # of a ship that is seen
REPORT_ORDER: Final = "report"
SAID_ORDERS: Final = (MARK_ORDER, REPORT_ORDER)  # which move nothing of the boat
CREW_AXES: Final = ("course", "depth", "speed", "pitch")  # of orders to the crew
UNSEEN_QUANTITIES: Final = (  # by any gauge; of a fire its smoke is seen
    *("heavy", "speed_over_ground", "north", "east"),
    *(f"fire_{name}" for name in PLACE_NAMES),
)
CREW_HANDS: Final = ("planesman", "helmsman")
HAND_SWITCHES: Final = {
    f"{hand} {word}": (hand, word) for hand in CREW_HANDS for word in ("on", "off")
}
CREW_TABLES: Final = ("crew", *CREW_HANDS)


@dataclass(frozen=True, kw_only=True)
class CrewRow:
    """One rule as it stands in the file."""

    order: str = required(Text(80, "as a crew types it; also planesman on, helmsman off and so on"))
    at_s: float | None = optional("s", within(0, MAX_TIME_S), "time from the start")
    when: str | None = optional(Text(79, "conditions, with and, as the gauges show it"))
    ordered: str | None = optional(Choice(CREW_AXES, "each time that the crew is ordered one"))
    after_s: float | None = optional("s", within(0, 3600), "this long after that; else 0")
    then: bool | None = optional(Flag("true: not before the rule above has been carried out"))
    from_s: float | None = optional("s", within(0, MAX_TIME_S), "with when: not before")
    to_s: float | None = optional("s", within(0, MAX_TIME_S), "with when: not later")
    every_s: float | None = optional(
        "s", above(0, 3600), "with when: again after this time, as long as it holds"
    )
    mean_s: float | None = optional(
        "s", above(0, 600), "with when: of the mean of the gauges over this time"
    )


@dataclass(frozen=True, kw_only=True)
class Planesman:
    """How the reference crew works its planes, after ``planesman on``."""

    answer_s: float = with_default(4.0, "s", within(0, 600), "from an order to the first move")
    look_s: float = with_default(5.0, "s", above(0, 60), "from look to look")
    mean_s: float = with_default(0.0, "s", within(0, 60), "depth as the mean over this time")
    bubble_deg_per_m: float = with_default(0.5, "deg/m", within(0, 10), "angle for an error")
    bubble_s: float = with_default(6.0, "deg/(m/s)", within(0, 60), "angle against depth rate")
    bubble_deg_max: float = with_default(7.0, "deg", above(0, 30), "largest angle")
    leave_m: float = with_default(14.0, "m", within(0, 100), "before it, off an ordered angle")
    stern_per_bubble: float = with_default(1.5, "-", within(0, 10), "stern planes for an angle")
    stern_s: float = with_default(10.0, "s", within(0, 60), "stern planes against pitch rate")
    stern_deg_max: float = with_default(25.0, "deg", within(0, 90), "largest")
    stern_off_deg: float = with_default(2.0, "deg", within(0, 30), "less is not worth an order")
    bow_within_m: float = with_default(6.0, "m", within(0, 100), "bow planes inside this error")
    bow_deg_per_m: float = with_default(1.5, "deg/m", within(0, 20), "bow planes for an error")
    bow_s: float = with_default(0.0, "deg/(m/s)", within(0, 90), "bow planes against the rate")
    bow_deg_max: float = with_default(20.0, "deg", within(0, 90), "largest")
    bow_step_deg: float = with_default(3.0, "deg", above(0, 30), "in steps of this")


@dataclass(frozen=True, kw_only=True)
class Helmsman:
    """How the reference crew works its rudder, after ``helmsman on``."""

    answer_s: float = with_default(4.0, "s", within(0, 600), "from an order to the first move")
    look_s: float = with_default(4.0, "s", above(0, 60), "from look to look")
    rudder_per_error: float = with_default(0.6, "-", within(0, 10), "rudder for an error")
    rudder_s: float = with_default(10.0, "s", within(0, 60), "rudder against rate of turn")
    rudder_deg_max: float = with_default(15.0, "deg", within(0, 90), "largest")
    rudder_off_deg: float = with_default(1.0, "deg", within(0, 30), "less is not worth an order")


@dataclass(frozen=True, kw_only=True)
class CrewRule:
    """One rule, its words understood. ``order`` of a hand has its name and on or off."""

    row: CrewRow
    conditions: tuple[Condition, ...]
    order: Order


@dataclass(frozen=True, kw_only=True)
class Crew:
    """A reference crew; without rules there is none."""

    rules: tuple[CrewRule, ...] = ()
    planesman: Planesman = field(default_factory=Planesman)
    helmsman: Helmsman = field(default_factory=Helmsman)


CREW_RULE_ROWS: Final = Rows(CrewRow, ("note",), 0, 200, "what the reference crew does, below")


def read_crew(table: Mapping[str, object], position: Position) -> Crew:
    """Return the reference crew of an exercise file; ConfigError with all that is wrong."""
    problems: list[str] = []
    if isinstance(table.get("crew"), dict):
        raise ConfigError(position.problem("[crew]: one reference crew, its rules [[crew]] each"))
    rules: list[CrewRule] = []
    readers: Readers = {"when": compile_conditions, "order": parse_crew_order}
    array = position.inside("crew")
    for i, inside, row in sound_rows(
        CREW_RULE_ROWS, table.get("crew", []), array, readers, problems
    ):
        with collecting(problems):
            rules.append(_read_rule(row, i, inside))
    ways: dict[str, Any] = {}
    for name, record in (("planesman", Planesman), ("helmsman", Helmsman)):
        with collecting(problems):
            ways[name] = read_record(record, table.get(name, {}), position.inside(name), ("note",))
    # which rules stand twice: two crews in one file
    rows = [rule.row for rule in rules]
    problems += [
        position.inside(f"crew[{i}]").problem(
            f'order = "{row.order}": is a rule above too; an exercise has one reference crew'
        )
        for i, row in enumerate(rows)
        if row in rows[:i] and not row.then
    ]
    raise_problems(problems)
    return Crew(rules=tuple(rules), **ways)


def _read_rule(row: CrewRow, i: int, position: Position) -> CrewRule:
    """Return one rule; ConfigError with all that is wrong in it."""
    problems: list[str] = []
    begins = [key for key in ("at_s", "when", "ordered") if getattr(row, key) is not None]
    if len(begins) > 1 or not (begins or row.then):
        problems.append(position.problem("give one of at_s, when, ordered, or then = true"))
    if row.then and i == 0:
        problems.append(position.wrong("then", row.then, "there is no rule above"))
    problems += [
        position.wrong(key, getattr(row, key), "goes with when")
        for key in ("from_s", "to_s", "every_s", "mean_s")
        if getattr(row, key) is not None and row.when is None
    ]
    conditions: tuple[Condition, ...] = ()
    with collecting(problems):
        conditions = compile_conditions(row.when, position) if row.when else ()
    problems += [
        position.wrong("when", row.when, f"no gauge shows {condition.quantity}")
        for condition in conditions
        if condition.quantity in UNSEEN_QUANTITIES
    ]
    with collecting(problems):
        order = parse_crew_order(row.order, position)
    raise_problems(problems)
    return CrewRule(row=row, conditions=conditions, order=order)


def parse_crew_order(text: str, position: Position) -> Order:
    """Return what a crew can order, or switch; ConfigError if it is neither."""
    words = " ".join(text.split()).lower()
    if words in HAND_SWITCHES:
        hand, word = HAND_SWITCHES[words]
        return Order(hand, 0.0, word, words)
    order = parse(text)
    if not isinstance(order, Order) and nearest(words.split(" ")[0], CREW_HANDS):
        raise ConfigError(
            position.wrong("order", text, f"say on or off{nearest(words, HAND_SWITCHES)}")
        )
    if not isinstance(order, Order):
        raise ConfigError(position.wrong("order", text, order.reason if order else "is no order"))
    if order.name not in (*ANSWER_ORDERS, *SAID_ORDERS):
        raise ConfigError(position.wrong("order", text, "no crew orders that"))
    return order
