"""Exercise files, checked when they are loaded.

What a file leaves out is as in a run without an exercise. ``session/past/plan`` makes a run of an
exercise, and a debrief judges the run by the same rules. All faults of a file are told at once, so
that its author mends them in one go.
"""

# long: one file format, with its tables and their readers
import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from trainer.config.boat.casualties import PARTS_RULE, Casualty, load_casualties, severity_rule
from trainer.config.exercise.derived import Condition, Loss, compile_condition, compile_losses
from trainer.config.exercise.reference_crew import CREW_TABLES, Crew, read_crew
from trainer.config.exercise.score_rules import ScoreRule, read_rules
from trainer.config.exercise.stated import StatedValue, read_stated
from trainer.config.exercise.steps import Step, read_steps
from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    nearest,
    number_problems,
    parse_toml,
    path_named,
    quote,
    raise_problems,
    read_text,
    relative_name,
)
from trainer.config.schema import (
    Choice,
    Choices,
    Flag,
    LongText,
    Quantity,
    Rows,
    Text,
    Texts,
    above,
    optional,
    read_record,
    required,
    with_default,
    within,
)
from trainer.config.words import EQUATION_SETS
from trainer.config.world.sea import Sea, SeaFile, load_sea, read_sea
from trainer.config.world.sound_rows import Readers, sound_rows
from trainer.config.world.world import WORLD_READERS, WorldTables, read_world
from trainer.io.orders.grammar import Order, parse, to_the_crew
from trainer.io.orders.schedule import MAX_TIME_S, ScheduledOrder
from trainer.io.orders.words import AUTOMATIC_ORDERS_BY_AXIS, HAND_AXES, ORDER_WORDS

# ``allowed`` names those that an exercise permits all the same.
AUTOMATIC_ORDERS: Final = tuple(
    dict.fromkeys(name for names in AUTOMATIC_ORDERS_BY_AXIS.values() for name in names)
)
HANDS_BY_CREW_AXIS: Final[Mapping[str, tuple[str, ...]]] = {  # that carry out an order to the crew
    "course": ("rudder",),
    "depth": ("planes", "ballast"),
    "periscope": ("planes", "ballast"),
    "speed": ("speed",),
    "pitch": ("planes", "ballast"),
}
KEPT_AXES: Final = HANDS_BY_CREW_AXIS.keys() - {"pitch"}  # by an order to the autopilot as well
AIDS: Final = ("ghost", "predictor")
EXERCISE_TABLES: Final = (
    "initial",
    "sea",
    "orders",
    "casualties",
    "limits",
    "scores",
    "stated",
    "steps",
    *CREW_TABLES,
    *WORLD_READERS,
)
TIMED_KEYS: Final = {  # what is settled before the run, as when has no time yet
    **dict.fromkeys(("within_s", "one_of"), "goes with at_s"),
    "lasts_s": "goes with at_s: a run is planned before when is known to come; say clear_at_s",
}


