"""Aids on pages: keys by keyboard, faint pointers, words, lines of charts; the way shown."""

import re
from pathlib import Path

import pytest
from helpers.browser import Look, Serve
from helpers.hands import see_whole
from helpers.lanes import sample_cases
from helpers.pages import Served
from helpers.waiting import PATIENCE
from playwright.sync_api import Page, expect

from trainer.config.files import path_named

ENDS = re.compile(r"ghost 100\.\d, ahead 100\.\d$")
LONG = PATIENCE * 1000.0  # [ms]
BEYOND = """() => [...document.querySelectorAll("#aids, #aids > *, main")]
  .filter((each) => each.checkVisibility())
  .filter((each) => {
    const { left, right, bottom } = each.getBoundingClientRect();
    return left < -1 || right > innerWidth + 1 || bottom > innerHeight + 1;
  }).map((each) => each.outerHTML.slice(0, 90))"""


@pytest.fixture
def allowing(serve: Serve, tmp_path: Path) -> Served:
    """Serve the jam, which allows both aids."""
    shipped = path_named("stern-plane-jam", "exercises").read_text(encoding="utf-8")
    drill = tmp_path / "drill.toml"
    drill.write_text(shipped.replace("hand = [", 'aids = ["ghost", "predictor"]\nhand = [', 1))
    return serve(str(drill))


def press(page: Page, key: str) -> None:
    page.locator(key).focus()
    page.keyboard.press("Enter")


@pytest.mark.parametrize(
    "size", sample_cases([(360, 640), (640, 360), (1280, 720)], (360, 640)), ids=str
)
def test_who_trains_has_both_aids_and_the_way_by_keyboard(
    allowing: Served, look: Look, size: tuple[int, int]
) -> None:
    page = look(allowing, "trainee")
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.locator("#close-briefing").click()
    expect(page.locator("depth-gauge .ghost").first).to_be_hidden()
    if size == (1280, 720):  # low and wide: alerts and keys share a row
        tops = (
            "['.bell', '#aids'].map((one) => document.querySelector(one).getBoundingClientRect().y)"
        )
        bell, keys = page.evaluate(tops)
        assert keys < bell + 48

    press(page, "#ghost")
    expect(page.locator("#ghost")).to_have_attribute("aria-pressed", "true", timeout=LONG)
    expect(page.locator("#off-ghost")).to_contain_text("than the ghost")
    press(page, "#predictor")
    expect(page.locator("#way-ahead")).to_contain_text("in 60 s: 100", timeout=LONG)
    expect(page.locator("depth-gauge .ghost").first).not_to_have_attribute("hidden", "")
    see_whole(page, f"at {size}", BEYOND)

    press(page, "#show-way")
    expect(page.locator("#show-way")).to_have_text("Back from the way shown", timeout=LONG)
    expect(page.locator("#state")).to_have_attribute("data-state", "running")
    expect(page.locator("repeat-bar")).to_have_attribute("inert", "")
    press(page, "#show-way")
    expect(page.locator("#show-way")).to_have_text("Show the way", timeout=LONG)
    expect(page.locator("#time")).to_have_text("00:00 / 10:00")

    press(page, "#ghost")
    press(page, "#predictor")
    expect(page.locator("#off-ghost")).to_have_text("")
    expect(page.locator("#way-ahead")).to_have_text("")

    expect(page.locator("#hint")).to_have_text("Hint: 5 marks")
    press(page, "#hint")
    told = re.compile("^(hint, 5 marks: .*|nothing is missing.*)$")
    expect(page.locator("#aids [role=status]")).to_have_text(told, timeout=LONG)
    see_whole(page, f"with a hint at {size}", BEYOND)


def test_an_instructors_charts_have_the_ghosts_line_and_the_way_ahead(
    allowing: Served, look: Look
) -> None:
    page = look(allowing, "instructor")
    page.set_viewport_size({"width": 1280, "height": 720})
    press(page, "#ghost")
    press(page, "#predictor")
    chart = page.locator("strip-chart[data-of=depth]")
    expect(chart).to_have_attribute("aria-label", ENDS, timeout=LONG)


def test_where_an_exercise_allows_no_aids_there_are_no_keys_for_them(
    serve: Serve, look: Look
) -> None:
    page = look(serve("stern-plane-jam"), "trainee")
    expect(page.locator("#show-way")).to_be_visible(timeout=LONG)
    for key in ("#ghost", "#predictor"):
        expect(page.locator(key)).to_be_hidden()
