"""The orders of a boat in a page that only write numbers: a row each.

A row is WORDS;LOW;HIGH;FACTOR;TURN;WRITES, an effect of ``trainer.boat.effects``. LOW to HIGH [SI]
bound x, the number typed after the words times FACTOR; nothing stands there if none is. TURN is the
number typed that counts as 0. WRITES are PLACE=RULE:ARGUMENT, done in order.
"""

from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.effects import Effect, effects_of_boat

NO_NUMBER: Final = ";;;"


def order_rows(boat: Boat) -> list[str]:
    """Return the rows of the orders that this boat takes."""
    return [_row(effect) for effect in effects_of_boat(boat)]


def _row(effect: Effect) -> str:
    """Return the row of an effect."""
    limits = NO_NUMBER
    if effect.number:
        low, high, size, turn = effect.number
        limits = f"{low!r};{high!r};{size!r};{turn}"
    writes = (f"{place}={rule}:{argument!r}" for place, rule, argument in effect.writes)
    return f"{effect.words};{limits};{','.join(writes)}"
