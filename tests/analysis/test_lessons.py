"""The lessons: flown by a newcomer who does what they say, and by one who does nothing."""

import functools
import math
import re
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.crewed import Begin, Crewed
from helpers.line import Line

from trainer.authoring.exercise_page import check_exercise
from trainer.authoring.stated import READING_TIMES_S, StepFlight, fly_steps
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.quantities import is_met, quantity_of
from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.derived import Condition
from trainer.config.exercise.exercise import load_exercise
from trainer.config.files import ConfigError, shipped_names
from trainer.console.client import Item
from trainer.console.drawing.panels import step_rows
from trainer.console.exercise import LessonStep
from trainer.console.model import SessionModel
from trainer.session.exercise.step_guide import StepGuide
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.run import briefing_of
from trainer.session.stations.roles import INSTRUCTOR_ROLE, ROLES

NAMES = [each.name for each in lessons()]
DRILL = """
schema = "exercise/1"
name = "Drill"
briefing = "Steer."
hand = ["rudder"]
[[steps]]
text = "Turn: `rudder right 10`."
when = ["rudder_deg > 8"]
within_s = 30
"""


STEP_S = 0.5  # [s] of the boats that fly here
HELD_S = 60.0  # [s] after the last step, with what it has ordered
SHOWN = {**dict.fromkeys(("course", "pitch", "bow"), math.degrees(1.0)), "heavy": 1e-3}  # from SI
ORDERED = {  # what each title orders, and the band in which it is held [m, deg, t]
    "wheel-and-course": {"course": (86.0, 94.0)},
    "planes-and-bubble": {"pitch": (-2.0, 2.0), "depth": (50.0, 70.0)},
    "fifteen-metres-down": {"depth": (73.0, 77.0), "pitch": (-2.0, 2.0)},
    "trim-by-hand": {"heavy": (-1.5, 1.0), "bow": (-4.0, 4.0), "depth": (58.0, 62.0)},
    "surface-and-dive": {"depth": (28.0, 32.0)},
    "jam-first-seconds": {"pitch": (-3.0, 3.0), "depth": (50.0, 80.0)},
    "surface-modes": {"pitch": (-3.0, 3.0), "depth": (57.0, 63.0)},
    "plant-that-dies": {"depth": (48.0, 52.0), "pitch": (-3.0, 3.0)},
}


def guards(plan: Plan) -> list[Condition]:
    """Return the conditions of depth that lose a lesson."""
    return [each for loss in plan.lost for each in loss.conditions if each.quantity == "depth"]


class Talk:
    """A line that says nothing."""

    def order(self, words: str) -> str:
        del words
        return ""

    def take(self) -> list[Item]:
        return []


@functools.cache
def planned(name: str) -> Plan:
    return plan_run(RunOptions(exercise=name))


@functools.cache
def flown(name: str, reading_s: float) -> tuple[list[StepFlight], Boat]:
    """Fly a lesson by its own text; return its steps, and the boat at their end."""
    boat = planned(name).launch_boat()
    return fly_steps(planned(name), boat, reading_s), boat


def at_sea(crewed: Begin, plan: Plan) -> tuple[Crewed, Line]:
    """Return a session of a lesson with nobody but a trainee in it."""
    ship = crewed(seconds=None, hand=frozenset(plan.hand), plan=plan)
    ship.leaves(ship.instructor)
    return ship, ship.comes("trainee")


def fly(ship: Crewed, most: int, act: Callable[[], None] = lambda: None) -> None:
    """Let time go on until the lesson is over, and have what is done between ticks taken."""
    ship.session.time.pacer.run()
    for _ in range(most):
        if ship.conduct.ending.over:
            return
        act()
        ship.session.tick()
        ship.session.attendance.listen()


def test_the_lessons_come_before_the_course() -> None:
    assert list(ORDERED) == NAMES
    assert [each.number for each in lessons()] == [*range(1, len(ORDERED) + 1)]
    assert not set(NAMES) & set(shipped_names("exercises"))
    assert all(each.steps >= 4 and each.hand for each in lessons())
    assert not any(each.steps for each in course())


@pytest.mark.parametrize("reading_s", READING_TIMES_S)
@pytest.mark.parametrize("name", NAMES)
def test_who_does_what_a_lesson_says_ends_each_of_its_steps_in_a_few_minutes(
    name: str, reading_s: float
) -> None:
    steps = planned(name).steps
    flights, _ = flown(name, reading_s)

    assert [each.done for each in flights] == [True] * len(steps)
    assert not [each.refused for each in flights if each.refused]
    for step, flight in zip(steps, flights, strict=True):
        assert flight.seconds > reading_s or not step.typed, step.row.text
        assert flight.seconds < 0.8 * step.row.within_s, step.row.text