@dataclass(frozen=True, kw_only=True)
class ExerciseHeading:
    """The nature of an exercise, and the method by which the boat is computed."""

    schema: str = required(Choice(("exercise/1",), "form of the file"))
    name: str = required(Text(55, "the crew's title, one line for the list of exercises"))
    lesson: float | None = optional(
        Quantity("-", within(1, 999), "place in the course: lists are in this order")
    )
    briefing: str = required(LongText(4000, "what the crew is told at the start"))
    instructor: str | None = optional(
        LongText(4000, "for the instructor alone: what is hidden, the cure")
    )
    hand: tuple[str, ...] | None = optional(Choices(HAND_AXES, "what the crew works by hand"))
    hand_from_s: float | None = optional(Quantity("s", within(0, MAX_TIME_S), "since when; else 0"))
    allowed: tuple[str, ...] | None = optional(
        Choices(AUTOMATIC_ORDERS, "automatic orders that are allowed all the same")
    )
    aids: tuple[str, ...] | None = optional(
        Choices(AIDS, "aids that are allowed; else none with [[scores]], both without")
    )
    hint_marks: float = with_default(5.0, "-", within(0, 100), "marks that each hint costs; else 5")
    light: str | None = optional(
        Choice(("day", "dusk", "night"), "what the periscope sees by; else day")
    )
    guard_depth_m: float | None = optional(
        Quantity("m", above(0, 12000), "before it the boat levels by itself, planes in hand")
    )
    visitors: bool | None = optional(
        Flag("a visitor may begin it again at any time, as at a kiosk; else false")
    )
    lost: tuple[str, ...] | None = optional(
        Texts(Text(79, "conditions that lose the exercise: depth > 160, showing > 0 for 5 s"), 8)
    )
    vessel: str | None = optional(Text(200, "name of a boat, or path of its file"))
    equations: str | None = optional(Choice(EQUATION_SETS, "set of equations"))
    rates: str | None = optional(Choice(("exact", "lagged"), "how accelerations are found"))
    integrator: str | None = optional(Text(200, "as --integrator"))
    step_s: float | None = optional(Quantity("s", within(0.001, 2), "time step"))
    seed: float | None = optional(Quantity("-", within(0, 1e15), "of everything random"))
    duration_s: float | None = optional(
        Quantity("s", within(0.001, MAX_TIME_S), "end of the exercise")
    )
    casualty_table: str | None = optional(Text(200, "path of a table of casualties of your own"))


@dataclass(frozen=True, kw_only=True)
class StartState:
    """Where the boat starts; what is left out is the vessel file's, the course north."""

    speed_kn: float | None = optional(Quantity("kn", within(0.001, 60), "speed"))
    depth_m: float | None = optional(Quantity("m", within(0, 12000), "depth"))
    course_deg: float | None = optional(Quantity("deg", within(0, 360), "course"))
    heavy_t: float | None = optional(
        Quantity("t", within(-100, 100), "too heavy, no tank shows it")
    )
    forward_t: float | None = optional(
        Quantity("t", within(-100, 100), "as much weight forward as belongs aft; no tank shows it")
    )


@dataclass(frozen=True, kw_only=True)
class OrderRow:
    """One order and its time."""

    at_s: float = required(Quantity("s", within(0, MAX_TIME_S), "time from the start"))
    order: str = required(Text(80, "as it is typed"))


@dataclass(frozen=True, kw_only=True)
class CasualtyRow:
    """Something that breaks, at a time or when a condition comes to hold."""

    name: str = required(Text(40, "as `trainer casualties` lists it"))
    severity: float | None = optional(Quantity("-", within(-10, 10), "else the table's"))
    ramp_s: float | None = optional(Quantity("s", within(0, 3600), "else the table's"))
    at_s: float | None = optional(Quantity("s", within(0, MAX_TIME_S), "time from the start"))
    when: str | None = optional(Text(79, "condition, instead of at_s"))
    rule: str | None = optional(Choice(("once", "again"), "how often, with when; else once"))
    clear_at_s: float | None = optional(Quantity("s", within(0, MAX_TIME_S), "when it is cleared"))
    within_s: float | None = optional(
        Quantity("s", above(0, MAX_TIME_S), "it comes up to so much after at_s, by the seed")
    )
    lasts_s: float | None = optional(
        Quantity("s", above(0, MAX_TIME_S), "how long it lasts, instead of clear_at_s")
    )
    one_of: str | None = optional(Text(40, "of all with this word one comes, by the seed"))


@dataclass(frozen=True, kw_only=True)
class ExerciseLimits:
    """The limits of an exercise. None: no limit."""

    depth_m_max: float | None = optional(Quantity("m", within(0, 12000), "deepest"))
    depth_m_min: float | None = optional(Quantity("m", within(0, 12000), "shallowest"))
    pitch_deg_max: float | None = optional(Quantity("deg", within(0, 90), "pitch either way"))
    heel_deg_max: float | None = optional(Quantity("deg", within(0, 90), "heel either way"))
    speed_kn_max: float | None = optional(Quantity("kn", within(-60, 60), "fastest"))
    speed_kn_min: float | None = optional(Quantity("kn", within(-60, 60), "slowest"))
    speed_over_ground_kn_max: float | None = optional(Quantity("kn", within(0, 60), "over ground"))
    validity_level_max: float | None = optional(
        Quantity("-", within(0, 2), "of the equations: 0 inside their range, 1 extrapolated")
    )
    clearance_m_min: float | None = optional(Quantity("m", within(0, 1000), "water under the keel"))
    cpa_m_min: float | None = optional(
        Quantity("m", within(0, 20_000), "nearest to any ship, from middle to middle")
    )


