"""A console of one's own session, drawn without a terminal: it gives an order, and ends the run.

It is what `trainer run` does where no process can be forked, but for the driver of the terminal.
"""

import asyncio
import sys

from textual.pilot import Pilot

from trainer.console.app import Console
from trainer.console.own_session import can_fork, sail_beside
from trainer.io import paths
from trainer.io.orders.grammar import Refused


async def attend(pilot: Pilot[Refused], app: Console) -> None:
    """Order a depth, look at its answer, and end the run."""
    while not app.model.joined:
        await pilot.pause(0.05)
    print("joined", paths.left_address()[0].rpartition(":")[0])
    app.model.order("depth 70")
    while not any(
        "70" in entry.text for entry in app.model.journal.entries if entry.kind == "answer"
    ):
        await pilot.pause(0.05)
    print("answered")
    app.model.order("quit")
    while not app.model.over:
        await pilot.pause(0.05)


def run(app: Console) -> str:
    """Run a console as its terminal would."""

    async def there() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await attend(pilot, app)

    asyncio.run(there())
    return ""


assert not can_fork()
Console.run = run  # type: ignore[assignment, method-assign]
code = sail_beside(["run", "--no-record", "--duration", "600"], None)
print("left", paths.left_address())
sys.exit(code)
