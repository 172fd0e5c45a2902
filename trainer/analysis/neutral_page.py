"""The neutral angles as a page for a terminal, and as a plot."""

import math
from typing import Final

import numpy as np

from trainer.analysis.characteristic import surface_lines
from trainer.analysis.neutral import (
    PLANES,
    Neutral,
    Side,
    level_flight,
    plane_angle,
    required_couple,
    sides,
    solutions,
    turning_points,
)
from trainer.analysis.report.plots import Curve, Panel
from trainer.analysis.report.text import figure, table, wrap
from trainer.boat.depths import near_surface
from trainer.config.vessel import VesselFile
from trainer.core.kernel import Numbers
from trainer.units import KNOT

DRAWN: Final = 20.0  # [deg] of pitch, either way
POINTS: Final = 200  # of each side of a curve, in pitch and in speed

Drawn = tuple[Numbers, Numbers, Numbers]

HEADS: Final = ("speed\n[kn]", "planes", "w\n[m/s]", "pitch\n[deg]", "angle\n[deg]", "")


def _speeds(speeds: tuple[float, ...]) -> str:
    """Return speeds [kn] as a phrase."""
    return ", ".join(f"{speed:.2f} kn" for speed in speeds) or "none"


def _critical(report: Neutral) -> list[str]:
    """Return the speeds at which the planes reverse."""
    lines = ["", "CRITICAL SPEEDS (a plane below its own reverses its effect on depth)"]
    for plane in PLANES:
        speed = report.critical_speed_kn[plane]
        folds = _speeds(report.fold_speeds_kn[plane])
        linear = "none" if speed is None else f"{speed:.2f} kn"
        lines.append(f"  {plane:<6} linear {linear:<10} solutions meet at {folds}")
    return lines


def _angles(report: Neutral) -> list[str]:
    """Return the table of all solutions."""
    rows = []
    for flight in report.flights:
        head = (f"{flight.speed_kn:.4g}", flight.plane)
        if not flight.solutions:
            rows.append((*head, "-", "-", "-", "no level flight"))
        for i, one in enumerate(flight.solutions):
            note = "" if one.within_limit else "beyond the limit"
            first = head if i == 0 else ("", "")
            w, pitch, plane = (f"{x:+.3f}" for x in (one.w_m_s, one.pitch_deg, one.plane_deg))
            rows.append((*first, w, pitch, plane, note))
    return [
        "",
        "NEUTRAL ANGLES (EC470: one pair of planes, the other at zero)",
        *table(HEADS, rows),
    ]


def _trims(report: Neutral) -> list[str]:
    """Return the table of the boat's own trims by the stern planes."""
    heads = ("speed\n[kn]", "w\n[m/s]", "pitch\n[deg]", "stern\n[deg]", "u_c\n[kn]")
    speeds = dict.fromkeys(flight.speed_kn for flight in report.flights)
    rows: list[tuple[str, ...]] = []
    for speed, trim in zip(speeds, report.trims, strict=True):
        if trim is None:
            rows.append((f"{speed:.4g}", "-", "-", "none", "-"))
            continue
        numbers = (trim.w_m_s, trim.pitch_deg, trim.stern_planes_deg)
        cells = (figure(number, "+.3f") for number in numbers)
        rows.append((f"{speed:.4g}", *cells, f"{trim.u_c_m_s / KNOT:.3f}"))
    return ["", "TRIM OF THE FULL SET (stern planes, bow planes at zero)", *table(heads, rows)]


def render(report: Neutral) -> str:
    """Return the report as text."""
    notes = [line for text in report.remarks for line in wrap("remark: " + text)]
    surface = surface_lines(report.depth_m, report.surface)
    heading = [report.vessel, *notes]
    parts = [heading, surface, _critical(report), _angles(report), _trims(report)]
    return "\n".join(line for part in parts for line in part)


def _steps(side: Side, most: float) -> list[float]:
    """Return the |w|/u at which a curve is drawn: even by themselves, and even in speed [kn]."""
    steepest = math.tan(math.radians(DRAWN))
    steps = {*np.geomspace(1e-5, steepest, POINTS).tolist(), *turning_points(side)}
    for knots in np.linspace(0.0, most, POINTS)[1:]:
        steps |= {t for t in solutions(side, (knots * KNOT) ** 2) if t < steepest}
    return sorted(steps)


def _curve(file: VesselFile, plane: str, most: float) -> Drawn:
    """Return speed [kn], pitch [deg] and plane angle [deg] along all solutions up to ``most`` [kn].

    The curve is followed by its pitch, so that it turns back where two solutions meet.
    """
    points: list[tuple[float, float, float]] = []
    for side, sense in zip(sides(file, plane), (1.0, -1.0), strict=True):
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
    knots, pitch, degrees = np.array(points).T
    return knots, pitch, degrees


def _points(file: VesselFile, plane: str, most: float, depth: float) -> Drawn:
    """Return speed [kn], pitch [deg] and plane angle [deg] of all solutions at a ``depth`` [m].

    The surface's share changes with speed, so that no curve is followed: it is dots over speed.
    """
    found = []
    for knots in np.linspace(0.0, most, POINTS)[1:]:
        speed = float(knots) * KNOT
        for t, angle in level_flight(near_surface(file, speed, depth), plane, speed):
            pitch = math.degrees(math.atan(t))
            if abs(pitch) <= DRAWN:
                found.append((float(knots), pitch, math.degrees(angle)))
    table = np.array(found, float).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def panels(file: VesselFile, report: Neutral) -> tuple[Panel, ...]:
    """Return pitch and plane angle over speed, every solution, critical speeds marked."""
    most = max(flight.speed_kn for flight in report.flights)
    dots = report.depth_m is not None
    pitches, planes, marks = [], [], []
    for plane in PLANES:
        if not any(flight.solutions for flight in report.flights if flight.plane == plane):
            continue
        knots, pitch, degrees = (
            _curve(file, plane, most)
            if report.depth_m is None
            else _points(file, plane, most, report.depth_m)
        )
        limit = getattr(file.surfaces, f"{plane}_plane_limit_deg")
        pitches.append(Curve(f"{plane} planes", knots, pitch, points=dots))
        shown = np.where(abs(degrees) <= limit, degrees, np.nan)
        planes.append(Curve(f"{plane} planes", knots, shown, points=dots))
        critical = report.critical_speed_kn[plane]
        if critical is not None and critical <= most:
            marks.append((f"critical, {plane}", critical))
    x = "speed [kn]"
    where = "" if report.depth_m is None else f", {report.depth_m:g} m down"
    return (
        Panel(
            f"{report.vessel}: level flight{where}", x, "pitch [deg]", tuple(pitches), tuple(marks)
        ),
        Panel("planes, within their limits", x, "plane angle [deg]", tuple(planes), tuple(marks)),
    )
