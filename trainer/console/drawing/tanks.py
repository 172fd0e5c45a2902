"""Tanks as bars, the air banks, and how the levers of the valves stand.

``layouts`` has them on the screens of ballast, diving officer and instructor. A drawing takes the
model, and the columns and rows that there are; it returns lines and changes nothing.
"""

from typing import Final

from trainer.console.drawing.values import no_value_reason, number
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, fit, line

TANK_LABELS: Final = (
    ("forward", "main forward"),
    ("mid", "main mid"),
    ("aft", "main aft"),
    ("negative", "negative"),
    ("trim_forward", "trim forward"),
    ("trim_aft", "trim aft"),
    ("auxiliary", "auxiliary"),
    ("depth_control", "depth control"),
)
MOVING_FIELDS: Final = {
    "trim_forward": "moving_trim",
    "auxiliary": "moving_auxiliary",
    "depth_control": "moving_depth_control",
}
FLOODED_FIELDS: Final = ("flood_forward", "flood_centre", "flood_aft")
BANK_LABELS: Final = (("main", "main bank"), ("emergency", "emergency"))
VALVE_NAMES: Final = ("forward", "mid", "aft", "negative")
NAME_COLUMNS: Final = 15  # [columns]
NUMBER_COLUMNS: Final = 21  # [columns] of the figures behind a bar


def bar(share: float | None, width: int) -> str:
    """Return a bar filled to a share [%]."""
    if share is None or width < 3:
        return ""
    filled = round(min(max(share, 0.0), 100.0) / 100.0 * (width - 2))
    return f"[{'█' * filled}{'·' * (width - 2 - filled)}]"


def levels(model: SessionModel, width: int, height: int) -> Lines:
    """Return the tanks, what is moved, and what has flooded."""
    picture = model.picture
    if not picture.word("tanks", "auxiliary"):
        text = no_value_reason(picture, "tanks", "this boat has no tanks")
        return [fit(line((f" {text}", "dim")), width)]
    lines = [fit(pumping_heading(model), width, "heading")]
    for name, says in TANK_LABELS:
        mass, share = picture.number("tanks", name), picture.number("tanks", f"{name}_full")
        if mass is None:
            continue
        room = max(width - NAME_COLUMNS - NUMBER_COLUMNS, 0)
        moving = picture.number("tanks", MOVING_FIELDS.get(name, "")) or 0.0
        text = f" {number(mass):>6} t {number(share, 0):>3} %"
        lines.append(
            line(
                (f" {says:<{NAME_COLUMNS - 1}}", "dim"),
                (bar(share, room), "ordered"),
                (text, "value"),
                (f" {moving:+.1f}" if moving else "", "warning"),
            )
        )
    lines.append(floodwater(model))
    return [fit(each, width) for each in lines[:height]]


def floodwater(model: SessionModel) -> Line:
    """Return what has come in where none belongs."""
    compartments = [
        f"{name.removeprefix('flood_')} {number(mass)} t"
        for name in FLOODED_FIELDS
        if (mass := model.picture.number("tanks", name))
    ]
    if not compartments:
        return line((" flooded        ", "dim"), "no compartment")
    return line((" FLOODED        ", "alarm"), (f" {', '.join(compartments)}", "warning"))


def pumping_heading(model: SessionModel) -> Line:
    """Return the heading: whether the boat hovers, and what is drained."""
    picture = model.picture
    drained = picture.word("tanks", "draining") or "nothing"
    return line(
        (" tanks", "heading"),
        ("   hover ", "heading-dim"),
        (picture.word("tanks", "hover") or "-", "heading-value"),
        ("  draining ", "heading-dim"),
        (drained, "heading-value"),
    )


def banks(model: SessionModel, width: int, height: int) -> Lines:
    """Return the air banks and the compressor."""
    picture = model.picture
    compressor = picture.word("air", "compressor") or "-"
    heading = line((" air", "heading"), (f"            compressor {compressor}", "heading-dim"))
    lines = [fit(heading, width, "heading")]
    for name, says in BANK_LABELS:
        pressure, share = picture.number("air", name), picture.number("air", f"{name}_full")
        if pressure is None:
            continue
        text = f" {number(pressure):>6} MPa {number(share, 0):>3} %"
        drawn = bar(share, max(width - NAME_COLUMNS - NUMBER_COLUMNS, 0))
        lines.append(
            line((f" {says:<{NAME_COLUMNS - 1}}", "dim"), (drawn, "ordered"), (text, "value"))
        )
    return [fit(each, width) for each in lines[:height]]


def fittings(model: SessionModel, width: int, height: int) -> Lines:
    """Return the valves above the air banks."""
    return [*valves(model, width, height), *banks(model, width, height)][:height]


def valves(model: SessionModel, width: int, height: int) -> Lines:
    """Return how the levers stand, a row for each group."""
    picture = model.picture
    lines = [fit(line((" valves         vent     blow", "heading")), width, "heading")]
    for name in VALVE_NAMES:
        vent, blow = (picture.word("valves", f"{what}_{name}") for what in ("vent", "blow"))
        lines.append(line((f" {name:<{NAME_COLUMNS - 1}}", "dim"), *lever(vent), *lever(blow)))
    flood = picture.word("valves", "negative_flood")
    lines.append(line((" negative flood ", "dim"), *lever(flood)))
    return [fit(each, width) for each in lines[:height]]


def lever(stands: str) -> Line:
    """Return how a lever stands: what is open in capitals."""
    if stands in ("", "shut"):
        return line((f"{stands or '-':<9}", "dim"))
    return line((f"{stands.upper():<9}", "warning"))
