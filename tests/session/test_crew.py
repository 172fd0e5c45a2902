"""What is said between those who order the crew, the crew and the instructor."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers.boats import start_bb2
from helpers.givers import giver_at
from helpers.line import Line, fields_of
from helpers.sessions import free_session, prompt_sender

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthGuard
from trainer.io.orders import grammar, sentences
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import parse_schedule
from trainer.io.recording.queries import Past, RecordedOrder
from trainer.io.recording.recording import Recording
from trainer.session.crew.agenda import Agenda
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork
from trainer.session.crew.orders_in_force import OrdersInForce
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station


class Crew:
    """A session with one line for each role, which flies tick by tick."""

    def __init__(
        self, boat: Boat, recording: Recording, schedule: str = "", **more: object
    ) -> None:
        entries = parse_schedule(schedule, "orders.txt")
        assert isinstance(entries, list)
        sending = prompt_sender(boat)
        self.session = free_session(boat, recording, sending, schedule=entries, by_hand=more)
        self.lines: dict[str, Line] = {}
        self.boat, self.sending = boat, sending

    def man(self, *roles: str) -> "Crew":
        for role in roles:
            line = self.lines[role] = Line(role)
            station = Station(line, Access(role), self.sending, self.session.event_log.log)
            self.session.event_log.stations.append(station)
        return self

    def say(self, role: str, *words: str) -> list[str]:
        """Say something at a station; return what it is sent."""
        line = self.lines[role]
        line.sent.clear()
        line.waiting += words
        self.session.attendance.listen()
        return line.sent

    def program(self, role: str, words: str) -> str:
        """Say something as a program does; return the answer."""
        self.say(role, sentences.order_sentence(words))
        return fields_of(self.lines[role].sent, "TRA")[-1][1]

    def facts(self, role: str) -> list[str]:
        """Return the facts that a program has been told, but who spoke, and forget them."""
        told = fields_of(self.lines[role].sent, "TRF")
        self.lines[role].sent.clear()
        return [f"{what}: {subject}" for _, _, what, subject in told if what != "said"]

    def fly(self, seconds: float) -> "Crew":
        for _ in range(round(seconds / 0.5)):
            self.session.tick()
        return self

    def heard(self, role: str) -> list[str]:
        """Return what a reader has been told, and forget it."""
        told, self.lines[role].sent = self.lines[role].sent, []
        return told


@pytest.fixture
def crew() -> Iterator[Callable[..., Crew]]:
    """Return a function that makes a session of BB2 at 10 kn, 60 m, course 000."""
    made: list[Recording] = []

    def make(schedule: str = "", path: Path | None = None, **more: object) -> Crew:
        boat = start_bb2()
        made.append(Recording.create(path, {}, boat.records.state.tobytes()))
        return Crew(boat, made[-1], schedule, **more)

    yield make
    for recording in made:
        recording.close()


Make = Callable[..., Crew]


def test_an_order_to_the_crew_is_told_to_everybody_with_its_fact(crew: Make) -> None:
    here = crew().man("instructor", "helm", "observer")
    here.say("observer", sentences.order_sentence("status"))
    here.facts("observer")

    assert here.say("instructor", "order course left 045") == ["ordered: course left to 045"]

    assert here.heard("helm") == ["instructor: ordered: course left to 045"]
    assert here.facts("observer") == ["crew-order: course left to 045"]
    (told,) = [each for each in here.session.history.recording.events() if each.kind == "crew"]
    assert told.text == "instructor: ordered: course left to 045"


def test_words_to_the_crew_and_reports_are_told(crew: Make) -> None:
    here = crew().man("diving", "planes", "instructor")

    assert here.say("diving", "tell stand by to surface") == ["told: stand by to surface"]
    assert here.heard("planes") == ["diving: to the crew: stand by to surface"]
    assert here.session.crew.told == "stand by to surface"

    assert here.say("planes", "report stern planes jammed dive") == ["reported"]
    assert here.heard("instructor")[-1] == "planes reports: stern planes jammed dive"


def test_who_comes_late_hears_which_orders_wait(crew: Make) -> None:
    here = crew("1 order depth 75\n").man("planes").fly(2.0)
    for words in ([], ["repeated"]):
        assert [told.fact.what for told in here.session.crew.standing()] == ["crew-order", *words]
        here.say("planes", "aye")


def test_after_a_backtrack_words_and_repeats_are_those_of_then(crew: Make) -> None:
    here = crew("1 order course 045\n5 tell hold her\n").man("instructor", "helm").fly(3.0)
    here.say("helm", "aye")
    here.fly(5.0)
    assert here.session.crew.told == "hold her"
    here.say("helm", "rudder right 5")

    here.say("instructor", "backtrack 4.5")

    assert here.boat.time == 3.5
    assert here.session.crew.told == ""
    assert here.say("helm", "aye") == ["? there is no new order to repeat"]
    here.say("instructor", "backtrack 1.5")
    assert here.say("helm", "aye") == ["course 045 aye"]


@pytest.mark.slow
def test_a_jump_reads_and_understands_no_order_however_many_were_given(
    crew: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = crew("1 order course 045\n").man("instructor", "helm").fly(3.0)
    here.say("helm", "aye")
    here.fly(1.0)
    words = ("rudder left 5", "scope raise", "order depth 80", "tell hold her")
    given = [order for order in map(parse, words) if isinstance(order, Order)]
    for number in range(10_000):
        here.session.dispatch.give(given[number % len(given)], giver_at("instructor"))
    here.fly(4.0)
    last = [told.fact.subject for told in here.session.crew.standing()]
    jumps = [
        order for order in map(parse, ("backtrack 4 s", "branch 1")) if isinstance(order, Order)
    ]
    understood: list[str] = []
    read: list[RecordedOrder] = []
    orders = Past.orders
    readable = grammar.readable

    def note_read(text: str) -> str:
        understood.append(text)
        return readable(text)

    monkeypatch.setattr(grammar, "readable", note_read)  # begins every parse

    def read_orders(*past_of: Any) -> list[RecordedOrder]:
        read.extend(orders(*past_of))
        return read

    monkeypatch.setattr(Past, "orders", read_orders)

    for jump, stands in zip(jumps, (["course 045"] * 2, last), strict=True):
        assert "branch" in str(here.session.dispatch.give(jump, giver_at("instructor")))
        assert [told.fact.subject for told in here.session.crew.standing()] == stands
    assert (understood, read) == ([], [])


def test_what_stands_after_a_jump_is_what_the_journal_tells_from_its_beginning(
    crew: Make, tmp_path: Path
) -> None:
    here = crew("1 order course 045\n", tmp_path / "a.trainer").man("instructor", "helm").fly(3.0)
    for words in ("order depth 80", "at 20 depth 70", "tell hold her", "rudder left 5"):
        here.say("instructor", words)
        here.say("helm", "course 054 aye")
        here.fly(2.0)
    here.say("helm", "course 045 aye")
    here.say("instructor", "belay", "cancel 1", "order course 090", "allow planes")
    here.fly(2.0)
    session = here.session
    for jump in ("backtrack 2 s", "branch 1", "backtrack 5 s", "reset", "branch 3", "branch 1"):
        here.say("instructor", jump)
        afresh = OrdersInForce(
            CrewTalk(here.boat, HandWork(here.boat)), Agenda(here.boat), session.history
        )
        afresh.read_journal()
        afresh.follow(session.history.now())
        assert session.crew.talk == afresh.crew.talk, jump
        assert session.agenda.plans == afresh.agenda.plans, jump
    assert session.crew.talk.spoken
    assert session.history.after > 0


def test_a_replay_says_again_what_was_said_and_writes_it_once(crew: Make) -> None:
    here = crew("1 order course 045\n").man("instructor", "helm", "observer").fly(3.0)
    here.say("helm", "course 054 aye")
    here.fly(1.0)
    here.say("helm", "aye")
    here.fly(8.0)
    first = [line for line in here.heard("observer") if "course" in line]
    assert len(first) == 3

    here.say("instructor", "replay 11.5 s")
    here.heard("observer")
    here.fly(12.5)

    assert [line for line in here.heard("observer") if "course" in line] == first
    assert "the same to the last bit" in " ".join(here.heard("instructor"))
    events = here.session.history.recording.events()
    assert len([each for each in events if each.kind == "crew"]) == 3


# Read-back


@pytest.mark.parametrize(
    ("order", "role", "words"),
    [
        ("order course 045", "helm", "aye"),
        ("order course 045", "helm", "course 045 aye"),
        ("order course 045", "pilot", "Course 45, aye"),
        ("order course left 045", "helm", "course left to 045 aye"),
        ("order course left 045", "helm", "course 045 aye"),
        ("order course 360", "helm", "course 000 aye"),
        ("order depth 200 ft", "planes", "depth 200 aye"),
        ("order depth 200 ft", "diving", "depth 200 ft aye"),
        ("order depth 60", "pilot", "depth 60 metres aye"),
        ("order periscope", "planes", "periscope aye"),
        ("order periscope", "planes", "depth 17.5 aye"),
        ("order speed 8", "helm", "speed 8 aye"),
        ("order pitch 5 down", "planes", "pitch 5 down aye"),
        ("order pitch zero", "planes", "pitch zero aye"),
        ("tell surface when ready", "ballast", "Surface, when ready aye"),
        ("tell surface when ready", "helm", "aye"),
    ],
)
def test_an_order_is_repeated_by_the_station_it_concerns(
    crew: Make, order: str, role: str, words: str
) -> None:
    here = crew().man("instructor", role)
    here.say("instructor", order)
    (answer,) = [line for line in here.say(role, words) if not line.startswith("instructor")]
    assert answer.endswith(" aye")
    assert "WRONG" not in answer
    assert "aye" in here.heard("instructor")[-1]
    before = here.boat.records.state.tobytes()
    assert here.say(role, words)[-1].startswith("? there is no new order")
    assert here.boat.records.state.tobytes() == before


@pytest.mark.parametrize("schedule", ["1 tell surface, then steer", ""])
def test_words_stand_on_the_panels_from_the_next_tick_also_once_repeated(
    crew: Make, schedule: str
) -> None:
    here = crew(schedule=schedule).man("instructor", "helm")
    here.program("helm", "subscribe orders")
    here.fly(2.0)
    if not schedule:
        here.say("instructor", "tell surface, then steer")
    here.say("helm", "aye")
    here.fly(1.0)
    (*_, last) = [line for line in here.lines["helm"].sent if line.startswith("$TRS,orders")]
    assert ",surface; then steer" in last
    assert here.say("helm", "aye")[-1].startswith("? there is no new order")


@pytest.mark.parametrize(
    ("order", "role", "words"),
    [
        ("order course 045", "helm", "course 054 aye"),
        ("order course left 045", "helm", "course right to 045 aye"),
        ("order depth 200 ft", "planes", "depth 200 m aye"),
        ("order depth 60", "planes", "depth 16 aye"),
        ("order speed 8", "helm", "speed 18 aye"),
        ("order pitch 5 down", "planes", "pitch 5 up aye"),
        ("tell surface when ready", "helm", "surface aye"),
    ],
)
def test_a_wrong_repeat_is_told_to_both_and_lets_the_order_stand_new(
    crew: Make, order: str, role: str, words: str
) -> None:
    here = crew().man("instructor", role)
    here.say("instructor", sentences.order_sentence(order))
    here.facts("instructor")

    answer = here.say(role, words)[-1]

    said = words.removesuffix(" aye")
    assert answer.startswith(f"WRONG REPEAT: {said}; ordered is ")
    (fact,) = here.facts("instructor")
    assert fact.startswith(f"wrong-repeat: {said}; ")
    assert here.say(role, "aye")[-1].endswith(" aye")


@pytest.mark.parametrize(
    ("order", "role", "words", "why"),
    [
        ("order course 045", "planes", "aye", "no new order"),
        ("order depth 60", "helm", "aye", "no new order"),
        ("order course 045", "instructor", "aye", "no new order"),
        (
            "order course 045",
            "helm",
            "depth 60 aye",
            '"depth 60" repeats no order; the new order is',
        ),
        ("order course 045", "helm", "will do aye", "say aye"),
    ],
)
def test_what_is_not_ordered_here_is_not_repeated(
    crew: Make, order: str, role: str, words: str, why: str
) -> None:
    here = crew().man(*{"instructor", role})
    here.say("instructor", order)
    assert why in here.say(role, words)[-1]


def test_an_order_that_nobody_repeats_is_shown_again_once(crew: Make) -> None:
    here = crew().man("instructor", "helm").fly(1.0)
    here.say("instructor", "order course 045")
    here.heard("helm")

    here.fly(9.5)
    assert here.heard("helm") == []
    here.fly(1.0)
    assert here.heard("helm") == ["NOT REPEATED in 10 s: course 045"]
    assert here.heard("instructor")[-1] == "NOT REPEATED in 10 s: course 045"
    here.fly(30.0)
    assert here.heard("helm") == []


def test_where_nobody_can_repeat_it_nothing_is_missing(crew: Make) -> None:
    here = crew().man("instructor", "planes")
    here.say("instructor", "order course 045")
    here.heard("instructor")
    here.fly(12.0)
    assert here.heard("instructor") == []


def test_belay_takes_back_the_newest_order_and_is_told(crew: Make) -> None:
    here = crew().man("instructor", "helm")
    here.say("instructor", "order course 045", "tell slow and easy", "order speed 5")
    here.heard("helm")

    here.say("instructor", "belay")
    assert here.heard("helm") == ["belay: speed 5 kn"]
    here.say("instructor", "belay")
    assert here.heard("helm") == ["belay: slow and easy"]
    assert here.session.crew.told == ""
    here.say("instructor", "belay course")
    assert here.heard("helm") == ["belay: course 045"]
    assert here.say("instructor", "belay")[-1] == "? the crew has no order"
    assert here.say("instructor", "belay words")[-1] == "? no words to the crew stand"
    here.say("instructor", "order course 010", "order depth 70", "belay")
    assert here.heard("helm")[-1] == "belay: depth 70 m"


@pytest.mark.parametrize(
    ("order", "role", "words"),
    [
        ("order course left 045", "helm", "rudder right 10"),
        ("order course 045", "helm", "rudder left 10"),
        ("order depth 90", "planes", "stern planes rise 5"),
        ("order depth 30", "planes", "bow planes dive 5"),
        ("order pitch 5 down", "planes", "stern planes rise 5"),
    ],
)
def test_an_order_carried_out_the_wrong_way_is_told_to_the_instructor_alone(
    crew: Make, order: str, role: str, words: str
) -> None:
    here = crew().man("instructor", role).fly(1.0)
    here.say("instructor", order)
    here.heard("instructor")

    told = here.say(role, words)

    assert not any("WRONG" in line for line in told)
    (wrong,) = [line for line in here.heard("instructor") if "WRONG WAY" in line]
    assert words in wrong
    here.say(role, words)
    assert not any("WRONG WAY" in line for line in here.heard("instructor"))


def test_a_replay_tells_a_wrong_way_again_and_writes_it_once(crew: Make) -> None:
    here = crew().man("instructor", "helm").fly(1.0)
    here.say("helm", sentences.order_sentence("briefing"))
    here.say("instructor", "order course 045")
    here.say("helm", sentences.order_sentence("rudder left 10"))
    assert not [fact for fact in here.facts("helm") if fact.startswith("wrong-way")]
    here.fly(5.0)

    here.say("instructor", "replay 5.5 s")
    here.heard("instructor")
    here.fly(6.5)

    assert len([line for line in here.heard("instructor") if "WRONG WAY" in line]) == 1
    events = here.session.history.recording.events()
    assert len([each for each in events if "WRONG WAY" in each.text]) == 1


def test_who_steers_is_told_what_the_x_tail_does_not_give(crew: Make) -> None:
    here = crew().man("instructor", "helm", "planes")
    here.say("helm", "rudder right 25")
    here.say("planes", "stern planes dive 20", "bow planes zero")
    here.heard("helm")

    here.fly(15.0)

    for role in ("helm", "planes", "instructor"):
        told = [line for line in here.heard(role) if "X-TAIL" in line]
        assert any("the rudder has " in line for line in told)


@pytest.mark.parametrize(
    ("order", "role", "words"),
    [
        ("order course 045", "helm", ("rudder right 10", "rudder left 10")),  # to meet it
        ("order course 180", "helm", ("rudder left 10",)),  # either way is as short
        ("order course right 002", "helm", ("rudder amidships",)),
        ("order depth 90", "planes", ("stern planes dive 5", "stern planes rise 5")),
    ],
)
def test_the_right_way_and_what_meets_it_is_not_told(
    crew: Make, order: str, role: str, words: tuple[str, ...]
) -> None:
    here = crew().man("instructor", role).fly(1.0)
    here.say("instructor", order)
    here.say(role, *words)
    assert not any("WRONG" in line for line in here.heard("instructor"))


# What the pumps have done


def test_a_pump_s_order_is_reported_to_everybody_when_it_is_done(crew: Make) -> None:
    here = crew().man("instructor", "helm", "ballast", "diving")
    (told,) = here.say("ballast", "flood depth-control 0.5")
    assert told == "flood depth-control 0.5 t: under way"
    here.say("diving", sentences.order_sentence("pump trim aft 0.4"))
    for role in here.lines:
        here.heard(role)

    here.fly(20.0)

    done = ["diving reports: trim: 0.4 t aft", "ballast reports: depth control: 0.5 t in"]
    for role in ("instructor", "helm", "ballast"):
        assert [line for line in here.heard(role) if "reports" in line] == done
    assert "report: diving: trim: 0.4 t aft" in here.facts("diving")
    here.fly(5.0)
    assert here.heard("helm") == []


def test_a_pump_that_still_works_where_a_replay_ends_is_reported_when_it_is_done(
    crew: Make,
) -> None:
    here = crew().man("instructor", "ballast").fly(2.0)
    here.say("ballast", "flood depth-control 0.5")
    here.fly(3.0)
    here.say("instructor", "replay 4 s")
    here.fly(4.5)
    assert not here.session.history.flown.replaying
    here.session.time.pacer.run()
    here.fly(20.0)
    told = [line for line in here.heard("instructor") if "reports" in line]
    assert told == ["ballast reports: depth control: 0.5 t in"]


def test_what_the_instructor_pumps_is_reported_to_nobody_else(crew: Make) -> None:
    here = crew().man("instructor", "ballast")
    here.say("instructor", "flood auxiliary 0.3")
    for role in here.lines:
        here.heard(role)
    here.fly(20.0)
    assert here.heard("instructor") == ["auxiliary: 0.3 t in"]
    assert here.heard("ballast") == []


def test_a_full_tank_is_reported_and_an_order_taken_back_is_not(crew: Make) -> None:
    here = crew().man("ballast")
    room = here.boat.vessel.capacity[6] - here.boat.state.water[6]
    here.boat.state.water[6] += room - 500.0
    here.say("ballast", "flood auxiliary 2", "pump depth-control 2")
    here.fly(5.0)
    here.say("ballast", "hover off")
    here.heard("ballast")
    here.fly(30.0)
    (told,) = [line for line in here.heard("ballast") if "reports" in line]
    assert told == "ballast reports: auxiliary is full: 0.5 of 2 t in"


def test_an_order_that_waits_for_its_pump_says_so(crew: Make) -> None:
    here = crew().man("ballast")
    here.say("ballast", "drain aft")
    waits = "waits, its pump drains the aft compartment; drain stop frees it"
    assert here.say("ballast", "pump auxiliary 1") == [f"pump auxiliary 1 t: {waits}"]
    assert here.say("ballast", "flood depth-control 1") == ["flood depth-control 1 t: under way"]
    here.boat.state.z = float(here.boat.vessel.shutoff_depth) + 1.0
    (told,) = here.say("ballast", "pump depth-control 1")
    assert "waits, the pump delivers nothing below " in told


# Who steers what


AUTOMATIC = {
    "rudder": ("helm", ("course 045", "course left 30", "course auto", "rudder auto")),
    "planes": ("planes", ("depth 60", "depth auto", "periscope", "planes auto", "bow auto")),
    "speed": ("helm", ("speed 5", "speed auto")),
    "ballast": ("ballast", ("hover on", "hover 60", "trim auto")),
}


@pytest.mark.parametrize("axis", AUTOMATIC)
def test_automatic_orders_for_what_is_in_hand_are_refused_until_the_instructor_allows_them(
    crew: Make, axis: str
) -> None:
    role, lines = AUTOMATIC[axis]
    here = crew(hand=frozenset({axis})).man("instructor", role)
    for line in lines:
        answer = here.say(role, line)[-1]
        assert answer.startswith("? the ")
        assert "in hand in this exercise: " in answer
        assert answer.endswith(f", or the instructor says allow {axis}")
    assert "in hand in this exercise" in here.say("instructor", lines[0])[-1]

    answer = here.say("instructor", f"allow {axis}")[-1]

    assert answer == f"{axis} may be automatic; the run is free: it has no marks"
    assert here.heard(role)[-1] == f"{axis} may be automatic"
    assert not here.say(role, lines[0])[-1].startswith("?")
    free = [each for each in here.session.event_log.news if each.kind == "exercise"]
    assert any("flown without marks" in each.text for each in free)


def test_an_automatic_order_that_the_exercise_allows_is_obeyed(crew: Make) -> None:
    here = crew(hand=frozenset({"planes"}), allowed=frozenset({"depth"})).man("planes")
    assert here.say("planes", "depth 70")[-1] == "keeping depth 70 m"
    assert not here.say("planes", "periscope depth")[-1].startswith("?")
    assert here.say("planes", "planes auto")[-1].startswith("? the planes are in hand")


def test_before_its_time_nothing_is_in_hand(crew: Make) -> None:
    here = crew(hand=frozenset({"planes"}), hand_from=2.0).man("planes")
    assert here.say("planes", "depth 70")[-1] == "keeping depth 70 m"
    here.fly(2.0)
    assert here.say("planes", "depth 80")[-1].startswith("? the planes are in hand")


def test_only_the_instructor_allows_and_only_what_is_in_hand(crew: Make) -> None:
    here = crew(hand=frozenset({"planes"})).man("instructor", "diving")
    assert "is the instructor's" in here.say("diving", "allow planes")[-1]
    assert "the rudder is not in hand" in here.say("instructor", "allow rudder")[-1]
    here.say("instructor", "allow planes")
    assert "already" in here.say("instructor", "allow planes")[-1]


def test_a_swing_is_met_until_it_stops_by_an_order_of_the_journal(crew: Make) -> None:
    here = crew().man("helm").fly(1.0)
    here.say("helm", "rudder right 15")
    here.fly(20.0)
    assert here.boat.state.psidot > 0.0

    assert here.say("helm", "rudder meet")[-1] == "rudder left 15, by hand"
    here.fly(40.0)

    texts = [(each.who, each.text) for each in here.session.history.said()]
    assert texts[-1] == ("helm meeting her", "rudder amidships")
    assert float(here.boat.state.ordered_r) == 0.0
    assert len(texts) == 3


# Phrases, by who says them


def test_the_same_phrase_steers_at_the_helm_and_orders_the_crew_from_who_may(crew: Make) -> None:
    here = crew().man("instructor", "diving", "helm", "planes")
    assert here.say("instructor", "come left to 045") == ["ordered: course left to 045"]
    assert here.say("helm", "come left to 045")[-1] == "course left to 045: keeping course 045"
    assert here.say("diving", "make your depth two hundred feet") == ["ordered: depth 200 ft"]
    assert here.say("planes", "make your depth 70 metres")[-1] == "keeping depth 70 m"
    assert here.say("instructor", "right 10 degrees rudder")[-1] == "rudder right 10, by hand"
    refused = here.say("planes", "five degrees down bubble")[-1]
    assert refused.startswith("? orders to the crew are the diving officer's")


def test_a_phrase_for_the_autopilot_is_refused_where_the_rudder_is_in_hand(crew: Make) -> None:
    here = crew(hand=frozenset({"rudder"})).man("instructor", "helm")
    for phrase in ("come left to 045", "steady on 045", "steady as she goes"):
        answer = here.say("helm", phrase)[-1]
        assert answer.startswith("? the rudder is in hand in this exercise: rudder left 5")
    assert here.say("instructor", "steady as she goes") == ["ordered: course 000"]
    assert here.say("helm", "steady as she goes aye")[-1] == "course 000 aye"
    assert "by hand" in here.say("helm", "right 10 degrees rudder")[-1]


@pytest.mark.parametrize("words", ["come left to 045 aye", "left to zero four five aye"])
def test_an_order_is_repeated_in_its_phrase(crew: Make, words: str) -> None:
    here = crew().man("instructor", "helm")
    here.say("instructor", "come left to 045")
    assert here.say("helm", words)[-1] == "course left to 045 aye"


# A visitor's lever, and the guard


def test_one_lever_works_both_pairs_of_planes(crew: Make) -> None:
    here = crew().man("visitor")
    state, toward = here.boat.state, here.boat.toward

    assert here.program("visitor", "lever dive 10") == "lever dive 10, by hand"
    assert math.degrees(state.ordered_b) * toward["bow"] == pytest.approx(-10.0)
    assert math.degrees(state.ordered_s) * toward["stern"] == pytest.approx(-6.0)
    assert (state.bow_by_hand, state.stern_by_hand) == (1.0, 1.0)
    here.say("visitor", "lever rise 80")
    assert math.degrees(state.ordered_b) * toward["bow"] == pytest.approx(30.0)
    here.say("visitor", "lever zero")
    assert (state.ordered_b, state.ordered_s) == (0.0, 0.0)


def guarded(crew: Make, **more: object) -> Crew:
    """Return a session whose boat levels by itself before 90 m, its planes in hand."""
    settings = {"hand": frozenset({"planes"}), "guard": DepthGuard(90.0), **more}
    return crew("0 planes manual\n", **settings).man("instructor", "visitor")


def test_a_boat_whose_lever_is_held_down_levels_before_its_guarded_depth(crew: Make) -> None:
    here = guarded(crew)
    deepest, steepest = 0.0, 0.0
    for _ in range(480):
        here.say("visitor", sentences.order_sentence("lever dive 20"))
        here.fly(0.5)
        deepest = max(deepest, float(here.boat.state.z))
        steepest = max(steepest, abs(math.degrees(here.boat.state.theta)))
    assert 70.0 < deepest < 92.0
    assert steepest < 30.0


def test_a_lever_is_refused_while_the_boat_levels_and_works_when_it_is_level(crew: Make) -> None:
    here = guarded(crew).fly(0.5)
    here.say("visitor", "lever dive 20")
    while here.boat.state.bow_by_hand:
        here.fly(0.5)
    assert "guard: keeping depth 70 m" in here.heard("instructor")[-1]
    assert "levels by itself before 90 m" in here.program("visitor", "lever dive 20")
    while not here.boat.state.bow_by_hand:
        here.fly(0.5)
    assert "guard: lever zero, by hand" in here.heard("instructor")[-1]
    assert here.program("visitor", "lever rise 5") == "lever rise 5, by hand"
