"""The data of a debrief, gathered from a recording, and its figures for programs.

``page`` draws a debrief from it, and ``history`` lists many. All is computed here, before anything
is drawn, so that page, terminal and ``--json`` have the same figures.
"""

# long: one record of a debrief, and all that is gathered for it
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.world.world import world_of
from trainer.config.exercise.reference_crew import Crew
from trainer.config.files import ConfigError
from trainer.core.digest import same_core
from trainer.debrief.attainable.curve import AttainableCurve, attainable_curve
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.attainable.search import NoCurve
from trainer.debrief.attainable.words import attainable_figures
from trainer.debrief.marks.changes import (
    OUTCOME_NAME,
    WIDTH_NAME,
    Change,
    changed_card,
    read_changes,
)
from trainer.debrief.marks.forms import EvaluationForm, compare_forms, read_forms
from trainer.debrief.marks.judgement import (
    WIDTH_FACTORS,
    MarkCost,
    dearest_costs,
    judge_run,
    plain_marks,
)
from trainer.debrief.marks.reference import Reference, can_fly, fly_reference, join_runs
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.debrief.marks.scoring import RuleScore, Scorecard
from trainer.debrief.marks.station_marks import TaskMarks, attribute_marks
from trainer.debrief.passage.crew_work import CrewWork, judge_crew
from trainer.debrief.passage.episodes import (
    Deflection,
    Episode,
    ReadBack,
    aids_used,
    answer_to,
    casualty_episodes,
    crew_orders,
    first_deflection,
    read_backs,
)
from trainer.debrief.passage.ships_met import meet_ships
from trainer.debrief.passage.trajectory import Trajectory, read_passage
from trainer.debrief.passage.watches import Watch, stood_watches
from trainer.io.recording.facts import OVER_WORDS, REFERENCE_GIVER, BranchCause, Giver, GiverKind
from trainer.io.recording.recording import (
    Branch,
    ExcessRows,
    RecordedEvent,
    RecordedOrder,
    Recording,
)
from trainer.session.past.header import FAMILIARISATION_KEY, layout_of, plan_of, trainees_of
from trainer.session.past.journal import restore_world
from trainer.session.past.plan import Plan
from trainer.session.stations.alerts import Alert, AlertNote, recorded_alerts

NO_MARKS: Final = Scorecard((), None)
ECHO_EVENTS: Final = frozenset({"order", "exercise"})  # events that repeat an order of the journal


@dataclass(frozen=True)
class CasualtyAnswer:
    """A casualty, and what the crew did about it."""

    episode: Episode
    order: RecordedOrder | None
    deflection: Deflection | None


@dataclass(frozen=True)
class GiverCount:
    """Somebody who gave orders, and how many."""

    giver: Giver
    orders: int
    refused: int

    @property
    def who(self) -> str:
        """Return the giver's name as people read it."""
        return self.giver.words


@dataclass(frozen=True)
class TickCounts:
    """The counts of the ticks that were timed. Times are in ns, None without any."""

    timed: int
    duty_cycle: float | None  # [-]
    work: tuple[float, float, float] | None  # median, 99 %, most
    lateness: tuple[float, float, float] | None


