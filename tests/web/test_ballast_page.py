"""The ballast page: each control gives its order, and the picture shows what stands."""

import math
import re
from typing import Final

import pytest
from helpers.browser import Look, Serve
from helpers.hands import (
    EACH_WAY,
    UNWORKED,
    WAYS,
    await_truth,
    heard,
    read,
    report,
    see_whole,
    step,
    work,
    work_frame,
    work_parts,
)
from helpers.lanes import sample_cases
from helpers.pages import SIZES, Served
from helpers.plant_page import close_plant, open_plant
from helpers.waiting import await_that
from playwright.sync_api import Page, expect
from soak.session_process import Caller

from trainer.web.modules import ASSETS_FOLDER

# Panels of controls with more room below their last row than keys have between them.
EMPTY_FEET: Final = """() => [...document.querySelectorAll(".group")].filter((panel) => {
  const bottoms = [...panel.children].map((each) => each.getBoundingClientRect().bottom);
  return panel.getBoundingClientRect().bottom - Math.max(...bottoms) > 24;
}).map((panel) => panel.dataset.group)"""
# What is worked, how the session then stands, and after which group key on a small screen.
CONTROLS: Final = (
    ("[data-lever=aft] [data-position=vent]", "valves.vent_aft", "open"),
    ("[data-lever=mid] [data-position=vent]", "valves.vent_mid", "open"),
    ("[data-lever=forward] [data-position=vent]", "valves.vent_forward", "open"),
    ("[data-lever=aft] [data-position=shut]", "valves.vent_aft", "shut"),
    ("[data-lever=aft] [data-position=blow]", "valves.blow_aft", "open"),
    ("[data-lever=mid] [data-position=blow]", "valves.blow_mid", "open"),
    ("[data-lever=forward] [data-position=blow]", "valves.blow_forward", "open"),
    ("[data-lever=forward] [data-position=shut]", "valves.blow_forward", "shut"),
    ("[data-lever=mid] [data-position=shut]", "valves.blow_mid", "shut"),
    ("[data-lever=negative] [data-position=flood]", "valves.negative_flood", "open"),
    ("[data-lever=negative] [data-position=blow]", "valves.blow_negative", "open"),
    ("[data-lever=negative] [data-position=shut]", "valves.negative_flood", "shut"),
    ("[data-order='vent all open']", "valves.vent_mid", "open"),
    ("[data-shut]", "valves.vent_mid", "shut"),
    ("[data-order='blow all']", "valves.blow_mid", "open"),
    ("[data-shut]", "valves.blow_mid", "shut"),
    ("[data-switch=trim] [data-position=hand]", "tanks.trim_mode", "hand"),
    ("[data-pump=trim] .high", "tanks.moving_trim", "2.0"),
    ("[data-pump=trim] .stop", "tanks.moving_trim", "0.0"),
    ("[data-pump=trim] .low", "tanks.moving_trim", "-2.0"),
    ("[data-switch=trim] [data-position=auto]", "tanks.trim_mode", "auto"),
    ("[data-pump=auxiliary] .high", "tanks.moving_auxiliary", "2.0"),
    ("[data-pump=auxiliary] .low", "tanks.moving_auxiliary", "-2.0"),
    ("[data-pump=auxiliary] .stop", "tanks.moving_auxiliary", "0.0"),
    ("[data-pump=depth_control] .low", "tanks.moving_depth_control", "-2.0"),
    ("[data-pump=depth_control] .high", "tanks.moving_depth_control", "2.0"),
    ("[data-pump=depth_control] .stop", "tanks.moving_depth_control", "0.0"),
    ("[data-switch=hover] [data-position=on]", "tanks.hover", "on"),
    ("[data-switch=hover] [data-position=off]", "tanks.hover", "off"),
    ("[data-switch=compressor] [data-position=on]", "air.compressor", "no air"),
    ("[data-switch=compressor] [data-position=off]", "air.compressor", "off"),
    ("[data-switch=drain] [data-position=aft]", "tanks.draining", "aft"),
    ("[data-switch=drain] [data-position=centre]", "tanks.draining", "centre"),
    ("[data-switch=drain] [data-position=forward]", "tanks.draining", "forward"),
    ("[data-switch=drain] [data-position=stop]", "tanks.draining", ""),
)

