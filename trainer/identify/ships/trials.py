"""``trainer ship prbs`` for ships that are not linear: plans, and what each would determine.

Each plan is flown by the ship itself in a calm. The expected information of a fit to that record
gives the standard deviations, as ``pages/experiment`` has them for a boat.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final

import numpy as np

from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, Conn, Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.vehicle import Measure
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.boat.ship.models import model_for
from trainer.config.files import ConfigError
from trainer.config.ship.sensors import Sensors
from trainer.config.ship.ship import ShipFile
from trainer.core.kernel import Numbers
from trainer.identify.experiment import REGISTER_TAPS, HelmOptions, prbs
from trainer.identify.record.measurements import Record
from trainer.identify.record.sources import TRAINER_COLUMNS
from trainer.identify.ships.fit import ShipFit, expect_fit, problem_of
from trainer.identify.ships.likelihood import YAW_GYRATION_LENGTHS, prior_of
from trainer.identify.ships.page import in_words
from trainer.identify.ships.records import MIN_TRIAL_SAMPLES, READING_CHANNELS
from trainer.identify.ships.results import (
    BOOK_PRIOR_SHARE,
    FittedCoefficient,
    UnknownDirection,
    coefficients_of,
    find_unknown,
)
from trainer.identify.ships.vehicle import IdentifiedShip
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, items, table, wrap
from trainer.units import KNOT

# steps of the ship between samples, where no interval is said: samples a twentieth of L/U apart
STEPS_PER_SAMPLE: Final = 2
MAX_LEGS: Final = 4  # speeds side by side, which a page is wide enough for
MIN_DISTURBANCE: Final = 1e-9  # [rad/s/rt(s)] a disturbance that is none
BETTER_PLAN_RATIO: Final = 0.9  # [-] of the next smaller deviation, from which a plan tells better
MAX_COMBINATIONS_SHOWN: Final = 3  # combinations that a page names of each plan
STATE_NAMES: Final = ("u", "v", "r", "psi", "p", "phi")
SENSOR_CHANNELS: Final = {"sway_kn": "sway", "yaw_rate_deg_s": "yaw_rate", "heading_deg": "heading"}
PLAN_LETTERS: Final = "ABCDE"


@dataclass(frozen=True)
class BinaryHelm(Manoeuvre):
    """Rudder from side to side by a pseudo-random binary sequence, again and again."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)

    angle_deg: float = 10.0
    hold_s: float = 30.0  # of a bit
    bits: int = 5  # of the register
    seed: int = 1
    duration_s: float = 600.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the sequence, to its end or that of the time."""
        yield from conn.hold(LEAD_TIME_S)
        sequence, last = prbs(self.bits, self.seed), 0.0
        for i in range(math.ceil((self.duration_s - LEAD_TIME_S) / self.hold_s)):
            bit = float(sequence[i % len(sequence)])  # 1 to port, as a rudder is positive
            if bit != last:
                conn.order("rudder", -bit * math.radians(self.angle_deg))
                conn.mark("execute")
            last = bit
            yield from conn.hold_to(min(LEAD_TIME_S + (i + 1) * self.hold_s, self.duration_s))

    def measures(self, flight: Flight) -> list[Measure]:
        """Return none: a sequence is judged by what a fit to it would tell."""
        del flight
        return []


@dataclass(frozen=True)
class Helm:
    """The rudder's part in a trial: a zig-zag, or a binary sequence."""

    zigzag_deg: tuple[float, float] | None = None  # rudder and heading
    sequence_deg: float = 0.0
    hold_s: float = 0.0
    bits: int = 0
    seed: int = 1

    def __str__(self) -> str:
        """Return the helm in words."""
        if self.zigzag_deg:
            return "zig-zag {:g}/{:g}".format(*self.zigzag_deg)
        bits = f"bits of {self.hold_s:.3g} s, register of {self.bits}"
        return f"sequence of {self.sequence_deg:g} deg, {bits}"

    @property
    def angle_deg(self) -> float:
        """Return the angle of the rudder."""
        return self.zigzag_deg[0] if self.zigzag_deg else self.sequence_deg

    def manoeuvre(self, seconds: float) -> Manoeuvre:
        """Return the manoeuvre that lasts so long."""
        if self.zigzag_deg:
            angle, execute = self.zigzag_deg
            return ZigZag(angle_deg=angle, execute_deg=execute, duration_s=seconds)
        return BinaryHelm(self.sequence_deg, self.hold_s, self.bits, self.seed, seconds)


