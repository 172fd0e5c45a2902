"""The causes of a change of the marks that could still be earned.

A fall is that of an order without which it would not have been, of one that was overdue, or of how
planes and rudder were worked. An order that the reference crew gives itself at that moment is never
blamed, and never praised. ``curve`` asks for the causes.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from trainer.boat.reference_crew import RuleProgress
from trainer.debrief.attainable.changes import ChangeCause, MarkChange, join_changes
from trainer.debrief.attainable.explorer import SUSPECT_TIME_S, RunExplorer
from trainer.debrief.attainable.falls import bound_falls, parted_falls, steep_falls
from trainer.debrief.attainable.stretches import (
    WORTH_MARKS,
    AttainablePoint,
    MarkStretch,
    most_tried,
)
from trainer.debrief.passage.controls import (
    HAND_CONTROLS,
    SURFACE_ORDERS,
    control_of,
    is_alike,
    is_wrong_way,
    share_of,
)
from trainer.debrief.passage.episodes import asked_of_hands
from trainer.io.recording.recording import RecordedOrder

CAUSE_SHARE: Final = 0.5  # [-] of a change that a cause must account for
ANSWER_SHARE: Final = 0.5  # [-] estimate: of the angle wanted, from which an order answers
HAND_LOOKS: Final = 5  # at what hands do, in a part of a fall
LEAST_SHARE: Final = 0.02  # [-] of a fall from which a part of it is looked into


def suspects(run: RunExplorer, stretch: MarkStretch) -> list[RecordedOrder]:
    """Return the crew's orders that may have caused a change: those nearest to its begin.

    They came before half of it had. A wrong order costs nothing as long as a careful crew could
    still put it right, so that orders of some seconds before are among them; without any, the last.
    """
    before = stretch.begin.tick - round(SUSPECT_TIME_S / run.step)
    given = [each for each in run.crew if each.tick < stretch.half.tick]
    near = [each for each in given if before <= each.tick] or given[-1:]
    near.sort(key=lambda each: abs(each.tick - stretch.begin.tick))
    return near[: most_tried(run.last)]


def standing_orders(run: RunExplorer, stretch: MarkStretch) -> list[RecordedOrder]:
    """Return the order of each control that stood when a fall began, the latest first."""
    earlier = (each for each in run.crew if each.tick < stretch.begin.tick)
    standing = {control_of(each.text): each for each in earlier}
    return sorted(standing.values(), key=lambda each: -each.tick)[: most_tried(run.last)]


def own_orders(run: RunExplorer, given: Iterable[RecordedOrder]) -> list[RecordedOrder]:
    """Return the orders that the reference crew does not give itself at their moments."""
    return [
        each
        for each in given
        if not any(is_alike(each.text, own) for own in run.soon_by_reference(each.tick))
    ]


def blamable(run: RunExplorer, given: Iterable[RecordedOrder]) -> list[RecordedOrder]:
    """Return the orders that may be to blame.

    Of planes and rudder it is none while another order is overdue.
    """
    return [
        each
        for each in own_orders(run, given)
        if each.name not in SURFACE_ORDERS or not run.overdue(each.tick, each.tick)
    ]


def worst_order(
    run: RunExplorer, stretch: MarkStretch, given: Sequence[RecordedOrder]
) -> tuple[RecordedOrder, float] | None:
    """Return the order that caused a fall, and its share of it.

    It is left out up to the end of the fall, then up to its half: where nobody does anything else,
    a fatal order saves nothing in the end. There it is named for less, if nothing was overdue.
    """
    for point in (stretch.end, stretch.half):
        lost = stretch.begin.marks - point.marks
        if not given or lost <= 0.0 or not (point.tick in run.departures or point.tick >= run.last):
            continue
        saved = {each.id: run.without(each, point.tick) - point.marks for each in given}
        worst = max(given, key=lambda each: saved[each.id])
        alone = point is stretch.half and not run.pending(point.tick)
        if saved[worst.id] >= (WORTH_MARKS if alone else CAUSE_SHARE * lost):
            return worst, min(saved[worst.id] / lost, 1.0)
    return None


def explain(
    run: RunExplorer, stretch: MarkStretch, lasting: Mapping[int, AttainablePoint]
) -> Iterator[MarkChange]:
    """Yield a change with its cause: the order without which it would not have been.

    What is lost beside that, or without any such order, is that of the order that was overdue, or
    of the way in which planes and rudder were worked. ``lasting`` has by tick what could still be
    had from then on or later.
    """
    change = MarkChange(stretch.begin.tick, stretch.end.tick, stretch.marks, ChangeCause.NO_ORDER)
    if change.marks > 0.0:
        yield explain_rise(run, stretch, change)
        return
    falls = steep_falls([lasting[each.tick] for each in stretch.points], run.finest)
    change = replace(change, falls=bound_falls(falls, -change.marks))
    worst = worst_order(run, stretch, blamable(run, suspects(run, stretch)))
    if not (worst or run.overdue(change.begin, change.end)):
        worst = worst_order(run, stretch, blamable(run, standing_orders(run, stretch)))
    if worst:
        order, share = worst
        rest = (1.0 - share) * change.marks
        share = 1.0 if abs(rest) <= WORTH_MARKS else share
        by_order = replace(blame_order(run, order, change), marks=share * change.marks)
        if share == 1.0:
            yield by_order
            return
        own, others = parted_falls(change.falls, order.tick, share * change.marks, rest)
        yield replace(by_order, falls=own)
        change = replace(change, marks=rest, falls=others)
    yield from blame_parts(run, stretch, change)


def explain_rise(run: RunExplorer, stretch: MarkStretch, change: MarkChange) -> MarkChange:
    """Return a rise with the order that made it, if one did."""
    by_hand = run.by_hand(stretch.begin.tick)
    near = [each for each in suspects(run, stretch) if each.name not in by_hand]
    given = own_orders(run, near)
    end = stretch.end.tick
    if not given or not (end in run.departures or end >= run.last):
        return change
    won = {each.id: stretch.end.marks - run.without(each, end) for each in given}
    best = max(given, key=lambda each: won[each.id])
    if won[best.id] < CAUSE_SHARE * change.marks:
        return change
    better = replace(change, cause=ChangeCause.BETTER, order=best.text, tick=best.tick)
    return replace(better, who=best.who)


def blame_order(run: RunExplorer, given: RecordedOrder, change: MarkChange) -> MarkChange:
    """Return a fall as that of a late, turned or needless order."""
    for late in run.pending(given.tick):
        due, text = run.due_tick(late), late.rule.order.text
        if is_alike(text, given.text) and due < given.tick:
            missing = replace(change, cause=ChangeCause.MISSING, order=text)
            return replace(missing, tick=due, came=given.tick)
    soon = run.soon_by_reference(given.tick)
    right = next((each for each in soon if is_wrong_way(given.text, each)), "")
    cause = ChangeCause.WRONG_WAY if right else ChangeCause.ORDER
    by_order = replace(change, cause=cause, order=given.text, tick=given.tick)
    return replace(by_order, who=given.who, right=right)


def blame_rule(run: RunExplorer, late: RuleProgress, change: MarkChange) -> MarkChange:
    """Return a fall as that of an overdue order, or of its opposite."""
    right, due = late.rule.order, run.due_tick(late)
    if late.undone and (by := [each for each in run.crew if each.tick == due]):
        undone = replace(change, cause=ChangeCause.ORDER, order=by[-1].text, tick=due)
        return replace(undone, who=by[-1].who)
    came = run.came(right, due)
    until = change.end if came is None else min(came, change.end)
    since = due - round(SUSPECT_TIME_S / run.step)
    near = [each for each in run.crew if since <= each.tick < until]
    turned = [each for each in near if is_wrong_way(each.text, right.text)]
    for each in own_orders(run, turned):
        wrong = replace(change, cause=ChangeCause.WRONG_WAY, order=each.text, tick=each.tick)
        return replace(wrong, who=each.who, right=right.text)
    missing = replace(change, cause=ChangeCause.MISSING, order=right.text, tick=due)
    return replace(missing, came=came)


def blame_parts(run: RunExplorer, stretch: MarkStretch, change: MarkChange) -> Iterator[MarkChange]:
    """Yield a fall in parts, each of an overdue order or of hands."""
    parts: list[MarkChange] = []
    for before, after in pairwise(stretch.points):
        marks = after.marks - before.marks
        if marks < LEAST_SHARE * change.marks and before.tick in run.departures:
            part = MarkChange(before.tick, after.tick, marks, change.cause)
            if late := run.overdue(before.tick, after.tick):
                parts.append(blame_rule(run, late, part))
            else:
                step = max((after.tick - before.tick) // HAND_LOOKS, 1)
                ticks = range(before.tick, after.tick, step)
                faults = [each for tick in ticks if (each := blame_hand(run, part, tick))]
                steered = replace(part, cause=ChangeCause.STEERING)
                other = steered if run.wanted(before.tick) else part
                parts.append(max(faults, key=faults.count, default=other))
    joined = join_changes(parts)
    told = join_changes(each for each in joined if each.marks < -WORTH_MARKS)
    told = told or sorted(joined, key=lambda each: each.marks)[:1]
    whole = sum(each.marks for each in told)
    for part in told:
        marks = change.marks * part.marks / whole
        falls = [each for each in change.falls if part.begin < each.tick <= part.end]
        yield replace(part, marks=marks, falls=bound_falls(falls, -marks))


def blame_hand(run: RunExplorer, change: MarkChange, tick: int) -> MarkChange | None:
    """Return a fall as that of a hand. None: no hand has anything to do.

    It is late, goes the wrong way, or works otherwise, by what it has ordered up to a tick since
    the last order to the crew or casualty, beside what the reference crew's would order then.
    """
    late = wrong = None
    hands = run.wanted(tick)
    for hand, texts in hands.items():
        control, names = HAND_CONTROLS[hand]
        asked = asked_of_hands(run.trajectory, tick)[hand]
        worked = [each for each in run.crew if each.tick >= asked and each.name in names]
        by_now = [each for each in worked if each.tick <= tick]
        if not texts or any(run.hand_share(hand, each) >= ANSWER_SHARE for each in by_now):
            continue
        opposite = [each for each in by_now if run.hand_share(hand, each) <= -ANSWER_SHARE]
        if opposite:
            given = opposite[0]
            wrong = replace(change, cause=ChangeCause.WRONG_WAY, order=given.text, right=texts[0])
            wrong = replace(wrong, tick=given.tick, who=given.who)
        came = next((e.tick for e in worked if share_of(e.text, texts[0]) >= ANSWER_SHARE), None)
        if came is not None or not worked:
            due = asked + round(run.answer_time(hand) / run.step)
            late = replace(change, cause=ChangeCause.MISSING, tick=due, came=came, control=control)
    otherwise = replace(change, cause=ChangeCause.STEERING) if any(hands.values()) else None
    return wrong or late or otherwise
