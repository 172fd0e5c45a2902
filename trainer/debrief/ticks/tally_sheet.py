"""The rules of a plan as rows of numbers, for ``tallies``.

``tick_judge`` has them taken into account by ``tallies``. A row says which columns of the state a
rule looks at, and what counts there.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.casualties import scale_of
from trainer.boat.depths import HULL_REACH
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.derived import DERIVED_QUANTITIES, Condition
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.score_rules import COURSE_QUANTITY, ORDERED_QUANTITIES, ScoreRule
from trainer.config.files import ConfigError
from trainer.core.casualties import CODES
from trainer.core.kernel import Numbers
from trainer.core.surfaces import SURFACES
from trainer.debrief.marks.gates import FULL_EXCESS, LEAST_EXCESS
from trainer.debrief.marks.judgement import TURNED_HEEL, TURNED_PITCH, widen_rules
from trainer.debrief.marks.measures import (
    HELD_TIME_S,
    LIMIT_QUANTITIES,
    NEAREST_RANGE,
    PLANE_NAMES,
    SETTLING_WINDOW_S,
)
from trainer.debrief.passage.trajectory import (
    CASUALTY_SLOTS,
    QUANTITY_FUNCTIONS,
    Trajectory,
    missing_quantities,
)
from trainer.debrief.ticks import tallies
from trainer.debrief.ticks.tallies import MEASURE_NAMES, TALLY_CONDITION, TALLY_RULE
from trainer.io.orders.grammar import Refused
from trainer.session.past.plan import Plan

PART_CODES: Final = {"task": tallies.TASK, "answer": tallies.ANSWER, "keeping": tallies.KEEPING}
TRAVEL_COLUMNS: Final = (
    *(f"delta_{letter}" for letter in SURFACES.values()),
    *(f"{name}_by_hand" for name in SURFACES),
)
WAY_COLUMNS: Final = ("x", "y")
# what is made of a boat's numbers, the ships near and its periscope
SHIP_COLUMNS: Final = ("nearest", "struck", "head_out", "raise", "eye")
SHOWN_ROWS: Final[Mapping[str, Mapping[str, str]]] = {
    "closest-approach": {"column": "nearest"},
    "exposed": {"column": "head_out"},
    "exposed-raise": {"column": "head_out", "aim": "raise"},
}
LOOK_OUT_MEASURES: Final = ("time-to-detect", "time-to-report")
WRITTEN_MEASURES: Final = ("aground", *LOOK_OUT_MEASURES)  # of whole windows alone
NO_ROW: Final = {"aim": -1.0, "end": math.inf, "target": math.nan, "size": 1.0, "sense": 1.0}
SIZELESS_LIMITS: Final = ("pitch_deg", "heel_deg")  # that hold either way

Row = dict[str, Any]  # of TALLY_RULE or TALLY_CONDITION; a name or a tuple of names is a column


@dataclass(frozen=True)
class TallySheet:
    """The rules that count, their rows, and the columns that these look at."""

    rules: tuple[ScoreRule, ...]  # of the first rows, one each; then come what caps the marks
    rows: Any  # [rows] of TALLY_RULE
    conditions: Any  # of TALLY_CONDITION
    reads: tuple[str, ...]  # fields of the state, the tick first
    derived: tuple[str, ...]  # quantities that are made from them, in the columns behind
    of_ships: tuple[str, ...]  # and those of SHIP_COLUMNS, behind these
    window: int  # [ticks] in which a boat has to have settled
    rings: int  # how many rows remember such a window


def lay_out(plan: Plan, boat: Boat, width: str, also: Sequence[str] = ()) -> TallySheet:
    """Return the sheet of a plan, which reads ``also`` these fields of the state.

    ConfigError naming what numbers cannot judge.
    """
    refuse_plan(plan)
    rules = tuple(
        each for each in widen_rules(plan.scores, width) if not missing_quantities(boat, each)
    )
    held: list[Row] = []
    step = plan.method.step
    window = round(SETTLING_WINDOW_S / step) + 1
    rows = [_rule_row(rule, boat, held) for rule in rules]
    settled = [row for row in rows if row["measure"] == tallies.SETTLED]
    for ring, row in enumerate(settled):
        row |= {"ring": ring, "needed": window}
    rows += [*_gate_rows(plan, boat), *_loss_rows(plan, boat, held), *_world_rows(plan)]
    named = [value for row in (*rows, *held) for value in row.values()]
    singles = [name for name in dict.fromkeys(named) if isinstance(name, str)]
    groups = [names for names in dict.fromkeys(named) if isinstance(names, tuple)]
    of_ships = [name for name in singles if name in SHIP_COLUMNS]
    derived = [name for name in singles if _is_derived(name) and name not in of_ships]
    made = {*of_ships, *derived}
    read = ["tick", *singles, *_sources(boat, derived), *also]
    fields_read = [name for name in dict.fromkeys(read) if name not in made]
    places: dict[Any, int] = {name: i for i, name in enumerate(fields_read)}
    for group in groups:
        places[group] = len(fields_read)
        fields_read += group
    places |= {name: len(fields_read) + i for i, name in enumerate((*derived, *of_ships))}
    return TallySheet(
        rules,
        _table(TALLY_RULE, [NO_ROW | {"step": step} | row for row in rows], places),
        _table(TALLY_CONDITION, held or [{}], places),
        tuple(fields_read),
        tuple(derived),
        tuple(of_ships),
        window,
        max(len(settled), 1),
    )


def refuse_plan(plan: Plan) -> None:
    """Raise ConfigError naming what numbers of one boat cannot judge."""
    for rule in plan.scores:
        name, chosen = rule.score.measure, bool(rule.conditions)
        written = name in WRITTEN_MEASURES and (chosen or rule.since is not None)
        if name not in MEASURE_NAMES or (name == "settled" and chosen) or written:
            only = "" if name not in MEASURE_NAMES else ", where it has a condition,"
            raise ConfigError(
                f"{plan.title}: {rule.score.name}: {name}{only} takes more than numbers tick by "
                "tick, so only the debrief judges it"
            )
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
        if rule.score.measure == "response":
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


def _is_derived(quantity: str) -> bool:
    return quantity in DERIVED_QUANTITIES and quantity != COURSE_QUANTITY


def _column(boat: Boat, quantity: str) -> Row:
    """Return the column of a quantity, and its size [SI]."""
    if _is_derived(quantity):
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
    if rule.measured and score.measure != "activity":
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
        row |= {"slots": TRAVEL_COLUMNS, "slot_count": len(SURFACES), "surfaces": sum(bits)}
    if score.measure == "distance":
        row["column"] = WAY_COLUMNS
    row |= SHOWN_ROWS.get(score.measure, {})
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


def _gate_rows(plan: Plan, boat: Boat) -> list[Row]:
    """Return the rows of the limits, as ``gates`` has them."""
    rows = []
    for name in (item.name for item in fields(plan.limits)):
        key, _, end = name.rpartition("_")
        limit = getattr(plan.limits, name)
        if limit is None or key not in (*LIMIT_QUANTITIES, NEAREST_RANGE):
            continue
        row: Row = {"measure": tallies.GATE, "target": limit, "column": "nearest", "size": 1.0}
        if key != NEAREST_RANGE:
            what = LIMIT_QUANTITIES[key]
            row |= _column(boat, what.name)
            row["size"] *= what.size
        row["sense"] = 1.0 if end == "max" else -1.0
        row |= {"absolute": float(key in SIZELESS_LIMITS)}
        rows.append(row | {"band": max(FULL_EXCESS * abs(limit), LEAST_EXCESS[key])})
    return rows


def _loss_rows(plan: Plan, boat: Boat, held: list[Row]) -> list[Row]:
    """Return the rows of what loses the exercise, and of the boat's own ends."""
    rows: list[Row] = [
        {"measure": tallies.LOSS, "needed": each.seconds, "column": "z"}
        | _held(each.conditions, boat, held)
        for each in plan.lost
    ]
    for column, limit in (("theta", TURNED_PITCH), ("phi", TURNED_HEEL)):
        rows.append({"measure": tallies.TURNED, "column": column, "target": limit})
    hull = plan.file.hull
    if hull.collapse_depth_m is not None:
        ends = {"aim": "theta", "band": HULL_REACH * hull.length}
        depth = {"column": "z", "target": hull.collapse_depth_m}
        rows.append({"measure": tallies.COLLAPSED, **depth, **ends})
    return rows


