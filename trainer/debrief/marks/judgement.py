"""Marks of an exercise by hand, and whether it was won, lost or neither.

``data`` and ``reference`` judge runs by ``judge_run``. A task with p marks earns t = 100 max(0, (p
- b) / (100 - b)), where b are its marks with nobody aboard: only what the crew adds to those
counts. An answer to a casualty earns its own t times the mean of the tasks. With T the mean of
tasks and answers, K that of what was kept, and W what the weakest task has of WHOLE_TASK_PERCENT, 1
at most, total = T (0.7 + 0.3 K / 100) (0.6 + 0.4 W). A broken limit leaves 50 to 100 at
most, in proportion, a lost exercise 25, a boat hard aground 0; each hint takes what the exercise
says off before that. From WON_PERCENT on it is won: docs/debrief.md.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.boat.boat import FLAT_WORDS
from trainer.config.exercise.loss_words import word_loss
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.score_rules import ScoreRule
from trainer.debrief.marks import tallies
from trainer.debrief.marks.gates import worst_breach
from trainer.debrief.marks.mark_numbers import (
    HARD_CAP,
    KEEPING_SHARE,
    LOST_CAP,
    MAX_NOBODY_PERCENT,
    WEAKEST_SHARE,
    WHOLE_TASK_PERCENT,
)
from trainer.debrief.marks.measures import hull_depth
from trainer.debrief.marks.scoring import (
    RuleScore,
    Scorecard,
    Verdict,
    score_record,
    score_rules,
)
from trainer.debrief.marks.tallied_record import TalliedRecord, tally_record
from trainer.debrief.passage.episodes import hints_told
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.ships_met import meet_ships
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.recording.facts import GiverKind
from trainer.report.svg import clock
from trainer.session.past.plan import Plan

WON_PERCENT: Final = 60.0  # [%] marks from which an exercise is won
DONE_TASK_PERCENT: Final = 50.0  # [%] marks from which a task is carried out
WIDTH_FACTORS: Final[Mapping[str, float]] = {"qualified": 1.0, "basic": 1.5}
FREEING_ORDERS: Final = frozenset({"allow", "casualty"})  # orders after which there are no marks
MAX_COSTS_TOLD: Final = 3  # sentences
MIN_COST_PERCENT: Final = 0.5  # [%] of the marks that is worth one


def judge_run(
    trajectory: Trajectory, plan: Plan, nobody: Mapping[str, float], width: str = "qualified"
) -> Scorecard:
    """Return the marks of a plan's rules. ``nobody`` has those with nobody aboard, by name [%]."""
    rules = widen_rules(plan.scores, width)
    hint_marks = plan.hint_marks * len(hints_told(trajectory))
    record = tally_record(trajectory, rules, plan)
    card = score_record(record, rules)
    if not plan.judged_by_tasks:
        total = None if card.total is None else max(card.total - hint_marks, 0.0)
        return replace(card, total=total)
    scores = tuple(_less_nobody(each, nobody) for each in card.scores)
    scores = tuple(_answered(each, scores) for each in scores)
    tasks = _mean((each.rule.weight, each.earned) for each in scores) or 0.0
    keeping_marks = _mean(
        (each.rule.weight, each.marks) for each in scores if each.rule.part == "keeping"
    )
    keeping = 100.0 if keeping_marks is None else keeping_marks
    verdict = _verdict(record, plan, scores, (tasks, keeping, hint_marks))
    none = verdict.void or verdict.free
    return Scorecard(scores, None if none else total_of(verdict), verdict)


def plain_marks(trajectory: Trajectory, plan: Plan, width: str = "qualified") -> dict[str, float]:
    """Return the marks of each rule by name [%], with nothing taken off.

    Of a flight with nobody aboard they are the b of each rule.
    """
    scores = score_rules(trajectory, widen_rules(plan.scores, width)).scores
    return {each.name: each.marks or 0.0 for each in scores}


def widen_rules(rules: tuple[ScoreRule, ...], width: str) -> tuple[ScoreRule, ...]:
    """Return the rules at a width. Bands, and the way from full to zero, grow by its factor."""
    factor = WIDTH_FACTORS[width]
    if factor == 1.0:
        return rules
    wider = []
    for rule in rules:
        said = rule.score
        band = None if said.band is None else factor * said.band
        zero = said.full + factor * (said.zero - said.full)
        wider.append(replace(rule, score=replace(said, band=band, zero=zero)))
    return tuple(wider)


