"""A fitted ship that is not linear, flown by ``trainer boat manoeuvre``, ``sweep`` and ``prbs``.

Its coefficients are uncertain, so a manoeuvre is flown again by ships drawn from their covariance,
and each measure has the range of 95 % of them. Beyond the motions that the records covered the
polynomials say nothing, and the report says where that happens.
"""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.estimate.uncertainty import JointCoefficients
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.page import (
    ManoeuvreOptions,
    ManoeuvreReport,
    fly_vehicle,
    format_measure,
)
from trainer.analysis.manoeuvres.page import render as render_flight
from trainer.analysis.manoeuvres.vehicle import Control, LostError, Measure
from trainer.analysis.sweep.job import Batch, Output, asked_of, fly_each, read_off
from trainer.analysis.sweep.manoeuvres import SINGLE_CHUNK_MEMBERS, manoeuvre_of, speed_of
from trainer.analysis.sweep.records import ManoeuvreTable
from trainer.analysis.sweep.study import Study
from trainer.boat.ship.forces import ROLL_INDEX
from trainer.boat.ship.motion import ShipMoment, ShipMotion
from trainer.config.files import ConfigError, Position, raise_problems
from trainer.config.schema import read_record
from trainer.config.ship.ship import ShipFile, read_ship
from trainer.report.text import table, wrap

FLIGHT_COLUMNS: Final = ("t", "u", "v", "r", "x", "y", "psi", "delta_r", "n")
ROLL_COLUMNS: Final = ("p", "phi")  # columns of a ship with roll, after them
MAX_DRAWS: Final = 100  # ships drawn for the bands of a manoeuvre
MIN_DRAWS: Final = 20  # of a long manoeuvre,
MAX_CYCLES: Final = 600_000  # so that all of them together take no more
MAX_LOST_SHARE: Final = 0.5  # [-] of the draws
RANGE_MARGIN: Final = 1.05  # [-] of the range seen, from which it is told
BOAT_OPTIONS: Final = {
    "method": ("equations", "rates", "trig", "integrator"),
    "manoeuvre": ("depth_kept", "controls", "trim", "law"),
}


class IdentifiedShip:
    """A ship that is not linear, from a file that a fit has written."""

    def __init__(self, ship: ShipFile, step: float | None = None) -> None:
        """Take the ship's numbers; ConfigError if no fit has given it any."""
        self.motion = ShipMotion(ship)
        self.name, self.length = ship.name, self.motion.length
        self.step = step or self.motion.step
        self.columns = FLIGHT_COLUMNS if ship.roll is None else (*FLIGHT_COLUMNS, *ROLL_COLUMNS)
        self.now = ShipMoment(0.0, 0.0, (0.0,) * self.motion.states, 0.0, 0.0)
        self._neutral = self._ordered = self._time = 0.0

    @property
    def speed_kn(self) -> float:
        """Return the speed [kn] at which manoeuvres begin."""
        return self.motion.result.speed_kn

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of the rudder; its propeller is not known astern."""
        return {"rudder": Control(-self.motion.limit, self.motion.limit)}

    def start(self, speed: float) -> None:
        """Begin anew, straight ahead at ``speed`` [m/s]; ConfigError if nothing holds it there."""
        self.now = self.motion.straight(speed)
        self._neutral = self._ordered = self.now.rudder
        self._time = 0.0

    def incline(self, heel: float) -> None:
        """Heel the ship; do nothing where the model has no roll."""
        if len(self.now.state) > ROLL_INDEX:
            self.now = self.now._replace(state=(*self.now.state[:ROLL_INDEX], heel))

    def order(self, control: str, value: float) -> None:
        """Order the rudder [rad], positive to starboard, from its neutral angle."""
        del control
        limit = self.motion.limit
        self._ordered = min(max(self._neutral + value, -limit), limit)

    def keep(self, quantity: str) -> None:
        """Do nothing: revolutions are constant, and there is no depth."""

    def observe(self) -> tuple[float, ...]:
        """Return the columns as they stand, SI and radians; the rudder positive to port."""
        now = self.now
        u, v, r, psi, *rolls = now.state
        return (self._time, u, v, r, now.north, now.east, psi, -now.rudder, now.turns, *rolls)

    def advance(self) -> None:
        """Advance by one step of Runge and Kutta; LostError if it is lost."""
        then = self.motion.after(self.now, self._ordered, self.step)
        if then is None:
            raise LostError(f"{self.name} is no ship under way after {self._time:g} s")
        self.now = then
        self._time += self.step


def draw_ships(ship: ShipFile, count: int) -> Iterator[ShipFile]:
    """Yield ships drawn from what the records leave open; none without a covariance."""
    if ship.covariance is None:
        return
    known = JointCoefficients(
        {name: ship.coefficients[name] for name in ship.uncertain}, np.array(ship.covariance)
    )
    for number in range(1, count + 1):
        yield replace(ship, coefficients={**ship.coefficients, **known.draw(number)})


@dataclass(frozen=True)
class Interval:
    """The range of a measure for 95 % of the ships drawn, SI."""

    name: str
    unit: str
    low: float | None
    high: float | None


@dataclass(frozen=True)
class ShipReport(ManoeuvreReport):
    """The report of a manoeuvre, with what the ship's uncertainty makes of it."""

    intervals: tuple[Interval, ...] = ()
    draws: int = 0  # ships drawn, and how many of them were lost
    draws_lost: int = 0