ORDER_ROWS: Final = Rows(OrderRow, ("note",), 0, 500, "scheduled orders, below")
CASUALTY_ROWS: Final = Rows(CasualtyRow, ("note",), 0, 20, "what breaks, below")


KNOWN_KEYS: Final = (*(item.name for item in fields(ExerciseHeading)), "note", *EXERCISE_TABLES)


@dataclass(frozen=True, kw_only=True)
class ConditionalCasualty:
    """A casualty that waits for a condition, once or ``again`` each time."""

    condition: Condition
    casualty: Casualty
    rule: str


@dataclass(frozen=True, kw_only=True)
class RandomCasualty:
    """A casualty of chance: the seed decides its time, or whether it comes."""

    row: CasualtyRow
    number: int  # in the file, from 0


@dataclass(frozen=True, kw_only=True)
class Exercise:
    """Everything an exercise file says; ``sea`` is None where it says none."""

    path: Path
    heading: ExerciseHeading
    initial: StartState
    sea: SeaFile | None
    casualties: Mapping[str, Casualty]
    schedule: tuple[ScheduledOrder, ...]
    armed: tuple[ConditionalCasualty, ...]
    limits: ExerciseLimits
    scores: tuple[ScoreRule, ...]
    drawn: tuple[RandomCasualty, ...]  # of chance, drawn by the seed
    lost: tuple[Loss, ...]
    crew: Crew
    world: WorldTables
    stated: tuple[StatedValue, ...]
    steps: tuple[Step, ...]

    @property
    def aids(self) -> tuple[str, ...]:
        """Return the aids that are allowed."""
        if self.heading.aids is not None:
            return self.heading.aids
        return () if self.scores else AIDS

    def schedule_of(self, seed: int) -> list[ScheduledOrder]:
        """Return the orders and timed casualties of a seed's run, in order of time."""
        timed = [*self.schedule]
        for casualty in _chosen(self.drawn, seed):
            timed += _timed_casualty(_settled(casualty, seed), casualty.number)
        return sorted(timed, key=lambda entry: entry.seconds)


def _chosen(drawn: tuple[RandomCasualty, ...], seed: int) -> list[RandomCasualty]:
    """Return the casualties that come by a seed: one of each group ``one_of``."""
    groups: dict[str, list[RandomCasualty]] = {}
    for casualty in drawn:
        # A casualty without a group is one alone; no group's name can begin with a blank.
        groups.setdefault(casualty.row.one_of or f" {casualty.number}", []).append(casualty)
    return [group[int(_share(seed, name) * len(group))] for name, group in groups.items()]


def _settled(drawn: RandomCasualty, seed: int) -> CasualtyRow:
    """Return the casualty with its times by this seed, in whole seconds."""
    row = drawn.row
    if row.at_s is None:
        return row
    late = math.floor(_share(seed, f"time {drawn.number}") * (row.within_s or 0.0))
    begins = row.at_s + late
    ends = None if row.clear_at_s is None else row.clear_at_s + late
    ends = begins + row.lasts_s if row.lasts_s is not None else ends
    return replace(row, at_s=begins, clear_at_s=ends)


def _share(seed: int, what: str) -> float:
    """Return a number in [0, 1) by a seed and a name.

    It is a hash of the two. So the number of one name changes no other's, and no sea depends on it.
    """
    digest = hashlib.sha256(f"{seed}/{what}".encode()).digest()
    return int.from_bytes(digest[:6], "big") / 2.0**48


