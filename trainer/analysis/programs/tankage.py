"""Overshoots by tankage, Table 5 and Figure 4 of [ASSES], the report of 1969.

``trainer report-1969 tanks --overshoots`` shows how well x_G and z_G must be known. The same
overshoot is flown slow and fast with x_G or z_G alone at the end of what the pumped tanks can do, W
= B. [ASSES] does not say where it begins: here all begin in the neutral flight of the boat in
balance, because only then are the figures as large as its own at 5 knots.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from trainer.analysis.check import critical_speeds
from trainer.analysis.manoeuvres.catalogue import within_limits
from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.vertical import Overshoot
from trainer.analysis.programs.compare import COMPARISON_END_S, compare_runs
from trainer.analysis.programs.tanks import report_fillings
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.vessel import VesselFile
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel
from trainer.report.text import format_number, titled_table, wrap
from trainer.units import KNOT

CHANGED_VARIABLES: Final = ("u", "theta", "z")
IN_BALANCE: Final = "in balance"
SPEED_RATIO: Final = 1.25  # [-] slow over the speed at which stern planes reverse: an estimate
BALLAST_SHARE: Final = 0.02  # [-] of BG, without tanks: what ballast moves, either way; an estimate
PERCENT_1969: Final = {  # [%] by tankage, slow (5 kn) and fast (25 kn), of CHANGED_VARIABLES
    "largest z_G": ((-1.3, -6.6, -23.4), (-2.9, 0.2, 7.7)),
    "as filled": ((-372.6, -681.2, -1307.7), (-11.6, -16.4, -41.4)),
    "largest x_G": ((-692.1, -856.8, -1545.0), (-16.0, -20.7, -53.5)),
}


@dataclass(frozen=True)
class TankageChange:
    """What one tankage does to the overshoot at one speed."""

    speed_kn: float
    tankage: str
    x_g_m: float
    z_g_m: float
    percent: dict[str, float | None]  # change of change by variable; None: too little change
    percent_1969: dict[str, float]
    lost: str  # why the flight ended early; "" if it did not


@dataclass(frozen=True)
class TankageReport:
    """All that ``trainer report-1969 tanks --overshoots`` says about a vessel."""

    vessel: str
    moved_by: str  # in words: tanks, or ballast
    changes: tuple[TankageChange, ...]


Centre = tuple[float, float, float]  # of gravity [m]
Flights = Mapping[float, Mapping[str, Flight]]  # by speed [kn] and tankage


def centres_of(file: VesselFile, fills: Mapping[str, float]) -> tuple[str, dict[str, Centre]]:
    """Return in words what moves the boat's centre, and the centres [m] by tankage."""
    (x_b, _, z_b), (x, y, z) = file.hull.cb, file.hull.cg
    if file.ballast is None and not fills:
        moved, share = f"ballast, {BALLAST_SHARE:.0%} of BG", BALLAST_SHARE * (z - z_b)
        ends, filled = (x_b + share, z + share), (x, y, z)
    else:
        tanks = report_fillings(file, fills)
        most = tanks.ranges[0].limits
        moved, filled = tanks.ranges[0].free, tanks.now.centre
        ends = max(most.x_g, key=lambda end: abs(end - x_b)), most.z_g.most
    return moved, {
        IN_BALANCE: (x_b, y, z),
        "largest z_G": (x_b, y, ends[1]),
        "as filled": filled,
        "largest x_G": (ends[0], y, z),
    }


def survey_tankage(file: VesselFile, fills: Mapping[str, float]) -> tuple[TankageReport, Flights]:
    """Return what tankage does to an overshoot, slow and fast, and the flights.

    ``fills`` [-] say how full tanks are, else as the vessel file has them. ConfigError if the boat
    has no tank of that name, or no stern planes.
    """
    low, high = file.run.speed_range_kn
    slow = max(low, float(round(SPEED_RATIO * (critical_speeds(file)["stern"] or 0.0))))
    moved_by, centres = centres_of(file, fills)
    flights: dict[float, dict[str, Flight]] = {}
    changes = []
    for column, speed in enumerate((slow, high)):
        flown = {name: _fly(file, centres[IN_BALANCE], at, speed) for name, at in centres.items()}
        flights[speed] = flown
        for name, then in PERCENT_1969.items():
            x, _, z = centres[name]
            percent = percent_of(flown[IN_BALANCE], flown[name])
            told = dict(zip(CHANGED_VARIABLES, then[column], strict=True))
            changes.append(TankageChange(speed, name, x, z, percent, told, flown[name].lost))
    return TankageReport(file.name, moved_by, tuple(changes)), flights


def _fly(file: VesselFile, balanced: Centre, centre: Centre, speed: float) -> Flight:
    """Return the overshoot with a centre of gravity [m], begun as the boat in balance does."""
    method = Method("full", "exact", "exact", "rk4", file.run.step_s)
    hulls = [replace(file.hull, weight=file.hull.buoyancy, cg=at) for at in (balanced, centre)]
    model, boat = (replace(file, hull=hull) for hull in hulls)
    vehicle = Submarine(boat, method)
    vehicle.boat.model = Boat(model, method)
    manoeuvre = within_limits(Overshoot(duration_s=COMPARISON_END_S), vehicle)
    return fly_manoeuvre(vehicle, manoeuvre, speed * KNOT)


def percent_of(balanced: Flight, moved: Flight) -> dict[str, float | None]:
    """Return the change of change [%] by variable, None of a lost flight."""
    percent: dict[str, float | None] = dict.fromkeys(CHANGED_VARIABLES)
    if balanced.lost or moved.lost:
        return percent
    points = compare_runs(balanced.series, moved.series, CHANGED_VARIABLES).points
    return percent | {point.variable: point.percent for point in reversed(points)}


def render(report: TankageReport) -> str:
    """Return the report as text."""
    then = (f"{name}\n1969" for name in CHANGED_VARIABLES)
    heads = ("speed\n[kn]", "", "x_G\n[m]", "z_G\n[m]", *CHANGED_VARIABLES, *then)
    rows = [
        (
            f"{one.speed_kn:g}",
            one.tankage,
            f"{one.x_g_m:+z.4f}",
            f"{one.z_g_m:+z.4f}",
            *(format_number(one.percent[name], "+z.1f") for name in CHANGED_VARIABLES),
            *(f"{one.percent_1969[name]:+.1f}" for name in CHANGED_VARIABLES),
        )
        for one in report.changes
    ]
    title = "OVERSHOOT BY TANKAGE (Table 5: change of change [%], beside that of 1969)"
    lines = [report.vessel, *titled_table(title, heads, rows)]
    lines += wrap(f"x_G and z_G are moved alone, by {report.moved_by}; the weight is the buoyancy")
    lines += wrap("beside them 1969: its own boat at 5 and 25 kn")
    for one in report.changes:
        if one.lost:
            lines += wrap(f"lost: {one.speed_kn:g} kn, {one.tankage}: {one.lost}")
    return "\n".join(lines)


def panels(report: TankageReport, flights: Flights) -> tuple[Panel, ...]:
    """Return Figure 4: u, theta and z over time, a curve for each tankage."""
    drawn = []
    for speed, flown in flights.items():
        for name in CHANGED_VARIABLES:
            factor, unit = page_unit(name)
            curves = tuple(
                Curve(tankage, flight.t, factor * flight.change(name))
                for tankage, flight in flown.items()
            )
            title = f"{report.vessel}: {name} at {speed:g} kn"
            label, lower = f"change of {name} [{unit}]", name in DEPTH_COLUMNS
            drawn.append(Panel(title, "time [s]", label, curves, downwards=lower))
    return tuple(drawn)
