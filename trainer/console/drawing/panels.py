"""The first line of a screen, and what each station shows above its charts."""

from typing import Final

from trainer.console.drawing.dials import (
    angles,
    course_dial,
    depth_dial,
    scale,
    side_by_side,
    speed_dial,
    telegraph,
)
from trainer.console.journal import clock
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, beside, fit, length, line

SILENCE: Final = 2.0  # [s] of a session that runs, after which it is called out


def top(model: SessionModel, width: int, _height: int) -> Lines:
    """Return the first line, or what is wrong with the line to the session."""
    wrong = trouble(model)
    if wrong:
        return [fit(line((f" {wrong} ", "alarm")), width, "alarm")]
    if not model.greeted:
        return [fit(line((f" {model.role} ", "bright"), ("making ready", "bar")), width, "bar")]
    clockwork = f"{clock(model.picture.seconds)} "
    left = (*line((f" {model.role} ", "bright"), (clockwork, "bright")), *pace(model))
    told = title(model)
    room = width - length(left)
    return [beside(left, line((told if len(told) <= room else "", "bar")), width, "bar")]


def trouble(model: SessionModel) -> str:
    """Return what is wrong with the line or with what comes on it, "" while nothing is."""
    if model.over:
        return "THE SESSION IS OVER: F10 leaves"
    if not model.joined:
        return f"NO LINE: {model.trouble}; trying again" if model.trouble else ""
    picture = model.picture
    last = picture.reading(model.gauges)
    step = last.seconds / last.tick if last.tick else 0.0
    silent = model.clock() - last.arrived
    if picture.frozen or not picture.pace or silent < SILENCE + 2.0 * step / picture.pace:
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
    held = picture.word("time", "held")
    if held:
        parts.append((f"  HELD: {held}", "key"))
    if model.instructs and picture.pace:
        parts.append((f"  branch {picture.word('time', 'branch')}", "bar"))
    return line(*parts)


def title(model: SessionModel) -> str:
    """Return what the session calls itself."""
    return f" {model.briefing[0]} " if model.briefing else ""


def foot(keys: tuple[tuple[str, str], ...], width: int) -> Lines:
    """Return the keys in a line; where there is no room the last but one go first."""
    shown, gap = list(keys), 2
    while len(shown) > 1 and key_columns(shown, gap) > width:
        if gap > 1:
            gap = 1
        else:
            del shown[-2]
    parts: list[tuple[str, str]] = [(" ", "bar")]
    for label, says in shown:
        parts += [(label, "key"), (f" {says}{' ' * gap}", "bar")]
    return [fit(line(*parts), width, "bar")]


def key_columns(keys: list[tuple[str, str]], gap: int) -> int:
    """Return the columns that keys take with so many blanks after each."""
    return 1 + sum(len(label) + 1 + len(says) + gap for label, says in keys) - gap


def helm(model: SessionModel, width: int, height: int) -> Lines:
    """Return the helm's panel: course, speed, depth, the rudder and the telegraph."""
    lines = [
        *side_by_side([course_dial(model), speed_dial(model), depth_dial(model)], width),
        scale(model, "rudder", "steering", width),
        line(),
        *telegraph(model, width),
        angles(model),
    ]
    return [fit(each, width) for each in lines[:height]]


def planes(model: SessionModel, width: int, height: int) -> Lines:
    """Return the planes' panel: depth, course and speed, attitude and both pairs of planes."""
    lines = [
        *side_by_side([depth_dial(model), course_dial(model), speed_dial(model)], width),
        scale(model, "stern", "diving", width),
        scale(model, "bow", "diving", width),
        line(),
        angles(model),
    ]
    return [fit(each, width) for each in lines[:height]]


def gauges(model: SessionModel, width: int, height: int) -> Lines:
    """Return the repeaters: depth, course, speed and attitude."""
    lines = [
        *side_by_side([depth_dial(model), course_dial(model), speed_dial(model)], width),
        angles(model),
    ]
    return [fit(each, width) for each in lines[:height]]


def lookout(model: SessionModel, width: int, height: int) -> Lines:
    """Return what an observer sees: the repeaters, every surface and the telegraph."""
    lines = [
        *side_by_side([depth_dial(model), course_dial(model), speed_dial(model)], width),
        scale(model, "rudder", "steering", width),
        scale(model, "stern", "diving", width),
        scale(model, "bow", "diving", width),
        *telegraph(model, width),
        angles(model),
    ]
    return [fit(each, width) for each in lines[:height]]
