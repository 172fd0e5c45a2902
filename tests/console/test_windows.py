"""Windows over the screens, keys by the mouse, charts and the track, drawn and looked at."""

import re

import pytest
from helpers.screens import CREW, at_the_console, seen, shown, sight_of, tape, typed, values
from textual.events import Key
from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.client import Greeting, LineLoss, RoleTaken
from trainer.console.drawing.chart import (
    Plot,
    Sheet,
    beside_headings,
    plan,
    strip,
    time_axis,
    unwrap,
)
from trainer.console.drawing.gauges import STATE_COLUMNS, sea
from trainer.console.drawing.panels import flowed, key_at, key_rows
from trainer.console.entry import Entry
from trainer.console.guide import TextView, break_line, briefing_rows, by_hand, guide, paragraphs
from trainer.console.journal import Journal
from trainer.console.keys import KEYS, footer
from trainer.console.layouts import LAYOUTS
from trainer.console.pane import Pane, line, plain
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Refused

ROLES = ("instructor", *CREW)
SIZES = ((80, 24), pytest.param((120, 40), marks=pytest.mark.slow), (200, 60))
FACTS = (
    "title=Depth, first steps", "hand=planes", "duration=600",
    "wins=on 75 m and on 60 m, each within 2 m for the last two minutes of its five and a half",
    "lost=depth > 160", "limits=depth_m_min:13,pitch_deg_max:15", "line=Depth changes, by hand.",
)  # fmt: skip


def words_of(texts: list[str]) -> list[str]:
    return " ".join(texts).split()


# Text in windows


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("role", ROLES)
def test_help_shows_every_word_of_itself_at_every_size(role: str, size: tuple[int, int]) -> None:
    read: list[str] = []

    async def scroll(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("f1")
        await seen(pilot, app, "Your station" if role != "instructor" else "A first exercise")
        for _ in range(60):
            pane = app.screen.query_one("#dialog", Pane)
            rows = [plain([row]) for row in pane.lines]
            assert all(len(row) <= pane.size.width for row in rows)
            read.extend(rows[1:-1])
            if "below" not in rows[-1]:
                return
            await pilot.press("pagedown")

    talk = tape(role)
    at_the_console(scroll, talk, role, size)
    whole = "".join(words_of([plain([row]) for row in guide(sight_of(tape(role), role)).text()]))
    shown_text = "".join(words_of(read))
    for key in KEYS[role]:
        assert "".join(key.does.split()) in shown_text, key.does
    assert set(whole) <= set(shown_text)


def test_a_line_that_is_too_long_is_broken_between_words_below_its_own_text() -> None:
    rows = break_line(line(("   label   ", "value"), ("one two three four", "plain")), 22)
    assert plain(rows) == "   label   one two\n           three four"
    assert [row[0][1] for row in rows] == ["value", "plain"]
    assert (
        plain(break_line(line("  1  first second third"), 16))
        == "  1  first\n     second\n     third"
    )


def test_lines_broken_for_a_page_are_one_paragraph_in_a_window() -> None:
    page = ["Depth changes, by hand. Take an angle, watch it, and take it off in time: the"]
    page += ["boat goes where it points.", "Nothing is hidden."]
    assert paragraphs(page) == [f"{page[0]} {page[1]}", page[2]]
    assert paragraphs([]) == []


def test_a_window_scrolls_by_keys_no_further_than_its_end() -> None:
    window = TextView("x", lambda: [line(f"row {n}") for n in range(30)])
    assert "row 0\n" in plain(window.draw(20, 12))
    for _ in range(9):
        window.press("pagedown", None)
    assert plain(window.draw(30, 12)).count("row") == 10
    assert "row 29" in plain(window.draw(30, 12))
    window.press("home", None)
    assert "20 more lines below" in plain(window.draw(60, 12))


def test_a_narrow_window_of_more_lines_than_rows_still_says_which_key_begins() -> None:
    text = [line(f"row {n}") for n in range(30)]
    window = TextView("x", lambda: text, {"enter": ("run", "Enter begins")})
    assert "20 more lines below" in plain(window.draw(96, 12))
    assert "20 more: Down;   Enter begins   Esc closes" in plain(window.draw(56, 12))


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("role", ROLES)
def test_the_briefing_has_mission_time_left_what_wins_and_the_limits(
    role: str, size: tuple[int, int]
) -> None:
    talk = tape(role)
    for told in FACTS:
        talk.say(sentences.fact(0, 0.0, "exercise", told))

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "09:00 left")
        assert "Depth, first steps" in shown(app).splitlines()[0]
        await pilot.press("f12")
        for text in (
            "Briefing",
            "Depth, first steps",
            "time left",
            "on 75 m and on 60 m",
            "lost at",
            "deeper than 160 m",
        ):
            await seen(pilot, app, text)
        await seen(pilot, app, "no shallower than 13 m; pitch 15 deg at most")
        await seen(pilot, app, "Depth changes, by hand.")
        await pilot.press("escape")
        talk.say(sentences.fact(130, 65.0, "exercise-over", "lost"))
        await seen(
            pilot,
            app,
            "EXERCISE OVER: lost" if role != "instructor" else "write the debrief",
        )
        assert "show the marks to the crew" not in shown(app)  # there are none yet
        talk.say(sentences.event(130, 65.0, "marks", "in other words"))
        talk.say(sentences.fact(130, 65.0, "marks", "lost,12.0"))
        talk.say(sentences.fact(130, 65.0, "reason", ",too deep for 20 s"))
        for text in ("lost, 12 marks of 100", "too deep for 20 s"):
            await seen(pilot, app, text)
        if role == "instructor":
            await seen(pilot, app, "show the marks to the crew")
            talk.say(sentences.fact(130, 65.0, "marks", "free,"))
            await seen(pilot, app, "free, no marks")
            assert "show the marks to the crew" not in shown(app)

    at_the_console(look, talk, role, size)


