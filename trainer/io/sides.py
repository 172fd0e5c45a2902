"""Angles with their side, as a control room says them: 6.0 dive, 10.0 left.

Consoles, panels in words and casualties word their angles by it. A sign is for charts and programs
alone, because nobody at a lever knows which way is positive.
"""

from collections.abc import Mapping
from typing import Final

SURFACE_SIDES: Final[Mapping[str, tuple[str, str]]] = {  # positive, negative
    "rudder": ("right", "left"),
    "stern": ("rise", "dive"),
    "bow": ("rise", "dive"),
}
ANGLE_SIDES: Final[Mapping[str, tuple[str, str]]] = {
    **SURFACE_SIDES,
    "pitch": ("up", "down"),
    "heel": ("stbd", "port"),
}


def sided(value: float, sides: tuple[str, str], decimals: int = 1, unit: str = "") -> str:
    """Return a size and its side; what is written as zero has none.

    ``sides`` are the words of a positive and of a negative value; ``unit`` stands before them.
    """
    size = round(abs(value), decimals)
    side = sides[value < 0.0] if size else ""
    return " ".join(filter(None, (f"{size:.{decimals}f}", unit, side)))
