"""``trainer dev bench`` measures a tick's cost on this machine, and the size of records.

A tick in real time is measured by the ledger of the session itself, without the waiting. It finds
caches and processor as half a second of sleep leaves them. The hot figures are the same work back
to back: medians of batches, each long against the clock that times it.
"""

import math
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Final

import click
import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]

from trainer.analysis.bench.on_time import head, load_line, machine_load, row
from trainer.analysis.bench.session_tick import (
    TIME_SPEED,
    Latency,
    SessionTickCost,
    run_to,
    session_of,
    temporary,
    time_attended,
    time_orders,
)
from trainer.analysis.bench.tick import (
    BATCH_COUNT,
    BATCH_NS,
    STANDARD_METHOD,
    CasualtyTick,
    UpdateCost,
    ready_boat,
    time_troubled,
    time_update,
)
from trainer.boat.boat import Boat
from trainer.boat.machine_code import way_name
from trainer.config.boat.vessel import VesselFile
from trainer.core.scheme import SCHEME
from trainer.core.state import SCRATCH, STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.report.text import INDENT, ascii_text, wrap
from trainer.session.time.ledger import Spread, Summary

DUTY_1969: Final = {0.5: 38.0, 1.0: 19.0}  # [%] by step [s], of the modified set in 1969
WORDS_1969: Final = 8192  # [16-bit words] the memory of 1969
CORE_RECORDS: Final = {
    "state": STATE,
    "vessel": VESSEL,
    "compact": COMPACT,
    "scheme": SCHEME,
    "scratch": SCRATCH,
}
BUSY_LOOP_METHODS: Final = (STANDARD_METHOD, ("full", "exact", "adams2"), ("full", "exact", "rk4"))


@dataclass(frozen=True)
class BenchMachine:
    """The conditions of the figures."""

    cpu_model: str
    cpu_target: str  # the compiler's name of its kind
    cpu_count: int
    system: str
    python: str
    numpy: str
    numba: str
    code: str  # how the kernels were computed
    load_processes: float | None  # before the bench


@dataclass(frozen=True)
class PacedTicks:
    """Ticks in real time, recorded, with a console attached. Waiting for the clock is excluded."""

    step_s: float
    ticks: int
    duty_cycle_percent: float
    duty_cycle_1969_percent: float
    times_less_than_1969: float
    unrecorded_percent: float  # the duty cycle of as many ticks more, without a recording
    work: Spread
    lateness: Spread
    samples_from_p99_up: int  # so few ticks each percentile rests on
    samples_from_p999_up: int
    overruns: int
    caught_up: int
    skipped: int
    gaps: int


@dataclass(frozen=True)
class RecordSize:
    """The size of a record."""

    bytes: int
    words_of_16_bits: int


@dataclass(frozen=True)
class BenchFigures:
    """Everything that was measured."""

    vessel: str
    machine: BenchMachine
    real_time: tuple[PacedTicks, ...]
    updates: tuple[UpdateCost, ...]
    troubled: CasualtyTick
    attended: SessionTickCost
    latency: Latency
    sizes: dict[str, RecordSize]
    memory_1969_words_of_16_bits: int


