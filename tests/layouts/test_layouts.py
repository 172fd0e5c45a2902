"""Commands over recordings of any layout of state, whole ones and damaged ones."""

import math
import random
from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest

from layouts.machine import play
from layouts.recordings import RELEASED, number_more, opened, put_released
from trainer.config.files import ConfigError
from trainer.session.past.options import RunOptions
from trainer.session.replay import replay_file
from trainer.session.resume import resume_boat

SEEDS: Final = (0, 5, 7, 11, 12, 17, 19)  # each kind of recording once; the nightly plays hundreds
GOING_ON: Final = RunOptions(headless=True, speed=math.inf, duration=60.0, priority="normal")
NEWEST: Final = max(RELEASED)
DAMAGES: Final = {
    "a tick is missing": "DELETE FROM states WHERE branch = 1 AND tick = 5",
    "a branch begins with a number": "UPDATE branches SET state = 7 WHERE id = 2",
    "an order was given by nobody": "UPDATE orders SET giver = 'nobody' WHERE branch = 1",
}
SHORT_STATES: Final = {
    "a state": "UPDATE states SET state = x'00' WHERE branch = 1 AND tick = 5",
    "a branch's first state": "UPDATE branches SET state = x'00' WHERE id = 2",
    "a snapshot": "UPDATE snapshots SET state = x'00'",
}


@pytest.mark.process
@pytest.mark.long
@pytest.mark.parametrize("seed", SEEDS)
def test_no_command_ruins_a_recording(seed: int, tmp_path: Path) -> None:
    desk = tmp_path / "desk"
    desk.mkdir()
    assert play(seed, desk).wrong == []


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_a_replay_finds_damaged_is_not_gone_on_with(damage: str, tmp_path: Path) -> None:
    path = put_damaged(tmp_path, DAMAGES[damage])
    before = path.read_bytes()

    with pytest.raises(ConfigError) as replayed:
        replay_file(path, {}, anyway=True, as_json=False)
    with pytest.raises(ConfigError) as resumed:
        resume_boat(path, GOING_ON, anyway=True)
    assert str(resumed.value) == str(replayed.value)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == before


@pytest.mark.parametrize("which", SHORT_STATES)
def test_a_state_cut_short_is_told_before_anybody_goes_back_to_it(
    which: str, tmp_path: Path
) -> None:
    path = put_damaged(tmp_path, SHORT_STATES[which])
    with pytest.raises(ConfigError, match="a state of 1 bytes"):
        resume_boat(path, GOING_ON, anyway=True)


def put_damaged(folder: Path, damage: str) -> Path:
    """Put a recording there to which a statement has been done."""
    path = folder / "old.trainer"
    put_released(NEWEST, path)
    with opened(path) as connection:
        connection.execute(damage)
    return path


def test_a_run_that_is_refused_leaves_no_copy(tmp_path: Path) -> None:
    path = tmp_path / "old.trainer"
    put_released(NEWEST, path)
    number_more(path, random.Random(1))  # noqa: S311 no secrets
    before = path.read_bytes()
    with pytest.raises(ConfigError):
        resume_boat(path, replace(GOING_ON, csv_path=tmp_path / "no" / "x.csv"), anyway=True)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == before


def test_each_copy_has_a_name_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "old.trainer"
    put_released(NEWEST, path)
    number_more(path, random.Random(1))  # noqa: S311 no secrets
    for names in ({"old-2.trainer"}, {"old-2.trainer", "old-3.trainer"}):
        resume_boat(path, GOING_ON, anyway=True)
        assert {each.name for each in tmp_path.glob("old-*.trainer")} == names