# Words at valves and of flooded compartments that a pipe or a valve goes through, and any words
# that others go through.
CROSSED: Final = """() => {
  const seen = (each) => each.checkVisibility() && (each.textContent || !each.matches("text"));
  const all = (kind) => [...document.querySelectorAll(`tank-mimic ${kind}`)].filter(seen);
  const within = ({ x, y }, { left, right, top, bottom }) =>
    x > left && x < right && y > top && y < bottom;
  const places = (line) => Array.from({ length: 200 }, (_, at) => line
    .getPointAtLength((line.getTotalLength() * at) / 199).matrixTransform(line.getScreenCTM()));
  const lines = [...all(".pipe"), ...all(".body"), ...all(".pump")].flatMap(places);
  return all(".word, .name, .value").filter((word) => {
    const box = word.getBoundingClientRect();
    const ends = all("text").filter((each) => each !== word).flatMap((each) => {
      const { left, right, top, bottom } = each.getBoundingClientRect();
      const y = (top + bottom) / 2;
      return [{ x: left, y }, { x: (left + right) / 2, y }, { x: right, y }];
    });
    const others = word.matches(".word") ? [...lines, ...ends] : ends;
    return others.some((place) => within(place, box));
  }).map((word) => word.textContent);
}"""


@pytest.fixture(autouse=True)
def level(instructor: Caller) -> None:
    """Keep the boat at its depth, whatever flows."""
    assert instructor.ask("freeze depth")[0]


def open_ballast(kept: Look, **how: object) -> Page:
    """Return the page, when it shows readings."""
    return await_readings(kept("ballast", **how))


def await_readings(page: Page) -> Page:
    """Return a page once it shows readings."""
    expect(page.locator("[data-place='gauges.depth']")).to_contain_text("m")
    expect(page.locator("[data-lever=aft]")).to_be_visible()
    return page


@pytest.mark.parametrize("way", sample_cases(EACH_WAY, "mouse"))
def test_every_control_does_in_the_boat_what_it_says(
    instructor: Caller, kept: Look, way: str
) -> None:
    page = open_ballast(kept)
    for control, place, wanted in CONTROLS:
        work(page, page.locator(control), way)
        await_stepped(instructor, place, wanted)
    for name in ("trim", "auxiliary", "depth_control"):
        pump = page.locator(f"[data-pump={name}]")
        for amount in ("1", "5", "10", "2"):
            work(page, pump.get_by_role("radio", name=amount, exact=True), way)
            expect(pump.locator(".high")).to_contain_text(f"{amount} t")
    for tank in page.locator(".tank").all():
        work(page, tank, way)
        expect(tank).to_have_attribute("aria-pressed", "true")
    report(page, f"trim is right {way}", way)
    assert heard(instructor, f"trim is right {way}")
    work(page, page.locator("emergency-cover .cover"), way)
    work_frame(page, way)
    open_plant(page, way)  # tests/web/test_plant_page.py works its keys
    close_plant(page, way)
    page.locator("emergency-cover .push").evaluate("(each) => (each.dataset.worked = '')")
    assert page.evaluate(UNWORKED) == []
    page.set_viewport_size({"width": 360, "height": 640})
    work_parts(page, way, "part-keys[part=group] button", "data-group")


def test_switches_show_what_stands_and_what_is_ordered(instructor: Caller, kept: Look) -> None:
    page = open_ballast(kept)
    vent = page.locator("[data-lever=aft] [data-position=vent]")
    vent.click()
    expect(vent).to_have_attribute("aria-checked", "true")
    expect(vent).to_have_attribute("data-stands", "")  # in a freeze too
    expect(page.locator("[data-part=vent_aft]")).to_have_attribute("data-open", "true")
    assert instructor.ask("vent aft shut")[0]
    step(instructor, 1)
    shut = page.locator("[data-lever=aft] [data-position=shut]")
    expect(shut).to_have_attribute("data-stands", "")
    expect(shut).to_have_attribute("aria-checked", "true")


