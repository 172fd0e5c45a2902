"""A job: a study with outputs and files, for the processes that fly it.

A member is one run of a study. ``sweep`` makes a job and sends it to processes or to a cluster. It
holds the texts of all files, because a machine of a cluster has none of them, and must not fly
another boat of the same name.
"""

import hashlib
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer import __version__
from trainer.analysis.manoeuvres.flight import Flight
from trainer.analysis.manoeuvres.vehicle import Measure, largest_value
from trainer.analysis.sweep.draws import Draws
from trainer.analysis.sweep.study import Study, load_study, with_members
from trainer.config.files import (
    ABANDONED_FILES,
    ConfigError,
    is_path,
    is_shipped,
    key_of,
    nearest,
    quote,
    reading_recorded,
    remembering,
)
from trainer.core.digest import core_digest, same_core
from trainer.core.kernel import Numbers

# columns of a study of identifications, by the parameter's name
DEVIATION_COLUMN: Final = "std dev of {}"
COVERED_COLUMN: Final = "{} covered"


class Output(NamedTuple):
    """One number kept of each member, SI and radians."""

    name: str
    unit: str


COLUMN_READINGS: Final[Mapping[str, Callable[[Numbers], float]]] = {
    "first": lambda values: float(values[0]),
    "last": lambda values: float(values[-1]),
    "lowest": lambda values: float(values.min()),
    "highest": lambda values: float(values.max()),
    "largest": largest_value,
}
COLUMN_UNITS: Final = {
    "t": "s",
    **dict.fromkeys(("u", "v", "w", "u_c"), "m/s"),
    **dict.fromkeys(("p", "q", "r"), "rad/s"),
    **dict.fromkeys(("x", "y", "z", "x_g", "z_g", "eta_wave"), "m"),
    **dict.fromkeys(("phi", "theta", "psi", "delta_r", "delta_s", "delta_b"), "rad"),
    "weight": "N",
}


def of_column(name: str, flight: Flight) -> Measure | None:
    """Return a measure such as "largest phi" or "last z"; None if that is none."""
    way, _, column = name.partition(" ")
    if way not in COLUMN_READINGS or not flight.has(column):
        return None
    return Measure(name, COLUMN_UNITS.get(column, "-"), COLUMN_READINGS[way](flight.column(column)))


def asked_of(study: "Study", flight: Flight, measures: Sequence[Measure]) -> tuple[Output, ...]:
    """Return the outputs that a study keeps of each member; ConfigError for an unknown one."""
    known, ways = {one.name: one for one in measures}, ", ".join(COLUMN_READINGS)
    names, file = study.heading.measures, study.path.name
    if names is None and not known:
        raise ConfigError(f"{file}: lacks measures: such as 'last z', by {ways} and a column")
    outputs = []
    for name in known if names is None else names:
        one = known.get(name) or of_column(name, flight)
        if one is None:
            columns = ", ".join(flight.series.columns)
            has = f"; there are {', '.join(known)}" if known else ""
            problem = f"no measure {quote(name)}{nearest(name, known)}{has}"
            raise ConfigError(f"{file}: {problem}; and {ways} of {columns}")
        outputs.append(Output(one.name, one.unit))
    return tuple(outputs)


def read_off(outputs: Sequence[Output], flight: Flight, measures: Sequence[Measure]) -> list[float]:
    """Return the outputs of a flight, NaN for one that the flight never came to."""
    known = {one.name: one for one in measures}
    values = []
    for output in outputs:
        one = known.get(output.name) or of_column(output.name, flight)
        value = None if one is None else one.value
        values.append(math.nan if value is None or not np.isfinite(value) else float(value))
    return values


@dataclass(frozen=True)
class Batch:
    """Members in their order."""

    members: NDArray[np.int64]
    seeds: NDArray[np.int64]
    drawn: dict[str, NDArray[Any]]  # by variable: numbers or words
    outputs: Numbers  # [member, output]; NaN: never came to that
    troubles: tuple[str | None, ...]  # why there is nothing of a member

    def told(self, index: int, names: Sequence[str]) -> dict[str, Any]:
        """Return one member by the result's columns. None: an output that it never came to."""
        numbers = [None if np.isnan(x) else float(x) for x in self.outputs[index]]
        return {
            "member": int(self.members[index]),
            "seed": int(self.seeds[index]),
            **member_values(self.drawn, index),
            **dict(zip(names, numbers, strict=True)),
            "trouble": self.troubles[index],
        }


class Subject(Protocol):
    """The common part of every member of a study."""

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of each member."""

    @property
    def chunk(self) -> int:
        """Return how many members are flown, and kept, at once."""

    def batch(self, first: int, count: int) -> Batch:
        """Return the results of ``count`` members from ``first`` on."""


def member_values(drawn: Mapping[str, NDArray[Any]], index: int) -> dict[str, Any]:
    """Return numbers and words of one member as Python's own."""
    return {
        name: values[index] if isinstance(values[index], str) else float(values[index])
        for name, values in drawn.items()
    }


