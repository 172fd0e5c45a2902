"""Who works an axis: taken by working it or by saying so, and told to both stations."""

import gc
from typing import NamedTuple

import pytest
from helpers.crewed import Begin, Crewed
from helpers.line import Line
from helpers.orders import read_order

from trainer.io.recording.facts import SCHEDULE_GIVER, Giver, station
from trainer.session.crew.crew import Talk
from trainer.session.crew.watch_bill import WatchBill
from trainer.session.stations.roles import ROLES

TAKEN = "pilot at line 3 has the planes, which planes at line 2 had"
PLANES, PILOT = station("planes", "line 2"), station("pilot", "line 3")


class Pair(NamedTuple):
    """A session with planes at line 2 and a pilot at line 3, who both work the planes."""

    ship: Crewed
    planes: Line
    pilot: Line


@pytest.fixture
def pair(crewed: Begin) -> Pair:
    ship = crewed(seconds=None)
    return Pair(ship, ship.comes("planes"), ship.comes("pilot"))


@pytest.mark.parametrize(
    "words", ["stern planes rise 5", "bow planes zero", "depth 70", "I have the planes"]
)
def test_both_stations_and_the_instructor_hear_who_takes_an_axis(pair: Pair, words: str) -> None:
    ship, planes, pilot = pair
    assert ship.say(planes, "stern planes dive 3")[0] == "ok"

    assert ship.say(pilot, words)[0] == "ok"

    for line in (planes, pilot, ship.instructor):
        assert TAKEN in ship.events(line, "crew")
        assert ship.facts(line, "has") == [
            "planes,planes at line 2,",
            "planes,pilot at line 3,planes at line 2",
        ]


def test_who_works_an_axis_alone_makes_no_news(pair: Pair) -> None:
    ship, planes, _ = pair
    for words in ("stern planes dive 3", "I have the planes", "bow planes rise 2"):
        ship.say(planes, words)

    assert ship.events(ship.instructor, "crew") == []
    assert ship.facts(planes, "has") == ["planes,planes at line 2,"]


def test_who_comes_later_is_told_who_has_what(pair: Pair) -> None:
    ship, _, pilot = pair
    ship.say(pilot, "rudder left 5")
    ship.say(pilot, "turns 8")

    late = ship.comes("helm")
    ship.say(late, "briefing")

    assert ship.facts(late, "has")[:2] == ["rudder,pilot at line 3,", "speed,pilot at line 3,"]


def test_what_is_not_a_station_s_to_work_it_cannot_have(pair: Pair) -> None:
    ship, planes, _ = pair
    said = ship.refused("I have the rudder", planes)

    assert said == "the rudder is the helm's or the pilot's; you have the planes"
    assert ship.facts(ship.instructor, "has") == []


def test_a_jump_puts_back_who_had_an_axis(pair: Pair) -> None:
    ship, planes, pilot = pair
    ship.say(planes, "stern planes dive 3")
    ship.fly(10)
    ship.order("snapshot here")
    ship.say(pilot, "I have the planes")
    assert ship.session.crew.bill.shown == "planes pilot"
    ship.order("freeze")

    ship.order("restore here")

    assert ship.session.crew.bill.shown == "planes planes"


def test_what_stands_after_each_order_shares_who_has_what(pair: Pair) -> None:
    ship, planes, _pilot = pair
    ship.say(planes, "stern planes dive 3")
    hands = ship.session.crew.talk.hands
    for course in range(10, 20):
        ship.say(ship.instructor, f"order course 0{course}")
    gc.collect()
    kept = [each for each in gc.get_objects() if type(each) is Talk and each.hands == hands]
    assert len(kept) >= 10
    assert len({id(each.hands) for each in kept}) == 1


def test_a_recording_tells_who_had_an_axis(pair: Pair) -> None:
    ship, planes, pilot = pair
    ship.say(planes, "stern planes dive 3")
    ship.say(pilot, "depth 70")
    standing = ship.session.in_force
    ship.session.crew.bill.hands.clear()
    standing.read(ship.recording.orders(1, 0))

    standing.follow(ship.session.history.now())

    assert ship.session.crew.bill.hands == {"planes": PILOT}


@pytest.mark.parametrize(
    ("words", "axes"),
    [
        ("autopilot on", "rudder planes speed ballast"),
        ("autopilot off", "rudder planes speed ballast"),
        ("hover on", "ballast"),
        ("planes auto", "planes"),
        ("speed 8", "speed"),
        ("course 045", "rudder"),
        ("have ballast", "ballast"),
        ("emergency blow", ""),
        ("scope raise", ""),
        ("order depth 60", ""),
    ],
)
def test_an_order_takes_the_axes_that_it_works(words: str, axes: str) -> None:
    bill = WatchBill()

    bill.take(read_order(words), PLANES)

    assert " ".join(bill.hands) == axes


def test_the_officer_of_the_deck_takes_back_his_own_orders_alone(crewed: Begin) -> None:
    ship = crewed(seconds=None)
    deck = ship.comes("deck")
    assert ship.say(deck, "make your depth 60 metres") == ("ok", "ordered: depth 60 m")
    ship.order("order pitch 3 up")

    assert ship.refused("belay", deck).endswith("who orders course, depth and speed alone")

    assert ship.say(deck, "belay depth")[0] == "ok"
    assert ship.say(ship.comes("planes"), "aye")[1] == "pitch 3 up aye"


@pytest.mark.parametrize("giver", [SCHEDULE_GIVER])
def test_what_is_no_station_takes_no_axis(giver: Giver) -> None:
    bill = WatchBill()

    assert bill.take(read_order("stern planes dive 3"), giver) == []
    assert bill.hands == {}


@pytest.mark.parametrize("role", ROLES)
def test_whoever_may_say_that_it_has_an_axis_may_work_one(role: str) -> None:
    works = {"rudder", "stern", "bell", "pump"} & ROLES[role].commands

    assert ("have" in ROLES[role].commands) == bool(works)
