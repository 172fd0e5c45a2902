"""The instructor's page: the truth, what breaks, what was flown, and a whole exercise by mouse."""

import re
from collections.abc import Iterator
from typing import Final

import pytest
from helpers.browser import Look, Serve
from helpers.hands import WAYS, await_obeyed, await_truth, see_whole, work
from helpers.pages import QUIET, SIZES, Served, find_chromium
from helpers.time_line import drag, drawn, fly, seconds_of, settled
from helpers.waiting import PATIENCE, await_that
from playwright.sync_api import Browser, Page, expect
from soak.session_process import Caller

COURSE = "Passage, fast and deep"


@pytest.fixture
def caller(shared: Served) -> Iterator[Caller]:
    """Return a line to the shared session, which is at its start, whole and frozen."""
    attached = shared.attach()
    await_obeyed(attached, "freeze")  # the page of the test before may have command yet
    for words in ("clear all", "reset", "time 1"):
        attached.ask(words)
    yield attached
    attached.hang_up()


def opened(session: Served, look: Look, way: str) -> Page:
    """Return the page in a browser that has a touch panel where it is to be touched."""
    return settled(session, look, has_touch=way == "touch")


# How far the title of each strip chart reaches over its value, in pixels.
OVERLAPS: Final = """() => [...document.querySelectorAll("strip-chart")].map((chart) => {
  const { prototype } = CanvasRenderingContext2D, { fillText } = prototype, ends = {};
  prototype.fillText = function (text, x, y, most = Infinity) {
    const wide = Math.min(this.measureText(text).width, most);
    const end = x + (this.textAlign === "left" ? wide : -wide);
    if (y < chart.clientHeight / 8) ends[this.textAlign] = end;
    fillText.call(this, text, x, y, most);
  };
  chart.series.actual = [[chart.series.now, -10.5]];
  chart.draw();
  prototype.fillText = fillText;
  return ends.left - ends.right;
})"""


def test_no_title_of_a_chart_reaches_over_its_value(shared: Served, look: Look) -> None:
    page = settled(shared, look)
    page.set_viewport_size({"width": 1024, "height": 768})
    await_that(lambda: max(page.evaluate(OVERLAPS)) <= 0.0, lambda: page.evaluate(OVERLAPS))


def test_the_keys_of_alerts_and_aids_share_a_row_on_a_laptop(serve: Serve, look: Look) -> None:
    page = look(serve("stern-plane-jam"), "instructor", size="laptop")
    alerts, hint = page.locator("alert-bar .bell"), page.locator("#hint")
    expect(hint).to_have_text("Hint: 5 marks")
    above, beside = alerts.bounding_box(), hint.bounding_box()
    assert above
    assert beside
    assert above["y"] <= beside["y"] < above["y"] + above["height"]


def test_an_answer_has_room_in_the_log_of_a_laptop_below_three_branches(
    serve: Serve, look: Look
) -> None:
    session = serve("first-depth-change")
    caller, page = session.attach(), look(session, "instructor", size="laptop")
    for words in ("step 60", "backtrack 9 s", "step 40", "backtrack 5 s") * 2:
        assert caller.ask(words)[0]
    expect(page.locator("time-line .lane")).to_have_count(4)
    expect(page.locator("#command")).to_be_visible()
    places = [page.locator(name).bounding_box() for name in ("#log", "#order", "#log-panel")]
    log, line, panel = (box or {"y": 0.0, "height": 0.0} for box in places)
    assert log["height"] >= 40  # two lines
    assert line["y"] + line["height"] <= panel["y"] + panel["height"]


@pytest.mark.parametrize("way", WAYS)
def test_time_is_let_go_made_faster_stepped_and_stopped(
    shared: Served, caller: Caller, look: Look, way: str
) -> None:
    page = opened(shared, look, way)
    caller.ask("give command")

    work(page, page.locator("#freeze"), way)
    await_truth(caller, "time.time", "running")
    work(page, page.locator("[data-pace='4']"), way)
    await_truth(caller, "time.speed", "4.0")
    expect(page.locator("[data-pace='4']")).to_have_attribute("aria-pressed", "true")
    work(page, page.locator("#freeze"), way)
    await_truth(caller, "time.time", "frozen")
    before = seconds_of(caller)
    work(page, page.locator("#step"), way)
    expect(page.locator("#log")).to_contain_text("step: 1 tick")
    assert seconds_of(caller) == before + 0.5


