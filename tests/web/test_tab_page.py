"""A page with a boat inside: one file, opened from a disk, in a browser without a network."""

import base64
import contextlib
import hashlib
import json
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from bench.standard_hour import standard_boat
from helpers import node
from helpers.altered import alter
from helpers.firefox import firefox
from helpers.givers import giver_at
from helpers.lanes import sample_cases
from helpers.pages import OFTEN, SIZES
from helpers.places import ROOT
from helpers.recorded import record
from helpers.shell import typed
from helpers.tab import standard_hour
from helpers.waiting import PATIENCE
from playwright.sync_api import Browser, Page, expect

from trainer.cli.export import boat_at_start, page_text
from trainer.config.files import ConfigError, read_text, shipped_path
from trainer.debrief.page import boat_page as boat_page_maker
from trainer.debrief.page.boat_page import boat_of_visitors, page_of, write_page
from trainer.debrief.page.page import DebriefRequest, debrief_file
from trainer.debrief.passage.recording_export import read_recording
from trainer.io.recording.recording import Recording
from trainer.session.past.options import RunOptions
from trainer.web import modules
from trainer.web import single_file as maker

Open = Callable[..., Page]
MOST = 600_000  # [bytes] of BB2, and with ten minutes recorded
AN_HOUR = 2_000_000  # [bytes] more, of an hour recorded
MARKUP = "<img src=x onerror=alert(1)>"
# the core in the page itself is flown by its own numbers; the state comes back as it lies in memory
FLY = """async (deeds) => {
  const unpack = async (id) => {
    const text = atob(document.getElementById(id).textContent);
    const bytes = Uint8Array.from(text, (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
  };
  const boat = JSON.parse(new TextDecoder().decode(await unpack("tab-boat")));
  const { instance } = await WebAssembly.instantiate(await unpack("tab-core"), {});
  const core = instance.exports;
  const bytes = new Uint8Array(core.memory.buffer);
  for (const [room, text] of Object.entries(boat.records)) {
    bytes.set(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), core[`trainer_${room}`].value);
  }
  const rooms = ["vessel", "compact", "scheme", "state", "scratch"]
    .map((room) => core[`trainer_${room}`].value);
  const from = core.trainer_state.value;
  const state = new Float64Array(core.memory.buffer, from, boat.state_doubles);
  for (const [deed, what] of deeds) {
    if (deed === "write") for (const [place, value] of what) state[place] = value;
    else for (let left = what; left > 0; left -= 1) core.trainer_tick(...rooms);
  }
  return btoa(String.fromCharCode(...bytes.slice(from, from + 8 * boat.state_doubles)));
}"""

UNSTYLED = """() => [...document.querySelectorAll("svg :is(path, rect, circle, polygon)")]
  .filter((each) => getComputedStyle(each).fill === "rgb(0, 0, 0)" && !each.closest("defs"))
  .filter((each) => each.checkVisibility() && each.getBBox().width * each.getBBox().height > 0)
  .map((each) => `${each.closest("svg").parentNode.localName} ${each.outerHTML}`)"""


def text_of(recording: Path | None = None, station: str = "instructor", **options: Any) -> str:
    """Return a page's text."""
    chosen = replace(RunOptions(vessel="bb2"), **options)
    return page_text(None if recording else boat_at_start(chosen), recording, station)


