"""The cost of stations in a browser, to people and to the session.

``python -m tests.bench --web`` measures it. A session sails twice for as long: alone, and with many
stations attached at its pages' server. At the second a real Chromium opens the helm's page, gives
orders over the page's own line and counts pictures.
"""

import asyncio
import contextlib
import signal
import tempfile
import threading
import time
from collections.abc import Coroutine, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from bench.on_time import END_TIMEOUT_S, count_missed
from trainer import __version__
from trainer.analysis.bench.delays import PAGES_ADDRESS, serving
from trainer.analysis.bench.ticks import load_line, read_ticks, row
from trainer.config.boat.vessel import VesselFile
from trainer.config.extras import advise_install
from trainer.config.files import ConfigError
from trainer.io.orders.sentences import order_sentence
from trainer.report.pdf import find_browser
from trainer.session.time.ledger import Spread

if TYPE_CHECKING:
    import subprocess
    from concurrent.futures import Future

    from playwright.sync_api import Page
    from websockets.asyncio.client import ClientConnection

Answer = TypeVar("Answer")

STATION_COUNT: Final = 30  # stations attached
ROLE_CHANNELS: Final = {  # who they are, and what each wants to see
    "helm": ("gauges", "orders", "steering", "engine", "time"),
    "planes": ("gauges", "orders", "diving", "time"),
    "ballast": ("gauges", "ballast", "time"),
    "observer": ("gauges", "time"),
    "instructor": ("motion", "orders", "time"),
}
SHORT_RUN_S: Final = 10.0  # [s] a shorter run is not to take many times as long as it says
FIRST_PICTURE: Final = """() => new Promise((done) => {
  const look = () => {
    const there = document.querySelector("#state")?.dataset.state === "running";
    if (there) requestAnimationFrame(() => done(performance.now()));
    else setTimeout(look, 2);
  };
  look();
})"""
GIVE_ORDERS: Final = """async ([orders, pause]) => {
  const { session } = document.motion;
  const drawn = () => new Promise((done) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = done;
    port2.postMessage(0);  // after this picture is painted
  }));
  const [sign, times] = [document.createElement("p"), []];
  document.body.append(sign);
  for (let order = 0; order < orders; order += 1) {
    const began = performance.now();
    const answer = await session.order(`rudder ${order % 2 ? "left" : "right"} 5`);
    const answered = performance.now() - began;
    sign.textContent = answer.text;
    await drawn();
    if (answer.ok) times.push([answered, performance.now() - began]);
    await new Promise((done) => setTimeout(done, pause * (0.5 + Math.random())));
  }
  return times;
}"""
COUNT_PICTURES: Final = """(watched) => new Promise((done) => {
  const { motion } = document;
  if (!motion) { done([0, []]); return; }
  let pictures = 0;
  motion.cost.length = 0;
  motion.addEventListener("frame", () => { pictures += 1; });
  setTimeout(() => done([pictures / watched * 1000, motion.cost]), watched);
})"""


@dataclass(frozen=True)
class Effort:
    """How much is measured at a page."""

    loads: int
    orders: int
    pause: int  # [ms] between orders
    watched: int  # [ms] in which pictures are counted

    @classmethod
    def of(cls, seconds: float) -> "Effort":
        """Return what suits a run of so long."""
        # the slowest twentieth of 60 orders is three of them, and swings by a third from run to run
        return cls(5, 200, 100, 2000) if seconds >= SHORT_RUN_S else cls(2, 20, 50, 1000)


class NoBrowserError(ConfigError):
    """The machine lacks a browser, or the library that drives it; the text says which."""


@dataclass(frozen=True)
class PageDelay:
    """The waiting of somebody at a page; times [ms]."""

    browser: str
    loads: int
    first_picture: float  # median, from the address to readings on the screen
    orders: int
    answer_median: float
    answer_p95: float
    pixel_median: float  # until the answer is painted
    pixel_p95: float
    pictures: float  # a second, between ticks; 0: the page has no pointers
    script_median: float  # a picture
    script_p95: float


@dataclass(frozen=True)
class WebTicks:
    """The ticks of a session, and how late they began."""

    stations: int
    ticks: int
    missed: int  # deadlines: overruns, slipped ticks and gaps
    lateness: Spread


@dataclass(frozen=True)
class WebFigures:
    """The cost of stations in a browser."""

    looking: PageDelay
    alone: WebTicks
    attended: WebTicks
    load: str  # of the machine before


def time_pages(file: VesselFile, seconds: float) -> WebFigures:
    """Return the figures of sessions of ``seconds`` [s] each; NoBrowserError, ConfigError."""
    browser = able_browser()
    load = load_line()
    with tempfile.TemporaryDirectory(prefix="trainer-") as name:
        folder = Path(name)
        with sailing(file, folder, "alone") as session:
            time.sleep(seconds)
        alone = ticks_of(session, 0)
        with sailing(file, folder, "attended", "--web", "127.0.0.1:0") as session:
            end = time.monotonic() + seconds
            with attending(session.url):
                looking = watch_page(session.url, browser, Effort.of(seconds))
                time.sleep(max(end - time.monotonic(), 0.0))
        return WebFigures(looking, alone, ticks_of(session, STATION_COUNT), load)


def able_browser() -> str:
    """Return a Chromium, Chrome or Edge to be led; NoBrowserError naming what is missing."""
    for library in ("playwright", "websockets", "uvicorn", "starlette", "segno"):
        if find_spec(library) is None:
            raise NoBrowserError(advise_install(library, "tests.bench --web"))
    browser = find_browser()
    if browser is None:
        raise NoBrowserError("tests.bench --web needs Chromium: install the package chromium")
    return browser


