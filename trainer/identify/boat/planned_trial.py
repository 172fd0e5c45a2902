"""A planned trial as an exercise for a crew, and as a page."""

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from trainer.config.exercise.exercise import ORDER_ROWS, parse_exercise
from trainer.config.files import ConfigError
from trainer.identify.boat.motion import STATE
from trainer.identify.boat.plan import PlannedFigure, TrialPlan
from trainer.identify.boat.trial_legs import START_COURSE_RAD, room_of
from trainer.identify.experiment import exercise_lines
from trainer.report.text import ascii_text, titled_table, wrap
from trainer.units import KNOT

MAX_NAME: Final = 55  # letters of an exercise's name
FIGURE_HEADS: Final = ("", "of the prior", "sd", "plain 20/20", "this trial", "left")
SURE_NOTE: Final = (
    "sd: expected standard deviations, of the boat as the prior has it and by slopes there. left: "
    "share of the sd before."
)
RECORD_NOTE: Final = (
    "Record surfaces as they stand, revolutions, log, heading, pitch, roll and depth, every "
    "{interval:.2g} s or oftener."
)
ORDERS_NOTE: Final = (
    "The times below are those of the boat as it is known; at sea the angles of the list count."
)


def exercise_text(plan: TrialPlan, path: Path) -> str:
    """Return a plan as an exercise file for ``path``.

    ConfigError if it has too many orders.
    """
    vessel, orders = plan.prior.vessel, plan.sailed.orders
    if len(orders) > ORDER_ROWS.most:
        raise ConfigError(
            f"{len(orders)} orders, and an exercise has {ORDER_ROWS.most} at most: give fewer "
            "--minutes, and sail the trial again"
        )
    briefing = [*_leg_lines(plan), RECORD_NOTE.format(interval=plan.sailed.trial.interval)]
    heads = {
        "name": f"Trial of {vessel.file.name}"[:MAX_NAME],
        "briefing": "\n".join(briefing),
        "vessel": os.path.relpath(vessel.file.path.resolve(), path.resolve().parent),
        "duration_s": round(len(plan.sailed.legs) * plan.sailed.seconds, 2),
    }
    start = {
        "speed_kn": round(vessel.speed / KNOT, 3),
        "depth_m": round(plan.waters.depth, 1),
        "course_deg": math.degrees(START_COURSE_RAD),
    }
    limits = {
        "depth_m_min": round(plan.waters.shallowest, 1),
        "depth_m_max": round(plan.waters.deepest, 1),
    }
    lines = ["# What to sail next, by `trainer boat plan-trial`.", f"# {ORDERS_NOTE}", ""]
    lines += exercise_lines(heads, {"initial": start, "limits": limits}, orders)
    text = "\n".join(lines) + "\n"
    parse_exercise(text, path)
    return text


def _leg_lines(plan: TrialPlan) -> Iterator[str]:
    """Yield what the crew does, leg by leg."""
    seconds = plan.sailed.seconds
    for number, leg in enumerate(plan.sailed.legs):
        yield f"From {number * seconds:.0f} s: {leg.name}: {leg.words}."
    yield "Between them keep course and depth."


def render_plan(plan: TrialPlan) -> str:
    """Return the page for a terminal."""
    waters, states = plan.waters, plan.sailed.states
    lines = [ascii_text(f"WHAT TO SAIL NEXT: {plan.prior.vessel.file.name}"), ""]
    for line in _leg_lines(plan):
        lines += wrap(line)
    depths = states[:, STATE.Z]
    room = "any room" if math.isinf(waters.room) else f"{waters.room:.0f} m of room"
    lines += wrap(
        f"It needs {room_of(plan.sailed):.0f} m of room and goes from {depths.min():.0f} to "
        f"{depths.max():.0f} m deep; allowed: {room}, {waters.shallowest:.0f} to "
        f"{waters.deepest:.0f} m."
    )
    lines += wrap(RECORD_NOTE.format(interval=plan.sailed.trial.interval))
    lines += titled_table("FIGURES", FIGURE_HEADS, map(_figure_row, plan.figures))
    return "\n".join([*lines, *wrap(SURE_NOTE)])


def _figure_row(row: PlannedFigure) -> tuple[str, ...]:
    """Return a figure with its deviations as cells."""
    factor, unit = (math.degrees(1.0), "deg") if row.unit == "rad" else (1.0, row.unit)
    numbers = (row.value, row.before, row.plain, row.planned)
    cells = [f"{factor * number:.3g}" for number in numbers]
    left = f"{row.planned / row.before:.2f}" if row.before > 0.0 else "-"
    return (f"{row.name} [{unit}]", *cells, left)
