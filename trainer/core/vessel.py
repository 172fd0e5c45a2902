"""Constants of one boat, dimensional, computed once from its prime coefficients.

``VESSEL`` carries the full set [GH67]; ``COMPACT`` the constants of the compact set by the mapping
of program EC790, [ASSES] equation (18) with its errata C10-C18. ``boat/assemble`` makes both
records from a vessel file.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trainer.core.ballast.tanks import BALLAST_FIELDS
from trainer.core.envelope import ENVELOPE_FIELDS
from trainer.core.kernel import Numbers, Record, record_dtype
from trainer.core.plant.parts import PLANT_FIELDS
from trainer.core.state import STRIP_COUNT
from trainer.core.terms import (
    COMPACT_TERMS,
    EXTRA_TERMS,
    LENGTH_POWERS,
    SLIP_TERMS,
    THRUST_KEYS,
)

INVERTED_NAMES: Final = {"K_pdot": "T4", "M_qdot": "T5", "N_rdot": "T6"}  # as [ASSES] (18) has them

MAX_GAIN_SPEEDS: Final = 12  # longest schedule of autopilot gains
PLANE_GAINS: Final = ("depth", "depth_rate", "pitch", "pitch_rate", "integral", "relief")
GAINS: Final = [
    *(f"stern_{name}" for name in PLANE_GAINS),
    *(f"bow_{name}" for name in PLANE_GAINS),
    "rudder_course",
    "rudder_yaw_rate",
    "rudder_sway",
    "rudder_integral",
    "depth_rate",
    "depth_acceleration",
    "course_rate",
    "course_acceleration",
]
# indices in a row of gains: where those of a pair of planes begin, and from there on
STERN_GAINS: Final = GAINS.index("stern_depth")
PLANE_COUNT: Final = len(PLANE_GAINS)
DEPTH_GAIN: Final = PLANE_GAINS.index("depth")
DEPTH_RATE_GAIN: Final = PLANE_GAINS.index("depth_rate")
PITCH_GAIN: Final = PLANE_GAINS.index("pitch")
PITCH_RATE_GAIN: Final = PLANE_GAINS.index("pitch_rate")
INTEGRAL_GAIN: Final = PLANE_GAINS.index("integral")
RELIEF_GAIN: Final = PLANE_GAINS.index("relief")
# the rudder's
COURSE_GAIN: Final = GAINS.index("rudder_course")
YAW_RATE_GAIN: Final = GAINS.index("rudder_yaw_rate")
SWAY_GAIN: Final = GAINS.index("rudder_sway")
COURSE_INTEGRAL_GAIN: Final = GAINS.index("rudder_integral")
# the slewing of depth and course, a rate and an acceleration each
DEPTH_SLEW: Final = GAINS.index("depth_rate")
SLEW_COUNT: Final = GAINS.index("course_rate") - DEPTH_SLEW
SLEW_RATE, SLEW_ACCELERATION = 0, 1

SURFACE_DEPTHS, SURFACE_SPEEDS = 8, 6  # largest tables of the calm surface's effect

# fmt: off
BODY_NAMES: Final = [
    "rho", "g", "ell", "mass", "weight", "buoyancy",
    "x_g", "y_g", "z_g", "x_b", "y_b", "z_b",
    "I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz",
]
# fmt: on

VESSEL: Final = record_dtype(
    # what every tick reads comes first: that makes the machine code shorter
    # control surfaces
    ("limit", ["limit_r", "limit_s", "limit_b"]),  # [rad]
    "surface_rate",  # [rad/s]
    "surface_lag",  # [s] time constant
    "x_tail",  # [-] 1: rudder and stern planes are the same four X planes
    # propulsion
    "telegraph_dead_time",  # [s]
    "propulsion_lag",  # [s] time constant of the revolutions
    "u_c_ahead",  # [m/s] largest command speed
    "u_c_astern",  # [m/s] most negative command speed
    # autopilot
    "speed_integral",  # [1/s] at the slowest speed of the schedule, more in proportion
    "turning_rate",  # [rad/s] from there on the trims of speed and rudder rest
    "gain_count",  # [-] speeds in the schedule; 0: no autopilot
    # the hull
    *BODY_NAMES,
    "eta_1",  # [-] thrust row 1 holds from here up, row 2 down to eta_2, row 3 below
    "eta_2",
    "eta_whole",  # [-] 1: eta = u_c/U, 0: u_c/u
    *THRUST_KEYS,
    *LENGTH_POWERS,
    # its schedule of gains
    ("gain_speed", (MAX_GAIN_SPEEDS,)),  # [m/s]
    ("gain", (MAX_GAIN_SPEEDS, len(GAINS))),
    # the boat near the surface
    "diameter",  # [m] of the hull; 0: not known
    "x_sail",  # [m] of the sail's top, in body axes
    "z_sail",
    "z_deck",  # [m] of the deck along the parallel middle body
    "surface_depths",  # [-] columns of the tables below; 0: no tables
    "surface_speeds",  # [-] rows
    ("surface_depth", (SURFACE_DEPTHS,)),  # [m] ascending, of the origin
    ("surface_speed", (SURFACE_SPEEDS,)),  # [m/s] ascending
    ("surface_Z", (SURFACE_SPEEDS, SURFACE_DEPTHS)),  # [N s2/m2] Z_star less that in deep water
    ("surface_M", (SURFACE_SPEEDS, SURFACE_DEPTHS)),  # [N s2/m]
    ("surface_Z_w", (SURFACE_DEPTHS,)),  # [N s2/m2] Z_w less that in deep water
    ("surface_M_w", (SURFACE_DEPTHS,)),  # [N s2/m]
    *BALLAST_FIELDS,
    *ENVELOPE_FIELDS,
    # [-] strips that waves push on: x over the length, shares of the displaced mass and of the
    # added mass down and sideways
    ("strips", (4, STRIP_COUNT)),
    *PLANT_FIELDS,
)

# The strips of a hull whose file has none: ellipsoid nose, parallel middle, cusped tail, prismatic
# coefficient 0.81 (that of Joubert's BB2); the added masses lie as the displaced mass does.
STRIP_STATIONS: Final = (0.37033, 0.24671, 0.10427, -0.03947, -0.18323, -0.31885, -0.43564)
STRIP_SHARES: Final = (0.10849, 0.17622, 0.17638, 0.17948, 0.17638, 0.14648, 0.03657)


Prime = Mapping[str, float | Numbers]  # [-] a number, or one for each member of a fleet
Eta = tuple[float, float, float]  # [-] where thrust rows 1 and 2 begin; 1 for eta by U, 0 by u


def _members(prime: Prime) -> int:
    """Return how many boats the coefficients are of."""
    return max(np.size(value) for value in prime.values())


def _scale(body: Mapping[str, float], power: int) -> float:
    """Return rho/2 l^power in SI units."""
    return float(0.5 * body["rho"] * body["ell"] ** power)


def strips(stations: ArrayLike, *masses: ArrayLike) -> Numbers:
    """Return stations and three masses of the strips, as shares [-].

    The stations are over the length. Each mass is divided by its sum over the strips.
    """
    shares = [np.array(mass) / np.sum(mass) for mass in masses]
    return np.array([stations, *shares])


def vessel_record(body: Mapping[str, float], prime: Prime, eta: Eta) -> Record:
    """Return the full-set constants; ``prime`` holds LENGTH_POWERS and THRUST_KEYS, dimensionless.

    Arrays make a record for each of their numbers. Control surfaces, propulsion dynamics and
    autopilot gains are left at zero. The strips are those of a hull that gives none.
    """
    vessel = np.zeros(_members(prime), VESSEL)
    for name in BODY_NAMES:
        vessel[name] = body[name]
    vessel["eta_1"], vessel["eta_2"], vessel["eta_whole"] = eta
    centre = body["x_b"] / body["ell"]
    vessel["strips"] = strips([x + centre for x in STRIP_STATIONS], *[STRIP_SHARES] * 3)
    for name, power in LENGTH_POWERS.items():
        vessel[name] = _scale(body, power) * prime.get(name, 0.0)
    for name in THRUST_KEYS:
        vessel[name] = _scale(body, 2) * prime.get(name, 0.0)
    return vessel


COMPACT: Final = record_dtype(
    "rho",
    "g",
    "mass",
    "weight",
    "buoyancy",
    "eta_1",
    "eta_2",
    "eta_whole",
    *THRUST_KEYS,
    *(INVERTED_NAMES.get(name, name) for name in COMPACT_TERMS),
    "ZB",  # [N m] buoyancy times z_b
    "extended",  # [-] 1: some of the following, besides those of slip, are kept
    "slipping",  # [-] 1: some of those of slip are kept
    *EXTRA_TERMS,
    "off_centre",  # [-] 1: some of the following are not zero
    "XB",  # [N m] buoyancy times x_b
    "YB",  # [N m] buoyancy times y_b
    "I_xy",  # [kg m2]
    "I_yz",
    "I_xz",
)


def compact_record(body: Mapping[str, float], prime: Prime, eta: Eta) -> Record:
    """Return the compact constants, [ASSES] (18).

    ``prime`` holds what the set keeps, with compensation factors applied. The mass is left out of
    Y_r (there as -m), since tanks change it. Arrays make a record for each of their numbers.
    """
    compact = np.zeros(_members(prime), COMPACT)
    for name in ("rho", "g", "mass", "weight", "buoyancy"):
        compact[name] = body[name]
    compact["eta_1"], compact["eta_2"], compact["eta_whole"] = eta
    for name in THRUST_KEYS:
        compact[name] = _scale(body, 2) * prime.get(name, 0.0)

    k5 = _scale(body, 5)
    t4 = 1.0 / (body["I_x"] - k5 * prime.get("K_pdot", 0.0))
    t5 = 1.0 / (body["I_y"] - k5 * prime.get("M_qdot", 0.0))
    t6 = 1.0 / (body["I_z"] - k5 * prime.get("N_rdot", 0.0))
    inverse = {"K": t4, "M": t5, "N": t6}
    for name in (*COMPACT_TERMS, *EXTRA_TERMS):
        scale = _scale(body, LENGTH_POWERS[name]) * inverse.get(name[0], 1.0)
        compact[INVERTED_NAMES.get(name, name)] = scale * prime.get(name, 0.0)
    compact["T4"], compact["T5"], compact["T6"] = t4, t5, t6
    compact["M_rp"] = (body["I_z"] - body["I_x"] + k5 * prime.get("M_rp", 0.0)) * t5
    compact["N_pq"] = (body["I_x"] - body["I_y"] + k5 * prime.get("N_pq", 0.0)) * t6
    for name in ("x_b", "y_b", "z_b"):
        compact[f"{name[0].upper()}B"] = body["buoyancy"] * body[name]
    for name in ("I_xy", "I_yz", "I_xz"):
        compact[name] = body[name]
    off_centre = ("x_b", "y_b", "I_xy", "I_yz", "I_xz")
    compact["off_centre"] = float(any(body[name] != 0.0 for name in off_centre))
    further = [name for name in EXTRA_TERMS if name not in SLIP_TERMS]
    for flag, names in (("extended", further), ("slipping", SLIP_TERMS)):
        compact[flag] = np.any([compact[name] != 0.0 for name in names], axis=0)
    return compact
