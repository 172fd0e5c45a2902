"""Weight and balance over all fillings of the tanks, and overshoots by tankage.

Program EC430 of [ASSES], the report of 1969 on the programs, erratum F6. It has the balance of a
boat's own tanks as they are filled, and the limits of all fillings. A flooded compartment is one
more tank. Free surfaces in a tank are not counted.

``trainer report-1969 tanks --overshoots`` has Table 5 and Figure 4: how well x_G and z_G must be
known. The same overshoot is flown slow and fast with x_G or z_G alone at the end of what the pumped
tanks can do, W = B. [ASSES] does not say where it begins: here all begin in the neutral flight of
the boat in balance, because only then are the figures as large as its own at 5 knots.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.check import critical_speeds
from trainer.analysis.manoeuvres.catalogue import within_limits
from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.vertical import Overshoot
from trainer.analysis.programs.compare import COMPARISON_END_S, compare_runs
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, nearest, quote, raise_problems
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, format_number, titled_table, wrap
from trainer.units import KNOT

WEIGHT_AXES = (1, 2, 3)  # places of x, y, z in Weight
TANK_TABLES: Final = ("pumped", "blown", "compartments")  # tables of [ballast]
# What is free to be filled; the rest stays as it is.
FREE_TANK_GROUPS: Final = {
    "pumped tanks": ("pumped",),
    "all tanks": ("pumped", "blown"),
    "tanks and flooding": ("pumped", "blown", "compartments"),
}
CHANGED_VARIABLES: Final = ("u", "theta", "z")
IN_BALANCE: Final = "in balance"
SPEED_RATIO: Final = 1.25  # [-] slow over the speed at which stern planes reverse: an estimate
BALLAST_SHARE: Final = 0.02  # [-] of BG, without tanks: what ballast moves, either way; an estimate
PERCENT_1969: Final = {  # [%] by tankage, slow (5 kn) and fast (25 kn), of CHANGED_VARIABLES
    "largest z_G": ((-1.3, -6.6, -23.4), (-2.9, 0.2, 7.7)),
    "as filled": ((-372.6, -681.2, -1307.7), (-11.6, -16.4, -41.4)),
    "largest x_G": ((-692.1, -856.8, -1545.0), (-16.0, -20.7, -53.5)),
}


class Weight(NamedTuple):
    """One weight and its place: the boat without tanks, or a tank's contents."""

    weight: float  # [N]
    x: float  # [m]
    y: float  # [m]
    z: float  # [m]


class Balance(NamedTuple):
    """Weight, moments about the origin, and centre of gravity."""

    weight: float  # [N]
    moments: tuple[float, float, float]  # [N m] weight times x, y, z
    centre: tuple[float, float, float]  # [m]


class FillingRange(NamedTuple):
    """Least and greatest value over all fillings."""

    least: float
    most: float


class TankLimits(NamedTuple):
    """The range of the tanks: weight [N] and centre of gravity [m], each alone."""

    weight: FillingRange
    x_g: FillingRange
    y_g: FillingRange
    z_g: FillingRange


def balance(hull: Weight, tanks: Sequence[Weight]) -> Balance:
    """Return weight [N], moments [N m] and centre [m].

    The centre is x_G = (W0 x0 + sum Wi xi)/W.
    """
    parts = (hull, *tanks)
    weight = sum(part.weight for part in parts)
    x, y, z = (sum(part.weight * part[axis] for part in parts) for axis in (1, 2, 3))
    return Balance(weight, (x, y, z), (x / weight, y / weight, z / weight))


def limits(hull: Weight, tanks: Sequence[Weight]) -> TankLimits:
    """Return the limits of weight [N] and centre [m], ``tanks`` being their full contents."""
    ends = [[_extreme(hull, tanks, axis, sign) for sign in (-1, 1)] for axis in WEIGHT_AXES]
    weights = FillingRange(hull.weight, balance(hull, tanks).weight)
    return TankLimits(weights, *(FillingRange(*pair) for pair in ends))


