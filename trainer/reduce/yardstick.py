"""Flights of the full set, and how far a candidate's are from them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.files.vessel_file import VesselFile
from trainer.guide.programme import Leg, own_method
from trainer.guide.verdicts import Judgement, judge
from trainer.reduce.candidate import Candidate
from trainer.study.manoeuvres.flight import Flight, fly
from trainer.study.manoeuvres.submarine import Submarine
from trainer.units import KNOT

FURTHEST: Final = 10.0  # [-] a difference beyond this counts as this


@dataclass(frozen=True)
class Row:
    """One number that is looked at."""

    leg: str
    quantity: str


class Yardstick:
    """The full set's flights of some legs, and the numbers in them that are judged."""

    def __init__(self, file: VesselFile, legs: Sequence[Leg]) -> None:
        """Fly the legs; those that the full set cannot start are left out."""
        boat = Submarine(file, own_method(file, "full"))
        self._flights = dict(_flown(boat, legs))
        self.rows = tuple(
            Row(leg.title, one.quantity)
            for leg, full in self._flights.items()
            for one in judge(leg.manoeuvre, full, full)
            if one.allowed
        )
        self._places = {row: i for i, row in enumerate(self.rows)}

    @property
    def legs(self) -> tuple[Leg, ...]:
        """Return the legs that the full set flies."""
        return tuple(self._flights)

    def judged(self, candidate: Candidate) -> Iterator[tuple[Leg, tuple[Judgement, ...]]]:
        """Yield leg and judgements, none of a leg that the candidate cannot start."""
        for leg, full in self._flights.items():
            try:
                other = candidate.fly(leg, full)
            except ConfigError:
                yield leg, ()
            else:
                yield leg, judge(leg.manoeuvre, full, other)

    def differences(self, candidate: Candidate) -> Numbers:
        """Return candidate less full by row, as multiples of what is allowed [-]."""
        found = np.full(len(self.rows), FURTHEST)
        for leg, judgements in self.judged(candidate):
            for one in judgements:
                place = self._places.get(Row(leg.title, one.quantity))
                if place is not None:
                    found[place] = multiple(one)
        return found


def multiple(one: Judgement) -> float:
    """Return a difference as a multiple of what is allowed [-]; what is lacking counts as zero."""
    if not one.allowed or one.full is None:
        return FURTHEST
    other = 0.0 if one.other is None else one.other
    return float(np.clip((other - one.full) / one.allowed, -FURTHEST, FURTHEST))


def _flown(boat: Submarine, legs: Sequence[Leg]) -> Iterator[tuple[Leg, Flight]]:
    """Yield the legs that can be started, with their flights."""
    for leg in legs:
        try:
            yield leg, fly(boat, leg.manoeuvre, leg.speed_kn * KNOT)
        except ConfigError:
            continue
