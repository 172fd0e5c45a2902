"""Files of orders to be given at set times.

``session/past/plan`` reads ``--orders``, and exercise files have the same entries. A line is
`SECONDS ORDER`; blank lines and what follows a "#" are ignored; the lines need not be in order of
time.
"""

import re
from dataclasses import dataclass

from trainer.io.orders.grammar import BadOrder, Order, parse, to_the_crew

MAX_TIME_S = 1e6  # [s]  eleven days
TIMED_PATTERN = re.compile(r"([0-9]{1,9}(?:\.[0-9]{0,9})?)\s+(\S.*)")


@dataclass(frozen=True)
class ScheduledOrder:
    """An order due `seconds` [s] after the start, and its line in the file."""

    seconds: float
    order: Order
    line_number: int


@dataclass(frozen=True)
class BadSchedule:
    """The first line of a schedule that cannot be followed."""

    source: str
    line_number: int
    reason: str

    def __str__(self) -> str:
        return f"{self.source}:{self.line_number}: {self.reason}"


def parse_schedule(text: str, source: str) -> list[ScheduledOrder] | BadSchedule:
    """Return the orders of a schedule sorted by time [s]. Equal times keep the file's order."""
    entries = []
    # Not splitlines(): it also breaks at characters that no editor counts as a line end.
    for i, line in enumerate(text.removeprefix("\ufeff").split("\n"), start=1):
        entry = parse_entry(line.partition("#")[0].strip(" \t\r"), i)
        if isinstance(entry, str):
            return BadSchedule(source, i, entry)
        if entry is not None:
            entries.append(entry)
    return sorted(entries, key=lambda entry: entry.seconds)


def parse_entry(line: str, line_number: int) -> ScheduledOrder | str | None:
    """Return the entry on a line, None when it is blank, or the error."""
    if not line:
        return None
    timed = TIMED_PATTERN.fullmatch(line)
    if timed is None:
        return "a line is SECONDS ORDER, such as: 600 rudder right 15"
    seconds = float(timed[1])
    if seconds > MAX_TIME_S:
        return f"{timed[1]} s: the latest time is {MAX_TIME_S:.0f} s"
    order = parse(timed[2])
    if isinstance(order, Order):
        return ScheduledOrder(seconds, to_the_crew(order), line_number)
    return order.reason if isinstance(order, BadOrder) else "a time without an order"
