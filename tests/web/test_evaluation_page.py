"""What could still be earned, on the instructor's page and on no other."""

import re

import pytest
from helpers.browser import Look
from helpers.lanes import sample_cases
from helpers.pages import served
from helpers.waiting import PATIENCE
from playwright.sync_api import expect

pytestmark = pytest.mark.process


@pytest.mark.parametrize("size", sample_cases(["phone", "laptop"], "phone"))
def test_the_bar_is_the_instructors_alone(look: Look, size: str) -> None:
    with served("first-depth-change") as session:
        page = look(session, "instructor", size=size)
        crew = look(session, "planes", size=size)
        page.keyboard.press("Escape")
        says = page.locator("#evaluation-says")
        expect(page.locator("#evaluation-marks")).to_have_text("100", timeout=1000.0 * PATIENCE)
        expect(says).to_have_text(re.compile("so far 0 . at 00:00"))
        box = page.locator("#evaluation").bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= page.evaluate("innerWidth")
        bar = page.locator("#evaluation-bar")
        expect(bar).to_have_attribute("aria-valuenow", "100")
        assert crew.locator("#evaluation").count() == 0
        assert "earn" not in crew.locator("body").inner_text()


def test_an_exercise_without_a_reference_crew_says_so(look: Look) -> None:
    with served("wheel-and-course") as session:
        page = look(session, "instructor")
        page.keyboard.press("Escape")
        says = page.locator("#evaluation-says")
        expect(says).to_have_text("No evaluation: this exercise has no reference crew")
        expect(page.locator("#evaluation-bar")).to_be_hidden()
