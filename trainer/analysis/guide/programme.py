"""What the guide flies, manoeuvres of 1969 and of today, and the processes that fly it."""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from time import monotonic
from typing import Final

import numpy as np

from trainer.analysis.characteristic import vertical
from trainer.analysis.check import round_speeds
from trainer.analysis.manoeuvres.catalogue import MANOEUVRES, find_manoeuvre, within_limits
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.workers import workers
from trainer.boat.assemble import Method
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile, load_vessel
from trainer.units import KNOT

OWN: Final = Rig()
ALONE: Final = 4.0  # [s]
CHUNK: Final = 6  # flights handed to a process at once


@dataclass(frozen=True)
class Task:
    """One flight to be flown."""

    manoeuvre: Manoeuvre
    speed: float  # [m/s]
    method: Method
    rig: Rig = OWN
    zeroed: tuple[str, ...] = ()  # coefficients taken away
    beside: Method | None = None  # of a flight whose events it takes within a cycle, as Conn has it


Flown = dict[Task, Flight | str]  # in words why there is no flight


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def _vessel(path: Path) -> VesselFile:
    """Return the boat of a file, read once in each process."""
    return load_vessel(str(path))


def fly_task(path: Path, task: Task) -> Flight | str:
    """Return the flight of a task by the boat of that file, or why there is none."""
    file = _vessel(path)
    if task.zeroed:
        nothing = dict.fromkeys(task.zeroed, 0.0)
        file = replace(file, coefficients={**file.coefficients, **nothing})
    boat = Submarine(file, task.method, task.rig)
    manoeuvre = within_limits(task.manoeuvre, boat)
    try:
        others: tuple[float | None, ...] = ()
        if task.beside:
            others = fly(Submarine(file, task.beside, task.rig), manoeuvre, task.speed).events
        return fly(boat, manoeuvre, task.speed, others)
    except ConfigError as wrong:
        return str(wrong)


def fly_all(path: Path, tasks: Iterable[Task], cores: int, step: Callable[[], None]) -> Flown:
    """Return the flights of all ``tasks`` by the boat of a file; ``step`` is called after each.

    Other processors are called in for what this one has not done in ALONE, which is about what
    starting them takes; they load the machine code that is there by then.
    """
    wanted = list(dict.fromkeys(tasks))
    found: Flown = {}
    begin = monotonic()
    for task in wanted:
        if cores > 1 and monotonic() - begin > ALONE:
            break
        found[task] = fly_task(path, task)
        step()
    rest = wanted[len(found) :]
    if rest:
        with workers(cores) as pool:
            flights = pool.map(partial(fly_task, path), rest, chunksize=CHUNK)
            for task, flight in zip(rest, flights, strict=True):
                found[task] = flight
                step()
    return found


SETS: Final = {  # equation set: accelerations, integrator
    "full": ("exact", "rk4"),
    "modified": ("lagged", "adams2"),
    "basic": ("lagged", "adams2"),
}
OF_ONE_SPEED: Final = (
    *("climbing-turn", "acceleration", "utmost-acceleration", "impulse", "rudder-impulse"),
    *("turning-circle", "zigzag-10", "zigzag-20", "pull-out", "spiral", "reverse-spiral"),
    *("vertical-zigzag", "crash-stop", "roll-decay"),
)
EXECUTES: Final = (5.0, 20.0)  # [deg] of the overshoots
RUDDERS: Final = (15.0, 35.0)  # [deg] of the turns
GRID: Final = 0.5  # [kn]


@dataclass(frozen=True)
class Leg:
    """One manoeuvre at one speed, to be flown by every equation set."""

    name: str  # of the manoeuvre
    variant: str  # what is particular, such as "execute 5 deg"
    speed_kn: float
    manoeuvre: Manoeuvre

    @property
    def title(self) -> str:
        """Return what the leg is called."""
        speed = "from rest" if self.manoeuvre.from_rest else f"{self.speed_kn:g} kn"
        return ", ".join(filter(None, (self.name, self.variant, speed)))

    def task(self, file: VesselFile, equations: str) -> Task:
        """Return the flight of the leg by one equation set, at the boat's own step.

        A reduced set is flown beside the full one.
        """
        beside = None if equations == "full" else own_method(file, "full")
        method = own_method(file, equations)
        return Task(self.manoeuvre, self.speed_kn * KNOT, method, beside=beside)


def own_method(file: VesselFile, equations: str) -> Method:
    """Return how the guide computes an equation set, at the boat's own step."""
    rates, integrator = SETS[equations]
    return Method(equations, rates, "exact", integrator, file.run.step_s)


def best_damped(file: VesselFile) -> float | None:
    """Return the speed [kn] on a grid at which vertical motion dies away fastest; None: at none."""
    low, high = file.run.speed_range_kn
    grid = np.arange(np.ceil(low / GRID) * GRID, high + 1e-9, GRID)
    slowest = [float(-vertical(file, float(u) * KNOT).eigenvalues.real.max()) for u in grid]
    best = int(np.argmax(slowest))
    return float(grid[best]) if slowest[best] > 0.0 else None


def legs(file: VesselFile) -> tuple[Leg, ...]:
    """Return the legs of the guide that this boat has the controls for, in order."""
    boat = Submarine(file, own_method(file, "full"))
    found = [
        replace(leg, manoeuvre=within_limits(leg.manoeuvre, boat))
        for leg in _legs_of_1969(file)
        if all(control in boat.controls for control in leg.manoeuvre.needs)
    ]
    return tuple(dict.fromkeys(_name_by_angle(leg) for leg in found))


def _legs_of_1969(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs, angles as of 1969."""
    speeds = round_speeds(*file.run.speed_range_kn)
    low, high, own = speeds[min(1, len(speeds) - 1)], speeds[-1], file.run.start_speed_kn
    best = best_damped(file)
    more = () if best is None else (best,)
    for speed in sorted({*speeds, *more}):
        yield Leg("meander", "", speed, find_manoeuvre("meander"))
    for speed in (low, high):
        for execute in EXECUTES:
            overshoot = replace(find_manoeuvre("overshoot"), execute_deg=execute)  # type: ignore[call-arg]
            yield Leg("overshoot", f"execute {execute:g} deg", speed, overshoot)
    for speed in (low, high):
        for rudder in RUDDERS:
            turn = replace(find_manoeuvre("turn"), angle_deg=rudder)  # type: ignore[call-arg]
            yield Leg("turn", "rudder", speed, turn)
    for speed in speeds:
        yield Leg("trim", "", speed, find_manoeuvre("trim"))
    for name in OF_ONE_SPEED:
        yield Leg(name, "", 0.0 if MANOEUVRES[name].from_rest else own, find_manoeuvre(name))


def _name_by_angle(leg: Leg) -> Leg:
    """Return the leg with the rudder's angle in its name, where it is the boat's limit or not."""
    if leg.variant != "rudder":
        return leg
    angle = getattr(leg.manoeuvre, "angle_deg")  # noqa: B009 (not every manoeuvre has one)
    return replace(leg, variant=f"rudder {angle:g} deg")
