"""The choice of an exercise before there is a session."""

import contextlib
import math
import os
import re
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers.places import environment
from helpers.recorded import record
from helpers.screens import run_aside, typed
from textual import events
from textual.pilot import Pilot

from trainer.cli import run as command
from trainer.cli.main import cli
from trainer.cli.run import trained
from trainer.config.exercise.course import Lesson, course, lessons
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import Progress, ProgressRun
from trainer.config.files import shipped_names
from trainer.console.dialogs import NO_OUTCOME, DialogOutcome
from trainer.console.exercise_choice import (
    FREE_SAILING,
    I_INSTRUCT,
    I_TRAIN,
    ExerciseChoice,
    ExerciseScreen,
    SideThenExercise,
    choose_exercise,
    exercise_choice,
    side_choice,
)
from trainer.console.pane import Pane, plain
from trainer.session.past import header
from trainer.session.past.options import RunOptions

OFFERED = (
    Lesson(1, "depth-gauge-failure", "Periscope watch, in a sea", "Hold 17.5 m by hand."),
    Lesson(2, "first-depth-change", "Depth, first steps", "Depth changes,\nby hand."),
    Lesson(3, "stern-plane-jam", "Passage, fast and deep", "Course 000, 100 m."),
)


def chosen(*keys: str, size: tuple[int, int] = (80, 24)) -> tuple[DialogOutcome | None, str]:
    """Return how the screen ends when keys are pressed, and what it showed before the last."""
    screen = ExerciseScreen(SideThenExercise(lambda _: exercise_choice(OFFERED), I_TRAIN))
    text = ""

    async def press(pilot: Pilot[DialogOutcome]) -> None:
        nonlocal text
        await pilot.pause(0.1)
        await pilot.press(*keys[:-1])
        await pilot.pause(0.1)
        text = plain(screen.screen.query_one("#dialog", Pane).lines)
        await pilot.press(keys[-1])

    async def run() -> None:
        async with screen.run_test(size=size) as pilot:
            await press(pilot)

    run_aside(run())
    return screen.return_value, text


@pytest.mark.parametrize(
    ("keys", "wanted"),
    [
        (("enter",), DialogOutcome((FREE_SAILING,))),
        (("down", "enter"), DialogOutcome(("depth-gauge-failure",))),
        ((*typed("depth"), "enter"), DialogOutcome(("first-depth-change",))),
        ((*typed("WATCH"), "enter"), DialogOutcome(("depth-gauge-failure",))),
        ((*typed("jam"), "enter"), DialogOutcome(("stern-plane-jam",))),
        ((*typed("Stern-plane-jam"), "enter"), DialogOutcome(("stern-plane-jam",))),
        (("escape",), NO_OUTCOME),
    ],
)
def test_an_exercise_is_found_by_its_title_and_enter_alone_sails(
    keys: tuple[str, ...], wanted: DialogOutcome
) -> None:
    assert chosen(*keys)[0] == wanted


@pytest.mark.parametrize("size", [(80, 24), (200, 60)])
def test_the_list_shows_titles_and_briefings_and_no_file_that_tells_what_breaks(
    size: tuple[int, int],
) -> None:
    _, text = chosen("down", "down", "enter", size=size)
    for each in OFFERED:
        assert each.title in text
        assert each.name not in text
    assert "Depth changes, by hand." in text
    assert FREE_SAILING in text


def test_no_two_titles_are_alike_but_for_a_clause() -> None:
    titles = [each.title for each in (*lessons(), *course())]
    heads = [re.split(",| in | with ", title)[0] for title in titles]
    alike = {title for title, head in zip(titles, heads, strict=True) if heads.count(head) > 1}
    assert not alike


def test_the_list_says_how_many_rows_a_small_screen_hides() -> None:
    choice = exercise_choice([*lessons(), *course()], trains=True)
    rows = len(choice.rows)
    drawn = plain(choice.draw(74, 20))
    assert choice.advice[0] in drawn  # whole
    below = re.search(r"(\d+) more below", drawn)
    assert below
    shown = sum(row.name.split("  ")[0] in drawn for row in choice.rows)
    assert int(below[1]) == rows - 11
    assert shown >= 11
    for _ in range(rows):
        choice.press("down", None)
    assert f"{rows - 11} more above" in plain(choice.draw(74, 20))
    assert "more below" not in plain(choice.draw(74, 20))
    assert "more" not in plain(choice.draw(74, 60))


