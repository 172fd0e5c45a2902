"""The figures of a debrief for programs: what its page tells, as JSON."""

from dataclasses import asdict
from typing import Any

from trainer.analysis.debrief.data import Answered, DebriefData
from trainer.analysis.debrief.readbacks import ReadBack
from trainer.analysis.debrief.reference import Reference
from trainer.analysis.debrief.scoring import Scorecard, Scored, Verdict
from trainer.analysis.rehearsal import CREW


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
        "trainees": list(debrief.trainees),
        "seed": debrief.plan.seed,
        "width": debrief.width,
        "by_hand": list(debrief.plan.hand),
        "practice": bool(debrief.practice),
        "seconds": float(debrief.trajectory.seconds[-1]),
        "total": debrief.total,
        "deviation": deviation_of(debrief),
        "verdict": _verdict(debrief.card.verdict),
        "cost_most": [asdict(each) for each in debrief.losses],
        **_compared(debrief),
        "changes": [asdict(each) | {"branch": int(each.branch)} for each in debrief.changes],
        "changed": debrief.changed and _card(debrief.changed, step),
        "scores": [_score(each, step) for each in debrief.card.scores],
        "orders_to_crew": [_read_back(each, step) for each in debrief.read_backs],
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


def deviation_of(debrief: DebriefData) -> float | None:
    """Return the standard deviation of a mark by the sea alone [%], None where none is known."""
    kept = debrief.plan.baseline
    if kept is None or kept.crew is None or kept.heading.seeds < 2:
        return None
    return kept.crew.deviation


def _compared(debrief: DebriefData) -> dict[str, Any]:
    """Return the reference crew's run, and where this one went wrong beside it."""
    found, step = debrief.compared, debrief.step
    if found is None:
        return {"reference": None, "went_wrong": None, "reference_from": None}
    fault = found.fault and asdict(found.fault) | {"seconds": found.fault.tick * step}
    return {
        "reference": _reference(found.reference, step),
        "went_wrong": fault,
        "reference_from": found.from_here and _reference(found.from_here, step),
    }


def _reference(each: Reference, step: float) -> dict[str, Any]:
    """Return a run of the reference crew: its marks, and its orders."""
    orders = [
        {"seconds": order.tick * step, "order": order.text}
        for order in each.trajectory.orders
        if order.who == CREW
    ]
    return {"from_s": each.since, **_card(each.card, step), "orders": orders}


def _card(card: Scorecard, step: float) -> dict[str, Any]:
    """Return the marks of a run."""
    return {
        "total": card.total,
        "verdict": _verdict(card.verdict),
        "scores": [_score(each, step) for each in card.scores],
    }


def _read_back(each: ReadBack, step: float) -> dict[str, Any]:
    """Return an order to the crew and what came of it."""
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
