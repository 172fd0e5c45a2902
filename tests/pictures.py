"""Draw the pictures of the screens for the documents, by `python tests/pictures.py`.

A session is served for them, ordered about, and looked at; docs/images gets what is seen.
"""

import asyncio
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from trainer.console.app import Console
from trainer.console.client import Client
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.console.pane import GROUND

IMAGES = Path(__file__).parent.parent / "docs" / "images"
ORDERS = """\
20 depth 80
35 course 030
105 order course 060
110 order depth 90
50 snapshot leaving-60-m
70 casualty stern-stuck
80 bow planes rise 8
95 clear stern-stuck
98 planes auto
100 sea state 4
"""
PICTURES = (
    ("instructor", (132, 40), 115.0),
    ("helm", (80, 24), 140.0),
    ("ballast", (80, 24), 150.0),
)


async def look(role: str, size: tuple[int, int], where: str, seconds: float) -> None:
    """Look at a session until ``seconds`` of its time; keep what is seen."""
    client = Client(lambda: where, role, wishes(LAYOUTS[role]))
    client.start()
    app = Console(SessionModel(client, role, LAYOUTS[role].charts))
    async with app.run_test(size=size) as pilot:
        while app.model.picture.seconds < seconds:
            await pilot.pause(0.1)
        svg = app.export_screenshot(title=f"trainer: {role}")
    client.close(1.0)
    svg = re.sub(r"@font-face \{.*?\}\s*", "", svg, flags=re.DOTALL)  # no fonts from elsewhere
    svg = svg.replace("Fira Code, monospace", "monospace")
    svg = re.sub(rf'<rect fill="{GROUND}"[^>]*/>', "", svg).replace("#292929", GROUND)
    svg = re.sub(r"[ \t]+$", "", svg, flags=re.MULTILINE)
    (IMAGES / f"{role}.svg").write_text(svg, encoding="utf-8")


def draw() -> None:
    """Draw them all."""
    with tempfile.TemporaryDirectory() as folder:
        orders, where = Path(folder) / "orders.txt", Path(folder) / "session.sock"
        orders.write_text(ORDERS, encoding="utf-8")
        serve = [sys.executable, "-m", "trainer", "serve", "--socket", str(where)]
        options = ["--listen", "none", "--no-record", "--speed", "4", "--orders", str(orders)]
        with subprocess.Popen([*serve, *options]) as session:
            while not where.exists():
                time.sleep(0.1)
            for role, size, seconds in PICTURES:
                asyncio.run(look(role, size, str(where), seconds))
            session.terminate()


if __name__ == "__main__":
    draw()
