"""The kiosk: a visitor who knows nothing dives, and the next finds it as the first did."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from helpers.browser import Look
from helpers.hands import UNWORKED, WAYS, see_whole, skip_until, stop_clock, work
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served, served
from helpers.slow_line import slow_line
from helpers.waiting import await_that
from playwright.sync_api import Locator, Page, expect
from playwright.sync_api import TimeoutError as Late
from soak.session_process import Caller

from trainer.config.files import ConfigError
from trainer.web.words import read_catalogue

ROOMS = [*(SIZES[name] for name in ("desk", "tablet", "phone", "phone-side")), (1080, 1920)]
STEP = 5  # [deg] of a tap on the groove
FAST = 7.0  # times faster than the clock: what is late on a busy machine is not late for the boat
FASTER = 10.0  # where nobody steers
TOUCH_MS = 3000.0  # [ms] in which he reaches a key
TARGET = 60  # [m] as the page says
ORDERED_BOW = 8  # place of ordered_bow in the channel diving
SEEN = """() => {
  const text = (id) => document.getElementById(id).textContent;
  const box = (place) => document.querySelector(place).getBoundingClientRect().toJSON();
  const slider = "order-lever [role=slider]";
  return {scene: document.body.dataset.scene, task: text("task") || "Wait",
          depth: Number(text("depth")), angle: Number(text("angle")),
          at: Number(document.querySelector(slider).getAttribute("aria-valuenow")),
          knob: box(slider), lever: box("order-lever")};
}"""
CUT = """() => [...document.querySelectorAll("main *")].filter((each) => {
  const box = each.getBoundingClientRect();
  if (!box.width || each.closest("svg") || each.tagName === "BOAT-SIDE") return false;
  const style = getComputedStyle(each);
  if (style.clipPath !== "none" || style.visibility === "hidden") return false;
  return box.left < -1 || box.top < -1 || box.right > innerWidth + 1 || box.bottom > innerHeight + 1
    || (style.overflowX === "visible" ? false : each.scrollWidth > each.clientWidth + 1);
}).map((each) => each.outerHTML.slice(0, 80))"""

# A visitor who touches something each second, for whom the kiosk goes on.
TOUCHES = "() => setInterval(() => dispatchEvent(new Event('pointerdown')), 1000)"

OVERLAID = """() => {
  const box = (place) => document.querySelector(place).getBoundingClientRect();
  const [task, panel] = [".task", ".instruments"].map(box);
  const beside = task.right <= panel.left || task.left >= panel.right;
  return !beside && task.bottom > panel.top && task.top < panel.bottom;
}"""


@dataclass
class Kiosk:
    """A session with the visitor's exercise, and its instructor."""

    session: Served
    instructor: Caller

    def order(self, words: str) -> None:
        done, why = self.instructor.ask(words)
        assert done, why

    def read(self, channel: str) -> tuple[str, ...]:
        """Return the latest fields of a channel."""
        self.order("who")
        return self.instructor.shown[channel][2:]


@pytest.fixture(scope="module")
def shared_kiosk() -> Iterator[Kiosk]:
    with served("visitor-dive") as session:
        made = Kiosk(session, session.attach())
        for channel in ("gauges", "diving"):
            made.order(f"subscribe {channel} at 2 hz")
        yield made


@pytest.fixture
def kiosk(shared_kiosk: Kiosk) -> Iterator[Kiosk]:
    """Return the kiosk at the speed of the clock."""
    shared_kiosk.order("time x1")
    yield shared_kiosk
    shared_kiosk.order("time x1")


def scene(page: Page, name: str) -> None:
    expect(page.locator("body")).to_have_attribute("data-scene", name)


def slider(page: Page) -> Locator:
    return page.locator("order-lever [role=slider]")


