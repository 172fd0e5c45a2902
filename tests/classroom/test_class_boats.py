"""The boats of a class: one dies and comes back, all end in order, all go on another day."""

import signal
from pathlib import Path

import pytest
from helpers.classes import Class, class_at_sea, kill, listens
from helpers.waiting import await_that
from soak.session_process import Caller

from trainer.classroom.fleet import Fleet
from trainer.config.class_file import ClassFile

pytestmark = pytest.mark.process


def await_tick(boat: Caller, tick: int) -> None:
    """Wait until a boat says that it is at a tick."""
    assert boat.ask("subscribe time")[0]
    await_that(lambda: boat.ask("who")[0] and boat.tick == tick, lambda: str(boat.tick))


def flown(boat: Caller, ticks: int) -> None:
    assert boat.ask(f"step {ticks}")[0]


def test_a_boat_whose_process_dies_comes_back_where_it_was_and_the_others_notice_nothing() -> None:
    with class_at_sea("depth-changes", "--boats", "2", boats=2) as lesson:
        first, second = lesson.attach(1), lesson.attach(2)
        assert first.ask("order depth 80")[0]
        flown(first, 20)
        assert first.ask("order depth 90")[0]  # what is kept goes to here, and may go no further
        await_tick(first, 20)
        before = lesson.process_of(2)
        kill(lesson.process_of(1))
        await_that(lambda: "boat 1 has died (by signal 9)" in lesson.text(), lesson.text)
        await_that(lambda: listens(lesson.socket(1)))

        await_tick(lesson.attach(1), 20)
        assert second.ask("who")[0]
        assert lesson.process_of(2) == before
        assert "boat 2 has" not in lesson.text()
        kept = sorted(lesson.folder.glob("boat-*/*.trainer"))
        assert [path.parent.name for path in kept] == ["boat-1", "boat-2"]
        see_all_boats_go_on(lesson)


def see_all_boats_go_on(lesson: Class) -> None:
    """End a class by Ctrl-C, and see that another has its boats where they were."""
    assert lesson.end(signal.SIGINT) == 0
    assert "trainer class --resume" in lesson.text()
    assert not lesson.processes()
    assert not [*lesson.folder.glob("boat-*/*-wal")]
    with class_at_sea("--resume", str(lesson.folder), boats=2, folder=lesson.folder) as again:
        for number, tick in ((1, 20), (2, 0)):
            boat = again.attach(number)
            await_tick(boat, tick)
        assert boat.ask("quit")[0]
        await_that(lambda: "boat 2 has ended" in again.text(), again.text)
        assert "boat 1 has ended" not in again.text()
        see_nothing_outlive(again)


def see_nothing_outlive(lesson: Class) -> None:
    """Kill the class itself, and see that its boats end in order."""
    kill(lesson.process.pid)
    await_that(lambda: not lesson.processes(), lesson.processes)
    assert not [*lesson.folder.glob("boat-*/*-wal")]


def test_a_boat_that_cannot_go_to_sea_is_told_with_the_reason(tmp_path: Path) -> None:
    told: list[str] = []
    planned = ClassFile(exercise=str(tmp_path / "none.toml"), boats=1)
    fleet = Fleet(planned, tmp_path, tmp_path, (), told.append)
    fleet.begin()
    fleet.await_end()

    assert len(told) == 1
    assert told[0].startswith("boat 1 cannot go to sea: trainer: ")
    assert "none.toml" in told[0]
