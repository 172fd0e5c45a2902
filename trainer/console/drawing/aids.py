"""What is ahead: ghost, predictor and safe depth in words, and the way for charts.

``panels`` and ``chart`` place them. While the aids are off there is nothing of them to draw.
"""

from collections.abc import Sequence
from typing import Final

from trainer.console.drawing.crew_orders import depth_text, depth_unit
from trainer.console.drawing.values import angle_text, course
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Run, fit, length, line

DANGER_NAMES: Final = ("jam", "flooding")
WAY_FIELDS: Final = ("depth", "heading", "pitch")  # of a point, after its seconds


def aid_rows(model: SessionModel, width: int) -> Lines:
    """Return the texts of both aids, in one row if that fits."""
    parts = [part for part in (ghost_text(model), ahead_text(model)) if part]
    joined = tuple(run for part in parts for run in part)
    return [joined] if joined and length(joined) <= width else parts


def ghost_text(model: SessionModel) -> Line:
    """Return how far off the ghost the boat is, () without one."""
    number = model.picture.number
    depth, heading = number("ghost", "depth_off"), number("ghost", "heading_off")
    if depth is None or heading is None:
        return ()
    way = "deeper" if depth > 0.0 else "higher"
    side = "right" if heading > 0.0 else "left"
    pitch = angle_text("pitch", number("ghost", "pitch_off"))
    off = f"{depth_text(model, abs(depth))} {depth_unit(model)} {way}, {abs(heading):.1f} {side}"
    return line((" off the ghost ", "dim"), (f"{off}, {pitch} ", "plain"))


def ahead_text(model: SessionModel) -> Line:
    """Return what the gauges will read, () without a predictor."""
    number = model.picture.number
    seconds, depth = number("predictor", "seconds"), number("predictor", "depth")
    if seconds is None or depth is None:
        return ()
    parts: tuple[Run, ...] = (
        (f" in {seconds:.0f} s ", "dim"),
        (f"{depth_text(model, depth)} {depth_unit(model)} ", "plain"),
        (f"{course(number('predictor', 'heading'))} ", "plain"),
        (angle_text("pitch", number("predictor", "pitch")), "plain"),
    )
    return line(*parts)


def safe_rows(model: SessionModel, width: int) -> Lines:
    """Return how deep a jam or a flooding would take the boat now."""
    number = model.picture.number
    test = number("safe", "test")
    told = [(name, number("safe", name)) for name in DANGER_NAMES]
    runs: list[Run] = []
    for name, depth in told:
        if depth is not None and test is not None:
            ink = "value" if depth <= test else "warning"
            runs += [(f" {name} to", "dim"), (f" {depth_text(model, depth)}", ink)]
    tail = (f" {depth_unit(model)}, safe to {depth_text(model, test)} ", "dim")
    return [fit(line((" now a", "dim"), *runs, tail), width)] if runs else []


def way_ahead(model: SessionModel, name: str) -> Sequence[tuple[float, float]]:
    """Return times [s] from now and values of a quantity to come."""
    if name not in WAY_FIELDS:
        return []
    column = 1 + WAY_FIELDS.index(name)
    rows = [point.split(":") for point in model.picture.word("predictor", "way").split(";")]
    try:
        return [(float(row[0]), float(row[column])) for row in rows if len(row) > column]
    except ValueError:
        return []


def interpolated_way(way: Sequence[tuple[float, float]], count: int) -> list[float]:
    """Return so many values of a way ahead, evenly spaced to its end."""
    values = []
    for number in range(1, count + 1):
        when = way[-1][0] * number / count
        index = next(k for k, (seconds, _) in enumerate(way) if seconds >= when - 1e-9)
        (t1, v1), (t0, v0) = way[index], way[index - 1] if index else way[index]
        values.append(v1 if t1 == t0 else v0 + (v1 - v0) * (when - t0) / (t1 - t0))
    return values
