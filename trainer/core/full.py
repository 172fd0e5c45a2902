"""The full equations of motion, [GH67] as [ASSES] (1)-(6): programs EB920 and, masked, ZC790.

They have all terms of the coefficients, and compact sets are judged by them. ``rates`` calls
``forces`` and ``inertia``, adds what acts from outside, and solves for the accelerations. Masked,
the motion out of the vertical plane is taken out. Symbols: ``kinematics``.

Each force function returns the right side of its equation without accelerations, less the velocity
products of the left side. ``inertia`` writes the factors of the accelerations. Errata A1-A26 are
applied. The constants contain k = rho/2 and the powers of l.
"""

import math

from trainer.core.kernel import Numbers, Record, kernel
from trainer.core.kinematics import Attitude
from trainer.core.propulsion import excess_eta, thrust
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING


@kernel
def mass(vessel: Record, state: Record) -> float:
    """Return the mass [kg]: the vessel's own, and what the tanks have added or taken."""
    c = vessel[0]
    return c.mass + (state[0].weight - c.weight) / c.g


@kernel
def sign(a: float) -> float:
    """Return a/|a| [-], 0 at 0 (errata A27)."""
    if a > 0.0:
        return 1.0
    return -1.0 if a < 0.0 else 0.0


@kernel
def axial_force(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return X [N], [ASSES] (1)."""
    c = vessel[0]
    s = state[0]
    _, _, sin_th, _ = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    e = excess_eta(vessel, state)

    body = m * (v * r - w * q + s.x_g * (q * q + r * r) - s.y_g * p * q - s.z_g * p * r)
    rotation = c.X_qq * q * q + c.X_rr * r * r + c.X_rp * r * p
    coupling = c.X_vr * v * r + c.X_wq * w * q
    drag = c.X_uu * u * u + c.X_vv * v * v + c.X_ww * w * w
    planes = (
        c.X_drdr * s.delta_r * s.delta_r
        + c.X_dsds * s.delta_s * s.delta_s
        + c.X_dbdb * s.delta_b * s.delta_b
    ) * (u * u)
    slip = (
        c.X_vv_eta * v * v
        + c.X_ww_eta * w * w
        + (c.X_drdr_eta * s.delta_r * s.delta_r + c.X_dsds_eta * s.delta_s * s.delta_s) * (u * u)
    ) * e
    weight = -(s.weight - c.buoyancy) * sin_th
    return body + rotation + coupling + drag + planes + thrust(vessel, state) + weight + slip


@kernel
def lateral_force(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return Y [N], [ASSES] (2) with errata A1, A2."""
    c = vessel[0]
    s = state[0]
    sin_phi, _, _, cos_th = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)
    e = excess_eta(vessel, state)

    body = m * (w * p - u * r + s.y_g * (r * r + p * p) - s.z_g * q * r - s.x_g * q * p)
    rotation = c.Y_pap * p * abs(p) + c.Y_pq * p * q + c.Y_qr * q * r
    coupling = c.Y_vq * v * q + c.Y_wp * w * p + c.Y_wr * w * r
    damping = (
        c.Y_r * u * r
        + c.Y_p * u * p
        + c.Y_ardr * u * abs(r) * s.delta_r
        + c.Y_var * sign(v) * cross * abs(r)
    )
    drift = c.Y_star * u * u + c.Y_v * u * v + c.Y_vav * v * cross + c.Y_vw * v * w
    rudder = c.Y_dr * (u * u) * s.delta_r
    weight = (s.weight - c.buoyancy) * (cos_th * sin_phi)
    slip = (
        c.Y_r_eta * u * r
        + c.Y_v_eta * u * v
        + c.Y_vav_eta * v * cross
        + c.Y_dr_eta * s.delta_r * (u * u)
    ) * e
    return body + rotation + coupling + damping + drift + rudder + weight + slip