@pytest.fixture(scope="module")
def drill(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of an exercise, with markup in what was said and in its name."""
    crew = {60.0: "depth 80", 90.0: f"mark {MARKUP}", 140.0: "course 30"}
    return record(tmp_path_factory.mktemp("drill") / "<b>drill.trainer", "stern-plane-jam", crew)


@pytest.fixture(scope="module")
def boat_page() -> str:
    """Return the page of BB2 for the instructor."""
    return text_of()


@pytest.fixture(scope="module")
def drill_page(drill: Path) -> str:
    """Return the page of that recording for the instructor."""
    return text_of(drill)


@pytest.fixture(scope="module")
def debriefed(drill: Path, drill_page: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return the debrief of that recording with the boat inside."""
    out = tmp_path_factory.mktemp("debriefed") / "debrief.html"
    debrief_file(drill, out, None, DebriefRequest(boat=drill_page))
    return out.read_text(encoding="utf-8")


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Iterator[Open]:
    """Return a function that opens a page's text as a file; nothing may be asked or complained."""
    with ExitStack() as stack:
        asked: list[str] = []
        said: list[str] = []

        def open_page(text: str, width: int = 1366, height: int = 768, locale: str = "en") -> Page:
            path = tmp_path / f"page-{len(asked)}.html"
            path.write_text(text, encoding="utf-8")
            context = browser.new_context(
                viewport={"width": width, "height": height},
                offline=True,
                locale=locale,
                reduced_motion="reduce",  # as for other pages: see helpers/browser
            )
            stack.callback(context.close)
            page = context.new_page()
            page.on("request", lambda request: asked.append(request.url))
            page.on("console", lambda message: said.append(message.text))
            page.on("pageerror", lambda error: said.append(str(error)))
            page.goto(path.as_uri())
            return page

        yield open_page
        assert not said
        assert [url for url in asked if not url.startswith(("file:", "blob:"))] == []
        assert all(url.endswith(".html") for url in asked if url.startswith("file:"))


# The file


def test_a_page_is_small_and_the_same_each_time(boat_page: str) -> None:
    assert len(boat_page.encode()) <= MOST
    assert text_of() == boat_page


@pytest.mark.parametrize("vessel", ["remus100", "sdv-mk9"])
@pytest.mark.parametrize("station", ["pilot", "ballast"])
def test_every_boat_and_station_can_be_a_page(vessel: str, station: str) -> None:
    text = text_of(vessel=vessel, station=station)

    assert len(text.encode()) <= MOST
    assert "<script src" not in text
    assert "/assets/" not in text


@pytest.mark.parametrize("sea", ["sea-state-3", "sea-state-6"])
def test_a_page_begins_in_the_sea_that_is_asked_for(sea: str) -> None:
    boat = boat_at_start(RunOptions(vessel="bb2", sea=sea))

    parts = page_of(boat, None, "instructor")

    packed = base64.b64decode(parts.boat["records"]["state"])
    assert packed == boat.records.state.tobytes()
    assert boat.state.sea_height > 0.5


def test_the_policy_names_what_is_inside_and_nothing_else(boat_page: str) -> None:
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', boat_page)
    assert found
    policy = found[1].replace("&#x27;", "'")
    scripts = re.findall(r"<script>(.*?)</script>", boat_page, re.DOTALL)
    sheets = re.findall(r"<style>(.*?)</style>", boat_page, re.DOTALL)

    assert len(scripts) == len(sheets) == 1
    for text in (*scripts, *sheets):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'; ")
    assert "unsafe-inline" not in policy
    assert "http" not in policy


def test_a_page_offers_only_orders_that_it_takes(boat_page: str) -> None:
    found = re.search(r'id="order-words">(.*?)</script>', boat_page)
    assert found

    heads = {usage.split()[0].strip("[]") for usage, _ in json.loads(found[1])["forms"]}

    assert {"depth", "blow", "flood", "sea", "casualty", "backtrack"} <= heads
    assert not {"hover", "lever", "order", "tell", "next", "end", "release"} & heads


def test_a_page_has_no_key_for_what_only_a_session_does(opened: Open, boat_page: str) -> None:
    page = opened(boat_page)
    expect(page.locator("#state")).to_have_attribute("data-state", "running")
    page.get_by_role("button", name="All instruments").click()

    page.click("#open-exercise")
    expect(page.locator("#exercise").get_by_role("button")).to_have_text(["Close"])
    page.keyboard.press("Escape")
    page.click("#open-drawer")
    expect(page.locator("#drawer h3")).to_have_text(["Moments kept"])
    pilot = opened(text_of(station="pilot"))
    expect(pilot.locator("#state")).to_have_attribute("data-state", "running")
    expect(pilot.get_by_role("button", name="Report")).to_have_count(0)


def test_an_import_of_an_unknown_kind_is_not_bundled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "one.js").write_text('import whole from "./two.js";\n')
    (tmp_path / "two.js").write_text("export default 3;\n")
    monkeypatch.setattr(modules, "ASSETS_FOLDER", tmp_path)

    with pytest.raises(modules.UnknownFormError, match=r"(two|one)\.js"):
        maker.bundle("one.js")


