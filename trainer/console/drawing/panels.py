"""The first line of a screen, and what each station shows above its charts.

``layouts`` names the panel of each role; ``app`` draws the first line and the keys. A drawing takes
the model, and the columns and rows that there are; it returns lines and changes nothing.
"""

import textwrap
from collections.abc import Sequence
from typing import Final

from trainer.console.drawing.aids import aid_rows, safe_rows
from trainer.console.drawing.crew_orders import order_line
from trainer.console.drawing.dials import (
    angles,
    compass,
    depth_gauge,
    dials,
    scale,
    small_dial,
    speed_log,
    telegraph,
)
from trainer.console.drawing.plant import supply_rows
from trainer.console.drawing.tanks import levels
from trainer.console.journal import clock
from trainer.console.model import MAKING_READY, SessionModel
from trainer.console.pane import Line, Lines, beside, fit, length, line

LARGE_NUMBER_ROWS: Final = 9  # [rows] with room for large numbers
LARGE_GAUGE_ROWS: Final = 7  # the same for the repeaters, which have fewer lines below
KEY_GAP_COLUMNS: Final = 1  # [columns] between keys
LIT_LABELS: Final = {  # of the instruments that a step of a lesson lights up
    **{name: (name,) for name in ("depth", "heading", "speed", "pitch", "rudder", "stern", "bow")},
    "bell": ("astern",),
}
LABEL_INKS: Final = ("dim", "heading")
SILENCE_TIMEOUT_S: Final = 2.0  # [s] without values of a running session, beside two ticks


def top(model: SessionModel, width: int, _height: int) -> Lines:
    """Return the screen's first line, or the trouble of the line to the session."""
    wrong = trouble(model)
    if wrong:
        return [fit(line((f" {wrong} ", "alarm")), width, "alarm")]
    if not model.greeted or model.follows:
        says = MAKING_READY if model.follows else "making ready"
        return [fit(line((f" {model.role} ", "bright"), (says, "bar")), width, "bar")]
    clockwork = f"{clock(model.picture.seconds)} "
    left_line = (*line((f" {model.role} ", "bright"), (clockwork, "bright")), *pace(model))
    title_text, room = title(model), width - length(left_line)
    title_text = title_text if len(title_text) <= room else f" {title_text.rpartition('  ')[2]}"
    return [
        beside(
            left_line, line((title_text if len(title_text) <= room else "", "bar")), width, "bar"
        )
    ]


def trouble(model: SessionModel) -> str:
    """Return the trouble of the line or of its data, "" while there is none."""
    if model.over:
        return "THE SESSION IS OVER: F10 leaves; the next one will be joined"
    if model.follows:
        return ""
    if not model.joined:
        return f"NO LINE: {model.trouble}; trying again" if model.trouble else ""
    picture = model.picture
    last = picture.reading(model.gauges)
    step = last.seconds / last.tick if last.tick else 0.0
    silent = model.clock() - last.arrived
    # values come once a tick, so a slow exercise may be silent for two ticks longer
    if picture.frozen or not picture.pace or silent < SILENCE_TIMEOUT_S + 2.0 * step / picture.pace:
        return ""
    return f"NO DATA for {silent:.0f} s: the session does not answer"


def pace(model: SessionModel) -> Line:
    """Return how time runs."""
    picture = model.picture
    factor = picture.word("time", "speed")
    speed = "as fast as it goes" if factor == "max" else f"x{picture.pace:g}"
    parts = [(" FROZEN ", "alarm")] if picture.frozen else [("RUNNING", "running")]
    parts.append((f" {speed}", "bar"))
    if picture.word("time", "replay") == "yes":
        parts.append(("  REPLAY", "key"))
    if picture.word("time", "shown") == "yes":
        parts.append(("  THE WAY SHOWN", "key"))
    held = picture.word("time", "held")
    if held:
        parts.append((f"  HELD: {held}", "key"))
    if model.instructs and picture.pace:
        parts.append((f"  branch {picture.word('time', 'branch')}", "bar"))
    return line(*parts)


