"""The stations of the control room: gauges, panels, tanks, air and valves.

``channels`` lists them. Depth, heading and speed are read off their gauges, and are as wrong as
these are. Angles of surfaces, attitude, turns, levels and pressures are shown as they are, because
their instruments have no casualty.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.sea_orders import FREEZABLE_PARTS
from trainer.core.ballast.tanks import BANKS, COMPARTMENTS, TANKS
from trainer.core.state import VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.nmea import number
from trainer.session.stations.view import Frame
from trainer.units import KNOT

Value = float | str | None  # None: the boat lacks it, or it stands for nothing at present
TONNE_KG: Final = 1000.0  # [kg]
# still to go: nearly round, the other way than was ordered
LONG_TURN_RAD: Final = math.radians(350.0)
VALVE_POSITIONS: Final = ("shut", "open", "emergency")  # of a valve's lever


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

    def text(self, frame: Frame) -> str:
        """Return the value with its decimals, "" for none."""
        value = self.read(frame)
        if isinstance(value, str):
            return value
        return number(value, self.decimals)


@dataclass(frozen=True)
class Channel:
    """Fields that are sent together, and that a role sees all or none of."""

    name: str
    says: str
    fields: tuple[Field, ...]
    fastest: float = math.inf  # [Hz] it is sent at, whatever is wished

    def values(self, frame: Frame) -> list[str]:
        """Return the fields of one tick."""
        return [field.text(frame) for field in self.fields]


def word(name: str, read: Callable[[Frame], Value]) -> Field:
    """Return a field that is a word."""
    return Field(name, "", 0, read)


def compass(angle: float, decimals: int = 1) -> float:
    """Return an angle [rad] as a course [deg] that is below 360 when written."""
    return round(math.degrees(angle), decimals) % 360.0


def degrees(name: str, field: str, unit: str = "deg", decimals: int = 1) -> Field:
    """Return a field of an angle or its rate, from a field of the state."""
    return Field(name, unit, decimals, lambda frame: math.degrees(frame[field]))


def metres(name: str, field: str, unit: str = "m", decimals: int = 1) -> Field:
    """Return a field of a length or its rate, from a field of the state."""
    return Field(name, unit, decimals, lambda frame: frame[field])


def knots(name: str, field: str, unit: str = "kn", decimals: int = 1) -> Field:
    """Return a field of a speed or its rate, from a field of the state."""
    return Field(name, unit, decimals, lambda frame: frame[field] / KNOT)


HEADING_FIELD: Final = Field("heading", "deg", 1, lambda frame: compass(frame.readings.heading))
DEPTH_FIELD: Final = Field("depth", "m", 1, lambda frame: frame.readings.depth)
SPEED_FIELD: Final = Field("speed", "kn", 1, lambda frame: frame.readings.speed / KNOT)
SOUNDING_FIELD: Final = Field("sounding", "m", 1, lambda frame: frame.readings.sounding or None)
PITCH_FIELD: Final = degrees("pitch", "theta")
HEEL_FIELD: Final = degrees("heel", "phi")


def surface_fields(surface: str) -> tuple[Field, ...]:
    """Return the angle of a surface, its order, and who orders it."""
    letter = SURFACES[surface]

    def angle(field: str, frame: Frame) -> float | None:
        toward = frame.boat.toward[surface]
        return math.degrees(frame[field]) * toward if toward else None

    def ordered(frame: Frame) -> float | None:
        by_hand = frame[f"{surface}_by_hand"]
        return angle(f"ordered_{letter}" if by_hand else f"command_{letter}", frame)

    return (
        Field(surface, "deg", 1, lambda frame: angle(f"delta_{letter}", frame)),
        Field(f"ordered_{surface}", "deg", 1, ordered),
        mode_field(surface),
    )


def mode_field(what: str) -> Field:
    """Return whether something is steered by hand or by the autopilot."""
    return word(f"{what}_mode", lambda frame: "hand" if frame[f"{what}_by_hand"] else "auto")


def ordered_course(frame: Frame) -> Value:
    """Return the course kept [deg]."""
    return None if frame["rudder_by_hand"] else compass(frame["ordered_psi"])


def ordered_depth(frame: Frame) -> Value:
    """Return the depth kept [m], by the planes or hovering."""
    is_kept = not (frame["stern_by_hand"] and frame["bow_by_hand"]) or frame["hover"]
    return frame["ordered_depth"] if is_kept else None


def ordered_speed(frame: Frame) -> Value:
    """Return the speed kept [kn]."""
    return None if frame["speed_by_hand"] else frame["ordered_speed"] / KNOT


def rpm(frame: Frame, u_c: float) -> float:
    """Return the revolutions a minute of a command speed [m/s]."""
    return u_c * frame.boat.file.propulsion.rps_per_mps * 60.0


def ordered_turns(frame: Frame) -> float:
    """Return the command speed [m/s] that is asked for, by hand or by the autopilot."""
    return frame["ordered_u_c"] if frame["speed_by_hand"] else frame["command_u_c"]


def bell(frame: Frame) -> Value:
    """Return the bell that is rung, if the turns ordered are those of one."""
    if not frame["speed_by_hand"]:
        return None
    ordered = frame["ordered_u_c"]
    bells = {"stop": 0.0, **frame.boat.file.propulsion.bells_kn}
    rung = [name for name, speed in bells.items() if abs(speed * KNOT - ordered) < 1e-9]
    return rung[0].replace("_", "-") if rung else None


def tonnes(name: str, field: str) -> Field:
    """Return a field of a mass."""
    return Field(name, "t", 1, lambda frame: frame[field] / TONNE_KG)


def tank_fields(index: int, tank: str) -> tuple[Field, ...]:
    """Return the content of a tank or compartment. A tank also tells how full it is."""
    name = tank.replace("compartment_", "flood_")

    def water(frame: Frame) -> float | None:
        return frame.at("water", index) / TONNE_KG if frame.fittings.capacity[index] else None

    def share(frame: Frame) -> float | None:
        whole = frame.fittings.capacity[index]
        return 100.0 * frame.at("water", index) / whole if whole else None

    mass = Field(name, "t", 1, water)
    return (mass,) if tank in COMPARTMENTS else (mass, Field(f"{name}_full", "%", 1, share))


def bank_fields(index: int, bank: str) -> tuple[Field, ...]:
    """Return the pressure of a bank, and how full it is."""

    def share(frame: Frame, whole: float, unit: float) -> float | None:
        return frame[f"bank_{bank}"] * unit / whole if whole else None

    def pressure(frame: Frame) -> float | None:
        return share(frame, frame.fittings.bank_volume[index], frame.fittings.gas / 1e6)

    def full(frame: Frame) -> float | None:
        return share(frame, frame.fittings.bank_full[index], 100.0)

    return Field(bank, "MPa", 1, pressure), Field(f"{bank}_full", "%", 1, full)


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
    if not frame.fittings.capacity[TANKS.index("trim_forward")]:
        return None
    return "hand" if frame["trim_by_hand"] else "auto"


def drained_compartment(frame: Frame) -> Value:
    """Return the compartment that is pumped out."""
    index = int(frame["drained"])
    return COMPARTMENTS[index - 1].removeprefix("compartment_") if index else None


def crew_order(axis: str, read: Callable[[Frame], float]) -> Callable[[Frame], Value]:
    """Return a reader of a number of an order to the crew. It reads None without an order."""
    index = CREW_AXES.index(axis)
    return lambda frame: read(frame) if frame.at("crew_order_tick", index) else None


def crew_since(axis: str) -> Field:
    """Return the field of how long [s] an order to the crew has stood."""
    index = CREW_AXES.index(axis)

    def since(frame: Frame) -> float:
        ticks = frame["tick"] - frame.at("crew_order_tick", index) + 1.0
        return ticks * frame.boat.method.step

    return Field(f"{axis}_since", "s", 0, crew_order(axis, since))


def crew_error(axis: str, unit: str, ordered: Field, gauge: Field) -> Field:
    """Return the field of what is still to go to an order, by the gauge."""

    def to_go(frame: Frame) -> float:
        wanted, shown = ordered.read(frame), gauge.read(frame)
        if isinstance(wanted, float) and isinstance(shown, float):
            return wanted - shown
        return math.nan  # no boat lacks these gauges

    return Field(f"{axis}_error", unit, 1, crew_order(axis, to_go))


def crew_value(axis: str, unit: str, size: float) -> Field:
    """Return an order to the crew in a unit of that size [SI]."""
    index = CREW_AXES.index(axis)
    read = crew_order(axis, lambda frame: frame.at("crew_order", index) / size)
    return Field(axis, unit, 1, read)


def course_to_go(frame: Frame) -> float:
    """Return the angle [deg] still to turn, right positive, by the way that was ordered."""
    to_go = frame.at("crew_order", 0) - frame.readings.heading
    if not frame["crew_course_side"] or abs(to_go) > LONG_TURN_RAD:
        to_go = math.remainder(to_go, math.tau)
    return math.degrees(to_go)


def course_side(frame: Frame) -> Value:
    """Return the way that the crew is to turn, None for the shorter."""
    stands = frame.at("crew_order_tick", 0)
    return {-1.0: "left", 1.0: "right"}.get(frame["crew_course_side"]) if stands else None


def depth_unit(frame: Frame) -> Value:
    """Return the unit in which the depth was ordered."""
    stands = frame.at("crew_order_tick", CREW_AXES.index("depth"))
    return ("m" if frame["crew_depth_unit"] == 1.0 else "ft") if stands else None


DEPTH_ORDER: Final = crew_value("depth", "m", 1.0)
SPEED_ORDER: Final = crew_value("speed", "kn", KNOT)
PITCH_ORDER: Final = crew_value("pitch", "deg", math.radians(1.0))
ORDERS_CHANNEL: Final = Channel(
    "orders",
    "what the crew is ordered; errors are to go, right, deeper, faster and bow up positive",
    (
        Field(
            "course", "deg", 1, crew_order("course", lambda frame: compass(frame["crew_course"]))
        ),
        word("course_side", course_side),
        Field("course_error", "deg", 1, crew_order("course", course_to_go)),
        crew_since("course"),
        DEPTH_ORDER,
        word("depth_unit", depth_unit),
        crew_error("depth", "m", DEPTH_ORDER, DEPTH_FIELD),
        crew_since("depth"),
        SPEED_ORDER,
        crew_error("speed", "kn", SPEED_ORDER, SPEED_FIELD),
        crew_since("speed"),
        PITCH_ORDER,
        crew_error("pitch", "deg", PITCH_ORDER, PITCH_FIELD),
        crew_since("pitch"),
        word("told", lambda frame: frame.pace.told or None),
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
            Field("ordered_course", "deg", 1, ordered_course),
            *surface_fields("rudder"),
            degrees("turn_rate", "r", "deg/s", 2),
        ),
    ),
    Channel(
        "engine",
        "log, telegraph and turns",
        (
            SPEED_FIELD,
            Field("ordered_speed", "kn", 1, ordered_speed),
            Field("rpm", "rpm", 1, lambda frame: rpm(frame, frame["u_c"])),
            Field("ordered_rpm", "rpm", 1, lambda frame: rpm(frame, ordered_turns(frame))),
            word("bell", bell),
            mode_field("speed"),
        ),
    ),
    Channel(
        "diving",
        "the planes' panel",
        (
            DEPTH_FIELD,
            Field("ordered_depth", "m", 1, ordered_depth),
            PITCH_FIELD,
            HEEL_FIELD,
            *surface_fields("stern"),
            *surface_fields("bow"),
            SOUNDING_FIELD,
        ),
    ),
    Channel(
        "tanks",
        "water aboard, and what is being moved: forward and inward positive",
        (
            *(field for i, tank in enumerate(TANKS) for field in tank_fields(i, tank)),
            tonnes("moving_trim", "move_trim"),
            tonnes("moving_auxiliary", "move_auxiliary"),
            tonnes("moving_depth_control", "move_depth_control"),
            word("draining", drained_compartment),
            is_working("hover"),
            word("trim_mode", trim_mode),
        ),
    ),
    Channel(
        "air",
        "the air banks",
        (
            *(field for i, bank in enumerate(BANKS) for field in bank_fields(i, bank)),
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