def _extreme(hull: Weight, tanks: Sequence[Weight], axis: int, sign: int) -> float:
    """Return the centre [m] furthest towards ``sign`` along an axis.

    At the extreme each tank is full or empty, and a full one lies beyond the centre of all others.
    Tanks are therefore filled from the outermost inwards, until one would draw the centre back.
    """
    weight, moment = hull.weight, hull.weight * hull[axis]
    for tank in sorted(tanks, key=lambda tank: -sign * tank[axis]):
        if sign * (tank[axis] - moment / weight) <= 0.0:
            break
        weight += tank.weight
        moment += tank.weight * tank[axis]
    return moment / weight


@dataclass(frozen=True)
class Tank:
    """A tank or compartment of the boat."""

    name: str
    kind: str  # of TANK_TABLES
    full: Weight  # of what it holds when full
    fill: float  # [-] of it, now

    @property
    def contents(self) -> Weight:
        """Return the weight of the present contents, and its place."""
        return self.full._replace(weight=self.fill * self.full.weight)


@dataclass(frozen=True)
class Ranges:
    """Limits over all fillings of some tanks, and the outline of weight and moment."""

    free: str  # which
    limits: TankLimits
    # corners of all that can be: W - B [N] and x_G W - x_B B [N m]
    outline: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class TanksReport:
    """All that ``trainer report-1969 tanks`` says about a vessel."""

    vessel: str
    buoyancy_N: float
    x_b_m: float
    z_b_m: float
    hull: Weight  # the boat with its tanks empty
    tanks: tuple[Tank, ...]
    now: Balance
    ranges: tuple[Ranges, ...]


def tanks_of(file: VesselFile, fills: Mapping[str, float]) -> list[Tank]:
    """Return the tanks, filled as at the start or as ``fills`` [-] says by name.

    ConfigError if the boat has no tanks, none of that name, or a share is not within 0 and 1.
    """
    if file.ballast is None:
        raise ConfigError(f"{file.path.name}: has no table [ballast]: there are no tanks to fill")
    unit = file.fluid.rho * file.fluid.g
    rows = [(kind, row) for kind in TANK_TABLES for row in getattr(file.ballast, kind)]
    names = [row.name for _, row in rows]
    problems = []
    for name, share in fills.items():
        if name not in names:
            known = f"this boat has {', '.join(names)}"
            problems.append(f"--fill {quote(name)}: no such tank{nearest(name, names)}; {known}")
        elif not 0.0 <= share <= 1.0:
            problems.append(f"--fill {name}={share:g}: must be within 0 (empty) and 1 (full)")
    raise_problems(problems)
    tanks = []
    for kind, row in rows:
        fill = fills.get(row.name, getattr(row, "start_fill", 0.0))
        tanks.append(Tank(row.name, kind, Weight(unit * row.capacity_m3, *row.centre_m), fill))
    return tanks


def _together(hull: Weight, parts: Sequence[Weight]) -> Weight:
    whole = balance(hull, parts)
    return Weight(whole.weight, *whole.centre)


def outline(file: VesselFile, fixed: Weight, free: Sequence[Weight]) -> NDArray[np.float64]:
    """Return the corners of all weights and moments. They are W - B [N] and x_G W - x_B B [N m].

    They are in order and closed, (n, 2).

    Each tank adds a line from empty to full. The outline of the sum of such lines has each line
    twice, in the order of their steepness (a Minkowski sum).
    """
    hull = file.hull
    start = [fixed.weight - hull.buoyancy, fixed.weight * fixed.x - hull.cb[0] * hull.buoyancy]
    lines = ([tank.weight, tank.weight * tank.x] for tank in free)
    steps = sorted(lines, key=lambda step: math.atan2(step[1], step[0]))
    backwards = [[-weight, -moment] for weight, moment in steps]
    return np.cumsum([start, *steps, *backwards], axis=0)


