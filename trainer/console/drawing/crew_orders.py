"""Orders to the crew beside the instruments, with the distance to what is ordered.

Helm and planes are worked by these orders, so each instrument has its own beside it. ``dials``,
``gauges``, ``chart`` and ``panels`` place them. An order is marked NEW until the crew has repeated
it.
"""

from collections.abc import Sequence
from typing import Final

from trainer.console.drawing.values import course
from trainer.console.model import SessionModel
from trainer.console.pane import Line, fit, line
from trainer.units import FOOT

ORDERS_CHANNEL: Final = "orders"
TENTHS_BELOW: Final = 3.0  # [m], [deg] to go, below which tenths count
REACHED_MARGIN: Final = 0.5  # [deg, m] closer than this is there
REACHED_MARGIN_FT: Final = 1.5  # [ft]
REACHED_MARGIN_KN: Final = 0.15  # [kn]
SETTLED_DEPTH_M: Final = 3.0  # [m] closer than this the ordered angle has come off
PITCH_ORDER_TIME_S: Final = 10.0  # [s] after an order for depth, in which an angle belongs to it
REPEAT_HINT: Final = "Enter repeats it"
REPEAT_FIRST_HINT: Final = "Enter repeats the first"


def in_feet(model: SessionModel) -> bool:
    """Return whether depths are said in feet, as the last order was."""
    return model.picture.word(ORDERS_CHANNEL, "depth_unit") == "ft"


def depth_text(model: SessionModel, metres: float | None) -> str:
    """Return a depth on the gauge, in the unit of the order."""
    if metres is None:
        return "-"
    return f"{round(metres / FOOT) + 0.0:.0f}" if in_feet(model) else f"{metres + 0.0:.1f}"


def depth_unit(model: SessionModel) -> str:
    """Return the unit of depths."""
    return "ft" if in_feet(model) else "m"


def short_number(value: float) -> str:
    """Return a number with as few digits as it needs, one decimal at most."""
    return f"{round(value, 1) + 0.0:g}"


def to_go(error: float) -> str:
    """Return how far it is, in tenths where that is little."""
    return f"{abs(error):.1f}" if abs(error) < TENTHS_BELOW else f"{abs(error):.0f}"


def course_order(model: SessionModel) -> tuple[str, str]:
    """Return the ordered course with its error, in full and in few words. "" for none."""
    ordered, error = _pair(model, "course")
    if ordered is None:
        return "", ""
    text = course(ordered)
    if error is None or abs(error) < REACHED_MARGIN:
        return _both(text, "" if error is None else ", on course")
    side = "right" if error > 0.0 else "left"
    return f"{text}, {to_go(error)} to the {side}", f"{text}, {to_go(error)} {side}"


def depth_order(model: SessionModel) -> tuple[str, str]:
    """Return the ordered depth with its error."""
    ordered, error = _pair(model, "depth")
    if ordered is None:
        return "", ""
    unit, size = ("ft", FOOT) if in_feet(model) else ("m", 1.0)
    feet = unit == "ft"
    text = f"{round(ordered / size)} ft" if feet else f"{short_number(ordered)} m"
    reached = REACHED_MARGIN_FT if feet else REACHED_MARGIN
    if error is None or abs(error / size) < reached:
        return _both(text, "" if error is None else ", at depth")
    way = "deeper" if error > 0.0 else "higher"
    return _both(text, f", {to_go(error / size)} {way}")


def speed_order(model: SessionModel) -> tuple[str, str]:
    """Return the ordered speed with its error."""
    ordered, error = _pair(model, "speed")
    if ordered is None:
        return "", ""
    text = f"{short_number(ordered)} kn"
    if error is None or abs(error) < REACHED_MARGIN_KN:
        return _both(text, "" if error is None else ", at speed")
    return _both(text, f", {abs(error):.1f} {'faster' if error > 0.0 else 'slower'}")


def has_come_off(model: SessionModel) -> bool:
    """Return whether the boat has reached the depth to which the ordered angle led.

    An angle ordered more than PITCH_ORDER_TIME_S after the depth is an order of its own.
    """
    number = model.picture.number
    ordered, error = _pair(model, "depth")
    later = (number(ORDERS_CHANNEL, "depth_since") or 0.0) - (
        number(ORDERS_CHANNEL, "pitch_since") or 0.0
    )
    return (
        ordered is not None and later <= PITCH_ORDER_TIME_S and abs(error or 0.0) < SETTLED_DEPTH_M
    )


def pitch_order(model: SessionModel) -> tuple[str, str]:
    """Return the ordered pitch with its error, which is none once its depth is reached."""
    ordered, error = _pair(model, "pitch")
    if ordered is None:
        return "", ""
    text = "zero" if abs(ordered) < 0.05 else f"{short_number(abs(ordered))} {_way(ordered)}"
    if ordered and has_come_off(model):
        return _both(text, ", at depth")
    if error is None or abs(error) < REACHED_MARGIN:
        return _both(text, "" if error is None else ", on it")
    return (f"{text}, {to_go(error)} to go {_way(error)}", f"{text}, {to_go(error)} {_way(error)}")