@pytest.mark.parametrize("hand", ["planes", "ballast", "planes,speed,ballast"])
def test_a_hint_is_whole_on_a_terminal_of_eighty_columns(hand: str) -> None:
    """A rule of the reference crew has the longest; the log had one row for it."""
    advice = "hint, 5 marks: bell astern full, due since 00:01:11: the gauges show stern < -4"
    talk = tape("trainee")
    talk.say(sentences.fact(130, 65.0, "exercise", f"hand={hand}"))

    async def read(pilot: Pilot[Refused], app: Console) -> None:
        talk.say(sentences.event(130, 65.0, "shown", advice))
        await seen(pilot, app, "bell astern full")
        await seen(pilot, app, "stern < -4")
        assert "gauges ..." not in shown(app)
        talk.say(sentences.event(131, 65.5, "shown", "hint, 5 marks: rudder amidships"))
        await seen(pilot, app, "rudder amidships")

    at_the_console(read, talk, "trainee", (80, 24))


def test_who_comes_after_the_end_reads_the_marks_without_their_words() -> None:
    talk = tape("helm")
    for words in ("title=Depth, first steps", "hand=planes"):
        talk.say(sentences.fact(130, 65.0, "exercise", words))
    talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))
    talk.say(sentences.fact(130, 65.0, "marks", "won,91.6"))

    async def read(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("f12")
        await seen(pilot, app, "won, 92 marks of 100")
        endings = app.model.exercise.endings
        talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))  # `briefing` tells it again
        talk.say(sentences.fact(130, 65.0, "exercise", "wins=on 75 m"))
        await seen(pilot, app, "on 75 m")
        assert app.model.exercise.endings == endings
        assert app.model.exercise.marks == ["won, 92 marks of 100"]

    at_the_console(read, talk, "helm", (80, 24))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "order"),
    [("d", "debrief"), ("aa", "again"), ("HH", "again from 2 min"), ("n", "next")],
)
@pytest.mark.parametrize("clicked", [False, True])
def test_the_instructor_is_offered_what_follows_an_exercise(
    key: str, order: str, monkeypatch: pytest.MonkeyPatch, *, clicked: bool
) -> None:
    monkeypatch.setattr("trainer.console.guide.DEAF_TIME_S", 0.0)
    talk = tape()

    async def end(pilot: Pilot[Refused], app: Console) -> None:
        talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))
        await seen(pilot, app, "the marks are being calculated")
        talk.say(sentences.fact(130, 65.0, "marks", "won,92.0"))
        await seen(pilot, app, "won, 92")
        for letter in key:
            assert len(app.screen_stack) == 2
            if clicked:
                await click(pilot, app, "#dialog", f"{letter.upper()} ")
            else:
                await pilot.press(letter)
        # who asks for the debrief reads there how far it is, and what each minute cost
        assert len(app.screen_stack) == 1 + (order == "debrief")

    assert at_the_console(end, talk)[1].orders == [order]


