"""The safe depth on the pages: a key below the depth gauge, and the diagram that it opens."""

import re

import pytest
from helpers.browser import Look
from helpers.hands import TOO_WIDE
from helpers.lanes import sample_cases
from helpers.pages import Served
from playwright.sync_api import Page, expect

DIVERS = ("planes", "pilot", "diving", "trainee")
DRAWN = """() => ["depth-diagram .safe", "depth-diagram .edge.jam", "depth-diagram .edge.flooding"]
    .map((part) => document.querySelector(part).getAttribute("d"))"""


def opened(look: Look, session: Served, name: str, size: str = "laptop", query: str = "") -> Page:
    """Return a page on which the safe depth is told."""
    page = look(session, name, size, query)
    expect(page.locator("#open-safe")).to_contain_text(re.compile("flooding to|Wassereinbruch"))
    return page


@pytest.mark.parametrize("name", sample_cases(list(DIVERS), "planes"))
def test_who_dives_is_told_how_deep_a_jam_would_go_and_sees_the_safe_depth(
    shared: Served, look: Look, name: str
) -> None:
    page = opened(look, shared, name)
    if page.locator("#briefing").is_visible():
        page.locator("#close-briefing").click()
    told = re.compile(r"^jam to \d+ m · flooding to \d+ m$")
    expect(page.locator("#open-safe")).to_have_text(told)
    bars = page.locator("depth-gauge .danger.jam:not([hidden])")
    expect(bars).to_have_count(1)
    page.locator("#open-safe").click()
    expect(page.locator("depth-diagram")).to_have_attribute(
        "aria-label", re.compile(r"the boat at \d+ knots, \d+ m")
    )
    assert all(len(path) > 40 for path in page.evaluate(DRAWN))
    page.keyboard.press("Escape")
    expect(page.locator("#safe")).to_be_hidden()


@pytest.mark.parametrize("size", ["phone", "phone-side"])
def test_the_safe_depth_has_room_on_a_phone(shared: Served, look: Look, size: str) -> None:
    page = opened(look, shared, "planes", size, "?lang=de")
    page.locator("#open-safe").click()
    expect(page.locator("#safe")).to_be_visible()
    assert not page.evaluate(TOO_WIDE)


@pytest.mark.parametrize("name", ["helm", "ballast"])
def test_who_does_not_dive_has_no_such_key(shared: Served, look: Look, name: str) -> None:
    page = look(shared, name)
    expect(page.locator("#state")).to_have_attribute("data-state", re.compile("frozen|running"))
    expect(page.locator("#open-safe")).to_have_count(0)