# A control of a page gives orders, and hears answers and readings, in the order of these lines.
WANTED: Final = """async (lines) => {
  const { Pending } = await import("/assets/js/model/pending.js");
  const latest = new Map();
  const session = { onFacts: () => {}, readings: { latest } };
  const pending = new Pending(session, "valves");
  const shown = [];
  let stands = "";
  for (const line of lines) {
    const [what, value] = line.split(" ");
    if (what === "give") pending.give("lever", value);
    if (what === "obeyed") pending.answered("lever", true);
    if (what === "reading") latest.set("valves", { tick: 7 });
    if (what === "reading") stands = value;
    shown.push(pending.resolve("lever", stands));
  }
  return shown;
}"""


HEARD: Final = {  # in these orders, and what the switch shows then
    "reading shut, give vent, obeyed, reading vent, reading shut": "shut",
    "reading shut, give vent, reading vent, obeyed, reading shut": "shut",
    "reading shut, give vent, reading shut, obeyed, reading shut": "vent",
    "reading shut, give vent, give shut, reading shut, obeyed, obeyed": "shut",
    "reading vent, give shut, give vent, reading vent, obeyed, obeyed, reading shut": "vent",
}


def test_a_switch_shows_an_order_until_a_reading_knows_it_and_then_what_stands(kept: Look) -> None:
    page = open_ballast(kept)
    pending = ASSETS_FOLDER / "js/model/pending.js"  # which is bundled on the page
    page.route("**/model/pending.js", lambda asked: asked.fulfill(path=pending))
    assert {lines: page.evaluate(WANTED, lines.split(", "))[-1] for lines in HEARD} == HEARD


def test_arrow_keys_move_a_switch_by_one_position(instructor: Caller, kept: Look) -> None:
    page = open_ballast(kept)
    page.locator("[data-lever=mid] [data-position=shut]").focus()
    page.keyboard.press("ArrowUp")
    await_stepped(instructor, "valves.vent_mid", "open")
    expect(page.locator("[data-lever=mid] [data-position=vent]")).to_be_focused()
    page.keyboard.press("ArrowDown")
    await_stepped(instructor, "valves.vent_mid", "shut")


def await_stepped(caller: Caller, place: str, wanted: str) -> None:
    """Let the frozen session make ticks until it says this of a place, amounts within 0.3 t."""
    for _ in range(100):
        found = read(caller, place)
        if found == wanted or (place.startswith("tanks.moving") and near(found, wanted)):
            return
        step(caller, 1)
    raise AssertionError(f"{place} is {read(caller, place)}, not {wanted}")


def near(found: str, wanted: str) -> bool:
    """Return whether an amount [t] is as good as the other: pumps have begun to move it."""
    return abs(float(found) - float(wanted)) < 0.3


def test_a_group_that_is_shut_leaves_the_others_blowing(instructor: Caller, kept: Look) -> None:
    page = open_ballast(kept)
    for lever, position in (("aft", "blow"), ("mid", "blow"), ("negative", "flood")):
        page.locator(f"[data-lever={lever}] [data-position={position}]").click()
    await_stepped(instructor, "valves.negative_flood", "open")
    assert read(instructor, "valves.blow_aft") == "open"
    page.locator("[data-lever=aft] [data-position=shut]").click()

    await_truth(instructor, "valves.blow_aft", "shut")
    for valve in ("blow_mid", "negative_flood", "vent_negative"):  # they are opened again
        await_truth(instructor, f"valves.{valve}", "open")
    assert read(instructor, "valves.blow_forward") == "shut"


