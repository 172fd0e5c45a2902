"""How a session is conducted: its exercise's end, branches gone back to, who has command."""

import math
import os
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.crewed import PLACE, Begin, Crewed
from helpers.line import Line, fields_of

from trainer.boat.quantities import is_met, quantity_of
from trainer.cli.run import debriefing
from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.derived import ALL_QUANTITIES, Condition
from trainer.config.exercise.exercise import load_exercise
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run, progress_path
from trainer.config.files import shipped_names
from trainer.core.state import STATE
from trainer.io.orders.sentences import parse_sentence
from trainer.session.aside import CLOSE_MARGIN_S, answer_aside
from trainer.session.doors.alarm import Alarm
from trainer.session.exercise.marks import DebriefSource, Judgement, WrittenDebrief

# The end of an exercise


@pytest.mark.parametrize("name", shipped_names("exercises"))
def test_what_loses_a_shipped_exercise_is_watched(crewed: Begin, name: str) -> None:
    exercise = load_exercise(name)
    ship = crewed()
    boat, ending = ship.boat, ship.conduct.ending
    ending.expect(exercise.lost, exercise.heading.duration_s)
    assert ending.watched
    boat.state.z = 30.0
    ending.look()
    assert not ending.over
    down = ("depth", "clearance")
    boat.state.z = 400.0 if any(each.text.startswith(down) for each in exercise.lost) else -2.0
    boat.state.bottom[0] = 100.0
    lasts = max((each.seconds for each in exercise.lost), default=0.0)
    for _ in range(20 + round(lasts / boat.method.step)):
        ending.look()
    assert ending.outcome == (Outcome.LOST if exercise.lost else Outcome.UNDECIDED)


@pytest.mark.parametrize("quantity", ALL_QUANTITIES)
def test_any_quantity_of_a_condition_can_lose_an_exercise(crewed: Begin, quantity: str) -> None:
    boat = crewed().boat
    boat.state.z = 2.0  # the sail shows
    boat.state.bottom[0] = 50.0
    value = quantity_of(boat, quantity)
    assert math.isfinite(value)
    for sense, strict, threshold, met in (
        (1.0, True, value - 1e-3, True),
        (1.0, True, value, False),
        (1.0, False, value, True),
        (-1.0, True, value + 1e-3, True),
        (-1.0, False, value - 1e-3, False),
    ):
        assert is_met(Condition(quantity, sense, strict, threshold, "", PLACE), boat) is met


def test_when_time_is_up_all_stations_freeze_and_the_session_lives_on(drill: Crewed) -> None:
    helm = drill.comes("helm")

    drill.fly(20)

    assert drill.boat.ticks == 10
    assert drill.session.time.frozen
    assert not drill.session.control.ended
    assert drill.facts(helm, "exercise-over") == drill.facts(drill.instructor, "exercise-over")
    assert drill.events(helm, "time")[-1] == "EXERCISE OVER: time is up at 5 s"
    assert "the exercise is over" in drill.refused("run")
    assert "the exercise is over" in drill.refused("step 3")


def test_after_the_end_the_boat_obeys_nobody_until_it_goes_on(drill: Crewed) -> None:
    ballast, diving = drill.comes("ballast"), drill.comes("diving")
    drill.fly(20)
    state, journal = drill.boat.records.state.tobytes(), len(drill.recording.orders(1))

    refused = "the exercise is over: the instructor goes on"
    assert drill.refused("emergency blow", ballast) == refused
    assert drill.refused("order depth 30", diving) == refused
    assert drill.refused("depth 30").startswith("the exercise is over: again, ")
    assert drill.refused("casualty stern-stuck").startswith("the exercise is over: again, ")
    assert drill.boat.records.state.tobytes() == state
    assert len(drill.recording.orders(1)) == journal
    assert drill.say(diving, "report ready")[0] == "ok"  # words move nothing

    drill.order("again from 2 s")

    assert drill.say(ballast, "emergency blow")[0] == "ok"