def test_bell_and_repeat_stand_beside_their_orders(
    shared: Served, caller: Caller, look: Look
) -> None:
    page = settled(shared, look)
    for words in ("bell ahead full", "order depth 90", "step 2"):
        assert caller.ask(words)[0]
    row = page.locator("#truth tr[data-of=turns]")
    expect(row.locator("td").last).to_have_text("ahead full")
    depth = page.locator("#truth tr[data-of=depth] .ordered")
    expect(depth).to_have_text("90")
    expect(depth).to_have_attribute("title", "not repeated yet")
    assert shared.attach("planes").ask("aye")[0]
    assert caller.ask("step 1")[0]
    expect(depth).to_have_attribute("title", "")
    expect(page.locator("td[data-waits]")).to_have_count(0)


@pytest.mark.parametrize("way", WAYS)
def test_a_casualty_is_given_in_its_unit_by_two_clicks_and_cleared(
    shared: Served, caller: Caller, look: Look, way: str
) -> None:
    page = opened(shared, look, way)
    caller.ask("give command")

    page.locator("#find").fill("stern hard")
    offer = page.locator("#offers button")
    expect(offer).to_have_count(1)
    work(page, offer, way)
    expect(page.locator("#unit")).to_have_text("deg")
    page.locator("#severity").fill("6")
    page.locator("#side").select_option("dive")
    work(page, page.locator("#give"), way)
    expect(page.locator("#log")).to_contain_text("casualty stern-hard-over -0.2")
    page.locator("#step").click()
    await_truth(caller, "casualties.casualty_1", "stern-hard-over")
    expect(page.locator("#broken")).to_contain_text("6 deg dive")
    expect(page.locator("time-line .casualty")).to_have_count(1)
    work(page, page.locator("#broken button"), way)
    page.locator("#step").click()
    expect(page.locator("#broken li")).to_have_count(0)
    expect(page.locator("time-line .cleared")).to_have_count(1)


@pytest.mark.parametrize("way", WAYS)
def test_marks_charts_windows_tabs_and_tanks_are_worked(
    shared: Served, caller: Caller, look: Look, way: str
) -> None:
    page = opened(shared, look, way)
    caller.ask("give command")

    work(page, page.get_by_role("button", name="10 min"), way)
    label = page.locator("strip-chart[data-of='depth']")
    expect(label).to_have_attribute("aria-label", re.compile("last 10 minutes, now 60.0 m"))
    work(page, page.locator("#mark"), way)
    expect(page.locator("time-line .mark")).to_have_count(1)
    work(page, page.locator("#open-values"), way)
    expect(page.locator("#reading-body tbody tr").first).to_contain_text("60.0")
    work(page, page.locator("#close-reading"), way)
    work(page, page.locator("#open-drawer"), way)
    expect(page.locator("#drawer-body")).to_contain_text("instructor at local")
    page.locator("#drawer input").fill("before jam")
    work(page, page.get_by_role("button", name="Keep this moment"), way)
    expect(page.get_by_role("button", name="Restore before-jam").first).to_be_visible()
    work(page, page.locator("#close-drawer"), way)
    page.evaluate(CHOOSE_TANK)
    work(page, page.get_by_role("button", name="vent open"), way)
    expect(page.locator("#log")).to_contain_text("vent mid open")
    work(page, page.locator("#sea-tab"), way)
    page.locator("#sea-state").select_option("4")
    work(page, page.locator("#raise"), way)
    expect(page.locator("#log")).to_contain_text("sea state 4")
    page.locator("#sea-from").fill("045")
    work(page, page.locator("#turn"), way)
    expect(page.locator("#log")).to_contain_text("sea from 045")
    work(page, page.locator("#calm"), way)
    expect(page.locator("#log")).to_contain_text("sea calm")
    expect(page.locator("#sea")).to_contain_text("Current towardsnone")
    page.locator("#current-set").fill("090")
    page.locator("#current-drift").fill("1.5")
    work(page, page.locator("#current-orders button").first, way)
    expect(page.locator("#log")).to_contain_text("current set 090 drift 1.5")
    page.locator("#step").click()
    page.locator("#step").click()
    await_truth(caller, "current.set", "90.0")
    expect(page.locator("#sea")).to_contain_text("Current towards090")
    work(page, page.locator("#no-current"), way)
    expect(page.locator("#log")).to_contain_text("current off")
    work(page, page.locator("#track-tab"), way)
    expect(page.locator("track-chart")).to_be_visible()