@dataclass(frozen=True, kw_only=True)
class TrialOptions(HelmOptions):
    """A user's wishes for trials; None is what suits the ship."""

    amplitude: float | None = None  # [deg] of a sequence, where one is wanted beside a zig-zag
    speeds: tuple[tuple[float, float], ...] = ()  # [kn] and that which the revolutions hold
    prior_strength: float = 0.5

    @property
    def read(self) -> tuple[str, ...]:
        """Return the channels that are read beside the speed."""
        return self.outputs or READING_CHANNELS[1:]


@dataclass(frozen=True)
class ShipLeg:
    """One trial of a plan.

    It has the helm, the speed at its begin, and the speed that its revolutions hold.
    """

    speed_kn: float
    held_kn: float
    helm: Helm = Helm()

    def __str__(self) -> str:
        """Return the leg in words."""
        other = "" if self.held_kn == self.speed_kn else f", revolutions of {self.held_kn:g} kn"
        kind = "zig-zag" if self.helm.zigzag_deg else "sequence"
        return f"{kind} from {self.speed_kn:g} kn{other}"


@dataclass(frozen=True)
class ShipTrialPlan:
    """Legs one after another, and what is expected of fitting them together."""

    name: str
    legs: tuple[ShipLeg, ...]
    seconds: float  # of each leg
    samples: int  # of all
    executes: int
    slowest_kn: float
    fastest_kn: float
    coefficients: tuple[FittedCoefficient, ...]
    from_book: tuple[str, ...]
    untold: tuple[UnknownDirection, ...]


