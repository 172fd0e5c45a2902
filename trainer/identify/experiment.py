"""Rudder experiments for a boat: the helm and its times, flown in a calm.

``trainer ship prbs`` designs an experiment by it, and the Monte-Carlo studies simulate one. Method:
model document, section 10. A sequence excites best with an amplitude small enough to stay linear,
with each bit held for 0.2 to 0.5 T1, over 20 to 40 T1, and read at intervals between T2/2 and T1/5.
It is pseudo-random, from a maximum-length shift register. The boat flies it without ports or clock,
and the flight becomes a record as a real trial does.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trainer.analysis.manoeuvres.flight import Flight, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.due_orders import obey_all, orders_due
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, toml_value
from trainer.config.ship.sensors import Sensors
from trainer.core.kernel import Numbers
from trainer.identify.model.nomoto import Nomoto
from trainer.identify.record.measurements import Record
from trainer.identify.record.sources import TRAINER_COLUMNS
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import ScheduledOrder
from trainer.units import KNOT

REGISTER_TAPS: Final = {  # bits of the register whose sum modulo 2 comes in: periods of 2^n - 1
    2: (2, 1),
    3: (3, 2),
    4: (4, 3),
    5: (5, 3),
    6: (6, 5),
    7: (7, 6),
    8: (8, 6, 5, 4),
    9: (9, 5),
    10: (10, 7),
    11: (11, 9),
    12: (12, 11, 10, 4),
}
LEAD_TIME_S: Final = 30.0  # [s] of straight motion before the first helm
LINEAR_RUDDER_DEG: Final = 10.0  # [deg] of rudder beyond which ships are not linear
HOLD_RANGE_T1: Final = (0.2, 0.5)  # [T1] of a bit
LENGTH_RANGE_T1: Final = (20.0, 40.0)  # [T1] of the whole
MAX_TRAVEL_SHARE: Final = 0.5  # [-] of a rudder's way over: so often a reading shows it moving
MAX_ORDERS: Final = 499  # that an exercise file takes
BOAT_EQUATIONS: Final = "full"
BOAT_INTEGRATOR: Final = "rk4"
KEEP_COURSE_ORDER: Final = "rudder auto"
TIME_FORM: Final = ".12g"  # a day of seconds to the microsecond, without noise of sums
EXERCISE_BRIEFING: Final = (
    "An experiment for identification: hands off, the helm is given by schedule and depth is kept "
    "by the planes. Record it, and give the recording to trainer identify."
)
TimedOrders = tuple[tuple[float, str], ...]  # [s], and the order as it is typed
FLOWN_COLUMNS: Final = {"t": "t", **TRAINER_COLUMNS}  # columns of the boat, by channel


def prbs(bits: int, seed: int = 1) -> Numbers:
    """Return one period, (2^bits - 1,), of -1 and 1. ``seed`` is what the register begins with.

    The register's own bits come out first, the highest first. ConfigError if no taps are known for
    that number of bits, or if the seed is 0: an empty register stays empty.
    """
    if bits not in REGISTER_TAPS:
        raise ConfigError(
            f"register of {bits} bits: must be {min(REGISTER_TAPS)} to {max(REGISTER_TAPS)}"
        )
    if not 1 <= seed < 2**bits:
        raise ConfigError(f"seed {seed}: a register of {bits} bits takes 1 to {2**bits - 1}")
    register = [(seed >> (bits - 1 - i)) & 1 for i in range(bits)]
    out = []
    for _ in range(2**bits - 1):
        out.append(register[0])
        register = [*register[1:], sum(register[bits - tap] for tap in REGISTER_TAPS[bits]) % 2]
    return 2.0 * np.array(out) - 1.0


def hold_bits(sequence: Numbers, amplitude: float, samples: int) -> Numbers:
    """Return the sequence times ``amplitude``, each bit held for some samples."""
    return np.repeat(amplitude * sequence, samples)


@dataclass(frozen=True, kw_only=True)
class HelmOptions:
    """A user's wishes for helm and record; None is what suits the vessel."""

    zigzag: tuple[float, float] | None = None  # [deg] rudder and heading, in place of a sequence
    hold: float | None = None  # [s] of a bit
    bits: int | None = None  # of the register
    seed: int = 1
    seconds: float = 600.0  # of a zig-zag, or of all trials of a ship
    interval: float | None = None  # [s] between samples
    outputs: tuple[str, ...] = ()
    sensors: Sensors
    unrest: float = 0.02  # [deg/s] rms, of the sea alone


def method_of(file: VesselFile) -> Method:
    """Return how experiments are flown: by the full set, and by Runge and Kutta.

    The compact set differs from the full one in steering by a few per cent, and a good record shows
    less than that. With the trainer's usual two-step method the rudder acts half a step early, and
    a fit of a short time constant shows this.
    """
    return Method(BOAT_EQUATIONS, "exact", "exact", BOAT_INTEGRATOR, file.run.step_s)


