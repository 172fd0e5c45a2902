"""What a station has seen or silenced of its pages' own alerts is kept for all of its pages."""

from types import SimpleNamespace

import pytest
from helpers.crewed import Begin, Crewed
from helpers.line import Line

from trainer.session.stations import own_alerts


def told(ship: Crewed, page: Line) -> list[str]:
    """Return what a page was told of its own alerts, without for how long."""
    return [each.rpartition(",")[0] for each in ship.facts(page, "own-alert")]


def test_what_one_page_has_seen_all_of_its_station_know(ship: Crewed) -> None:
    one, other, planes = ship.comes("helm"), ship.comes("helm"), ship.comes("planes")
    ship.say(one, "ack seen steering-rudder")
    assert told(ship, other) == told(ship, ship.comes("helm")) == ["steering-rudder,seen"]
    assert told(ship, one) == told(ship, planes) == told(ship, ship.comes("planes")) == []
    ship.say(other, "ack over steering-rudder")
    assert told(ship, one) == ["steering-rudder,over"]
    assert told(ship, ship.comes("helm")) == []


def test_silence_lasts_half_a_minute_on_a_page_that_comes_later(
    crewed: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = 100.0
    monkeypatch.setattr(own_alerts, "time", SimpleNamespace(monotonic=lambda: now))
    ship = crewed(seconds=None)
    one, other = ship.comes("helm"), ship.comes("helm")
    ship.say(one, "ack silent pitch")
    assert ship.facts(other, "own-alert") == ["pitch,silent,30.0"]
    now = 118.0
    assert ship.facts(ship.comes("helm"), "own-alert") == ["pitch,silent,12.0"]
    now = 131.0
    assert ship.facts(ship.comes("helm"), "own-alert") == []


def test_nothing_is_seen_of_what_time_has_gone_back_over(ship: Crewed) -> None:
    one = ship.comes("planes")
    ship.fly(2)
    ship.say(one, "ack seen pitch")
    ship.fly(8)
    ship.say(one, "ack seen diving-stern")
    ship.order("backtrack 2 s")
    assert told(ship, ship.comes("planes")) == ["pitch,seen"]


def test_a_role_keeps_the_latest_of_more_alerts_than_any_page_has(ship: Crewed) -> None:
    one = ship.comes("helm")
    for number in range(own_alerts.MAX_KEPT_ALERTS + 3):
        ship.say(one, f"ack seen alert-{number}")
    kept = told(ship, ship.comes("helm"))
    assert len(kept) == own_alerts.MAX_KEPT_ALERTS
    assert (kept[0], kept[-1]) == ("alert-3,seen", f"alert-{number},seen")
