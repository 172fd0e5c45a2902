"""The lateness of ticks: bare loops of the clock, and a session in a crowd.

A loop of 100 Hz is timed in a process of its own: alone, beside a busy thread of the same process,
and beside busy processes, with and without a real-time priority. Beside the latter runs the same
loop in C, where there is a compiler, to tell what is the machine's own doing.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trainer.config.vessel import VesselFile
from trainer.session.time.ledger import Spread
from trainer.verify.bench.contention import Crowd, hogs, sail_in_crowd

STEP: Final = 0.01  # [s]
CONTROL: Final = Path(__file__).with_name("control.c")
METRONOME: Final = (sys.executable, "-m", "trainer.verify.bench.metronome")
COMPILERS: Final = ("cc", "gcc", "clang")


@dataclass(frozen=True)
class Loop:
    """How late the ticks of a loop began, and what the system had granted it."""

    granted: str
    lateness: Spread


@dataclass(frozen=True)
class OnTime:
    """How late ticks begin, by what else goes on."""

    seconds: float  # of each loop
    busy_processes: int
    alone: Loop
    beside_thread: Loop  # with a real-time priority, where permitted, as a run has it
    beside_processes: Loop
    control: Spread | None  # the loop in C, at the same time; None without a compiler
    times_the_control: float | None  # 99 % by 99 %
    realtime: Loop  # beside processes too
    crowd: Crowd


def time_ticks(file: VesselFile, seconds: float, minutes: float) -> OnTime:
    """Return the figures of loops of ``seconds`` [s]. A session of ``minutes`` is in a crowd."""
    count = os.cpu_count() or 1
    alone, beside_thread = loop(seconds), loop(seconds, "busy", "realtime")
    with hogs(count):
        beside, control = beside_control(seconds)
        realtime = loop(seconds, "realtime")
    times = beside.lateness.p99_ns / max(control.p99_ns, 1) if control else None
    return OnTime(
        seconds=seconds,
        busy_processes=count,
        alone=alone,
        beside_thread=beside_thread,
        beside_processes=beside,
        control=control,
        times_the_control=times,
        realtime=realtime,
        crowd=sail_in_crowd(file, 60.0 * minutes),
    )


def loop(seconds: float, *words: str) -> Loop:
    """Return what became of a loop in a process of its own."""
    command = [*METRONOME, str(seconds), str(STEP), *words]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    said: dict[str, Any] = json.loads(ran.stdout)
    return Loop(said.pop("granted"), Spread(**said))


def beside_control(seconds: float) -> tuple[Loop, Spread | None]:
    """Return the ticks of a loop, and those of the one in C."""
    compiler = next(filter(None, map(shutil.which, COMPILERS)), None)
    if compiler is None:
        return loop(seconds), None
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        program = f"{folder}/control"
        subprocess.run([compiler, "-O2", "-o", program, str(CONTROL)], check=True)  # noqa: S603
        with subprocess.Popen(  # noqa: S603
            [program, str(seconds), str(STEP)], stdout=subprocess.PIPE, text=True
        ) as control:
            found = loop(seconds)
            said, _ = control.communicate()
    return found, Spread(*(int(number) for number in said.split()))


def lines(figures: OnTime) -> list[str]:
    """Return the figures as lines of a page."""
    crowd, busy = figures.crowd, f"beside {figures.busy_processes} busy processes"
    rows = [
        row("alone", figures.alone.lateness),
        row("beside a busy thread", figures.beside_thread.lateness),
        row(busy, figures.beside_processes.lateness),
    ]
    if figures.control and figures.times_the_control is not None:
        times = f"{figures.times_the_control:.2f} times that"
        rows += [row("  the loop in C then", figures.control), f"    99 % is {times}"]
    rows += [row(f"  {figures.realtime.granted.split(',')[0]}", figures.realtime.lateness)]
    rate, head = 1.0 / STEP, f"  {'lateness [us]':<34}{'median':>11}{'99 %':>11}{'99.9 %':>11}"
    return [
        "",
        f"ON TIME (a loop of {rate:.0f} Hz for {figures.seconds:g} s each)",
        f"{head}{'most':>11}",
        *rows,
        f"  a session of {crowd.ticks} ticks, {crowd.step_s:g} s apart, among",
        f"  {', '.join(crowd.among)}:",
        row(f"  {crowd.missed} deadlines missed", crowd.lateness),
        f"    {crowd.granted}",
    ]


def row(name: str, spread: Spread) -> str:
    """Return a row of percentiles [us]."""
    times = (spread.p50_ns, spread.p99_ns, spread.p999_ns, spread.max_ns)
    return f"  {name:<34}" + "".join(f"{time / 1e3:11.1f}" for time in times)