def _world_rows(plan: Plan) -> list[Row]:
    """Return the rows of what ground and ships end or cap, as ``judgement`` and ``gates`` do."""
    rows: list[Row] = []
    bottom, encounters = plan.around.get("bottom"), plan.around.get("contacts")
    if bottom is not None:
        rows.append({"measure": tallies.HARD, "column": "z"})
        own = plan.world.get("bottom")
        if own is not None and own.grounding == "end":
            rows.append({"measure": tallies.GROUNDED, "column": "z"})
        if own is not None and own.bottoming:
            rows.append({"measure": tallies.LAID_BADLY, "column": "z"})
    if encounters is not None and encounters.collision == "end":
        rows.append({"measure": tallies.STRUCK, "column": "struck", "target": 0.5})
    return rows


class AskedColumns(dict[str, Numbers]):
    """Columns of a single row, which notes those that are asked for."""

    def __missing__(self, name: str) -> Numbers:
        self[name] = np.zeros(1)
        return self[name]


def _sources(boat: Boat, derived: Sequence[str]) -> list[str]:
    """Return the fields of the state from which quantities are made."""
    columns = AskedColumns()
    for name in derived:
        QUANTITY_FUNCTIONS[name](passage_of(boat, columns, 1))
    return list(columns)


def passage_of(boat: Boat, columns: Mapping[str, Numbers], count: int) -> Trajectory:
    """Return a passage of so many rows, for quantities that are made of several columns."""
    none = np.full(count, np.nan)
    ticks = np.arange(count, dtype=np.int64)
    return Trajectory(boat, ExerciseLimits(), (), ticks, columns, none, none)