def test_marks_go_to_the_instructor_first_and_to_all_when_released(drill: Crewed) -> None:
    helm = drill.comes("helm")
    assert "not over" in drill.refused("release marks")
    drill.fly(20)
    drill.settle(lambda: drill.conduct.marks.found)

    assert drill.facts(drill.instructor, "marks") == ["not reached,42.0"]
    assert drill.facts(helm, "marks") == []
    assert not any("42" in line for line in helm.sent)
    kept = drill.conduct.marks.kept
    change = f'  to change a mark: trainer debrief {kept} --change "NAME: WHAT, REASON"'
    assert drill.events(drill.instructor, "exercise")[-4:] == [
        *("marks: not reached, 42 marks of 100", "  branch 1: 42"),
        *("  Stern jam answered: does not count", change),
    ]

    drill.order("release marks")

    assert not any("Stern jam" in line or "--change" in line for line in helm.sent)

    assert drill.facts(helm, "marks") == ["not reached,42.0"]
    assert drill.events(helm, "marks") == ["marks: not reached, 42 marks of 100", "  branch 1: 42"]


def test_who_comes_after_the_end_is_told_it_and_the_marks_that_are_its_own(drill: Crewed) -> None:
    assert drill.facts(drill.comes("helm"), "exercise-over") == []
    drill.fly(20)
    drill.settle(lambda: drill.conduct.marks.found)

    helm, second = drill.comes("helm"), drill.comes("instructor")
    for late in (helm, second):
        assert drill.facts(late, "exercise-over") == ["ended"]
    assert drill.facts(helm, "marks") == []
    assert drill.facts(second, "marks") == ["not reached,42.0"]

    drill.order("release marks")
    assert drill.facts(drill.comes("planes"), "marks") == ["not reached,42.0"]

    drill.order("again from 2 s")
    assert drill.facts(drill.comes("helm"), "exercise-over") == []


def test_an_exercise_is_lost_by_its_rule_and_by_turning_over(crewed: Begin) -> None:
    ship = crewed(lost=["depth > 61"], seconds=60.0)
    helm = ship.comes("helm")
    ship.order("depth 200")
    ship.fly(119)
    assert ship.facts(ship.instructor, "exercise-over") == ["lost"]
    assert ship.events(ship.instructor, "exercise")[-1] == "lost: deeper than 61 m"
    assert ship.events(helm, "time")[-1] == f"EXERCISE OVER: lost at {ship.boat.time:g} s"
    assert not any("deeper than 61 m" in line for line in helm.sent)
    assert ship.boat.state.z > 61.0
    deep = [ship.recording.state_at(1, ship.boat.ticks - back) for back in (2, 3)]
    places = [np.frombuffer(state or b"", STATE)["z"][0] for state in deep]
    assert places[0] > 61.0 >= places[1]  # for a second: two ticks after the first beyond

    for angle, size in (("phi", 1.1), ("phi", -1.1), ("theta", 0.8), ("theta", -0.8)):
        other = crewed(seconds=60.0)
        other.fly(1)
        other.boat.state[angle] = size
        other.fly(1)
        assert other.conduct.ending.why == "turned over"


def test_the_instructor_ends_an_exercise_and_its_crew_hears_who_did(ship: Crewed) -> None:
    helm = ship.comes("helm")
    ship.fly(4)
    assert "instructor" in ship.refused("end exercise", helm)

    assert ship.order("end exercise") == "the exercise is over"

    assert ship.session.time.frozen
    assert ship.events(helm, "time")[-1].startswith("EXERCISE OVER: ended at 2 s by the instructor")
    assert "again" in ship.refused("end exercise")


def test_again_begins_a_new_branch_at_the_start_that_ends_at_its_time_anew(drill: Crewed) -> None:
    drill.order("snapshot beginning")
    drill.fly(20)
    drill.settle(lambda: drill.conduct.marks.found)
    assert "here is the end" in drill.refused("again from here")

    assert "frozen; branch 2 begins" in drill.order("again")
    assert drill.boat.ticks == 0
    assert not drill.conduct.ending.over
    assert drill.facts(drill.instructor, "back") == ["again"]
    drill.order("run")
    drill.fly(20)
    assert drill.boat.ticks == 10
    drill.settle(lambda: len(drill.facts(drill.instructor, "marks")) == 2)
    assert drill.events(drill.instructor, "exercise")[-3] == "  branch 2: 42"

    drill.order("again from 2 s")
    assert drill.boat.ticks == 6
    drill.order("again from here")
    drill.order("again from beginning")
    assert drill.boat.ticks == 0
    assert "here, beginning" in drill.refused("again from nowhere")


