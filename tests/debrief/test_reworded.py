"""A debrief decides by fields: with every text of a recording in other words it is the same."""

import shutil
import sqlite3
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from helpers.recorded import record

from trainer.debrief.page.data import DebriefData, gather_debrief
from trainer.io.recording.recording import Recording

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

OTHER = "in other words"
REWORDED = (
    f"UPDATE orders SET answer = '{OTHER}', who = '{OTHER} ' || role",
    f"UPDATE branches SET why = '{OTHER}'",
    f"UPDATE events SET who = '{OTHER}' || role",
    f"UPDATE events SET text = '{OTHER}' WHERE kind != 'mark'",  # a remark is what somebody said
)
RUNS: dict[str, dict[float, str]] = {
    "depth-changes": {61.0: "depth 90 aye", 65.0: "depth 100 aye", 66.0: "stern planes dive 5"},
    "stern-plane-jam": {45.0: "emergency blow", 50.0: "mark too late"},
    "crossing-traffic": {40.0: "scope raise", 60.0: "mark contact 029"},
    "gyro-stuck": {30.0: "casualty stern-stuck", 40.0: "allow planes"},
}


def decided(debrief: DebriefData) -> dict[str, Any]:
    """Return what a debrief has decided, without its words."""
    card = debrief.card
    verdict = card.verdict
    return {
        "total": card.total,
        "outcome": verdict and (verdict.outcome, verdict.cap, verdict.free, verdict.void),
        "scores": [(each.name, each.marks, each.earned, each.nobody) for each in card.scores],
        "repeats": [
            (each.axis, each.repeated and each.repeated.tick, each.wrong, each.carried_out)
            for each in debrief.read_backs
        ],
        "casualties": [asdict(each.episode) for each in debrief.casualties],
        "answers": [each.order and each.order.id for each in debrief.casualties],
        "crew": [each.id for each in debrief.crew],
        "practice": bool(debrief.practice),
    }


@pytest.mark.slow
@pytest.mark.parametrize("exercise", RUNS)
def test_a_debrief_of_reworded_texts_decides_the_same(tmp_path: Path, exercise: str) -> None:
    path = record(tmp_path / "said.trainer", exercise, RUNS[exercise], who="diving at panel")
    other = Path(shutil.copy(path, tmp_path / "reworded.trainer"))
    with closing(sqlite3.connect(other, isolation_level=None)) as connection:
        for statement in REWORDED:
            assert connection.execute(statement).rowcount >= 0
    decisions = []
    for each in (path, other):
        with closing(Recording.look(each)) as recording:
            decisions.append(decided(gather_debrief(recording, each, None)))
    assert decisions[0] == decisions[1]
    assert decisions[0]["scores"]
    if exercise == "depth-changes":
        assert any(repeat[1] for repeat in decisions[0]["repeats"])
        assert any(repeat[2] for repeat in decisions[0]["repeats"])
