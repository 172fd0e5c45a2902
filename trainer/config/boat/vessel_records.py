"""The tables of a vessel file. Each record has keys with their unit, limits and meaning.

Units are those of the file. The coefficients are in ``coefficients``. ``vessel`` reads files by
them. Unit, limits and meaning of a key stand here once, and serve the reader, its
messages, the JSON Schema and docs/vessel-keys.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from trainer.config.schema import (
    Choice,
    Choices,
    NamedNumbers,
    NumberLimits,
    Quantities,
    Quantity,
    Rows,
    above,
    optional,
    required,
    within,
)
from trainer.core.terms import COMPACT_TERMS, EXTRA_TERMS

ENGINE_BELLS = (
    "ahead_one_third",
    "ahead_two_thirds",
    "ahead_standard",
    "ahead_full",
    "ahead_flank",
    "astern_one_third",
    "astern_two_thirds",
    "astern_full",
)
MAX_SPEEDS = 12  # entries of a gain table
MAX_DEPTHS, MAX_SURFACE_ROWS = 8, 6  # of the tables of the calm surface
WAVE_STRIP_COUNT = 7  # of the hull in waves


def _gain(unit: str, meaning: str) -> Quantities:
    """Return a list of gains [unit], one for each entry of speed_kn."""
    return Quantities(Quantity(unit, within(-1e4, 1e4), meaning), 2, MAX_SPEEDS)


def _positive(unit: str, meaning: str) -> Quantities:
    """Return a list of limits [unit] above zero, one for each entry of speed_kn."""
    return Quantities(Quantity(unit, within(1e-6, 1e4), meaning), 2, MAX_SPEEDS)


def _centre(meaning: str) -> Quantities:
    """Return a point x, y, z [m] in body axes."""
    return Quantities(Quantity("m", within(-200, 200), meaning), 3, 3)


def _size(meaning: str) -> Quantity:
    """Return a dimension [m] of the hull."""
    return Quantity("m", within(0.01, 500), meaning)


def _prime_inertia(name: str) -> Quantity:
    """Return a moment of inertia [-] in the prime system, which the program compares only."""
    return Quantity("-", within(1e-9, 1), f"checked: {name}/(rho/2 L^5)")


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """The water, and gravity."""

    rho: float = required(Quantity("kg/m3", within(900, 1100), "water density"))
    g: float = required(Quantity("m/s2", within(9.7, 9.9), "gravity"))


@dataclass(frozen=True, kw_only=True)
class Hull:
    """Size, mass and centres; x forward, y starboard, z down from the body's origin."""

    length: float = required(
        Quantity("m", within(0.3, 400), "reference length L of the coefficients")
    )
    mass: float = required(
        Quantity("kg", within(1e-3, 1e9), "mass, with water in free-flooding spaces")
    )
    weight: float = required(Quantity("N", within(1e-2, 1e10), "weight"))
    buoyancy: float = required(Quantity("N", within(1e-2, 1e10), "buoyancy"))
    cg: tuple[float, float, float] = required(_centre("centre of gravity"))
    cb: tuple[float, float, float] = required(_centre("centre of buoyancy"))
    Ix: float = required(Quantity("kg m2", within(1e-9, 1e13), "moment of inertia in roll"))
    Iy: float = required(Quantity("kg m2", within(1e-9, 1e13), "moment of inertia in pitch"))
    Iz: float = required(Quantity("kg m2", within(1e-9, 1e13), "moment of inertia in yaw"))
    Ixy: float = required(Quantity("kg m2", within(-1e12, 1e12), "integral of x y dm"))
    Iyz: float = required(Quantity("kg m2", within(-1e12, 1e12), "integral of y z dm"))
    Ixz: float = required(Quantity("kg m2", within(-1e12, 1e12), "integral of x z dm"))
    displaced_volume: float | None = optional(
        Quantity("m3", within(1e-6, 1e7), "checked: buoyancy/(rho g)")
    )
    m_prime: float | None = optional(
        Quantity("-", within(1e-6, 10), "checked: mass/(rho/2 L^3)"),
    )
    Ix_prime: float | None = optional(_prime_inertia("Ix"))
    Iy_prime: float | None = optional(_prime_inertia("Iy"))
    Iz_prime: float | None = optional(_prime_inertia("Iz"))
    max_depth_m: float | None = optional(
        Quantity("m", within(0.1, 12000), "deepest depth that may be ordered; else test_depth_m")
    )
    test_depth_m: float | None = optional(
        Quantity("m", within(0.1, 12000), "test depth, called out; none: never")
    )
    collapse_depth_m: float | None = optional(
        Quantity("m", within(0.1, 12000), "depth at which the hull is lost; none: never")
    )
    beam: float | None = optional(_size("greatest breadth"))
    diameter: float | None = optional(_size("diameter of a round hull"))
    height_to_deck: float | None = optional(_size("keel to deck"))
    height_to_sail_top: float | None = optional(_size("keel to top of sail"))
    cg_below_sail_top: float | None = optional(_size("top of sail to centre of gravity"))
    cg_from_nose: float | None = optional(_size("nose to centre of gravity"))
    sail_from_nose: float | None = optional(_size("nose to middle of sail"))