@pytest.mark.parametrize("lost", [False, True])
def test_a_jump_to_the_very_end_of_an_exercise_does_not_take_its_end_back(
    crewed: Begin,
    lost: bool,  # noqa: FBT001
) -> None:
    ship = crewed(lost=["depth > 1"] * lost, seconds=None if lost else 5.0)
    helm = ship.comes("helm")
    ship.fly(20)
    end, how = ship.boat.ticks, ship.conduct.ending.outcome
    assert how
    ship.order("snapshot last")

    for jump in ("restore last", "again from last", "branch 1"):
        ship.order(jump)

        assert (ship.boat.ticks, ship.conduct.ending.outcome) == (end, how)
        assert "the exercise is over" in ship.refused("rudder left 10", helm)
        assert "the exercise is over" in ship.refused("step 1")
        assert ship.facts(helm, "exercise-over")[-1] == how


def test_marks_of_a_flight_that_was_begun_again_meanwhile_are_told_to_nobody(drill: Crewed) -> None:
    drill.fly(20)
    assert drill.judged.wait(60.0)
    drill.session.control.ended = False
    drill.instructor.waiting = ["again"]
    for station in drill.session.event_log.stations:
        for asked in station.take(1):
            drill.session.dispatch.hear(asked)  # before what is done beside is taken
    drill.settle(lambda: True)

    assert drill.conduct.marks.found is None
    assert drill.facts(drill.instructor, "marks") == []


def test_a_debrief_is_written_beside_the_session_which_says_where(drill: Crewed) -> None:
    drill.session.time.pacer.run()
    assert "freeze" in drill.refused("debrief")
    drill.fly(20)

    assert "branch 1" in drill.order("debrief")
    drill.settle(lambda: drill.facts(drill.instructor, "debrief"))

    (path,) = drill.facts(drill.instructor, "debrief")
    assert path.endswith(".branch1.html")
    assert drill.facts(drill.instructor, "debriefing") == ["0.25", ""]
    assert "2,0:02: much was lost." in drill.facts(drill.instructor, "reason")


def test_who_trains_alone_has_a_debrief_written_at_the_end(drill: Crewed) -> None:
    trainee = drill.comes("trainee")
    drill.say(drill.instructor, "detach")
    assert "first end exercise" in drill.refused("debrief", trainee)
    drill.fly(20)
    drill.settle(lambda: drill.facts(trainee, "marks"))

    assert drill.say(trainee, "debrief")[0] == "ok"
    drill.settle(lambda: drill.facts(trainee, "debrief"))

    assert drill.facts(trainee, "debriefing") == ["0.25", ""]
    assert drill.facts(trainee, "reason")[-1] == "2,0:02: much was lost."


def hold_debrief(ship: Crewed) -> threading.Event:
    """Have no debrief written before the event that is returned."""
    may_write = threading.Event()

    def write(
        path: Path, branch: int, closing: threading.Event, share: Callable[[float], object]
    ) -> WrittenDebrief:
        assert may_write.wait(60.0)
        return ship._write(path, branch, closing, share)  # noqa: SLF001

    ship.conduct.marks.debriefing = DebriefSource(ship._judge, write)  # noqa: SLF001
    return may_write


def test_what_a_run_cost_is_not_told_of_one_that_has_taken_its_place(drill: Crewed) -> None:
    may_write = hold_debrief(drill)
    drill.fly(20)
    drill.settle(lambda: drill.facts(drill.instructor, "marks"))
    drill.order("debrief")
    drill.order("again")
    may_write.set()
    drill.settle(lambda: drill.facts(drill.instructor, "debrief"))

    assert "much was lost" not in str(drill.facts(drill.instructor, "reason"))


