"""What cost marks, each in a plain sentence, the dearest first."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from trainer.analysis.debrief.judgement import KEPT_SHARE
from trainer.analysis.debrief.reference import worth
from trainer.analysis.debrief.scoring import Scorecard, Scored, Verdict

MOST: Final = 3  # sentences
LEAST: Final = 0.5  # [%] of the marks that is worth one
PERCENT: Final = 100.0


@dataclass(frozen=True)
class Loss:
    """What cost some of the marks."""

    marks: float  # [%] of the total
    told: str


def dearest(card: Scorecard, reference: Scorecard | None) -> tuple[Loss, ...]:
    """Return what cost most, MOST of it at most."""
    found = [each for each in losses(card, reference) if each.marks >= LEAST]
    return tuple(sorted(found, key=lambda each: -each.marks)[:MOST])


def losses(card: Scorecard, reference: Scorecard | None) -> Iterator[Loss]:
    """Yield all that cost marks: rules by their share in the total, and the gate."""
    best = {each.name: each for each in reference.scores} if reference else {}
    yield from _by_gate(card)
    for each in card.scores:
        lost = PERCENT - (worth(each) or 0.0)
        share = _share(each, card)
        if each.marks is not None and share and lost > 0.0:
            told = _sentence(each, best.get(each.name), share * lost)
            yield Loss(share * lost, told)


def _by_gate(card: Scorecard) -> Iterator[Loss]:
    """Yield what a broken limit or a loss has cost beyond the tasks."""
    verdict = card.verdict
    if verdict is None:
        return
    whole = before_gate(verdict)
    if verdict.free:
        return
    if verdict.void:
        yield Loss(whole, f"The boat turned over: {verdict.reason}. All marks are void.")
    elif verdict.cap is not None and whole > verdict.cap:
        why = f"The exercise was lost ({verdict.reason})"
        if verdict.outcome != "lost":
            why = f"A limit was broken ({verdict.gate})"
        cost = whole - verdict.cap
        yield Loss(cost, f"{why}: {_marks(cost)}, since at most {verdict.cap:.0f} are left.")


def before_gate(verdict: Verdict) -> float:
    """Return the total [%] that tasks and keeping make, before any gate."""
    return verdict.tasks * (1.0 - KEPT_SHARE + KEPT_SHARE * verdict.keeping / PERCENT)


def _share(each: Scored, card: Scorecard) -> float:
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
        return share * KEPT_SHARE * verdict.tasks / PERCENT
    if each.earned is None:  # nobody aboard has it as well: it earns nothing
        return 0.0
    return share * (1.0 - KEPT_SHARE + KEPT_SHARE * verdict.keeping / PERCENT)


def _sentence(each: Scored, best: Scored | None, cost: float) -> str:
    """Return what a rule cost, and what would have been right."""
    unit = "" if each.unit == "-" else f" {each.unit}"
    value = each.attained.value
    came = each.attained.why if value is None else f"{value:.4g}{unit}"
    told = f"{each.name}: {came}, full marks at {each.rule.score.full:.4g}{unit}"
    if best is not None and best.attained.value is not None:
        told += f", the reference crew {best.attained.value:.4g}{unit}"
    if each.rule.part == "answer" and (each.marks or 0.0) > (each.earned or 0.0):
        told += ", counted as far as the tasks were done"
    return f"{told}: {_marks(cost)}."


def _marks(cost: float) -> str:
    whole = round(cost)
    if not whole:
        return "it cost less than a mark"
    return f"it cost {whole} mark{'s' if whole > 1 else ''}"
