"""Planes for straight level flight, and the speed at which they reverse: program EC470.

``cli/workshop/programs`` and the guide show them; a manoeuvre may begin in the full set's
``trim_at``. [ASSES] is the report of 1969 on the programs. [ASSES] EC470 with errata F1-F4: pitch
equals the angle of attack, q = 0, weight equals buoyancy, x_G = 0, one pair of planes deflected and
the other at zero. With t = w/u, h = t/sqrt(1 + t^2) and R2 = 2 (z_B B - z_G W)/(rho L^3), normal
force and pitching moment vanish where

    Z_waw t|t| + Z_ww t^2 + Z_w t + Z_aw |t| + Z_star + Z_d d = 0
    M_waw t|t| + M_ww t^2 + M_w t + M_aw |t| + M_star + M_d d + R2 h/u^2 = 0

M_d times the first less Z_d times the second has no d: q(t) = k h/u^2, with k = Z_d R2 and q a
parabola on either side of t = 0. Near a calm surface (Tables 12 and 13) Z_star, M_star, Z_w and M_w
are those of the depth and speed. All its roots are found: between neighbouring stationary points of
q/h, which are roots of a quartic, there is at most one.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Final, NamedTuple

import numpy as np

from trainer.analysis.check import PLANE_NAMES, critical_speeds
from trainer.analysis.programs.characteristic import surface_lines
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.depths import (
    SurfaceForces,
    feeling_surface,
    near_surface,
    require_covered,
    surface_at,
    surface_remarks,
)
from trainer.config.boat.vessel import VesselFile
from trainer.core.scheme import equations_alone
from trainer.core.trim import STERN_PLANES, trim
from trainer.report.plots import Curve, Panel
from trainer.report.text import titled_table, wrap
from trainer.units import KNOT

MAX_FLOW_SLOPE: Final = math.tan(math.radians(85.0))  # [-] |w|/u; the equations end before
REAL_ROOT_TOLERANCE: Final = 1e-9  # [-] of a root: an imaginary part below it is rounding
MAX_HALVINGS: Final = 200  # more than a double has bits, whatever the first interval
MAX_FOLD_ROUNDS: Final = 50  # of a speed at which solutions meet, near the surface
SAME_SPEED_RATIO: Final = 1e-9  # [-] difference of two speeds
DRAWN_PITCH_DEG: Final = 20.0  # [deg] of pitch, either way
CURVE_POINTS: Final = 200  # of each side of a curve, in pitch and in speed
ANGLE_TITLE: Final = "NEUTRAL ANGLES (EC470: one pair of planes, the other at zero)"
ANGLE_HEADS: Final = ("speed\n[kn]", "planes", "w\n[m/s]", "pitch\n[deg]", "angle\n[deg]", "")
TRIM_TITLE: Final = "TRIM OF THE FULL SET (stern planes, bow planes at zero)"
TRIM_HEADS: Final = ("speed\n[kn]", "w\n[m/s]", "pitch\n[deg]", "stern\n[deg]", "u_c\n[kn]")


class SideEquation(NamedTuple):
    """The equation square t^2 + slope t + constant = couple/u^2 h(t).

    It holds on one side of t = 0, with t = |w|/u.
    """

    square: float  # [-]
    slope: float  # [-]
    constant: float  # [-]
    couple: float  # [speed squared]


@dataclass(frozen=True)
class LevelSolution:
    """One solution: level flight by one pair of planes."""

    w_m_s: float
    pitch_deg: float  # equal to the angle of attack
    plane_deg: float
    within_limit: bool  # of the planes


@dataclass(frozen=True)
class LevelFlights:
    """All solutions by one pair of planes at one speed, the smallest |w| first."""

    plane: str
    speed_kn: float
    solutions: tuple[LevelSolution, ...]


@dataclass(frozen=True)
class Trim:
    """Level flight by the stern planes in the boat's own equations, bow planes at zero."""

    speed_kn: float
    w_m_s: float
    pitch_deg: float
    stern_planes_deg: float
    u_c_m_s: float  # command speed that keeps the speed


