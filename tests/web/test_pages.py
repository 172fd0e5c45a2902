"""Pages in a real browser: they show what the session says, and ask nowhere else."""

from collections.abc import Callable

from helpers.pages import Served
from playwright.sync_api import Page, expect

Look = Callable[..., Page]


def test_a_station_shows_what_its_session_says(shared: Served, look: Look) -> None:
    page = look(shared, "helm")

    expect(page.locator("#state")).to_have_text("FROZEN")
    instructor = shared.attach()
    assert instructor.ask("run")[0]
    expect(page.locator("#state")).to_have_text("RUNNING")
    assert instructor.ask("freeze")[0]
    expect(page.locator("#state")).to_have_text("FROZEN")


def test_the_first_page_leads_to_each_station(shared: Served, look: Look) -> None:
    page = look(shared)

    expect(page.locator("#state")).to_have_text("CONNECTED")
    for role in ("helm", "planes", "pilot"):
        expect(page.locator(f"[href='/{role}'] small")).to_have_text("free")