@dataclass(frozen=True, kw_only=True)
class ThrustSet:
    """One row of thrust minus drag. It is rho/2 L^2 (a u^2 + b u uc + c uc^2)."""

    eta_min: float = required(Quantity("-", within(-100, 100), "used from eta of this"))
    a: float = required(Quantity("-", within(-10, 10), "factor of u^2"))
    b: float = required(Quantity("-", within(-10, 10), "factor of u uc"))
    c: float = required(Quantity("-", within(-10, 10), "factor of uc^2"))
    going: str | None = optional(
        Choice(("ahead", "astern"), "which way the boat goes; ahead where it is not said")
    )


@dataclass(frozen=True, kw_only=True)
class Propulsion:
    """Thrust, the engine's answer to an order, and the bells; uc is command speed."""

    sets: tuple[ThrustSet, ...] = required(
        Rows(ThrustSet, ("status",), 1, 5, "thrust rows, below: up to 3 ahead, 2 or none astern"),
    )
    eta_speed: str | None = optional(
        Choice(("ahead", "whole"), "eta is uc over speed ahead u, or over the whole U; else ahead")
    )
    rps_per_mps: float = required(
        Quantity("1/m", within(1e-3, 1000), "turns a second per m/s of uc")
    )
    dead_time_s: float = required(Quantity("s", within(0, 600), "order to first change of uc"))
    time_constant_s: float = required(
        Quantity("s", within(0, 600), "of uc's approach to the order")
    )
    max_ordered_speed_kn: float = required(
        Quantity("kn", within(0.01, 60), "largest command speed")
    )
    bells_kn: Mapping[str, float] = required(
        NamedNumbers(Quantity("kn", within(-60, 60), "command speed of each bell"), ENGINE_BELLS),
    )
    propeller_diameter: float | None = optional(Quantity("m", within(0.01, 20), "of the propeller"))
    KQ: tuple[float, ...] | None = optional(
        Quantities(Quantity("-", within(-10, 10), "torque by J: q0, q1, q2 of J^0, J, J^2"), 3, 3)
    )
    torque_limit_n_m: float | None = optional(
        Quantity("N m", within(1e-3, 1e8), "the engine's most; needs KQ and propeller_diameter")
    )
    shaft_power_w: float | None = optional(
        Quantity("W", within(1e-2, 1e9), "the most the shaft takes; alone: it gives the torque too")
    )


@dataclass(frozen=True, kw_only=True)
class Surfaces:
    """Rudder and planes."""

    rudder_limit_deg: float = required(Quantity("deg", within(0.1, 90), "rudder either way"))
    stern_plane_limit_deg: float = required(
        Quantity("deg", within(0.1, 90), "stern planes either way")
    )
    bow_plane_limit_deg: float = required(Quantity("deg", within(0, 90), "bow planes; 0: has none"))
    rate_deg_s: float = required(Quantity("deg/s", within(0.01, 1000), "fastest movement of each"))
    time_constant_s: float = required(Quantity("s", within(0, 60), "lag of each; 0: none"))
    tail: str = required(Choice(("x", "cruciform"), "x: rudder and stern planes share one limit"))


def _angle(most: float, meaning: str) -> Quantity:
    """Return an angle [deg] up to ``most``."""
    return Quantity("deg", within(0.1, most), meaning)