def test_a_ship_is_added_by_bearing_and_range_and_steered_from_its_tab(
    shared: Served, look: Look, caller: Caller
) -> None:
    page = settled(shared, look)
    caller.ask("give command")
    page.locator("#ships-tab").click()
    page.locator("#ship").select_option("new tug")
    for name, value in (("bearing", "045"), ("range", "1500"), ("course", "270"), ("speed", "8")):
        page.locator(f"#ship-{name}").fill(value)
    page.locator("#ship-add").click()
    row = page.locator("#ships tbody tr >> nth=0")
    expect(row).to_have_text(re.compile(r"tug1045150\d m2708\.0"))
    row.click()
    expect(page.locator("#ship")).to_have_value("tug1")
    page.locator("#ship-bearing").fill("090")
    page.locator("#ship-move").click()
    expect(row.locator("td >> nth=0")).to_have_text("090")
    expect(page.locator("#ship-add")).to_be_hidden()
    expect(page.locator("#ship-turn")).to_be_visible()
    page.locator("#ship-remove").click()
    expect(page.locator("#no-ships")).to_be_visible()


CHOOSE_TANK = """() => document.querySelector("tank-mimic")
    .dispatchEvent(new CustomEvent("choose", { detail: "mid" }))"""


def test_an_order_is_completed_answered_and_brought_back(
    shared: Served, caller: Caller, look: Look
) -> None:
    caller.hang_up()
    page = settled(shared, look)

    page.keyboard.press("/")
    page.keyboard.type("dep")
    expect(page.locator("#completions button")).to_have_text(["depth"])
    page.keyboard.press("Tab")
    expect(page.locator("#completions")).to_contain_text("a depth, 0 to 2000 m")
    page.keyboard.type("80")
    page.keyboard.press("Enter")
    expect(page.locator("#log")).to_contain_text("depth 80")
    page.locator("#step").click()
    expect(page.locator("#truth tr[data-of='depth'] .ordered")).to_have_text("80")
    page.locator("#order").focus()
    expect(page.locator("#log")).to_contain_text("depth 80")
    page.keyboard.press("ArrowUp")
    expect(page.locator("#order")).to_have_value("depth 80")
    page.locator("#order").fill("rudder 15")
    page.get_by_role("button", name="Give", exact=True).click()
    expect(page.locator("#log")).to_contain_text("rudder left or rudder right")
    page.locator("#order").fill("help rudder")
    page.keyboard.press("Enter")
    expect(page.locator("#reading-body")).to_contain_text("rudder, in full")
    page.locator("#close-reading").click()
    page.locator("#order").fill("casualty flooding-a")
    page.locator("#completions button").click()
    expect(page.locator("#order")).to_have_value("casualty flooding-aft ")


