"""The diving officer's and the observer's pages: orders to the crew, what planes hold, marks."""

import re
from typing import Final

import pytest
from helpers.browser import Look
from helpers.hands import (
    UNWORKED,
    WAYS,
    await_truth,
    heard,
    read,
    report,
    see_whole,
    step,
    work,
    work_frame,
    work_parts,
)
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served
from helpers.plant_page import close_plant, open_plant
from playwright.sync_api import Page, expect
from soak.session_process import Caller

# Digits, the key after them, and how the order then stands.
NUMBERS: Final = (
    ("80", "depth, m", {"orders.depth": "80.0", "orders.depth_unit": "m"}),
    ("200", "depth, ft", {"orders.depth": "61.0", "orders.depth_unit": "ft"}),
    ("5", "pitch down", {"orders.pitch": "-5.0"}),
    ("3", "pitch up", {"orders.pitch": "3.0"}),
    ("45", "course left", {"orders.course": "45.0", "orders.course_side": "left"}),
    ("90", "course right", {"orders.course": "90.0", "orders.course_side": "right"}),
    ("120", "course", {"orders.course": "120.0", "orders.course_side": ""}),
    ("8", "speed, kn", {"orders.speed": "8.0"}),
)


def open_page(kept: Look, name: str = "diving", **how: object) -> Page:
    """Return the page, when it shows readings."""
    return await_readings(kept(name, **how))


def await_readings(page: Page) -> Page:
    """Return a page once it shows readings."""
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("[data-place='gauges.heel']")).not_to_be_empty()
    return page


@pytest.mark.parametrize("way", WAYS)
def test_the_keypad_orders_the_crew(instructor: Caller, kept: Look, way: str) -> None:
    page = open_page(kept)
    for digits, key, wanted in NUMBERS:
        for digit in digits:
            work(
                page,
                page.locator("order-keypad").get_by_role("button", name=digit, exact=True),
                way,
            )
        expect(page.locator("order-keypad .typed")).to_have_text(digits)
        work(page, page.locator("order-keypad .ends").get_by_text(key, exact=True), way)
        expect(page.locator("order-keypad .typed")).to_have_text("none")
        expect(page.locator("#answer")).to_contain_text("ordered: ")
        step(instructor, 1)
        for place, value in wanted.items():
            await_truth(instructor, place, value)


def test_the_officer_of_the_deck_has_course_depth_and_speed_alone(
    instructor: Caller, kept: Look
) -> None:
    page = open_page(kept, "deck")
    expect(page.locator("[data-place='gauges.speed']")).to_have_text("10.0 kn")
    ends = page.locator("order-keypad .ends button")
    expect(ends).to_have_text(
        ["depth, m", "depth, ft", "course left", "course right", "course", "speed, kn"]
    )
    page.locator("#typed-order input").fill("come left to 045")
    page.keyboard.press("Enter")
    expect(page.locator("#standing")).to_contain_text("course 045")
    assert heard(instructor, "deck: ordered: course left to 045")
    page.locator("#typed-order input").fill("order pitch 3 up")
    page.keyboard.press("Enter")
    expect(page.locator("#answer")).to_contain_text("who orders course, depth and speed alone")
    page.locator("#standing").get_by_role("button", name="Belay").click()
    expect(page.locator("#standing")).to_have_text("none stands")


def test_what_is_ordered_stands_in_its_unit_until_it_is_belayed(
    instructor: Caller, kept: Look
) -> None:
    page = open_page(kept)
    page.locator("order-keypad").get_by_role("button", name="2", exact=True).focus()
    page.keyboard.type("2000")
    expect(page.locator("order-keypad .ends").get_by_text("depth, m")).to_be_disabled()
    page.keyboard.press("Backspace")
    page.locator("order-keypad .ends").get_by_text("depth, ft").click()
    expect(page.locator("#answer")).to_contain_text("200 ft")
    step(instructor, 1)
    expect(page.locator("#standing")).to_contain_text("depth 200 ft")
    expect(page.locator("#standing")).to_contain_text("not repeated yet")
    expect(page.locator("#ordered")).to_have_text("depth 200 ft")
    expect(page.locator("repeat-bar")).to_be_hidden()
    page.get_by_role("button", name="Belay: depth").click()
    expect(page.locator("#answer")).to_contain_text("belay depth")
    step(instructor, 1)
    expect(page.locator("#standing")).to_have_text("none stands")
    assert read(instructor, "orders.depth") == ""


