"""The instructor's state at a glance: the boat and its attitude, tanks, the sea, casualties.

``layouts`` has it on the instructor's screen, who alone sees true values; a gauge that is wrong
stands beside them. A drawing takes the model, and the columns and rows that there are; it returns
lines and changes nothing.
"""

from trainer.console.drawing.crew_orders import crew_line
from trainer.console.drawing.values import (
    NO_VALUE,
    angle_text,
    bell,
    course,
    no_value_reason,
    number,
    order_text,
)
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, first_fitting, fit, line

MOTION_COLUMNS = 27  # [columns] of what the boat does; the rest is what is ordered
TANK_LABELS = (
    ("main", ("forward", "mid", "aft")),
    ("neg", ("negative",)),
    ("trim", ("trim_forward", "trim_aft")),
    ("aux", ("auxiliary",)),
    ("dc", ("depth_control",)),
)
STATE_COLUMNS = 56  # [columns] of the state
SHALLOW_DEPTH_M = 15.0  # [m] of water over the sail, from which on up it is shown
GAUGE_ERROR_MARGIN = 0.5  # [m, deg, kn] of error above which a gauge is shown as wrong


def state(model: SessionModel, width: int, _height: int) -> Lines:
    """Return the state in ten lines."""
    room = width - MOTION_COLUMNS
    rows = [
        (reading(model, "depth", "diving", "m"), plane(model, "rudder", "steering", room)),
        (reading(model, "heading", "steering", ""), plane(model, "stern", "diving", room)),
        (reading(model, "speed", "engine", "kn"), plane(model, "bow", "diving", room)),
        (angle(model, "pitch"), engine(model, room)),
        (angle(model, "heel"), weight(model)),
    ]
    lines = [(*fit(left, MOTION_COLUMNS), *right) for left, right in rows]
    lines += [tanks(model, width), air(model), sea(model), casualty_names(model)]
    return [fit(each, width) for each in (*lines, crew_line(model, width))]


def interpolate(model: SessionModel, name: str) -> float | None:
    """Return a value of the gauges' channel, smoothed between ticks."""
    return model.picture.smooth(model.gauges, name, model.clock())


def pair(label: str, actual: str, ordered: str, unit: str) -> Line:
    """Return a value and what is ordered."""
    order_run = ("", "plain") if ordered == NO_VALUE else (f" > {ordered}", "ordered")
    return line((f" {label:<7}", "dim"), (f"{actual:>6}", "value"), order_run, (f" {unit}", "dim"))


def false(model: SessionModel, name: str) -> str:
    """Return the reading of a gauge that is wrong, "" for one that is right."""
    shown, true = model.picture.number("gauges", name), model.picture.number("motion", name)
    if shown is None or true is None:
        return ""
    apart = abs(shown - true)
    apart = min(apart, 360.0 - apart) if name == "heading" else apart
    return f"GAUGE {number(shown)}" if apart > GAUGE_ERROR_MARGIN else ""


def reading(model: SessionModel, name: str, channel: str, unit: str) -> Line:
    """Return a true value and its order: the autopilot's, else the crew's.

    A wrong gauge takes the order's place.
    """
    actual = interpolate(model, name)
    axis = "course" if name == "heading" else name
    wanted = model.picture.number(channel, f"ordered_{axis}")
    if wanted is None:
        wanted = model.picture.number("orders", axis)
    if name == "heading":
        shown = pair(name, course(actual, 1), course(wanted), unit)
    else:
        shown = pair(name, number(actual), number(wanted), unit)
    wrong = false(model, name)
    if not wrong:
        return shown
    choices = [(*shown[:2], (f"{gap}{wrong}", "warning")) for gap in ("  ", " ")]
    return first_fitting(MOTION_COLUMNS, *choices)


def angle(model: SessionModel, name: str) -> Line:
    """Return pitch or heel in words."""
    value = angle_text(name, interpolate(model, name))
    return line((f" {name:<7}", "dim"), (f"{value:>9}", "value"))


def plane(model: SessionModel, name: str, channel: str, room: int) -> Line:
    """Return a surface's angle, its order, and where there is room who orders it."""
    picture = model.picture
    actual = picture.smooth(channel, name, model.clock())
    shows = angle_text(name, actual)
    ordered = order_text(name, picture.number(channel, f"ordered_{name}"), shows)
    mode = picture.word(channel, f"{name}_mode") if actual is not None else "none"
    shown = line((f"{name:<7}", "dim"), (shows, "value"), (f" > {ordered}", "ordered"))
    by = line((f" {mode}", "warning" if mode == "hand" else "dim"))
    return first_fitting(room, (*shown, *by), shown)