@kernel
def normal_force(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return Z [N], [ASSES] (3) with errata A3-A6."""
    c = vessel[0]
    s = state[0]
    _, cos_phi, _, cos_th = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)
    e = excess_eta(vessel, state)

    body = m * (u * q - v * p + s.z_g * (p * p + q * q) - s.x_g * r * p - s.y_g * r * q)
    rotation = c.Z_pp * p * p + c.Z_rr * r * r + c.Z_rp * r * p
    coupling = c.Z_vr * v * r + c.Z_vp * v * p
    damping = c.Z_q * u * q + c.Z_aqds * u * abs(q) * s.delta_s + c.Z_waq * sign(w) * cross * abs(q)
    incidence = (
        c.Z_star * u * u
        + c.Z_w * u * w
        + c.Z_waw * w * cross
        + c.Z_aw * u * abs(w)
        + c.Z_ww * abs(w) * cross
    )
    planes = c.Z_vv * v * v + (c.Z_ds * s.delta_s + c.Z_db * s.delta_b) * (u * u)
    weight = (s.weight - c.buoyancy) * (cos_th * cos_phi)
    slip = (
        c.Z_q_eta * u * q
        + c.Z_w_eta * u * w
        + c.Z_waw_eta * w * cross
        + c.Z_ds_eta * s.delta_s * (u * u)
    ) * e
    return body + rotation + coupling + damping + incidence + planes + weight + slip


@kernel
def rolling_moment(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return K [N m], [ASSES] (4) with errata A7, A8."""
    c = vessel[0]
    s = state[0]
    sin_phi, cos_phi, _, cos_th = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)

    inertia = (c.I_y - c.I_z) * q * r + c.I_xz * p * q - c.I_yz * (r * r - q * q) - c.I_xy * p * r
    body = m * (s.y_g * (u * q - v * p) - s.z_g * (w * p - u * r))
    rotation = c.K_qr * q * r + c.K_pq * p * q + c.K_pap * p * abs(p)
    damping = c.K_p * u * p + c.K_r * u * r + c.K_vq * v * q + c.K_wp * w * p + c.K_wr * w * r
    drift = c.K_star * u * u + c.K_v * u * v + c.K_vav * v * cross + c.K_vw * v * w
    rudder = c.K_dr * (u * u) * s.delta_r
    weight = (s.y_g * s.weight - c.y_b * c.buoyancy) * cos_th * cos_phi - (
        s.z_g * s.weight - c.z_b * c.buoyancy
    ) * cos_th * sin_phi
    slip = c.K_star_eta * u * u * excess_eta(vessel, state)
    return inertia + body + rotation + damping + drift + rudder + weight + slip


