"""What each station's screen shows above its charts."""

from trainer.screen.drawing.dials import (
    angles,
    course_dial,
    depth_dial,
    scale,
    side_by_side,
    speed_dial,
    telegraph,
)
from trainer.screen.ink import Lines, fit, line
from trainer.screen.sight import Sight


def helm(sight: Sight, width: int, height: int) -> Lines:
    """Return the helm's panel: course, speed, depth, the rudder and the telegraph."""
    lines = [
        *side_by_side([course_dial(sight), speed_dial(sight), depth_dial(sight)], width),
        scale(sight, "rudder", "steering", width),
        line(),
        *telegraph(sight, width),
        angles(sight),
    ]
    return [fit(each, width) for each in lines[:height]]


def planes(sight: Sight, width: int, height: int) -> Lines:
    """Return the planes' panel: depth, course and speed, attitude and both pairs of planes."""
    lines = [
        *side_by_side([depth_dial(sight), course_dial(sight), speed_dial(sight)], width),
        scale(sight, "stern", "diving", width),
        scale(sight, "bow", "diving", width),
        line(),
        angles(sight),
    ]
    return [fit(each, width) for each in lines[:height]]


def gauges(sight: Sight, width: int, height: int) -> Lines:
    """Return the repeaters: depth, course, speed and attitude."""
    lines = [
        *side_by_side([depth_dial(sight), course_dial(sight), speed_dial(sight)], width),
        angles(sight),
    ]
    return [fit(each, width) for each in lines[:height]]


def lookout(sight: Sight, width: int, height: int) -> Lines:
    """Return what an observer sees: the repeaters, every surface and the telegraph."""
    lines = [
        *side_by_side([depth_dial(sight), course_dial(sight), speed_dial(sight)], width),
        scale(sight, "rudder", "steering", width),
        scale(sight, "stern", "diving", width),
        scale(sight, "bow", "diving", width),
        *telegraph(sight, width),
        angles(sight),
    ]
    return [fit(each, width) for each in lines[:height]]
