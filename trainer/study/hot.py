"""The core's tick back to back: called, in a compiled loop, and with everything going on."""

import gc
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from trainer import casualty
from trainer.boat import Boat
from trainer.core.kernel import Record, kernel
from trainer.core.update import update
from trainer.files.sea_file import load_sea
from trainer.files.vessel_file import VesselFile
from trainer.fitout import Method, Records
from trainer.study.batches import Batches, time_batches
from trainer.units import KNOT
from trainer.watch import showing

STANDARD: Final = ("modified", "lagged", "adams2")
SEA: Final = "sea-state-5"
CASUALTIES: Final = (
    *("rudder-slow", "stern-slow", "bow-slow"),
    *("depth-gauge-noisy", "gyro-biased", "log-noisy"),
)


@dataclass(frozen=True)
class Update:
    """One way to compute the boat: a tick called from Python, and inside a compiled loop."""

    equations: str
    rates: str
    integrator: str
    step_s: float
    called: Batches
    in_kernel: Batches
    crossing_ns: float  # the least of called less the least of in_kernel: interference only adds


@dataclass(frozen=True)
class Troubled:
    """A tick in the compiled loop, in a calm and with a sea, tanks at work and six casualties."""

    calm: Batches
    troubled: Batches
    times_the_calm: float  # least over least: interference only adds


@kernel
def take_ticks(
    vessel: Record, compact: Record, scheme: Record, count: int, state: Record, scratch: Record
) -> int:
    """Advance ``state`` by ``count`` ticks without Python between them; return the last status."""
    status = 0
    for _ in range(count):
        status = update(vessel, compact, scheme, state, scratch)
    return status


def in_a_loop(records: Records, count: int) -> int:
    """Take ``count`` ticks of a boat in the compiled loop; return the status of the last."""
    vessel, compact, scheme, state, scratch = records
    return int(take_ticks(vessel, compact, scheme, count, state, scratch))


def ready(file: VesselFile, way: tuple[str, str, str], step: float) -> Boat:
    """Return a boat under way in trim, its tick compiled and the garbage out of the way."""
    equations, rates, integrator = way
    boat = Boat(file, Method(equations, rates, "exact", integrator, step))
    boat.start(file.run.start_speed_kn * KNOT, file.run.start_depth_m, 0.0)
    start = boat.snapshot()
    boat.tick()
    showing(boat)
    boat.restore(start)
    gc.collect()
    gc.freeze()  # as a run does: a full collection with numba loaded takes 0.1 s
    return boat


def time_update(boat: Boat) -> Update:
    """Return the cost of a tick of the core, with and without a call from Python around it."""
    vessel, compact, scheme, state, scratch = boat.records
    tick = boat.tick

    def call(count: int) -> None:
        for _ in range(count):
            tick()

    def loop(count: int) -> None:
        take_ticks(vessel, compact, scheme, count, state, scratch)

    called, in_kernel = time_batches([call, loop])
    method = boat.method
    return Update(
        equations=method.equations,
        rates=method.rates,
        integrator=method.integrator,
        step_s=method.step,
        called=called,
        in_kernel=in_kernel,
        crossing_ns=called.least_ns - in_kernel.least_ns,
    )


def time_troubled(file: VesselFile, way: tuple[str, str, str]) -> Troubled:
    """Return what sea, tanks (where the boat has any) and casualties add to a tick."""
    boats = [ready(file, way, file.run.step_s) for _ in range(2)]
    troubled = boats[1]
    troubled.put_to_sea(load_sea(SEA))
    troubled.state.hover = troubled.vessel.fitted
    troubled.state.move_trim = 1e9 * troubled.vessel.fitted
    for name in CASUALTIES:
        casualty.insert(troubled, name)

    def loop(boat: Boat) -> Callable[[int], None]:
        vessel, compact, scheme, state, scratch = boat.records

        def run(count: int) -> None:
            take_ticks(vessel, compact, scheme, count, state, scratch)

        return run

    calm, worst = time_batches([loop(boat) for boat in boats])
    return Troubled(calm, worst, worst.least_ns / calm.least_ns)
