"""Passages of a few rows, made of given columns, without a recording."""

from typing import Any

import numpy as np

from helpers.boats import make_boat
from trainer.boat.calls import Rank
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.score_rules import ScoreRule
from trainer.core.casualties import CODES
from trainer.debrief.marks.measures import Measurement
from trainer.debrief.marks.scoring import score_rules
from trainer.debrief.passage.trajectory import CASUALTY_SLOTS, PASSAGE_COLUMNS, Trajectory
from trainer.session.stations.alerts import Alert, Instant

BB2 = make_boat("bb2", "modified")


def trajectory(
    limits: ExerciseLimits | None = None, orders: Any = (), **columns: Any
) -> Trajectory:
    """Return a passage at 0.5 s a tick, whose columns but those given are zero."""
    given = {name: np.asarray(values, float) for name, values in columns.items()}
    count = max((values.size for values in given.values()), default=5)
    flat = np.zeros(count)
    slots = given.pop("jam", flat)
    whole = (
        dict.fromkeys(PASSAGE_COLUMNS, flat)
        | given
        | {CASUALTY_SLOTS[0]: slots * CODES["stern-stuck"]}
    )
    untimed = np.full(count, np.nan)
    ticks = np.arange(count)
    return Trajectory(
        BB2, limits or ExerciseLimits(), tuple(orders), ticks, whole, untimed, untimed
    )


def alert(raised: int, seen: int | None = None, by: str = "", rank: Rank = Rank.ALARM) -> Alert:
    """Return an alert by the ticks of 0.5 s at which it came and was acknowledged."""
    when = None if seen is None else Instant(1, seen, 0.5 * seen)
    return Alert(1, "", "depth", rank, "too deep", Instant(1, raised, 0.5 * raised), when, by)


def take_measure(flown: Trajectory, rule: ScoreRule) -> Measurement:
    """Return the measure of a rule in a passage."""
    return score_rules(flown, (rule,)).scores[0].attained
