"""Hands on the plant of a page: its window, and the keys of what moves a surface."""

from typing import Final

from playwright.sync_api import Page, expect
from soak.session_process import Caller

from helpers.hands import await_truth, read, step, work
from helpers.waiting import eventually

# Rows and keys of the window, the field, and how it then stands: one of these words.
PLANT_KEYS: Final = (
    *((f"Pump {name}", "stop", f"pump_{name}", "stopped") for name in ("1", "2")),
    *((f"Pump {name}", "run", f"pump_{name}", "running standing by") for name in ("1", "2")),
    ("Vital pump", "stop", "pump_vital", "stopped"),
    ("Vital pump", "run", "pump_vital", "running standing by"),
    *(
        (row, key, f"{name}_oil", stands)
        for row, name in (
            *(("Main oil", "main"), ("Vital oil", "vital")),
            *(("Rudder leg", "rudder"), ("Stern leg", "stern"), ("Bow leg", "bow")),
        )
        for key, stands in (("Isolate", "isolated"), ("Open", "open"))
    ),
    ("Port bus", "Open", "port_breaker", "open"),
    ("Port bus", "Shut", "port_breaker", "shut"),
    ("Stbd bus", "Open", "starboard_breaker", "open"),
    ("Stbd bus", "Shut", "starboard_breaker", "shut"),
    ("Loads", "Shed", "loads", "shed"),
    ("Bus tie", "Shut", "tie", "shut"),
    ("Bus tie", "Open", "tie", "open"),
    ("Loads", "Back", "loads", "on"),
    ("Forward", "Fight fire", "party", "forward"),
    ("Control", "Fight fire", "party", "control"),
    ("Aft", "Fight fire", "party", "aft"),
    ("Ventilation", "Secure", "ventilation", "secured"),
    ("Ventilation", "Exhaust", "ventilation", "exhausting"),
    ("Ventilation", "run", "ventilation", "running"),
)
SHIFTS: Final = (("Emerg.", "emergency", 6), ("Hand", "hand", 124), ("Normal", "normal", 6))


def open_plant(page: Page, way: str = "mouse") -> None:
    """Open the window of the plant by its key."""
    opener = page.locator("#open-plant")
    expect(opener).to_be_visible()
    work(page, opener, way)
    expect(page.locator("#plant")).to_be_visible()


def close_plant(page: Page, way: str = "mouse") -> None:
    """Close the window of the plant by its own key."""
    work(page, page.locator("#plant h2 button"), way)
    expect(page.locator("#plant")).to_be_hidden()


def work_safe_depth(page: Page, way: str = "mouse") -> None:
    """Open the window of the safe depth by its key, and close it by its own."""
    opener, window = page.locator("#open-safe"), page.locator("#safe")
    expect(opener).to_be_visible()
    work(page, opener, way)
    expect(window).to_be_visible()
    work(page, window.locator("h2 button"), way)
    expect(window).to_be_hidden()


def work_window(page: Page, caller: Caller, way: str) -> None:
    """Work every key of the window's rows, and await what the session and the page say of it."""
    for row, key, field, stands in PLANT_KEYS:

        def is_done(field: str = field, stands: str = stands) -> bool:
            return read(caller, f"plant.{field}") in stands

        found = page.locator(f"#plant button[aria-label='{row}: {key}']")
        work(page, found, way)
        step(caller, 1)
        assert eventually(is_done), (row, key, stands)
        expect(found).to_have_attribute("aria-pressed", "true")


def work_supplies(page: Page, caller: Caller, way: str, within: str, surfaces: list[str]) -> None:
    """Shift surfaces to each mode by the keys in a part of a page."""
    for name in surfaces:
        keys = page.locator(f"{within} supply-keys[name={name}]")
        for word, mode, ticks in SHIFTS:
            key = keys.locator(f"button[aria-label^='{word}']")
            work(page, key, way)
            step(caller, 1)
            expect(key).to_have_attribute("data-coming", "")
            expect(key).to_have_attribute("aria-pressed", "false")
            step(caller, ticks)
            await_truth(caller, f"supply.{name}_supply", mode)
            expect(key).to_have_attribute("aria-pressed", "true")
