"""What each minute cost: in words, for a terminal, and as figures for programs.

``curve`` has how many marks could still be earned at each moment. The page, the terminal and
``--json`` take words and numbers of it from here, so that all three say the same.
"""

import math
from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np

from trainer.debrief.attainable.changes import ChangeCause, MarkChange
from trainer.debrief.attainable.curve import AttainableCurve
from trainer.debrief.attainable.explorer import BETTER_TIME_S
from trainer.debrief.attainable.falls import PassedKind, SteepFall
from trainer.debrief.attainable.stretches import FINEST_PERIOD_S, POINT_PERIODS
from trainer.report.svg import TIME_STEPS_S, clock, step_of
from trainer.report.svg import ticks as axis_ticks

TEXT_COLUMNS: Final = 60  # [columns] of the curve in a terminal of 80
MAX_TEXT_MOMENTS: Final = 6  # steps of time under it
FALL_WORDS: Final = {
    PassedKind.LOSS: "the reference crew loses ({})",
    PassedKind.LIMIT: "the reference crew breaks a limit ({})",
    PassedKind.RULE: 'the reference crew falls short in "{}"',
}
TEXT_ROWS_PERCENT: Final = (100.0, 80.0, 60.0, 40.0, 20.0, 0.0)  # [%] of marks, a row each


def until_words(curve: AttainableCurve, step: float) -> str:
    """Return in words until when the exercise could be won, and the boat be saved.

    Where a run is so long that points lie further apart than usual, that is told too.
    """
    last = curve.points[-1].tick
    sentences = []
    if curve.until_won is None:
        sentences.append("From its start this could not be won, even by the reference crew.")
    elif curve.until_won < last:
        sentences.append(f"Until {clock(curve.until_won * step)} this could still be won.")
    if curve.until_saved is not None and curve.until_saved < last:
        sentences.append(f"Until {clock(curve.until_saved * step)} the boat could be saved.")
    if not sentences:
        sentences.append("To its end nothing was lost that decides the exercise.")
    for order in curve.beyond:
        moment = clock(math.floor(order.tick * step))
        by = f'"{order.text}", by {order.who} at {moment}'
        sentences.append(f"The marks are for the exercise's own orders, not for {by}.")
    if curve.finest * step >= 2.0 * FINEST_PERIOD_S:
        near, far = (f"{each * curve.finest * step:g} s" for each in (1, POINT_PERIODS))
        sentences.append(
            f"The run is long: where orders are given a point each {far}, and down to {near} at a "
            "change."
        )
    return " ".join(sentences)


def change_words(change: MarkChange, step: float) -> str:
    """Return one change of the attainable marks in words.

    It is one sentence, one more for each of its steep falls, and one with the better order.
    """
    falls = _falls_words(change.falls, step)
    return " ".join((_cause_words(change, step), *falls, *_better_words(change, step)))


def _better_words(change: MarkChange, step: float) -> Iterator[str]:
    """Yield what the reference crew orders from the moment of a change."""
    if change.better is None:
        return
    orders = [f'"{text}" at {clock(math.floor(tick * step))}' for tick, text in change.better]
    begin = clock(math.floor(change.told_at * step))
    none = f"nothing for {BETTER_TIME_S:g} s from {begin} on"
    yield f"The reference crew orders {' and '.join(orders) or none}."


def _falls_words(falls: Iterable[SteepFall], step: float) -> Iterator[str]:
    """Yield what passes where marks fall within a second, because no order need come there.

    The marks are rounded so that they add up to no more than the whole, as it is told.
    """
    whole = 0.0
    for fall in falls:
        marks, whole = round(whole + fall.marks) - round(whole), whole + fall.marks
        what = FALL_WORDS[fall.kind].format(fall.text)
        yield f"Of these, {marks} went at {clock(fall.tick * step)}: from there even {what}."


