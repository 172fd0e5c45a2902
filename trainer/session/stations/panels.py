"""The stations of the control room: gauges, panels, tanks, air and valves.

``channels`` lists them. Depth, heading and speed are read off their gauges, and are as wrong as
these are. Angles of surfaces, attitude, turns, levels and pressures are shown as they are, because
their instruments have no casualty.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.readings import READING_OFFSETS
from trainer.boat.sea_orders import FREEZABLE_PARTS
from trainer.core.ballast.tanks import BANKS, COMPARTMENTS, TANKS
from trainer.core.state import VALVES
from trainer.io.nmea import number
from trainer.io.orders.grammar import Refused
from trainer.io.sides import ANGLE_SIDES, sided
from trainer.session.stations.view import Frame
from trainer.units import DEGREE, KNOT

Value = float | str | None  # None: the boat lacks it, or it stands for nothing at present
TONNE_KG: Final = 1000.0  # [kg]
PERCENT: Final = 0.01  # [-]
MEGAPASCAL: Final = 1e6  # [Pa]
VALVE_POSITIONS: Final = ("shut", "open", "emergency")  # of a valve's lever


class Source(NamedTuple):
    """The number that a field shows, in the state or among the readings."""

    place: int
    size: float = 1.0  # [SI] of the field's unit
    of_state: bool = False
    is_course: bool = False  # an angle that is shown from 0 to 360 degrees
    words: tuple[str, ...] = ()  # that the number stands for, "" for nothing to be said


@dataclass(frozen=True)
class Field:
    """A field of a channel: name, unit, decimals, and its reader off a frame.

    ``unit`` is "" for a word, "-" for a plain number.
    """

    name: str
    unit: str
    decimals: int
    read: Callable[[Frame], Value]
    packed: bool = False  # for programs alone: words leave it out
    sides: tuple[str, str] | None = None  # words of a positive and a negative angle
    source: Source | None = None  # of what it shows, if no more than a number is read

    def text(self, frame: Frame) -> str:
        """Return the value with its decimals, "" for none."""
        value = self.read(frame)
        if isinstance(value, str):
            return value
        return number(value, self.decimals)

    def words(self, frame: Frame) -> str:
        """Return the value with unit and side, as people say it, "" for none."""
        text, unit = self.text(frame), self.unit.strip("-")
        if self.sides and text:
            return sided(float(text), self.sides, self.decimals, unit)
        return f"{text} {unit}".rstrip() if text else ""


@dataclass(frozen=True)
class Channel:
    """Fields that are sent together, and that a role sees all or none of."""

    name: str
    says: str
    fields: tuple[Field, ...]
    fastest: float = math.inf  # [Hz] it is sent at, whatever is wished
    lack: Callable[[Boat], Refused | None] = lambda _: None  # why a boat has no such channel

    def values(self, frame: Frame) -> list[str]:
        """Return the fields of one tick."""
        return [field.text(frame) for field in self.fields]


def word(name: str, read: Callable[[Frame], Value]) -> Field:
    """Return a field that is a word."""
    return Field(name, "", 0, read)


def compass(angle: float, decimals: int = 1) -> float:
    """Return an angle [rad] as a course [deg] that is below 360 when written."""
    return round(math.degrees(angle), decimals) % 360.0


def measured(name: str, unit: str, decimals: int, source: Source) -> Field:
    """Return a field of a number of the state or of a reading."""
    place, size, of_state, is_course, words = source

    def read(frame: Frame) -> Value:
        value = (frame.numbers if of_state else frame.shown)[place]
        if math.isnan(value):
            return None
        if words:
            return words[int(value)]
        return compass(value, decimals) if is_course else value / size

    return Field(name, unit, decimals, read, source=source)


def reading(name: str, unit: str, decimals: int, size: float = 1.0, of: str = "") -> Field:
    """Return a field of a reading in a unit of that size [SI].

    ``of`` is its name in the core, if it has another.
    """
    return measured(name, unit, decimals, Source(READING_OFFSETS[of or name], size))


def course(name: str, decimals: int = 1, of: str = "") -> Field:
    """Return a field of a reading that is a direction."""
    return measured(name, "deg", decimals, Source(READING_OFFSETS[of or name], is_course=True))


def number_of_state(name: str, field: str, unit: str, decimals: int, size: float = 1.0) -> Field:
    """Return a field of the state in a unit of that size [SI]."""
    return measured(name, unit, decimals, Source(STATE_OFFSETS[field], size, of_state=True))


def word_of_state(name: str, field: str, *words: str) -> Field:
    """Return a field of a number of the state that stands for a word."""
    return measured(name, "", 0, Source(STATE_OFFSETS[field], of_state=True, words=words))


HEADING_FIELD: Final = course("heading")
DEPTH_FIELD: Final = reading("depth", "m", 1)
SPEED_FIELD: Final = reading("speed", "kn", 1, KNOT)
PITCH_FIELD: Final = replace(
    number_of_state("pitch", "theta", "deg", 1, DEGREE), sides=ANGLE_SIDES["pitch"]
)
HEEL_FIELD: Final = replace(
    number_of_state("heel", "phi", "deg", 1, DEGREE), sides=ANGLE_SIDES["heel"]
)


def surface_fields(surface: str) -> tuple[Field, ...]:
    """Return the angle of a surface, its order, and who orders it."""
    angle, ordered = (
        replace(reading(name, "deg", 1, DEGREE), sides=ANGLE_SIDES[surface])
        for name in (surface, f"ordered_{surface}")
    )
    return angle, ordered, mode_field(surface)


def mode_field(what: str) -> Field:
    """Return whether something is steered by hand or by the autopilot."""
    return word(f"{what}_mode", lambda frame: "hand" if frame[f"{what}_by_hand"] else "auto")


def rpm(frame: Frame, u_c: float | None) -> float:
    """Return the revolutions a minute of a command speed [m/s]."""
    return (u_c or 0.0) * frame.boat.file.propulsion.rps_per_mps * 60.0


def bell(frame: Frame) -> Value:
    """Return the bell that is rung, if the turns ordered are those of one."""
    if not frame["speed_by_hand"]:
        return None
    ordered = frame["ordered_u_c"]
    bells = {"stop": 0.0, **frame.boat.file.propulsion.bells_kn}
    rung = [name for name, speed in bells.items() if abs(speed * KNOT - ordered) < 1e-9]
    return rung[0].replace("_", "-") if rung else None


def tank_fields(tank: str) -> tuple[Field, ...]:
    """Return the content of a tank or compartment. A tank also tells how full it is."""
    name = tank.replace("compartment_", "flood_")
    mass = reading(name, "t", 1, TONNE_KG)
    return (mass,) if tank in COMPARTMENTS else (mass, reading(f"{name}_full", "%", 1, PERCENT))


def bank_fields(bank: str) -> tuple[Field, ...]:
    """Return the pressure of a bank, and how full it is."""
    return reading(bank, "MPa", 1, MEGAPASCAL), reading(f"{bank}_full", "%", 1, PERCENT)


def valve_fields(valve: str) -> tuple[Field, ...]:
    """Return how the levers of a vent and a blow valve stand."""

    def position(name: str) -> Field:
        return word(name, lambda frame: VALVE_POSITIONS[int(frame[name])])

    return position(f"vent_{valve}"), position(f"blow_{valve}")


def is_working(name: str) -> Field:
    """Return whether something works."""
    return word(name, lambda frame: "on" if frame[name] else "off")


def compressor(frame: Frame) -> Value:
    """Return whether the compressor works, where the boat has one, and has air."""
    vessel = frame.boat.vessel
    if not vessel.compressor_rate:
        return None
    running = "on" if frame["z"] <= vessel.intake_depth else "no air"
    return running if frame["compressor"] else "off"


def trim_mode(frame: Frame) -> Value:
    """Return who trims, where the boat has trim tanks."""
    if frame.read("trim_forward") is None:
        return None
    return "hand" if frame["trim_by_hand"] else "auto"


def drained_compartment(frame: Frame) -> Value:
    """Return the compartment that is pumped out."""
    index = int(frame["drained"])
    return COMPARTMENTS[index - 1].removeprefix("compartment_") if index else None


def crew_since(axis: str) -> Field:
    """Return the field of how long [s] an order to the crew has stood."""

    def since(frame: Frame) -> Value:
        ticks = frame.read(f"{axis}_since")
        return None if ticks is None else ticks * frame.boat.method.step

    return Field(f"{axis}_since", "s", 0, since)


def crew_fields(axis: str, unit: str, size: float) -> tuple[Field, ...]:
    """Return an order to the crew, what is to go, and how long it stands."""
    ordered = reading(axis, unit, 1, size, of=f"crew_{axis}")
    return ordered, reading(f"{axis}_error", unit, 1, size), crew_since(axis)


def course_side(frame: Frame) -> Value:
    """Return the way that the crew is to turn, None for the shorter."""
    stands = frame.at("crew_order_tick", 0)
    return {-1.0: "left", 1.0: "right"}.get(frame["crew_course_side"]) if stands else None


def depth_unit(frame: Frame) -> Value:
    """Return the unit in which the depth was ordered."""
    stands = frame.at("crew_order_tick", CREW_AXES.index("depth"))
    return ("m" if frame["crew_depth_unit"] == 1.0 else "ft") if stands else None


DEPTH_FIELDS: Final = crew_fields("depth", "m", 1.0)
ORDERS_CHANNEL: Final = Channel(
    "orders",
    "what the crew is ordered; errors are to go, right, deeper, faster and bow up positive",
    (
        course("course", of="crew_course"),
        word("course_side", course_side),
        reading("course_error", "deg", 1, DEGREE),
        crew_since("course"),
        DEPTH_FIELDS[0],
        word("depth_unit", depth_unit),
        *DEPTH_FIELDS[1:],
        *crew_fields("speed", "kn", KNOT),
        *crew_fields("pitch", "deg", DEGREE),
        word("told", lambda frame: frame.pace.told or None),
        word("hands", lambda frame: frame.pace.hands or None),
    ),
)


PANEL_CHANNELS: Final = (
    Channel(
        "gauges",
        "the repeaters at every station",
        (DEPTH_FIELD, HEADING_FIELD, SPEED_FIELD, PITCH_FIELD, HEEL_FIELD),
    ),
    ORDERS_CHANNEL,
    Channel(
        "steering",
        "the helm's panel",
        (
            HEADING_FIELD,
            course("ordered_course"),
            *surface_fields("rudder"),
            number_of_state("turn_rate", "r", "deg/s", 2, DEGREE),
        ),
    ),
    Channel(
        "engine",
        "log, telegraph and turns",
        (
            SPEED_FIELD,
            reading("ordered_speed", "kn", 1, KNOT),
            Field("rpm", "rpm", 1, lambda frame: rpm(frame, frame["u_c"])),
            Field("ordered_rpm", "rpm", 1, lambda frame: rpm(frame, frame.read("ordered_turns"))),
            word("bell", bell),
            mode_field("speed"),
        ),
    ),
    Channel(
        "diving",
        "the planes' panel",
        (
            DEPTH_FIELD,
            reading("ordered_depth", "m", 1),
            PITCH_FIELD,
            HEEL_FIELD,
            *surface_fields("stern"),
            *surface_fields("bow"),
            reading("sounding", "m", 1),
        ),
    ),
    Channel(
        "tanks",
        "water aboard, and what is being moved: forward and inward positive",
        (
            *(field for tank in TANKS for field in tank_fields(tank)),
            number_of_state("moving_trim", "move_trim", "t", 1, TONNE_KG),
            number_of_state("moving_auxiliary", "move_auxiliary", "t", 1, TONNE_KG),
            number_of_state("moving_depth_control", "move_depth_control", "t", 1, TONNE_KG),
            word("draining", drained_compartment),
            is_working("hover"),
            word("trim_mode", trim_mode),
        ),
    ),
    Channel(
        "air",
        "the air banks",
        (
            *(field for bank in BANKS for field in bank_fields(bank)),
            word("compressor", compressor),
        ),
    ),
    Channel(
        "valves",
        "how their levers stand, whatever the valves do",
        (
            *(field for valve in VALVES for field in valve_fields(valve)),
            word("negative_flood", lambda frame: "open" if frame["negative_flood"] else "shut"),
        ),
    ),
    Channel(
        "time",
        "how time runs",
        (
            word("time", lambda frame: "frozen" if frame.pace.frozen else "running"),
            Field(
                "speed",
                "x",
                1,
                lambda frame: "max" if math.isinf(frame.pace.speed) else frame.pace.speed,
            ),
            word("held", lambda f: "+".join(p for p in FREEZABLE_PARTS if f[f"held_{p}"]) or None),
            Field("branch", "-", 0, lambda frame: float(frame.pace.branch)),
            word("replay", lambda frame: "yes" if frame.pace.replaying else "no"),
            word("shown", lambda frame: "yes" if frame.pace.shows_way else "no"),
        ),
    ),
)
