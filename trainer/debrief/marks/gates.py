"""The gate of an exercise: what a broken limit leaves of the marks, in proportion.

The limits of an exercise file are its gate. ``judgement`` keeps the marks below what the worst
breach leaves. A breach costs by how far and how long a limit was passed, because a second beyond it
is no wreck.
"""

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from trainer.boat.limits import LIMIT_WORDS
from trainer.core.kernel import Numbers
from trainer.debrief.marks.measures import excess_beyond, limits_of
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.trajectory import RowMask, Trajectory, row_stretches
from trainer.report.svg import clock
from trainer.session.past.plan import Plan

GATE_TIME_S: Final = 2.0  # [s] for which a limit must be broken before it costs marks
GATE_CAP: Final = 50.0  # [%] most that is left where a limit was wholly broken
FULL_BREACH_S: Final = 30.0  # [s] beyond a limit by FULL_EXCESS of it that break it wholly
FULL_EXCESS: Final = 0.25  # [-] of the limit; an estimate
LEAST_EXCESS: Final[Mapping[str, float]] = {  # [unit of the limit] at least, for limits near 0
    "depth_m": 2.0,
    "pitch_deg": 2.0,
    "heel_deg": 2.0,
    "speed_kn": 0.5,
    "speed_over_ground_kn": 0.5,
    "clearance_m": 0.5,
    "cpa_m": 20.0,
}


class GateBreach(NamedTuple):
    """A broken limit, and what it leaves of the marks."""

    text: str
    cap: float  # [%] most that is left


def worst_breach(trajectory: Trajectory, plan: Plan) -> GateBreach | None:
    """Return the breach that leaves least, None if no limit was broken."""
    breaches = (*_broken(trajectory), *_laid_badly(trajectory, plan))
    return min(breaches, key=lambda breach: breach.cap, default=None)


def _broken(trajectory: Trajectory) -> Iterator[GateBreach]:
    """Yield the limits that were broken for GATE_TIME_S.

    What is left falls by how far each was passed, and for how long: no second decides it.
    """
    for name in limits_of(trajectory):
        excess = excess_beyond(trajectory, name)
        row = first_for(excess > 0.0, GATE_TIME_S, trajectory)
        if row is not None:
            limit = getattr(trajectory.limits, name)
            width = max(FULL_EXCESS * abs(limit), LEAST_EXCESS[name.rpartition("_")[0]])
            share = _excess_time(excess, trajectory) / (width * FULL_BREACH_S)
            text = f"{LIMIT_WORDS[name].format(limit)} at {clock(float(trajectory.seconds[row]))}"
            yield GateBreach(text, 100.0 - (100.0 - GATE_CAP) * min(share, 1.0))


def _excess_time(excess: Numbers, trajectory: Trajectory) -> float:
    """Return the excess over the time [unit of the limit times s], stretches of GATE_TIME_S on."""
    step, times = trajectory.boat.method.step, trajectory.seconds
    return step * sum(
        float(excess[first:after].sum())
        for first, after in row_stretches(excess > 0.0)
        if times[after - 1] - times[first] >= GATE_TIME_S - 1e-9
    )


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


def first_for(holds: RowMask, seconds: float, trajectory: Trajectory) -> int | None:
    """Return the first row from which something holds for so long. None: it never does."""
    times = trajectory.seconds
    return next(
        (
            first
            for first, after in row_stretches(holds)
            if times[after - 1] - times[first] >= seconds - 1e-9
        ),
        None,
    )
