"""A compact set against the full one: in the guide's flights, in steady turns, in what is new."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from trainer.files.vessel_file import VesselFile
from trainer.guide.programme import Leg
from trainer.guide.programme import legs as guide_legs
from trainer.guide.verdicts import BEYOND
from trainer.reduce.candidate import Candidate
from trainer.reduce.programme import flyable, held_out, turns
from trainer.reduce.yardstick import Yardstick, multiple
from trainer.study.manoeuvres.measures import PERCENT

PARTS: Final = {  # [%] of change allowed, [s] of zero crossings
    "guide": PERCENT,
    "steady turns": PERCENT,
    "held out": 2.0 * PERCENT,
}


@dataclass(frozen=True)
class Checked:
    """One leg by the compact set."""

    part: str
    leg: str
    judged: int  # numbers
    beyond: int
    worst: float  # [-] of what is allowed
    quantity: str  # that is the worst


def legs(file: VesselFile, part: str) -> Sequence[Leg]:
    """Return the legs of a part of the verdict."""
    if part == "guide":
        return guide_legs(file)
    return flyable(file, turns(file)) if part == "steady turns" else held_out(file)


def verdict(file: VesselFile, candidate: Candidate) -> tuple[Checked, ...]:
    """Return every leg of every part judged."""
    return tuple(one for part in PARTS for one in _part(file, part, candidate))


def _part(file: VesselFile, part: str, candidate: Candidate) -> Iterator[Checked]:
    """Yield the legs of one part."""
    share = PARTS[part] / PERCENT
    for leg, judgements in Yardstick(file, legs(file, part)).judged(candidate):
        if not judgements:
            yield Checked(part, leg.title, 1, 1, float("inf"), "it cannot start")
            continue
        judged = [one for one in judgements if one.allowed]
        lost = [one for one in judgements if one.verdict == BEYOND and not one.allowed]
        sizes = {one.quantity: abs(multiple(one)) / share for one in judged}
        sizes |= {one.quantity: float("inf") for one in lost}
        worst = max(sizes, key=lambda name: sizes[name], default="")
        beyond = sum(size > 1.0 for size in sizes.values())
        yield Checked(part, leg.title, len(sizes), beyond, sizes.get(worst, 0.0), worst)


def passed(checked: Sequence[Checked]) -> bool:
    """Return whether nothing is beyond what is allowed."""
    return not any(one.beyond for one in checked)
