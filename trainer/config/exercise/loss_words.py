"""What loses an exercise, in words: ``depth > 160`` is "deeper than 160 m".

It knows the conditions of ``derived`` by their text alone, because a console loads no numbers.
"""

import re
from collections.abc import Mapping
from typing import Final

# quantity and unit, side, number, unit
LOSS_PATTERN: Final = re.compile(
    r"([a-z][a-z_]*?)(?:_(kn|m_s|m|ft|deg|s|min))?\s*([<>])=?\s*([-+.\de]+)\s*(\S*)", re.IGNORECASE
)
HELD_PATTERN: Final = re.compile(r"(.*\S)\s+for\s+([\d.]+)\s*s")
AND_PATTERN: Final = re.compile(r"\s+and\s+")
FIRST_UNITS: Final[Mapping[str, str]] = {  # of a condition that names none
    "depth": "m",
    "clearance": "m",
    "showing": "m",
    "speed": "kn",
    "speed_over_ground": "kn",
    "pitch": "deg",
    "heel": "deg",
    "time": "s",
}
LOSS_WORDS: Final[Mapping[str, str]] = {
    "depth>": "deeper than {}",
    "depth<": "shallower than {}",
    "speed>": "faster than {}",
    "speed<": "slower than {}",
    "time>": "after {}",
    "time<": "before {}",
    "clearance<": "less than {} of water under the keel",
}
SIDE_WORDS: Final[Mapping[str, str]] = {">": "more than", "<": "less than"}


def word_loss(text: str) -> str:
    """Return a condition that loses an exercise in words, all before a comma."""
    text, comma, cause = text.partition(",")
    held = HELD_PATTERN.fullmatch(text)
    conditions, lasting = (held[1], f" for {held[2]} s") if held else (text, "")
    return (
        " and ".join(map(_word_condition, AND_PATTERN.split(conditions))) + lasting + comma + cause
    )


def _word_condition(text: str) -> str:
    """Return one comparison in words, or as it is where it is none that is known."""
    match = LOSS_PATTERN.fullmatch(text)
    if match is None:
        return text
    quantity, suffix, side, number, unit = match.groups()
    if (quantity, side) == ("showing", ">") and not float(number):
        return "sail or deck out of the water"
    shown = f"{number} {suffix or unit or FIRST_UNITS.get(quantity, '')}".rstrip().replace("_", "/")
    if words := LOSS_WORDS.get(f"{quantity}{side}"):
        return words.format(shown)
    return f"{quantity.replace('_', ' ')} {SIDE_WORDS[side]} {shown}"
