"""How soon the trainer answers: commands from their start, and an order at a page.

Everything is a process of its own, so that one measure does not warm the next. Orders go by a
page's own line, at instants spread evenly over a tick, because an order waits for the next one; the
time runs until the page is told of the rudder on its way. ``tests.bench --web`` has the painting.
"""

import contextlib
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

from trainer import __version__
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.io.orders.sentences import order_sentence

TRAINER_COMMAND: Final = (sys.executable, "-m", "trainer")
START_COUNT: Final = 3  # starts of each command, of which the fastest counts
RUN_WORDS: Final = ("run", "--headless", "--duration", "0.5", "--no-record", "--speed", "max")
SHOWN_NUMBER: Final = re.compile(rb"[0-9]\.[0-9]")  # a depth or a course on the screen
PAGES_ADDRESS: Final = re.compile(r"pages at (http://\S+)/")
PAGE_ORDERS: Final = ("role helm", "subscribe steering at 50 hz")  # there is a line for each tick
RUDDER_SHOWN: Final = re.compile(r"\$TRS,steering,[0-9]+,[0-9.]+,[^,]*,[^,]*,(-?[0-9.]+),")
RUDDER_ORDERS: Final = (("rudder left full", -1.0), ("rudder right full", 1.0))
ORDERS_PER_SECOND: Final = 4  # orders, for a second asked for
GOLDEN_RATIO: Final = 0.5 * (math.sqrt(5.0) - 1.0)  # its multiples are spread evenly, however many
ANSWER_TIMEOUT_S: Final = 30.0  # [s] from an order to what shows it
BINS_PER_STEP: Final = 10  # of the histogram, to a step
ALLOWED_DELAY_S: Final = 0.020  # [s] beyond half a step, for lines and programs


@dataclass(frozen=True)
class StartTimes:
    """Times from the start of a process, by what was waited for."""

    least_s: dict[str, float]


def time_starts() -> StartTimes:
    """Return how soon commands answer, the console where a program may have a terminal."""
    run = partial(time_to_end, *TRAINER_COMMAND, *RUN_WORDS)
    with tempfile.TemporaryDirectory(prefix="bench-") as empty:  # where nothing is compiled
        ways: dict[str, Callable[[], float]] = {
            "python -c pass": partial(time_to_end, sys.executable, "-c", "pass"),
            "import numba": partial(time_to_end, sys.executable, "-c", "import numba"),
            "trainer --help": partial(time_to_end, *TRAINER_COMMAND, "--help"),
            "a run to its first tick, the first ever": partial(run, NUMBA_CACHE_DIR=empty),
            "a run to its first tick, later": run,
        }
        if hasattr(os, "openpty"):
            ways["trainer run: figures on the console"] = time_to_screen
        times = {name: min(way() for _ in range(START_COUNT)) for name, way in ways.items()}
    return StartTimes(times)


def time_to_end(*command: str, **environment: str) -> float:
    """Return how long [s] a process took to its end; ConfigError if it failed."""
    begun = time.perf_counter()
    finish(*command, **environment)
    return time.perf_counter() - begun


