"""The wall: ten people read it from four metres, and nobody works it."""

import re
from collections.abc import Iterator

import pytest
from helpers.browser import Look
from helpers.hands import await_obeyed, see_whole, stop_clock
from helpers.pages import SIZES, Served, served
from helpers.waiting import await_that
from playwright.sync_api import Page, expect
from soak.session_process import Caller

from trainer.web.modules import ASSETS_FOLDER


@pytest.fixture(scope="module")
def sailing() -> Iterator[tuple[Served, Caller]]:
    """Return a session with an exercise and its instructor."""
    with served("visitor-dive") as session:
        yield session, session.attach()


def order(sailing: tuple[Served, Caller], words: str) -> None:
    done, why = sailing[1].ask(words)
    assert done, why


def test_the_wall_shows_what_the_crews_gauges_show_and_what_is_ordered(
    sailing: tuple[Served, Caller], look: Look
) -> None:
    session, _ = sailing
    order(sailing, "restart")
    order(sailing, "freeze")
    order(sailing, "order course 120")
    order(sailing, "step 2")
    page = look(session, "wall")

    expect(page.locator("#exercise")).to_have_text("A visitor's dive")
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("#depth")).to_have_text("18.0")
    expect(page.locator("#ordered-depth")).to_have_text("ordered 60 m")
    expect(page.locator("#ordered-course")).to_have_text("ordered 120")
    order(sailing, "casualty depth-gauge-biased ramp 1")
    order(sailing, "step 40")
    expect(page.locator("#depth")).to_have_text(re.compile("^(?!18.0)"))
    truth = look(session, "wall", query="?truth")
    expect(truth.locator("#depth")).to_have_text(re.compile(r"\d"))
    shown, true = page.locator("#depth"), truth.locator("#depth")
    await_that(lambda: abs(float(true.inner_text()) - float(shown.inner_text())) > 1.0)
    expect(truth.locator("#source")).to_have_text("the truth")
    order(sailing, "restart")
    order(sailing, "freeze")


TRACK = "() => document.querySelector('track-chart').getAttribute('aria-label')"


def test_the_wall_shows_alerts_the_bell_and_the_track_by_dead_reckoning(look: Look) -> None:
    with served() as session:
        instructor = session.attach()
        for words in ("bell ahead full", "course 090", "casualty stern-stuck", "stern rise 20"):
            assert instructor.ask(words)[0], words
        page, truth = look(session, "wall"), look(session, "wall", query="?truth")
        expect(page.locator("#bell")).to_have_text("ahead full")
        expect(page.locator("alert-bar .bell")).to_be_visible()
        expect(page.locator("alert-bar .bell .count")).to_have_text("0")
        for words in ("time max", "run"):
            assert instructor.ask(words)[0]
        expect(page.locator("track-chart")).to_have_attribute(
            "aria-label", re.compile(r"[1-9]\d{2,3} m east of the start")
        )
        assert instructor.ask("freeze")[0]
        expect(truth.locator("#state")).to_have_text("FROZEN")

        def reckoned_and_sailed() -> list[int]:
            return [
                int(re.findall(r"(\d+) m", str(wall.evaluate(TRACK)))[1]) for wall in (page, truth)
            ]

        def is_near() -> bool:  # the tracks have their own pace
            reckoned, sailed = reckoned_and_sailed()
            return reckoned == pytest.approx(sailed, rel=0.1)

        await_that(is_near, reckoned_and_sailed)
        see_reckoned(page)
        assert page.locator("track-chart").evaluate(INK) > 100


# A boat that gathers way is seen each minute; then one that turns as fast.
RECKONED = """async () => {
  const { reckon } = await import("/assets/js/model/reckoning.js");
  const gathers = [0, 6, 12].map((speed) => ({ speed, heading: 90 }));
  const turns = [0, 90, 180].map((heading) => ({ speed: 10, heading }));
  return [gathers, turns].map((rows) => reckon({ times: [0, 60, 120], rows }, 9));
}"""


def see_reckoned(page: Page) -> None:
    """See that a boat seen each minute is reckoned by the mean of two readings."""
    script = ASSETS_FOLDER / "js/model/reckoning.js"
    page.route("**/model/reckoning.js", lambda asked: asked.fulfill(path=script))
    gathers, turns = page.evaluate(RECKONED)

    knot = 1852 / 3600
    assert gathers == [pytest.approx((0, each * knot), abs=0.01) for each in (0, 180, 720)]
    assert turns[1] == pytest.approx((300 * knot, 300 * knot), abs=0.01)