@dataclass(frozen=True)
class NeutralReport:
    """All that ``trainer report-1969 neutral`` says about a vessel."""

    vessel: str
    critical_speed_kn: dict[str, float | None]  # by plane, linear; None: none
    fold_speeds_kn: dict[str, tuple[float, ...]]  # where the number of solutions changes
    flights: tuple[LevelFlights, ...]
    trims: tuple[Trim | None, ...]  # by speed; None: Newton's method finds none
    remarks: tuple[str, ...]
    depth_m: float | None  # None: deep water
    surface: tuple[SurfaceForces, ...]  # by speed; none in deep water


def side_equations(file: VesselFile, plane: str) -> tuple[SideEquation, SideEquation]:
    """Return the equation for w > 0 and w < 0 by one pair. It is the "stern" or the "bow" pair."""
    c, hull = file.coefficients, file.hull
    force, moment = c[f"Z_d{plane[0]}"], c[f"M_d{plane[0]}"]

    def part(name: str) -> float:
        return moment * c[f"Z_{name}"] - force * c[f"M_{name}"]

    couple = 2.0 * (hull.cb[2] * hull.buoyancy - hull.cg[2] * hull.weight)
    couple *= force / (file.fluid.rho * hull.length**3)
    down = SideEquation(part("ww") + part("waw"), part("w") + part("aw"), part("star"), couple)
    up = SideEquation(part("ww") - part("waw"), part("aw") - part("w"), part("star"), -couple)
    return down, up


def required_couple(side: SideEquation, t: float) -> float:
    """Return couple/u^2 [-] at which ``t`` > 0 is a solution."""
    parabola = (side.square * t + side.slope) * t + side.constant
    return parabola * math.hypot(1.0, t) / t


def turning_points(side: SideEquation) -> list[float]:
    """Return the t > 0 at which ``required_couple`` is stationary, in order.

    Roots of 2 square t^4 + slope t^3 + square t^2 - constant.
    """
    roots = np.roots([2.0 * side.square, side.slope, side.square, 0.0, -side.constant])
    real = [float(t.real) for t in roots if abs(t.imag) <= REAL_ROOT_TOLERANCE * abs(t)]
    return sorted({t for t in real if 0.0 < t < MAX_FLOW_SLOPE})


def solutions(side: SideEquation, square_of_speed: float) -> list[float]:
    """Return every t = |w|/u > 0 to MAX_FLOW_SLOPE that solves ``side`` at u^2."""
    wanted = side.couple / square_of_speed
    at_zero = math.copysign(math.inf, side.constant) if side.constant else side.slope - wanted

    def excess(t: float) -> float:
        return required_couple(side, t) - wanted if t > 0.0 else at_zero

    return [
        _between(side, wanted, low, high)
        for low, high in pairwise([0.0, *turning_points(side), MAX_FLOW_SLOPE])
        if (excess(low) > 0.0) != (excess(high) > 0.0)
    ]


def _between(side: SideEquation, wanted: float, low: float, high: float) -> float:
    """Return the one root between ``low`` and ``high``, by halving down to the last bit."""
    rising = required_couple(side, high) > wanted
    for _ in range(MAX_HALVINGS):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        if (required_couple(side, middle) > wanted) == rising:
            high = middle
        else:
            low = middle
    return high


def level_flight(file: VesselFile, plane: str, speed: float) -> list[tuple[float, float]]:
    """Return all (w/u [-], plane angle [rad]) at ``speed`` > 0, the smallest |w| first.

    Empty if the boat has no such planes. Any consistent units.
    """
    if not file.coefficients[f"Z_d{plane[0]}"] and not file.coefficients[f"M_d{plane[0]}"]:
        return []
    down, up = side_equations(file, plane)
    slopes = [*solutions(down, speed**2), *(-t for t in solutions(up, speed**2))]
    if down.constant == 0.0:
        slopes.append(0.0)
    return [(t, plane_angle(file, plane, t, speed)) for t in sorted(slopes, key=abs)]