def finish(*command: str, **environment: str) -> str:
    """Return what a process prints; ConfigError in its own words if it fails."""
    done = subprocess.run(  # noqa: S603  our own program
        command, env=os.environ | environment, stdin=subprocess.DEVNULL, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise ConfigError(f"no figure in a benchmark: {done.stderr.strip()}")
    return done.stdout


def time_to_screen() -> float:
    """Return how long [s] the console took to show figures; OSError if it shows none."""
    import termios  # noqa: PLC0415  not everywhere

    ours, theirs = os.openpty()
    termios.tcsetwinsize(theirs, (40, 120))  # rows and columns
    with tempfile.TemporaryDirectory(prefix="bench-") as folder:
        words, begun = ("run", "--no-record", "--socket", f"{folder}/s"), time.perf_counter()
        with subprocess.Popen(  # noqa: S603  our own program
            [*TRAINER_COMMAND, *words], stdin=theirs, stdout=theirs, stderr=theirs,
            env=os.environ | {"TERM": "xterm-256color"},
        ) as process:  # fmt: skip
            os.close(theirs)
            shown = b""
            while not SHOWN_NUMBER.search(shown):
                shown += os.read(ours, 65536)
            seconds = time.perf_counter() - begun
            process.terminate()
            os.close(ours)
    return seconds


def start_lines(figures: StartTimes) -> list[str]:
    """Return how soon commands answer, as lines of a page."""
    numba = figures.least_s["import numba"]
    rows = [
        f"  {name:<44}{1e3 * seconds:6.0f} ms{seconds / numba:6.2f} times numba"
        for name, seconds in figures.least_s.items()
    ]
    return ["STARTING (from the start of the process, the least of a few)", *rows]


@dataclass(frozen=True)
class OrderDelays:
    """How long each order took to be seen."""

    step_s: float
    delays_s: tuple[float, ...]


def time_page(file: VesselFile, seconds: float) -> OrderDelays:
    """Return the delays of orders at a page for ``seconds`` [s]; ConfigError if none acts."""
    from websockets.sync.client import connect  # noqa: PLC0415  an extra's

    words = ("--vessel", str(file.path), "--web", "127.0.0.1:0", "--listen", "none", "--no-record")
    with (
        tempfile.TemporaryDirectory(prefix="bench-") as folder,
        serving("pages at", *words, "--socket", f"{folder}/s", "--battery", "endless") as (_, said),
    ):
        (address,) = PAGES_ADDRESS.findall(said)
        line = f"{address.replace('http', 'ws', 1)}/line?version={__version__}"
        with connect(line, additional_headers={"Origin": address}, max_queue=None) as page:

            def say(order: str) -> None:
                page.send(order_sentence(order, "1"))

            def look(until: float) -> float | None:
                shown: list[str] = []
                with contextlib.suppress(TimeoutError, EOFError):
                    while not shown:
                        frame = page.recv(max(until - time.monotonic(), 0.0))
                        shown = RUDDER_SHOWN.findall(str(frame))
                return float(shown[-1]) if shown else None

            for order in PAGE_ORDERS:
                say(order)
            return time_orders(file, seconds, say, look)


@contextlib.contextmanager
def serving(begun: str, *words: str) -> Iterator[tuple["subprocess.Popen[str]", str]]:
    """Serve a session inside the block. Yield its process and the line on stderr with ``begun``.

    ConfigError if it ends before. It is killed after the block, if it has not ended.
    """
    with subprocess.Popen(  # noqa: S603  our own program
        [*TRAINER_COMMAND, "serve", "--verbose", *words], stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        try:
            said = [""]
            while begun not in said[-1]:
                said.append(process.stderr.readline() if process.stderr else "")
                if not said[-1]:
                    raise ConfigError(f"the session of the bench failed: {''.join(said).strip()}")
            yield process, said[-1]
        finally:
            process.kill()


def time_orders(
    file: VesselFile, seconds: float, say: Callable[[str], None], look: Callable[..., float | None]
) -> OrderDelays:
    """Return the delays of orders to the rudder for ``seconds`` [s]; ConfigError if none acts.

    ``look`` returns its next angle [deg], None if there is none by a time [s].
    """
    step, delays = file.run.step_s, list[float]()
    angle = look(time.monotonic() + ANSWER_TIMEOUT_S)
    for number in range(round(ORDERS_PER_SECOND * seconds)):
        pause = time.monotonic() + step * phase(number)
        while angle is not None and (shown := look(pause)) is not None:
            angle = shown
        words, sense = RUDDER_ORDERS[number % 2]
        begun = time.monotonic()
        say(words)
        moved = False
        while angle is not None and not moved:
            before, angle = angle, look(time.monotonic() + ANSWER_TIMEOUT_S)
            moved = angle is not None and sense * (angle - before) > 0.0
        delays += [time.monotonic() - begun] if moved else []
    if not delays:
        raise ConfigError(f"{file.path.name}: the rudder is not seen to move")
    return OrderDelays(step, tuple(delays))


def phase(number: int) -> float:
    """Return the part of a tick [-] between a tick seen and an order."""
    return (number + 0.5) * GOLDEN_RATIO % 1.0


def order_lines(figures: OrderDelays, way: str = "A PAGE (its own line") -> list[str]:
    """Return how soon orders are seen as lines of a page, with a histogram."""
    step, delays = figures.step_s, figures.delays_s
    bins = [int(delay / step * BINS_PER_STEP) for delay in delays]
    median, most = 1e3 * statistics.median(delays), 1e3 * max(delays)
    limit = f"at most {1e3 * (0.5 * step + ALLOWED_DELAY_S):.0f}: half a step and 20 ms"
    return [
        f"FROM HELM TO {way}, ticks {step:g} s apart)",
        f"  {len(delays)} orders: median {median:.0f} ms ({limit}), most {most:.0f} ms",
        *(
            f"  {1e3 * each * step / BINS_PER_STEP:6.0f} ms {bins.count(each):4} "
            f"{'#' * bins.count(each)}"[:79].rstrip()
            for each in range(max(bins) + 1)
        ),
    ]
