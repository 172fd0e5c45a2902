"""One moment everywhere: what the instructor's page shows of the past, and of which branch."""

import re
import time
from typing import Final

import pytest
from helpers.browser import Look, Serve
from helpers.hands import read
from helpers.lanes import sample_cases
from helpers.pages import Served
from helpers.time_line import drag, drawn, fly, settled
from helpers.waiting import PATIENCE
from playwright.sync_api import Page, WebSocketRoute, expect
from soak.session_process import Caller

from trainer.web.modules import ASSETS_FOLDER

# The moment [s] that is looked at, the time at the right end of each chart and of its last reading,
# and how many places the track has.
MOMENTS = """() => {
  const charts = [...document.querySelectorAll("strip-chart")].filter((each) => !each.hidden);
  const line = document.querySelector("time-line");
  return {looked: line.looking?.seconds ?? line.flown.now,
          ends: charts.map(({ series }) => series.now),
          last: charts.map(({ series }) => series.actual.at(-1)[0]),
          places: document.querySelector("track-chart").shown.places.length};
}"""


def await_moment(page: Page, seconds: float) -> int:
    """Wait until all charts end at a moment; return how many places the track has."""
    until = time.monotonic() + PATIENCE
    while True:
        shown = page.evaluate(MOMENTS)
        looked = shown["looked"]
        near = abs(looked - seconds) <= 1.0  # a mouse hits a time so well
        if near and set(shown["ends"]) == {looked} and max(shown["last"]) <= looked:
            return int(shown["places"])
        assert time.monotonic() < until, shown
        page.wait_for_timeout(50)