@pytest.mark.parametrize("reading_s", READING_TIMES_S)
@pytest.mark.parametrize("name", NAMES)
def test_what_a_lesson_s_title_orders_is_reached_and_held_by_who_does_what_it_says(
    name: str, reading_s: float
) -> None:
    boat = planned(name).launch_boat()
    fly_steps(planned(name), boat, reading_s)
    bands = ORDERED[name]

    for _ in range(boat.ticks_in(HELD_S)):
        for quantity, (least, most) in bands.items():
            value = quantity_of(boat, quantity) * SHOWN.get(quantity, 1.0)
            assert least <= value <= most, f"{quantity} at {boat.time:g} s"
        boat.tick()


@pytest.mark.parametrize("name", ["planes-and-bubble", "fifteen-metres-down"])
def test_who_leaves_the_planes_at_dive_loses_the_lesson_before_the_boat_is_deep(
    crewed: Begin, name: str
) -> None:
    ship, trainee = at_sea(crewed, planned(name))
    ship.conduct.ending.expect(planned(name).lost, None)
    assert ship.say(trainee, "stern planes dive 6")[0] == "ok"
    fly(ship, 8000)

    assert ship.conduct.ending.outcome == "lost"
    assert quantity_of(ship.boat, "depth") < 101.0
    assert ship.facts(trainee, "steps-undone")


def test_each_lesson_has_an_envelope_that_its_own_text_never_nears() -> None:
    for name in NAMES:
        deepest = min(each.threshold for each in guards(planned(name)) if each.sense > 0.0)
        _, boat = flown(name, READING_TIMES_S[-1])
        assert quantity_of(boat, "depth") < deepest - 10.0, name


def test_the_lessons_take_less_than_half_an_hour() -> None:
    assert sum(each.seconds for name in NAMES for each in flown(name, 8.0)[0]) < 30 * 60


@pytest.mark.parametrize("name", NAMES)
def test_a_check_finds_nothing_wrong_in_a_lesson(name: str) -> None:
    assert any(line.startswith("step ") for line in check_exercise(name))


def led(crewed: Begin, name: str, reading: int) -> tuple[Crewed, Line]:
    """Fly a lesson by the texts that a station gets, each obeyed within ``reading`` [ticks]."""
    ship, trainee = at_sea(crewed, planned(name))
    done: list[str] = []

    def act() -> None:
        told = ship.facts(trainee, "step")
        if told and told[-1] not in done and ship.boat.ticks % reading == 0:
            done.append(told[-1])
            for words in re.findall(r"`([^`]+)`", told[-1]):
                assert ship.say(trainee, words)[0] == "ok", words

    fly(ship, 3000, act)

    assert ship.conduct.ending.over
    unread = [each for each in ship.facts(trainee, "step") if each not in done]
    assert not [each for each in unread if "`" in each], "what it says is over before it is read"
    return ship, trainee


# [ticks] at most before he does what is said
@pytest.mark.parametrize("reading", [3, pytest.param(12, marks=pytest.mark.slow), 16])
@pytest.mark.parametrize("name", NAMES)
def test_a_newcomer_at_a_station_is_led_to_the_end_by_the_texts_that_he_gets(
    crewed: Begin, name: str, reading: int
) -> None:
    ship, trainee = led(crewed, name, reading)

    count = len(planned(name).steps)
    assert [each.split(",")[0] for each in ship.facts(trainee, "step")] == [
        *map(str, range(1, count + 1)),
        "0",
    ]
    assert ship.conduct.ending.outcome == "done"
    assert not [text for text in ship.events(trainee, "lesson") if "not done" in text]


@pytest.mark.parametrize("reading", [pytest.param(40, marks=pytest.mark.slow), 56])
@pytest.mark.parametrize("name", NAMES)
def test_who_reads_for_half_a_minute_has_each_step_before_him_and_is_told_what_is_not_done(
    crewed: Begin, name: str, reading: int
) -> None:
    ship, trainee = led(crewed, name, reading)

    undone = [each.split(",")[1:] for each in ship.facts(trainee, "steps-undone")]
    steps = planned(name).steps
    hurried = [n for n, each in enumerate(steps) if each.row.within_s <= reading * STEP_S]
    # a course or a depth may be past by the last; what is asked at once, and what comes of it
    known = {str(len(steps)), *(str(n + more) for n in hurried for more in (1, 2))}
    assert bool(undone) == (ship.conduct.ending.outcome == "not done")
    assert not undone or set(undone[0]) <= known


