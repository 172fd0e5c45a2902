"""The screen of who trains alone: the step of a lesson, the end of an exercise, typing."""

import math

import pytest
from helpers.screens import ScriptedLine, run_aside
from textual.events import Key
from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.drawing.panels import trainee
from trainer.console.entry import Entry
from trainer.console.exercise import LESSON_END
from trainer.console.guide import EndView, briefing, steps_after
from trainer.console.keys import KEYS
from trainer.console.layouts import LAYOUTS
from trainer.console.model import SessionModel
from trainer.console.pane import plain
from trainer.io.orders.grammar import Refused
from trainer.io.orders.sentences import names, state


def told(*facts: tuple[str, str, str]) -> tuple[SessionModel, ScriptedLine]:
    line = ScriptedLine(*facts)
    model = SessionModel(line, "trainee", LAYOUTS["trainee"].charts)
    model.hear()
    return model, line


def time_now(model: SessionModel, line: ScriptedLine, tick: int, word: str) -> None:
    """Let the session tell whether time runs."""
    line.say(names("time", [("time", "")]), state("time", tick, tick / 2.0, [word]))
    model.hear()


STEP = ("0.5", "step", "2,6,stern,Dive, now: `stern planes dive 5`.")


def test_a_step_stands_above_the_panel_with_its_hint_and_lights_up_its_instrument() -> None:
    model, _ = told(STEP, ("20.0", "step-hint", "The Down key."))

    lines = trainee(model, 80, 17)

    assert "step 2 of 6  Dive, now: `stern planes dive 5`." in plain(lines)
    assert "hint: The Down key." in plain(lines)
    lit = {text.strip() for line in lines for text, ink in line if ink == "new"}
    assert lit == {"step 2 of 6", "stern"}


def test_a_new_step_takes_the_hint_away_and_the_last_one_the_text() -> None:
    model, _ = told(STEP, ("20.0", "step-hint", "The Down key."), ("30.0", "step", "3,6,,Wait."))
    assert model.exercise.step.hint == ""
    model, _ = told(STEP, ("40.0", "step", "0"))
    assert model.exercise.step == LESSON_END
    assert "step" not in plain(trainee(model, 80, 17))


def test_a_lesson_with_a_step_undone_says_which_and_lets_who_trains_choose() -> None:
    model, line = told(
        ("200.0", "step", "0"),
        ("200.0", "exercise-over", "not done"),
        ("200.0", "steps-undone", "planes-and-bubble,2,4"),
    )
    time_now(model, line, 400, "frozen")

    steps = steps_after(model)

    assert next(iter(steps)) == "a"
    assert (steps["n"].order, steps["n"].asked) == ("next planes-and-bubble", True)
    drawn = plain(EndView(model).draw(80, 24))
    assert "not done: steps 2, 4; lessons have no marks" in drawn
    assert "on all the same: planes-and-bubble" in drawn
    model.exercise.go_on()
    assert steps_after(model)["n"].order == "next"


def test_after_the_marks_the_way_leads_to_where_it_went_wrong_and_to_the_next() -> None:
    model, line = told(
        ("600.0", "exercise-over", "ended"),
        ("600.0", "marks", "not reached,61.0"),
        ("600.0", "reason", ",Time to 75 m: 40"),
        ("600.0", "reason", "210,cost most: too late"),
        ("600.0", "reason", "400,cost most: too deep"),
    )
    time_now(model, line, 1200, "frozen")

    steps = steps_after(model)

    assert steps["w"].order == "again from 405 s"
    assert "03:15" in steps["w"].does
    assert steps["n"].order == "next"
    assert "r" not in steps
    assert "cost most: too late" in plain(EndView(model).draw(80, 24))


@pytest.mark.parametrize("role", ["trainee", "instructor"])
def test_the_window_of_an_exercise_tells_how_much_of_its_debrief_is_written(role: str) -> None:
    facts = (("600.0", "exercise-over", "ended"), ("600.0", "debriefing", "0.41"))
    line = ScriptedLine(*facts)
    model = SessionModel(line, role, LAYOUTS[role].charts)
    model.hear()
    window = EndView(model)
    assert "the debrief is being written: 41%" in plain(window.draw(80, 24))
    held = "being calculated; an instructor who is here has them first"
    assert (held in plain(window.draw(96, 24))) == (role == "trainee")
    model.clock = lambda: math.inf
    assert window.press("d", "d") is None  # it stays open, and is told
    assert line.orders[-1] == "debrief"

    line.items += ScriptedLine(
        ("600.0", "debriefing", ""),
        ("600.0", "debrief", "drill.html"),
        ("600.0", "reason", "71.5,1:11: 30 marks lost"),
    ).items
    model.hear()
    drawn = plain(window.draw(80, 24))
    assert "being written" not in drawn
    assert ": drill.html" in drawn
    assert "1:11: 30 marks lost" in drawn


@pytest.mark.parametrize("role", ["trainee", "instructor"])
def test_quit_quits_in_the_window_of_an_exercise_that_is_over(role: str) -> None:
    line = ScriptedLine(("600.0", "exercise-over", "ended"))
    model = SessionModel(line, role, LAYOUTS[role].charts)
    model.hear()
    window = EndView(model)
    assert " Q " in plain(window.draw(80, 24))
    model.clock = lambda: math.inf

    outcome = window.press("q", "q")
    assert outcome
    assert outcome.orders == ("quit",)


def test_enter_begins_at_the_briefing_of_who_trains_while_time_stands() -> None:
    model, line = told()
    time_now(model, line, 1, "frozen")

    window = briefing(model)

    assert "Enter begins" in plain(window.draw(80, 24))
    for key in ("enter", "r"):
        outcome = window.press(key, None)
        assert outcome
        assert outcome.orders == ("run",)
    over = ScriptedLine(("1.0", "exercise-over", "ended"))  # which freezes time too
    line.items += over.items
    time_now(model, line, 1, "frozen")
    assert "Enter begins" not in plain(briefing(model).draw(80, 24))
    time_now(model, line, 2, "running")
    assert "Enter begins" not in plain(briefing(model).draw(80, 24))


def test_who_begins_to_type_types_and_no_letter_of_an_order_moves_a_control() -> None:
    model, line = told()
    screen = Console(model)

    async def press(pilot: Pilot[Refused]) -> None:
        await pilot.pause(0.2)
        for letter in "bow planes rise 15":  # not pressed, which waits a second for each
            screen.post_message(Key({" ": "space"}.get(letter, letter), letter))
        await pilot.pause(0.1)
        assert screen.query_one(Entry).value == "bow planes rise 15"
        await pilot.press("enter")
        await pilot.pause(0.1)

    async def run() -> None:
        async with screen.run_test(size=(80, 24)) as pilot:
            await press(pilot)

    run_aside(run())
    assert line.orders[-1] == "bow planes rise 15"


def test_letters_that_are_keys_begin_no_order_that_a_lesson_has_typed() -> None:
    letters = {name for key in KEYS["trainee"] for name in key.names if len(name) == 1}
    assert {each for each in letters if each.isalpha()} == {"m", "z", "x"}
