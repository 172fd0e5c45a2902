"""The pages decide by facts: a text for people may be reworded, and they do the same."""

import json
import re
import subprocess
import tomllib
from collections.abc import Iterator
from typing import Final

import pytest
from helpers import node, page_alerts, page_orders
from helpers.browser import Look
from helpers.pages import SIZES, Served, served
from helpers.places import ROOT
from helpers.rewording import reworded
from helpers.waiting import PATIENCE
from playwright.sync_api import Browser, Page, WebSocketRoute, expect

from trainer.config.exercise.loss_words import word_loss
from trainer.io.orders.grammar import Order, parse
from trainer.web.modules import ASSETS_FOLDER

pytestmark = pytest.mark.process

GRAMMAR: Final = "the page's own grammar reads an order, which is typed or in the grammar's words"
BESIDE: Final = "leaves out what stands beside it on the page; other words are shown whole"
# Where a script may look into what its name calls a text, and why.
EXEMPT: Final = {
    ("frame.js", 'session.refusal.replace(/: (--token|type role) .*$/, "")'): (
        "leaves out what a terminal types; other words are shown whole"
    ),
    **{
        (f"stations/{page}.js", 'text.replace(/: (--token|type role) .*$/, "")'): (
            "leaves out what a terminal types; other words are shown whole"
        )
        for page in ("class", "entrance")
    },
    ("frame.js", "told in RIGGED"): "an order to the crew in words, as the officer has told it",
    ("instructor/completion.js", r"text.toLowerCase().trimStart().split(/\s+/)"): GRAMMAR,
    ("model/causes.js", r'text.replace(/^.*?: | \[\d+\]$/g, "")'): BESIDE,
    ("model/told.js", r'text.replace(/^tick \d+ \([\d.]+ s\): /, "")'): BESIDE,
    (
        "model/told.js",
        r'text.replace(/^tick \d+ \([\d.]+ s\): /, "").replace(/^LIMIT: /, "Limit passed: ")',
    ): BESIDE,
    ("protocol/line.js", "FRAME.exec(line)"): "the frame of a sentence, whatever is in it",
    ("protocol/line.js", "/[^ -~]|[$*]/u.exec(words)"): "what an order cannot hold",
    ("scope/sea.js", "DIGITS.indexOf(text[at * count + i])"): "digits of packed numbers",
    ("tab/desk.js", 'order.words !== "take over"'): GRAMMAR,
    ("tab/grammar.js", "REMARK.exec(line)"): GRAMMAR,
    (
        "tab/grammar.js",
        r'line.replace(IN_TWO, "$1-third").toLowerCase().trim().split(/\s+/)',
    ): GRAMMAR,
    ("tab/grammar.js", 'line.replace(IN_TWO, "$1-third")'): GRAMMAR,
    ("tab/grammar.js", "text in numbers"): GRAMMAR,
    ("tab/grammar.js", "text in names"): GRAMMAR,
    ("tab/grammar.js", 'text === "COURSE"'): GRAMMAR,
    ("tab/grammar.js", 'text === "TOKEN"'): GRAMMAR,
    ("tab/grammar.js", 'text === "TOPIC"'): GRAMMAR,
    ("tab/grammar.js", r'text.replace(/[[\]]/g, "")'): GRAMMAR,
    ("tab/orders.js", 'order.words === "sea from"'): GRAMMAR,
    ("tab/orders.js", 'order.words === "sea calm"'): GRAMMAR,
    ("tab/orders.js", 'order.words === "sea state"'): GRAMMAR,
}
FAULTS: Final = (  # ways to decide on English, most of them once in the pages
    'if (entry.text.startsWith("marks: ")) go();',
    "if (text.startsWith(`${role} at ${line} is ready`)) go();",
    'const won = answer.text.split("won")[0];',
    "const holder = HOLDER.exec(answer.text)?.[1];",
    "if (/beyond|collapse/.test(alert.words)) go();",
    "const told = log.filter(({ text }) => !ASKED.test(text));",
    'if (session.source.why === "no session") go();',
    'if ("lost" !== reason) go();',
    'if (lines[0].includes("has command")) go();',
    "if (KNOWN.includes(answer.text)) go();",
    'switch (link.why) { case "full": go(); }',
)
NOT_FAULTS: Final = (
    'if (fact.what === "marks") go();',
    'if (text === "") go();',
    'if (subject.split(",")[0] === "won") go();',
)


