"""The time from helm to instrument.

``trainer dev bench --latency`` measures it. A session in a process of its own has a helmsman at one
serial line, and sends the rudder angle by NMEA 0183 to another. The helmsman orders the rudder to
the other side at instants that are spread evenly over a tick, because an order waits for the next
tick. The time runs from the first byte of the order to the last byte of the sentence that shows the
rudder on its way.
"""

import contextlib
import itertools
import math
import os
import re
import select
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from re import Match, Pattern
from typing import Final

from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.session.time.ledger import SECOND_NS, Histogram, Spread

TERMINAL_SIZE: Final = 40, 120  # rows and columns
TRAINER_COMMAND: Final = (sys.executable, "-m", "trainer")
RUDDER_ORDERS: Final = (("rudder left full", -1.0), ("rudder right full", 1.0))
SENTENCE_RATE_HZ: Final = "20"  # [Hz] of the sentences, at most: there is one for each tick
RUDDER_SENTENCE: Final = re.compile(rb"\$INRSA,(-?[0-9]+\.[0-9]+),A[^\n]*\n")
ORDERS_PER_SECOND: Final = 4  # orders, for a second asked for
# of whose multiples any number are spread evenly
GOLDEN_RATIO: Final = 0.5 * (math.sqrt(5.0) - 1.0)
START_TIMEOUT_S: Final = 600.0  # [s] a first start, on a machine that is busy with other work
ANSWER_TIMEOUT_S: Final = 30.0  # [s] from an order to the sentence that shows it
BINS_PER_STEP: Final = 10  # of the histogram, to a step
ALLOWED_DELAY_S: Final = 0.020  # [s] beyond half a step
MAX_BAR_LENGTH: Final = 40  # [characters] of its bars


