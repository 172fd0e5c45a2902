"""Debriefs that look at few moments, for tests of all else that they say."""

import pytest

from trainer.debrief.attainable import curve as attainable_curve
from trainer.debrief.attainable.explorer import RunExplorer


def look_at_few_moments(patch: pytest.MonkeyPatch) -> None:
    """Let a debrief look at few moments for what could still be earned.

    They lie ten times further apart than else, and are not halved where marks fall.
    """

    def look_at_ends(run: RunExplorer, before: int, after: int) -> None:
        run.point(before)
        run.point(after)

    patch.setattr(attainable_curve, "POINT_PERIODS", 100)
    patch.setattr(attainable_curve, "IDLE_POINTS", 1)
    patch.setattr(attainable_curve, "halve", look_at_ends)


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the debriefs of a test look at few moments."""
    look_at_few_moments(monkeypatch)
