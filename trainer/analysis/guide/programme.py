"""The programme of the guide: manoeuvres of 1969 and of today, and their processes.

A leg is one manoeuvre at one speed, flown by every equation set; a task is one flight of it. The
guide, ``check`` and the search for a compact set take their legs from here, so that a set is judged
by the flights that a reader sees. Flights are spread over processes, because a guide has hundreds.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.check import round_speeds
from trainer.analysis.manoeuvres.casualties import OutOfBalance
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre, within_limits
from trainer.analysis.manoeuvres.flight import FIELD_CHOICES, Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.seakeeping import wave_number
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vertical import Meander, Overshoot, TrimChange
from trainer.analysis.programs.characteristic import vertical_system
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.units import KNOT
from trainer.workers import worker_pool

OWN_RIG: Final = Rig()
LIMITED_RIG: Final = Rig(engine="limited")
LONE_FLIGHTS: Final = 200  # about as many as one process flies until others have started
CHUNK_FLIGHTS: Final = 6  # flights handed to a process at once
SET_METHODS: Final = {  # equation set: accelerations, integrator
    "full": ("exact", "rk4"),
    "modified": ("lagged", "adams2"),
    "basic": ("lagged", "adams2"),
}
# at the boat's own speed or from rest, each to both sides or up and down
# fmt: off
ONE_SPEED_MANOEUVRES: Final = (
    "climbing-turn", "acceleration", "utmost-acceleration", "impulse", "rudder-impulse",
    "turning-circle", "zigzag-10", "zigzag-20", "pull-out", "spiral", "reverse-spiral",
    "vertical-zigzag", "crash-stop", "backing", "roll-decay", "plane-jam", "rudder-jam",
)
# fmt: on
TWO_SIDED_MANOEUVRES: Final = ("pull-out", "spiral", "reverse-spiral")  # by themselves
SHALLOW_MANOEUVRES: Final = ("turn", "zigzag-10", "trim")  # flown near the surface as well
SEA_MANOEUVRE: Final = "beam-sea"
# [diameters] of the origin's depth there: an estimate of periscope depth
SHALLOW_DEPTH_DIAMETERS: Final = 2.5
LOAD_SHARES: Final = (0.002, -0.002)  # [-] of the weight, out of balance
EXECUTE_ANGLES_DEG: Final = (5.0, 20.0)  # [deg] of the overshoots
RUDDER_ANGLES_DEG: Final = (15.0, 35.0)  # [deg] of the turns
SPEED_GRID_KN: Final = 0.5  # [kn] between the speeds among which the best damped is sought
OFFSETS_1969, EXECUTES_1969 = (10.0, 20.0), (4.0, 8.0, 12.0, 16.0)  # [deg] of the overshoots
RUDDERS_1969: Final = (15.0, 25.0, 35.0)  # [deg]
PITCH_SWING_MEASURES: Final = ("pitch peak", "pitch zero")
TRAINER_CHECKS: Final = {  # what a trainer's guide judges, by the beginnings of measures
    "meander": PITCH_SWING_MEASURES,
    "overshoot": PITCH_SWING_MEASURES,
    "turn": ("snap roll", "steady roll", "steady speed, of the first", "heading after 60 s"),
    "utmost-acceleration": ("speed after",),
}
RUDDER_PLACEHOLDER: Final = "rudder"  # stands for its angle until the boat's limit is known


@dataclass(frozen=True)
class Task:
    """A flight to fly: manoeuvre, speed and method. It is the key of its flight."""

    manoeuvre: Manoeuvre
    speed: float  # [m/s]
    method: Method
    rig: Rig = OWN_RIG
    zeroed: tuple[str, ...] = ()  # coefficients taken away
    beside: Method | None = None  # of a flight whose events it takes within a cycle, as Conn has it


FlightTable = dict[Task, Flight | str]  # in words why there is no flight


@cache
def _vessel(path: Path) -> VesselFile:
    """Return the boat of a file, read once in each process."""
    return load_vessel(str(path))


def fly_task(path: Path, task: Task) -> Flight | str:
    """Return the flight of a task by that file's boat, or why there is none."""
    file = _vessel(path)
    if task.zeroed:
        nothing = dict.fromkeys(task.zeroed, 0.0)
        file = replace(file, coefficients={**file.coefficients, **nothing})
    return fly_boat(file, task)