@pytest.mark.parametrize("name", NAMES)
def test_who_does_nothing_is_told_and_is_never_stuck(crewed: Begin, name: str) -> None:
    ship, trainee = at_sea(crewed, planned(name))

    fly(ship, 8000)

    assert ship.conduct.ending.over
    told = ship.events(trainee, "lesson")
    assert any("not done" in text for text in told)
    assert any(text.startswith("hint: ") for text in told)
    again = [step for step in planned(name).steps if step.row.missed == "again"]
    assert ship.conduct.ending.outcome != "done"
    assert ship.facts(trainee, "steps-undone")
    backs = [each for each in told if "once more" in each]
    assert len(backs) <= 2 * len(again)
    assert bool(backs) == bool(again)


@pytest.mark.parametrize("name", NAMES)
def test_the_texts_of_a_lesson_fit_a_small_terminal(name: str) -> None:
    for step in planned(name).steps:
        model = SessionModel(Talk(), "trainee", ())
        hint = step.row.hint or ""
        model.exercise.step = LessonStep("1", "6", "", step.row.text, hint)
        assert len(step_rows(model, 80)) <= 6, step.row.text


# Lessons of one's own


def drill(tmp_path: Path, text: str) -> str:
    path = tmp_path / "drill.toml"
    path.write_text(text)
    return str(path)


def refused(tmp_path: Path, *changes: tuple[str, str]) -> str:
    text = DRILL
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(ConfigError) as wrong:
        check_exercise(drill(tmp_path, text))
    return str(wrong.value)


def test_a_check_flies_what_the_texts_say(tmp_path: Path) -> None:
    assert "step    Turn: `rudder right 10`." in check_exercise(drill(tmp_path, DRILL))


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("right 10", "left 10", "[steps[0]] when: never ends, flown by a newcomer"),
        ("[[steps]]", 'lost = ["depth > 50"]\n[[steps]]', "0.5 s later: depth > 50 loses"),
        ("[[steps]]", "duration_s = 5\n[[steps]]", "duration_s = 5.0: ends before its steps"),
        ("`rudder right 10`", "rudder right 10", "have the text say the orders, in backquotes"),
        ("rudder right 10", "rudder rihgt 10", "did you mean right?"),
        ("rudder right 10", "rudder right 90", "the boat refuses it"),
        ("rudder_deg > 8", "rudder_deg > 30", "this boat's rudder goes to 30 deg: it never ends"),
        ("rudder_deg > 8", "ruder_deg > 8", "no quantity 'ruder_deg'; nearest is rudder_deg"),
        (
            '["rudder_deg > 8"]',
            '["rudder_deg > 8", "rudder_deg < 6"]',
            "cannot hold at once: it never ends",
        ),
        ("within_s = 30", "within_s = 30\nfor_s = 30", "is not less than within_s: it never ends"),
        ("within_s = 30", 'within_s = 30\nlight = "ruder"', "light = "),
        ("within_s = 30", 'within_s = 30\nmissed = "back"', "missed"),
        ("within_s = 30", 'within_s = 30\norders = ["run"]', "has no place in a step"),
    ],
)
def test_a_step_that_nobody_can_end_is_refused_with_its_place(
    tmp_path: Path, old: str, new: str, why: str
) -> None:
    text = refused(tmp_path, (old, new))

    assert why in text
    assert text.startswith("drill.toml: line ")


# What is missed, and what is gone back to


@pytest.fixture
def missed(crewed: Begin, tmp_path: Path) -> tuple[Crewed, Line]:
    steps = 'within_s = 30\nmissed = "again"\norders = ["order course 040"]\n'
    second = '[[steps]]\ntext = "Amidships."\nwhen = ["rudder_deg < 1"]\nwithin_s = 10\n'
    text = DRILL.replace("within_s = 30\n", steps) + second
    return at_sea(crewed, plan_run(RunOptions(exercise=drill(tmp_path, text))))


def test_a_missed_step_begins_again_twice_with_its_orders_and_then_the_next_comes(
    missed: tuple[Crewed, Line],
) -> None:
    ship, trainee = missed
    fly(ship, 3 * 60 + 40)

    told = [text for text in ship.events(trainee, "lesson") if "step 1: " in text]
    assert told == [
        "step 1: not done; once more, from its beginning",
        "step 1: not done; once more, from its beginning",
        "step 1: not done; on to the next",
    ]
    assert ship.facts(trainee, "step-missed")[:3] == ["1,again", "1,again", "1,on"]
    assert len(ship.facts(trainee, "crew-order")) >= 3
    assert ship.session.history.recording.branch == 3
    assert ship.conduct.ending.over


