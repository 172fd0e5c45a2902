"""The tick by its parts, each in a compiled loop of its own.

The regimes are a sea and a calm, at two depths.
With ``--against`` the tick is timed beside that of an earlier commit, in one run: batches of two
processes, one of each core, take turns.
"""

import io
import statistics
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

from helpers.loops import in_a_loop
from helpers.places import tests_environment

from bench.batches import SEA_NAME, Voyage, time_batches
from trainer.analysis.bench.ticks import STANDARD_METHOD, ready_boat
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.core.autopilot.autopilot import autopilot
from trainer.core.ballast.ballast import advance_ballast
from trainer.core.kernel import Record, kernel
from trainer.core.rates import rates
from trainer.core.sea.forces import wave_forces
from trainer.core.sea.sea import advance_sea
from trainer.core.update import outside

Loop = Callable[..., None]  # of the five records and a count

REGIMES: Final = {  # sea and depth [m]
    "sea, 18 m": (SEA_NAME, 18.0),
    "sea, 60 m": (SEA_NAME, 60.0),
    "calm, 18 m": ("calm", 18.0),
    "calm, 60 m": ("calm", 60.0),
}
TICKS: Final = 4000  # in a batch beside another core
PAIRS: Final = 41
ROOT: Final = Path(__file__).parents[2]
CHILD: Final = """
import sys
sys.path.insert(0, sys.argv[1])
import time
from numba import njit
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.world.sea import load_sea
from trainer.config.boat.vessel import load_vessel
from trainer.core.update import update
from trainer.units import KNOT

def take(vessel, compact, scheme, state, scratch, count):
    for _ in range(count):
        update(vessel, compact, scheme, state, scratch)

take = njit(error_model="numpy")(take)
file = load_vessel(sys.argv[2])
boat = Boat(file, Method("modified", "lagged", "exact", "adams2", file.run.step_s))
for line in sys.stdin:
    sea, depth, count = line.split()
    boat.put_to_sea(load_sea("calm"))
    boat.start(file.run.start_speed_kn * KNOT, float(depth), 0.0)
    boat.put_to_sea(load_sea(sea))
    take(*boat.records, 200)
    began = time.perf_counter_ns()
    take(*boat.records, int(count))
    print(time.perf_counter_ns() - began, flush=True)
"""