def engine(model: SessionModel, room: int) -> Line:
    """Return bell or mode, and revolutions. Where room is short labels go, numbers stay."""
    picture = model.picture
    rung = bell(picture.word("engine", "bell"))
    mode_text = "auto" if picture.word("engine", "speed_mode") == "auto" else "turns"
    rpm, ordered = (picture.number("engine", name) for name in ("rpm", "ordered_rpm"))
    numbers = line((number(rpm, 0), "value"), (f" > {number(ordered, 0)}", "ordered"))
    labels = (
        line(("bell ", "dim"), (rung or mode_text, "value"), (" rpm ", "dim")),
        line((rung or mode_text, "value"), (" rpm ", "dim")),
        line(("rpm ", "dim")),
    )
    return first_fitting(room, *((*label, *numbers) for label in labels))


def weight(model: SessionModel) -> Line:
    """Return how heavy or light the boat is."""
    heavy = model.picture.number("motion", "heavy")
    if heavy is None:
        return line(("weight ", "dim"), NO_VALUE)
    side = "" if abs(heavy) < 0.05 else (" t heavy" if heavy > 0.0 else " t light")
    return line(("weight ", "dim"), (f"{abs(heavy):.1f}{side or ' t, in trim'}", "value"))


def tanks(model: SessionModel, room: int) -> Line:
    """Return how full the tanks are [%]. Where room is short the label goes."""
    if model.picture.number("tanks", "auxiliary") is None:
        return line(
            (" tanks  ", "dim"), no_value_reason(model.picture, "tanks", "this boat has none")
        )
    parts = []
    for says, names in TANK_LABELS:
        full = (number(model.picture.number("tanks", f"{name}_full"), 0) for name in names)
        shares_text = "/".join(full)
        parts += [(f" {says} ", "dim"), (shares_text, "plain")]
    shares = line(*parts, (" %", "dim"))
    return first_fitting(room, line((" tanks ", "dim"), *shares), shares)


def air(model: SessionModel) -> Line:
    """Return the pressures of the banks and what blows."""
    picture = model.picture
    if not picture.word("air", "main"):
        return line((" air    ", "dim"), no_value_reason(picture, "air", "this boat has none"))
    main, reserve = picture.number("air", "main"), picture.number("air", "emergency")
    blown = [
        name.removeprefix("blow_")
        for name in picture.rows("valves", "blow_")
        if picture.word("valves", name) != "shut"
    ]
    return line(
        (" air    ", "dim"),
        (f"main {number(main)}  emergency {number(reserve)} MPa", "plain"),
        (f"  BLOWING {' '.join(blown)}", "warning")
        if blown
        else (f"  compressor {picture.word('air', 'compressor')}", "dim"),
    )


def sea(model: SessionModel) -> Line:
    """Return the sea, and the ordered sea if it is another."""
    now, then = swell(model, ""), swell(model, "ordered_")
    order_text = "" if now == then else f" > {then}"
    carried = over_ground(model)
    now = now.replace(",", "") if carried else now  # both fit side by side
    return line(
        (" sea    ", "dim"),
        (now, "plain"),
        *over_sail(model),
        (carried, "plain"),
        (order_text, "ordered"),
    )


def over_ground(model: SessionModel) -> str:
    """Return set, drift [kn] and way over the ground, "" in still water."""
    picture = model.picture
    towards, way = (picture.number("current", name) for name in ("set", "course_over_ground"))
    if towards is None:
        return ""
    drift, speed = (picture.number("current", name) for name in ("drift", "speed_over_ground"))
    return f"; set {course(towards)} {number(drift)}; ground {course(way)} {number(speed)}"


def over_sail(model: SessionModel) -> Line:
    """Return the water over the sail while it is little: at periscope depth and above."""
    water = model.picture.number("sea", "over_sail")
    if water is None or water > SHALLOW_DEPTH_M:
        return ()
    if water < 0.0:
        return line((f"; sail {-water:.1f} m OUT", "warning"))
    return line((f"; {number(water)} m over sail", "plain"))


def swell(model: SessionModel, which: str) -> str:
    """Return a sea in words."""
    height, period, origin = (
        model.picture.number("sea", f"{which}{name}") for name in ("height", "period", "from")
    )
    if not height:
        return no_value_reason(model.picture, "sea", "calm")
    return f"{height:.1f} m, {number(period, 0)} s, from {course(origin)}"


def casualty_names(model: SessionModel) -> Line:
    """Return the names of the casualties."""
    picture = model.picture
    slots = [name for name in picture.rows("casualties", "casualty_") if name[-1].isdigit()]
    names = [
        f"{picture.word('casualties', name)} {picture.word('casualties', f'{name}_says')}".rstrip()
        for name in slots
    ]
    if not names:
        text = no_value_reason(model.picture, "casualties", "nothing; F4 lists what can be")
        return line((" broken ", "dim"), (text, "plain"))
    text = ", ".join(names)
    if len(text) > STATE_COLUMNS - len(" broken   "):
        text = ", ".join(picture.word("casualties", name) for name in slots)
    return line((" broken ", "dim"), (f" {text} ", "alarm"))