def _less_nobody(each: RuleScore, nobody: Mapping[str, float]) -> RuleScore:
    """Return a score with what it earned beyond nobody aboard.

    A task of which nobody aboard gets more than MAX_NOBODY_PERCENT at this seed does not count. A
    task whose time the record does not reach has earned nothing.
    """
    if each.marks is None and each.attained.beyond_record:
        each = replace(each, marks=0.0)
    if each.rule.part == "keeping" or each.marks is None:
        return each
    free = nobody.get(each.name, 0.0)
    if free > MAX_NOBODY_PERCENT:
        return replace(each, nobody=free)
    earned = 100.0 * max(0.0, (each.marks - free) / (100.0 - free))
    return replace(each, nobody=free, earned=earned)


def _answered(each: RuleScore, scores: tuple[RuleScore, ...]) -> RuleScore:
    """Return an answer times the mean of the tasks, because an order alone masters nothing."""
    if each.rule.part != "answer" or each.earned is None:
        return each
    others = _mean((one.rule.weight, one.earned) for one in scores if one.rule.part == "task")
    return each if others is None else replace(each, earned=each.earned * others / 100.0)


def _mean(weighted: Iterable[tuple[float, float | None]]) -> float | None:
    """Return the mean by weight of what counts, 0 without weight. None: nothing counts."""
    counted = [(weight, value) for weight, value in weighted if value is not None]
    whole = sum(weight for weight, _ in counted)
    mean = sum(weight * value for weight, value in counted) / whole if whole else 0.0
    return mean if counted else None


def _verdict(
    record: TalliedRecord,
    plan: Plan,
    scores: tuple[RuleScore, ...],
    parts: tuple[float, float, float],
) -> Verdict:
    """Return the outcome, by the worst thing that happened.

    ``parts`` are the means of the tasks and of what was kept, and what hints cost.
    A free run comes before all, because it has no marks; a loss comes before what was not reached.
    """
    trajectory, turned = record.trajectory, _turned_over(record)
    hard, aground = _aground(trajectory, plan)
    lost = turned or hard or aground or next(_losses(record), "")
    lost = lost or _ended(record) or _collided(trajectory)
    breach = worst_breach(record, plan)
    cap = breach.cap if breach else None
    cap = HARD_CAP if hard else LOST_CAP if lost else cap
    counted = [each for each in scores if each.earned is not None]
    verdict = Verdict(
        outcome=Outcome.WON,
        reason="",
        tasks=parts[0],
        keeping=parts[1],
        hint_marks=parts[2],
        weakest=min(map(whole_share, counted)) if len(counted) > 1 else 1.0,  # else T says it
        gate=breach.text if breach else "",
        gate_cap=breach.cap if breach else None,
        cap=cap,
        void=bool(turned),
        free=False,
    )
    if free := _free(trajectory):
        return replace(verdict, outcome=Outcome.FREE, reason=free, free=True)
    if lost:
        return replace(verdict, outcome=Outcome.LOST, reason=lost)
    total, early = total_of(verdict), _cut_short(trajectory, plan)
    if total >= WON_PERCENT and not early:
        return verdict
    undone = ", ".join(
        each.name for each in counted if (_own_marks(each) or 0.0) < DONE_TASK_PERCENT
    )
    by_gate = verdict.gate if total < before_gate(verdict) else ""
    few = f"{total:.0f} marks, {WON_PERCENT:.0f} win"
    return replace(verdict, outcome=Outcome.NOT_REACHED, reason=by_gate or undone or early or few)


def _free(trajectory: Trajectory) -> str:
    """Return what made the run free of marks: an order ``allow``, or a casualty by hand."""
    for order in trajectory.orders:
        if order.accepted is False or order.giver.kind is GiverKind.SCHEDULE:
            continue
        if order.name in FREEING_ORDERS:
            seconds = order.tick * trajectory.boat.method.step
            return f"{order.text} at {clock(seconds)}, by {order.who}"
    return ""


def whole_share(each: RuleScore) -> float:
    """Return how far a task was carried out, 1 at most. One that does not count passes."""
    if each.earned is None or each.marks is None:
        return 1.0
    return min((_own_marks(each) or 0.0) / WHOLE_TASK_PERCENT, 1.0)


