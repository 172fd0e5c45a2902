"""The rules of a plan as rows of numbers, for ``tallies``.

``tallies`` takes ticks into account by them, for ``scoring`` and ``ticks/judge``. A row says which
columns of the state a rule looks at, and what counts there.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.casualties import scale_of
from trainer.boat.entries import GIVEN_ROWS, GIVEN_SIZE, Entry, RecordRow
from trainer.boat.limits import RECALL_COVER_M
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.derived import Condition, Loss
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.score_rules import (
    ANSWER_MEASURES,
    COURSE_QUANTITY,
    ORDERED_QUANTITIES,
    ScoreRule,
)
from trainer.config.files import ConfigError
from trainer.core.casualties import CODES
from trainer.core.kernel import Numbers
from trainer.core.surfaces import SURFACES
from trainer.debrief.marks import tallies
from trainer.debrief.marks.mark_numbers import (
    FULL_EXCESS,
    GATE_TIME_S,
    HELD_TIME_S,
    LEAST_EXCESS,
    SETTLING_WINDOW_S,
    TURNED_HEEL,
    TURNED_PITCH,
)
from trainer.debrief.marks.measures import (
    AIR_COLUMNS,
    LIMIT_QUANTITIES,
    MADE_COLUMNS,
    NEAREST_RANGE,
    PLANE_NAMES,
    air_banks,
    lacking,
    limits_of,
)
from trainer.debrief.marks.tallies import MEASURE_NAMES, TALLY, TALLY_CONDITION, TALLY_RULE
from trainer.debrief.passage.trajectory import CASUALTY_SLOTS, Trajectory
from trainer.io.orders.grammar import Refused
from trainer.session.past.plan import Plan

PART_CODES: Final = {"task": tallies.TASK, "answer": tallies.ANSWER, "keeping": tallies.KEEPING}
TRAVEL_COLUMNS: Final = (
    *(f"delta_{letter}" for letter in SURFACES.values()),
    *(f"{name}_by_hand" for name in SURFACES),
)
# what is made of a boat's numbers, the ships near and its periscope
SHIP_COLUMNS: Final = ("nearest", "struck", "head_out", "raise", "eye")
COLUMN_ROWS: Final[Mapping[str, Mapping[str, str]]] = {
    "closest-approach": {"column": "nearest"},
    "exposed": {"column": "head_out"},
    "exposed-raise": {"column": "head_out", "aim": "raise"},
    "beyond-test-depth": {"column": "over_test_depth"},
    "time-beyond-test-depth": {"column": "over_test_depth"},
}
LOOK_OUT_MEASURES: Final = ("time-to-detect", "time-to-report")
NO_ROW: Final = {"aim": -1.0, "end": math.inf, "target": math.nan, "size": 1.0, "sense": 1.0}
SIZELESS_LIMITS: Final = ("pitch_deg", "heel_deg")  # that hold either way

Row = dict[str, Any]  # of TALLY_RULE or TALLY_CONDITION; a name or a tuple of names is a column


# the kernel as ``machine_code`` calls it, whose object is no part of the core's
ENTRIES: Final = (
    Entry(
        tallies.take_ticks,
        (
            *(RecordRow(TALLY_RULE), RecordRow(TALLY_CONDITION), GIVEN_ROWS),
            *(RecordRow(TALLY), GIVEN_ROWS, (GIVEN_SIZE, tallies.TOTALS)),
        ),
        many_ticks=True,
    ),
)


@dataclass(frozen=True)
class TallySheet:
    """The rules that count, their rows, and the columns that these look at."""

    rules: tuple[ScoreRule, ...]  # of the first rows, one each; then comes what caps the marks
    caps: tuple[Any, ...]  # the key of a limit, a loss, or "" for each of these
    rows: Any  # [rows] of TALLY_RULE
    conditions: Any  # of TALLY_CONDITION
    reads: tuple[str, ...]  # fields of the state, the tick first
    derived: tuple[str, ...]  # quantities that are made from them, in the columns behind
    of_ships: tuple[str, ...]  # and those of SHIP_COLUMNS, behind these
    window: int  # [ticks] in which a boat has to have settled
    rings: int  # how many rows remember such a window


def lay_out(
    rules: Sequence[ScoreRule],
    boat: Boat,
    limits: ExerciseLimits,
    plan: Plan | None = None,
    also: Sequence[str] = (),
) -> TallySheet:
    """Return the sheet of the rules that a boat has all for.

    It reads ``also`` these fields. With a plan it has the rows of what loses the plan's exercise.
    """
    judged = tuple(each for each in rules if not lacking(boat, each))
    held: list[Row] = []
    step = boat.method.step
    window = round(SETTLING_WINDOW_S / step) + 1
    rows = [_rule_row(rule, boat, held) for rule in judged]
    settled = [row for row in rows if row["measure"] == tallies.SETTLED]
    for ring, row in enumerate(settled):
        row["ring"] = ring
    caps: list[tuple[Any, Row]] = [*_gate_rows(limits, boat), *_own_end_rows(boat)]
    if plan is not None:
        caps += [*_loss_rows(plan, boat, held), *_world_rows(plan)]
    rows += [row for _, row in caps]
    named = [value for row in (*rows, *held) for value in row.values()]
    singles = [name for name in dict.fromkeys(named) if isinstance(name, str)]
    groups = [names for names in dict.fromkeys(named) if isinstance(names, tuple)]
    of_ships = [name for name in singles if name in SHIP_COLUMNS]
    derived = [name for name in singles if _is_made(name) and name not in of_ships]
    made = {*of_ships, *derived}
    read = ["tick", *singles, *_sources(boat, derived), *also]
    fields_read = [name for name in dict.fromkeys(read) if name not in made]
    places: dict[Any, int] = {name: i for i, name in enumerate(fields_read)}
    for group in groups:
        places[group] = len(fields_read)
        fields_read += group
    places |= {name: len(fields_read) + i for i, name in enumerate((*derived, *of_ships))}
    moment = round(HELD_TIME_S / step)
    return TallySheet(
        judged,
        tuple(name for name, _ in caps),
        _table(
            TALLY_RULE, [NO_ROW | {"step": step, "moment": moment} | row for row in rows], places
        ),
        _table(TALLY_CONDITION, held or [{}], places),
        tuple(fields_read),
        tuple(derived),
        tuple(of_ships),
        window,
        max(len(settled), 1),
    )


def conditions_hold(sheet: TallySheet, r: int, rows: Numbers) -> Any:
    """Return in which of some rows [..., columns] the conditions of a rule hold."""
    first, holds = int(sheet.rows[r]["first_condition"]), np.ones(rows.shape[:-1], bool)
    for each in sheet.conditions[first : first + int(sheet.rows[r]["conditions"])]:
        value = rows[..., int(each["column"])] / each["size"]
        value = value % each["around"] if each["around"] else value
        above = each["sense"] * (value - each["threshold"])
        holds &= above > 0.0 if each["strict"] else above >= 0.0
    return holds


def begin_tallies(taken: Any, rings: Numbers) -> None:
    """Begin the tallies of one boat, and what they remember of its last ticks."""
    taken[:] = np.zeros((), TALLY)
    taken["at"] = -1.0
    taken["answered"] = np.nan
    rings[:] = np.nan


def refuse_plan(plan: Plan) -> None:
    """Raise ConfigError naming what numbers of one boat cannot judge."""
    if any(entry.order.name == "contact" for entry in plan.schedule):
        raise ConfigError(
            f"{plan.title}: its schedule orders ships, and those of all boats are the same"
        )
    if not plan.judged_by_tasks or plan.duration is None:
        raise ConfigError(f"{plan.title or 'no exercise'}: there are no tasks with an end to judge")


def forbids_numbers(plan: Plan) -> Refused | None:
    """Return why an exercise cannot be flown and judged by numbers, None if it can."""
    try:
        refuse_plan(plan)
        refuse_words(plan)
    except ConfigError as why:
        return Refused(str(why).removeprefix(f"{plan.title}: "))
    return None


def refuse_words(plan: Plan) -> None:
    """Raise ConfigError where an exercise asks for words, or hides what numbers show."""
    for rule in plan.scores:
        if rule.score.measure in ANSWER_MEASURES:
            raise ConfigError(
                f"{plan.title}: {rule.score.name}: an answer is an order in words, and numbers are "
                "given at every step"
            )
    for entry in plan.schedule:
        if entry.order.name in WORLD_PARTS:
            raise ConfigError(
                f"{plan.title}: its schedule orders {entry.order.text}, and the world is one for "
                "all boats"
            )
    if plan.hides:
        raise ConfigError(f"{plan.title}: its casualties deceive the gauges, and numbers do not")


def _table(dtype: np.dtype, rows: Sequence[Row], places: Mapping[Any, int]) -> Any:
    """Return rows as records, their columns found."""
    table = np.zeros(len(rows), dtype)
    for record, row in zip(table, rows, strict=True):
        for name, value in row.items():
            record[name] = places[value] if isinstance(value, str | tuple) else value
    return table


def _is_made(quantity: str) -> bool:
    return quantity in MADE_COLUMNS and quantity != COURSE_QUANTITY


def _column(boat: Boat, quantity: str) -> Row:
    """Return the column of a quantity, and its size [SI]."""
    if _is_made(quantity):
        return {"column": quantity, "size": 1.0}
    if quantity == COURSE_QUANTITY:
        return {"column": "psi", "size": 1.0}
    return {"column": STATE_QUANTITIES[quantity].field, "size": scale_of(boat, quantity)}


def _rule_row(rule: ScoreRule, boat: Boat, held: list[Row]) -> Row:
    """Return the row of a rule; its conditions come to those ``held``."""
    score, step = rule.score, boat.method.step
    row: Row = {
        "measure": MEASURE_NAMES.index(score.measure),
        "part": PART_CODES[rule.part],
        "band": score.band or 0.0,
        "begin": (score.from_s or 0.0) / step,
        "end": math.inf if score.to_s is None else score.to_s / step,
        "full": score.full,
        "zero": score.zero,
        "weight": rule.weight,
        "needed": math.ceil(HELD_TIME_S / step - 1e-9),
        **_held(rule.conditions, boat, held),
    }
    if score.measure == "reserve-air":
        row["column"] = AIR_COLUMNS[air_banks(rule)]
    elif rule.measured and score.measure != "activity":
        row |= _column(boat, rule.measured.name)
        row["size"] *= rule.measured.size
        row["around"] = math.tau / rule.measured.size * (rule.measured.name == COURSE_QUANTITY)
    if score.target is not None:
        row["target"] = score.target
    elif rule.measured and score.measure in tallies.AIMED_MEASURES:
        row["aim"] = ORDERED_QUANTITIES[rule.measured.name]
    if score.measure in ("activity", "hand-travel"):
        named: tuple[str, ...] = (rule.measured.name,) if rule.measured else PLANE_NAMES
        named = named if score.measure == "activity" else tuple(SURFACES)
        bits = (1 << i for i, name in enumerate(SURFACES) if name in named and boat.carries(name))
        row |= {"angles": TRAVEL_COLUMNS, "angle_count": len(SURFACES), "surfaces": sum(bits)}
    if score.measure == "distance":
        row |= {"column": "x", "aim": "y"}
    if score.measure == "broaches":
        row |= {"column": "showing", "aim": "surfacing", "band": RECALL_COVER_M}
    row |= COLUMN_ROWS.get(score.measure, {})
    casualty = rule.casualty or rule.since
    if casualty is not None:
        codes = {"since": CODES[casualty.kind], "slot_count": len(CASUALTY_SLOTS)}
        row |= {"slots": CASUALTY_SLOTS, **codes}
    return row


def _held(conditions: Sequence[Condition], boat: Boat, held: list[Row]) -> Row:
    """Add conditions to those held; return where they are."""
    first = len(held)
    for each in conditions:
        course = each.quantity == COURSE_QUANTITY
        held.append(
            _column(boat, each.quantity)
            | {"around": math.tau * course, "sense": each.sense, "strict": float(each.strict)}
            | {"threshold": each.threshold}
        )
    return {"first_condition": first, "conditions": len(conditions)}


def _gate_rows(limits: ExerciseLimits, boat: Boat) -> Iterator[tuple[str, Row]]:
    """Yield the rows of the limits, by their keys."""
    for name in limits_of(limits):
        key, _, end = name.rpartition("_")
        limit = getattr(limits, name)
        row: Row = {"measure": tallies.GATE, "target": limit, "column": "nearest", "size": 1.0}
        if key != NEAREST_RANGE:
            what = LIMIT_QUANTITIES[key]
            row |= _column(boat, what.name)
            row["size"] *= what.size
        row["sense"] = 1.0 if end == "max" else -1.0
        row |= {"absolute": float(key in SIZELESS_LIMITS), "needed": GATE_TIME_S}
        yield name, row | {"band": max(FULL_EXCESS * abs(limit), LEAST_EXCESS[key])}


def _own_end_rows(boat: Boat) -> Iterator[tuple[str, Row]]:
    """Yield the rows of the boat's own ends."""
    for column, limit in (("theta", TURNED_PITCH), ("phi", TURNED_HEEL)):
        yield "", {"measure": tallies.TURNED, "column": column, "target": limit}
    if (depth := boat.file.hull.collapse_depth_m) is not None:
        crushed = math.nextafter(depth, -math.inf)  # at that depth already
        yield "", {"measure": tallies.COLLAPSED, "column": "hull_depth", "target": crushed}


