"""Helm, planes and pilot in a browser: every hand reaches the boat, and the page says so."""

import time
from collections.abc import Callable
from itertools import pairwise

import pytest
from helpers.pages import SIZES, Served
from playwright.sync_api import Locator, Page, expect

from trainer.verify.soak.session_process import Caller

Look = Callable[..., Page]
Serve = Callable[..., Served]
PATIENCE = 30.0  # [s]
CUT = """() => [...document.querySelectorAll("main button, header button, .knob")]
    .filter((each) => each.checkVisibility())
    .filter((each) => {
        const { left, right, top, bottom } = each.getBoundingClientRect();
        return left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1;
    }).map((each) => each.textContent)"""
COUNT = """() => { const send = WebSocket.prototype.send; window.sent = [];
WebSocket.prototype.send = function (line) {
    if (/TRO,\\d+,(rudder|bell)/.test(line)) window.sent.push([performance.now(), line]);
    send.call(this, line);
}; }"""


@pytest.fixture(scope="module")
def session(shared: Served) -> Caller:
    """Return the instructor's line to the shared session, in which time runs."""
    instructor = shared.attach()
    assert instructor.ask("run")[0]
    return instructor


def await_value(caller: Caller, channel: str, place: int, wanted: str) -> None:
    """Wait until a field of a channel has a value."""
    assert caller.ask(f"subscribe {channel}")[0]
    end, found = time.monotonic() + PATIENCE, ""
    while time.monotonic() < end:
        caller.ask("who")
        found = caller.shown.get(channel, ("",) * 20)[place + 2].replace("-0.0", "0.0")
        if found == wanted:
            return
        time.sleep(0.05)
    raise AssertionError(f"{channel} {place}: {found}, not {wanted}")


def middle(found: Locator) -> tuple[float, float]:
    """Return the middle of what is found."""
    box = found.bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_the_rudder_follows_mouse_keys_and_the_automatic_key(
    shared: Served, session: Caller, look: Look
) -> None:
    page = look(shared, "helm")
    expect(page.locator("#state")).to_have_text("RUNNING")
    groove = page.locator("order-lever[name=rudder] .groove")
    x, y = middle(groove)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y, steps=4)
    page.mouse.move(x + 400, y, steps=4)
    page.mouse.up()

    await_value(session, "steering", 3, "30.0")
    knob = page.get_by_role("slider", name="Rudder")
    knob.press("Home")
    await_value(session, "steering", 3, "0.0")
    knob.press("Shift+ArrowLeft")
    await_value(session, "steering", 3, "-5.0")
    page.locator("body").press("ArrowRight")
    await_value(session, "steering", 3, "-4.0")
    expect(page.locator("[data-mode=rudder]")).to_have_text("by hand")
    page.locator("[data-auto=rudder]").click()
    await_value(session, "steering", 4, "auto")
    expect(page.locator("[data-mode=rudder]")).to_contain_text("automatic")


def test_the_planes_follow_a_finger(shared: Served, session: Caller, look: Look) -> None:
    page = look(shared, "planes", "tablet", has_touch=True)
    expect(page.locator("#state")).to_have_text("RUNNING")
    for name, place in (("stern", 5), ("bow", 8)):
        box = page.locator(f"order-lever[name={name}] .groove").bounding_box()
        assert box
        page.touchscreen.tap(box["x"] + box["width"] / 2, box["y"] + 1)
        await_value(session, "diving", place, "30.0")


def test_the_telegraph_orders_only_where_a_slide_ends(
    shared: Served, session: Caller, look: Look
) -> None:
    page = look(shared, "helm", has_touch=True)
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.evaluate(COUNT)
    page.mouse.move(*middle(page.locator("[data-bell='ahead flank']")))
    page.mouse.down()
    page.mouse.move(*middle(page.locator("[data-bell='ahead one-third']")), steps=6)
    page.mouse.up()

    await_value(session, "engine", 4, "ahead-one-third")
    assert len(page.evaluate("sent")) == 1
    expect(page.locator("[data-bell='ahead one-third']")).to_have_attribute("aria-checked", "true")
    page.touchscreen.tap(*middle(page.locator("[data-bell='ahead standard']")))
    await_value(session, "engine", 4, "ahead-standard")
    page.locator("[data-bell='ahead standard']").press("ArrowDown")
    await_value(session, "engine", 4, "ahead-two-thirds")


def test_a_lever_sends_ten_orders_a_second_and_the_last(
    shared: Served, session: Caller, look: Look
) -> None:
    page = look(shared, "helm")
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.evaluate(COUNT)
    x, y = middle(page.locator("order-lever[name=rudder] .groove"))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 400, y, steps=120)
    page.mouse.up()

    await_value(session, "steering", 3, "-30.0")
    times = [at for at, _ in page.evaluate("sent")]
    assert all(b - a > 90 for a, b in pairwise(times))


def test_an_order_is_shown_until_it_is_repeated(
    shared: Served, session: Caller, look: Look
) -> None:
    page = look(shared, "helm")
    expect(page.locator("#state")).to_have_text("RUNNING")
    obeyed, answer = session.ask("order course left 45")
    assert obeyed, answer
    expect(page.locator("#ordered")).to_contain_text("course left to 045")
    page.get_by_role("button", name="Repeat").click()
    expect(page.locator("repeat-bar")).to_be_hidden()

    session.ask("who")
    assert any("aye" in " ".join(each.fields) for each in session.news)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", ["helm", "planes", "pilot"])
@pytest.mark.usefixtures("session")
def test_nothing_is_cut_at_any_size(shared: Served, look: Look, name: str, size: str) -> None:
    page = look(shared, name, size)
    expect(page.locator("#state")).to_have_text("RUNNING")

    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate(CUT) == []


def test_the_briefing_opens_first_and_the_end_is_told(serve: Serve, look: Look) -> None:
    served = serve("first-depth-change")
    page, session = look(served, "planes"), served.attach()
    briefing = page.locator("#briefing")
    expect(briefing).to_be_visible()
    expect(briefing).to_contain_text("By hand")
    page.keyboard.press("F1")
    expect(briefing).to_be_hidden()
    page.keyboard.press("F1")
    page.locator("#ready").click()
    expect(briefing).to_be_hidden()
    assert session.ask("run")[0]
    assert session.ask("end exercise")[0]
    expect(page.locator("#state")).to_have_text("ENDED")
    expect(briefing).to_contain_text("The exercise is over")
