"""What a careful crew could still earn, above the instructor's line of time.

A column is as high as the marks that could still be earned at its time; it stands where the line of
time below has that time. No other screen draws it, because no other role is told.
"""

from typing import Final

from trainer.config.exercise.outcome import Outcome
from trainer.console.drawing.event_log import MIN_TIMELINE_COLUMNS, end_of
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, Run, fit, line

HEIGHTS: Final = "▁▂▃▄▅▆▇█"  # from no marks to all
OLD_AGE_S: Final = 15.0  # [s] of exercise time from which the age is told


def evaluation(model: SessionModel, width: int, _height: int) -> Lines:
    """Return the marks still to be had, how they fell, and those so far."""
    points, reason = model.timeline.attainable, model.timeline.unevaluated
    if reason or not points:
        return [fit(line((f" no evaluation: {reason}", "dim")), width)]
    last = points[-1]
    ink = "value" if last.outcome is Outcome.WON else "warning"
    left = line((f"earn{last.marks:3.0f}", ink))
    age = model.picture.seconds - last.seconds
    right_text = f" {age:.0f} s ago" if age > OLD_AGE_S else f" so far {last.so_far:.0f}"
    right_text = f" not for {last.beyond}" if last.beyond else right_text
    right = line((f"{right_text:<10}", "dim"))
    room = width - len("earn100") - len(right_text.ljust(10))
    if room < MIN_TIMELINE_COLUMNS:
        return [fit((*left, *right), width)]
    return [(*left, *columns(model, room), *right)]


def columns(model: SessionModel, room: int) -> tuple[Run, ...]:
    """Return a column for each time, up to the last evaluation."""
    points, end = model.timeline.attainable, end_of(model)
    runs: list[Run] = []
    for at in range(room):
        until = (at + 0.5) / max(room - 1, 1) * end
        known = [each for each in points if each.seconds <= until]
        if not known or at > round(points[-1].seconds / end * (room - 1)):
            runs.append((" ", "dim"))
            continue
        point = known[-1]
        height = HEIGHTS[min(int(point.marks / 100.0 * len(HEIGHTS)), len(HEIGHTS) - 1)]
        runs.append((height, "ordered" if point.outcome is Outcome.WON else "warning"))
    return tuple(runs)
