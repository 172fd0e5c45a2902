"""Who trains alone, on a page: led step by step, by keyboard or finger, and told nothing hidden."""

import re
import time
from pathlib import Path

import pytest
from helpers.browser import Look, Serve
from helpers.hands import see_whole, skip_until
from helpers.lanes import sample_cases
from helpers.pages import Served
from helpers.waiting import PATIENCE
from playwright.sync_api import Page, WebSocket, expect

from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.exercise import load_exercise
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run
from trainer.config.exercise.steps import LIGHTED_INSTRUMENTS
from trainer.console.keys import KEYS, MoveAction, OrderAction
from trainer.web.modules import ASSETS_FOLDER

LESSON = """\
schema = "exercise/1"
name = "Two steps"
briefing = "You steer."
hand = ["rudder"]
[[steps]]
text = "Turn: `rudder right 10`."
when = ["rudder_deg > 8"]
within_s = 20
missed = "again"
hint = "Press the Right key."
hint_after_s = 4
light = "rudder"
[[steps]]
text = "Dive: `depth 65`."
when = ["depth_m > 62"]
within_s = 200
light = "depth"
"""
KIOSK_LESSON = """\
schema = "exercise/1"
name = "Down, step by step"
briefing = "One lever. Each step says what to do."
visitors = true
hand = ["planes"]
guard_depth_m = 88
[initial]
speed_kn = 10
depth_m = 18
[[steps]]
text = "Push the lever down: `lever dive 10`."
when = ["bow_deg < -3"]
light = "bow"
[[steps]]
text = "Leave it there until the boat is deeper than 19 m."
when = ["depth_m > 19"]
light = "depth"
"""
FAST = "time 10"  # a lesson takes minutes
FASTEST = "time 50"  # where nothing has to be done meanwhile
STEP = """[...document.querySelectorAll("#lesson-head, #lesson-text button")]
    .map((each) => each.textContent)"""
SHOWN = "(each) => getComputedStyle(each).outlineWidth"


def type_order(page: Page, words: str) -> None:
    """Type an order as the terminal's panel takes it: a colon, the words, Enter."""
    page.keyboard.press(":")
    page.keyboard.type(words)
    page.keyboard.press("Enter")
    expect(page.locator("#order")).not_to_be_focused()  # it is obeyed, and keys work the boat again


def begin(page: Page) -> None:
    """Begin the exercise from its briefing, by Enter."""
    expect(page.locator("#begin")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#state")).to_have_text("RUNNING")


def head(page: Page, step: int, count: int) -> None:
    expect(page.locator("#lesson-head")).to_have_text(f"Step {step} of {count}")


def obey_steps(page: Page, said: list[str]) -> None:
    """Do what each step says, typing its orders, until the window of the end is there."""
    end = time.monotonic() + 10.0 * PATIENCE
    following = page.locator("#next")
    while not following.is_visible():
        assert time.monotonic() < end, said
        at, *orders = page.evaluate(STEP)  # at one look: a step may end between two
        if not said or said[-1] != at:
            said.append(at)
            for words in orders:
                type_order(page, words)
        page.wait_for_timeout(60)


@pytest.fixture
def drill(tmp_path: Path) -> str:
    path = tmp_path / "drill.toml"
    path.write_text(LESSON, encoding="utf-8")
    return str(path)


# The way in


def test_who_sails_freely_takes_any_chair_or_a_lesson_and_sees_which_are_done(
    serve: Serve, look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = serve("--trainee", "Ann")
    monkeypatch.setenv("XDG_STATE_HOME", str(session.folder))
    for branch, outcome in enumerate([Outcome.DONE, Outcome.LEFT]):
        name = lessons()[branch].name
        add_run("Ann", ProgressRun("a", branch, name, "t", "2026", 60.0, outcome, None))

    page = open_by_clock(look, session, "trainee")
    expect(page.locator("#briefing-title")).to_have_text("What do you want to train?")
    offered, kept = page.locator("#lessons b"), page.locator("#lessons small")
    expect(offered).to_have_text([each.title for each in (*lessons(), *course())])
    expect(kept.nth(0)).to_have_text(f"{lessons()[0].steps} steps, done")
    expect(kept.nth(1)).to_have_text(f"{lessons()[1].steps} steps, begun")
    expect(kept.nth(2)).to_have_text(f"{lessons()[2].steps} steps")
    chosen = page.locator("#lessons [aria-current=step]")
    expect(chosen).to_have_attribute("data-name", lessons()[1].name)
    expect(page.locator("#lessons summary")).to_contain_text(
        f"1 of {len(lessons()) + len(course())} passed"
    )
    for place in lighted_places().values():
        expect(page.locator(place)).to_have_count(1)

    page.keyboard.press(":")
    page.keyboard.type("role instructor")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("/instructor"))
    expect(page.locator("#state")).to_contain_text("FROZEN")
    page.locator("#order").fill("role trainee")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("/trainee"))
    offered.nth(1).click()
    await_lesson(page, lessons()[1].title)
    begin(page)
    head(page, 1, 6)


