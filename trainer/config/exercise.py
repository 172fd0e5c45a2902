"""An exercise from its file: what it sets, orders, breaks and limits, all checked at load.

What a file leaves out is as ``trainer run`` has it without an exercise.

What an exercise file may say, table by table: keys, units and limits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

from trainer.config.casualties import Casualty, load_casualties, severity_rule
from trainer.config.condition import Condition, compile_condition
from trainer.config.files import (
    ConfigError,
    Place,
    beside,
    collecting,
    nearest,
    parse_toml,
    path_named,
    read_text,
)
from trainer.config.method import EQUATIONS
from trainer.config.schema import (
    Choice,
    Quantity,
    Rows,
    Text,
    of,
    optional,
    read_record,
    tables_of,
    within,
)
from trainer.config.score_rules import Rule, Score, read_rules
from trainer.config.sea import SeaFile, load_sea, read_sea
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import LATEST, Scheduled


@dataclass(frozen=True)
class Page:
    """Some lines of text."""

    longest: int
    meaning: str

    @property
    def cells(self) -> tuple[str, str, str]:
        """Return unit, range and meaning."""
        return "text", f"1 to {self.longest} characters", self.meaning

    def read(self, key: str, value: object, place: Place) -> str:
        """Return the text; ConfigError if it is empty, too long or not printable."""
        good = isinstance(value, str) and value.replace("\n", "").isprintable()
        if not isinstance(value, str) or not good or not 1 <= len(value.strip()) <= self.longest:
            raise ConfigError(
                place.wrong(key, value, f"must be printable text of 1 to {self.longest} characters")
            )
        return value.strip()


@dataclass(frozen=True, kw_only=True)
class Heading:
    """What an exercise is, and how the boat is computed."""

    schema: str = of(Choice(("exercise/1",), "form of the file"))
    name: str = of(Text(55, "one line for the list of exercises"))
    briefing: str = of(Page(4000, "what the crew is told at the start"))
    vessel: str | None = optional(Text(200, "name of a boat, or path of its file"))
    equations: str | None = optional(Choice(EQUATIONS, "set of equations"))
    rates: str | None = optional(Choice(("exact", "lagged"), "how accelerations are found"))
    integrator: str | None = optional(Text(200, "as --integrator"))
    step_s: float | None = optional(Quantity("s", within(0.001, 2), "time step"))
    seed: float | None = optional(Quantity("-", within(0, 1e15), "of everything random"))
    duration_s: float | None = optional(Quantity("s", within(0.001, LATEST), "end of the exercise"))
    casualty_table: str | None = optional(Text(200, "path of a table of casualties of your own"))


@dataclass(frozen=True, kw_only=True)
class Initial:
    """Where the boat starts; what is left out is the vessel file's, the course north."""

    speed_kn: float | None = optional(Quantity("kn", within(0.001, 60), "speed"))
    depth_m: float | None = optional(Quantity("m", within(0, 12000), "depth"))
    course_deg: float | None = optional(Quantity("deg", within(0, 360), "course"))


@dataclass(frozen=True, kw_only=True)
class OrderRow:
    """One order and its time."""

    at_s: float = of(Quantity("s", within(0, LATEST), "time from the start"))
    order: str = of(Text(80, "as it is typed"))