def test_amounts_to_move_add_up_and_count_down(instructor: Caller, kept: Look) -> None:
    page = open_ballast(kept)
    assert instructor.ask("trim manual")[0]
    pump = page.locator("[data-pump=auxiliary]")
    pump.get_by_role("radio", name="5").click()
    expect(pump.locator(".high")).to_contain_text("5 t")
    before = float(read(instructor, "tanks.auxiliary"))
    pump.locator(".high").click()
    pump.locator(".high").click()
    expect(pump.locator(".left")).to_have_text("Flood: 10.0 t to go")  # the page's word is ahead
    await_truth(instructor, "tanks.moving_auxiliary", "10.0")
    step(instructor, 40)
    moved = float(read(instructor, "tanks.auxiliary")) - before
    assert 0.1 < moved < 9.5
    assert float(read(instructor, "tanks.moving_auxiliary")) == pytest.approx(10 - moved, abs=0.1)
    left = read(instructor, "tanks.moving_auxiliary")
    expect(pump.locator(".left")).to_have_text(f"Flood: {left} t to go")
    expect(page.locator("[data-part='auxiliary target']")).to_have_attribute("d", re.compile("M"))
    pump.get_by_role("radio", name="5").focus()
    page.keyboard.press("ArrowRight")
    pump.locator(".low").click()
    expect(pump.locator(".left")).to_have_text("Pump: 10.0 t to go")


@pytest.mark.parametrize("way", WAYS)
def test_an_emergency_blow_needs_its_cover_lifted_and_a_push(
    instructor: Caller, kept: Look, way: str
) -> None:
    page = open_ballast(kept)
    push = page.locator("emergency-cover .push")
    expect(push).to_be_disabled()
    work(page, page.locator("emergency-cover .cover"), way)
    expect(push).to_be_enabled()
    assert read(instructor, "valves.blow_mid") == "shut"
    work(page, push, way)

    def is_blown() -> bool:  # the answer may be that to the way before
        step(instructor, 1)
        return read(instructor, "valves.blow_mid") == "emergency"

    await_that(is_blown)
    expect(page.locator("#answer")).to_contain_text("both banks")
    expect(push).to_be_disabled()


