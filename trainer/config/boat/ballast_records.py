"""The table [ballast] of a vessel file: its keys, and whether they fit together.

``vessel`` reads it, and ``boat/assemble`` fits the tanks. Every boat has the same named places
(tanks, air bank, pumps), because the core's record has them; a file leaves out those that its boat
lacks. Units are those of the file.
"""

from dataclasses import dataclass
from typing import Any, Final

from trainer.config.schema import (
    Choice,
    Quantities,
    Quantity,
    Rows,
    Table,
    optional,
    required,
    within,
)
from trainer.core.ballast.tanks import (
    BANKS,
    BLOWN_TANKS,
    COMPARTMENTS,
    MAX_DENSITY_LAYERS,
    PUMPED_TANKS,
)

MIN_TRIM_SHARE: Final = 1e-4  # [-] of the displaced volume, the least for automatic trim


def _centre() -> Any:
    """Return a point x, y, z [m] in body axes."""
    point = Quantity("m", within(-200, 200), "centre of its volume, x y z from the body's origin")
    return required(Quantities(point, 3, 3))


def _volume(meaning: str) -> Any:
    """Return a volume [m3]."""
    return required("m3", within(1e-7, 1e5), meaning)


def _share(meaning: str) -> Any:
    """Return a filling [-]."""
    return required("-", within(0, 1), meaning)


def _area(unit: str, meaning: str) -> Any:
    """Return an effective area [unit], discharge coefficient included."""
    return required(unit, within(0, 1e6), f"effective area of {meaning}")


@dataclass(frozen=True, kw_only=True)
class BlownTank:
    """A tank open to the sea at its foot, emptied by air."""

    name: str = required(Choice(BLOWN_TANKS, "which"))
    capacity_m3: float = _volume("what it holds")
    centre_m: tuple[float, float, float] = _centre()
    height_m: float = required("m", within(1e-3, 50), "flood port to vent")
    start_fill: float = _share("filling at which weight and cg of [vessel] hold")
    flood_port_m2: float = _area("m2", "its flood ports")
    vent_cm2: float = _area("cm2", "its vent")
    blow_mm2: float = _area("mm2", "its blow valve")
    emergency_blow_mm2: float = _area("mm2", "its emergency blow valve")


@dataclass(frozen=True, kw_only=True)
class PumpedTank:
    """A tank within the hull, vented inboard."""

    name: str = required(Choice(PUMPED_TANKS, "which"))
    capacity_m3: float = _volume("what it holds")
    centre_m: tuple[float, float, float] = _centre()
    start_fill: float = _share("filling at which weight and cg of [vessel] hold")


@dataclass(frozen=True, kw_only=True)
class Compartment:
    """A part of the pressure hull that may be flooded."""

    name: str = required(Choice(COMPARTMENTS, "which"))
    capacity_m3: float = _volume("water that it takes")
    centre_m: tuple[float, float, float] = _centre()


@dataclass(frozen=True, kw_only=True)
class Bank:
    """Bottles of compressed air."""

    name: str = required(Choice(BANKS, "which"))
    volume_m3: float = _volume("of its bottles")
    pressure_mpa: float = required("MPa", within(0, 100), "absolute pressure at the start")


@dataclass(frozen=True, kw_only=True)
class Air:
    """The air itself, and what compresses it."""

    temperature_c: float = required("degC", within(-5, 40), "of the air throughout")
    compressor_kg_s: float = required("kg/s", within(0, 100), "charging rate; 0: none")
    intake_depth_m: float | None = optional(
        Quantity("m", within(-100, 100), "deepest origin with air; left out: hull awash")
    )


@dataclass(frozen=True, kw_only=True)
class Pumps:
    """Rates of the pumps."""

    trim_kg_s: float = required("kg/s", within(0, 1e4), "trim transfer, either way")
    drain_kg_s: float = required("kg/s", within(0, 1e4), "trim-and-drain, at the surface")
    depth_control_kg_s: float = required("kg/s", within(0, 1e4), "depth control, likewise")
    shutoff_depth_m: float = required("m", within(0.1, 12000), "deepest they pump out against")