def _loss_rows(plan: Plan, boat: Boat, held: list[Row]) -> Iterator[tuple[Loss, Row]]:
    """Yield the rows of what loses the exercise."""
    for each in plan.lost:
        row: Row = {"measure": tallies.LOSS, "needed": each.seconds, "column": "z"}
        yield each, row | _held(each.conditions, boat, held)


def _world_rows(plan: Plan) -> Iterator[tuple[str, Row]]:
    """Yield the rows of what ground and ships end or cap."""
    bottom, encounters = plan.around.get("bottom"), plan.around.get("contacts")
    if bottom is not None:
        yield "", {"measure": tallies.HARD, "column": "z"}
        own = plan.world.get("bottom")
        if own is not None and own.grounding == "end":
            yield "", {"measure": tallies.GROUNDED, "column": "z"}
        if own is not None and own.bottoming:
            yield "", {"measure": tallies.LAID_BADLY, "column": "z"}
    if encounters is not None and encounters.collision == "end":
        yield "", {"measure": tallies.STRUCK, "column": "struck", "target": 0.5}


class AskedColumns(dict[str, Numbers]):
    """Columns of a single row, which notes those that are asked for."""

    def __missing__(self, name: str) -> Numbers:
        self[name] = np.zeros(1)
        return self[name]


def _sources(boat: Boat, derived: Sequence[str]) -> list[str]:
    """Return the fields of the state from which quantities are made."""
    columns = AskedColumns()
    for name in derived:
        MADE_COLUMNS[name](passage_of(boat, columns, 1))
    return list(columns)


def passage_of(boat: Boat, columns: Mapping[str, Numbers], count: int) -> Trajectory:
    """Return a passage of so many rows, for quantities that are made of several columns."""
    none = np.full(count, np.nan)
    ticks = np.arange(count, dtype=np.int64)
    return Trajectory(boat, ExerciseLimits(), (), ticks, columns, none, none)