def test_letters_of_no_title_are_answered_and_do_nothing() -> None:
    done, text = chosen(*typed("xyz"), "enter", "escape")
    assert done == NO_OUTCOME
    assert "No title or name has these letters" in text


@pytest.mark.parametrize(
    ("done", "chosen"),
    [
        (DialogOutcome((FREE_SAILING,)), (I_TRAIN, "")),
        (DialogOutcome(("stern-plane-jam",)), (I_TRAIN, "stern-plane-jam")),
        (NO_OUTCOME, None),
    ],
)
def test_what_is_chosen_is_returned_by_its_name(
    done: DialogOutcome, chosen: tuple[str, str] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ExerciseScreen, "run", lambda _: done)
    assert choose_exercise(lambda _: exercise_choice(OFFERED), I_TRAIN) == chosen


@pytest.mark.parametrize("side", [I_TRAIN, I_INSTRUCT])
def test_keys_pressed_at_once_choose_the_side_and_then_from_its_list(side: str) -> None:
    def offer(told: str) -> ExerciseChoice:
        return exercise_choice(OFFERED, trains=told == I_TRAIN)

    subject = SideThenExercise(offer)
    screen = ExerciseScreen(subject)

    async def press() -> None:
        async with screen.run_test(size=(80, 24)) as pilot:
            await pilot.pause(0.1)
            for key in (*("down",) * (side == I_INSTRUCT), "enter", "down", "enter"):
                screen.post_message(events.Key(key, None))
            await pilot.pause(0.1)

    run_aside(press())
    assert subject.side == side
    names = {I_TRAIN: "first-depth-change", I_INSTRUCT: "depth-gauge-failure"}
    assert screen.return_value == DialogOutcome((names[side],))


def test_esc_at_either_list_leaves() -> None:
    for keys in (("escape",), ("enter", "escape")):
        subject = SideThenExercise(lambda _: exercise_choice(OFFERED))
        assert [subject.press(key, None) for key in keys][-1] == NO_OUTCOME


def test_the_command_offers_what_is_shipped_and_runs_what_is_chosen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str] = []

    def choose(offer: Callable[[str], ExerciseChoice], given: str) -> tuple[str, str] | None:
        told = given or side
        choice = offer(told)
        assert ("Kept on this machine" in choice.advice[-1]) is (told == I_TRAIN)
        asked[:] = [row.words for row in choice.rows if row.words != FREE_SAILING]
        return None if answer is None else (told, answer)

    side = I_INSTRUCT
    monkeypatch.setattr("trainer.console.exercise_choice.choose_exercise", choose)
    options = RunOptions()
    answer: str | None = "heavy-boat"
    wanted = replace(options, exercise="heavy-boat", given=frozenset({"exercise"}))
    assert command.choose(options) == wanted
    assert set(asked) == set(shipped_names("exercises"))
    assert asked == [each.name for each in course()]
    assert [each.number for each in course()] == [*range(1, len(asked)), math.inf]
    assert all(each.title and each.briefing for each in course())
    side = I_TRAIN
    assert command.choose(options) == replace(wanted, train=True)
    assert command.trained(command.choose(options)).frozen
    assert asked == [each.name for each in [*lessons(), *course()]]
    side = I_INSTRUCT
    answer = ""
    assert command.choose(options) == options
    answer = None
    with pytest.raises(SystemExit) as left:
        command.choose(options)
    assert left.value.code == 0
    answer, side = "heavy-boat", "nobody is asked"  # what the menu is told
    instructs = replace(options, instruct=True)
    assert command.choose(instructs) == replace(wanted, instruct=True)
    assert command.choose(replace(options, train=True)) == replace(wanted, train=True)


def test_the_list_tells_length_and_hand_and_who_trains_begins_with_a_lesson() -> None:
    rows = [row.name for row in exercise_choice([*lessons(), *course()], trains=True).rows]
    assert rows[0].split("  ")[0] == "Lesson 1: the wheel and the course"
    assert rows[0].endswith("10 steps  rudder")
    assert rows[len(lessons())].endswith("10 min  planes")
    assert rows[-1] == FREE_SAILING
    assert max(map(len, rows)) <= 71
    assert [row.name for row in side_choice().rows] == [I_TRAIN, I_INSTRUCT]


