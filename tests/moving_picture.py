"""Draw the README's moving picture of a console and a page, by `python tests/moving_picture.py`.

A session is served, dives and turns. Its planes at a terminal and its helm on a telephone are
looked at side by side, every few seconds; docs/images/session.png (APNG) gets what is seen.
"""

import asyncio
import base64
import io
from typing import Final

from helpers.pages import PALETTES, QUIET, SIZES, Served, find_chromium, served
from pictures import IMAGES, THERE, svg_of
from PIL import Image
from playwright.async_api import Browser, Page, async_playwright

from trainer.console.app import Console
from trainer.console.client import Client
from trainer.console.layouts import LAYOUTS, wishes
from trainer.console.model import SessionModel

ORDERS: Final = ("depth 80", "course 060", "time 4")
CONSOLE_ROLE: Final = "planes"
PAGE: Final = "helm"
CONSOLE_SIZE: Final = (80, 24)  # [columns, lines]
PICTURE_SIZE: Final = (905, 420)  # [pixels]
INTERVAL_S: Final = 5.0  # of the session's time, from one picture to the next
PICTURES: Final = 20
SHOWN_MS: Final = 250  # each; the last one stands longer
LAST_SHOWN_MS: Final = 2500
COLOURS: Final = 32
FRAME: Final = """\
<body style="margin:0; background:#0c1116; display:flex; align-items:center; gap:12px">
<img src="data:image/svg+xml;base64,{console}" style="height:420px; flex:none">
<img src="data:image/png;base64,{page}" style="height:420px; flex:none">
"""


async def watch(browser: Browser, session: Served) -> list[tuple[str, bytes]]:
    """Return what a console and a page show at the same moments: SVG and PNG."""
    client = Client(lambda: str(session.socket), CONSOLE_ROLE, wishes(LAYOUTS[CONSOLE_ROLE]))
    client.start()
    app = Console(SessionModel(client, CONSOLE_ROLE, LAYOUTS[CONSOLE_ROLE].charts))
    width, height = SIZES["phone"]
    page = await browser.new_page(viewport={"width": width, "height": height})
    await page.goto(f"{session.url}/{PAGE}?palette={PALETTES[0]}")
    await page.wait_for_selector(THERE)
    seen = []
    async with app.run_test(size=CONSOLE_SIZE) as pilot:
        instructor = session.attach()
        for words in ORDERS:
            assert instructor.ask(words)[0], words
        begin_s = app.model.picture.seconds
        for number in range(PICTURES):
            while app.model.picture.seconds < begin_s + number * INTERVAL_S:
                await pilot.pause(0.05)
            shot = await page.screenshot()
            seen.append((svg_of(app, CONSOLE_ROLE), shot))
    client.close(1.0)
    return seen


async def compose(page: Page, console: str, shot: bytes) -> Image.Image:
    """Return a console and a page side by side."""
    texts = {"console": console.encode(), "page": shot}
    await page.set_content(
        FRAME.format(**{name: base64.b64encode(each).decode() for name, each in texts.items()})
    )
    return Image.open(io.BytesIO(await page.screenshot())).convert("RGB")


async def draw() -> None:
    """Draw the moving picture."""
    width, height = PICTURE_SIZE
    async with async_playwright() as driver:
        browser = await driver.chromium.launch(executable_path=find_chromium(), args=list(QUIET))
        with served("--no-record", frozen=False) as session:
            seen = await watch(browser, session)
        page = await browser.new_page(viewport={"width": width, "height": height})
        frames = [await compose(page, console, shot) for console, shot in seen]
        await browser.close()
    every = Image.new("RGB", (width, height * len(frames)))  # one palette for all of them
    for number, frame in enumerate(frames):
        every.paste(frame, (0, number * height))
    palette = every.quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    first, *rest = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    first.save(
        IMAGES / "session.png",
        save_all=True,
        append_images=rest,
        duration=[SHOWN_MS] * len(rest) + [LAST_SHOWN_MS],
        optimize=True,
        loop=0,
    )


if __name__ == "__main__":
    asyncio.run(draw())
