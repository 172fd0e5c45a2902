"""An identified ship under the orders of a manoeuvre or a study, with its uncertainty."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.estimate.uncertainty import Joint
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.analysis.manoeuvres.page import Report, fly_vehicle, format_measure
from trainer.analysis.manoeuvres.page import render as render_flight
from trainer.analysis.manoeuvres.vehicle import Control, LostError, Measure
from trainer.analysis.report.text import table, wrap
from trainer.analysis.sweep.job import Batch, Output, asked_of, fly_each, read_off
from trainer.analysis.sweep.manoeuvres import ALONE, manoeuvre_of, speed_of
from trainer.analysis.sweep.records import ManoeuvreTable
from trainer.analysis.sweep.study import Study
from trainer.boat.ship.forces import AXES, PLACES, ROLL, ROWS, add_heel, add_terms, set_terms
from trainer.boat.ship.models import NONLINEAR, check_names, model_for
from trainer.config.files import ConfigError, Place
from trainer.config.schema import read_record
from trainer.config.ship import ShipFile, read_ship
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_filter import sail_record
from trainer.identify.ships.records import SWING
from trainer.units import KNOT

COLUMNS: Final = ("t", "u", "v", "r", "x", "y", "psi", "delta_r", "n")
OF_ROLL: Final = ("p", "phi")  # columns of a ship with roll, after them
STEP: Final = 0.025  # [L/U] of a cycle
STEADY_STEPS: Final = 60  # of Newton, to speed held straight
CLOSE: Final = 1e-10
NONE_FREE: Final = np.empty((0, 1), np.int64)
DRAWS: Final = 100
FEWEST_DRAWS: Final = 20  # of a long manoeuvre,
MOST_CYCLES: Final = 600_000  # so that all of them together take no more
MOST_LOST: Final = 0.5  # [-] of the draws
BEYOND: Final = 1.05  # [-] of the range seen, from which it is told
OF_BOATS: Final = {
    "method": ("equations", "rates", "trig", "integrator"),
    "manoeuvre": ("depth_kept", "controls", "trim", "law"),
}


class IdentifiedShip:
    """A ship that is not linear, of a file that a fit has written."""

    def __init__(self, ship: ShipFile, step: float | None = None) -> None:
        """Take the ship's numbers; ConfigError if no fit has given it any."""
        if ship.result is None:
            raise ConfigError(
                f"{ship.path.name}: lacks [result] and [coefficients]: fit it first, "
                "trainer identify RECORD --model mmg --ship FILE --write-ship FOUND"
            )
        self.name = ship.name
        self.length = ship.dimensions.length_m
        self.file, self.result = ship, ship.result
        usual = STEP * self.length / (self.result.speed_kn * KNOT)
        if ship.roll is not None:
            usual = min(usual, SWING / math.sqrt(ship.stiffness))
        self.step = step or float(f"{usual:.1g}")
        model = model_for(ship, self.result.model, wind="N_ww" in ship.coefficients)
        check_names(ship, model)
        self._terms, self._constants = model.terms, ship.constants
        self._whole = model.whole(ship.coefficients)
        self._limit = math.radians(ship.dimensions.rudder_limit_deg)
        self._driven, states = model.driven, model.states
        self.columns = COLUMNS if ship.roll is None else (*COLUMNS, *OF_ROLL)
        self._state, self._place = np.zeros(states), np.zeros(2)
        self._record, self._out = np.zeros((2, 12)), np.empty((2, states))
        self._values = np.concatenate([self._whole, np.zeros(len(model.noises) + states)])
        self._neutral = self._rudder = self._ordered = self._turns = self._time = 0.0

    @property
    def speed_kn(self) -> float:
        """Return the speed [kn] at which manoeuvres begin."""
        return self.result.speed_kn

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of the rudder; its propeller is not known astern."""
        return {"rudder": Control(-self._limit, self._limit)}

    def start(self, speed: float) -> None:
        """Begin anew, straight ahead at ``speed`` [m/s]; ConfigError if nothing holds it there."""
        sway, rudder, turns, *heel = self._steady(speed)
        rolls = [0.0, *heel] if heel else []
        self._state = np.array([speed, sway, 0.0, 0.0, *rolls])
        self._place = np.zeros(2)
        self._neutral = self._rudder = self._ordered = rudder
        self._turns, self._time = turns, 0.0

    def _rates(self, state: Numbers, rudder: float, turns: float) -> Numbers:
        """Return du/dt, dv/dt, dr/dt, and with roll dp/dt, in no wind."""
        axes = len(self._driven)
        work, out = np.empty((ROWS, 1)), np.empty((PLACES, 1))
        inputs = np.array([rudder, turns, 0.0, 0.0])
        set_terms(work, self._constants, state, inputs, self._whole[-len(NONLINEAR) :])
        add_terms(work, self._terms, self._whole, self._constants, out)
        if axes == AXES:
            add_heel(state, out)
        return np.array(out[:axes, 0])

    def _steady(self, speed: float) -> tuple[float, ...]:
        """Return sway [m/s], rudder [rad] and revolutions [1/s] of straight motion, by Newton.

        With roll, also the heel [rad].
        """
        axes = len(self._driven)
        scale = np.array([speed, 1.0, self.result.revolutions_per_s or 1.0, 1.0])[:axes]
        found = np.zeros(axes)
        found[2] = scale[2] * speed / (self.result.speed_kn * KNOT)

        def rates(z: Numbers) -> Numbers:
            return self._rates(np.array([speed, z[0], 0.0, 0.0, 0.0, *z[3:]]), z[1], z[2])

        unit = (
            np.array([1.0, 1.0, self.length, self.length])[:axes]
            * self.length
            / max(speed, 1e-9) ** 2
        )
        for _ in range(STEADY_STEPS):
            left = unit * rates(found)
            if np.max(np.abs(left)) < CLOSE:
                break
            aside = 1e-6 * scale
            J = np.column_stack(
                [
                    unit * (rates(found + e) - rates(found - e)) / (2.0 * e.sum())
                    for e in np.diag(aside)
                ]
            )
            try:
                move = np.linalg.solve(J, left)
            except np.linalg.LinAlgError:
                break
            found = found - move / max(1.0, float(np.max(np.abs(move) / (0.3 * scale))))
        good = np.max(np.abs(unit * rates(found))) < 1e3 * CLOSE and abs(found[1]) < self._limit
        if not good or not np.isfinite(found).all():
            raise ConfigError(
                f"{self.name}: nothing holds it straight at {speed / KNOT:.4g} kn; "
                f"it was identified at {self.result.speed_kn:.4g} kn"
            )
        return tuple(map(float, found))

    def incline(self, heel: float) -> None:
        """Heel the ship; do nothing where the model has no roll."""
        self._state[ROLL:] = heel

    def order(self, control: str, value: float) -> None:
        """Order the rudder [rad], positive to starboard, from its neutral angle."""
        del control
        self._ordered = min(max(self._neutral + value, -self._limit), self._limit)

    def keep(self, quantity: str) -> None:
        """Do nothing: revolutions are held, and there is no depth."""

    def observe(self) -> tuple[float, ...]:
        """Return the columns as they stand, SI and radians; the rudder positive to port."""
        u, v, r, psi, *rolls = map(float, self._state)
        x, y = map(float, self._place)
        return (self._time, u, v, r, x, y, psi, -self._rudder, self._turns, *rolls)

    def advance(self) -> None:
        """Advance by one step of Runge and Kutta; LostError if it is lost."""
        h = self.step
        most = math.radians(self.file.dimensions.rudder_rate_deg_s) * h
        before, state = self._rudder, self._state
        self._rudder += min(max(self._ordered - before, -most), most)
        record, out, values = self._record, self._out, self._values
        record[0, 4], record[1, 4] = before, self._rudder
        record[0, 5] = record[1, 5] = self._turns
        record[0, 8], record[0, 9] = h, 1.0
        values[-len(state) :] = state
        system = self._constants, self._terms, values, NONE_FREE, self._driven
        if sail_record(system, record, out) < 2:
            raise LostError(f"{self.name} is no ship under way after {self._time:g} s")
        self._state = out[1].copy()
        u, v, _, psi, *_ = (0.5 * (state + self._state)).tolist()
        self._place[0] += h * (u * math.cos(psi) - v * math.sin(psi))
        self._place[1] += h * (u * math.sin(psi) + v * math.cos(psi))
        self._time += h


def draws(ship: ShipFile, count: int) -> Iterator[ShipFile]:
    """Yield ships drawn from what the records leave open."""
    if ship.covariance is None:
        return
    known = Joint({name: ship.coefficients[name] for name in ship.uncertain}, ship.covariance)
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
class ShipReport(Report):
    """The report of a manoeuvre, with what the ship's uncertainty makes of it."""

    intervals: tuple[Interval, ...] = ()
    draws: int = 0  # ships drawn, and how many of them were lost
    draws_lost: int = 0


