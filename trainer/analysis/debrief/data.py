"""All that a debrief tells, gathered from a recording, and its figures for programs."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.debrief.episodes import (
    Deflection,
    Episode,
    answer_to,
    crew_orders,
    deflection,
    spells,
)
from trainer.analysis.debrief.judgement import judge, plain_marks
from trainer.analysis.debrief.scoring import Scorecard, Scored, Verdict
from trainer.analysis.debrief.trajectory import Trajectory, read_passage
from trainer.analysis.rehearsal import fly
from trainer.boat.boat import Boat
from trainer.config.files import ConfigError
from trainer.core.cache import same_core
from trainer.io.recording.recording import Branch, Journalled, Noted, Recording
from trainer.session.header import layout_of, plan_of
from trainer.session.plan import Plan

ECHOES: Final = frozenset({"order", "exercise"})  # events that repeat an order of the journal


@dataclass(frozen=True)
class Answered:
    """A casualty, and what the crew did about it."""

    episode: Episode
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
class DebriefData:
    """Everything about one branch of a recording with its past."""

    source: Path
    header: Mapping[str, str]
    plan: Plan
    branch: Branch
    branches: tuple[tuple[Branch, int], ...]  # each with its last tick
    trajectory: Trajectory
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


def gather(
    recording: Recording, source: Path, number: int | None, width: str = "qualified"
) -> DebriefData:
    """Return the dossier of a branch, None for the latest, judged at a width.

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
    trajectory = read_passage(recording, wanted, layout_of(header), boat, plan.limits)
    return DebriefData(
        source=source,
        header=header,
        plan=plan,
        branch=branch,
        branches=tuple((each, last_tick(recording, each)) for each in branches),
        trajectory=trajectory,
        card=judge(trajectory, plan, nobody_aboard(plan, header, width), width),
        casualties=tuple(pair_answers(trajectory)),
        crew=crew_orders(trajectory),
        hands=hands(trajectory),
        events=tuple(events_of(recording, branches, branch)),
        ticks=ticks_of(trajectory),
    )


def nobody_aboard(plan: Plan, header: Mapping[str, str], width: str) -> Mapping[str, float]:
    """Return the marks of each rule with nobody aboard, by its name.

    They are flown at the seed of the record, or by another core those that are kept.
    """
    if not plan.judged_by_tasks:
        return {}
    if plan.duration is not None and same_core(header.get("core")):
        return plain_marks(fly(plan.alone()).trajectory, plan, width)
    return plan.baseline.marks if plan.baseline else {}


def last_tick(recording: Recording, branch: Branch) -> int:
    """Return the last tick recorded of a branch."""
    return max((tick for tick, _ in recording.states(branch.id)), default=branch.tick)


def pair_answers(trajectory: Trajectory) -> Iterator[Answered]:
    """Yield the casualties with what was done about them."""
    for episode in spells(trajectory):
        yield Answered(episode, answer_to(trajectory, episode), deflection(trajectory, episode))


def hands(trajectory: Trajectory) -> tuple[Hand, ...]:
    """Return who gave orders, in the order in which they began to."""
    found = []
    for who in dict.fromkeys(each.who for each in trajectory.orders):
        own = [each for each in trajectory.orders if each.who == who]
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


def ticks_of(trajectory: Trajectory) -> Ticks:
    """Return what became of the ticks."""
    timed = ~np.isnan(trajectory.work)
    count = int(timed.sum())
    if not count:
        return Ticks(0, None, None, None)
    work, lateness = trajectory.work[timed], np.maximum(trajectory.lateness[timed], 0.0)
    duty = float(work.sum()) / (count * trajectory.boat.method.step * 1e9)
    return Ticks(count, duty, _spread(work), _spread(lateness))


def _spread(values: np.ndarray) -> tuple[float, float, float]:
    median, most_of_them = np.percentile(values, (50.0, 99.0))
    return float(median), float(most_of_them), float(values.max())


def figures(debrief: DebriefData) -> dict[str, Any]:
    """Return what the page tells in numbers; times in s, marks in per cent."""
    step = debrief.step
    return {
        "exercise": debrief.plan.title,
        "vessel": debrief.plan.file.name,
        "started": debrief.header.get("started"),
        "branch": debrief.branch.id,
        "branches": [
            {"branch": each.id, "parent": each.parent, "tick": each.tick, "last": last}
            | {"why": each.why}
            for each, last in debrief.branches
        ],
        "seconds": float(debrief.trajectory.seconds[-1]),
        "total": debrief.card.total,
        "verdict": _verdict(debrief.card.verdict),
        "practice": debrief.branch.parent is not None,
        "scores": [_score(each, step) for each in debrief.card.scores],
        "casualties": [_casualty(each, step) for each in debrief.casualties],
        "marks": [
            {"seconds": each.tick * step, "remark": each.text, "by": each.who}
            for each in debrief.of_kind("mark")
        ],
        "ticks": asdict(debrief.ticks),
    }


def _seconds(tick: int | None, step: float) -> float | None:
    return None if tick is None else tick * step


def _verdict(verdict: Verdict | None) -> dict[str, Any] | None:
    """Return how an exercise ended, None for one whose marks are a plain mean."""
    return None if verdict is None else asdict(verdict)


def _score(each: Scored, step: float) -> dict[str, Any]:
    """Return a rule and how it was met."""
    return {
        "name": each.name,
        "measure": each.rule.score.measure,
        "value": each.attained.value,
        "unit": each.unit,
        "why": each.attained.why,
        "marks": each.marks,
        "part": each.rule.part,
        "nobody": each.nobody,
        "earned": each.earned,
        "weight": each.rule.weight,
        "tick": each.attained.tick,
        "seconds": _seconds(each.attained.tick, step),
        "formula": each.formula,
    }


def _casualty(each: Answered, step: float) -> dict[str, Any]:
    """Return a casualty and what was done about it."""
    return {
        "kind": each.episode.kind,
        "begun_s": each.episode.begun * step,
        "ended_s": _seconds(each.episode.ended, step),
        "order": each.order and each.order.text,
        "order_by": each.order and each.order.who,
        "order_s": each.order and each.order.tick * step,
        "deflected": each.deflection and each.deflection.surface,
        "deflected_s": each.deflection and each.deflection.tick * step,
    }