def shown_at_start(words: tuple[str, ...], wanted: bytes, question: bytes = b"") -> bytes:
    """Return what `trainer run` shows until ``wanted``; Enter twice is pressed at ``question``."""
    import fcntl  # noqa: PLC0415  not everywhere
    import pty  # noqa: PLC0415
    import struct  # noqa: PLC0415
    import subprocess  # noqa: PLC0415
    import termios  # noqa: PLC0415

    far, near = pty.openpty()
    fcntl.ioctl(near, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    plain_words = environment(TERM="xterm-256color")
    plain_words.pop("LC_ALL", None)
    with subprocess.Popen(
        [sys.executable, "-m", "trainer", "run", *words],
        stdin=near, stdout=near, stderr=near, env=plain_words, start_new_session=True,
    ) as process:  # fmt: skip
        os.close(near)
        late = threading.Timer(60.0, process.kill)
        late.start()
        shown = b""
        with contextlib.suppress(OSError):
            while wanted not in shown and (some := os.read(far, 65536)):
                shown += some
                if question and question in shown:
                    os.write(far, b"\r\r")
                    question = b""
        process.terminate()
        with contextlib.suppress(OSError):
            while os.read(far, 65536):
                pass
        late.cancel()
    os.close(far)
    return shown


@pytest.mark.process
@pytest.mark.long
@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_a_run_with_options_asks_nothing() -> None:
    shown = shown_at_start(("--no-record",), b"F1 shows help")
    assert b"F1 shows help" in shown
    assert b"I instruct" not in shown


@pytest.mark.process
@pytest.mark.clock
@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_a_run_without_options_asks_and_enter_twice_at_once_begins_the_first_lesson() -> None:
    wanted = b"Esc closes"  # the briefing of the lesson
    shown = shown_at_start((), wanted, b"I instruct")
    assert b"I instruct" in shown
    assert wanted in shown


def test_a_trainee_is_offered_what_is_weakest_and_told_why() -> None:
    run = ProgressRun("a", 1, "depth-gauge-failure", "t", "2026", 60.0, Outcome.WON, 88.0)
    begun = ProgressRun("b", 1, "first-depth-change", "t", "2026", 60.0, Outcome.LOST, 12.0)
    progress = Progress("Ann", (run, begun))
    choice = exercise_choice(OFFERED, trains=True, progress=progress)
    assert choice.order == "first-depth-change"
    assert choice.title == "Ann: 1 of 3 passed; next is chosen"
    text = plain(choice.draw(76, 22))
    assert re.search(r"   88  Periscope watch", text)
    assert re.search(r">    12  Depth, first steps", text)
    assert "Next: 12 marks today. Depth changes, by hand." in text
    assert "Kept on this machine as Ann; another: --trainee NAME" in text
    alone = exercise_choice(OFFERED, trains=True)
    assert "88" not in plain(alone.draw(76, 22))
    assert "trainer run --trainee NAME" in plain(alone.draw(76, 22))
    assert "trainer run --trainee NAME" not in text
    narrow = plain(alone.draw(56, 16))  # of a terminal of 60 columns
    assert "Esc leaves" in narrow
    assert "trainer run --trainee NAME" in narrow


def test_who_trains_is_remembered_by_the_name_of_his_account(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("getpass.getuser", lambda: "ann")
    alone = RunOptions(train=True)
    assert trained(alone).trainee == ("ann",)
    assert trained(replace(alone, trainee=("Bo",))).trainee == ("Bo",)
    assert trained(replace(alone, no_record=True)).trainee == ()
    assert trained(RunOptions()).trainee == ()
    monkeypatch.setattr("getpass.getuser", lambda: "CORP\\ann")  # no name of a file
    assert trained(alone).trainee == ()


@pytest.mark.parametrize("alone", [False, True])
@pytest.mark.parametrize(("names", "told"), [(("Ada",), ("Ada",)), ((), ("ann",))])
def test_who_sat_there_goes_on_under_the_name_of_the_recording_unless_another_does(
    *,
    names: tuple[str, ...],
    told: tuple[str, ...],
    alone: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, name = tmp_path / "a.trainer", "first-depth-change"
    kept = record(path, name, {}, duration=1.0, trainee=names, train=alone)
    begun: list[RunOptions] = []
    monkeypatch.setattr(header, "account_names", lambda: ("ann",))
    monkeypatch.setattr(command, "set_out", lambda asked, *_, **__: begun.append(asked))
    for words in ([], ["--train"], ["--instruct"]):
        assert CliRunner().invoke(cli, ["resume", str(kept), *words]).exit_code == 0
    trains, instructs = (True, told), (False, ())
    before = trains if alone else instructs
    assert [(each.train, each.trainee) for each in begun] == [before, trains, instructs]
    assert CliRunner().invoke(cli, ["resume", str(kept), "--train", "--instruct"]).exit_code == 2