def open_by_clock(look: Look, session: Served, name: str = "") -> Page:
    """Return a page whose own clock a test may move on."""
    page = look(session)
    page.clock.install()
    page.goto(f"{session.url}/{name}")
    return page


def await_lesson(page: Page, title: str) -> None:
    """Wait for the briefing of a lesson; the page dials again when its exercise has changed."""
    skip_until(page, lambda: page.locator("#briefing-title").text_content() == title)


def lighted_places() -> dict[str, str]:
    """Return where a page has the instruments that a step may light up, by their names."""
    script = (ASSETS_FOLDER / "js" / "crew" / "step-panel.js").read_text(encoding="utf-8")
    return dict(re.findall(r'(\w+): \{ place: "(.*?)"', script))


def test_a_page_knows_each_instrument_that_a_step_may_light_up() -> None:
    assert lighted_places().keys() == set(LIGHTED_INSTRUMENTS)


# A long briefing

LENGTHEN = """(text) => text.append(...Array.from({ length: 60 }, () => {
  const line = document.createElement("p");
  line.textContent = "One more line.";
  return line;
}))"""


@pytest.mark.parametrize("size", ["laptop", "phone"])
def test_the_keys_of_a_long_briefing_stay_in_sight(
    serve: Serve, look: Look, drill: str, size: str
) -> None:
    page = look(serve(drill), "trainee", size=size)
    expect(page.locator("#briefing")).to_be_visible()
    page.locator("#briefing-text").evaluate(LENGTHEN)
    place = page.locator("#briefing").bounding_box()
    for key in ("#begin", "#close-briefing"):
        box = page.locator(key).bounding_box()
        assert box
        assert place
        assert box["y"] + box["height"] <= place["y"] + place["height"], key


def test_a_sentence_of_the_briefing_is_not_broken_off_at_the_end_of_a_file_s_line(
    serve: Serve, look: Look
) -> None:
    page = look(serve("first-depth-change"), "trainee", size="phone")
    first = page.locator("#briefing-text p").first
    expect(first).to_contain_text("take it off in time: the boat goes where it points.")


def test_why_an_order_is_refused_is_read_to_its_end_on_a_phone(serve: Serve, look: Look) -> None:
    page = look(serve("first-depth-change"), "trainee", size="phone")
    begin(page)
    page.locator("part-keys [data-name=log]:visible").click()
    page.locator("#order").fill("course 045 left")
    page.keyboard.press("Enter")
    told = page.locator("#answer")
    expect(told).to_contain_text("did you mean course left to 045?")
    assert told.evaluate("(line) => line.scrollWidth <= line.clientWidth")
    assert told.evaluate("(line) => line.scrollHeight <= line.clientHeight + 1")


# Led through a lesson


