"""Values in words and signs, as a control room says them.

Every drawing words its values by them, so that one value reads alike in all places.
"""

from typing import Final

from trainer.console.readings import ChannelReadings

NO_VALUE: Final = "-"
SIDE_LETTERS: Final = {"rudder": "LR", "stern": "DR", "bow": "DR"}  # negative, positive
ZERO_ANGLE_DEG: Final = 0.05  # [deg] less is zero, on no side
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


def surface(name: str, angle: float | None) -> str:
    """Return the angle of a surface with its side, such as R15.0."""
    if angle is None:
        return NO_VALUE
    side = " " if abs(angle) < ZERO_ANGLE_DEG else SIDE_LETTERS[name][angle > 0.0]
    return f"{side}{abs(angle):4.1f}"


def attitude(value: float | None, positive: str, negative: str) -> str:
    """Return an angle of the boat with its side in words."""
    if value is None:
        return NO_VALUE
    side = "" if abs(value) < ZERO_ANGLE_DEG else f" {positive if value > 0.0 else negative}"
    return f"{abs(value):.1f}{side}"


def bell(given: str) -> str:
    """Return a bell in few letters: ahead std, astern full, stop."""
    way, _, rest = given.partition("-")
    if way not in ("ahead", "astern"):
        return given
    return f"{way} {SHORT_BELLS.get(rest, rest)}"
