"""An alert lasts as long as its condition, and until somebody has seen it."""

import pytest
from helpers.crewed import Crewed
from helpers.line import Line

from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.depths import DEPTH_KEYS, WATCH_KEYS, called_depth
from trainer.boat.grounding import BEYOND_KEY
from trainer.boat.limits import (
    FOLLOWING_SEA_TEXT,
    LIMIT_WORDS,
    MAST_SPEED_TEXT,
    RANGE_RANKS,
    RANGE_WORDS,
)
from trainer.boat.pilot import GIVEN_UP_TEXTS, REMARK_NAMES, SHARED_SURFACES
from trainer.boat.plant_alerts import PLANT_RANKS
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.files import ConfigError
from trainer.io.recording.recording import RecordedEvent
from trainer.session.stations.alert_table import ALERT_TABLE, alert_row
from trainer.session.stations.alerts import (
    MAX_OPEN_ALERTS,
    REMARK_S,
    AlertBook,
    AlertNote,
    Instant,
)


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
            words[number] = ",".join(rest[1:]).rpartition(" s): ")[2]
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
    assert f"alert 2 over: {AT}" in ship.events(planes, "alert")


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


def test_each_branch_has_its_alerts_as_they_were_acknowledged_there(ship: Crewed) -> None:
    planes = ship.comes("planes")
    hold(ship, 230.0)
    ship.order("snapshot near")
    hold(ship, 230.0)
    acknowledge_all(ship, planes)
    hold(ship, 230.0)
    ship.order("freeze")
    ship.order("restore near")
    assert open_alerts(ship, planes) == {NEAR: "active"}
    hold(ship, 251.0)
    ship.order("freeze")
    ship.order("branch 1")
    assert open_alerts(ship, planes) == {NEAR: "acknowledged"}
    ship.order("branch 2")
    assert open_alerts(ship, planes) == {NEAR: "active", AT: "active"}


def test_a_run_that_goes_on_has_its_alerts_as_they_were(ship: Crewed) -> None:
    """As where a session is resumed from its recording."""
    planes = ship.comes("planes")
    hold(ship, 230.0)
    hold(ship, 251.0)
    first, second = (each.number for each in ship.session.event_log.alerts.listed[::-1])
    assert ship.say(planes, f"ack {first}")[0] == "ok"
    assert ship.say(planes, f"ack silent {second}")[0] == "ok"
    log, lists = ship.session.event_log, ship.session.event_log.account_alerts
    station = log.stations[0]
    ship.recording.flush()
    before = lists(station)
    log.alerts = AlertBook()
    log.__post_init__()
    log.own_alerts.by_role.clear()

    log.recall_alerts()
    log.take_up(ship.session.holding())

    assert [line.replace("silenced", "active") for line in before] == lists(station)
    assert [each.number for each in log.alerts.listed] == [second, first]
    assert log.alerts.open[first].seen_by == "planes"
    hold(ship, 301.0)
    assert log.alerts.listed[0].number == second + 1  # numbers go on


def test_a_replay_has_its_alerts_as_they_were_and_makes_none_of_its_own(ship: Crewed) -> None:
    planes = ship.comes("planes")
    ship.order("autopilot off")
    ship.boat.state.z = 219.0
    ship.order("snapshot above")
    ship.order("restore above")
    ship.order("blow stop")
    ship.order("stern planes dive 10")
    while not ship.session.event_log.alerts.listed:
        ship.fly(1)
    (known,) = ship.session.event_log.alerts.listed
    ship.fly(2)
    acknowledge_all(ship, planes)
    ship.fly(2)
    flown, noted = ship.session.history.tick, [*ship.session.event_log.alerts.notes]
    ship.order("freeze")

    ship.order(f"replay {flown * ship.boat.method.step:g} s")
    ship.fly(1)
    assert open_alerts(ship, planes) == {}
    ship.fly(known.raised.tick - 1)
    assert open_alerts(ship, planes) == {NEAR: "active"}
    assert [*ship.session.event_log.alerts.open] == [known.number]
    assert ship.events(planes, "depth")[-1].endswith(f" [{known.number}]")
    acknowledge_all(ship, planes)  # of what is replayed nothing is changed
    assert [*ship.session.event_log.alerts.notes] == noted
    ship.fly(flown)

    assert ship.session.history.tick == flown
    assert open_alerts(ship, planes) == {NEAR: "acknowledged"}
    assert [each.number for each in ship.session.event_log.alerts.listed] == [known.number]


def test_an_alert_that_is_acknowledged_in_a_replay_is_owed_after_it(ship: Crewed) -> None:
    planes = ship.comes("planes")
    ship.order("autopilot off")
    ship.boat.state.z = 219.0
    ship.order("snapshot above")
    ship.order("restore above")
    ship.order("blow stop")
    ship.order("stern planes dive 10")
    while not ship.session.event_log.alerts.listed:
        ship.fly(1)
    ship.fly(4)
    ship.order("freeze")

    ship.order(f"replay {3 * ship.boat.method.step:g} s")
    ship.fly(1)
    acknowledge_all(ship, planes)
    assert open_alerts(ship, planes) == {NEAR: "acknowledged"}
    ship.fly(3)

    assert not ship.session.history.flown.replaying
    assert open_alerts(ship, planes) == {NEAR: "active"}


def test_a_note_of_an_alert_that_is_damaged_is_told() -> None:
    for text in ("{", "[]", '["seen"]', '["gone", 1]', '["raised", 1]', '["seen", null]'):
        event = RecordedEvent(1, 7, "alert-note", "", text, "")
        with pytest.raises(ConfigError, match="alert-note at tick 7: damaged"):
            AlertNote.of(event, 0.5)


