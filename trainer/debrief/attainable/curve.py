"""What could still be earned over a run, and what made it fall."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from trainer.debrief.attainable.causes import FaultFinder
from trainer.debrief.attainable.changes import FaultKind, MarkChange, join_changes
from trainer.debrief.attainable.explorer import MAX_TICKS, RunExplorer
from trainer.debrief.attainable.search import WORTH_MARKS, AttainablePoint
from trainer.debrief.passage.episodes import ordered_beyond
from trainer.io.recording.recording import RecordedOrder

LATER_S: Final = (6.0, 14.0, 30.0)  # [s] after a fall, at which it is searched again
CURVE_SHARE: Final = 0.6  # [-] of the work, which the points take; the rest is what made the falls


@dataclass(frozen=True)
class AttainableCurve:
    """What could still be earned, over a run."""

    points: tuple[AttainablePoint, ...]
    changes: tuple[MarkChange, ...]
    finest: int = 1  # [ticks] down to which a change is followed
    beyond: tuple[RecordedOrder, ...] = ()  # the instructor's, which the marks are not for
    cut_short: bool = False  # the record ends before the exercise does

    @property
    def until_won(self) -> int | None:
        """Return the last tick from which the exercise could be won. None: never."""
        return max((each.tick for each in self.points if each.won), default=None)

    @property
    def until_saved(self) -> int | None:
        """Return the last tick from which it need not be lost. None: never."""
        return max((each.tick for each in self.points if not each.lost), default=None)


def attainable_curve(run: RunExplorer) -> AttainableCurve:
    """Return what could be earned at each moment of a run, and what cost it.

    The run has been flown again by ``RunExplorer.fly_again``.
    """
    fly_points(run)
    finder = FaultFinder(run)
    falls = finder.falls()
    changes: list[MarkChange] = []
    for number, (begin, end) in enumerate(falls):
        changes += sorted(finder.explain(begin, end), key=lambda each: each.told_at)
        run.progress(CURVE_SHARE + (1.0 - CURVE_SHARE) * (number + 1) / len(falls))
    points = tuple(run.points[tick] for tick in sorted(run.points))
    flown = points[:-1] if run.cut_short else points
    rest = points[0].marks - flown[-1].marks + sum(each.marks for each in changes)
    if rest > WORTH_MARKS:  # a little here and there
        changes.append(MarkChange(0, flown[-1].tick, -rest, FaultKind.UNPROVED))
    short = flown[-1].marks - points[-1].marks
    if short > WORTH_MARKS:
        fault = FaultKind.RECORD_ENDS
        changes.append(MarkChange(flown[-1].tick, points[-1].tick, -short, fault))
    run.progress(1.0)
    beyond = ordered_beyond(run.trajectory.orders)
    return AttainableCurve(points, tuple(join_changes(changes)), run.finest, beyond, run.cut_short)


def fly_points(run: RunExplorer) -> None:
    """Find the points between which marks fall, down to the finest period.

    Marks never rise, so that between two of the same marks and fate nothing can differ.
    """
    end = max(run.departures) if run.cut_short else run.last
    for tick in (run.last, 0, end):
        run.point(tick)
    halve(run, end, 0.0)
    for before, after in pairwise(sorted(run.points)):
        first = run.points[before]
        if first.marks - run.points[after].marks > WORTH_MARKS:  # what could be had may come back
            for seconds in LATER_S:
                tick = after + run.finest * round(seconds / run.step / run.finest)
                if tick < end and run.search.flown <= MAX_TICKS:
                    run.point(tick, first.marks, won=first.won)
    halve(run, end, 0.5)


def halve(run: RunExplorer, end: int, done: float) -> None:
    """Halve stretches between whose ends marks or fate differ, down to the finest period.

    ``done`` is the share [-] of the points that was known before.
    """
    known = [tick for tick in sorted(run.points) if tick <= end]
    stretches, covered = list(pairwise(known)), 0
    while stretches:
        begin, after = stretches.pop()
        first, last = run.points[begin], run.points[after]
        middle = begin + run.finest * ((after - begin) // run.finest // 2)
        alike = first.marks - last.marks <= WORTH_MARKS and first.fate == last.fate
        if alike or not begin < middle < after or run.search.flown > MAX_TICKS:
            covered += after - begin
            run.progress(CURVE_SHARE * (done + 0.5 * covered / end))
        else:
            run.point(middle, first.marks, won=first.won)
            stretches += [(begin, middle), (middle, after)]