def plane_angle(file: VesselFile, plane: str, t: float, speed: float) -> float:
    """Return the plane angle [rad] that balances the solution ``t`` = w/u."""
    c, hull = file.coefficients, file.hull
    couple = 2.0 * (hull.cb[2] * hull.buoyancy - hull.cg[2] * hull.weight)
    couple /= file.fluid.rho * hull.length**3

    def part(axis: str) -> float:
        even = c[f"{axis}_ww"] * t * t + c[f"{axis}_aw"] * abs(t) + c[f"{axis}_star"]
        return even + c[f"{axis}_waw"] * t * abs(t) + c[f"{axis}_w"] * t

    force, moment = c[f"Z_d{plane[0]}"], c[f"M_d{plane[0]}"]
    pitching = part("M") + couple * t / math.hypot(1.0, t) / speed**2
    # both vanish: the larger lever decides, where one of them is zero the other
    return -(force * part("Z") + moment * pitching) / (force**2 + moment**2)


def fold_speeds(file: VesselFile, plane: str) -> list[float]:
    """Return the speeds at which two solutions meet and vanish, in order. Any consistent units."""
    points = [(side, t) for side in side_equations(file, plane) for t in turning_points(side)]
    ratios = [(side.couple, required_couple(side, t)) for side, t in points]
    squares = [couple / required for couple, required in ratios if required]
    return sorted(math.sqrt(square) for square in squares if square > 0.0)


def fold_speeds_at(file: VesselFile, plane: str, depth: float | None) -> list[float]:
    """Return the speeds [m/s] at which two solutions meet at ``depth`` [m]; None: deep water.

    The surface's force depends on the speed that is sought, so that the search repeats. A speed
    that does not settle is left out.
    """
    if depth is None:
        return fold_speeds(file, plane)
    speeds: list[float] = []
    for start in fold_speeds(near_surface(file, file.run.start_speed_kn * KNOT, depth), plane):
        speed = start
        for _ in range(MAX_FOLD_ROUNDS):
            folds = np.array(fold_speeds(near_surface(file, speed, depth), plane))
            if not folds.size:
                break
            last, speed = speed, float(folds[np.argmin(abs(folds - speed))])
            if math.isclose(last, speed, rel_tol=SAME_SPEED_RATIO):
                if not any(math.isclose(speed, one) for one in speeds):
                    speeds.append(speed)
                break
    return sorted(speeds)


def trim_at(boat: Boat, speed: float, depth: float | None = None) -> Trim | None:
    """Return trim of the boat's own equations at ``speed`` [m/s]; None if none is found.

    The search begins at the solution of EC470 with the smallest |w|; planes have no limit here.
    At a ``depth`` [m] the force and moment of the calm surface act besides; None is deep water.
    """
    r, s = boat.records, boat.state
    for name in ("v", "phi", "delta_r", "delta_b"):
        s[name] = 0.0
    start = level_flight(near_surface(boat.file, speed, depth), "stern", speed)
    t, angle = start[0] if start else (0.0, 0.0)
    s.u = s.u_c = speed
    s.w, s.theta, s.delta_s = t * speed, math.atan(t), angle
    r.scratch["external"][0, :] = 0.0
    if depth is not None:
        s.z = depth
    alone = equations_alone(r.scheme)
    with (
        feeling_surface(boat, speed, depth),
        np.errstate(all="ignore"),  # a boat without stern planes has a singular system
    ):
        settled = trim(r.vessel, r.compact, alone, r.state, r.scratch, STERN_PLANES)
    if not settled:
        return None
    pitch, planes = math.degrees(s.theta), math.degrees(s.delta_s)
    return Trim(speed / KNOT, float(s.w), pitch, planes, float(s.u_c))


