"""Levers that are held, not hit: fingers on glass, one scale with the dial, words that are read."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, Final

import pytest
from helpers.browser import Look, Serve, hear_all
from helpers.hands import await_truth, on_groove
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served
from helpers.waiting import await_that
from playwright.sync_api import Locator, Page, expect
from soak.session_process import Caller

from trainer.web.pages import PAGES

Opened = Callable[..., Page]
PHONE: Final = (390, 844)
# Those at which pages are looked at: phones both ways, a tablet, laptops, a desk.
LOOKED_AT: Final = (*SIZES.values(), PHONE, (844, 390), (1366, 768), (1024, 768))
SIX: Final = ((1920, 1080), (1366, 768), (1024, 768), (844, 390), PHONE, (360, 640))
PAGE_OF: Final = {"rudder": "helm", "stern": "planes", "bow": "planes"}
CHANNELS: Final = {"rudder": "steering", "stern": "diving", "bow": "diving"}
STEP: Final = 5  # [deg] of a tap on the groove
LEAST_TEXT_PX: Final = 11.0
each_lever = pytest.mark.parametrize("lever", sample_cases(PAGE_OF, "rudder", "stern"))


FOUR: Final = sample_cases([PHONE, (768, 1024), (1366, 768), (1920, 1080)], PHONE, (1366, 768))

SENT: Final = """() => { window.sent = []; window.line.send = function (line) {
    if (/TRO,\\d+,(rudder|stern|bow)/.test(line)) window.sent.push(line);
    WebSocket.prototype.send.call(this, line);
}; }"""


@pytest.fixture
def opened(
    kept: Look,
    instructor: Caller,  # noqa: ARG001  who takes the boat to its start
) -> Opened:
    """Return a function that shows the page of a station, whose boat is as at its start."""

    def show(name: str, size: tuple[int, int] = PHONE) -> Page:
        page = kept(name)
        page.set_viewport_size({"width": size[0], "height": size[1]})
        for lever in page.locator("order-lever").all():
            mode = page.locator(f"[data-mode={lever.get_attribute('name')}]")
            expect(mode).not_to_have_text("by hand")
        expect(page.locator("order-lever .knob").first).not_to_be_empty()
        page.evaluate(SENT)
        hear_all(page)
        return page

    return show


class Finger:
    """One finger on the glass, by the events that a touch screen sends."""

    def __init__(self, page: Page) -> None:
        """Lay a finger on a page."""
        self.session = page.context.new_cdp_session(page)

    def send(self, kind: str, *places: tuple[float, float]) -> None:
        """Send one event of a touch screen."""
        points = [{"x": x, "y": y, "id": 1} for x, y in places]
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    @contextmanager
    def down(self, x: float, y: float) -> Iterator[None]:
        """Hold a finger down at a place while the block lasts."""
        self.send("touchStart", (x, y))
        try:
            yield
        finally:  # else it stays on a page that others get, and they fail too
            self.send("touchEnd")


def box_of(found: Locator) -> dict[str, float]:
    """Return where something is."""
    box = found.bounding_box()
    assert box
    return {"x": box["x"], "y": box["y"], "width": box["width"], "height": box["height"]}


def knob_of(page: Page, lever: str) -> Locator:
    return page.locator(f"order-lever[name={lever}] .knob")


def standing(page: Page, lever: str) -> int:
    """Return what a lever stands at [deg]."""
    return int(knob_of(page, lever).get_attribute("aria-valuenow") or 0)


def travel(page: Page, lever: str) -> float:
    """Return how far the knob goes from one stop to the other [px]."""
    return float(page.evaluate(f"2 * document.querySelector('order-lever[name={lever}]').fan.half"))


@each_lever
def test_a_finger_at_the_knobs_edge_orders_nothing_and_keeps_its_place(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened(PAGE_OF[lever])
    before, finger = standing(page, lever), Finger(page)
    knob, a_degree = box_of(knob_of(page, lever)), travel(page, lever) / 60.0
    x, y = knob["x"] + knob["width"] - 3.0, knob["y"] + 3.0
    with finger.down(x, y):
        page.wait_for_timeout(500)  # longer than a hold on the groove waits
        assert page.evaluate("sent") == []
        assert standing(page, lever) == before
        along = 12 * a_degree
        for part in range(1, 7):  # towards right, or rise
            step = along * part / 6.0
            finger.send("touchMove", (x + step, y) if lever == "rudder" else (x, y - step))
        wanted = pytest.approx(before + 12, abs=1)
        await_that(lambda: standing(page, lever) == wanted)
    await_truth(instructor, f"{CHANNELS[lever]}.ordered_{lever}", f"{standing(page, lever):.1f}")
    assert len(page.evaluate("sent")) >= 1


@each_lever
def test_a_touch_that_leaves_the_knob_where_it_was_takes_no_surface_by_hand(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened(PAGE_OF[lever])
    knob = box_of(knob_of(page, lever))
    page.touchscreen.tap(knob["x"] + knob["width"] - 2.0, knob["y"] + knob["height"] / 2.0)
    assert page.evaluate("sent") == []
    await_truth(instructor, f"{CHANNELS[lever]}.{lever}_mode", "auto")


@each_lever
def test_a_tap_on_the_groove_steps_towards_it(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened(PAGE_OF[lever])
    knob_of(page, lever).press("Home")
    for share, wanted in ((0.95, STEP), (0.95, 2 * STEP), (0.05, STEP)):
        page.touchscreen.tap(*on_groove(page, lever, share))
        await_truth(instructor, f"{CHANNELS[lever]}.ordered_{lever}", f"{wanted:.1f}")
        assert standing(page, lever) == wanted
    page.wait_for_timeout(500)  # and no further, by itself
    assert standing(page, lever) == STEP


@each_lever
def test_a_hold_on_the_groove_makes_the_lever_go_to_the_finger(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened(PAGE_OF[lever])
    knob_of(page, lever).press("Home")
    x, y = on_groove(page, lever, 0.8)
    with Finger(page).down(x, y):

        def off() -> float:
            knob = box_of(knob_of(page, lever))
            middle = knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2
            return abs(middle[0] - x if lever == "rudder" else middle[1] - y)

        await_that(lambda: off() < travel(page, lever) / 60.0)
        page.wait_for_timeout(300)  # it is there
        assert off() < travel(page, lever) / 60.0
        arrived = standing(page, lever)
    assert arrived > 12
    await_truth(instructor, f"{CHANNELS[lever]}.ordered_{lever}", f"{arrived:.1f}")
    assert standing(page, lever) == arrived


@each_lever
def test_fine_keys_at_both_ends_move_a_degree_and_go_on_while_they_are_held(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened(PAGE_OF[lever])
    knob_of(page, lever).press("Home")
    place = f"{CHANNELS[lever]}.ordered_{lever}"
    for end, share, way in (("high", 1.0, 1), ("low", 0.0, -1)):
        key = page.locator(f"order-lever[name={lever}] .fine.{end}")
        box, (x, y) = box_of(key), on_groove(page, lever, share)
        assert min(box["width"], box["height"]) >= 48.0
        aside = max(box["x"] - x, x - box["x"] - box["width"], 0.0)
        below = max(box["y"] - y, y - box["y"] - box["height"], 0.0)
        assert max(aside, below) < 64.0, f"the {end} key is at the groove's end"
        key.tap()
        await_truth(instructor, place, f"{way:.1f}")
        key.press("Enter")
        await_truth(instructor, place, f"{2 * way:.1f}")
        with Finger(page).down(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2):
            await_that(lambda: way * standing(page, lever) > 3)  # noqa: B023
        held = standing(page, lever)
        assert 3 < way * held < 12
        await_truth(instructor, place, f"{held:.1f}")
        knob_of(page, lever).press("Home")
        await_truth(instructor, place, "0.0")


@each_lever
def test_the_figure_stands_above_the_thumb_while_it_holds(opened: Opened, lever: str) -> None:
    page = opened(PAGE_OF[lever])
    figure = page.locator(f"order-lever[name={lever}] .figure")
    expect(figure).to_be_hidden()
    knob = box_of(knob_of(page, lever))
    x, y = knob["x"] + knob["width"] / 2, knob["y"] + knob["height"] / 2
    finger = Finger(page)
    with finger.down(x, y):
        finger.send("touchMove", (x + 60, y) if lever == "rudder" else (x, y - 60))
        expect(figure).to_be_visible()
        expect(figure).to_contain_text(str(abs(standing(page, lever))))
        shown, moved = box_of(figure), box_of(knob_of(page, lever))
        assert shown["y"] + shown["height"] <= moved["y"] - 8.0
        assert shown["y"] >= 0.0
        size = figure.evaluate("(each) => parseFloat(getComputedStyle(each).fontSize)")
        assert size >= 16.0
    expect(figure).to_be_hidden()


def await_shown(page: Page, faults: str, where: object) -> None:
    """Await that a page has none of these faults; it is laid out a moment after a change."""
    await_that(lambda: page.evaluate(faults) == [], lambda: f"{where}: {page.evaluate(faults)}")


# The lengths of grooves that are too short [px].
GROOVES: Final = """() => [...document.querySelectorAll("order-lever")]
  .filter((each) => each.checkVisibility()).map((each) => {
    const { width, height } = each.querySelector(".groove").getBoundingClientRect();
    return Math.max(width, height);
  }).filter((each) => each < 300)"""


# How far a page goes on below the screen [px].
BELOW: Final = """() => [document.documentElement.scrollHeight - innerHeight]
  .filter((each) => each > 0)"""


ENDS: Final = """(keys) => keys.map((each) => getComputedStyle(each, "::after").content)
  .map((text) => text === "none" ? "" : text.slice(1, -1))"""


@pytest.mark.parametrize("name", ["helm", "planes", "pilot", "trainee"])
def test_grooves_are_three_hundred_pixels_long_on_a_phone_and_telegraphs_have_large_keys(
    instructor: Caller, kept: Look, name: str
) -> None:
    page = kept(name)
    for key in page.locator("#close-briefing:visible").all():
        key.click()
    if name != "planes":
        see_telegraph(page)
    for words in ("order course 45", "order depth 70"):  # which take room until they are repeated
        assert instructor.ask(words)[0]
    expect(page.locator("repeat-bar button")).to_be_visible()
    halves = page.locator("part-keys[part=half] button")
    for width, height in (PHONE, (360, 640), (844, 390)):
        page.set_viewport_size({"width": width, "height": height})
        for part in range(min(halves.count(), 2) or 1):  # to steer, to dive
            if halves.count():
                halves.nth(part).evaluate("(each) => each.click()")
            expect(page.locator("order-lever:visible")).not_to_have_count(0)
            await_shown(page, GROOVES, (width, height, part))
            await_shown(page, BELOW, (width, height, part))


def see_telegraph(page: Page) -> None:
    """See that each bell has a key of forty pixels on a phone on its side."""
    for width, height in ((844, 390), (640, 360)):
        page.set_viewport_size({"width": width, "height": height})
        keys = page.locator("order-telegraph button")
        expect(keys).to_have_count(9)
        for key in keys.all():
            box = box_of(key)
            assert min(box["height"], box["width"]) >= 40, (width, height, box)
            assert box["y"] + box["height"] <= height
        assert keys.evaluate_all(ENDS) == [""] * 6 + ["\u2193"] * 3  # which bells are astern


each_plane = pytest.mark.parametrize("lever", sample_cases(["stern", "bow"], "stern"))


@each_plane
def test_a_phone_on_its_side_has_the_planes_levers_across_and_rise_to_the_right(
    instructor: Caller, opened: Opened, lever: str
) -> None:
    page = opened("planes", (844, 390))
    knob = knob_of(page, lever)
    expect(knob).to_have_attribute("aria-orientation", "horizontal")
    knob.press("Home")
    box, along = box_of(knob), 12 * travel(page, lever) / 60.0
    x, y = box["x"] + 3.0, box["y"] + 3.0
    finger = Finger(page)
    with finger.down(x, y):
        for part in range(1, 7):
            finger.send("touchMove", (x + along * part / 6.0, y))
        await_that(lambda: abs(standing(page, lever) - 12) <= 1, lambda: str(standing(page, lever)))
    ordered = standing(page, lever)
    await_truth(instructor, f"diving.ordered_{lever}", f"{ordered:.1f}")
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    expect(knob).to_have_attribute("aria-orientation", "vertical")
    assert standing(page, lever) == ordered


ARROWS: Final = """() => [...document.querySelectorAll("order-lever .fine")]
  .filter((each) => each.checkVisibility()).filter((each) => {
    const [key, arrow] = [each, each.firstElementChild].map((part) => part.getBoundingClientRect());
    const within = arrow.left >= key.left && arrow.right <= key.right
      && arrow.top >= key.top && arrow.bottom <= key.bottom;
    return !within || arrow.width < 5;
  }).map((each) => each.className)"""


# Where the scale of a dial and the knob of its lever stand, by angles; set and read at one moment.
SCALE: Final = """(name) => {
  const lever = document.querySelector(`order-lever[name=${name}]`);
  const dial = lever.querySelector("angle-dial");
  const place = (part, x, y) => {
    const at = new DOMPoint(x, y).matrixTransform(part.getScreenCTM());
    return [at.x, at.y];
  };
  const ticks = [...dial.querySelectorAll(".tick:not(.minor)")].map((tick) =>
    place(tick, tick.x1.baseVal.value, tick.y1.baseVal.value));
  const pointer = dial.querySelector(".pointer");
  const found = [-30, -20, -10, 0, 10, 20, 30].map((angle, at) => {
    lever.set(angle);
    dial.show(angle);
    const knob = lever.querySelector(".knob").getBoundingClientRect();
    return {
      tick: ticks[at],
      pointer: place(pointer, 0, 0),
      knob: [knob.x + knob.width / 2, knob.y + knob.height / 2],
    };
  });
  const panel = lever.closest("section").getBoundingClientRect();
  return { found, panel: [panel.width, panel.height] };
}"""


@pytest.mark.parametrize("size", FOUR)
def test_the_rudders_lever_is_the_lower_rim_of_an_arc_across_the_panel_on_one_scale(
    opened: Opened, size: tuple[int, int]
) -> None:
    seen = opened("helm", size).evaluate(SCALE, "rudder")
    found, (wide, _) = seen["found"], seen["panel"]
    for each in found:
        assert each["knob"][0] == pytest.approx(each["tick"][0], abs=1.0)
        assert each["pointer"][0] == pytest.approx(each["tick"][0], abs=1.5)
        below = each["knob"][1] - each["tick"][1]
        assert below == pytest.approx(found[3]["knob"][1] - found[3]["tick"][1], abs=1.5)
        assert below > 24.0  # the knob does not cover the scale
    assert found[-1]["tick"][0] - found[0]["tick"][0] >= 0.75 * wide
    assert found[3]["tick"][1] > found[0]["tick"][1] + 30.0  # an arc, not a ruler
    steps = [b["tick"][0] - a["tick"][0] for a, b in pairwise(found)]
    assert max(steps) - min(steps) < 1.0


@each_plane
@pytest.mark.parametrize("size", FOUR)
def test_the_planes_lever_lies_on_the_chord_of_its_dial_twice_as_large_as_it_was(
    opened: Opened, lever: str, size: tuple[int, int]
) -> None:
    seen = opened("planes", size).evaluate(SCALE, lever)
    found, (_, high) = seen["found"], seen["panel"]
    for each in found:
        assert each["knob"][1] == pytest.approx(each["tick"][1], abs=1.0)
        assert each["pointer"][1] == pytest.approx(each["tick"][1], abs=1.5)
        assert each["knob"][0] == pytest.approx(found[0]["knob"][0], abs=0.5)  # a straight groove
    assert found[0]["tick"][0] == pytest.approx(found[-1]["tick"][0], abs=0.5)  # beside a chord
    bulge = abs(found[3]["tick"][0] - found[0]["tick"][0])
    assert bulge > (3.0 if size == PHONE else 20.0)
    chord = found[0]["tick"][1] - found[-1]["tick"][1]
    assert chord >= 0.45 * high
    assert chord >= 262.0  # [px] the dial's chord was 131 on a laptop of 1366 px


LARGEST: Final = """() => {
  const drawn = (each) => {
    const { width, height } = each.getBoundingClientRect();
    const view = each.viewBox.baseVal;
    return view && view.width ? Math.min(width, height * view.width / view.height) : 0;
  };
  const others = [...document.querySelectorAll(".gauge > svg")].filter((each) =>
    each.checkVisibility() && !each.closest("order-lever")).map(drawn);
  const own = [...document.querySelectorAll("order-lever .groove")].map((each) =>
    each.getTotalLength());
  return [Math.min(...own), Math.max(...others)];
}"""


@pytest.mark.parametrize("name", sample_cases(["helm", "planes"], "helm"))
def test_the_own_control_is_the_biggest_instrument_of_its_page(opened: Opened, name: str) -> None:
    for size in (*SIX, (768, 1024)):
        page = opened(name, size)
        own, other = page.evaluate(LARGEST)
        assert own > other, f"{name} at {size}: {own:.0f} px, another {other:.0f} px"


# Each text that is seen, with its size on the glass: the scale of an SVG counts.
TEXTS: Final = """() => {
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode.parentElement;
    const words = walker.currentNode.data.trim();
    const seen = { visibilityProperty: true, opacityProperty: true };
    if (!words || node.closest(".unseen, option, script, template")) continue;
    if (!node.checkVisibility(seen)) continue;
    const { width, height } = node.getBoundingClientRect();
    if (width < 2 || height < 2) continue;
    let size = parseFloat(getComputedStyle(node).fontSize);
    if (node.closest("svg")) {
      const { a, b, c, d } = node.getScreenCTM();
      size *= Math.min(Math.hypot(a, b), Math.hypot(c, d));
    }
    found.push([size, words]);
  }
  return found;
}"""


def parts_of(page: Page) -> int:
    """Return how many parts a page has of which it shows one at a time, at least one."""
    keys = "part-keys:not([part=group]) button:visible, #tabs button:visible"
    return max(page.locator(keys).count(), 1)


def show_part(page: Page, part: int) -> None:
    """Show one of the parts of a page."""
    keys = page.locator("part-keys:not([part=group]) button:visible, #tabs button:visible")
    if keys.count():
        keys.nth(part).evaluate("(each) => each.click()")


NEXT_FRAMES: Final = (
    "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
)


def small_texts(page: Page) -> list[Any]:
    """Return the texts that are too small, once the page is laid out and tells scales anew."""
    end = time.monotonic() + 5.0
    while True:
        page.evaluate(NEXT_FRAMES)
        texts: list[Any] = page.evaluate(TEXTS)
        assert texts
        small = [each for each in texts if each[0] < LEAST_TEXT_PX]
        if not small or time.monotonic() > end:
            return small[:5]


@pytest.mark.usefixtures("instructor")
@pytest.mark.parametrize(
    "name", sample_cases([page.name for page in PAGES], "trainee"), ids=lambda name: name or "first"
)
def test_no_drawn_text_is_small_and_each_fine_key_has_its_arrow_inside_it_at_any_size(
    shared: Served, look: Look, name: str
) -> None:
    page = look(shared, name)
    expect(page.locator("[data-state=connecting]")).to_have_count(0)
    for width, height in LOOKED_AT:
        page.set_viewport_size({"width": width, "height": height})
        for part in range(parts_of(page)):
            show_part(page, part)
            assert not small_texts(page), f"{name} at {width}x{height}, part {part}"
            await_shown(page, ARROWS, (width, height, part))


# Pointers that touch words of their instrument, and words that touch others, all over its range.
TOUCHED: Final = """() => {
  const ranges = { "angle-dial": [-30, 30], "depth-gauge": [0, 300], "pitch-gauge": [-30, 30],
    "course-ring": [0, 357] };
  const found = new Set();
  const words = (gauge) => [...gauge.querySelectorAll("text")]
    .filter((each) => each.textContent && each.checkVisibility()).map((each) => {
      const box = each.getBBox();
      const wide = each.getComputedTextLength() / 2;
      const high = 0.34 * parseFloat(getComputedStyle(each).fontSize); // half of a digit
      const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
      const back = each.getScreenCTM().inverse();
      return { each, back, left: x - wide, right: x + wide, top: y - high, bottom: y + high };
    });
  const see = (gauge) => {
    const seen = words(gauge);
    for (const pointer of gauge.querySelectorAll(".pointer")) {
      if (!pointer.checkVisibility()) continue;
      const [long, matrix] = [pointer.getTotalLength(), pointer.getScreenCTM()];
      for (let at = 0; at < long; at += long / 24) {
        const place = pointer.getPointAtLength(at).matrixTransform(matrix);
        for (const { each, back, left, right, top, bottom } of seen) {
          const { x, y } = place.matrixTransform(back);
          if (x > left && x < right && y > top && y < bottom) {
            found.add(`${gauge.tagName} ${gauge.id}: pointer on ${each.textContent}`);
          }
        }
      }
    }
    const level = seen.filter(({ each }) => !each.closest("[transform]")); // but a ring's, turned
    level.forEach((one, at) => level.slice(at + 1).forEach((other) => {
      const across = one.left < other.right && other.left < one.right;
      if (across && one.top < other.bottom && other.top < one.bottom) {
        const texts = [one, other].map(({ each }) => each.textContent);
        found.add(`${gauge.tagName} ${gauge.id}: ${texts.join(" on ")}`);
      }
    }));
  };
  for (const [tag, [low, high]] of Object.entries(ranges)) {
    for (const gauge of document.querySelectorAll(tag)) {
      if (!gauge.checkVisibility()) continue;
      for (let at = 0; at <= 30; at += 1) {
        const value = low + ((high - low) * at) / 30;
        gauge.wrote = -Infinity; // digits change at once
        gauge.show(value, Math.round(value));
        see(gauge);
      }
    }
  }
  return [...found].slice(0, 9);
}"""


# The size of each numeral of an arc, and that which the arc is laid out for.
ARC_NUMERALS: Final = """() => [...document.querySelectorAll("angle-dial .numeral")]
  .filter((each) => each.checkVisibility())
  .map((each) => [each, each.closest("angle-dial")]
    .map((one) => parseFloat(getComputedStyle(one).fontSize)))"""


@pytest.mark.usefixtures("instructor")
@pytest.mark.parametrize(
    "name", sample_cases(["helm", "planes", "trainee", "diving", "observer"], "helm")
)
def test_no_needle_lies_on_a_numeral_and_no_word_on_another_and_numerals_have_their_size(
    shared: Served, look: Look, name: str
) -> None:
    page = look(shared, name)
    expect(page.locator("#state")).to_have_text("FROZEN")
    for width, height in (*SIX, (3840, 2160)):
        page.set_viewport_size({"width": width, "height": height})
        for part in range(parts_of(page)):
            show_part(page, part)
            await_shown(page, TOUCHED, (width, height, part))
            sizes = page.evaluate(ARC_NUMERALS)
            assert sizes or name != "helm"
            for numeral, around in sizes:
                assert numeral == pytest.approx(max(11.5, 0.8 * around), abs=0.01), (width, height)


CHARTS: Final = """() => [...document.querySelectorAll("strip-chart")]
  .filter((each) => each.checkVisibility()).map((each) => {
    const box = each.getBoundingClientRect();
    const room = each.closest(".fill").getBoundingClientRect();
    const canvas = each.querySelector("canvas").getBoundingClientRect();
    const { left, right } = each.frame(each.begin(), each.series);
    each.draw();
    return { row: Math.round(box.top), left: box.left - room.left, right: room.right - box.right,
      canvas: canvas.width / box.width, plot: (right - left) / box.width, wide: box.width };
  })"""


@pytest.mark.slow
@pytest.mark.parametrize("vessel", sample_cases(["bb2", "sdv-mk9"], "bb2"))
def test_charts_are_as_wide_as_their_panel(serve: Serve, look: Look, vessel: str) -> None:
    served = serve("--vessel", vessel)
    page = look(served, "instructor")
    window = page.locator("#exercise")
    expect(window).to_be_visible()  # it opens by itself at the start
    window.evaluate("(each) => each.close()")
    expect(window).to_be_hidden()
    see_wide(page)
    see_wide(look(served, "observer"))


def see_wide(page: Page) -> None:
    """See that charts are as wide as their panel on any screen."""
    for width, height in (*SIX, (768, 1024)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.locator("[data-state=connecting]")).to_have_count(0)
        words = page.get_by_role("button", name="Charts", exact=True)
        if words.count() and words.is_visible():
            words.click()
        page.wait_for_function("() => document.querySelector('strip-chart')?.series")
        page.wait_for_timeout(700)
        charts = page.evaluate(CHARTS)
        assert len(charts) >= 4
        for row in {each["row"] for each in charts}:
            beside = [each for each in charts if each["row"] == row]
            assert min(each["left"] for each in beside) < 2.0
            assert min(each["right"] for each in beside) < 2.0, f"{width}x{height}"
        for each in charts:
            assert each["canvas"] == pytest.approx(1.0, abs=0.02)
            assert each["plot"] > 0.7, (width, height, each)  # the rest is figures at the axes
