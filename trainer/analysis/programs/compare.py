"""Two runs compared by the percent change of change: programs ZC590 and ZC691.

``trainer report-1969 compare`` prints it, and the guide judges by it; [ASSES] is the report of 1969
on the programs. [ASSES] VI: with D the value at a reference point less the value at t = 0 of the
same run, percent = 100 (D_full - D_reduced)/D_full, and 5 % is allowed. Reference points are the
extreme of a variable, its steady value, or, where it has neither, the end of the time looked at
(120 s). Extremes are compared each at its own time: phase is not judged.

A schedule sees an event, such as the pitch at which planes are reversed, at the start of a step.
Two runs may see it a step apart, whatever their equations. The difference that this alone can make
is no failure. It is estimated: as much as the variable changes in that time at its fastest.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT
from trainer.config.files import ConfigError
from trainer.config.ship.series import Series
from trainer.core.kernel import Numbers
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, PAGE_WIDTH, cut_text, format_number, table, wrap

COMPARISON_END_S: Final = 120.0  # [s] the time looked at, of [ASSES]
STEADY_SHARE: Final = 0.1  # of the time: its last part tells whether a value is steady,
STEADY_SPREAD: Final = 0.02  # [-] of D: which it is with no more change than this
# [-] of the largest change: a change below it is shown and not judged
MINOR_CHANGE_RATIO: Final = 0.05
SURFACE_COLUMNS: Final = ("delta_r", "delta_s", "delta_b")
STILL_SURFACE_RAD: Final = 1e-9  # [rad] a step: a surface that moves less stands still
STILL_SHARE: Final = 0.1  # [-] of the steps, in which one that is thrown over stands still
TIME_ROUNDING_S: Final = 1e-6  # [s]
# What is compared unless asked otherwise, and the change [SI, rad] that instruments begin to show.
COMPARED_VARIABLES: Final = {
    "u": 0.05,
    "z": 0.1,
    "theta": math.radians(0.1),
    "phi": math.radians(0.1),
    "psi": math.radians(0.1),
    "r": math.radians(0.01),
}
POINT_HEADS: Final = ("", "", "t full\n[s]", "t other\n[s]", "full", "other", "percent", "")


@dataclass(frozen=True)
class ReferencePoint:
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
    event_worth: float = 0.0  # allowed besides the percent, for an event a step apart
    by_event: bool = False  # whether it passes by that alone


@dataclass(frozen=True)
class RunComparison:
    """All that ``trainer report-1969 compare`` says about two runs."""

    full: str
    reduced: str
    until_s: float
    allowed_percent: float
    unchanged: tuple[str, ...]  # variables that the full run does not change
    points: tuple[ReferencePoint, ...]
    passed: bool
    event_s: float = 0.0  # by how much the first event lies apart, at most a step; 0: by none


def compare_runs(
    full: Series,
    reduced: Series,
    variables: Sequence[str],
    until: float = COMPARISON_END_S,
    allowed: float = ALLOWED_PERCENT,
    event: float = 0.0,
) -> RunComparison:
    """Return the percent change of change of ``variables`` up to ``until`` [s] from the start.

    ``event`` [s] is how far apart the runs see an event, by ``event_apart``. Without ``variables``
    all of COMPARED_VARIABLES that both runs have. ConfigError if a run lacks one, or both runs have
    none.
    """
    names = list(variables) or [
        name for name in COMPARED_VARIABLES if name in full.columns and name in reduced.columns
    ]
    if not names:
        known = ", ".join(COMPARED_VARIABLES)
        raise ConfigError(f"{full.path} and {reduced.path} share no column of {known}")
    end = min(until, *(float(run.t[-1] - run.t[0]) for run in (full, reduced)))
    points: list[ReferencePoint] = []
    for name in names:
        run = changes(full, name, end)
        compared = _points(name, (run, changes(reduced, name, end)), allowed)
        worth = event * float(abs(np.diff(run[1]) / np.diff(run[0])).max())  # at its fastest
        points += [_excuse(point, allowed, worth) if event else point for point in compared]
    changed = {point.variable for point in points}
    return RunComparison(
        full=str(full.path),
        reduced=str(reduced.path),
        until_s=end,
        allowed_percent=allowed,
        unchanged=tuple(name for name in names if name not in changed),
        points=tuple(points),
        passed=all(point.passed for point in points),
        event_s=event,
    )


def _excuse(point: ReferencePoint, allowed: float, worth: float) -> ReferencePoint:
    """Return a point that also passes if its excess is no more than an event is ``worth``."""
    if not point.judged:
        return point
    most = abs(point.change_full) * allowed / 100.0 + worth
    by_event = abs(point.change_full - point.change_reduced) <= most and not point.passed
    return replace(point, event_worth=worth, passed=point.passed or by_event, by_event=by_event)


def event_apart(full: Series, reduced: Series) -> float:
    """Return the time [s] between two runs at the first event that they see apart.

    Events are the times at which a surface that is thrown over begins to move. The time is 0 where
    there is no such event. It is 0 too where the event lies further apart than the longer of the
    steps, because then the runs themselves differ.
    """
    step = max(float(np.median(np.diff(run.t))) for run in (full, reduced))
    gaps = [0.0]
    for name in SURFACE_COLUMNS:
        if name not in full.columns or name not in reduced.columns:
            continue
        pairs = zip(_throws(full, name), _throws(reduced, name), strict=False)
        apart = [(abs(a[0] - b[0]), a[1] == b[1]) for a, b in pairs]
        gap, alike = next((one for one in apart if one[0] > TIME_ROUNDING_S), (0.0, True))
        if alike and gap <= step + TIME_ROUNDING_S:
            gaps.append(gap)
    return max(gaps)


def _throws(run: Series, name: str) -> list[tuple[float, float]]:
    """Return time [s] from the start, and sign, of each move that a surface begins.

    A surface that hardly ever stands still has none, because an autopilot moves it.
    """
    moves = np.diff(run.column(name))
    signs = np.where(abs(moves) < STILL_SURFACE_RAD, 0.0, np.sign(moves))
    if np.mean(signs == 0.0) < STILL_SHARE:
        return []
    before = np.concatenate(([0.0], signs[:-1]))
    begins = np.flatnonzero((signs != 0.0) & (signs != before))
    times = (run.t - run.t[0])[begins]
    return list(zip(times.tolist(), signs[begins].tolist(), strict=True))


def changes(run: Series, name: str, end: float) -> Numbers:
    """Return times from the start [s] and the change since, (2, n), to ``end`` [s]."""
    t, values = run.t - run.t[0], run.column(name)
    inside = t < end
    last = np.interp(end, t, values)
    return np.array([np.append(t[inside], end), np.append(values[inside], last) - values[0]])


def _points(name: str, runs: tuple[Numbers, Numbers], allowed: float) -> list[ReferencePoint]:
    """Return the reference points of one variable, none if the full run does not change it."""
    full, reduced = runs
    largest = float(abs(full[1]).max())
    if largest <= COMPARED_VARIABLES.get(name, 0.0):
        return []
    points, index = [], int(np.argmax(abs(full[1])))
    is_extreme = 0 < index < full.shape[1] - 1
    if is_extreme:
        # the same sense in the reduced run, whenever that is
        other_index = int(np.argmax(math.copysign(1.0, full[1, index]) * reduced[1]))
        points.append(_point(name, "extreme", full[:, index], reduced[:, other_index], allowed))
    last = full[1, full[0] >= (1.0 - STEADY_SHARE) * full[0, -1]]
    is_steady = bool(np.ptp(last) <= STEADY_SPREAD * abs(full[1, -1]))
    label = "steady" if is_steady else "at the end"
    ending = _point(name, label, full[:, -1], reduced[:, -1], allowed)
    if abs(ending.change_full) < MINOR_CHANGE_RATIO * largest or (is_extreme and not is_steady):
        ending = replace(ending, judged=False, passed=True)
    return [*points, ending]


def _point(
    name: str, point: str, full: Numbers, reduced: Numbers, allowed: float
) -> ReferencePoint:
    """Return both runs at one reference point, each (time, change), judged."""
    by_full, by_reduced = float(full[1]), float(reduced[1])
    percent = 100.0 * (by_full - by_reduced) / by_full if by_full != 0.0 else None
    return ReferencePoint(
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


def render(report: RunComparison) -> str:
    """Return the report as text."""
    room = PAGE_WIDTH - len("  other ")
    rows = []
    for point in report.points:
        factor, unit = page_unit(point.variable)
        verdict = "within" if point.judged else ""
        verdict = "a step" if point.by_event else verdict if point.passed else "BEYOND"
        rows.append(
            (
                f"{point.variable} [{unit}]",
                point.point,
                *(f"{t:.1f}" for t in (point.t_full, point.t_reduced)),
                *(f"{factor * by:+.4g}" for by in (point.change_full, point.change_reduced)),
                format_number(point.percent, "+.2f"),
                verdict,
            )
        )
    lines = [
        "PERCENT CHANGE OF CHANGE (ZC590, ZC691)",
        f"{INDENT}full  {cut_text(report.full, room)}",
        f"{INDENT}other {cut_text(report.reduced, room)}",
        f"{INDENT}changes since the start, over {report.until_s:g} s; 100 (full - other)/full",
    ]
    lines += ["", *table(POINT_HEADS, rows)] if report.points else []
    if report.unchanged:
        names = ", ".join(report.unchanged)
        lines += wrap(f"too little change in the full run to compare: {names}")
    if report.event_s:
        lines += wrap(
            f"an event is {report.event_s:g} s apart in the two runs. Times of events are known to "
            "a step, so what this alone may be worth is no failure: a step"
        )
    judged = [point for point in report.points if point.judged]
    beyond = sum(not point.passed for point in judged)
    verdict = f"{beyond} of {len(judged)} beyond {report.allowed_percent:g} %."
    if not beyond:
        besides = sum(point.by_event for point in judged)
        verdict = f"All of {len(judged)} within {report.allowed_percent:g} %"
        verdict += f", {besides} of them but for a step." if besides else "."
    return "\n".join([*lines, "", verdict])


def panels(report: RunComparison, full: Series, reduced: Series) -> tuple[Panel, ...]:
    """Return the changes of both runs over time, extremes marked."""
    panel_list = []
    for name in dict.fromkeys(point.variable for point in report.points):
        factor, unit_name = page_unit(name)
        curves = []
        for label, run in (("full", full), ("other", reduced)):
            t, change = changes(run, name, report.until_s)
            curves.append(Curve(label, t, factor * change))
        spots = [
            spot
            for point in report.points
            if point.variable == name and point.judged
            for spot in ((point.t_full, point.change_full), (point.t_reduced, point.change_reduced))
        ]
        if spots:
            times, heights = np.array(spots).T
            curves.append(Curve("compared", times, factor * heights, points=True))
        label = f"change of {name} [{unit_name}]"
        x, lower = "time from the start [s]", name in DEPTH_COLUMNS
        panel_list.append(Panel(name, x, label, tuple(curves), downwards=lower))
    return tuple(panel_list)
