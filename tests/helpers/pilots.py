"""Screens under test go on as soon as nothing is left to do."""

import asyncio
import sys
from typing import Final

import pytest

# of the event loop; the longest chain of messages after a key takes some ten
REST_TURNS: Final = 100


async def await_rest(*_: float) -> None:
    """Wait until the loop has gone round so often that all but timers is done.

    Textual's own wait looks at the processor: of a process in which other threads work, or on a
    machine that is busy, it waits for a second after each key.
    """
    for _turn in range(REST_TURNS):
        await asyncio.sleep(0)


@pytest.fixture(autouse=True)
def prompt_pilot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the pilots of screens wait for what is to be done, and for no time."""
    if "textual.pilot" in sys.modules:
        for user in ("app", "pilot"):
            monkeypatch.setattr(f"textual.{user}.wait_for_idle", await_rest)
