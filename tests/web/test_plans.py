"""What is ahead on the instructor's page: planned by mouse, touch and keys, drawn, taken away."""

import re
from collections.abc import Iterator
from functools import partial

import pytest
from helpers.browser import Look, Serve
from helpers.hands import WAYS, work
from helpers.pages import Served
from playwright.sync_api import Page, WebSocket, expect
from soak.session_process import Caller


@pytest.fixture
def caller(shared: Served) -> Iterator[Caller]:
    """Return a line to the shared session, which is at its start and frozen."""
    attached = shared.attach()
    for words in ("cancel all", "clear all", "reset"):
        attached.ask(words)
    yield attached
    attached.hang_up()


def opened(session: Served, look: Look, way: str = "mouse", size: str = "desk") -> Page:
    """Return the page, with no window before it, in a browser that may be touched."""
    page = look(session, "instructor", size=size, has_touch=way == "touch")
    expect(page.locator("#offers li").first).to_be_attached()
    expect(page.locator("#exercise")).to_be_visible()  # it opens by itself at the start
    page.keyboard.press("Escape")
    expect(page.locator("#exercise")).to_be_hidden()
    return page


@pytest.mark.parametrize("way", WAYS)
def test_a_casualty_is_planned_drawn_and_taken_away(
    shared: Served, caller: Caller, look: Look, way: str
) -> None:
    page = opened(shared, look, way)
    caller.ask("give command")

    page.locator("#find").fill("stern hard")
    work(page, page.locator("#offers button"), way)
    page.locator("#how").select_option("at")
    expect(page.locator("#give")).to_have_text("Plan")
    page.locator("#moment").fill("2:30")
    work(page, page.locator("#give"), way)
    ahead = page.locator("#ahead li")
    expect(ahead).to_contain_text(["stern-hard-over"])
    expect(ahead).to_contain_text(["at 02:30"])
    sign = page.locator("time-line .planned")
    expect(sign).to_have_attribute("title", re.compile("^02:30 planned: casualty stern-hard-over"))
    share = sign.evaluate("(sign) => parseFloat(sign.style.left)")
    assert share == pytest.approx(100.0 * 150.0 / 600.0)

    work(page, page.get_by_role("button", name="Take away stern-hard-over"), way)
    expect(sign).to_have_count(0)
    expect(page.locator("#ahead")).to_be_hidden()


def test_a_casualty_waits_for_a_condition_and_for_a_while(
    shared: Served, caller: Caller, look: Look
) -> None:
    page = opened(shared, look)
    caller.ask("give command")
    page.locator("#find").fill("rudder-stuck")
    page.locator("#offers button").first.click()
    page.locator("#how").select_option("when")
    page.locator("#quantity").select_option("depth")
    page.locator("#sense").select_option("<")
    page.locator("#threshold").fill("61")
    page.locator("#give").click()
    expect(page.locator("#ahead li")).to_contain_text("when shallower than 61 m")
    expect(page.locator("time-line .planned")).to_have_count(0)
    page.locator("#step").click()
    expect(page.locator("#broken")).to_contain_text("rudder-stuck")
    expect(page.locator("#ahead")).to_be_hidden()

    page.locator("#find").fill("bow-stuck")
    page.locator("#offers button").first.click()
    page.locator("#how").select_option("in")
    page.locator("#moment").fill("noon")
    page.locator("#give").click()
    expect(page.locator("#log")).to_contain_text("expected a time")
    expect(page.locator("#timing")).to_be_visible()  # as it was typed
    page.locator("#moment").fill("1")
    page.locator("#give").click()
    expect(page.locator("#ahead li")).to_contain_text("at 00:01")
    for _ in range(3):
        page.locator("#step").click()
    expect(page.locator("#broken")).to_contain_text("bow-stuck")
    expect(page.locator("time-line .casualty")).to_have_count(2)


def listen(heard: list[str], line: WebSocket) -> None:
    """Keep what a page is sent."""
    line.on("framereceived", lambda frame: heard.append(str(frame)))


def test_the_instructor_sees_the_exercise_s_events_ahead_and_the_crew_nothing(
    serve: Serve, look: Look
) -> None:
    session = serve("stern-plane-jam")
    page = opened(session, look)
    expect(page.locator("time-line .planned").first).to_be_attached()
    expect(page.locator("#ahead")).to_contain_text("exercise")
    expect(page.locator("#ahead b").first).not_to_be_empty()
    casualty = page.locator("#ahead b").first.inner_text()
    crew, heard = look(session), list[str]()
    crew.on("websocket", partial(listen, heard))
    for name in ("planes", "diving", "observer", "wall"):
        heard.clear()
        crew.goto(f"{session.url}/{name}")
        expect(crew.locator("#state")).to_have_text("FROZEN")
        assert heard
        assert not any(casualty in frame or "planned" in frame for frame in heard)