def begin_session(words: Sequence[str]) -> "subprocess.Popen[str]":
    """Start a session in a process of its own, and keep what it prints."""
    return subprocess.Popen(  # noqa: S603  our own program
        [*TRAINER_COMMAND, "serve", "--verbose", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@dataclass
class TerminalLine:
    """The bench's end of a serial line, and the name of the other end."""

    descriptor: int
    name: str
    received: bytes = b""  # what has come and has not been delays_ns

    def say(self, words: str) -> None:
        """Write a line."""
        os.write(self.descriptor, f"{words}\r".encode("ascii"))

    def hear(self, until: float) -> bool:
        """Read until ``until`` [s] of the monotonic clock. Return whether anything came."""
        wait = max(until - time.monotonic(), 0.0)
        if not select.select([self.descriptor], [], [], wait)[0]:
            return False
        with contextlib.suppress(OSError):  # the other end has gone
            self.received += os.read(self.descriptor, 65536)
            return True
        return False

    def find(self, pattern: Pattern[bytes], until: float) -> Match[bytes] | None:
        """Return the next match; drop it and all before it. None if none comes in time."""
        while True:
            match = pattern.search(self.received)
            if match:
                self.received = self.received[match.end() :]
                return match
            if not self.hear(until):
                return None


@contextlib.contextmanager
def line() -> Iterator[TerminalLine]:
    """Yield a line whose other end a program can open. The system must have pseudo-terminals."""
    import fcntl  # noqa: PLC0415  not everywhere
    import struct  # noqa: PLC0415
    import termios  # noqa: PLC0415

    ours, theirs = os.openpty()
    try:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", *TERMINAL_SIZE, 0, 0))
        yield TerminalLine(ours, os.ttyname(theirs))
    finally:
        os.close(theirs)
        os.close(ours)


@contextlib.contextmanager
def on_terminal(*words: str) -> Iterator[tuple[TerminalLine, "subprocess.Popen[bytes]"]]:
    """Run the program on a terminal inside the block. Yield our end of it and the process."""
    with line() as screen:
        terminal = os.open(screen.name, os.O_RDWR | os.O_NOCTTY)
        with subprocess.Popen(  # noqa: S603  our own program
            [*TRAINER_COMMAND, *words],
            stdin=terminal,
            stdout=terminal,
            stderr=terminal,
            env=os.environ | {"TERM": "xterm-256color"},
        ) as process:
            os.close(terminal)
            yield screen, process


@dataclass(frozen=True)
class InstrumentDelay:
    """How long it took an order to be seen at an instrument."""

    step_s: float
    orders: int
    latency: Spread
    allowed_median_ms: float  # half a step, and what lines and programs may take
    bin_ms: float
    histogram: tuple[int, ...]  # orders by bin


def time_helm(file: VesselFile, seconds: float) -> InstrumentDelay:
    """Return the latency of orders given for ``seconds`` [s]; ConfigError if none acts."""
    step = file.run.step_s
    with line() as helm, line() as instrument:
        words = ("serve", "--vessel", str(file.path), "--line", f"helm={helm.name}")
        nmea = (
            "--nmea",
            instrument.name,
            "--nmea-sentences",
            "RSA",
            "--nmea-rate",
            SENTENCE_RATE_HZ,
        )
        alone = ("--listen", "none", "--socket", "none", "--no-record")
        with subprocess.Popen(  # noqa: S603  our own program
            [*TRAINER_COMMAND, *words, *nmea, *alone],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        ) as process:
            try:
                orders = round(ORDERS_PER_SECOND * seconds)
                delays_ns = list(time_rudder_orders(helm, instrument, step, orders))
            finally:
                process.terminate()
            complaint = process.stderr.read().decode() if process.stderr else ""
    if not delays_ns:
        raise ConfigError(f"{file.path.name}: the rudder is not seen to move; {complaint.strip()}")
    return summarise(delays_ns, step)


def time_rudder_orders(
    helm: TerminalLine, instrument: TerminalLine, step: float, orders: int
) -> Iterator[int]:
    """Order the rudder from side to side. Yield the time [ns] until each order is seen."""
    angle = next_rudder_angle(instrument, time.monotonic() + START_TIMEOUT_S)
    for number, (words, sense) in zip(range(orders), itertools.cycle(RUDDER_ORDERS), strict=False):
        pause = time.monotonic() + step * phase(number)
        while angle is not None and (shown := next_rudder_angle(instrument, pause)) is not None:
            angle = shown
        begun = time.monotonic_ns()
        helm.say(words)
        while angle is not None:
            before = angle
            angle = next_rudder_angle(instrument, time.monotonic() + ANSWER_TIMEOUT_S)
            if angle is not None and sense * (angle - before) > 0.0:
                break
        if angle is None:
            return
        yield time.monotonic_ns() - begun


def phase(number: int) -> float:
    """Return the part of a tick [-] between a tick seen and an order."""
    return (number + 0.5) * GOLDEN_RATIO % 1.0


def next_rudder_angle(instrument: TerminalLine, until: float) -> float | None:
    """Return the rudder's next angle [deg] to starboard. None: none comes in time."""
    match = instrument.find(RUDDER_SENTENCE, until)
    return float(match[1]) if match else None


def summarise(delays_ns: list[int], step: float) -> InstrumentDelay:
    """Return the figures of times [ns] from order to instrument."""
    histogram, width = Histogram(), step / BINS_PER_STEP
    counts = [0] * (int(max(delays_ns) / SECOND_NS / width) + 1)
    for time_ns in delays_ns:
        histogram.add(time_ns)
        counts[int(time_ns / SECOND_NS / width)] += 1
    median = round(statistics.median(delays_ns))  # itself: a bin is wider than what lines may take
    return InstrumentDelay(
        step_s=step,
        orders=len(delays_ns),
        latency=replace(histogram.spread(), p50_ns=median),
        allowed_median_ms=1e3 * (0.5 * step + ALLOWED_DELAY_S),
        bin_ms=1e3 * width,
        histogram=tuple(counts),
    )


def lines(figures: InstrumentDelay) -> list[str]:
    """Return the figures as lines of a page."""
    spread, most = figures.latency, max(figures.histogram)
    allowed = f"at most {figures.allowed_median_ms:.0f}: half a step and 20 ms"
    summary = f"median {spread.p50_ns / 1e6:.0f} ms ({allowed}), most {spread.max_ns / 1e6:.0f} ms"
    return [
        "",
        f"FROM HELM TO INSTRUMENT (two serial lines, ticks {figures.step_s:g} s apart)",
        f"  {figures.orders} orders: {summary}",
        *(
            f"  {number * figures.bin_ms:6.0f} ms {count:4} "
            f"{'#' * math.ceil(MAX_BAR_LENGTH * (count / most))}".rstrip()
            for number, count in enumerate(figures.histogram)
        ),
    ]
