"""A dive by keyboard, and all that a screen reader says of it, kept as a text.

The reader is a program in the page (``@guidepup/virtual-screen-reader``): it follows the focus, and
says what live regions tell. What it says is read by people when it changes.
"""

import difflib
from pathlib import Path
from typing import Final

import pytest
from helpers import node
from helpers.browser import Look, Serve
from helpers.hands import read
from helpers.places import DATA
from helpers.waiting import await_that
from playwright.sync_api import Page, expect
from soak.session_process import Caller

pytestmark = pytest.mark.slow
KEPT: Final = DATA / "said" / "dive-by-keyboard.txt"
EXERCISE: Final = """\
schema = "exercise/1"
name = "By ear"
briefing = "Take the boat from 30 to 40 m by the planes."
duration_s = 600
hand = ["planes"]
[initial]
speed_kn = 8
depth_m = 30
"""
TAKE: Final = """async () => {
    const said = await screenReader.spokenPhraseLog();
    await screenReader.clearSpokenPhraseLog();
    return said; }"""
BEGIN: Final = "async () => { await screenReader.start({ container: document.body }); }"


class Listener:
    """Who sits before a page without seeing it: presses keys, and writes down what is said."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.text: list[str] = []
        page.evaluate(node.screen_reader())
        page.evaluate(BEGIN)
        self._take()

    def press(self, *keys: str) -> None:
        """Press keys one after the other."""
        for key in keys:
            self.page.keyboard.press(key)
            self._write(key)

    def find(self, name: str) -> None:
        """Press Tab until something of that name is said."""
        for _ in range(60):
            self.page.keyboard.press("Tab")
            said = self._take()
            if any(name in each for each in said):
                self.text += [f"> Tab to {name}", *said]
                return
        raise AssertionError(f"no way by Tab to {name}: {self.text[-5:]}")

    def hear(self, what: str, words: str) -> None:
        """Wait until words are said, after what others have done."""
        heard: list[str] = []

        def is_said() -> bool:
            heard.extend(each for each in self._take() if each not in heard)
            return any(words in each for each in heard)

        await_that(is_said)
        self.text += [f"> {what}", *heard]

    def _write(self, what: str) -> None:
        self.text += [f"> {what}", *self._take()]

    def _take(self) -> list[str]:
        self.page.wait_for_timeout(400)  # a live region is told a moment later
        return list(dict.fromkeys(self.page.evaluate(TAKE)))


def test_a_dive_by_keyboard_is_said_as_it_was(serve: Serve, look: Look, tmp_path: Path) -> None:
    exercise = tmp_path / "by-ear.toml"
    exercise.write_text(EXERCISE, encoding="utf-8")
    session = serve(str(exercise))
    instructor = session.attach()
    page = look(session, "planes")
    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    if page.locator("#briefing").is_visible():
        page.keyboard.press("Escape")
    listener = Listener(page)
    dive(listener, instructor)

    told = "\n".join(listener.text) + "\n"
    new = tmp_path / KEPT.name
    new.write_text(told, encoding="utf-8")
    kept = KEPT.read_text(encoding="utf-8") if KEPT.exists() else ""
    changes = "\n".join(difflib.unified_diff(kept.splitlines(), told.splitlines(), lineterm=""))
    assert not changes, f"read it, then keep it: cp {new} {KEPT}\n{changes}"


def dive(listener: Listener, instructor: Caller) -> None:
    """Go from 30 to 40 m, with all that a planesman says and does."""
    assert instructor.ask("order depth 40")[0]
    listener.hear("the order is given", "New order: depth 40 m")
    listener.find("Repeat: depth 40 m aye")
    listener.press("Enter")
    listener.find("slider, Stern planes")
    listener.press("ArrowDown", "ArrowDown", "PageDown")
    assert instructor.ask("casualty bow-stuck")[0]
    assert instructor.ask("step 60")[0]
    listener.find("slider, Bow planes")
    listener.press("PageUp")
    assert instructor.ask("step 20")[0]
    listener.hear("the bow planes do not follow", "warning: Bow planes off their order")
    listener.find("Acknowledge")
    listener.press("Enter")
    listener.find("combobox, Report")
    listener.page.keyboard.type("bow planes jammed")
    listener.press("Enter")
    listener.find("Safe depth")
    listener.press("Enter", "Escape")
    assert float(read(instructor, "gauges.depth")) > 30.5