def bench_boat(file: VesselFile, seconds: int) -> BenchFigures:
    """Return the figures of a boat.

    It takes twice ``seconds`` [s] of real time at each step of 1969, and then steers the boat over
    TCP for ``seconds``. ConfigError if the boat cannot fly straight, or loses its numbers at such a
    step.
    """
    step, load = file.run.step_s, machine_load()
    ordered = ready_boat(file, STANDARD_METHOD, step)
    twice = (*DUTY_1969, *DUTY_1969, step / TIME_SPEED)  # recorded, and not
    length = sum(round(seconds / each) for each in twice)
    quiet = not sys.stderr.isatty()
    with click.progressbar(length=length, label="ticking", file=sys.stderr, hidden=quiet) as bar:

        def progress(_tick: int) -> None:
            bar.update(1)

        boats = (ready_boat(file, STANDARD_METHOD, step) for step in DUTY_1969)
        paced = tuple(run_paced(boat, seconds, progress) for boat in boats)
        latency = time_orders(ordered, seconds, progress)
    return BenchFigures(
        vessel=file.name,
        machine=BenchMachine(
            cpu_model=cpu_model(Path("/proc/cpuinfo")),
            cpu_target=binding.get_host_cpu_name(),
            cpu_count=os.cpu_count() or 1,
            system=platform.platform(terse=True),
            python=platform.python_version(),
            numpy=np.__version__,
            numba=metadata.version("numba"),
            code=way_name(),
            load_processes=load,
        ),
        real_time=paced,
        updates=tuple(time_update(ready_boat(file, way, step)) for way in BUSY_LOOP_METHODS),
        troubled=time_troubled(file, STANDARD_METHOD),
        attended=time_attended(lambda: ready_boat(file, STANDARD_METHOD, step)),
        latency=latency,
        sizes={
            name: RecordSize(kind.itemsize, kind.itemsize // 2)
            for name, kind in CORE_RECORDS.items()
        },
        memory_1969_words_of_16_bits=WORDS_1969,
    )


def run_paced(boat: Boat, seconds: int, progress: Callable[[int], None]) -> PacedTicks:
    """Return what became of the ticks of ``seconds`` [s] of real time."""
    step = boat.method.step
    ticks = round(seconds / step)

    def run_with(recording: Recording | NoRecording, last_tick: int) -> Summary:
        with session_of(boat, 1.0, recording, ("teletype",)) as session:
            session.progress = progress
            run_to(session, last_tick)
        return session.time.ledger.summary()

    ledger = run_with(temporary(boat), ticks)
    unrecorded = run_with(NoRecording(), 2 * ticks)
    percent = 100.0 * ledger.duty_cycle
    return PacedTicks(
        step_s=step,
        ticks=ledger.ticks,
        duty_cycle_percent=percent,
        duty_cycle_1969_percent=DUTY_1969[step],
        times_less_than_1969=DUTY_1969[step] / percent,
        unrecorded_percent=100.0 * unrecorded.duty_cycle,
        work=ledger.work,
        lateness=ledger.lateness,
        samples_from_p99_up=samples_up(ledger.ticks, 990),
        samples_from_p999_up=samples_up(ledger.ticks, 999),
        overruns=ledger.overruns,
        caught_up=ledger.caught_up,
        skipped=ledger.skipped,
        gaps=ledger.gaps,
    )


def samples_up(samples: int, permille: int) -> int:
    """Return how many of ``samples`` lie at or above the percentile."""
    return samples - math.ceil(samples * permille / 1000) + 1


def cpu_model(listing: Path) -> str:
    """Return the processor's name in the ``listing`` of a Linux kernel, or the next best."""
    text = listing.read_text(encoding="utf-8") if listing.exists() else ""
    match = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return match[1].strip() if match else platform.processor() or platform.machine()


# The page for a terminal, 79 columns of ASCII


def render(figures: BenchFigures) -> str:
    """Return the figures as text."""
    machine = figures.machine
    versions = f"python {machine.python}, numpy {machine.numpy}, numba {machine.numba}"
    latency, most = figures.latency, figures.latency.ticks_to_effect_most
    effect = f"{most} tick{'s' * (most != 1)} at most" if most else "none: this boat has no rudder"
    period = f"{1e3 * latency.tick_s:g} ms"
    total = sum(size.bytes for size in figures.sizes.values())
    then = f"   of {figures.memory_1969_words_of_16_bits} words in 1969"
    processors = f"{machine.cpu_model} ({machine.cpu_target}), {machine.cpu_count} processors"
    system = f"{machine.system}, {versions}; the core {machine.code}"
    heading = (figures.vessel, processors, system, load_line(machine.load_processes))
    lines = [
        *(line for text in heading for line in wrap(text, "", INDENT)),
        *_real_time(figures.real_time),
        *_updates(figures.updates),
        f"  with a sea, tanks at work and six casualties {figures.troubled.troubled.median_ns:.0f}",
        f"  ({figures.troubled.times_the_calm:.2f} times the calm one)",
        *_session_cost(figures.attended),
        "",
        f"ORDERS OVER TCP (five subscribers, time x{TIME_SPEED:g}: a tick each {period})",
        head("  [us]", 16),
        row("  reply", latency.reply, 16),
        f"    {latency.orders} orders; from order to effect: {effect}",
        "",
        "RECORDS",
        f"  {'':<14}{'bytes':>8}{'16-bit words':>14}",
        *(
            f"  {name:<14}{size.bytes:>8}{size.words_of_16_bits:>14}"
            for name, size in figures.sizes.items()
        ),
        f"  {'all':<14}{total:>8}{total // 2:>14}{then}",
    ]
    return ascii_text("\n".join(lines))


def _real_time(paced: Iterable[PacedTicks]) -> list[str]:
    """Return duty cycle, work and punctuality at each step."""
    lines = ["", "REAL TIME (modified set, lagged rates, adams2, a console; waiting is not work)"]
    for run in paced:
        duty = f"duty cycle {run.duty_cycle_percent:.4f} %"
        then = f"1969: {run.duty_cycle_1969_percent:g} %, {run.times_less_than_1969:.0f} times that"
        p99, p999 = (
            "longest one" if count == 1 else f"{count} longest"
            for count in (run.samples_from_p99_up, run.samples_from_p999_up)
        )
        missed = f"overruns {run.overruns}, caught up {run.caught_up}, slipped {run.skipped}"
        lines += [
            f"  step {run.step_s:g} s: {duty} ({then})",
            head("  [us]", 16),
            row("  work a tick", run.work, 16),
            row("  lateness", run.lateness, 16),
            f"    {run.ticks} ticks: 99 % rests on the {p99}, 99.9 % on the {p999}",
            f"    {missed}, gaps {run.gaps}",
            f"    duty cycle of as many ticks without the recording {run.unrecorded_percent:.4f} %",
        ]
    return lines


def _updates(updates: Iterable[UpdateCost]) -> list[str]:
    """Return what an update costs, called and in a loop."""
    lines = [
        "",
        f"UPDATE, HOT ([ns], medians of {BATCH_COUNT} batches of {BATCH_NS / 1e6:g} ms or more)",
        f"  {'':<26}{'from Python':>12}{'in a kernel':>12}{'crossing':>10}{'ticks a batch':>16}",
    ]
    for update in updates:
        name = f"{update.equations} {update.rates} {update.integrator}"
        ticks = f"{update.called.repetitions}/{update.in_kernel.repetitions}"
        lines.append(
            f"  {name:<26}{update.called.median_ns:>12.0f}{update.in_kernel.median_ns:>12.0f}"
            f"{update.crossing_ns:>10.0f}{ticks:>16}"
        )
    difference = "the difference of the two least, which the machine disturbs least"
    return [*lines, f"  (crossing: {difference})"]


def _session_cost(attended: SessionTickCost) -> list[str]:
    """Return what a tick of the session costs, by what attends to it."""
    names = ("boat", "bare session", "recorded", "5 subscribers", "a CSV row")
    costs = (attended.boat, attended.bare, attended.recorded, attended.subscribed, attended.csv_row)
    times = f"{attended.times_the_bare:.2f} times the bare session"
    return [
        "",
        "TICK OF A SESSION, HOT ([ns], likewise; modified lagged adams2)",
        "        " + "".join(f"{name:>14}" for name in names),
        "  median" + "".join(f"{cost.median_ns:>14.0f}" for cost in costs),
        "  least " + "".join(f"{cost.least_ns:>14.0f}" for cost in costs),
        f"  (recorded, with five subscribers at 10 Hz: {times})",
    ]
