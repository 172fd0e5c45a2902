"""Three people at three pages, who know what the pages say, bring an exercise to its full marks."""

import time
from dataclasses import dataclass, field
from statistics import fmean
from typing import Any, Final

import pytest
from helpers.browser import Look, Serve
from helpers.waiting import await_that
from playwright.sync_api import Page, expect
from soak.session_process import Caller

RISING: Final = 10  # times faster than the clock while she comes up
KEEPING: Final = 25  # and afterwards
LOOK: Final = 0.1  # [s] between two looks at the pages
DRAWN: Final = 22.0  # [m] from where the sea draws her up
BAND: Final = (16.9, 18.3)  # [m] in which a mean depth is good
SETTLED: Final = 420.0  # [s] when way and depth are steady
MEAN: Final = 60.0  # [s] of the mean, and between two orders by it
PUMPS: Final = "[data-pump=depth_control]"
SEEN: Final = """() => {
  const text = (place) => document.querySelector(place)?.textContent ?? "";
  const [minutes, seconds] = text("#time").split(" ")[0].split(":").map(Number);
  return { seconds: 60 * minutes + seconds, state: text("#state"), ordered: text("#ordered"),
           depth: Number(text("depth-gauge .digits")), repeat: text("repeat-bar b"),
           offered: text("#autopilot button") };
}"""


def steer(page: Page) -> None:
    """Repeat what concerns the pilot, and give the autopilot what it may keep."""
    seen = page.evaluate(SEEN)
    if seen["repeat"].startswith(("depth", "speed")):
        page.locator("repeat-bar button").click()
    if seen["offered"]:
        page.locator("#autopilot button").first.click()


def ballast(page: Page) -> None:
    """Repeat what is told to ballast, and move the water."""
    words = page.evaluate(SEEN)["repeat"]
    if not words.startswith("ballast"):
        return
    page.locator("repeat-bar button").click()
    _, way, amount, _ = words.split()
    page.locator(PUMPS).get_by_role("radio", name="2" if amount == "4" else amount).first.click()
    for _ in range(2 if amount == "4" else 1):
        page.locator(PUMPS).get_by_role("button", name=way.title()).click()
    expect(page.locator("repeat-bar")).to_be_hidden()


@dataclass
class Officer:
    """The diving officer, who tells ballast what the depth gauge says of the weight."""

    page: Page
    up: bool = False  # whether she is where the sea draws her up
    changed: float = 0.0  # [s] when the weight was last changed
    track: list[tuple[float, float]] = field(default_factory=list)

    def work(self) -> str:
        """Look at the gauge, and give the order that is due; return the state of time."""
        seen = self.page.evaluate(SEEN)
        self.track.append((seen["seconds"], seen["depth"]))
        if not self.up:
            self.up = "depth 17.5" in seen["ordered"] and seen["depth"] < DRAWN
            if self.up:
                self.tell("flood 4 t", seen)
        elif seen["seconds"] > max(self.changed + MEAN, SETTLED):
            self.judge(seen)
        return str(seen["state"])

    def judge(self, seen: dict[str, Any]) -> None:
        """Change the weight by what the depth is in the mean."""
        mean = fmean(depth for at, depth in self.track if at > seen["seconds"] - MEAN)
        if mean < BAND[0]:
            self.tell("flood 1 t", seen)
        elif mean > BAND[1]:
            self.tell("pump 1 t", seen)

    def tell(self, words: str, seen: dict[str, Any]) -> None:
        """Type an order to ballast."""
        self.changed = seen["seconds"]
        field = self.page.get_by_label("Order in words")
        field.fill(f"tell ballast {words}")
        field.press("Enter")
        expect(field).to_be_empty()


def marks(instructor: Caller) -> list[str]:
    """Return what the session gives for the exercise, once it is judged."""

    def said() -> list[str]:
        assert instructor.ask("who")[0]
        return [each.fields[3] for each in instructor.news if each.fields[2] == "exercise"]

    await_that(lambda: any("marks of 100" in each for each in said()))
    return said()


@pytest.mark.slow
def test_a_crew_of_three_brings_periscope_depth_to_its_full_marks(serve: Serve, look: Look) -> None:
    session = serve("periscope-depth")
    instructor = session.attach()
    pages = [look(session, name) for name in ("pilot", "ballast", "diving")]
    for page in pages:
        page.locator("#ready").click()
        expect(page.locator("#briefing")).to_be_hidden()
    officer = Officer(pages[2])
    for words in (f"time x{RISING}", "run"):
        assert instructor.ask(words)[0]
    while officer.work() != "ENDED":
        before = officer.up
        steer(pages[0])
        ballast(pages[1])
        officer.work()
        if officer.up > before:
            assert instructor.ask(f"time x{KEEPING}")[0]
        time.sleep(LOOK)  # a crew looks, and lets the boat go on

    assert "marks: won, 100 marks of 100" in marks(instructor), instructor.news
