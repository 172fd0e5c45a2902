"""Helm, planes and pilot in a browser: every hand reaches the boat, and the page says so."""

import contextlib
import re
import signal
from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import pytest
from helpers.browser import Look, Serve
from helpers.hands import (
    EACH_WAY,
    TOO_WIDE,
    UNWORKED,
    WAYS,
    await_obeyed,
    await_truth,
    heard,
    on_groove,
    read,
    ready,
    report,
    see_whole,
    step,
    work,
    work_frame,
    work_parts,
)
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served
from helpers.plant_page import work_safe_depth, work_supplies
from helpers.waiting import await_that
from playwright.sync_api import Locator, Page, WebSocketRoute, expect
from soak.session_process import Caller

NAMES: Final = ("helm", "planes", "pilot")
SURFACES: Final = {"rudder": "steering", "stern": "diving", "bow": "diving"}
BEYOND: Final = """() => [...document.querySelectorAll("main button, header button, .knob")]
    .filter((each) => each.checkVisibility() && !each.closest("#autopilot")) // that rolls
    .filter((each) => {
        const { left, right, top, bottom } = each.getBoundingClientRect();
        return left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1;
    }).map((each) => each.textContent)"""
OVERLAPS: Final = """() => [...document.querySelectorAll("level-bar")].flatMap((bar) => {
    const spans = [...bar.querySelectorAll(".numerals span")];
    const all = spans.filter((each) => each.checkVisibility());
    const ends = all.map((each) => each.getBoundingClientRect());
    return ends.slice(1).filter((each, at) => each.left < ends[at].right + 1).map(() => bar.id);
})"""
WAY: Final = """() => ["speed", "rpm"].filter((name) => { // neither a bar has it nor digits
    const bar = document.getElementById(name);
    const digits = document.querySelector(`.way [data-place$=".${name}"]`);
    const read = digits.checkVisibility() && /[0-9]/.test(digits.textContent);
    return !(bar.checkVisibility() || read);
})"""
THUMB_SIZES: Final = ((360, 640), (360, 740), (390, 844), (844, 390), (820, 1180), (1366, 768))
# what a thumb or a mouse may be on; not what an order or an alert brings with it
KEYS_AT: Final = """() => [...document.querySelectorAll(
    "body > header :is(button, select), main :is(button, input, order-lever)")]
    .filter((each) => each.checkVisibility() && !each.closest("dialog, #autopilot, repeat-bar"))
    .filter((each) => !each.matches(".knob, [data-auto]"))
    .map((each) => {
        const { left, top, width, height } = each.getBoundingClientRect();
        return [each.id || each.name || each.getAttribute("name"),
            left, top, width, height];
    })"""
LAID_OUT: Final = """() => new Promise((done) => requestAnimationFrame(
    () => requestAnimationFrame(() => requestAnimationFrame(done))))"""
COUNT: Final = """() => { const send = WebSocket.prototype.send; window.sent = [];
WebSocket.prototype.send = function (line) {
    if (/TRO,\\d+,(rudder|bell|stern|blow)/.test(line)) window.sent.push([performance.now(), line]);
    send.call(this, line);
}; }"""


def opened(look: Look, session: Served, name: str = "pilot", **how: object) -> Page:
    """Return a page that shows readings."""
    page = look(session, name, **how)
    expect(page.locator("#state")).to_have_text(re.compile("FROZEN|RUNNING"))
    expect(page.locator("depth-gauge .digits")).not_to_be_empty()
    return page


