"""What stations are told of exercise and vessel, and that a crew is told nothing that is hidden."""

import functools
import math

import numpy as np
import pytest
from helpers.boats import make_boat
from helpers.document_tables import fact_keys
from helpers.line import Line, fields_of
from helpers.orders import read_order
from helpers.sessions import free_session, prompt_sender, start_plan

from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.exercise import load_exercise
from trainer.config.files import shipped_names
from trainer.io.orders import sentences
from trainer.io.orders.help import help_text
from trainer.io.orders.table import HELP_TOPICS
from trainer.io.orders.words import CREW_ROLES, HAND_AXES
from trainer.io.recording.absence import NoRecording
from trainer.session.attendance import Introduction
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.people.briefing import (
    hint,
    ranges,
)
from trainer.session.run import briefing_of, situation
from trainer.session.stations.roles import INSTRUCTOR_ROLE, ROLES, STRANGER_ROLE, Access
from trainer.session.stations.station import Station

LOOK_EVERY = 300.0  # [s]
COME = Access()


class Attended:
    """The session of a plan, with a line of a program for each role that comes by itself."""

    def __init__(self, plan: Plan, options: RunOptions, roles: tuple[str, ...]) -> None:
        self.boat = start_plan(plan)
        self.plan = plan
        told = briefing_of(plan, options)
        sending = prompt_sender(self.boat)
        here = situation(plan, self.boat)
        self.session = free_session(
            *(self.boat, NoRecording(), sending),
            schedule=plan.schedule,
            monitor=LimitMonitor.over(self.boat, plan.limits),
            introduction=Introduction(
                (*told.heading(INSTRUCTOR_ROLE), *here), (*told.heading(STRANGER_ROLE), *here), told
            ),
            by_hand={
                "hand": frozenset(plan.hand),
                "hand_from": plan.hand_from,
                "allowed": frozenset(plan.allowed),
            },
        )
        self.lines = {role: Line("line") for role in roles}
        for line in self.lines.values():
            station = Station(line, COME, sending, self.session.event_log.log)
            self.session.event_log.stations.append(station)

    def ask(self, *words: str) -> None:
        """Have every line ask the same."""
        for line in self.lines.values():
            line.waiting += [sentences.order_sentence(each) for each in words]
        self.session.attendance.listen()

    def enter(self) -> None:
        """Have every line say what it is."""
        for role, line in self.lines.items():
            line.waiting.append(sentences.order_sentence(f"role {role}"))
        self.session.attendance.listen()

    def facts(self, role: str, what: str) -> list[tuple[str, str]]:
        """Return the keys and values of a kind of fact that a line was told."""
        return [tuple(each.split("=", 1)) for each in self.facts_of(role, what)]  # type: ignore[misc]

    def facts_of(self, role: str, what: str) -> list[str]:
        """Return the subjects of a kind of fact that a line was told."""
        return [each[3] for each in fields_of(self.lines[role].sent, "TRF") if each[2] == what]

    def answer(self, role: str, words: str) -> str:
        """Ask something on one line; return the answer."""
        line = self.lines[role]
        before = len(line.sent)
        line.waiting.append(sentences.order_sentence(words))
        self.session.attendance.listen()
        return fields_of(line.sent[before:], "TRA")[0][1]


def attended(name: str, *roles: str) -> Attended:
    options = RunOptions(exercise=name)
    return Attended(plan_run(options), options, roles)


def secrets(plan: Plan, name: str) -> set[str]:
    """Return what no line of the crew may hold, in small letters."""
    exercise = load_exercise(name)
    broken = {each.casualty.name for each in plan.armed}
    broken |= {each.row.name for each in exercise.drawn}
    broken |= {e.order.subject for e in plan.schedule if e.order.name in ("casualty", "clear")}
    told = {line.strip() for line in plan.instructor.splitlines() if len(line.split()) > 2}
    scores = {rule.score.name for rule in plan.scores if rule.casualty or rule.since}
    tasks = {each for each in scores if each.lower() not in help_on_every_order()}  # of its order
    words = broken | {each.replace("-", " ") for each in broken} | told | tasks
    if "-" in name and (plan.hides or plan.instructor):
        words.add(name)
    return {word.lower() for word in words - {"", "all"}}


