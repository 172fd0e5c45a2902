"""``trainer boat check``: a boat judged by its numbers, and its stable steps.

It compares the compact set with the full one in a steady turn, and finds the largest step at which
an integrator does not make a stable boat unstable. ``check_page`` shows the report; estimates,
guides and reductions use the same checks.
"""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import starmap

import numpy as np

from trainer.boat.assemble import Method, scheme_record
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.envelope import bounded_keys, is_clipped, surface_modes
from trainer.boat.linear import Mode, bring_to, measure_response, modes
from trainer.boat.plant import PlantFacts, plant_facts
from trainer.boat.stability import (
    boat_responses,
    largest_flown,
    largest_step,
    stable_at,
    worst_motion,
)
from trainer.config.boat.plausibility import torque_remarks
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core import full
from trainer.core.envelope import substeps
from trainer.core.terms import COEFFICIENTS
from trainer.units import KNOT

TURN_RUDDER_DEG = 15.0  # [deg]
TURN_LENGTHS = 90.0  # boat lengths at the first speed: long enough to settle,
AVERAGED_LENGTHS = 20.0  # the last of which are averaged
MAX_TURN_TICKS = 20_000  # at whatever speed
TURN_OFFSETS = np.array([STATE_OFFSETS[name] for name in ("u", "v", "psidot", "phi")])
MAX_YAW_RATE_SPREAD = 0.02  # [-] of the yaw rate over them: more is not steady
PLANE_NAMES = ("stern", "bow")
# [ASSES] equations (2), (4), (6)
ASYMMETRIC_COEFFICIENTS = ("Y_star", "K_star", "N_star", "K_star_eta")
EQUATION_SETS = ("full", "modified", "basic")
STABILITY_METHODS = ("adams2", "euler")
STEPS_1969_S = (0.5, 1.0)  # [s] of [ASSES]: modified and basic set
CHECKED_SPEEDS_KN = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # [kn]
SPEED_INTERVALS = 5  # between the speeds checked, at most: the least round step that does is taken


@dataclass(frozen=True)
class SteadyTurn:
    """A steady turn."""

    diameter_m: float
    speed_kn: float  # resultant in the boat's plane
    yaw_rate_deg_s: float
    heel_deg: float  # starboard side down


@dataclass(frozen=True)
class TurnComparison:
    """The same turn by both sets. A turn that did not settle is None, and ``problem`` says why."""

    rudder_deg: float
    speed_kn: float
    depth: str  # how it was kept
    full: SteadyTurn | None
    modified: SteadyTurn | None
    percent: dict[str, float]  # modified less full, of full
    problem: str


def steady_turn(file: VesselFile, equations: str, rudder: float) -> SteadyTurn:
    """Return the turn with ``rudder`` [rad] at the vessel's start speed, command speed constant.

    ConfigError if it does not trim, diverges or does not become steady.
    """
    boat = Boat(file, Method(equations, "lagged", "exact", "adams2", file.run.step_s))
    speed = file.run.start_speed_kn * KNOT
    boat.start(speed, file.run.start_depth_m, 0.0)
    s = boat.state
    s.speed_by_hand = s.rudder_by_hand = 1.0
    s.ordered_r = rudder
    settled = math.ceil(TURN_LENGTHS * file.hull.length / speed / boat.method.step)
    ticks = min(settled, MAX_TURN_TICKS)
    seen = np.empty((ticks, len(TURN_OFFSETS)))
    if status := boat.fly(TURN_OFFSETS, seen):
        raise ConfigError(f"{equations}: {boat.failure(status)}")
    last = seen[-math.ceil(ticks * AVERAGED_LENGTHS / TURN_LENGTHS) :]
    u, v, yaw, heel = (float(mean) for mean in last.mean(axis=0))
    if np.ptp(last[:, 2]) >= MAX_YAW_RATE_SPREAD * abs(yaw):
        raise ConfigError(f"{equations}: the turn is not steady after {boat.time:.0f} s")
    through = math.hypot(u, v)
    diameter = 2.0 * through / abs(yaw)
    return SteadyTurn(diameter, through / KNOT, math.degrees(yaw), math.degrees(heel))