def load_exercise(name_or_path: str) -> Exercise:
    """Return the shipped exercise of that name or the one in that file. ConfigError if wrong.

    Whatever has a path separator or ends in .toml is a path.
    """
    path = path_named(name_or_path, "exercises")
    return parse_exercise(read_text(path), path)


def parse_exercise(text: str, path: Path) -> Exercise:
    """Return the exercise in ``text``, which came from ``path``; ConfigError with all faults."""
    table = parse_toml(text, path.name)
    try:
        return read_exercise(table, path)
    except ConfigError as wrong:
        raise ConfigError(*number_problems(wrong.problems, text, path.name)) from None


def read_exercise(table: Mapping[str, Any], path: Path) -> Exercise:
    """Return the exercise of parsed tables, which came from ``path``; ConfigError as above."""
    position = Position(path.name, "")
    problems = [
        position.wrong(key, value, f"no such key{nearest(key, KNOWN_KEYS)}")
        for key, value in table.items()
        if key not in KNOWN_KEYS
    ]
    parts: dict[str, Any] = {"sea": None, "casualties": load_casualties()}
    with collecting(problems):
        heading_values = {
            key: value
            for key, value in table.items()
            if key in KNOWN_KEYS and key not in EXERCISE_TABLES
        }
        heading = read_record(ExerciseHeading, heading_values, position, ("note",))
        parts["heading"] = replace(
            heading, vessel=heading.vessel and relative_name(path, heading.vessel)
        )
        if heading.vessel is not None:
            _refuse_unknown(position, "vessel", heading.vessel, "vessels")
        if heading.seed is not None and heading.seed != int(heading.seed):
            problems.append(position.wrong("seed", heading.seed, "must be a whole number"))
    with collecting(problems):
        if isinstance(own_table := table.get("casualty_table"), str):
            parts["casualties"] = load_casualties(relative_name(path, own_table))
    for name, record in (("initial", StartState), ("limits", ExerciseLimits)):
        with collecting(problems):
            content = table.get(name, {})
            parts[name] = read_record(record, content, position.inside(name), ("note",))
    with collecting(problems):
        if "sea" in table:
            parts["sea"] = sea_given(table["sea"], path)
    timed: list[ScheduledOrder] = []
    with collecting(problems):
        timed += read_orders(table, position)
    with collecting(problems):
        broken, parts["armed"], parts["drawn"] = _casualties(table, position, parts["casualties"])
        timed += broken
    with collecting(problems):
        parts["scores"] = read_rules(table, position, parts["casualties"])
    with collecting(problems):
        parts["crew"] = read_crew(table, position)
    with collecting(problems):
        parts["stated"] = read_stated(table, position)
    with collecting(problems):
        parts["steps"] = read_steps(table, position)
    with collecting(problems):
        parts["world"] = read_world(table, path)
    with collecting(problems):
        parts["lost"] = compile_losses(_texts(table, "lost"), position)
    problems += _unmanned(table, position)
    if "ghost" in _texts(table, "aids") and not table.get("crew"):
        message = "the ghost is the run of the reference crew, and there is no [[crew]]"
        problems.append(position.wrong("aids", table["aids"], message))
    if _texts(table, "hand"):
        problems += _without_win(parts.get("scores", ()), position)
    raise_problems(problems)
    timed.sort(key=lambda entry: entry.seconds)
    return Exercise(path=path, schedule=tuple(timed), **parts)


