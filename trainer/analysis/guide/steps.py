"""The step-size study compares integrators and steps with Runge and Kutta at a tenth.

The manoeuvres have no events, which a step would delay, and controls act at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.check import round_speeds
from trainer.analysis.guide.programme import Flown, Task
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig
from trainer.analysis.manoeuvres.turns import Turn
from trainer.analysis.manoeuvres.vertical import TrimChange
from trainer.boat.assemble import Method
from trainer.config.vessel import VesselFile
from trainer.units import KNOT

SHARES: Final = (0.5, 1.0, 2.0, 3.0)  # of the boat's own step: 0.25, 0.5, 1 and 1.5 s of 1969
FINE: Final = 0.1  # of it, the standard
LEAD: Final = 12.0  # own steps before controls move: whole ones of every share
SCHEMES: Final = (
    ("Adams 2", "adams2", "lagged"),
    ("Adams 2", "adams2", "exact"),
    ("Euler", "euler", "lagged"),
    ("Runge-Kutta 4", "rk4", "exact"),
)
WATCHED: Final = ("u", "w", "v", "r", "theta", "phi", "psi")
GOOD: Final = 1.0  # [%] error up to which a step is fine,
BAD: Final = 5.0  # and from which it is of no use
STILL: Final = 1e-3  # [rad] or of the speed: a column that moves less is not looked at
AT_ONCE: Final = Rig(controls="once")


@dataclass(frozen=True)
class StepRun:
    """One scheme at one step in one manoeuvre."""

    case: str
    scheme: str
    rates: str
    step_s: float
    percent: float | None  # worst error of any column, of its largest change; None: lost
    worst: str  # the column
    verdict: str  # "fine", "coarse", "of no use" or "lost"


def cases(file: VesselFile) -> dict[str, tuple[Manoeuvre, float]]:
    """Return the manoeuvres of the study and their speeds [m/s]."""
    lead, own = LEAD * file.run.step_s, file.run.start_speed_kn
    top = round_speeds(*file.run.speed_range_kn)[-1]
    turn = Turn(duration_s=300.0 * file.run.step_s / 0.5, keep=(), lead_s=lead)
    trim = TrimChange(duration_s=240.0 * file.run.step_s / 0.5, lead_s=lead)
    return {
        f"planes offset 3 deg, {own:g} kn": (trim, own * KNOT),
        f"rudder 15 deg, {own:g} kn": (turn, own * KNOT),
        f"rudder 15 deg, {top:g} kn": (turn, top * KNOT),
    }


def standard(file: VesselFile, manoeuvre: Manoeuvre, speed: float) -> Task:
    """Return the flight that is taken as true."""
    fine = Method("full", "exact", "exact", "rk4", FINE * file.run.step_s)
    return Task(manoeuvre, speed, fine, AT_ONCE)


def fly_schemes(
    file: VesselFile, manoeuvre: Manoeuvre, speed: float
) -> Iterator[tuple[tuple[str, str, str], float, Task]]:
    """Yield scheme, step [s] and flight of all that is tried."""
    for scheme in SCHEMES:
        for share in SHARES:
            step = share * file.run.step_s
            method = Method("full", scheme[2], "exact", scheme[1], step)
            yield scheme, step, Task(manoeuvre, speed, method, AT_ONCE)


def tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights of the study."""
    for manoeuvre, speed in cases(file).values():
        yield standard(file, manoeuvre, speed)
        yield from (task for _, _, task in fly_schemes(file, manoeuvre, speed))


def study(file: VesselFile, flown: Flown) -> tuple[StepRun, ...]:
    """Return how far every scheme and step is from the standard."""
    found = []
    for case, (manoeuvre, speed) in cases(file).items():
        true = flown[standard(file, manoeuvre, speed)]
        if isinstance(true, str) or true.lost:
            continue
        for (name, _, rates), step, task in fly_schemes(file, manoeuvre, speed):
            percent, worst = error(true, flown[task])
            found.append(StepRun(case, name, rates, step, percent, worst, verdict(percent)))
    return tuple(found)


def error(true: Flight, other: Flight | str) -> tuple[float | None, str]:
    """Return the worst error [%] of any column's extremes and end, and which; None: lost.

    Of as much as the column changes. Phase is not judged: Adams answers to a step of a control as
    if it had come half a cycle earlier.
    """
    if isinstance(other, str) or other.lost:
        return None, ""
    worst = (0.0, "")
    for name in WATCHED:
        span = float(np.ptp(true.column(name)))
        unit = true.speed if name in "uvw" else 1.0
        if span < STILL * unit:
            continue
        furthest = max(
            abs(a - b) for a, b in zip(_ends(true, name), _ends(other, name), strict=True)
        )
        worst = max(worst, (100.0 * furthest / span, name))
    return worst


def _ends(flight: Flight, name: str) -> tuple[float, float, float]:
    """Return the largest, the smallest and the last value of a column."""
    values = flight.column(name)
    return float(values.max()), float(values.min()), float(values[-1])


def verdict(percent: float | None) -> str:
    """Return an error [%] in words."""
    if percent is None:
        return "lost"
    if percent <= GOOD:
        return "fine"
    return "coarse" if percent <= BAD else "of no use"