def fly_each(
    draws: Draws,
    first: int,
    count: int,
    width: int,
    fly: Callable[[dict[str, Any], int], Sequence[float]],
    done: Mapping[int, Sequence[float]] = MappingProxyType({}),
) -> Batch:
    """Return the results of members flown one by one, except those that are ``done``.

    ``fly`` takes a member's numbers and seed, and returns ``width`` numbers; its ConfigError says
    why there are none.
    """
    drawn, seeds = draws.drawn(first, count), draws.seeds(first, count)
    outputs = np.full((count, width), np.nan)
    troubles: list[str | None] = [None] * count
    for i in range(count):
        try:
            outputs[i] = done[i] if i in done else fly(member_values(drawn, i), int(seeds[i]))
        except ConfigError as wrong:
            troubles[i] = wrong.problems[0]
    return Batch(np.arange(first, first + count), seeds, drawn, outputs, tuple(troubles))


@dataclass(frozen=True)
class Job:
    """A study that can be flown anywhere: no file is read but from ``texts``."""

    name: str  # as the user gave it
    members: int | None  # instead of the study's own
    texts: tuple[tuple[str, str], ...]  # by key, sorted
    version: str
    core: str  # digest of the core's sources
    make: Callable[[Study], Subject]  # makes the members ready

    @property
    def facts(self) -> dict[str, Any]:
        """Return the facts that determine the members' bits, for a manifest; no place on disk."""
        return {
            "study": Path(self.name).stem,
            "members": self.members,
            "files": as_seen_from(self.name, dict(self.texts)),
            "version": self.version,
            "core": self.core,
        }

    @cached_property
    def digest(self) -> str:
        """Return a short hash of the facts."""
        text = json.dumps(self.facts, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class OpenJob:
    """A job made ready on this machine."""

    study: Study
    subject: Subject

    @property
    def members(self) -> int:
        """Return how many members there are."""
        return self.study.draws.members

    @property
    def chunks(self) -> int:
        """Return how many chunks the members are flown in."""
        return -(-self.members // self.subject.chunk)

    def chunk(self, index: int) -> Batch:
        """Return the results of one chunk's members."""
        first = index * self.subject.chunk
        return self.subject.batch(first, min(self.subject.chunk, self.members - first))


def as_seen_from(study: str, texts: Mapping[str, str]) -> dict[str, str]:
    """Return texts by their paths from a study's folder. Shipped files keep theirs."""
    if not is_path(study):
        return dict(texts)
    folder = Path(study).parent
    return {
        key if is_shipped(key) else key_of(Path(os.path.relpath(key, folder))): text
        for key, text in texts.items()
    }


def job_of(name: str, members: int | None, make: Callable[[Study], Subject]) -> Job:
    """Return the job of the study of that name or path. ConfigError if it cannot be flown.

    ``make`` makes its members ready. It goes to other processes by its name.
    """
    with remembering() as texts:
        _open(name, members, make)
    return Job(name, members, tuple(sorted(texts.items())), __version__, core_digest(), make)


def _open(name: str, members: int | None, make: Callable[[Study], Subject]) -> OpenJob:
    study = load_study(name)
    study = study if members is None else with_members(study, members)
    subject = make(study)
    if not subject.outputs:
        raise ConfigError("there is nothing to keep of a member")
    return OpenJob(study, subject)


@lru_cache(maxsize=2)
def open_job(job: Job) -> OpenJob:
    """Return the job made ready, once in each process; ConfigError if this is another version."""
    mine = core_digest()
    if not same_core(job.core):
        raise ConfigError(f"this machine's core is {mine}, the study's is {job.core}: update it")
    with reading_recorded(dict(job.texts)):
        return _open(job.name, job.members, job.make)


def fly_chunk(job: Job, index: int) -> Batch:
    """Return the results of one chunk's members, from the files in the job alone."""
    ready = open_job(job)
    with reading_recorded(dict(job.texts)):
        return ready.chunk(index)


def fact_differences(then: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return in words what differs between the facts of two jobs."""
    study = str(then.get("study", ""))  # an earlier version's is its path
    files = as_seen_from(study, then.get("files", {}))
    then = {**then, "study": Path(study).stem, "files": files}
    problems = [
        f"{name}: {then.get(name)!r} then, {now[name]!r} now"
        for name in ("study", "members", "version", "core")
        if then.get(name) != now[name]
        and not (name == "core" and same_core(then.get(name)) and same_core(now[name]))
    ]
    before, after = then["files"], now["files"]
    before = {key: text for key, text in before.items() if key not in ABANDONED_FILES}
    for key in sorted({*before, *after}):
        if before.get(key) == after.get(key):
            continue
        if key not in before or key not in after:
            problems.append(f"{key}: is read {'now' if key in after else 'no longer'}")
        else:
            problems.append(_first_line(key, before[key], after[key]))
    return problems


def _first_line(key: str, before: str, after: str) -> str:
    """Return the first line in which two texts differ, in words."""
    old, new = before.splitlines(), after.splitlines()
    for number in range(max(len(old), len(new))):
        one, other = (lines[number] if number < len(lines) else "" for lines in (old, new))
        if one != other:
            return f"{key}, line {number + 1}: {one.strip()!r} then, {other.strip()!r} now"
    return f"{key}: ends otherwise"
