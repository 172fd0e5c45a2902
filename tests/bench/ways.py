"""The core's tick in three ways to compute, and with all that adds to it.

``python -m tests.bench --ways`` measures it: called, and in a compiled loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from helpers.loops import CASUALTY_KINDS, in_a_loop

from bench.batches import BATCH_NS, SEA_NAME, BatchCost, Voyage, time_batches
from trainer.analysis.bench.ticks import BATCH_COUNT, STANDARD_METHOD, ready_boat
from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.config.world.sea import load_sea

WAYS: Final = (STANDARD_METHOD, ("full", "exact", "adams2"), ("full", "exact", "rk4"))


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


@dataclass(frozen=True)
class WaysFigures:
    """What a tick costs in each way to compute, and in trouble."""

    updates: Sequence[UpdateCost]
    troubled: CasualtyTick


def time_ways(file: VesselFile) -> WaysFigures:
    """Return the figures of a boat."""
    boats = [ready_boat(file, way, file.run.step_s) for way in WAYS]
    return WaysFigures([*map(time_update, boats)], time_troubled(file, STANDARD_METHOD))


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


def lines(figures: WaysFigures) -> list[str]:
    """Return the figures as lines of a page."""
    page = [
        "",
        f"UPDATE, HOT ([ns], medians of {BATCH_COUNT} batches of {BATCH_NS / 1e6:g} ms or more)",
        f"  {'':<26}{'from Python':>12}{'in a kernel':>12}{'crossing':>10}{'ticks a batch':>16}",
    ]
    for update in figures.updates:
        name = f"{update.equations} {update.rates} {update.integrator}"
        ticks = f"{update.called.repetitions}/{update.in_kernel.repetitions}"
        page.append(
            f"  {name:<26}{update.called.median_ns:>12.0f}{update.in_kernel.median_ns:>12.0f}"
            f"{update.crossing_ns:>10.0f}{ticks:>16}"
        )
    difference = "the difference of the two least, which the machine disturbs least"
    return [
        *page,
        f"  (crossing: {difference})",
        f"  with a sea, tanks at work and six casualties {figures.troubled.troubled.median_ns:.0f}",
        f"  ({figures.troubled.times_the_calm:.2f} times the calm one)",
    ]