@dataclass(frozen=True)
class ReferenceComparison:
    """A run beside that of the reference crew."""

    reference: Reference
    curve: AttainableCurve | None = None  # what could still be earned, at each moment
    no_curve: str = ""  # why there is none
    from_here: Reference | None = None  # the reference crew from a recorded moment on


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
    casualties: tuple[CasualtyAnswer, ...]
    crew: tuple[RecordedOrder, ...]
    hands: tuple[GiverCount, ...]
    events: tuple[RecordedEvent, ...]  # of this past, without those that repeat an order
    ticks: TickCounts
    width: str = "qualified"  # of the bands, as it was judged first
    practice: str = ""  # why it is none of the record: it was wound back
    trainees: tuple[str, ...] = ()
    familiarisation: bool = False  # a run to get to know the simulator: it has no marks
    forms: tuple[EvaluationForm, ...] = ()  # filled in by assessors and peers
    read_backs: tuple[ReadBack, ...] = ()
    watches: tuple[Watch, ...] = ()  # of persons at stations
    crew_work: CrewWork | None = None  # None: fewer than two stations, or nothing was ordered
    changes: tuple[Change, ...] = ()  # of the instructor's
    changed: Scorecard | None = None  # the marks after them
    compared: ReferenceComparison | None = None
    excess: tuple[ExcessRows, ...] = ()  # of what the recording has more than was read
    nobody: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # [%] by width, score

    @property
    def aids(self) -> tuple[str, ...]:
        """Return the aids that were on at any time of the run."""
        return aids_used(self.trajectory)

    @property
    def shown(self) -> bool:
        """Return whether the reference crew flew it, to show the way."""
        return is_shown([each for each, _ in self.branches], self.branch)

    @property
    def title(self) -> str:
        """Return what was flown."""
        return self.plan.title or "A run without an exercise"

    @property
    def step(self) -> float:
        """Return the time [s] from tick to tick."""
        return self.plan.method.step

    @property
    def final(self) -> Scorecard:
        """Return the marks that count: the instructor's changed ones, if there are any."""
        return self.changed or self.card

    @property
    def total(self) -> float | None:
        """Return the marks of all [%], None where nothing counts or the run is free."""
        return self.final.total

    @property
    def task_marks(self) -> tuple[TaskMarks, ...]:
        """Return whose the marks of each task are; a free run has none."""
        return () if self.free else attribute_marks(self.trajectory, self.final, self.watches)

    @property
    def manned(self) -> bool:
        """Return whether it makes a difference who did what: several stations, or named watches."""
        roles = {each.giver.role for each in self.crew}
        return len(roles) > 1 or bool(self.watches)

    @property
    def free(self) -> bool:
        """Return whether the run is flown without marks."""
        return bool(self.final.verdict and self.final.verdict.free)

    @property
    def costs(self) -> tuple[MarkCost, ...]:
        """Return what cost most of the marks that count; a free run has none."""
        if self.free:
            return ()
        return dearest_costs(self.final, self.compared.reference.card if self.compared else None)

    def of_kind(self, *kinds: str) -> tuple[RecordedEvent, ...]:
        """Return the events of these kinds."""
        return tuple(event for event in self.events if event.kind in kinds)


class RunOpinions(NamedTuple):
    """What people think of a run, kept beside its recording."""

    changes: tuple[Change, ...]  # of the instructor's
    forms: tuple[EvaluationForm, ...]  # filled in by assessors and peers


def read_opinions(source: Path) -> RunOpinions:
    """Return what is kept beside a recording; ConfigError if it cannot be read."""
    return RunOpinions(read_changes(source), read_forms(source))


def gather_debrief(
    recording: Recording,
    source: Path,
    number: int | None,
    width: str | None = None,
    opinions: RunOpinions | None = None,
) -> DebriefData:
    """Return the data of a branch. None: that of ``crew_branch``, the width of the run.

    The ``width`` is of the bands of marks: "qualified", or "basic", half as wide again.
    ``opinions`` stands for what is kept beside the recording.

    ConfigError if the header cannot be read or there is no such branch.
    """
    header = recording.header()
    begun = header.get("width", "")
    width = width or (begun if begun in WIDTH_FACTORS else "qualified")
    branches = recording.branches()
    branch = find_branch(recording, source, number)
    wanted = branch.id
    plan = plan_of(header)
    if is_shown(branches, branch):  # by the reference crew: it counts for no mark
        plan = replace(plan, scores=(), lost=(), hand=(), crew=Crew())
    boat = plan.outfit.another()
    boat.world = world_of(boat, plan.around)
    restore_world(boat, recording, wanted, sys.maxsize)
    events = tuple(events_of(recording, branches, branch))
    trajectory = replace(
        read_passage(recording, wanted, layout_of(header), boat, plan.limits),
        marks=tuple(each for each in events if each.kind == "mark"),
        alerts=tuple(
            recorded_alerts(
                AlertNote.of(each, plan.method.step)
                for each in within_past(recording.notes(), branches, branch)
            )
        ),
    )
    familiarisation = FAMILIARISATION_KEY in header
    if familiarisation:
        plan = replace(plan, scores=())
    opinions = opinions or read_opinions(source)
    changes = tuple(each for each in opinions.changes if each.branch == wanted and plan.scores)
    nobody = {
        each: nobody_aboard(plan, header, each)
        for each in {width, *(change.what for change in changes if change.name == WIDTH_NAME)}
    }
    spoken, last = read_backs(trajectory), int(trajectory.ticks[-1])
    return DebriefData(
        source=source,
        header=header,
        plan=plan,
        branch=branch,
        branches=tuple((each, last_tick(recording, each)) for each in branches),
        trajectory=trajectory,
        card=NO_MARKS if familiarisation else judge_run(trajectory, plan, nobody[width], width),
        casualties=tuple(
            CasualtyAnswer(each, answer_to(trajectory, each), first_deflection(trajectory, each))
            for each in casualty_episodes(trajectory)
        ),
        crew=crew_orders(trajectory),
        hands=order_givers(trajectory),
        events=events,
        ticks=ticks_of(trajectory),
        width=width,
        practice=practice_of(plan, branches, branch),
        trainees=trainees_of(header),
        familiarisation=familiarisation,
        forms=opinions.forms,
        read_backs=spoken,
        crew_work=judge_crew(trajectory.orders, spoken, plan.method.step, last),
        watches=stood_watches(trajectory),
        changes=changes,
        changed=changed_card(trajectory, plan, nobody, width, changes) if changes else None,
        excess=recording.excess(),
        nobody=nobody,
    )


