"""Hands on a page, three ways, and the truth about the boat from its session."""

from collections.abc import Callable
from typing import Final

from playwright.sync_api import Locator, Page, expect
from soak.session_process import Caller

from helpers.lanes import sample_cases
from helpers.waiting import await_that, eventually
from trainer.session.stations.channels import CHANNELS

LEAP_S: Final = 5.0  # to a moment that is not yet over when the page hears of it
EACH_WAY: Final = ("mouse", "touch", "keyboard")
WAYS: Final = sample_cases(EACH_WAY, "keyboard")  # clicked is in all other tests

# Where something on a page is wider or higher than its place, or lies beyond the window.
CUT: Final = """() => {
  const found = [];
  const { scrollWidth, scrollHeight } = document.documentElement;
  if (scrollWidth > innerWidth || scrollHeight > innerHeight) found.push("the page");
  for (const each of document.querySelectorAll("main *")) {
    if (!each.checkVisibility() || each.closest("svg, .unseen")) continue;
    const [box, style] = [each.getBoundingClientRect(), getComputedStyle(each)];
    const name = `${each.tagName} ${each.className} ${each.id} ${each.textContent}`.slice(0, 80);
    const wide = each.scrollWidth > each.clientWidth + 1 && each.clientWidth > 0;
    const high = each.scrollHeight > each.clientHeight + 1 && each.clientHeight > 0;
    const rolls = ["auto", "scroll"].includes(style.overflowY);
    if (wide && style.textOverflow !== "ellipsis" && style.display !== "inline") found.push(name);
    if (high && !rolls && style.display !== "inline" && !wide) found.push(name);
    if (each.matches("button, input") && box.right > innerWidth + 1) found.push(name);
  }
  return found;
}"""

# Where a page is wider than the window.
TOO_WIDE: Final = """() => {
  const { scrollWidth } = document.documentElement;
  return scrollWidth > innerWidth ? [`${scrollWidth} px`] : [];
}"""


def see_whole(page: Page, where: object, cut_parts: str = CUT) -> None:
    """Await that nothing of a page is cut; a page is laid out anew a moment after a change."""
    await_that(lambda: page.evaluate(cut_parts) == [], lambda: (where, page.evaluate(cut_parts)))


STANDS: Final = """() => {
  const all = document.querySelectorAll("*").length;
  if (window.counted !== all) [window.counted, window.since] = [all, performance.now()];
  const keys = [...document.querySelectorAll("part-keys")];  // some are of what a boat has
  return keys.every((each) => each.childElementCount) && performance.now() - window.since > 300;
}"""  # all that the first readings build is there


def ready(page: Page) -> None:
    """Wait until a page shows a session."""
    expect(page.locator("[data-state=connecting]")).to_have_count(0)
    page.wait_for_function(STANDS, polling=50)


# What can be worked now and bears no mark that it was.
UNWORKED: Final = """() => [...document.querySelectorAll(
    "button, input, select, [role=slider], [role=button], [role=radio]")]
  .filter((each) => each.checkVisibility() && !("worked" in each.dataset))
  .map((each) => each.outerHTML.slice(0, 120))"""


# Whether a control has the focus, which it is given: what is hidden, disabled or inert takes none.
FOCUSED: Final = "(each) => { each.focus(); return each.matches(':focus'); }"


def work(page: Page, control: Locator, way: str, part: tuple[float, float] = (0.5, 0.5)) -> None:
    """Work a control with the mouse, a finger, or the keyboard.

    ``part`` is where it is touched, as shares of its width and height.
    """
    control.evaluate("(each) => (each.dataset.worked = '')")
    if way == "keyboard":
        await_that(lambda: control.evaluate(FOCUSED), lambda: f"{control} takes no focus")
        page.keyboard.press("Enter")
        return
    if part == (0.5, 0.5):
        control.click() if way == "mouse" else control.tap()
        return
    control.scroll_into_view_if_needed()
    box = control.bounding_box()
    assert box
    x, y = box["x"] + box["width"] * part[0], box["y"] + box["height"] * part[1]
    (page.mouse.click if way == "mouse" else page.touchscreen.tap)(x, y)


# A place on a lever's groove, by its share from one end to the other, as the page has it.
ON_GROOVE: Final = """([name, share]) => {
  const path = document.querySelector(`order-lever[name=${name}] .reach`);
  const place = path.getPointAtLength(path.getTotalLength() * share);
  const { x, y } = place.matrixTransform(path.getScreenCTM());
  return [x, y];
}"""


