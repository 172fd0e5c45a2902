"""What all stations share: alerts in plain words, the bell, repeats, and light that is told."""

import re
from typing import Final

import pytest
from helpers.browser import Look, Serve
from helpers.hands import WAYS, heard, step, work
from helpers.pages import Served
from helpers.waiting import await_that
from playwright.sync_api import Locator, Page, expect
from soak.session_process import Caller

CREW: Final = ("helm", "planes", "pilot", "ballast", "diving")
PITCH: Final = 1200  # [Hz] of the bell
LISTEN: Final = """() => {
  window.struck = [];
  const make = AudioContext.prototype.createOscillator;
  AudioContext.prototype.createOscillator = function () {
    const tone = make.call(this);
    const start = tone.start.bind(tone);
    tone.start = (at) => { window.struck.push(tone.frequency.value); start(at); };
    return tone;
  };
}"""


def opened(look: Look, session: Served, name: str, **how: object) -> Page:
    """Return a page of a frozen session that shows readings."""
    page = look(session, name, **how)
    expect(page.locator("#state")).to_have_text("FROZEN")
    return page


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name in CREW[2:] else []) for name in CREW],
)
def test_each_new_order_rings_the_bell_of_those_who_are_to_repeat_it(
    shared: Served, instructor: Caller, look: Look, name: str
) -> None:
    page = opened(look, shared, name)
    page.evaluate(LISTEN)
    page.locator("#sound").click()
    for words, role in (("prepare to surface", name), ("stand by", "observer")):
        assert instructor.ask(f"tell {words}")[0]
        expect(page.locator("repeat-bar .ordered")).to_have_text(words)
        page.wait_for_function("() => window.struck.length === 1")
        assert page.evaluate("window.struck.splice(0)") == [PITCH]
        if role == name:
            page.locator("repeat-bar button").click()
            expect(page.locator("repeat-bar")).to_be_hidden()
            assert heard(instructor, f"{name}: {words} aye")
    step(instructor, 2)  # readings alone ring nothing
    assert page.evaluate("window.struck") == []


def test_a_page_shows_which_of_its_controls_another_station_has(
    shared: Served, instructor: Caller, look: Look
) -> None:
    planes, pilot = opened(look, shared, "planes"), shared.attach("pilot")
    for words, shown in (
        ("stern planes dive 3", "others have: planes pilot"),
        ("rudder left 5", "others have: planes pilot"),  # the rudder is none of the planes'
    ):
        assert pilot.ask(words)[0]
        expect(planes.locator("#link")).to_have_text(shown)
    assert instructor.ask("stern planes zero")[0]
    expect(planes.locator("#link")).to_have_text("others have: planes instructor")


def test_after_the_end_of_an_exercise_no_order_waits_to_be_repeated(
    serve: Serve, look: Look
) -> None:
    session = serve("depth-changes")
    page, caller = look(session, "planes"), session.attach()
    assert caller.ask("order depth 90")[0]
    expect(page.locator("repeat-bar .ordered")).to_have_text("depth 90 m")
    step(caller, 2)
    assert caller.ask("end exercise")[0]
    expect(page.locator("#state")).to_have_text("ENDED")
    expect(page.locator("repeat-bar")).to_be_hidden()


HEAR_AIR = """() => {
  window.loud = 0;
  const change = AudioParam.prototype.setTargetAtTime;
  AudioParam.prototype.setTargetAtTime = function (value, ...rest) {
    window.loud = value;
    return change.call(this, value, ...rest);
  };
}"""


def test_the_telegraph_is_heard_where_it_stands_and_only_when_it_is_rung(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "helm")
    page.evaluate(LISTEN)
    page.locator("#sound").click()
    assert instructor.ask("bell ahead full")[0]
    page.wait_for_function("() => window.struck.length === 2")
    assert page.evaluate("window.struck.splice(0)") == [PITCH, PITCH]
    step(instructor, 2)
    assert instructor.ask("bell ahead full")[0]
    step(instructor, 200)
    expect(page.locator("#time")).to_contain_text("01:4")  # which came after the bell
    assert page.evaluate("window.struck") == []
    page.locator("#sound").click()  # off and on at one place
    assert instructor.ask("bell stop")[0]
    expect(page.locator("order-telegraph [aria-checked=true]")).to_have_text("STOP")
    assert page.evaluate("window.struck") == []


