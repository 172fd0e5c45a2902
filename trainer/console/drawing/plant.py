"""The plant in words and figures: oil, power and fire, and what moves each surface.

``layouts`` has the whole of it beside the gauges of ballast and instructor, where there are columns
for it, and a line of it on the panels of helm and planes.
"""

from typing import Final

from trainer.console.drawing.values import no_value_reason, number
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Run, fit, line

NAME_COLUMNS: Final = 7  # [columns]
LOW_OIL_MPA: Final = 16.0  # [MPa] below which oil is low, as the session's alert has it
SMOKE_PERCENT: Final = 5.0  # [%] likewise
SURFACE_NAMES: Final = ("rudder", "stern", "bow")


def told(model: SessionModel, field: str, says: str = "", *, usual: str = "") -> tuple[Run, ...]:
    """Return a word of the plant after its name, marked where unusual."""
    word = model.picture.word("plant", field) or "-"
    ink = "value" if word == usual or not usual else "warning"
    return (f" {says}", "dim"), (f" {word}", ink)


def oil(model: SessionModel, system: str, pumps: tuple[str, ...]) -> Line:
    """Return a system of oil: its pressure, its tank, its pumps."""
    picture = model.picture
    pressure = picture.number("plant", f"{system}_pressure")
    low = pressure is not None and pressure < LOW_OIL_MPA
    shut = picture.word("plant", f"{system}_oil") == "isolated"
    return line(
        (f" {system:<{NAME_COLUMNS - 1}}", "dim"),
        (f"{number(pressure):>5} MPa", "warning" if low else "value"),
        (f" {number(picture.number('plant', f'{system}_level'), 0):>3} L", "value"),
        *(run for pump in pumps for run in told(model, f"pump_{pump}", f"pump {pump}")),
        (" ISOLATED" if shut else "", "warning"),
    )


def bus(model: SessionModel, name: str) -> Line:
    """Return a bus: whether it is live, its load, its breaker."""
    load = number(model.picture.number("plant", f"{name}_load"), 0)
    runs = told(model, f"{name}_bus", usual="live")
    breaker = () if name == "dc" else told(model, f"{name}_breaker", "breaker", usual="shut")
    return line(
        (f" {name[:5]:<{NAME_COLUMNS - 2}}", "dim"), *runs, (f" {load:>3} kW", "value"), *breaker
    )


def fire(model: SessionModel) -> Line:
    """Return the smoke of each compartment, ventilation, and the party."""
    runs: list[Run] = [(" smoke", "dim")]
    for name in ("forward", "control", "aft"):
        smoke = model.picture.number("plant", f"smoke_{name}")
        seen = smoke is not None and smoke > SMOKE_PERCENT
        runs += [(f" {name}", "dim"), (f" {number(smoke, 0)} %", "alarm" if seen else "value")]
    return line(*runs)


def plant(model: SessionModel, width: int, height: int) -> Lines:
    """Return oil, buses, battery, smoke, and what moves each surface."""
    picture = model.picture
    if not picture.word("plant", "main_pressure"):
        text = no_value_reason(picture, "plant", "this boat has no plant")
        return [fit(line((f" {text}", "dim")), width)]
    left = picture.number("plant", "overload_left")
    heading = line(
        (" plant", "heading"),
        ("   charge ", "heading-dim"),
        (f"{number(picture.number('plant', 'charge'))} %", "heading-value"),
        (f"  OVERLOAD {number(left, 0)} s" if left is not None else "", "heading-warning"),
    )
    party = picture.word("plant", "party")
    lines = [
        fit(heading, width, "heading"),
        oil(model, "main", ("1", "2")),
        oil(model, "vital", ("vital",)),
        *(bus(model, name) for name in ("port", "starboard", "dc")),
        fire(model),
        line(
            *told(model, "tie", "tie", usual="open"),
            *told(model, "loads", "loads", usual="on"),
            *told(model, "ventilation", "ventilation", usual="running"),
        ),
        supply(model, "plant", SURFACE_NAMES),
        line(
            (
                f" dead {picture.word('plant', 'dead')}" if picture.word("plant", "dead") else "",
                "warning",
            ),
            (f" party {party}" if party else "", "good"),
        ),
    ]
    return [fit(each, width) for each in lines[:height]]


def supply(model: SessionModel, channel: str, surfaces: tuple[str, ...]) -> Line:
    """Return what moves some surfaces, nothing where it is not told."""
    picture, runs = model.picture, list[Run]()
    for name in surfaces:
        mode = picture.word(channel, f"{name}_supply")
        if not mode:
            continue
        coming = picture.word(channel, f"{name}_shifted_to")
        text = f" {mode} to {coming}" if coming else f" {mode}"
        runs += [
            (f" {name}", "dim"),
            (text, "value" if mode == "normal" and not coming else "warning"),
        ]
    return line(*runs)


def supply_rows(model: SessionModel, surfaces: tuple[str, ...], width: int) -> Lines:
    """Return the line of what moves surfaces; none without a plant."""
    pressures = [model.picture.number("supply", f"{name}_pressure") for name in ("main", "vital")]
    if pressures[0] is None:
        return []
    low = any(each is not None and each < LOW_OIL_MPA for each in pressures)
    shown = " / ".join(number(each) for each in pressures)
    runs = supply(model, "supply", surfaces)
    return [
        fit(line((" oil", "dim"), (f" {shown} MPa", "warning" if low else "value"), *runs), width)
    ]
