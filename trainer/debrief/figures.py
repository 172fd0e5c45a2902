"""The figures of a debrief, for programs."""

from dataclasses import asdict
from typing import Any

from trainer.debrief.dossier import Dossier


def figures(dossier: Dossier) -> dict[str, Any]:
    """Return what the page tells in numbers; times in s, marks in per cent."""
    step = dossier.step

    def seconds(tick: int | None) -> float | None:
        return None if tick is None else tick * step

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
        "scores": [
            {
                "name": each.name,
                "measure": each.rule.score.measure,
                "value": each.attained.value,
                "unit": each.unit,
                "why": each.attained.why,
                "marks": each.marks,
                "weight": each.rule.weight,
                "tick": each.attained.tick,
                "seconds": seconds(each.attained.tick),
                "formula": each.formula,
            }
            for each in dossier.card.scores
        ],
        "casualties": [
            {
                "kind": each.spell.kind,
                "begun_s": seconds(each.spell.begun),
                "ended_s": seconds(each.spell.ended),
                "order": each.order and each.order.text,
                "order_by": each.order and each.order.who,
                "order_s": seconds(each.order.tick) if each.order else None,
                "deflected": each.deflection and each.deflection.surface,
                "deflected_s": seconds(each.deflection.tick) if each.deflection else None,
            }
            for each in dossier.casualties
        ],
        "marks": [
            {"seconds": seconds(each.tick), "remark": each.text, "by": each.who}
            for each in dossier.of_kind("mark")
        ],
        "ticks": asdict(dossier.ticks),
    }
