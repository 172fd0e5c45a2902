"""The measures by name, and the tables ``[[scores]]`` that are checked against them.

A measure is one number of a run, such as ``overshoot``; a rule says what is measured, and which
values earn all marks and none. ``exercise`` reads rules here, and ``debrief/marks/tallies`` counts
each measure tick by tick. The formula stands beside the name, in words, because a crew is shown
how its marks came about.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

from trainer.config.boat.casualties import Casualty
from trainer.config.exercise.derived import (
    ALL_QUANTITIES,
    Condition,
    compile_conditions,
    parse_name,
)
from trainer.config.exercise.derived import nearest_quantity as guess
from trainer.config.files import ConfigError, Position, collecting, nearest, raise_problems
from trainer.config.schema import (
    Choice,
    Choices,
    Quantity,
    Rows,
    Text,
    above,
    optional,
    required,
    within,
)
from trainer.config.world.sound_rows import Readers, sound_rows
from trainer.core.surfaces import SURFACES
from trainer.io.orders.schedule import MAX_TIME_S
from trainer.io.orders.words import ORDER_WORDS, Obeyer

RULES_FORM: Final = "3"  # of the rules of marking; counted up where a run's marks would change
OWN_UNIT: Final = ""  # the unit of a measure that is a quantity's
COURSE_QUANTITY: Final = "course"  # a quantity beside those of conditions: it goes round
ORDERED_QUANTITIES: Final[Mapping[str, str]] = {  # offsets of the state that hold what is ordered
    "depth": "ordered_depth",
    COURSE_QUANTITY: "ordered_psi",
    "speed": "ordered_speed",
}
AIR_BANKS: Final = ("bank_main", "bank_emergency")
ALERT_RANKS: Final = ("alarm", "warning")  # that somebody has to acknowledge
ANSWER_MEASURES: Final = ("response", "alert-response")  # else task is the part
TIMELESS_MEASURES: Final = ("response",)  # they take the whole record, without a window
WINDOW_KEYS: Final = ("since", "from_s", "to_s", "when")
VALUE_LIMITS: Final = within(-1e9, 1e9)
HINT_ORDER: Final = "hint"
MARK_PARTS: Final = ("task", "answer", "keeping")
# Only these answer a casualty: the rest is the instructor's to give, or only words.
ANSWER_ORDERS: Final = tuple(
    sorted(w.name for w in ORDER_WORDS.values() if w.obeyer is Obeyer.BOAT and w.control.roles)
)
VALUE_MEASURES: Final = ("final", "largest")  # of the quantity itself, if there is no target
# Keys that only some measures take.
OPTIONAL_KEYS: Final = ("quantity", "target", "band", "casualty", "orders", "rank", *WINDOW_KEYS)


@dataclass(frozen=True)
class ScoreMeasure:
    """One measure: what a rule must and may say, its unit, and its formula."""

    unit: str  # OWN_UNIT: that of the quantity
    formula: str  # {q} the quantity, {t} its target, {b} its band, {c} the casualty, {k} the rank
    moment: str  # which moment is told
    needs: tuple[str, ...] = ()
    may: tuple[str, ...] = ()
    quantities: tuple[str, ...] = ()  # the only ones it takes; () any


SCORE_MEASURES: Final[Mapping[str, ScoreMeasure]] = {
    "overshoot": ScoreMeasure(
        OWN_UNIT,
        "furthest of {q} beyond {t}, seen from where it began; no value short of it{by}",
        "the furthest",
        needs=("quantity", "target"),
        may=("band",),
    ),
    "time-to": ScoreMeasure(
        "s",
        "time until {q} is within {b} of {t}, for 30 s or to the end; where a window ends "
        "before, at its mean pace",
        "when it is",
        needs=("quantity", "target", "band"),
    ),
    "reach": ScoreMeasure(
        "s",
        "time until {q} is within {b} of {t}, for 30 s or to the end; where a window ends "
        "before, at its mean pace; no value if it was there at once",
        "when it is",
        needs=("quantity", "target", "band"),
    ),
    "settled": ScoreMeasure(
        "%",
        "share of the last 120 s with {q} within {b} of {t}, in part to half as far again; "
        "no value if it was there at once",
        "the furthest from it",
        needs=("quantity", "target", "band"),
    ),
    "final": ScoreMeasure(
        OWN_UNIT, "{q} at the end{f}", "the end", needs=("quantity",), may=("target",)
    ),
    "rms": ScoreMeasure(
        OWN_UNIT,
        "root of the mean of ({q} - {t})^2, a term for each tick; no value where a condition holds "
        "for less than 30 s",
        "the furthest from it",
        needs=("quantity",),
        may=("target",),
    ),
    "in-band": ScoreMeasure(
        "%",
        "share of the ticks with {q} within {b} of {t}, in part to half as far again; "
        "with a condition of 30 s at least",
        "the furthest from it",
        needs=("quantity", "band"),
        may=("target",),
    ),
    "highest": ScoreMeasure(OWN_UNIT, "greatest {q}", "when it was", needs=("quantity",)),
    "lowest": ScoreMeasure(OWN_UNIT, "least {q}", "when it was", needs=("quantity",)),
    "largest": ScoreMeasure(
        OWN_UNIT, "greatest {q} either way{f}", "when it was", needs=("quantity",), may=("target",)
    ),
    "activity": ScoreMeasure(
        "deg/min",
        "sum of what {q} moved from tick to tick, by the time",
        "the fastest",
        may=("quantity",),
        quantities=tuple(SURFACES),
    ),
    "hand-travel": ScoreMeasure(
        "deg/min",
        "sum of what planes and rudder moved from tick to tick, worked by hand, by the time",
        "the fastest",
    ),
    "distance": ScoreMeasure("m", "sum of the way over the ground from tick to tick", "the last"),
    "closest-approach": ScoreMeasure(
        "m", "least range to any ship, middle to middle, straight between ticks", "when it was"
    ),
    "exposed": ScoreMeasure(
        "s",
        "number of ticks with the periscope's head out of the water, times the step",
        "the first",
    ),
    "exposed-raise": ScoreMeasure(
        "s", "the same of the raise of the mast that has most", "its first"
    ),
    "time-to-detect": ScoreMeasure(
        "s",
        "mean time from when a ship came in sight to a mark of it: `mark contact 045`, within "
        "3 deg; each from full to zero, which a ship not marked has, or not seen that a raised "
        "mast would have shown for 2 min; 30 s more of a ship for each mark of none; no value "
        "where none was marked",
        "the slowest mark",
    ),
    "time-to-report": ScoreMeasure(
        "s",
        "time from when the periscope's head first shows to the crew's first right report of "
        "contacts: `report no close contacts`, as long as no ship is within `cpa_m` of [contacts]; "
        "one that names a contact, such as `report contact 045`, is right at all times",
        "the report",
    ),
    "broaches": ScoreMeasure(
        "-",
        "times that sail or deck came out of the sea, main ballast not being blown",
        "the first",
    ),
    "aground": ScoreMeasure(
        "-",
        "times that the ground carried the boat, not counting where it was laid down well",
        "the first",
    ),
    "beyond-limits": ScoreMeasure(
        "s", "number of ticks beyond any limit of the exercise, times the step", "the first"
    ),
    "beyond-test-depth": ScoreMeasure(
        "m", "furthest that the hull's lowest point was beyond test depth", "the furthest"
    ),
    "time-beyond-test-depth": ScoreMeasure(
        "s",
        "number of ticks with the hull's lowest point beyond test depth, times the step",
        "the first",
    ),
    "response": ScoreMeasure(
        "s",
        "time from the first onset of {c} to the crew's next order{o} that it does not turn round "
        "within 20 s",
        "the order",
        needs=("casualty",),
        may=("orders",),
    ),
    "alert-response": ScoreMeasure(
        "s",
        "mean time from each alert{k} to its acknowledgement; each from full to zero, which one "
        "that nobody acknowledged has",
        "the slowest acknowledgement",
        may=("rank",),
    ),
    "reserve-air": ScoreMeasure(
        "%",
        "least of the air in {q} as a share of full",
        "when it was",
        may=("quantity",),
        quantities=AIR_BANKS,
    ),
}


@dataclass(frozen=True, kw_only=True)
class ScoreRow:
    """One rule as it stands in the file."""

    name: str = required(Text(60, "what is judged, for the debrief"))
    measure: str = required(Text(30, "one of the measures of docs/measures.md"))
    quantity: str | None = optional(Text(40, "what is measured, its unit after it: depth_m"))
    target: float | None = optional(
        Quantity("its own", VALUE_LIMITS, "where it should be; else as ordered at each moment")
    )
    band: float | None = optional(Quantity("its own", above(0, 1e9), "how far off it may be"))
    casualty: str | None = optional(Text(40, "what is to be answered"))
    orders: tuple[str, ...] | None = optional(
        Choices(ANSWER_ORDERS, "which orders answer it, by docs/orders.md; else any")
    )
    rank: str | None = optional(Choice(ALERT_RANKS, "of the alerts; else both"))
    since: str | None = optional(
        Text(40, "a casualty: from_s and to_s count from when it first came; else from the start")
    )
    from_s: float | None = optional(Quantity("s", within(0, MAX_TIME_S), "first moment looked at"))
    to_s: float | None = optional(Quantity("s", within(0, MAX_TIME_S), "last moment looked at"))
    when: str | None = optional(Text(79, "conditions, with and: only moments at which they hold"))
    full: float = required(Quantity("measure's", VALUE_LIMITS, "value that earns full marks"))
    zero: float = required(
        Quantity("measure's", VALUE_LIMITS, "value that earns none; between, in proportion")
    )
    weight: float | None = optional(Quantity("-", above(0, 1000), "in the total; else 1"))
    part: str | None = optional(
        Choice(
            MARK_PARTS,
            "of the marks; else answer for responses, and task for all others",
        )
    )


# Each exercise by hand has this rule, or one of its own with this name. Its width is an estimate:
# reference crews move planes and rudder by up to 20 deg/min, hunting ones by 60 and more.
QUIET_HANDS: Final = ScoreRow(
    name="Quiet hands", measure="hand-travel", full=30.0, zero=90.0, part="keeping"
)
SCORE_ROWS: Final = Rows(ScoreRow, ("note",), 0, 50, "how the crew is judged, below")


@dataclass(frozen=True)
class MeasuredQuantity:
    """A quantity in a unit; ``size`` is the unit's [SI]."""

    name: str
    unit: str
    size: float

    def __str__(self) -> str:
        return self.name.replace("_", " ")


