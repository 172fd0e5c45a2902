"""Orders to the crew on its panels: beside the instrument, with what is to go, until repeated."""

from typing import Any

import pytest
from helpers.screens import (
    CREW,
    VALUES,
    ScriptedLine,
    Tape,
    at_the_console,
    pressed,
    seen,
    shown,
    sight_of,
    tape,
    typed,
)
from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.client import LineLoss, RoleTaken
from trainer.console.drawing.dials import Gauge, dial
from trainer.console.layouts import LAYOUTS
from trainer.console.model import SessionModel
from trainer.console.pane import Pane, plain
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused
from trainer.session.stations.channels import CHANNELS

FIELDS = (
    "course", "course_side", "course_error", "course_since",
    "depth", "depth_unit", "depth_error", "depth_since",
    "speed", "speed_error", "speed_since",
    "pitch", "pitch_error", "pitch_since", "told",
)  # fmt: skip
COURSE = {"course": "45", "course_side": "", "course_error": "7.2", "course_since": "50"}
DEPTH = {"depth": "60", "depth_unit": "m", "depth_error": "12.0", "depth_since": "50"}
SPEED = {"speed": "8", "speed_error": "-2.0", "speed_since": "50"}
PITCH = {"pitch": "-5", "pitch_error": "-3.0", "pitch_since": "50"}
ALL = COURSE | DEPTH | SPEED | PITCH


def ordered(role: str, told: dict[str, str]) -> Tape:
    """Return a session in which the crew has been ordered so."""
    talk = tape(role)
    tell(talk, told)
    return talk


def tell(talk: Tape, told: dict[str, str], tick: int = 121) -> None:
    row = [told.get(name, "") for name in FIELDS]
    talk.say(sentences.state("orders", tick, tick / 2.0, row))


def new(talk: Tape, subject: str) -> None:
    talk.say(sentences.fact(121, 60.5, "crew-order", subject))


def screen_of(
    talk: Tape, role: str, *words: str, absent: tuple[str, ...] = (), size: Any = (80, 24)
) -> Console:
    """Look at a screen until it shows some words, the last of them in blue; return it."""

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        for text in words:
            await seen(pilot, app, text)
        for text in absent:
            assert text not in shown(app)
        assert inks_of(app, words[-1]) <= {"ordered", "new", "warning", "heading-dim"}

    return at_the_console(look, talk, role, size)[0]


def inks_of(app: Console, text: str) -> set[str]:
    """Return the inks in which a text is drawn."""
    return {
        ink
        for pane in app.screen_stack[0].query(Pane)
        for row in pane.lines
        for part, ink in row
        if text in part
    }


@pytest.mark.long
@pytest.mark.parametrize("size", [(80, 24), (120, 40), (200, 60)])
@pytest.mark.parametrize("role", CREW)
def test_what_is_ordered_stands_beside_the_instrument_with_what_is_to_go(
    role: str, size: tuple[int, int]
) -> None:
    words = ("045, 7 ", "right", "60 m, 12 deeper", "8 kn, 2.0 slower", "5 down, 3 ")
    screen_of(ordered(role, ALL), role, *words, size=size)


def test_the_instructor_sees_what_the_crew_is_ordered_and_its_error() -> None:
    told = "045, 7 to the right; 60 m, 12 deeper"
    screen_of(ordered("instructor", COURSE | DEPTH), "instructor", told)
    screen_of(ordered("instructor", ALL), "instructor", "045 +7; 60 m +12; 8 kn -2; 5 down -3")


