"""The figures of a debrief, for programs."""

from dataclasses import asdict
from typing import Any

from trainer.debrief.dossier import Answered, Dossier
from trainer.scores.scoring import Scored


def figures(dossier: Dossier) -> dict[str, Any]:
    """Return what the page tells in numbers; times in s, marks in per cent."""
    step = dossier.step
    return {
        "exercise": dossier.plan.title,
        "vessel": dossier.plan.file.name,
        "started": dossier.header.get("started"),
        "branch": dossier.branch.id,
        "branches": [
            {"branch": each.id, "parent": each.parent, "tick": each.tick, "last": last}
            | {"why": each.why}
            for each, last in dossier.branches
        ],
        "seconds": float(dossier.passage.seconds[-1]),
        "total": dossier.card.total,
        "scores": [_score(each, step) for each in dossier.card.scores],
        "casualties": [_casualty(each, step) for each in dossier.casualties],
        "marks": [
            {"seconds": each.tick * step, "remark": each.text, "by": each.who}
            for each in dossier.of_kind("mark")
        ],
        "ticks": asdict(dossier.ticks),
    }


def _seconds(tick: int | None, step: float) -> float | None:
    return None if tick is None else tick * step


def _score(each: Scored, step: float) -> dict[str, Any]:
    """Return a rule and how it was met."""
    return {
        "name": each.name,
        "measure": each.rule.score.measure,
        "value": each.attained.value,
        "unit": each.unit,
        "why": each.attained.why,
        "marks": each.marks,
        "weight": each.rule.weight,
        "tick": each.attained.tick,
        "seconds": _seconds(each.attained.tick, step),
        "formula": each.formula,
    }


def _casualty(each: Answered, step: float) -> dict[str, Any]:
    """Return a casualty and what was done about it."""
    return {
        "kind": each.spell.kind,
        "begun_s": each.spell.begun * step,
        "ended_s": _seconds(each.spell.ended, step),
        "order": each.order and each.order.text,
        "order_by": each.order and each.order.who,
        "order_s": each.order and each.order.tick * step,
        "deflected": each.deflection and each.deflection.surface,
        "deflected_s": each.deflection and each.deflection.tick * step,
    }