def test_a_lesson_is_not_done_where_a_step_was_given_up_and_the_course_waits_for_a_choice(
    missed: tuple[Crewed, Line],
) -> None:
    ship, trainee = missed
    ship.allow_next()
    fly(ship, 3 * 60 + 40)
    after = lessons()[0].name  # of a lesson that is none of the course
    choice = f"step 1 is not done: again, or next {after} to go on"

    assert ship.conduct.ending.outcome == "not done"
    assert ship.facts(trainee, "exercise-over") == ["not done"]
    assert ship.facts(trainee, "steps-undone") == [f"{after},1"]
    assert ship.events(trainee, "lesson")[-2:] == ["the last step is over", choice]
    assert ship.say(trainee, "next") == ("no", choice)
    assert not ship.session.control.ended
    assert ship.facts(ship.comes("helm"), "steps-undone") == [f"{after},1"]  # who comes late
    assert ship.say(trainee, f"next {after}") == ("ok", f"next: {after}")


def test_a_step_that_is_done_when_it_is_flown_again_is_given_up_no_more(
    missed: tuple[Crewed, Line],
) -> None:
    ship, trainee = missed
    fly(ship, 3 * 60 + 40)
    assert ship.say(trainee, "again")[0] == "ok"
    ship.session.time.pacer.run()
    fly(ship, 4)
    assert ship.say(trainee, "rudder right 10")[0] == "ok"
    fly(ship, 20)
    assert ship.say(trainee, "rudder amidships")[0] == "ok"
    fly(ship, 40)

    assert ship.conduct.ending.outcome == "done"
    assert ship.conduct.guide.done
    assert ship.events(trainee, "lesson")[-1] == "the last step is done"


def test_a_step_that_was_given_up_stays_so_for_who_goes_back_after_it_or_takes_the_run_up_again(
    missed: tuple[Crewed, Line],
) -> None:
    ship, trainee = missed
    fly(ship, 2 * 60 + 20)
    assert ship.say(trainee, "rudder right 4")[0] == "ok"  # not enough for either step
    fly(ship, 60)
    guide = ship.conduct.guide
    assert (guide.index, guide.undone) == (1, [1, 2])
    assert ship.say(trainee, "backtrack 2 s")[0] == "ok"
    assert guide.undone == [1, 2]

    other = StepGuide(  # as in another process, which has the recording alone
        *(guide.control, guide.log, guide.work, guide.shown, guide.finish, str, guide.steps)
    )
    other.follow(ship.session.history.now())
    assert (other.index, other.undone) == (1, [1, 2])


def test_the_progress_of_a_lesson_says_done_only_if_each_step_is(
    missed: tuple[Crewed, Line], monkeypatch: pytest.MonkeyPatch
) -> None:
    ship, trainee = missed
    kept: list[str] = []
    monkeypatch.setattr(
        "trainer.session.exercise.training.begin_aside", lambda words: kept.append(words[-1])
    )
    training = ship.conduct.training
    assert training.terms.debriefing
    keeping = replace(training.terms.debriefing, progress=("keep",))
    training.terms = replace(training.terms, trainees=("Ann",), debriefing=keeping)
    fly(ship, 3 * 60 + 40)
    ship.settle(lambda: bool(kept))
    assert ship.say(trainee, "again")[0] == "ok"
    fly(ship, 4)
    assert ship.say(trainee, "rudder right 10")[0] == "ok"
    fly(ship, 20)
    assert ship.say(trainee, "rudder amidships")[0] == "ok"
    fly(ship, 40)
    ship.settle(lambda: len(kept) == 2)

    assert kept == ["not done", "done"]


def test_a_step_whose_past_cannot_be_read_goes_on_from_where_it_is(
    missed: tuple[Crewed, Line], monkeypatch: pytest.MonkeyPatch
) -> None:
    ship, trainee = missed
    fly(ship, 10)
    with monkeypatch.context() as broken, closing(sqlite3.connect(":memory:")) as empty:
        broken.setattr(ship.recording, "_connection", empty)
        fly(ship, 60)
        told = [text for text in ship.events(trainee, "lesson") if "cannot be read" in text]
        assert len(told) == 1
        assert told[0].startswith("not gone back: ")
        assert ship.boat.ticks == 70
    fly(ship, 3 * 60)
    assert ship.session.history.recording.branch == 2


