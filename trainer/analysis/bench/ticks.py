"""What ticks take in real time, and the core's tick back to back.

A tick in real time finds caches and processor as half a second of sleep leaves them. Its run is a
process of its own, which refuses a boat that is lost; what it took is read from the recording and
the summary. Back to back the median of batches counts, each long against the clock's resolution.
"""

import contextlib
import gc
import os
import platform
import re
import statistics
import tempfile
import time
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]

from trainer.analysis.bench.delays import TRAINER_COMMAND, finish
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.depths import collapse_of
from trainer.boat.limits import height_showing
from trainer.boat.machine_code import way_name
from trainer.boat.plant import without_drain
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core.plant.parts import BUS_NAMES
from trainer.io.recording.recording import Recording
from trainer.report.text import INDENT, wrap
from trainer.session.time.ledger import Histogram, Spread
from trainer.units import KNOT

DUTY_1969: Final = {0.5: 38.0, 1.0: 19.0}  # [%] by step [s], of the modified set in 1969
NAMED_COUNT: Final = re.compile(r"([a-z][a-z ]*) ([0-9]+)")  # in the summary of a run
STANDARD_METHOD: Final = ("modified", "lagged", "adams2")
BATCH_COUNT: Final = 21  # batches: an odd number has a median of its own
BATCH_TICKS: Final = 50_000  # [ticks] of some 10 ms; the clock resolves far better


@dataclass(frozen=True)
class PacedTicks:
    """The ticks of a run at the clock's pace. Waiting for the clock is no work."""

    ticks: int
    duty_cycle_percent: float
    work: Spread
    lateness: Spread
    counts: dict[str, int]  # overruns, caught up, slipped, gaps
    granted: str  # by the system, for punctuality
    unrecorded_percent: float = 0.0  # the duty cycle of as many without a recording


@dataclass(frozen=True)
class TickCost:
    """The median cost of a tick: called from Python, and inside a compiled loop."""

    called_ns: float
    in_kernel_ns: float
    crossing_ns: float  # the least of called less the least within: interference only adds


@dataclass(frozen=True)
class TickFigures:
    """Runs at the clock's pace by their steps, and the tick back to back."""

    conditions: tuple[str, ...]
    runs: dict[float, PacedTicks]  # by step [s]
    duty_cycles_1969_percent: dict[float, float]
    tick: TickCost


def time_duty(file: VesselFile, seconds: float) -> TickFigures:
    """Return the ticks of ``seconds`` [s] at each step of 1969, with recording and without.

    ConfigError if the boat is lost, frozen or without power, or loses its numbers at such a step.
    """
    conditions, runs = describe_conditions(file), dict[float, PacedTicks]()
    for step in DUTY_1969:
        words = ("--step", str(step), "--duration", str(seconds))
        with tempfile.TemporaryDirectory(prefix="bench-") as folder:
            recording = Path(folder) / "run.trainer"
            run = read_ticks(recording, sail(file, *words, "--record", str(recording)))
        bare = duty_cycle(sail(file, *words, "--no-record"))
        runs[step] = replace(run, unrecorded_percent=bare)
    boat = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    return TickFigures(conditions, runs, DUTY_1969, time_tick(boat))


def describe_conditions(file: VesselFile) -> tuple[str, ...]:
    """Return the conditions of the figures: boat, processor, programs, load before the bench."""
    target = binding.get_host_cpu_name()  # the compiler's name of its kind
    processors = f"{cpu_model(Path('/proc/cpuinfo'))} ({target}), {os.cpu_count()} processors"
    python = f"{platform.platform(terse=True)}, python {platform.python_version()}"
    numbers = f"numpy {version('numpy')}, numba {version('numba')}; the core {way_name()}"
    return file.name, processors, f"{python}, {numbers}", load_line()


def cpu_model(listing: Path) -> str:
    """Return the processor's name in the ``listing`` of a Linux kernel, or the next best."""
    text = listing.read_text(encoding="utf-8") if listing.exists() else ""
    match = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return match[1].strip() if match else platform.processor() or platform.machine()


def load_line() -> str:
    """Return how many processes wanted a processor in the last minute, as a line."""
    load = f"{os.getloadavg()[0]:.2f} processes" if hasattr(os, "getloadavg") else "unknown"
    return f"load of the machine in the minute before: {load}"


def sail(file: VesselFile, *words: str) -> str:
    """Return the summary of a run by itself; ConfigError if it fails."""
    alone = ("--vessel", str(file.path), "--headless", "--verbose", "--battery", "endless")
    return finish(*TRAINER_COMMAND, "run", *alone, *words)


