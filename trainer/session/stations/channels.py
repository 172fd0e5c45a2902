"""The table of all channels by name, and the fields that only the instructor sees.

A channel is a group of values that is sent together, such as ``gauges``. A station subscribes to
those that its role may see. A field is a name, a unit, its decimals, and a function that reads its
value off a frame (``view``). Fields of the crew's instruments stand in ``panels``, ships and
periscope in ``plot``.
"""

import math
from collections.abc import Callable, Mapping
from typing import Final

from trainer.boat.casualties import describe_amount
from trainer.boat.motion_rates import MotionRates
from trainer.boat.world.bottom import height_of_keel
from trainer.core.casualties import KINDS
from trainer.core.sea.sea import DIRECTION, HEIGHT, OMEGA
from trainer.core.state import MAX_CASUALTIES
from trainer.session.stations import panels
from trainer.session.stations.aid_channels import AID_CHANNELS
from trainer.session.stations.panels import (
    TONNE_KG,
    Channel,
    Field,
    Value,
    compass,
    degrees,
    knots,
    metres,
    word,
)
from trainer.session.stations.plot import CONTACTS_CHANNEL, PERISCOPE_CHANNELS
from trainer.session.stations.view import Frame
from trainer.units import KNOT

MIN_SHOWN_SPEED_KN: Final = 0.005  # [kn] that is not written as zero
TELETYPE_CHANNEL: Final = "teletype"  # the state in one line of 79 columns, under headings
EVENTS_CHANNEL: Final = "events"  # what happens, when it happens


def rate(name: str, read: Callable[[MotionRates], float]) -> Field:
    """Return a field of the rate of an angle."""
    return Field(name, "deg/s", 3, lambda frame: math.degrees(read(frame.rates)))


def excess_weight(frame: Frame) -> Value:
    """Return how much heavier [t] than its displacement the boat is."""
    return (frame["weight"] - frame.fittings.buoyancy) / frame.fittings.g / TONNE_KG


def clearance(frame: Frame) -> Value:
    """Return the height [m] of the keel over the ground, None without a ground."""
    height = height_of_keel(frame.numbers, frame.fittings.length, frame.fittings.keel)
    return None if math.isinf(height) else height


def way_made(frame: Frame) -> tuple[float, float]:
    """Return track [deg] and speed [kn] over the ground. At rest the track is the heading."""
    rates = frame.rates
    speed = float(rates.way) / KNOT
    angle = math.atan2(rates.east, rates.north) if speed >= MIN_SHOWN_SPEED_KN else frame["psi"]
    return compass(angle, 2), speed


def set_and_drift(frame: Frame) -> tuple[float | None, float]:
    """Return set [deg] and drift [kn] at the boat. Still water has no set."""
    north = frame["water_north"] + frame["shear_north"] * frame["z"]
    east = frame["water_east"] + frame["shear_east"] * frame["z"]
    drift = math.hypot(north, east) / KNOT
    return (compass(math.atan2(east, north), 1) if drift >= MIN_SHOWN_SPEED_KN else None), drift


def sea_fields(block: str, before: str) -> tuple[Field, ...]:
    """Return height, period of the peak and origin of a sea."""

    def period(frame: Frame) -> Value:
        return math.tau / frame.at(block, OMEGA) if frame.at(block, HEIGHT) else None

    def origin(frame: Frame) -> Value:
        towards = frame.at(block, DIRECTION)
        return compass(towards + math.pi, 0) if frame.at(block, HEIGHT) else None

    return (
        Field(f"{before}height", "m", 2, lambda frame: frame.at(block, HEIGHT)),
        Field(f"{before}period", "s", 1, period),
        Field(f"{before}from", "deg", 0, origin),
    )


def slot_fields(slot: int) -> tuple[Field, ...]:
    """Return what one slot for casualties holds."""

    def held(frame: Frame, block: str) -> float | None:
        return frame.at(block, slot) if frame.at("casualty", slot) else None

    def kind(frame: Frame) -> Value:
        code = int(held(frame, "casualty") or 0.0)
        return KINDS[code - 1] if code else None

    def ticks(frame: Frame) -> float | None:
        return held(frame, "casualty_ticks")

    def target(frame: Frame) -> Value:
        ticks_left = ticks(frame)
        return (
            None
            if ticks_left is None
            else (0.0 if ticks_left < 0.0 else held(frame, "casualty_target"))
        )

    def says(frame: Frame) -> Value:
        name = kind(frame)
        amount = held(frame, "casualty_amount")
        return describe_amount(frame.boat, str(name), amount or 0.0) if name else None

    def seconds(frame: Frame) -> Value:
        ticks_left = ticks(frame)
        return None if ticks_left is None else abs(ticks_left) * frame.boat.method.step

    name = f"casualty_{slot + 1}"
    return (
        word(name, kind),
        Field(f"{name}_amount", "si", 5, lambda frame: held(frame, "casualty_amount")),
        Field(f"{name}_target", "si", 5, target),
        Field(f"{name}_left", "s", 1, seconds),
        word(f"{name}_says", says),
    )


