"""Numbers that a hull's own coefficients do not determine.

No coefficient is known to one in a hundred. Where a row of them so much larger or smaller moves a
number of the full set's own flight by more than a compact set may be off, a compact set that is
off there has lost nothing. The guide, ``trainer boat check`` and ``trainer boat reduce`` tell such
a number and do not judge it.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Final

from trainer.analysis.guide.programme import Leg, fly_boat
from trainer.analysis.guide.verdicts import NOT_DETERMINED, Judgement, allowed_multiple, judge
from trainer.analysis.manoeuvres.flight import Flight
from trainer.config.vessel import VesselFile
from trainer.core.terms import COEFFICIENTS

COEFFICIENT_ROWS: Final = tuple(dict.fromkeys(term.equation for term in COEFFICIENTS))
ROW_CHANGE: Final = 0.01  # [-] estimate: a towing tank measures no better


def neighbour_moves(file: VesselFile, leg: Leg, full: Flight) -> dict[str, float]:
    """Return how far neighbours move the numbers of the full set's flight of a leg.

    A neighbour has one row of coefficients one percent larger or smaller. The largest move of each
    number counts, a multiple of what is allowed [-]. A neighbour that cannot start moves nothing.
    """
    moves: dict[str, float] = {}
    for row, change in product(COEFFICIENT_ROWS, (ROW_CHANGE, -ROW_CHANGE)):
        moved = {
            name: value * (1.0 + change)
            for name, value in file.coefficients.items()
            if value and name.startswith(f"{row}_")
        }
        if not moved:
            continue
        neighbour = replace(file, coefficients={**file.coefficients, **moved})
        other = fly_boat(neighbour, leg.task(neighbour, "full"))
        if isinstance(other, str):
            continue
        for one in judge(leg.manoeuvre, full, other):
            if one.allowed:
                move = abs(allowed_multiple(one))
                moves[one.quantity] = max(moves.get(one.quantity, 0.0), move)
    return moves


def set_apart(
    file: VesselFile, leg: Leg, full: Flight, found: Sequence[Judgement], share: float = 1.0
) -> tuple[Judgement, ...]:
    """Return judgements of a leg; what is beyond, and beyond by neighbours too, is NOT_DETERMINED.

    ``share`` is of what is allowed. Neighbours fly only where something is beyond.
    """
    if not any(_beyond(one, share) for one in found):
        return tuple(found)
    moves = neighbour_moves(file, leg, full)
    return tuple(
        replace(one, allowed=None, verdict=NOT_DETERMINED)
        if _beyond(one, share) and moves.get(one.quantity, 0.0) > share
        else one
        for one in found
    )


def _beyond(one: Judgement, share: float) -> bool:
    """Return whether a number is off by more than ``share`` of what is allowed."""
    return bool(one.allowed) and abs(allowed_multiple(one)) > share
