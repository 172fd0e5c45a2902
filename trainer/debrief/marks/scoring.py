"""Scoring: the rules of an exercise applied to a passage, each with its marks.

A passage is what was flown to the end of a branch of a recording (``trajectory``). The value of a
rule (``tallied_record``) becomes marks in proportion between the rule's ``full`` and ``zero``.
``judgement`` makes an exercise's total of them.
"""

from dataclasses import dataclass
from typing import Final

from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.score_rules import (
    OWN_UNIT,
    SCORE_MEASURES,
    ScoreRule,
)
from trainer.debrief.marks.measures import Measurement
from trainer.debrief.marks.tallied_record import TalliedRecord, tally_record
from trainer.debrief.passage.trajectory import Trajectory

DEFAULT_SUBJECTS: Final = {
    "activity": "stern and bow planes",
    "reserve-air": "all banks",
}  # no quantity named


def formula_of(rule: ScoreRule) -> str:
    """Return how the value of a rule is found, in words."""
    score, measure = rule.score, SCORE_MEASURES[rule.score.measure]
    unit = rule.measured.unit if rule.measured else ""
    words = {
        "q": str(rule.measured or DEFAULT_SUBJECTS.get(score.measure, "")),
        "t": "what is ordered" if score.target is None else f"{score.target:g} {unit}",
        "b": f"{score.band:g} {unit}" if score.band is not None else "",
        "by": f" by {score.band:g} {unit}" if score.band is not None else "",
        "f": "" if score.target is None else f", its distance from {score.target:g} {unit}",
        "c": score.casualty or "",
        "k": f" of rank {score.rank}" if score.rank else "",
        "o": f" of {', '.join(score.orders)}" if score.orders else "",
    }
    return measure.formula.format(**words) + _window(rule)


def _window(rule: ScoreRule) -> str:
    """Return in words the time that a rule looks at, '' for all of it."""
    score = rule.score
    parts = [
        "" if score.from_s is None else f"from {score.from_s:g} s",
        "" if score.to_s is None else f"to {score.to_s:g} s",
        f"after {score.since}" if score.since and (score.from_s or score.to_s) else "",
        f"from {score.since} on" if score.since and not (score.from_s or score.to_s) else "",
        f"while {score.when}" if score.when else "",
    ]
    words = " ".join(filter(None, parts))
    return words and f", {words}"


def unit_of(rule: ScoreRule) -> str:
    """Return the unit of a rule's value."""
    unit = SCORE_MEASURES[rule.score.measure].unit
    return unit if unit != OWN_UNIT or rule.measured is None else rule.measured.unit


@dataclass(frozen=True)
class RuleScore:
    """A rule with its measured value and its marks."""

    rule: ScoreRule
    attained: Measurement
    unit: str
    formula: str
    marks: float | None  # [%] None: it does not count
    nobody: float | None = None  # [%] marks with nobody aboard, where they are taken off
    earned: float | None = None  # [%] what is left of the marks, of a task or an answer

    @property
    def name(self) -> str:
        """Return the name of the rule."""
        return self.rule.score.name

    @property
    def idle(self) -> bool:
        """Return whether it does not count: a boat with nobody aboard has it too."""
        return self.nobody is not None and self.earned is None

    @property
    def told(self) -> str:
        """Return its marks in words."""
        if self.idle:
            return f"{self.name}: does not count, a boat with nobody aboard has it as well"
        return f"{self.name}: {self.marks or 0.0:.0f}"


@dataclass(frozen=True)
class Verdict:
    """The outcome of an exercise, its reason, and the parts of the total."""

    outcome: Outcome
    reason: str  # "" where it was won
    tasks: float  # [%] mean of tasks and answers, T of ``judgement``
    keeping: float  # [%] mean of how the boat was kept, K
    weakest: float  # [-] W: marks of the weakest task over those of a whole one, 1 at most
    gate: str  # the limit that was broken, "" if none was
    gate_cap: float | None  # [%] most that it leaves
    cap: float | None  # [%] most that is left by gate or loss
    void: bool  # the boat turned over: there are no marks
    free: bool  # the instructor let something be automatic, or broke it by hand: no marks either
    hint_marks: float = 0.0  # [%] that hints cost


@dataclass(frozen=True)
class Scorecard:
    """All rules of an exercise, and the marks of what counts; None if nothing does."""

    scores: tuple[RuleScore, ...]
    total: float | None  # [%]
    verdict: Verdict | None = None  # of an exercise whose marks are those of tasks


def score_rules(trajectory: Trajectory, rules: tuple[ScoreRule, ...]) -> Scorecard:
    """Return the score of each rule, and the mean of all by weight."""
    return score_record(tally_record(trajectory, rules), rules)


def score_record(record: TalliedRecord, rules: tuple[ScoreRule, ...]) -> Scorecard:
    """Return the same of a record that was tallied by these rules."""
    scores = []
    for rule in rules:
        attained = record.measurement(rule)
        marks = marks_of(rule, attained.value) if attained.counts else None
        scores.append(RuleScore(rule, attained, unit_of(rule), formula_of(rule), marks))
    counted = [each for each in scores if each.marks is not None]
    weight = sum(each.rule.weight for each in counted)
    earned = sum(each.rule.weight * (each.marks or 0.0) for each in counted)
    return Scorecard(tuple(scores), earned / weight if weight else None)


def marks_of(rule: ScoreRule, value: float | None) -> float:
    """Return the marks [%] of a value, in proportion between full and zero. No value, no marks."""
    if value is None:
        return 0.0
    share = (value - rule.score.zero) / (rule.score.full - rule.score.zero)
    return 100.0 * min(max(share, 0.0), 1.0)