def test_air_is_heard_while_it_flows_into_a_tank(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "ballast")
    page.evaluate(HEAR_AIR)
    page.locator("#sound").click()
    for words in ("blow mid", "run"):
        assert instructor.ask(words)[0]
    page.wait_for_function("() => window.loud > 0")
    page.locator("#sound").click()
    page.wait_for_function("() => window.loud === 0")
    page.locator("#sound").click()
    page.wait_for_function("() => window.loud > 0")
    assert instructor.ask("blow stop")[0]
    page.wait_for_function("() => window.loud === 0")
    assert instructor.ask("blow mid")[0]
    page.wait_for_function("() => window.loud > 0")
    assert instructor.ask("freeze")[0]
    page.wait_for_function("() => window.loud === 0")


def test_a_wrong_repeat_stands_beside_the_order_until_it_is_right(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "helm")
    assert instructor.ask("order course left 45")[0]
    bar = page.locator("repeat-bar")
    expect(page.locator("#ordered")).to_contain_text("course left to 045")
    assert "WRONG" in shared.attach("pilot").ask("course left 54 aye")[1]
    expect(bar.locator(".wrong")).to_have_text(re.compile("^WRONG REPEAT: course left .*54"))
    page.locator("repeat-bar button").press("Enter")
    expect(bar).to_be_hidden()
    expect(page.locator("#ordered")).to_contain_text("course left to 045")  # it stands


@pytest.mark.parametrize("way", WAYS)
def test_an_alert_is_in_plain_words_without_its_tick_and_is_acknowledged(
    shared: Served, instructor: Caller, look: Look, way: str
) -> None:
    page = opened(look, shared, "planes", has_touch=way == "touch")
    assert instructor.ask("stern planes dive 12")[0]
    alert = page.locator("alert-bar .alert", has_text=re.compile("test depth", re.IGNORECASE))
    sail_until(instructor, alert.first)
    assert heard(instructor, "tick ")  # as programs are told
    expect(page.locator("#state")).to_have_text("FROZEN")  # nothing more is coming
    told = page.locator("alert-bar .alert b").all_inner_texts()
    assert not [words for words in told if re.search(r"\btick\b|\(\d", words)]
    new = page.locator("alert-bar .alert[data-new] b").get_by_text(told[0], exact=True)
    expect(new).to_have_count(1)
    page.set_viewport_size({"width": 360, "height": 640})
    expect(page.locator("alert-bar .alert button").first).to_be_in_viewport(ratio=1.0)
    if way == "keyboard":
        page.locator("body").press("a")
    else:
        work(page, page.locator("alert-bar .alert button").first, way)
    expect(new).to_have_count(0)
    late = opened(look, shared, "diving")
    late.locator("alert-bar .bell").click()
    seen = late.locator("alert-bar .all .alert[data-state=acknowledged]", has_text=told[0])
    expect(seen).to_contain_text("seen")


SOUNDER: Final = """async () => {
  const { AlertSounder } = await import("/assets/js/alert-sounder.js");
  const heard = [];
  let now = 0;
  const silence = (alert) => (alert.state = "silenced");
  const alerts = Object.assign(new EventTarget(), { shown: [], silence });
  const sound = { alert: (rank) => heard.push(`${now / 1000} ${rank}`) };
  const sounder = new AlertSounder(alerts, sound, () => now);
  const pass = (seconds) => {
    for (let k = 0; k < seconds; k += 1) { now += 1000; sounder.look(); }
  };
  const alert = (key, rank) => ({ key, rank, state: "active", owed: true });
  alerts.shown = [alert("a", "alarm"), alert("w", "warning")];
  pass(12);
  sounder.silence();
  pass(29);
  for (const each of alerts.shown) each.state = "active"; // half a minute is over
  pass(2);
  alerts.shown = [];
  pass(1);
  alerts.shown = [alert("a", "alarm")];
  pass(1);
  alerts.shown = [alert("e", "emergency")];
  pass(3);
  alerts.shown[0].state = "acknowledged";
  pass(3);
  alerts.shown[0].state = "rectified";
  pass(9);
  return heard;
}"""


def test_an_alert_sounds_again_until_it_is_seen_and_anew_when_it_comes_again(
    shared: Served, look: Look
) -> None:
    """By MSC.302(87): an alarm after 10 s, and 30 s after Silence; an emergency each 2 s."""
    assert look(shared, "helm").evaluate(SOUNDER) == [
        *("1 alarm", "11 alarm", "42 alarm"),  # silent from 12 s for half a minute
        *("45 alarm", "46 emergency", "48 emergency"),
    ]


def listening(look: Look, session: Served) -> Page:
    """Return a page of the planes whose sound is on, and which counts what it sounds."""
    page = opened(look, session, "planes")
    page.evaluate(LISTEN)
    page.locator("#sound").click()
    return page


