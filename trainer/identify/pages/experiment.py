"""``trainer ship prbs`` for a boat: a rudder experiment, flown in a calm and drawn.

It says before the trial what a fit to the experiment's record would tell, and writes the exercise
that flies it. The inverse of the expected information is the smallest covariance that any estimate
can have (Cramer and Rao), and maximum likelihood reaches it in long records; so no record need be
simulated. ``ships/trials`` does the same for ships that are not linear.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.ship.sensors import Sensors
from trainer.core.kernel import Numbers
from trainer.identify.experiment import (
    LEAD_TIME_S,
    BinarySequence,
    HelmOptions,
    exercise_text,
    fly_trial,
    measure_zigzag,
    remarks,
    schedule_orders,
    suggest_bits,
    suggest_hold,
    suggest_interval,
    zigzag_flight,
    zigzag_orders,
)
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.problem import problem_of
from trainer.identify.fitting.study_problem import ERROR_NAMES, INITIAL_STATE_NAMES, free_names
from trainer.identify.judge.uncertainty import propagate_covariance, uncertainty
from trainer.identify.model.derived import QUANTITY_UNITS, quantities, quantity_units
from trainer.identify.model.models import MODELS, OUTPUT_UNITS, Plant, Ship
from trainer.identify.model.nomoto import Nomoto, SteeringModel, find_steering
from trainer.identify.record.measurements import Record, samples_of
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap
from trainer.units import KNOT

MAX_SPREAD: Final = 100.0  # times a parameter's size: known no better, it is not known at all
SEA_LEVER_LENGTHS: Final = 0.25  # [-] of the length: at which the sea's force makes its moment
HIDDEN_IF_ZERO: Final = ("T_imag",)  # shown with T1 if it is not zero


@dataclass(frozen=True)
class Prospect:
    """Expected values and standard deviations of a record, by name, in SI and prime.

    They are of Model 1 where sway is read. Without sway only rudder to yaw can be determined.
    """

    model: str
    samples: int
    interval_s: float
    values: dict[str, float]
    deviations: dict[str, float]


def prospect(
    steering: SteeringModel,
    record: Record,
    outputs: tuple[str, ...],
    sensors: Sensors,
    unrest: float,
) -> Prospect:
    """Return what would be known from such a record of such a ship.

    ``unrest`` [deg/s] is the rms yaw rate that the sea alone makes. ConfigError if the record
    cannot separate the parameters.
    """
    kind = "1" if "sway" in outputs else "nomoto2"
    model = MODELS[kind]
    plant = Plant(model, Ship(steering.length, steering.speed), outputs, record.interval)
    errors = {
        name: (sensors.error(channel) * OUTPUT_UNITS[channel][1]) ** 2
        for channel, name in ERROR_NAMES[kind].items()
    }
    values = model.vector(**_ship(steering, kind), **errors)
    for name, channel in INITIAL_STATE_NAMES[kind]:
        if channel:
            values[model.index(name)] = float(record.column(channel)[0]) * OUTPUT_UNITS[channel][1]
    # the ratio of the densities of disturbance; their size follows from the unrest
    sea = {"R1_N": 1.0, "R1_Y": SEA_LEVER_LENGTHS**-2}
    if kind != "1":  # the moment acts on yaw at once and, through sway, by the rate 1/T3
        sea = {"R1_2": 1.0, "R1_1": steering.nomoto.T3**-2}
    indices = [model.index(name) for name in sea]
    values[indices] = list(sea.values())
    density = _density(plant, values, math.radians(unrest))
    values[indices] *= density
    free = [name for name in free_names(plant, ()) if name not in sea or density > 0.0]
    problem = problem_of(plant, samples_of(record, outputs), values, free)
    known = uncertainty(problem.names, Likelihood(problem).information(problem.start))
    spread = np.sqrt(np.diag(known.covariance)) / np.maximum(np.abs(problem.start), 1.0)
    vague = [(name,) for name, one in zip(problem.names, spread, strict=True) if one > MAX_SPREAD]
    if lost := known.flat or vague:
        groups_text = "; ".join(" with ".join(group) for group in lost)
        raise ConfigError(f"such a record cannot separate {groups_text}")
    expected_spread = propagate_covariance(
        lambda theta: quantities(plant, problem.whole(theta)), problem.start, known.covariance
    )
    names = quantity_units(model)
    return Prospect(
        model=kind,
        samples=len(record.t),
        interval_s=record.interval,
        values=dict(zip(names, map(float, expected_spread.values), strict=True)),
        deviations=dict(zip(names, map(float, expected_spread.deviations), strict=True)),
    )


def _ship(steering: SteeringModel, kind: str) -> dict[str, float]:
    """Return the model's parameters of the ship.

    ConfigError if it has a pair of complex roots, and so no T1 and T2.
    """
    if kind == "1":
        return steering.prime
    form = steering.nomoto
    if form.T1.imag:
        raise ConfigError("sway and yaw swing together: rudder to yaw alone has no T1 and T2")
    return {"K": form.K, "T1": form.T1.real, "T2": form.T2.real, "T3": form.T3}


def _density(plant: Plant, values: Numbers, rate: float) -> float:
    """Return by what to multiply the densities for a yaw rate of ``rate`` [rad/s] rms.

    The sea alone makes that yaw rate. Its variance is linear in the densities, by Lyapunov's
    equation for the states without heading.
    """
    from scipy.linalg import solve_continuous_lyapunov  # noqa: PLC0415

    if rate == 0.0:
        return 0.0
    blocks = plant.blocks(values[None])
    A, noise = blocks.drift[0, :2, :2], blocks.noise[0, :2, :2]
    if np.linalg.eigvals(A).real.max() >= 0.0:
        raise ConfigError("an unstable ship has no unrest of a size; say --unrest 0")
    return float(rate**2 / solve_continuous_lyapunov(A, -noise)[1, 1])


@dataclass(frozen=True, kw_only=True)
class ExperimentReport:
    """All that ``trainer ship prbs`` says about an experiment."""

    vessel: str
    speed_kn: float
    kind: str  # "prbs" or "zigzag"
    settings: dict[str, Any]
    seconds: float
    orders: tuple[tuple[float, str], ...]
    largest_heading_deg: float  # in a calm
    largest_rate_deg_s: float
    lowest_speed_kn: float
    reach_s: float | None = None  # of a zig-zag
    period_s: float | None = None
    overshoots_deg: tuple[float, ...] = ()
    remarks: tuple[str, ...]
    outputs: tuple[str, ...]
    prospect: Prospect


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions(HelmOptions):
    """A user's wishes for an experiment; None is what suits the boat."""

    vessel: str  # its name or path, for the exercise
    speed_kn: float | None = None
    depth: float | None = None  # [m]
    amplitude: float = 5.0  # [deg]
    periods: int = 1
    by: str = "rudder"
    sea: str | None = None


