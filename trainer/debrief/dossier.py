"""The dossier: all that a debrief tells, gathered from a recording."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trainer.boat import Boat
from trainer.config import ConfigError
from trainer.io.recording import Branch, Journalled, Noted, Recording
from trainer.plan import Plan
from trainer.records.log_book import layout_of, plan_of
from trainer.scores.passage import Passage, read_passage
from trainer.scores.scoring import Scorecard, score
from trainer.scores.spells import Deflection, Spell, answer_to, crew_orders, deflection, spells

ECHOES: Final = frozenset({"order", "exercise"})  # events that repeat an order of the journal


@dataclass(frozen=True)
class Answered:
    """A casualty, and what the crew did about it."""

    spell: Spell
    order: Journalled | None
    deflection: Deflection | None


@dataclass(frozen=True)
class Hand:
    """One that gave orders, and how many."""

    who: str
    orders: int
    refused: int


@dataclass(frozen=True)
class Ticks:
    """What became of the ticks that were timed; times in ns, None without any."""

    timed: int
    duty_cycle: float | None  # [-]
    work: tuple[float, float, float] | None  # median, 99 %, most
    lateness: tuple[float, float, float] | None


@dataclass(frozen=True)
class Dossier:
    """Everything about one branch of a recording with its past."""

    source: Path
    header: Mapping[str, str]
    plan: Plan
    branch: Branch
    branches: tuple[tuple[Branch, int], ...]  # each with its last tick
    passage: Passage
    card: Scorecard
    casualties: tuple[Answered, ...]
    crew: tuple[Journalled, ...]
    hands: tuple[Hand, ...]
    events: tuple[Noted, ...]  # of this past, without those that repeat an order
    ticks: Ticks

    @property
    def title(self) -> str:
        """Return what was flown."""
        return self.plan.title or "A run without an exercise"

    @property
    def step(self) -> float:
        """Return the time [s] from tick to tick."""
        return self.plan.method.step

    def of_kind(self, *kinds: str) -> tuple[Noted, ...]:
        """Return the events of these kinds."""
        return tuple(event for event in self.events if event.kind in kinds)


def gather(recording: Recording, source: Path, number: int | None) -> Dossier:
    """Return the dossier of a branch, None for the latest.

    ConfigError if the header cannot be read or there is no such branch.
    """
    header = recording.header()
    branches = recording.branches()
    wanted = branches[-1].id if number is None else number
    branch = next((each for each in branches if each.id == wanted), None)
    if branch is None:
        there = f"1 to {branches[-1].id}" if len(branches) > 1 else "1 only"
        raise ConfigError(f"{source}: --branch {wanted}: there are branches {there}")
    plan = plan_of(header)
    boat = Boat(plan.file, plan.method)
    passage = read_passage(recording, wanted, layout_of(header), boat, plan.limits)
    return Dossier(
        source=source,
        header=header,
        plan=plan,
        branch=branch,
        branches=tuple((each, last_tick(recording, each)) for each in branches),
        passage=passage,
        card=score(passage, plan.scores),
        casualties=tuple(answered(passage)),
        crew=crew_orders(passage),
        hands=hands(passage),
        events=tuple(events_of(recording, branches, branch)),
        ticks=ticks_of(passage),
    )


def last_tick(recording: Recording, branch: Branch) -> int:
    """Return the last tick recorded of a branch."""
    return max((tick for tick, _ in recording.states(branch.id)), default=branch.tick)


def answered(passage: Passage) -> Iterator[Answered]:
    """Yield the casualties with what was done about them."""
    for spell in spells(passage):
        yield Answered(spell, answer_to(passage, spell), deflection(passage, spell))


def hands(passage: Passage) -> tuple[Hand, ...]:
    """Return who gave orders, in the order in which they began to."""
    found = []
    for who in dict.fromkeys(each.who for each in passage.orders):
        own = [each for each in passage.orders if each.who == who]
        found.append(Hand(who, len(own), sum(each.accepted is False for each in own)))
    return tuple(found)


def events_of(recording: Recording, branches: list[Branch], branch: Branch) -> Iterator[Noted]:
    """Yield what happened in a branch and in its past, up to where each next one began."""
    ends: dict[int, int | None] = {}
    here: Branch | None = branch
    end: int | None = None
    while here is not None:
        ends[here.id] = end
        end = here.tick
        parent = here.parent
        here = next((each for each in branches if each.id == parent), None)
    for event in recording.events():
        if event.branch not in ends or event.kind in ECHOES:
            continue
        last = ends[event.branch]
        if last is None or event.tick <= last:
            yield event


def ticks_of(passage: Passage) -> Ticks:
    """Return what became of the ticks."""
    timed = ~np.isnan(passage.work)
    count = int(timed.sum())
    if not count:
        return Ticks(0, None, None, None)
    work, lateness = passage.work[timed], np.maximum(passage.lateness[timed], 0.0)
    duty = float(work.sum()) / (count * passage.boat.method.step * 1e9)
    return Ticks(count, duty, _spread(work), _spread(lateness))


def _spread(values: np.ndarray) -> tuple[float, float, float]:
    median, most_of_them = np.percentile(values, (50.0, 99.0))
    return float(median), float(most_of_them), float(values.max())