def test_a_step_lights_up_its_instrument_gives_its_hint_and_comes_again_if_missed(
    serve: Serve, look: Look, drill: str
) -> None:
    page = look(serve(drill), "trainee", size="phone")
    begin(page)
    head(page, 1, 2)
    expect(page.locator("#lesson-text")).to_have_text("Turn: rudder right 10.")
    lit = page.locator("section[data-lit]")
    expect(lit).to_have_attribute("aria-labelledby", "h-rudder")
    assert lit.evaluate(SHOWN) == "4px"
    expect(lit).to_be_visible()
    dimmed = page.locator("section[data-dim]")
    expect(dimmed.and_(page.locator(".planes"))).to_have_count(2)  # others work the planes
    expect(dimmed.and_(page.locator(".rudder"))).to_have_count(0)
    page.locator("part-keys [data-name=log]:visible").click()
    type_order(page, FAST)

    expect(page.locator("#lesson-hint")).to_have_text("Hint: Press the Right key.")
    missed = page.locator("#lesson-missed")
    expect(missed).to_have_text("Step 1 was not done in its time: once more, from its beginning.")
    page.locator("#lesson-text button").click()  # a finger gives the order of the text
    head(page, 2, 2)
    expect(page.locator("#lesson-progress")).to_have_js_property("value", 1)
    expect(lit).to_have_attribute("aria-labelledby", "h-depth")
    expect(lit).to_be_visible()  # the page has gone to its part
    expect(page.locator("part-keys [data-name=dive]:visible")).to_have_attribute("data-lit", "")


def test_a_newcomer_is_led_through_the_first_lesson_by_keyboard_alone_and_on_to_the_next(
    serve: Serve, look: Look
) -> None:
    page = open_by_clock(look, serve("wheel-and-course"))
    expect(page.locator("#title")).to_have_text("Lesson 1: the wheel and the course")
    expect(page.locator("#facts")).to_contain_text("Lesson: 10 steps that lead who trains")
    expect(page.locator("#ask b")).to_have_text(["I train", "I instruct"])
    page.locator("#ask a").first.press("Enter")
    begin(page)
    head(page, 1, 10)
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    head(page, 2, 10)
    type_order(page, "time 5")
    head(page, 3, 10)
    page.keyboard.press("m")
    said = ["Step 3 of 6"]
    obey_steps(page, said)

    expect(page.locator("#lesson-head")).to_have_text("The last step is done.")
    expect(page.locator("#briefing-text")).to_contain_text("Lessons have no marks.")
    expect(page.locator("#next")).to_be_focused()
    page.clock.fast_forward(1_100)  # a key that was meant for the boat is not taken at once
    page.keyboard.press("Enter")
    await_lesson(page, "Lesson 2: the planes and the bubble")
    begin(page)
    head(page, 1, 6)
    for _ in range(5):
        page.keyboard.press("ArrowDown")
    expect(page.locator("#answer")).to_contain_text("stern dive 5")


def test_a_lesson_that_is_not_done_does_not_lead_on_by_enter(
    serve: Serve, look: Look, tmp_path: Path
) -> None:
    path = tmp_path / "short.toml"
    path.write_text(LESSON.replace("within_s = 200", "within_s = 5"), encoding="utf-8")
    page = look(serve(str(path)), "trainee")
    begin(page)
    type_order(page, FAST)
    page.locator("#lesson-text button").click()

    expect(page.locator("#lesson-head")).to_have_text("Steps not done: 2.")
    expect(page.locator("#briefing-text")).to_contain_text("The exercise is over: not done.")
    expect(page.locator("#next")).to_be_hidden()
    expect(page.locator("#again")).to_be_focused()
    expect(page.locator("#lessons button").nth(1)).to_be_visible()  # on all the same


def test_in_the_course_of_a_class_a_lesson_that_is_not_done_leads_on(
    serve: Serve, look: Look, tmp_path: Path
) -> None:
    path, course = tmp_path / "short.toml", tmp_path / "class.toml"
    path.write_text(LESSON.replace("within_s = 200", "within_s = 5"), encoding="utf-8")
    rows = f'[[course]]\nexercise = "{path}"\n[[course]]\nexercise = "steady-course"\n'
    course.write_text(f"boats = 2\n{rows}", encoding="utf-8")
    page = look(serve(str(path), "--course", str(course)), "trainee")
    begin(page)
    type_order(page, FAST)
    page.locator("#lesson-text button").click()

    expect(page.locator("#next")).to_be_visible()


@pytest.mark.parametrize("role", ["trainee", "instructor"])
def test_an_order_begun_before_the_last_is_answered_is_typed_on(
    serve: Serve, look: Look, drill: str, role: str
) -> None:
    page = look(serve(drill), role)
    page.locator("#order").fill("run")
    page.keyboard.press("Enter")
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.locator("#order").fill("rudder right 10")
    page.keyboard.press("Enter")  # it is answered at the next tick, half a second later
    page.keyboard.type("rudder left 5", delay=60)
    expect(page.locator("#order")).to_have_value("rudder left 5")
    expect(page.locator("#order")).to_be_focused()