@dataclass(frozen=True)
class ExperimentDesign:
    """A report, the boat's record in a calm, and the exercise that makes it."""

    report: ExperimentReport
    record: Record
    exercise: str


def design_experiment(file: VesselFile, options: ExperimentOptions) -> ExperimentDesign:
    """Return the experiment that is asked for.

    ConfigError if the boat cannot fly it, or a record of it would not determine the ship.
    """
    speed_kn = options.speed_kn or file.run.start_speed_kn
    speed, step = speed_kn * KNOT, file.run.step_s
    ship = find_steering(file, speed)
    interval = options.interval or suggest_interval(ship.nomoto, step)
    depth = options.depth or file.run.start_depth_m
    if options.zigzag:
        kind, orders, seconds, report_fields = _zigzag(file, speed, options.zigzag, options.seconds)
    else:
        rate = file.surfaces.rate_deg_s
        kind, orders, seconds, report_fields = _sequence(ship.nomoto, interval, rate, options)
    flight = fly_trial(file, schedule_orders(orders), speed, depth, seconds)
    record = flight.every(max(1, round(interval / step)))
    outputs = options.outputs or ("sway", "yaw_rate", "heading")
    conditions: dict[str, str | float] = {"vessel": options.vessel, "speed_kn": speed_kn}
    conditions |= {"depth_m": depth, "duration_s": seconds}
    conditions |= {"sea": options.sea} if options.sea else {}
    exercise = exercise_text(orders, f"{kind} for identification at {speed_kn:g} kn", conditions)
    report = ExperimentReport(
        vessel=file.name,
        speed_kn=speed_kn,
        kind=kind,
        seconds=seconds,
        orders=orders,
        largest_heading_deg=_largest(flight.heading),
        largest_rate_deg_s=_largest(flight.yaw_rate),
        lowest_speed_kn=float(np.min(flight.column("speed"))) / KNOT,
        outputs=outputs,
        prospect=prospect(ship, record, outputs, options.sensors, options.unrest),
        **report_fields,
    )
    return ExperimentDesign(report, flight, exercise)