@dataclass
class WebSession:
    """A session in its own process, its recording, and the address of its pages."""

    process: "subprocess.Popen[str]"
    recording: Path
    url: str = ""
    account: str = ""


@contextlib.contextmanager
def sailing(file: VesselFile, folder: Path, name: str, *words: str) -> Iterator[WebSession]:
    """Run a session inside the block; its account is there afterwards. ConfigError if it fails."""
    recording = folder / f"{name}.trainer"
    words += ("--vessel", str(file.path), "--record", str(recording))
    words += ("--listen", "none", "--socket", str(folder / f"{name}.sock"))
    begun = "pages at" if "--web" in words else "listening at"
    with serving(begun, *words) as (process, said):
        session = WebSession(process, recording, "".join(PAGES_ADDRESS.findall(said)))
        yield session
        process.send_signal(signal.SIGTERM)
        session.account, error_text = process.communicate(timeout=END_TIMEOUT_S)
    if process.returncode:
        raise ConfigError(f"the session of the bench failed: {error_text.strip()}")


def ticks_of(session: WebSession, stations: int) -> WebTicks:
    """Return the ticks of a session that is over."""
    ticks = read_ticks(session.recording, session.account)
    return WebTicks(stations, ticks.ticks, count_missed(ticks), ticks.lateness)


@contextlib.contextmanager
def attending(url: str) -> Iterator[None]:
    """Keep stations attached at the pages' server inside the block.

    Each station reads all that the server sends to it, because a page does.
    """
    # in one thread: with one for each station these would take the processors after each tick,
    # which the machines of a class do not
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()

    def begin(work: Coroutine[Any, Any, Answer]) -> "Future[Answer]":
        return asyncio.run_coroutine_threadsafe(work, loop)

    roles = list(islice(cycle(ROLE_CHANNELS), STATION_COUNT))
    lines = [begin(attach_station(url, role)).result(END_TIMEOUT_S) for role in roles]
    readers = [begin(read_all(line)) for line in lines]
    try:
        yield
    finally:
        for line in lines:
            begin(line.close()).result(END_TIMEOUT_S)
        for reader in readers:
            reader.result(END_TIMEOUT_S)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()


async def attach_station(url: str, role: str) -> "ClientConnection":
    """Attach a station of a role at the pages' server, as a page does; return its line."""
    from websockets.asyncio.client import connect  # noqa: PLC0415  an extra's
    from websockets.typing import Origin  # noqa: PLC0415

    where = f"{url.replace('http', 'ws')}/line?version={__version__}"
    line = await connect(where, origin=Origin(url), max_queue=None, close_timeout=1.0)
    for order in (f"role {role}", *(f"subscribe {each}" for each in ROLE_CHANNELS[role])):
        await line.send(order_sentence(order, "1"))
    return line


async def read_all(line: "ClientConnection") -> None:
    """Read a line to its end."""
    async for _ in line:
        pass


def watch_page(url: str, browser: str, effort: Effort) -> PageDelay:
    """Return how long somebody at the helm's page waits."""
    from playwright.sync_api import sync_playwright  # noqa: PLC0415  for development

    with sync_playwright() as driver, driver.chromium.launch(executable_path=browser) as opened:
        page = opened.new_page()
        firsts = sorted(first_picture(page, f"{url}/helm") for _ in range(effort.loads))
        pictures, costs = page.evaluate(COUNT_PICTURES, effort.watched)
        times = page.evaluate(GIVE_ORDERS, [effort.orders, effort.pause])
        version = opened.version
    if not times:
        raise ConfigError("no order of the bench was obeyed")
    answers, pixels = (sorted(column) for column in zip(*times, strict=True))
    costs.sort()
    return PageDelay(
        browser=f"Chromium {version}",
        loads=effort.loads,
        first_picture=value_at_share(firsts, 0.5),
        orders=len(times),
        answer_median=value_at_share(answers, 0.5),
        answer_p95=value_at_share(answers, 0.95),
        pixel_median=value_at_share(pixels, 0.5),
        pixel_p95=value_at_share(pixels, 0.95),
        pictures=pictures,
        script_median=value_at_share(costs, 0.5),
        script_p95=value_at_share(costs, 0.95),
    )


def first_picture(page: "Page", url: str) -> float:
    """Return the time [ms] from opening the address to the first readings."""
    page.goto(url, wait_until="commit")
    return float(page.evaluate(FIRST_PICTURE))


def value_at_share(ordered: list[float], share: float) -> float:
    """Return the value that a ``share`` [-] of values do not exceed; 0 without any."""
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else 0.0


def lines(figures: WebFigures) -> list[str]:
    """Return the figures as lines of a page."""
    seen, alone, attended = figures.looking, figures.alone, figures.attended
    answer = f"median {seen.answer_median:.1f} ms (5), 95 % {seen.answer_p95:.1f} ms (10)"
    pixel = f"median {seen.pixel_median:.1f} ms, 95 % {seen.pixel_p95:.1f} ms (50)"
    script = f"script median {seen.script_median:.2f} ms, 95 % {seen.script_p95:.2f} ms each"
    missed = f"{alone.missed} of {alone.ticks} alone, {attended.missed} of {attended.ticks}"
    return [
        "",
        f"STATIONS IN A BROWSER ({seen.browser}; goals in brackets)",
        f"  first picture    median {seen.first_picture:.0f} ms of {seen.loads} (500)",
        f"  order to answer  {answer}, {seen.orders} orders",
        f"  order to pixel   {pixel}: its answer is painted",
        f"  pictures         {seen.pictures:.1f} a second (20); {script}",
        row("late alone", alone.lateness, 20),
        row(f"late, {attended.stations} stations", attended.lateness, 20),
        f"  deadlines missed: {missed} with stations (0)",
        f"  {figures.load}",
    ]