@dataclass(frozen=True, kw_only=True)
class ScoreRule:
    """One rule, its names understood."""

    score: ScoreRow
    measured: MeasuredQuantity | None
    conditions: tuple[Condition, ...]
    casualty: Casualty | None
    since: Casualty | None = None

    @property
    def part(self) -> str:
        """Return which part of the marks it belongs to."""
        return self.score.part or ("answer" if self.score.measure in ANSWER_MEASURES else "task")

    @property
    def weight(self) -> float:
        """Return the weight in the total."""
        return 1.0 if self.score.weight is None else self.score.weight


def with_quiet_hands(rules: tuple[ScoreRule, ...], hand: Collection[str]) -> tuple[ScoreRule, ...]:
    """Return the rules, with QUIET_HANDS where an exercise by hand lacks it."""
    if not (rules and hand) or any(rule.score.name == QUIET_HANDS.name for rule in rules):
        return rules
    return (*rules, ScoreRule(score=QUIET_HANDS, measured=None, conditions=(), casualty=None))


def understand_rule(
    score: ScoreRow, position: Position, known: Mapping[str, Casualty]
) -> ScoreRule:
    """Return the rule of a table, the names in it understood; ConfigError with all faults.

    Whether its keys go with its measure is checked only where an exercise file is read.
    """
    problems: list[str] = []
    measured = None
    conditions: tuple[Condition, ...] = ()
    with collecting(problems):
        measured = score.quantity and parse_quantity(score.quantity, position)
    with collecting(problems):
        conditions = compile_conditions(score.when, position) if score.when else ()
    casualties: dict[str, Casualty | None] = {}
    for key in ("casualty", "since"):
        name = getattr(score, key)
        with collecting(problems):
            casualties[key] = None if name is None else _casualty_named(known, key, name, position)
    if score.full == score.zero:
        problems.append(position.wrong("zero", score.zero, "must not be the value of full"))
    if score.to_s is not None and score.to_s < (score.from_s or 0.0):
        problems.append(position.wrong("to_s", score.to_s, "is before from_s"))
    raise_problems(problems)
    return ScoreRule(score=score, measured=measured or None, conditions=conditions, **casualties)