def test_an_order_that_has_come_is_repeated_by_enter_on_the_empty_line(
    serve: Serve, look: Look, tmp_path: Path
) -> None:
    path = tmp_path / "order.toml"
    path.write_text(LESSON.replace("light =", 'orders = ["order course 040"]\nlight =', 1))
    page = look(serve(str(path)), "trainee")
    begin(page)
    bar = page.locator("repeat-bar")
    expect(bar).to_be_visible()
    page.keyboard.press("Enter")
    expect(bar).to_be_hidden()
    page.keyboard.press("Enter")
    expect(page.locator("#order")).to_be_focused()
    page.keyboard.press("Escape")
    page.keyboard.press("F2")
    expect(page.locator("#state")).to_have_text("FROZEN")


LOST = """\
schema = "exercise/1"
name = "Not too deep"
briefing = "Stay above 62 m."
hand = ["planes"]
lost = ["depth > 62"]
duration_s = 600
[[scores]]
name = "Quiet hands"
measure = "hand-travel"
full = 55
zero = 160
part = "keeping"
[[scores]]
name = "At 61 m"
measure = "reach"
quantity = "depth_m"
target = 61
band = 0.5
full = 60
zero = 600
part = "task"
"""


def test_who_has_lost_gets_the_marks_and_flies_again_from_where_it_went_wrong(
    serve: Serve, look: Look, tmp_path: Path
) -> None:
    path = tmp_path / "lost.toml"
    path.write_text(LOST)
    page = look(serve(str(path)), "trainee")
    begin(page)
    type_order(page, "stern planes dive 20")
    type_order(page, FASTEST)
    wrong = page.locator("#from-wrong")
    expect(wrong).to_have_text(re.compile(r"^Again from 00:\d\d, where it went wrong$"))
    expect(page.locator("#briefing-text")).to_contain_text("lost, 0 marks of 100")
    begun = (wrong.text_content() or "")[11:16]
    page.wait_for_timeout(1100)
    wrong.click()
    expect(page.locator("#briefing")).to_be_hidden()
    expect(page.locator("#time")).to_contain_text(begun)
    expect(page.locator("#state")).not_to_have_text("ENDED")


def test_the_page_has_the_keys_of_the_terminals_panel_that_lessons_name() -> None:
    script = (ASSETS_FOLDER / "js" / "stations" / "trainee.js").read_text(encoding="utf-8")
    (orders,) = re.findall(r"const KEYS = \{(.*?)\};", script, re.DOTALL)
    (bow,) = re.findall(r"const BOW = \{(.*?)\};", script, re.DOTALL)

    assert dict(re.findall(r'(\w): "(.*?)"', orders)) == {
        key.names[0]: key.act.words
        for key in KEYS["trainee"]
        if isinstance(key.act, OrderAction) and len(key.names[0]) == 1  # F8 is a button there
    }
    assert {name: int(by) for name, by in re.findall(r'"(\S)": (-?\d)', bow)} == {
        key.label.replace(" ", ""): key.act.by
        for key in KEYS["trainee"]
        if isinstance(key.act, MoveAction) and key.act.surface == "bow"
    }


# Sizes


@pytest.mark.slow
@pytest.mark.parametrize("language", sample_cases(["en", "de"], "de"))
def test_a_lessons_page_is_whole_at_every_size(serve: Serve, look: Look, language: str) -> None:
    page = look(serve("fifteen-metres-down"), "trainee", query=f"?lang={language}")
    expect(page.locator("#begin")).to_be_focused()
    page.keyboard.press("Enter")
    for width, height in ((360, 640), (390, 844), (844, 390), (640, 360), (768, 1024), (1366, 768)):
        page.set_viewport_size({"width": width, "height": height})
        for part in ("steer", "dive", "tanks", "charts", "log"):
            keys = page.locator(f"part-keys [data-name={part}]:visible")
            if keys.count():
                keys.first.click()
            page.wait_for_timeout(200)
            text = page.locator("#lesson-text").bounding_box()
            assert text
            assert text["y"] + 20 < height
            see_whole(page, f"{part} at {width}x{height}", TOO_LARGE)