def _by_surface(quantity: Quantity) -> Quantities:
    """Return three numbers: of the rudder, the stern planes and the bow planes."""
    return Quantities(quantity, 3, 3)


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """The boat beyond the range of the coefficients; what is left out follows from them."""

    tested_deg: float | None = optional(
        _angle(60, "flow off the bow beyond which the coefficients are extrapolated; 12")
    )
    handover_deg: tuple[float, float] | None = optional(
        Quantities(_angle(89, "flow from and to which the wide set takes over; 35, 55"), 2, 2)
    )
    hull_share_horizontal: float | None = optional(
        Quantity("-", within(0, 1), "of the hull in Y_v, whose lift acts at the bow astern; 0.5")
    )
    hull_share_vertical: float | None = optional(
        Quantity("-", within(0, 1), "of the hull in Z_w; 0.5")
    )
    drag_astern: float | None = optional(
        Quantity("-", within(0.1, 10), "axial drag astern over that ahead; 1.2")
    )
    plane_effect_astern: float | None = optional(
        Quantity("-", within(0, 2), "lift of rudder and planes astern over that ahead; 0.6")
    )
    stall_deg: tuple[float, ...] | None = optional(
        _by_surface(_angle(90, "incidence at which rudder, stern, bow planes stall; never"))
    )
    stall_slope: tuple[float, ...] | None = optional(
        _by_surface(Quantity("-", within(0, 1), "of their lift slope left beyond; 0"))
    )
    stall_astern_deg: tuple[float, ...] | None = optional(
        _by_surface(_angle(90, "angle at which they stall astern; 18"))
    )
    strip_width: tuple[float, ...] | None = optional(
        Quantities(Quantity("-", within(0, 10), "of the hull's five strips from aft; equal"), 5, 5)
    )
    crossflow_y: float | None = optional(
        Quantity("-", within(0, 10), "cross-flow drag of the hull in sway; that of Y_vav")
    )
    crossflow_z: float | None = optional(
        Quantity("-", within(0, 10), "... in heave; that of Z_waw")
    )
    tail_place: float | None = optional(
        Quantity("-", within(-0.6, 0.6), "of the tail, in lengths from the origin; no tail")
    )
    tail_y: float | None = optional(Quantity("-", within(0, 10), "its cross-flow drag in sway; 0"))
    tail_z: float | None = optional(Quantity("-", within(0, 10), "... in heave; 0"))
    sail_place: tuple[float, float] | None = optional(
        Quantities(Quantity("m", within(-200, 200), "x and z of the sail's middle; no sail"), 2, 2)
    )
    sail_y: float | None = optional(Quantity("-", within(0, 10), "its cross-flow drag; 0"))
    sail_lift: float | None = optional(
        Quantity(
            "-",
            within(0, 10),
            "its lift slope, hull's share too, as in Y_v; so far as it feeds no motion; 0",
        )
    )
    sail_lift_place: tuple[float, float] | None = optional(
        Quantities(Quantity("m", within(-200, 200), "x and z of where that lift acts"), 2, 2)
    )
    sail_added_mass: float | None = optional(
        Quantity("kg", within(0, 1e9), "its share of the added mass in sway; 0")
    )
    surface_damping: float | None = optional(
        Quantity("-", within(0, 1), "damping ratio of a hull that the surface cuts; 0.03")
    )


@dataclass(frozen=True, kw_only=True)
class CompactTerms:
    """The terms of this hull's compact set beyond the 60 of the report."""

    extra_terms: tuple[str, ...] = required(Choices(EXTRA_TERMS, "more terms that are kept"))


@dataclass(frozen=True, kw_only=True)
class HeldTerms:
    """The terms that no search for a compact set drops or changes."""

    held_terms: tuple[str, ...] = required(
        Choices((*COMPACT_TERMS, *EXTRA_TERMS), "terms never dropped, their factor 1")
    )


@dataclass(frozen=True, kw_only=True)
class RunDefaults:
    """How a run starts unless the command says otherwise."""

    step_s: float = required(Quantity("s", within(0.001, 2), "time step"))
    start_speed_kn: float = required(Quantity("kn", within(0.01, 60), "speed at the start"))
    start_depth_m: float = required(Quantity("m", within(0, 12000), "depth at the start"))
    speed_range_kn: tuple[float, float] = required(
        Quantities(
            Quantity("kn", within(0.01, 60), "slowest and fastest speed to be controlled"), 2, 2
        ),
    )
    periscope_depth_m: float | None = optional(
        Quantity("m", within(0.05, 100), "depth kept by `periscope depth`; may be left out")
    )