def test_one_debrief_is_written_at_a_time_and_marks_do_not_wait_for_it(drill: Crewed) -> None:
    """Twenty at once took 425 MB, and answers came after seconds."""
    may_write = hold_debrief(drill)
    assert "branch 1" in drill.order("debrief")
    assert "one is being written" in drill.refused("debrief")
    drill.order("run")
    drill.fly(20)
    drill.settle(lambda: drill.facts(drill.instructor, "marks"))
    assert "one is being written" in drill.refused("debrief")
    may_write.set()
    drill.settle(lambda: drill.facts(drill.instructor, "debrief"))
    assert "branch 1" in drill.order("debrief")  # and another may be asked for


@pytest.mark.process
def test_one_debrief_is_a_process_whose_failure_is_told_in_a_line(
    crewed: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(RuntimeError, match=r"no\.trainer.*No such file"):  # of the process
        debriefing().write(Path("no.trainer"), 1, threading.Event(), lambda _: None)
    ship = crewed(seconds=None)
    for program, told in (
        ("import sys; print('working', file=sys.stderr); sys.exit('no room')", "no room"),
        ("import os; os._exit(3)", "its process has ended with 3"),
        ("import threading; threading.Event().wait()", "the session ended before it was written"),
    ):

        def write(
            _path: Path,
            _branch: int,
            closing: threading.Event,
            share: Callable[[float], object],
            it: str = program,
        ) -> WrittenDebrief:
            return WrittenDebrief(answer_aside(("-c", it), closing, share))

        ship.conduct.marks.debriefing = DebriefSource(ship._judge, write)  # noqa: SLF001
        ship.order("debrief")
        if "threading" in program:
            monkeypatch.setattr("trainer.session.aside.CLOSE_TIMEOUT_S", CLOSE_MARGIN_S)
            ship.conduct.work.finish()
        ship.settle(partial(is_told, ship, f"no debrief: {told}"))


@pytest.mark.process
def test_the_share_of_a_debrief_is_heard_while_its_process_is_at_work(tmp_path: Path) -> None:
    """The process waits until a share of it has been heard, so that came before its end."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    program = (
        f"print(0.10); print(0.37, flush=True); open({str(pipe)!r}).read(); print('the \"answer\"')"
    )
    heard: list[float] = []

    def share(done: float) -> None:
        heard.append(done)
        pipe.write_text("heard", encoding="utf-8")

    assert answer_aside(("-c", program), threading.Event(), share) == 'the "answer"'
    assert heard == [0.37]


def is_told(ship: Crewed, news: str) -> bool:
    """Return whether the instructor has been told something of the exercise."""
    return news in ship.events(ship.instructor, "exercise")


def test_what_cannot_be_judged_is_told_and_ends_nothing(drill: Crewed) -> None:
    def fail(path: Path, branch: int) -> Judgement:
        raise ValueError(f"{path.name} {branch}")

    drill.conduct.marks.debriefing = DebriefSource(fail, drill._write)  # noqa: SLF001
    drill.fly(20)
    drill.settle(lambda: "no marks: 0.trainer 1" in drill.events(drill.instructor, "exercise"))
    assert "no marks yet" in drill.refused("release marks")


def test_another_exercise_follows_where_it_can_and_else_it_is_said_how(drill: Crewed) -> None:
    helm = drill.comes("helm")
    assert "quit, then trainer run backing" in drill.refused("next backing")

    drill.allow_next()
    drill.fly(2)
    assert "end exercise" in drill.refused("next backing")
    drill.fly(18)
    assert 'no exercise "nothing"' in drill.refused("next nothing")
    drill.order("next")
    assert drill.said[:2] == ["first-depth-change", "steady-course"]  # the course's order

    drill.order("next backing")

    assert drill.session.control.ended
    assert drill.session.control.following == "backing"
    assert drill.facts(drill.instructor, "next") == ["backing"]
    assert drill.facts(helm, "next") == [""]  # a file's name may tell what is hidden
    assert drill.events(helm, "time")[-1] == "the next exercise is being made ready"
    assert not any("backing" in line for line in helm.sent)


def test_next_is_for_who_trains_what_is_weakest_and_longest_ago(
    crewed: Begin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    run = ProgressRun("a", 1, "backing", "t", "2026", 60.0, Outcome.LOST, 12.0)
    done = [
        replace(run, exercise=each.name, outcome=Outcome.DONE, total=None) for each in lessons()
    ]
    for place, each in enumerate([run, *done]):
        add_run("Ann", replace(each, branch=place))
    ship = crewed(seconds=5.0)
    ship.allow_next()
    trainee = ship.comes("trainee")
    ship.say(ship.instructor, "detach")
    ship.fly(20)
    first = lessons()[0].name

    def answer() -> str:
        return ship.say(trainee, "next")[1]

    assert answer() == "next: the one after this"  # nobody's progress is kept
    assert ship.session.control.following == first

    training = ship.conduct.training
    training.terms = replace(training.terms, trainees=("Ann",))
    assert answer().startswith("next: 12 marks ")
    assert ship.session.control.following == "backing"

    training.terms = replace(training.terms, exercise="backing")  # which is not offered again
    assert answer() == "next: no marks in it yet, and the next of the course"
    assert ship.session.control.following == course()[0].name

    (passed,) = (each for each in ship.facts(ship.comes("trainee"), "exercise") if "done=" in each)
    assert (
        passed
        == "done=" + ",".join(f"{each.name}:done:passed" for each in lessons()) + ",exercise-9:12"
    )
    assert not any("done=" in each for each in ship.facts(ship.comes("helm"), "exercise"))

    progress_path("Ann").write_text("{", encoding="utf-8")
    assert answer() == "next: the one after this"


# Nothing is lost


def test_branches_are_listed_and_any_is_gone_back_to(ship: Crewed) -> None:
    ship.fly(6)
    ship.order("freeze")
    ship.order("rudder left 10")  # in the freeze, at the end of the branch
    left = ship.boat.records.state.tobytes()
    assert "branch 1 returns to where you were" in ship.order("reset")
    told = [each.split(",")[:4] for each in ship.facts(ship.instructor, "branch")]
    assert told == [["1", "", "0.000", "3.000"], ["2", "1", "0.000", "0.000"]]  # with the jump
    ship.fly(2)

    ship.order("branches")
    assert [text.split(":")[0] for text in ship.said] == ["branch 1", "branch 2"]
    assert ship.said[0] == "branch 1: from 0 s to 3 s; the start"
    assert ship.said[1].startswith("branch 2: from 0 s of branch 1 to 1 s; reset, by instructor")
    assert ship.said[1].endswith("; the present one")
    facts = ship.facts(ship.instructor, "branch")[-2:]
    assert facts[0] == "1,,0.000,3.000,the start"
    assert facts[1].startswith("2,1,0.000,1.000,reset")

    assert ship.order("branch 1") == "at the end of branch 1, 3 s; branch 3 begins"
    assert ship.boat.records.state.tobytes() == left
    assert ship.session.time.frozen
    assert ship.facts(ship.instructor, "back") == ["reset", "branch 1"]
    ship.fly(4)
    ship.order("branch 2")
    assert ship.boat.ticks == 2


def test_what_happened_on_a_branch_left_behind_is_not_counted(ship: Crewed) -> None:
    def counted() -> dict[str, list[float]]:
        return ship.session.monitors.times

    ship.fly(4)
    ship.session.monitors.limits.times["broached"] = [1.0, 2.0]
    ship.session.monitors.depths.times["test depth passed"] = [1.5]
    ship.fly(4)
    ship.order("backtrack 2.5 s")
    assert counted() == {"broached": [1.0], "test depth passed": [1.5]}
    ship.order("backtrack 1 s")
    assert counted() == {}
    ship.session.monitors.limits.times["followed"] = [0.5]
    ship.fly(2)
    ship.order("branch 1")
    assert counted() == {"broached": [1.0, 2.0], "test depth passed": [1.5]}
    ship.order("replay 1.5 s")
    assert counted() == {"broached": [1.0, 2.0], "test depth passed": [1.5]}


def test_a_branch_that_is_not_there_is_named_with_what_there_is(ship: Crewed) -> None:
    assert ship.refused("branch 99") == "no branch 99: there is 1 to 1; branches lists them"


def test_quit_asks_once_more_while_others_are_attached(crewed: Begin) -> None:
    ship = crewed(seconds=None)
    helm, ballast = ship.comes("helm"), ship.comes("ballast")

    asked = ship.refused("quit")
    assert (
        asked == "2 stations are attached: type quit again within 10 s to end it for all, or detach"
    )
    ship.now += 10.5
    assert ship.refused("quit") == asked
    ship.leaves(ballast)
    ship.now += 10.5
    assert ship.refused("quit").startswith("1 station is attached")
    ship.now += 9.5
    assert ship.order("quit") == "ending"
    assert ship.session.control.ended

    alone = crewed(seconds=None)
    assert alone.order("quit") == "ending"
    assert not helm.ended


# Who is there


def test_run_waits_for_nobody_and_tells_who_is_not_ready(ship: Crewed) -> None:
    helm, planes = ship.comes("helm"), ship.comes("planes")
    ship.comes("observer")
    ship.order("freeze")

    assert ship.say(helm, "ready") == ("ok", "ready; not ready: planes at line 3")
    assert ship.facts(ship.instructor, "ready") == ["helm at line 2"]
    assert ship.order("run") == "running"
    assert ship.events(helm, "station")[-1] == "not ready: planes at line 3"
    ship.fly(2)
    assert "has begun" in ship.refused("ready", planes)
    told = len(ship.events(helm, "station"))
    ship.order("freeze")
    ship.order("run")
    assert len(ship.events(helm, "station")) == told

    ship.order("reset")
    assert ship.say(planes, "ready") == ("ok", "ready; not ready: helm at line 2")
    assert ship.say(helm, "ready") == ("ok", "ready; everybody is")


def test_one_instructor_has_command_and_the_others_watch_and_mark(ship: Crewed) -> None:
    ship.order("freeze")
    second = ship.comes("instructor")

    assert ship.refused("run", second) == "line 1 has command: take command asks for it"
    assert ship.say(second, "mark well done")[0] == "ok"
    assert ship.events(ship.instructor, "mark") == ["mark by instructor at line 2: well done"]
    ship.order("freeze")
    assert ship.events(second, "time")[-1].startswith("instructor at line 1: freeze: frozen")
    assert ship.say(second, "status")[0] == "ok"

    assert "line 1 is asked" in ship.say(second, "take command")[1]
    assert ship.facts(ship.instructor, "asked") == ["line 2"]
    assert ship.order("keep command") == "you keep command"
    ship.now += 20.0
    assert "line 1 has command" in ship.refused("run", second)

    ship.say(second, "take command")
    ship.now += 9.0
    assert "line 1 has command" in ship.refused("run", second)
    ship.now += 1.5
    ship.session.attendance.listen()
    assert ship.say(second, "run") == ("ok", "running")
    assert ship.facts(second, "command")[-1] == "line 2"
    assert "line 2 has command" in ship.refused("freeze")

    assert ship.say(second, "give command") == ("ok", "line 1 has command")
    ship.order("freeze")
    ship.leaves(ship.instructor)
    ship.session.attendance.listen()
    assert ship.facts(second, "command")[-1] == "line 2"
    assert ship.say(second, "run") == ("ok", "running")


def test_command_that_the_session_s_only_instructor_has_cannot_be_given(ship: Crewed) -> None:
    assert ship.refused("give command") == "there is no other instructor"
    assert ship.refused("keep command") == "nobody has asked for command"
    assert ship.order("take command") == "you have command"


# What a channel has shown


def past(ship: Crewed, line: Line, channel: str) -> list[tuple[str, ...]]:
    """Return the rows of a channel between the marks of its past."""
    sent = [parse_sentence(each) for each in line.sent]
    marks = [
        place
        for place, each in enumerate(sent)
        if each and each.kind == "TRF" and each.fields[2] == "past"
    ]
    assert ship.facts(line, "past")[-2:] == [f"begin,{channel}", f"end,{channel}"]
    between = [each for each in sent[marks[-2] : marks[-1]] if each and each.kind == "TRS"]
    return [each.fields for each in between if each.fields[0] == channel]


def test_a_late_station_sees_what_its_gauges_showed_before_what_they_show(ship: Crewed) -> None:
    watch = ship.comes("observer")
    ship.say(watch, "subscribe gauges")
    ship.fly(400)
    ship.order("casualty depth-gauge-stuck")
    ship.order("depth 90")
    ship.fly(400)
    ship.order("freeze")
    ship.recording.flush()
    live = {fields[1]: fields for fields in fields_of(watch.sent, "TRS")}
    late = ship.comes("helm")
    ship.say(late, "subscribe gauges")
    rows = len([each for each in late.sent if each.startswith("$TRS")])

    assert ship.say(late, "history gauges 60 min")[0] == "ok"
    ship.settle(lambda: len(ship.facts(late, "past")) == 2)

    found = past(ship, late, "gauges")
    assert 200 < len(found) <= 361
    assert all(row == live[row[1]] for row in found if int(row[1]) > 0)
    assert len({row[3] for row in found if int(row[1]) > 401}) == 1  # the depth gauge is stuck
    after = [each for each in late.sent if each.startswith("$TRS,gauges")]
    assert len(after) == rows + len(found) + 1  # the live ones go on


class Narrow(Line):
    """A line that loses what is sent while it has no room, as a slow one does."""

    taken = 0  # lines before it is full

    def make_room(self, lines: int) -> None:
        """Have room for so many lines."""
        self.taken, self.room = len(self.sent) + lines, True

    def send(self, line: str) -> None:
        if line.startswith("$TRS") and not self.room:
            self.dropped += 1
        super().send(line)
        self.room = len(self.sent) < self.taken


def test_a_slow_line_loses_nothing_of_the_past(ship: Crewed) -> None:
    ship.fly(200)
    ship.order("freeze")
    ship.recording.flush()
    late = Narrow("a slow line", room=False)
    ship.attach(late, "helm")

    assert ship.say(late, "history gauges 60 min")[0] == "ok"
    time.sleep(0.1)  # in which the thread that sends would send
    assert not [each for each in late.sent if each.startswith("$TRS")]
    while "end,gauges" not in ship.facts(late, "past"):
        late.make_room(10)
        ship.settle(lambda: not late.room or "end,gauges" in ship.facts(late, "past"))
    assert [row[1] for row in past(ship, late, "gauges")] == [str(tick) for tick in range(201)]
    assert late.dropped == 0


def test_the_past_is_that_of_the_role_and_of_the_present_branch(ship: Crewed) -> None:
    ship.fly(20)
    ship.order("mark on the old branch")
    ship.order("backtrack 5 s")
    ship.order("mark on the new one")
    ship.order("casualty rudder-stuck")
    ship.fly(6)
    ship.order("freeze")
    helm, watch = ship.comes("helm"), ship.comes("observer")

    assert "not shown here" in ship.refused("history motion", helm)
    assert "no past" in ship.refused("history ledger")
    assert ship.refused("history gages", helm).startswith("no channel gages")
    ship.say(watch, "history events")
    assert ship.facts(watch, "mark") == ["on the new one"]
    before = len(ship.events(helm, "station") + ship.events(helm, "time"))
    before += len(ship.events(helm, "moment"))
    answer = ship.say(helm, "history events")[1]
    heard = len(ship.events(helm, "station") + ship.events(helm, "time")) - before
    heard += len(ship.events(helm, "moment"))
    assert answer == f"events: {heard} of them"
    assert not any("rudder-stuck" in line for line in helm.sent)
    other = ship.comes("instructor")
    ship.say(other, "history events")
    assert "casualty rudder-stuck" in ship.facts(other, "order")
    ship.recording.flush()
    ship.say(other, "history motion")
    ship.settle(lambda: "end,motion" in ship.facts(other, "past"))
    assert [row[1] for row in past(ship, other, "motion")] == [str(tick) for tick in range(17)]


def test_what_was_ordered_at_the_start_is_no_past_after_a_reset(ship: Crewed) -> None:
    ship.order("casualty rudder-stuck")
    ship.order("reset")
    ship.order("mark on the second way")
    other = ship.comes("instructor")

    ship.say(other, "history events")

    assert ship.facts(other, "order") == []
    assert ship.facts(other, "mark") == ["on the second way"]


def test_the_past_after_a_return_to_a_branch_is_that_of_this_branch(ship: Crewed) -> None:
    ship.fly(20)
    ship.order("mark on the first branch")
    ship.order("backtrack 5 s")
    ship.fly(5)
    ship.order("mark on the second")
    ship.order("branch 1")
    ship.order("mark on the third")
    late = ship.comes("observer")

    ship.say(late, "history events")

    assert ship.facts(late, "mark") == ["on the first branch", "on the third"]


def test_without_a_recording_the_past_is_what_memory_keeps(ship: Crewed) -> None:
    ship.conduct.past.kept = None
    ship.fly(100)
    ship.order("freeze")
    ship.order("history motion")
    ship.settle(lambda: len(ship.facts(ship.instructor, "past")) == 2)

    ticks = [row[1] for row in past(ship, ship.instructor, "motion")]
    assert ticks == ["20", "40", "60", "80", "100"]


# What waits for a while


def test_an_alarm_wakes_once_at_the_earliest_time_asked_for() -> None:
    woken: list[float] = []
    rung = threading.Event()

    def wake() -> None:
        woken.append(time.monotonic())
        rung.set()

    alarm = Alarm(wake)
    for after in (300.0, 200.0, 0.05, 0.1, 400.0):
        alarm.set(after)
    assert rung.wait(60.0)
    waiting = [each for each in threading.enumerate() if isinstance(each, threading.Timer)]
    for each in waiting:  # those that were to ring later wait for nothing
        each.join(60.0)
        assert not each.is_alive()
    rung.clear()

    alarm.set(0.05)  # it rings again when it is asked again

    assert rung.wait(60.0)
    assert len(woken) == 2


# A visitor


def test_a_visitors_restart_begins_the_exercise_again_and_time_goes_on_after_the_end_too(
    drill: Crewed,
) -> None:
    drill.conduct.muster.visitors = True
    visitor = drill.comes("visitor")
    begun = drill.boat.plain.tobytes()
    drill.fly(4)
    assert drill.say(visitor, "restart") == ("ok", "from the start, running; branch 2 begins")
    assert (drill.boat.plain.tobytes(), drill.session.time.frozen) == (begun, False)
    drill.fly(20)
    assert drill.conduct.ending.over

    drill.say(visitor, "restart")

    assert not drill.conduct.ending.over
    assert (drill.boat.time, drill.session.time.frozen) == (0.0, False)
    assert drill.facts(visitor, "back") == ["restart", "restart"]
    assert drill.facts(visitor, "exercise-over") == ["ended"]


def test_a_visitor_does_not_begin_the_run_of_a_crew_again(drill: Crewed) -> None:
    visitor, helm = drill.comes("visitor"), drill.comes("helm")
    drill.fly(4)
    before = drill.boat.plain.tobytes()

    why = "a visitor begins an exercise again only where its file has visitors = true"
    assert drill.refused("restart", visitor) == f"{why}: ask the instructor"

    assert (drill.boat.plain.tobytes(), drill.session.time.frozen) == (before, False)
    assert drill.facts(helm, "back") == []
    assert len(drill.recording.branches()) == 1
    assert drill.order("restart").startswith("from the start, running")


def test_a_station_is_called_by_a_name_of_its_own(drill: Crewed) -> None:
    wall = drill.comes("observer")
    assert drill.say(wall, "name wall") == ("ok", "this line is called wall")
    drill.order("who")
    assert any(f"observer at {wall.name}, called wall: 0 orders" in line for line in drill.said)
    assert drill.say(wall, "name <b>")[0] == "no"
    drill.order("who")
    assert any(f"observer at {wall.name}, called wall: " in line for line in drill.said)
