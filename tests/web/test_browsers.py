"""Pages in more than one browser, by TLS, and on lines that lose packets and break."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.browser import Look, Serve
from helpers.firefox import Tab, firefox
from helpers.pages import Served
from helpers.slow_line import slow_line
from helpers.waiting import PATIENCE
from helpers.wire import make_certificate
from playwright.sync_api import Browser, WebSocketRoute, expect
from soak.session_process import Caller

from trainer.web.pages import PAGES

pytestmark = pytest.mark.process

STATE = "document.querySelector('#state').textContent"
SLOW_S = 0.15  # [s] one way
LOSS = 0.05  # of all packets


@pytest.fixture(scope="module")
def fox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    """Return a tab of one Firefox for the tests of this module."""
    with firefox(tmp_path_factory.mktemp("fox") / "profile") as tab:
        yield tab


def test_a_line_that_did_well_is_dialled_again_within_a_second(shared: Served, look: Look) -> None:
    page = look(shared, "helm")
    lines: list[tuple[float, WebSocketRoute]] = []

    def carry(line: WebSocketRoute) -> None:
        line.connect_to_server()
        lines.append((time.monotonic(), line))

    page.route_web_socket("**/*", carry)
    page.reload()
    expect(page.locator("angle-dial .digits").first).not_to_be_empty()
    broken = time.monotonic()
    lines[0][1].close(code=1011)
    while len(lines) < 2:
        page.wait_for_timeout(20.0)  # [ms] in which the browser's events are heard
        assert time.monotonic() - broken < PATIENCE, "it is not dialled again"
    assert lines[1][0] - broken < 3.0  # [s]; a line that fails again and again waits for five


@pytest.mark.slow
@pytest.mark.parametrize("name", [each.name for each in PAGES if each.name not in ("", "kiosk")])
@pytest.mark.usefixtures("instructor")
def test_a_page_works_in_firefox(shared: Served, fox: Tab, name: str) -> None:
    fox.open(f"{shared.url}/{name}?lang=de")
    fox.await_that(f"{STATE} === 'ANGEHALTEN'")
    digits = {"wall": "#depth", "scope": "#time", "ballast": "[data-place='gauges.depth']"}
    place = digits.get(name, ".digits, #truth tbody td")
    fox.await_that(f"document.querySelector({place!r}).textContent")
    assert fox.evaluate("document.documentElement.lang") == "de"


@pytest.mark.slow
@pytest.mark.usefixtures("instructor")
def test_in_firefox_a_lever_orders_and_a_second_visit_asks_for_the_page_alone(
    shared: Served, fox: Tab
) -> None:
    with slow_line(shared.port) as line:
        fox.open(f"{line.url}/pilot?lang=en")
        fox.await_that(f"{STATE} === 'FROZEN'")
        knob = "document.querySelector('order-lever[name=stern] [role=slider]')"
        press = "new KeyboardEvent('keydown', { key: 'ArrowUp', bubbles: true })"
        fox.evaluate(f"String({knob}.dispatchEvent({press}))")
        fox.await_that("document.querySelector('#answer').textContent.includes('stern rise 1')")
        line.asked.clear()
        fox.open(f"{line.url}/pilot?lang=en")
        fox.await_that(f"{STATE} === 'FROZEN'")
        assert [each for each in line.asked if not each.startswith("/line")] == ["/pilot?lang=en"]


# TLS


@pytest.fixture
def secure(serve: Serve, tmp_path: Path) -> Served:
    """Return a session whose pages are encrypted, and ask for a word."""
    cert, key = make_certificate(tmp_path)
    return serve("--token", "mast", "--web-cert", str(cert), "--web-key", str(key))


@pytest.mark.slow
def test_firefox_comes_in_by_tls(secure: Served, fox: Tab) -> None:
    fox.open(f"{secure.url.replace('http', 'https')}/helm?lang=en")
    fox.await_that(f"{STATE} === 'ROLE?'")
    fox.evaluate("String(document.querySelector('#word input').value = 'mast')")
    fox.evaluate("String(document.querySelector('#word form').requestSubmit())")
    fox.await_that(f"{STATE} === 'FROZEN'")


# Lines that are slow, lose packets, and break


def test_on_a_line_that_is_slow_and_loses_packets_every_order_is_obeyed_once(
    shared: Served, instructor: Caller, browser: Browser
) -> None:
    with slow_line(shared.port, SLOW_S, LOSS) as line, browser.new_context() as context:
        page = context.new_page()
        page.goto(f"{line.url}/pilot")
        expect(page.locator("#state")).to_have_text("FROZEN")
        knob = page.locator("order-lever[name=stern] [role=slider]")
        knob.press("Home")
        for _ in range(10):
            knob.press("ArrowUp")
        expect(page.locator("#answer")).to_contain_text("stern rise 10")
        expect(knob).to_have_attribute("aria-valuenow", "10")
        expect(page.locator("#state")).to_have_text("FROZEN")
        assert line.lost

    assert instructor.ask("subscribe diving at 2 hz")[0]
    end = time.monotonic() + PATIENCE
    while "10.0" not in instructor.shown.get("diving", ()):
        assert time.monotonic() < end
        instructor.ask("who")
