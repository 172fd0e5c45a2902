"""The job for whoever flies members: the study, and every file it reads."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

from trainer import __version__
from trainer.analysis.sweep.batch import Batch, Subject
from trainer.analysis.sweep.study import Study, load_study, with_members
from trainer.config.files import ABANDONED, ConfigError, reading_recorded, remembering
from trainer.core.cache import core_digest, same_core


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
        """Return what the members' bits follow from, for a manifest."""
        return {
            "study": self.name,
            "members": self.members,
            "files": dict(self.texts),
            "version": self.version,
            "core": self.core,
        }

    @cached_property
    def digest(self) -> str:
        """Return a short hash of all of that."""
        text = json.dumps(self.facts, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Opened:
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

    def chunk(self, place: int) -> Batch:
        """Return what becomes of the members of one chunk."""
        first = place * self.subject.chunk
        return self.subject.batch(first, min(self.subject.chunk, self.members - first))


def job_of(name: str, members: int | None, make: Callable[[Study], Subject]) -> Job:
    """Return the job of the study of that name or path. ConfigError if it cannot be flown.

    ``make`` makes its members ready; it is sent to whoever flies them by its name.
    """
    with remembering() as texts:
        _open(name, members, make)
    return Job(name, members, tuple(sorted(texts.items())), __version__, core_digest(), make)


def _open(name: str, members: int | None, make: Callable[[Study], Subject]) -> Opened:
    study = load_study(name)
    study = study if members is None else with_members(study, members)
    return Opened(study, _check_outputs(make(study)))


def _check_outputs(subject: Subject) -> Subject:
    """Return the subject; ConfigError if what it is asked to keep is not there."""
    if not subject.outputs:
        raise ConfigError("there is nothing to keep of a member")
    return subject


@lru_cache(maxsize=2)
def open_job(job: Job) -> Opened:
    """Return the job made ready, once in each process; ConfigError if this is another version."""
    mine = core_digest()
    if not same_core(job.core):
        raise ConfigError(f"this machine's core is {mine}, the study's is {job.core}: update it")
    with reading_recorded(dict(job.texts)):
        return _open(job.name, job.members, job.make)


def fly_chunk(job: Job, place: int) -> Batch:
    """Return what becomes of one chunk's members, by no files but the job's."""
    ready = open_job(job)
    with reading_recorded(dict(job.texts)):
        return ready.chunk(place)


def differences(then: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return in words what differs between the facts of two jobs."""
    found = [
        f"{name}: {then.get(name)!r} then, {now[name]!r} now"
        for name in ("study", "members", "version", "core")
        if then.get(name) != now[name]
        and not (name == "core" and same_core(then.get(name)) and same_core(now[name]))
    ]
    before, after = then.get("files", {}), now["files"]
    before = {key: text for key, text in before.items() if key not in ABANDONED}
    for key in sorted({*before, *after}):
        if before.get(key) == after.get(key):
            continue
        if key not in before or key not in after:
            found.append(f"{key}: is read {'now' if key in after else 'no longer'}")
        else:
            found.append(_first_line(key, before[key], after[key]))
    return found


def _first_line(key: str, before: str, after: str) -> str:
    """Return the first line in which two texts differ, in words."""
    old, new = before.splitlines(), after.splitlines()
    for number in range(max(len(old), len(new))):
        one, other = (lines[number] if number < len(lines) else "" for lines in (old, new))
        if one != other:
            return f"{key}, line {number + 1}: {one.strip()!r} then, {other.strip()!r} now"
    return f"{key}: ends otherwise"
