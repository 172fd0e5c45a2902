"""A lone person changes his chair, both ways; nobody else does, and the marks tell of it."""

import re
from contextlib import closing
from pathlib import Path

import pytest
from helpers.crewed import Begin, Crewed
from helpers.line import Line
from helpers.orders import read_order

from trainer.console.exercise import marks_in_words
from trainer.console.guide import INSTRUCTOR_HELP, TRAINEE_HELP
from trainer.debrief.passage.episodes import aids_used
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import CREW_ROLES
from trainer.io.recording.recording import Recording
from trainer.session.people.briefing import hint
from trainer.session.stations.roles import ROLES, Access
from trainer.session.stations.station import Station


def alone(ship: Crewed, role: str = "", door: Access | None = None) -> Line:
    """Let the instructor go, and somebody come alone, as a program that hears facts."""
    ship.leaves(ship.instructor)
    return joins(ship, role, door or Access(here=lambda: True))


def joins(ship: Crewed, role: str, door: Access) -> Line:
    line = Line(f"line {len(ship.session.event_log.stations) + 1}")
    station = Station(line, door, ship.sending, ship.session.event_log.log)
    ship.session.event_log.stations.append(station)
    if role:
        ship.say(line, f"role {role}")
    return line


def role_of(ship: Crewed, line: Line) -> str:
    return next(each.role.name for each in ship.session.event_log.stations if each.line is line)


def test_who_is_alone_takes_every_chair_and_goes_back(drill: Crewed) -> None:
    line = alone(drill, "trainee")
    for role in ("instructor", "trainee", *CREW_ROLES, "observer", "trainee"):
        assert drill.say(line, f"role {role}") == ("ok", f"you {ROLES[role].part}")
        assert role_of(drill, line) == role
        assert drill.facts(line, "chair")[-1] == role
    assert drill.refused("role trainee", line) == "you are a trainee already"


def test_the_class_is_nobody_beside_whom_a_chair_or_an_end_has_to_wait(drill: Crewed) -> None:
    line = alone(drill, "trainee")
    joins(drill, "class", Access())
    drill.say(line, "who")
    assert [each.partition(" ")[0] for each in drill.said] == ["trainee"]
    assert drill.say(line, "role instructor")[0] == "ok"
    assert drill.say(line, "quit") == ("ok", "ending")


def test_what_is_hidden_stays_behind_with_the_instructors_chair(drill: Crewed) -> None:
    line = alone(drill, "trainee")
    assert drill.say(line, "subscribe motion")[0] == "no"
    drill.say(line, "role instructor")
    for channel in ("motion", "casualties", "gauges"):
        assert drill.say(line, f"subscribe {channel}")[0] == "ok"
    drill.say(line, "role trainee")
    line.sent.clear()

    drill.fly(3)
    told = "\n".join(line.sent)
    assert "$TRS,gauges" in told
    assert not re.search("motion|casualties", told)
    assert drill.say(line, "casualty stern-stuck")[0] == "no"


def test_a_change_is_in_the_journal_and_the_line_is_briefed_anew(drill: Crewed) -> None:
    line = alone(drill, "trainee")
    drill.fly(4)
    drill.say(line, "role instructor")

    entry = drill.recording.orders(1)[-1]
    assert (entry.text, entry.tick, entry.accepted) == ("role instructor", 4, True)
    assert entry.giver.role == "trainee"
    assert any("type an order, such as" in each for each in line.sent)


@pytest.mark.parametrize(
    ("door", "role", "why"),
    [
        (Access(), "trainee", "a line keeps its role"),  # not of this machine
        (Access("planes", here=lambda: True), "", "a line keeps its role"),  # a panel
        (Access(tokens={"": "WORD"}, here=lambda: True), "trainee WORD", "a line keeps its role"),
        (Access(here=lambda: True), "visitor", "a line keeps its role"),
    ],
)
def test_a_line_keeps_its_role_that_may_not_change_it(
    drill: Crewed, door: Access, role: str, why: str
) -> None:
    line = alone(drill, role, door)
    before = role_of(drill, line)
    assert why in drill.refused("role instructor", line)
    assert role_of(drill, line) == before