def touch_lever(page: Page, seen: dict[str, Any], wanted: int) -> None:
    """Touch the groove beyond the knob, or a fine key where the knob is nearly there."""
    lever, knob = seen["lever"], seen["knob"]
    way = 1 if wanted > seen["at"] else -1
    if abs(wanted - seen["at"]) < STEP:
        with suppress(Late):  # the dive may end under his finger, and the key is gone
            page.locator(f"order-lever .fine.{'high' if way > 0 else 'low'}").tap(timeout=TOUCH_MS)
        return
    y = knob["y"] + knob["height"] / 2.0 - way * (knob["height"] / 2.0 + 12.0)
    y = min(max(y, lever["y"] + 1), lever["y"] + lever["height"] - 1)
    page.touchscreen.tap(knob["x"] + knob["width"] / 2.0, y)


def put_lever(page: Page, wanted: int) -> None:
    """Touch towards where the lever is wanted, again and again by where it went."""
    for _ in range(20):
        if (seen := page.evaluate(SEEN))["at"] == wanted:
            return
        touch_lever(page, seen, wanted)
    raise AssertionError


# Where a visitor puts the lever who reads a sentence, by depth [m] and angle [deg].
DOES: dict[str, Callable[[int, int], int]] = {
    "Push the lever down": lambda _, __: -8,
    "Good": lambda _, angle: -8 if angle < 9 else 0,
    "Steep enough": lambda _, __: 3,
    "Now lift early": lambda _, __: 8,
    "Almost there": lambda _, __: -3,
    "Hold": lambda depth, _: -3 if depth < TARGET else 3 if depth > TARGET else 0,
    "Too deep": lambda _, __: 8,
    "It comes up": lambda _, __: 0,
}


def obey(page: Page, seen: dict[str, Any]) -> None:
    """Do what the sentence says."""
    for opening, does in DOES.items():
        if seen["task"].startswith(opening):
            wanted = does(seen["depth"], seen["angle"])
            if abs(wanted - seen["at"]) > 1:  # no visitor hits a degree
                touch_lever(page, seen, wanted)


@pytest.mark.alone  # the visitor sees the boat as late as the page draws it
def test_a_visitor_who_does_what_the_page_says_holds_sixty_metres(kiosk: Kiosk, look: Look) -> None:
    page = look(kiosk.session, "kiosk", size="tablet", has_touch=True)
    expect(page.locator("#challenge")).to_contain_text("70 metres long, 4,400 tonnes")
    kiosk.order(f"time x{FAST:g}")

    page.locator("#start").tap()
    scene(page, "dive")
    said = set()
    end = time.monotonic() + 300.0
    while (seen := page.evaluate(SEEN))["scene"] == "dive":
        assert time.monotonic() < end
        said.add(seen["task"].split()[0])
        obey(page, seen)

    assert said >= {"Push", "Good.", "Now"}
    expect(page.locator("#verdict")).to_have_text("You held 60 metres")
    assert float(kiosk.read("gauges")[0]) == pytest.approx(TARGET, abs=6.0)
    expect(page.locator("#nobody")).to_contain_text("Back to the start in")
    assert len((page.locator("#trace .way").get_attribute("points") or "").split()) > 200


def test_a_lever_held_down_is_taken_and_given_back_before_ninety_metres(
    kiosk: Kiosk, look: Look
) -> None:
    page = look(kiosk.session, "kiosk", size="tablet", has_touch=True)
    kiosk.order(f"time x{FASTER:g}")
    page.locator("#start").click()
    scene(page, "dive")
    slider(page).press("Home")
    for _ in range(4):
        slider(page).press("Shift+ArrowDown")

    expect(page.locator("#task")).to_contain_text("levels by itself")
    expect(page.locator("#task")).not_to_contain_text("levels by itself")
    kiosk.order("time x1")

    assert 60.0 < float(kiosk.read("gauges")[0]) < 90.0
    put_lever(page, -3)
    await_that(lambda: float(kiosk.read("diving")[ORDERED_BOW]) == -3.0)
    kiosk.order("end exercise")
    expect(page.locator("#verdict")).to_have_text("You went past 60 metres")


