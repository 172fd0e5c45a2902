"""Recordings that programs before this one wrote are opened, replayed, and refused with a word.

``tests/data/recordings/README.md`` says how each was made.
"""

import lzma
import math
import sqlite3
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pytest
from helpers.places import TESTS

from trainer.config.files import ConfigError
from trainer.core.digest import same_core
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import MARK_KIND, RecordedOrder, Recording
from trainer.session.past.header import differences, notes
from trainer.session.past.layout import LAYOUT
from trainer.session.past.options import RunOptions
from trainer.session.replay import replay_anyway, replay_file
from trainer.session.resume import resume_boat

FOLDER: Final = TESTS / "data" / "recordings"


class OldRecording(NamedTuple):
    """What a recording of a program before this one holds, and what is flown otherwise now."""

    format: int
    core: str
    numbers: int  # of a state
    branches: Sequence[tuple[int | None, int, int]]  # the parent, the first tick, the last one
    parting: str  # of the first branch, "" where it is the same today

    def __str__(self) -> str:
        return f"format {self.format}, core {self.core}"


OLD: Final = {
    "0.1.0": OldRecording(
        1,
        "903b64a6d0ec99fb",
        414,
        ((None, 0, 73), (1, 28, 39), (2, 29, 84)),
        "tick 47: u was 5.066742",
    ),
    "0.2.0": OldRecording(
        2, "fbdb20f4c45be54b", 414, ((None, 0, 73), (1, 28, 37), (1, 27, 83)), ""
    ),
    "0.3.0": OldRecording(
        2, "43ed887495848b23", 481, ((None, 0, 73), (1, 28, 37), (1, 27, 81)), ""
    ),
}
OF_ANOTHER_CORE: Final = [name for name, each in OLD.items() if not same_core(each.core)]
ORDERED: Final = (  # on the first branch, by whom
    ("schedule", "planes manual"),
    ("instructor at console", "rudder left 10"),
    ("instructor at console", "casualty stern-slow 0.5 ramp 20 s"),
    ("instructor at console", "sea state 3"),
    ("instructor at console", "in 10 s depth 65 m"),
)
MARKED: Final = ("here", "end")
each_old = pytest.mark.parametrize("name", OLD)


@pytest.fixture
def old(name: str, tmp_path: Path) -> Path:
    """Return a recording of a program before this one."""
    path = tmp_path / f"{name}.trainer"
    path.write_bytes(lzma.decompress((FOLDER / f"{path.name}.xz").read_bytes()))
    return path


def format_of(path: Path) -> int:
    """Return the format of a recording, as its file says it."""
    with closing(sqlite3.connect(path)) as connection:
        (version,) = connection.execute("PRAGMA user_version").fetchone()
    return int(version)


def own_orders(recording: Recording, branch: int) -> list[RecordedOrder]:
    """Return the orders that were given on a branch itself."""
    return [order for order in recording.orders(branch) if order.branch == branch]


@each_old
def test_all_that_stands_in_it_is_read(name: str, old: Path) -> None:
    was = OLD[name]
    with closing(Recording.look(old)) as recording:
        branches = list(recording.branches())
        spans = [(each.parent, each.tick, recording.last_tick(each.id)) for each in branches]
        orders = own_orders(recording, 1)
        later = [order.text for each in branches[1:] for order in own_orders(recording, each.id)]
        marks = [event.text for event in recording.events() if event.kind == MARK_KIND]
        states = [len(list(recording.states(each.id))) for each in branches]

    assert format_of(old) == was.format
    assert spans == list(was.branches)
    assert [each.cause for each in branches] == [BranchCause.START, *2 * [BranchCause.JUMP]]
    assert [(str(order.giver), order.text) for order in orders] == list(ORDERED)
    assert all(order.accepted for order in orders)
    assert later == ["speed 9 kn", "course 010", "clear all"]
    assert marks == list(MARKED)
    assert all(count >= last - first for count, (_, first, last) in zip(states, spans, strict=True))


@each_old
def test_it_is_flown_again_and_who_flies_it_is_told_what_is_otherwise(name: str, old: Path) -> None:
    was = OLD[name]
    with closing(Recording.look(old)) as recording, np.errstate(all="ignore"):
        told = differences(recording.header())
        flights = replay_anyway(recording)

    other = any(f"recorded {was.core}: other equations" in each for each in told)
    assert other is (name in OF_ANOTHER_CORE)
    longer = any(f"recorded {was.numbers}; new: " in each for each in told)
    assert longer is (was.numbers < len(LAYOUT))
    assert [(each.answers, each.trouble) for each in flights] == 3 * [([], "")]
    assert all(each.compared for each in flights)
    partings = [str(each.parting) if each.parting else "" for each in flights]
    assert partings[1:] == ["", ""]
    assert partings[0].startswith(was.parting)
    assert bool(partings[0]) is bool(was.parting)


@pytest.mark.parametrize("name", OF_ANOTHER_CORE)
def test_one_of_another_core_is_refused_with_a_word_and_stays_as_it_is(
    name: str, old: Path
) -> None:
    before = old.read_bytes()
    options = RunOptions(headless=True, serve=False)

    refusals: Sequence[Callable[[], int]] = (
        lambda: replay_file(old, {}, anyway=False, as_json=False),
        lambda: resume_boat(old, options, anyway=False),
    )
    for refused in refusals:
        with pytest.raises(ConfigError) as error:
            refused()
        assert f"{old.name}: core " in str(error.value)
        assert OLD[name].core in str(error.value)
        assert "--anyway" in str(error.value)
        assert old.read_bytes() == before
        assert [each.name for each in old.parent.iterdir()] == [old.name]


@each_old
def test_it_goes_on_where_its_end_was_if_the_user_insists(name: str, old: Path) -> None:
    parent, first, last = OLD[name].branches[-1]
    seconds = 0.5 * last + 5.0
    options = RunOptions(headless=True, speed=math.inf, duration=seconds, priority="normal")
    before, copied = old.read_bytes(), OLD[name].numbers != len(LAYOUT)

    code = resume_boat(old, options, anyway=True)

    goes_on = old.with_name(f"{name}-2.trainer") if copied else old
    assert not copied or old.read_bytes() == before
    with closing(Recording.look(goes_on)) as recording:
        (*_, newest) = recording.branches()
        assert (newest.parent, newest.tick) == (parent, first)
        assert recording.last_tick(newest.id) == round(2 * seconds)
        assert not any("cannot" in each for each in notes(recording.header()))
    assert code in (0, 1)  # by the marks
    assert format_of(goes_on) == 2
    if not OLD[name].parting:
        assert replay_file(goes_on, {}, anyway=True, as_json=False) == 0