def _largest(values: Any) -> float:
    """Return the largest angle [deg] of values [rad]."""
    return math.degrees(float(np.max(np.abs(values))))


def _sequence(ship: Nomoto, interval: float, rate: float, options: ExperimentOptions) -> Any:
    """Return kind, orders, duration [s] and further fields of the report, of a sequence."""
    hold = options.hold or suggest_hold(ship, interval)
    sequence = BinarySequence(
        bits=options.bits or suggest_bits(ship, hold),
        amplitude_deg=options.amplitude,
        hold_s=hold,
        periods=options.periods,
        by=options.by,
        seed=options.seed,
    )
    warned = tuple(remarks(sequence, ship, interval, rate))
    report_fields = {"settings": asdict(sequence), "remarks": warned}
    return "PRBS", sequence.orders(), sequence.seconds, report_fields


def _zigzag(file: VesselFile, speed: float, angles: tuple[float, float], most: float) -> Any:
    """Return the same four of a zig-zag at ``speed`` [m/s] that lasts ``most`` [s] at most."""
    helm, execute = angles
    flight = zigzag_flight(file, speed, angles, most)
    orders = zigzag_orders(flight, helm)
    report_fields = {
        "settings": {"helm_deg": helm, "execute_deg": execute},
        "remarks": (f"the ship reaches {execute:g} deg only in a calm at just these times",),
        **measure_zigzag(flight, execute),
    }
    return "zig-zag", orders, orders[-1][0] + LEAD_TIME_S, report_fields


def render(report: ExperimentReport) -> str:
    """Return the report as text."""
    settings = ", ".join(
        f"{name} {value}" if isinstance(value, str) else f"{name} {value:g}"
        for name, value in report.settings.items()
    )
    turns, slows = report.largest_rate_deg_s, report.lowest_speed_kn
    pace = f"turns at {turns:.2f} deg/s and slows to {slows:.1f}"
    lines = [
        f"RUDDER EXPERIMENT: {report.kind}",
        f"{INDENT}{cut_text(report.vessel, 70)}, {report.speed_kn:g} kn",
        *wrap(settings, INDENT, INDENT),
        f"{INDENT}{report.seconds:g} s, {len(report.orders)} orders",
        "",
        f"{INDENT}In a calm the ship swings {report.largest_heading_deg:.0f} deg, {pace} kn.",
    ]
    if report.overshoots_deg:
        overshoots = ", ".join(f"{one:.1f}" for one in report.overshoots_deg)
        lines.append(
            f"{INDENT}Reach {format_number(report.reach_s, '.1f')} s, period "
            f"{format_number(report.period_s, '.1f')} s, overshoots {overshoots} deg."
        )
    expected = report.prospect
    head = f"{INDENT}Expected from {expected.samples} samples at {expected.interval_s:g} s of "
    lines += ["", f"{head}{', '.join(report.outputs)}:", ""]
    rows = [
        (
            name,
            QUANTITY_UNITS.get(name, "prime"),
            f"{value:.5g}",
            f"{expected.deviations[name]:.2g}",
            f"{100.0 * expected.deviations[name] / abs(value):.1f}" if value else "-",
        )
        for name, value in expected.values.items()
        if name not in HIDDEN_IF_ZERO and (value or expected.deviations[name])
    ]
    lines += table(("quantity", "unit", "value", "std dev", "%"), rows)
    if report.remarks:
        lines += ["", *items(report.remarks)]
    return "\n".join(lines)


def panels(design_: ExperimentDesign) -> tuple[Panel, ...]:
    """Return rudder, heading and yaw rate of the experiment in a calm."""
    record = design_.record
    t = record.t

    def panel(title: str, unit: str, channel: str) -> Panel:
        curve = Curve(channel, t, np.degrees(record.column(channel)))
        return Panel(title, "time [s]", unit, (curve,), levels=(0.0,))

    return (
        panel("rudder, positive to port", "[deg]", "rudder"),
        panel("heading in a calm", "[deg]", "heading"),
        panel("yaw rate in a calm", "[deg/s]", "yaw_rate"),
    )