@kernel
def loop_outside(
    vessel: Record, _compact: Record, scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Write the forces from outside, so many times."""
    for _ in range(count):
        outside(vessel, scheme, state, scratch)


@kernel
def loop_wave_forces(
    vessel: Record, _compact: Record, _scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Add the forces of the waves, so many times."""
    for _ in range(count):
        wave_forces(vessel, scratch, state, scratch[0].external)


@kernel
def loop_sea(
    vessel: Record, _compact: Record, scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Advance the sea, so many ticks."""
    for _ in range(count):
        advance_sea(vessel, scheme[0].h, scratch, state)


@kernel
def loop_rates(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Compute the twelve rates, so many times."""
    for _ in range(count):
        rates(vessel, compact, scheme, state, scratch)


@kernel
def loop_autopilot(
    vessel: Record, _compact: Record, scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Let the autopilot command, so many ticks."""
    for _ in range(count):
        autopilot(vessel, scheme[0].h, state, scratch)


@kernel
def loop_tanks(
    vessel: Record, _compact: Record, scheme: Record, state: Record, _scratch: Record, count: int
) -> None:
    """Advance the tanks, so many ticks."""
    for _ in range(count):
        advance_ballast(vessel, scheme[0].h, state)


@kernel
def loop_copy(
    _vessel: Record, _compact: Record, _scheme: Record, state: Record, scratch: Record, count: int
) -> None:
    """Keep the state for a tick that fails, so many times."""
    s, work = state[0], scratch[0]
    for _ in range(count):
        s.tick += 1.0  # else the compiler keeps it once
        for i in range(s.whole.size):
            work.before[i] = s.whole[i]


PARTS: Final[dict[str, Loop]] = {
    "outside": loop_outside,
    "of it wave forces": loop_wave_forces,
    "sea": loop_sea,
    "rates": loop_rates,
    "autopilot": loop_autopilot,
    "tanks": loop_tanks,
    "copy": loop_copy,
}


@dataclass(frozen=True)
class PartTimes:
    """What the tick and each of its parts take, by regime."""

    vessel: str
    tick_ns: dict[str, float]
    part_ns: dict[str, dict[str, float]]  # by regime and part
    against: str | None  # the other commit
    ratio: dict[str, float]  # of this core's tick to the other's, by regime


def boat_in(file: VesselFile, sea: str, depth: float) -> Boat:
    """Return a boat under way in a sea, at a depth [m]."""
    boat = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    boat.start(float(boat.state.u), depth, 0.0)
    boat.put_to_sea(load_sea(sea))
    in_a_loop(boat.records, 200)
    return boat


def run_part(boat: Boat, loop: Loop, count: int) -> None:
    """Run a part so many times, and leave the boat where it is."""
    moment = boat.snapshot()
    loop(*boat.records, count)
    boat.restore(moment)


def time_regime(file: VesselFile, sea: str, depth: float) -> dict[str, float]:
    """Return the least times [ns] of the tick and of its parts."""
    boat = boat_in(file, sea, depth)
    other = boat_in(file, sea, depth)
    works: list[Callable[[int], object]] = [Voyage.of(other, partial(in_a_loop, other.records))]
    works += [partial(run_part, boat, loop) for loop in PARTS.values()]
    costs = time_batches(works)
    return dict(zip(("tick", *PARTS), (cost.least_ns for cost in costs), strict=True))


def time_parts(file: VesselFile, against: str | None = None) -> PartTimes:
    """Return the tick by parts; beside the core of a commit, if one is given."""
    times = {name: time_regime(file, *regime) for name, regime in REGIMES.items()}
    tick = {name: parts.pop("tick") for name, parts in times.items()}
    ratio = time_against(file, against) if against else {}
    return PartTimes(file.name, tick, times, against, ratio)


@contextmanager
def core_process(root: Path, file: VesselFile) -> Iterator["subprocess.Popen[str]"]:
    """Yield a process that takes batches of ticks of the core under ``root``."""
    path = file.path.resolve()
    if path.is_relative_to(ROOT):  # a shipped boat is as its own core can read it
        path = root / path.relative_to(ROOT)
    words = [sys.executable, "-W", "ignore", "-c", CHILD, str(root), str(path)]
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(words, cwd=root, env=tests_environment(), text=True, **pipes) as child:
        try:
            yield child
        finally:
            child.kill()


def batch_ns(child: "subprocess.Popen[str]", sea: str, depth: float) -> int:
    """Return the time [ns] of a batch; ConfigError if the process ended."""
    assert child.stdin
    assert child.stdout
    child.stdin.write(f"{sea} {depth} {TICKS}\n")
    child.stdin.flush()
    reply = child.stdout.readline()
    if not reply:
        raise ConfigError("the tick of the other commit did not run")
    return int(reply)


def time_against(file: VesselFile, commit: str) -> dict[str, float]:
    """Return this core's tick over that of a commit, by regime.

    A ratio is the median of pairs of batches.
    """
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        words = ["git", "-C", str(ROOT), "archive", commit, "trainer", "configs", "pyproject.toml"]
        done = subprocess.run(words, capture_output=True, check=False)
        if done.returncode != 0:
            raise ConfigError(f"--against {commit}: {done.stderr.decode().strip()}")
        with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
            archive.extractall(folder, filter="data")
        with core_process(ROOT, file) as ours, core_process(Path(folder), file) as theirs:
            return {
                name: statistics.median(
                    batch_ns(ours, *regime) / batch_ns(theirs, *regime) for _ in range(PAIRS)
                )
                for name, regime in REGIMES.items()
            }


def lines(figures: PartTimes) -> list[str]:
    """Return the figures as lines of a page."""
    width = max(map(len, PARTS))
    header = "".join(f"{name:>13}" for name in REGIMES)
    rows = [f"  {'tick':<{width}}" + "".join(f"{figures.tick_ns[n]:>13.0f}" for n in REGIMES)]
    rows += [
        f"  {part:<{width}}" + "".join(f"{figures.part_ns[n][part]:>13.0f}" for n in REGIMES)
        for part in PARTS
    ]
    if figures.against:
        title = f"tick/{figures.against[:8]}"
        rows.append(f"  {title:<{width}}" + "".join(f"{figures.ratio[n]:>13.2f}" for n in REGIMES))
    return [
        "",
        f"THE TICK BY PARTS ([ns], {figures.vessel}, modified set)",
        " " * (width + 2) + header,
        *rows,
    ]