def _cause_words(change: MarkChange, step: float) -> str:
    """Return what a change came to, and why."""
    amount = f"{abs(change.marks):.0f} mark{'' if round(abs(change.marks)) == 1 else 's'}"
    begin, end = clock(change.begin * step), clock(change.end * step)
    if change.cause in (ChangeCause.ORDER, ChangeCause.WRONG_WAY):
        way = f' the wrong way for "{change.right}",' if change.right else ""
        back = "" if change.back is None else f" taken back at {_moment(change.back, step)},"
        at = _moment(change.tick, step)
        return f'{at}: "{change.order}", by {change.who},{way}{back} cost {amount}.'
    if change.cause is ChangeCause.RECORD_ENDS:
        return f"{end}: {amount} not earned, the record ends."
    if change.cause is ChangeCause.BETTER:
        crew = "the crew did better than the reference crew"
        return f'{begin} to {end}: {amount} won; by "{change.order}" {crew}.'
    way = "more to be had" if change.marks > 0.0 else "lost"
    why = {
        ChangeCause.NO_ORDER: f"{way}; no one order did it",
        ChangeCause.MISSING: f"lost; {_missing_words(change, step)}",
    }
    steered = "lost; planes or rudder were not worked as the reference crew would have"
    return f"{begin} to {end}: {amount} {why.get(change.cause, steered)}."


def _missing_words(change: MarkChange, step: float) -> str:
    """Return what did not come, or how late it came."""
    late = math.ceil(((change.came or 0) - (change.tick or 0)) * step)
    due, came = _moment(change.tick, step), _moment(change.came, step)
    if not change.order:
        until = f"until {came}, {late} s late" if came else f"from {due} on"
        return f"nobody worked the {change.control} {until}"
    end = f"came {late} s late, at {came}" if came else "did not come"
    return f'"{change.order}" was due at {due} and {end}'


def _moment(tick: int | None, step: float) -> str:
    return "" if tick is None else clock(math.floor(tick * step))


def terminal_lines(curve: AttainableCurve, step: float) -> Iterator[str]:
    """Yield the curve and its changes as lines of a terminal of 80 columns."""
    ticks = np.array([point.tick for point in curve.points])
    marks = np.array([point.marks for point in curve.points])
    columns = np.linspace(ticks[0], ticks[-1], TEXT_COLUMNS)
    values = np.interp(columns, ticks, marks)
    yield until_words(curve, step)
    half = 0.5 * (TEXT_ROWS_PERCENT[0] - TEXT_ROWS_PERCENT[1])
    for level in TEXT_ROWS_PERCENT:
        drawn = "".join("#" if value >= level - half else " " for value in values)
        yield f"{level:4.0f} |{drawn}".rstrip()
    yield f"     +{'-' * TEXT_COLUMNS}"
    yield f"      {text_axis(ticks[0] * step, ticks[-1] * step)}"
    for change in curve.changes:
        yield change_words(change, step)


def text_axis(begin: float, end: float) -> str:
    """Return the moments [s] under a curve in a terminal, each where its column is."""
    moments = axis_ticks(begin, end, step_of(end - begin, MAX_TEXT_MOMENTS, TIME_STEPS_S))
    axis = ""
    for seconds in (*moments, end):
        column = round((seconds - begin) / (end - begin) * (TEXT_COLUMNS - 1))
        if not axis or column > len(axis):  # else the end is close to a moment
            axis = f"{axis:{column}}{clock(seconds)}"
    return axis


def attainable_figures(curve: AttainableCurve, step: float) -> dict[str, Any]:
    """Return the curve and its changes for programs; times in s, marks in per cent."""
    return {
        "until_won_s": _seconds(curve.until_won, step),
        "until_saved_s": _seconds(curve.until_saved, step),
        "points": [
            {"seconds": each.tick * step, "marks": each.marks, "won": each.won, "lost": each.lost}
            for each in curve.points
        ],
        "changes": [
            {
                "from_s": each.begin * step,
                "to_s": each.end * step,
                "marks": each.marks,
                "cause": each.cause.value,
                "order": each.order,
                "order_s": _seconds(each.tick, step),
                "came_s": _seconds(each.came, step),
                "by": each.who,
                "right": each.right,
                "taken_back_s": _seconds(each.back, step),
                "better": [
                    {"seconds": tick * step, "order": text} for tick, text in each.better or ()
                ],
                "told": change_words(each, step),
            }
            for each in curve.changes
        ],
    }


def _seconds(tick: int | None, step: float) -> float | None:
    return None if tick is None else tick * step
