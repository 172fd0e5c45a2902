"""``trainer ship steering``: gains, lever arms, steady turns and the loop of a ship's file.

The spiral is the steady yaw rate over the rudder angle. Where a ship is unstable on its course the
curve is an S, and the ship jumps between its ends: the loop. Beside a recorded manoeuvre stand its
gains and time constants by the methods from before likelihoods, sections 2.3 (a turn) and 2.8 (a
zig-zag) of the report of 1974; all in SI and rad, the rudder to port.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, nearest, parse_toml, quote, read_text
from trainer.config.ship.derivatives import DERIVATIVES_SCHEMA, load_derivatives
from trainer.config.ship.nomoto import NOMOTO_SCHEMA, load_nomoto
from trainer.core.kernel import Numbers
from trainer.identify.fitting.nonlinear import BentShip
from trainer.identify.model.nomoto import (
    Nomoto,
    SteeringModel,
    find_steering,
    tabled_steering,
    time_constants,
)
from trainer.identify.record.measurements import Record
from trainer.identify.record.study import load_study, observe_record, plain_study
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, format_number, table, wrap
from trainer.units import DEGREE, KNOT

STEADY_SHARE: Final = 0.1  # [-] of a turn, its end, in which it is steady
THROWN_SHARE: Final = 0.5  # [-] of the largest rudder: from there on it has been thrown
MIN_TURNING_POINTS, MIN_SAMPLES, MIN_HALF_WINDOW = 3, 20, 4  # [-], [samples], [samples]
SHOWN_HELMS_DEG: Final = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # [deg] of the table of steady turns
CURVE_POINTS: Final = 201  # points
NUMBER_UNITS: Final = {"K": "1/s", "T1": "s", "T2": "s", "T3": "s", "K_v": "m/s", "T3v": "s"}
NOMOTO_METHOD, PHASE_PLOT = "Nomoto's", "phase plot"
SMOOTHING_TIME: Final = 0.3  # [lengths at speed] of the phase plot's window, as of trials
LEVER_NAMES: Final = ("l_v", "l_r", "N_delta/Y_delta", "l_r - l_v")  # as a fit calls them


def is_zigzag(record: Record) -> bool:
    """Return whether the rudder was thrown to both sides."""
    rudder = record.column("rudder")
    thrown = THROWN_SHARE * np.nanmax(np.abs(rudder))
    return bool(np.nanmax(rudder) >= thrown and np.nanmin(rudder) <= -thrown)


def measure_zigzag(record: Record) -> tuple[float, float]:
    """Return K [1/s] and T [s] of a zig-zag by Nomoto's method.

    T r' + r = K (delta + delta_0) is integrated. Between turning points of the heading r is zero at
    both ends, so that K and delta_0 are left; from there to a zero of the heading T is. ConfigError
    if it is too short.
    """
    t, rudder, rate, heading = _columns(record)
    helm, heading = _integral(t, rudder), heading - heading[0]
    begin = t[np.argmax(np.abs(rudder) >= THROWN_SHARE * np.abs(rudder).max())]
    tops, zeros = (each[each > begin] for each in (_crossings(t, rate), _crossings(t, heading)))
    if len(tops) < MIN_TURNING_POINTS:
        raise ConfigError(
            f"{record.source}: the heading turns {len(tops)} times: Nomoto's method needs "
            f"{MIN_TURNING_POINTS} turning points: sail the zig-zag for longer"
        )
    helms, headings = (np.interp(tops, t, values) for values in (helm, heading))
    sums = np.column_stack([np.diff(helms), np.diff(tops)])
    K, drift = np.linalg.lstsq(sums, np.diff(headings), rcond=None)[0]
    zeros = zeros[zeros > tops[0]]
    helm_since, turned = np.interp(zeros, t, helm) - helms[0], np.interp(zeros, t, heading)
    lacking = K * helm_since + drift * (zeros - tops[0]) - (turned - headings[0])
    rates = np.interp(zeros, t, rate)
    return float(K), float(lacking @ rates / (rates @ rates))


def read_phase_plot(record: Record, ship: BentShip, window: float) -> tuple[complex, ...]:
    """Return T1, T2, T3 [s] from a zig-zag's phase plot, r' over r (Bech, Smitt).

    What the steady turns of ``ship`` leave is (T1 + T2) r' + T1 T2 r'' - K T3 delta'. r'' is r'
    times the plot's slope. All are smoothed alike over ``window`` [s]: a throw breaks no term.
    """
    t, rudder, rate, _ = _columns(record)
    even = np.arange(t[0], t[-1], record.interval)
    rudder, rate = np.interp(even, t, rudder), np.interp(even, t, rate)
    count = max(round(0.5 * window / record.interval), MIN_HALF_WINDOW)
    weights = (1.0 - np.linspace(-1.0, 1.0, 2 * count + 1) ** 2) ** 3
    left = ship.K * (rudder - ship.helm(rate))
    left, helm, rate = (
        np.convolve(values, weights / weights.sum(), "valid") for values in (left, rudder, rate)
    )
    turning, thrown = (np.gradient(values, record.interval) for values in (rate, helm))
    bending = np.gradient(turning, record.interval)
    terms = np.column_stack([turning, bending, -ship.K * thrown, np.ones_like(left)])
    inner = slice(2, -2)  # at the ends differences are to one side
    (total, product, T3, _), *_ = np.linalg.lstsq(terms[inner], left[inner], rcond=None)
    return (*time_constants(total / product, 1.0 / product), complex(T3))


def measure_turn(record: Record, speed: float) -> tuple[float, ...]:
    """Return the effective K [1/s] and T [s] of a turn, twice.

    They are of its time, then of its distance as if run at ``speed`` [m/s]. K is the steady rate
    over the rudder, T by how much the heading lags behind K times the rudder.
    """
    sailed = np.full_like(record.t, speed)
    if record.speed is not None:
        sailed = np.hypot(record.speed, 0.0 if record.sway is None else record.sway)
    t, rudder, rate, _, sailed = _columns(record, sailed)
    steady = t >= t[-1] - STEADY_SHARE * (t[-1] - t[0])
    found = list[float]()
    for clock, turning in ((t, rate), (_integral(t, sailed) / speed, rate * speed / sailed)):
        last_rudder, last_rate = rudder[steady].mean(), turning[steady].mean()
        lag = _integral(clock, rudder / last_rudder - turning / last_rate)[-1]
        found += [float(last_rate / last_rudder), float(lag)]
    return tuple(found)


def _columns(record: Record, *further: Numbers) -> tuple[Numbers, ...]:
    """Return time, rudder, yaw rate, heading and others of the samples that have all of them."""
    names = ("rudder", "turning", "heading")
    columns = np.array([record.t, *(record.column(name) for name in names), *further])
    whole = columns[:, ~np.isnan(columns).any(axis=0)]
    if whole.shape[1] < MIN_SAMPLES or not whole[1].any():
        needs = "rows with rudder, yaw rate and heading, and a rudder that moves"
        raise ConfigError(f"{record.source}: the old methods need {MIN_SAMPLES} {needs}")
    return tuple(whole)


def _integral(t: Numbers, values: Numbers) -> Numbers:
    """Return the integral from the first sample to each, by trapezoids (n,)."""
    return np.append(0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t)))


def _crossings(t: Numbers, values: Numbers) -> Numbers:
    """Return the times at which values go through zero."""
    at = np.flatnonzero((values[:-1] < 0.0) != (values[1:] < 0.0))
    return np.asarray(t[at] - values[at] * (t[at + 1] - t[at]) / (values[at + 1] - values[at]))


@dataclass(frozen=True)
class SteeringAtSpeed:
    """How the ship steers at one speed, SI.

    T_imag is the imaginary part where T1 and T2 are a complex pair.
    """

    speed_kn: float
    numbers: dict[str, float]  # by NUMBER_UNITS, and T_imag
    levers_m: dict[str, float] | None  # of a vessel file or a table of derivatives
    helm: tuple[float, float, float]  # [s, s^2, s^3] H(r) of steady turns: 1/K, -kappa, 0
    neutral_deg: float  # residual helm
    stable: bool
    turns_deg_s: tuple[tuple[float, ...], ...]  # by SHOWN_HELMS_DEG, all rates that are steady
    # of an unstable ship's spiral, to either side (2.12): the rate [deg/s] at zero helm, and rate
    # [deg/s] and helm [deg] where the ship goes over to the other side
    loop: tuple[float, ...] | None


@dataclass(frozen=True)
class ClassicalFigure:
    """A number of a recorded manoeuvre by an old method, SI, beside the ship's."""

    method: str
    name: str
    ship: float
    value: float
    prime: float  # of a turn by its own speed, else by the ship's


