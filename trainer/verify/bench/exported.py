"""The cost of a run on an exported core: start, memory, an hour in node.

Both are whole processes, in turn, from their start to their end: Python with nothing to do, and a
run of one tick through the command's own entry. Their compiled sources are at hand, as after an
installation.
"""

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.vessel import load_vessel
from trainer.units import KNOT

STARTS: Final = 25
COMMAND: Final = "from trainer.__main__ import main; main()"
# A child's peak includes what its parent was when it forked: only a small parent tells the child's.
PEAK: Final = (
    "import os, sys; child = os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ, "
    "file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]); "
    "print(os.wait4(child, 0)[2].ru_maxrss)"
)


@dataclass(frozen=True)
class Process:
    """One kind of process, from its start to its end."""

    least_ms: float
    median_ms: float
    peak_mib: float


@dataclass(frozen=True)
class ExportedStart:
    """A run of one tick on an exported core, beside Python doing nothing."""

    vessel: str
    cpu: str
    export_s: float  # with the machine code of the kernels at hand
    code_words_of_16_bits: int
    python: Process
    first_tick: Process
    times_python: float  # least over least: interference only adds
    times_python_memory: float
    wasm_hour_ms: float | None  # an hour of ticks in node, without its start; None: no node


def measure_exported(vessel: str, starts: int = STARTS) -> ExportedStart:
    """Export the core of ``vessel`` into a temporary folder. Time so many runs of one tick."""
    with tempfile.TemporaryDirectory(prefix="trainer-") as name:
        folder = Path(name)
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder / "compiled")}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        began = time.perf_counter()
        words = command("export-core", str(folder), "--vessel", vessel, "--json")
        answer = subprocess.run(words, env=environment, capture_output=True, check=True)  # noqa: S603
        spent = time.perf_counter() - began
        written = json.loads(answer.stdout)
        library = str(folder / "libtrainer_core.so")
        tick = ("--duration", str(written["step_s"]), "--speed", "max")
        kinds = (
            [sys.executable, "-c", "pass"],
            command("run", "--headless", "--core", library, *tick),
        )
        python, first_tick = time_processes(kinds, starts, environment)
        hour = hour_in_node(vessel, folder, starts)
    return ExportedStart(
        vessel=written["boat"],
        cpu=written["cpu"],
        export_s=spent,
        code_words_of_16_bits=written["words_of_16_bits"]["code"],
        python=python,
        first_tick=first_tick,
        times_python=first_tick.least_ms / python.least_ms,
        times_python_memory=first_tick.peak_mib / python.peak_mib,
        wasm_hour_ms=hour,
    )


def hour_in_node(vessel: str, folder: Path, starts: int) -> float | None:
    """Return how long [ms] the shipped core for WebAssembly takes for an hour of ``vessel``."""
    from trainer.boat.export import wasm  # noqa: PLC0415  kernels are settled

    node = shutil.which("node")
    if node is None:
        return None
    file = load_vessel(vessel)
    boat = Boat(file, Method(file.own_equations, "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    (folder / wasm.MODULE).write_bytes(wasm.shipped(boat))
    (folder / wasm.NUMBERS).write_text(json.dumps(wasm.numbers_of(boat)), encoding="utf-8")
    shutil.copy(Path(wasm.__file__).with_name(wasm.HOST), folder)
    host, ticks = str(folder / wasm.HOST), round(3600.0 / file.run.step_s)
    kinds = ([node, host, "0"], [node, host, str(ticks)])
    start, hour = time_processes(kinds, max(starts // 5, 1), dict(os.environ))
    return hour.least_ms - start.least_ms


def command(*words: str) -> list[str]:
    """Return the words that start the trainer's command as an installed one starts."""
    return [sys.executable, "-c", COMMAND, *words]


def time_processes(
    kinds: Sequence[list[str]], starts: int, environment: dict[str, str]
) -> list[Process]:
    """Return the cost of each kind of process.

    They start in turn so many times after one unheeded.
    """
    spent: list[list[float]] = [[] for _ in kinds]
    for _ in range(starts + 1):
        for words, times in zip(kinds, spent, strict=True):
            began = time.perf_counter()
            subprocess.run(words, env=environment, stdout=subprocess.DEVNULL, check=True)  # noqa: S603
            times.append(1e3 * (time.perf_counter() - began))
    return [
        Process(min(times[1:]), statistics.median(times[1:]), peak_mib(words, environment))
        for words, times in zip(kinds, spent, strict=True)
    ]


def peak_mib(words: list[str], environment: dict[str, str]) -> float:
    """Return the most memory [MiB] that a process was resident in."""
    small = [sys.executable, "-S", "-c", PEAK, *words]
    answer = subprocess.run(small, env=environment, capture_output=True, check=True)  # noqa: S603
    unit = 1 if sys.platform == "darwin" else 1024  # of what the system tells
    return int(answer.stdout) * unit / 2**20


def lines(figures: ExportedStart) -> list[str]:
    """Return the figures as lines of a page."""
    rows = (("python -c pass", figures.python), ("one tick", figures.first_tick))
    return [
        "",
        f"EXPORTED CORE ({figures.cpu}; neither numba nor numpy)",
        f"  {figures.vessel}",
        f"  exported in {figures.export_s:.1f} s: {figures.code_words_of_16_bits:,} words of code",
        f"    {'':<16}{'least [ms]':>12}{'median [ms]':>12}{'peak [MiB]':>12}",
        *(
            f"    {name:<16}{each.least_ms:>12.1f}{each.median_ms:>12.1f}{each.peak_mib:>12.1f}"
            for name, each in rows
        ),
        f"  one tick takes {figures.times_python:.2f} times Python's own start and end,",
        f"  and {figures.times_python_memory:.2f} times its memory",
        "  WebAssembly, an hour in node: "
        + ("no node here" if figures.wasm_hour_ms is None else f"{figures.wasm_hour_ms:.0f} ms"),
    ]
