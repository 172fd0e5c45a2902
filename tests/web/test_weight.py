"""What the pages weigh on a line: few files, kept for ever, and none of them asked for twice."""

import gzip
import json
import re
from pathlib import Path

import pytest
from helpers.lanes import sample_cases
from helpers.pages import Served
from helpers.slow_line import slow_line
from helpers.waiting import PATIENCE
from helpers.wire import request
from playwright.sync_api import Browser, expect

from trainer.web import modules
from trainer.web.gate import hash_of, page_policy
from trainer.web.modules import SCRIPT_TAG, collect_modules, wrap_module
from trainer.web.packing import Assets
from trainer.web.pages import PAGES, render
from trainer.web.pages import Page as WebPage

LATENCY_MS = 400.0
BYTES_PER_S = 50_000.0
READY_S = 3.0  # [s] that the helm may take from nothing on such a line
MOST_FILES = 4  # that a page asks for, the typeface among them
PAGES_MOST = 30_000  # [bytes] of any page, packed


def test_a_file_keeps_its_name_as_long_as_it_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    helm = next(page for page in PAGES if page.name == "helm")
    before, again = Assets(), Assets()
    html, _ = before.link(render(helm))
    assert again.link(render(helm))[0] == html
    assert before.files.keys() == again.files.keys()

    for name, kept in before.files.items():
        assert re.fullmatch(r"\w+\.[0-9a-f]{16}\.(js|css|woff2)", name)
        assert gzip.decompress(kept.packed) == kept.body

    folder = tmp_path / "assets"
    folder.mkdir()
    for path in modules.ASSETS_FOLDER.rglob("*.*"):
        copy = folder / path.relative_to(modules.ASSETS_FOLDER)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    with (folder / "js" / "gauges" / "course-ring.js").open("a") as script:
        script.write("const another = 1;\n")
    monkeypatch.setattr(modules, "ASSETS_FOLDER", folder)
    changed = Assets()
    changed.link(render(helm))
    gone = {name.split(".")[0] + name[-3:] for name in before.files.keys() - changed.files.keys()}
    assert gone == {"steering.js"}  # what all share has kept its name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name or "choice")
def test_the_import_map_leads_every_module_of_a_page_to_a_file_that_is_there(page: WebPage) -> None:
    html = render(page)
    assets = Assets()
    linked, inline = assets.link(html)
    places = json.loads(inline)["imports"]
    (script,) = re.findall(r'<script type="module" src="\./assets/(\S+)">', linked)

    entry = SCRIPT_TAG.findall(html)[0]
    text = (assets.files[script].body).decode()
    for module in collect_modules(entry, {}):
        own = f"M[{json.dumps(module)}] = (() =>" in text
        assert own or places[f"./assets/{module}"].removeprefix("./assets/") in assets.files
    for name in re.findall(r'"\./assets/([^"]+)"', re.sub(r'"imports":\{[^}]*\}', "", linked)):
        assert name in assets.files
    assert linked.index("importmap") < linked.index("modulepreload") < linked.index(script)
    assert hash_of(inline) in page_policy(inline)
    assert len(gzip.compress(linked.encode())) < PAGES_MOST


@pytest.mark.process
@pytest.mark.parametrize(
    "name", sample_cases([each.name for each in PAGES], "", "instructor", "helm", "kiosk")
)
def test_a_second_visit_asks_for_nothing_but_the_page(
    shared: Served, browser: Browser, name: str
) -> None:
    with slow_line(shared.port) as line, browser.new_context() as context:
        for wanted in (1 + MOST_FILES, 1):
            page = context.new_page()
            line.asked.clear()
            page.goto(f"{line.url}/{name}")
            if name != "kiosk":
                state = page.locator("#state")
                expect(state).not_to_have_text("CONNECTING", timeout=1000.0 * PATIENCE)
            asked = [path for path in line.asked if not path.startswith("/line")]
            assert asked[0] == f"/{name}"
            assert len(asked) <= wanted, asked
            page.close()


@pytest.mark.process
def test_a_file_is_packed_for_who_can_unpack_it_and_never_asked_for_again(shared: Served) -> None:
    html = request(shared.port, "/helm").body.decode()
    (script,) = re.findall(r'<script type="module" src="\.(\S+)">', html)
    packed = request(shared.port, script, Accept_Encoding="gzip, br")
    plain = request(shared.port, script)

    assert packed.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in plain.headers
    assert gzip.decompress(packed.body) == plain.body
    for each in (packed, plain):
        assert each.headers["cache-control"] == "public, max-age=31536000, immutable"
        assert "Accept-Encoding" in each.headers["vary"]
    assert request(shared.port, "/assets/js/draw.js").status == 404


@pytest.mark.slow
@pytest.mark.process
def test_the_helm_is_ready_in_three_seconds_on_a_slow_line(
    shared: Served, browser: Browser, capsys: pytest.CaptureFixture[str]
) -> None:
    taken = []
    for _ in range(3):  # the machine may be busy: the line is what is measured
        with browser.new_context() as context:
            page = context.new_page()
            line = context.new_cdp_session(page)
            line.send("Network.enable")
            speed = {"downloadThroughput": BYTES_PER_S, "uploadThroughput": BYTES_PER_S}
            how = {"offline": False, "latency": LATENCY_MS, **speed}
            line.send("Network.emulateNetworkConditions", how)
            page.goto(f"{shared.url}/helm", wait_until="commit")
            taken.append(page.evaluate(READY) / 1000.0)
    with capsys.disabled():
        print(f"\nhelm ready after {', '.join(f'{each:.2f}' for each in taken)} s")
    assert min(taken) < READY_S


READY = """() => new Promise((settle) => {
  const look = () => {
    const state = document.querySelector("#state")?.textContent;
    const digits = document.querySelector("course-ring .digits")?.textContent;
    if (["FROZEN", "RUNNING"].includes(state) && digits) settle(performance.now());
    else requestAnimationFrame(look);
  };
  look();
})"""


def test_lines_of_comments_are_left_out_and_a_cast_at_the_begin_of_a_line_stays() -> None:
    source = """// What it is.
/**
 * @param {number} one
 */
export function add(one) {
  /** @type {HTMLElement} */ (panel).hidden = true; // why
  // because
  return "// " + one;
}

/** @typedef {string} Name */
"""
    kept = ["  /** @type {HTMLElement} */ (panel).hidden = true; // why", '  return "// " + one;']
    text = wrap_module("js/a.js", source).splitlines()
    assert text[1:5] == ["function add(one) {", *kept, "}"]
    assert not any("because" in line or "typedef" in line for line in text)
