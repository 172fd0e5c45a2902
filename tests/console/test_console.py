"""The screens: drawn, typed at, resized, cut off and brought back, without a terminal."""

import itertools
import math
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest
from helpers.contrast import contrast
from helpers.lanes import sample_cases
from helpers.orders import read_order
from helpers.places import ROOT
from helpers.screens import (
    CREW,
    at_the_console,
    names,
    pressed,
    run_aside,
    seen,
    settled,
    shown,
    sight_of,
    tape,
    typed,
    values,
)
from textual.events import Key
from textual.pilot import Pilot
from textual.strip import Strip

from trainer.console.app import Console
from trainer.console.charts import Sample, Trace
from trainer.console.client import MAX_ORDER_LETTERS, Client, Item, LineLoss, RoleRefusal, RoleTaken
from trainer.console.drawing.attitude import turn
from trainer.console.drawing.chart import limits
from trainer.console.drawing.evaluation import evaluation
from trainer.console.entry import Entry, complete_word, hint, offer
from trainer.console.journal import TimelineMoment
from trainer.console.key_orders import TypedKeys
from trainer.console.keys import KEYS, MoveAction, OrderAction
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.console.own_session import free_socket
from trainer.console.pane import GROUND_COLOUR, INKS, Pane, plain
from trainer.console.readings import ChannelReadings
from trainer.console.vessel import CasualtyOffer
from trainer.io import paths
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.session.stations.roles import ROLES, refusal

STYLE = ROOT / "trainer" / "console" / "console.tcss"
SIZES = ((80, 24), (20, 5), (300, 100), (160, 48), (1, 1))


# Orders by keys

KEYSTROKES = (
    (("f2",), "freeze"),
    (("space",), "freeze"),
    (("f3",), "step"),
    (("full_stop",), "step"),
    (("plus",), "time 2"),
    (("minus",), "time 0.5"),
    ((*typed("depth 70"), "enter"), "depth 70"),
    (("f8", *typed("here"), "enter"), "snapshot here"),
    (("f9", *typed("good recovery"), "enter"), "mark good recovery"),
    (("f4", *typed("stern-h -0.5 ramp 20"), "enter"), "casualty stern-hard-over -0.5 ramp 20"),
    (("f4", *typed("fl"), "enter"), "casualty flooding-aft 1 ramp 5"),
    (("f4", *typed("stern"), "down", *typed(" 0.3"), "enter"), "casualty stern-hard-over 0.3"),
    (("f4", "down", "enter"), "casualty stern-hard-over -1 ramp 0"),
    (("f4", "down", "delete"), "clear stern-hard-over"),
    (("f4", "ctrl+x"), "clear all"),
    (("f5", *typed("state 5"), "enter"), "sea state 5"),
    (("f5", *typed("wind 30"), "enter"), "sea wind 30"),
    (("f5", "enter"), "sea calm"),
    (("f6", "enter"), "backtrack 30 s"),
    (("f6", "left", "enter"), "backtrack 35 s"),
    (("f6", "shift+right", "shift+left", "r"), "replay 60 s"),
    (("f6", "2", "enter"), "reset"),
    (("f7", "1", "left", "right", "right", "enter"), "replay 50 s"),
)


def test_every_key_gives_an_order_that_its_role_may_give() -> None:
    for role, keys in KEYS.items():
        for key in keys:
            if isinstance(key.act, OrderAction):
                order = read_order(key.act.words)
                assert refusal(ROLES[role], order) is None, key
            if isinstance(key.act, MoveAction):
                side = "right" if key.act.surface == "rudder" else "rise"
                order = read_order(f"{key.act.surface} {side} 1")
                assert refusal(ROLES[role], order) is None, key


def test_no_key_does_two_things() -> None:
    for keys in KEYS.values():
        found = [name for key in keys for name in key.names]
        assert len(found) == len(set(found))


@pytest.mark.parametrize("role", CREW)
def test_every_key_of_a_station_sends_its_order(role: str) -> None:
    giving = [
        (name, key.act.words)
        for key in KEYS[role]
        if isinstance(key.act, OrderAction)
        for name in key.names
    ]
    assert pressed(tuple(name for name, _ in giving), role) == [words for _, words in giving]


def test_every_key_of_the_instructor_sends_its_order() -> None:
    async def press(pilot: Pilot[Refused], _app: Console) -> None:
        for keys, _ in KEYSTROKES:
            await pilot.press(*keys)

    _, talk = at_the_console(press)
    assert talk.orders == [order for _, order in KEYSTROKES]


def test_what_is_typed_before_the_order_line_is_open_is_not_obeyed() -> None:
    async def press(pilot: Pilot[Refused], app: Console) -> None:
        app.set_focus(None)
        await pilot.press(*typed("depth -5"))

    _, talk = at_the_console(press)
    assert talk.orders == []