def test_the_cover_falls_shut_again_and_two_taps_do_not_blow(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = look(shared)
    page.clock.install()
    page.goto(f"{shared.url}/ballast")
    await_readings(page)
    cover, push = page.locator("emergency-cover .cover"), page.locator("emergency-cover .push")
    cover.dblclick()
    expect(push).to_be_enabled()
    expect(page.locator("emergency-cover .left")).to_contain_text("shuts in")
    page.clock.fast_forward(6_000)
    expect(push).to_be_disabled()
    step(instructor, 1)
    assert read(instructor, "valves.blow_mid") == "shut"

    box = cover.bounding_box()
    assert box
    page.mouse.move(box["x"] + 20, box["y"] + box["height"] - 10)
    page.mouse.down()
    page.mouse.move(box["x"] + 20, box["y"] + 10, steps=4)
    page.mouse.up()
    expect(push).to_be_enabled()


def test_the_crew_is_told_when_little_air_is_left(instructor: Caller, kept: Look) -> None:
    page = open_ballast(kept)
    alerts = page.locator("alert-bar")
    assert instructor.ask("emergency blow")[0]
    for share, rank, title in ((20, "caution", "below 20 %"), (5, "warning", "below 5 %")):
        while float(read(instructor, "air.main_full")) >= share:
            step(instructor, 40)
        if not alerts.locator(".all").is_visible():
            alerts.locator(".bell").click()
        entry = alerts.locator(f".alert[data-rank={rank}]", has_text=f"Main air bank {title}")
        expect(entry).to_be_visible()
        bank = page.locator("[data-part='bank main']")
        expect(bank).to_have_attribute("data-rank", rank)
        expect(page.locator("[data-place='air.main']")).to_have_text(
            f"{read(instructor, 'air.main')} MPa"
        )


def test_the_picture_shows_levels_flows_and_flooded_compartments(
    instructor: Caller, kept: Look
) -> None:
    page = open_ballast(kept)
    assert instructor.ask("trim manual")[0]
    assert instructor.ask("blow aft")[0]
    assert instructor.ask("flood depth-control 10")[0]
    assert instructor.ask("casualty flooding-aft")[0]
    assert instructor.ask("run")[0]
    expect(page.locator(".tank[data-part=aft]")).to_have_attribute("data-flow", "out")
    expect(page.locator(".tank[data-part=depth_control]")).to_have_attribute("data-flow", "in")
    expect(page.locator(".tank[data-part=mid]")).to_have_attribute("data-flow", "none")
    expect(page.locator("[data-part='flood_aft word']")).to_contain_text("FLOODED")
    assert instructor.ask("freeze")[0]
    amount, full = read(instructor, "tanks.aft"), read(instructor, "tanks.aft_full")
    value = page.locator("[data-part='aft value']")
    expect(value).to_have_text(f"{amount} t {math.floor(float(full) + 0.5)} %".replace("t ", "t  "))
    page.locator(".tank[data-part=aft]").focus()
    page.keyboard.press("Enter")
    whole = 184.5  # [t] of the aft tank of BB2, 180 m3 of sea water
    expect(page.locator("#tank")).to_have_text(f"Aft main: {amount} of {whole} t")


def test_nothing_is_cut_and_no_word_of_the_picture_lies_on_a_pipe_at_any_size(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = await_readings(look(shared, "ballast"))
    expect(page.locator("[data-part='forward value']")).to_contain_text("100 %")  # the longest
    page.set_viewport_size({"width": 1280, "height": 720})
    assert page.evaluate(CROSSED) == []
    assert page.evaluate(EMPTY_FEET) == []
    for compartment in ("aft", "centre", "forward"):
        assert instructor.ask(f"casualty flooding-{compartment}")[0]
    assert instructor.ask("emergency blow")[0]
    step(instructor, 240)
    expect(page.locator("tank-mimic .flooded .word:visible")).to_have_count(3)
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        keys = page.locator("part-keys[part=group] button")
        shown = keys.count() if keys.first.is_visible() else 1
        for place in range(shown):
            if shown > 1:
                keys.nth(place).click()
            see_whole(page, f"{width}x{height}, group {place}")
            assert page.evaluate(CROSSED) == [], f"{width}x{height}, group {place}"


@pytest.mark.slow
def test_a_boat_without_tanks_is_told_so_and_has_no_controls(serve: Serve, look: Look) -> None:
    session = serve("--vessel", "remus100")
    page = look(session, "ballast")
    expect(page.locator("tank-mimic .none")).to_be_visible()
    expect(page.locator("section.group")).to_have_count(6)
    for each in page.locator("section.group").all():
        expect(each).to_be_hidden()


# The height of a capital as it is drawn, in millimetres of a screen of 96 points an inch.
CAPITAL = """(each) => {
  const pen = document.createElement("canvas").getContext("2d");
  const { fontWeight, fontSize, fontFamily } = getComputedStyle(each);
  pen.font = `${fontWeight} ${fontSize} ${fontFamily}`;
  return (pen.measureText("H").actualBoundingBoxAscent * 25.4) / 96;
}"""
ONE_METRE_MM = 1000.0  # from whoever works the valves
LEGIBLE_ARC = math.radians(15.0 / 60.0)  # MIL-STD-1472G, 5.2.2.2: 15 minutes of arc at least


def test_the_order_line_and_the_state_are_read_from_one_metre(
    instructor: Caller, kept: Look
) -> None:
    for words in ("order course right 45", "order depth 70", "order speed 6"):
        assert instructor.ask(words)[0]
    for size in ("tablet", "laptop", "desk"):
        page = kept("ballast", size)
        expect(page.locator("#ordered")).to_have_text(re.compile("course .*045, depth 70 m"))
        for place in ("#ordered", "#state"):
            height = float(page.locator(place).evaluate(CAPITAL))
            assert height >= ONE_METRE_MM * math.tan(LEGIBLE_ARC), place
            expect(page.locator(place)).to_be_in_viewport(ratio=1.0)
        assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