@dataclass(frozen=True)
class BinarySequence:
    """A binary sequence of helm, or of courses for the autopilot to steer."""

    bits: int  # of the register
    amplitude_deg: float
    hold_s: float  # of each bit
    periods: int
    by: str  # "rudder" or "course"
    seed: int = 1

    @property
    def seconds(self) -> float:
        """Return how long the sequence lasts [s]. Its lead and a last bit of rest are included."""
        return LEAD_TIME_S + self.hold_s * (self.periods * ((1 << self.bits) - 1) + 1)

    def orders(self) -> TimedOrders:
        """Return time [s] and order of each change, course 000 being kept before and after."""
        timed_orders: list[tuple[float, str]] = []
        last = 0.0
        for i, bit in enumerate(list(prbs(self.bits, self.seed)) * self.periods):
            if bit != last:
                side = "left" if bit > 0 else "right"  # 1 to port, as the rudder is positive
                rudder = f"rudder {side} {self.amplitude_deg:g}"
                course = f"course {(-bit * self.amplitude_deg) % 360.0:05.1f}"
                order = rudder if self.by == "rudder" else course
                timed_orders.append((LEAD_TIME_S + i * self.hold_s, order))
            last = bit
        end = LEAD_TIME_S + self.hold_s * self.periods * (2**self.bits - 1)
        timed_orders.append((end, KEEP_COURSE_ORDER if self.by == "rudder" else "course 000"))
        if len(timed_orders) > MAX_ORDERS:
            raise ConfigError(
                f"{len(timed_orders)} changes of helm are more than the {MAX_ORDERS} an exercise "
                "takes; give fewer --bits or --periods"
            )
        return tuple(timed_orders)


def schedule_orders(orders: TimedOrders) -> list[ScheduledOrder]:
    """Return orders in words as a schedule; ConfigError if a text is no order."""
    scheduled = []
    for i, (seconds, text) in enumerate(orders, start=1):
        order = parse(text)
        if not isinstance(order, Order):
            raise ConfigError(f"{text}: {order.reason if order else 'is no order'}")
        scheduled.append(ScheduledOrder(seconds, order, i))
    return scheduled


def suggest_hold(ship: Nomoto, interval: float) -> float:
    """Return a length of bit [s], a third of T1 in whole sampling intervals."""
    return max(1.0, round(abs(ship.T1) / 3.0 / interval)) * interval


def suggest_bits(ship: Nomoto, hold: float) -> int:
    """Return the register whose period is nearest to 30 T1, 4 to 8 bits."""
    wanted = 30.0 * abs(ship.T1) / hold
    return min(range(4, 9), key=lambda bits: abs(math.log((2**bits - 1) / wanted)))


def suggest_interval(ship: Nomoto, step: float) -> float:
    """Return a sampling interval [s] between T2/2 and T1/5, in whole steps."""
    middle = math.sqrt(0.5 * abs(ship.T2) * 0.2 * abs(ship.T1))
    return max(1.0, round(middle / step)) * step


def remarks(
    sequence: BinarySequence, ship: Nomoto, interval: float, rudder_rate: float
) -> Iterator[str]:
    """Yield warnings about a sequence for a ship that is read every ``interval`` [s].

    Its rudder moves at ``rudder_rate`` [deg/s].
    """
    T1, T2 = abs(ship.T1), abs(ship.T2)
    if sequence.by == "rudder" and sequence.amplitude_deg > LINEAR_RUDDER_DEG:
        yield f"{sequence.amplitude_deg:g} deg of rudder is much: the ship will not be linear"
    if not HOLD_RANGE_T1[0] * T1 <= sequence.hold_s <= HOLD_RANGE_T1[1] * T1:
        low, high = HOLD_RANGE_T1[0] * T1, HOLD_RANGE_T1[1] * T1
        yield f"bits of {sequence.hold_s:g} s: {low:.0f} to {high:.0f} s excite this ship best"
    if sequence.seconds < LENGTH_RANGE_T1[0] * T1:
        least = LENGTH_RANGE_T1[0] * T1
        yield f"{sequence.seconds:.0f} s is short: {least:.0f} s or more is advised"
    if not ship.stable and sequence.by == "rudder":
        yield "the ship does not keep its course by itself: let the autopilot steer (--by course)"
    if not 0.5 * T2 <= interval <= 0.2 * T1:
        low, high = 0.5 * T2, 0.2 * T1
        yield f"samples every {interval:g} s: {low:.1f} to {high:.1f} s suit its time constants"
    travel = 2.0 * sequence.amplitude_deg / rudder_rate
    if sequence.by == "rudder" and interval > MAX_TRAVEL_SHARE * travel:
        yield (
            f"the rudder goes over in {travel:.2g} s: record it every "
            f"{MAX_TRAVEL_SHARE * travel:.2g} s or oftener; --every then takes means"
        )
    if abs(sequence.hold_s / interval - round(sequence.hold_s / interval)) > 1e-6:
        yield f"a bit of {sequence.hold_s:g} s is no whole number of {interval:g} s samples"