@pytest.mark.long
def test_a_recorded_hour_is_small(tmp_path: Path, boat_page: str) -> None:
    hour = record(tmp_path / "hour.trainer", "watch", {60.0: "depth 80", 700.0: "course 90"})
    recording = Recording.look(hour)
    ticks = recording.last_tick(1)
    recording.close()

    text = text_of(hour)

    assert ticks >= 3600
    assert (len(text.encode()) - len(boat_page.encode())) * 7200 / ticks < AN_HOUR


# In a browser


def test_a_page_flies_offline_from_a_file_without_a_complaint(opened: Open, boat_page: str) -> None:
    page = opened(boat_page)

    expect(page.locator("#state")).to_have_attribute("data-state", "running")
    page.get_by_role("button", name="All instruments").click()
    page.fill("#order", "depth 90")
    page.press("#order", "Enter")
    expect(page.locator("#log")).to_contain_text("depth 90")
    page.click("#freeze")
    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    expect(page.locator("#tab-note")).to_contain_text("Marks are not judged here")


@pytest.mark.parametrize("size", sample_cases(SIZES, *OFTEN))
def test_a_boat_in_a_file_begins_with_one_lever_that_dives_her(
    opened: Open, boat_page: str, size: str
) -> None:
    width, height = SIZES[size]
    page = opened(boat_page, width, height)
    slider = page.get_by_role("slider")

    expect(slider).to_have_count(1)  # nothing else is to be moved
    expect(page.locator("#find")).to_be_hidden()
    page.get_by_role("button", name="Level off").click(trial=True)  # in sight, and nothing over it
    slider.press("Shift+ArrowDown")
    said = page.locator("#first-lever [role=status]")
    expect(said).to_have_text("The order: stern dive 5")
    readouts = page.locator("#first-lever .readouts")
    expect(readouts).to_contain_text(re.compile("Pitch [1-9][.0-9]* down"), timeout=60_000)
    page.get_by_role("button", name="Level off").click()
    expect(said).to_have_text("The order: depth 60 m")
    expect(page.locator("#first-lever order-lever")).to_have_class(re.compile("automatic"))
    assert page.evaluate(
        "[document.documentElement.scrollWidth, document.documentElement.scrollHeight]"
    ) == [width, height]

    page.get_by_role("button", name="All instruments").click()

    expect(page.locator("#first-lever")).to_have_count(0)
    expect(page.locator("#tabs" if size.startswith("phone") else "#find")).to_be_visible()


@pytest.mark.parametrize("station", ["instructor", "pilot", "ballast", "observer", "visitor"])
def test_a_page_in_a_file_has_the_styles_of_all_that_it_draws(opened: Open, station: str) -> None:
    page = opened(text_of(station=station))
    expect(page.locator("svg :is(path, rect, circle)").first).to_be_attached()

    assert page.evaluate(UNSTYLED) == []  # what no style fills is black


def test_only_the_whole_desk_begins_with_one_lever(opened: Open, drill_page: str) -> None:
    for text in (drill_page, text_of(station="pilot")):
        page = opened(text)
        expect(page.locator("#state")).to_have_attribute("data-state", re.compile("running|frozen"))
        expect(page.locator("#first-lever")).to_have_count(0)


