"""Draw the pictures of screens and pages for the documents, by `python tests/pictures.py`.

A session is served for them, ordered about, and looked at; docs/images gets what is seen.
`python tests/pictures.py FOLDER` draws every page there, at every size and in every palette: look
at them all.
"""

import asyncio
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from helpers.pages import PALETTES, QUIET, SIZES, Served, find_chromium, served
from playwright.sync_api import Browser, sync_playwright

from trainer.console.app import Console
from trainer.console.client import Client
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.console.pane import GROUND
from trainer.web.pages import PAGES

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
PAGE_PICTURES = (  # of docs/browser.md: page, size, palette
    ("instructor", "desk", "dusk"),
    ("helm", "laptop", "dusk"),
    ("ballast", "tablet", "day"),
    ("pilot", "phone", "night"),
    ("wall", "laptop", "dusk"),
    ("kiosk", "tablet", "dusk"),
)
NAMES = [page.name for page in PAGES]
UNDER_WAY = ("order course 060", "order depth 80", "depth 80", "course 030", "run")


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


def draw_page(browser: Browser, session: Served, what: tuple[str, str, str], path: Path) -> None:
    """Draw one page at a size and in a palette."""
    name, size, palette = what
    width, height = SIZES[size]
    with browser.new_page(viewport={"width": width, "height": height}) as page:
        page.goto(f"{session.url}/{name}?palette={palette}")
        page.wait_for_selector("[data-state=running], [data-state=frozen]")
        page.wait_for_timeout(1500)  # pointers settle
        page.screenshot(path=path)


def draw_pages(folder: Path | None) -> None:
    """Draw the pages of the documents, or all that there are into a folder."""
    every = [(n, s, p) for n in NAMES for s in SIZES for p in PALETTES]
    wanted = every if folder else [each for each in PAGE_PICTURES if each[0] in NAMES]
    with (
        served("--no-record", "--speed", "4", frozen=False) as session,
        sync_playwright() as driver,
        driver.chromium.launch(executable_path=find_chromium(), args=QUIET) as browser,
    ):
        instructor = session.attach()
        for words in UNDER_WAY:
            instructor.ask(words)
        for name, size, palette in wanted:
            file = f"{name or 'first'}-{size}-{palette}.png" if folder else f"page-{name}.png"
            draw_page(browser, session, (name, size, palette), (folder or IMAGES) / file)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
        draw_pages(Path(sys.argv[1]))
    else:
        draw()
        draw_pages(None)
