"""A browser and sessions with pages, for the tests of the pages."""

import functools
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright
from soak.session_process import Caller

from helpers.pages import QUIET, SIZES, Heard, Served, find_chromium, served
from helpers.waiting import PATIENCE
from trainer.io.orders.sentences import order_sentence

Serve = Callable[..., Served]
Look = Callable[..., Page]

IN_VAIN = "ERR_CONNECTION_REFUSED"  # a browser says it on the console
LAST_TAG = "999999"  # which no page has come to
NAME_LINE = """window.WebSocket = class extends WebSocket {
  constructor(...how) { super(...how); window.line = this; }
};"""
# what is answered comes behind all that was told before; the second frame shows it
HEAR_ALL = f"""(asks) => new Promise((done) => {{
  const hear = ({{ data }}) => {{
    if (!String(data).includes("$TRA,{LAST_TAG},ok")) return;
    window.line.removeEventListener("message", hear);
    requestAnimationFrame(() => requestAnimationFrame(done));
  }};
  window.line.addEventListener("message", hear);
  window.line.send(asks);
}})"""

expect.set_options(timeout=1000.0 * PATIENCE)  # [ms]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Return one Chromium for all tests of a process."""
    chromium = find_chromium()
    with (
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=chromium, args=QUIET) as opened,
    ):
        yield opened


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Return a function that serves a session with pages: ``serve("periscope-depth")``."""
    with ExitStack() as stack:
        yield lambda *words, **how: stack.enter_context(served(*words, **how))


@pytest.fixture(scope="module")
def shared() -> Iterator[Served]:
    """Return one session, free of any exercise, for the tests of a module that change little."""
    with served() as session:
        yield session


@pytest.fixture
def instructor(shared: Served) -> Caller:
    """Return the instructor's line to the shared session, which is frozen and as at its start."""
    caller = shared.callers[0] if shared.callers else shared.attach()
    for words in ("freeze", "reset"):
        assert caller.ask(words)[0]
    caller.ask("clear all")
    caller.news.clear()
    caller.shown.clear()  # of the moment before
    return caller


@pytest.fixture
def look(browser: Browser) -> Iterator[Look]:
    """Return a function that opens a page: ``look(session, "helm", size="phone")``."""
    with looking(browser) as open_page:
        yield open_page


@pytest.fixture(scope="module")
def kept(browser: Browser, shared: Served) -> Iterator[Look]:
    """Return a function that shows a page of the shared session: ``kept("helm", "phone")``.

    The page takes touches, and stays open for the tests of a module. Each time it has heard all
    that was told before, and is laid out for the size that is asked for.
    """
    with looking(browser) as look:
        page_of = functools.cache(functools.partial(look, shared, script=NAME_LINE, has_touch=True))

        def show(name: str, size: str = "laptop") -> Page:
            page, (width, height) = page_of(name), SIZES[size]
            page.set_viewport_size({"width": width, "height": height})
            expect(page.locator("[data-state=connecting]")).to_have_count(0)
            hear_all(page)
            return page

        yield show


def hear_all(page: Page) -> None:
    """Wait until a kept page has heard what its session has told it so far, and shows it."""
    page.evaluate(HEAR_ALL, order_sentence("who", LAST_TAG))


@contextmanager
def looking(browser: Browser) -> Iterator[Look]:
    """Yield a function that opens pages, which stay open while the block lasts.

    It draws each reading once, as for who wants no motion, because pictures between the ticks
    would cost a third of a processor; ``reduced_motion="no-preference"`` draws them. At the end the
    test fails where a page has said something on its console, or has asked elsewhere.
    """
    with ExitStack() as stack:
        pages: list[tuple[Served, Heard]] = []

        def open_page(
            session: Served,
            name: str = "",
            size: str = "laptop",
            query: str = "",
            script: str = "",
            **how: object,
        ) -> Page:
            width, height = SIZES[size]
            viewport = {"width": width, "height": height}
            calm = {"reduced_motion": "reduce"} | how
            context = browser.new_context(viewport=viewport, **calm)  # type: ignore[arg-type]
            stack.callback(context.close)
            context.set_default_timeout(1000.0 * PATIENCE)  # [ms] of clicks, as of `expect`
            page, heard = context.new_page(), Heard()
            pages.append((session, heard))
            page.on("console", lambda said: heard.console.append(said.text))
            page.on("pageerror", lambda error: heard.console.append(str(error)))
            page.on("request", lambda request: heard.requests.append(request.url))
            page.on("websocket", lambda line: heard.requests.append(line.url))
            if script:
                page.add_init_script(script)
            page.goto(f"{session.url}/{name}{query}")
            return page

        yield open_page
        for session, heard in pages:
            over = session.process.poll() is not None  # then the page dials in vain, twice a second
            assert not [each for each in heard.console if not (over and IN_VAIN in each)]
            assert not heard.foreign(session.url)