def _casualty_named(
    known: Mapping[str, Casualty], key: str, name: str, position: Position
) -> Casualty:
    """Return the casualty that a key names; ConfigError if there is none."""
    if name not in known:
        raise ConfigError(position.wrong(key, name, f"no such casualty{nearest(name, known)}"))
    return known[name]


def _refuse_unknown(measure: str, position: Position) -> None:
    """Raise ConfigError if there is no such measure."""
    if measure not in SCORE_MEASURES:
        guess = nearest(measure, SCORE_MEASURES) or f"; there are: {', '.join(SCORE_MEASURES)}"
        raise ConfigError(position.wrong("measure", measure, f"no such measure{guess}"))


SHOWN_UNITS: Final = {"mpa": "MPa", "l": "L", "percent": "%"}  # as people write them


def parse_quantity(text: str, position: Position) -> MeasuredQuantity:
    """Return the quantity that is named, in its unit or else its own. ConfigError if none is."""
    name_and_unit = parse_name(text)
    if name_and_unit is None:
        raise ConfigError(position.wrong("quantity", text, f"no such quantity{guess(text)}"))
    name, unit = name_and_unit
    units = ALL_QUANTITIES[name].units
    unit = unit or next(iter(units))
    return MeasuredQuantity(name, SHOWN_UNITS.get(unit, unit.replace("_", "/")), units[unit])