@dataclass(frozen=True)
class SteeringReport:
    """All that ``trainer ship steering`` says about a ship."""

    ship: str
    length_m: float
    helms_deg: tuple[float, ...]
    speeds: tuple[SteeringAtSpeed, ...]
    recorded: tuple[ClassicalFigure, ...] = ()


def of_vessel(file: VesselFile, speeds_kn: Sequence[float]) -> SteeringReport:
    """Return how a boat steers at ``speeds_kn``, by its vessel file; roll is left out."""
    rows = tuple(_linear(knots, find_steering(file, knots * KNOT)) for knots in speeds_kn)
    return SteeringReport(file.name, file.hull.length, SHOWN_HELMS_DEG, rows)


def _linear(knots: float, ship: SteeringModel) -> SteeringAtSpeed:
    """Return how a ship without a bend steers."""
    return _at_speed(knots, ship.nomoto, BentShip(ship.nomoto.K, 0.0, 0.0, 0.0), ship.levers)


def of_ship(path: Path) -> SteeringReport | None:
    """Return how the ship of a Nomoto file or of a table of derivatives steers.

    None of a vessel file; ConfigError for a file that is none of the three.
    """
    table = parse_toml(read_text(path), path.name)
    schema = str(table.get("schema", ""))
    readers = {NOMOTO_SCHEMA: of_nomoto, DERIVATIVES_SCHEMA: of_derivatives}
    if schema in readers:
        return readers[schema](path)
    if "coefficients" in table:
        return None
    raise ConfigError(
        f"{path.name}: is no vessel file, as it has no [coefficients]; of a ship schema = "
        f"{quote(schema)} must be {' or '.join(map(quote, readers))}{nearest(schema, readers)}"
    )


