"""Two runs compared by the percent change of change: programs ZC590 and ZC691.

[ASSES] VI: with D the value at a reference point less the value at t = 0 of the same run, percent =
100 (D_full - D_reduced)/D_full, and 5 % is allowed. Reference points are the extreme of a variable,
its steady value, or, where it has neither, the end of the time looked at (120 s). Extremes are
compared each at its own time: phase is not judged.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.study.series import Series

UNTIL: Final = 120.0  # [s]
ALLOWED: Final = 5.0  # [%]
STEADY_SHARE: Final = 0.1  # of the time: its last part tells whether a value is steady,
STEADY_SPREAD: Final = 0.02  # [-] of D: which it is with no more change than this
MINOR: Final = 0.05  # [-] of the largest change: a change below it is shown and not judged
# What is compared unless asked otherwise, and the change [SI, rad] that instruments begin to show.
VARIABLES: Final = {
    "u": 0.05,
    "z": 0.1,
    "theta": math.radians(0.1),
    "phi": math.radians(0.1),
    "psi": math.radians(0.1),
    "r": math.radians(0.01),
}


@dataclass(frozen=True)
class Point:
    """One variable at one reference point of both runs; SI and radians."""

    variable: str
    point: str  # "extreme", "steady" or "at the end"
    t_full: float  # [s]
    t_reduced: float  # [s]
    change_full: float  # value less that at t = 0
    change_reduced: float
    percent: float | None  # change of change; None: the full run has no change
    judged: bool
    passed: bool  # or not judged


@dataclass(frozen=True)
class Comparison:
    """All that ``trainer compare`` says about two runs."""

    full: str
    reduced: str
    until_s: float
    allowed_percent: float
    unchanged: tuple[str, ...]  # variables that the full run does not change
    points: tuple[Point, ...]
    passed: bool


def percent_change(change_full: float, change_reduced: float) -> float:
    """Return 100 (D_full - D_reduced)/D_full; the full change must not be zero."""
    return 100.0 * (change_full - change_reduced) / change_full


def compare(
    full: Series,
    reduced: Series,
    variables: Sequence[str],
    until: float = UNTIL,
    allowed: float = ALLOWED,
) -> Comparison:
    """Return the percent change of change of ``variables`` up to ``until`` [s] from the start.

    Without ``variables`` all of VARIABLES that both runs have. ConfigError if a run lacks one, or
    both runs have none.
    """
    names = list(variables) or [
        name for name in VARIABLES if name in full.columns and name in reduced.columns
    ]
    if not names:
        known = ", ".join(VARIABLES)
        raise ConfigError(f"{full.path} and {reduced.path} share no column of {known}")
    end = min(until, *(float(run.t[-1] - run.t[0]) for run in (full, reduced)))
    points: list[Point] = []
    unchanged = []
    for name in names:
        found = _points(name, (changes(full, name, end), changes(reduced, name, end)), allowed)
        points += found
        if not found:
            unchanged.append(name)
    return Comparison(
        full=str(full.path),
        reduced=str(reduced.path),
        until_s=end,
        allowed_percent=allowed,
        unchanged=tuple(unchanged),
        points=tuple(points),
        passed=all(point.passed for point in points),
    )


def changes(run: Series, name: str, end: float) -> Numbers:
    """Return times from the start [s] and the change since then, (2, n), up to ``end`` [s]."""
    t, values = run.t - run.t[0], run.column(name)
    inside = t < end
    last = np.interp(end, t, values)
    return np.array([[*t[inside], end], np.array([*values[inside], last]) - values[0]])


def _points(name: str, runs: tuple[Numbers, Numbers], allowed: float) -> list[Point]:
    """Return the reference points of one variable, none if the full run does not change it."""
    full, reduced = runs
    largest = float(abs(full[1]).max())
    if largest <= VARIABLES.get(name, 0.0):
        return []
    found = []
    place = int(np.argmax(abs(full[1])))
    is_extreme = 0 < place < full.shape[1] - 1
    if is_extreme:
        # the same sense in the reduced run, whenever that is
        there = int(np.argmax(math.copysign(1.0, full[1, place]) * reduced[1]))
        found.append(_point(name, "extreme", full[:, place], reduced[:, there], allowed))
    is_steady = _steady(full)
    label = "steady" if is_steady else "at the end"
    ending = _point(name, label, full[:, -1], reduced[:, -1], allowed)
    if abs(ending.change_full) < MINOR * largest or (is_extreme and not is_steady):
        ending = replace(ending, judged=False, passed=True)
    return [*found, ending]


def _steady(run: Numbers) -> bool:
    """Return whether the last part of a run changes by little of its change."""
    last = run[1, run[0] >= (1.0 - STEADY_SHARE) * run[0, -1]]
    return bool(np.ptp(last) <= STEADY_SPREAD * abs(run[1, -1]))


def _point(name: str, point: str, full: Numbers, reduced: Numbers, allowed: float) -> Point:
    """Return both runs at one reference point, each (time, change), judged."""
    by_full, by_reduced = float(full[1]), float(reduced[1])
    percent = percent_change(by_full, by_reduced) if by_full != 0.0 else None
    return Point(
        variable=name,
        point=point,
        t_full=float(full[0]),
        t_reduced=float(reduced[0]),
        change_full=by_full,
        change_reduced=by_reduced,
        percent=percent,
        judged=True,
        passed=percent is not None and abs(percent) <= allowed,
    )
