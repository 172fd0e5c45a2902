"""Who mans what, and what is said where nobody does."""

import pytest
from helpers.crewed import Begin, Crewed
from helpers.orders import read_order

from trainer.io.orders.schedule import parse_schedule
from trainer.session.crew.manning import unheard

BOTH = frozenset({"rudder", "planes"})


@pytest.mark.parametrize(
    ("order", "hand", "roles", "said"),
    [
        (
            "order course 045",
            (),
            ("planes", "instructor"),
            "nobody mans the helm: `course 045` for the autopilot, `rudder left 5` by hand",
        ),
        (
            "order course left 045",
            (),
            (),
            (
                "nobody mans the helm: `course left to 045` for the autopilot, "
                "`rudder left 5` by hand"
            ),
        ),
        ("order course 045", ("rudder",), (), "nobody mans the helm: `rudder left 5` by hand"),
        (
            "order depth 80",
            (),
            ("helm",),
            (
                "nobody mans the planes: `depth 80 m` for the autopilot, "
                "`stern planes dive 5` by hand"
            ),
        ),
        (
            "order pitch 5 deg up",
            (),
            (),
            "nobody mans the planes: `stern planes dive 5` by hand",
        ),
        (
            "order speed 8",
            (),
            (),
            "nobody mans the helm: `speed 8 kn` for the autopilot, `bell ahead standard` by hand",
        ),
        ("tell hold her there", (), (), "nobody of the crew is here"),
        ("tell hold her there", (), ("ballast",), ""),
        ("order course 045", (), ("pilot",), ""),
        ("order depth 80", (), ("diving",), ""),
        ("order clear depth", (), (), ""),
        ("depth 80", (), (), ""),
    ],
)
def test_an_order_to_a_crew_that_is_not_there_says_how_else_it_is_carried_out(
    order: str, hand: tuple[str, ...], roles: tuple[str, ...], said: str
) -> None:
    assert unheard(read_order(order), hand, (), roles) == said


def test_ready_names_what_is_in_hand_and_has_nobody_at_it(crewed: Begin) -> None:
    ship = crewed(seconds=None, hand=BOTH)
    helm = ship.comes("helm")

    assert ship.say(helm, "ready") == ("ok", "ready; nobody mans the planes")
    assert ship.events(ship.instructor, "station")[-1] == (
        "helm at line 2 is ready; nobody mans the planes"
    )
    planes = ship.comes("planes")
    assert ship.say(planes, "ready") == ("ok", "ready; everybody is")


def test_the_crew_s_controls_are_in_hand_before_time_runs(crewed: Begin) -> None:
    schedule = parse_schedule("0 planes manual\n0.5 rudder manual", "orders.txt")
    assert isinstance(schedule, list)
    ship = crewed(seconds=None, schedule=schedule)
    ship.session.control.ended = True

    ship.session.run(frozen=True)

    state = ship.boat.state
    assert [state.stern_by_hand, state.bow_by_hand, state.rudder_by_hand] == [1.0, 1.0, 0.0]
    assert ship.boat.ticks == 0


@pytest.mark.parametrize(
    ("kept", "scored", "why"),
    [
        (False, True, "no marks: this session is not recorded"),
        (True, False, "no marks: nothing in this exercise has marks"),
    ],
)
def test_an_end_without_marks_says_so_and_nobody_waits_for_them(
    drill: Crewed, *, kept: bool, scored: bool, why: str
) -> None:
    drill.conduct.marks.scored = scored
    drill.conduct.marks.kept = drill.conduct.marks.kept if kept else None
    helm = drill.comes("helm")

    drill.fly(20)

    assert drill.facts(drill.instructor, "marks") == drill.facts(helm, "marks") == ["ended,"]
    assert drill.events(helm, "time")[-1] == why
    assert drill.refused("release marks") == why.removeprefix("no marks: ")
    assert drill.facts(drill.comes("planes"), "marks") == ["ended,"]
