"""The reference crew's run beside a recorded one, of the same exercise and seed.

A task has a band about the reference run. At each moment it holds the values of the task's quantity
in the reference run, as much earlier, later and further off as the task allows.
A run leaves the band for good where it stays outside for LASTING_TIME_S,
or to the end of the task's time: docs/debrief.md, "Where it went wrong".
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.config.condition import ANGLE_UNITS
from trainer.config.score_rules import COURSE_QUANTITY, ScoreRule
from trainer.core.kernel import Numbers
from trainer.debrief.episodes import INSTRUCTOR_ROLE, KEPT_TOLERANCES, crew_orders, first_spell
from trainer.debrief.judgement import judge_run, marks_given, share_of, widen_rules
from trainer.debrief.rehearsal import Departure, Rehearsal, fly_rehearsal, last_tick
from trainer.debrief.scoring import RuleScore, Scorecard, looked_at
from trainer.debrief.trajectory import RowMask, Trajectory, row_stretches
from trainer.io.recording.facts import Giver, GiverKind
from trainer.session.plan import Plan

MAX_REFERENCE_TICKS: Final = 400_000  # [ticks] flown while somebody waits for a debrief
LASTING_TIME_S: Final = 20.0  # [s] outside the band, from which a run has left it for good
TIME_LEEWAY_S: Final = 10.0  # [s] earlier or later at least
DEAR_FAULT_SHARE: Final = 0.33  # [-] of the dearest fault, from which an earlier one is told
TIME_MEASURES: Final = ("reach", "time-to")  # measures whose value is a time
EXTREME_MEASURES: Final = (
    "highest",
    "lowest",
    "largest",
    "overshoot",
)  # over when they are attained
REFERENCE_BAND_WORDS: Final = "the band about the reference run was"
INSTRUCTOR_GIVER: Final = Giver(GiverKind.STATION, INSTRUCTOR_ROLE, INSTRUCTOR_ROLE)
LOST_TASK_PERCENT: Final = (
    10.0  # [%] of a task's marks less than the reference crew's: it went wrong
)


@dataclass(frozen=True)
class Reference:
    """A run of the reference crew, and its marks."""

    rehearsal: Rehearsal
    card: Scorecard
    since: float | None = None  # [s] from which it was flown; None: from the start

    @property
    def trajectory(self) -> Trajectory:
        """Return the passage of the run."""
        return self.rehearsal.trajectory


@dataclass(frozen=True)
class Fault:
    """The moment at which a run went wrong, by one task."""

    tick: int
    score: str  # the task's name
    quantity: str  # "" for an answer that did not come in time
    told: str


def can_fly(plan: Plan) -> bool:
    """Return whether a plan ends within MAX_REFERENCE_TICKS, because somebody waits."""
    return plan.duration is not None and last_tick(plan) <= MAX_REFERENCE_TICKS


def fly_reference(plan: Plan, card: Scorecard, width: str) -> Reference | None:
    """Return the run of the exercise's reference crew at the plan's seed. None: no crew."""
    if not plan.crew.rules or not can_fly(plan):
        return None
    rehearsal = fly_rehearsal(plan.alone(), plan.crew)
    return Reference(rehearsal, judge_run(rehearsal.trajectory, plan, nobody_of(card), width))


def fly_from(
    trajectory: Trajectory, plan: Plan, departure: Departure, card: Scorecard, width: str
) -> Reference:
    """Return the reference crew's run from a recorded moment, judged with its past."""
    rehearsal = fly_rehearsal(plan.alone(), plan.crew, since=departure)
    whole = join_runs(trajectory, rehearsal.trajectory)
    seconds = departure.moment.tick * plan.method.step
    return Reference(rehearsal, judge_run(whole, plan, nobody_of(card), width), seconds)


def nobody_of(card: Scorecard) -> dict[str, float]:
    """Return the marks with nobody aboard, as taken off, by the scores' names."""
    return {each.name: each.nobody or 0.0 for each in card.scores}


