"""The alerts of a session at a console: kept as told, drawn with what is due, at every station."""

import pytest
from helpers.screens import CREW, Tape, at_the_console, seen, shown, sight_of, tape
from textual.pilot import Pilot

from trainer.console.alerts import AlertList
from trainer.console.app import Console
from trainer.console.drawing.alerts import alerts
from trainer.console.pane import plain
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused

ALARM = (3, "alarm", "Passing test depth, 250 m")
WARNING = (4, "warning", "the mast shakes")
EMERGENCY = (5, "emergency", "Passing 275 m, 25 m beyond test depth")
CAUTION = (6, "caution", "surfaced")


def tell(talk: Tape, *raised: tuple[int, str, str]) -> None:
    """Have a session tell of alerts that have come at 65 s."""
    for number, rank, words in raised:
        talk.say(sentences.fact(130, 65.0, "alert-rank", f"{number},{rank}"))
        text = f"tick 130 (65 s): {words}"
        talk.say(sentences.fact(130, 65.0, "alert", f"{number},depth,{text}"))
        become(talk, number, "active")


def become(talk: Tape, number: int, state: str, left: float = 0.0, duty: str = "you") -> None:
    fields = f"{number},{state},{left:.1f},{duty},test depth"
    talk.say(sentences.fact(140, 70.0, "alert-state", fields))


def drawn(talk: Tape, width: int = 80, height: int = 4, clock: float = 100.0) -> list[str]:
    model = sight_of(talk, "planes", clock)
    model.hear()
    return plain(alerts(model, width, height)).splitlines()


def test_alerts_are_listed_with_what_is_owed_first_and_the_order_that_is_due() -> None:
    talk = tape("planes")
    tell(talk, ALARM, WARNING, EMERGENCY, CAUTION)
    become(talk, 4, "acknowledged")
    assert drawn(talk) == [
        " 00:01:05 emergency, active: Passing 275 m, 25 m beyond test depth ack silent 5",
        " 00:01:05 alarm, active: Passing test depth, 250 m                        ack 3",
        " 00:01:05 warning, acknowledged: the mast shakes",
        " 00:01:05 caution, active: surfaced",
    ]


def test_alerts_without_room_are_counted() -> None:
    talk = tape("planes")
    tell(talk, ALARM, WARNING, EMERGENCY)
    assert [line[:20] for line in drawn(talk, height=2)] == [
        " 00:01:05 emergency,",
        " and 2 more: type al",
    ]


def test_an_alert_that_is_over_and_seen_leaves_the_list_and_an_unseen_one_stays() -> None:
    talk = tape("planes")
    tell(talk, ALARM, WARNING)
    become(talk, 3, "rectified")
    become(talk, 4, "normal")
    (line,) = drawn(talk)
    assert line.startswith(" 00:01:05 alarm, over, not seen: Passing test depth")
    assert line.endswith(" ack 3")


def test_after_a_jump_in_time_the_alerts_are_those_that_are_told_anew() -> None:
    talk = tape("planes")
    tell(talk, ALARM, EMERGENCY)
    talk.say(sentences.fact(140, 70.0, "alerts", "1"))
    tell(talk, WARNING)
    (line,) = drawn(talk)
    assert "the mast shakes" in line


def test_another_station_s_alert_is_told_with_whose_it_is() -> None:
    talk = tape("planes")
    tell(talk, ALARM)
    become(talk, 3, "active", duty="ballast diving")
    assert drawn(talk)[0].endswith(" for ballast or diving; ack silent 3")


def test_a_silence_ends_by_itself() -> None:
    now = 100.0
    listed = AlertList(lambda: now)
    listed.take_rank(1.0, "3,alarm")
    listed.take(1.0, "3,depth,tick 2 (1 s): too deep")
    listed.take_state(1.0, "3,silenced,30.0,you,test depth")
    (alert,) = listed.listed
    assert (alert.state(129.0), alert.state(130.5)) == ("silenced", "active")


QUICK = ("instructor", "diving", "trainee")
SIZES = ((60, 18), (80, 20), (120, 40), (200, 60))
QUICK_SIZE = (80, 24)
LOOKED_AT = [
    *((role, QUICK_SIZE) for role in QUICK),
    *(
        pytest.param(role, size, marks=pytest.mark.slow)
        for role in ("instructor", *CREW, "trainee")
        for size in (SIZES if role in QUICK else (QUICK_SIZE, *SIZES))
    ),
]


@pytest.mark.parametrize(("role", "size"), LOOKED_AT)
def test_every_station_shows_its_alerts_and_keeps_its_line(
    role: str, size: tuple[int, int]
) -> None:
    talk = tape(role)

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        assert not app.screen.query_one("#alerts").display
        tell(talk, ALARM)
        await seen(pilot, app, "alarm, active: Passing test depth, 250 m")
        assert "ack 3" in shown(app)
        assert app.screen.query_one("#entry").region.bottom <= size[1]
        record = app.screen.query_one("#record").region
        assert record.height >= 1
        assert record.bottom <= app.screen.query_one("#bottom").region.y
        become(talk, 3, "normal")
        for _ in range(200):
            if not app.screen.query_one("#alerts").display:
                return
            await pilot.pause(0.02)
        raise AssertionError

    at_the_console(look, talk, role, size)
