"""The instruments of the stations: large numbers, scales of surfaces, the engine telegraph.

``panels`` puts them together for each station. A drawing takes the model, and the columns and rows
that there are; it returns lines and changes nothing.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from trainer.console.drawing.crew_orders import depth_text, depth_unit, order_beside, pitch_beside
from trainer.console.drawing.gauges import interpolate
from trainer.console.drawing.values import (
    SHORT_BELLS,
    angle_text,
    course,
    no_value_reason,
    number,
    order_text,
)
from trainer.console.keys import TELEGRAPH_KEYS, OrderAction
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Run, fit, length, line
from trainer.io.sides import SURFACE_SIDES

LARGE_DIGITS: Final = {
    "0": ("┏━┓", "┃ ┃", "┗━┛"),
    "1": (" ╻ ", " ┃ ", " ╹ "),
    "2": ("╺━┓", "┏━┛", "┗━╸"),
    "3": ("╺━┓", "╺━┫", "╺━┛"),
    "4": ("╻ ╻", "┗━┫", "  ╹"),
    "5": ("┏━╸", "┗━┓", "╺━┛"),
    "6": ("┏━╸", "┣━┓", "┗━┛"),
    "7": ("╺━┓", "  ┃", "  ╹"),
    "8": ("┏━┓", "┣━┫", "┗━┛"),
    "9": ("┏━┓", "┗━┫", "╺━┛"),
    ".": (" ", " ", "▪"),
    "-": ("   ", "╺━╸", "   "),
}
SCALE_END_DEG: Final = 35.0  # [deg] at the ends
AHEAD_BELLS: Final = ("one-third", "two-thirds", "standard", "full", "flank")
ASTERN_BELLS: Final = ("full", "two-thirds", "one-third")
GAP_SIGN: Final = "╌"  # between where a surface is and its order
MIN_SCALE_COLUMNS: Final = 24  # [columns] of a scale
RATE_SPAN: Final = 10.0  # [s] over which a change of depth is taken
BELL_KEYS: Final = {
    key.act.words.removeprefix("bell "): key.label
    for key in TELEGRAPH_KEYS
    if isinstance(key.act, OrderAction)
}


def large(text: str) -> tuple[str, str, str]:
    """Return a number in three lines."""
    drawn = [LARGE_DIGITS.get(character, ("", "", "")) for character in text]
    upper, middle, lower = (" ".join(rows[i] for rows in drawn) for i in range(3))
    return upper, middle, lower


class Gauge(NamedTuple):
    """An instrument's name, its value, its unit, and the ordered value."""

    axis: str  # of the order
    label: str
    text: str
    unit: str
    automatic: str  # what the autopilot keeps, "" for nothing
    rate: str = ""  # how it changes


def dial(model: SessionModel, gauge: Gauge, room: int) -> Lines:
    """Return a large number with its label, and what is ordered below it."""
    rows = large(gauge.text)
    if len(rows[0]) >= room:  # half a digit is another
        rows = "", gauge.text, ""
    name, unit, rate = f" {gauge.label}", f"  {gauge.unit}", f"  {gauge.rate}"
    if len(name + unit + rate) > room:  # a rate without its side says too little
        rate = ""
    return [
        line((name, "heading"), (unit + rate, "heading-dim")),
        *(line((f" {row}", "value")) for row in rows),
        order_beside(model, gauge.axis, gauge.automatic, room),
    ]


def small_dial(model: SessionModel, gauge: Gauge, width: int) -> Line:
    """Return an instrument in one row."""
    shown = line(
        (f" {gauge.label:<8}", "dim"), (f"{gauge.text:>6}", "value"), (f" {gauge.unit:<4}", "dim")
    )
    return fit(
        (*shown, *order_beside(model, gauge.axis, gauge.automatic, width - length(shown))), width
    )


def dials(model: SessionModel, gauges: Sequence[Gauge], width: int) -> Lines:
    """Return large numbers beside each other."""
    room = width // max(len(gauges), 1)
    return side_by_side([dial(model, gauge, room) for gauge in gauges], width)


def side_by_side(dials: list[Lines], width: int) -> Lines:
    """Return drawings beside each other, as many as there is room for."""
    room = width // max(len(dials), 1)
    rows = max(map(len, dials))
    return [
        fit(
            tuple(
                run
                for drawn in dials
                for run in fit(
                    drawn[row] if row < len(drawn) else line(), room, "plain" if row else "heading"
                )
            ),
            width,
            "plain" if row else "heading",
        )
        for row in range(rows)
    ]


def depth_gauge(model: SessionModel) -> Gauge:
    """Return the depth gauge."""
    ordered = model.picture.number("diving", "ordered_depth")
    ordered_text = "" if ordered is None else depth_text(model, ordered)
    shown = depth_text(model, interpolate(model, "depth"))
    return Gauge("depth", "depth", shown, depth_unit(model), ordered_text, depth_rate(model))


def depth_rate(model: SessionModel) -> str:
    """Return how fast the depth gauge sinks or rises, by its chart."""
    names = [each.name for each in model.quantities]
    if "depth" not in names:
        return ""
    shown = model.charts.trace.series(names.index("depth"), RATE_SPAN, 2)
    first, last = (None if each is None else each.actual for each in shown)
    if first is None or last is None:
        return ""
    rate = (last - first) / RATE_SPAN
    return f"{abs(rate):.2f} m/s {'down' if rate > 0.0 else 'up'}" if abs(rate) >= 0.005 else ""