def report_fillings(file: VesselFile, fills: Mapping[str, float]) -> TanksReport:
    """Return balance and limits of the boat's tanks, filled as ``fills`` [-] says by name."""
    at_start = [tank.contents for tank in tanks_of(file, {})]  # which [vessel] holds
    taken = [water._replace(weight=-water.weight) for water in at_start]
    hull = _together(Weight(file.hull.weight, *file.hull.cg), taken)
    tanks, ranges = tanks_of(file, fills), []
    kinds = {tank.kind for tank in tanks}
    for name, members in FREE_TANK_GROUPS.items():
        if members[-1] in kinds:
            fixed = _together(hull, [tank.contents for tank in tanks if tank.kind not in members])
            free = [tank.full for tank in tanks if tank.kind in members]
            corners = tuple((float(w), float(m)) for w, m in outline(file, fixed, free))
            ranges.append(Ranges(name, limits(fixed, free), corners))
    return TanksReport(
        vessel=file.name,
        buoyancy_N=file.hull.buoyancy,
        x_b_m=file.hull.cb[0],
        z_b_m=file.hull.cb[2],
        hull=hull,
        tanks=tuple(tanks),
        now=balance(hull, [tank.contents for tank in tanks]),
        ranges=tuple(ranges),
    )


def _weight(name: str, part: Weight, fill: str) -> tuple[str, ...]:
    """Return one weight as a line of the table."""
    centre = (f"{at:+.3f}" for at in (part.x, part.y, part.z))
    return (name, fill, f"{1e-3 * part.weight:.1f}", *centre)


def _balance(report: TanksReport) -> list[str]:
    """Return hull, tanks and their sum."""
    heads = ("", "filled", "[kN]", "x [m]", "y [m]", "z [m]")
    now = Weight(report.now.weight, *report.now.centre)
    rows = [
        _weight("hull, tanks empty", report.hull, ""),
        *(_weight(tank.name, tank.contents, f"{tank.fill:.1%}") for tank in report.tanks),
        _weight("together", now, ""),
    ]
    excess = 1e-3 * (report.now.weight - report.buoyancy_N)
    moment = 1e-3 * (report.now.moments[0] - report.x_b_m * report.buoyancy_N)
    x, y, z = (1e-3 * part for part in report.now.moments)
    below = report.now.centre[2] - report.z_b_m
    return [
        *titled_table("WEIGHT AND BALANCE (EC430)", heads, rows),
        f"{INDENT}moments about the origin: x {x:+.1f}, y {y:+.1f}, z {z:+.1f} kN m",
        f"{INDENT}W - B {excess:+.1f} kN, bow-down moment {moment:+.1f} kN m",
        f"{INDENT}centre of gravity {below:.4f} m below the centre of buoyancy",
    ]


def _span(limits: FillingRange, scale: float, form: str) -> str:
    """Return a range as text."""
    return f"{scale * limits.least:{form}} to {scale * limits.most:{form}}"


def render(report: TanksReport) -> str:
    """Return the report as text."""
    heads = ("free to be filled", "weight [kN]", "x_G [m]", "z_G [m]")
    rows, sided = [], []
    for ranges in report.ranges:
        weight, x_g, y_g, z_g = ranges.limits
        centre = (_span(at, 1.0, "+.3f") for at in (x_g, z_g))
        rows.append((ranges.free, _span(weight, 1e-3, ".1f"), *centre))
        if y_g != (0.0, 0.0):
            sided.append(f"{INDENT}{ranges.free}: y_G {_span(y_g, 1.0, '+.4f')} m")
    title = "LIMITS OVER ALL FILLINGS, each by itself"
    return "\n".join([report.vessel, *_balance(report), *titled_table(title, heads, rows), *sided])


def panels(report: TanksReport) -> tuple[Panel, ...]:
    """Return the outlines of excess weight and moment, the boat as it is among them."""
    here = (
        1e-3 * (report.now.moments[0] - report.x_b_m * report.buoyancy_N),
        1e-3 * (report.now.weight - report.buoyancy_N),
    )
    outlines = []
    for ranges in report.ranges:
        corners = 1e-3 * np.array(ranges.outline)
        outline = Curve(ranges.free, corners[:, 1], corners[:, 0])
        now = Curve("as filled", np.array(here[:1]), np.array(here[1:]), points=True)
        x, y = "bow-down moment [kN m]", "W - B [kN]"
        outlines.append(Panel(f"{report.vessel}: {ranges.free}", x, y, (outline, now)))
    return tuple(outlines)


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


def render_overshoots(report: TankageReport) -> str:
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


def overshoot_panels(report: TankageReport, flights: Flights) -> tuple[Panel, ...]:
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
