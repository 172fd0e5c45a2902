"""What each minute cost: in words, for a terminal, and as figures for programs.

``attainable`` finds how many marks could still be earned at each moment. The page, the terminal and
``--json`` take words and numbers of it from here, so that all three say the same.
"""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from trainer.debrief.attainable import (
    BETTER_TIME_S,
    AttainableCurve,
    ChangeCause,
    MarkChange,
)
from trainer.debrief.attainable_falls import PassedKind, SteepFall
from trainer.debrief.attainable_stretches import FINEST_PERIOD_S, POINT_PERIODS
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
    falls = (_fall_words(fall, step) for fall in change.falls)
    return " ".join((_cause_words(change, step), *falls, *_better_words(change, step)))


def _better_words(change: MarkChange, step: float) -> Iterator[str]:
    """Yield what the reference crew orders from the moment of a change."""
    if change.better is None:
        return
    orders = [f'"{text}" at {clock(math.floor(tick * step))}' for tick, text in change.better]
    begin = clock(math.floor(change.told_at * step))
    none = f"nothing for {BETTER_TIME_S:g} s from {begin} on"
    yield f"The reference crew orders {' and '.join(orders) or none}."


def _fall_words(fall: SteepFall, step: float) -> str:
    """Return what passes where marks fall within a second, because no order need come there."""
    what = FALL_WORDS[fall.kind].format(fall.text)
    return f"Of these, {fall.marks:.0f} went at {clock(fall.tick * step)}: from there even {what}."


def _cause_words(change: MarkChange, step: float) -> str:
    begin, end, marks = clock(change.begin * step), clock(change.end * step), abs(change.marks)
    amount = f"{marks:.0f} mark{'' if round(marks) == 1 else 's'}"
    at = "" if change.tick is None else clock(math.floor(change.tick * step))
    came = "did not come"
    if change.came is not None and change.tick is not None:
        late = math.ceil((change.came - change.tick) * step)
        came = f"came {late} s late, at {clock(math.floor(change.came * step))}"
    if change.cause is ChangeCause.BETTER:
        return f"{begin} to {end}: {amount} won, the crew did better than the reference crew."
    if change.cause is ChangeCause.ORDER:
        return f'{at}: "{change.order}", by {change.who}, cost {amount}.'
    if change.cause is ChangeCause.MISSING:
        return f'{begin} to {end}: {amount} lost; "{change.order}" was due at {at} and {came}.'
    if change.cause is ChangeCause.RECORD_ENDS:
        return f"{end}: {amount} not earned, the record ends."
    if change.untouched:
        controls = " or the ".join(change.untouched)
        return f"{begin} to {end}: {amount} lost; nobody worked the {controls}."
    return (
        f"{begin} to {end}: {amount} lost; planes or rudder were not worked as "
        "the reference crew would have."
    )


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
