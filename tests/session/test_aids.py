"""The ghost and the predictor: where they are allowed, what they show, and to whom."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from helpers.crewed import Begin, Crewed
from helpers.line import Line, fields_of
from helpers.sessions import TIME_TO_65_M, start_plan

from trainer.boat.casualties import instrument_readings
from trainer.config.exercise.exercise import AIDS, load_exercise, parse_exercise
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError
from trainer.console.exercise import marks_in_words
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.io.orders.sentences import parse_sentence
from trainer.session.exercise import aids as exercise_aids
from trainer.session.exercise.marks import Judgement
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.stations.aids import Predictor
from trainer.session.stations.roles import ROLES

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")


def planned(exercise: str, *aids: str) -> Plan:
    """Return the plan of a shipped exercise that allows some aids."""
    plan = plan_run(RunOptions(exercise=exercise, given=frozenset({"exercise"})))
    return replace(plan, aids=aids)


def shown(line: Line, channel: str) -> Sequence[str]:
    """Return the fields that a station was sent of a channel last."""
    return [fields for fields in fields_of(line.sent, "TRS") if fields[0] == channel][-1][3:]


def switch_on(ship: Crewed, words: str) -> None:
    """Switch an aid on, and wait until it is there."""
    ship.order(words)
    aids = ship.session.shown
    aid = words.split(maxsplit=1)[0]
    ship.settle(lambda: aids.aids.ghost if aid == "ghost" else aids.aids.predictor)


@pytest.fixture
def allowing(crewed: Begin) -> Crewed:
    """Return a depth change that allows both aids."""
    return crewed(plan=planned("first-depth-change", *AIDS), seconds=None)


def test_the_ghost_is_the_reference_crews_run_from_the_start(allowing: Crewed) -> None:
    plan = planned("first-depth-change")
    run = fly_rehearsal(plan, plan.crew).trajectory.columns

    switch_on(allowing, "ghost on")

    ghost = np.array(allowing.session.shown.aids.ghost)
    assert len(ghost) == len(run["z"])
    assert np.array_equal(ghost[:, 0], run["z"])
    assert np.array_equal(ghost[:, 3], run["theta"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "role", sorted(name for name, role in ROLES.items() if {*AIDS} <= {*role.channels})
)
def test_no_role_sees_anything_of_an_aid_that_is_off(allowing: Crewed, role: str) -> None:
    line = allowing.instructor if role == "instructor" else allowing.comes(role)
    for channel in AIDS:
        assert allowing.say(line, f"subscribe {channel}")[0] == "ok"
    allowing.fly(4)
    assert not any((*shown(line, "ghost"), *shown(line, "predictor")))

    switch_on(allowing, "ghost on")
    switch_on(allowing, "predictor 30 s")
    allowing.fly(1)
    assert all(shown(line, "ghost"))
    assert shown(line, "predictor")[0] == "30"

    allowing.order("ghost off")
    allowing.order("predictor off")
    assert not any((*shown(line, "ghost"), *shown(line, "predictor")))


def test_an_exercise_that_does_not_allow_an_aid_shows_none_to_anybody(crewed: Begin) -> None:
    ship = crewed(plan=planned("first-depth-change", "ghost"), seconds=None)
    trainee = ship.comes("trainee")
    assert ship.refused("predictor 60 s").startswith("this exercise does not allow it")
    assert ship.refused("ghost on", trainee).startswith("an instructor is here")
    assert "is the instructor's" in ship.refused("ghost on", ship.comes("helm"))
    assert ship.refused("ghost off") == "ghost is off"
    assert ship.session.shown.aids.predictor is None


def test_a_free_run_has_the_predictor_and_is_told_that_it_has_no_ghost(crewed: Begin) -> None:
    ship = crewed(plan=plan_run(RunOptions()), seconds=None)
    assert ship.refused("ghost on").startswith("this free run has no reference crew")
    switch_on(ship, "predictor 60 s")
    assert ship.refused("predictor 5 s") == "5 s: a time ahead is 10 to 120 s"


def test_the_predictor_tells_where_the_boat_goes_if_nobody_does_anything(
    allowing: Crewed,
) -> None:
    ship = allowing
    ship.fly(10)
    ship.order("stern planes dive 5")
    predictor = Predictor(planned("first-depth-change").launch_boat(), 60.0)
    ahead = predictor.look_ahead(ship.boat.records.state.view(np.float64).tolist())

    now = ship.boat.time
    flown = []
    for point in ahead:
        ship.fly(round((now + point.seconds - ship.boat.time) / 0.5))
        reads = instrument_readings(ship.boat)
        flown.append((reads.depth, reads.heading, float(ship.boat.state.theta)))

    assert [each.seconds for each in ahead] == [5.0 * n for n in range(1, 13)]
    assert flown == [(each.depth, each.heading, each.pitch) for each in ahead]
    assert flown[-1][0] > 62.0


def test_the_predictor_knows_nothing_of_what_is_still_to_break() -> None:
    text = """
    schema = "exercise/1"
    name = "A jam to come"
    briefing = "Keep the depth."
    duration_s = 60
    [[casualties]]
    name = "stern-hard-over"
    severity = -0.5
    when = "time > 5"
    """
    plan = plan_run(RunOptions())
    exercise = parse_exercise(text, load_exercise("watch").path)
    armed = replace(plan, armed=exercise.armed)
    start = armed.launch_boat().records.state.view(np.float64).tolist()
    jammed = armed.launch_boat()
    for _ in range(120):
        jammed.tick()

    ahead = Predictor(armed.launch_boat(), 60.0).look_ahead(start)[-1]

    assert float(jammed.state.z) > 65.0
    assert ahead.depth == pytest.approx(60.0, abs=0.5)


def test_the_predictor_reads_the_gauges_as_they_will_lie(allowing: Crewed) -> None:
    ship = allowing
    ship.fly(4)
    stuck = instrument_readings(ship.boat).depth
    ship.order("casualty depth-gauge-stuck")
    ship.order("stern planes dive 8")
    predictor = Predictor(planned("first-depth-change").launch_boat(), 60.0)
    ahead = predictor.look_ahead(ship.boat.records.state.view(np.float64).tolist())
    assert {round(each.depth, 2) for each in ahead} == {round(stuck, 2)}
    assert math.degrees(ahead[-1].pitch) < -3.0


def test_an_aid_that_is_on_is_in_the_journal_of_each_branch_that_begins(allowing: Crewed) -> None:
    def journalled() -> list[str]:
        branch = allowing.recording.branch
        orders = allowing.recording.orders(branch)
        return [each.text for each in orders if each.accepted and each.branch == branch]

    allowing.fly(20)
    switch_on(allowing, "ghost on")
    allowing.fly(10)
    allowing.order("backtrack 12 s")
    assert journalled() == ["ghost on"]
    allowing.order("ghost off")
    allowing.order("again")
    assert journalled() == []
    switch_on(allowing, "ghost on")
    allowing.fly(5)
    allowing.order("replay 2 s")
    assert allowing.refused("ghost off") == "a replay is running: take over first"


def test_an_aid_that_could_not_be_made_is_told_and_made_when_it_is_asked_for_again(
    allowing: Crewed, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as broken:
        broken.setattr(exercise_aids, "Predictor", no_memory)
        allowing.order("predictor 60 s")
        allowing.settle(lambda: allowing.events(allowing.instructor, "trouble"))
    assert allowing.refused("predictor off") == "predictor is off"
    switch_on(allowing, "predictor 60 s")


def no_memory(_boat: object) -> Predictor:
    """Stand for a predictor for which there is no room."""
    raise MemoryError("no room")


def test_marks_say_which_aids_were_used() -> None:
    told = Judgement(Outcome.WON, 88.2, aids=AIDS)
    assert str(told) == "won, 88 marks of 100, with ghost, with predictor"
    assert told.fields == "won,88.2,ghost,predictor"
    assert marks_in_words(told.fields) == str(told)
    for plain in (Judgement(Outcome.LOST, 4.0), Judgement(Outcome.UNDECIDED, None)):
        assert marks_in_words(plain.fields) == str(plain)


EXERCISE = """
schema = "exercise/1"
name = "Down a little"
briefing = "Go to 65 m."
duration_s = 100
{more}
"""


@pytest.mark.parametrize(
    ("more", "aids"),
    [
        ("", AIDS),
        (TIME_TO_65_M, ()),
        (f'aids = ["predictor"]\n{TIME_TO_65_M}', ("predictor",)),
        ("aids = []", ()),
    ],
)
def test_an_exercise_with_marks_allows_no_aid_unless_it_says_so(
    more: str, aids: tuple[str, ...]
) -> None:
    path = load_exercise("watch").path
    assert parse_exercise(EXERCISE.format(more=more), path).aids == aids


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ('aids = ["gohst"]', "; nearest is ghost"),
        ('aids = ["ghost"]', "there is no [[crew]]"),
        ('aid = ["ghost"]', "; nearest is aids"),
    ],
)
def test_a_wrong_list_of_aids_is_told(more: str, why: str) -> None:
    with pytest.raises(ConfigError) as wrong:
        parse_exercise(EXERCISE.format(more=more), load_exercise("watch").path)
    assert why in str(wrong.value)


def test_a_second_boat_begins_with_the_bits_of_the_first() -> None:
    plan = planned("periscope-sea-3")
    boat = start_plan(plan)
    assert plan.launch_boat().snapshot().tobytes() == boat.snapshot().tobytes()


def test_the_ghost_has_a_past_and_the_predictor_has_none(allowing: Crewed) -> None:
    ship = allowing
    ship.fly(60)
    switch_on(ship, "ghost on")
    assert "it has no past" in ship.refused("history predictor 1 min")
    before = len(ship.instructor.sent)
    ship.order("history ghost 1 min")
    ship.settle(lambda: "end,ghost" in ship.facts(ship.instructor, "past"))
    rows = [parse_sentence(each) for each in ship.instructor.sent[before:]]
    told = {
        int(each.fields[1]): float(each.fields[3]) for each in rows if each and each.kind == "TRS"
    }
    ghost = ship.session.shown.aids.ghost
    assert set(told) == set(range(61))
    assert told == {tick: pytest.approx(ghost[tick].depth, abs=0.05) for tick in told}