def join_runs(before: Trajectory, after: Trajectory) -> Trajectory:
    """Return a run up to where another begins, and that other."""
    rows = before.ticks < after.ticks[0]
    by_instructor = all(each.giver.role == INSTRUCTOR_ROLE for each in crew_orders(before))
    orders = [each for each in before.orders if each.tick < after.ticks[0]]
    alone = bool(orders) and by_instructor  # then the instructor is the crew
    taken = tuple(
        replace(item, giver=INSTRUCTOR_GIVER) if alone and item.place is None else item
        for item in after.orders
    )
    return replace(
        after,
        orders=(*orders, *taken),
        marks=(*(each for each in before.marks if each.tick < after.ticks[0]), *after.marks),
        ticks=np.concatenate((before.ticks[rows], after.ticks)),
        columns={
            name: np.concatenate((before.columns[name][rows], values))
            for name, values in after.columns.items()
        },
        lateness=np.concatenate((before.lateness[rows], after.lateness)),
        work=np.concatenate((before.work[rows], after.work)),
    )


# Where it went wrong


def first_fault(
    trajectory: Trajectory, card: Scorecard, reference: Reference, plan: Plan, width: str
) -> Fault | None:
    """Return the first moment at which a dear task went wrong, None if none did.

    A task is dear if it cost DEAR_FAULT_SHARE of what the dearest one cost: an early trifle would
    else be named in place of the fault that mattered.
    """
    rules = widen_rules(plan.scores, width)
    faults = list(_faults(trajectory, rules, card, reference))
    lost = {
        score.name: share_of(score, card) * (100.0 - (marks_given(score) or 0.0))
        for score in card.scores
    }
    dearest = max((lost[fault.score] for fault in faults), default=0.0)
    dear = (fault for fault in faults if lost[fault.score] >= DEAR_FAULT_SHARE * dearest)
    return min(dear, key=lambda fault: fault.tick, default=None)


def tasks_behind(card: Scorecard, reference: Scorecard) -> tuple[str, ...]:
    """Return the tasks and answers that are worth much less than the reference crew's."""
    best = {each.name: marks_given(each) or 0.0 for each in reference.scores}
    return tuple(
        score.name
        for score in card.scores
        if score.rule.part != "keeping" and score.marks is not None
        if best.get(score.name, 0.0) - (marks_given(score) or 0.0) >= LOST_TASK_PERCENT
    )


def _faults(
    trajectory: Trajectory, rules: tuple[ScoreRule, ...], card: Scorecard, reference: Reference
) -> Iterator[Fault]:
    own_scores = {each.name: each for each in card.scores}
    worse = tasks_behind(card, reference.card)
    ours = {each.name: each for each in reference.card.scores}
    for rule in rules:
        if rule.score.name not in worse:
            continue
        mine, best = own_scores[rule.score.name], ours[rule.score.name]
        fault = (
            _late_answer(trajectory, rule, mine, best)
            if rule.score.measure == "response"
            else _departure(trajectory, rule, (mine, best), reference.trajectory)
        )
        if fault is not None:
            yield fault


def _late_answer(
    trajectory: Trajectory, rule: ScoreRule, mine: RuleScore, best: RuleScore
) -> Fault | None:
    """Return the moment until which an answer earns full marks, if it came later or never."""
    episode = first_spell(trajectory, rule.casualty)
    allowed = max(rule.score.full, best.attained.value or 0.0)
    value = mine.attained.value
    if episode is None or (value is not None and value <= allowed):
        return None
    step = trajectory.boat.method.step
    tick = min(episode.begun + round(allowed / step), int(trajectory.ticks[-1]))
    came = "none came" if value is None else f"it came after {value:g} s"
    sentence = f"an answer to {episode.kind} was due within {allowed:g} s; {came}"
    return Fault(tick, rule.score.name, "", sentence)


def _departure(
    trajectory: Trajectory,
    rule: ScoreRule,
    both: tuple[RuleScore, RuleScore],
    reference: Trajectory,
) -> Fault | None:
    """Return where the quantity of a task leaves the band about the reference run for good."""
    mine, best = both
    if rule.measured is None or not trajectory.has(rule.measured.name):
        return None
    rows = looked_at(trajectory, rule)
    if rows is None:
        return None
    if rule.score.measure in EXTREME_MEASURES and mine.attained.tick is not None:
        rows &= trajectory.ticks <= mine.attained.tick
    if not rows.any():
        return None
    low, high = limits_about(reference, trajectory, rule, best)
    value = trajectory.measured(rule.measured)
    outside = rows & ~_within(value, low, high, rule) & ~_better(value, low, high, rule)
    last, seconds = int(np.flatnonzero(rows)[-1]), trajectory.seconds
    row = next(
        (
            first
            for first, after in row_stretches(outside)
            if after > last or seconds[after - 1] - seconds[first] >= LASTING_TIME_S
        ),
        None,
    )
    if row is None:
        return None
    sentence = _told(rule, float(value[row]), (float(low[row]), float(high[row])))
    return Fault(int(trajectory.ticks[row]), rule.score.name, rule.measured.name, sentence)


