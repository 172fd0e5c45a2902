"""The reference crew's run of an exercise, and runs joined to one.

The reference crew follows rules that the exercise's author wrote. Flown at the same seed, it shows
what a careful crew could have had (``data``); flown on from a moment of a recorded run, it shows
what that run could still earn (``attainable``). A passage is such a run as arrays by tick
(``trajectory``).
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal, last_tick
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.passage.episodes import INSTRUCTOR_ROLE, crew_orders
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.recording.facts import Giver, GiverKind
from trainer.session.past.plan import Plan
from trainer.session.stations.alerts import Alert, Instant

MAX_REFERENCE_TICKS: Final = 400_000  # [ticks] flown while somebody waits for a debrief
INSTRUCTOR_GIVER: Final = Giver(GiverKind.STATION, INSTRUCTOR_ROLE, INSTRUCTOR_ROLE)


@dataclass(frozen=True)
class Reference:
    """A run of the reference crew, and its marks."""

    rehearsal: Rehearsal
    card: Scorecard
    since: float | None = None  # [s] from which it was flown; None: from the start

    @property
    def trajectory(self) -> Trajectory:
        """Return the passage of the run."""
        return self.rehearsal.trajectory


def can_fly(plan: Plan) -> bool:
    """Return whether a plan ends within MAX_REFERENCE_TICKS, because somebody waits."""
    return plan.duration is not None and last_tick(plan) <= MAX_REFERENCE_TICKS


def fly_reference(plan: Plan, card: Scorecard, width: str) -> Reference | None:
    """Return the run of the exercise's reference crew at the plan's seed. None: no crew."""
    if not plan.crew.rules or not can_fly(plan):
        return None
    rehearsal = fly_rehearsal(plan.alone(), plan.crew)
    return Reference(rehearsal, judge_run(rehearsal.trajectory, plan, nobody_of(card), width))


def nobody_of(card: Scorecard) -> dict[str, float]:
    """Return the marks with nobody aboard, as taken off, by the scores' names."""
    return {each.name: each.nobody or 0.0 for each in card.scores}


def alerts_until(flown: Trajectory, tick: int) -> tuple[Alert, ...]:
    """Return the alerts of a run up to a tick.

    Who takes over then acknowledges those that are owed it.
    """
    there = [each for each in flown.alerts if each.raised.tick < tick]
    joint = Instant(0, tick, tick * flown.boat.method.step)
    return tuple(
        replace(each, seen=joint, seen_by=INSTRUCTOR_ROLE)
        if each.seen is None or each.seen.tick > tick
        else each
        for each in there
    )


def join_runs(before: Trajectory, after: Trajectory) -> Trajectory:
    """Return a run up to where another begins, and that other, as one.

    Whoever gave the orders before counts as giving those after it, because marks are of one crew.
    """
    rows = slice(int(before.ticks.searchsorted(after.ticks[0])))
    by_instructor = all(each.giver.role == INSTRUCTOR_ROLE for each in crew_orders(before))
    orders = [each for each in before.orders if each.tick < after.ticks[0]]
    alone = bool(orders) and by_instructor  # then the instructor is the crew
    taken = tuple(
        replace(item, giver=INSTRUCTOR_GIVER) if alone and item.entry is None else item
        for item in after.orders
    )
    return replace(
        after,
        orders=(*orders, *taken),
        marks=(*(each for each in before.marks if each.tick < after.ticks[0]), *after.marks),
        alerts=alerts_until(before, int(after.ticks[0])),
        ticks=np.concatenate((before.ticks[rows], after.ticks)),
        columns={
            name: np.concatenate((before.columns[name][rows], values))
            for name, values in after.columns.items()
        },
        lateness=np.concatenate((before.lateness[rows], after.lateness)),
        work=np.concatenate((before.work[rows], after.work)),
    )