@pytest.mark.parametrize("size", [(80, 24), (200, 60)])
def test_what_is_ordered_by_hand_stands_beside_what_the_boat_does(
    size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("ordered_depth", "ordered_course", "ordered_speed"):
        monkeypatch.setitem(VALUES, name, "")  # no autopilot keeps it
    beside = ("> 60.0 m", "> 045", "> 8.0 kn")
    screen_of(ordered("instructor", ALL), "instructor", *beside, size=size)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"course": "0", "course_error": "-179.0"}, "ordered 000, 179 left"),
        ({"course": "360", "course_error": "0.2"}, "ordered 000, on course"),
        ({"depth": "60", "depth_error": "-0.3", "depth_unit": "m"}, "ordered 60 m, at depth"),
        ({"depth": "60", "depth_error": "-4", "depth_unit": "m"}, "ordered 60 m, 4 higher"),
        (
            {"depth": "60.96", "depth_error": "-3.05", "depth_unit": "ft"},
            " 200 ft, 10 higher",
        ),
        ({"speed": "8", "speed_error": "1.5"}, "ordered 8 kn, 1.5 faster"),
        ({"pitch": "0", "pitch_error": "2"}, "ordered zero, 2.0 to go up"),
    ],
)
def test_the_error_has_its_side_in_words(told: dict[str, str], words: str) -> None:
    screen_of(ordered("pilot", told), "pilot", words)


def test_the_depth_gauge_is_in_feet_where_the_order_was() -> None:
    told = {"depth": "60.96", "depth_error": "0.96", "depth_unit": "ft"}
    screen_of(ordered("planes", told), "planes", "depth  ft", absent=("depth  m ",))
    screen_of(ordered("planes", told), "planes", "depth 196.9", " ╌╌ 200.0", "ft  2 min")


def test_without_an_order_to_the_crew_the_autopilot_s_stands_there() -> None:
    screen_of(ordered("planes", {}), "planes", "ordered 80.0", absent=("deeper", "NEW"))


@pytest.mark.parametrize("keys", [("enter",), ("enter", "m")])
def test_enter_repeats_a_new_order_and_does_no_more(keys: tuple[str, ...]) -> None:
    talk = ordered("helm", COURSE)
    new(talk, "course 045")
    rest = ["rudder amidships"] * (len(keys) - 1)
    assert pressed(keys, "helm", talk) == ["aye", *rest]


def test_a_colon_begins_an_order_also_while_one_is_to_be_repeated_and_is_no_part_of_it() -> None:
    talk = ordered("helm", COURSE)
    new(talk, "course 045")
    keys = ("colon", "colon", *typed("rudder right 9"), "enter")
    assert pressed(keys, "helm", talk) == ["rudder right 9"]


def test_a_narrow_chart_leaves_out_its_unit_before_it_touches_the_value() -> None:
    told = {"course": "0", "course_error": "0.2"}
    screen_of(ordered("trainee", told), "trainee", "╌╌ 000     2 min", size=(60, 24))


def test_a_rate_is_shown_with_its_side_or_not_at_all() -> None:
    gauge = Gauge("depth", "depth", "60.0", "m", "", "0.44 m/s down")
    model = SessionModel(ScriptedLine(), "trainee", LAYOUTS["trainee"].charts)
    assert plain(dial(model, gauge, 26)[:1]) == " depth  m  0.44 m/s down"
    assert plain(dial(model, gauge, 20)[:1]) == " depth  m"


def test_enter_on_the_open_and_empty_line_repeats_too() -> None:
    talk = ordered("helm", COURSE)

    async def press(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("enter")
        new(talk, "course 045")
        await seen(pilot, app, "NEW ORDER")
        await pilot.press("enter")

    assert at_the_console(press, talk, "helm")[1].orders == ["aye"]


def test_an_order_is_new_until_it_is_repeated() -> None:
    talk = ordered("helm", COURSE)
    new(talk, "course right to 045")

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "NEW ORDER  course right to 045   Enter repeats it")
        await seen(pilot, app, "NEW: 045")
        assert inks_of(app, "NEW: 045") == {"new"}
        talk.say(sentences.fact(123, 61.5, "repeated", "course right to 045"))
        await seen(pilot, app, "ordered 045")
        assert "NEW" not in shown(app)
        new(talk, "course 050")
        talk.say(sentences.fact(123, 61.5, "wrong-repeat", "055; course 050"))
        await seen(pilot, app, "REPEATED WRONG: 055; ordered course 050")
        talk.say(sentences.fact(60, 30.0, "back", "backtrack 30 s"))
        await seen(pilot, app, "ordered 045")
        assert "NEW" not in shown(app)

    at_the_console(look, talk, "helm")


