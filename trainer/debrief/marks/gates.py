"""The gate of an exercise: what a broken limit leaves of the marks, in proportion.

The limits of an exercise file are its gate. ``judgement`` keeps the marks below what the worst
breach leaves. A breach costs by how far and how long a limit was passed, because a second beyond it
is no wreck.
"""

from collections.abc import Iterator
from typing import NamedTuple

from trainer.boat.limits import LIMIT_WORDS
from trainer.debrief.marks import tallies
from trainer.debrief.marks.mark_numbers import FULL_BREACH_S, GATE_CAP
from trainer.debrief.marks.tallied_record import TalliedRecord
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.trajectory import Trajectory
from trainer.report.svg import clock
from trainer.session.past.plan import Plan


class GateBreach(NamedTuple):
    """A broken limit, and what it leaves of the marks."""

    text: str
    cap: float  # [%] most that is left


def worst_breach(record: TalliedRecord, plan: Plan) -> GateBreach | None:
    """Return the breach that leaves least, None if no limit was broken."""
    breaches = (*_broken(record), *_laid_badly(record.trajectory, plan))
    return min(breaches, key=lambda breach: breach.cap, default=None)


def _broken(record: TalliedRecord) -> Iterator[GateBreach]:
    """Yield the limits that were broken for GATE_TIME_S.

    What is left falls by how far each was passed, and for how long: no second decides it.
    """
    for name, row, tally in record.caps(tallies.GATE):
        share = float(row["step"] * tally["sum"] / (row["band"] * FULL_BREACH_S))
        limit, when = getattr(record.trajectory.limits, name), clock(tally["at"] * row["step"])
        text = f"{LIMIT_WORDS[name].format(limit)} at {when}"
        yield GateBreach(text, 100.0 - (100.0 - GATE_CAP) * min(share, 1.0))


def _laid_badly(trajectory: Trajectory, plan: Plan) -> Iterator[GateBreach]:
    """Yield that a boat that may lie on the ground came there badly, and when."""
    bottom = plan.world.get("bottom")
    if bottom is None or not bottom.bottoming:
        return
    for grounding in groundings(trajectory):
        if grounding.at_fault:
            why = ", ".join(grounding.touch.faults) or "did not come to lie"
            when = clock(float(trajectory.seconds[grounding.row]))
            yield GateBreach(f"laid on the ground badly at {when}: {why}", GATE_CAP)
