"""The plant on the pages: at each lever what moves the surface, and a window with all the rest."""

import re
from typing import Final

import pytest
from helpers import node
from helpers.browser import Look, Serve
from helpers.hands import TOO_WIDE, read, see_whole, step
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served
from helpers.plant_page import close_plant, open_plant, work_supplies, work_window
from helpers.waiting import await_that
from playwright.sync_api import Locator, Page, expect
from soak.session_process import Caller

LEVERS: Final = {"helm": ["rudder"], "planes": ["stern", "bow"], "pilot": ["rudder", "stern"]}
WINDOWS: Final = ("ballast", "diving", "instructor", "observer", "trainee")
PARTS_WITH_KEY: Final = {"instructor": "Track|Spur", "trainee": "Tanks|Zellen"}
PARTS: Final = """() => [...document.querySelectorAll(
    "main :is(.knob, .fine, [data-bell], .panel > supply-keys button)")]
    .filter((each) => each.checkVisibility())
    .map((each) => { const { x, y, width } = each.getBoundingClientRect();
        return [each.className, x, y, width].join(); })"""


def opened(look: Look, session: Served, name: str, size: str = "laptop", query: str = "") -> Page:
    """Return a page that shows readings."""
    page = look(session, name, size, query)
    expect(page.locator("#state")).to_have_attribute("data-state", re.compile("frozen|running"))
    return page


def told(page: Page, row: str) -> Locator:
    """Return what a row of the window tells."""
    return page.locator(f"#plant .plant-row:has(> b:text-is('{row}')) .told")


def keys_within(page: Page, part: str) -> int:
    """Return how many keys are seen in a part of a page."""
    return sum(key.is_visible() for key in page.locator(f"{part} button").all())


@pytest.mark.parametrize("name", sample_cases(list(LEVERS), "planes"))
def test_a_lever_s_keys_shift_what_moves_it_and_move_no_key(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    page = opened(look, shared, name)
    expect(page.locator(".panel > supply-keys:visible").first).to_be_visible()
    page.evaluate("document.fonts.ready")
    expect(page.locator("[data-mode]").first).not_to_be_empty()
    before = page.evaluate(PARTS)
    work_supplies(page, instructor, "mouse", ".panel >", LEVERS[name])
    assert instructor.ask(f"{LEVERS[name][0]} hand")[0]
    step(instructor, 2)
    shown = page.locator(f".panel > supply-keys[name={LEVERS[name][0]}] .told")
    expect(shown).to_have_text(re.compile(r"to hand in 59 s|to hand in 60 s"))
    assert page.evaluate(PARTS) == before


@pytest.mark.parametrize("name", sample_cases(["ballast", "diving", "trainee"], "ballast"))
def test_every_key_of_the_window_does_in_the_boat_what_it_says(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    page = opened(look, shared, name)
    open_plant(page)
    work_window(page, instructor, "mouse")
    if name == "ballast":
        assert keys_within(page, "#plant supply-keys") == 0  # it may not shift them
    else:
        work_supplies(page, instructor, "mouse", "#plant", ["bow"])
    close_plant(page)
    page.locator("#open-plant").focus()
    for key, shown in (("Enter", True), ("Tab", True), ("Escape", False)):
        page.keyboard.press(key)
        expect(page.locator("#plant")).to_be_visible(visible=shown)


def test_a_telephone_shifts_its_planes_in_the_window(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "planes", "phone")
    expect(page.locator(".panel > supply-keys:visible")).to_have_count(0)
    open_plant(page)
    expect(page.locator("#plant supply-keys")).to_have_count(2)
    work_supplies(page, instructor, "mouse", "#plant", ["stern"])


def test_an_observer_sees_the_plant_without_keys_and_what_is_unusual_in_words(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "observer")
    expect(page.locator("#open-plant")).to_have_text("Plant")
    open_plant(page)
    assert keys_within(page, "#plant .groups-of-plant") == 0
    assert page.locator("#plant [data-unusual]").count() == 0
    row = told(page, "Port bus")
    expect(row).to_contain_text("live")
    for words in ("casualty bus-port-lost", "casualty fire-aft", "stern planes emergency"):
        assert instructor.ask(words)[0], words
    step(instructor, 200)
    expect(row).to_contain_text("DEAD")
    assert "autopilot" in read(instructor, "plant.dead")
    dead = told(page, "Dead")
    expect(dead).to_contain_text("oil pump 1")
    expect(dead).to_have_attribute("data-unusual", "")
    expect(told(page, "Aft")).to_contain_text("SMOKE")
    expect(page.locator("#plant supply-keys[name=stern] .told")).to_contain_text("vital oil")
    expect(page.locator("#open-plant")).to_have_text("Plant !")


def test_a_boat_without_a_plant_has_neither_window_nor_keys(serve: Serve, look: Look) -> None:
    session = serve("--vessel", "sdv-mk9")
    for name in ("pilot", "diving"):
        page = opened(look, session, name)
        expect(page.locator("depth-gauge .digits")).not_to_be_empty()
        expect(page.locator("#open-plant")).to_be_hidden()
        assert keys_within(page, "supply-keys") == 0


@pytest.mark.parametrize("name", sample_cases([*WINDOWS, "planes"], "ballast", "instructor"))
@pytest.mark.parametrize("view", sample_cases([("de", "day"), ("en", "dusk")], ("de", "day")))
def test_the_window_has_no_barrier_and_fits_every_size(
    shared: Served, instructor: Caller, look: Look, name: str, view: tuple[str, str]
) -> None:
    language, palette = view
    assert instructor.ask("casualty bus-port-lost")[0]
    assert instructor.ask("step 4")[0]
    page = opened(look, shared, name, "phone", f"?lang={language}&palette={palette}")
    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    if name == "instructor":
        page.evaluate("document.querySelector('#exercise').close()")  # it opens by itself
    if name in PARTS_WITH_KEY:  # on a telephone
        words = re.compile(f"^({PARTS_WITH_KEY[name]})$")
        page.get_by_role("button", name=words).first.click()
    open_plant(page)
    page.evaluate(node.axe())
    await_that(lambda: page.evaluate(node.BARRIERS) == [], lambda: page.evaluate(node.BARRIERS))
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for parts in (TOO_WIDE, CUT):
            see_whole(page, f"{name} at {size}", parts)


# What of the window is wider than its place, or lies beyond the picture.
CUT: Final = """() => [...document.querySelectorAll("#plant, #plant *")]
  .filter((each) => each.checkVisibility() && getComputedStyle(each).display !== "inline")
  .filter((each) => {
    const { left, right } = each.getBoundingClientRect();
    return right > innerWidth + 1 || left < -1 || each.scrollWidth > each.clientWidth + 1;
  })
  .map((each) => `${each.className} ${each.textContent}`.slice(0, 80))"""
