"""The preparation of a boat before the clock starts: loaded, and of a stable step.

``run`` calls these functions, because code that is loaded or compiled within a tick would stop the
boat.
"""

import gc
import sys
from functools import partial
from typing import Final

from trainer.boat import casualties, compilation, machine_code
from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.files import ConfigError
from trainer.core.start import set_out
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

BOAT_TEXT: Final = "the boat, this once (about a minute)"


def warm_boat(boat: Boat) -> None:
    """Load the boat's code and try it, because nothing may compile once the clock runs."""
    if machine_code.way_name() != machine_code.BY_NUMBA:
        try_out(boat)
        return
    with compilation.announce_compiling(BOAT_TEXT, partial(print, file=sys.stderr)):
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
