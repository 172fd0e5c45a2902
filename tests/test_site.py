"""The site of the documents: what a page may load, and the whole of it, built and looked at."""

import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from helpers.address import project_urls
from helpers.loaded import loaded_from_outside
from helpers.notebooks import NOTEBOOKS
from helpers.pages import Heard
from helpers.places import CHECKOUT, ROOT, environment
from playwright.sync_api import Browser, Page, expect

ELSEWHERE = "https://example.org/a"
LOADED = (
    f'<script src="{ELSEWHERE}"></script>',
    '<img src="//example.org/a">',
    f'<img srcset="a.png 1x, {ELSEWHERE} 2x">',
    f'<link rel="preload stylesheet" href="{ELSEWHERE}">',
    f'<svg><use href="{ELSEWHERE}"/></svg>',
    f"<style>@import '{ELSEWHERE}';</style>",
    f'<p style="background: url({ELSEWHERE})">',
    f'@font-face {{ src: url("{ELSEWHERE}") }}',
)
NOT_LOADED = (
    f'<a href="{ELSEWHERE}">there</a>',
    f'<link rel="canonical" href="{ELSEWHERE}">',
    '<img src="images/a.png"><script src="../a.js"></script>',
    '<img src="data:image/png;base64,AAAA">',
    f"<p>{ELSEWHERE}</p>",
)
SIZES = ((390, 844), (1366, 768))
SAILED = "stern-plane-jam.html"


@pytest.mark.parametrize("text", LOADED)
def test_what_comes_from_another_host_is_seen(text: str) -> None:
    assert len(loaded_from_outside(text)) == 1


@pytest.mark.parametrize("text", NOT_LOADED)
def test_a_link_to_another_host_and_a_file_beside_are_no_fault(text: str) -> None:
    assert loaded_from_outside(text) == []


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the site, built strictly by the tools from the package index."""
    tools, place = tmp_path_factory.mktemp("tools"), urlsplit(project_urls()["Homepage"]).path
    folder = tmp_path_factory.mktemp("host") / place.strip("/")  # as its host has it
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]["site"]
    pip = (sys.executable, "-m", "pip", "install", "--quiet", "--target", str(tools))
    subprocess.run([*pip, *wanted], check=True)
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env=environment() | {"PYTHONPATH": f"{CHECKOUT}:{tools}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert re.search(
        r"^\d+ pages, [\d.]+ MB, nothing from another host$", done.stdout, re.MULTILINE
    )
    return folder


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Return where the site is served."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(site.parent))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/{site.name}"
        server.shutdown()


@pytest.fixture
def opened(browser: Browser, address: str) -> Iterator[Page]:
    """Return a page; at its end nothing has come from another host, or gone wrong."""
    page, heard = browser.new_page(), Heard()
    page.on("console", lambda said: heard.console.append(said.text))
    page.on("pageerror", lambda error: heard.console.append(str(error)))
    page.on("request", lambda request: heard.requests.append(request.url))
    yield page
    page.close()
    assert not heard.console
    assert not heard.foreign(address)


@pytest.mark.slow
@pytest.mark.process
def test_every_document_is_a_page_of_the_site(site: Path) -> None:
    names = {path.stem for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"))} - {"README"}
    names |= {f"{path.stem}-notebook" for path in NOTEBOOKS}
    names |= {"documents", "sail", "pictures", "api"}

    there = {path.stem for path in site.glob("*.html")}
    assert there == names | {"404", Path(SAILED).stem}
    for path in ROOT.glob("docs/images/*"):
        assert (site / "images" / path.name).read_bytes() == path.read_bytes()


@pytest.mark.slow
def test_every_page_of_the_site_fits_and_asks_no_other_host(
    site: Path, address: str, opened: Page
) -> None:
    for width, height in SIZES:
        opened.set_viewport_size({"width": width, "height": height})
        for path in sorted(site.glob("*.html")):
            opened.goto(f"{address}/{path.name}")
            wide = opened.evaluate("document.documentElement.scrollWidth")
            assert wide <= width, path.name


@pytest.mark.slow
def test_the_site_is_searched(address: str, opened: Page) -> None:
    opened.goto(f"{address}/index.html")

    opened.get_by_placeholder("Search").fill("hydroplane jam")

    expect(opened.locator(".md-search-result__item").first).to_be_visible()


@pytest.mark.slow
def test_the_boat_of_the_site_is_sailed(address: str, opened: Page) -> None:
    opened.goto(f"{address}/sail.html")

    opened.get_by_role("link", name="Go aboard").click()
    opened.get_by_role("button", name="Take over at 01:06").click()

    expect(opened.locator("#state")).to_have_attribute("data-state", "running")
