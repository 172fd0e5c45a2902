"""Hands on a page, three ways, and the truth about the boat from its session."""

import time
from typing import Final

import pytest
from playwright.sync_api import Locator, Page

from helpers.pages import PATIENCE
from trainer.session.stations.channels import CHANNELS
from trainer.verify.soak.session_process import Caller

WAYS: Final = ("mouse", pytest.param("touch", marks=pytest.mark.slow), "keyboard")

# Where something on a page is wider or higher than its place, or lies beyond the window.
CUT: Final = """() => {
  const found = [];
  const { scrollWidth, scrollHeight } = document.documentElement;
  if (scrollWidth > innerWidth || scrollHeight > innerHeight) found.push("the page");
  for (const each of document.querySelectorAll("main *")) {
    if (!each.checkVisibility() || each.closest("svg, .unseen")) continue;
    const [box, style] = [each.getBoundingClientRect(), getComputedStyle(each)];
    const name = `${each.tagName} ${each.className} ${each.id} ${each.textContent}`.slice(0, 80);
    const wide = each.scrollWidth > each.clientWidth + 1 && each.clientWidth > 0;
    const high = each.scrollHeight > each.clientHeight + 1 && each.clientHeight > 0;
    const rolls = ["auto", "scroll"].includes(style.overflowY);
    if (wide && style.textOverflow !== "ellipsis" && style.display !== "inline") found.push(name);
    if (high && !rolls && style.display !== "inline" && !wide) found.push(name);
    if (each.matches("button, input") && box.right > innerWidth + 1) found.push(name);
  }
  return found;
}"""


def work(page: Page, control: Locator, way: str) -> None:
    """Work a control with the mouse, a finger, or the keyboard."""
    if way == "mouse":
        control.click()
    elif way == "keyboard":
        control.focus()
        page.keyboard.press("Enter")
    else:
        control.scroll_into_view_if_needed()
        box = control.bounding_box()
        assert box
        page.touchscreen.tap(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


def read(caller: Caller, place: str) -> str:
    """Return what a session says of a place such as `valves.blow_aft`, at its latest tick."""
    channel, field = place.split(".")
    names = [each.name for each in CHANNELS[channel].fields]
    if channel not in caller.shown:
        assert caller.ask(f"subscribe {channel}")[0]
    assert caller.ask("who")[0]
    end = time.monotonic() + PATIENCE
    while channel not in caller.shown:
        assert caller.ask("who")[0]
        assert time.monotonic() < end, f"nothing comes of {channel}"
    return caller.shown[channel][2 + names.index(field)]


def step(caller: Caller, ticks: int) -> None:
    """Let a frozen session make ticks, and wait for the last of them."""
    read(caller, "gauges.depth")
    wanted = caller.tick + ticks
    assert caller.ask(f"step {ticks}")[0]
    end = time.monotonic() + PATIENCE
    while caller.tick < wanted:
        assert caller.ask("who")[0]
        assert time.monotonic() < end, f"tick {caller.tick} of {wanted}"
        time.sleep(0.005)


def await_truth(caller: Caller, place: str, wanted: str) -> None:
    """Wait until a session says this of a place."""
    end = time.monotonic() + PATIENCE
    while (now := read(caller, place)) != wanted:
        assert time.monotonic() < end, f"{place} is {now}, not {wanted}"
        time.sleep(0.02)