# Where a panel or a key is larger than its place, or lies beyond the window. Figures of dials and
# words that may be cut with dots are judged by tests of their own.
TOO_LARGE = """() => [...document.querySelectorAll(
    "body > *, main > *, main .panel, main button, main input")]
  .filter((each) => each.checkVisibility() && !each.closest("svg, .unseen, dialog"))
  .filter((each) => {
    const rolls = each.parentElement.closest("#lesson, .tanks, .groups, #log");
    const { left, top, right, bottom } = each.getBoundingClientRect();
    const beyond = top < -1 || bottom > innerHeight + 1;
    return right > innerWidth + 1 || left < -1 || (!rolls && beyond);
  })
  .map((each) => each.outerHTML.slice(0, 90))"""


# What is hidden


def test_nothing_hidden_reaches_the_line_of_who_trains(serve: Serve, look: Look) -> None:
    heard: list[str] = []
    session = serve("stern-plane-jam")
    page = look(session)

    def listen(line: WebSocket) -> None:
        line.on("framereceived", lambda frame: heard.append(str(frame)))

    page.on("websocket", listen)
    page.goto(f"{session.url}/trainee")
    begin(page)
    type_order(page, FASTEST)
    page.wait_for_function("() => document.querySelector('#time').textContent >= '01:20'")  # jammed

    told = "\n".join(heard)
    assert "$TRS,diving" in told
    exercise = load_exercise("stern-plane-jam")
    hidden = [line.strip() for line in (exercise.heading.instructor or "").splitlines()]
    for words in (*hidden, "stern-plane-jam", "casualty", "heavy", "evaluat"):
        assert words not in told, words
        assert words not in page.content() or words in ("heavy", "casualty"), words


# The kiosk


@pytest.mark.slow
def test_a_lesson_can_be_the_kiosks_exercise_and_the_next_visitor_begins_anew(
    serve: Serve, look: Look, tmp_path: Path
) -> None:
    path = tmp_path / "kiosk.toml"
    path.write_text(KIOSK_LESSON, encoding="utf-8")
    session = serve(str(path))
    page = look(session, "kiosk", size="tablet")
    body, start = page.locator("body"), page.locator("#start")
    expect(page.locator("#invitation")).to_have_text("Down, step by step")
    expect(page.locator("#challenge")).to_have_text("One lever. Each step says what to do.")
    instructor = session.attach()

    def dives() -> None:
        start.click()
        expect(body).to_have_attribute("data-scene", "dive")
        expect(page.locator("#step")).to_have_text("1 / 2")
        expect(page.locator("#task")).to_contain_text("Push the lever down")
        expect(page.locator("order-lever")).to_have_attribute("data-lit", "")

    dives()
    assert instructor.ask(FAST)[0]
    page.locator("order-lever [role=slider]").focus()
    for _ in range(8):
        page.keyboard.press("ArrowDown")
    expect(page.locator("#step")).to_have_text("2 / 2")
    expect(page.locator("[data-shows=depth]")).to_have_attribute("data-lit", "")
    expect(body).to_have_attribute("data-scene", "result")
    expect(page.locator("#verdict")).to_have_text("Well done: each step, to the last.")
    expect(body).to_have_attribute("data-scene", "attract")  # by itself
    dives()


# A newcomer's trial


@pytest.mark.slow
def test_a_newcomer_comes_through_the_lessons_by_the_page_alone_and_to_the_first_exercise(
    serve: Serve, look: Look
) -> None:
    page = look(serve("wheel-and-course"), "trainee")
    for lesson in lessons():
        expect(page.locator("#briefing-title")).to_have_text(lesson.title)
        begin(page)
        type_order(page, "time 4")
        said: list[str] = []
        obey_steps(page, said)
        expect(page.locator("#lesson-head")).to_have_text("The last step is done.")
        assert len(said) >= lesson.steps - 1, said  # one may be over in a moment
        page.wait_for_timeout(1100)
        page.keyboard.press("Enter")
    expect(page.locator("#briefing-title")).to_have_text(course()[0].title)
    begin(page)
    expect(page.locator("#lesson")).to_be_hidden()
