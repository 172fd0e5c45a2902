"""Values in words and signs, as a control room says them.

Every drawing words its values by them, so that one value reads alike in all places.
"""

from typing import Final

from trainer.console.readings import ChannelReadings
from trainer.io.sides import ANGLE_SIDES, sided

NO_VALUE: Final = "-"
SHORT_BELLS: Final = {"one-third": "1/3", "two-thirds": "2/3", "standard": "std"}


def number(value: float | None, decimals: int = 1, sign: str = "-") -> str:
    """Return a number with its decimals, a dash for none; never a negative zero."""
    if value is None:
        return NO_VALUE
    return f"{round(value, decimals) + 0.0:{sign}.{decimals}f}"


def no_value_reason(picture: ChannelReadings, channel: str, says: str) -> str:
    """Return why there is no value: the boat has none, or a dash."""
    return says if channel in picture.last else NO_VALUE


def course(value: float | None, decimals: int = 0) -> str:
    """Return a course with three digits before the point."""
    if value is None:
        return NO_VALUE
    turned = round(value, decimals) % 360.0
    return f"{turned:0{3 if not decimals else 4 + decimals}.{decimals}f}"


def angle_text(name: str, value: float | None) -> str:
    """Return an angle with its side, such as 15.0 right."""
    return NO_VALUE if value is None else sided(value, ANGLE_SIDES[name])


def order_text(name: str, ordered: float | None, actual: str) -> str:
    """Return an ordered angle beside the ``actual`` one, with its side where that differs."""
    size, _, side = angle_text(name, ordered).partition(" ")
    return size if actual.endswith(side) else f"{size} {side}"


def bell(given: str) -> str:
    """Return a bell in few letters: ahead std, astern full, stop."""
    way, _, rest = given.partition("-")
    if way not in ("ahead", "astern"):
        return given
    return f"{way} {SHORT_BELLS.get(rest, rest)}"