def find_branch(recording: Recording, source: Path, number: int | None) -> Branch:
    """Return a branch by its number, that of ``crew_branch`` for None.

    ConfigError if there is none such.
    """
    branches = recording.branches()
    wanted = crew_branch(recording, branches).id if number is None else number
    branch = next((each for each in branches if each.id == wanted), None)
    if branch is None:
        numbers = f"1 to {branches[-1].id}" if len(branches) > 1 else "1 only"
        raise ConfigError(f"{source}: --branch {wanted}: there are branches {numbers}")
    return branch


def compare_debrief(
    debrief: DebriefData,
    seconds: float | None = None,
    progress: Callable[[float], object] = lambda _: None,
) -> DebriefData:
    """Return a debrief with the reference crew's run beside it, if it has one.

    With ``seconds`` the reference crew also takes over at that time. ConfigError if it cannot.
    ``progress`` is told the share of the curve that is known.
    """
    reference = None
    if not debrief.familiarisation:
        reference = fly_reference(debrief.plan, debrief.card, debrief.width)
    if reference is None:
        if seconds is not None:
            raise ConfigError("--reference-from: this exercise has no reference crew and no end")
        return debrief
    run = RunExplorer(
        debrief.plan, debrief.trajectory, partial(judge_as_changed, debrief), progress
    )
    tick = None if seconds is None else tick_within(debrief, seconds)
    try:
        run.fly_again()
        from_here = None if tick is None else reference_from(debrief, run, tick)
        curve = None if debrief.free else attainable_curve(run)
        why = "a free run has no marks" if debrief.free else ""
        comparison = ReferenceComparison(reference, curve, why, from_here)
    except NoCurve as none:
        if tick is not None:
            raise ConfigError(f"--reference-from {seconds:g}: {none.why}") from None
        comparison = ReferenceComparison(reference, None, none.why)
    return replace(debrief, compared=comparison)


def judge_as_changed(debrief: DebriefData, trajectory: Trajectory) -> Scorecard:
    """Return the marks of a run by the rules as the instructor changed them.

    An outcome that the instructor set is of the recorded run alone.
    """
    rules = tuple(each for each in debrief.changes if each.name != OUTCOME_NAME)
    return changed_card(trajectory, debrief.plan, debrief.nobody, debrief.width, rules)


def reference_from(debrief: DebriefData, run: RunExplorer, tick: int) -> Reference:
    """Return the reference crew's run from a tick on, judged with the past."""
    moment = run.at(tick)
    rehearsal = run.search.fly(moment, run.search.best(moment).way)
    whole = join_runs(debrief.trajectory, rehearsal.trajectory)
    return Reference(rehearsal, judge_as_changed(debrief, whole), tick * debrief.step)


def tick_within(debrief: DebriefData, seconds: float) -> int:
    """Return the tick of a time [s] within the record; ConfigError if it is not."""
    last, tick = int(debrief.trajectory.ticks[-1]), round(seconds / debrief.step)
    if not 0 <= tick < last:
        end = last * debrief.step
        raise ConfigError(
            f"--reference-from {seconds:g}: not within the record, which is of 0 to {end:g} s"
        )
    return tick


def practice_of(plan: Plan, branches: list[Branch], branch: Branch) -> str:
    """Return how a run was wound back. "": it never was, or only to its start."""
    wound = (each for each in _ancestry(branches, branch) if each.tick > 0)
    return next(
        (
            f"{rewind.why}, to {rewind.tick * plan.method.step:g} s"
            for rewind in wound
            if plan.judged_by_tasks and rewind.cause is not BranchCause.GAP
        ),
        "",
    )


def _ancestry(branches: list[Branch], branch: Branch) -> Iterator[Branch]:
    """Yield a branch, then each branch that it begins in."""
    by_number = {each.id: each for each in branches}
    here: Branch | None = branch
    while here is not None:
        yield here
        here = None if here.parent is None else by_number.get(here.parent)


def is_shown(branches: list[Branch], branch: Branch) -> bool:
    """Return whether the way was shown on a branch or its ancestry."""
    return any(each.cause is BranchCause.SHOWN for each in _ancestry(branches, branch))