def _turned_over(record: TalliedRecord) -> str:
    """Return that the boat turned over, and when."""
    if not (over := record.caps(tallies.TURNED)):
        return ""
    trajectory = record.trajectory
    row = trajectory.row(int(min(tally["at"] for _, _, tally in over)))
    pitch, heel = (abs(float(trajectory.columns[name][row])) for name in ("theta", "phi"))
    angles = f"pitch {np.degrees(pitch):.0f} deg, heel {np.degrees(heel):.0f} deg"
    told = f"turned over at {clock(float(trajectory.seconds[row]))}: {angles}"
    return told + _flat_words(trajectory, row)


def _flat_words(trajectory: Trajectory, row: int) -> str:
    """Return words for a loss at a row where the battery was flat, else ""."""
    full = float(trajectory.boat.vessel.battery_full)
    return FLAT_WORDS if 0.0 < full <= trajectory.columns["battery_spent"][row] else ""


def _aground(trajectory: Trajectory, plan: Plan) -> tuple[str, str]:
    """Return that the boat was hard aground, and that it was where that ends the exercise."""
    bottom = plan.world.get("bottom")
    hard = aground = ""
    for grounding in groundings(trajectory):
        when = clock(float(trajectory.seconds[grounding.row]))
        if grounding.hard and not hard:
            hard = f"hard aground at {when}, {grounding.touch.normal:.2f} m/s into the ground"
        if grounding.at_fault and not aground and bottom is not None and bottom.grounding == "end":
            aground = f"aground at {when}"
    return hard, aground


def _losses(record: TalliedRecord) -> Iterator[str]:
    """Yield the conditions that lost the exercise, and when."""
    for loss, row, tally in record.caps(tallies.LOSS):
        told = f"{word_loss(loss.text)} at {clock(tally['at'] * row['step'])}"
        yield told + _flat_words(record.trajectory, record.trajectory.row(int(tally["at"])))


def _ended(record: TalliedRecord) -> str:
    """Return that the hull has collapsed."""
    trajectory = record.trajectory
    for _, _, tally in record.caps(tallies.COLLAPSED):
        flat = _flat_words(trajectory, trajectory.row(int(tally["at"])))
        return f"the hull collapsed at {hull_depth(trajectory).max():.0f} m{flat}"
    return ""


def _collided(trajectory: Trajectory) -> str:
    """Return that a collision has ended the exercise."""
    met = meet_ships(trajectory)
    if met.collision != "end" or not met.collisions:
        return ""
    tick, name = met.collisions[0]
    return f"collision with {name} at {clock(tick * trajectory.boat.method.step)}"


def _cut_short(trajectory: Trajectory, plan: Plan) -> str:
    """Return that the record ends before the exercise does."""
    end = float(trajectory.seconds[-1])
    if plan.duration is None or end >= plan.duration - plan.method.step - 1e-6:
        return ""
    return f"the record ends at {clock(end)}"


# What cost marks


@dataclass(frozen=True)
class MarkCost:
    """A cause that cost some of the marks."""

    marks: float  # [%] of the total
    told: str
    tick: int | None = None  # where in the record


def marks_given(each: RuleScore) -> float | None:
    """Return the marks [%] of a score; of a task those beyond nobody aboard."""
    return each.marks if each.earned is None else each.earned


def _own_marks(each: RuleScore) -> float | None:
    """Return the marks [%] by which a rule itself is to blame.

    What an answer lost because tasks failed is blamed on the tasks: the answer came in time.
    """
    return each.marks if each.rule.part == "answer" else marks_given(each)


def dearest_costs(card: Scorecard, reference: Scorecard | None) -> tuple[MarkCost, ...]:
    """Return the dearest causes, MAX_COSTS_TOLD at most."""
    dear_costs = [each for each in costs(card, reference) if each.marks >= MIN_COST_PERCENT]
    return tuple(sorted(dear_costs, key=lambda each: -each.marks)[:MAX_COSTS_TOLD])


def costs(card: Scorecard, reference: Scorecard | None) -> Iterator[MarkCost]:
    """Yield all causes that cost marks: rules by share in the total, and the gate."""
    best = {each.name: each for each in reference.scores} if reference else {}
    yield from _by_gate(card)
    yield from _by_weakest(card)
    yield from _by_hints(card)
    for rule_score in card.scores:
        lost = 100.0 - (_own_marks(rule_score) or 0.0)
        share = share_of(rule_score, card)
        if rule_score.marks is not None and share and lost > 0.0:
            sentence = _sentence(rule_score, best.get(rule_score.name), share * lost)
            yield MarkCost(share * lost, sentence, rule_score.attained.tick)