def test_what_was_meant_for_the_order_line_does_nothing_when_the_exercise_ends() -> None:
    talk = tape()

    async def end(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press(*typed("mar"))
        talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))
        await seen(pilot, app, "EXERCISE OVER")
        assert len(app.screen_stack) == 1  # an order has been begun
        await pilot.press(*typed("k x"), "enter")
        await seen(pilot, app, "the marks are being calculated")
        await pilot.press("a", "a", "d", "r")
        assert len(app.screen_stack) == 2

    assert at_the_console(end, talk)[1].orders == ["mark x"]


def test_marks_are_released_from_a_window_that_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trainer.console.guide.DEAF_TIME_S", 0.0)
    talk = tape()

    async def end(pilot: Pilot[Refused], app: Console) -> None:
        talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))
        await seen(pilot, app, "the marks are being calculated")
        talk.say(sentences.fact(130, 65.0, "marks", "won,92.0"))
        talk.say(sentences.fact(130, 65.0, "reason", ",Depth: 92"))
        await seen(pilot, app, "Depth: 92")
        await pilot.press("r")
        await seen(pilot, app, "show the marks to the crew: done")
        await pilot.press("d")

    assert at_the_console(end, talk)[1].orders == ["release marks", "debrief"]


def test_another_exercise_at_the_same_stations_begins_with_an_empty_time_line() -> None:
    talk = tape()
    model = sight_of(talk)
    talk.say(sentences.fact(0, 0.0, "exercise", "title=Depth"))
    talk.say(sentences.fact(100, 50.0, "mark", "well done"))
    model.hear()
    talk.items += [LineLoss("the session has closed the line"), Greeting("Courses"), RoleTaken()]
    talk.say(sentences.fact(0, 0.0, "exercise", "title=Courses"))
    model.hear()
    assert (model.timeline.marks, model.timeline.furthest) == ([], 0.0)
    assert model.exercise.briefing == ["Courses"]