def crew_branch(recording: Recording, branches: list[Branch]) -> Branch:
    """Return the crew's latest branch that came to the exercise's end, or the latest."""
    told = (each for each in recording.first_events() if each.kind == "time")
    ended = {each.branch for each in told if each.text.startswith(OVER_WORDS)}
    best_first = sorted(branches, key=lambda each: (each.id in ended, each.id), reverse=True)
    return next(each for each in best_first if not is_shown(branches, each))


def nobody_aboard(plan: Plan, header: Mapping[str, str], width: str) -> Mapping[str, float]:
    """Return the marks of each rule with nobody aboard, by its name.

    They are flown at the seed of the record. If another core made the record they are those of the
    baseline that is kept beside the exercise.
    """
    if not plan.judged_by_tasks:
        return {}
    if can_fly(plan) and same_core(header.get("core")):
        return plain_marks(fly_rehearsal(plan.alone()).trajectory, plan, width)
    return plan.baseline.marks if plan.baseline else {}


def last_tick(recording: Recording, branch: Branch) -> int:
    """Return the last tick recorded of a branch."""
    return max((tick for tick, _ in recording.states(branch.id)), default=branch.tick)


def order_givers(trajectory: Trajectory) -> tuple[GiverCount, ...]:
    """Return who gave orders, from the first on; a plan's orders count as one's."""
    by_giver: dict[Giver, list[RecordedOrder]] = defaultdict(list)
    for order in trajectory.orders:
        giver = order.giver
        if giver.kind is GiverKind.PLAN:
            giver = Giver(giver.kind, giver.role, f"{giver.role} at the plan")
        by_giver[giver].append(order)
    return tuple(
        GiverCount(giver, len(orders), sum(each.accepted is False for each in orders))
        for giver, orders in by_giver.items()
    )


def events_of(
    recording: Recording, branches: list[Branch], branch: Branch
) -> Iterator[RecordedEvent]:
    """Return the events of a branch's past, without those that repeat an order."""
    events = within_past(recording.first_events(), branches, branch)
    return (each for each in events if each.kind not in ECHO_EVENTS)


def within_past(
    events: Iterable[RecordedEvent], branches: list[Branch], branch: Branch
) -> Iterator[RecordedEvent]:
    """Yield what is of a branch and of its past, up to each next beginning."""
    ends: dict[int, int | None] = {}
    end: int | None = None
    for here in _ancestry(branches, branch):
        ends[here.id] = end
        end = here.tick
    for event in events:
        if event.branch not in ends:
            continue
        last = ends[event.branch]
        if last is None or event.tick <= last:
            yield event


def ticks_of(trajectory: Trajectory) -> TickCounts:
    """Return how many ticks were timed, with their duty cycle, work and lateness."""
    timed = ~np.isnan(trajectory.work)
    count = int(timed.sum())
    if not count:
        return TickCounts(0, None, None, None)
    work, lateness = trajectory.work[timed], np.maximum(trajectory.lateness[timed], 0.0)
    duty = float(work.sum()) / (count * trajectory.boat.method.step * 1e9)
    return TickCounts(count, duty, _spread(work), _spread(lateness))


def _spread(values: np.ndarray) -> tuple[float, float, float]:
    # not by percentile, which loads masked arrays: a hundredth of a debrief
    slots = np.array([0.5, 0.99]) * (len(values) - 1)
    median, most_of_them = np.interp(slots, np.arange(len(values)), np.sort(values))
    return float(median), float(most_of_them), float(values.max())


# Figures for programs