def test_the_runs_own_console_changes_its_chair_and_nobody_does_beside_another(
    drill: Crewed,
) -> None:
    line = alone(drill, "", Access("instructor", own=True))
    assert drill.say(line, "role trainee")[0] == "ok"
    other = joins(drill, "helm", Access(here=lambda: True))
    for each in (line, other):
        assert "while others are attached" in drill.refused("role instructor", each)
    drill.leaves(other)
    assert drill.say(line, "role instructor")[0] == "ok"


def aids_of(path: Path, branch: int, ship: Crewed) -> tuple[str, ...]:
    with closing(Recording.look(path)) as recording:
        orders = tuple(recording.orders(branch))
    trajectory = object.__new__(Trajectory)
    object.__setattr__(trajectory, "orders", orders)
    object.__setattr__(trajectory, "boat", ship.boat)
    return aids_used(trajectory)


def test_marks_tell_since_when_or_until_when_somebody_saw_what_is_hidden(crewed: Begin) -> None:
    ship = crewed(seconds=None)
    line = alone(ship, "trainee")
    ship.fly(400)
    ship.say(line, "role helm")
    ship.say(line, "role trainee")
    kept = ship.conduct.marks.kept
    assert kept
    ship.recording.flush()
    assert aids_of(kept, 1, ship) == ()

    ship.say(line, "role instructor")
    ship.say(line, "role trainee")
    ship.recording.flush()
    assert aids_of(kept, 1, ship) == ("a look as instructor from 3:20",)
    ship.session.time.pacer.freeze()
    assert ship.say(line, "backtrack 100 s")[0] == "ok"
    ship.fly(2)
    ship.recording.flush()
    assert aids_of(kept, 2, ship) == ("a look as instructor from 1:40",)

    told = marks_in_words("not reached,61.0,a look as instructor from 3:20")
    assert told.endswith("with a look as instructor from 3:20")

    ship = crewed(seconds=None)
    line = alone(ship, "instructor")
    ship.fly(20)
    ship.say(line, "role trainee")
    ship.recording.flush()
    kept = ship.conduct.marks.kept
    assert kept
    assert aids_of(kept, 1, ship) == ("a look as instructor until 0:10",)


# Advice is obeyed where it is read.


@pytest.mark.parametrize("hand", [(), ("rudder", "planes", "speed", "ballast")])
@pytest.mark.parametrize("role", ["", *sorted(set(ROLES) - {"visitor"})])
def test_advice_that_a_line_is_given_is_obeyed_there(
    crewed: Begin, role: str, hand: tuple[str, ...]
) -> None:
    order = read_order("tell trim the boat")
    ship = crewed(seconds=None, hand=frozenset(hand), schedule=[ScheduledOrder(0.5, order, 1)])
    line = alone(ship, role)
    ship.fly(4)
    advice = hint(ROLES[role or "observer"], hand)
    words = re.findall("`([^`]+)`", advice) or advice.partition(": ")[2].split("   ")
    assert len(words) >= 2
    for each in words:
        assert ship.say(line, each)[0] == "ok", each


@pytest.mark.parametrize(
    ("role", "texts"), [("trainee", TRAINEE_HELP), ("instructor", INSTRUCTOR_HELP)]
)
def test_advice_of_a_chair_s_help_is_obeyed_there(
    crewed: Begin, role: str, texts: tuple[str, ...]
) -> None:
    words = [each for text in texts for each in re.findall("`([^`]+)`", text)]
    assert "role instructor" in words
    line = alone(ship := crewed(seconds=None), role)
    for each in words:
        assert ship.say(line, each)[0] == "ok", each


REFUSED_IN_A_CHAIR = [
    *((role, order) for role in CREW_ROLES for order in ("freeze", "time x2", "again", "quit")),
    ("trainee", "casualty stern-stuck"),
    ("helm", "casualty stern-stuck"),
    ("helm", "stern planes dive 5"),
    ("observer", "run"),
]


@pytest.mark.parametrize(("role", "order"), REFUSED_IN_A_CHAIR)
def test_who_is_refused_an_order_alone_is_told_the_chair_that_has_it(
    ship: Crewed, role: str, order: str
) -> None:
    line = alone(ship, role)
    (advice,) = re.findall("`([^`]+)`", ship.refused(order, line))
    wanted = "instructor" if order.startswith("casualty") else "trainee"
    assert advice == f"role {wanted}"
    assert ship.say(line, advice)[0] == "ok"
    assert ship.say(line, order)[0] == "ok"