@pytest.mark.parametrize("way", WAYS)
def test_phrases_to_the_crew_are_orders_to_the_crew(
    instructor: Caller, kept: Look, way: str
) -> None:
    page = open_page(kept)
    phrases = (
        ("Periscope depth", "periscope", "orders.depth", "17.5"),
        ("Level", "pitch zero", "orders.pitch", "0.0"),
        ("Steady as she goes", "steady", "orders.course", "0.0"),
    )
    for phrase, said, place, value in phrases:
        work(page, page.get_by_role("button", name=phrase), way)
        expect(page.locator("#answer")).to_contain_text("ordered: ")
        expect(page.locator("#answer")).to_contain_text(said)
        step(instructor, 1)
        await_truth(instructor, place, value)
    work(page, page.locator("[data-order=belay]"), way)
    expect(page.locator("#answer")).to_contain_text("belay")
    step(instructor, 1)
    await_truth(instructor, "orders.course", "")
    work(page, page.get_by_label("Order in words"), way)
    page.get_by_label("Order in words").focus()
    page.keyboard.type("five degrees down bubble")
    work(page, page.locator("#typed-order button"), way)
    expect(page.locator("#answer")).to_contain_text("five degrees down bubble")
    step(instructor, 1)
    await_truth(instructor, "orders.pitch", "-5.0")
    page.get_by_label("Order in words").fill("mark naïve")
    work(page, page.locator("#typed-order button"), way)
    refusal = 'mark naïve: "ï" (U+00EF) cannot be sent; type plain letters'
    expect(page.locator("#answer")).to_contain_text(refusal)
    expect(page.get_by_label("Order in words")).to_have_value("mark naïve")
    page.get_by_label("Order in words").fill("")  # the page is kept for the next test


@pytest.mark.parametrize("way", WAYS)
def test_what_acts_at_once_asks_first(instructor: Caller, kept: Look, way: str) -> None:
    page = open_page(kept)
    acts = (
        ("Surface", "valves.blow_mid", "open"),
        ("Dive", "valves.vent_mid", "open"),
        ("Hover", "tanks.hover", "on"),
    )
    for words, place, value in acts:
        key = page.locator(".phrases").get_by_role("button", name=words)
        before = read(instructor, place)
        work(page, key, way)
        work(page, page.get_by_role("button", name="No", exact=True), way)
        expect(page.locator("dialog.question")).to_have_count(0)
        step(instructor, 2)
        assert read(instructor, place) == before != value
        work(page, key, way)
        work(page, page.locator("dialog.question .yes"), way)
        expect(page.locator("#answer")).to_contain_text(words.lower())
        step(instructor, 2)
        assert read(instructor, place) == value


def test_the_crews_repeats_are_shown(shared: Served, instructor: Caller, kept: Look) -> None:
    page = open_page(kept)
    planes = shared.attach("planes")
    page.locator("order-keypad").get_by_role("button", name="8", exact=True).click()
    page.locator("order-keypad").get_by_role("button", name="0", exact=True).click()
    page.locator("order-keypad .ends").get_by_text("depth, m").click()
    expect(page.locator("#answer")).to_contain_text("80 m")
    step(instructor, 1)
    assert instructor.ask("order course 080")[0]
    assert "WRONG" in planes.ask("depth 70 m aye")[1]
    expect(page.locator("#standing [data-wrong]")).to_have_text("WRONG REPEAT")
    expect(page.locator("#standing li").first).to_contain_text("WRONG REPEAT")
    expect(page.locator("#said li").last).to_be_in_viewport(ratio=1)
    assert planes.ask("aye")[0]
    expect(page.locator("#standing li", has_text="depth")).to_contain_text("repeated")
    expect(page.locator("#standing li", has_text="depth")).not_to_contain_text("not repeated")
    expect(page.locator("#said")).to_contain_text("planes: depth 80 m aye")
    for words in ("order speed 7", "order course 090", "order depth 85"):
        assert instructor.ask(words)[0]
    expect(page.locator("#said li").nth(5)).to_be_attached()  # six have room where three had it
    expect(page.locator("#said li").last).to_contain_text("85 m")


def test_evidence_of_trim_is_what_the_planes_hold_in_the_mean(
    instructor: Caller, kept: Look
) -> None:
    page = open_page(kept)
    assert instructor.ask("freeze depth")[0]
    assert instructor.ask("bow planes rise 6")[0]
    assert instructor.ask("stern planes dive 2")[0]
    for _ in range(21):
        step(instructor, 20)
    expect(page.locator("#span")).to_have_text("mean of 03:00")
    expect(page.locator("#bow-held")).to_have_text("hold 6.0 rise")
    expect(page.locator("#stern-held")).to_have_text("hold 2.0 dive")
    assert float(read(instructor, "diving.bow")) == pytest.approx(6.0, abs=0.05)
    assert instructor.ask("bow planes zero")[0]
    for _ in range(9):
        step(instructor, 20)
    half = re.compile(r"hold (2\.[89]|3\.[0-3]) rise")  # half of three minutes, but for the way
    expect(page.locator("#bow-held")).to_have_text(half)


