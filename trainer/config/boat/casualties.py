"""Tables of casualties: what can break, how badly and how fast.

Exercises name them, and ``boat/casualties`` puts them into the state. One table is shipped, and
users write their own. An entry of a user's table is completed by the shipped entry of its kind. The
meaning and limits of a severity depend on the kind.
"""

import math
import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any, Final

from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    nearest,
    parse_toml,
    raise_problems,
    read_text,
    shipped_path,
    text_if_there,
)
from trainer.config.schema import (
    KeyForm,
    NumberLimits,
    Rows,
    Text,
    above,
    optional,
    read_record,
    required,
    within,
)
from trainer.config.schema import Kind as FieldKind
from trainer.core.casualties import CASUALTY_TABLE, CODES, GAUGES, KINDS, SERVO_STUCK
from trainer.core.state import MAX_CASUALTIES
from trainer.core.surfaces import SURFACES
from trainer.units import KNOT

SHARE_LIMITS: Final = above(0, 1)
SWITCH_LIMITS: Final = within(1, 1)  # of a casualty that is only on or off
SIDE_LIMITS: Final = within(-1, 1)
FACTOR_LIMITS: Final = above(0, 10)
SIGNED_FACTOR_LIMITS: Final = within(-10, 10)
HEADING_FIELDS: Final[Mapping[str, FieldKind]] = {
    "schema": Text(20, "form of the file: casualties/1"),
    "name": Text(200, "name shown"),
    "note": Text(1000, "for the reader"),
}
KNOWN_KEYS: Final = (*HEADING_FIELDS, "casualty")
PARTS_RULE: Final = "each part has its own degree and ramp; order a part alone with another"
STANDARD_LIST: Final = "standard"
COMPOUND_LIST: Final = "compound"  # of several with one cause
CASUALTY_NAME: Final = re.compile(r"[a-z][a-z0-9-]{0,39}")
# fmt: off
PARAMETER_KEYS: Final = (
    "hole_m2", "leak_l_s", "dip_s",
    "noise_m", "noise_deg", "noise_kn", "bias_m", "bias_deg", "bias_kn",
)
# fmt: on


class Count(Enum):
    """How people count the amount of a casualty."""

    NOTHING = ""
    ANGLE = "angle"  # of a surface, with its side
    NOISE = "noise"  # of a gauge, in its unit, and the next two
    VALUE = "value"
    BIAS = "bias"
    HOLE = "hole"
    FLOW = "flow"
    TIME = "time"
    SHARE = "share"  # in words of ``share``


@dataclass(frozen=True)
class SeverityMeasure:
    """The meaning of a kind's severity, and how its amount is counted."""

    limits: NumberLimits
    meaning: str
    count: Count = Count.NOTHING
    share: str = ""  # what the amount is a share of
    parameter: str = ""  # key of what severity 1 is
    factor: float = 1.0  # [SI] of the parameter's unit

    @property
    def sudden(self) -> bool:
        """Return whether the casualty is only on or off, without degrees and ramps."""
        return self.limits == SWITCH_LIMITS


GAUGE_UNITS: Final = {  # what a gauge shows: unit, and its size [SI]
    "depth-gauge": ("m", 1.0),
    "gyro": ("deg", math.radians(1.0)),
    "log": ("kn", KNOT),
    "sounder": ("m", 1.0),
}
AS_IT_STOOD: Final = "none: held as it stood"


def _surface_measures(surface: str) -> dict[str, SeverityMeasure]:
    """Return the measures of a surface's faults."""
    side = "right" if surface == "rudder" else "rise"
    return {
        "slow": _share("share of the rate lost", "of the rate lost"),
        "follow-up-lost": SeverityMeasure(SWITCH_LIMITS, "none: on or off"),
        "free": _share("share of its rate", "of its rate"),
        "hard-over": SeverityMeasure(SIDE_LIMITS, f"of its limit, + {side}", Count.ANGLE),
        "stuck": SeverityMeasure(SWITCH_LIMITS, AS_IT_STOOD, Count.ANGLE),
        SERVO_STUCK: SeverityMeasure(SIDE_LIMITS, f"of its limit, + {side}", Count.ANGLE),
    }


def _gauge_measures(gauge: str) -> dict[str, SeverityMeasure]:
    """Return the measures of a gauge's faults."""
    unit, size = GAUGE_UNITS[gauge]
    noise, bias = f"noise_{unit}", f"bias_{unit}"
    return {
        "noisy": SeverityMeasure(
            FACTOR_LIMITS, f"times {noise}", Count.NOISE, parameter=noise, factor=size
        ),
        "biased": SeverityMeasure(
            SIGNED_FACTOR_LIMITS, f"times {bias}", Count.BIAS, parameter=bias, factor=size
        ),
        "stuck": SeverityMeasure(SWITCH_LIMITS, AS_IT_STOOD, Count.VALUE),
    }