def compare_turns(file: VesselFile) -> TurnComparison:
    """Return the starboard turn by the full and modified sets.

    The rudder is at 15 deg, or its limit.
    """
    rudder = min(TURN_RUDDER_DEG, file.surfaces.rudder_limit_deg)
    to_starboard = -1.0 if file.coefficients["N_dr"] <= 0.0 else 1.0
    turns: dict[str, SteadyTurn | None] = {"full": None, "modified": None}
    problem = ""
    for equations in turns:
        try:
            turns[equations] = steady_turn(file, equations, to_starboard * math.radians(rudder))
        except ConfigError as wrong:
            problem = problem or str(wrong)
    full, modified = turns["full"], turns["modified"]
    percent = {}
    if full and modified:
        by_compact = asdict(modified)
        percent = {
            name: 100.0 * (by_compact[name] - value) / value
            for name, value in asdict(full).items()
            if value != 0.0
        }
    depth = "by the autopilot" if file.autopilot else "not kept, planes as trimmed"
    speed = file.run.start_speed_kn
    return TurnComparison(rudder, speed, depth, full, modified, percent, problem)


def absent_coefficients(file: VesselFile, *, kept: bool) -> dict[str, list[str]]:
    """Return by equation the coefficients that the file does not give.

    ``kept`` chooses those that the compact set keeps, or those that it drops.
    """
    absent_keys: dict[str, list[str]] = {}
    for term in COEFFICIENTS:
        if term.key in file.absent and term.kept == kept:
            absent_keys.setdefault(term.equation, []).append(term.key)
    return absent_keys


def asymmetries(file: VesselFile) -> dict[str, float]:
    """Return by name what makes port and starboard differ: coefficients [-], [m] and [kg m2]."""
    hull = file.hull
    sided = {name: file.coefficients[name] for name in ASYMMETRIC_COEFFICIENTS}
    sided |= {"y_G": hull.cg[1], "y_B": hull.cb[1], "I_xy": hull.Ixy, "I_yz": hull.Iyz}
    return {name: value for name, value in sided.items() if value != 0.0}


@dataclass(frozen=True)
class Inertia:
    """The 6x6 mass matrix, scaled by its diagonal, and the lagged sweep's decay."""

    condition: float
    smallest: float  # smallest eigenvalue of the symmetric part
    definite: bool
    contraction: dict[str, float]  # spectral radius of the sweep by equation set


def inertia(file: VesselFile, step: float) -> Inertia:
    """Return condition [-], definiteness and contraction [-] of the boat at rest."""
    contraction = {}
    for equations in ("full", "modified"):
        boat = Boat(file, Method(equations, "lagged", "exact", "adams2", step))
        boat.state.u = boat.state.u_c = 1.0
        contraction[equations] = float(abs(np.linalg.eigvals(measure_response(boat).G)).max())
    matrix = np.zeros((6, 6))
    boat = Boat(file, Method("full", "exact", "exact", "adams2", step))
    full.inertia(boat.records.vessel, boat.records.state, matrix)
    scale = np.sqrt(abs(np.diag(matrix)))  # of masses and of mass times length squared
    scaled = matrix / np.outer(scale, scale)
    smallest = float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min())
    return Inertia(float(np.linalg.cond(scaled)), smallest, smallest > 0.0, contraction)


def _ratio(above: float, below: float) -> float | None:
    """Return above/below, None where there is nothing to divide by."""
    return above / below if below != 0.0 else None


def margins(file: VesselFile) -> dict[str, float | None]:
    """Return the margins of stability [-] in the vertical and horizontal plane, Gv and Gh.

    Gv = 1 - M_w (Z_q + m')/(Z_w M_q), Gh = 1 - N_v (Y_r - m')/(Y_v N_r), as printed for SUBOFF
    (Roddy 1990); None where a damping is zero.
    """
    c = file.coefficients
    mass = file.hull.mass / (0.5 * file.fluid.rho * file.hull.length**3)
    vertical = _ratio(c["M_w"] * (c["Z_q"] + mass), c["Z_w"] * c["M_q"])
    horizontal = _ratio(c["N_v"] * (c["Y_r"] - mass), c["Y_v"] * c["N_r"])
    ratios = {"Gv": vertical, "Gh": horizontal}
    return {name: None if ratio is None else 1.0 - ratio for name, ratio in ratios.items()}