def test_what_holds_where_nobody_has_flown_is_told_without_news(ship: Crewed) -> None:
    """As where a recorded run goes on, or an exercise begins too deep."""
    ship.boat.state.z = 259.5
    ship.session.monitors.follow(ship.session.history.now())
    ship.session.event_log.take_up(ship.session.holding())
    late = ship.comes("planes")
    held = {
        "Near test depth: 30 m above it": "active",
        "Test depth passed: at test depth": "active",
    }
    assert open_alerts(ship, late) == held
    assert ship.events(late, "depth") == []
    hold(ship, 259.5)
    assert open_alerts(ship, late) == held


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
    helm = ship.comes("helm")
    limits = ship.session.monitors.limits
    limits.limits = ExerciseLimits(depth_m_max=140.0)
    limits.__post_init__()
    for depth, state in ((141.0, "active"), (139.0, "rectified")):
        hold(ship, depth)
        told = open_alerts(ship, ship.instructor)
        assert told["LIMIT: deeper than 140 m"] == state
    over = "alert 1 over: LIMIT: deeper than 140 m"
    assert over in ship.events(ship.instructor, "exercise")
    assert not any("LIMIT" in said for said in helm.sent)  # a crew hears nothing of a truth


def test_the_table_has_each_alert_with_the_rank_of_its_call(ship: Crewed) -> None:
    """All others are flown, or follow one another in a table of their monitor."""
    depths = [called_depth(250.0, index).call for index in range(3)]
    assert [alert_row(call.key).rank for call in depths] == [call.rank for call in depths]
    assert [alert_row(name).rank for name in RANGE_WORDS[1:]] == [*RANGE_RANKS[1:]]
    for name in GIVEN_UP_TEXTS:
        remark = name in REMARK_NAMES
        assert alert_row(name).rank is (Rank.CAUTION if remark else Rank.WARNING)
    named = {*DEPTH_KEYS, *WATCH_KEYS, *LIMIT_WORDS, *RANGE_WORDS[1:], *GIVEN_UP_TEXTS}
    named |= PLANT_RANKS.keys()
    named |= {FOLLOWING_SEA_TEXT, MAST_SPEED_TEXT, BEYOND_KEY, "collapse", "collision", "approach"}
    named |= {"engine limited", *(f"{each} short on the X-tail" for each in SHARED_SURFACES)}
    assert ALERT_TABLE.keys() == named | {"aground", "surfaced", "broached", ""}
    assert not ship.session.holding()


def test_a_responsible_station_acknowledges_and_the_others_silence(ship: Crewed) -> None:
    helm = ship.comes("helm")
    hold(ship, 230.0)
    hold(ship, 251.0)
    numbers = [told.partition(",")[0] for told in ship.facts(helm, "alert")]
    assert ship.facts(helm, "alert-state")[-1] == f"{numbers[1]},active,0.0,you,test depth"
    assert ship.say(helm, f"ack {numbers[0]}")[0] == "ok"  # nobody else is there

    planes = ship.comes("planes")
    assert ship.facts(helm, "alert-state")[-1] == f"{numbers[1]},active,0.0,planes,test depth"
    only = f"planes acknowledges it; here only ack silent {numbers[1]}"
    assert ship.refused(f"ack {numbers[1]}", helm) == only
    assert ship.refused(f"ack {numbers[1]}") == only  # an instructor is no planesman
    assert ship.say(helm, f"ack silent {numbers[1]}")[0] == "ok"
    ship.leaves(planes)
    assert ship.facts(helm, "alert-state")[-1].endswith("silenced,30.0,you,test depth")


def test_a_trainee_answers_for_all(ship: Crewed) -> None:
    trainee, _ = ship.comes("trainee"), ship.comes("planes")
    hold(ship, 251.0)
    acknowledge_all(ship, trainee)
    assert open_alerts(ship, trainee) == {AT: "acknowledged"}


def test_nobody_of_a_crew_acknowledges_all_at_once(ship: Crewed) -> None:
    """A program of before is told how it is done now."""
    planes = ship.comes("planes")
    hold(ship, 230.0)
    hold(ship, 251.0)
    refused = ship.refused("ack all", planes)
    assert refused == "each alert is acknowledged by itself: ack 2; ack 1"
    ship.leaves(planes)
    ship.order("ack all")
    assert {*open_alerts(ship, ship.instructor).values()} == {"acknowledged"}


def test_a_terminal_lists_what_the_pages_do_and_the_instructor_what_is_over(ship: Crewed) -> None:
    planes = ship.comes("planes")
    assert ship.say(planes, "alerts")[0] == "ok"
    assert ship.said == ["no alerts"]
    hold(ship, 230.0)
    acknowledge_all(ship, planes)
    hold(ship, 276.0)
    ship.say(planes, "alerts")
    seen = f"1 alarm at 00:00:00, acknowledged: {NEAR}; acknowledged by planes after 0.5 s"
    assert ship.said == [f"2 emergency at 00:00:01, active: {BEYOND}", seen]
    hold(ship, 210.0)
    ship.say(ship.instructor, "alerts")
    assert ship.said == [
        f"2 emergency at 00:00:01, normal: {BEYOND}; over at 00:00:02",
        f"{seen.replace('acknowledged:', 'normal:')}; over at 00:00:02",
    ]


def test_the_list_has_first_what_is_owed_then_by_rank_then_the_newest() -> None:
    book, now = AlertBook(), Instant(1, 0, 0.0)
    ranks = (Rank.ALARM, Rank.WARNING, Rank.EMERGENCY, Rank.ALARM, Rank.CAUTION, Rank.ALARM)
    for rank in ranks:
        book.add("watch", MonitorCall("", rank, "holds"), now)
    book.see(book.open[4], "helm", now)
    assert [alert.number for alert in book.listed] == [3, 6, 1, 2, 4, 5]