def fly_boat(file: VesselFile, task: Task) -> Flight | str:
    """Return a boat's flight of a task, or in words why there is none."""
    boat = Submarine(file, task.method, task.rig)
    manoeuvre = within_limits(task.manoeuvre, boat)
    try:
        others: tuple[float | None, ...] = ()
        if task.beside:
            other = Submarine(file, task.beside, task.rig)
            others = fly_manoeuvre(other, manoeuvre, task.speed).events
        return fly_manoeuvre(boat, manoeuvre, task.speed, others)
    except ConfigError as wrong:
        return str(wrong)


def fly_all(path: Path, tasks: Iterable[Task], cores: int, step: Callable[[], None]) -> FlightTable:
    """Return the flights of all ``tasks`` by the boat of a file. ``step`` is called after each.

    This process flies LONE_FLIGHTS alone, because starting others takes about as long. Others then
    fly the rest, and load the machine code that this one has compiled by then. It is a count and no
    time, so that the same tasks go the same way on a busy machine.
    """
    wanted = list(dict.fromkeys(tasks))
    flown_tasks: FlightTable = {}
    lone = wanted[:LONE_FLIGHTS] if cores > 1 else wanted
    for task in lone:
        flown_tasks[task] = fly_task(path, task)
        step()
    rest = wanted[len(lone) :]
    if rest:
        with worker_pool(cores) as pool:
            flights = pool.map(partial(fly_task, path), rest, chunksize=CHUNK_FLIGHTS)
            for task, flight in zip(rest, flights, strict=True):
                flown_tasks[task] = flight
                step()
    return flown_tasks


@dataclass(frozen=True)
class Leg:
    """One manoeuvre at one speed, to be flown by every equation set."""

    name: str  # of the manoeuvre
    variant: str  # what is particular, such as "execute 5 deg"
    speed_kn: float
    manoeuvre: Manoeuvre
    rig: Rig = OWN_RIG
    checks: tuple[str, ...] = ()  # beginnings of the measures that are judged; (): all are

    @property
    def title(self) -> str:
        """Return what the leg is called."""
        speed = "from rest" if self.manoeuvre.from_rest else f"{self.speed_kn:g} kn"
        depth = "" if self.rig.depth is None else f"{self.rig.depth:g} m deep"
        engine = "engine limited" if self.rig.engine == "limited" else ""
        return ", ".join(filter(None, (self.name, self.variant, speed, depth, engine)))

    def method(self, file: VesselFile, equations: str) -> Method:
        """Return how a set computes the leg: in waves as the reduced sets are computed."""
        own = own_method(file, equations)
        if not self.manoeuvre.in_waves:
            return own
        rates, integrator = SET_METHODS["modified"]
        return replace(own, rates=rates, integrator=integrator)

    def task(self, file: VesselFile, equations: str) -> Task:
        """Return the flight of the leg by one equation set, at the boat's own step.

        A reduced set is flown beside the full one.
        """
        beside = None if equations == "full" else self.method(file, "full")
        method = self.method(file, equations)
        return Task(self.manoeuvre, self.speed_kn * KNOT, method, self.rig, beside=beside)


def own_method(file: VesselFile, equations: str) -> Method:
    """Return how the guide computes an equation set, at the boat's own step."""
    rates, integrator = SET_METHODS[equations]
    return Method(equations, rates, "exact", integrator, file.run.step_s)


def _best_speed(file: VesselFile, damping: Callable[[Any], Any]) -> float | None:
    """Return the speed [kn] on a grid whose least damping of vertical roots is largest, if any."""
    low, high = file.run.speed_range_kn
    grid = np.arange(np.ceil(low / SPEED_GRID_KN) * SPEED_GRID_KN, high + 1e-9, SPEED_GRID_KN)
    least = [damping(vertical_system(file, float(u) * KNOT).eigenvalues).min() for u in grid]
    best = int(np.argmax(least))
    return float(grid[best]) if least[best] > 0.0 else None


def guide_legs(file: VesselFile, depth: float | None = None) -> tuple[Leg, ...]:
    """Return the legs of the guide that this boat has the controls for, in order.

    They begin at ``depth`` [m]; None: deep, and some of them near the surface too. ConfigError for
    a depth that the boat cannot begin at.
    """
    boat = _boat_at(file, depth)
    return _manned(boat, _legs(boat, file, depth))