@dataclass(frozen=True, kw_only=True)
class HoverControl:
    """The law by which the depth-control tank keeps depth by itself."""

    frequency_rad_s: float = required("rad/s", within(1e-4, 1), "natural frequency")
    depth_rate_m_s: float = required("m/s", within(1e-4, 10), "largest depth rate it asks for")


@dataclass(frozen=True, kw_only=True)
class HullBuoyancy:
    """The change of the hull's buoyancy with depth; all numbers may be 0."""

    compressibility_kg_m: float = required("kg/m", within(0, 1e5), "buoyancy lost with depth")
    reference_depth_m: float = required(
        "m", within(0, 12000), "where the buoyancy of [vessel] holds"
    )
    layer_depth_m: tuple[float, ...] = required(
        Quantities(
            Quantity("m", within(0, 12000), "depths of layer_kg_m3, ascending"),
            0,
            MAX_DENSITY_LAYERS,
        )
    )
    layer_kg_m3: tuple[float, ...] = required(
        Quantities(
            Quantity("kg/m3", within(-50, 50), "density less rho of [fluid]"), 0, MAX_DENSITY_LAYERS
        )
    )


@dataclass(frozen=True, kw_only=True)
class Ballast:
    """All of a boat's tanks and air."""

    blown: tuple[BlownTank, ...] = required(
        Rows(BlownTank, ("note",), 0, len(BLOWN_TANKS), "tanks emptied by air, below")
    )
    pumped: tuple[PumpedTank, ...] = required(
        Rows(PumpedTank, ("note",), 0, len(PUMPED_TANKS), "tanks with pumps, below")
    )
    compartments: tuple[Compartment, ...] = required(
        Rows(Compartment, ("note",), 0, len(COMPARTMENTS), "what may be flooded, below")
    )
    banks: tuple[Bank, ...] = required(Rows(Bank, ("note",), 0, len(BANKS), "air, below"))
    air: Air = required(Table(Air, "below"))  # noqa: RUF009  (a frozen description)
    pumps: Pumps = required(Table(Pumps, "below"))  # noqa: RUF009  (a frozen description)
    hover: HoverControl = required(Table(HoverControl, "below"))  # noqa: RUF009  (a frozen description)
    sea: HullBuoyancy = required(Table(HullBuoyancy, "below"))  # noqa: RUF009  (a frozen description)


def ballast_problems(ballast: Ballast) -> list[str]:
    """Return what does not fit among tables that are right one by one."""
    problems = []
    for key in ("blown", "pumped", "compartments", "banks"):
        names = [row.name for row in getattr(ballast, key)]
        problems += [
            f"{key}: {name} is given twice"
            for name in dict.fromkeys(names)
            if names.count(name) > 1
        ]
    depths = ballast.sea.layer_depth_m
    if len(depths) != len(ballast.sea.layer_kg_m3):
        problems.append(
            f"sea.layer_kg_m3 = {list(ballast.sea.layer_kg_m3)}: has "
            f"{len(ballast.sea.layer_kg_m3)} entries, layer_depth_m has {len(depths)}"
        )
    if list(depths) != sorted(set(depths)):
        problems.append(f"sea.layer_depth_m = {list(depths)}: must ascend, none twice")
    return problems


def ballast_remarks(ballast: Ballast, displaced: float) -> list[str]:
    """Return which tanks are too small for automatic trim of so much displaced volume [m3]."""
    least = MIN_TRIM_SHARE * displaced
    return [
        f"pumped: {row.name}: capacity_m3 = {row.capacity_m3:g}: automatic trim wants {least:.2g} "
        "m3 or more; it will tell when the tank has no more to give"
        for row in ballast.pumped
        if row.name.startswith("trim") and row.capacity_m3 < least
    ]
