"""The time that the core for WebAssembly takes for an hour, in node."""

import json
import os
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.export.targets import NoCompilerError
from trainer.config.boat.vessel import VesselFile
from trainer.units import KNOT

STARTS: Final = 5  # of each process; the least counts: interference only adds


@dataclass(frozen=True)
class HourInNode:
    """The hour of one boat by the shipped module."""

    vessel: str
    ticks: int
    hour_ms: float  # without the start of the process


def time_hour_in_node(file: VesselFile, starts: int = STARTS) -> HourInNode:
    """Return how long node takes for an hour of a boat; NoCompilerError without node."""
    from trainer.boat.export import wasm  # noqa: PLC0415  kernels are settled

    node = shutil.which("node")
    if node is None:
        raise NoCompilerError("no hour was flown: node is not here; install the package nodejs")
    boat = Boat(file, Method(file.own_equations, "lagged", "exact", "adams2", file.run.step_s))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    ticks = round(3600.0 / file.run.step_s)
    with tempfile.TemporaryDirectory(prefix="trainer-") as name:
        folder = Path(name)
        (folder / wasm.MODULE_FILE).write_bytes(wasm.shipped_module(boat))
        (folder / wasm.NUMBERS_FILE).write_text(json.dumps(wasm.numbers_of(boat)), encoding="utf-8")
        shutil.copy(Path(wasm.__file__).with_name(wasm.HOST_FILE), folder)
        host = str(folder / wasm.HOST_FILE)
        start, hour = (
            min(time_process(node, host, str(count)) for _ in range(starts)) for count in (0, ticks)
        )
    return HourInNode(file.name, ticks, hour - start)


def time_process(*words: str) -> float:
    """Return how long [ms] a process takes from its start to its end."""
    begun = time.perf_counter()
    subprocess.run(words, env=os.environ, stdout=subprocess.DEVNULL, check=True)
    return 1e3 * (time.perf_counter() - begun)


def lines(figures: HourInNode) -> list[str]:
    """Return the figures as lines of a page."""
    return [
        "",
        f"WEBASSEMBLY (node; {figures.vessel})",
        f"  an hour of {figures.ticks} ticks {figures.hour_ms:.0f} ms",
    ]
