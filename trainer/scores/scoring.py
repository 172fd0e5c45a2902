"""Scoring: the rules of an exercise laid to a passage, each with its marks."""

from dataclasses import dataclass

import numpy as np

from trainer.scores.measure_table import MEASURES, formula_of, unit_of
from trainer.scores.measures import Attained
from trainer.scores.passage import Passage, lacks
from trainer.scores.score_rule import Rule


@dataclass(frozen=True)
class Scored:
    """How a rule was met."""

    rule: Rule
    attained: Attained
    unit: str
    formula: str
    marks: float | None  # [%] None: it does not count

    @property
    def name(self) -> str:
        """Return what is judged."""
        return self.rule.score.name


@dataclass(frozen=True)
class Scorecard:
    """All rules of an exercise, and the marks of what counts; None if nothing does."""

    scores: tuple[Scored, ...]
    total: float | None  # [%]


def score(passage: Passage, rules: tuple[Rule, ...]) -> Scorecard:
    """Return how each rule was met, and the marks of all, each by its weight."""
    scores = tuple(_scored(passage, rule) for rule in rules)
    counted = [each for each in scores if each.marks is not None]
    weight = sum(each.rule.weight for each in counted)
    earned = sum(each.rule.weight * (each.marks or 0.0) for each in counted)
    return Scorecard(scores, earned / weight if weight else None)


def _scored(passage: Passage, rule: Rule) -> Scored:
    attained = attain(passage, rule)
    marks = marks_of(rule, attained.value) if attained.counts else None
    return Scored(rule, attained, unit_of(rule), formula_of(rule), marks)


def attain(passage: Passage, rule: Rule) -> Attained:
    """Return what the measure of a rule has come to in a passage."""
    if lacking := lacks(passage.boat, rule):
        return Attained(None, None, f"this boat has no {lacking[0]}", counts=False)
    rows = passage.between(rule.score.from_s, rule.score.to_s)
    if not np.any(rows):
        told = f"the record ends at {passage.seconds[-1]:g} s"
        return Attained(None, None, told, counts=False)
    if rule.condition:
        rows &= passage.holds(rule.condition)
    if not np.any(rows):
        return Attained(None, None, f"never {rule.condition and rule.condition.text}")
    return MEASURES[rule.score.measure].take(passage, rows, rule)


def marks_of(rule: Rule, value: float | None) -> float:
    """Return the marks [%] of a value: in proportion between full and none; no value, none."""
    if value is None:
        return 0.0
    share = (value - rule.score.zero) / (rule.score.full - rule.score.zero)
    return 100.0 * min(max(share, 0.0), 1.0)