def test_keys_act_only_where_nobody_types(shared: Served, caller: Caller, look: Look) -> None:
    caller.hang_up()
    page = settled(shared, look)

    for key in ("b", "m", "l", " ", "."):
        page.locator("#find").press(key)
    expect(page.locator("#find")).to_have_value("bml .")
    expect(page.locator("#drawer")).to_be_hidden()
    page.locator("#find").fill("")
    page.locator("#find").blur()
    page.keyboard.press("m")
    expect(page.locator("time-line .mark")).to_have_count(1)
    page.keyboard.press("]")
    expect(page.get_by_role("button", name="10 min")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("[")
    expect(page.get_by_role("button", name="3 min")).to_have_attribute("aria-pressed", "true")
    page.keyboard.press("l")
    expect(page.locator("#drawer")).to_be_visible()
    page.keyboard.press("l")
    expect(page.locator("#drawer")).to_be_hidden()
    page.keyboard.press(".")
    expect(page.locator("#time")).to_have_text("00:00")
    page.keyboard.press(" ")
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.keyboard.press(" ")
    expect(page.locator("#state")).to_have_text("FROZEN")
    page.keyboard.press("b")
    expect(page.locator("#find")).to_be_focused()


@pytest.mark.parametrize("way", WAYS)
def test_looking_back_sends_nothing_and_returns(
    shared: Served, caller: Caller, look: Look, way: str
) -> None:
    page = opened(shared, look, way)
    now = fly(caller, 100.0, "100")
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("#time")).to_have_text(f"{int(now) // 60:02}:{int(now) % 60:02}")
    drawn(page, now)
    assert caller.ask("give command")[0]
    caller.news.clear()

    if way == "mouse":
        drag(page, 55.0)
    elif way == "touch":
        box = page.locator("time-line .track").bounding_box()
        assert box
        page.touchscreen.tap(box["x"] + box["width"] * 55 / 600, box["y"] + box["height"] / 2)
    else:
        page.locator("time-line [role='slider']").press("Home")
        for key in ("PageDown", "PageDown", *["ArrowLeft"] * 5):
            page.keyboard.press(key)
    expect(page.locator("#when")).to_have_text("as it was at 00:55")
    assert given_by_page(caller) == []
    work(page, page.get_by_role("button", name="Return to now"), way)
    expect(page.locator("#when")).to_have_text("truth")
    assert seconds_of(caller) == now


def test_the_briefing_closes_when_time_runs_whoever_lets_it_run(
    shared: Served, caller: Caller, look: Look
) -> None:
    page = look(shared, "instructor")
    window = page.locator("#exercise")
    second = look(shared, "instructor").locator("#exercise")
    second.get_by_role("button", name="Choose another").click()
    expect(second).to_have_attribute("data-view", "choice")
    expect(window).to_be_visible()
    assert caller.ask("run")[0]
    for each in (window, second):
        expect(each).to_be_hidden()
    page.locator("#open-exercise").click()
    clock = page.locator("#time")
    expect(clock).not_to_have_text(clock.inner_text())  # it stays while time runs
    expect(window).to_be_visible()


def given_by_page(caller: Caller) -> list[str]:
    """Return the orders that another instructor has given, as they were told."""
    assert caller.ask("who")[0]
    told = [each.fields[3] for each in caller.news]
    return [text for text in told if text.startswith("instructor at ")]


def test_a_late_comer_sees_the_past(shared: Served, caller: Caller, look: Look) -> None:
    fly(caller, 60.0, "100")
    assert caller.ask("depth 80")[0]
    assert caller.ask("mark going down")[0]
    now = fly(caller, 1740.0)
    page = settled(shared, look)
    drawn(page, now)

    page.get_by_role("button", name="60 min").click()
    expect(page.locator("#log")).to_contain_text("mark: going down")
    expect(page.locator("time-line .mark[title*='going down']")).to_have_count(1)
    drag(page, 30.0)
    depth = page.locator("#truth tr[data-of='depth'] td >> nth=0")
    expect(depth).to_have_text("60.0", timeout=1000.0 * PATIENCE)  # once the past is there
    drag(page, 1500.0)
    expect(depth).to_have_text(re.compile(r"80\.\d|79\.\d"))


@pytest.fixture
def another(browser: Browser) -> Iterator[Browser]:
    """Return a second Chromium, a process of its own."""
    with browser.browser_type.launch(executable_path=find_chromium(), args=QUIET) as opened:
        yield opened


