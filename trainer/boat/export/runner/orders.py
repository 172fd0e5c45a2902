"""The few orders that are nothing but numbers written into the state.

A row is WORDS;LOW;HIGH;FACTOR;TURN;WRITES. LOW to HIGH [SI] bound x, the number typed after the
words times FACTOR; nothing stands there if none is. FACTOR is negative where right and rise are
positive and the words say the other. TURN is the number typed that counts as 0. WRITES are
PLACE=RULE:ARGUMENT, done in order:

    const V      V
    number S     S x
    place P      what stands at place P
    short P      the angle x, as the turns nearest to the angle at place P
    shorter P    the angle at PLACE itself, likewise
"""

import math

from trainer.boat.export.runner.library import Core, WrongError


class Row:
    """One wording and what it writes."""

    def __init__(self, text: str) -> None:
        """Read a row."""
        self.words, low, high, factor, turn, writes = text.split(";")
        self.takes_number = bool(low)
        self.low = float(low or 0.0)
        self.high = float(high or 0.0)
        self.factor = float(factor or 1.0)
        ends = (self.low / self.factor + 0.0, self.high / self.factor + 0.0)
        self.typed = sorted(ends)  # the limits as they are typed
        self.turn = turn
        self.writes = []
        for write in writes.split(","):
            place, _, rule = write.partition("=")
            name, _, argument = rule.partition(":")
            self.writes.append((int(place), name, float(argument)))

    def number(self, typed: str) -> float:
        """Return the number typed [SI]; WrongError if it is none, or beyond the boat's."""
        digits = typed.removeprefix("-") if self.typed[0] < 0.0 else typed
        if not digits.replace(".", "", 1).isdecimal() or not digits.isascii():
            raise WrongError(f"{self.words} {typed}: give a plain number, without a unit")
        # adding zero turns -0.0 into 0.0, so that "left 0" and "right 0" steer alike
        x = (0.0 if typed == self.turn else float(typed)) * self.factor + 0.0
        if not self.low <= x <= self.high:
            limits = f"{self.typed[0]:.6g} to {self.typed[1]:.6g}"
            raise WrongError(f"{self.words} {typed}: this boat takes {limits}")
        return x

    def carry_out(self, core: Core, x: float) -> None:
        """Write into the state of ``core`` what the order means with the number ``x`` [SI]."""
        s = core.state
        for place, rule, argument in self.writes:
            if rule == "const":
                s[place] = argument
            elif rule == "number":
                s[place] = argument * x
            elif rule == "place":
                s[place] = s[int(argument)]
            else:
                near = s[int(argument)]
                angle = x if rule == "short" else s[place]
                s[place] = near + math.remainder(angle - near, math.tau)


def rows_of(core: Core) -> dict[str, Row]:
    """Return the rows of a core by their words."""
    rows = [Row(text) for text in core.card.orders]
    return {row.words: row for row in rows}


def understand(line: str, rows: dict[str, Row]) -> tuple[Row, float]:
    """Return the row and the number [SI] of an order. WrongError if it is none of them."""
    words = " ".join(line.lower().split())
    if words in rows and not rows[words].takes_number:
        return rows[words], 0.0
    head, _, typed = words.rpartition(" ")
    if head in rows and rows[head].takes_number:
        return rows[head], rows[head].number(typed)
    near = [row for row in rows.values() if row.words.split()[0] == words.split()[0]]
    said = [row.words + " NUMBER" * row.takes_number for row in near or rows.values()]
    raise WrongError(f"{line!r}: an exported core takes, in full words: {', '.join(said)}")
