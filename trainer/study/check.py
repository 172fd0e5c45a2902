"""What a boat is by its numbers, and which steps it can be flown with: ``trainer check``."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from trainer.boat import Boat
from trainer.files.vessel_file import VesselFile
from trainer.fitout import Method, scheme_record
from trainer.study import hull_facts
from trainer.study.linear import bring_to, respond
from trainer.study.modes import Mode, modes
from trainer.study.stability import (
    largest_flown,
    largest_step,
    responses,
    stable_at,
    worst_motion,
)
from trainer.study.steady_turn import Comparison, compare_turns
from trainer.units import KNOT

EQUATIONS = ("full", "modified", "basic")
REGIONS = ("adams2", "euler")
STEPS = (0.5, 1.0)  # [s] of [ASSES]: modified and basic set
UNITS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # [kn]
INTERVALS = 5


@dataclass(frozen=True)
class ModeRow:
    """One mode; ``largest`` step [s] by method where the boat damps it, else empty."""

    name: str
    real: float  # [1/s]
    imaginary: float  # [1/s]
    period_s: float | None
    damping_ratio: float | None
    time_constant_s: float | None
    stable: bool
    largest_s: dict[str, float]


@dataclass(frozen=True)
class Flight:
    """Straight flight at one speed by the full set."""

    speed_kn: float
    trimmed: bool
    pitch_deg: float
    stern_planes_deg: float
    bow_planes_deg: float
    modes: tuple[ModeRow, ...]


@dataclass(frozen=True)
class Verdict:
    """One step of 2nd-order Adams with lagged accelerations, over all speeds."""

    equations: str
    step_s: float
    stable: bool
    growth: float  # [-] largest factor per tick that is not the boat's own
    worst: str  # the motion that is in, and the speed


@dataclass(frozen=True)
class Report:
    """All that ``trainer check`` says about a vessel; as JSON by ``dataclasses.asdict``."""

    vessel: str
    path: str
    defaulted: tuple[str, ...]
    remarks: tuple[str, ...]
    absent_but_kept: dict[str, list[str]]  # absent, and the compact set would keep them
    absent_and_dropped: dict[str, list[str]]
    asymmetries: dict[str, float]
    inertia: hull_facts.Inertia
    margins: dict[str, float | None]
    critical_speed_kn: dict[str, float | None]
    flights: tuple[Flight, ...]
    largest_flown_s: dict[str, dict[str, float | None]]  # by equation set, by method; None: any
    verdicts: tuple[Verdict, ...]
    turn: Comparison
    stable: bool


def round_speeds(low: float, high: float) -> tuple[float, ...]:
    """Return ``low``, ``high`` [kn] and the round speeds between, about five."""
    unit = next((u for u in UNITS if (high - low) / u <= INTERVALS), UNITS[-1])
    between = (unit * i for i in range(math.ceil(low / unit), math.ceil(high / unit)))
    return tuple(sorted({low, *(round(speed, 9) for speed in between if speed > low), high}))


def _row(mode: Mode) -> ModeRow:
    """Return one mode and the steps its decay allows."""
    largest = {}
    if mode.stable:
        for integrator in REGIONS:
            scheme = scheme_record(Method("full", "exact", "exact", integrator, 1.0))
            largest[integrator] = largest_step(scheme, mode.eigenvalue)
    return ModeRow(
        mode.name,
        mode.real,
        mode.imaginary,
        mode.period,
        mode.damping_ratio,
        mode.time_constant,
        mode.stable,
        largest,
    )


def flights(file: VesselFile, speeds: Iterable[float]) -> tuple[Flight, ...]:
    """Return trim and modes of the full set at ``speeds`` [kn]."""
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    found = []
    for speed in speeds:
        trimmed = bring_to(boat, speed * KNOT)
        flight = respond(boat)
        found.append(
            Flight(
                speed_kn=speed,
                trimmed=trimmed,
                pitch_deg=math.degrees(boat.state.theta),
                stern_planes_deg=math.degrees(boat.state.delta_s),
                bow_planes_deg=math.degrees(boat.state.delta_b),
                modes=tuple(_row(mode) for mode in modes(flight.nature, flight.names)),
            )
        )
    return tuple(found)


def _finite(number: float) -> float | None:
    """Return ``number``, None for infinity."""
    return None if math.isinf(number) else number


def check(file: VesselFile) -> Report:
    """Return the report on ``file``; ``stable`` is False if any of the verdicts is."""
    speeds = round_speeds(*file.run.speed_range_kn)
    largest: dict[str, dict[str, float | None]] = {}
    verdicts = []
    for equations in EQUATIONS:
        boat = Boat(file, Method(equations, "lagged", "exact", "adams2", file.run.step_s))
        flown = responses(boat, (speed * KNOT for speed in speeds))
        largest[equations] = {}
        for integrator in REGIONS:
            scheme = scheme_record(Method(equations, "lagged", "exact", integrator, 1.0))
            largest[equations][integrator] = _finite(largest_flown(flown.values(), scheme))
        adams = scheme_record(Method(equations, "lagged", "exact", "adams2", 1.0))
        for step in sorted({*STEPS, file.run.step_s}):
            stable = stable_at(flown.values(), adams, step)
            verdicts.append(Verdict(equations, step, stable, *worst_motion(flown, adams, step)))
    critical = {plane: hull_facts.critical_speed(file, plane) for plane in ("stern", "bow")}
    return Report(
        vessel=file.name,
        path=str(file.path),
        defaulted=file.defaulted,
        remarks=file.remarks,
        absent_but_kept=hull_facts.absent(file, kept=True),
        absent_and_dropped=hull_facts.absent(file, kept=False),
        asymmetries=hull_facts.asymmetries(file),
        inertia=hull_facts.inertia(file, file.run.step_s),
        margins=hull_facts.margins(file),
        critical_speed_kn={
            plane: None if speed is None else speed / KNOT for plane, speed in critical.items()
        },
        flights=flights(file, speeds),
        largest_flown_s=largest,
        verdicts=tuple(verdicts),
        turn=compare_turns(file),
        stable=all(verdict.stable for verdict in verdicts),
    )