def critical_speed(file: VesselFile, plane: str) -> float | None:
    """Return the speed [m/s] at which depth control by the "stern" or "bow" planes reverses.

    Linear, program EC470: u^2 = Z_d R/(Z_w M_d - Z_d M_w), R = 2 (z_B B - z_G W)/(rho L^3). None if
    there is no such speed or no such plane.
    """
    c, hull = file.coefficients, file.hull
    force, moment = c[f"Z_d{plane[0]}"], c[f"M_d{plane[0]}"]
    couple = 2.0 * (hull.cb[2] * hull.buoyancy - hull.cg[2] * hull.weight)
    stiffness = force * couple / (file.fluid.rho * hull.length**3)
    square = _ratio(stiffness, c["Z_w"] * moment - force * c["M_w"])
    return math.sqrt(square) if square is not None and square > 0.0 else None


def critical_speeds(file: VesselFile) -> dict[str, float | None]:
    """Return the critical speeds [kn] by plane, None where there is none."""
    speeds = {plane: critical_speed(file, plane) for plane in PLANE_NAMES}
    return {plane: None if speed is None else speed / KNOT for plane, speed in speeds.items()}


@dataclass(frozen=True)
class SurfaceCheck:
    """The lightest boat at the surface, and how many parts a step has there."""

    period_s: dict[str, float]  # by mode
    parts: dict[float, int]  # by step [s], of a multistep method


def afloat(file: VesselFile) -> SurfaceCheck:
    """Return the modes of the boat afloat, and how many parts each step has."""
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    modes = surface_modes(boat.records.vessel)
    steps = sorted({*STEPS_1969_S, file.run.step_s})
    return SurfaceCheck(
        {name: 2.0 * math.pi / float(rate[0]) for name, rate in modes.items() if rate[0] > 0.0},
        {step: substeps(boat.records.vessel, step, 1, boat.records.state) for step in steps},
    )


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
class StraightFlight:
    """Straight flight at one speed by the full set."""

    speed_kn: float
    trimmed: bool
    pitch_deg: float
    stern_planes_deg: float
    bow_planes_deg: float
    modes: tuple[ModeRow, ...]


@dataclass(frozen=True)
class StepVerdict:
    """One step of 2nd-order Adams with lagged accelerations, over all speeds."""

    equations: str
    step_s: float
    stable: bool
    growth: float  # [-] largest factor per tick that is not the boat's own
    worst: str  # the motion that is in, and the speed


@dataclass(frozen=True)
class BoundedKey:
    """A key that is cut at a bound, so that its force feeds no motion."""

    key: str
    given: float
    flown: float


@dataclass(frozen=True)
class CheckReport:
    """All that ``trainer boat check`` says about a vessel; as JSON by ``dataclasses.asdict``."""

    vessel: str
    path: str
    defaulted: tuple[str, ...]
    remarks: tuple[str, ...]
    bounded: tuple[BoundedKey, ...]
    notes: tuple[str, ...]  # of the vessel file
    absent_but_kept: dict[str, list[str]]  # absent, and the compact set would keep them
    absent_and_dropped: dict[str, list[str]]
    asymmetries: dict[str, float]
    inertia: Inertia
    margins: dict[str, float | None]
    critical_speed_kn: dict[str, float | None]
    flights: tuple[StraightFlight, ...]
    largest_flown_s: dict[str, dict[str, float | None]]  # by equation set, by method; None: any
    verdicts: tuple[StepVerdict, ...]
    turn: TurnComparison
    plant: PlantFacts | None
    afloat: SurfaceCheck
    clipped: bool  # what would feed the boat beyond the range is left out
    stable: bool  # at every step looked at
    own_step_s: float
    own_step_stable: bool  # by every equation set