def level_flights(file: VesselFile, plane: str, speed: float) -> LevelFlights:
    """Return all level flights at ``speed`` [m/s] in the units of a page."""
    limit = getattr(file.surfaces, f"{plane}_plane_limit_deg")
    rows = [
        (t * speed, math.degrees(math.atan(t)), math.degrees(angle))
        for t, angle in level_flight(file, plane, speed)
    ]
    solutions = tuple(LevelSolution(*numbers, abs(numbers[-1]) <= limit) for numbers in rows)
    return LevelFlights(plane, speed / KNOT, solutions)


def remarks(file: VesselFile) -> tuple[str, ...]:
    """Return the assumptions of EC470 that do not hold for the boat."""
    hull = file.hull
    notes = []
    if hull.weight != hull.buoyancy:
        heavy = 100.0 * (hull.weight - hull.buoyancy) / hull.buoyancy
        notes.append(f"EC470 takes the weight as equal to the buoyancy; it is {heavy:+.2g} % of it")
    if hull.cg[0] != 0.0 or hull.cb[0] != 0.0:
        notes.append("EC470 takes x_G and x_B as zero; the trim of the boat itself does not")
    return tuple(notes)


def report_neutral(
    file: VesselFile, speeds: Iterable[float], depth: float | None = None
) -> NeutralReport:
    """Return the neutral angles at ``speeds`` [kn], critical speeds and trims.

    At a ``depth`` [m] they are those under a calm surface. ConfigError if the vessel file has no
    tables of it.
    """
    require_covered(file, depth)
    speeds = [knots * KNOT for knots in speeds]
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    return NeutralReport(
        vessel=file.name,
        critical_speed_kn=critical_speeds(file),
        fold_speeds_kn={
            plane: tuple(speed / KNOT for speed in fold_speeds_at(file, plane, depth))
            for plane in PLANE_NAMES
        },
        flights=tuple(
            level_flights(near_surface(file, speed, depth), plane, speed)
            for speed in speeds
            for plane in PLANE_NAMES
        ),
        trims=tuple(trim_at(boat, speed, depth) for speed in speeds),
        remarks=(*remarks(file), *surface_remarks(file, depth)),
        depth_m=depth,
        surface=() if depth is None else tuple(surface_at(file, at, depth) for at in speeds),
    )


def _angle_rows(flight: LevelFlights) -> Iterator[tuple[str, ...]]:
    """Yield the solutions of one flight as lines of the table."""
    head = (f"{flight.speed_kn:.4g}", flight.plane)
    if not flight.solutions:
        yield (*head, "-", "-", "-", "no level flight")
    for one in flight.solutions:
        note = "" if one.within_limit else "beyond the limit"
        yield (*head, *(f"{x:+.3f}" for x in (one.w_m_s, one.pitch_deg, one.plane_deg)), note)
        head = ("", "")


def _trim_row(speed: float, found: Trim | None) -> tuple[str, ...]:
    """Return a trim by the stern planes as a line of the table."""
    if found is None:
        return (f"{speed:.4g}", "-", "-", "none", "-")
    numbers = (found.w_m_s, found.pitch_deg, found.stern_planes_deg)
    cells = (f"{number:+.3f}" for number in numbers)
    return (f"{speed:.4g}", *cells, f"{found.u_c_m_s / KNOT:.3f}")


def render(report: NeutralReport) -> str:
    """Return the report as text."""
    critical = []
    for plane, speed in report.critical_speed_kn.items():
        folds = ", ".join(f"{fold:.2f} kn" for fold in report.fold_speeds_kn[plane]) or "none"
        linear = "none" if speed is None else f"{speed:.2f} kn"
        critical.append(f"  {plane:<6} linear {linear:<10} solutions meet at {folds}")
    speeds = dict.fromkeys(flight.speed_kn for flight in report.flights)
    lines = [
        report.vessel,
        *(line for text in report.remarks for line in wrap("remark: " + text)),
        *surface_lines(report.depth_m, report.surface),
        "",
        "CRITICAL SPEEDS (a plane below its own reverses its effect on depth)",
        *critical,
        *titled_table(ANGLE_TITLE, ANGLE_HEADS, chain(*map(_angle_rows, report.flights))),
        *titled_table(TRIM_TITLE, TRIM_HEADS, map(_trim_row, speeds, report.trims)),
    ]
    return "\n".join(lines)


