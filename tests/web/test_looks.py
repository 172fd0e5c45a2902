"""Every page at every size: contrast, nothing cut, keyboard, zoom, calm, and no request leaves."""

import re

import pytest
from helpers import node
from helpers.browser import Look
from helpers.contrast import contrast
from helpers.hands import TOO_WIDE, ready, see_whole
from helpers.lanes import sample_cases
from helpers.pages import PALETTES, SIZES, Served
from helpers.waiting import await_that
from playwright.sync_api import Page, expect
from soak.session_process import Caller

from trainer.web.modules import ASSETS_FOLDER
from trainer.web.pages import PAGES

NAMES = [page.name for page in PAGES]
SHORT = {"", "instructor", "scope"}  # the pages of the short run, where all would take minutes
LAID_OUT = {"", "helm", "trainee", "instructor", "ballast", "kiosk"}  # each in a way of its own
each_page = pytest.mark.parametrize(
    "name", sample_cases(NAMES, *LAID_OUT), ids=[name or "first" for name in NAMES]
)
some_pages = pytest.mark.parametrize(
    "name", sample_cases(NAMES, *SHORT), ids=[name or "first" for name in NAMES]
)

# Pairs of tokens: what is written or drawn, on what; WCAG 2.2, 1.4.3 and 1.4.11.
TEXT = 4.5
SHAPE = 3.0
ENHANCED = 7.0  # WCAG 2.2, 1.4.6
PAIRS = {
    **{(ink, ground): TEXT for ink in ("ink", "ink-2") for ground in ("page", "panel", "well")},
    **{("ink", ground): TEXT for ground in ("page", "panel", "well", "raised")},
    **{(ink, "panel"): TEXT for ink in ("ink-3", "alarm-ink", "warning-ink", "caution-ink")},
    **{("ordered", ground): TEXT for ground in ("page", "panel", "well", "deep")},
    ("actual", "well"): TEXT,
    ("on-alarm", "alarm"): TEXT,
    ("warning-ink", "raised"): TEXT,
    ("on-warning", "warning"): TEXT,
    ("on-caution", "caution"): TEXT,
    ("page", "ordered"): TEXT,
    ("page", "ink"): TEXT,
    ("edge", "panel"): SHAPE,
    ("warning-line", "well"): SHAPE,
    ("focus", "page"): SHAPE,
    ("focus", "panel"): SHAPE,
    ("hull-edge", "deep"): SHAPE,
}


def tokens(palette: str) -> dict[str, str]:
    """Return the colours of a palette, by name."""
    sheet = (ASSETS_FOLDER / "css" / "tokens.css").read_text(encoding="utf-8")
    found: dict[str, str] = {}
    for selector, block in re.findall(r"(:root[^{]*)\{([^}]*)\}", sheet):
        if "data-palette" not in selector or f'"{palette}"' in selector:
            found |= dict(re.findall(r"--([\w-]+):\s*(#[0-9a-f]{6})", block))
    return found


def test_at_night_no_alert_is_brighter_than_the_letters_of_the_page() -> None:
    night = tokens("night")
    for ground in ("alarm", "raised"):  # what fills an alarm, and a warning
        assert contrast(night[ground], night["page"]) < contrast(night["ink"], night["page"]) / 2


@pytest.mark.parametrize("palette", PALETTES)
def test_contrast_of_each_pair_of_tokens_suffices(palette: str) -> None:
    colours = tokens(palette)
    assert len(colours) > 25

    for (ink, ground), least in PAIRS.items():
        ratio = contrast(colours[ink], colours[ground])
        assert ratio >= least, f"{palette}: {ink} on {ground} is {ratio:.2f}"


def test_a_palette_for_the_sun_has_the_contrast_of_the_enhanced_rule() -> None:
    bright = tokens("bright")
    for ink in ("ink", "ink-2", "ink-3", "ordered", "alarm-ink", "warning-ink", "caution-ink"):
        for ground in ("page", "panel", "well"):
            assert contrast(bright[ink], bright[ground]) >= ENHANCED, f"{ink} on {ground}"
    assert contrast(bright["edge"], bright["panel"]) >= ENHANCED


MOVING = "document.getAnimations().filter((each) => each.playState === 'running').length"


# Language, palette and first size.
VIEWS = [
    *(("de", "dusk", "phone"), ("en", "dusk", "laptop"), ("de", "day", "laptop")),
    *(("en", "day", "phone"), ("de", "night", "phone"), ("en", "night", "laptop")),
]


@each_page
@pytest.mark.parametrize("view", sample_cases(VIEWS, VIEWS[0]), ids="-".join)
def test_a_page_has_no_barrier_and_fits_every_size(
    shared: Served, look: Look, name: str, view: tuple[str, str, str]
) -> None:
    """Of 1280 by 720 a browser's zoom of 200 % leaves 640 by 360, which is one of these."""
    language, palette, first = view
    page = look(shared, name, first, f"?lang={language}&palette={palette}")
    ready(page)
    assert page.evaluate(MOVING) == 0  # `look` asks for no motion
    page.evaluate(node.axe())  # as a tool of the browser would: no page may load it
    await_that(
        lambda: page.evaluate(node.BARRIERS) == [], lambda: page.evaluate(node.BARRIERS)
    )  # once it is drawn
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})

        for parts in (TOO_WIDE, CUT):
            see_whole(page, f"{name} at {size}", parts)