def test_who_begins_anew_has_all_repeats_before_him(missed: tuple[Crewed, Line]) -> None:
    ship, trainee = missed
    for _ in range(2):
        fly(ship, 3 * 60 + 40)
        assert ship.say(trainee, "again")[0] == "ok"

    assert ship.facts(trainee, "step-missed").count("1,again") == 4


def test_who_trains_may_choose_a_lesson_by_its_name(crewed: Begin) -> None:
    ship = crewed(seconds=5.0)
    trainee = ship.comes("trainee")
    ship.leaves(ship.instructor)
    ship.allow_next()
    ship.fly(20)
    assert ship.say(trainee, "next trim-by-hand") == ("ok", "next: trim-by-hand")
    assert ship.session.control.following == "trim-by-hand"


def test_who_goes_back_in_time_is_at_the_step_of_that_time(missed: tuple[Crewed, Line]) -> None:
    ship, trainee = missed
    fly(ship, 10)
    assert ship.say(trainee, "rudder right 10")[0] == "ok"
    fly(ship, 20)
    assert ship.conduct.guide.index == 1

    assert ship.say(trainee, "backtrack 14 s")[0] == "ok"
    assert ship.conduct.guide.index == 0
    assert ship.facts(trainee, "step")[-1].startswith("1,2,")


# What the trainee is told, and what not


def test_who_trains_has_time_and_all_controls_unless_an_instructor_is_there(crewed: Begin) -> None:
    ship = crewed(seconds=5.0)
    trainee = ship.comes("trainee")
    assert "an instructor is here" in ship.refused("freeze", trainee)
    ship.leaves(ship.instructor)
    for words in ("run", "freeze", "rudder left 5", "blow all", "stern planes dive 3"):
        assert ship.say(trainee, words)[0] == "ok", words
    for words in ("casualty stern-stuck", "plans", "casualties", "release marks", "sea state 5"):
        assert ship.say(trainee, words)[0] == "no", words


def test_who_trains_alone_gets_the_marks_at_once_and_an_instructor_first_if_there(
    crewed: Begin,
) -> None:
    for alone in (True, False):
        ship = crewed(seconds=5.0)
        trainee = ship.comes("trainee")
        if alone:
            ship.leaves(ship.instructor)
        ship.fly(20)
        marks = ship.conduct.marks
        ship.settle(lambda marks=marks: bool(marks.found))  # type: ignore[misc]
        assert bool(ship.facts(trainee, "marks")) is alone


@pytest.mark.parametrize("name", [each.name for each in course()])
def test_nothing_that_the_instructor_alone_is_told_reaches_who_trains(name: str) -> None:
    exercise = load_exercise(name)
    briefing = briefing_of(planned(name), RunOptions(exercise=name))
    told = [*briefing.heading(ROLES["trainee"]), *map(str, briefing.facts(ROLES["trainee"], 0.0))]
    hidden = (exercise.heading.instructor or "").splitlines()
    assert hidden
    assert not [line for line in hidden if any(line in text for text in told)]
    assert any(hidden[0] in text for text in briefing.heading(INSTRUCTOR_ROLE))


def test_each_lesson_asks_for_what_it_says(crewed: Begin) -> None:
    """Whoever leaves an order out, or gives two in the wrong order, does the step again."""
    for name, done, wrong in (
        ("plant-that-dies", ["loads shed"], ["bus tie shut", "loads shed"]),
        ("jam-first-seconds", ["bell astern full", "bow planes rise 25"], ["bell astern full"]),
    ):
        for orders, index in ((done, 2), (wrong, 1)):
            ship, trainee = at_sea(crewed, planned(name))
            fly(ship, 24)
            assert ship.conduct.guide.index == 1
            for order in orders:
                assert ship.say(trainee, order)[0] == "ok"
            fly(ship, 36)
            assert (ship.conduct.guide.index >= 2) == (index == 2), (name, orders)


def test_air_is_saved_and_vents_are_shut_before_the_lesson_goes_on() -> None:
    blown, shut = (planned("surface-and-dive").steps[n].conditions for n in (2, 4))
    boat = planned("surface-and-dive").launch_boat()
    boat.plain[STATE_OFFSETS["blow_mid"]] = boat.plain[STATE_OFFSETS["vent_mid"]] = 1.0
    unmet = [[each.quantity for each in step if not is_met(each, boat)] for step in (blown, shut)]
    assert "blow" in unmet[0]
    assert "vent" in unmet[1]