def of_derivatives(path: Path) -> SteeringReport:
    """Return how the ship of a table of derivatives steers, linear."""
    ship = load_derivatives(path)
    steering = tabled_steering(ship)
    if not steering.nomoto.K:
        raise ConfigError(f"{path.name}: Y_delta and N_delta turn the ship to neither side")
    row = _linear(ship.speed_kn, steering)
    return SteeringReport(ship.name, ship.length_m, SHOWN_HELMS_DEG, (row,))


def of_nomoto(path: Path) -> SteeringReport:
    """Return how a Nomoto ship steers, with kappa or Bech's H(r)."""
    ship = load_nomoto(path)
    T1, T2 = complex(ship.T1_s), complex(ship.T2_s)
    form = Nomoto(ship.K_per_s, T1, T2, ship.T3_s, ship.K_v_m_s or 0.0, ship.T3v_s or 0.0)
    H = None if ship.H1_s is None else (ship.H1_s, ship.H2_s2 or 0.0, ship.H3_s3 or 0.0)
    neutral = (ship.neutral_deg or 0.0) * DEGREE
    bent = BentShip(ship.K_per_s, 0.0, 0.0, 0.0, ship.kappa_s2 or 0.0, neutral, H)
    return SteeringReport(
        ship.name, ship.length_m, SHOWN_HELMS_DEG, (_at_speed(ship.speed_kn, form, bent),)
    )


def with_record(report: SteeringReport, path: Path) -> SteeringReport:
    """Return the report with what the old methods read off a recorded zig-zag or turn."""
    study = load_study(path) if path.suffix == ".toml" else plain_study(path)
    record, one = observe_record(study), report.speeds[0]
    V, L = one.speed_kn * KNOT, report.length_m
    K, T1, T2, T3 = (one.numbers[name] for name in ("K", "T1", "T2", "T3"))
    own = one.numbers | {"T": T1 + T2 - T3}
    if is_zigzag(record):
        bent = BentShip(K, T1, T2, T3, delta_0=one.neutral_deg * DEGREE, H=one.helm)
        constants = read_phase_plot(record, bent, SMOOTHING_TIME * L / V)
        by_nomoto = zip("KT", measure_zigzag(record), strict=True)
        found = [(NOMOTO_METHOD, name, value, value) for name, value in by_nomoto]
        reals = {f"T{i}": value.real for i, value in enumerate(constants, 1)}
        reals["T_imag"] = constants[0].imag  # of T1 and, with the other sign, T2
        found += [(PHASE_PLOT, *pair, pair[1]) for pair in reals.items() if pair[1]]
    else:
        gain, lag, *at_speed = measure_turn(record, V)
        found = [("effective", "K", gain, at_speed[0]), ("effective", "T", lag, at_speed[1])]
    figures = (
        ClassicalFigure(method, name, own[name], value, at_V * (L / V if name == "K" else V / L))
        for method, name, value, at_V in found
    )
    return replace(report, recorded=tuple(figures))


