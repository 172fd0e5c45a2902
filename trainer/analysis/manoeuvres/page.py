"""``trainer boat manoeuvre``: one manoeuvre flown, with its report, page, plot and CSV file.

``cli/workshop/guide`` calls ``fly_boat``; fitted ships come by ``fly_vehicle``. A report is a
record, from which page and ``--json`` are both made.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from trainer.analysis.manoeuvres.catalogue import (
    ParameterValues,
    adjust_manoeuvre,
    format_parameters,
    manoeuvre_parameters,
)
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, Mark, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import CALM_SEA, DEEP_WATER_M, Rig, Submarine
from trainer.analysis.manoeuvres.turns import SPIRAL_WAYS
from trainer.analysis.manoeuvres.vehicle import Measure, Vehicle
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core.scheme import RUNGE_KUTTAS
from trainer.io.outputs import write_whole
from trainer.report.columns import DEPTH_COLUMNS, page_unit
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, format_number, table, wrap
from trainer.units import KNOT

TRACK_PANEL = "track"
TURNS_PANEL = "turns"  # yaw rate over rudder where turns were steady
HELD_PANEL = "rates held"


@dataclass(frozen=True)
class ManoeuvreReport:
    """The figures that ``trainer boat manoeuvre`` prints; measures SI and radians."""

    vessel: str
    manoeuvre: str
    speed_kn: float  # at the start
    parameters: ParameterValues  # [deg], [s] and [kn]
    method: Method | None  # of a boat; another vehicle computes as it does
    rig: Rig | None
    marks: tuple[Mark, ...]
    measures: tuple[Measure, ...]
    lost: str
    notices: tuple[str, ...] = ()  # depths passed and the surface broken, of a boat at a depth


@dataclass(frozen=True, kw_only=True)
class ManoeuvreOptions:
    """A user's wishes for a manoeuvre; None is the vehicle's own.

    ``manoeuvre_parameters`` are by the names of PARAMETERS. The fields from ``equations`` on are
    for boats alone.
    """

    speed: float | None = None  # [kn]
    step: float | None = None  # [s]
    parameters: ParameterValues = field(default_factory=dict)
    equations: str = "full"
    rates: str | None = None
    trig: str = "exact"
    integrator: str = "adams2"
    rig: Rig = field(default_factory=Rig)


def fly_boat(
    file: VesselFile, name: str, options: ManoeuvreOptions
) -> tuple[ManoeuvreReport, Flight]:
    """Return report and flight of the manoeuvre of that name."""
    runge_kutta = options.integrator in RUNGE_KUTTAS
    method = Method(
        options.equations,
        options.rates or ("exact" if runge_kutta else "lagged"),
        options.trig,
        options.integrator,
        options.step or file.run.step_s,
    )
    boat = Submarine(file, method, options.rig)
    report, flight = fly_vehicle(boat, name, options, file.run.start_speed_kn)
    notices = boat.notices(flight.series.columns)
    rig = replace(options.rig, sea=boat.sea)
    return replace(report, method=method, rig=rig, notices=notices), flight


def fly_vehicle(
    vehicle: Vehicle, name: str, options: ManoeuvreOptions, usual: float
) -> tuple[ManoeuvreReport, Flight]:
    """Return report and flight of the manoeuvre of that name by any vehicle.

    It begins at ``usual`` [kn] unless ``options`` have another speed. ConfigError for a speed of a
    manoeuvre that starts from rest.
    """
    manoeuvre = adjust_manoeuvre(name, vehicle, options.parameters)
    if manoeuvre.from_rest and options.speed is not None:
        raise ConfigError("--speed: this manoeuvre starts from rest")
    moving = usual if options.speed is None else options.speed
    flight = fly_manoeuvre(vehicle, manoeuvre, 0.0 if manoeuvre.from_rest else moving * KNOT)
    report = ManoeuvreReport(
        vessel=vehicle.name,
        manoeuvre=name,
        speed_kn=flight.speed / KNOT,
        parameters=manoeuvre_parameters(manoeuvre),
        method=None,
        rig=None,
        marks=flight.marks,
        measures=tuple(manoeuvre.measures(flight)),
        lost=flight.lost,
    )
    return report, flight


def render(report: ManoeuvreReport) -> str:
    """Return the report as text."""
    parameter_text = format_parameters(report.parameters)
    rows = [(one.name, *format_measure(one)) for one in report.measures]
    lines = [
        f"{report.vessel}: {report.manoeuvre}",
        f"{INDENT}from {report.speed_kn:g} kn; {parameter_text or 'no parameters'} [deg, s, kn]",
        *_method_facts(report),
        "",
        *table(("measure", "", "unit"), rows),
    ]
    if report.notices:
        lines.append("")
        lines += [line for words in report.notices for line in wrap(words)]
    if report.lost:
        lines += ["", *wrap(f"LOST: {report.lost}")]
    return "\n".join(lines)


def _method_facts(report: ManoeuvreReport) -> list[str]:
    """Return how a boat was computed and rigged; nothing for another vehicle."""
    method, rig = report.method, report.rig
    if method is None or rig is None:
        return []
    computed = f"{method.equations} set, {method.rates} accelerations, {method.integrator}"
    conditions = f"from {DEEP_WATER_M:g} m, where neither hull nor surface sets limits"
    if rig.depth is not None:
        seed = "" if rig.sea == CALM_SEA else f", seed {rig.seed}"
        conditions = f"from {rig.depth:g} m; sea: {rig.sea}{seed}"
    return [
        f"{INDENT}{computed}, step {method.step:g} s",
        f"{INDENT}controls: {rig.controls}; trim: {rig.trim}; depth law: {rig.law}",
        f"{INDENT}{conditions}",
    ]


def format_measure(one: Measure) -> tuple[str, str]:
    """Return number and unit of a measure on a page: degrees for radians."""
    if not one.unit.startswith("rad"):
        return format_number(one.value, ".4g"), one.unit
    degrees = None if one.value is None else math.degrees(one.value)
    return format_number(degrees, ".4g"), one.unit.replace("rad", "deg")


def panels(manoeuvre: Manoeuvre, flight: Flight) -> tuple[Panel, ...]:
    """Return the panels of what the manoeuvre shows and the vehicle has, events marked."""
    marks = tuple((mark.name, mark.t) for mark in flight.marks)
    drawn = []
    for name in manoeuvre.shows:
        if name == TRACK_PANEL:
            curve = Curve("track", flight.column("y"), flight.column("x"))
            drawn.append(Panel("track", "east [m]", "north [m]", (curve,)))
        elif name == TURNS_PANEL and flight.has("delta_r"):
            curves = tuple(_steady_turns(flight))
            drawn.append(Panel("steady turns", "delta_r [deg]", "r [deg/s]", curves))
        elif flight.has(name):
            factor, of = page_unit(name)
            curve = Curve(name, flight.t, factor * flight.column(name))
            lower = name in DEPTH_COLUMNS
            drawn.append(
                Panel(name, "time [s]", f"{name} [{of}]", (curve,), marks, downwards=lower)
            )
    return tuple(drawn)


def _steady_turns(flight: Flight) -> Iterator[Curve]:
    """Yield yaw rate over rudder at the marks, each way of a spiral by itself."""
    ways = dict.fromkeys(_way(mark) for mark in flight.marks)
    for way in ways:
        t = np.array([mark.t for mark in flight.marks if _way(mark) == way])
        helm, rate = (np.interp(t, flight.t, flight.column(name)) for name in ("delta_r", "r"))
        yield Curve(way, np.degrees(helm), np.degrees(rate), points=way == HELD_PANEL)


def _way(mark: Mark) -> str:
    """Return which way of a direct spiral a mark is of, HELD_PANEL where a rate was held."""
    first = mark.name.split()[0]
    return first if first in SPIRAL_WAYS else HELD_PANEL


def write_csv(flight: Flight, path: Path) -> None:
    """Write all columns of a flight, every digit; ConfigError if that cannot be."""
    columns = flight.series.columns
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    try:
        write_whole(path, "\n".join(lines) + "\n")
    except OSError as error:
        raise ConfigError(f"--csv {path}: cannot be written: {error.strerror}") from None