@pytest.mark.parametrize("way", WAYS)
def test_each_key_is_worked_each_way(kiosk: Kiosk, look: Look, way: str) -> None:
    page = look(kiosk.session, "kiosk", has_touch=True)
    html = page.locator("html")
    for language in ("de", "en"):
        work(page, page.locator("#language"), way)
        expect(html).to_have_attribute("lang", language)
    work(page, page.locator("#start"), way)
    scene(page, "dive")
    work(page, page.locator("#stop"), way)
    scene(page, "attract")
    work(page, page.locator("#start"), way)
    scene(page, "dive")
    kiosk.order("end exercise")
    scene(page, "result")
    expect(page.locator("#again")).to_be_focused()  # the key that is offered
    work(page, page.locator("#again"), way)
    scene(page, "dive")
    work(page, page.locator("#stop"), way)
    scene(page, "attract")
    assert page.evaluate(UNWORKED) == []


def test_who_does_nothing_for_45_seconds_is_not_waited_for(kiosk: Kiosk, look: Look) -> None:
    page = look(kiosk.session)
    page.clock.install()
    page.goto(f"{kiosk.session.url}/kiosk")
    page.locator("#start").click()
    scene(page, "dive")
    page.locator("#language").click()
    expect(page.locator("#stop")).to_have_text("Ende")
    kiosk.order("freeze")
    expect(page.locator("#task")).to_contain_text("Die Zeit steht")

    stop_clock(page)
    slider(page).press("ArrowDown")  # from here on, exactly
    page.clock.run_for(43_000)
    scene(page, "dive")
    slider(page).press("ArrowDown")
    page.clock.run_for(43_000)
    scene(page, "dive")
    page.clock.run_for(3_000)

    scene(page, "attract")
    expect(page.locator("#start")).to_have_text("Start the dive")  # the first language again


def test_a_result_is_shown_for_20_seconds(kiosk: Kiosk, look: Look) -> None:
    page = look(kiosk.session)
    page.clock.install()
    page.goto(f"{kiosk.session.url}/kiosk")
    page.locator("#start").click()
    scene(page, "dive")
    kiosk.order("end exercise")
    scene(page, "result")
    stop_clock(page)
    nobody = page.locator("#nobody")
    expect(nobody).to_contain_text(re.compile(r"in \d+$"))
    left = int(str(nobody.text_content()).rpartition(" ")[2])
    page.clock.run_for(1000 * (left - 2))
    expect(nobody).to_contain_text(re.compile(r"in [123]$"))
    page.clock.run_for(3_000)
    scene(page, "attract")


def test_a_lost_line_is_told_kindly_and_the_kiosk_comes_back(kiosk: Kiosk, look: Look) -> None:
    with slow_line(kiosk.session.port) as line:
        session = replace(kiosk.session, port=line.own_port)
        page = look(session)
        page.clock.install()
        page.goto(f"{line.url}/kiosk?lang=de")
        expect(page.locator("#challenge")).to_contain_text("70 Meter lang, 4.400 Tonnen")
        page.locator("#start").click()
        scene(page, "dive")
        line.cut()
        expect(page.locator(".waiting")).to_be_visible()
        expect(page.locator(".waiting")).to_contain_text("kommt von selbst zurück")
        skip_until(page, page.locator(".waiting").is_hidden)  # it is dialled again
        if page.locator("body").get_attribute("data-scene") == "dive":
            page.locator("#stop").click()
        page.locator("#start").click()
        scene(page, "dive")


@pytest.mark.parametrize("language", sample_cases(["en", "de"], "de"))
def test_nothing_is_cut_at_any_size(kiosk: Kiosk, look: Look, language: str) -> None:
    page = look(kiosk.session, "kiosk", query=f"?lang={language}")
    page.evaluate(TOUCHES)  # a part that is cut is waited for longer than the kiosk waits

    for name in ("attract", "dive", "result"):
        if name == "dive":
            page.locator("#start").click()
            expect(page.locator("#task")).not_to_be_empty()
        elif name == "result":
            kiosk.order("end exercise")
        scene(page, name)
        for width, height in ROOMS:
            page.set_viewport_size({"width": width, "height": height})
            see_whole(page, (name, width, height), CUT)
            assert name != "dive" or not page.evaluate(OVERLAID)
    page.locator("#language").focus()


