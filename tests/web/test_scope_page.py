"""The periscope's page: what is worked reaches the boat, and what is seen is what is there."""

import re
from collections.abc import Iterator
from typing import Final

import pytest
from helpers.browser import Look, looking
from helpers.hands import WAYS, await_truth, read, see_whole, work
from helpers.lanes import sample_cases
from helpers.pages import OFTEN, SIZES, Served, served
from helpers.waiting import await_that
from playwright.sync_api import Browser, Page, expect
from soak.session_process import Caller

TRAFFIC: Final = """\
schema = "exercise/1"
name = "Traffic"
briefing = "Look round."
light = "dusk"
duration_s = 3600

[limits]
cpa_m_min = 150

[initial]
speed_kn = 5
depth_m = 17.5

[sea]
sea_state = 2
generator = "cosines"

[[contact]]
name = "big"
type = "tanker"
points = [[3000, 0]]
course_deg = 90
status = "under way"

[[contact]]
name = "beyond"
type = "tug"
points = [[90000, 0]]
"""
BEYOND: Final = """() => [...document.querySelectorAll("main button, main input")]
    .filter((each) => each.checkVisibility())
    .filter((each) => {
        const { left, right, top, bottom } = each.getBoundingClientRect();
        return left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1;
    }).map((each) => each.textContent)"""
# the level of the page's own sea
LEVEL: Final = """([x, y]) => {
  const { sea } = document.querySelector("scope-view");
  sea.run(0);
  return sea.level(x, y);
}"""
# what of the painted square is not as the round view needs it
PAINTED: Final = """() => {
  const canvas = document.querySelector("scope-view canvas");
  const [box, room] = [canvas, document.querySelector(".glass")]
    .map((each) => each.getBoundingClientRect());
  const side = Math.min(room.width, room.height);
  const near = (one, other) => Math.abs(one - other) <= 1;
  const mixed = canvas.getContext("2d").getContextAttributes().alpha;
  const fits = near(box.width, side) && near(box.height, side);
  const painted = canvas.width === canvas.height && near(canvas.width, Math.min(side, 720));
  return fits && painted && !mixed ? [] : [box, room, canvas.width, canvas.height, mixed];
}"""
LEFT: Final = "\u22121\u00b0"  # one degree to the left


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Return a frozen session with a ship ahead, its mast all out."""
    path = tmp_path_factory.mktemp("traffic") / "traffic.toml"
    path.write_text(TRAFFIC)
    with served(str(path), "--no-record") as session:
        caller = session.attach()
        assert caller.ask("scope raise")[0]
        assert caller.ask("step 17")[0]
        await_truth(caller, "lookout.mast", "8.0")
        yield session


@pytest.fixture
def desk(traffic: Served) -> Caller:
    """Return the instructor's line, with the scope trained ahead."""
    caller = traffic.callers[0]
    for words in ("scope raise", "scope train 0", "scope power 1.5"):
        assert caller.ask(words)[0]
    return caller


@pytest.fixture(scope="module")
def kept_view(browser: Browser, traffic: Served) -> Iterator[Page]:
    """Return the page in front of that ship, which stays open for the tests of this module."""
    with looking(browser) as look:
        yield opened(look, traffic)


@pytest.fixture
def ahead(desk: Caller, kept_view: Page) -> Page:  # noqa: ARG001  who trains it
    """Return the page on a laptop, once it looks ahead."""
    resize(kept_view, "laptop")
    expect(kept_view.locator("#bearing")).to_have_text("000")
    return kept_view


def resize(page: Page, size: str) -> None:
    """Give a page the room of a screen."""
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})


def opened(look: Look, session: Served, **how: object) -> Page:
    """Return a page that shows a view."""
    page = look(session, "scope", **how)
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("scope-view")).to_have_attribute("data-view", re.compile("clear|drops"))
    return page


@pytest.mark.parametrize("way", WAYS)
def test_every_key_reaches_the_boat(traffic: Served, desk: Caller, look: Look, way: str) -> None:
    page = opened(look, traffic, size="desk", has_touch=way == "touch")
    work(page, page.get_by_role("button", name="6", exact=False).last, way)
    await_truth(desk, "scope.power", "6.0")
    for name, wanted in (("+10°", "10.0"), (LEFT, "9.0"), ("Ahead", "0.0")):
        work(page, page.get_by_role("button", name=name, exact=True), way)
        await_truth(desk, "scope.train", wanted)
    work(page, page.get_by_role("button", name="Range"), way)
    expect(page.locator("#ranged")).to_contain_text("bearing 000: 30 m high, range")
    work(page, page.get_by_role("button", name="Mark contact"), way)
    expect(page.locator("#answer")).to_contain_text("marked at")
    work(page, page.get_by_role("button", name="Lower"), way)
    await_truth(desk, "scope.going", "lowering")
    work(page, page.get_by_role("button", name="Raise"), way)
    await_truth(desk, "scope.going", "up")