@dataclass(frozen=True, kw_only=True)
class CasualtyRow:
    """Something that breaks, at a time or when a condition comes to hold."""

    name: str = of(Text(40, "as `trainer casualties` lists it"))
    severity: float | None = optional(Quantity("-", within(-10, 10), "else the table's"))
    ramp_s: float | None = optional(Quantity("s", within(0, 3600), "else the table's"))
    at_s: float | None = optional(Quantity("s", within(0, LATEST), "time from the start"))
    when: str | None = optional(Text(79, "condition, instead of at_s"))
    rule: str | None = optional(Choice(("once", "again"), "how often, with when; else once"))
    clear_at_s: float | None = optional(Quantity("s", within(0, LATEST), "when it is cleared"))


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What an exercise does not want passed; None: no limit."""

    depth_m_max: float | None = optional(Quantity("m", within(0, 12000), "deepest"))
    depth_m_min: float | None = optional(Quantity("m", within(0, 12000), "shallowest"))
    pitch_deg_max: float | None = optional(Quantity("deg", within(0, 90), "pitch either way"))
    heel_deg_max: float | None = optional(Quantity("deg", within(0, 90), "heel either way"))
    speed_kn_max: float | None = optional(Quantity("kn", within(-60, 60), "fastest"))
    speed_kn_min: float | None = optional(Quantity("kn", within(-60, 60), "slowest"))
    validity_level_max: float | None = optional(
        Quantity("-", within(0, 2), "of the equations: 0 inside their range, 1 extrapolated")
    )


ORDERS: Final = Rows(OrderRow, ("note",), 0, 500, "scheduled orders, below")
CASUALTIES: Final = Rows(CasualtyRow, ("note",), 0, 20, "what breaks, below")

RECORDS: Final = {
    "": Heading,
    "initial": Initial,
    "[orders]": OrderRow,
    "[casualties]": CasualtyRow,
    "limits": Limits,
    "[scores]": Score,
}


def key_tables() -> str:
    """Return the Markdown tables of every key, as docs/exercises.md shows them."""
    return tables_of(RECORDS)


UNSCHEDULED: Final = (  # they answer a console, or are a person's to decide
    *("help", "status", "again", "next", "debrief", "release-marks", "command", "give", "keep"),
    *("branch", "branches", "history", "ready"),
)


TABLES: Final = ("initial", "sea", "orders", "casualties", "limits", "scores")
KNOWN: Final = (*(item.name for item in fields(Heading)), "note", *TABLES)


@dataclass(frozen=True, kw_only=True)
class Armed:
    """A casualty that waits for a condition, once or ``again`` each time."""

    condition: Condition
    casualty: Casualty
    rule: str


@dataclass(frozen=True, kw_only=True)
class Exercise:
    """Everything an exercise file says; ``sea`` is None where it says none."""

    path: Path
    heading: Heading
    initial: Initial
    sea: SeaFile | None
    casualties: Mapping[str, Casualty]
    schedule: tuple[Scheduled, ...]
    armed: tuple[Armed, ...]
    limits: Limits
    scores: tuple[Rule, ...]


def load_exercise(name_or_path: str) -> Exercise:
    """Return the shipped exercise of that name or the one in that file; ConfigError if wrong.

    Whatever has a path separator or ends in .toml is a path.
    """
    path = path_named(name_or_path, "exercises")
    return parse_exercise(read_text(path), path)


def parse_exercise(text: str, path: Path) -> Exercise:
    """Return the exercise in ``text``, which came from ``path``; ConfigError with all faults."""
    return read_exercise(parse_toml(text, path.name), path)


def read_exercise(table: Mapping[str, Any], path: Path) -> Exercise:
    """Return the exercise of parsed tables, which came from ``path``; ConfigError as above."""
    place = Place(path.name, "")
    problems = [
        place.wrong(key, value, f"no such key{nearest(key, KNOWN)}")
        for key, value in table.items()
        if key not in KNOWN
    ]
    parts: dict[str, Any] = {"sea": None, "casualties": load_casualties()}
    with collecting(problems):
        own = {key: value for key, value in table.items() if key in KNOWN and key not in TABLES}
        heading = read_record(Heading, own, place, ("note",))
        parts["heading"] = replace(heading, vessel=heading.vessel and beside(path, heading.vessel))
        if heading.seed is not None and heading.seed != int(heading.seed):
            problems.append(place.wrong("seed", heading.seed, "must be a whole number"))
        if heading.casualty_table is not None:
            parts["casualties"] = load_casualties(beside(path, heading.casualty_table))
    for name, record in (("initial", Initial), ("limits", Limits)):
        with collecting(problems):
            given = table.get(name, {})
            parts[name] = read_record(record, given, place.inside(name), ("note",))
    with collecting(problems):
        if "sea" in table:
            parts["sea"] = _sea(table["sea"], path)
    timed: list[Scheduled] = []
    with collecting(problems):
        timed += _orders(table, place)
    with collecting(problems):
        broken, parts["armed"] = _casualties(table, place, parts["casualties"])
        timed += broken
    with collecting(problems):
        parts["scores"] = read_rules(table, place, parts["casualties"])
    if problems:
        raise ConfigError(*problems)
    timed.sort(key=lambda entry: entry.seconds)
    return Exercise(path=path, schedule=tuple(timed), **parts)


def _sea(value: object, path: Path) -> SeaFile:
    """Return a sea given by name or path, or as a table of its own."""
    if isinstance(value, str):
        return load_sea(beside(path, value))
    sea = read_sea(value, Place(path.name, "sea"))
    return SeaFile(path=path, text="", name="the exercise's sea", sea=sea)


def _orders(table: Mapping[str, object], place: Place) -> list[Scheduled]:
    """Return the orders and their times; ConfigError with all that are none."""
    problems: list[str] = []
    found = []
    for i, row in enumerate(ORDERS.read("orders", table.get("orders", []), place)):
        inside = place.inside(f"orders[{i}]")
        order = parse(row.order)
        if not isinstance(order, Order):
            reason = order.reason if order else "is no order"
            problems.append(inside.wrong("order", row.order, reason))
        elif order.name in UNSCHEDULED:
            problems.append(inside.wrong("order", row.order, "has no place in a schedule"))
        else:
            found.append(Scheduled(row.at_s, order, i + 1))
    if problems:
        raise ConfigError(*problems)
    return found


def _casualties(
    table: Mapping[str, object], place: Place, known: Mapping[str, Casualty]
) -> tuple[list[Scheduled], tuple[Armed, ...]]:
    """Return what breaks at set times, and what waits for a condition; ConfigError with all."""
    problems: list[str] = []
    timed: list[Scheduled] = []
    armed: list[Armed] = []
    rows = CASUALTIES.read("casualties", table.get("casualties", []), place)
    for i, row in enumerate(rows):
        inside = place.inside(f"casualties[{i}]")
        with collecting(problems):
            casualty = _known_casualty(row, inside, known)
            timed += _timed_casualty(row, i)
            if row.when is not None:
                condition = compile_condition(row.when, inside)
                rule = row.rule or "once"
                armed.append(Armed(condition=condition, casualty=casualty, rule=rule))
    if problems:
        raise ConfigError(*problems)
    return timed, tuple(armed)


def _known_casualty(row: CasualtyRow, place: Place, known: Mapping[str, Casualty]) -> Casualty:
    """Return the casualty as severe and sudden as the row says; ConfigError on what is wrong."""
    if row.name not in known:
        text = f"no such casualty{nearest(row.name, known)}; `trainer casualties` lists them"
        raise ConfigError(place.wrong("name", row.name, text))
    entry = known[row.name]
    entry = replace(
        entry,
        severity=entry.severity if row.severity is None else row.severity,
        ramp_s=entry.ramp_s if row.ramp_s is None else row.ramp_s,
    )
    problems = []
    if entry.severity not in entry.measure.limits:
        problems.append(place.wrong("severity", entry.severity, severity_rule(entry.kind)))
    if entry.measure.sudden and entry.ramp_s:
        problems.append(place.wrong("ramp_s", entry.ramp_s, f"{entry.kind} comes at once"))
    if (row.at_s is None) == (row.when is None):
        problems.append(place.problem("give one of at_s, when"))
    if row.rule is not None and row.when is None:
        problems.append(place.wrong("rule", row.rule, "goes with when"))
    if row.at_s is not None and row.clear_at_s is not None and row.clear_at_s < row.at_s:
        problems.append(place.wrong("clear_at_s", row.clear_at_s, "is before at_s"))
    if problems:
        raise ConfigError(*problems)
    return entry


def _timed_casualty(row: CasualtyRow, i: int) -> list[Scheduled]:
    """Return the orders that insert and clear the casualty at set times."""
    timed = []
    if row.at_s is not None:
        numbers = tuple(x for x in (row.severity, row.ramp_s) if x is not None)
        word = "" if row.ramp_s is None else "ramp"
        text = f"casualty {row.name}"
        text += "" if row.severity is None else f" {row.severity:g}"
        text += "" if row.ramp_s is None else f" ramp {row.ramp_s:g} s"
        order = Order("casualty", 0.0, word, text, numbers, row.name)
        timed.append(Scheduled(row.at_s, order, i + 1))
    if row.clear_at_s is not None:
        order = Order("clear", 0.0, "", f"clear {row.name}", (), row.name)
        timed.append(Scheduled(row.clear_at_s, order, i + 1))
    return timed