def _pair(model: SessionModel, axis: str) -> tuple[float | None, float | None]:
    """Return what is ordered on an axis, and how far it is to go."""
    number = model.picture.number
    return number(ORDERS_CHANNEL, axis), number(ORDERS_CHANNEL, f"{axis}_error")


def _both(told: str, error: str) -> tuple[str, str]:
    return f"{told}{error}", f"{told}{error}"


def _way(pitch: float) -> str:
    return "up" if pitch > 0.0 else "down"


AXIS_TEXTS: Final = {
    "course": course_order,
    "depth": depth_order,
    "speed": speed_order,
    "pitch": pitch_order,
}


def order_beside(model: SessionModel, axis: str, automatic: str, room: int) -> Line:
    """Return what is ordered beside an instrument of ``room`` columns, blue; NEW until repeated.

    Without an order to the crew it is what the autopilot keeps, "" for nothing.
    """
    texts = AXIS_TEXTS[axis](model)
    if not texts[0]:
        return line((f" ordered {automatic}" if automatic else "", "ordered"))
    if model.crew.awaits(axis, model.role):
        return line((f" NEW: {texts[0] if len(texts[0]) + 6 < room else texts[1]}", "new"))
    for text in (f" ordered {texts[0]}", f" ordered {texts[1]}", f" {texts[1]}"):
        if len(text) < room:
            return line((text, "ordered"))
    return line((f" {texts[1]}", "ordered"))


def order_line(model: SessionModel, width: int) -> Line:
    """Return the new orders until they are repeated, newest first; else the last words."""
    crew = model.crew
    if model.picture.word("time", "shown") == "yes":
        return fit(line((f" {told_words(model)}", "good")), width)
    if crew.wrong:
        return fit(line((f" REPEATED WRONG: {crew.wrong} ", "warning")), width)
    new = crew.all_to_repeat(model.role)
    if len(new) > 1:
        says = " | ".join(each.says for each in new)
        return fit(
            line((f" NEW ORDERS  {says} ", "new"), (f"  {REPEAT_FIRST_HINT}", "key")), width, "bar"
        )
    if new:
        says = new[0].says
        return fit(line((f" NEW ORDER  {says} ", "new"), (f"  {REPEAT_HINT}", "key")), width, "bar")
    words = "" if model.exercise.step.text else told_words(model)
    return fit(line((f" told: {words}" if words else "", "ordered")), width)


def told_words(model: SessionModel) -> str:
    """Return the last order in words, with the commas that only its fact has."""
    words = model.picture.word(ORDERS_CHANNEL, "told")
    return model.crew.told if len(model.crew.told) == len(words) else words


def crew_line(model: SessionModel, width: int) -> Line:
    """Return the crew's orders and the distance to each, for the instructor."""
    label = line((" crew   ", "dim"))
    new = model.crew.oldest
    if new:
        waits = max(model.picture.seconds - new.seconds, 0.0)
        return (*label, (f"NEW {new.says}, not repeated for {waits:.0f} s ", "warning"))
    order_texts = [order(model) for order in AXIS_TEXTS.values()]
    words = told_words(model)
    for text in (
        _joined([each[0] for each in order_texts]),
        _joined([each[1] for each in order_texts]),
    ):
        if text and len(text) + len(" crew   ") <= width:
            return (*label, (text, "ordered"))
    # all orders with their errors by sign, where words have no room
    size = FOOT if in_feet(model) else 1.0
    parts = []
    for axis in AXIS_TEXTS:
        ordered, error = _pair(model, axis)
        if ordered is not None:
            done = error is None or (axis == "pitch" and ordered and has_come_off(model))
            to_go = 0.0 if done else (error or 0.0) / (size if axis == "depth" else 1.0)
            parts.append(f"{AXIS_TEXTS[axis](model)[1].partition(',')[0]} {to_go:+.0f}")
    signed = "; ".join(parts)
    if signed:
        return (*label, (signed, "ordered"))
    return (*label, (f"told: {words}", "ordered") if words else ("no orders", "dim"))


def _joined(texts: Sequence[str]) -> str:
    return "; ".join(text for text in texts if text)


def pitch_beside(model: SessionModel, room: int) -> Line:
    """Return the ordered pitch, nothing where none stands."""
    full, few = pitch_order(model)
    if not full:
        return line()
    mark = "NEW: " if model.crew.awaits("pitch", model.role) else "ordered "
    text = f"  {mark}{full if len(full) + len(mark) + 2 <= room else few}"
    return line((text, "new" if mark == "NEW: " else "ordered"))
