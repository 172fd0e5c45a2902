"""The compact set EC780, [ASSES] (12)-(17), on the constants of (18); errata C1-C20.

It is the short set of equations that [ASSES] made of the full one, so that a computer of 1969 kept
up with time: the terms that matter, over constants divided beforehand, each acceleration from its
own equation. ``rates`` uses it where the scheme asks for it. Symbols: ``kinematics``.

``modified`` and ``basic`` differ only in their constants and trigonometry. The terms of the mass
are gathered by the six components of the acceleration of turning axes. Departures from the report:
the mass in Y_r is the present one, since tanks change it. A vessel file may keep further terms.
y_G, x_B, y_B and the products of inertia, which the report leaves out, act where they are not zero.
"""

import math

from trainer.core.full import mass
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.kinematics import Attitude
from trainer.core.propulsion import thrust
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING


@inline_kernel
def forces(compact: Record, attitude: Attitude, state: Record, force: Numbers) -> None:
    """Write the right sides of (12)-(17) without accelerations to ``force``.

    The first three are forces [N], the last three angular accelerations [rad/s2].
    """
    c = compact[0]
    s = state[0]
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    m = mass(compact, state)
    m_x, m_z = m * s.x_g, m * s.z_g
    cross = math.sqrt(v * v + w * w)
    v_cross, u_dr = v * cross, u * s.delta_r
    sin_phi, cos_phi, sin_th, cos_th = attitude
    heavy = s.weight - c.buoyancy
    righting, tilting = s.z_g * s.weight - c.ZB, s.x_g * s.weight
    athwart, below = cos_th * sin_phi, cos_th * cos_phi
    ahead, aside, down = v * r - w * q, w * p - u * r, u * q - v * p  # -(omega x velocity)

    force[AXIAL] = (
        m * ahead
        + m_x * (q * q + r * r)
        - m_z * r * p
        + u
        * u
        * (
            c.X_drdr * s.delta_r * s.delta_r
            + c.X_dsds * s.delta_s * s.delta_s
            + c.X_dbdb * s.delta_b * s.delta_b
        )
        + thrust(compact, state)
        - heavy * sin_th
    )
    force[LATERAL] = (
        m * aside
        - q * (m_z * r + m_x * p)
        + u * (c.Y_r * r + c.Y_p * p + c.Y_v * v + c.Y_dr * u_dr)
        + c.Y_vav * v_cross
        + heavy * athwart
    )
    force[NORMAL] = (
        m * down
        + m_z * (p * p + q * q)
        - m_x * r * p
        + u * (c.Z_q * q + c.Z_w * w)
        + u * u * (c.Z_star + c.Z_ds * s.delta_s + c.Z_db * s.delta_b)
        + r * (c.Z_rr * r + c.Z_vr * v)
        + c.Z_vv * v * v
        + c.Z_waw * w * cross
        + heavy * below
    )
    force[ROLLING] = (
        u * (c.K_p * p + c.K_v * v) + c.K_vav * v_cross - c.T4 * (m_z * aside + righting * athwart)
    )
    force[PITCHING] = (
        u * (c.M_q * q + c.M_w * w)
        + u * u * (c.M_star + c.M_ds * s.delta_s + c.M_db * s.delta_b)
        + r * (c.M_rp * p + c.M_rr * r + c.M_vr * v)
        + c.M_vv * v * v
        + cross * (c.M_awq * q + c.M_waw * w)
        + c.T5 * (m_z * ahead - m_x * down - tilting * below - righting * sin_th)
    )
    force[YAWING] = (
        u * (c.N_p * p + c.N_r * r + c.N_v * v + c.N_dr * u_dr)
        + c.N_pq * p * q
        + c.N_vav * v_cross
        + c.T6 * (m_x * aside + tilting * athwart)
    )