def test_command_goes_between_two_browsers_and_comes_back_when_one_dies(
    serve: Serve, look: Look, another: Browser
) -> None:
    session = serve()
    first = settled(session, look)
    expect(first.locator("#aboard")).to_have_text("no station aboard")

    def look_there(_: Served, name: str, size: str, **__: object) -> Page:
        width, height = SIZES[size]
        page = another.new_page(viewport={"width": width, "height": height})
        page.goto(f"{session.url}/{name}")
        return page

    second = settled(session, look_there)
    pages = first, second
    holds, watches = ("You have command", "has command. You watch and mark")
    expect(first.locator("#command")).to_contain_text(holds)
    expect(second.locator("#command")).to_contain_text(watches)

    order(second, "depth 95")
    # a count of earlier messages may stand above it
    expect(second.locator("#log")).to_contain_text("take command asks for it")
    order(first, "casualty stern-stuck")
    order(first, "depth 85")
    order(second, "mark seen by the second")  # who watches marks
    for page in pages:
        expect(page.locator("#log")).to_contain_text("seen by the second")
        expect(page.locator("#log")).to_contain_text("depth 85")
    order(first, "step 3")
    for page in pages:
        expect(page.locator("#truth tr[data-of='depth'] .ordered")).to_have_text("85")
        expect(page.locator("#time")).to_have_text("00:01")
    # the last of three ticks may be on its way to one of them
    await_that(lambda: len({page.locator("#truth").text_content() for page in pages}) == 1)

    second.get_by_role("button", name="Take command").click()
    first.get_by_role("button", name="Keep command").click()
    expect(second.locator("#log")).to_contain_text("keeps command")
    expect(second.locator("#command")).to_contain_text(watches)
    second.get_by_role("button", name="Take command").click()
    first.get_by_role("button", name="Give command").click()
    expect(second.locator("#command")).to_contain_text(holds)
    expect(first.locator("#command")).to_contain_text(watches)
    order(first, "depth 100")
    expect(first.locator("#log")).to_contain_text("take command asks for it")

    another.close()  # as a machine does that loses power

    expect(first.locator("#command")).to_be_hidden()
    order(first, "depth 100")
    expect(first.locator("#log")).to_contain_text("depth 100")
    first.locator("#step").click()
    expect(first.locator("#truth tr[data-of='depth'] .ordered")).to_have_text("100")


def test_a_refused_debrief_is_told_beside_its_key(
    shared: Served, caller: Caller, look: Look
) -> None:
    page = settled(shared, look)
    assert caller.ask("end exercise")[0]
    window = page.locator("#exercise")

    window.get_by_role("button", name="Debrief").click()

    expect(window.get_by_role("alert")).to_contain_text("has command")


def order(page: Page, words: str) -> None:
    """Give an order at a page's order line."""
    page.locator("#order").fill(words)
    page.keyboard.press("Enter")


@pytest.mark.usefixtures("caller")
def test_the_start_tells_who_is_aboard_and_ready(shared: Served, look: Look) -> None:
    helm = shared.attach("helm")
    page = settled(shared, look)

    page.locator("#open-exercise").click()
    expect(page.locator("#exercise-body")).to_contain_text("not ready yet")
    assert helm.ask("ready")[0]
    # tests before may have left stations aboard
    ready = page.locator("#exercise-body li").filter(has_text=re.compile("^helm at .*: ready$"))
    expect(ready).to_have_count(1)
    expect(page.locator("#aboard")).to_contain_text("helm")
    helm.hang_up()
    expect(ready).to_have_count(0)


FLOODS = """() => [...document.querySelectorAll("body *")].filter((each) => {
  const box = each.getBoundingClientRect();
  const inside = each.closest("alert-bar, .scroll, #columns, time-line .lanes, canvas, .unseen");
  const away = getComputedStyle(each).clipPath !== "none" || box.width < 3;
  return !inside && !away && (box.right > innerWidth + 1 || box.bottom > innerHeight + 1);
}).map((each) => each.outerHTML.slice(0, 90))"""
PAGE = "() => [document.scrollingElement.scrollWidth, document.scrollingElement.scrollHeight]"


