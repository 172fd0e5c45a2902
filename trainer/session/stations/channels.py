"""The table of all channels by name, and the fields that only the instructor sees.

A channel is a group of values that is sent together, such as ``gauges``. A station subscribes to
those that its role may see. A field is a name, a unit, its decimals, and a function that reads its
value off a frame (``view``). Fields of the crew's instruments stand in ``panels``, ships and
periscope in ``plot``.
"""

from collections.abc import Mapping
from typing import Final

from trainer.boat.boat import STATE_OFFSETS
from trainer.boat.casualties import describe_amount
from trainer.core.casualties import KINDS
from trainer.core.state import MAX_CASUALTIES
from trainer.session.stations import panels
from trainer.session.stations.aid_channels import AID_CHANNELS
from trainer.session.stations.panels import (
    TONNE_KG,
    Channel,
    Field,
    Source,
    Value,
    course,
    measured,
    number_of_state,
    reading,
    word,
)
from trainer.session.stations.plant_channels import PLANT_CHANNELS
from trainer.session.stations.plot import CONTACTS_CHANNEL, PERISCOPE_CHANNELS
from trainer.session.stations.safe_channel import SAFE_CHANNEL
from trainer.session.stations.view import Frame
from trainer.units import DEGREE, KNOT

TRUE_HEADING: Final = Source(STATE_OFFSETS["psi"], of_state=True, is_course=True)
TELETYPE_CHANNEL: Final = "teletype"  # the state in one line of 79 columns, under headings
EVENTS_CHANNEL: Final = "events"  # what happens, when it happens


def sea_fields(before: str) -> tuple[Field, ...]:
    """Return height, period of the peak and origin of a sea."""
    return (
        reading(f"{before}height", "m", 2),
        reading(f"{before}period", "s", 1),
        course(f"{before}from", 0, of=f"{before}origin"),
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
            number_of_state("depth", "z", "m", 2),
            measured("heading", "deg", 2, TRUE_HEADING),
            number_of_state("speed", "u", "kn", 2, KNOT),
            number_of_state("pitch", "theta", "deg", 2, DEGREE),
            number_of_state("heel", "phi", "deg", 2, DEGREE),
            number_of_state("north", "x", "m", 1),
            number_of_state("east", "y", "m", 1),
            reading("depth_rate", "m/s", 3),
            reading("turn_rate", "deg/s", 3, DEGREE),
            # an acceleration is of the forces within a tick: it is that of the tick before
            number_of_state("speed_rate", "udot", "kn/s", 4, KNOT),
            reading("pitch_rate", "deg/s", 3, DEGREE),
            reading("heel_rate", "deg/s", 3, DEGREE),
            reading("north_rate", "m/s", 2),
            reading("east_rate", "m/s", 2),
            reading("heavy", "t", 1, TONNE_KG),
            reading("clearance", "m", 1),
        ),
    ),
    Channel(
        "sea",
        "the sea in force, the one it is becoming, and the surface above the boat",
        (
            *sea_fields(""),
            *sea_fields("ordered_"),
            number_of_state("ramp", "sea_ramp", "s", 1),
            number_of_state("elevation", "eta_wave", "m", 2),
            reading("over_sail", "m", 1),
        ),
    ),
    Channel(
        "current",
        "the water at the boat, where it goes to and how fast, and the way made over the ground",
        (
            course("set"),
            reading("drift", "kn", 2, KNOT),
            course("course_over_ground", of="track"),
            reading("speed_over_ground", "kn", 2, KNOT, of="way"),
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
        *PLANT_CHANNELS,
        SAFE_CHANNEL,
        *PERISCOPE_CHANNELS,
        *AID_CHANNELS,
        *INSTRUCTOR_CHANNELS,
    )
}