@inline_kernel
def further_forces(compact: Record, state: Record, force: Numbers) -> None:
    """Add the terms to ``force`` that (12)-(17) do not have.

    A vessel file may keep them.
    """
    c = compact[0]
    s = state[0]
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    cross = math.sqrt(v * v + w * w)
    force[AXIAL] += (
        v * (c.X_vr * r + c.X_vv * v)
        + w * (c.X_wq * q + c.X_ww * w)
        + r * (c.X_rr * r + c.X_rp * p)
        + c.X_qq * q * q
    )
    force[LATERAL] += q * (c.Y_pq * p + c.Y_qr * r + c.Y_vq * v) + w * (
        c.Y_wp * p + c.Y_wr * r + c.Y_vw * v
    )
    force[NORMAL] += p * (c.Z_pp * p + c.Z_rp * r + c.Z_vp * v)
    force[ROLLING] += (
        q * (c.K_pq * p + c.K_qr * r + c.K_vq * v)
        + w * (c.K_wp * p + c.K_wr * r + c.K_vw * v)
        + u * (c.K_r * r + c.K_star * u)
        + c.K_pap * p * abs(p)
    )
    force[PITCHING] += p * (c.M_pp * p + c.M_vp * v) + c.M_qaq * q * abs(q)
    force[YAWING] += (
        q * (c.N_qr * r + c.N_vq * v)
        + w * (c.N_wp * p + c.N_wr * r + c.N_vw * v)
        + r * (c.N_rar * abs(r) + c.N_avr * cross)
    )


@inline_kernel
def slip_forces(compact: Record, state: Record, force: Numbers) -> None:
    """Add the terms of the propeller's slip to ``force``, which (12)-(17) do not have.

    They are u (eta - 1) times the rest: u_c - u, without a division, where eta is u_c/u. A vessel
    with eta by U has it as the full set does, 0 at U = 0. Of the slip terms of [ASSES] (1)-(6)
    those by v^2, w^2 and V are not here, because they would need a division.
    """
    c = compact[0]
    s = state[0]
    u = s.u
    slip = s.u_c - u
    if c.eta_whole != 0.0:
        speed = math.sqrt(u * u + s.v * s.v + s.w * s.w)
        slip = u * (s.u_c / speed - 1.0) if speed > 0.0 else 0.0
    drag = c.X_drdr_eta * s.delta_r * s.delta_r + c.X_dsds_eta * s.delta_s * s.delta_s
    force[AXIAL] += slip * u * drag
    force[LATERAL] += slip * (c.Y_r_eta * s.r + c.Y_v_eta * s.v + c.Y_dr_eta * u * s.delta_r)
    force[NORMAL] += slip * (c.Z_q_eta * s.q + c.Z_w_eta * s.w + c.Z_ds_eta * u * s.delta_s)
    force[ROLLING] += slip * u * c.K_star_eta
    force[PITCHING] += slip * (c.M_q_eta * s.q + c.M_w_eta * s.w + c.M_ds_eta * u * s.delta_s)
    force[YAWING] += slip * (c.N_r_eta * s.r + c.N_v_eta * s.v + c.N_dr_eta * u * s.delta_r)


@inline_kernel
def off_centre(compact: Record, state: Record) -> bool:
    """Return whether the boat has any of y_G, x_B, y_B, I_xy, I_yz, I_xz."""
    return compact[0].off_centre != 0.0 or state[0].y_g != 0.0


@kernel
def off_centre_forces(compact: Record, attitude: Attitude, state: Record, force: Numbers) -> None:
    """Add the terms of y_G, x_B, y_B, I_xy, I_yz, I_xz in [ASSES] (1)-(6) to ``force``.

    The first three are forces [N], the last three angular accelerations [rad/s2].
    """
    c = compact[0]
    s = state[0]
    p, q, r = s.p, s.q, s.r
    m_y = mass(compact, state) * s.y_g
    sin_phi, cos_phi, sin_th, cos_th = attitude
    athwart, below = cos_th * sin_phi, cos_th * cos_phi
    heeling = s.y_g * s.weight - c.YB
    force[AXIAL] -= m_y * p * q
    force[LATERAL] += m_y * (r * r + p * p)
    force[NORMAL] -= m_y * r * q
    force[ROLLING] += c.T4 * (
        c.I_xz * p * q
        - c.I_yz * (r * r - q * q)
        - c.I_xy * p * r
        + m_y * (s.u * q - s.v * p)
        + heeling * below
    )
    force[PITCHING] += c.T5 * (
        c.I_xy * q * r - c.I_xz * (p * p - r * r) - c.I_yz * q * p + c.XB * below
    )
    force[YAWING] += c.T6 * (
        c.I_yz * r * p
        - c.I_xy * (q * q - p * p)
        - c.I_xz * r * q
        - m_y * (s.v * r - s.w * q)
        - c.XB * athwart
        + heeling * sin_th
    )