def test_nothing_overflows_at_any_size(shared: Served, caller: Caller, look: Look) -> None:
    caller.hang_up()
    page = settled(shared, look)

    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        views = page.locator("#tabs button").all() if width <= 640 else [None]
        for view in views:
            if view:
                view.click()
            see_whole(page, (width, height), FLOODS)
            wide, high = page.evaluate(PAGE)
            assert wide <= width
            assert high <= height
        page.locator("#open-exercise").click()
        see_whole(page, (width, height), FLOODS)
        page.get_by_role("button", name="Choose another").click()
        expect(page.locator(".card").first).to_be_visible()
        see_whole(page, (width, height), FLOODS)
        page.locator("#exercise").get_by_role("button", name="Close", exact=True).click()


CUT = """() => {
  const panel = document.querySelector("#state-panel");
  const { right, bottom } = panel.getBoundingClientRect();
  const end = right - parseFloat(getComputedStyle(panel).paddingRight) + 1;
  const cells = [...document.querySelectorAll("#truth td, #truth th")].filter((each) => {
    const box = each.getBoundingClientRect();
    return box.width > 0 && (box.right > end || box.bottom > bottom);
  });
  const view = document.querySelector("boat-side").getBoundingClientRect();
  const labels = [...document.querySelectorAll("boat-side text")].filter((each) => {
    const box = each.getBoundingClientRect();
    return box.width > 0 && (box.top < view.top - 2 || box.bottom > view.bottom + 2);
  });
  return [...cells, ...labels].map((each) => each.textContent);
}"""


def test_no_number_of_the_state_and_no_depth_of_the_ladder_is_cut(
    shared: Served, caller: Caller, look: Look
) -> None:
    for words in ("casualty depth-gauge-biased 5 ramp 0", "casualty stern-hard-over -1 ramp 0"):
        assert caller.ask(words)[0]
    for words in ("depth 250", "course 187", "stern planes rise 30", "step 20"):
        assert caller.ask(words)[0]
    page = settled(shared, look)
    expect(page.locator("#truth tr[data-of='depth']")).to_contain_text("GAUGE")
    for width, height in SIZES.values():
        page.set_viewport_size({"width": width, "height": height})
        see_whole(page, (width, height), CUT)


@pytest.mark.slow
def test_a_whole_exercise_is_led_by_the_mouse_alone(serve: Serve, look: Look) -> None:
    """Chosen, begun, broken, looked back into, taken over, ended, judged, debriefed, left."""
    session = serve("steady-course")
    page = look(session, "instructor", size="desk")
    start(page)
    break_something(page)
    go_back(page)
    enter_the_old_branch(page)
    end(page)
    begin_the_next(page)


def start(page: Page) -> None:
    """Begin another exercise than the one that is served."""
    expect(page.locator("#exercise-title")).to_have_text("Steering, first steps")
    page.get_by_role("button", name="Choose another").click()
    page.get_by_role("button", name=COURSE).click()
    expect(page.locator("#exercise-title")).to_have_text(COURSE)
    expect(page.locator("#exercise-body")).to_contain_text("Hidden: at about 1 minute")
    expect(page.locator("#exercise-body")).to_contain_text("You have the planes and the bell")
    expect(page.locator("#exercise-body")).to_contain_text("No station")
    page.locator("#exercise").get_by_role("button", name="Run").click()
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.locator("#freeze").click()
    expect(page.locator("#state")).to_have_text("FROZEN")


def break_something(page: Page) -> None:
    """Break the depth gauge, and see that the crew's reading is told apart."""
    step_to(page, 20)
    offer = page.locator("#offers button", has_text="depth-gauge-stuck")
    offer.click()
    offer.click()
    expect(page.locator("#broken")).to_contain_text("depth-gauge-stuck")
    expect(page.locator("#truth tr[data-of='depth']")).to_contain_text("GAUGE")
    step_to(page, 40)
    page.locator("#mark").click()