def decisions(sources: dict[str, str]) -> set[tuple[str, str]]:
    """Return where scripts decide on a text for people: the script, and the code."""
    tool = ROOT / "tests/web/english.mjs"
    done = subprocess.run(
        ["node", str(tool), str(node.modules())],
        input=json.dumps(sources),
        capture_output=True,
        text=True,
        check=True,
    )
    return {(name, code) for name, code in json.loads(done.stdout)}


def test_no_page_decides_on_english() -> None:
    folder = ASSETS_FOLDER / "js"
    paths = sorted(folder.rglob("*.js"))
    sources = {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in paths}
    found = decisions(sources)

    assert sources
    assert all(EXEMPT.values())
    assert not found - EXEMPT.keys(), "have the session send a fact (docs/stations.md)"
    assert not EXEMPT.keys() - found, "no script has that any more: take it from EXEMPT"


def test_a_decision_on_english_would_be_found() -> None:
    assert {name for name, _ in decisions({code: code for code in FAULTS})} == set(FAULTS)
    assert not decisions({code: code for code in NOT_FAULTS})


def test_the_pages_know_order_words_from_the_tables_of_the_session() -> None:
    renew = "renew: in tests/, python -m helpers.page_orders"
    assert page_orders.PAGE.read_text("utf-8") == page_orders.script(), renew


def test_the_pages_know_alerts_from_the_table_of_the_session() -> None:
    renew = "renew: in tests/, python -m helpers.page_alerts"
    assert page_alerts.PAGE.read_text("utf-8") == page_alerts.script(), renew


READ: Final = (  # an order as it is told, which the pages are to read as the session does
    *("at 600 s casualty rudder-stuck", "in 90 s depth 80", "when depth > 60 then bell stop"),
    *("casualty stern-stuck", "clear all", "snapshot before", "branch 2", "replay 90 s"),
    *("release marks", "take command", "take over", "course 045", "run"),
    *("freeze", "freeze depth", "mark here", "order course 045", "tell rig for red", "again"),
)


JS_URI: Final = (ASSETS_FOLDER / "js").as_uri()


def evaluated(module: str, names: str, code: str) -> object:
    """Return what code makes of what a module of the pages exports."""
    address = (ASSETS_FOLDER / "js" / module).as_uri()
    script = f'import {{ {names} }} from "{address}"; console.log(JSON.stringify({code}));'
    words = ["node", "--input-type=module", "-e", script]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    value: object = json.loads(done.stdout)
    return value


LOSSES: Final = {  # conditions that lose an exercise, and what is said of them
    "depth > 160": "deeper than 160 m",
    "depth_m >= 40 for 5 s": "deeper than 40 m for 5 s",
    "depth < 100 ft": "shallower than 100 ft",
    "speed_kn < 10 and time < 60": "slower than 10 kn and before 60 s",
    "showing > 0 for 5 s": "sail or deck out of the water for 5 s",
    "clearance < 0 for 60 s": "less than 0 m of water under the keel for 60 s",
    "heel > 40": "heel more than 40 deg",
}


def test_what_loses_an_exercise_is_said_in_the_same_words_by_pages_and_session() -> None:
    every = (
        "Object.fromEntries(" + json.dumps([*LOSSES]) + ".map((each) => [each, lossInWords(each)]))"
    )
    assert evaluated("briefing.js", "lossInWords", every) == LOSSES
    assert {each: word_loss(each) for each in LOSSES} == LOSSES