def _texts(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """Return the texts of a list, even of a file that is wrong elsewhere."""
    value = table.get(key)
    return tuple(each for each in value if isinstance(each, str)) if isinstance(value, list) else ()


def controls_manning(axis: str) -> tuple[str, ...]:
    """Return the hands and orders that can carry out an order to the crew."""
    hands = HANDS_BY_CREW_AXIS[axis]
    orders = (each for hand in hands for each in AUTOMATIC_ORDERS_BY_AXIS[hand])
    kept = (each for each in orders if axis in KEPT_AXES and " " not in each)
    return tuple(dict.fromkeys((*hands, *kept)))


def _unmanned(table: Mapping[str, Any], position: Position) -> list[str]:
    """Return problems of scheduled orders to the crew for an axis that nobody mans."""
    if not isinstance(table.get("hand", []), list):
        return []  # it is told as no list, and says nobody yet
    order_names = (*_texts(table, "hand"), *_texts(table, "allowed"))
    problems = []
    rows = table.get("orders", [])
    for i, row in enumerate(rows if isinstance(rows, list) else []):
        text = row.get("order") if isinstance(row, Mapping) else None
        order = parse(text) if isinstance(text, str) else None
        order = to_the_crew(order) if isinstance(order, Order) else order
        axis = order.word.partition("_")[0] if isinstance(order, Order) else ""
        if isinstance(order, Order) and order.name == "order" and axis in HANDS_BY_CREW_AXIS:
            manned = controls_manning(axis)
            if not set(manned) & set(order_names):
                message = f"nobody mans it: hand = [{', '.join(map(quote, order_names))}]"
                message += f" has none of {', '.join(manned)}"
                problems.append(position.inside(f"orders[{i}]").wrong("order", text, message))
    return problems


def _without_win(rules: tuple[ScoreRule, ...], position: Position) -> list[str]:
    """Return a problem if an exercise has scores, but none that wins it."""
    if not rules or any(rule.part == "task" for rule in rules):
        return []
    return [position.problem('[[scores]] have no part = "task": nothing wins this exercise')]


def _refuse_unknown(position: Position, key: str, name_or_path: str, kind: str) -> None:
    """Refuse a key's name that no shipped file of ``kind`` has. ConfigError."""
    try:
        path_named(name_or_path, kind)
    except ConfigError as wrong:
        raise ConfigError(position.wrong(key, name_or_path, str(wrong))) from None


def sea_given(value: object, path: Path) -> SeaFile:
    """Return a sea given by name or path, or as a table of its own."""
    if isinstance(value, str):
        _refuse_unknown(Position(path.name, ""), "sea", value, "seas")
        return load_sea(relative_name(path, value))
    sea = read_sea(value, Position(path.name, "sea"))
    return SeaFile(path=path, text="", name=sea_words(sea), sea=sea)


def sea_words(sea: Sea) -> str:
    """Return a sea in words: how high, and where from."""
    degrees = (
        ("sea state {:g}", sea.sea_state),
        ("wind {:g} kn", sea.wind_kn),
        ("waves of {:g} m", sea.height_m),
    )
    (words,) = (text.format(value) for text, value in degrees if value is not None)
    return f"{words} from {sea.direction_deg:03.0f}"


def read_orders(table: Mapping[str, object], position: Position) -> list[ScheduledOrder]:
    """Return the orders and their times; ConfigError with all that are not orders."""
    problems: list[str] = []
    orders = []
    rows: object = table.get("orders", [])
    readers: Readers = {"order": _read_order}
    for i, inside, row in sound_rows(
        ORDER_ROWS, rows, position.inside("orders"), readers, problems
    ):
        with collecting(problems):
            order = _read_order(row.order, inside)
            orders.append(ScheduledOrder(row.at_s, order, i + 1))
    raise_problems(problems)
    return orders


def _read_order(text: str, position: Position) -> Order:
    """Return a scheduled order; ConfigError if it is none."""
    order = parse(text)
    if not isinstance(order, Order):
        raise ConfigError(position.wrong("order", text, order.reason if order else "is no order"))
    if not ORDER_WORDS[order.name].scheduled:
        raise ConfigError(position.wrong("order", text, "has no place in a schedule"))
    return to_the_crew(order)


def _casualties(
    table: Mapping[str, object], position: Position, known: Mapping[str, Casualty]
) -> tuple[list[ScheduledOrder], tuple[ConditionalCasualty, ...], tuple[RandomCasualty, ...]]:
    """Return casualties at set times, those that wait for a condition, those of chance.

    ConfigError with all that is wrong.
    """
    problems: list[str] = []
    drawn: list[RandomCasualty] = []
    timed: list[ScheduledOrder] = []
    armed: list[ConditionalCasualty] = []
    rows = table.get("casualties", [])
    readers: Readers = {"name": partial(_entry_named, known), "when": compile_condition}
    array = position.inside("casualties")
    for i, inside, row in sound_rows(CASUALTY_ROWS, rows, array, readers, problems):
        condition = None
        with collecting(problems):
            condition = row.when and compile_condition(row.when, inside)
        with collecting(problems):
            casualty = _known_casualty(row, inside, known)
            if row.within_s is None and row.one_of is None:
                timed += _timed_casualty(_settled(RandomCasualty(row=row, number=i), 0), i)
            else:
                drawn.append(RandomCasualty(row=row, number=i))
            if condition:
                rule = row.rule or "once"
                armed.append(ConditionalCasualty(condition=condition, casualty=casualty, rule=rule))
    raise_problems(problems)
    return timed, tuple(armed), tuple(drawn)


def _entry_named(known: Mapping[str, Casualty], name: str, position: Position) -> Casualty:
    """Return the casualty of that name as its table has it; ConfigError if there is none."""
    if name not in known:
        text = f"no such casualty{nearest(name, known)}; `trainer casualties` lists them"
        raise ConfigError(position.wrong("name", name, text))
    return known[name]


def _known_casualty(
    row: CasualtyRow, position: Position, known: Mapping[str, Casualty]
) -> Casualty:
    """Return the casualty with the row's severity and ramp; ConfigError on what is wrong."""
    entry = _entry_named(known, row.name, position)
    entry = replace(
        entry,
        severity=entry.severity if row.severity is None else row.severity,
        ramp_s=entry.ramp_s if row.ramp_s is None else row.ramp_s,
    )
    problems = []
    for key, value in (("severity", row.severity), ("ramp_s", row.ramp_s)):
        if entry.parts and value is not None:
            problems.append(position.wrong(key, value, f"{entry.name}: {PARTS_RULE}"))
    if not entry.parts and entry.severity not in entry.measure.limits:
        problems.append(position.wrong("severity", entry.severity, severity_rule(entry.kind)))
    if not entry.parts and entry.sudden and entry.ramp_s:
        problems.append(position.wrong("ramp_s", entry.ramp_s, f"{entry.kind} comes at once"))
    if (row.at_s is None) == (row.when is None):
        problems.append(position.problem("give one of at_s, when"))
    if row.rule is not None and row.when is None:
        problems.append(position.wrong("rule", row.rule, "goes with when"))
    if row.at_s is not None and row.clear_at_s is not None and row.clear_at_s < row.at_s:
        problems.append(position.wrong("clear_at_s", row.clear_at_s, "is before at_s"))
    problems += [
        position.wrong(key, getattr(row, key), why)
        for key, why in TIMED_KEYS.items()
        if getattr(row, key) is not None and row.at_s is None
    ]
    if row.lasts_s is not None and row.clear_at_s is not None:
        problems.append(position.problem("give one of clear_at_s, lasts_s"))
    raise_problems(problems)
    return entry


def _timed_casualty(row: CasualtyRow, i: int) -> list[ScheduledOrder]:
    """Return the orders that insert and clear the casualty at set times."""
    timed = []
    if row.at_s is not None:
        numbers = tuple(x for x in (row.severity, row.ramp_s) if x is not None)
        word = "" if row.ramp_s is None else "ramp"
        text = f"casualty {row.name}"
        text += "" if row.severity is None else f" {row.severity:g}"
        text += "" if row.ramp_s is None else f" ramp {row.ramp_s:g} s"
        order = Order("casualty", 0.0, word, text, numbers, row.name)
        timed.append(ScheduledOrder(row.at_s, order, i + 1))
    if row.clear_at_s is not None:
        order = Order("clear", 0.0, "", f"clear {row.name}", (), row.name)
        timed.append(ScheduledOrder(row.clear_at_s, order, i + 1))
    return timed