def go_back(page: Page) -> None:
    """Look at a moment, watch it again, take the replay over, and take over where it was."""
    drag(page, 30.0)
    expect(page.locator("#when")).to_have_text("as it was at 00:30")
    page.get_by_role("button", name="Watch again from here").click()
    expect(page.locator("#state")).to_have_text("REPLAY")
    page.locator("[data-deed='take']").click()
    expect(page.locator("#state")).to_have_text("RUNNING")
    page.locator("#freeze").click()
    drag(page, 15.0)
    page.get_by_role("button", name="Take over here").click()
    expect(page.locator("#time")).to_have_text(re.compile("^00:15"))
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("#broken li")).to_have_count(0)
    expect(page.locator("time-line [data-branch='1']")).to_have_count(1)


def enter_the_old_branch(page: Page) -> None:
    """Look into what was left, and go on from there."""
    drag(page, 35.0, "time-line [data-branch='1']")
    expect(page.locator("#when")).to_have_text("as it was at 00:35 on branch 1")
    expect(page.locator("#truth tr[data-of='depth'] td >> nth=0")).not_to_be_empty()
    page.get_by_role("button", name="Take over here").click()
    expect(page.locator("#time")).to_have_text(re.compile("^00:35"))
    expect(page.locator("#broken")).to_contain_text("depth-gauge-stuck")


def end(page: Page) -> None:
    """End it; see, release and debrief its marks; fly it again from a moment."""
    page.locator("#freeze").click()
    expect(page.locator("#exercise")).to_be_hidden()
    page.locator("#open-exercise").click()
    page.get_by_role("button", name="End exercise").click()
    window = page.locator("#exercise")
    expect(page.locator("#state")).to_have_text("ENDED")
    expect(window.locator(".marks li").first).to_be_visible()
    broken = window.get_by_role("button", name="depth-gauge-stuck")
    at = broken.inner_text()[-len("00:20") :]
    page.get_by_role("button", name="Release marks").click()
    expect(page.locator("#log")).to_contain_text("everybody has the marks")
    broken.click()  # which takes the log back too
    expect(page.locator("#when")).to_contain_text(f"as it was at {at}")
    page.get_by_role("button", name="Debrief").click()
    expect(window.locator(".path")).to_contain_text(".html")
    with page.expect_popup() as opened:
        window.get_by_role("link", name="Open the debrief").click()
    read_debrief(opened.value)
    window.get_by_role("button", name=f"Again from {at}").click()
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("#time")).to_have_text(re.compile(f"^{at}"))
    expect(window).to_be_hidden()


def read_debrief(page: Page) -> None:
    """See that the debrief is there, in its own styles, and can do nothing."""
    expect(page.locator("h1")).to_have_text(COURSE)  # a page that is still opening is not reloaded
    said: list[str] = []
    page.on("console", lambda told: said.append(told.text))
    answer = page.reload()
    assert answer
    policy = answer.headers["content-security-policy"]
    assert "sandbox" in policy
    assert "script-src" not in policy.replace("default-src 'none'", "")
    expect(page.locator("h1")).to_have_text(COURSE)
    assert page.locator("main svg").count() > 0
    share = page.locator(".share i").first
    assert share.evaluate("(bar) => getComputedStyle(bar).display") == "block"
    assert not said
    page.close()


def begin_the_next(page: Page) -> None:
    """End it once more, and begin the next: the page comes back by itself."""
    page.locator("#open-exercise").click()
    page.get_by_role("button", name="End exercise").click()
    expect(page.locator("#state")).to_have_text("ENDED")
    page.get_by_role("button", name="Next", exact=True).click()
    page.get_by_role("button", name="Steering, first steps").click()
    expect(page.locator("#exercise-title")).to_have_text("Steering, first steps")
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(page.locator("#time")).to_have_text(re.compile("^00:00"))
    expect(page.locator("time-line .lane")).to_have_count(0)


def step_to(page: Page, seconds: int) -> None:
    """Step a frozen boat to a time, of which it was short: no machine is too slow for it."""
    there = re.compile(f"^00:{seconds}")
    while not there.match(page.locator("#time").inner_text()):
        page.locator("#step").click()