def test_a_station_that_has_read_its_briefing_says_that_it_is_ready() -> None:
    talk = tape("helm")
    talk.say(sentences.fact(0, 0.0, "exercise", "title=Courses"))

    async def read(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("f12")
        await seen(pilot, app, "R says ready")
        await pilot.press("r")

    assert at_the_console(read, talk, "helm")[1].orders == ["ready"]


@pytest.mark.parametrize("role", ["instructor", "helm"])
def test_the_briefing_has_no_old_marks_once_the_exercise_is_flown_again(role: str) -> None:
    model = sight_of(talk := tape(role), role)
    over = sentences.fact(130, 65.0, "exercise-over", "ended")
    for again in (sentences.fact(0, 0.0, "back", "again"), ""):
        talk.tick(130)
        marks = sentences.fact(130, 65.0, "marks", "won,92.0")
        talk.say(over, marks, sentences.fact(130, 65.0, "reason", ",Depth: 92"))
        model.hear()
        assert "marks" in plain(briefing_rows(model)).lower()
        if again:
            talk.say(again)
        talk.tick(2)  # of the same exercise, or of the same one next
        model.hear()
        assert (model.exercise.marks, model.exercise.outcome) == ([], "")
        assert "92" not in plain(briefing_rows(model))


def test_a_long_answer_is_read_in_a_window_and_a_short_one_in_the_log() -> None:
    talk = tape()
    talk.answers["status"] = [f"line {n}" for n in range(40)]
    talk.answers["who"] = ["instructor at local 1"]

    async def ask(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press(*"who", "enter")
        await seen(pilot, app, "instructor at local 1")
        assert len(app.screen_stack) == 1
        await pilot.press(*"status", "enter")
        await seen(pilot, app, "more lines below")
        await pilot.press("end")
        await seen(pilot, app, "line 39")
        await pilot.press("escape")
        assert len(app.screen_stack) == 1
        await pilot.press(*"status", "enter")
        await seen(pilot, app, "or type an order")
        for letter in "freeze":  # faster than the window closes, as what is pasted
            app.post_message(Key(letter, letter))
        await pilot.press("enter")
        assert len(app.screen_stack) == 1

    assert at_the_console(ask, talk)[1].orders[-1] == "freeze"


# Keys in the last lines


@pytest.mark.parametrize("role", ROLES)
def test_every_panel_shows_all_its_keys_at_80_columns(role: str) -> None:
    async def look(_pilot: Pilot[Refused], app: Console) -> None:
        text = " ".join(shown(app).split())
        for label, says in footer(role):
            assert f"{label} {says}" in text

    at_the_console(look, role=role)
    assert len(flowed(footer(role), 80)) <= 3


def test_keys_that_have_no_room_go_from_the_end_and_never_the_first() -> None:
    keys = footer("diving")
    rows = key_rows(keys, 40, 2)
    assert len(rows) == 2
    assert rows[0][0] == keys[0]
    assert key_at(keys, 40, 2, (1, 0)) == ("F1", "F1")
    assert key_at(keys, 40, 2, (5, 0)) == ("F1", "help")
    assert key_at(keys, 40, 2, (39, 9)) == ("", "")


# The mouse


async def click(pilot: Pilot[Refused], app: Console, pane: str, text: str) -> None:
    """Click on the first character of a text of a drawing."""
    found = app.screen.query_one(pane, Pane)
    for y, row in enumerate(found.lines):
        x = plain([row]).find(text)
        if x >= 0:
            edge = found.content_region.offset - found.region.offset
            await pilot.click(pane, offset=(x + edge.x, y + edge.y))
            return
    raise AssertionError(f"{text!r} is not in {pane}")


@pytest.mark.parametrize(
    ("role", "text", "order"),
    [
        ("instructor", "freeze", "freeze"),
        ("helm", "amidships", "rudder amidships"),
        ("helm", "Left", "rudder right 4"),
        ("helm", "Right: rudder", "rudder right 6"),
        ("ballast", "G: aux", "pump auxiliary 1"),
        ("ballast", "F G", "flood auxiliary 1"),
    ],
)
def test_a_click_on_a_key_is_the_key(role: str, text: str, order: str) -> None:
    async def act(pilot: Pilot[Refused], app: Console) -> None:
        await click(pilot, app, "#foot", text)

    assert at_the_console(act, tape(role), role)[1].orders == [order]


def test_a_click_on_words_that_stand_for_several_keys_does_nothing() -> None:
    async def act(pilot: Pilot[Refused], app: Console) -> None:
        await click(pilot, app, "#foot", "to 8: engine")

    assert at_the_console(act, tape("helm"), "helm")[1].orders == []


def test_clicks_choose_from_lists_and_on_the_time_line_and_the_wheel_scrolls() -> None:
    talk = tape()
    for k in range(60):
        talk.say(sentences.event(k, k / 2.0, "exercise", f"happening {k}"))

    async def act(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "happening 59")
        app.screen.query_one("#log", Pane).on_mouse_scroll_up(Turn())  # type: ignore[arg-type]
        await seen(pilot, app, "more lines below")
        await pilot.press("f4")
        await click(pilot, app, "#dialog", "flooding-aft")
        await click(pilot, app, "#dialog", "flooding-aft")
        assert talk.orders == ["casualty flooding-aft 1 ramp 5"]
        await pilot.click("#line", offset=(38, 0))
        await seen(pilot, app, "Go back to")
        await pilot.press("enter")
        assert re.fullmatch(r"backtrack (29|30)(\.\d+)? s", talk.orders[-1])
        await pilot.press("f10")
        await click(pilot, app, "#dialog", "leave; the session goes on")

    assert at_the_console(act, talk)[0].return_code == 0


class Turn:
    """A turn of the wheel."""

    def stop(self) -> None:
        """Go no further."""


# Charts and the track


def test_ordered_and_actual_are_drawn_at_the_same_height_when_equal() -> None:
    model = sight_of(tape())
    plot = Plot(40.0, 80.0, 30, 9)
    for value in (40.0, 47.3, 60.0, 71.9, 80.0):
        for down in (False, True):
            actual, ordered = Sheet(30, 9), plot._dashes([value] * 60, down=down)  # noqa: SLF001
            plot._trace(actual, [value] * 60, down=down)  # noqa: SLF001
            for mine, theirs in zip(actual.cells, ordered.cells, strict=True):
                assert all(not dash or dash & dot == dash for dot, dash in zip(mine, theirs))  # noqa: B905
    assert model.quantities[0].name == "depth"


def test_depth_grows_downwards_and_time_has_marks() -> None:
    talk = tape()
    model = sight_of(talk)
    for tick, depth in ((120, "60.0"), (240, "80.0")):
        talk.tick(tick, depth=depth, ordered_depth="")
    model.hear()
    rows = [plain([row]) for row in strip(0, model, 120.0, 80, 12)]
    shallow = next(n for n, row in enumerate(rows) if "⠉" in row or "⠒" in row or "⠤" in row)
    assert int(rows[1].split("┊")[0]) < int(rows[-2].split("┊")[0])
    assert shallow > 0
    assert "-1min" in rows[-1]
    assert rows[-1].endswith("now┴")


@pytest.mark.parametrize(
    ("headings", "drawn"),
    [
        ([350.0, 355.0, 359.5, 0.5, 10.0], [-10.0, -5.0, -0.5, 0.5, 10.0]),
        ([181.0, 180.0, 90.0, 0.0, 359.0], [541.0, 540.0, 450.0, 360.0, 359.0]),
        ([None, 359.0, None, 1.0], [None, -1.0, None, 1.0]),
    ],
)
def test_headings_are_drawn_on_through_north(
    headings: list[float | None], drawn: list[float | None]
) -> None:
    assert unwrap(headings) == drawn


def test_an_ordered_course_is_drawn_without_a_jump_in_it() -> None:
    # from 180 back to 000 by the left, the boat first a little beyond 180
    headings = [180.4, 179.6, 90.0, 1.0, 0.5]
    assert beside_headings([0.0] * 5, headings, None) == [0.0] * 5
    # north is ordered where the boat comes from the west; then east
    shown = [270.0, 355.0, 364.0, 380.0]
    assert beside_headings([0.0, 0.0, 0.0, 90.0], shown, None) == [360.0, 360.0, 360.0, 450.0]
    # still 190 to go, the way that was ordered
    assert beside_headings([None, 200.0], [10.0, 10.0], 190.0) == [None, 200.0]
    assert beside_headings([None, 200.0], [10.0, 10.0], None) == [None, -160.0]


def test_marks_of_time_stand_where_their_time_is() -> None:
    text = plain([time_axis(120.0, 61)]).partition("└")[2]
    assert [n for n, sign in enumerate(text) if sign == "┴"] == [0, 15, 30, 45, 60]
    assert text[1:6] == "-2min"
    assert text[16:20] == "-90s"


@pytest.mark.parametrize(("width", "height"), [(40, 30), (120, 20), (30, 60)])
def test_a_turning_circle_is_round(width: int, height: int) -> None:
    import math  # noqa: PLC0415

    talk = tape()
    model = sight_of(talk)
    for step in range(60):
        angle = math.tau * step / 59.0
        at = {"north": f"{500 * math.sin(angle):.1f}", "east": f"{500 * math.cos(angle):.1f}"}
        tick = 10 * step + 10
        talk.say(sentences.state("motion", tick, tick / 2.0, values("motion", heading="0.0", **at)))
    model.hear()
    rows = [plain([row]).ljust(width) for row in plan(model, width, height)[1:-1]]
    dots = [
        (2 * x + column, 4 * y + row)
        for y, text in enumerate(rows)
        for x, sign in enumerate(text)
        if 0x2800 < ord(sign) < 0x2900
        for column, bits in enumerate(((0, 1, 2, 6), (3, 4, 5, 7)))
        for row, bit in enumerate(bits)
        if (ord(sign) - 0x2800) >> bit & 1
    ]
    wide = max(x for x, _ in dots) - min(x for x, _ in dots)
    high = max(y for _, y in dots) - min(y for _, y in dots)
    assert wide == pytest.approx(high, abs=6)  # the boat's nose is ahead of the circle
    assert wide > 30


def test_the_track_forgets_what_lies_after_a_moment_gone_back_to() -> None:
    talk = tape()
    model = sight_of(talk)
    for tick in (20, 40, 60, 24):
        at = {"north": str(float(tick)), "east": "0.0"}
        talk.say(sentences.state("motion", tick, tick / 2.0, values("motion", **at)))
    model.hear()
    assert [north for north, _ in model.charts.track] == [20.0, 24.0, 24.0]  # the last is the boat


def test_the_track_is_in_a_window_of_its_own_at_any_size() -> None:
    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("ctrl+t")
        await seen(pilot, app, "north up")
        await pilot.press("escape")
        assert len(app.screen_stack) == 1

    talk = tape()
    talk.tick(121, north="10.0", east="5.0")
    assert at_the_console(look, talk)[1].orders == []


def test_a_large_screen_shows_the_track_all_the_time() -> None:
    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "north up")
        assert app.query_one("#plan", Pane).size.height >= 6
        assert app.query_one("#chart0", Pane).size.height >= 8

    talk = tape()
    talk.tick(121, north="10.0", east="5.0")
    at_the_console(look, talk, size=(200, 60))


def test_water_over_the_sail_and_the_waves_are_told_to_the_instructor_alone() -> None:
    talk = tape()
    talk.tick(121, over_sail="4.2")

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "1.9 m, 7 s, from 000; 4.2 m over sail")
        talk.tick(123, over_sail="-0.8")
        await seen(pilot, app, "sail 0.8 m OUT")

    at_the_console(look, talk)
    assert all("sea" not in LAYOUTS[role].channels for role in CREW)