def _at_speed(
    knots: float, form: Nomoto, bent: BentShip, arms: tuple[float, ...] | None = None
) -> SteeringAtSpeed:
    """Return how a ship of these numbers steers."""
    numbers = [form.K, form.T1.real, form.T2.real, form.T3, form.K_v, form.T3v]
    return SteeringAtSpeed(
        speed_kn=knots,
        numbers=dict(zip(NUMBER_UNITS, map(float, numbers), strict=True))
        | {"T_imag": form.T1.imag},
        levers_m=None if arms is None else dict(zip(LEVER_NAMES, arms, strict=True)),
        helm=bent.curve,
        neutral_deg=bent.delta_0 / DEGREE,
        stable=form.T1.real > 0.0,
        turns_deg_s=tuple(
            tuple(rate / DEGREE for rate in bent.rates(helm * DEGREE)) for helm in SHOWN_HELMS_DEG
        ),
        loop=bent.loop and tuple(one / DEGREE for one in bent.loop),
    )


def render(report: SteeringReport) -> str:
    """Return the report as text."""
    lines = [
        f"{cut_text(report.ship, 60)}: steering",
        f"{INDENT}{report.length_m:g} m; a positive rudder turns to port: K < 0 of a stable ship",
    ]
    for one in report.speeds:
        word = "stable" if one.stable else "NOT STABLE"
        margin = f", l_r - l_v = {one.levers_m['l_r - l_v']:.4g} m" if one.levers_m else ""
        lines += ["", f"{one.speed_kn:.4g} kn: straight course {word}{margin}"]
        lines += _numbers(report, one)
        rows = [
            (f"{helm:g}", "  ".join(f"{rate:+.4f}" for rate in rates))
            for helm, rates in zip(report.helms_deg, one.turns_deg_s, strict=True)
        ]
        lines += ["", *table(("rudder\n[deg]", "steady yaw rates\n[deg/s]"), rows)]
        if one.loop is not None:
            rate, fold_rate, fold = map(format_number, one.loop)
            lines += wrap(
                f"- the spiral has a loop (2.12): amidships the ship turns at {rate} deg/s to "
                f"either side; it goes over to the other beyond {fold} deg of opposite rudder, "
                f"from {fold_rate} deg/s"
            )
    if report.recorded:
        found = [
            (one.name, one.method, *(f"{n:.4g}" for n in (one.ship, one.value, one.prime)))
            for one in report.recorded
        ]
        heads = ("SI", "method", "ship's", "record's", "prime")
        lines += ["", "of the record, beside the ship's", *table(heads, found)]
    return "\n".join(lines)


def _numbers(report: SteeringReport, one: SteeringAtSpeed) -> list[str]:
    """Return gains, time constants and lever arms, SI and in lengths and speeds of the ship."""
    V, L = one.speed_kn * KNOT, report.length_m
    sizes = {"1/s": V / L, "s": L / V, "m/s": V, "m": L}
    numbers = [(name, unit, one.numbers[name]) for name, unit in NUMBER_UNITS.items()]
    if one.numbers["T_imag"]:
        numbers.insert(3, ("T_imag", "s", one.numbers["T_imag"]))
    numbers += [(name, "m", value) for name, value in (one.levers_m or {}).items()]
    rows = [
        (name, unit, f"{value:.5g}", f"{value / sizes[unit]:.4g}")
        for name, unit, value in numbers
        if value
    ]
    for power, value in enumerate(one.helm, 1):
        if any(one.helm[1:]):
            unit = "s" if power == 1 else f"s^{power}"
            rows.append((f"H{power}", unit, f"{value:.5g}", f"{value * (V / L) ** power:.4g}"))
    return table(("", "unit", "value", "prime"), rows)


def panels(report: SteeringReport) -> tuple[Panel, ...]:
    """Return yaw rate over rudder in steady turns, the loop with its inner branch."""
    curves = []
    for one in report.speeds:  # the rudder (12.1) over all rates that up to the largest helm makes
        bent = BentShip(math.nan, 0.0, 0.0, 0.0, delta_0=one.neutral_deg * DEGREE, H=one.helm)
        most = max(abs(rate) for rates in one.turns_deg_s for rate in rates) * DEGREE
        rates = np.linspace(-most, most, CURVE_POINTS)
        name = f"{one.speed_kn:.4g} kn"
        curves.append(Curve(name, bent.helm(rates) / DEGREE, rates / DEGREE))
    title, rudder = "steady turns: the spiral", "rudder, positive to port [deg]"
    return (Panel(title, rudder, "yaw rate [deg/s]", tuple(curves), levels=(0.0,)),)
