"""How soon a fresh process has fitted a ship: with machine code kept from before, and with none."""

import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.identify.rehearsal import TANKER, TANKER_RUDDER
from trainer.identify.simulate import drawn
from trainer.machine_code import cache_folder

TIMES: Final = 3
COMPILING: Final = "from trainer.identify import first_fit\nwith first_fit.alone():\n    pass"
HEAD: Final = """\
schema = "identify/1"
name = "a tanker"
data = "record.csv"
columns = [
  {channel = "t", column = "t", unit = "s"},
  {channel = "rudder", column = "rudder", unit = "deg"},
  {channel = "sway", column = "sway", unit = "kn"},
  {channel = "yaw_rate", column = "yaw_rate", unit = "deg/s"},
  {channel = "heading", column = "heading", unit = "deg"},
]
[ship]
length_m = 329
speed_kn = 15.9
[model]
kind = "1"
outputs = ["sway", "yaw_rate", "heading"]
"""


@dataclass(frozen=True)
class First:
    """A fit from the start of its process to its end."""

    clock_s: float
    processor_s: float  # of all processes that answer; the compiler beside them is another's


def write_study(folder: Path, samples: int) -> Path:
    """Return the study file of a tanker's record of so many samples, written into ``folder``."""
    problem = TANKER.problem(TANKER_RUDDER[:samples])
    record = drawn(problem, problem.start, np.random.default_rng(1))
    columns = np.column_stack([record.t, record.inputs, record.outputs])
    rows = [",".join(repr(float(number)) for number in row) for row in columns]
    text = "\n".join(["t,rudder,sway,yaw_rate,heading", *rows])
    (folder / "record.csv").write_text(f"{text}\n", encoding="ascii")
    start = {"m12": 0.0, "m21": 0.0, **TANKER.truth, **TANKER.begin}
    parameters = [
        f'[[parameters]]\nname = "{name}"\nstart = {value!r}\n'
        f'free = "{"yes" if name in TANKER.free else "no"}"\n'
        for name, value in start.items()
    ]
    study = folder / "study.toml"
    study.write_text(HEAD + "".join(parameters), encoding="ascii")
    return study


def fitted(study: Path, **environment: str) -> First:
    """Return how long ``trainer identify`` took; ConfigError if it fails."""
    words = [sys.executable, "-m", "trainer", "identify", str(study)]
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(  # noqa: S603
        words, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    taken, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise ConfigError(f"the fit of {study.name} failed: {done.stderr.strip()}")
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return First(taken, spent)


def first_fits(samples: int) -> tuple[First, First]:
    """Return the fit with machine code kept, the least of a few, and the one without any.

    What the latter has compiled beside it is waited for.
    """
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        study = write_study(Path(name), samples)
        subprocess.run([sys.executable, "-m", "trainer.identify.compiling"], check=True)
        later = min((fitted(study) for _ in range(TIMES)), key=lambda first: first.clock_s)
        empty = {"NUMBA_CACHE_DIR": name}
        (Path(name) / cache_folder().name).mkdir()
        first = fitted(study, **empty)
        subprocess.run([sys.executable, "-c", COMPILING], env=os.environ | empty, check=True)  # noqa: S603
    return later, first