def test_a_casualty_is_told_with_unit_and_side() -> None:
    talk = tape()
    talk.tick(
        121, casualty_1="stern-hard-over", casualty_1_says="6 deg dive", casualty_1_left="0.0"
    )

    async def look(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "broken  stern-hard-over 6 deg dive")
        await pilot.resize_terminal(160, 48)
        await seen(pilot, app, "stern-hard-over  6 deg dive")

    at_the_console(look, talk)


def test_of_presses_of_one_control_the_log_keeps_the_last() -> None:
    journal = Journal()
    for seconds, angle in ((60.0, 1), (60.5, 2), (62.0, 3), (70.0, 4)):
        journal.add(seconds, "order", f"planes: stern planes dive {angle}: by hand")
    journal.add(71.0, "order", "planes: bow planes dive 4: by hand")
    kept = [each.text.split(":")[1].strip() for each in journal.entries]
    assert kept == ["stern planes dive 3", "stern planes dive 4", "bow planes dive 4"]


@pytest.mark.parametrize("role", ["instructor", "helm"])
def test_what_is_shown_of_an_exercise_that_is_over_goes_when_it_is_flown_again(role: str) -> None:
    talk = tape(role)

    async def again(pilot: Pilot[Refused], app: Console) -> None:
        talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))
        talk.say(sentences.event(130, 65.0, "marks", "in other words"))
        talk.say(sentences.fact(130, 65.0, "marks", "won,92.0"))
        await seen(pilot, app, "won, 92")
        assert len(app.screen_stack) == 2
        talk.say(sentences.fact(20, 10.0, "back", "again"))
        await seen(pilot, app, "RUNNING")
        await pilot.pause(0.3)
        assert len(app.screen_stack) == 1

    at_the_console(again, talk, role)