def test_the_view_follows_a_drag_and_the_arrows(desk: Caller, ahead: Page) -> None:
    page = ahead
    view = page.locator("scope-view")
    expect(view).to_have_attribute("data-ships", "1")
    box = view.bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - box["height"] / 4, y, steps=3)
    page.mouse.up()
    await_truth(desk, "scope.train", "8.0")  # a quarter of 32 degrees
    page.keyboard.press("Home")
    await_truth(desk, "scope.train", "0.0")
    for key in ("ArrowLeft", "Shift+ArrowLeft"):
        page.keyboard.press(key)
    await_truth(desk, "scope.train", "349.0")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowLeft")
    expect(view).to_have_attribute("data-ships", "0")
    expect(page.locator("#bearing")).to_have_text("309")
    await_truth(desk, "scope.train", "309.0")  # or its order would come after the next test's


def test_the_page_s_waves_are_the_session_s(desk: Caller, ahead: Page) -> None:
    page = ahead
    eye = float(read(desk, "lookout.eye"))
    page.wait_for_function(
        f"() => Math.abs(document.querySelector('scope-view').eye - {eye}) < 0.06"
    )
    level = float(read(desk, "sea.elevation"))
    assert page.evaluate(LEVEL, [0, 0]) == pytest.approx(level, abs=0.006)
    levels = [page.evaluate(LEVEL, [x, 40]) for x in range(-200, 200, 10)]
    assert max(levels) - min(levels) > 0.1
    assert all(abs(each) < 1.0 for each in levels)


@pytest.mark.parametrize("size", sample_cases(SIZES, *OFTEN, "4k", "phone-side"))
def test_the_view_and_every_key_have_room_and_no_more_is_painted(ahead: Page, size: str) -> None:
    resize(ahead, size)
    see_whole(ahead, size, BEYOND)
    box = ahead.locator("scope-view").bounding_box()
    assert box
    assert min(box["width"], box["height"]) >= 0.36 * min(SIZES[size])
    for key in ahead.locator(".optics button").all():
        found = key.bounding_box()
        assert found
        assert found["height"] >= 44
    await_that(lambda: ahead.evaluate(PAINTED) == [], lambda: ahead.evaluate(PAINTED))


def test_a_trainee_s_page_is_told_no_range(traffic: Served, ahead: Page) -> None:
    page = ahead
    told = page.locator("scope-view").get_attribute("aria-label") or ""
    expect(page.locator("scope-view")).to_have_attribute("aria-label", re.compile("tanker 000"))
    assert "tug" not in told
    helm = traffic.attach("helm")
    assert not helm.ask("subscribe scope")[0]
    assert not traffic.attach("scope").ask("subscribe lookout")[0]


def test_a_mast_that_is_down_shows_nothing_and_says_so(shared: Served, look: Look) -> None:
    page = look(shared, "scope")
    view = page.locator("scope-view")
    expect(view).to_have_attribute("data-view", "dark")
    expect(view).to_have_attribute("aria-label", "Scope down")


@pytest.mark.usefixtures("desk")
def test_the_instructor_sees_mast_and_exposure(traffic: Served, look: Look) -> None:
    page = look(traffic, "instructor", size="desk")
    row = page.locator("tr[data-of=mast]")
    expect(row).to_contain_text("8.0 out")
    expect(row).to_contain_text("shown")


def test_who_wants_no_motion_sees_a_still_view(ahead: Page) -> None:
    assert ahead.evaluate("document.querySelector('scope-view').scene.roll") == 0


# whether a page stops drawing its view: eight pictures in a row, of forty at most
RESTS: Final = """() => new Promise((done) => {
  const { water } = document.querySelector("scope-view");
  const draw = water.draw;
  let [still, all] = [0, 0];
  water.draw = function (...what) { still = 0; draw.apply(this, what); };
  document.motion.addEventListener("frame", () => {
    [still, all] = [still + 1, all + 1];
    if (still > 8 || all > 40) done(still > 8);
  });
})"""


@pytest.mark.usefixtures("desk")
def test_a_view_that_stands_still_is_not_drawn_anew(traffic: Served, look: Look) -> None:
    page = opened(look, traffic, size="phone", reduced_motion="no-preference")
    assert page.evaluate(RESTS)


def test_a_type_of_ship_fills_in_its_masthead_and_the_briefing_is_there_in_words(
    ahead: Page,
) -> None:
    for size in ("laptop", "phone"):
        resize(ahead, size)
        ahead.get_by_role("combobox", name="Type of ship").select_option(label="tanker")
        expect(ahead.locator("#range input")).to_have_value("40")
        ahead.get_by_role("button", name="Range").click()
        expect(ahead.locator("#ranged")).to_contain_text("40 m high, range")
        ahead.locator("#range input").fill("1")
    ahead.get_by_role("button", name="Briefing").click()
    expect(ahead.locator("#briefing-text")).to_contain_text("Look round.")
    expect(ahead.locator("#briefing-text")).to_contain_text("range to a ship at least 150 m")


# the colour of the sky, beside the wire
SKY: Final = """() => {
  const canvas = document.querySelector("scope-view canvas");
  const at = [0.42, 0.25].map((part) => Math.round(part * canvas.width));
  return [...canvas.getContext("2d").getImageData(...at, 1, 1).data];
}"""


@pytest.mark.usefixtures("desk")
def test_the_light_outside_is_the_session_s_whatever_the_palette(
    traffic: Served, look: Look
) -> None:
    pages = [opened(look, traffic, query=f"?palette={palette}") for palette in ("day", "night")]
    day, night = (page.evaluate(SKY) for page in pages)
    assert day == night
    assert max(day[:3]) - min(day[:3]) > 20  # coloured as at dusk