def read_ticks(recording: Path, summary: str) -> PacedTicks:
    """Return the ticks of a run that is over, by its recording and its summary."""
    work, lateness, ticks = Histogram(), Histogram(), 0
    with contextlib.closing(Recording.look(recording)) as run:
        for _, late_ns, work_ns in run.ledger(run.branch):
            work.add(work_ns)
            lateness.add(late_ns)
            ticks += 1
    counts = {name: int(count) for name, count in NAMED_COUNT.findall(entry(summary, "on time"))}
    granted, spreads = entry(summary, "the clock"), (work.spread(), lateness.spread())
    return PacedTicks(ticks, duty_cycle(summary), *spreads, counts, granted)


def duty_cycle(summary: str) -> float:
    """Return the duty cycle [%] of a run by its summary."""
    return float(entry(summary, "duty cycle").split()[0])


def entry(summary: str, name: str) -> str:
    """Return what a run's summary says under a name, "" if it says nothing."""
    entries = (text for text in summary.splitlines() if text.startswith(name))
    return next(entries, name).removeprefix(name).strip()


def ready_boat(file: VesselFile, way: tuple[str, str, str], step: float) -> Boat:
    """Return a boat under way in trim, its tick compiled, with an endless battery.

    The garbage is collected and frozen, because a collection in a batch would count as ticks.
    """
    equations, rates, integrator = way
    boat = Boat(without_drain(file), Method(equations, rates, "exact", integrator, step))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    start = boat.snapshot()
    boat.tick()  # the first calls compile; their one tick of motion is then taken back
    height_showing(boat)
    boat.restore(start)
    gc.collect()
    gc.freeze()  # as a run does: a full collection with numba loaded takes 0.1 s
    return boat


def time_tick(boat: Boat) -> TickCost:
    """Return the cost of a boat's tick; ConfigError as ``trouble_of`` tells.

    Each batch begins from the boat put back. Both ways take turns, to meet the same machine.
    """
    tick, nothing, start = boat.tick, np.empty(0, np.int64), boat.snapshot()
    costs: tuple[list[float], list[float]] = [], []
    for batch in range(2 * BATCH_COUNT):
        boat.restore(start)
        begun = time.perf_counter_ns()
        if batch % 2:
            boat.fly(nothing, np.empty((BATCH_TICKS, 0)))
        else:
            for _ in range(BATCH_TICKS):
                tick()
        costs[batch % 2].append((time.perf_counter_ns() - begun) / BATCH_TICKS)
        if trouble := trouble_of(boat, int(start["tick"][0]), BATCH_TICKS):
            raise ConfigError(f"{boat.file.path.name} has no figure in a benchmark: {trouble}")
    called, within = costs
    return TickCost(statistics.median(called), statistics.median(within), min(called) - min(within))


def trouble_of(boat: Boat, begun: int, ticks: int) -> str:
    """Return why a boat's ticks since ``begun`` are no figure: frozen, lost or without power."""
    if boat.ticks - begun < ticks:
        return f"it has done {boat.ticks - begun} of {ticks} ticks"
    if lost := collapse_of(boat) or boat.flat_words:
        return lost.removeprefix(", ")
    dead = [name for name in BUS_NAMES if boat.state[f"{name}_dead"]]
    return f"{' and '.join(dead)} without power" if dead else ""


def lines(figures: TickFigures) -> list[str]:
    """Return the figures as lines of a page."""
    page = [line for text in figures.conditions for line in wrap(text, "", INDENT)]
    page += ["", "REAL TIME (waiting for the clock is not work)"]
    for step, run in figures.runs.items():
        duty, then = run.duty_cycle_percent, figures.duty_cycles_1969_percent[step]
        page += [
            f"  step {step:g} s: duty cycle {duty:.4f} %",
            f"    1969: {then:g} %, {then / duty:.0f} times that",
            f"    without the recording {run.unrecorded_percent:.4f} %",
            row("work a tick", run.work),
            row("lateness", run.lateness),
            f"    {run.ticks} ticks: {', '.join(f'{what} {n}' for what, n in run.counts.items())}",
            f"    {run.granted}",
        ]
    cost, method = figures.tick, " ".join(STANDARD_METHOD)
    page += ["", f"TICK, HOT ([ns], medians of {BATCH_COUNT} batches; {method})"]
    page += [f"  from Python {cost.called_ns:.0f}, in a kernel {cost.in_kernel_ns:.0f}"]
    return [*page, f"  crossing {cost.crossing_ns:.0f}, by the least of each"]


def row(name: str, spread: Spread, width: int = 13) -> str:
    """Return a row of percentiles [us]."""
    times = (spread.p50_ns, spread.p99_ns, spread.p999_ns, spread.max_ns)
    median, p99, p999, most = (f"{time / 1e3:8.1f}" for time in times)
    return f"    {name:<{width}}median{median}, 99 %{p99}, 99.9 %{p999}, most{most} us"