def fly_ship(ship: ShipFile, name: str, options: Mapping[str, Any]) -> tuple[ShipReport, Flight]:
    """Return report and flight of a manoeuvre, with intervals by ships drawn."""
    vehicle = IdentifiedShip(ship, options["step"])
    report, flight = fly_vehicle(vehicle, name, options, vehicle.speed_kn)
    drawn, lost = [], 0
    count = min(max(MOST_CYCLES // max(len(flight.t), 1), FEWEST_DRAWS), DRAWS)
    for other in draws(ship, count):
        try:
            flown, _ = fly_vehicle(
                IdentifiedShip(other, vehicle.step), name, options, vehicle.speed_kn
            )
        except ConfigError:
            lost += 1
            continue
        lost += bool(flown.lost)
        if not flown.lost:
            drawn.append({one.name: one.value for one in flown.measures})
    own = {item.name: getattr(report, item.name) for item in fields(Report)}
    own["notices"] = (*report.notices, *_beyond(ship, flight))
    intervals = tuple(_interval(one, drawn) for one in report.measures) if drawn else ()
    return ShipReport(**own, intervals=intervals, draws=len(drawn) + lost, draws_lost=lost), flight


def _interval(one: Measure, drawn: list[dict[str, float | None]]) -> Interval:
    """Return where 95 % of the drawn ships have a measure; None where half have none."""
    values = [value for each in drawn if (value := each.get(one.name)) is not None]
    if one.value is None or len(values) < MOST_LOST * len(drawn):
        return Interval(one.name, one.unit, None, None)
    low, high = np.percentile(values, (2.5, 97.5))
    return Interval(one.name, one.unit, float(low), float(high))


def _beyond(ship: ShipFile, flight: Flight) -> Iterator[str]:
    """Yield where a manoeuvre leaves what the records saw."""
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
        slack = (BEYOND - 1.0) * max(abs(low), abs(high))
        if least < low - slack or most > high + slack:
            yield (
                f"{name} goes from {least:.3g} to {most:.3g} {unit}; the records saw {low:.3g} to "
                f"{high:.3g}: beyond it the polynomials are not known"
            ).replace(" -;", ";")


def render(report: ShipReport) -> str:
    """Return the report as text, with the intervals."""
    plain = replace(report, intervals=())
    text = render_flight(plain)
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


class Sailing:
    """The members of a study that sail an identified ship, one by one."""

    chunk = ALONE

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member cannot sail."""
        self.study = study
        self.trial, self.flight = self._sailed(study.draws.middle())

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return what is kept of each member. ConfigError if the study asks for what is not."""
        return asked_of(self.study, self.flight, self.trial.measures(self.flight))

    def batch(self, first: int, count: int) -> Batch:
        """Return what becomes of ``count`` members from ``first`` on."""
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
        inside = Place(path.name, "manoeuvre")
        table = read_record(ManoeuvreTable, tables["manoeuvre"], inside, ())
        _check_words(self.study, table)
        named = Path(self.study.heading.vessel or "")
        ship = IdentifiedShip(read_ship(tables["vessel"], named), self.study.method.step_s)
        manoeuvre = manoeuvre_of(table, ship)
        return manoeuvre, fly(ship, manoeuvre, speed_of(table, ship.speed_kn))


def _check_words(study: Study, table: ManoeuvreTable) -> None:
    """Check that a study has no words for boats alone; ConfigError with all it has."""
    given = {"method": asdict(study.method), "manoeuvre": asdict(table)}
    problems = [
        Place(study.path.name, where).wrong(key, given[where][key], "is for boats, not for ships")
        for where, keys in OF_BOATS.items()
        for key in keys
        if given[where][key] is not None
    ]
    if problems:
        raise ConfigError(*problems)
