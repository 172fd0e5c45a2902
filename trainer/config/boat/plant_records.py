"""The table [plant] of a vessel file: its keys, and whether they fit together.

``vessel`` reads it, and ``boat/assemble`` fits the plant. Every plant has the same named parts (oil
systems, buses, consumers, compartments), because the core's record has them. Units are those of
the file.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from trainer.config.schema import (
    Choice,
    Choices,
    Rows,
    Table,
    above,
    optional,
    required,
    within,
)
from trainer.core.plant.parts import (
    BURNING_ITEMS,
    BUS_NAMES,
    CONSUMER_NAMES,
    MODE_NAMES,
    OIL_PUMPS,
    PLACE_NAMES,
)

NORMAL_MODE, EMERGENCY_MODE, HAND_MODE = MODE_NAMES


def _power(meaning: str) -> Any:
    """Return a power [W]."""
    return required("W", within(0, 1e9), meaning)


def _time(meaning: str) -> Any:
    """Return a time [s] above 0."""
    return required("s", above(0, 1e5), meaning)


@dataclass(frozen=True, kw_only=True)
class OilSystem:
    """An oil system: its accumulator and its tank."""

    full_mpa: float = required("MPa", above(0, 100), "pressure of the full accumulator")
    low_mpa: float = required("MPa", above(0, 100), "pressure of its gas without oil")
    usable_m3: float = required("m3", above(0, 100), "oil of the full accumulator")
    tank_m3: float = required("m3", above(0, 1000), "oil in the tank at the start")


@dataclass(frozen=True, kw_only=True)
class OilPump:
    """A pump of oil, which fills its system's accumulator."""

    name: str = required(Choice(OIL_PUMPS, "which"))
    start_mpa: float = required("MPa", above(0, 100), "it starts below this pressure")
    rate_l_s: float = required("L/s", above(0, 1000), "what it delivers")


@dataclass(frozen=True, kw_only=True)
class SurfaceOil:
    """The oil that surfaces draw, and what each way of moving them gives."""

    modes: tuple[str, ...] = required(Choices(MODE_NAMES, "ways to move the surfaces"))
    rudder_l: float = required("L", above(0, 1e5), "oil for 60 degrees of rudder")
    stern_l: float = required("L", above(0, 1e5), "... of stern planes")
    bow_l: float = required("L", above(0, 1e5), "... of bow planes")
    rated_mpa: float = required("MPa", above(0, 100), "from here up they have their whole rate")
    dead_mpa: float = required("MPa", within(0, 100), "from here down they do not move")
    emergency_share: float = required("-", above(0, 1), "of the rate, in emergency")
    hand_deg_s: float = required("deg/s", above(0, 90), "rate in hand")
    shift_s: float = _time("to shift to normal or emergency")
    man_s: float = _time("to shift to hand")
    trail_share: float = required(
        "-", within(0, 1), "of the rate, with which an unfed surface goes to zero; 0: it stays"
    )


@dataclass(frozen=True, kw_only=True)
class Consumer:
    """What draws power, and from where."""

    name: str = required(Choice(CONSUMER_NAMES, "which"))
    buses: tuple[str, ...] = required(Choices(BUS_NAMES, "what can feed it"))
    power_w: float = _power("drawn while it runs")


@dataclass(frozen=True, kw_only=True)
class Hotel:
    """The small consumers of a bus together."""

    bus: str = required(Choice(BUS_NAMES, "which"))
    power_w: float = _power("drawn")
    shed_w: float = _power("of it, that `loads shed` takes off")


@dataclass(frozen=True, kw_only=True)
class Battery:
    """The battery, its buses, and what the propeller draws."""

    capacity_kwh: float = required("kWh", above(0, 1e6), "charge at the start")
    cell_w: float = required("W", above(0, 1e9), "drained P (1 + P / this) for a power P")
    propeller_w: float = required("W", above(0, 1e9), "at propeller_kn, by the cube of the speed")
    propeller_kn: float = required("kn", above(0, 100), "command speed of propeller_w")
    bus_limit_w: float = required("W", above(0, 1e9), "most that a breaker carries for long")
    overload_s: float = _time("for which it carries more")
    gyro_s: float = required("s", within(0, 1e5), "the gyro's own battery")