@dataclass(frozen=True)
class TrialReport:
    """All that ``trainer ship prbs`` says of trials of a ship that is not linear."""

    ship: str
    model: str
    length_m: float
    helms: tuple[Helm, ...]
    seconds: float
    interval_s: float
    outputs: tuple[str, ...]
    prior: str
    prior_strength: float
    plans: tuple[ShipTrialPlan, ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class TrialDesign:
    """A report with the flights of each plan, and what is expected of it."""

    report: TrialReport
    flights: tuple[tuple[Flight, ...], ...]
    expected: tuple[ShipFit, ...]


class TrialShip(IdentifiedShip):
    """A ship that begins at one speed with the revolutions that hold another.

    So its speed changes in the trial, and drag and thrust can be told apart.
    """

    def __init__(self, ship: ShipFile, held: float) -> None:
        """Take the ship, and the speed [m/s] that its revolutions hold."""
        super().__init__(ship)
        self._held = held

    def start(self, speed: float) -> None:
        """Begin straight ahead at ``speed`` [m/s]; ConfigError if nothing holds it there."""
        super().start(speed)
        self.now = self.now._replace(turns=self.motion.straight(self._held).turns)


def design_trials(ship: ShipFile, options: TrialOptions) -> TrialDesign:
    """Return trials of the ship, and what is expected of fitting them.

    With several speeds, or both kinds of helm, each is tried alone, then all together in the same
    time, so that plans can be compared. ConfigError.
    """
    usual = IdentifiedShip(ship)
    speeds = options.speeds or ((usual.speed_kn, usual.speed_kn),)
    helms = tuple(_helms(usual, options))
    legs = [ShipLeg(speed, held, helm) for helm in helms for speed, held in speeds]
    _check(ship, legs, options)
    ways = [(leg,) for leg in legs] + ([tuple(legs)] if len(legs) > 1 else [])
    interval = options.interval or STEPS_PER_SAMPLE * usual.step
    every = max(1, round(interval / usual.step))
    flown = tuple(_flights(ship, way, options) for way in ways)
    expected = tuple(_expected(ship, flights, every, options) for flights in flown)
    plans = tuple(_plan(*one) for one in zip(PLAN_LETTERS, ways, flown, expected, strict=False))
    report = TrialReport(
        ship=ship.name,
        model=expected[0].problem.model.name,
        length_m=ship.dimensions.length_m,
        helms=helms,
        seconds=options.seconds,
        interval_s=every * usual.step,
        outputs=("speed", *options.read),
        prior=prior_of(expected[0].problem.model, ship)[1],
        prior_strength=options.prior_strength,
        plans=plans,
        remarks=tuple(_remarks(plans)),
    )
    return TrialDesign(report, flown, expected)


def _helms(usual: IdentifiedShip, options: TrialOptions) -> Iterator[Helm]:
    """Yield the helms that are asked for: the zig-zag, the sequence, or both.

    A bit lasts the time of a ship length. The register is the shortest one that is not repeated
    within the time.
    """
    if options.zigzag is not None:
        yield Helm(options.zigzag)
    if options.amplitude is not None:
        hold = options.hold or usual.length / (usual.speed_kn * KNOT)
        wanted = options.seconds / hold
        long = (bits for bits in REGISTER_TAPS if 2**bits - 1 >= wanted)
        bits = options.bits or next(long, max(REGISTER_TAPS))
        prbs(bits, options.seed)
        yield Helm(None, options.amplitude, hold, bits, options.seed)


def sensors_of(ship: ShipFile, asked: Sensors, given: Collection[str]) -> Sensors:
    """Return the instruments: as ``asked`` if ``given``, or if the file has none."""
    sensors = ship.sensors or Sensors()
    sensor_keys = [key for key, name in SENSOR_CHANNELS.items() if name not in given]
    of_file = {key: value for key in sensor_keys if (value := getattr(sensors, key)) is not None}
    return replace(asked, **of_file)


def _check(ship: ShipFile, legs: Sequence[ShipLeg], options: TrialOptions) -> None:
    """Check what is asked for; ConfigError with the limit."""
    most = ship.dimensions.rudder_limit_deg
    for leg in legs:
        if leg.helm.angle_deg > most:
            option = "zigzag" if leg.helm.zigzag_deg else "amplitude"
            raise ConfigError(
                f"--{option}: the rudder goes to {most:g} deg, not {leg.helm.angle_deg:g}"
            )
    if len(legs) > MAX_LEGS:
        raise ConfigError(f"--speed: {len(legs)} trials: a page has room for {MAX_LEGS}")
    read = options.read
    if "sway" not in read or not {"yaw_rate", "heading"} & set(read):
        raise ConfigError("--output: such a ship is told by sway with yaw_rate or heading")


def _flights(ship: ShipFile, legs: Sequence[ShipLeg], options: TrialOptions) -> tuple[Flight, ...]:
    """Return the flights of a plan, which share its seconds. ConfigError if one is lost."""
    leg_time = options.seconds / len(legs)
    flown = []
    for leg in legs:
        vessel = TrialShip(ship, leg.held_kn * KNOT)
        flight = fly_manoeuvre(vessel, leg.helm.manoeuvre(leg_time), leg.speed_kn * KNOT)
        if flight.lost:
            raise ConfigError(f"{ship.path.name}: {leg}: {flight.lost}")
        flown.append(flight)
    return tuple(flown)


def flown_trial(flight: Flight, every: int, read: Sequence[str]) -> Record:
    """Return a flight as a record without errors; ConfigError if it is too short."""
    t = flight.t[::every]
    if len(t) < MIN_TRIAL_SAMPLES:
        raise ConfigError(
            f"--seconds: {len(t)} samples of a trial; needs {MIN_TRIAL_SAMPLES} or more"
        )
    columns = {"speed": "u", "rudder": "delta_r", "revolutions": "n"}
    columns |= {channel: TRAINER_COLUMNS[channel] for channel in read}
    columns |= {"roll": "phi"} if flight.has("phi") else {}
    numbers: dict[str, Any] = {
        channel: flight.column(name)[::every] for channel, name in columns.items()
    }
    source, rows = flight.series.path.name, np.arange(len(t))
    return Record(source=source, t=t, rows=rows, names={}, between_readings="straight", **numbers)


def _expected(
    ship: ShipFile, flights: Sequence[Flight], every: int, options: TrialOptions
) -> ShipFit:
    """Return what is expected of fitting the records of these flights together."""
    if ship.result is None:
        raise ConfigError(f"{ship.path.name}: lacks [result]")
    trials = [flown_trial(flight, every, options.read) for flight in flights]
    model = model_for(ship, ship.result.model, wind=False)
    prior, _ = prior_of(model, ship)
    problem = problem_of(model, np.array(ship.constants), trials, prior, options.prior_strength)
    noise, axes = _noise(ship, ship.result.speed_kn * KNOT, options), len(model.driven)
    noise[axes:] = np.maximum(noise[axes:], problem.least)  # as a fit would have them
    states = STATE_NAMES[: model.states]
    firsts = [[flight.column(name)[0] for name in states] for flight in flights]
    coefficients = [ship.coefficients[name] for name in model.free]
    return expect_fit(problem, np.concatenate([coefficients, np.log(noise), *firsts]))


def _noise(ship: ShipFile, speed: float, options: TrialOptions) -> Numbers:
    """Return the disturbances and the errors of readings.

    The disturbance of yaw is such that it makes the unrest within the time of a ship length. Those
    of surge and sway are of a force at a quarter of the length, which is also the radius of
    gyration. Roll has the disturbance of yaw, and is read as well as heading.
    """
    length = ship.dimensions.length_m
    turning = max(math.radians(options.unrest) / math.sqrt(length / speed), MIN_DISTURBANCE)
    aside = YAW_GYRATION_LENGTHS * length * turning
    errors = [options.sensors.error(name) for name in ("sway", "sway", "yaw_rate", "heading")]
    rolls = ([turning], errors[2:]) if ship.roll is not None else ([], [])
    return np.array([aside, aside, turning, *rolls[0], *errors, *rolls[1]])


def _plan(
    name: str, legs: tuple[ShipLeg, ...], flights: Sequence[Flight], expected: ShipFit
) -> ShipTrialPlan:
    """Return the plan with what is expected of it."""
    coefficients = coefficients_of(expected)[: len(expected.problem.model.free)]
    speeds = np.concatenate([flight.column("u") for flight in flights]) / KNOT
    return ShipTrialPlan(
        name=name,
        legs=legs,
        seconds=float(flights[0].t[-1]),
        samples=sum(len(trial.t) for trial in expected.problem.trials),
        executes=sum(len(flight.marks) for flight in flights),
        slowest_kn=float(speeds.min()),
        fastest_kn=float(speeds.max()),
        coefficients=coefficients,
        from_book=tuple(one.name for one in coefficients if one.prior_share > BOOK_PRIOR_SHARE),
        untold=find_unknown(expected),
    )


def _remarks(plans: Sequence[ShipTrialPlan]) -> Iterator[str]:
    """Yield which plan tells which coefficients best, and where a trial hardly turned."""
    for plan in plans:
        if plan.executes < 3 * len(plan.legs):
            yield f"{plan.name}: {plan.executes} executes are few: give it more --seconds"
    best: dict[str, list[str]] = {}
    for i, one in enumerate(plans[0].coefficients if len(plans) > 1 else ()):
        sizes = sorted((plan.coefficients[i].deviation, plan.name) for plan in plans)
        if sizes[0][0] < BETTER_PLAN_RATIO * sizes[1][0]:
            best.setdefault(sizes[0][1], []).append(one.name)
    for name, better_names in sorted(best.items()):
        yield f"{name} tells {', '.join(better_names)} better than the others"


def render(report: TrialReport) -> str:
    """Return the report as text."""
    helms = "; ".join(map(str, report.helms))
    lines = [
        f"TRIALS OF A SHIP, model {report.model}",
        f"{INDENT}{cut_text(report.ship, 60)}, {report.length_m:g} m",
        *wrap(
            f"{helms}; {report.seconds:g} s in all, samples every "
            f"{report.interval_s:g} s of {', '.join(report.outputs)}"
        ),
        *wrap(f"prior: {report.prior}, widths times {report.prior_strength:g}"),
        "",
    ]
    for plan in report.plans:
        legs = "; ".join(map(str, plan.legs))
        lines += wrap(
            f"{plan.name}  {legs}: {plan.seconds:g} s each, {plan.executes} executes, "
            f"{plan.slowest_kn:.1f} to {plan.fastest_kn:.1f} kn, {plan.samples} samples"
        )
    rows = [
        (
            one.name,
            f"{one.value:.4g}",
            *(
                f"{x.deviation:.2g} {100.0 * min(x.prior_share, 1.0):3.0f}%"
                for x in (plan.coefficients[i] for plan in report.plans)
            ),
        )
        for i, one in enumerate(report.plans[0].coefficients)
    ]
    heads = [f"{plan.name}: std dev\nprior's share" for plan in report.plans]
    lines += ["", *table(("coefficient", "value", *heads), rows)]
    for plan in report.plans:
        lines += ["", f"{INDENT}What {plan.name} will not tell"]
        lines += items(map(in_words, plan.untold[:MAX_COMBINATIONS_SHOWN]))
        if plan.from_book:
            lines += wrap(f"- {', '.join(plan.from_book)}: from the book (its share above 90 %)")
        elif not plan.untold:
            lines += wrap("- nothing: each coefficient is told by itself")
    lines += ["", *items(report.remarks)]
    return "\n".join(lines).rstrip()


def panels(found: TrialDesign) -> tuple[Panel, ...]:
    """Return rudder, heading and speed of each leg."""
    drawn = []
    both = zip(found.report.plans, found.flights, strict=True)
    shown = [(str(plan.legs[0]), flights[0]) for plan, flights in both if len(plan.legs) == 1]
    for title, unit, name, factor in (
        ("rudder, positive to port", "[deg]", "delta_r", 180.0 / math.pi),
        ("heading", "[deg]", "psi", 180.0 / math.pi),
        ("speed", "[kn]", "u", 1.0 / KNOT),
    ):
        curves = (Curve(leg, flight.t, factor * flight.column(name)) for leg, flight in shown)
        drawn.append(Panel(title, "time [s]", unit, tuple(curves)))
    return tuple(drawn)