def legs_of_1969(file: VesselFile, depth: float | None = None) -> tuple[Leg, ...]:
    """Return the programme that was flown for the report, as ``guide_legs`` has the guide's.

    Five speeds each have overshoots by two angles until four pitches (40 in all), turns by three
    rudders (15), meanders and trims. Both accelerations, and a pulse of planes and of rudder, are
    flown once. Speeds are fifths of the boat's top speed, where 1969 had 5 to 25 kn.
    """
    boat = _boat_at(file, depth)
    bare_legs = _legs_of_1969(file)
    return _manned(boat, (replace(leg, rig=Rig(depth=depth)) for leg in bare_legs))


def legs_of_trainer(file: VesselFile, depth: float | None = None) -> tuple[Leg, ...]:
    """Return the short programme that section V of 1969 asks of a trainer.

    Meanders at five speeds, of which one has the largest damping ratio; overshoots and turns at a
    low and a high speed, these with depth kept by the stern planes; ahead from rest and stopped.
    """
    boat, rig = _boat_at(file, depth), Rig(depth=depth)
    bare_legs = _legs_of_trainer(file)
    return _manned(
        boat, (replace(leg, rig=rig, checks=TRAINER_CHECKS[leg.name]) for leg in bare_legs)
    )


def _legs_of_trainer(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs of the short programme, each one way."""
    speeds = _fifths(file)
    damped = _best_speed(file, lambda roots: -roots.real / abs(roots))
    if damped is not None:
        nearest = min(speeds, key=lambda speed: abs(speed - damped))
        speeds[speeds.index(nearest)] = damped
    for speed in speeds:
        yield Leg("meander", "", speed, Meander())
    ends = (speeds[0], speeds[-1])
    for speed, execute in product(ends, EXECUTE_ANGLES_DEG):
        yield Leg("overshoot", f"execute {execute:g} deg", speed, Overshoot(execute_deg=execute))
    for speed, rudder in product(ends, RUDDER_ANGLES_DEG):
        turn = Turn(angle_deg=rudder, keep=("depth by stern planes",))
        yield Leg("turn", RUDDER_PLACEHOLDER, speed, turn)
    yield Leg("utmost-acceleration", "", 0.0, find_manoeuvre("utmost-acceleration"))


def _fifths(file: VesselFile) -> list[float]:
    """Return five speeds [kn] to the boat's top speed."""
    low, top = file.run.speed_range_kn
    return [round(max(low, top * fifth / 5), 2) for fifth in range(1, 6)]


def _boat_at(file: VesselFile, depth: float | None) -> Submarine:
    """Return the boat; ConfigError where it cannot begin at a ``depth`` [m]."""
    boat = Submarine(file, own_method(file, "full"), Rig(depth=depth))
    if depth is not None:
        boat.start(file.run.start_speed_kn * KNOT)
    return boat


def _manned(boat: Submarine, wanted: Iterable[Leg]) -> tuple[Leg, ...]:
    """Return the legs that the boat has controls for, each angle within the control's limit."""
    manned = [
        replace(leg, manoeuvre=within_limits(leg.manoeuvre, boat))
        for leg in wanted
        if all(control in boat.controls for control in leg.manoeuvre.needs)
    ]
    return tuple(dict.fromkeys(_name_by_angle(leg) for leg in manned))


def _legs_of_1969(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs of the report's programme, each one way as there."""
    for speed in _fifths(file):
        yield Leg("meander", "", speed, Meander())
        for angle, execute in product(OFFSETS_1969, EXECUTES_1969):
            variant = f"planes {angle:g} deg, execute {execute:g} deg"
            yield Leg("overshoot", variant, speed, Overshoot(angle_deg=angle, execute_deg=execute))
        for rudder in RUDDERS_1969:
            yield Leg("turn", RUDDER_PLACEHOLDER, speed, Turn(angle_deg=rudder))
        yield Leg("trim", "", speed, TrimChange())
    own_speed = file.run.start_speed_kn
    for name in ("acceleration", "utmost-acceleration", "impulse", "rudder-impulse"):
        manoeuvre = find_manoeuvre(name)
        yield Leg(name, "", 0.0 if manoeuvre.from_rest else own_speed, manoeuvre)


def _legs(boat: Submarine, file: VesselFile, depth: float | None) -> Iterator[Leg]:
    """Yield the legs at a depth [m], angles as of 1969; where it is None, some near the surface."""
    deep = (*_legs_by_speed(file), *_legs_of_one_speed(file))
    if depth is not None:
        yield from (replace(leg, rig=replace(leg.rig, depth=depth)) for leg in deep)
        return
    yield from deep
    diameter, own_speed = float(boat.boat.vessel.diameter), file.run.start_speed_kn
    if diameter > 0.0:  # else the boat does not feel the surface
        near = Rig(depth=round(SHALLOW_DEPTH_DIAMETERS * diameter, 1))
        for name in SHALLOW_MANOEUVRES:
            for leg in both_ways(name, own_speed, find_manoeuvre(name)):
                yield replace(leg, rig=near)
    if file.autopilot:  # by hand the boat would leave the waves' beam
        rig = Rig(depth=round(1.0 / wave_number(file.hull.length), 1))  # the peak's over 2 pi
        yield Leg(SEA_MANOEUVRE, "", own_speed, find_manoeuvre(SEA_MANOEUVRE), rig)


def both_ways(name: str, speed: float, manoeuvre: Manoeuvre, variant: str = "") -> Iterator[Leg]:
    """Yield a manoeuvre to each side, to rise and to dive, where it has these.

    One that has both rises to starboard and dives to port.
    """
    fields = [name for name in FIELD_CHOICES if hasattr(manoeuvre, name)]
    for picked in zip(*(FIELD_CHOICES[field] for field in fields), strict=True) if fields else [()]:
        words = ", ".join(filter(None, (variant, *picked)))
        yield Leg(name, words, speed, replace(manoeuvre, **dict(zip(fields, picked, strict=True))))


def turn_rigs(file: VesselFile) -> tuple[Rig, ...]:
    """Return how a boat turns: by held revolutions, and within the limits of its engine.

    A turn slows the boat, so that the propeller takes more torque than in straight flight.
    """
    engine = file.propulsion
    limited = engine.torque_limit_n_m is not None or engine.shaft_power_w is not None
    return (OWN_RIG, LIMITED_RIG) if limited else (OWN_RIG,)


def _legs_by_speed(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs at several speeds."""
    speeds = round_speeds(*file.run.speed_range_kn)
    low, high = speeds[min(1, len(speeds) - 1)], speeds[-1]
    best = _best_speed(file, lambda roots: -roots.real)  # at which motion dies away fastest
    for speed in sorted({*speeds, *([] if best is None else [best])}):
        yield from both_ways("meander", speed, find_manoeuvre("meander"))
    for speed in (low, high):
        for execute in EXECUTE_ANGLES_DEG:
            overshoot = replace(find_manoeuvre("overshoot"), execute_deg=execute)  # type: ignore[call-arg]
            yield from both_ways("overshoot", speed, overshoot, f"execute {execute:g} deg")
    for speed in (low, high):
        for rudder in RUDDER_ANGLES_DEG:
            turn = replace(find_manoeuvre("turn"), angle_deg=rudder)  # type: ignore[call-arg]
            legs = tuple(both_ways("turn", speed, turn, RUDDER_PLACEHOLDER))
            for rig in turn_rigs(file) if speed == high else (OWN_RIG,):
                yield from (replace(leg, rig=rig) for leg in legs)
    for speed in speeds:
        yield from both_ways("trim", speed, find_manoeuvre("trim"))


def _legs_of_one_speed(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs at the boat's own speed, or from rest."""
    own_speed = file.run.start_speed_kn
    for name in ONE_SPEED_MANOEUVRES:
        manoeuvre = find_manoeuvre(name)
        speed = 0.0 if manoeuvre.from_rest else own_speed
        if name in TWO_SIDED_MANOEUVRES:
            yield Leg(name, "", speed, manoeuvre)
        else:
            yield from both_ways(name, speed, manoeuvre)
    for share in LOAD_SHARES:
        kept_axes = ("depth",) if share < 0.0 else ()
        variant = f"{share:+.1%}, {'depth kept' if kept_axes else 'planes still'}"
        yield Leg("out-of-balance", variant, own_speed, OutOfBalance(share=share, keep=kept_axes))


def _name_by_angle(leg: Leg) -> Leg:
    """Return the leg with the rudder's angle in its name, where it is the boat's limit or not."""
    if not isinstance(leg.manoeuvre, Turn):
        return leg
    angle = f"rudder {leg.manoeuvre.angle_deg:g} deg"
    return replace(leg, variant=leg.variant.replace(RUDDER_PLACEHOLDER, angle, 1))