@functools.cache
def help_on_every_order() -> str:
    """Return the answers to `help ORDER` for each order, in small letters."""
    return "\n".join(line for head in HELP_TOPICS for line in help_text(head)).lower()


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_names("exercises"))
def test_no_line_of_a_crew_holds_a_hidden_word(name: str) -> None:
    here = attended(name, *CREW_ROLES, "observer")
    here.ask("briefing", "help", "log", "status")
    here.enter()
    here.ask("subscribe teletype at 0.1 hz", "help session")
    manual = help_on_every_order()  # the same to every role, in every exercise
    for role, line in here.lines.items():
        channels = [f"subscribe {each} at 0.1 hz" for each in ROLES[role].channels]
        line.waiting += [sentences.order_sentence(each) for each in channels]
    with np.errstate(all="ignore"):
        for _ in range(math.ceil((here.plan.duration or 600.0) / LOOK_EVERY)):
            for _ in range(round(LOOK_EVERY / here.plan.method.step)):
                here.session.tick()
            here.ask("briefing", "status", "log 100", "who", "aye", "report well", "mark")
            here.ask("history events", "branches", "casualties", "next", "snapshots")
    words = secrets(here.plan, name)
    for role, line in here.lines.items():
        heard = "\n".join(line.sent).lower()
        assert len(heard) > 5000
        found = [word for word in words if word in heard or word in manual]
        assert not found, f"{role} was told {found}"


def test_a_program_is_told_exercise_and_vessel_with_its_role() -> None:
    here = attended("stern-plane-jam", "instructor", "planes")
    here.enter()

    crew = dict(here.facts("planes", "exercise"))
    assert crew["title"] == "Passage, fast and deep"
    assert crew["hand"] == "planes,speed"
    assert "depth_m_max:140" in crew["limits"].split(",")
    assert (crew["duration"], crew["left"]) == ("600", "600")
    assert ("lost", "depth > 160") in here.facts("planes", "exercise")
    assert not {"name", "hand-from", "free"} & set(crew)
    assert ("wins", "First answer") not in here.facts("planes", "exercise")
    whole = here.facts("instructor", "exercise")
    assert ("name", "stern-plane-jam") in whole
    assert ("wins", "First answer") in whole
    assert any("cure" in value for key, value in whole if key == "line")
    assert {key for key, _ in whole} <= fact_keys("exercise")

    limits = here.facts("planes", "range")
    assert ("rudder", "30") in limits
    assert ("bell", "stop:0") in limits
    assert any(value.startswith("ahead two-thirds:") for key, value in limits if key == "bell")
    assert any(value.startswith("depth_control:") for key, value in limits if key == "tank")
    assert "test-depth" not in dict(limits)
    assert dict(here.facts("instructor", "range"))["test-depth"] == "250"
    assert dict(here.facts("planes", "rate")) == {"second": "20", "once": "100"}


def test_a_reader_is_briefed_in_words_of_79_columns() -> None:
    here = attended("stern-plane-jam", "planes")
    here.enter()
    here.lines["planes"].waiting.append("briefing")
    here.lines["planes"].sent.clear()

    here.session.attendance.listen()

    said = [line for line in here.lines["planes"].sent if not line.startswith("$")]
    assert "by hand: planes, speed" in said
    assert "limits: depth at most 140 m, pitch at most 20 deg" in said
    assert any(line.startswith("lost by: deeper than 160 m; slower") for line in said)
    assert "length: 600 s, 600 s left" in said
    assert any(line.startswith("won by: each order carried out") for line in said)
    assert max(map(len, said)) <= 79


def test_the_crew_takes_its_axes_in_hand_when_their_time_comes() -> None:
    here = attended("power-loss", "instructor", "pilot")
    here.enter()
    assert "hand" not in dict(here.facts("pilot", "exercise"))
    begins = here.plan.hand_from
    assert dict(here.facts("instructor", "exercise"))["hand-from"] == f"{begins:g}"

    with np.errstate(all="ignore"):
        for _ in range(round(begins / here.plan.method.step) + 1):
            here.session.tick()

    taken = dict(here.facts("pilot", "exercise"))["hand"]
    assert set(taken.split(",")) == set(here.plan.hand)
    assert any("by hand from now on: " in line for line in here.lines["pilot"].sent)


