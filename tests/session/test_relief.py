"""Persons relieve each other at a station: told, kept through jumps, and in the journal."""

from helpers.crewed import Begin


def test_a_relief_is_told_to_everybody_and_to_who_comes_later(crewed: Begin) -> None:
    ship = crewed(seconds=None)
    planes = ship.comes("planes")
    assert ship.say(planes, "relief Anna Ott") == ("ok", "Anna Ott has the watch")

    assert ship.say(planes, "Relief Berg") == ("ok", "Berg has the watch")

    assert ship.events(ship.instructor, "crew") == [
        "planes: Anna Ott has the watch",
        "planes: Berg has the watch, Anna Ott is relieved",
    ]
    late = ship.comes("helm")
    ship.say(late, "briefing")
    assert ship.facts(late, "watch")[-1] == "planes,Berg,"


def test_a_relief_is_kept_by_a_new_line_of_the_station_and_put_back_by_a_jump(
    crewed: Begin,
) -> None:
    ship = crewed(seconds=None)
    planes = ship.comes("planes")
    ship.say(planes, "relief Ott")
    ship.fly(5)
    ship.order("snapshot here")
    ship.leaves(planes)

    ship.say(ship.comes("planes"), "relief Berg")
    assert ship.session.crew.bill.watch == {"planes": "Berg"}
    ship.order("freeze")
    ship.order("restore here")

    assert ship.session.crew.bill.watch == {"planes": "Ott"}
    ship.session.crew.bill.watch.clear()
    ship.session.in_force.read_journal()
    ship.session.in_force.follow(ship.session.history.now())
    assert ship.session.crew.bill.watch == {"planes": "Ott"}


def test_who_works_nothing_has_no_watch(crewed: Begin) -> None:
    ship = crewed(seconds=None)

    said = ship.refused("relief Berg", ship.comes("observer"))

    assert said.startswith("the watch is the helm's or the planes station's")
