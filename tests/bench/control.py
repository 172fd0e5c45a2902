"""The lateness of a loop in C beside the session's clock, among busy processes.

Both sleep and spin alike, at the same time, without a real-time priority. The C tells what is the
machine's own doing.
"""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from c_twin.compiler import compiler

from bench.on_time import LOOP_STEP_S, busy_processors, measure_loop
from trainer.analysis.bench.ticks import row
from trainer.session.time.ledger import Spread

CONTROL: Final = Path(__file__).with_name("control.c")


@dataclass(frozen=True)
class BesideC:
    """The lateness of both loops."""

    seconds: float  # of each loop
    busy_processes: int
    lateness: Spread
    lateness_in_c: Spread
    times_the_c: float  # 99 % by 99 %


def time_beside_c(seconds: float) -> BesideC:
    """Return the lateness of both loops in ``seconds`` [s]; NoCompilerError without a compiler."""
    count = os.cpu_count() or 1
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        program = f"{folder}/control"
        subprocess.run([*compiler(), "-O2", "-o", program, str(CONTROL)], check=True)
        words = [program, str(seconds), str(LOOP_STEP_S)]
        with (
            busy_processors(count),
            subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as control,
        ):
            ours = measure_loop(seconds).lateness
            numbers, _ = control.communicate()
    in_c = Spread(*map(int, numbers.split()))
    return BesideC(seconds, count, ours, in_c, ours.p99_ns / max(in_c.p99_ns, 1))


def lines(figures: BesideC) -> list[str]:
    """Return the figures as lines of a page."""
    return [
        "",
        f"THE CLOCK BESIDE C (loops of {1.0 / LOOP_STEP_S:.0f} Hz for {figures.seconds:g} s)",
        row(f"late, beside {figures.busy_processes} busy processes", figures.lateness, 32),
        row("the same in C, then", figures.lateness_in_c, 32),
        f"  99 % is {figures.times_the_c:.2f} times that of C",
    ]