# What can be worked and lies outside the picture at its side, where nobody scrolls.
CUT = """() => [...document.querySelectorAll("button, a, input, select, [role=slider]")]
  .filter((each) => each.checkVisibility() && !each.closest(".unseen, alert-bar"))
  .filter((each) => {
    const { left, right } = each.getBoundingClientRect();
    return right > innerWidth + 1 || left < -1;
  })
  .map((each) => each.id || each.textContent)"""


# Controls that Tab should reach; of a group of choices, one.
CONTROLS = """() => {
  const all = [...document.querySelectorAll(
    "a[href], button, input, select, textarea, [tabindex]")];
  const within = (each) => each.closest("[inert], dialog:not([open])");
  const seen = (each) => each.checkVisibility({ visibilityProperty: true });  // or holds its place
  return all.filter((each) => seen(each) && !within(each) && !each.disabled
    && each.tabIndex >= 0).map((each) => {
      each.dataset.reached = "";
      return each.outerHTML.slice(0, 80);
    });
}"""
REACHED = """() => {
  const at = document.activeElement;
  const { outlineStyle, outlineWidth } = getComputedStyle(at);
  const seen = outlineStyle !== "none" && parseFloat(outlineWidth) >= 2;
  if (at !== document.body && !seen) return at.outerHTML.slice(0, 80);
  at.dataset.reached = "yes";
  const all = [...document.querySelectorAll("[data-reached='']")];
  return all.filter((each) => each.tabIndex >= 0).length;  // of a group one, by its reading
}"""


@some_pages
def test_the_keyboard_alone_reaches_every_control(shared: Served, look: Look, name: str) -> None:
    page = look(shared, name)
    ready(page)
    controls = page.evaluate(CONTROLS)
    assert controls or name == "wall"  # which nobody touches

    for _ in range(2 * len(controls)):
        page.keyboard.press("Tab")
        left = page.evaluate(REACHED)
        assert isinstance(left, int), left  # what has the focus is marked by a line around it
        if left == 0:
            return
    left = page.evaluate(
        "[...document.querySelectorAll(\"[data-reached='']\")]"
        ".filter(e => e.tabIndex >= 0).map(e => e.outerHTML)"
    )
    assert left == []


# Pictures drawn within a time [ms], and whether what is seen of the water has moved
DRAWN = """async (span) => {
  const water = () => document.querySelector("boat-side pattern")?.getAttribute("patternTransform");
  const [before, count] = [water(), { drawn: 0, moved: false }];
  const add = () => (count.drawn += 1);
  document.motion.addEventListener("frame", add);
  await new Promise((done) => setTimeout(done, span));
  document.motion.removeEventListener("frame", add);
  return { ...count, moved: water() !== before };
}"""


PRESSED = """() => setInterval(() => document.body.dispatchEvent(
  new KeyboardEvent("keydown", { key: "Shift", bubbles: true })), 200)"""


@pytest.mark.parametrize("name", sample_cases(["helm", "instructor"], "helm"))
def test_a_page_rests_in_a_freeze_and_without_motion_until_somebody_does_something(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    page = look(shared, name, reduced_motion="no-preference")
    ready(page)
    await_drawn(page, 0, 3)
    page.evaluate(PRESSED)
    await_drawn(page, 6, 99)  # of twenty, on a machine that has other work
    page.reload()
    ready(page)
    assert instructor.ask("run")[0]
    await_drawn(page, 6, 99, moved=name == "instructor")

    page.emulate_media(reduced_motion="reduce")
    page.reload()
    ready(page)
    await_drawn(page, 1, 6)  # in two ticks
    page.evaluate(PRESSED)
    await_drawn(page, 11, 99)


def await_drawn(page: Page, least: int, most: int, *, moved: bool = False) -> None:
    """Wait for a second in which a page draws so many pictures, and its water moves or not."""

    def is_drawn() -> bool:
        found = page.evaluate(DRAWN, 1000)
        return least <= found["drawn"] <= most and found["moved"] is moved

    await_that(is_drawn, lambda: page.evaluate(DRAWN, 1000))


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_first_palette_is_the_browser_s_and_then_the_user_s(
    shared: Served, look: Look, scheme: str
) -> None:
    page = look(shared, "helm", color_scheme=scheme)
    palette = page.locator("#palette")
    expect(palette).to_have_value("day" if scheme == "light" else "dusk")

    palette.select_option("night")
    page.reload()

    expect(page.locator(":root")).to_have_attribute("data-palette", "night")
