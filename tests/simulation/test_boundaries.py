"""What goes on after a kill in the midst of an order is what was before it, or after it."""

from typing import Final, cast

import pytest

from simulation.boundaries import ROWS, Resumed, Whole, faults_of, kill_at, kill_at_each
from simulation.mutants import gather, with_fault

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # who is killed closes nothing
FEW_TURNS: Final = 8  # every eighth turn of some rows
MIDST: Final = {  # turns after the arrival, about the answer
    "snapshot A": range(7, 10),
    "ack all": range(10, 40),
}
SNAPSHOT: Final = "step 4|snapshot A"
ACKNOWLEDGED: Final = "casualty bus-port-lost|step 4|ack all"
CHANGED: Final = {  # by the order at the end of each row
    "order depth 90": {"state", "words"},
    "belay": {"words"},
    "in 10 s depth 80": {"plans"},
    "cancel all": {"plans"},
    "casualty bus-port-lost": {"state"},
    "ack all": {"alerts"},
    "snapshot A": {"snapshots"},
    "restore A": {"state", "tick", "branch", "branches", "plans", "words"},
    "backtrack 5 s": {"state", "tick", "branch", "branches", "plans", "words"},
    "mark here": {"marks"},
}


def ended(row: str) -> str:
    """Return the order at the end of a row."""
    return row.rpartition("|")[2]


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=ended)
def test_a_kill_at_each_turn_of_an_order_leaves_it_whole(row: str) -> None:
    resumed = list(kill_at_each(row, 1))

    assert not faults_of(resumed)
    assert set(resumed[0].whole.unlike(resumed[-1].whole)) == CHANGED[ended(row)]
    assert resumed[-1].answered
    assert len(resumed) > 15


@pytest.mark.long
@pytest.mark.parametrize("row", [ROWS[3], ROWS[7]], ids=ended)
def test_a_kill_at_every_eighth_turn_of_an_order_leaves_it_whole(row: str) -> None:
    resumed = list(kill_at_each(row, FEW_TURNS))

    assert not faults_of(resumed)
    assert set(resumed[0].whole.unlike(resumed[-1].whole)) == CHANGED[ended(row)]


@pytest.mark.long
def test_an_alert_that_was_answered_as_seen_is_seen_after_a_kill() -> None:
    kills = (kill_at(ACKNOWLEDGED, turns) for turns in MIDST["ack all"])
    resumed = next(each for each in kills if each.answered)

    assert [seen for _, _, seen in resumed.whole.alerts] == ["instructor"]


@pytest.mark.long
def test_a_snapshot_that_is_answered_before_it_is_written_is_found() -> None:
    gathered = with_fault(lambda patch: gather(patch, "snapshot"))
    resumed = [kill_at(SNAPSHOT, turns, gathered) for turns in (-1, *MIDST[ended(SNAPSHOT)])]
    resumed.append(kill_at(SNAPSHOT, 20))

    assert any(
        "snapshot 'a' of" in fault and "0 in the file" in fault for fault in faults_of(resumed)
    )


def test_what_is_neither_before_nor_after_is_told() -> None:
    states = {name: cast("object", None) for name in Whole._fields}
    before, between, after = (Whole(**{**states, "tick": tick}) for tick in (1, 2, 3))  # type: ignore[arg-type]

    def killed(*wholes: Whole, answered_at: int = 9) -> list[Resumed]:
        return [Resumed(i, i >= answered_at, whole, ()) for i, whole in enumerate(wholes)]

    assert not faults_of(killed(before, before, after, after, answered_at=2))
    assert "neither" in faults_of(killed(before, between, after))[0]
    assert "gone" in faults_of(killed(before, after, before, after))[0]
    assert "gone" in faults_of(killed(before, before, after, answered_at=1))[0]