def _share(meaning: str, share: str) -> SeverityMeasure:
    return SeverityMeasure(SHARE_LIMITS, meaning, Count.SHARE, share)


HOLE_MEASURE: Final = SeverityMeasure(
    FACTOR_LIMITS, "times hole_m2", Count.HOLE, parameter="hole_m2"
)
FAULT_MEASURES: Final[Mapping[str, Mapping[str, SeverityMeasure]]] = {  # by equipment and fault
    **{surface: _surface_measures(surface) for surface in SURFACES},
    **{gauge: _gauge_measures(gauge) for gauge in GAUGES},
    "propulsion": {
        "lost": _share("share of turns lost", "of the turns lost"),
        "stuck": SeverityMeasure(SWITCH_LIMITS, AS_IT_STOOD),
    },
    "autopilot": {"failed": SeverityMeasure(SWITCH_LIMITS, "none: its commands stay")},
    "leak": {"hole": HOLE_MEASURE},
    "flooding": {"hole": HOLE_MEASURE},
    "pump": {"failed": _share("share of the rate lost", "of the pump lost")},
    "bank": {"failed": _share("share of the rate lost", "of the air bank lost")},
    "blow": {"shut": _share("share of the opening lost", "of the blow lost")},
    "vent": {
        "shut": _share("share of the opening lost", "of the vent lost"),
        "open": _share("opening it is stuck at", "open"),
    },
    "hydraulic": {"failed": _share("share of delivery lost", "of the delivery lost")},
    "oil": {
        "leak": SeverityMeasure(
            FACTOR_LIMITS, "times leak_l_s", Count.FLOW, parameter="leak_l_s", factor=1e-3
        )
    },
    "bus": {"lost": SeverityMeasure(SWITCH_LIMITS, "none: it is dead")},
    "cells": {"lost": _share("share of the charge lost", "of the charge lost")},
    "power": {"dip": SeverityMeasure(FACTOR_LIMITS, "times dip_s", Count.TIME, parameter="dip_s")},
    "fire": {"burning": _share("share of a usual fire", "of a usual fire")},
}
SEVERITY_MEASURES: Final[Mapping[str, SeverityMeasure]] = {
    kind.name: FAULT_MEASURES[kind.equipment][kind.fault] for kind in CASUALTY_TABLE
}


def severity_rule(kind: str) -> str:
    """Return what the severity of a kind must be, in words."""
    measure = SEVERITY_MEASURES[kind]
    if measure.sudden:
        return f"{kind} has no degrees: its severity is 1"
    return f"must be {measure.limits} for {kind} ({measure.meaning})"


@dataclass(frozen=True)
class KindWord:
    """One of the kinds of casualty."""

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        return KeyForm("word", "a kind below", "what breaks, and how", {"enum": [*KINDS]})

    def read(self, key: str, value: object, position: Position) -> str:
        """Return the kind; ConfigError naming the nearest if there is none of that name."""
        if not isinstance(value, str) or value not in CODES:
            guess = nearest(value, KINDS) if isinstance(value, str) else ""
            raise ConfigError(position.wrong(key, value, f"no such kind of casualty{guess}"))
        return value


@dataclass(frozen=True, kw_only=True)
class CasualtyEntry:
    """One casualty as its table says it, in the table's units."""

    kind: str = required(KindWord())
    severity: float = required("-", within(-10, 10), "unless ordered otherwise")
    ramp_s: float = required("s", within(0, 3600), "time to come on")
    clear_ramp_s: float = required("s", within(0, 3600), "time to go when cleared")
    description: str = required(Text(75, "for the list"))
    hole_m2: float | None = optional("m2", above(0, 10), "flooding, leak: the hole")
    leak_l_s: float | None = optional("L/s", above(0, 1000), "oil-leak: at full pressure")
    dip_s: float | None = optional("s", above(0, 600), "power-dip: how long")
    noise_m: float | None = optional("m", above(0, 1000), "depth-gauge, sounder: noisy")
    noise_deg: float | None = optional("deg", above(0, 180), "gyro-noisy")
    noise_kn: float | None = optional("kn", above(0, 50), "log-noisy")
    bias_m: float | None = optional(
        "m", within(-1000, 1000), "depth-gauge, sounder: reads so much more"
    )
    bias_deg: float | None = optional("deg", within(-180, 180), "gyro-biased")
    bias_kn: float | None = optional("kn", within(-50, 50), "log-biased")


PART_ROWS: Final = Rows(
    CasualtyEntry, ("note",), 2, MAX_CASUALTIES, "what breaks with one cause: each as above"
)