def debrief_figures(debrief: DebriefData) -> dict[str, Any]:
    """Return the figures of the page for programs; times in s, marks in per cent."""
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
        "trainees": list(debrief.trainees),
        "seed": debrief.plan.seed,
        "width": debrief.width,
        "by_hand": list(debrief.plan.hand),
        "practice": bool(debrief.practice),
        "familiarisation": debrief.familiarisation,
        "aids": list(debrief.aids),
        "shown": debrief.shown,
        "seconds": float(debrief.trajectory.seconds[-1]),
        "total": debrief.total,
        "deviation": deviation_of(debrief),
        "standard_error": standard_error_of(debrief),
        "verdict": debrief.card.verdict and asdict(debrief.card.verdict),
        "cost_most": [{"marks": each.marks, "told": each.told} for each in debrief.costs],
        **_compared(debrief),
        "changes": [asdict(each) | {"branch": int(each.branch)} for each in debrief.changes],
        "changed": debrief.changed and _card(debrief.changed, step),
        "forms": [asdict(each) for each in debrief.forms],
        "compared_marks": [
            asdict(each) | {"mean": each.mean, "spread": each.spread}
            for each in compare_forms(debrief.forms, debrief.final)
        ],
        "scores": [_score(each, step) for each in debrief.card.scores],
        "task_marks": [
            {"name": each.name, "marks": each.marks, "able": list(each.able)}
            | {"hands": [hand._asdict() for hand in each.hands]}
            | {"station": each.own.role if each.own else "", "person": each.person}
            | {"whose": each.whose}
            for each in debrief.task_marks
        ],
        "orders_to_crew": [_read_back(each, step) for each in debrief.read_backs],
        "crew_work": debrief.crew_work and asdict(debrief.crew_work),
        "watches": [_watch(each, step) for each in debrief.watches],
        "alerts": [_alert(each) for each in debrief.trajectory.alerts],
        "casualties": [_casualty(each, step) for each in debrief.casualties],
        "ships": [
            {"name": name, "closest_m": apart, "seconds": tick * step}
            for name, (apart, tick) in meet_ships(debrief.trajectory).closest.items()
        ],
        "marks": [
            {"seconds": each.tick * step, "remark": each.text, "by": each.who}
            for each in debrief.of_kind("mark")
        ],
        "ticks": asdict(debrief.ticks),
        "left_out": [asdict(each) for each in debrief.excess],
    }


def _seconds(tick: int | None, step: float) -> float | None:
    return None if tick is None else tick * step


def _score(each: RuleScore, step: float) -> dict[str, Any]:
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


def _casualty(each: CasualtyAnswer, step: float) -> dict[str, Any]:
    """Return a casualty and the crew's answer to it."""
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


def _alert(each: Alert) -> dict[str, Any]:
    """Return an alert and what became of it."""
    return {
        "number": each.number,
        "rank": each.rank.value,
        "alert": each.words,
        "raised_s": each.raised.seconds,
        "silenced": [{"at": role, "seconds": when.seconds} for role, when in each.silenced],
        "acknowledged_s": each.seen.seconds if each.seen and each.seen_by else None,
        "acknowledged_by": each.seen_by,
        "over_s": each.over and each.over.seconds,
    }


def deviation_of(debrief: DebriefData) -> float | None:
    """Return the standard deviation of a mark by the sea alone [%]. None: none is known."""
    baseline = debrief.plan.baseline
    if baseline is None or baseline.crew is None or baseline.heading.seeds < 2:
        return None
    return baseline.crew.deviation


def standard_error_of(debrief: DebriefData) -> float | None:
    """Return the standard error of a mark from run to run [%], of model people. None: unknown."""
    baseline = debrief.plan.baseline
    return baseline.people.standard_error if baseline and baseline.people else None


def _compared(debrief: DebriefData) -> dict[str, Any]:
    """Return the reference crew's run, and what could still be earned at each moment."""
    comparison, step = debrief.compared, debrief.step
    if comparison is None:
        return {"reference": None, "attainable": None, "reference_from": None}
    return {
        "reference": _reference(comparison.reference, step),
        "attainable": attainable_figures(comparison.curve, step)
        if comparison.curve
        else {"why_none": comparison.no_curve},
        "reference_from": comparison.from_here and _reference(comparison.from_here, step),
    }


def _reference(each: Reference, step: float) -> dict[str, Any]:
    """Return a run of the reference crew: its marks, and its orders."""
    orders = [
        {"seconds": order.tick * step, "order": order.text}
        for order in each.trajectory.orders
        if order.giver == REFERENCE_GIVER
    ]
    return {"from_s": each.since, **_card(each.card, step), "orders": orders}


def _card(card: Scorecard, step: float) -> dict[str, Any]:
    """Return the marks of a run."""
    return {
        "total": card.total,
        "verdict": card.verdict and asdict(card.verdict),
        "scores": [_score(each, step) for each in card.scores],
    }


def _watch(each: Watch, step: float) -> dict[str, Any]:
    """Return a person's time at a station."""
    times = {"begun_s": each.begun * step, "ended_s": _seconds(each.ended, step)}
    return {"role": each.role, "person": each.person, **times, "orders": each.orders}


def _read_back(each: ReadBack, step: float) -> dict[str, Any]:
    """Return an order to the crew with its repeat and its end."""
    return {
        "order": each.told,
        "axis": each.axis,
        "seconds": each.order.tick * step,
        "by": each.order.who,
        "repeated_by": each.repeated and each.repeated.who,
        "repeated_s": each.repeated and each.repeated.tick * step,
        "wrong_repeats": list(each.wrong),
        "carried_out_s": _seconds(each.carried_out, step),
    }
