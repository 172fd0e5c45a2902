"""Ladders of lateness: an exercise flown by its reference crew, each time five seconds later.

A crew is late in one of two ways: it takes so much longer over each step, or it begins late and
then works as it should. ``validation`` tells what five seconds cost, and whether later is worse.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import pairwise
from typing import Final, NamedTuple

from trainer.authoring.trainees import Skill, Trainee
from trainer.boat.reference_crew import CrewReaction
from trainer.config.boat.casualties import HOLE_MEASURE, SEVERITY_MEASURES
from trainer.core.casualties import CASUALTY_TABLE
from trainer.debrief.marks.judgement import before_gate, marks_given
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.marks.scoring import RuleScore, Scorecard
from trainer.session.past.plan import Plan

LATENESS_S: Final = tuple(range(0, 85, 5))  # [s] of the rungs of a ladder
LATE_KINDS: Final[Mapping[str, Skill]] = {
    "each step late": Skill("each step late"),
    "late to begin": Skill("late to begin", prompt_steps=True),
}
STEEP_FALL: Final = 15.0  # [%] of the marks from one rung to the next, which is told
CLEAR_RISE: Final = 3.0  # [%] of the marks that a later crew may have more by chance
RANKED_PERCENT: Final = 25.0  # [%] the most of a lost run: below it no order is asked for
URGENT_LATE_S: Final = 40  # [s] with which a hole or a jam is not mastered
MAX_URGENT_MARKS: Final = 60.0  # [%] that are left then
URGENT_KINDS: Final = frozenset(  # holes and jams
    kind.name
    for kind in CASUALTY_TABLE
    if SEVERITY_MEASURES[kind.name] is HOLE_MEASURE or kind.turned
)


class Ladder(NamedTuple):
    """The marks [%] of crews that are late in one way.

    ``falls`` and ``rises`` tell where a later crew has far fewer, or more.
    """

    kind: str
    marks: tuple[float, ...]  # for each of LATENESS_S
    falls: tuple[str, ...]  # each in words
    rises: tuple[str, ...]

    def at(self, seconds: float) -> float:
        """Return the marks [%] of a crew so late [s]."""
        return self.marks[LATENESS_S.index(round(seconds))]


def is_urgent(plan: Plan) -> bool:
    """Return whether an exercise opens a hole or jams a surface."""
    orders = (each.order for each in plan.schedule)
    subjects = {each.subject for each in orders if each.name == "casualty"}
    subjects |= {each.casualty.name for each in plan.armed}
    broken = (each for name in subjects for each in plan.casualties[name].broken)
    return any(each.kind in URGENT_KINDS for each in broken)


def fly_ladders(plan: Plan, judge: Callable[[Rehearsal], Scorecard]) -> tuple[Ladder, ...]:
    """Return both ladders of an exercise at the seed of its plan."""
    return tuple(_fly_ladder(plan, judge, skill) for skill in LATE_KINDS.values())


def _fly_ladder(plan: Plan, judge: Callable[[Rehearsal], Scorecard], skill: Skill) -> Ladder:
    come_aboard = partial(Trainee, skill)
    cards = [
        judge(fly_rehearsal(plan, plan.crew, CrewReaction(float(late)), come_aboard))
        for late in LATENESS_S
    ]
    rungs = list(zip(LATENESS_S, cards, strict=True))
    return Ladder(
        skill.name,
        tuple(_total(card) for card in cards),
        tuple(_falls(skill.name, rungs)),
        tuple(_rises(skill.name, rungs)),
    )


def _total(card: Scorecard) -> float:
    return card.total or 0.0


def _falls(kind: str, rungs: list[tuple[int, Scorecard]]) -> Iterator[str]:
    """Yield in words where the next rung has far fewer marks, and what did it."""
    for (late, card), (_, next_card) in pairwise(rungs):
        if _total(card) - _total(next_card) > STEEP_FALL:
            yield f"{_step(kind, late, card, next_card)}: {_cause(card, next_card)}"


def _rises(kind: str, rungs: list[tuple[int, Scorecard]]) -> Iterator[str]:
    """Yield in words where a later crew has more marks than one that did not lose."""
    for (late, card), (_, next_card) in pairwise(rungs):
        more = _total(next_card) - max(_total(card), RANKED_PERCENT)
        if more > CLEAR_RISE:
            yield _step(kind, late, card, next_card)


def _step(kind: str, late: int, card: Scorecard, next_card: Scorecard) -> str:
    marks = f"{_total(card):.0f}, then {_total(next_card):.0f} marks"
    return f"{kind}, {late} and {late + LATENESS_S[1]} s: {marks}"


def _cause(card: Scorecard, next_card: Scorecard) -> str:
    """Return the limit that was broken, or the measure that lost most of the total."""
    verdict = next_card.verdict
    if verdict is not None and _total(next_card) < before_gate(verdict):
        return verdict.reason or verdict.gate
    pairs = zip(card.scores, next_card.scores, strict=True)
    before, after = max(pairs, key=lambda pair: _weighed(pair[0]) - _weighed(pair[1]))
    values = [_value_of(each) for each in (before, after)]
    return f"{before.name} {', then '.join(values)}"


def _weighed(each: RuleScore) -> float:
    return each.rule.weight * (marks_given(each) or 0.0)


def _value_of(each: RuleScore) -> str:
    value = each.attained.value
    return each.attained.why if value is None else f"{value:.3g} {each.unit}".rstrip(" -")