def test_keys_are_large_and_there_is_no_word_to_type_and_nothing_to_select(
    kiosk: Kiosk, look: Look
) -> None:
    page = look(kiosk.session, "kiosk", size="phone", has_touch=True)
    for place in ("#start", "#language"):
        expect(page.locator(place)).to_be_visible()
        box = page.locator(place).bounding_box()
        assert box
        assert min(box["width"], box["height"]) >= 72.0
    assert page.locator("input:visible, textarea:visible, select:visible").count() == 0
    page.locator("#invitation").dblclick()
    assert page.evaluate("getSelection().toString()") == ""
    assert page.evaluate("getComputedStyle(document.body).touchAction") == "none"
    menu = "dispatchEvent(new MouseEvent('contextmenu', {bubbles: true, cancelable: true}))"
    assert page.evaluate(f"document.querySelector('h1').{menu}") is False


# Where there is no kiosk


def test_a_crews_session_has_no_kiosk_and_its_run_goes_on_whoever_opens_one(look: Look) -> None:
    with served("watch", frozen=False) as session:
        instructor = session.attach()
        first = look(session)
        expect(first.locator("#title")).to_have_text("A watch")
        expect(first.locator("[data-name=helm]")).to_be_visible()
        first.locator("#others summary").click()
        expect(first.locator("[data-name=wall]")).to_be_visible()
        expect(first.locator("[data-name=kiosk]")).to_be_hidden()

        page = look(session, "kiosk")
        expect(page.locator("#crewed")).to_have_text(
            "A crew sails this boat now. Please ask the instructor."
        )
        expect(page.locator("#start")).to_be_hidden()
        page.locator("#start").evaluate("(key) => key.click()")  # by whatever way
        visitor = session.attach("visitor")
        done, why = visitor.ask("restart")
        assert not done
        assert why.endswith("has visitors = true: ask the instructor")
        scene(page, "attract")
        assert instructor.ask("branches")[0]
        assert len(instructor.said) == 1  # nobody has begun another


def test_the_first_page_offers_the_kiosk_where_visitors_dive(kiosk: Kiosk, look: Look) -> None:
    page = look(kiosk.session)
    page.locator("[data-name=kiosk]").click()
    page.locator("#start").click()
    scene(page, "dive")


# The words


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('msgid "a"\nmsgstr "b"\n\nmsgid "a"\nmsgstr "c"\n', "line 4: msgid 'a': is there twice"),
        ('msgid "a {0}"\nmsgstr "b"\n', "line 1: 'b': not the holes of 'a {0}'"),
        ('msgctxt "x"\nmsgid "a"\n', "line 1: msgctxt"),
        ("msgid a\n", "line 1: msgid a: expected msgid or msgstr"),
    ],
)
def test_a_catalogue_that_is_wrong_is_refused_with_its_line(
    tmp_path: Path, text: str, reason: str
) -> None:
    path = tmp_path / "fr.po"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=re.escape(f"fr.po: {reason}")):
        read_catalogue(path)


def test_words_in_doubt_and_words_without_a_translation_stay_english(tmp_path: Path) -> None:
    path = tmp_path / "fr.po"
    path.write_text(
        'msgid ""\nmsgstr "Language: fr\\n"\n\n#, fuzzy\nmsgid "a"\nmsgstr "b"\n\n'
        'msgid "c"\nmsgstr ""\n\nmsgid ""\n"long "\n"words"\nmsgstr "longs \\"mots\\""\n'
        '#~ msgid "old"\n#~ msgstr "vieux"\n',
        encoding="utf-8",
    )
    assert read_catalogue(path) == {"long words": 'longs "mots"'}