def test_after_a_lost_line_only_what_is_told_again_is_new() -> None:
    talk = ordered("helm", COURSE)
    new(talk, "course 045")
    model = sight_of(talk, "helm")
    model.hear()
    assert model.crew.to_repeat("helm")
    talk.items += [LineLoss("the session has closed the line"), RoleTaken()]
    model.hear()
    assert model.crew.to_repeat("helm") is None
    new(talk, "course 045")
    model.hear()
    assert model.crew.to_repeat("helm")


def test_only_who_is_ordered_repeats_and_is_shown_that_it_is_new() -> None:
    talk = ordered("planes", COURSE)
    new(talk, "course 045")
    assert pressed(("enter",), "planes", talk) == []
    talk = ordered("planes", COURSE)
    new(talk, "course 045")
    screen_of(talk, "planes", "ordered 045, 7", absent=("NEW",))


def test_charts_show_what_the_crew_is_ordered_in_place_of_the_autopilot_s() -> None:
    model = sight_of(ordered("planes", DEPTH | PITCH), "planes")
    model.hear()
    depth, pitch = model.quantities
    number = model.picture.number
    assert (depth.order(number), pitch.order(number)) == (60.0, -5.0)
    model = sight_of(ordered("planes", {}), "planes")
    model.hear()
    number = model.picture.number
    assert (depth.order(number), pitch.order(number)) == (80.0, None)


def test_the_instructor_is_told_how_long_an_order_has_not_been_repeated() -> None:
    talk = ordered("instructor", COURSE)
    new(talk, "course 045")
    talk.tick(141)
    screen_of(talk, "instructor", "NEW course 045, not repeated for 10 s")


def test_what_is_told_stands_on_the_panel() -> None:
    for role in CREW:
        talk = ordered(role, {"told": "hold 60, pumps only"})
        new(talk, "tell hold 60, pumps only")
        talk.say(sentences.fact(123, 61.5, "repeated", "tell hold 60, pumps only"))
        screen_of(talk, role, "told: hold 60, pumps only")


def test_who_has_given_an_order_does_not_repeat_it() -> None:
    talk = ordered("diving", DEPTH)
    talk.facts["order depth 60"] = [("crew-order", "depth 60 m"), ("own-order", "depth 60 m")]

    async def give(pilot: Pilot[Refused], app: Console) -> None:
        app.model.order("order depth 60")
        await seen(pilot, app, "order depth 60: done")
        assert "NEW" not in shown(app)
        new(talk, "depth 70 m")
        await seen(pilot, app, "NEW ORDER  depth 70 m")
        talk.say(sentences.fact(124, 62.0, "belayed", "depth 70 m"))
        await pilot.pause(0.2)
        assert "NEW" not in shown(app)

    at_the_console(give, talk, "diving")


def test_after_the_end_of_an_exercise_no_order_is_new_and_gone_back_it_is_again() -> None:
    talk = ordered("planes", DEPTH)
    new(talk, "depth 70 m")

    async def end(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "NEW ORDER  depth 70 m")
        talk.say(sentences.fact(130, 65.0, "exercise-over", "won"))
        new(talk, "course 045")  # told once more to who comes late
        new(talk, "depth 70 m")
        await pilot.pause(0.2)
        assert "NEW" not in shown(app)
        talk.say(sentences.fact(122, 61.0, "back", "backtrack 4 s"))
        new(talk, "depth 70 m")
        await seen(pilot, app, "NEW ORDER  depth 70 m")

    at_the_console(end, talk, "planes")