def sail_until(instructor: Caller, alert: Locator, *, shows: bool = True) -> None:
    """Let a frozen session make ticks until a page shows an alert, or does so no more."""

    def is_so() -> bool:
        step(instructor, 8)
        return alert.is_visible() is shows

    await_that(is_so)


def test_what_was_seen_or_silenced_is_so_on_a_second_page_and_after_a_reload(
    shared: Served, instructor: Caller, look: Look
) -> None:
    jammed = "Stern planes off their order"
    first = listening(look, shared)
    for words in ("casualty stern-stuck", "stern planes dive 20"):
        assert instructor.ask(words)[0]
    new = first.locator("alert-bar .alert[data-new]", has_text=jammed)
    sail_until(instructor, new)
    first.wait_for_function("() => window.struck.length > 0")
    first.locator("alert-bar .hush").click()

    second = listening(look, shared)
    second.evaluate("() => { const now = performance.now(); performance.now = () => now; }")
    fresh = second.locator("alert-bar .alert[data-new]", has_text=jammed)
    sail_until(instructor, fresh)  # it finds by its own gauges that they are off
    assert second.evaluate("window.struck") == []  # silenced on the first page, by its clock
    fresh.get_by_role("button").click()
    expect(new).to_have_count(0)
    seen = first.locator("alert-bar .alert:not([data-new])", has_text=jammed)
    expect(seen).to_be_visible()
    first.reload()
    expect(first.locator("#state")).to_have_text("FROZEN")
    sail_until(instructor, seen)

    assert instructor.ask("clear stern-stuck")[0]
    sail_until(instructor, seen, shows=False)
    for words in ("casualty stern-stuck", "stern planes rise 20"):
        assert instructor.ask(words)[0]
    sail_until(instructor, new)  # it ended, and has come again
    second.wait_for_function("() => window.struck.length > 0")


FEW: Final = 3  # alerts whose keys are all on the screen
RANK_SEEN: Final = "document.querySelector('.all .rank').checkVisibility()"
WORDS_WHOLE: Final = """() => {
  const words = document.querySelector(".worst b");
  words.textContent = "No link: readings are old, controls do nothing. It is dialled again.";
  const { bottom, right } = words.getBoundingClientRect();
  const bar = document.querySelector("alert-bar").getBoundingClientRect();
  const { overflow } = getComputedStyle(words);
  const cut = overflow !== "visible" || words.scrollWidth > words.clientWidth;
  return !cut && bottom <= bar.bottom && right <= innerWidth && bar.height <= 49;
}"""


def test_the_list_has_all_alerts_and_silence_is_there_while_one_is_new(
    shared: Served, instructor: Caller, look: Look
) -> None:
    page = opened(look, shared, "planes")
    bell, hush = page.locator("alert-bar .bell"), page.locator("alert-bar .hush")
    expect(bell).to_have_text("0")
    expect(hush).to_be_disabled()
    for words in ("stern planes dive 20", "bow planes dive 20", "time max", "run"):
        assert instructor.ask(words)[0]
    expect(page.locator("alert-bar .worst .alert")).to_have_attribute("data-new", "")
    page.wait_for_function(f"() => document.querySelector('.bell .count').textContent >= {FEW}")
    for words in ("freeze", "time x1"):
        assert instructor.ask(words)[0]
    expect(page.locator("#state")).to_have_text("FROZEN")
    expect(hush).to_be_enabled()
    bell.click()
    entries = page.locator("alert-bar .all .alert")
    expect(entries.first).to_be_visible()
    for width, height in ((390, 844), (844, 390), (1366, 768)):
        page.set_viewport_size({"width": width, "height": height})
        keys = page.locator("alert-bar .all button")
        for at in range(FEW):
            expect(keys.nth(at)).to_be_in_viewport(ratio=0.99)
        assert page.evaluate(RANK_SEEN)
    first = page.locator("alert-bar .all button").first
    first.focus()
    fresh = page.locator("alert-bar .all .alert[data-new]")
    for left in (fresh.count() - 1, fresh.count() - 2):  # the focus goes on to the next
        page.keyboard.press("Enter")
        expect(fresh).to_have_count(left)
        expect(page.locator("alert-bar .all button").first).to_be_focused()
    page.keyboard.press("Escape")
    expect(entries).to_have_count(0)
    expect(page.locator("alert-bar .worst .alert")).to_have_count(1)
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate(WORDS_WHOLE)