def on_groove(page: Page, name: str, share: float) -> tuple[float, float]:
    """Return a place on the groove of a lever, from its left or lower end (0) to the other (1)."""
    x, y = page.evaluate(ON_GROOVE, [name, share])
    return x, y


def work_frame(page: Page, way: str) -> None:
    """Work what stands above every station: sound, palette, choices, and the alerts' bell."""
    bell, listed = page.locator("alert-bar .bell"), page.locator("alert-bar .all")
    work(page, bell, way)
    expect(listed).to_be_visible()
    work(page, bell, way)
    expect(listed).to_be_hidden()
    page.locator("alert-bar .hush").evaluate("(each) => (each.dataset.worked = '')")
    for shown in (True, False):
        work(page, page.locator("#open-choices"), way)
        expect(page.locator("#choices")).to_be_visible(visible=shown)
    for words in ("Sound on", "Sound off"):
        work(page, page.locator("#sound"), way)
        expect(page.locator("#sound")).to_have_text(words)
    palette = page.locator("#palette")
    palette.evaluate("(each) => (each.dataset.worked = '')")
    palette.select_option("dusk")
    if way == "keyboard":
        palette.focus()
        page.keyboard.press("ArrowDown")
    else:
        palette.select_option("day")
    expect(page.locator(":root")).to_have_attribute("data-palette", "day")


def work_parts(page: Page, way: str, keys: str, shown: str) -> None:
    """Work the keys that choose the part of a page; ``shown`` is where the body names it."""
    for key in page.locator(keys).all():
        work(page, key, way)
        expect(key).to_have_attribute("aria-pressed", "true")
        chosen = key.get_attribute("data-name")
        expect(page.locator("body")).to_have_attribute(shown, str(chosen))


def report(page: Page, words: str, way: str) -> None:
    """Report something by the bar of a station."""
    field = page.get_by_label("Report", exact=True)
    work(page, field, way)
    field.fill(words)
    work(page, page.locator("report-bar form button"), way)
    expect(field).to_be_empty()


def heard(caller: Caller, words: str) -> bool:
    """Return whether a line is told something with these words in it, in time."""

    def has_come() -> bool:
        assert caller.ask("who")[0]
        return any(words in each.fields[3] for each in caller.news)

    return eventually(has_come)


def read(caller: Caller, place: str) -> str:
    """Return what a session says of a place such as `valves.blow_aft`, at its latest tick."""
    channel, field = place.split(".")
    names = [each.name for each in CHANNELS[channel].fields]
    if channel not in caller.shown:
        assert caller.ask(f"subscribe {channel}")[0]

    def is_shown() -> bool:
        return caller.ask("who")[0] and channel in caller.shown

    await_that(is_shown, lambda: f"nothing comes of {channel}")
    return caller.shown[channel][2 + names.index(field)]


def step(caller: Caller, ticks: int) -> None:
    """Let a frozen session make ticks, and wait for the last of them."""
    read(caller, "gauges.depth")
    wanted = caller.tick + ticks
    assert caller.ask(f"step {ticks}")[0]

    def is_there() -> bool:
        return caller.ask("who")[0] and caller.tick >= wanted

    await_that(is_there, lambda: f"tick {caller.tick} of {wanted}")


def await_obeyed(caller: Caller, words: str) -> None:
    """Give an order until it is obeyed: what must come before it may take its time."""
    await_that(lambda: caller.ask(words)[0], lambda: f"{words}: {caller.ask(words)[1]}")


def stop_clock(page: Page) -> None:
    """Let a page's own time go on by `run_for` alone: an installed clock goes on by itself."""
    page.clock.pause_at(page.evaluate("Date.now()") / 1000.0 + LEAP_S)


def skip_until(page: Page, happened: Callable[[], object]) -> None:
    """Move a page's installed clock on, a second at a time, until something happens."""

    def has_happened() -> object:
        page.clock.fast_forward(1_000)
        return happened()

    await_that(has_happened)


def await_truth(caller: Caller, place: str, wanted: str) -> None:
    """Wait until a session says this of a place."""
    await_that(
        lambda: read(caller, place) == wanted,
        lambda: f"{place} is {read(caller, place)}, not {wanted}",
    )
