"""An alert lasts as long as its condition, and until somebody has seen it."""

from helpers.crewed import Crewed
from helpers.line import Line

from trainer.boat.calls import MonitorCall, Rank
from trainer.config.exercise import ExerciseLimits
from trainer.session.stations.alerts import MAX_OPEN_ALERTS, REMARK_S, AlertBook, Instant


def hold(ship: Crewed, depth: float, ticks: int = 2) -> None:
    """Let time go on with the boat level at a depth [m]; test depth is 250 m."""
    for _ in range(ticks):
        ship.boat.state.z, ship.boat.state.theta = depth, 0.0
        ship.fly(1)


def open_alerts(ship: Crewed, line: Line) -> dict[str, str]:
    """Return what a program holds for open: the words of each alert, and its state."""
    words: dict[str, str] = {}
    states: dict[str, str] = {}
    for what, subject in ship.all_facts(line):
        number, *rest = subject.split(",")
        if what == "alerts":
            words, states = {}, {}
        elif what == "alert":
            words[number] = ",".join(rest[1:]).rpartition("s): ")[2]
        elif what == "alert-state":
            states[number] = rest[0]
    return {words[each]: state for each, state in states.items() if state != "normal"}


def acknowledge_all(ship: Crewed, line: Line) -> None:
    """Acknowledge each alert that is owed it, by its number."""
    for each in ship.session.event_log.alerts.listed:
        if each.owed:
            assert ship.say(line, f"ack {each.number}")[0] == "ok"


NEAR, AT = "Passing 220 m, 30 m above test depth", "Passing test depth, 250 m"
BEYOND = "Passing 275 m, 25 m beyond test depth"


def test_an_acknowledged_alarm_stands_as_long_as_the_boat_is_too_deep(ship: Crewed) -> None:
    planes = ship.comes("planes")
    hold(ship, 259.5)
    acknowledge_all(ship, planes)
    hold(ship, 259.5, 140)  # 70 s
    late = ship.comes("diving")
    assert any("test depth, 250 m" in told for told in ship.facts(late, "alert"))
    assert open_alerts(ship, planes) == open_alerts(ship, late)
    assert open_alerts(ship, late)[AT] == "acknowledged"


def test_an_alarm_is_over_with_a_margin_and_an_unseen_one_waits_to_be_seen(ship: Crewed) -> None:
    planes = ship.comes("planes")
    hold(ship, 230.0)
    hold(ship, 251.0)
    assert open_alerts(ship, planes)[AT] == "active"
    hold(ship, 246.0)
    assert open_alerts(ship, planes)[AT] == "active"
    hold(ship, 244.0)
    assert open_alerts(ship, planes)[AT] == open_alerts(ship, ship.comes("diving"))[AT]
    assert open_alerts(ship, planes)[AT] == "rectified"
    assert open_alerts(ship, planes)[NEAR] == "active"
    acknowledge_all(ship, planes)
    assert open_alerts(ship, planes) == {NEAR: "acknowledged"}
    hold(ship, 200.0)
    assert open_alerts(ship, planes) == {}
    assert f"alert 2 over: {AT}" in ship.events(planes, "depth")


def test_a_depth_further_beyond_takes_the_place_of_the_one_before(ship: Crewed) -> None:
    planes = ship.comes("planes")
    hold(ship, 276.0)
    hold(ship, 301.0)
    further = "Passing 300 m, 50 m beyond test depth"
    assert {BEYOND, further} & open_alerts(ship, planes).keys() == {further}


def test_an_emergency_takes_no_acknowledgement_but_silence_at_each_station(ship: Crewed) -> None:
    planes, other = ship.comes("planes"), ship.comes("diving")
    hold(ship, 276.0)
    number = ship.facts(planes, "alert-state")[-1].partition(",")[0]
    refused = ship.refused(f"ack {number}", planes)
    assert refused == f"an emergency takes no acknowledgement: ack silent {number}"
    assert ship.say(planes, f"ack silent {number}")[0] == "ok"
    assert open_alerts(ship, planes)[BEYOND] == "silenced"
    assert open_alerts(ship, ship.comes("planes"))[BEYOND] == "silenced"
    assert open_alerts(ship, other)[BEYOND] == "active"
    hold(ship, 240.0)
    assert BEYOND not in open_alerts(ship, planes)
    assert ship.refused(f"ack silent {number}", planes) == f"no alert {number} sounds here"


def test_a_jump_tells_all_that_holds_then_as_it_was_then_and_nothing_later(ship: Crewed) -> None:
    planes = ship.comes("planes")
    hold(ship, 230.0)
    ship.order("snapshot near")
    acknowledge_all(ship, planes)
    ship.order("snapshot seen")
    hold(ship, 251.0)
    hold(ship, 100.0)
    acknowledge_all(ship, planes)
    assert open_alerts(ship, planes) == {}
    ship.order("restore seen")
    assert open_alerts(ship, planes) == {NEAR: "acknowledged"}
    hold(ship, 100.0)
    ship.order("restore near")
    # a moment holds no later remark: it was seen in the same tick
    assert open_alerts(ship, planes) == open_alerts(ship, ship.comes("diving"))
    assert open_alerts(ship, planes).keys() == {NEAR}


def test_what_holds_where_nobody_has_flown_is_told_without_news(ship: Crewed) -> None:
    """As where a recorded run goes on, or an exercise begins too deep."""
    ship.boat.state.z = 259.5
    ship.session.monitors.follow(ship.session.history.now())
    ship.session.event_log.take_up(ship.session.holding())
    late = ship.comes("planes")
    assert open_alerts(ship, late) == {NEAR: "active", AT: "active"}
    assert ship.events(late, "depth") == []
    hold(ship, 259.5)
    assert open_alerts(ship, late) == {NEAR: "active", AT: "active"}


def test_a_remark_without_a_condition_is_over_by_itself(ship: Crewed) -> None:
    planes = ship.comes("planes")
    ship.session.event_log.alert("pilot", MonitorCall("the ascent is over", Rank.CAUTION))
    assert open_alerts(ship, planes) == {"the ascent is over": "active"}
    ship.fly(round(REMARK_S / ship.boat.method.step) - 1)
    assert open_alerts(ship, planes) == {"the ascent is over": "active"}
    ship.fly(1)
    assert open_alerts(ship, planes) == {}


def test_the_book_keeps_no_more_than_so_many_alerts() -> None:
    book = AlertBook()
    for tick in range(MAX_OPEN_ALERTS + 3):
        book.add("watch", MonitorCall("again"), Instant(1, tick, 0.5 * tick))
    assert [*book.open] == [*range(4, MAX_OPEN_ALERTS + 4)]
    assert len(book.past) == 3


def test_a_limit_of_the_exercise_is_over_as_soon_as_the_boat_is_within_it(ship: Crewed) -> None:
    limits = ship.session.monitors.limits
    limits.limits = ExerciseLimits(depth_m_max=140.0)
    limits.__post_init__()
    for depth, state in ((141.0, "active"), (139.0, "rectified")):
        hold(ship, depth)
        told = open_alerts(ship, ship.instructor)
        assert told["LIMIT: deeper than 140 m"] == state