@dataclass(frozen=True, kw_only=True)
class Autopilot:
    """Gains as lists over speed, and what does not depend on it. Angles in rad unless named."""

    speed_kn: tuple[float, ...] = required(
        Quantities(Quantity("kn", within(0, 60), "speeds of the lists, ascending"), 2, MAX_SPEEDS),
    )
    stern_depth: tuple[float, ...] = required(_gain("rad/m", "stern planes per depth error"))
    stern_depth_rate: tuple[float, ...] = required(_gain("rad s/m", "... per depth rate"))
    stern_pitch: tuple[float, ...] = required(_gain("-", "... per pitch"))
    stern_pitch_rate: tuple[float, ...] = required(_gain("s", "... per pitch rate"))
    stern_integral: tuple[float, ...] = required(
        _gain("rad/(m s)", "... per integral of depth error")
    )
    stern_relief: tuple[float, ...] = required(
        _gain("1/s", "... per integral of the bow planes' angle")
    )
    bow_depth: tuple[float, ...] = required(_gain("rad/m", "bow planes per depth error"))
    bow_depth_rate: tuple[float, ...] = required(_gain("rad s/m", "... per depth rate"))
    bow_pitch: tuple[float, ...] = required(_gain("-", "... per pitch"))
    bow_pitch_rate: tuple[float, ...] = required(_gain("s", "... per pitch rate"))
    bow_integral: tuple[float, ...] = required(
        _gain("rad/(m s)", "... per integral of depth error")
    )
    bow_relief: tuple[float, ...] = required(_gain("1/s", "... per integral of their own angle"))
    rudder_course: tuple[float, ...] = required(_gain("-", "rudder per course error"))
    rudder_yaw_rate: tuple[float, ...] = required(_gain("s", "... per yaw rate"))
    rudder_sway: tuple[float, ...] = required(_gain("rad s/m", "... per sway speed"))
    rudder_integral: tuple[float, ...] = required(_gain("1/s", "... per integral of course error"))
    depth_rate_m_s: tuple[float, ...] = required(_positive("m/s", "depth rate allowed"))
    depth_acceleration_m_s2: tuple[float, ...] = required(_positive("m/s2", "its change allowed"))
    course_rate_deg_s: tuple[float, ...] = required(_positive("deg/s", "course rate allowed"))
    course_acceleration_deg_s2: tuple[float, ...] = required(
        _positive("deg/s2", "its change allowed")
    )
    speed_integral: float = required(
        Quantity("1/s", within(0, 10), "surge rate at the slowest of these speeds; learns trim")
    )
    turning_rate_deg_s: float = required(
        Quantity("deg/s", within(1e-3, 90), "a turn from this rate on")
    )


def _differences(meaning: str) -> Quantities:
    """Return a list of differences [-] of a coefficient, one for each entry of depth_m."""
    return Quantities(Quantity("-", within(-1, 1), meaning), 2, MAX_DEPTHS)


@dataclass(frozen=True, kw_only=True)
class SurfaceRow:
    """The addition of the calm surface to two coefficients at one speed."""

    speed_kn: float = required(Quantity("kn", within(0, 60), "speed of the row, ascending"))
    Z_star: tuple[float, ...] = required(_differences("Z_star less that in deep water, by depth_m"))
    M_star: tuple[float, ...] = required(_differences("M_star less that in deep water, by depth_m"))


@dataclass(frozen=True, kw_only=True)
class FreeSurface:
    """The calm surface's effect as tables of depth and speed, bilinear between."""

    depth_m: tuple[float, ...] = required(
        Quantities(
            Quantity("m", within(0, 12000), "depths of the origin, ascending; none below the last"),
            2,
            MAX_DEPTHS,
        ),
    )
    rows: tuple[SurfaceRow, ...] = required(
        Rows(SurfaceRow, ("note",), 2, MAX_SURFACE_ROWS, "rows, below")
    )
    Z_w: tuple[float, ...] | None = optional(
        _differences("Z_w less that in deep water, by depth_m; without it the same")
    )
    M_w: tuple[float, ...] | None = optional(
        _differences("M_w less that in deep water, by depth_m; without it the same")
    )


def _by_strip(unit: str, limits: NumberLimits, meaning: str) -> Quantities:
    """Return seven numbers, one for each strip."""
    return Quantities(Quantity(unit, limits, meaning), WAVE_STRIP_COUNT, WAVE_STRIP_COUNT)


@dataclass(frozen=True, kw_only=True)
class WaveStrips:
    """The seven parts along the hull that waves push on."""

    x_m: tuple[float, ...] = required(
        _by_strip("m", within(-400, 400), "place of each from the origin")
    )
    displaced_kg: tuple[float, ...] = required(
        _by_strip("kg", above(0, 1e9), "displaced mass; the sum must be buoyancy/g, about cb")
    )
    added_down_kg: tuple[float, ...] = required(
        _by_strip("kg", within(0, 1e9), "added mass in heave; its shares of -Z_wdot are used")
    )
    added_side_kg: tuple[float, ...] = required(
        _by_strip("kg", within(0, 1e9), "added mass in sway; its shares of -Y_vdot are used")
    )


@dataclass(frozen=True, kw_only=True)
class Scope:
    """The periscope, which stands on the sail's top and comes out of it."""

    x_m: float = required(
        Quantity("m", within(-400, 400), "place of the mast, forward of the origin")
    )
    extension_m: float = required(Quantity("m", above(0, 30), "head over the sail's top, all out"))
    raise_s: float = required(Quantity("s", within(0.1, 600), "time from all in to all out"))
    speed_kn_max: float = required(Quantity("kn", above(0, 60), "at which the mast may be out"))
