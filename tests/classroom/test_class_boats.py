"""The boats of a class: one dies and comes back, all end in order, all go on another day."""

import contextlib
import json
import signal
from pathlib import Path

import pytest
from helpers.classes import Class, class_at_sea, kill, listens
from helpers.waiting import await_that
from soak.session_process import Caller

from trainer.classroom.fleet import Fleet
from trainer.cli.main import cli
from trainer.config.exercise.class_file import ClassFile
from trainer.config.files import ConfigError
from trainer.session.past.header import open_recording

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


SHORT = """\
schema = "exercise/1"
name = "Down"
duration_s = 5
briefing = "Stay where you are."

[initial]
speed_kn = 10
depth_m = 60
course_deg = 0

[[scores]]
name = "Depth"
measure = "rms"
quantity = "depth_m"
target = 60
full = 1
zero = 20
"""
FIRST, SECOND = "Down (short)", "Deep, then shallow (depth-changes)"
COURSE = """\
boats = 2
seeds = "by-boat"

[[course]]
exercise = "./short.toml"
reach = 60

[[course]]
exercise = "depth-changes"
"""


def sailed_by(boat: Caller) -> str:
    """Return the heading of the exercise that a boat sails, with the name of its file."""
    assert boat.ask("briefing")[0]
    return boat.said[0]


def test_each_boat_goes_on_in_the_course_and_is_there_after_a_kill_and_another_day(
    tmp_path: Path,
) -> None:
    (tmp_path / "short.toml").write_text(SHORT, encoding="utf-8")
    path = tmp_path / "tuesday.toml"
    path.write_text(COURSE, encoding="utf-8")
    with class_at_sea(str(path), boats=2) as lesson:
        first = lesson.attach(1)
        assert sailed_by(first) == FIRST
        assert first.ask("step 8")[0]
        assert "not over" in first.ask("next course")[1]
        assert first.ask("end exercise")[0]
        await_that(lambda: first.ask("next course")[0], lambda: str(first.said))
        first = once_there(lesson, 1, SECOND)
        flown(first, 7)
        assert first.ask("order depth 90")[0]  # so far it is kept
        for boat in (1, 2):
            kill(lesson.process_of(boat))
        await_that(lambda: lesson.text().count("has died (by signal 9)") == 2, lesson.text)
        await_tick(once_there(lesson, 1, SECOND), 7)
        second = once_there(lesson, 2, FIRST)
        assert second.ask("end exercise")[0]  # one that was resumed goes on as well
        assert second.ask("next depth-changes")[0]
        once_there(lesson, 2, SECOND)
        assert lesson.end() == 0
        assert seeds_of(lesson) == {1: {1}, 2: {2}}
        with class_at_sea("--resume", str(lesson.folder), boats=2, folder=lesson.folder) as again:
            for boat in (1, 2):
                once_there(again, boat, SECOND)


def once_there(lesson: Class, boat: int, exercise: str) -> Caller:
    """Return a line to a boat once it sails that exercise."""
    lines: list[Caller] = []

    def there() -> bool:
        with contextlib.suppress(Exception):
            lines.append(lesson.attach(boat))
            return sailed_by(lines[-1]) == exercise
        return False

    await_that(there, lambda: lesson.log(boat))
    return lines[-1]


def seeds_of(lesson: Class) -> dict[int, set[int]]:
    """Return the seeds of all recordings, by boats."""
    found: dict[int, set[int]] = {1: set(), 2: set()}
    for path in lesson.folder.glob("boat-*/*.trainer"):
        with open_recording(path) as recording:
            seed = json.loads(recording.header()["seed"])
        found[int(path.parent.name.removeprefix("boat-"))].add(seed)
    return found


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


@pytest.mark.parametrize(
    "given",
    [("--boats", "2"), ("--one-sea", "500"), ("--seed", "3"), ("--own-seeds",), ("--folder", "x")],
)
def test_a_class_that_goes_on_is_told_nothing_that_its_file_says(
    given: tuple[str, ...], tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=f"{given[0]}: a class goes on as .*class.toml says"):
        cli(["class", "--resume", str(tmp_path), *given], standalone_mode=False)