def test_of_two_new_orders_both_are_shown_and_the_newest_is_repeated_first() -> None:
    talk = ordered("pilot", DEPTH | COURSE)
    new(talk, "depth 60 m")
    new(talk, "course 045")
    both = "NEW ORDERS  course 045 | depth 60 m   Enter repeats the first"
    screen_of(talk, "pilot", "NEW: 60 m", "NEW: 045", both)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"depth_error": "0.4"}, "ordered 5 down, at depth"),
        ({"depth_error": "-2.9", "pitch_since": "41"}, "ordered 5 down, at depth"),
        ({"depth_error": "0.4", "pitch_since": "39"}, "ordered 5 down, 3 to go down"),
        ({"depth_error": "9"}, "ordered 5 down, 3 to go down"),
        ({"depth_error": "0.4", "pitch": "0"}, "ordered zero, 3 to go down"),
    ],
)
def test_an_angle_ordered_with_a_depth_is_done_with_at_the_depth(
    told: dict[str, str], words: str
) -> None:
    screen_of(ordered("planes", DEPTH | PITCH | told), "planes", words)
    signed = "5 down +0" if "at depth" in words else " -3"
    screen_of(ordered("instructor", ALL | told), "instructor", signed)


def test_after_a_jump_only_what_waits_there_is_new() -> None:
    model = sight_of(ordered("helm", COURSE), "helm")
    talk = model.talk
    assert isinstance(talk, Tape)
    new(talk, "course 045")  # told again, since the repeat was undone
    talk.say(sentences.fact(240, 120.0, "back", "branch 1"))
    model.hear()
    assert model.crew.to_repeat("helm") is None
    talk.say(sentences.fact(240, 120.0, "back", "backtrack 60 s"))
    new(talk, "course 045")
    model.hear()
    assert model.crew.to_repeat("helm")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fact", "event", "rings"),
    [
        (None, ("alert", "planes: alert 3 seen: Passing test depth, 250 m"), 0),
        (("crew-order", "depth 60 m"), None, 1),
        (("exercise-over", "won"), None, 1),
        (None, ("depth", "Passing test depth, 250 m"), 1),
        (None, ("watch", "LIMIT: deeper than 130 m"), 1),
        (("order", "casualty stern-stuck"), None, 1),
        (("repeated", "depth 60 m"), ("crew", "helm: aye"), 0),
        (("order", "depth 60"), ("order", "helm: depth 60"), 0),
    ],
)
@pytest.mark.parametrize("silent", [False, True])
def test_the_bell_rings_for_limits_orders_and_casualties_unless_it_is_off(
    fact: tuple[str, str] | None, event: tuple[str, str] | None, rings: int, *, silent: bool
) -> None:
    talk = tape("instructor")
    rung: list[None] = []

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        app.bell = lambda: rung.append(None)  # type: ignore[method-assign]
        if silent:
            await pilot.press("ctrl+g")
            await seen(pilot, app, "the bell is off")
        if fact:
            talk.say(sentences.fact(125, 62.5, *fact))
        if event:
            talk.say(sentences.event(125, 62.5, *event))
        talk.say(sentences.event(125, 62.5, "exercise", "heard"))
        while app.model.journal.entries[-1].text != "heard":
            await pilot.pause(0.02)
        await pilot.pause(0.15)

    at_the_console(look, talk)
    assert len(rung) == (0 if silent else rings)


def test_presses_of_a_pump_key_add_up() -> None:
    keys = ("u", "u", "I", "t")
    assert pressed(keys, "ballast") == [
        "flood depth-control 1",
        "flood depth-control 2",
        "flood depth-control 1",
        "pump trim aft 1",
    ]


def test_a_press_beyond_the_stop_orders_the_stop() -> None:
    talk = tape("helm")
    talk.say(sentences.fact(0, 0.0, "range", "rudder=30"))
    keys = ("shift+right",) * 6
    assert pressed(keys, "helm", talk)[-2:] == ["rudder right 30", "rudder right 30"]