def test_looking_back_moves_all_charts_the_track_and_the_log(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = settled(shared, look)
    log = page.locator("#log")
    for seconds, remark in ((60.0, "early"), (40.0, "late"), (20.0, "")):
        now = fly(instructor, seconds)
        assert not remark or instructor.ask(f"mark {remark}")[0]
    drawn(page, now)
    whole = await_moment(page, now)
    expect(log).to_contain_text("mark: late")

    drag(page, 80.0)
    assert await_moment(page, 80.0) < whole
    expect(log).to_contain_text("mark: early")
    expect(log).not_to_contain_text("mark: late")
    page.keyboard.press("Escape")
    expect(log).to_contain_text("mark: late")

    lane = f"time-line [data-branch='{read(instructor, 'time.branch')}']"
    assert instructor.ask("backtrack 70 s")[0]
    fly(instructor, 30.0)
    expect(page.locator(lane)).to_be_visible()
    drag(page, 110.0, lane)
    assert await_moment(page, 110.0) > 0
    expect(log).to_contain_text("mark: late")
    drag(page, 75.0)  # the same time on the present branch, where nobody has marked
    await_moment(page, 75.0)
    expect(log).not_to_contain_text("mark: early")


def test_a_key_and_a_button_step_from_cause_to_cause(serve: Serve, look: Look) -> None:
    session = serve("stern-plane-jam")
    caller = session.attach()
    fly(caller, 80.0)
    assert caller.ask("bow planes rise 2")[0]
    assert caller.ask("rudder left 1")[0]
    now = fly(caller, 30.0)
    page = settled(session, look)
    says, when = page.locator("time-line .says"), page.locator("#when")
    drawn(page, now)
    causes = ["casualty: stern-hard-over", "first order: bow planes rise 2", "limit: pitch more"]

    def by_key(*, later: bool) -> None:
        page.keyboard.press("c" if later else "Shift+C")

    def by_mouse(*, later: bool) -> None:
        page.locator(f"[data-deed={'next' if later else 'before'}]").click()

    for step_on in (by_mouse, by_key):
        for cause in causes:
            step_on(later=True)
            expect(says).to_contain_text(cause)
        expect(when).to_contain_text("as it was at")
        for cause in reversed(causes[:2]):
            step_on(later=False)
            expect(says).to_contain_text(cause)
        for _ in causes:
            step_on(later=True)
        expect(says).to_contain_text("limit: deeper than 140 m")
        step_on(later=True)
        expect(when).to_have_text("truth")


@pytest.mark.parametrize("back", sample_cases(["again", "backtrack 80 s"], "backtrack 80 s"))
def test_the_end_tells_of_the_branch_that_stands(serve: Serve, look: Look, back: str) -> None:
    session = serve("stern-plane-jam")
    caller = session.attach()
    assert caller.ask("time max")[0]
    page = look(session, "instructor")
    expect(page.locator("#state")).to_have_text("FROZEN")
    fly(caller, 80.0)
    assert caller.ask("bow planes rise 2")[0]
    fly(caller, 30.0)
    expect(page.locator("#log")).to_contain_text("deeper than 140 m")
    assert caller.ask(back)[0]
    fly(caller, 10.0)
    assert caller.ask("end exercise")[0]
    window = page.locator("#exercise")
    expect(window.locator(".marks li").first).to_be_visible()
    expect(window.get_by_role("button", name="Release marks")).to_be_visible()
    expect(window.locator("#exercise-title")).to_have_text("Passage, fast and deep: OVER")
    expect(window).to_contain_text("First answer: does not count")
    expect(window).not_to_contain_text("deeper than 140 m")
    expect(window).not_to_contain_text("bow planes rise 2")


OTHER_SHIP: Final = """(now) => document.querySelector("track-chart").shown.more.ships
    .find(({ range }) => range !== now)"""


def test_who_looks_back_sees_the_ships_where_they_were(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = settled(shared, look)
    assert instructor.ask("contact add ferry2 ferry at 3000 1500 course 270 speed 20")[0]
    end = fly(instructor, 30.0)
    drawn(page, end)
    page.locator("#ships-tab").click()
    listed = page.locator("#ships tbody tr").first
    expect(listed).to_contain_text("ferry2")
    closest = float(read(instructor, "contacts.contact_1_tcpa"))
    expect(listed).to_contain_text(f"{closest // 60:02.0f}:{closest % 60:02.0f}")
    drag(page, end - 20.0)
    expect(page.locator("#when")).to_contain_text("as it was")
    expect(listed).to_contain_text("ferry2")
    expect(listed).not_to_contain_text(f"{closest // 60:02.0f}:{closest % 60:02.0f}")
    then = page.wait_for_function(  # a picture is drawn after the words
        OTHER_SHIP,
        arg=float(read(instructor, "contacts.contact_1_range")),
        timeout=1000.0 * PATIENCE,
    )
    assert then.json_value()["name"] == "ferry2"
    assert instructor.ask("contact ferry2 remove")[0]
    drag(page, end - 25.0)
    expect(listed).to_contain_text("ferry2")  # it was there
    page.keyboard.press("Escape")
    expect(page.locator("#no-ships")).to_be_visible()


def test_what_was_broken_how_valves_stood_and_the_sea_are_those_of_the_moment(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = settled(shared, look)
    broken, count = page.locator("#broken"), page.locator("#broken-count")
    sea = page.locator("#sea tbody tr").first.locator("td").first
    for words in ("casualty depth-gauge-biased", "vent forward open", "sea state 5"):
        assert instructor.ask(words)[0]
    for seconds in (45.0, 15.0):  # a line that is behind leaves readings out, but never the last
        drawn(page, fly(instructor, seconds))
    for words in ("clear all", "vent forward shut", "sea calm", "casualty rudder-stuck"):
        assert instructor.ask(words)[0]
    end = fly(instructor, 120.0)
    drawn(page, end)
    page.locator("#sea-tab").click()
    expect(broken).to_contain_text("rudder-stuck")
    expect(sea).to_have_text("calm")
    depth = page.locator("#truth tr[data-of='depth']")
    vent = page.locator("tank-mimic [data-part='vent_forward']")

    drag(page, 50.0)
    expect(broken).to_contain_text("depth-gauge-biased")
    expect(broken).not_to_contain_text("rudder-stuck")
    expect(count).to_have_text("1 of 8")
    expect(broken.get_by_role("button")).to_have_count(0)  # nothing can be cleared in the past
    expect(depth).to_contain_text("GAUGE")
    expect(vent).to_have_attribute("data-open", "true")
    expect(sea).to_have_text(re.compile(r"^\d+\.\d$"))
    page.keyboard.press("Escape")
    expect(broken).to_contain_text("rudder-stuck")
    expect(broken.get_by_role("button")).to_have_count(1)
    expect(depth).not_to_contain_text("GAUGE")
    expect(vent).to_have_attribute("data-open", "false")
    expect(sea).to_have_text("calm")


# A page's session hears, in any order that a line may have them: rows of a past that it has asked
# for, a jump, and the branches.
HEARD: Final = """async (lines) => {
  const { Session } = await import("/assets/js/model/session.js");
  const { causesOf } = await import("/assets/js/model/causes.js");
  const order = async () => ({ ok: true, text: "", lines: [] });
  const source = Object.assign(new EventTarget(), { order, there: true, tries: 0 });
  const session = new Session(source, "instructor", ["motion", "time"]);
  for (const line of lines) {
    const [kind, ...fields] = line.split(",");
    const told = kind === "TRE" || kind === "TRF"; // their last field may hold commas
    const last = told ? [fields.splice(3).join(",")] : [];
    session.hear({ kind, tag: "", fields: [...fields, ...last] });
  }
  return {
    depths: session.history.of("motion").rows.map(({ depth }) => depth),
    causes: causesOf(session).map(({ words }) => words),
  };
}"""
NAMES: Final = ["TRN,motion,depth:m", "TRN,time,branch:-"]
FIRST: Final = "TRF,0,0,branch,1,,0,110,the start"
SECOND: Final = "TRF,60,30,branch,2,1,30,30,backtrack"
BACK: Final = "TRF,60,30,back,backtrack 80 s"
JUMP: Final = [
    pytest.param([SECOND, BACK], id="as told"),
    pytest.param([BACK, SECOND], id="branch late"),
    pytest.param(["TRS,motion,60,30,3", BACK, SECOND], id="reading before"),
]


def heard(page: Page, lines: list[str]) -> dict[str, list[object]]:
    """Return what a session has of the past, and which causes, that hears these lines."""
    causes = ASSETS_FOLDER / "js/model/causes.js"  # which a station's page does not have
    page.route("**/model/causes.js", lambda asked: asked.fulfill(path=causes))
    return dict(page.evaluate(HEARD, lines))


def flown(*seconds: int, depth: int) -> list[str]:
    """Return the readings of a depth [m] at times [s]."""
    return [f"TRS,motion,{2 * at},{at},{depth}" for at in seconds]


@pytest.mark.parametrize("jump", JUMP)
@pytest.mark.parametrize("before", sample_cases([0, 1, 3], 1), ids="{} rows before the jump".format)
def test_a_past_that_comes_after_a_jump_puts_nothing_back(
    kept: Look, jump: list[str], before: int
) -> None:
    rows = flown(10, 20, 40, depth=9)
    past = ["TRF,220,110,past,begin,motion", *rows[:before], *jump, *rows[before:]]
    lines = [*NAMES, FIRST, "TRS,time,220,110,1", *past, "TRF,220,110,past,end,motion"]
    told = heard(kept("helm"), lines)
    assert [depth for depth in told["depths"] if depth != 3] == [9, 9]


@pytest.mark.parametrize("jump", JUMP)
def test_nothing_of_a_branch_that_was_left_is_a_cause(kept: Look, jump: list[str]) -> None:
    first = flown(10, depth=1) + flown(100, 110, depth=2)
    left = ["TRF,160,80,order,bow planes rise 2", "TRE,200,100,watch,LIMIT: deeper than 140 m"]
    whole = [*NAMES, FIRST, "TRF,20,10,order,casualty jam", *first, *left]
    page = kept("helm")
    told = heard(page, whole)
    assert told["causes"] == ["jam", "bow planes rise 2", "deeper than 140 m"]
    told = heard(page, [*whole, *jump])
    assert told["causes"] == ["jam"]
    again = "TRF,80,40,order,rudder left 1"
    told = heard(page, [*whole, *jump, again, *flown(120, depth=5)])
    assert told == {"causes": ["jam", "rudder left 1"], "depths": [*told["depths"][:-1], 5]}
    assert 2 not in told["depths"]


def test_what_is_told_again_leaves_its_signs_and_jumps_nowhere(kept: Look) -> None:
    again = ["TRF,20,10,order,casualty jam", "TRF,60,30,back,backtrack 80 s"]
    past = ["TRF,220,110,past,begin,events", *again, "TRF,220,110,past,end,events"]
    told = heard(kept("helm"), [*NAMES, FIRST, *flown(10, 20, 40, depth=9), *past])
    assert told == {"causes": ["jam"], "depths": [9, 9, 9]}


def test_who_goes_to_a_moment_of_a_branch_that_was_left_sees_the_way_there(kept: Look) -> None:
    first = [*flown(*range(1, 101), depth=1), "TRF,180,90,order,casualty jam"]
    second = [*flown(*range(31, 131), depth=2), "TRF,240,120,order,casualty fire"]
    third = ["TRF,200,100,branch,3,1,100,100,restore deep", "TRF,200,100,back,restore deep"]
    lines = [*NAMES, FIRST, *first, SECOND, BACK, *second, *third, *flown(101, depth=3)]
    told = heard(kept("helm"), lines)
    assert told == {"causes": ["jam"], "depths": [1] * 100 + [3]}


def test_the_end_leaves_out_what_was_left_when_the_branch_is_told_late(
    serve: Serve, look: Look
) -> None:
    held: list[tuple[WebSocketRoute, str]] = []

    def hold(route: WebSocketRoute) -> None:
        server = route.connect_to_server()

        def pass_on(frame: str | bytes) -> None:
            for line in str(frame).split("\n"):
                if ",branch,2," in line:
                    held.append((route, line))
                else:
                    route.send(line)

        server.on_message(pass_on)

    session = serve("stern-plane-jam")
    caller = session.attach()
    page = look(session, "instructor")
    page.route_web_socket(re.compile("^ws"), hold)
    page.reload()
    expect(page.locator("#state")).to_have_text("FROZEN")
    fly(caller, 110.0)
    expect(page.locator("#log")).to_contain_text("deeper than 140 m")
    assert caller.ask("again")[0]
    fly(caller, 10.0)
    assert caller.ask("end exercise")[0]
    window = page.locator("#exercise")
    expect(window.locator(".marks li").first).to_be_visible()
    assert held
    for route, line in held:
        route.send(line)
    expect(window).not_to_contain_text("deeper than 140 m")
