"""``trainer ship prbs`` for a boat: a rudder experiment, flown in a calm and drawn.

It says what a fit to the experiment's record would tell (``judge/design``), and writes the exercise
that flies it. ``ships/trials`` does the same for ships that are not linear.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from trainer.config.vessel import VesselFile
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
from trainer.identify.judge.design import Prospect, prospect
from trainer.identify.model.derived import QUANTITY_UNITS
from trainer.identify.model.nomoto import Nomoto
from trainer.identify.model.steering import find_steering
from trainer.identify.record.measurements import Record
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, format_number, items, table, wrap
from trainer.units import KNOT

HIDDEN_IF_ZERO: Final = ("T_imag",)  # shown with T1 if it is not zero


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
        kind, orders, seconds, report_fields = _sequence(ship.nomoto, interval, options)
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


def _sequence(ship: Nomoto, interval: float, options: ExperimentOptions) -> Any:
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
    warned = tuple(remarks(sequence, ship, interval))
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