def zigzag_flight(
    file: VesselFile, speed: float, angles: tuple[float, float], seconds: float
) -> Flight:
    """Return a zig-zag flown at ``speed`` [m/s], helm and heading ``angles`` [deg].

    ConfigError if the boat has no rudder that goes so far.
    """
    angle, execute = angles
    if angle > file.surfaces.rudder_limit_deg:
        most = file.surfaces.rudder_limit_deg
        raise ConfigError(f"the rudder goes to {most:g} deg, not {angle:g}")
    manoeuvre = ZigZag(angle_deg=angle, execute_deg=execute, duration_s=seconds)
    return fly_manoeuvre(Submarine(file, method_of(file), Rig()), manoeuvre, speed)


def zigzag_orders(flight: Flight, angle: float) -> TimedOrders:
    """Return time [s] and order of each execute, the first to starboard after the lead."""
    times = [mark.t for mark in flight.marks if mark.name == "execute"]
    late = LEAD_TIME_S - times[0] if times else 0.0
    sides = ("right", "left")
    orders = [(late + t, f"rudder {sides[i % 2]} {angle:g}") for i, t in enumerate(times)]
    return (*orders, (late + float(flight.t[-1]), KEEP_COURSE_ORDER))


def measure_zigzag(flight: Flight, execute: float) -> dict[str, Any]:
    """Return reach, period and overshoots of a zig-zag with that heading angle [deg].

    The reach is the time from the first helm to the second, the period that from the second to the
    fourth. Each is None where the flight ended before that helm.
    """
    measures = ZigZag(execute_deg=execute).measures(flight)
    times = [mark.t for mark in flight.marks if mark.name == "execute"]
    overshoots = [one.value for one in measures if "overshoot" in one.name]
    return {
        "reach_s": times[1] - times[0] if len(times) > 1 else None,
        "period_s": times[3] - times[1] if len(times) > 3 else None,
        "overshoots_deg": tuple(math.degrees(one) for one in overshoots if one is not None),
    }


def exercise_text(orders: TimedOrders, name: str, table: dict[str, Any]) -> str:
    """Return the text of an exercise that gives ``orders``.

    ``table`` has vessel, speed_kn, depth_m, duration_s and perhaps sea.
    """
    start = {"speed_kn": table["speed_kn"], "depth_m": table["depth_m"], "course_deg": 0}
    heads = {"name": name, **{key: one for key, one in table.items() if key not in start}}
    heads |= {"equations": BOAT_EQUATIONS, "integrator": BOAT_INTEGRATOR}
    heads["briefing"] = EXERCISE_BRIEFING
    return "\n".join(exercise_lines(heads, {"initial": start}, orders)) + "\n"


def exercise_lines(
    heads: Mapping[str, Any], tables: Mapping[str, Mapping[str, Any]], orders: TimedOrders
) -> Iterator[str]:
    """Yield the lines of an exercise file that gives ``orders``."""
    for title, table in {"": {"schema": "exercise/1", **heads}, **tables}.items():
        yield from ["", f"[{title}]"] if title else []
        yield from (f"{key} = {toml_value(one, TIME_FORM)}" for key, one in table.items())
    for seconds, order in orders:
        yield from ("", "[[orders]]", f"at_s = {toml_value(seconds, TIME_FORM)}")
        yield f"order = {toml_value(order)}"


def fly_trial(
    file: VesselFile, schedule: Iterable[ScheduledOrder], speed: float, depth: float, seconds: float
) -> Record:
    """Return the record of a boat that begins at ``speed`` [m/s] and ``depth`` [m].

    ConfigError if the boat cannot begin so, refuses an order, or its state becomes infinite.
    """
    step = file.run.step_s
    boat = Boat(file, method_of(file))
    boat.start(speed, depth, 0.0)
    due = orders_due(boat, [*schedule])
    rows = []
    for tick in range(round(seconds / step) + 1):
        for words, why in obey_all(boat, due.get(tick, ())):
            raise ConfigError(f"{boat.time:g} s: {words}: {why}")
        rows.append(boat.numbers(tuple(FLOWN_COLUMNS.values())))
        if status := boat.tick():
            raise ConfigError(f"{file.path.name}: {boat.failure(status)}")
    return Record(
        source=f"{file.name} at {speed / KNOT:g} kn",
        rows=np.arange(len(rows)),
        names={},
        **dict(zip(FLOWN_COLUMNS, np.array(rows).T, strict=True)),
    )
