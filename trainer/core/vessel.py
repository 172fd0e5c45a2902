"""Constants of one boat, dimensional, computed once from its prime coefficients.

``VESSEL`` carries the full set [GH67]; ``COMPACT`` the constants of the compact set by the mapping
of program EC790, [ASSES] equation (18) with its errata C10-C18.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from trainer.core.ballast.tanks import BALLAST_FIELDS
from trainer.core.kernel import Numbers, Record, record_dtype

# Coefficients by equation and power of the length, as in [ASSES] Tables 2-4.
TERMS: Final[dict[str, int]] = {
    **dict.fromkeys(("X_qq", "X_rr", "X_rp"), 4),
    **dict.fromkeys(("X_udot", "X_vr", "X_wq"), 3),
    **dict.fromkeys(("X_uu", "X_vv", "X_ww", "X_drdr", "X_dsds", "X_dbdb"), 2),
    **dict.fromkeys(("X_vv_eta", "X_ww_eta", "X_drdr_eta", "X_dsds_eta"), 2),
    **dict.fromkeys(("Y_rdot", "Y_pdot", "Y_pap", "Y_pq", "Y_qr"), 4),
    **dict.fromkeys(("Y_vdot", "Y_vq", "Y_wp", "Y_wr", "Y_r", "Y_p", "Y_ardr", "Y_var"), 3),
    **dict.fromkeys(("Y_star", "Y_v", "Y_vav", "Y_vw", "Y_dr"), 2),
    **dict.fromkeys(("Y_r_eta",), 3),
    **dict.fromkeys(("Y_v_eta", "Y_vav_eta", "Y_dr_eta"), 2),
    **dict.fromkeys(("Z_qdot", "Z_pp", "Z_rr", "Z_rp"), 4),
    **dict.fromkeys(("Z_wdot", "Z_vr", "Z_vp", "Z_q", "Z_aqds", "Z_waq"), 3),
    **dict.fromkeys(("Z_star", "Z_w", "Z_waw", "Z_aw", "Z_ww", "Z_vv", "Z_ds", "Z_db"), 2),
    **dict.fromkeys(("Z_q_eta",), 3),
    **dict.fromkeys(("Z_w_eta", "Z_waw_eta", "Z_ds_eta"), 2),
    **dict.fromkeys(("K_pdot", "K_rdot", "K_qr", "K_pq", "K_pap"), 5),
    **dict.fromkeys(("K_p", "K_r", "K_vdot", "K_vq", "K_wp", "K_wr"), 4),
    **dict.fromkeys(("K_star", "K_v", "K_vav", "K_vw", "K_dr", "K_star_eta"), 3),
    **dict.fromkeys(("M_qdot", "M_pp", "M_rr", "M_rp", "M_qaq"), 5),
    **dict.fromkeys(("M_wdot", "M_vr", "M_vp", "M_q", "M_aqds", "M_awq"), 4),
    **dict.fromkeys(("M_star", "M_w", "M_waw", "M_aw", "M_ww", "M_vv", "M_ds", "M_db"), 3),
    **dict.fromkeys(("M_q_eta",), 4),
    **dict.fromkeys(("M_w_eta", "M_waw_eta", "M_ds_eta"), 3),
    **dict.fromkeys(("N_rdot", "N_pdot", "N_pq", "N_qr", "N_rar"), 5),
    **dict.fromkeys(("N_vdot", "N_wr", "N_wp", "N_vq", "N_p", "N_r", "N_ardr", "N_avr"), 4),
    **dict.fromkeys(("N_star", "N_v", "N_vav", "N_vw", "N_dr"), 3),
    **dict.fromkeys(("N_r_eta",), 4),
    **dict.fromkeys(("N_v_eta", "N_vav_eta", "N_dr_eta"), 3),
}

THRUST: Final = ["a1", "b1", "c1", "a2", "b2", "c2", "a3", "b3", "c3"]

# What the compact set keeps, [ASSES] Table 18 with errata C18, C19.
KEPT: Final = (
    *("X_udot", "X_drdr", "X_dsds", "X_dbdb"),
    *("Y_pdot", "Y_rdot", "Y_vdot", "Y_r", "Y_p", "Y_v", "Y_vav", "Y_dr"),
    *("Z_qdot", "Z_wdot", "Z_q", "Z_w", "Z_star", "Z_ds", "Z_db", "Z_waw", "Z_vv", "Z_rr", "Z_vr"),
    *("K_rdot", "K_pdot", "K_vdot", "K_p", "K_v", "K_vav"),
    *("M_qdot", "M_wdot", "M_q", "M_w", "M_star", "M_awq", "M_waw", "M_ds", "M_db"),
    *("M_rr", "M_vr", "M_vv", "M_rp"),
    *("N_rdot", "N_pdot", "N_vdot", "N_r", "N_p", "N_v", "N_vav", "N_pq", "N_dr"),
)
INVERTED: Final = {"K_pdot": "T4", "M_qdot": "T5", "N_rdot": "T6"}  # as [ASSES] (18) has them
BASIC_DROPS: Final = ("Z_waw", "M_waw", "M_awq")
# What a vessel file may keep besides.
EXTRA_TERMS: Final = (
    *("X_vr", "X_qq", "X_rr", "X_rp", "X_wq", "X_vv", "X_ww"),
    *("Y_pq", "Y_qr", "Y_vq", "Y_wp", "Y_wr", "Y_vw"),
    *("Z_pp", "Z_rp", "Z_vp"),
    *("K_pap", "K_qr", "K_pq", "K_r", "K_vq", "K_wp", "K_wr", "K_vw", "K_star"),
    *("M_pp", "M_qaq", "M_vp"),
    *("N_rar", "N_avr", "N_qr", "N_wr", "N_wp", "N_vq", "N_vw"),
)

SPEEDS: Final = 12  # longest schedule of autopilot gains
PLANE_GAINS: Final = ("depth", "depth_rate", "pitch", "pitch_rate", "integral", "relief")
GAINS: Final = [
    *(f"stern_{name}" for name in PLANE_GAINS),
    *(f"bow_{name}" for name in PLANE_GAINS),
    *("rudder_course", "rudder_yaw_rate", "rudder_sway", "rudder_integral"),
    *("depth_rate", "depth_acceleration", "course_rate", "course_acceleration"),
]

SURFACE_DEPTHS, SURFACE_SPEEDS = 8, 6  # largest tables of the calm surface's effect

BODY: Final = [
    *("rho", "g", "ell", "mass", "weight", "buoyancy"),
    *("x_g", "y_g", "z_g", "x_b", "y_b", "z_b"),
    *("I_x", "I_y", "I_z", "I_xy", "I_yz", "I_xz"),
]

VESSEL: Final = record_dtype(
    # what every tick asks for comes first: machine code is shorter for it
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
    "turning_rate",  # [rad/s] above it the trims of speed and rudder rest
    "gain_count",  # [-] speeds in the schedule; 0: no autopilot
    # the hull
    *BODY,
    "eta_1",  # [-] thrust row 1 holds from here up, row 2 down to eta_2, row 3 below
    "eta_2",
    *THRUST,
    *TERMS,
    # its schedule of gains
    ("gain_speed", (SPEEDS,)),  # [m/s]
    ("gain", (SPEEDS, len(GAINS))),
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
    *BALLAST_FIELDS,
)


Prime = Mapping[str, float | Numbers]  # [-] a number, or one for each member of a fleet


def _members(prime: Prime) -> int:
    """Return how many boats the coefficients are of."""
    return max(np.size(value) for value in prime.values())


def _scale(body: Mapping[str, float], power: int) -> float:
    """Return rho/2 l^power in SI units."""
    return float(0.5 * body["rho"] * body["ell"] ** power)


def vessel_record(body: Mapping[str, float], prime: Prime, eta: tuple[float, float]) -> Record:
    """Return the full-set constants; ``prime`` holds TERMS and THRUST, dimensionless.

    Arrays make a record for each of their numbers. Control surfaces, propulsion dynamics and
    autopilot gains are left at zero.
    """
    vessel = np.zeros(_members(prime), VESSEL)
    for name in BODY:
        vessel[name] = body[name]
    vessel["eta_1"], vessel["eta_2"] = eta
    for name, power in TERMS.items():
        vessel[name] = _scale(body, power) * prime.get(name, 0.0)
    for name in THRUST:
        vessel[name] = _scale(body, 2) * prime.get(name, 0.0)
    return vessel


COMPACT: Final = record_dtype(
    *("rho", "g", "mass", "weight", "buoyancy", "eta_1", "eta_2"),
    *THRUST,
    *(INVERTED.get(name, name) for name in KEPT),
    "ZB",  # [N m] buoyancy times z_b
    "extended",  # [-] 1: some of the following are kept
    *EXTRA_TERMS,
)


def compact_record(body: Mapping[str, float], prime: Prime, eta: tuple[float, float]) -> Record:
    """Return the compact constants, [ASSES] (18).

    ``prime`` holds what the set keeps, compensation factors applied. The mass is left out of Y_r
    (there as -m), since tanks change it. Arrays make a record for each of their numbers.
    """
    compact = np.zeros(_members(prime), COMPACT)
    for name in ("rho", "g", "mass", "weight", "buoyancy"):
        compact[name] = body[name]
    compact["eta_1"], compact["eta_2"] = eta
    for name in THRUST:
        compact[name] = _scale(body, 2) * prime.get(name, 0.0)

    k5 = _scale(body, 5)
    t4 = 1.0 / (body["I_x"] - k5 * prime.get("K_pdot", 0.0))
    t5 = 1.0 / (body["I_y"] - k5 * prime.get("M_qdot", 0.0))
    t6 = 1.0 / (body["I_z"] - k5 * prime.get("N_rdot", 0.0))
    inverse = {"K": t4, "M": t5, "N": t6}
    for name in (*KEPT, *EXTRA_TERMS):
        scale = _scale(body, TERMS[name]) * inverse.get(name[0], 1.0)
        compact[INVERTED.get(name, name)] = scale * prime.get(name, 0.0)
    compact["T4"], compact["T5"], compact["T6"] = t4, t5, t6
    compact["M_rp"] = (body["I_z"] - body["I_x"] + k5 * prime.get("M_rp", 0.0)) * t5
    compact["N_pq"] = (body["I_x"] - body["I_y"] + k5 * prime.get("N_pq", 0.0)) * t6
    compact["ZB"] = body["buoyancy"] * body["z_b"]
    compact["extended"] = np.any([compact[name] != 0.0 for name in EXTRA_TERMS], axis=0)
    return compact
