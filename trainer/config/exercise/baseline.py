"""The baseline beside an exercise: its marks with nobody aboard, and with the reference crew.

``trainer exercise baseline`` flies and writes it. A debrief takes the marks with nobody aboard from
it if the recording was made with another core (docs/debrief.md). ``trainer exercise validate
--keep`` adds how well its marks tell model people apart (docs/validation.md).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    parse_toml,
    text_if_there,
    toml_value,
)
from trainer.config.schema import Choice, Quantity, Text, read_record, required, within

BASELINE_SCHEMA: Final = "baseline/1"
BASELINE_SUFFIX: Final = ".baseline.toml"  # ends the name of its file; no run depends on it
# fmt: off
UNFLOWN_KEYS: Final = (
    "name", "lesson", "briefing", "instructor", "stated", "note", "visitors",
)  # keys that fly nothing
# fmt: on
MARK_QUANTITY: Final = Quantity("%", within(0, 100), "marks")


@dataclass(frozen=True, kw_only=True)
class BaselineHeading:
    """The conditions in which a baseline was flown."""

    schema: str = required(Choice((BASELINE_SCHEMA,), "form of the file"))
    exercise: str = required(Text(64, "digest of what the exercise flies and judges"))
    core: str = required(Text(80, "digest of the core"))
    seed: float = required("-", within(0, 1e15), "of the marks")
    seeds: float = required("-", within(1, 1e4), "flown for mean and deviation")


@dataclass(frozen=True, kw_only=True)
class Totals:
    """The totals of one way to fly it, at its seed and over all seeds."""

    total: float = required(MARK_QUANTITY)
    outcome: str = required(Text(40, "won, lost or not reached, at the exercise's seed"))
    mean: float = required(MARK_QUANTITY)
    deviation: float = required("%", within(0, 100), "standard deviation by the sea alone")
    least: float = required(MARK_QUANTITY)


@dataclass(frozen=True, kw_only=True)
class PeopleFigures:
    """What the marks of model people in one exercise are worth, by test and retest."""

    core: str = required(Text(80, "digest of the core"))
    persons: float = required("-", within(2, 1e4), "each flew it twice")
    correlation: float = required("-", within(-1, 1), "of the ranks of marks with those of skill")
    better_has_more: float = required("-", within(0, 1), "share of pairs of a better and a worse")
    standard_error: float = required("%", within(0, 100), "of one run's mark")
    ceiling: float = required("-", within(0, 1), "share of runs with next to all marks")
    mean: float = required(MARK_QUANTITY)


@dataclass(frozen=True, kw_only=True)
class Baseline:
    """A baseline as it is kept."""

    heading: BaselineHeading
    nobody: Totals
    crew: Totals | None
    marks: Mapping[str, float]  # [%] with nobody aboard, by the name of the score
    people: PeopleFigures | None = None

    def fits(self, text: str) -> bool:
        """Return whether it is of an exercise with this text."""
        return self.heading.exercise == digest_of(text)


def digest_of(text: str) -> str:
    """Return the digest of what an exercise flies and judges, without titles and briefings."""
    table = parse_toml(text, "exercise")
    flown = {key: value for key, value in table.items() if key not in UNFLOWN_KEYS}
    return hashlib.sha256(json.dumps(flown, sort_keys=True).encode()).hexdigest()[:16]


def baseline_path(exercise: Path) -> Path:
    """Return where the baseline of an exercise is kept: beside it."""
    return exercise.with_name(f"{exercise.stem}{BASELINE_SUFFIX}")


def kept_baseline(exercise: Path) -> Baseline | None:
    """Return the baseline beside an exercise, None without; ConfigError if it is wrong."""
    path = baseline_path(exercise)
    text = text_if_there(path)
    return None if text is None else read_baseline(text, path)


def read_baseline(text: str, path: Path) -> Baseline:
    """Return the baseline in ``text``; ConfigError if it is wrong."""
    table, position = parse_toml(text, path.name), Position(path.name, "")
    tables = ("nobody", "crew", "people", "marks")
    heading = {key: value for key, value in table.items() if key not in tables}
    marks = as_table(table.get("marks", {}), position.inside("marks"))
    if "nobody" not in table:
        raise ConfigError(position.problem("lacks [nobody]"))
    crew, people = table.get("crew"), table.get("people")
    return Baseline(
        heading=read_record(BaselineHeading, heading, position, ()),
        nobody=read_record(Totals, table["nobody"], position.inside("nobody"), ()),
        crew=None if crew is None else read_record(Totals, crew, position.inside("crew"), ()),
        people=None
        if people is None
        else read_record(PeopleFigures, people, position.inside("people"), ()),
        marks={
            name: MARK_QUANTITY.read(name, value, position.inside("marks"))
            for name, value in marks.items()
        },
    )


def write_baseline(baseline: Baseline) -> str:
    """Return the text that reads back as this baseline."""
    head = baseline.heading
    lines = [
        "# Written by `trainer exercise baseline`: marks [%] with nobody aboard and with the",
        "# reference crew. Not to be changed by hand.",
        *(f"{key} = {toml_value(getattr(head, key))}" for key in ("schema", "exercise", "core")),
        *(f"{key} = {int(getattr(head, key))}" for key in ("seed", "seeds")),
    ]
    for name, totals in (("nobody", baseline.nobody), ("crew", baseline.crew)):
        if totals is not None:
            lines += ["", f"[{name}]", f"total = {totals.total:.1f}"]
            lines += [f"outcome = {toml_value(totals.outcome)}", f"mean = {totals.mean:.1f}"]
            lines += [f"deviation = {totals.deviation:.1f}", f"least = {totals.least:.1f}"]
    if (people := baseline.people) is not None:
        lines += ["", "[people]  # model operators: trainer exercise validate --keep"]
        lines += [f"core = {toml_value(people.core)}", f"persons = {people.persons:.0f}"]
        shares = ("correlation", "better_has_more", "ceiling")
        lines += [f"{key} = {getattr(people, key):.2f}" for key in shares]
        lines += [f"{key} = {getattr(people, key):.1f}" for key in ("standard_error", "mean")]
    lines += ["", "[marks]  # with nobody aboard"]
    lines += [f"{toml_value(name)} = {mark:.2f}" for name, mark in baseline.marks.items()]
    return "\n".join(lines) + "\n"
