"""A debrief says which aids were on, and takes nothing that was shown for the crew's."""

from contextlib import closing
from pathlib import Path

import pytest
from helpers.recorded import record

from trainer.config.files import ConfigError
from trainer.debrief.page import sections
from trainer.debrief.page.data import DebriefData, debrief_figures, gather_debrief
from trainer.debrief.page.page import as_text
from trainer.debrief.trainees.history import compute_result, kept_result, list_lines, list_recording
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import SHOWN_REASON, Recording

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")


def debriefed(path: Path, branch: int | None = None) -> DebriefData:
    with closing(Recording.look(path)) as recording:
        return gather_debrief(recording, path, branch)


def test_the_aids_of_a_run_stand_beside_its_marks_and_are_no_order_of_the_crews(
    tmp_path: Path,
) -> None:
    orders = [(10.0, "ghost on"), (20.0, "predictor off"), (70.0, "predictor 60 s")]
    path = record(tmp_path / "run.trainer", "stern-plane-jam", orders)

    debrief = debriefed(path)

    assert debrief.aids == ("ghost", "predictor")
    assert debrief.crew == ()
    assert debrief.casualties[0].order is None
    assert "Flown with ghost and predictor." in sections.verdict(debrief)
    assert ", with ghost, with predictor " in " ".join(as_text(debrief).split())
    assert debrief_figures(debrief)["aids"] == ["ghost", "predictor"]
    assert compute_result(path).aids == "ghost, predictor"
    assert kept_result(path) == compute_result(path)
    assert next(list_lines([list_recording(path)])).endswith("(with ghost, predictor)")


def test_a_run_without_aids_says_nothing_of_them(tmp_path: Path) -> None:
    path = record(tmp_path / "run.trainer", "stern-plane-jam", [(10.0, "predictor off")])
    debrief = debriefed(path)
    assert debrief.aids == ()
    assert "Flown with" not in sections.verdict(debrief)
    assert "with" not in next(list_lines([list_recording(path)]))


@pytest.fixture
def shown(tmp_path: Path) -> Path:
    """Return a run of which the last branch shows the way, and was cut short."""
    path = record(tmp_path / "run.trainer", "stern-plane-jam", {})
    with closing(Recording.reopen(path)) as recording:
        moment = recording.moment(1, 300)
        assert moment
        recording.fork(moment, "demonstrate, by instructor", BranchCause.SHOWN)
        for tick in range(301, 340):
            state = recording.state_at(1, tick)
            assert state
            recording.state(tick, state)
    return path


def test_a_debrief_is_of_the_crews_branch_and_names_the_one_that_was_shown(shown: Path) -> None:
    assert debriefed(shown).branch.id == 1
    assert not debriefed(shown).shown

    of_crew = debriefed(shown, 2)

    assert of_crew.shown
    assert of_crew.card.total is None
    assert "Flown by the reference crew, to show the way" in sections.verdict(of_crew)
    with pytest.raises(ConfigError, match="there are branches 1 to 2"):
        debriefed(shown, 3)


def test_what_the_crew_flies_after_the_way_was_shown_is_practice(shown: Path) -> None:
    with closing(Recording.reopen(shown)) as recording:
        recording.leave_shown()
        assert recording.branch == 3
        recording.leave_shown()  # there is nothing more to leave
        assert recording.branch == 3
    debrief = debriefed(shown)
    assert (debrief.branch.id, debrief.branch.parent) == (3, 1)
    assert debrief.practice == f"{SHOWN_REASON}, to 150 s"
    assert debrief.card.total is not None