def band_of(rule: ScoreRule, best: RuleScore) -> tuple[float, float]:
    """Return how early or late [s], and how far off, a task allows.

    How far off is the task's band in the quantity's unit. To either allowance comes what full marks
    leave beyond the reference crew's value: in time, or of an extreme.
    """
    score, measured = rule.score, rule.measured
    assert measured  # noqa: S101 (asked for by who calls)
    allowed = 0.0 if best.attained.value is None else abs(score.full - best.attained.value)
    usual = KEPT_TOLERANCES.get(measured.name)
    usual = 0.25 * abs(score.zero - score.full) if usual is None else usual / measured.size
    off = usual if score.band is None else score.band
    if score.measure in TIME_MEASURES:
        return max(allowed, TIME_LEEWAY_S), off
    return TIME_LEEWAY_S, off + (allowed if score.measure in EXTREME_MEASURES else 0.0)


def limits_about(
    reference: Trajectory, trajectory: Trajectory, rule: ScoreRule, best: RuleScore
) -> tuple[Numbers, Numbers]:
    """Return the least and the greatest value within the band, at each tick."""
    assert rule.measured  # noqa: S101
    values, (early, off) = reference.measured(rule.measured), band_of(rule, best)
    most = min(round(early / reference.boat.method.step), values.size)
    rows = np.minimum(np.searchsorted(reference.ticks, trajectory.ticks), values.size - 1)
    low, high = (window_extremes(values, most, choose)[rows] for choose in (np.minimum, np.maximum))
    return low - off, high + off


def window_extremes(values: Numbers, most: int, choose: Callable[..., Numbers]) -> Numbers:
    """Return the least or greatest value of the rows up to ``most`` around each."""
    windows = np.pad(values, most, mode="edge")
    width, span = 2 * most + 1, 1
    while 2 * span <= width:  # windows: the extreme of ``span`` rows from each one on
        windows = choose(windows[:-span], windows[span:])
        span *= 2
    rest = width - span
    return choose(windows[: values.size], windows[rest : rest + values.size])


def _within(value: Numbers, low: Numbers, high: Numbers, rule: ScoreRule) -> RowMask:
    """Return where a value is within limits; a course may be whole turns away."""
    assert rule.measured  # noqa: S101
    round_about = math.tau / rule.measured.size
    turns = (-round_about, 0.0, round_about) if rule.measured.name == COURSE_QUANTITY else (0.0,)
    inside = [(low <= value + turn) & (value + turn <= high) for turn in turns]
    within: RowMask = np.any(inside, axis=0)
    return within


def _better(value: Numbers, low: Numbers, high: Numbers, rule: ScoreRule) -> RowMask:
    """Return where a value is nearer to the target than the band about the reference.

    A crew that does better than the reference crew has left the band, and did nothing wrong.
    """
    assert rule.measured  # noqa: S101
    score = rule.score
    if score.target is not None and rule.measured.name != COURSE_QUANTITY:
        edge = np.clip(score.target, low, high)
        nearer: RowMask = np.abs(value - score.target) < np.abs(edge - score.target)
        return nearer
    if score.measure in ("highest", "lowest") and score.target is None:
        return value < low if score.full < score.zero else value > high
    return np.zeros(value.size, bool)


def _told(rule: ScoreRule, value: float, limits: tuple[float, float]) -> str:
    """Return a departure in words."""
    assert rule.measured  # noqa: S101
    name, unit = rule.measured.name, rule.measured.unit
    if name == COURSE_QUANTITY:
        words = (
            round(angle * rule.measured.size / ANGLE_UNITS["deg"]) % 360
            for angle in (value, *limits)
        )
        return "course {:03d}; {} {:03d} to {:03d}".format(
            next(words), REFERENCE_BAND_WORDS, *words
        )
    low, high = limits
    return (
        f"{rule.measured} {value:.2f} {unit}; {REFERENCE_BAND_WORDS} {low:.2f} to {high:.2f} {unit}"
    )