def test_the_core_in_the_page_ends_the_standard_hour_in_its_bits(opened: Open) -> None:
    deeds, end = standard_hour()
    page = opened(page_text(standard_boat(), None, "instructor"))

    state = page.evaluate(FLY, [list(deed) for deed in deeds])

    assert hashlib.sha256(base64.b64decode(state)).hexdigest() == end


@pytest.mark.slow
@pytest.mark.process
def test_in_firefox_a_page_flies_and_the_hour_has_the_same_bits(tmp_path: Path) -> None:
    deeds, end = standard_hour()
    page = tmp_path / "boat.html"
    page.write_text(page_text(standard_boat(), None, "instructor"), encoding="utf-8")

    with firefox(tmp_path / "profile") as tab:
        tab.open(page.as_uri())
        until = time.monotonic() + PATIENCE
        while tab.evaluate("document.querySelector('#state').dataset.state") != "running":
            assert time.monotonic() < until
        state = tab.evaluate(f"({FLY})({json.dumps([list(deed) for deed in deeds])})")

    assert hashlib.sha256(base64.b64decode(state)).hexdigest() == end


@pytest.mark.parametrize("station", ["instructor", "pilot", "a card"])
def test_a_page_has_no_barrier(opened: Open, drill_page: str, station: str) -> None:
    page = opened(drill_page if station == "a card" else text_of(station=station))
    expect(page.locator("#state")).to_have_attribute("data-state", re.compile("running|frozen"))

    page.evaluate(node.axe())

    assert page.evaluate(node.BARRIERS) == []


def test_a_recording_is_seen_and_taken_over_and_its_markup_stays_text(
    opened: Open, drill_page: str
) -> None:
    page = opened(drill_page)

    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    page.get_by_role("button", name="Look round first").click()
    expect(page.locator("#log")).to_contain_text("<b>drill.trainer: drag the time line")
    expect(page.locator("#log")).to_contain_text(MARKUP)
    assert page.title().endswith("<b>drill.trainer")
    handle = page.locator("time-line .handle")
    handle.focus()
    page.keyboard.press("PageDown")
    for _ in range(3):
        page.keyboard.press("PageUp")
    expect(page.locator("time-line .says")).to_contain_text("Looking at")
    assert float(handle.get_attribute("aria-valuemax") or 0) > 100.0
    page.click("[data-deed=take]")
    expect(page.locator("time-line .lane")).to_have_count(1)
    page.fill("#order", "rudder right 5")
    page.press("#order", "Enter")
    expect(page.locator("#log")).to_contain_text("rudder right 5")
    assert page.locator("img").count() == 0


def first_break(recording: Path) -> str:
    """Return the clock's reading at the first casualty of a recording."""
    with contextlib.closing(Recording.look(recording)) as kept:
        ticks = [each.tick for each in kept.orders(1) if each.text.startswith("casualty")]
    seconds = min(ticks) // 2  # two ticks a second
    return f"{seconds // 60:02}:{seconds % 60:02}"


def order_here(page: Page, words: str) -> None:
    """Give an order, and wait until it is in the log."""
    page.fill("#order", words)
    page.press("#order", "Enter")
    expect(page.locator("#log")).to_contain_text(words)


def result_of(page: Page) -> list[list[str]]:
    """Return the rows of a try's result, which is awaited at fifty times the clock's pace."""
    page.fill("#order", "time 50")
    page.press("#order", "Enter")
    expect(page.locator("#task td").first).to_be_visible()
    return [row.locator("td").all_inner_texts() for row in page.locator("#task tbody tr").all()]