def test_the_telegraph_names_its_keys_and_its_knots() -> None:
    talk = tape("helm")
    for bell, knots in (("ahead full", 12), ("ahead flank", 15), ("astern full", -8)):
        talk.say(sentences.fact(0, 0.0, "range", f"bell={bell}:{knots}"))
    new(talk, "speed 8 kn")
    told = ("kn: ahead 12/15, astern 8", "0 stop", "4 full", "8 full", "NEW ORDER")
    screen_of(talk, "helm", *told)


@pytest.mark.parametrize(
    ("role", "key", "name"),
    [
        ("helm", "left", "rudder"),
        ("planes", "up", "stern planes"),
        ("planes", "left", "bow planes"),
        ("ballast", "u", "depth control tank"),
    ],
)
def test_a_control_that_is_not_ready_or_not_there_is_named(role: str, key: str, name: str) -> None:
    for there, told in ((False, f"not ready: the {name};"), (True, f"this boat has no {name}")):
        talk = tape(role)
        if there:
            surfaces = ("ordered_rudder", "ordered_stern", "ordered_bow", "moving_depth_control")
            talk.tick(121, **dict.fromkeys(surfaces, ""))
        else:
            talk.items = talk.items[:2]  # the line, and nothing shown on it yet

        async def press(pilot: Pilot[Refused], app: Console, told: str = told) -> None:
            await pilot.press(key)
            await seen(pilot, app, told)

        assert at_the_console(press, talk, role)[1].orders == []


PLANT = {
    "main_pressure": "12.4", "vital_pressure": "20.7", "main_level": "178", "port_bus": "dead",
    "starboard_bus": "live", "overload_left": "14", "smoke_aft": "21", "stern_supply": "normal",
    "stern_shifted_to": "emergency", "bow_supply": "normal", "rudder_supply": "hand",
}  # fmt: skip


@pytest.mark.parametrize(
    ("role", "told"),
    [("helm", "rudder hand"), ("planes", "stern normal to emergency bow normal")],
)
def test_who_works_a_surface_sees_what_moves_it_and_the_oil(role: str, told: str) -> None:
    talk = tape(role)
    talk.say(sentences.state("supply", 121, 60.5, row_of("supply", PLANT)))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, f"oil 12.4 / 20.7 MPa {told}")
        assert inks_of(app, "12.4 / 20.7 MPa") == {"warning"}

    at_the_console(look, talk, role)


@pytest.mark.parametrize(
    ("role", "size"),
    [("ballast", (130, 40)), ("instructor", (200, 60)), ("trainee", (130, 40))],
)
def test_the_plant_is_seen_whole_where_it_is_worked(role: str, size: tuple[int, int]) -> None:
    talk = tape(role)
    talk.say(sentences.state("plant", 121, 60.5, row_of("plant", PLANT)))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        for text in ("OVERLOAD 14 s", "12.4 MPa 178 L", "port   dead", "aft 21 %"):
            await seen(pilot, app, text)

    at_the_console(look, talk, role, size)


@pytest.mark.parametrize("role", ["planes", "pilot", "diving", "trainee"])
def test_who_dives_sees_how_deep_a_jam_or_a_flooding_would_take_the_boat(role: str) -> None:
    talk = tape(role)
    told = {"jam": "266", "flooding": "140", "test": "250"}
    talk.say(sentences.state("safe", 121, 60.5, row_of("safe", told)))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "now a jam to 266.0 flooding to 140.0 m, safe to 250.0")
        assert inks_of(app, "266.0") == {"warning"}
        assert inks_of(app, "140.0") == {"value"}

    at_the_console(look, talk, role)


def row_of(channel: str, told: dict[str, str]) -> list[str]:
    """Return the values of a channel, none of a field that is not told."""
    return [told.get(each.name, "") for each in CHANNELS[channel].fields]