def test_a_window_that_would_hide_a_new_order_goes() -> None:
    talk = tape("helm")

    async def order(pilot: Pilot[Refused], app: Console) -> None:
        await pilot.press("f12")
        assert len(app.screen_stack) == 2
        talk.say(sentences.fact(121, 60.5, "crew-order", "course 045"))
        await seen(pilot, app, "NEW ORDER  course 045")
        assert len(app.screen_stack) == 1

    at_the_console(order, talk, "helm")


def test_the_briefing_names_the_stations_that_are_needed() -> None:
    assert by_hand("planes,speed") == "planes, speed; needs: planes and helm, or one pilot"
    assert by_hand("ballast") == "ballast; needs: ballast"
    assert by_hand("") == ""


def test_the_sea_s_line_has_set_drift_and_the_way_over_the_ground() -> None:
    talk = tape()
    model = sight_of(talk)
    model.hear()
    still = plain([sea(model)])
    shown = {"set": "90.0", "drift": "2.00"}
    shown |= {"course_over_ground": "50.6", "speed_over_ground": "11.47"}
    talk.say(sentences.state("current", 121, 60.5, values("current", **shown)))
    model.hear()
    carried = plain([sea(model)])
    assert "; set" not in still
    assert "; set 090 2.0; ground 051 11.5" in carried
    assert len(carried.partition(" > ")[0]) <= STATE_COLUMNS


def test_the_keys_of_an_exercise_that_is_over_lead_on_after_its_window_is_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("trainer.console.guide.DEAF_TIME_S", 0.0)
    talk = tape("trainee")
    talk.say(sentences.fact(130, 65.0, "exercise-over", "ended"))

    async def close(pilot: Pilot[Refused], app: Console) -> None:
        await seen(pilot, app, "Exercise over")
        await pilot.press("escape")
        assert "Exercise over" not in shown(app)
        await pilot.press("h")  # which asks once more
        await seen(pilot, app, "press H once more")
        assert not app.query_one(Entry).value
        await pilot.press("h")
        assert talk.orders == ["again from 2 min"]
        await pilot.press("n")
        assert talk.orders == ["again from 2 min", "next"]

    at_the_console(close, talk, "trainee")