def test_the_keys_that_stop_and_wake_a_terminal_do_nothing_and_ctrl_c_asks() -> None:
    async def press(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("ctrl+s", "ctrl+q", "ctrl+p")
        assert len(app.screen_stack) == 1
        await pilot.press("ctrl+c")
        assert "Leave?" in shown(app)

    app, talk = at_the_console(press)
    assert app.return_code is None
    assert talk.orders == []


def test_who_has_said_that_the_run_ends_for_everybody_is_not_asked_once_more() -> None:
    assert pressed(("f10", "q")) == ["quit", "quit"]  # the second where others are attached


def test_escape_leaves_every_dialog_and_orders_nothing() -> None:
    dialogs = ("f1", "f4", "f5", "f6", "f7", "f10")
    keys = itertools.chain.from_iterable((key, "escape", "f3") for key in dialogs)
    assert pressed(tuple(keys)) == ["step"] * len(dialogs)


def test_a_dialog_that_a_key_has_ended_takes_no_second_one() -> None:
    async def press(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("f4")
        dialog = app.screen
        for _ in range(2):  # both wait in its queue before it is taken away
            dialog.post_message(Key("escape", None))
        await pilot.pause(0.1)
        await pilot.press("f3")

    assert at_the_console(press)[1].orders == ["step"]


def test_a_frozen_boat_is_let_go_by_the_same_key() -> None:
    talk = tape()
    talk.tick(121, time="frozen")
    assert pressed(("f2",), talk=talk) == ["run"]


def test_the_replay_key_ends_a_replay_that_runs() -> None:
    talk = tape()
    talk.tick(121, replay="yes")
    assert pressed(("f7",), talk=talk) == ["take over"]


def test_presses_add_up_before_the_boat_has_shown_the_first() -> None:
    assert pressed(("right", "right", "shift+left"), "helm") == [
        "rudder right 6",
        "rudder right 7",
        "rudder right 2",
    ]
    assert pressed(("up", "ctrl+down", "right"), "planes") == [
        "stern planes dive 2",
        "stern planes dive 7",
        "bow planes rise 1",
    ]


def test_after_a_refusal_the_keys_start_from_where_the_surface_is() -> None:
    talk = tape("helm")
    talk.refuses = frozenset({"rudder right 10"})

    async def press(pilot: Pilot[Refused], _app: Console) -> None:
        await pilot.press("shift+right")
        await pilot.pause(0.15)
        await pilot.press("right")

    assert at_the_console(press, talk, "helm")[1].orders == ["rudder right 10", "rudder right 6"]


def test_an_emergency_blow_is_asked_for_twice() -> None:
    assert pressed(("e", "escape"), "ballast") == []
    assert pressed(("e", "e", "escape"), "ballast") == []  # held, or a letter of a word
    assert pressed(("E", "B"), "ballast") == ["emergency blow"]


def test_the_same_words_can_be_typed_at_a_station_whose_keys_are_controls() -> None:
    typing = ("enter", *typed("rudder right 9"), "enter", "m")
    assert pressed(typing, "helm") == ["rudder right 9", "rudder amidships"]


def test_a_letter_that_is_no_key_begins_an_order_at_every_station() -> None:
    typing = (*typed("course 090"), "enter", "1")
    assert pressed(typing, "helm") == ["course 090", "bell ahead one-third"]
    assert pressed((*typed("depth 80"), "enter", "a"), "planes") == ["depth 80", "planes auto"]


@pytest.mark.parametrize(
    ("keys", "ordered", "told"),
    [
        ("35 left rudder", ["bell ahead standard", "bell ahead flank"], '"35"'),
        ("mark why", ["rudder amidships"], '"m"'),
        ("left rudder", [], ""),
    ],
)
def test_who_types_an_order_without_a_colon_is_told_which_letters_were_keys(
    keys: str, ordered: list[str], told: str
) -> None:
    async def press(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press(*typed(keys))
        above = app.query_one("#line", Pane)
        above.look()
        assert told in plain(above.lines)
        assert bool(told) == ("with :" in plain(above.lines))
        await pilot.press("enter")

    app, talk = at_the_console(press, tape("trainee"), "trainee")
    *by_keys, _typed = talk.orders
    assert by_keys == ordered
    said = [each.text for each in app.model.journal.entries if "begin an order with :" in each.text]
    assert len(said) == bool(told)
    assert all(told in text for text in said)


def test_a_key_pressed_a_while_before_an_order_is_not_taken_for_its_first_letter() -> None:
    time = 0.0
    keys = TypedKeys(lambda: time)
    keys.take("m", OrderAction("rudder amidships"))
    time = 2.0
    assert keys.explain_lost() == ""
    keys.take(None, MoveAction("rudder", -1))  # an arrow is no letter
    keys.take("0", OrderAction("bell stop"))
    assert '"0"' in keys.explain_lost()
    assert keys.explain_lost() == ""  # once


# The order line


@pytest.mark.slow
@pytest.mark.parametrize("role", sorted(KEYS))
def test_the_brackets_change_the_time_of_the_charts_on_every_screen(role: str) -> None:
    async def press(pilot: Pilot[Refused], app: Console) -> None:
        for key, minutes in (
            *(("left_square_bracket", 1), ("left_square_bracket", 1)),
            *(("right_square_bracket", 2), ("right_square_bracket", 5)),
        ):
            await pilot.press(key)
            await pilot.pause(0.15)
            if LAYOUTS[role].charts:
                assert f"{minutes} min" in shown(app)

    assert at_the_console(press, tape(role), role, (160, 48))[1].orders == []


def test_page_up_looks_back_in_the_log_and_page_down_returns() -> None:
    talk = tape()
    for k in range(60):
        talk.say(sentences.event(k, k / 2.0, "exercise", f"happening {k}"))

    async def press(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.pause(0.15)
        newest = "happening 59"
        assert newest in shown(app)
        await pilot.press("pageup", "pageup")
        await pilot.pause(0.15)
        assert newest not in shown(app)
        await pilot.press("pagedown", "pagedown")
        await seen(pilot, app, newest)

    assert at_the_console(press, talk)[1].orders == []


@pytest.mark.slow
@pytest.mark.parametrize("role", CREW)
def test_every_key_that_moves_a_surface_orders_it_by_its_step(role: str) -> None:
    moves = [
        (key.act, name)
        for key in KEYS[role]
        if isinstance(key.act, MoveAction)
        for name in key.names
    ]
    there_and_back = [key for act, name in moves for key in (name, opposite(moves, act))]
    orders = [parse(words) for words in pressed(tuple(there_and_back), role)]
    for (act, _), moved, back in zip(moves, orders[::2], orders[1::2], strict=True):
        assert isinstance(moved, Order)
        assert isinstance(back, Order)
        assert moved.name == back.name == act.surface
        assert math.degrees(moved.value - back.value) == pytest.approx(act.by)


def opposite(moves: list[tuple[MoveAction, str]], act: MoveAction) -> str:
    """Return a key that moves the same surface as far the other way."""
    return next(
        name for other, name in moves if (other.surface, other.by) == (act.surface, -act.by)
    )


def test_what_is_sent_and_answered_stands_in_the_log() -> None:
    talk = tape()
    talk.refuses = frozenset({"rudder left 90"})

    async def order(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press(*typed("depth 70"), "enter", *typed("rudder left 90"), "enter")
        await seen(pilot, app, "> depth 70\n")
        assert "depth 70: done" in shown(app)
        assert "? beyond the limit of 30" in shown(app)

    at_the_console(order, talk)


@pytest.mark.parametrize("words", ["наутилус", "mark why * this", "mark $5", "rudder right 10°"])
def test_what_no_order_can_hold_is_refused_and_the_screen_stays(words: str) -> None:
    talk = tape()
    model = sight_of(talk)
    model.hear()
    model.order(words)
    assert ") cannot be sent; type plain letters" in model.journal.entries[-1].text
    model.order("depth 70")
    assert talk.orders == ["depth 70"]


def test_tab_completes_and_the_arrows_bring_orders_back() -> None:
    async def order(pilot: Pilot[Refused], app: Console) -> None:
        entry = app.query_one(Entry)
        await pilot.press(*typed("casu"), "tab")
        assert entry.value == "casualt"  # casualty or casualties
        await pilot.press(*typed("y st"), "tab", *typed("s"), "tab")
        assert entry.value == "casualty stern-stuck "
        await pilot.press("enter", *typed("step"), "enter", "up", "up")
        assert entry.value == "casualty stern-stuck"
        await pilot.press("down", "down")
        assert entry.value == ""
        await pilot.press("up", "escape")
        assert entry.value == ""

    at_the_console(order)


def test_completion_offers_what_the_grammar_has() -> None:
    known = {"the name of a casualty": ["stern-stuck", "rudder-slow"]}

    assert set(offer("ru", known).words) == {"rudder", "run"}
    assert "left" in offer("rudder ", known).words
    assert complete_word("rudder le", known) == "rudder left "
    assert offer("casualty ", known).words == ("stern-stuck", "rudder-slow")
    assert "a depth (0 to 2000 m)" in hint("depth ", known)
    assert "the line is full" in hint("mark ".ljust(MAX_ORDER_LETTERS, "x"), known)
    assert offer("no such order", known) == ((), ())
    assert complete_word("", known) == ""


# The pictures


@pytest.mark.long
@pytest.mark.parametrize("role", sample_cases(LAYOUTS, "instructor", "helm", "trainee"))
def test_every_screen_keeps_to_its_size_and_shows_what_matters(role: str) -> None:
    def wrong(app: Console, width: int, height: int) -> str:
        """Return what does not fit on a screen of a size, "" for nothing."""
        if app.size != (width, height):
            return f"the screen is still of {app.size}"
        for pane in app.screen.query(Pane):
            rows = pane.lines[: pane.size.height]
            if any(len(plain([row])) > pane.size.width for row in rows):
                return f"at {width} by {height} {pane} is too wide"
        line = app.query_one(Entry).region
        head = shown(app).splitlines()[:1]
        if width >= 20 and not (head and "00:01:00" in head[0]):
            return f"at {width} by {height} the head is {head}"
        low = width >= 20 and (line.bottom > height or line.height != 1)
        return f"at {width} by {height} the line of orders is at {line}" if low else ""

    async def resize(pilot: Pilot[Refused], app: Console) -> None:
        for width, height in SIZES:
            await pilot.resize_terminal(width, height)
            await settled(pilot, lambda: wrong(app, width, height))  # noqa: B023  awaited here
        await pilot.resize_terminal(80, 24)
        if role in ("instructor", "observer"):
            await seen(pilot, app, "60.0")

    at_the_console(resize, role=role)


STYLED: Final = (
    ("instructor", ""),
    ("diving", ""),
    ("pilot", ""),
    ("ballast", ""),
    ("trainee", ""),
)
LED: Final = (("trainee", "lesson"), ("trainee", "tanks"), ("trainee", "lesson tanks"))


@pytest.mark.parametrize(("role", "styles"), [*STYLED, *LED])
def test_the_log_the_line_of_orders_and_the_keys_have_room_on_a_short_screen(
    monkeypatch: pytest.MonkeyPatch, role: str, styles: str
) -> None:
    monkeypatch.setattr(Console, "_lead_in", lambda _app: None)  # it would take the styles off

    def wrong(app: Console, size: tuple[int, int]) -> str:
        """Return how the rows of a screen of a size do not lie, "" where they lie well."""
        log, line, foot = (app.query_one(f"#{name}").region for name in ("log", "line", "foot"))
        entry = app.query_one(Entry).region
        lie = (
            log.height
            and log.bottom <= line.y
            and (line.bottom, line.bottom + 1) == (entry.y, foot.y)
        )
        if app.size == size and lie and foot.bottom == size[1]:
            return ""
        return f"{size}: log {log}, line {line}, entry {entry}, foot {foot}"

    async def resize(pilot: Pilot[Refused], app: Console) -> None:
        app.screen_stack[0].add_class(*styles.split())
        for size in ((60, 20), (60, 24), (80, 22), (80, 24), (100, 30)):
            await pilot.resize_terminal(*size)
            await settled(pilot, lambda: wrong(app, size))  # noqa: B023  awaited here

    at_the_console(resize, tape(role), role)


def test_the_first_screen_says_the_state_at_a_glance() -> None:
    async def look(_pilot: Pilot[Refused], app: Console) -> None:
        text = shown(app)
        for words in (
            "RUNNING x1", "depth    60.0 > 80.0 m", "> 090", "pitch   2.0 down",
            "heel    1.0 stbd",
            "5.0 right > 5.0 auto", "3.0 dive", "hand", "ahead std", "rpm 71 > 71", "2.0 t heavy",
            "main 25.0", "BLOWING forward", "1.9 m, 7 s, from 000", "F1 help", "F10 quit",
            "nothing; F4",
        ):  # fmt: skip
            assert words in text, words

    at_the_console(look)


def test_the_ballast_station_has_tanks_valves_and_air_on_a_small_screen() -> None:
    async def look(_pilot: Pilot[Refused], app: Console) -> None:
        text = shown(app)
        for words in ("auxiliary", "30.8 t", "main bank", "25.0 MPa 100 %", "OPEN", "compressor"):
            assert words in text, words

    for role in ("ballast", "diving"):
        at_the_console(look, role=role)


def test_nothing_is_said_by_colour_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    talk = tape()
    talk.tick(121, time="frozen", casualty_1="stern-stuck", replay="yes", held="depth")

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        assert app.no_color
        text = shown(app)
        for words in ("FROZEN", "REPLAY", "HELD: depth", "broken  stern-stuck", "BLOWING"):
            assert words in text, words
        await pilot.press("f4")
        await seen(pilot, app, "  stern-stuck                ACTIVE")

    at_the_console(look, talk)


@pytest.mark.parametrize(
    ("keys", "order"),
    [
        (("enter",), "casualty stern-hard-over -1 ramp 0"),
        ((*typed("stern"), "enter"), "casualty stern-hard-over -1 ramp 0"),
        ((*typed("stern-stuck"), "delete"), "clear stern-stuck"),
        (("up", "delete"), "clear stern-stuck"),
        (("down", "enter"), "casualty flooding-aft 1 ramp 5"),
    ],
)
def test_what_is_broken_already_is_not_chosen_to_be_broken(
    keys: tuple[str, ...], order: str
) -> None:
    talk = tape()
    talk.tick(121, casualty_1="stern-stuck")
    assert pressed(("f4", *keys), talk=talk) == [order]


def test_a_false_gauge_is_called_out_to_the_instructor_alone() -> None:
    talk = tape()
    for channel, depth in (("motion", "60.0"), ("gauges", "72.5")):
        talk.say(sentences.state(channel, 121, 60.5, values(channel, depth=depth)))

    async def look(_pilot: Pilot[Refused], app: Console) -> None:
        assert "depth     60.3  GAUGE 72.5" in shown(app) or "60.0  GAUGE 72.5" in shown(app)

    at_the_console(look, talk)


def test_colours_stand_out_from_what_is_behind_them() -> None:
    for name, ink in INKS.items():
        assert contrast(ink.colour, ink.ground) >= 4.5, name
    for block in re.findall(r"\{([^}]*)\}", STYLE.read_text(encoding="utf-8")):
        ground = re.search(r"background: (#\w{6})", block)
        for colour in re.findall(r"(?<![\w-])color: (#\w{6})", block):
            for behind in [ground[1]] if ground else (GROUND_COLOUR, "#16222a", "#1d2f3a"):
                assert contrast(colour, behind) >= 4.5, block
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)


def show(picture: ChannelReadings, now: float, *lines: str) -> None:
    """Show what a session says at a time [s]."""
    for text in lines:
        sentence = parse_sentence(text)
        assert sentence
        picture.take(sentence, now)


def test_pointers_move_between_ticks_and_no_further_than_the_next() -> None:
    picture, now = ChannelReadings(), 100.0
    for name in ("time", "motion"):
        show(picture, now, names(name), sentences.state(name, 120, 60.0, values(name)))

    assert picture.smooth("motion", "depth", now) == 60.0
    assert picture.smooth("motion", "depth", now + 0.2) == pytest.approx(60.1)
    assert picture.smooth("motion", "depth", now + 9.0) == pytest.approx(60.25)
    assert picture.smooth("motion", "heading", now + 9.0) == pytest.approx(0.0)

    show(picture, now, sentences.state("time", 120, 60.0, values("time", time="frozen")))
    assert picture.smooth("motion", "depth", now + 0.2) == 60.0


def test_gauges_without_rates_move_from_one_reading_to_the_next() -> None:
    picture = ChannelReadings()
    show(picture, 0.0, names("gauges"))
    show(picture, 10.0, sentences.state("gauges", 1, 0.5, values("gauges", heading="359.0")))
    show(picture, 10.5, sentences.state("gauges", 2, 1.0, values("gauges", heading="1.0")))

    assert picture.smooth("gauges", "heading", 10.5) == pytest.approx(359.0)
    assert picture.smooth("gauges", "heading", 10.75) == pytest.approx(0.0)
    assert picture.smooth("gauges", "heading", 12.0) == pytest.approx(1.0)


def test_a_chart_forgets_what_lies_after_a_moment_gone_back_to() -> None:
    trace = Trace()
    for second in range(10):
        trace.add(float(second), [Sample(float(second), None)])
    trace.add(4.0, [Sample(40.0, None)])

    found = trace.series(0, 4.0, 5)
    assert [each.actual if each else None for each in found] == [0.0, 1.0, 2.0, 3.0, 40.0]
    assert trace.series(0, 8.0, 3)[0] is None


def test_a_chart_shows_round_limits_about_all_there_is() -> None:
    for values_ in ([60.0, 80.0], [50.0, 68.0], [0.0, 0.0], [-359.0, 12.0], [1e4, 1e4 + 1.0]):
        low, high = limits(values_, 4.0)
        assert low <= min(values_) <= max(values_) <= high
        assert high - low >= 4.0
    assert limits([None], 4.0)[0] <= 0.0


def test_the_drawn_boat_pitches_her_bow_up() -> None:
    bow = turn([(1.0, 0.0)], 0.2, 10.0, (0.0, 0.0))[0]
    assert bow[1] < 0.0  # towards the top of the screen


# The session's news


def test_the_facts_that_a_screen_takes_are_those_of_the_line() -> None:
    assert set(sight_of(tape()).facts) <= set(sentences.FACTS)


def test_the_time_line_keeps_casualties_marks_and_snapshots_until_they_are_undone() -> None:
    talk = tape()
    talk.answers["snapshots"] = []
    talk.say(sentences.fact(40, 20.0, "order", "casualty stern-stuck"))
    talk.say(sentences.fact(100, 50.0, "mark", "good recovery"))
    model = sight_of(talk)
    model.hear()
    marks = model.timeline.marks
    assert [(kept.sign, kept.seconds) for kept in marks] == [
        ("C", 20.0),
        ("M", 50.0),
    ]

    talk.say(sentences.fact(60, 30.0, "back", "backtrack 30 s"))
    model.hear()
    assert [kept.sign for kept in model.timeline.marks] == ["C"]
    assert model.timeline.furthest == 30.0


@pytest.mark.parametrize(
    "remark",
    [
        "back from 60 s to 0 s",
        "instructor: backtrack 60 s: back from 60 s to 0 s, frozen",
        "the session is over",
        "casualty stern-stuck: casualty stern-stuck",
    ],
)
def test_no_remark_can_wipe_the_time_line_or_look_like_the_session(remark: str) -> None:
    talk = tape()
    talk.say(sentences.fact(40, 20.0, "mark", "first"))
    talk.say(sentences.fact(100, 50.0, "mark", remark))
    talk.say(sentences.event(100, 50.0, "mark", f"mark by helm: {remark}"))
    talk.say(sentences.event(110, 55.0, "order", f"helm: rudder left 5: {remark}"))
    model = sight_of(talk)
    model.hear()
    assert [kept.text for kept in model.timeline.marks] == ["first", remark]
    assert [kept.sign for kept in model.timeline.marks] == ["M", "M"]
    assert not model.over


def test_a_remark_of_one_s_own_does_not_wipe_the_time_line_either() -> None:
    talk = tape()
    model = sight_of(talk)
    model.hear()
    model.timeline.marks.append(TimelineMoment(20.0, "M", "before"))
    talk.facts["mark back from 60 s to 0 s"] = [("mark", "back from 60 s to 0 s")]
    model.order("mark back from 60 s to 0 s")
    model.hear()
    assert [kept.text for kept in model.timeline.marks] == ["before", "back from 60 s to 0 s"]


WILD = ("1e308", "-1e308", "1e-308", "9" * 300, "-0", "5e-324", "1e9", "-1e9", "nan", "-inf")


@pytest.mark.slow
@pytest.mark.parametrize("role", LAYOUTS)
def test_no_number_that_a_session_sends_ends_a_screen(role: str) -> None:
    async def act(pilot: Pilot[Refused], app: Console) -> None:
        for tick, number in enumerate(WILD, start=200):
            for channel in talk.channels:
                told = [number if value[-1:].isdigit() else value for value in values(channel)]
                talk.say(sentences.state(channel, tick, tick / 2.0, told))
            app.model.clock = lambda now=float(tick): now  # type: ignore[misc]
            await pilot.pause(0.15)
        assert app.is_running
        assert app._exception is None  # noqa: SLF001  what ended it

    talk = tape(role)
    at_the_console(act, talk, role, size=(160, 48))


def test_what_can_break_is_asked_of_the_session() -> None:
    model = sight_of(tape())
    model.hear()
    model.hear()
    assert model.vessel.casualties[0] == CasualtyOffer(
        "stern-stuck", "", "The stern planes stay where they are"
    )
    assert model.vessel.casualties[1].degree == "-1 ramp 0"


# The line


@pytest.mark.parametrize("role", ["instructor", *CREW])
def test_before_the_session_is_there_nothing_is_said_of_the_boat_and_at_once_then(
    role: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.console.app.REFRESH_RATE_HZ", 0.01)  # no other look is in time
    talk = tape(role)
    held, talk.items = talk.items, []
    app = Console(sight_of(talk, role))

    async def run() -> None:
        async with app.run_test(size=(160, 48)) as pilot:
            await seen(pilot, app, "making ready")
            early = shown(app)
            for claim in ("NO LINE", "this boat has", "calm", "none;", "nothing;", "RUNNING"):
                assert claim not in early
            talk.items.extend(held)
            await seen(pilot, app, "RUNNING")
            assert "making ready" not in shown(app)

    run_aside(run())


def test_what_is_ordered_before_the_session_is_there_is_sent_to_it() -> None:
    talk = tape()
    held, talk.items, talk.connected = talk.items, [], False
    app = Console(sight_of(talk, "instructor"))

    async def run() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.press(*typed("depth 70"), "enter")
            await seen(pilot, app, "depth 70: sent as soon as the boat is ready")
            assert talk.orders == []
            talk.items, talk.connected = held, True
            await seen(pilot, app, "depth 70: done")
            await pilot.press(*typed("course 45"), "enter")
            await seen(pilot, app, "course 45: done")

    run_aside(run())
    assert talk.orders == ["depth 70", "course 45"]


class Impatient(Console):
    """A console at which keys are hit before its line is there, one of them Enter as it was."""

    CSS_PATH = str(STYLE)

    async def on_mount(self) -> None:
        for name in (*typed("depth 70"), "ctrl+j", *typed("course 45"), "enter", *typed("aye")):
            character = " " if name == "space" else name if len(name) == 1 else None
            await self.on_event(Key(name, character))


def test_keys_before_the_instructor_s_line_is_there_are_typed_into_it() -> None:
    talk = tape()
    app = Impatient(sight_of(talk, "instructor"))

    async def run() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await seen(pilot, app, "course 45: done")
            await pilot.press("enter", "f3")
            await seen(pilot, app, "step: done")

    run_aside(run())
    assert talk.orders == ["depth 70", "course 45", "aye", "step"]


def test_a_lost_line_is_shown_and_orders_are_not_swallowed() -> None:
    talk = tape()

    async def lose(pilot: Pilot[Refused], app: Console) -> None:
        talk.connected = False
        talk.items.append(LineLoss("the session has closed the line"))
        await seen(pilot, app, "NO LINE: the session has closed the line; trying again")
        await pilot.press("f3")
        await seen(pilot, app, "? not sent")
        talk.connected = True
        talk.items.append(RoleTaken())
        await pilot.pause(0.15)
        assert "NO LINE" not in shown(app)
        assert "the connection is back" in shown(app)

    at_the_console(lose, talk)
    assert talk.orders == []


def test_while_the_next_exercise_is_made_ready_no_line_is_no_alarm() -> None:
    talk = tape("helm")
    now = [100.0]
    model = SessionModel(talk, "helm", LAYOUTS["helm"].charts, clock=lambda: now[0])
    app = Console(model)
    dialled = "/run/s: no session listens there; start one: trainer run or trainer serve"

    async def wait() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await seen(pilot, app, "RUNNING")
            talk.say(sentences.fact(125, 62.5, "next", ""))
            talk.items += [LineLoss("the session has closed the line"), LineLoss(dialled)]
            await seen(pilot, app, "helm the next exercise is being made ready")
            assert "line" not in shown(app)
            assert "listens" not in shown(app)
            talk.items.append(RoleTaken())
            await seen(pilot, app, "the next exercise is ready")
            assert "RUNNING" in shown(app)
            talk.say(sentences.fact(125, 62.5, "next", ""))
            talk.items.append(LineLoss("the session has closed the line"))
            await seen(pilot, app, "helm the next exercise is being made ready")
            now[0] += 61.0  # it does not come
            talk.items.append(LineLoss(dialled))
            await seen(pilot, app, "NO LINE")

    run_aside(wait())


def test_a_session_that_says_nothing_more_is_called_out() -> None:
    talk = tape()
    now = [100.0]
    model = SessionModel(talk, "instructor", LAYOUTS["instructor"].charts, clock=lambda: now[0])
    app = Console(model)

    async def wait() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.pause(0.15)
            assert "NO DATA" not in shown(app)
            now[0] += 7.0
            await seen(pilot, app, "NO DATA for 7 s")

    run_aside(wait())


def test_a_console_that_is_not_let_in_says_why_and_ends() -> None:
    talk = tape()

    async def bar(pilot: Pilot[Refused], _app: Console) -> None:
        talk.items.append(RoleRefusal("wrong token"))
        await pilot.pause(0.2)

    assert at_the_console(bar, talk)[0].return_value == RoleRefusal("wrong token")


def test_the_end_of_the_session_is_shown_and_ends_the_console_that_ordered_it() -> None:
    over = sentences.fact(120, 60.0, "over", "")
    talk = tape()

    async def end(pilot: Pilot[Refused], app: Console) -> None:
        talk.say(over)
        await seen(pilot, app, "THE SESSION IS OVER")
        await pilot.press("f10")

    assert at_the_console(end, talk)[0].return_code == 0

    other = tape()

    async def quits(pilot: Pilot[Refused], _app: Console) -> None:
        await pilot.press("f10", "q")
        await pilot.pause(0.15)
        other.say(over)
        await pilot.pause(0.2)

    assert at_the_console(quits, other)[0].return_code == 0


class Harbour:
    """A session's end of a socket that takes roles, and can be closed and opened again."""

    def __init__(self, path: Path) -> None:
        self.heard: list[str] = []
        self.last = ""  # what a client says last
        self.admits = True
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen()
        self._end: socket.socket | None = None
        self.attended = threading.Semaphore(0)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                end, _ = self._listener.accept()
            except OSError:
                return
            self._end = end
            with end, end.makefile("r", encoding="ascii", newline="\n") as lines:
                for text in lines:
                    self.heard.append(text.strip())
                    if "role" in text:
                        answer = sentences.answer("1", accepted=self.admits, text="wrong token")
                        end.sendall(f"{answer}\n".encode())
                    if text.strip() == self.last or not self.admits:
                        self.attended.release()

    def hang_up(self) -> None:
        assert self._end
        self._end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(60.0)


@pytest.fixture
def harbour(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Harbour, Path]]:
    path = tmp_path_factory.mktemp("h") / "s"
    found = Harbour(path)
    yield found, path
    found.close()


def test_a_broken_line_is_dialled_again_and_says_its_role_and_wishes_again(
    harbour: tuple[Harbour, Path],
) -> None:
    session, path = harbour
    wanted = wishes(LAYOUTS["helm"])
    said = [order_sentence("role helm WORD", "1")]
    said += [order_sentence(f"subscribe {name} {often}", "2") for name, often in wanted.items()]
    session.last = said[-1]

    client = Client(lambda: str(path), "helm WORD", wanted)
    client.start()
    assert session.attended.acquire(timeout=60.0)
    session.hang_up()
    assert session.attended.acquire(timeout=60.0)
    client.close(5.0)

    assert [type(item) for item in client.take()] == [RoleTaken, LineLoss, RoleTaken]
    assert session.heard[: 2 * len(said)] == said * 2


def test_a_wrong_token_is_told_and_not_tried_again(harbour: tuple[Harbour, Path]) -> None:
    session, path = harbour
    session.admits = False
    client = Client(lambda: str(path), "helm", {})
    client.start()
    told: list[Item] = []
    waited = threading.Event()
    for _ in range(200):
        told += client.take()
        if told or waited.wait(0.05):
            break
    client.close(5.0)

    assert told == [RoleRefusal("wrong token")]
    assert session.heard.count(order_sentence("role helm", "1")) == 1


def test_the_first_drawing_of_a_screen_has_what_had_come_by_then(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first: dict[str | None, str] = {}
    render = Pane.render_line

    def noting(pane: Pane, y: int) -> Strip:
        strip = render(pane, y)
        if y == 0:
            first.setdefault(pane.id, strip.text)
        return strip

    async def look(pilot: Pilot[Refused], _app: Console) -> None:
        await pilot.pause()

    monkeypatch.setattr(Pane, "render_line", noting)
    at_the_console(look)

    assert "00:01:00 RUNNING" in first["top"]  # a boat, not an empty screen and one a moment later


# What it is made of


@pytest.mark.process
def test_the_screens_load_neither_numbers_nor_boats() -> None:
    code = (
        "import sys, trainer.console.launch; "
        "bad = {'numpy', 'numba', 'trainer.core', 'trainer.boat.boat', 'trainer.session.session'}; "
        "print(sorted(bad & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_instructor_sees_what_could_still_be_earned_above_the_line_of_time() -> None:
    talk = tape()
    for told in ("10.000,100.0,0.0,won,1,0", "30.000,90.0,5.0,won,1,0", "58.000,12.4,7.6,open,1,0"):
        talk.say(sentences.fact(60, 30.0, "attainable", told))
    seen = sight_of(talk)
    seen.hear()
    (row,) = evaluation(seen, 80, 1)
    text = "".join(part for part, _ in row)
    assert len(text) == 80
    assert text.startswith("earn 12 ")
    assert text.rstrip().endswith("so far 8")
    assert text.count("█") > text.count("▁") > 0
    talk.say(sentences.fact(40, 20.0, "back", "backtrack 40"))
    seen.hear()
    assert [each.seconds for each in seen.timeline.attainable] == [10.0]
    (row,) = evaluation(seen, 80, 1)
    assert "50 s ago" in "".join(part for part, _ in row)
    beyond = "20.000,31.0,0.0,open,1,0,order course left 330"
    talk.say(sentences.fact(40, 20.0, "attainable", beyond))
    seen.hear()
    (row,) = evaluation(seen, 80, 1)
    text = "".join(part for part, _ in row)
    assert text.startswith("earn 31")
    assert text.endswith(" not for order course left 330")
    assert len(text) == 80
    talk.say(sentences.fact(60, 30.0, "no-attainable", "this exercise has no end"))
    seen.hear()
    (row,) = evaluation(seen, 80, 1)
    assert "no evaluation: this exercise has no end" in "".join(part for part, _ in row)


def test_a_folder_whose_name_is_too_long_is_told_by_who_listens_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", f"/home/{'x' * 110}")

    assert free_socket() == paths.socket_path()