def round_speeds(low: float, high: float) -> tuple[float, ...]:
    """Return ``low``, ``high`` [kn] and the round speeds between, about five."""
    unit = next(
        (u for u in CHECKED_SPEEDS_KN if (high - low) / u <= SPEED_INTERVALS), CHECKED_SPEEDS_KN[-1]
    )
    between = (unit * i for i in range(math.ceil(low / unit), math.ceil(high / unit)))
    return tuple(sorted({low, *(round(speed, 9) for speed in between if speed > low), high}))


def _row(mode: Mode) -> ModeRow:
    """Return one mode and the steps its decay allows."""
    schemes = {name: Method("full", "exact", "exact", name, 1.0) for name in STABILITY_METHODS}
    return ModeRow(
        name=mode.name,
        real=mode.real,
        imaginary=mode.imaginary,
        period_s=mode.period,
        damping_ratio=mode.damping_ratio,
        time_constant_s=mode.time_constant,
        stable=mode.stable,
        largest_s={
            name: largest_step(scheme_record(scheme), mode.eigenvalue)
            for name, scheme in schemes.items()
            if mode.stable
        },
    )


def straight_flights(file: VesselFile, speeds: Iterable[float]) -> tuple[StraightFlight, ...]:
    """Return trim and modes of the full set at ``speeds`` [kn]."""
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    rows = []
    for speed in speeds:
        trimmed = bring_to(boat, speed * KNOT)
        flight = measure_response(boat)
        rows.append(
            StraightFlight(
                speed_kn=speed,
                trimmed=trimmed,
                pitch_deg=math.degrees(boat.state.theta),
                stern_planes_deg=math.degrees(boat.state.delta_s),
                bow_planes_deg=math.degrees(boat.state.delta_b),
                modes=tuple(_row(mode) for mode in modes(flight.nature, flight.names)),
            )
        )
    return tuple(rows)


def check_vessel(file: VesselFile) -> CheckReport:
    """Return the report on ``file``; ``stable`` is False if any of the verdicts is."""
    speeds = round_speeds(*file.run.speed_range_kn)
    own_step = file.run.step_s
    boat = Boat(file, Method("full", "exact", "exact", "adams2", own_step))
    largest: dict[str, dict[str, float | None]] = {}
    verdicts = []
    for equations in EQUATION_SETS:
        lagged = Boat(file, Method(equations, "lagged", "exact", "adams2", own_step))
        flown = boat_responses(lagged, (speed * KNOT for speed in speeds))
        largest[equations] = {}
        for integrator in STABILITY_METHODS:
            scheme = scheme_record(Method(equations, "lagged", "exact", integrator, 1.0))
            step = largest_flown(flown.values(), scheme)
            largest[equations][integrator] = None if math.isinf(step) else step
        adams = scheme_record(Method(equations, "lagged", "exact", "adams2", 1.0))
        for step in sorted({*STEPS_1969_S, own_step}):
            stable = stable_at(flown.values(), adams, step)
            verdicts.append(StepVerdict(equations, step, stable, *worst_motion(flown, adams, step)))
    return CheckReport(
        vessel=file.name,
        path=str(file.path),
        defaulted=file.defaulted,
        remarks=(*file.remarks, *torque_remarks(file.coefficients, file.hull, file.fluid)),
        bounded=tuple(starmap(BoundedKey, bounded_keys(file, boat.records.vessel))),
        notes=file.notes,
        absent_but_kept=absent_coefficients(file, kept=True),
        absent_and_dropped=absent_coefficients(file, kept=False),
        asymmetries=asymmetries(file),
        inertia=inertia(file, own_step),
        margins=margins(file),
        critical_speed_kn=critical_speeds(file),
        plant=plant_facts(file.plant, file.propulsion.max_ordered_speed_kn) if file.plant else None,
        flights=straight_flights(file, speeds),
        largest_flown_s=largest,
        verdicts=tuple(verdicts),
        turn=compare_turns(file),
        afloat=afloat(file),
        clipped=is_clipped(file, boat.records.vessel),
        stable=all(verdict.stable for verdict in verdicts),
        own_step_s=own_step,
        own_step_stable=all(one.stable for one in verdicts if one.step_s == own_step),
    )