INSTRUCTOR_CHANNELS: Final = (
    Channel(
        "motion",
        "the truth and its rates, for displays that move between ticks",
        (
            Field("depth", "m", 2, lambda frame: frame.truth.depth),
            Field("heading", "deg", 2, lambda frame: compass(frame.truth.heading, 2)),
            Field("speed", "kn", 2, lambda frame: frame.truth.speed / KNOT),
            degrees("pitch", "theta", decimals=2),
            degrees("heel", "phi", decimals=2),
            metres("north", "x"),
            metres("east", "y"),
            Field("depth_rate", "m/s", 3, lambda frame: frame.rates.down),
            rate("turn_rate", lambda rates: rates.heading),
            # an acceleration is of the forces within a tick: it is that of the tick before
            knots("speed_rate", "udot", "kn/s", 4),
            rate("pitch_rate", lambda rates: rates.pitch),
            rate("heel_rate", lambda rates: rates.heel),
            Field("north_rate", "m/s", 2, lambda frame: frame.rates.north),
            Field("east_rate", "m/s", 2, lambda frame: frame.rates.east),
            Field("heavy", "t", 1, excess_weight),
            Field("clearance", "m", 1, clearance),
        ),
    ),
    Channel(
        "sea",
        "the sea in force, the one it is becoming, and the surface above the boat",
        (
            *sea_fields("sea", ""),
            *sea_fields("sea_target", "ordered_"),
            metres("ramp", "sea_ramp", "s"),
            metres("elevation", "eta_wave", decimals=2),
            Field("over_sail", "m", 1, lambda frame: -frame.height(*frame.fittings.sail)),
        ),
    ),
    Channel(
        "current",
        "the water at the boat, where it goes to and how fast, and the way made over the ground",
        (
            Field("set", "deg", 1, lambda frame: set_and_drift(frame)[0]),
            Field("drift", "kn", 2, lambda frame: set_and_drift(frame)[1]),
            Field("course_over_ground", "deg", 1, lambda frame: round(way_made(frame)[0], 1) % 360),
            Field("speed_over_ground", "kn", 2, lambda frame: way_made(frame)[1]),
        ),
    ),
    Channel(
        "casualties",
        "what is broken: kind, amount in SI units now and in the end, and the time until then",
        tuple(field for slot in range(MAX_CASUALTIES) for field in slot_fields(slot)),
    ),
    CONTACTS_CHANNEL,
    Channel(
        "ledger",
        "what became of the ticks",
        (
            Field("ticks", "-", 0, lambda frame: frame.ledger.ticks),
            Field("duty_cycle", "%", 3, lambda frame: 100.0 * frame.ledger.duty_cycle),
            Field("overruns", "-", 0, lambda frame: frame.ledger.overruns),
            Field("caught_up", "-", 0, lambda frame: frame.ledger.caught_up),
            Field("slipped", "-", 0, lambda frame: frame.ledger.skipped),
            Field("gaps", "-", 0, lambda frame: frame.ledger.gaps),
            Field("work_p50", "us", 1, lambda frame: frame.ledger.work.p50_ns / 1e3),
            Field("work_p99", "us", 1, lambda frame: frame.ledger.work.p99_ns / 1e3),
            Field("work_most", "us", 1, lambda frame: frame.ledger.work.max_ns / 1e3),
            Field("late_p50", "us", 1, lambda frame: frame.ledger.lateness.p50_ns / 1e3),
            Field("late_p99", "us", 1, lambda frame: frame.ledger.lateness.p99_ns / 1e3),
            Field("late_most", "us", 1, lambda frame: frame.ledger.lateness.max_ns / 1e3),
        ),
    ),
)


CHANNELS: Final[Mapping[str, Channel]] = {
    channel.name: channel
    for channel in (
        *panels.PANEL_CHANNELS,
        *PERISCOPE_CHANNELS,
        *AID_CHANNELS,
        *INSTRUCTOR_CHANNELS,
    )
}
