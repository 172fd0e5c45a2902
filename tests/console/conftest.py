"""Screens under test go on as soon as nothing is left to do."""

import asyncio

import pytest


async def await_rest(*_: float) -> None:
    """Wait until nothing but timers is left to run.

    Textual's own wait looks at the processor: of a process in which other threads work, or on a
    machine that is busy, it waits for a second after each key.
    """
    ready = asyncio.get_running_loop()._ready  # type: ignore[attr-defined]  # noqa: SLF001
    await asyncio.sleep(0)
    while ready:  # noqa: ASYNC110  there is no event to wait for
        await asyncio.sleep(0)


@pytest.fixture(autouse=True)
def prompt_pilot(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the pilots of screens wait for what is to be done, and for no time."""
    for user in ("app", "pilot"):
        monkeypatch.setattr(f"textual.{user}.wait_for_idle", await_rest)