BAR: Final = """() => {
  const ordered = document.querySelector("#ordered");
  const words = [...document.querySelectorAll("alert-bar .worst b")];
  const keys = [...document.querySelectorAll("body > header button")];
  const bar = document.querySelector("alert-bar").getBoundingClientRect();
  const beyond = (box) => box.top < bar.top - 1 || box.bottom > bar.bottom + 1;
  const cut = [ordered, ...keys, ...words].filter((each) => each.checkVisibility() &&
    (each.scrollWidth > each.clientWidth + 1 || each.scrollHeight > each.clientHeight + 1 ||
      (words.includes(each) && beyond(each.getBoundingClientRect()))));
  const { top } = document.querySelector("main").getBoundingClientRect();
  return [top, cut.map((each) => each.textContent)];
}"""
LOW_BAR_PX: Final = 64  # on a wide phone's side: a key of a finger, and two gaps


def test_a_wide_phone_on_its_side_has_one_bar_with_alert_order_and_keys_whole(
    shared: Served, instructor: Caller, look: Look
) -> None:
    assert instructor.ask("tell prepare to surface")[0]
    for name, width in (("helm", 800), ("ballast", 844), ("diving", 844), ("trainee", 844)):
        page = look(shared, name, locale="de")  # whose words are longer
        page.set_viewport_size({"width": width, "height": 390})
        close = page.locator("#close-briefing")
        if close.is_visible():
            close.click()
        expect(page.locator("#ordered")).to_contain_text("prepare to surface")
        for words in ("casualty bus-port-lost", "clear all"):
            assert instructor.ask(words)[0]
            step(instructor, 2)
            top, cut = page.evaluate(BAR)
            assert (top <= LOW_BAR_PX, cut) == (True, []), (name, words, top)


def test_rig_for_red_makes_every_page_night_and_white_gives_back_its_own(
    shared: Served, instructor: Caller, look: Look
) -> None:
    pages = [opened(look, shared, name) for name in ("ballast", "wall")]
    pages[0].locator("#palette").select_option("dusk")
    for words, palettes in (("red", ("night", "night")), ("white", ("dusk", "day"))):
        assert instructor.ask(f"tell rig for {words}")[0]
        for page, palette in zip(pages, palettes, strict=True):
            expect(page.locator(":root")).to_have_attribute("data-palette", palette)
    assert instructor.ask("tell rig for red")[0]
    late = opened(look, shared, "observer")
    expect(late.locator(":root")).to_have_attribute("data-palette", "night")
    expect(late.locator("#palette")).to_have_value("night")
    late.locator("#palette").select_option("dusk")  # by the user's hand it may be another
    step(instructor, 2)
    expect(late.locator(":root")).to_have_attribute("data-palette", "dusk")


def test_a_page_that_comes_at_the_start_knows_what_was_done_before(
    shared: Served, instructor: Caller, look: Look
) -> None:
    for words in ("mark she is light", "mark she is heavy", "casualty stern-stuck"):
        assert instructor.ask(words)[0]
    log = opened(look, shared, "observer").locator("#log li", has_text="she is")
    expect(log).to_contain_text(["light", "heavy"])
    line = opened(look, shared, "instructor").locator("time-line")
    expect(line.locator(".mark")).to_have_count(2)
    expect(line.locator(".casualty")).to_have_count(1)

    assert instructor.ask("reset")[0]
    expect(line.locator(".mark")).to_have_count(0)
    late = opened(look, shared, "instructor")
    expect(late.locator("#log")).to_contain_text("reset")
    expect(late.locator("time-line .sign")).to_have_count(0)


LAID_IN: Final = """async () => {
  const { laidIn } = await import("/assets/js/model/told.js");
  const entries = (words) => words.split(" ").map((each) =>
    ({ seconds: Number(each.slice(1)), kind: "station", text: each[0] }));
  const told = (log, earlier) => laidIn(entries(log), entries(earlier)).map(({ text }) => text);
  const said = { speaker: "instructor", words: "depth 80: ok" };
  const [own, whole] = ["instructor: depth 80: ok", "instructor at tcp 127.0.0.1:7: depth 80: ok"]
    .map((text, at) => [{ seconds: 7 + at / 2, kind: "own", text, ...said }]);
  return [
    ...[["c0 d0", "a0 b0 c0"], ["a0 b5 f50", "a0 b5 c5 d20 e40"], ["x0", "a0 b0"]]
      .map(([log, earlier]) => told(log, earlier).join("")),
    laidIn(own, whole).length,
  ];
}"""


@pytest.mark.usefixtures("instructor")
def test_what_was_told_before_is_laid_into_the_log_where_it_belongs(
    shared: Served, look: Look
) -> None:
    assert opened(look, shared, "helm").evaluate(LAID_IN) == ["abcd", "abcdef", "xab", 1]