def _by_weakest(card: Scorecard) -> Iterator[MarkCost]:
    """Yield what the weakest task took of all marks, because it fell short of being done."""
    verdict = card.verdict
    if verdict is None or verdict.weakest == 1.0:
        return
    weakest = min(card.scores, key=whole_share)
    cost = verdict.tasks * _kept_factor(verdict) * (1.0 - _weakest_factor(verdict))
    came = weakest.attained.value is not None
    fault = f"it fell short of {WHOLE_TASK_PERCENT:.0f}" if came else "it was not carried out"
    sentence = f"{weakest.name}: {fault}, beside its own marks: {_marks(cost)}."
    yield MarkCost(cost, sentence, weakest.attained.tick)


def _by_hints(card: Scorecard) -> Iterator[MarkCost]:
    """Yield what hints took off."""
    if card.verdict is not None and not card.verdict.free:
        cost = before_hints(card.verdict) - before_gate(card.verdict)
        yield MarkCost(cost, f"Hints: {_marks(cost)}.")


def _by_gate(card: Scorecard) -> Iterator[MarkCost]:
    """Yield the marks that a broken limit or a loss took beyond the tasks."""
    verdict = card.verdict
    if verdict is None:
        return
    whole = before_gate(verdict)
    if verdict.free:
        return
    if verdict.void:
        yield MarkCost(whole, f"The boat turned over: {verdict.reason}. All marks are void.")
    elif verdict.cap is not None and whole > verdict.cap:
        why = f"The exercise was lost ({verdict.reason})"
        if verdict.outcome is not Outcome.LOST:
            why = f"A limit was broken ({verdict.gate})"
        cost = whole - verdict.cap
        yield MarkCost(cost, f"{why}: {_marks(cost)}, since at most {verdict.cap:.0f} are left.")


def before_gate(verdict: Verdict) -> float:
    """Return the total [%] that tasks, keeping and hints make, before any gate."""
    return max(before_hints(verdict) - verdict.hint_marks, 0.0)


def before_hints(verdict: Verdict) -> float:
    """Return the total [%] that tasks and keeping make by themselves."""
    return verdict.tasks * _kept_factor(verdict) * _weakest_factor(verdict)


def total_of(verdict: Verdict) -> float:
    """Return the total [%] that a verdict leaves."""
    whole = before_gate(verdict)
    return whole if verdict.cap is None else min(whole, verdict.cap)


def _kept_factor(verdict: Verdict) -> float:
    return 1.0 - KEEPING_SHARE + KEEPING_SHARE * verdict.keeping / 100.0


def _weakest_factor(verdict: Verdict) -> float:
    return 1.0 - WEAKEST_SHARE + WEAKEST_SHARE * verdict.weakest


def share_of(each: RuleScore, card: Scorecard) -> float:
    """Return how much of a rule's marks are of the total [-]."""
    verdict = card.verdict
    keeping = verdict is not None and each.rule.part == "keeping"
    alike = [
        other
        for other in card.scores
        if other.marks is not None
        and (verdict is None or (other.earned is None) == (each.earned is None))
    ]
    weight = sum(other.rule.weight for other in alike)
    share = each.rule.weight / weight if weight else 0.0
    if verdict is None:
        return share
    if keeping:
        return share * KEEPING_SHARE * verdict.tasks / 100.0
    if each.earned is None:  # nobody aboard has it as well: it earns nothing
        return 0.0
    return share * _kept_factor(verdict)


def _sentence(each: RuleScore, best: RuleScore | None, cost: float) -> str:
    """Return what a rule cost, and what would have been right."""
    unit = "" if each.unit == "-" else f" {each.unit}"
    value = each.attained.value
    came = each.attained.why if value is None else f"{value:.4g}{unit}"
    words = f"{each.name}: {came}, full marks at {each.rule.score.full:.4g}{unit}"
    if best is not None and best.attained.value is not None:
        words += f", the reference crew {best.attained.value:.4g}{unit}"
    return f"{words}: {_marks(cost)}."


def _marks(cost: float) -> str:
    whole = round(cost)
    if not whole:
        return "it cost less than a mark"
    return f"it cost {whole} mark{'s' if whole > 1 else ''}"


def dearest_rule(before: Scorecard, after: Scorecard) -> str:
    """Return the score that lost most between two runs, "" without scores."""
    earned = [
        {each.name: share_of(each, card) * (marks_given(each) or 0.0) for each in card.scores}
        for card in (before, after)
    ]
    lost = {name: marks - earned[1].get(name, 0.0) for name, marks in earned[0].items()}
    return max(lost, key=lambda name: lost[name], default="")
