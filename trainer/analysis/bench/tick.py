"""The cost of the core's tick back to back: called, and in a compiled loop.

A part of ``trainer dev bench``. Batches are long against the clock's resolution, and the median of
them counts, because other programs can only make a batch longer.
"""

import gc
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from trainer.boat import casualties
from trainer.boat.assemble import Method, Records
from trainer.boat.boat import Boat
from trainer.boat.depths import collapse_of
from trainer.boat.limits import height_showing
from trainer.boat.machine_code import EMPTY_CHART
from trainer.boat.plant import without_drain
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.core.entry import fly
from trainer.core.plant.parts import BUS_NAMES
from trainer.units import KNOT

BATCH_COUNT: Final = 21  # batches: an odd number has a median of its own
BATCH_NS: Final = 10_000_000  # [ns] a batch takes at least; the clock resolves far better
STANDARD_METHOD: Final = ("modified", "lagged", "adams2")
SEA_NAME: Final = "sea-state-5"
# fmt: off
CASUALTY_KINDS: Final = (
    "rudder-slow", "stern-slow", "bow-slow", "depth-gauge-noisy", "gyro-biased", "log-noisy",
)
# fmt: on


@dataclass(frozen=True)
class BatchCost:
    """The cost of one repetition: over batches of equal length, the median and the least."""

    median_ns: float
    least_ns: float
    batches: int
    repetitions: int  # in a batch


def time_batches(works: Sequence[Callable[[int], object]]) -> list[BatchCost]:
    """Return the cost of one repetition of each of ``works``. Each is called with a count.

    The batches of all works take turns, because the machine's pace may change and must then change
    for all of them.
    """
    counts = [long_enough(work) for work in works]
    costs = [
        [time_repetitions(work, count) / count for work, count in zip(works, counts, strict=True)]
        for _ in range(BATCH_COUNT)
    ]
    return [
        BatchCost(statistics.median(cost), min(cost), BATCH_COUNT, count)
        for cost, count in zip(zip(*costs, strict=True), counts, strict=True)
    ]


def long_enough(work: Callable[[int], object]) -> int:
    """Return a number of repetitions that takes at least a batch's time.

    The shortest of three times decides, because the first call may compile and another program may
    interrupt: both only lengthen a time.
    """
    count = 1
    while min(time_repetitions(work, count) for _ in range(3)) < BATCH_NS:
        count *= 2
    return count


def time_repetitions(work: Callable[[int], object], count: int) -> int:
    """Return the time [ns] that ``count`` repetitions take.

    A boat's ``Voyage`` is put back before; ConfigError where it was none afterwards.
    """
    if isinstance(work, Voyage):
        work.put_back()
    start = time.perf_counter_ns()
    work(count)
    taken = time.perf_counter_ns() - start
    if isinstance(work, Voyage) and (trouble := work.trouble(count)):
        raise ConfigError(f"{work.name} has no figure in a benchmark: {trouble}")
    return taken


@dataclass(frozen=True)
class Voyage:
    """Work with a boat that is put back before each batch."""

    name: str
    work: Callable[[int], object]
    put_back: Callable[[], object]
    trouble: Callable[[int], str]  # after so many repetitions; "" for none

    def __call__(self, count: int) -> None:
        """Do so many repetitions."""
        self.work(count)

    @classmethod
    def of(cls, boat: Boat, work: Callable[[int], object]) -> "Voyage":
        """Return work with a boat that takes a tick at least in each repetition."""
        put_back = partial(boat.restore, boat.snapshot())
        return cls(boat.file.path.name, work, put_back, partial(trouble_of, boat, boat.ticks))


def trouble_of(boat: Boat, begun: int, ticks: int) -> str:
    """Return why a boat's ticks since ``begun`` are no figure: frozen, lost or without power."""
    if boat.ticks - begun < ticks:
        return f"it has done {boat.ticks - begun} of {ticks} ticks"
    if lost := collapse_of(boat) or boat.flat_words:
        return lost.removeprefix(", ")
    dead = [name for name in BUS_NAMES if boat.state[f"{name}_dead"]]
    return f"{' and '.join(dead)} without power" if dead else ""


@dataclass(frozen=True)
class UpdateCost:
    """One way to compute the boat: called from Python, and inside a compiled loop."""

    equations: str
    rates: str
    integrator: str
    step_s: float
    called: BatchCost
    in_kernel: BatchCost
    crossing_ns: float  # the least of called less the least of in_kernel: interference only adds


@dataclass(frozen=True)
class CasualtyTick:
    """A compiled tick: in a calm, and with sea, tanks and six casualties."""

    calm: BatchCost
    troubled: BatchCost
    times_the_calm: float  # least over least: interference only adds


def in_a_loop(records: Records, count: int) -> int:
    """Take ``count`` ticks of a boat without Python between them; return the last status."""
    return int(fly(records, EMPTY_CHART, EMPTY_CHART, np.empty((count, 0))))


def ready_boat(file: VesselFile, way: tuple[str, str, str], step: float) -> Boat:
    """Return a boat under way in trim, its tick compiled, with an endless battery.

    A quick machine's batch is longer than a battery lasts. The garbage is collected and frozen,
    because a collection during a batch would count as ticks.
    """
    equations, rates, integrator = way
    boat = Boat(without_drain(file), Method(equations, rates, "exact", integrator, step))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    start = boat.snapshot()
    # the first calls compile; their one tick of motion is then taken back
    boat.tick()
    height_showing(boat)
    boat.restore(start)
    gc.collect()
    gc.freeze()  # as a run does: a full collection with numba loaded takes 0.1 s
    return boat


def time_update(boat: Boat) -> UpdateCost:
    """Return the cost of the core's tick, with and without a call from Python."""
    tick = boat.tick

    def call(count: int) -> None:
        for _ in range(count):
            tick()

    works = call, partial(in_a_loop, boat.records)
    called, in_kernel = time_batches([Voyage.of(boat, work) for work in works])
    method = boat.method
    return UpdateCost(
        equations=method.equations,
        rates=method.rates,
        integrator=method.integrator,
        step_s=method.step,
        called=called,
        in_kernel=in_kernel,
        crossing_ns=called.least_ns - in_kernel.least_ns,
    )


def time_troubled(file: VesselFile, way: tuple[str, str, str]) -> CasualtyTick:
    """Return what sea, tanks (where the boat has any) and casualties add to a tick."""
    boats = [ready_boat(file, way, file.run.step_s) for _ in range(2)]
    troubled = boats[1]
    troubled.put_to_sea(load_sea(SEA_NAME))
    # ``fitted`` is 1 where the boat has tanks: pumps then work all through, for the order to move
    # trim water is larger than any tank
    troubled.state.hover = troubled.vessel.fitted
    troubled.state.move_trim = 1e9 * troubled.vessel.fitted
    for name in CASUALTY_KINDS:
        casualties.insert_casualty(troubled, name)

    calm, worst = time_batches([Voyage.of(b, partial(in_a_loop, b.records)) for b in boats])
    return CasualtyTick(calm, worst, worst.least_ns / calm.least_ns)