@dataclass(frozen=True, kw_only=True)
class CompoundEntry:
    """Several casualties with one cause, as their table says it."""

    description: str = required(Text(75, "for the list"))
    parts: tuple[CasualtyEntry, ...] = required(PART_ROWS)


@dataclass(frozen=True)
class Casualty:
    """One casualty that can be ordered by its name.

    One with ``parts`` stands for these, which come and go together. It is then of the kind of its
    first part, by which it is known in marks and conditions.
    """

    name: str
    kind: str
    severity: float  # [-] unless ordered otherwise
    ramp_s: float
    clear_ramp_s: float
    description: str
    full: float  # [SI] at severity 1, for a hard-over surface a share of its limit
    parts: "tuple[Casualty, ...]" = ()

    @property
    def broken(self) -> "tuple[Casualty, ...]":
        """Return its parts, or itself where it has none."""
        return self.parts or (self,)

    @property
    def sudden(self) -> bool:
        """Return whether an order gives it neither severity nor ramp."""
        return bool(self.parts) or self.measure.sudden

    @property
    def code(self) -> int:
        """Return the core's number of its kind."""
        return CODES[self.kind]

    @property
    def measure(self) -> SeverityMeasure:
        """Return what its severity is."""
        return SEVERITY_MEASURES[self.kind]


def clause_of(description: str) -> str:
    """Return what happens as a clause, with ``{0}`` where an amount stands.

    "The stern planes run to this angle and jam: 1 full rise" is "the stern planes run to {0} and
    jam".
    """
    says, _, _ = description.partition(": 1 ")
    return (says[:1].lower() + says[1:]).replace("this angle", "{0}")


def load_casualties(*paths: str) -> Mapping[str, Casualty]:
    """Return the casualties of the shipped table and of the user's files, by name.

    ConfigError if a file is wrong or has a name that is already taken.
    """
    shipped_table = shipped_path("casualties", STANDARD_LIST)
    text, several = read_text(shipped_table), shipped_table.with_name(f"{COMPOUND_LIST}.toml")
    # a recording of before has only the standard table
    casualties = dict(_shipped(text, shipped_table, text_if_there(several), several))
    for path in map(Path, paths):
        for name, casualty in parse_casualties(read_text(path), path, casualties).items():
            if name in casualties:
                position = Position(path.name, f"casualty.{name}")
                raise ConfigError(
                    position.problem("is already in another table; give it a new name")
                )
            casualties[name] = casualty
    return casualties


@cache
def _shipped(
    text: str, path: Path, compound: str | None, compound_path: Path
) -> Mapping[str, Casualty]:
    """Return the casualties of the shipped tables, cached for the next exercise."""
    standard = parse_casualties(text, path, {})
    if compound is None:
        return standard
    return {**standard, **parse_casualties(compound, compound_path, standard)}


def parse_casualties(
    text: str, path: Path, standard: Mapping[str, Casualty]
) -> dict[str, Casualty]:
    """Return the casualties written in ``text`` from ``path``; ConfigError with all that is wrong.

    ``standard`` has what they may leave out, under the names of the kinds.
    """
    position = Position(path.name, "")
    table = parse_toml(text, path.name)
    problems: list[str] = []
    casualties: dict[str, Casualty] = {}
    for key, value in table.items():
        with collecting(problems):
            if key in HEADING_FIELDS:
                HEADING_FIELDS[key].read(key, value, position)
            elif key != "casualty":
                advice = nearest(key, KNOWN_KEYS) or "; write [casualty.NAME]"
                raise ConfigError(position.wrong(key, value, f"no such key{advice}"))
    with collecting(problems):
        if "casualty" not in table:
            raise ConfigError(position.problem("has no table [casualty.NAME]"))
        within_file = position.inside("casualty")
        for name, entry in as_table(table["casualty"], within_file).items():
            with collecting(problems):
                casualties[name] = read_casualty(name, entry, within_file.inside(name), standard)
    raise_problems(problems)
    return casualties