def read_rules(
    table: Mapping[str, object], position: Position, known: Mapping[str, Casualty]
) -> tuple[ScoreRule, ...]:
    """Return the rules of an exercise file; ConfigError with all that is wrong in them."""
    problems: list[str] = []
    rules: list[ScoreRule] = []
    readers: Readers = {
        "measure": _refuse_unknown,
        "quantity": parse_quantity,
        "when": compile_conditions,
        "casualty": partial(_casualty_named, known, "casualty"),
        "since": partial(_casualty_named, known, "since"),
    }
    rows, array = table.get("scores", []), position.inside("scores")
    for _, inside, score in sound_rows(SCORE_ROWS, rows, array, readers, problems):
        with collecting(problems):
            rules.append(_read_rule(score, inside, known))
    names = [rule.score.name for rule in rules]
    problems += [
        position.problem(f'two [[scores]] have the name "{name}"')
        for name in dict.fromkeys(names)
        if names.count(name) > 1
    ]
    raise_problems(problems)
    return tuple(rules)


def _read_rule(score: ScoreRow, position: Position, known: Mapping[str, Casualty]) -> ScoreRule:
    """Return one rule, its names understood and its keys fit for its measure; ConfigError."""
    problems: list[str] = []
    with collecting(problems):
        rule = understand_rule(score, position, known)
    with collecting(problems):
        _refuse_unknown(score.measure, position)
        problems += _unfit(score, position)
    if not problems:
        problems += _check_target(rule, position)
    raise_problems(problems)
    return rule


def _unfit(score: ScoreRow, position: Position) -> list[str]:
    """Return problems of keys that the measure has no use for, or lacks."""
    measure = SCORE_MEASURES[score.measure]
    timed = () if score.measure in TIMELESS_MEASURES else WINDOW_KEYS
    taken = (*measure.needs, *measure.may, *timed)
    given_keys = [key for key in OPTIONAL_KEYS if getattr(score, key) is not None]
    problems = [
        position.wrong(key, getattr(score, key), f"{score.measure} has no use for it")
        for key in given_keys
        if key not in taken
    ]
    lacking = [key for key in measure.needs if key not in given_keys]
    if lacking:
        problems.append(position.problem(f"{score.measure} lacks {', '.join(lacking)}"))
    return problems


def _check_target(rule: ScoreRule, position: Position) -> list[str]:
    """Return problems of the quantity, or of a target that it lacks."""
    measure, measured, score = SCORE_MEASURES[rule.score.measure], rule.measured, rule.score
    if measured is None:
        return []
    if measure.quantities and measured.name not in measure.quantities:
        message = f"{score.measure} is of {' or '.join(measure.quantities)}"
        return [position.wrong("quantity", score.quantity, message)]
    aims = "target" in measure.may and score.measure not in VALUE_MEASURES
    if score.target is None and aims and measured.name not in ORDERED_QUANTITIES:
        message = f"nobody orders it as such ({', '.join(ORDERED_QUANTITIES)} are): give a target"
        return [position.wrong("quantity", score.quantity, message)]
    return []