def test_no_shipped_exercise_is_lost_by_raw_words() -> None:
    raw = re.compile(r"[<>_=]")
    for path in (ROOT / "configs").glob("*/*.toml"):
        for each in tomllib.loads(path.read_text("utf-8")).get("lost", ()):
            assert not raw.search(word_loss(each)), path.name


def test_the_pages_read_an_order_as_the_session_does() -> None:
    read = evaluated("model/orders.js", "wordOf", f"{json.dumps(READ)}.map(wordOf)")
    orders = [parse(words) for words in READ]
    names = [order.name if isinstance(order, Order) else "" for order in orders]

    assert read == names


RANKED: Final = """((role) => {
  const numbers = { "gauges.depth": 150, "gauges.pitch": 31, "air.main_full": 0.5 };
  const open = new OpenAlerts();
  for (const [number, rank, kind] of [["1", "alarm", "watch"], ["2", "alarm", "depth"],
      ["3", "caution", "watch"], ["4", "emergency", "watch"]]) {
    open.rank(`${number},${rank}`);
    open.raise(9, `${number},${kind},beyond all, ${number} of ${kind}`);
  }
  open.raise(8, "5,depth,seen before");
  open.become("5,acknowledged,0.0");
  open.become("1,rectified,0.0");
  const session = { role, seconds: 10, state: "running", alerts: open, on: () => undefined,
    onFacts: () => undefined, number: (place) => numbers[place] ?? null,
    exercise: { limits: "depth_m_max:140" } };
  const alerts = new Alerts(session, [bankWatch("Bank", "air.main_full")]);
  alerts.look();
  return alerts.shown.map(({ rank, words, owed, state }) =>
    `${owed ? "" : "known: "}${state} ${rank} ${words}`);
})"""


@pytest.mark.parametrize(
    ("role", "limits"),
    [("planes", ["active alarm Beyond the limit: depth at most 140 m"]), ("instructor", [])],
)
def test_what_is_owed_a_look_comes_first_then_rank_then_the_newest(
    role: str, limits: list[str]
) -> None:
    """The session tells the instructor of a limit passed; a remark waits for nobody."""
    names = "Alerts, bankWatch"
    opened = f'const {{ OpenAlerts }} = await import("{JS_URI}/model/open-alerts.js");'
    code = f'(await (async () => {{ {opened} return {RANKED}("{role}"); }})())'
    shown = evaluated("model/alerts.js", names, code)

    assert shown == [
        "active emergency beyond all, 4 of watch",
        *("active alarm Pitch beyond 30 degrees", *limits, "active alarm Bank empty"),
        *("active alarm beyond all, 2 of depth", "rectified alarm beyond all, 1 of watch"),
        "known: acknowledged warning seen before",
        "known: active caution beyond all, 3 of watch",
    ]


def test_a_page_offers_an_order_where_the_session_s_table_lets_it_be_given() -> None:
    asked = [
        *(("run", "instructor", "ended"), ("freeze", "instructor", "ended")),
        *(("ready", "observer", "frozen"), ("ready", "helm", "frozen")),
        *(("rudder left 5", "helm", "replay"), ("mark here", "observer", "replay")),
    ]
    code = f"{json.dumps(asked)}.map((each) => mayGive(...each))"
    told = evaluated("model/orders.js", "mayGive", code)

    assert told == [False, True, False, True, False, True]


# What the instructor's page has decided: of texts, only those that are its own.
SEEN: Final = """() => {
  const all = (path) => [...document.querySelectorAll(path)];
  const text = (path) => all(path).map((each) => each.textContent);
  return {
    command: text("#command span"), keys: text("#command button"), aboard: text("#aboard"),
    state: text("#state"), signs: all("time-line .sign").map((each) => each.className),
    offers: text("#offers li b"), title: text("#exercise-title"),
    unit: text("#unit"), severity: document.querySelector("#severity").value,
    sides: text("#side option"), side: document.querySelector("#side").value,
    ready: text("#exercise-body li b").map((role, at) =>
      [role, all("#exercise-body li")[at].textContent.endsWith(": ready")]),
    marks: text("#exercise .big, #exercise .marks li"),
    freeze: document.querySelector("#freeze").disabled,
    who: [...new Set(text("#log .who"))].filter((each) => each !== "order").sort(),
  };
}"""