@kernel
def pitching_moment(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return M [N m], [ASSES] (5) with errata A6, A9-A11."""
    c = vessel[0]
    s = state[0]
    _, cos_phi, sin_th, cos_th = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)
    e = excess_eta(vessel, state)

    inertia = (c.I_z - c.I_x) * r * p + c.I_xy * q * r - c.I_xz * (p * p - r * r) - c.I_yz * q * p
    body = m * (s.z_g * (v * r - w * q) - s.x_g * (u * q - v * p))
    rotation = c.M_pp * p * p + c.M_rr * r * r + c.M_rp * r * p + c.M_qaq * q * abs(q)
    coupling = c.M_vr * v * r + c.M_vp * v * p
    damping = c.M_q * u * q + c.M_aqds * u * abs(q) * s.delta_s + c.M_awq * cross * q
    incidence = (
        c.M_star * u * u
        + c.M_w * u * w
        + c.M_waw * w * cross
        + c.M_aw * u * abs(w)
        + c.M_ww * abs(w) * cross
    )
    planes = c.M_vv * v * v + (c.M_ds * s.delta_s + c.M_db * s.delta_b) * (u * u)
    weight = (
        -(s.x_g * s.weight - c.x_b * c.buoyancy) * (cos_th * cos_phi)
        - (s.z_g * s.weight - c.z_b * c.buoyancy) * sin_th
    )
    slip = (
        c.M_q_eta * u * q
        + c.M_w_eta * u * w
        + c.M_waw_eta * w * cross
        + c.M_ds_eta * s.delta_s * (u * u)
    ) * e
    return inertia + body + rotation + coupling + damping + incidence + planes + weight + slip


@kernel
def yawing_moment(vessel: Record, attitude: Attitude, state: Record) -> float:
    """Return N [N m], [ASSES] (6) with errata A12-A15."""
    c = vessel[0]
    s = state[0]
    sin_phi, _, sin_th, cos_th = attitude
    m = mass(vessel, state)
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)
    e = excess_eta(vessel, state)

    inertia = (c.I_x - c.I_y) * p * q + c.I_yz * r * p - c.I_xy * (q * q - p * p) - c.I_xz * r * q
    body = m * (s.x_g * (w * p - u * r) - s.y_g * (v * r - w * q))
    rotation = c.N_pq * p * q + c.N_qr * q * r + c.N_rar * r * abs(r)
    coupling = c.N_wr * w * r + c.N_wp * w * p + c.N_vq * v * q
    damping = (
        c.N_p * u * p + c.N_r * u * r + c.N_ardr * u * abs(r) * s.delta_r + c.N_avr * cross * r
    )
    drift = c.N_star * u * u + c.N_v * u * v + c.N_vav * v * cross + c.N_vw * v * w
    rudder = c.N_dr * (u * u) * s.delta_r
    weight = (s.x_g * s.weight - c.x_b * c.buoyancy) * (cos_th * sin_phi) + (
        s.y_g * s.weight - c.y_b * c.buoyancy
    ) * sin_th
    slip = (
        c.N_r_eta * u * r
        + c.N_v_eta * u * v
        + c.N_vav_eta * v * cross
        + c.N_dr_eta * s.delta_r * (u * u)
    ) * e
    return inertia + body + rotation + coupling + damping + drift + rudder + weight + slip


@kernel
def forces(vessel: Record, attitude: Attitude, state: Record, force: Numbers) -> None:
    """Write X Y Z [N] K M N [N m] to ``force``."""
    force[AXIAL] = axial_force(vessel, attitude, state)
    force[LATERAL] = lateral_force(vessel, attitude, state)
    force[NORMAL] = normal_force(vessel, attitude, state)
    force[ROLLING] = rolling_moment(vessel, attitude, state)
    force[PITCHING] = pitching_moment(vessel, attitude, state)
    force[YAWING] = yawing_moment(vessel, attitude, state)


@kernel
def inertia(vessel: Record, state: Record, out: Numbers) -> None:
    """Write the 6x6 matrix [M] of [ASSES] III-C-8 [kg, kg m, kg m2]."""
    c = vessel[0]
    s = state[0]
    m = mass(vessel, state)
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
    out[0, 0], out[0, 4], out[0, 5] = m - c.X_udot, m * s.z_g, -m * s.y_g
    out[1, 1], out[1, 3], out[1, 5] = m - c.Y_vdot, -c.Y_pdot - m * s.z_g, -c.Y_rdot + m * s.x_g
    out[2, 2], out[2, 3], out[2, 4] = m - c.Z_wdot, m * s.y_g, -c.Z_qdot - m * s.x_g
    out[3, 1], out[3, 2], out[3, 3] = -c.K_vdot - m * s.z_g, m * s.y_g, c.I_x - c.K_pdot
    out[3, 4], out[3, 5] = -c.I_xy, -c.I_xz - c.K_rdot
    out[4, 0], out[4, 2], out[4, 3] = m * s.z_g, -c.M_wdot - m * s.x_g, -c.I_xy
    out[4, 4], out[4, 5] = c.I_y - c.M_qdot, -c.I_yz
    out[5, 0], out[5, 1], out[5, 3] = -m * s.y_g, -c.N_vdot + m * s.x_g, -c.I_xz - c.N_pdot
    out[5, 4], out[5, 5] = -c.I_yz, c.I_z - c.N_rdot


@kernel
def mask_lateral(force: Numbers, out: Numbers) -> None:
    """Take v, p, r out of the equations: program ZC790, [ASSES] (8)-(11)."""
    for i in (1, 3, 5):
        force[i] = 0.0
        for j in range(6):
            out[i, j] = 0.0
            out[j, i] = 0.0
        out[i, i] = 1.0
