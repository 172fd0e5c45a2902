"""The instructor's page and its time line, worked by the mouse; a session flown to a moment."""

import re
from functools import partial

from playwright.sync_api import Page, expect
from soak.session_process import Caller

from helpers.browser import Look
from helpers.pages import Served
from helpers.waiting import PATIENCE, await_that


def settled(session: Served, look: Look, size: str = "desk", **how: object) -> Page:
    """Return the page, with no window before it."""
    page = look(session, "instructor", size=size, **how)
    expect(page.locator("#state")).to_have_text(re.compile("FROZEN|RUNNING"))
    expect(page.locator("#truth tr[data-of='depth'] td >> nth=0")).not_to_be_empty()
    expect(page.locator("#offers li").first).to_be_attached()
    page.keyboard.press("Escape")
    expect(page.locator("#exercise")).to_be_hidden()
    return page


def drag(page: Page, seconds: float, upon: str = "time-line .track") -> None:
    """Drag with the mouse on the time line to a moment."""
    await_that(page.locator(upon).bounding_box)  # a lane may be drawn anew just now
    box = page.locator(upon).bounding_box()
    assert box
    end = page.locator("time-line").evaluate("(line) => line.flown.end")
    high = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] * (seconds + 8.0) / end, high)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * seconds / end, high, steps=3)
    page.mouse.up()


def fly(caller: Caller, seconds: float, pace: str = "max") -> float:
    """Sail fast for so long, then stand still; return the time [s] there."""
    end = seconds_of(caller) + seconds
    assert caller.ask(f"time {pace}")[0]
    while (left := end - (now := seconds_of(caller))) > 0.0:
        steps = min(left, 500.0)
        assert caller.ask(f"step {steps / 0.5:.0f}")[0]
        await_that(partial(has_come_to, caller, now + steps))
    assert caller.ask("time 1")[0]
    return seconds_of(caller)


def has_come_to(caller: Caller, seconds: float) -> bool:
    """Return whether the present moment is at a time [s], or later."""
    return seconds_of(caller) >= seconds


def drawn(page: Page, seconds: float) -> None:
    """Wait until the time line has been drawn up to a time [s]."""
    page.wait_for_function(
        "(now) => document.querySelector('time-line').flown.now >= now",
        arg=seconds,
        timeout=1000.0 * PATIENCE,
    )


def seconds_of(caller: Caller) -> float:
    """Return the time of the present moment [s]."""
    assert caller.ask("branches")[0]
    (now,) = re.findall(r"to ([\d.]+) s;[^;]*; the present one", "\n".join(caller.said))
    return float(now)