def read_casualty(
    name: str, table: object, position: Position, standard: Mapping[str, Casualty]
) -> Casualty:
    """Return one casualty from its table; ConfigError with all that is wrong."""
    row = as_table(table, position)
    if not CASUALTY_NAME.fullmatch(name) or name == "all":
        text = "a name is 1 to 40 of a to z, 0 to 9 and -, a letter first, and not all"
        raise ConfigError(position.problem(text))
    if "parts" in row:
        return _read_compound(name, row, position, standard)
    entry = read_record(CasualtyEntry, {**_filler(row, standard), **row}, position, ("note",))
    measure = SEVERITY_MEASURES[entry.kind]
    problems = [
        position.problem(f"{key} means nothing to {entry.kind}")
        for key in PARAMETER_KEYS
        if key in row and key != measure.parameter
    ]
    full = getattr(entry, measure.parameter) if measure.parameter else 1.0
    if full is None:
        problems.append(position.problem(f"lacks {measure.parameter}, which {entry.kind} needs"))
    if entry.severity not in measure.limits:
        problems.append(position.wrong("severity", entry.severity, severity_rule(entry.kind)))
    if measure.sudden and (entry.ramp_s or entry.clear_ramp_s):
        problems.append(position.problem(f"{entry.kind} comes and goes at once: ramps must be 0"))
    raise_problems(problems)
    return Casualty(
        name=name,
        kind=entry.kind,
        severity=entry.severity,
        ramp_s=entry.ramp_s,
        clear_ramp_s=entry.clear_ramp_s,
        description=entry.description,
        full=full * measure.factor,
    )


def _read_compound(
    name: str, row: Mapping[str, Any], position: Position, standard: Mapping[str, Casualty]
) -> Casualty:
    """Return a casualty that stands for several; ConfigError with all that is wrong."""
    problems: list[str] = []
    parts: list[Casualty] = []
    for i, part in enumerate(PART_ROWS.listed("parts", row["parts"], position)):
        within_part = position.inside(f"parts[{i}]")
        with collecting(problems):
            if "parts" in as_table(part, within_part):
                raise ConfigError(within_part.problem("has parts of its own; name a kind"))
            read = read_casualty(name, part, within_part, standard)
            if read.kind in [each.kind for each in parts]:
                raise ConfigError(within_part.wrong("kind", read.kind, "is a part above too"))
            parts.append(replace(read, name=read.kind))
    with collecting(problems):
        filled = [_filler(as_table(part, position), standard) | part for part in row["parts"]]
        entry = {**row, "parts": filled}
        said = read_record(CompoundEntry, entry, position, ("note",)).description
    raise_problems([*dict.fromkeys(problems)])  # a wrong part is read twice
    clearing = max(each.clear_ramp_s for each in parts)
    return replace(
        parts[0],
        name=name,
        severity=1.0,
        ramp_s=0.0,
        clear_ramp_s=clearing,
        description=said,
        parts=tuple(parts),
    )


def _filler(given: Mapping[str, Any], standard: Mapping[str, Casualty]) -> dict[str, Any]:
    """Return the values of the standard entry of the same kind, in the table's units."""
    kind = given.get("kind")
    usual = standard.get(kind) if isinstance(kind, str) else None
    if usual is None:
        return {}
    keys = ("severity", "ramp_s", "clear_ramp_s", "description")
    filler: dict[str, Any] = {key: getattr(usual, key) for key in keys}
    if usual.measure.parameter:
        filler[usual.measure.parameter] = usual.full / usual.measure.factor
    return filler


def listing(casualties: Mapping[str, Casualty]) -> str:
    """Return the casualties as a table of at most 79 columns, two lines for each."""
    lines = [f"{'name':27}{'severity':>9}{'ramp':>8}{'clear':>8}  severity is"]
    for entry in casualties.values():
        times = f"{entry.ramp_s:>6g} s{entry.clear_ramp_s:>6g} s"
        measure = "those of its parts" if entry.parts else entry.measure.meaning
        lines.append(f"{entry.name:27}{entry.severity:>9g}{times}  {measure}")
        lines.append(f"    {entry.description}")
        lines += parts_lines(entry)
    return "\n".join(lines)


def parts_text(casualty: Casualty) -> str:
    """Return what a casualty breaks, part by part, "" for one without parts."""
    degrees = ("" if each.sudden else f" {each.severity:.2g}" for each in casualty.parts)
    named = (f"{each.name}{degree}" for each, degree in zip(casualty.parts, degrees, strict=True))
    return f"breaks {', '.join(named)}" if casualty.parts else ""


def parts_lines(casualty: Casualty) -> list[str]:
    """Return the same as indented lines of 79 columns, none for one without parts."""
    return textwrap.wrap(
        parts_text(casualty),
        79,
        initial_indent="    ",
        subsequent_indent="    ",
        break_on_hyphens=False,
    )


def as_json(casualties: Mapping[str, Casualty]) -> list[dict[str, Any]]:
    """Return the casualties as JSON-able tables, ``full`` in SI."""
    return [
        {
            "name": entry.name,
            "kind": entry.kind,
            "severity": entry.severity,
            "severity_is": entry.measure.meaning,
            "ramp_s": entry.ramp_s,
            "clear_ramp_s": entry.clear_ramp_s,
            "full": entry.full,
            "description": entry.description,
            "parts": [each.name for each in entry.parts],
        }
        for entry in casualties.values()
    ]