def middle(found: Locator) -> tuple[float, float]:
    """Return the middle of what is found."""
    box = found.bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def put(page: Page, name: str, way: str) -> int:
    """Put a lever to some place by its groove, or by keys; return the angle that it says."""
    lever = page.locator(f"order-lever[name={name}]")
    slider = lever.get_by_role("slider")
    if way == "keyboard":
        slider.evaluate("(each) => (each.dataset.worked = '')")
        keys = ("Home", "PageUp", "ArrowUp", "ArrowLeft", "Shift+ArrowRight", "PageDown")
        for key in (*keys, "ArrowUp", "ArrowRight"):  # 7 is ordered once, at the end
            slider.press(key)
    else:
        (page.mouse.click if way == "mouse" else page.touchscreen.tap)(*on_groove(page, name, 0.9))
        slider.evaluate("(each) => (each.dataset.worked = '')")
    for end in ("low", "high", "high"):  # to what was not ordered before, so that it is the last
        work(page, lever.locator(f".fine.{end}"), way)
    expect(slider).not_to_have_attribute("aria-valuenow", "0")
    return standing(page, name)


@pytest.mark.parametrize("way", WAYS)
def test_every_control_reaches_the_boat(
    shared: Served, instructor: Caller, look: Look, way: str
) -> None:
    page = opened(look, shared, size="desk", has_touch=way == "touch")
    work_supplies(page, instructor, way, ".panel >", [*SURFACES])
    for name, channel in SURFACES.items():
        angle = put(page, name, way)
        await_truth(instructor, f"{channel}.ordered_{name}", f"{angle:.1f}")
        expect(page.locator(f"[data-mode={name}]")).to_have_text("by hand")
        work(page, page.locator(f"[data-auto={name}]"), way)
        await_truth(instructor, f"{channel}.{name}_mode", "auto")
        expect(page.locator(f"[data-auto={name}]")).to_be_hidden()
    bells = page.locator("[data-bell]")
    for at in range(bells.count()):
        bell = str(bells.nth(at).get_attribute("data-bell"))
        work(page, bells.nth(at), way)
        await_truth(instructor, "engine.bell", bell.replace(" ", "-"))
        expect(bells.nth(at)).to_have_attribute("aria-checked", "true")
    for words in ("order course right 45", "order depth 70", "order speed 6"):
        assert instructor.ask(words)[0]
        work(page, page.locator("repeat-bar button"), way)
        expect(page.locator("repeat-bar")).to_be_hidden()
    for words, place, wanted in (
        ("course 045", "steering.ordered_course", "45.0"),
        ("depth 70 m", "diving.ordered_depth", "70.0"),
        ("speed 6 kn", "engine.ordered_speed", "6.0"),
    ):
        work(page, page.get_by_role("button", name=f"Autopilot: {words}"), way)
        await_truth(instructor, place, wanted)
    report(page, f"steady by {way}", way)
    assert heard(instructor, f"steady by {way}")
    work_frame(page, way)
    work_safe_depth(page, way)
    assert page.evaluate(UNWORKED) == []