def fly_ship(ship: ShipFile, name: str, options: ManoeuvreOptions) -> tuple[ShipReport, Flight]:
    """Return report and flight of a manoeuvre, with intervals by ships drawn."""
    vehicle = IdentifiedShip(ship, options.step)
    report, flight = fly_vehicle(vehicle, name, options, vehicle.speed_kn)
    count = min(max(MAX_CYCLES // max(len(flight.t), 1), MIN_DRAWS), MAX_DRAWS)
    drawn, others = [], list(draw_ships(ship, count))
    for other in others:
        with suppress(ConfigError):  # that one is lost
            sailing = IdentifiedShip(other, vehicle.step)
            flown, _ = fly_vehicle(sailing, name, options, vehicle.speed_kn)
            if not flown.lost:
                drawn.append({one.name: one.value for one in flown.measures})
    report_values = {**vars(report), "notices": (*report.notices, *_beyond(ship, flight))}
    intervals = tuple(_interval(one, drawn) for one in report.measures) if drawn else ()
    report_values |= {"draws": len(others), "draws_lost": len(others) - len(drawn)}
    return ShipReport(**report_values, intervals=intervals), flight


def _interval(one: Measure, drawn: list[dict[str, float | None]]) -> Interval:
    """Return where 95 % of the drawn ships have a measure; None where half have none."""
    values = [value for each in drawn if (value := each.get(one.name)) is not None]
    if one.value is None or len(values) < MAX_LOST_SHARE * len(drawn):
        return Interval(one.name, one.unit, None, None)
    low, high = np.percentile(values, (2.5, 97.5))
    return Interval(one.name, one.unit, float(low), float(high))


def _beyond(ship: ShipFile, flight: Flight) -> Iterator[str]:
    """Yield where a manoeuvre leaves the ranges that the records covered."""
    u, v, r = (flight.column(name) for name in ("u", "v", "r"))
    size, length = np.hypot(u, v), ship.dimensions.length_m
    flown = {
        "v": ("v'", v / size, "-"),
        "r": ("r'", r * length / size, "-"),
        "rudder": ("the rudder", -flight.column("delta_r"), "deg"),
        "speed": ("the speed", u, "m/s"),
    }
    if flight.has("phi"):
        flown["roll"] = ("the roll", flight.column("phi"), "deg")
    for key, (name, values, unit) in flown.items():
        if key not in ship.ranges:
            continue
        factor = 180.0 / math.pi if unit == "deg" else 1.0
        low, high = (factor * end for end in ship.ranges[key])
        least, most = factor * float(values.min()), factor * float(values.max())
        slack = (RANGE_MARGIN - 1.0) * max(abs(low), abs(high))
        if least < low - slack or most > high + slack:
            yield (
                f"{name} goes from {least:.3g} to {most:.3g} {unit}; the records saw {low:.3g} to "
                f"{high:.3g}: beyond it the polynomials are not known"
            ).replace(" -;", ";")


def render(report: ShipReport) -> str:
    """Return the report as text, with the intervals."""
    text = render_flight(replace(report, intervals=()))
    if not report.intervals:
        return text
    rows = []
    for one in report.intervals:
        low, unit = format_measure(Measure(one.name, one.unit, one.low))
        high, _ = format_measure(Measure(one.name, one.unit, one.high))
        rows.append((one.name, low, high, unit))
    lost = f", {report.draws_lost} of them lost" if report.draws_lost else ""
    lines = wrap(f"Where 95 % of {report.draws} ships lie, drawn from the covariance{lost}:")
    return "\n".join([text, "", *lines, *table(("measure", "from", "to", "unit"), rows)])


class SailingSubject:
    """The members of a study that sail an identified ship, one by one."""

    chunk = SINGLE_CHUNK_MEMBERS

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member cannot sail."""
        self.study = study
        self.trial, self.flight = self._sailed(study.draws.middle())

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return the measures that are kept of each member. ConfigError for an unknown one."""
        return asked_of(self.study, self.flight, self.trial.measures(self.flight))

    def batch(self, first: int, count: int) -> Batch:
        """Return the results of ``count`` members from ``first`` on."""
        return fly_each(self.study.draws, first, count, len(self.outputs), self._numbers)

    def _numbers(self, drawn: Mapping[str, Any], seed: int) -> list[float]:
        """Return the numbers of one member; ConfigError why there are none."""
        del seed  # nothing is random in calm water
        manoeuvre, flight = self._sailed(drawn)
        if flight.lost:
            raise ConfigError(flight.lost)
        return read_off(self.outputs, flight, manoeuvre.measures(flight))

    def _sailed(self, drawn: Mapping[str, Any]) -> tuple[Manoeuvre, Flight]:
        """Return manoeuvre and flight of one member; ConfigError if it cannot begin."""
        tables, path = self.study.varied(drawn), self.study.path
        inside = Position(path.name, "manoeuvre")
        table = read_record(ManoeuvreTable, tables["manoeuvre"], inside, ())
        settings = {"method": asdict(self.study.method), "manoeuvre": asdict(table)}
        problems = [
            Position(path.name, where).wrong(
                key, settings[where][key], "is for boats, not for ships"
            )
            for where, keys in BOAT_OPTIONS.items()
            for key in keys
            if settings[where][key] is not None
        ]
        raise_problems(problems)
        named = Path(self.study.heading.vessel or "")
        ship = IdentifiedShip(read_ship(tables["vessel"], named), self.study.method.step_s)
        manoeuvre = manoeuvre_of(table, ship)
        return manoeuvre, fly_manoeuvre(ship, manoeuvre, speed_of(table, ship.speed_kn))
