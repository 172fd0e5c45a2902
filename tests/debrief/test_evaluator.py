"""What a careful crew could still earn, found of a recording while it is being written."""

import base64
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.recorded import record

from trainer.debrief.attainable.curve import AttainableCurve
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.attainable.search import NoCurve
from trainer.debrief.attainable.words import until_words
from trainer.debrief.live.evaluator import Evaluator, answers
from trainer.debrief.page.data import gather_debrief, judge_as_changed
from trainer.debrief.passage.episodes import ordered_beyond
from trainer.io.recording.recording import Recording
from trainer.session.past.header import open_recording

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
DIVE = {100.0: "stern planes dive 10", 130.0: "stern planes rise 8"}


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of a crew that dives much too steeply."""
    return record(tmp_path_factory.mktemp("kept") / "dive.trainer", "first-depth-change", DIVE)


@pytest.fixture
def recording(kept: Path) -> Iterator[Recording]:
    with open_recording(kept) as opened:
        yield opened


def asked(recording: Recording, tick: int, order: str = "") -> dict[str, Any]:
    """Return the question about a moment before the orders of its tick."""
    moment = recording.moment(1, tick)
    assert moment is not None
    before = [each.id for each in recording.orders(1) if each.tick < tick]
    state = base64.b64encode(moment.state).decode()
    after = max(before, default=0)
    return {"branch": 1, "tick": tick, "after": after, "state": state, "order": order}


def test_the_marks_still_to_be_had_are_those_of_the_debrief(
    recording: Recording, kept: Path
) -> None:
    debrief = gather_debrief(recording, kept, None)
    run = RunExplorer(debrief.plan, debrief.trajectory, partial(judge_as_changed, debrief))
    run.fly_again()
    evaluator = Evaluator.of(recording, kept)
    ticks = range(0, run.last, 120)
    found = [evaluator.answer(asked(recording, tick))["marks"] for tick in ticks]
    assert found == [run.point(tick).marks for tick in ticks]
    assert max(found) - min(found) > 50.0


def test_time_that_goes_back_is_followed_from_where_the_orders_are_the_same(
    recording: Recording, kept: Path
) -> None:
    evaluator = Evaluator.of(recording, kept)
    ticks = (100, 240, 400, 160, 400)
    found = [evaluator.answer(asked(recording, tick))["marks"] for tick in ticks]
    assert found[2] == found[4] != found[1]
    alone = Evaluator.of(recording, kept).answer(asked(recording, 160))
    assert found[3] == alone["marks"]
    others = [each for each in recording.orders(1) if each.tick < 200]
    without, moment = others[1:], recording.moment(1, 190)
    assert moment is not None
    with pytest.raises(NoCurve, match="to the bit"):
        evaluator.follower.follow(without, 230, moment.state)


def test_a_wrong_order_costs_what_it_would_bring_and_one_that_is_refused_says_why(
    recording: Recording, kept: Path
) -> None:
    evaluator = Evaluator.of(recording, kept)
    alone = evaluator.answer(asked(recording, 180))
    blown = evaluator.answer(asked(recording, 180, "blow all"))
    assert blown["marks"] == alone["marks"]  # the run itself is not changed
    assert blown["with"] < alone["marks"] - 10.0
    assert blown["refused"] == ""
    still = evaluator.answer(asked(recording, 180, "compressor off"))
    assert still["with"] == pytest.approx(alone["marks"], abs=5.0)
    assert "greatest depth" in evaluator.answer(asked(recording, 180, "depth 2000"))["refused"]
    assert evaluator.answer(asked(recording, 180)) == alone


def test_what_the_instructor_has_ordered_since_is_told_beside_marks_that_are_not_for_it(
    tmp_path: Path,
) -> None:
    """The reference crew obeys it too, and the exercise's tasks do not ask for it."""
    ordered = [(62.0, "order course 020"), (100.0, "order course left 330")]
    path = record(tmp_path / "turn.trainer", "steady-course", ordered, who="instructor")
    with open_recording(path) as opened:
        evaluator = Evaluator.of(opened, path)
        before, after = (evaluator.answer(asked(opened, tick)) for tick in (190, 210))
    assert (before["beyond"], after["beyond"]) == ("", "order course left 330")
    assert after["marks"] < before["marks"] - 30.0
    with open_recording(path) as opened:
        debrief = gather_debrief(opened, path, None)
    run = RunExplorer(debrief.plan, debrief.trajectory, partial(judge_as_changed, debrief))
    curve = AttainableCurve((run.point(run.last),), (), 2, ordered_beyond(run.trajectory.orders))
    order = '"order course left 330", by instructor at 1:40'
    told = f"The marks are for the exercise's own orders, not for {order}."
    assert told in until_words(curve, 0.5)


def test_a_run_that_is_flown_on_without_marks_says_so_apart(tmp_path: Path) -> None:
    free = {20.0: "casualty stern-stuck"}
    path = record(tmp_path / "free.trainer", "first-depth-change", free, duration=40.0)
    with open_recording(path) as opened:
        line = json.dumps(asked(opened, 60))
    assert list(answers(path, iter([line]))) == [
        {"free": "free run since casualty stern-stuck at 0:20: backtrack for marks"}
    ]


def test_a_run_without_a_curve_says_why_on_every_line(tmp_path: Path) -> None:
    path = record(tmp_path / "alone.trainer", "wheel-and-course", {}, duration=1.0)
    with np.errstate(all="ignore"):
        told = list(answers(path, iter(["{}\n", "{}\n"])))
    assert told == [{"why": "this exercise has no reference crew"}] * 2