# How many points of a canvas bear something.
INK = """(chart) => {
  const canvas = chart.querySelector("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return data.filter((part, at) => at % 4 === 3 && part > 0).length;
}"""


def test_an_alert_stands_on_the_wall_in_large_words(look: Look) -> None:
    with served() as session:
        page, instructor = look(session, "wall", size="desk"), session.attach()
        for words in ("stern dive 25", "bow dive 25", "bell ahead flank", "time max", "run"):
            assert instructor.ask(words)[0], words
        alert = page.locator("alert-bar .alert")
        expect(alert).to_contain_text(re.compile("depth|collapse", re.IGNORECASE))
        assert instructor.ask("freeze")[0]
        expect(page.locator("alert-bar .bell .count")).to_have_text(re.compile(r"[1-9]"))
        large = alert.locator("b").first
        size = "(each) => parseFloat(getComputedStyle(each).fontSize)"
        await_that(lambda: large.evaluate(size) >= 32.0)  # the page may draw it anew meanwhile
        expect(large).to_be_in_viewport(ratio=1.0)


def test_a_wall_that_came_first_as_an_instructor_gives_command_to_who_asks(look: Look) -> None:
    with served() as session:
        wall = look(session, "wall", query="?truth")
        expect(wall.locator("#state")).to_have_text("FROZEN")
        instructor = session.attach()
        refused, why = instructor.ask("run")
        assert not refused
        assert "take command" in why
        assert instructor.ask("take command")[0]
        expect(wall.locator("#state")).to_have_text("FROZEN")
        await_obeyed(instructor, "run")  # once the page has given command
        expect(wall.locator("#state")).to_have_text("RUNNING")

        session.process.kill()  # what is lost is told, and nothing on a wall can be worked
        expect(wall.locator("alert-bar .alert")).to_contain_text("No link")
        expect(wall.locator("boat-side")).to_have_attribute("data-stale", "")
        assert wall.locator(":is(button, input, select, a):visible").count() == 0


ROLLS = """() => [...document.querySelectorAll("main, body")].filter((each) =>
  each.scrollWidth > each.clientWidth + 1 || each.scrollHeight > each.clientHeight + 1)
  .map((each) => each.tagName)"""


def test_digits_are_seven_of_a_hundred_parts_of_the_height_at_least(
    sailing: tuple[Served, Caller], look: Look
) -> None:
    page = look(sailing[0], "wall")
    for size, share in (("desk", 0.13), ("laptop", 0.13), ("tablet", 0.05)):
        width, height = SIZES[size]
        page.set_viewport_size({"width": width, "height": height})
        expect(page.locator("#depth")).to_have_text(re.compile(r"\d"))
        size_of = "getComputedStyle(document.querySelector('#depth')).fontSize"
        assert float(page.evaluate(f"parseFloat({size_of}) / innerHeight")) >= share
        see_whole(page, size, ROLLS)


def test_a_still_pointer_goes_and_the_picture_moves_a_little_each_minute(
    sailing: tuple[Served, Caller], look: Look
) -> None:
    page = look(sailing[0])
    page.clock.install()
    page.goto(f"{sailing[0].url}/wall")
    expect(page.locator("#depth")).to_have_text(re.compile(r"\d"))
    stop_clock(page)
    page.mouse.move(200, 200)
    expect(page.locator("body")).not_to_have_css("cursor", "none")
    page.clock.run_for(3500)
    expect(page.locator("body")).to_have_css("cursor", "none")
    page.mouse.move(210, 200)
    expect(page.locator("body")).not_to_have_css("cursor", "none")
    places = set()
    for _ in range(9):
        page.clock.fast_forward(60_000)
        box = page.locator("main").bounding_box()
        assert box
        places.add((box["x"], box["y"]))
        assert min(box["x"], box["y"]) >= 0.0
        assert box["x"] + box["width"] <= 1280.0
        assert box["y"] + box["height"] <= 720.0
    assert len(places) == 9
    assert {abs(a[0] - b[0]) for a in places for b in places} == {0.0, 2.0, 4.0}


def test_the_marks_are_shown_once_they_are_released(
    sailing: tuple[Served, Caller], look: Look
) -> None:
    page = look(sailing[0], "wall")
    order(sailing, "restart")
    expect(page.locator("#state")).to_have_text("RUNNING")
    order(sailing, "end exercise")
    expect(page.locator("#state")).to_have_text("ENDED")
    expect(page.locator("#marks")).to_be_hidden()
    await_obeyed(sailing[1], "release marks")  # once they are judged
    expect(page.locator("#marks")).to_contain_text("marks of 100")
    order(sailing, "restart")
    expect(page.locator("#marks")).to_be_hidden()
