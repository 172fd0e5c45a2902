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
from pathlib import Path

from helpers.pages import PALETTES, QUIET, SIZES, Served, find_chromium, served
from helpers.waiting import await_begun
from playwright.sync_api import Browser, Playwright, sync_playwright
from soak.session_process import Caller

from trainer.console.app import Console
from trainer.console.client import Client
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel
from trainer.console.pane import GROUND_COLOUR
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
PAGE_PICTURES = (  # of the documents: page, size, palette
    ("instructor", "desk", "dusk"),
    ("helm", "laptop", "dusk"),
    ("ballast", "tablet", "day"),
    ("pilot", "phone", "night"),
    ("planes", "laptop", "day"),
    ("scope", "laptop", "dusk"),
    ("wall", "laptop", "dusk"),
    ("kiosk", "tablet", "dusk"),
)
THERE = "[data-state=running], [data-state=frozen], [data-scene=dive]"
NAMES = [page.name for page in PAGES]
UNDER_WAY = (
    *("depth 80", "course 030", "at 70 order course 060", "at 80 order depth 80"),
    *("at 90 course 060", "at 100 casualty stern-slow", "time 20", "run"),
)
SHOWN = 220  # [ticks] into the run
SHIPS = """\
schema = "exercise/1"
name = "Traffic"
briefing = "Look round."
light = "dusk"
duration_s = 3600
[initial]
speed_kn = 5
depth_m = 17
[sea]
sea_state = 4
direction_deg = 60
[[contact]]
name = "ferry"
type = "ferry"
points = [[1500, -60]]
course_deg = 70
status = "under way"
[[contact]]
name = "smack"
type = "fishing"
points = [[600, 80]]
course_deg = 300
"""


async def look(role: str, size: tuple[int, int], where: str, seconds: float) -> None:
    """Look at a session until ``seconds`` of its time; keep what is seen."""
    client = Client(lambda: where, role, wishes(LAYOUTS[role]))
    client.start()
    app = Console(SessionModel(client, role, LAYOUTS[role].charts))
    async with app.run_test(size=size) as pilot:
        while app.model.picture.seconds < seconds:
            await pilot.pause(0.1)
        svg = svg_of(app, role)
    client.close(1.0)
    (IMAGES / f"{role}.svg").write_text(svg, encoding="utf-8")


def svg_of(app: Console, role: str) -> str:
    """Return what a console shows, without fonts from elsewhere."""
    svg = app.export_screenshot(title=f"trainer: {role}")
    svg = re.sub(r"@font-face \{.*?\}\s*", "", svg, flags=re.DOTALL)
    svg = svg.replace("Fira Code, monospace", "monospace")
    svg = re.sub(rf'<rect fill="{GROUND_COLOUR}"[^>]*/>', "", svg).replace("#292929", GROUND_COLOUR)
    return re.sub(r"[ \t]+$", "", svg, flags=re.MULTILINE)


def draw() -> None:
    """Draw them all."""
    with tempfile.TemporaryDirectory() as folder:
        orders, where = Path(folder) / "orders.txt", Path(folder) / "session.sock"
        orders.write_text(ORDERS, encoding="utf-8")
        serve = [sys.executable, "-m", "trainer", "serve", "--socket", str(where)]
        options = ["--listen", "none", "--no-record", "--speed", "4", "--orders", str(orders)]
        with subprocess.Popen([*serve, *options]) as session:
            await_begun(session, where.exists)
            for role, size, seconds in PICTURES:
                asyncio.run(look(role, size, str(where), seconds))
            session.terminate()


def sail(instructor: Caller) -> None:
    """Sail until there is something to see."""
    for words in UNDER_WAY:
        assert instructor.ask(words)[0], words
    instructor.ask("subscribe time")
    while instructor.tick < SHOWN:
        instructor.ask("who")
    instructor.ask("time 4")


def look_out(instructor: Caller) -> None:
    """Raise the periscope, and wait until it is up."""
    for words in ("scope raise", "run", "subscribe time"):
        assert instructor.ask(words)[0], words
    while instructor.tick < 20:
        instructor.ask("who")


def open_chromium(driver: Playwright) -> Browser:
    """Return a browser that asks for nothing itself."""
    return driver.chromium.launch(executable_path=find_chromium(), args=QUIET)


def draw_page(browser: Browser, session: Served, what: tuple[str, str, str], path: Path) -> None:
    """Draw one page at a size and in a palette."""
    name, size, palette = what
    width, height = SIZES[size]
    with browser.new_page(viewport={"width": width, "height": height}) as page:
        page.goto(f"{session.url}/{name}?palette={palette}")
        if name == "kiosk":
            page.locator("#start").click()
        page.wait_for_selector(THERE)
        if name == "planes":
            page.locator("#open-safe").click()
        page.wait_for_timeout(4000)  # pointers settle, and the past has come
        page.screenshot(path=path)


def draw_pages(folder: Path | None) -> None:
    """Draw the pages of the documents, or all that there are into a folder."""
    every = [(n, s, p) for n in NAMES for s in SIZES for p in PALETTES]
    wanted = every if folder else PAGE_PICTURES
    with (
        sync_playwright() as driver,
        open_chromium(driver) as browser,
        tempfile.TemporaryDirectory() as kept,
    ):
        ships = Path(kept) / "ships.toml"
        ships.write_text(SHIPS, encoding="utf-8")
        for exercise, names, begin in (
            ((), set(NAMES) - {"kiosk", "scope"}, sail),
            ((str(ships),), {"scope"}, look_out),
            (("visitor-dive",), {"kiosk"}, None),
        ):
            with served(*exercise, "--no-record", "--speed", "4", frozen=False) as session:
                instructor = session.attach()
                if begin:
                    begin(instructor)
                instructor.hang_up()
                for what in (each for each in wanted if each[0] in names):
                    draw_page(browser, session, what, file_of(what, folder))


def file_of(what: tuple[str, str, str], folder: Path | None) -> Path:
    """Return where the picture of a page, a size and a palette is kept."""
    name = what[0] or "first"
    return folder / f"{'-'.join((name, *what[1:]))}.png" if folder else IMAGES / f"page-{name}.png"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        Path(sys.argv[1]).mkdir(parents=True, exist_ok=True)
        draw_pages(Path(sys.argv[1]))
    else:
        draw()
        draw_pages(None)