def _steps(side: SideEquation, most: float) -> list[float]:
    """Return the |w|/u of a curve's points: evenly spaced ones, and ones even in speed [kn]."""
    steepest = math.tan(math.radians(DRAWN_PITCH_DEG))
    steps = {*np.geomspace(1e-5, steepest, CURVE_POINTS).tolist(), *turning_points(side)}
    for knots in np.linspace(0.0, most, CURVE_POINTS)[1:]:
        steps |= {t for t in solutions(side, (knots * KNOT) ** 2) if t < steepest}
    return sorted(steps)


def _curve(file: VesselFile, plane: str, most: float) -> list[tuple[float, float, float]]:
    """Return speed [kn], pitch [deg] and plane angle [deg] along all solutions up to ``most`` [kn].

    The curve is followed by its pitch, so that it turns back where two solutions meet.
    """
    points: list[tuple[float, float, float]] = []
    for side, sense in zip(side_equations(file, plane), (1.0, -1.0), strict=True):
        for t in _steps(side, most):
            ratio = required_couple(side, t)
            square = side.couple / ratio if ratio else math.inf
            speed = math.sqrt(square) if square > 0.0 else math.nan
            if not speed <= most * KNOT:
                points.append((math.nan, math.nan, math.nan))
                continue
            angle = plane_angle(file, plane, sense * t, speed)
            points.append((speed / KNOT, math.degrees(math.atan(sense * t)), math.degrees(angle)))
        points.append((math.nan, math.nan, math.nan))
    return points


def _points(
    file: VesselFile, plane: str, most: float, depth: float
) -> list[tuple[float, float, float]]:
    """Return speed [kn], pitch [deg] and plane angle [deg] of all solutions at a ``depth`` [m].

    The surface's force changes with speed, so that the curve cannot be followed by its pitch: the
    panel has dots over speed.
    """
    points = [
        (knots, math.degrees(math.atan(t)), math.degrees(angle))
        for knots in map(float, np.linspace(0.0, most, CURVE_POINTS)[1:])
        for t, angle in level_flight(near_surface(file, knots * KNOT, depth), plane, knots * KNOT)
    ]
    return [point for point in points if abs(point[1]) <= DRAWN_PITCH_DEG]


def panels(file: VesselFile, report: NeutralReport) -> tuple[Panel, ...]:
    """Return pitch and plane angle over speed, every solution, critical speeds marked."""
    most = max(flight.speed_kn for flight in report.flights)
    dots = report.depth_m is not None
    pitches, planes, marks = [], [], []
    solved = {flight.plane for flight in report.flights if flight.solutions}
    for plane in filter(solved.__contains__, PLANE_NAMES):
        points = (
            _curve(file, plane, most)
            if report.depth_m is None
            else _points(file, plane, most, report.depth_m)
        )
        knots, pitch, degrees = np.array(points, float).reshape(-1, 3).T
        limit = getattr(file.surfaces, f"{plane}_plane_limit_deg")
        pitches.append(Curve(f"{plane} planes", knots, pitch, points=dots))
        shown = np.where(abs(degrees) <= limit, degrees, np.nan)
        planes.append(Curve(f"{plane} planes", knots, shown, points=dots))
        critical = report.critical_speed_kn[plane]
        if critical is not None and critical <= most:
            marks.append((f"critical, {plane}", critical))
    x, down = "speed [kn]", "" if report.depth_m is None else f", {report.depth_m:g} m down"
    title, within = f"{report.vessel}: level flight{down}", "planes, within their limits"
    return (
        Panel(title, x, "pitch [deg]", tuple(pitches), tuple(marks)),
        Panel(within, x, "plane angle [deg]", tuple(planes), tuple(marks)),
    )
