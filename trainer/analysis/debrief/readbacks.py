"""Orders to the crew: repeated by whom and how soon, and how soon carried out.

All from the journal: what was ordered, the repeats with their answers. A recording without any
has none to tell.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.analysis.debrief.reference import WIDTHS
from trainer.analysis.debrief.trajectory import CREW_ORDERS, Trajectory
from trainer.config.measures import COURSE
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Journalled

ORDERED: Final = "ordered: "  # begins the answer to an order to the crew
AYE: Final = " aye"  # ends that to a repeat
WRONG: Final = "WRONG REPEAT: "
WORDS: Final = "words"  # the axis of an order in words


@dataclass(frozen=True)
class ReadBack:
    """One order to the crew, and what came of it."""

    order: Journalled
    axis: str
    told: str  # as the crew was told
    repeated: Journalled | None = None
    wrong: tuple[str, ...] = ()  # words of wrong repeats
    carried_out: int | None = None  # [tick] from which it was kept until the next


def read_backs(trajectory: Trajectory) -> tuple[ReadBack, ...]:
    """Return the orders to the crew of a run, with repeats and when they were carried out."""
    found: list[ReadBack] = []
    for entry in trajectory.orders:
        order = parse(entry.text)
        if not isinstance(order, Order) or entry.accepted is False:
            continue
        if order.name in ("order", "tell"):
            found += _ordered(entry, order)
        elif order.name == "aye":
            _repeat(found, entry)
    return tuple(_carried_out(found, trajectory))


def _ordered(entry: Journalled, order: Order) -> Iterator[ReadBack]:
    """Yield what an order to the crew begins; nothing where it ends one."""
    if order.name == "tell":
        yield ReadBack(entry, WORDS, order.subject)
    elif entry.answer.startswith(ORDERED) or not order.word.startswith("clear"):
        axis = order.word.partition("_")[0].replace("periscope", "depth")
        yield ReadBack(entry, axis, entry.answer.removeprefix(ORDERED) or entry.text)


def _repeat(found: list[ReadBack], entry: Journalled) -> None:
    """Note a repeat, right or wrong, with the newest order that it is about."""
    wrong = entry.answer.startswith(WRONG)
    said, _, meant = entry.answer.removeprefix(WRONG).partition("; ordered is ")
    told = meant if wrong else entry.answer.removesuffix(AYE)
    for i in range(len(found) - 1, -1, -1):
        if found[i].told == told and found[i].repeated is None:
            changed = {"wrong": (*found[i].wrong, said)} if wrong else {"repeated": entry}
            found[i] = replace(found[i], **changed)
            return


def _carried_out(found: list[ReadBack], trajectory: Trajectory) -> Iterator[ReadBack]:
    """Yield the orders with the tick from which each was kept until the next of its axis."""
    for i, each in enumerate(found):
        later = (other.order.tick for other in found[i + 1 :] if other.axis == each.axis)
        end = next(later, int(trajectory.ticks[-1]))
        known = each.axis in CREW_ORDERS and trajectory.has(each.axis)
        yield replace(each, carried_out=_kept_from(each, end, trajectory) if known else None)


def _kept_from(each: ReadBack, end: int, trajectory: Trajectory) -> int | None:
    """Return the first tick from which an order is kept, None if it is not at the end."""
    rows = (trajectory.ticks > each.order.tick) & (trajectory.ticks <= end)
    if not rows.any():
        return None
    off = trajectory.series(each.axis)[rows] - trajectory.ordered(each.axis)[rows][0]
    if each.axis == COURSE:
        off = (off + math.pi) % math.tau - math.pi
    beyond = np.flatnonzero(~(np.abs(off) <= WIDTHS[each.axis]))
    first = int(beyond[-1]) + 1 if beyond.size else 0
    ticks = trajectory.ticks[rows]
    return int(ticks[first]) if first < ticks.size else None
