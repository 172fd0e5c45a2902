"""The compact set EC780, [ASSES] (12)-(17), on the constants of (18); errata C1-C20.

``modified`` and ``basic`` differ in their constants and trigonometry only. Departures: the mass
in Y_r is the present one, since tanks change it; X_vr, K_pap, N_rar and N_avr have room, and are
zero unless the vessel file asks for them.
"""

import math

from trainer.core.full import mass
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.kinematics import pitch_roll_cosine, pitch_roll_sine
from trainer.core.propulsion import thrust


@part
def forces(compact: Record, trig: int, state: Record, force: Numbers) -> None:
    """Write the right sides of (12)-(17) without accelerations to ``force``.

    The first three are forces [N], the last three angular accelerations [rad/s2].
    """
    c = compact[0]
    s = state[0]
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    m = mass(compact, state)
    cross = math.sqrt(v * v + w * w)
    sin_th, cos_th = pitch_roll_sine(trig, s.theta), pitch_roll_cosine(trig, s.theta)
    sin_phi, cos_phi = pitch_roll_sine(trig, s.phi), pitch_roll_cosine(trig, s.phi)
    heavy = s.weight - c.buoyancy

    force[0] = (
        m * (s.x_g * (q * q + r * r) - s.z_g * p * r + v * r - w * q)
        + u
        * u
        * (
            c.X_drdr * s.delta_r * s.delta_r
            + c.X_dsds * s.delta_s * s.delta_s
            + c.X_dbdb * s.delta_b * s.delta_b
        )
        + thrust(compact, state)
        + c.X_vr * v * r
        - heavy * sin_th
        + c.X_qq * q * q
        + c.X_rr * r * r
        + c.X_rp * r * p
        + c.X_wq * w * q
        + c.X_vv * v * v
        + c.X_ww * w * w
    )
    force[1] = (
        u * (c.Y_r * r - m * r + c.Y_p * p + c.Y_v * v)
        - m * (s.z_g * q * r + s.x_g * q * p - w * p)
        + c.Y_vav * v * cross
        + c.Y_dr * (u * u) * s.delta_r
        + heavy * cos_th * sin_phi
        + c.Y_pq * p * q
        + c.Y_qr * q * r
        + c.Y_vq * v * q
        + c.Y_wp * w * p
        + c.Y_wr * w * r
        + c.Y_vw * v * w
    )
    force[2] = (
        u * (c.Z_q * q + c.Z_w * w)
        + m * (s.z_g * (p * p + q * q) - s.x_g * r * p + u * q - v * p)
        + c.Z_rr * r * r
        + c.Z_vr * v * r
        + c.Z_vv * v * v
        + c.Z_waw * w * cross
        + (u * u) * (c.Z_ds * s.delta_s + c.Z_db * s.delta_b + c.Z_star)
        + heavy * cos_th * cos_phi
        + c.Z_pp * p * p
        + c.Z_rp * r * p
        + c.Z_vp * v * p
    )
    force[3] = (
        m * s.z_g * (u * r - w * p) * c.K_pdot
        + u * (c.K_p * p + c.K_v * v)
        + c.K_vav * v * cross
        + c.K_pap * p * abs(p)
        - c.K_pdot * (s.z_g * s.weight - c.ZB) * cos_th * sin_phi
        + c.K_qr * q * r
        + c.K_pq * p * q
        + c.K_r * u * r
        + c.K_vq * v * q
        + c.K_wp * w * p
        + c.K_wr * w * r
        + c.K_vw * v * w
        + c.K_star * u * u
    )
    force[4] = (
        c.M_rp * r * p
        + u * (c.M_q * q + c.M_w * w)
        - m * (s.z_g * (w * q - v * r) - s.x_g * (v * p - u * q)) * c.M_qdot
        + c.M_rr * r * r
        + c.M_vr * v * r
        + c.M_vv * v * v
        + c.M_awq * q * cross
        + c.M_waw * w * cross
        + u * u * (c.M_star + c.M_db * s.delta_b + c.M_ds * s.delta_s)
        - c.M_qdot * (s.x_g * s.weight * cos_th * cos_phi + (s.z_g * s.weight - c.ZB) * sin_th)
        + c.M_pp * p * p
        + c.M_qaq * q * abs(q)
        + c.M_vp * v * p
    )
    force[5] = (
        c.N_pq * p * q
        + u * u * c.N_dr * s.delta_r
        - m * s.x_g * (u * r - w * p) * c.N_rdot
        + c.N_vav * v * cross
        + u * (c.N_p * p + c.N_r * r + c.N_v * v)
        + c.N_rar * r * abs(r)
        + c.N_avr * cross * r
        + c.N_rdot * s.x_g * s.weight * cos_th * sin_phi
        + c.N_qr * q * r
        + c.N_wr * w * r
        + c.N_wp * w * p
        + c.N_vq * v * q
        + c.N_vw * v * w
    )


@part
def add_external(compact: Record, external: Numbers, force: Numbers) -> None:
    """Add forces [N] and moments [N m] from outside; K_pdot, M_qdot, N_rdot are T4 to T6."""
    c = compact[0]
    force[0] += external[0]
    force[1] += external[1]
    force[2] += external[2]
    force[3] += external[3] * c.K_pdot
    force[4] += external[4] * c.M_qdot
    force[5] += external[5] * c.N_rdot


@part
def lagged(compact: Record, force: Numbers, state: Record) -> None:
    """Write u' v' w' p' q' r' in that order, with last cycle's where this one's are not known yet.

    The acceleration terms of (12)-(17); the same as ``sweep`` with ``inertia``, written out.
    """
    c = compact[0]
    s = state[0]
    m = mass(compact, state)
    m_x, m_z = m * s.x_g, m * s.z_g
    s.udot = (force[0] - m_z * s.qdot) / (m - c.X_udot)
    s.vdot = (force[1] + (m_z + c.Y_pdot) * s.pdot + (c.Y_rdot - m_x) * s.rdot) / (m - c.Y_vdot)
    s.wdot = (force[2] + (m_x + c.Z_qdot) * s.qdot) / (m - c.Z_wdot)
    s.pdot = force[3] + (m_z * c.K_pdot + c.K_vdot) * s.vdot + c.K_rdot * s.rdot
    s.qdot = force[4] + (m_x * c.M_qdot + c.M_wdot) * s.wdot - m_z * c.M_qdot * s.udot
    s.rdot = force[5] + (c.N_vdot - m_x * c.N_rdot) * s.vdot + c.N_pdot * s.pdot


@kernel
def inertia(compact: Record, state: Record, out: Numbers) -> None:
    """Write what multiplies the accelerations in (12)-(17), for the exact solve."""
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
    out[3, 1], out[3, 5] = -(m_z * c.K_pdot + c.K_vdot), -c.K_rdot
    out[4, 0], out[4, 2] = m_z * c.M_qdot, -(m_x * c.M_qdot + c.M_wdot)
    out[5, 1], out[5, 3] = m_x * c.N_rdot - c.N_vdot, -c.N_pdot