@pytest.fixture(scope="module")
def session() -> Iterator[Served]:
    """Return a session with an exercise that has marks."""
    with served("first-depth-change") as there:
        yield there


def reword(line: WebSocketRoute) -> None:
    """Pass all on between a page and its session, what the session says in other words."""
    server = line.connect_to_server()
    line.on_message(server.send)

    def hand(message: str | bytes) -> None:
        line.send("\n".join(map(reworded, str(message).split("\n"))))

    server.on_message(hand)


@pytest.fixture
def odd(browser: Browser, session: Served) -> Iterator[Page]:
    """Return the instructor's page of a session whose every text is in other words."""
    width, height = SIZES["desk"]
    with browser.new_context(viewport={"width": width, "height": height}) as context:
        page = context.new_page()
        page.route_web_socket(lambda _: True, reword)
        page.goto(f"{session.url}/instructor")
        yield page


def same(pages: tuple[Page, Page], what: str, wanted: object) -> None:
    """Wait until both pages show the same, and that is what is wanted."""
    for page in pages:
        page.wait_for_function(
            f"([what, wanted]) => JSON.stringify(({SEEN})()[what]) === wanted",
            arg=[what, json.dumps(wanted, separators=(",", ":"), ensure_ascii=False)],
            timeout=1000.0 * PATIENCE,
        )


def test_a_page_decides_the_same_when_every_text_of_the_session_is_reworded(
    session: Served, look: Look, odd: Page
) -> None:
    plain = look(session, "instructor", size="desk")
    pages = plain, odd
    for page in pages:
        expect(page.locator("#offers li").first).to_be_attached(timeout=1000.0 * PATIENCE)
    helm = session.attach("helm")
    session.attach("planes")
    assert helm.ask("ready")[0]
    same(pages, "ready", [["helm", True], ["planes", False]])
    same(pages, "aboard", ["helm, planes, 1 more instructor aboard"])
    holder = next(page for page in pages if page.evaluate(SEEN)["keys"] == [])
    watcher = next(page for page in pages if page is not holder)
    expect(holder.locator("#command")).to_contain_text("You have command")
    expect(watcher.locator("#command")).to_contain_text("has command. You watch and mark.")

    for page in pages:
        page.keyboard.press("Escape")
        page.locator("#offers button", has_text="stern-hard-over").first.click()
        expect(page.locator("#chosen")).to_be_visible()
    same(pages, "side", plain.evaluate(SEEN)["side"])
    same(pages, "severity", plain.evaluate(SEEN)["severity"])

    watcher.get_by_role("button", name="Take command").click()
    holder.get_by_role("button", name="Give command").click()
    expect(watcher.locator("#command")).to_contain_text("You have command")
    watcher.locator("#order").fill("casualty stern-stuck")
    watcher.keyboard.press("Enter")
    watcher.locator("#order").fill("mark here")
    watcher.keyboard.press("Enter")
    for page in pages:
        expect(page.locator("time-line .casualty")).to_have_count(1)
        expect(page.locator("time-line .mark")).to_have_count(1)
    same(pages, "who", plain.evaluate(SEEN)["who"])

    watcher.locator("#order").fill("end exercise")
    watcher.keyboard.press("Enter")
    for page in pages:
        expect(page.locator("#state")).to_have_text("ENDED")
        expect(page.locator("#exercise .marks li").first).to_be_visible(timeout=1000.0 * PATIENCE)
    shown = plain.evaluate(SEEN)
    for what in ("title", "marks", "freeze"):
        same(pages, what, shown[what])