@inline_kernel
def add_external(compact: Record, external: Numbers, force: Numbers) -> None:
    """Add forces [N] and moments [N m] from outside."""
    c = compact[0]
    force[AXIAL] += external[AXIAL]
    force[LATERAL] += external[LATERAL]
    force[NORMAL] += external[NORMAL]
    force[ROLLING] += external[ROLLING] * c.T4
    force[PITCHING] += external[PITCHING] * c.T5
    force[YAWING] += external[YAWING] * c.T6


@inline_kernel
def lagged_rates(compact: Record, force: Numbers, state: Record) -> None:
    """Write u' v' w' p' q' r' in that order.

    Where a rate of this cycle is not known yet, last cycle's is used. These are the acceleration
    terms of (12)-(17); the same as ``sweep`` with ``inertia``, written out.
    """
    c = compact[0]
    s = state[0]
    m = mass(compact, state)
    m_x, m_z = m * s.x_g, m * s.z_g
    s.udot = (force[AXIAL] - m_z * s.qdot) / (m - c.X_udot)
    s.vdot = (force[LATERAL] + (m_z + c.Y_pdot) * s.pdot + (c.Y_rdot - m_x) * s.rdot) / (
        m - c.Y_vdot
    )
    s.wdot = (force[NORMAL] + (m_x + c.Z_qdot) * s.qdot) / (m - c.Z_wdot)
    s.pdot = force[ROLLING] + (m_z * c.T4 + c.K_vdot) * s.vdot + c.K_rdot * s.rdot
    s.qdot = force[PITCHING] + (m_x * c.T5 + c.M_wdot) * s.wdot - m_z * c.T5 * s.udot
    s.rdot = force[YAWING] + (c.N_vdot - m_x * c.T6) * s.vdot + c.N_pdot * s.pdot


@kernel
def inertia(compact: Record, state: Record, out: Numbers) -> None:
    """Write the factors of the accelerations in (12)-(17), for the exact solve."""
    c = compact[0]
    s = state[0]
    m = mass(compact, state)
    m_x, m_z = m * s.x_g, m * s.z_g
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
        out[i, i] = 1.0
    out[0, 0], out[0, 4] = m - c.X_udot, m_z
    out[1, 1], out[1, 3], out[1, 5] = m - c.Y_vdot, -(m_z + c.Y_pdot), m_x - c.Y_rdot
    out[2, 2], out[2, 4] = m - c.Z_wdot, -(m_x + c.Z_qdot)
    out[3, 1], out[3, 5] = -(m_z * c.T4 + c.K_vdot), -c.K_rdot
    out[4, 0], out[4, 2] = m_z * c.T5, -(m_x * c.T5 + c.M_wdot)
    out[5, 1], out[5, 3] = m_x * c.T6 - c.N_vdot, -c.N_pdot


@kernel
def off_centre_inertia(compact: Record, state: Record, out: Numbers) -> None:
    """Add the factors of the accelerations in [ASSES] (1)-(6) by y_G, I_xy, I_yz, I_xz."""
    c = compact[0]
    m_y = mass(compact, state) * state[0].y_g
    out[0, 5] -= m_y
    out[2, 3] += m_y
    out[3, 2] += m_y * c.T4
    out[3, 4] -= c.I_xy * c.T4
    out[3, 5] -= c.I_xz * c.T4
    out[4, 3] -= c.I_xy * c.T5
    out[4, 5] -= c.I_yz * c.T5
    out[5, 0] -= m_y * c.T6
    out[5, 3] -= c.I_xz * c.T6
    out[5, 4] -= c.I_yz * c.T6
