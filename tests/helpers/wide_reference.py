"""The wide set once more, by vectors and matrices, from a boat's constants; docs/envelope.md.

Momentum P and angular momentum L of body and water turn with the axes: the force of the motion is
-(omega x P), the moment -(omega x L + velocity x P). All that the core writes out term by term
is here one cross product. Deep water, outside the range.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]


def skew(a: Numbers) -> Numbers:
    """Return the matrix of a cross product from the left."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def body_mass(c: Any) -> tuple[Numbers, Numbers]:
    """Return the 6x6 mass matrix of the body, and its centre of gravity [m]."""
    centre = np.array([c.x_g, c.y_g, c.z_g])
    turning = np.array(
        [[c.I_x, -c.I_xy, -c.I_xz], [-c.I_xy, c.I_y, -c.I_yz], [-c.I_xz, -c.I_yz, c.I_z]]
    )
    arm = c.mass * skew(centre)
    return np.block([[c.mass * np.eye(3), -arm], [arm, turning]]), centre


def ideal_mass(c: Any) -> Numbers:
    """Return the 6x6 matrix of the added masses that Kirchhoff's equations have."""
    out = np.diag([c.m11, c.m22, c.m33, c.m44, c.m55, c.m66]).astype(float)
    for i, j in ((1, 3), (1, 5), (2, 4), (3, 5)):
        out[i, j] = out[j, i] = c[f"m{i + 1}{j + 1}"]
    return out


def solved_mass(c: Any, body: Numbers) -> Numbers:
    """Return the 6x6 matrix that is solved: body and the file's added masses, made symmetric."""
    added = np.zeros((6, 6))
    for i, force in enumerate("XYZKMN"):
        for j, rate in enumerate(("udot", "vdot", "wdot", "pdot", "qdot", "rdot")):
            if f"{force}_{rate}" in c.dtype.names:
                added[i, j] = -c[f"{force}_{rate}"]
    whole = body + added
    return np.asarray(0.5 * (whole + whole.T))


def rotation(s: Mapping[str, float]) -> Numbers:
    """Return the matrix from body axes to the earth's."""
    (cz, cy, cx), (sz, sy, sx) = (
        [f(s[name]) for name in ("psi", "theta", "phi")] for f in (np.cos, np.sin)
    )
    yaw = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    return np.asarray(yaw @ pitch @ roll)


def drag_at(place: Numbers, strength: Numbers, velocity: Numbers, omega: Numbers) -> Numbers:
    """Return force and moment of a strip: strength by y and z against the whole flow across."""
    flow = velocity + np.cross(omega, place)
    flow[0] = 0.0
    force = -strength * np.linalg.norm(flow) * flow
    return np.concatenate([force, np.cross(place, force)])


def forces(c: Any, s: Mapping[str, float]) -> Numbers:
    """Return X Y Z [N] K M N [N m] without accelerations."""
    velocity, omega = (np.array([s[k] for k in names]) for names in ("uvw", "pqr"))
    motion = np.concatenate([velocity, omega])
    u, u_c, p = s["u"], s["u_c"], s["p"]
    body, centre = body_mass(c)
    momentum = (body + ideal_mass(c)) @ motion
    turned = [
        -np.cross(omega, momentum[:3]),
        -np.cross(omega, momentum[3:]) - np.cross(velocity, momentum[:3]),
    ]
    total = np.concatenate(turned)
    down = rotation(s).T @ [0.0, 0.0, 1.0]
    lift = c.buoyancy - c.g * c.compressibility * (s["z"] - c.reference_depth) * c.fitted
    total += np.concatenate([c.weight * down, np.cross(centre, c.weight * down)])
    up = -c.buoyancy * down
    total += np.concatenate([up, np.cross([c.x_b, c.y_b, c.z_b], up)])
    total[:3] -= (lift - c.buoyancy) * down
    way = 0 if u >= 0.0 else 1
    for rows, columns, table in (
        ((1, 3, 5), (1, 3, 5), c.lateral[way]),
        ((2, 4), (2, 4), c.vertical[way]),
    ):
        total[list(rows)] += abs(u) * (table @ motion[list(columns)])
    total[2] += c.Z_star * u * u
    total[4] += c.M_star * u * u
    rolling = (np.linalg.norm(velocity) - abs(u)) * c.roll_damping + c.roll_drag * abs(p)
    total[3] += rolling * p + c.K_star * u_c * abs(u_c)
    for x, y, z in zip(c.station_x, c.crossflow_Y, c.crossflow_Z, strict=True):
        flat = omega * [0.0, 1.0, 1.0]  # the strips of the hull do not feel the roll
        total += drag_at(np.array([x, 0.0, 0.0]), np.array([0.0, y, z]), velocity, flat)
    for only, strength in ((1, c.tail_Y), (2, c.tail_Z)):
        along = np.array([c.tail_x, 0.0, 0.0])
        flow = np.zeros(3)
        flow[only] = (velocity + np.cross(omega * [0.0, 1.0, 1.0], along))[only]
        force = -strength * abs(flow[only]) * flow
        total += np.concatenate([force, np.cross(along, force)])
    sail = np.array([c.strip_x, 0.0, c.strip_z])
    aside = (velocity + np.cross(omega, sail))[1]
    push = np.array([0.0, -c.strip_Y * np.hypot(aside, s["w"]) * aside, 0.0])
    total += np.concatenate([push, np.cross(sail, push)])
    angle = np.array([s["delta_r"], s["delta_s"], s["delta_b"]])
    most = c.stall_ahead if u >= 0.0 else c.stall_astern
    effect = (1.0 if u >= 0.0 else c.astern_effect) * u * abs(u)
    r, st, b = effect * np.clip(angle, -most, most)
    total[0] += u * abs(u) * float(c.plane_drag @ angle**2)
    total += [
        *(0.0, c.Y_dr * r, c.Z_ds * st + c.Z_db * b),
        *(c.K_dr * r, c.M_ds * st + c.M_db * b, c.N_dr * r),
    ]
    total[0] += thrust(c, u, u_c)
    return total


def thrust(c: Any, u: float, u_c: float) -> float:
    """Return thrust less drag [N] by the row that is in force."""
    if u < 0.0:
        row = c.thrust_astern[0 if u_c < 0.0 else 1]
    else:
        eta = np.inf * np.sign(u_c) if u == 0.0 else u_c / u
        first, second = (eta >= c.eta_1, eta >= c.eta_2) if u > 0.0 else (u_c >= 0.0, False)
        row = [c[f"{k}{1 if first else 2 if second else 3}"] for k in "abc"]
    return float(np.dot(row, [u * u, u * u_c, u_c * u_c]))


def rates(c: Any, s: Mapping[str, float]) -> Numbers:
    """Return the twelve rates, as ``trainer boat evaluate`` orders them."""
    body, _ = body_mass(c)
    accelerations = np.linalg.solve(solved_mass(c, body), forces(c, s))
    p, q, r = s["p"], s["q"], s["r"]
    sx, cx = np.sin(s["phi"]), np.cos(s["phi"])
    turning = (q * sx + r * cx) / np.cos(s["theta"])
    angles = [p + turning * np.sin(s["theta"]), q * cx - r * sx, turning]
    through = rotation(s) @ [s["u"], s["v"], s["w"]]
    return np.concatenate([accelerations, angles, through])
