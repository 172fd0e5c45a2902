"""What waits long: a freeze of ten minutes, and a tablet that sleeps in it."""

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.browser import Serve
from helpers.pages import QUIET, find_chromium, free_port
from helpers.waiting import PATIENCE, once_it_can
from playwright.sync_api import Browser, Error, Page, expect
from soak.session_process import Caller

A_FREEZE = 600.0  # [s]
A_SLEEP = 75.0  # [s] the server gives up who answers no ping for 40
LATER = 1e3 * PATIENCE  # [ms]
STATIONS = ("instructor", "helm", "ballast", "wall")


@contextlib.contextmanager
def tablet(folder: Path) -> Iterator[tuple[int, str]]:
    """Run a browser in a process group of its own; give the group, and where it is driven."""
    port = free_port()
    own = ["--headless=new", f"--remote-debugging-port={port}", f"--user-data-dir={folder}"]
    process = subprocess.Popen(
        [find_chromium(), *QUIET, *own],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process.pid, f"http://127.0.0.1:{port}"
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(PATIENCE)


def driven(browser: Browser, where: str) -> Browser:
    """Return that browser, once it answers."""
    return once_it_can(lambda: browser.browser_type.connect_over_cdp(where), Error)


def aboard(instructor: Caller) -> int:
    """Return how many of the stations are there, the one that asks left out."""
    assert instructor.ask("who")[0]
    return sum(" local " in f" {line}" for line in instructor.said) - 1


def all_say(pages: list[Page], state: str) -> None:
    for page in pages:
        expect(page.locator("#state")).to_have_text(state, timeout=LATER)


@pytest.mark.slow
def test_a_freeze_of_ten_minutes_and_a_tablet_asleep_in_it_end_by_themselves(
    serve: Serve, browser: Browser, tmp_path: Path
) -> None:
    session = serve()
    instructor = session.attach()
    since = time.monotonic()
    with tablet(tmp_path) as (group, where):
        context = driven(browser, where).contexts[0]
        pages = [context.new_page() for _ in STATIONS]
        for page, name in zip(pages, STATIONS, strict=True):
            page.goto(f"{session.url}/{name}")
        all_say(pages, "FROZEN")
        assert aboard(instructor) == len(STATIONS)

        os.killpg(group, signal.SIGSTOP)
        time.sleep(A_SLEEP)
        assert aboard(instructor) == 0
        os.killpg(group, signal.SIGCONT)
        all_say(pages, "FROZEN")
        assert aboard(instructor) == len(STATIONS)

        time.sleep(max(since + A_FREEZE - time.monotonic(), 0.0))
        all_say(pages, "FROZEN")
        assert instructor.ask("run")[0]
        all_say(pages, "RUNNING")
        for page in pages:
            expect(page.locator("#time")).not_to_have_text("00:00", timeout=LATER)