@pytest.mark.parametrize("way", WAYS)
def test_the_chosen_tank_has_its_controls_below(instructor: Caller, kept: Look, way: str) -> None:
    page = open_page(kept)
    expect(page.locator("[data-pump=auxiliary]")).to_be_hidden()
    work(page, page.locator(".tank[data-part=auxiliary]"), way)
    expect(page.locator("#tank")).to_contain_text("Auxiliary: ")
    # a kept page may still have the pump of before: the same way again adds
    expect(page.locator("[data-pump=auxiliary] .left")).to_have_text("nothing to move")
    work(page, page.locator("[data-pump=auxiliary] .high"), way)
    expect(page.locator("#answer")).to_contain_text("under way")
    step(instructor, 1)
    assert float(read(instructor, "tanks.moving_auxiliary")) == pytest.approx(2.0, abs=0.1)
    work(page, page.get_by_role("button", name="EMERG."), way)
    work(page, page.locator("emergency-cover .cover"), way)
    expect(page.locator("emergency-cover .push")).to_be_enabled()
    work(page, page.locator("emergency-cover .push"), way)
    expect(page.locator("#answer")).to_contain_text("both banks")
    step(instructor, 1)
    assert read(instructor, "valves.blow_mid") == "emergency"


@pytest.mark.usefixtures("instructor")
@pytest.mark.parametrize("name", sample_cases(["diving", "observer"], "diving"))
def test_nothing_is_cut_at_any_size(shared: Served, look: Look, name: str) -> None:
    page = await_readings(look(shared, name))
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        keys = page.locator("part-keys[part=part] button:visible")
        for place in range(max(keys.count(), 1)):
            if keys.count():
                keys.nth(place).click()
            see_whole(page, f"{width}x{height}, part {place}")


@pytest.mark.parametrize("way", WAYS)
def test_an_observer_marks_a_moment_and_works_nothing_else(
    instructor: Caller, kept: Look, way: str
) -> None:
    page = open_page(kept, "observer")
    assert page.locator("main [data-control]").evaluate_all("each => each.map(x => x.id)") == [
        "mark"
    ]
    expect(page.locator("depth-gauge .beyond")).to_be_visible()
    page.get_by_label("Remark").fill(f"bow well down {way}")
    work(page, page.locator("#mark button"), way)
    expect(page.locator("#answer")).to_contain_text("mark")
    assert heard(instructor, f"bow well down {way}")
    expect(page.locator("#log")).to_contain_text(f"bow well down {way}")
    assert instructor.ask("vent aft open")[0]
    step(instructor, 1)
    expect(page.locator("[data-part=vent_aft]")).to_have_attribute("data-open", "true")
    depth = float(read(instructor, "gauges.depth"))
    expect(page.locator("depth-gauge .digits")).to_have_text(f"{depth:.1f}")
    for tank in page.locator(".tank").all():
        work(page, tank, way)
        expect(tank).to_have_attribute("aria-pressed", "true")
    work(page, page.get_by_label("Remark"), way)
    work_frame(page, way)
    open_plant(page, way)
    close_plant(page, way)
    assert page.evaluate(UNWORKED) == []
    page.set_viewport_size({"width": 360, "height": 640})
    work_parts(page, way, "part-keys button", "data-part")


@pytest.mark.parametrize("way", WAYS)
def test_what_else_the_officer_works(instructor: Caller, kept: Look, way: str) -> None:
    page = open_page(kept, size="desk")
    pad = page.locator("order-keypad")
    for digit in "1234567890":
        work(page, pad.get_by_role("button", name=digit, exact=True), way)
    expect(pad.locator(".typed")).to_have_text("7890")
    work(page, pad.get_by_role("button", name="Last digit back"), way)
    expect(pad.locator(".typed")).to_have_text("789")
    work(page, pad.get_by_role("button", name="Clear"), way)
    expect(pad.locator(".typed")).to_have_text("none")
    assert instructor.ask("order speed 5")[0]
    work(page, page.get_by_role("button", name="Belay: speed"), way)
    await_truth(instructor, "orders.speed", "")
    work_parts(page, way, "part-keys[part=group] button", "data-group")
    work(page, page.get_by_role("button", name="More"), way)
    report(page, f"she is heavy {way}", way)
    assert heard(instructor, f"she is heavy {way}")
    work_frame(page, way)
    page.set_viewport_size({"width": 360, "height": 640})
    work_parts(page, way, "part-keys[part=part] button", "data-part")


@pytest.mark.usefixtures("instructor")
def test_an_observer_has_charts_before_the_log(kept: Look) -> None:
    page = open_page(kept, "observer")
    charts, log = page.locator(".plots strip-chart"), page.locator("#log")
    order = "(log) => log.compareDocumentPosition(document.querySelector('.plots'))"
    assert log.evaluate(order) & 2  # Node.DOCUMENT_POSITION_PRECEDING
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        parts = page.locator("part-keys button:visible")
        if parts.count():
            words = parts.all_inner_texts()
            assert words.index("Charts") < words.index("Log")
            page.get_by_role("button", name="Charts", exact=True).click()
            expect(charts).to_have_count(6)
            expect(charts.last).to_be_in_viewport(ratio=1.0)
            expect(log).to_be_hidden()
        else:
            chart, entries = charts.first.bounding_box(), log.bounding_box()
            assert chart
            assert entries
            assert chart["y"] < entries["y"]
    expect(charts.first).to_have_attribute("aria-label", re.compile(r"^Depth, .* now \d+"))