@pytest.mark.parametrize(
    "size", sample_cases([(1366, 768), (360, 640), (844, 390)], (360, 640)), ids=str
)
def test_a_mailed_run_begins_with_a_card_and_is_taken_over_there_by_one_key(
    opened: Open, drill: Path, drill_page: str, size: tuple[int, int]
) -> None:
    at = first_break(drill)
    page = opened(drill_page, *size)
    card = page.locator("#task")

    expect(card.locator("h2")).to_have_text(f"At {at} the stern planes run to 6 deg dive and jam.")
    expect(card).to_contain_text("Keep the boat above 140 m and its pitch within 20 degrees.")
    for key in card.get_by_role("button").all():
        box = key.bounding_box()
        assert box
        assert 0 <= box["y"] <= box["y"] + box["height"] <= size[1]
    page.keyboard.press("Enter")
    expect(card).to_be_hidden()
    expect(page.locator("#state")).to_have_attribute("data-state", "running")
    expect(page.locator("#time")).to_contain_text(at[:3])
    expect(page.locator("#tab-note")).to_contain_text("Keep the boat above 140 m")
    limit = "document.querySelector('strip-chart[data-of=depth]').series.limit"
    page.wait_for_function(f"{limit} === 140")


def test_a_card_says_what_breaks_in_the_language_of_its_page(
    opened: Open, drill: Path, drill_page: str
) -> None:
    page = opened(drill_page, locale="de")

    expect(page.locator("#task h2")).to_have_text(
        f"{first_break(drill)}: die Heckruder laufen auf 6 Grad unten und klemmen."
    )


@pytest.mark.slow
def test_a_try_ends_after_two_minutes_with_its_result_beside_what_was_recorded(
    opened: Open, drill: Path, drill_page: str
) -> None:
    page = opened(drill_page)
    expect(page.locator("#task")).to_be_visible()
    page.keyboard.press("Enter")
    expect(page.locator("#state")).to_have_attribute("data-state", "running")

    (deep, steep) = result_of(page)

    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    minutes, seconds = map(int, first_break(drill).split(":"))
    expect(page.locator("#time")).to_contain_text(f"{minutes + 2:02}:{seconds:02}")
    assert deep[0] == "140.0 m"
    assert deep[1] == deep[2]  # nobody has done anything else than was recorded
    assert steep[1] == steep[2]
    expect(page.locator("#task h2")).to_have_text("A limit was passed")
    page.keyboard.press("Enter")  # again
    expect(page.locator("#task")).to_be_hidden()

    page = opened(drill_page)  # with the cure, at the clock's own pace
    expect(page.locator("#task")).to_be_visible()
    page.keyboard.press("Enter")
    expect(page.locator("#task")).to_be_hidden()
    for words in ("bell astern full", "bow planes rise 30"):
        order_here(page, words)
    (better, _) = result_of(page)
    assert float(better[1].split()[0]) < float(deep[1].split()[0]) - 10.0
    page.get_by_role("button", name="Go on from here").click()
    expect(page.locator("#state")).to_have_attribute("data-state", "running")


def visitors_page(**options: Any) -> str:
    """Return the kiosk as one file."""
    chosen = replace(RunOptions(vessel="bb2"), **options)
    boat, dive = boat_of_visitors(chosen)
    return page_text(boat, None, "visitor", dive)


def test_a_kiosk_is_a_file_too(opened: Open) -> None:
    text = visitors_page()
    assert len(text.encode()) <= MOST
    page = opened(text)
    body = page.locator("body")
    expect(body).to_have_attribute("data-scene", "attract")
    for lever in (-20, -5):  # the next visitor finds it as the first did
        page.locator("#start").click()
        expect(body).to_have_attribute("data-scene", "dive")
        expect(page.locator("#depth")).to_have_text("18")
        expect(page.locator("#left")).to_have_text(re.compile("^2:5"))
        slider = page.locator("order-lever [role=slider]")
        for _ in range(lever // -5):
            slider.press("Shift+ArrowDown")
        expect(slider).to_have_attribute("aria-valuenow", str(lever))
        if lever == -20:  # the bow goes down
            expect(page.locator("#angle")).not_to_have_text(re.compile("^[01]$"))
        page.locator("#stop").click()
    page.locator("#language").click()
    expect(page.locator("#start")).to_have_text("Tauchen")


def test_a_kiosk_needs_planes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boat_page_maker, "LEVER_SHARES", {})
    with pytest.raises(ConfigError, match=r"bb2\.toml: a kiosk needs planes"):
        visitors_page()


