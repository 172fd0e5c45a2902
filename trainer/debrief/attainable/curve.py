"""The curve of what could still be earned in a run, with its changes."""

from dataclasses import dataclass
from itertools import pairwise

from trainer.debrief.attainable.causes import explain
from trainer.debrief.attainable.changes import ChangeCause, MarkChange, net_changes
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.attainable.falls import lasting_points
from trainer.debrief.attainable.stretches import (
    IDLE_POINTS,
    POINT_PERIODS,
    WORTH_MARKS,
    AttainablePoint,
    changed_stretches,
    without_luck,
)
from trainer.debrief.marks.rehearsal import last_tick
from trainer.debrief.passage.episodes import ordered_beyond
from trainer.io.recording.recording import RecordedOrder


@dataclass(frozen=True)
class AttainableCurve:
    """What could still be earned, over a run."""

    points: tuple[AttainablePoint, ...]
    changes: tuple[MarkChange, ...]
    finest: int = 1  # [ticks] down to which a change is followed
    beyond: tuple[RecordedOrder, ...] = ()  # the instructor's, which the marks are not for

    @property
    def until_won(self) -> int | None:
        """Return the last tick from which the exercise could be won. None: never."""
        return max((each.tick for each in self.points if each.won), default=None)

    @property
    def until_saved(self) -> int | None:
        """Return the last tick from which it need not be lost. None: never."""
        return max((each.tick for each in self.points if not each.lost), default=None)


def attainable_curve(run: RunExplorer) -> AttainableCurve:
    """Return what could be earned at each moment of a run.

    The run has been flown again by ``RunExplorer.fly_again``.
    """
    stride = IDLE_POINTS * POINT_PERIODS * run.finest
    ticks = sorted({*range(0, run.last, stride), run.last} & {*run.departures, run.last})
    for before, after in pairwise(ticks):
        halve(run, before, after)
        run.progress(1.0 - (1.0 - after / run.last) ** 2)  # from later moments less is flown
    points = tuple(run.points[tick] for tick in sorted(run.points))
    cut_short = run.last < last_tick(run.plan) and not points[-1].lost
    flown = points[:-1] if cut_short else points
    level = without_luck(flown, [each.tick for each in run.crew])
    lasting = {each.tick: each for each in lasting_points(level)}
    changes = net_changes(
        change
        for stretch in changed_stretches(level, run.step)
        for change in sorted(explain(run, stretch, lasting), key=lambda each: each.told_at)
    )
    rest = points[-1].marks - flown[-1].marks
    if abs(rest) > WORTH_MARKS:
        cause = ChangeCause.RECORD_ENDS
        changes.append(MarkChange(flown[-1].tick, points[-1].tick, rest, cause))
    beyond = ordered_beyond(run.trajectory.orders)
    return AttainableCurve(points, tuple(map(run.with_better, changes)), run.finest, beyond)


def halve(run: RunExplorer, before: int, after: int) -> None:
    """Find the points of a stretch, halved where its ends differ or orders lie."""
    first, last, stride = run.point(before), run.point(after), run.finest
    near = after - before <= POINT_PERIODS * stride
    idle = near or not any(before <= each.tick < after for each in run.crew)
    if abs(first.marks - last.marks) <= WORTH_MARKS and first.fate == last.fate and idle:
        return
    middle = before + stride * ((after - before) // stride // 2)
    if middle > before and middle in run.departures:
        halve(run, before, middle)
        halve(run, middle, after)