def title(model: SessionModel) -> str:
    """Return the session's name, and the rest of the exercise or how it went."""
    exercise = model.exercise
    named = exercise.values.get("title") or next(iter(exercise.briefing), "")
    if exercise.outcome:
        return f" {named}  EXERCISE OVER: {exercise.outcome} "
    left = exercise.left_at(model.picture.seconds)
    time_text = "" if left is None else f"  {clock(left)[3:]} left"
    return f" {named}{time_text} " if named or time_text else ""


def foot(keys: Sequence[tuple[str, str]], width: int, rows: int) -> Lines:
    """Return the keys in as many lines as they need, ``rows`` at most."""
    lines = []
    for row in key_rows(keys, width, rows):
        parts: list[tuple[str, str]] = [(" ", "bar")]
        for label, says in row:
            parts += [(label, "key"), (f" {says}{' ' * KEY_GAP_COLUMNS}", "bar")]
        lines.append(fit(line(*parts), width, "bar"))
    return lines


def key_rows(keys: Sequence[tuple[str, str]], width: int, rows: int) -> list[list[tuple[str, str]]]:
    """Return the keys by rows. Where room is short, the last key stays and those before it go."""
    shown = list(keys)
    while len(flowed(shown, width)) > max(rows, 1) and len(shown) > 1:
        del shown[-2]
    return flowed(shown, width)


def flowed(keys: Sequence[tuple[str, str]], width: int) -> list[list[tuple[str, str]]]:
    """Return keys in as many rows of at most ``width`` columns as it takes."""
    key_rows: list[list[tuple[str, str]]] = [[]]
    used = 1
    for key in keys:
        wide = sum(map(len, key)) + 1
        if key_rows[-1] and used + wide > width:
            key_rows.append([])
            used = 1
        key_rows[-1].append(key)
        used += wide + KEY_GAP_COLUMNS
    return key_rows


def key_at(
    keys: Sequence[tuple[str, str]], width: int, rows: int, cell: tuple[int, int]
) -> tuple[str, str]:
    """Return the label of the key at a column and row, and its text there."""
    column, row = cell
    drawn = key_rows(keys, width, rows)
    start = 1
    for label, says in drawn[row] if row < len(drawn) else ():
        if start <= column < start + len(label) + 1 + len(says):
            return label, label if column <= start + len(label) else says
        start += len(label) + 1 + len(says) + KEY_GAP_COLUMNS
    return "", ""


def helm(model: SessionModel, width: int, height: int) -> Lines:
    """Return the helm's panel: heading, speed, depth, the rudder and the telegraph."""
    lines = [
        *dials(model, [compass(model), speed_log(model), depth_gauge(model)], width),
        order_line(model, width),
        *aid_rows(model, width),
        scale(model, "rudder", "steering", width),
        *supply_rows(model, ("rudder",), width),
        *telegraph(model, width),
        angles(model, width),
    ]
    return [fit(each, width) for each in lines[:height]]


def planes(model: SessionModel, width: int, height: int) -> Lines:
    """Return the planes' panel: depth, heading and speed, attitude and both pairs of planes."""
    lines = [
        *instruments(model, width, large=height >= LARGE_NUMBER_ROWS),
        scale(model, "stern", "diving", width),
        scale(model, "bow", "diving", width),
        *supply_rows(model, ("stern", "bow"), width),
        *safe_rows(model, width),
        angles(model, width),
    ]
    return [fit(each, width) for each in lines[:height]]


def pilot(model: SessionModel, width: int, height: int) -> Lines:
    """Return the panel of a pilot or an observer: those of planes and helm."""
    lines = [
        *dials(model, [depth_gauge(model), compass(model), speed_log(model)], width),
        order_line(model, width),
        *aid_rows(model, width),
        *surfaces(model, width),
        *supply_rows(model, ("rudder", "stern", "bow"), width),
        *safe_rows(model, width),
        *telegraph(model, width),
        angles(model, width),
    ]
    return [fit(each, width) for each in lines[:height]]