HOSTILE: list[str] = [
    "</script><script>window.bad = 1</script>",
    "<img src=x onerror=window.bad=1>",
    "<svg onload=window.bad=1><!--<script>",
    "]]><![CDATA[<b onclick=window.bad=1>",
    "{{7*7}} ${window.bad=1} \\u003cscript\\u003e",
    "\"'`><iframe srcdoc='<script>top.bad=1</script>'>",
]
UNSEEN: list[
    str
] = [  # no file of ours may have these; a recording may, since anybody can write one
    "one\u2028two\u2029three",
    "abc\u202egpj.exe\u2066\u2069",
    "bell\x07 escape\x1b[2J nul\x01",
]
ATTACKED = """
schema = "exercise/1"
name = {name}
briefing = {briefing}
vessel = "./hull.toml"
casualty_table = "table.toml"
duration_s = 20
"""


BREAKS = """
schema = "casualties/1"
name = "Own"

[casualty.own-jam]
kind = "stern-stuck"
description = {says}
severity = 1.0
"""


@pytest.fixture(scope="module")
def attacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording whose every text is hostile, in a file of a hostile name."""
    folder = tmp_path_factory.mktemp("attacked")
    hull = read_text(shipped_path("vessels", "bb2"))
    name = json.dumps(HOSTILE[0])
    hull = re.sub(r'^name = "Joubert.*$', lambda _: f"name = {name}", hull, flags=re.MULTILINE)
    (folder / "hull.toml").write_text(hull, encoding="utf-8")
    (folder / "table.toml").write_text(BREAKS.format(says=json.dumps(HOSTILE[5])), encoding="utf-8")
    (folder / "drill.toml").write_text(
        ATTACKED.format(name=json.dumps(HOSTILE[1]), briefing=json.dumps("\n".join(HOSTILE))),
        encoding="utf-8",
    )
    path = record(folder / "<img src=x onerror=bad()>.trainer", str(folder / "drill.toml"), {})
    with contextlib.closing(Recording.reopen(path)) as recording:
        for tick, text in enumerate([*HOSTILE, *UNSEEN], 1):
            for kind in ("mark", "exercise", "watch", "station", text):
                recording.event(tick, kind, text, text)
            recording.answered(
                recording.order(tick, giver_at(text), text, None), text, accepted=True
            )
    return path


@pytest.mark.parametrize("station", sample_cases(["instructor", "pilot", "observer"], "instructor"))
def test_no_text_of_a_recording_runs_in_its_page_and_each_is_shown_as_text(
    opened: Open, attacked: Path, station: str
) -> None:
    page = opened(text_of(attacked, station))
    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    expect(page.locator("#time")).to_have_text("00:20 / 00:20")
    page.get_by_role("button", name="Look round first").click()
    if station == "instructor":
        for text in (*HOSTILE, "one\\u2028two", "abc\\u202egpj.exe", "escape\\x1b[2J"):
            expect(page.locator("#log")).to_contain_text(text)
        for words in ("mark again", "depth 80", "casualty stern-stuck"):
            page.fill("#order", words)
            page.press("#order", "Enter")
        page.keyboard.press("End")

    assert page.evaluate("window.bad") is None
    assert page.locator("img, iframe, main script, [onload], [onerror], [onclick]").count() == 0
    assert page.locator("script:not([type])").count() == 1  # the page's own
    shown = page.evaluate("document.body.innerText + document.title")
    assert not re.search("[\u2028\u2029\u202a-\u202e\u2066-\u2069\x07\x1b]", shown)


def test_a_boats_name_with_markup_stays_text(opened: Open) -> None:
    name = f"</title></script>{MARKUP}"
    parts = page_of(boat_at_start(RunOptions(vessel="bb2")), None, "instructor")

    page = opened(maker.single_file("instructor", parts.boat | {"title": name}, parts.core, name))

    expect(page.locator("#title")).to_have_text(name)
    assert page.title() == name
    assert page.locator("img").count() == 0


@pytest.mark.parametrize(("width", "height"), [(360, 640), (1366, 768)])
def test_a_page_fits_on_a_telephone_and_on_a_desk(
    opened: Open, drill_page: str, width: int, height: int
) -> None:
    page = opened(drill_page, width, height)

    expect(page.locator("#state")).to_have_attribute("data-state", "frozen")
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= width


def test_a_debrief_has_the_boat_inside(opened: Open, debriefed: str) -> None:
    page = opened(debriefed)

    boat = page.frame_locator("iframe")
    expect(boat.locator("#state")).to_have_attribute("data-state", "frozen")
    expect(boat.locator("#log")).to_contain_text(MARKUP)
    expect(boat.locator("#task")).to_have_count(0)  # the debrief tells it, and keeps the focus
    boat.locator("#step").click()
    expect(boat.locator("#log")).to_contain_text("1 tick, then frozen")
    assert page.locator("img").count() == 0


def test_a_debrief_leads_the_boat_inside_it_to_where_marks_were_lost(
    opened: Open, debriefed: str
) -> None:
    page = opened(debriefed)
    boat = page.frame_locator("iframe")
    expect(boat.locator("#state")).to_have_attribute("data-state", "frozen")
    first = page.get_by_role("link", name="Play from here").first
    _, lapse, _ = (first.get_attribute("data-orders") or "").split("; ")
    begun = 600.0 - float(lapse.split()[1])

    first.click()

    expect(boat.locator("#state")).to_have_attribute("data-state", "running")
    expect(boat.locator("#time")).to_have_text(re.compile(f"^0{begun // 60:.0f}:"))


# What is wrong


OTHERS = {
    "another core": (
        "UPDATE header SET value = '0123456789abcdef' WHERE key = 'core'",
        "would not be the same run",
    ),
    "no branch": ("DELETE FROM branches", "has no branch|damaged"),
    "no layout": ("DELETE FROM header WHERE key = 'layout'", "layout"),
    "a state missing": ("DELETE FROM states WHERE tick = 50", "damaged"),
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_recording_that_cannot_be_flown_is_refused(
    what: str, drill: Path, tmp_path: Path
) -> None:
    path = tmp_path / "other.trainer"
    shutil.copy(drill, path)
    statement, why = OTHERS[what]
    alter(path, statement)

    with pytest.raises(ConfigError, match=why) as wrong:
        page_of(None, path, "instructor")
    assert len(wrong.value.args) == 1


def test_another_method_is_refused_by_name() -> None:
    boat = boat_at_start(RunOptions(vessel="bb2", equations="full"))

    with pytest.raises(ConfigError, match=r"full set.*a page's boat has the modified set"):
        page_of(boat, None, "instructor")


def test_a_disk_without_room_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, data: bytes) -> int:
        with path.open("wb") as file:
            file.write(data[:10])
        raise OSError(28, "No space left on device", str(path))

    out = tmp_path / "boat.html"
    out.write_text("before")
    monkeypatch.setattr(Path, "write_bytes", full)

    with pytest.raises(ConfigError, match=r"boat\.html cannot be written: No space left"):
        write_page(out, "text")
    assert out.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.process
def test_the_documented_run_is_a_small_page_the_same_each_time(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "boat-by-mail.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"^trainer run .* --recording .*$", text, re.MULTILINE)

    done = typed(line, tmp_path, "")

    assert done.returncode == 0, done.stderr
    made = (tmp_path / "drill.html").read_text(encoding="utf-8")
    assert len(made.encode()) <= MOST
    assert made == text_of(tmp_path / "drill.trainer")
    depths = read_recording(tmp_path / "drill.trainer").columns["z"]
    assert len(depths) == 1201  # ten minutes, with the start
    assert f"the boat went to {depths.max():.0f} m" in text