@dataclass(frozen=True, kw_only=True)
class Fire:
    """How a fire grows, is fought, and smokes."""

    start: float = required("-", above(0, 1), "size at severity 1; 1: the whole compartment")
    growth_s: float = _time("f' = f (1 - f) / this")
    fight_s: float = _time("f' = -f / this, well fought")
    party_s: float = required("s", within(0, 1e5), "from `fight fire` until it is fought")
    out: float = required("-", above(0, 1), "size below which it is out")
    smoke_s: float = _time("smoke s' = f (1 - s) / this")
    spread_s: float = _time("in which ventilation mixes it")
    clear_s: float = _time("in which exhausting clears it")


@dataclass(frozen=True, kw_only=True)
class Compartment:
    """A compartment that can burn."""

    name: str = required(Choice(PLACE_NAMES, "which"))
    bus: str | None = optional(Choice(BUS_NAMES, "that has to be dead to fight it well; none"))


@dataclass(frozen=True, kw_only=True)
class BurningItem:
    """What a fire takes away."""

    name: str = required(Choice(BURNING_ITEMS, "a consumer or a bus"))
    compartment: str = required(Choice(PLACE_NAMES, "where it stands"))
    dose_s: float = _time("of a whole compartment's fire that it stands")


@dataclass(frozen=True, kw_only=True)
class Plant:
    """What feeds surfaces, pumps, gauges and propulsion."""

    main: OilSystem = required(Table(OilSystem, "below"))  # noqa: RUF009  (a frozen description)
    vital: OilSystem = required(Table(OilSystem, "below"))  # noqa: RUF009  (a frozen description)
    surfaces: SurfaceOil = required(Table(SurfaceOil, "below"))  # noqa: RUF009  (a frozen description)
    battery: Battery = required(Table(Battery, "below"))  # noqa: RUF009  (a frozen description)
    fire: Fire = required(Table(Fire, "below"))  # noqa: RUF009  (a frozen description)
    pumps: tuple[OilPump, ...] = required(
        Rows(OilPump, ("note",), len(OIL_PUMPS), len(OIL_PUMPS), "of oil, below")
    )
    consumers: tuple[Consumer, ...] = required(
        Rows(Consumer, ("note",), len(CONSUMER_NAMES), len(CONSUMER_NAMES), "all of them, below")
    )
    hotel: tuple[Hotel, ...] = required(Rows(Hotel, ("note",), 0, len(BUS_NAMES), "by bus, below"))
    compartments: tuple[Compartment, ...] = required(
        Rows(Compartment, ("note",), len(PLACE_NAMES), len(PLACE_NAMES), "that can burn, below")
    )
    burning: tuple[BurningItem, ...] = required(
        Rows(BurningItem, ("note",), 0, len(BURNING_ITEMS), "what fires take away, below")
    )


def plant_problems(plant: Plant) -> list[str]:
    """Return what does not fit among tables that are right one by one."""
    problems = list(_twice(plant))
    for name in ("main", "vital"):
        system = getattr(plant, name)
        if system.low_mpa >= system.full_mpa:
            problems.append(
                f"{name}.low_mpa = {system.low_mpa:g}: must be below full_mpa = {system.full_mpa:g}"
            )
    surfaces = plant.surfaces
    if surfaces.dead_mpa >= surfaces.rated_mpa:
        problems.append(
            f"surfaces.dead_mpa = {surfaces.dead_mpa:g}: must be below "
            f"rated_mpa = {surfaces.rated_mpa:g}"
        )
    if NORMAL_MODE not in surfaces.modes:
        problems.append(f"surfaces.modes = {list(surfaces.modes)}: lacks {NORMAL_MODE!r}")
    problems += [
        f"consumers: {row.name} has no bus: give it one of {', '.join(BUS_NAMES)}"
        for row in plant.consumers
        if not row.buses
    ]
    problems += [
        f"hotel: {row.bus}: shed_w = {row.shed_w:g}: must be at most power_w = {row.power_w:g}"
        for row in plant.hotel
        if row.shed_w > row.power_w
    ]
    for pump in plant.pumps:
        system = plant.vital if pump.name == "vital" else plant.main
        if pump.start_mpa > system.full_mpa:
            problems.append(
                f"pumps: {pump.name}: start_mpa = {pump.start_mpa:g}: must be at most the "
                f"system's full_mpa = {system.full_mpa:g}"
            )
    return problems


def _twice(plant: Plant) -> Iterator[str]:
    """Yield the rows that are given twice."""
    for key in ("pumps", "consumers", "compartments", "burning", "hotel"):
        names = [getattr(row, "name", "") or row.bus for row in getattr(plant, key)]
        for name in dict.fromkeys(names):
            if names.count(name) > 1:
                yield f"{key}: {name} is given twice"