def trainee(model: SessionModel, width: int, height: int) -> Lines:
    """Return a lesson's step, and below it the panel of what is in hand."""
    steps = step_rows(model, width)
    if "ballast" in model.exercise.by_hand:  # small, because the tanks below need the room
        drawn = [*instruments(model, width, large=False), *surfaces(model, width)]
        drawn.append(angles(model, width))
    else:
        drawn = pilot(model, width, height)
    drawn = [*steps, *lit(drawn, LIT_LABELS.get(model.exercise.step.instrument, ()))]
    return [fit(each, width) for each in drawn[:height]]


def trainee_levels(model: SessionModel, width: int, height: int) -> Lines:
    """Return the tanks, their heading lit up where a step asks to look there."""
    lines = levels(model, width, height)
    if model.exercise.step.instrument == "tanks" and lines:
        lines[0] = tuple((text, "new") for text, _ in lines[0])
    return lines


def step_rows(model: SessionModel, width: int) -> Lines:
    """Return the present step of a lesson and its hint, nothing without one."""
    number, count, _, text, hint = model.exercise.step
    if not text:
        return []
    head = f" step {number} of {count} "
    first, *more = textwrap.wrap(text, max(width - 2, 20), initial_indent=" " * len(head))
    rows = [line((head, "new"), (f" {first.strip()}", "value"))]
    rows += [line((f" {each}", "value")) for each in more]
    hints = textwrap.wrap(f"hint: {hint}", max(width - 2, 20)) if hint else []
    return [*rows, *(line((f" {each}", "warning")) for each in hints), line()]


def lit(lines: Sequence[Line], labels: Sequence[str]) -> Lines:
    """Return a drawing with the labels of an instrument lit up."""
    return [
        tuple(
            (text, "new")
            if ink in LABEL_INKS and text.strip().startswith(tuple(labels))
            else (text, ink)
            for text, ink in each
        )
        if labels
        else each
        for each in lines
    ]


def gauges(model: SessionModel, width: int, height: int) -> Lines:
    """Return the repeaters: depth, heading, speed and attitude."""
    lines = [*instruments(model, width, large=height >= LARGE_GAUGE_ROWS), angles(model, width)]
    return [fit(each, width) for each in lines[:height]]


def periscope(model: SessionModel, width: int, height: int) -> Lines:
    """Return what the periscope shows in numbers and words, under the repeaters."""
    picture = model.picture

    def said(name: str) -> str:
        return picture.word("scope", name) or "-"

    towards = picture.number("scope", "bearing")
    bearing = "-" if towards is None else f"{round(towards) % 360:03d}"
    optics = f" bearing {bearing}  off the bow {said('train')} deg  power {said('power')} x"
    mast = f" mast {said('going')}, {said('mast')} m out  view {said('view')}"
    lines = [
        *instruments(model, width, large=height >= LARGE_NUMBER_ROWS),
        line((optics, "bright")),
        line((mast, "bright")),
        line((f" in the view: {picture.word('scope', 'sighted') or 'nothing'}", "bright")),
    ]
    return [fit(each, width) for each in lines[:height]]


def instruments(model: SessionModel, width: int, *, large: bool) -> Lines:
    """Return depth, heading and speed above the newest order, small where room is short."""
    shown = [depth_gauge(model), compass(model), speed_log(model)]
    drawn = (
        dials(model, shown, width) if large else [small_dial(model, each, width) for each in shown]
    )
    return [*drawn, order_line(model, width), *aid_rows(model, width)]


def surfaces(model: SessionModel, width: int) -> Lines:
    """Return the scales of rudder and planes."""
    shown = (("rudder", "steering"), ("stern", "diving"), ("bow", "diving"))
    return [scale(model, name, channel, width) for name, channel in shown]
