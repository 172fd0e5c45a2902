"""The preparation of a boat before the clock starts: compiled, and of a stable step.

``run`` calls these functions, because code that compiles within a tick would stop the boat for
seconds. As a program (``python -m trainer.session.warm_up``) it compiles for later starts, beside a
run that flies by the interpreter meanwhile (``first_start``).
"""

import contextlib
import gc
import os
import sys
from functools import partial
from typing import Final

import click
import numpy as np

from trainer.boat import casualties, compilation
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise import ExerciseLimits
from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.core.cache import cache_folder
from trainer.core.entry import LOOKOUT, ROW_COLUMNS, sail
from trainer.core.start import set_out
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

BOAT_TEXT: Final = "the boat, this once (about a minute)"
MAX_CPU_TIME_S: Final = 600  # [s] of processor time: whatever happens, it ends
TICK_NICENESS: Final = 5  # a run is waiting for it, and goes first all the same
REST_NICENESS: Final = 10  # of a process that compiles beside a run: the ticks come first


def warm_boat(boat: Boat) -> None:
    """Compile and try the boat, because nothing may compile once the clock runs."""
    with compilation.announce_compiling(BOAT_TEXT, partial(click.echo, err=True)):
        try_out(boat)


def set_garbage_aside() -> None:
    """Leave all present objects out of later collections, in a process that is one run."""
    if gc.isenabled():  # else this process has just begun, and has no garbage to speak of
        gc.collect()
    gc.freeze()  # a full collection with numba loaded takes 0.1 s
    gc.enable()


def try_out(boat: Boat) -> None:
    """Take a tick and a casualty on a throw-away state, to run all code once."""
    before = boat.snapshot()
    boat.state.u = 1.0
    boat.trimmed(1.0)
    set_out(*boat.records)
    boat.stand_by()
    boat.put_to_sea(boat.sea)
    casualties.insert_casualty(boat, "propulsion-lost")
    boat.tick()
    casualties.instrument_readings(boat)
    casualties.clear_casualty(boat, "all")
    LimitMonitor.over(boat, ExerciseLimits())
    state = boat.records.state.tobytes()
    StateReader(boat, Ledger(boat.method.step).summary).frame(Picture(0, state, Pace()))
    boat.restore(before)


def refuse_unstable(boat: Boat) -> None:
    """Raise ConfigError if the step makes the boat unstable, naming the largest stable one."""
    from trainer.boat import stability  # noqa: PLC0415

    low, high = boat.file.run.speed_range_kn
    flights = stability.boat_responses(boat, (low * KNOT, 0.5 * (low + high) * KNOT, high * KNOT))
    if not stability.stable_at(flights.values(), boat.records.scheme, boat.method.step):
        verdict = stability.stable_step(boat, flights)
        raise ConfigError(
            f"--step {boat.method.step:g} s is not stable with {boat.method.integrator}: "
            f"{verdict.worst}; the largest stable step is {verdict.largest:.3g} s "
            "(--unsafe-step runs it all the same)"
        )


# The core compiled for later starts: ``python -m trainer.session.warm_up``


def precompile(lock: int | None = None) -> None:
    """Compile all that a run needs, unless another process does so or has done so.

    ``lock`` allows it, where the process that started this one has taken the lock already.
    """
    with contextlib.ExitStack() as stack:
        if lock is None:
            lock = stack.enter_context(compilation.compilation_lock())
        if lock is not None and not compilation.is_kept():
            compile_in_stages()


def compile_in_stages() -> None:
    """Compile the tick first, because runs at sea wait for it, and then the rest."""
    limit_work(TICK_NICENESS)
    if not compilation.is_tick_kept():
        from trainer.boat.first_tick import compile_tick  # noqa: PLC0415  an interpreted run must not

        compile_tick(compilation.write_progress)
        compilation.mark_compiled("tick")
    limit_work(REST_NICENESS - TICK_NICENESS)
    boat = Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    try_out(boat)
    # what flies manoeuvres calls the tick from kernels: many ticks in one call
    sail(tuple(boat.records), np.zeros(1, LOOKOUT), np.zeros((1, ROW_COLUMNS)))
    compilation.mark_compiled()
    for name in (compilation.ERROR_LOG_NAME, compilation.PROGRESS_NAME):
        (cache_folder() / name).unlink(missing_ok=True)


def limit_work(niceness: int) -> None:
    """Lower the priority of this process, and limit its processor time, if possible."""
    if os.name == "posix":
        import resource  # noqa: PLC0415  not everywhere

        os.nice(niceness)
        resource.setrlimit(resource.RLIMIT_CPU, (MAX_CPU_TIME_S, MAX_CPU_TIME_S))


if __name__ == "__main__":
    precompile(*map(int, sys.argv[1:]))