def test_an_older_exercise_that_hides_something_is_briefed_to_the_instructor_alone() -> None:
    plan = plan_run(RunOptions(exercise="stern-plane-jam"))
    old = briefing_of(plan, RunOptions(exercise="stern-plane-jam"))
    shown = old.__class__(**{**old.__dict__, "instructor": (), "hides": True})

    assert shown.heading(STRANGER_ROLE) == ()
    assert "Passage, fast and deep (stern-plane-jam)" in shown.heading(INSTRUCTOR_ROLE)
    assert not {"title", "line"} & {key for key, _ in shown.facts(ROLES["helm"], 0.0)}


def test_without_an_exercise_nothing_is_told_of_one() -> None:
    options = RunOptions()
    here = Attended(plan_run(options), options, ("helm",))
    here.enter()
    assert here.facts("helm", "exercise") == []
    assert dict(here.facts("helm", "range"))["stern"] == "30"
    assert dict(here.facts("helm", "range"))["trim-arm"] == "52"
    remus = make_boat("remus100")
    assert {key for key, _ in ranges(remus, INSTRUCTOR_ROLE)} <= fact_keys("range") - {
        "trim-arm",
        "tank",
    }


def test_an_observer_is_told_the_ranges_when_it_says_what_it_is() -> None:
    """A line that has said nothing observes already; its role stays the same."""
    options = RunOptions()
    here = Attended(plan_run(options), options, ("observer",))
    here.enter()
    assert dict(here.facts("observer", "range"))["test-depth"]


# Alerts


def test_alerts_have_numbers_and_are_acknowledged_before_the_others() -> None:
    here = attended("stern-plane-jam", "instructor", "planes", "helm")
    here.enter()
    log = here.session.event_log
    log.alert("watch", MonitorCall("LIMIT: depth above 140 m"))
    log.alert("pilot", MonitorCall("autopilot: afloat"))

    assert here.facts_of("instructor", "alert") == [
        "1,watch,LIMIT: depth above 140 m",
        "2,pilot,autopilot: afloat",
    ]
    assert here.facts_of("helm", "alert") == ["2,pilot,autopilot: afloat"]
    assert any("afloat [2]" in line for line in here.lines["helm"].sent)

    assert here.answer("helm", "ack 1") == "no such alert is open here; there is 2"
    assert here.answer("helm", "ack 2") == "seen: 2"
    assert here.facts_of("planes", "ack") == ["2"]
    assert here.answer("planes", "ack all") == "no such alert is open here; there is none"
    assert here.answer("instructor", "ack all") == "seen: 1"
    assert not any(alert.owed for alert in log.alerts.listed)


def test_a_caution_is_told_with_its_rank_and_asks_nobody_to_acknowledge_it() -> None:
    here = attended("stern-plane-jam", "planes")
    here.enter()
    log = here.session.event_log
    log.alert("depth", MonitorCall("lies on the ground", Rank.CAUTION))

    assert here.facts_of("planes", "alert-rank") == ["1,caution"]
    assert here.facts_of("planes", "alert") == ["1,depth,lies on the ground"]
    assert not any("[1]" in line for line in here.lines["planes"].sent)
    assert here.answer("planes", "ack 1") == "no such alert is open here; there is none"


def test_who_comes_late_is_told_the_alerts_that_nobody_has_seen() -> None:
    here = attended("stern-plane-jam", "planes")
    here.session.event_log.alert("pilot", MonitorCall("autopilot: afloat"))
    here.enter()
    assert here.facts_of("planes", "alert") == ["1,pilot,autopilot: afloat"]


@pytest.mark.parametrize("role", ROLES)
@pytest.mark.parametrize("hand", [(), ("rudder", "planes"), ("speed", "ballast"), HAND_AXES])
def test_whoever_comes_is_offered_orders_that_he_may_give(role: str, hand: tuple[str, ...]) -> None:
    offered = hint(ROLES[role], frozenset(hand))
    assert len(offered) <= 79
    for words in filter(None, offered.partition(": ")[2].split("   ")):
        order = read_order(words)
        assert order.name in ROLES[role].commands, words


def test_who_has_no_place_yet_is_told_how_to_take_one() -> None:
    boat = attended("crossing-traffic", "scope")
    (line,) = boat.lines.values()
    boat.session.attendance.greet(boat.session.event_log.stations[0])
    assert "`role helm` to take a station" in line.sent[-1]
    assert "depth" not in line.sent[-1]
    boat.enter()
    boat.session.attendance.greet(boat.session.event_log.stations[0])
    assert "scope raise" in line.sent[-1]
    assert "rudder" not in line.sent[-1]
