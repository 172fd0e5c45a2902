"""What each minute cost: in words, for a terminal, and as figures for programs.

``curve`` has how many marks could still be earned at each moment. The page, the terminal and
``--json`` take words and numbers of it from here, so that all three say the same.
"""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from trainer.debrief.attainable.changes import FaultKind, MarkChange
from trainer.debrief.attainable.curve import AttainableCurve
from trainer.debrief.attainable.explorer import FINEST_PERIOD_S
from trainer.report.svg import TIME_STEPS_S, clock, step_of
from trainer.report.svg import ticks as axis_ticks

TEXT_COLUMNS: Final = 60  # [columns] of the curve in a terminal of 80
MAX_TEXT_MOMENTS: Final = 6  # steps of time under it
FAULT_WORDS: Final = {  # of an order: what it did, as it goes on with "cost"
    FaultKind.UNDONE: "undid {} and ",
    FaultKind.WRONG_WAY: "given for {}, ",
    FaultKind.WRONG_PLACE: "given for {}, ",
    FaultKind.WRONG_AMOUNT: "given for {}, ",
    FaultKind.TURNED: "given before {}, ",
    FaultKind.MISSING: "",
    FaultKind.NEEDLESS: "",
}
TEXT_ROWS_PERCENT: Final = (100.0, 80.0, 60.0, 40.0, 20.0, 0.0)  # [%] of marks, a row each


def until_words(curve: AttainableCurve, step: float) -> str:
    """Return in words until when the exercise could be won, and the boat be saved.

    Where a run is so long that points lie further apart than usual, that is told too.
    """
    last = curve.points[-2 if curve.cut_short else -1].tick
    sentences = []
    if curve.until_won is None:
        sentences.append("From its start no flight wins this.")
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
        sentences.append(f"The run is long: moments are {curve.finest * step:g} s apart.")
    return " ".join(sentences)


def change_words(change: MarkChange, step: float) -> str:
    """Return one change in words, and until when it could be put right."""
    said = _fault_words(change, step)
    if change.until is None:
        return said
    return f"{said} Until {_moment(change.until, step)} it could still be put right."


def _fault_words(change: MarkChange, step: float) -> str:
    """Return what a change came to, and why."""
    amount = f"{abs(change.marks):.0f} mark{'' if round(abs(change.marks)) == 1 else 's'}"
    begin, end = _moment(change.begin, step), _moment(change.end, step)
    if change.fault is FaultKind.STEERING:
        return f"{begin} to {end}: {amount} lost; {_steering_words(change, step)}."
    if change.order and change.fault is not FaultKind.LATE:
        order = f'{_moment(change.tick, step)}: "{change.order}"'
        how = FAULT_WORDS[change.fault].format(f'"{change.right}"')
        if change.fault is FaultKind.MISSING:
            due = _moment(change.tick, step)
            return f'"{change.order}" was due at {due} and did not come: {amount} lost.'
        return f"{order}, by {change.who}, {how}cost {amount}."
    if change.order:
        late = math.ceil(((change.came or 0) - (change.tick or 0)) * step)
        due, came = _moment(change.tick, step), _moment(change.came, step)
        said = f'"{change.order}" was due at {due} and came {late} s late, at {came}'
        others = change.late_orders - 1
        more = f", and {others} order{'s' if others > 1 else ''} more came late" if others else ""
        return f"{said}{more}: {amount} lost."
    if change.fault is FaultKind.RECORD_ENDS:
        return f"{end}: {amount} not earned, the record ends."
    why = "no flight shows by which order"
    if change.fault is FaultKind.UNSEARCHED:
        why = "the cause of so long a run is not looked for"
    return f"{begin} to {end}: {amount} lost; {why}."


def _steering_words(change: MarkChange, step: float) -> str:
    if change.order:
        since = f'from "{change.order}" at {_moment(change.tick, step)} on'
        return f"{since} planes or rudder were not worked as the reference crew would have"
    begin = _moment(change.begin, step)
    when = f"from {begin} to {_moment(change.came, step)}" if change.came else f"from {begin} on"
    return f"nobody worked planes or rudder {when}, which the reference crew would have"


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
                "fault": each.fault.value,
                "order": each.order,
                "order_s": _seconds(each.tick, step),
                "came_s": _seconds(each.came, step),
                "by": each.who,
                "right": each.right,
                "until_s": _seconds(each.until, step),
                "remedy": [{"seconds": tick * step, "order": text} for tick, text in each.remedy],
                "told": change_words(each, step),
            }
            for each in curve.changes
        ],
    }


def _seconds(tick: int | None, step: float) -> float | None:
    return None if tick is None else tick * step
