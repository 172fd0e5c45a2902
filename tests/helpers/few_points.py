"""Debriefs that look at few moments, for tests of all else that they say."""

import pytest

from trainer.debrief.attainable import curve as attainable_curve
from trainer.debrief.attainable.explorer import RunExplorer

PERIODS = 100  # of the finest, from moment to moment


def look_at_few_moments(patch: pytest.MonkeyPatch) -> None:
    """Let a debrief look at few moments for what could still be earned."""

    def look_at_a_few(run: RunExplorer) -> None:
        for tick in (run.last, *range(0, run.last, PERIODS * run.finest)):
            run.point(tick)

    patch.setattr(attainable_curve, "fly_points", look_at_a_few)


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the debriefs of a test look at few moments."""
    look_at_few_moments(monkeypatch)