def compass(model: SessionModel) -> Gauge:
    """Return the compass."""
    ordered = model.picture.number("steering", "ordered_course")
    ordered_text = "" if ordered is None else course(ordered)
    shown = course(interpolate(model, "heading"), 1)
    return Gauge("course", "heading", shown, "deg", ordered_text, rate_of_turn(model))


def rate_of_turn(model: SessionModel) -> str:
    """Return how fast the boat turns by its own gyro, "" at stations without."""
    turn = model.picture.number("steering", "turn_rate")
    if turn is None or abs(turn) < 0.05:
        return ""
    return f"{abs(turn):.1f} deg/s {'right' if turn > 0.0 else 'left'}"


def speed_log(model: SessionModel) -> Gauge:
    """Return the log, which shows the speed through the water."""
    ordered = model.picture.number("engine", "ordered_speed")
    ordered_text = "" if ordered is None else number(ordered)
    return Gauge("speed", "speed", number(interpolate(model, "speed")), "kn", ordered_text)


def angles(model: SessionModel, width: int) -> Line:
    """Return pitch and heel in words, the echo sounder, and the ordered pitch."""
    sounding = model.picture.number("diving", "sounding")
    echo = "" if sounding is None else f"{sounding:.1f} m  "
    shown = line(
        (" pitch ", "dim"),
        (f"{angle_text('pitch', interpolate(model, 'pitch')):<11}", "value"),
        ("heel ", "dim"),
        (f"{angle_text('heel', interpolate(model, 'heel')):<9}", "value"),
        ("sounder " if echo else "", "dim"),
        (echo, "value"),
    )
    return (*shown, *pitch_beside(model, width - length(shown)))


def scale(model: SessionModel, name: str, channel: str, width: int) -> Line:
    """Return a surface on its scale. A block is where it is, a diamond is the order.

    Dots of the order's ink lie between them.
    """
    picture = model.picture
    actual = picture.smooth(channel, name, model.clock())
    ordered = picture.number(channel, f"ordered_{name}")
    if actual is None:
        lacking = no_value_reason(picture, channel, "this boat has none")
        return line((f" {name:<7}", "dim"), (lacking, "dim"))
    right, left_word = SURFACE_SIDES[name]
    mode, shows = picture.word(channel, f"{name}_mode"), angle_text(name, actual)
    ends = line((f" {name:<7}{left_word} ", "dim")), line((f" {right}  ", "dim"))
    marks_line = line(
        (f"{shows:>10}", "value"),
        (f" > {order_text(name, ordered, shows):<10}", "ordered"),
        (f" {mode:<4} ", "warning" if mode == "hand" else "dim"),
    )
    room = width - sum(len(text) for part in (*ends, marks_line) for text, _ in part)
    drawn = marks(actual, ordered, room) if room >= MIN_SCALE_COLUMNS // 2 else ()
    return (*ends[0], *drawn, *ends[1], *marks_line)


def marks(actual: float, ordered: float | None, room: int) -> tuple[Run, ...]:
    """Return the scale itself in ``room`` columns."""

    def column(angle: float) -> int:
        share = (min(max(angle, -SCALE_END_DEG), SCALE_END_DEG) + SCALE_END_DEG) / (
            2.0 * SCALE_END_DEG
        )
        return round(share * (room - 1))

    middle, block = column(0.0), column(actual)
    signs = ["·"] * room
    for x in range(min(middle, block), max(middle, block) + 1):
        signs[x] = "━"
    signs[middle], signs[block] = "┼", "█"
    inks = ["value" if sign in "━█" else "dim" for sign in signs]
    if ordered is not None:
        for x in range(min(block, column(ordered)), max(block, column(ordered)) + 1):
            if signs[x] == "·":
                signs[x], inks[x] = GAP_SIGN, "ordered"
        signs[column(ordered)], inks[column(ordered)] = "◆", "ordered"
    return tuple(zip(signs, inks, strict=True))


def telegraph(model: SessionModel, width: int) -> Lines:
    """Return the engine telegraph, the bell that is rung in brackets, and the revolutions."""
    picture = model.picture
    rung = picture.word("engine", "bell")
    parts: list[Run] = [(" astern ", "dim")]
    for way, bells in (("astern", ASTERN_BELLS), ("", ("stop",)), ("ahead", AHEAD_BELLS)):
        parts += [("ahead ", "dim")] if way == "ahead" else []
        for name in bells:
            here = rung == (f"{way}-{name}" if way else name)
            says = SHORT_BELLS.get(name, name)
            parts.append((BELL_KEYS[f"{way} {name}".strip()], "key"))
            parts.append((f"[{says}]" if here else f" {says} ", "chosen" if here else "plain"))
    rpm, ordered = (picture.number("engine", name) for name in ("rpm", "ordered_rpm"))
    speed_text = (
        "speed kept automatically" if picture.word("engine", "speed_mode") == "auto" else ""
    )
    turns = line(
        (" rpm ", "dim"),
        (number(rpm, 0), "value"),
        (f" > {number(ordered, 0)}  ", "ordered"),
        (speed_text or bells_in_knots(model), "dim"),
    )
    return [fit(tuple(parts), width), fit(turns, width)]


def bells_in_knots(model: SessionModel) -> str:
    """Return the turns of the bells [kn], which the session has sent."""
    ranges, texts = model.vessel.ranges, []
    for way, bells in (("ahead", AHEAD_BELLS), ("astern", ASTERN_BELLS[::-1])):
        turns = [ranges[f"{way} {name}"] for name in bells if f"{way} {name}" in ranges]
        texts += [f"{way} {'/'.join(f'{abs(each):g}' for each in turns)}"] * bool(turns)
    return f"kn: {', '.join(texts)}" if texts else ""