@pytest.mark.parametrize("way", WAYS)
def test_each_half_of_a_small_pilot_s_page_works_without_the_other(
    shared: Served, instructor: Caller, look: Look, way: str
) -> None:
    page = opened(look, shared, size="phone", has_touch=True)
    work_parts(page, way, "part-keys button", "data-half")
    for half, shown, unseen in (
        ("Steer", ["rudder"], "stern"),
        ("Dive", ["stern", "bow"], "rudder"),
    ):
        work(page, page.get_by_role("button", name=half, exact=True), way)
        expect(page.locator(f"order-lever[name={unseen}]")).to_be_hidden()
        for name in shown:
            angle = put(page, name, way)
            await_truth(instructor, f"{SURFACES[name]}.ordered_{name}", f"{angle:.1f}")
        before = read(instructor, f"{SURFACES[unseen]}.ordered_{unseen}")
        page.evaluate("document.activeElement.blur()")  # no lever is meant by its focus
        place, stood = f"{SURFACES[shown[0]]}.ordered_{shown[0]}", standing(page, shown[0])
        for key in ("ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
        await_truth(instructor, place, f"{stood + 1:.1f}")
        assert read(instructor, f"{SURFACES[unseen]}.ordered_{unseen}") == before
    work(page, page.get_by_role("button", name="Steer", exact=True), way)
    work(page, page.locator("[data-bell='astern full']"), way)
    await_truth(instructor, "engine.bell", "astern-full")
    report_by_key(page, instructor, way)


def report_by_key(page: Page, instructor: Caller, way: str) -> None:
    """Report by the window that a phone has in the bar's place, held either way."""
    key, window = page.locator("report-bar > .open"), page.locator("report-bar dialog")
    for size, words in (("phone", "on depth"), ("phone-side", "steady")):
        width, height = SIZES[size]
        page.set_viewport_size({"width": width, "height": height})
        work(page, key, way)
        see_whole(page, size, BEYOND)
        work(page, window.get_by_role("button", name=words), way)
        expect(window).to_be_hidden()
        assert heard(instructor, words)
        work(page, key, way)
        report(page, f"{words} by {way}", way)
        expect(window).to_be_hidden()
        assert heard(instructor, f"{words} by {way}")
        work(page, key, way)
        work(page, window.get_by_role("button", name="Close", exact=True), way)
        expect(window).to_be_hidden()


# a window that is closed and opened anew before its close is told, as on a machine under load
ANEW: Final = """() => {
    const bar = document.querySelector("report-bar");
    const [key, dialog] = [bar.querySelector(".open"), bar.querySelector("dialog")];
    key.click();
    dialog.close();
    key.click();
}"""


def test_a_report_window_that_is_opened_anew_at_once_keeps_its_field(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, size="phone")
    page.evaluate(ANEW)
    page.evaluate(LAID_OUT)
    expect(page.get_by_label("Report", exact=True)).to_be_visible(timeout=5000.0)
    report(page, "all is well", "mouse")
    assert heard(instructor, "all is well")


def standing(page: Page, name: str) -> int:
    """Return what a lever stands at [deg]."""
    slider = page.locator(f"order-lever[name={name}]").get_by_role("slider")
    return int(slider.get_attribute("aria-valuenow") or 0)


@pytest.mark.parametrize("name", ["helm", "planes"])
def test_a_drag_keys_and_a_slide_end_where_the_hand_does(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    page = opened(look, shared, name)
    page.evaluate(COUNT)
    lever, places = {"helm": ("rudder", "steering"), "planes": ("stern", "diving")}[name]
    x, y = middle(page.locator(f"order-lever[name={lever}] .knob"))
    way = (-700, 0) if name == "helm" else (0, 400)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + way[0], y + way[1], steps=60)
    page.mouse.up()
    await_truth(instructor, f"{places}.ordered_{lever}", "-30.0")
    assert all(b - a > 90 for (a, _), (b, _) in pairwise(page.evaluate("sent")))

    keys = page.locator("body")
    keys.press("Shift+ArrowRight" if name == "helm" else "Shift+ArrowUp")
    await_truth(instructor, f"{places}.ordered_{lever}", "-25.0")
    if name == "planes":
        return
    page.evaluate("sent.length = 0")
    page.mouse.move(*middle(page.locator("[data-bell='ahead flank']")))
    page.mouse.down()
    page.mouse.move(*middle(page.locator("[data-bell='ahead one-third']")), steps=6)
    page.mouse.up()
    await_truth(instructor, "engine.bell", "ahead-one-third")
    assert len(page.evaluate("sent")) == 1
    page.locator("[data-bell='ahead one-third']").press("ArrowUp")
    await_truth(instructor, "engine.bell", "ahead-two-thirds")


def test_no_order_of_a_lever_comes_after_the_one_that_gives_it_away(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "helm")
    page.evaluate(COUNT)
    lever = "document.querySelector('order-lever[name=rudder]')"
    give_away = "document.querySelector('[data-auto=rudder]').click()"  # at once: 5 waits its turn
    page.evaluate(f"() => {{ {lever}.choose(3); {lever}.choose(5); {give_away}; }}")
    await_truth(instructor, "steering.rudder_mode", "auto")
    expect(page.locator("order-lever[name=rudder].automatic")).to_be_visible()
    page.wait_for_timeout(200.0)  # [ms] twice the time between two orders
    assert ["rudder auto" in line for _, line in page.evaluate("sent")] == [False, True]


def test_what_is_ordered_in_a_freeze_stands_at_once_on_every_page(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page, other = opened(look, shared), opened(look, shared, "planes")
    tick = read(instructor, "time.time"), instructor.tick
    angle = put(page, "bow", "mouse")

    expect(page.locator("#answer")).to_contain_text("acts when time runs")
    for each in (page, other):
        expect(each.get_by_role("slider", name="Bow planes")).to_have_attribute(
            "aria-valuenow", str(angle)
        )
        expect(each.locator("#bow .order")).to_have_text(f"ordered {angle} rise")
        expect(each.locator("#bow .digits")).to_have_text("0.0")  # the boat has not moved
    assert (read(instructor, "time.time"), instructor.tick) == tick


def test_a_reading_that_was_on_its_way_moves_no_lever_back(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = look(shared)
    last: list[str] = []

    def between(route: WebSocketRoute) -> None:
        server = route.connect_to_server()

        def pass_on(frame: str | bytes) -> None:
            for line in str(frame).split("\n"):
                pass_line(line)

        def pass_line(text: str) -> None:
            if text.startswith("$TRS,steering"):
                last.append(text)
                if len(last) > 1:
                    return  # what comes after the order is late
            route.send(text)
            if text.startswith("$TRA") and "by hand" in text:
                route.send(last[0])  # older than the order, and behind its answer

        server.on_message(pass_on)

    page.route_web_socket(re.compile("/line"), between)
    page.goto(f"{shared.url}/helm")
    slider = page.get_by_role("slider", name="Rudder")
    expect(page.locator("#rudder .digits")).not_to_be_empty()
    for key, angle in (("PageUp", 5), ("ArrowRight", 6), ("ArrowRight", 7)):
        slider.press(key)
        expect(page.locator("#answer")).to_contain_text(f"right {angle}")
        expect(page.locator("order-lever.asking")).to_have_count(0)
        await_truth(instructor, "steering.ordered_rudder", f"{angle:.1f}")


def test_what_is_in_hand_cannot_be_made_automatic(serve: Serve, look: Look) -> None:
    served = serve("surface-and-steer")  # all is in hand
    page, instructor = opened(look, served), served.attach()
    page.locator("#close-briefing").click()
    for words in ("order course left 20", "order depth 60", "order speed 4"):
        assert instructor.ask(words)[0]
    expect(page.locator("#ordered")).to_contain_text("speed 4 kn")
    for name, channel in SURFACES.items():
        angle = put(page, name, "mouse")
        await_truth(instructor, f"{channel}.ordered_{name}", f"{angle:.1f}")
        expect(page.locator(f"[data-mode={name}]")).to_have_text("by hand")
        expect(page.locator(f"[data-auto={name}]")).to_be_hidden()
    expect(page.locator("#autopilot button")).to_have_count(0)
    refused, why = served.attach("pilot").ask("planes auto")
    assert not refused
    assert "hand" in why


@contextlib.contextmanager
def stopped(session: Served) -> Iterator[None]:
    """Hold a session's process still."""
    session.process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        session.process.send_signal(signal.SIGCONT)


def test_without_readings_nothing_works_and_all_is_crossed_until_they_are_back(
    shared: Served, instructor: Caller, look: Look
) -> None:
    assert instructor.ask("run")[0]
    pages = [opened(look, shared, name) for name in NAMES]
    pages += [look(shared, name) for name in ("ballast", "diving", "observer")]
    for page in pages:
        expect(page.locator("#state")).to_have_text("RUNNING")
        page.evaluate(COUNT)
    with stopped(shared):
        for page in pages:
            expect(page.locator("#state")).to_have_text("NO LINK")
            expect(page.locator(":is(.gauge, tank-mimic):not([data-stale])")).to_have_count(0)
            expect(page.locator("main [data-control]:not([inert])")).to_have_count(0)
            for cross in page.locator(".gauge:visible .cross").all():
                expect(cross).to_be_visible()
            expect(page.locator("alert-bar .alert[data-rank=warning]")).to_contain_text("No link")
            work_nothing(page)
    for page in pages:
        expect(page.locator("#state")).to_have_text("RUNNING")
        expect(page.locator(".gauge[data-stale], main [data-control][inert]")).to_have_count(0)
        assert page.evaluate("sent") == []
        link = page.locator("alert-bar .alert[data-state=rectified]", has_text="No link")
        expect(link).to_contain_text("over")  # until somebody says that he has seen it
        link.get_by_role("button").click()
        expect(link).to_have_count(0)
    angle = put(pages[0], "rudder", "mouse")
    await_truth(instructor, "steering.ordered_rudder", f"{angle:.1f}")


def work_nothing(page: Page) -> None:
    """Try what gives orders, with keys and mouse."""
    for key in ("ArrowRight", "ArrowUp"):
        page.locator("body").press(key)
    hands = "order-lever :is(.knob, .fine), [data-bell='ahead full'], [data-order='blow all']"
    for each in page.locator(hands).all():
        page.mouse.click(*middle(each))


def test_the_crew_is_alerted_by_its_gauges_alone(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared)
    alerts = page.locator("alert-bar .alert")
    assert instructor.ask("casualty rudder-stuck")[0]
    put(page, "rudder", "mouse")
    warning = alerts.and_(page.locator("[data-rank=warning]"))

    def is_warned() -> bool:
        step(instructor, 4)
        return warning.count() > 0

    await_that(is_warned)
    expect(warning).to_contain_text("Rudder off its order")
    assert instructor.ask("clear all")[0]
    step(instructor, 30)
    expect(warning).to_have_attribute("data-state", "rectified")
    page.keyboard.press("a")
    expect(alerts).to_have_count(0)
    assert instructor.ask("order course left 90")[0]
    put(page, "rudder", "mouse")
    assert heard(instructor, "WRONG WAY: pilot: rudder right")
    expect(alerts).to_have_count(0)


@pytest.mark.parametrize("size", sample_cases(["phone", "phone-side"], "phone"))
def test_the_key_that_repeats_a_long_order_shows_all_of_it(
    shared: Served, instructor: Caller, look: Look, size: str
) -> None:
    order = "pilot keep a sharp lookout for the ferry on the starboard bow"
    page = opened(look, shared, "pilot")
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    assert instructor.ask(f"tell {order}")[0]
    key = page.locator("repeat-bar button")

    expect(key).to_contain_text(order)

    for part in (key, page.locator("repeat-bar")):
        assert part.evaluate("part => part.scrollWidth <= part.clientWidth")
        assert part.evaluate("part => part.scrollHeight <= part.clientHeight")


@pytest.mark.parametrize("name", sample_cases(NAMES, "pilot"))
def test_nothing_is_cut_and_no_numeral_covers_another_at_any_size(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    for words in ("order course right 45", "order depth 70", "order speed 6"):
        assert instructor.ask(words)[0]
    page = opened(look, shared, name)
    expect(page.locator("repeat-bar")).to_be_visible()
    expect(page.locator("#autopilot button")).to_have_count(
        {"helm": 2, "planes": 1, "pilot": 3}[name]
    )
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        keys = page.locator("part-keys button:visible")
        for place in range(max(keys.count(), 1)):
            if keys.count():
                keys.nth(place).click()
            if page.locator("order-lever[name=rudder]").is_visible():
                see_whole(page, size, WAY)
            for parts in (TOO_WIDE, BEYOND, OVERLAPS):
                see_whole(page, size, parts)


def test_the_briefing_opens_first_its_keys_are_worked_and_the_end_is_told(
    serve: Serve, look: Look
) -> None:
    served = serve("first-depth-change")
    page, session = look(served, "planes", has_touch=True), served.attach()
    briefing = page.locator("#briefing")
    expect(briefing).to_be_visible()
    expect(briefing).to_contain_text("By hand")
    page.keyboard.press("F1")
    expect(briefing).to_be_hidden()
    for way in EACH_WAY:
        for key in ("#close-briefing", "#ready"):
            work(page, page.locator("#show-briefing"), way)
            expect(briefing).to_be_visible()
            work(page, page.locator(key), way)
            expect(briefing).to_be_hidden()
        assert heard(session, "is ready")  # told once each time
        session.news.clear()
    assert session.ask("run")[0]
    for end in (1, 2):  # of the exercise, and of the branch that runs on from before it
        assert session.ask("end exercise")[0]
        expect(page.locator("#state")).to_have_text("ENDED")
        expect(briefing).to_be_visible()
        expect(briefing).to_contain_text("The exercise is over")
        if end == 1:
            for words in ("again from 0.5 s", "run"):
                assert session.ask(words)[0]
            expect(page.locator("#state")).to_have_text("RUNNING")
            expect(briefing).to_be_hidden()
    page.locator("#close-briefing").click()
    await_obeyed(session, "release marks")  # once they are judged
    expect(briefing).to_be_visible()  # the marks are shown, though its end has been put away
    expect(briefing).to_contain_text("marks of 100")
    page.locator("#close-briefing").click()
    expect(briefing).to_be_hidden()


def test_a_jam_is_told_with_its_side_and_marked_at_the_lever(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "planes", size="desk")
    assert instructor.ask("stern planes dive 6")[0]
    step(instructor, 60)
    for words in ("casualty stern-stuck", "stern planes zero", "bow planes auto"):
        assert instructor.ask(words)[0]
    step(instructor, 2)
    stern = page.locator("section.stern")
    expect(stern.locator("h2 .is")).to_have_text("6.0 dive")
    expect(stern.locator(".digits")).to_have_text("6.0dive")
    expect(page.locator("#heel .toward")).to_have_css("display", "inline")
    expect(stern.locator(".order")).to_have_text("ordered 0")
    expect(stern.locator(".gap.off")).to_have_attribute("d", re.compile("L"))
    stern.locator("order-lever").evaluate("(lever) => { lever.set(0, 0.3); }")
    expect(stern.locator(".knob")).to_have_text("0.3")
    assert instructor.ask("clear all")[0]
    step(instructor, 60)
    expect(stern.locator(".gap.off")).to_have_count(0)


def keys_by_size(page: Page) -> dict[tuple[int, ...], list[list[object]]]:
    """Return where each key of a page is, at each size, in each part that the size shows."""
    found: dict[tuple[int, ...], list[list[object]]] = {}
    for width, height in THUMB_SIZES:
        page.set_viewport_size({"width": width, "height": height})
        parts = page.locator("part-keys[part=half] button:visible")
        for place in range(max(parts.count(), 1)):
            if parts.count():
                parts.nth(place).click()
            page.evaluate(LAID_OUT)
            found[width, height, place] = page.evaluate(KEYS_AT)
    return found


@pytest.mark.parametrize("name", [*NAMES, "ballast"])
def test_no_key_moves_when_an_order_an_alert_or_a_report_comes(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    assert instructor.ask("rudder left 0")[0]  # who has what is told beforehand
    step(instructor, 1)  # a page of a session that has not begun has no readings yet
    page = look(shared, name)
    ready(page)
    page.evaluate("document.fonts.ready")
    before = keys_by_size(page)
    assert all(before.values())
    for words in ("order course left 045", "order depth 80", "emergency blow"):
        assert instructor.ask(words)[0]
    assert shared.attach("diving").ask("report on depth")[0]
    step(instructor, 40)
    expect(page.locator("#ordered")).to_contain_text("depth 80 m")
    expect(page.locator("alert-bar .alert")).not_to_have_count(0)
    after = keys_by_size(page)
    for size, keys in before.items():
        for stood, stands in zip(keys, after[size], strict=True):
            assert stands == [stood[0], *(pytest.approx(end, abs=1.5) for end in stood[1:])], size
    assert instructor.ask("order clear all")[0]
