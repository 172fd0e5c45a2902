"""The motion of a submerged boat that goes ahead, as a fit takes it.

The equations are those of NSRDC Report 2510 [GH67] that ``trainer.core.full`` has, without waves,
tanks, engine or what lies beyond the range of the coefficients. ``filter`` steps by them. Beside
the ten numbers of the motion a state has seven slow ones, which a record tells of and a boat's file
does not: weight and trim, errors of gauges, and a current.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.boat.regressors import ATOM_PLACES
from trainer.identify.kernels.kernel import indices, lean_kernel

Indices = NDArray[np.int64]

STATE_NAMES: Final = (
    *("u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "z"),
    *("weight", "trim", "pitch_error", "roll_error", "log_error", "north_flow", "east_flow"),
)
STATE: Final = indices(
    "U V W P Q R PHI THETA PSI Z WEIGHT TRIM PITCH_ERROR ROLL_ERROR LOG_ERROR NORTH EAST"
)
MOTION_COUNT: Final = 10  # numbers of a state that move; the slow ones follow
STATE_COUNT: Final = len(STATE_NAMES)
CONTROL_PLACES: Final = indices("RUDDER STERN BOW UC")
BODY_PLACES: Final = indices(
    "MASS WEIGHT BUOYANCY X_G Y_G Z_G X_B Y_B Z_B I_X I_Y I_Z I_XY I_YZ I_XZ ETA_WHOLE"
)


class BoatNumbers(NamedTuple):
    """A boat as kernels take it."""

    body: Numbers  # of BODY_PLACES, SI
    forces: Numbers  # (terms,) coefficients with rho/2 and the power of L
    scales: Numbers  # (terms,) rho/2 L^n, of which a coefficient is multiplied
    inverse: Numbers  # (6, 6) of the mass matrix
    factors: Indices  # of regressors.TermTable
    rows: Indices
    moving: Indices


@lean_kernel
def write_atoms(body: Numbers, x: Numbers, control: Numbers, atoms: Numbers) -> None:
    """Write what terms are products of; accelerations are left as they are."""
    u, v, w = x[STATE.U], x[STATE.V], x[STATE.W]
    p, q, r = x[STATE.P], x[STATE.Q], x[STATE.R]
    cross = math.sqrt(v * v + w * w)
    speed = math.sqrt(u * u + cross * cross) if body[BODY_PLACES.ETA_WHOLE] != 0.0 else u
    atoms[ATOM_PLACES.ONE] = 1.0
    atoms[ATOM_PLACES.U], atoms[ATOM_PLACES.V], atoms[ATOM_PLACES.W] = u, v, w
    atoms[ATOM_PLACES.P], atoms[ATOM_PLACES.Q], atoms[ATOM_PLACES.R] = p, q, r
    atoms[ATOM_PLACES.ABS_U], atoms[ATOM_PLACES.ABS_W] = abs(u), abs(w)
    atoms[ATOM_PLACES.ABS_P], atoms[ATOM_PLACES.ABS_Q], atoms[ATOM_PLACES.ABS_R] = (
        abs(p),
        abs(q),
        abs(r),
    )
    atoms[ATOM_PLACES.SIGN_V], atoms[ATOM_PLACES.SIGN_W] = np.sign(v), np.sign(w)
    atoms[ATOM_PLACES.CROSS] = cross
    atoms[ATOM_PLACES.DR], atoms[ATOM_PLACES.DS] = (
        control[CONTROL_PLACES.RUDDER],
        control[CONTROL_PLACES.STERN],
    )
    atoms[ATOM_PLACES.DB], atoms[ATOM_PLACES.UC] = (
        control[CONTROL_PLACES.BOW],
        control[CONTROL_PLACES.UC],
    )
    atoms[ATOM_PLACES.SLIP] = control[CONTROL_PLACES.UC] / speed - 1.0 if speed != 0.0 else 0.0


@lean_kernel
def product(factors: Indices, j: int, atoms: Numbers) -> float:
    """Return what term ``j`` multiplies."""
    value = atoms[factors[j, 0]] * atoms[factors[j, 1]]
    for i in range(2, factors.shape[1]):
        if factors[j, i] == ATOM_PLACES.ONE:
            break
        value *= atoms[factors[j, i]]
    return value


@lean_kernel
def write_rates(
    boat: BoatNumbers, x: Numbers, control: Numbers, atoms: Numbers, force: Numbers, rate: Numbers
) -> None:
    """Write the rates (10,) of a state, and its products and accelerations to ``atoms``.

    ``force`` (6,) is scratch. Rigid body, weight and buoyancy are as in ``trainer.core.full``.
    """
    body, c = boat.body, boat.forces
    write_atoms(body, x, control, atoms)
    u, v, w = x[STATE.U], x[STATE.V], x[STATE.W]
    p, q, r = x[STATE.P], x[STATE.Q], x[STATE.R]
    sin_phi, cos_phi = math.sin(x[STATE.PHI]), math.cos(x[STATE.PHI])
    sin_th, cos_th = math.sin(x[STATE.THETA]), math.cos(x[STATE.THETA])
    m, W, B = body[BODY_PLACES.MASS], body[BODY_PLACES.WEIGHT], body[BODY_PLACES.BUOYANCY]
    x_g, y_g, z_g = body[BODY_PLACES.X_G], body[BODY_PLACES.Y_G], body[BODY_PLACES.Z_G]
    I_x, I_y, I_z = body[BODY_PLACES.I_X], body[BODY_PLACES.I_Y], body[BODY_PLACES.I_Z]
    I_xy, I_yz, I_xz = body[BODY_PLACES.I_XY], body[BODY_PLACES.I_YZ], body[BODY_PLACES.I_XZ]
    net = W - B + W * x[STATE.WEIGHT]
    along = x_g * W - body[BODY_PLACES.X_B] * B + W * x[STATE.TRIM]
    aside = y_g * W - body[BODY_PLACES.Y_B] * B
    below = z_g * W - body[BODY_PLACES.Z_B] * B

    force[0] = m * (v * r - w * q + x_g * (q * q + r * r) - y_g * p * q - z_g * p * r)
    force[1] = m * (w * p - u * r + y_g * (r * r + p * p) - z_g * q * r - x_g * q * p)
    force[2] = m * (u * q - v * p + z_g * (p * p + q * q) - x_g * r * p - y_g * r * q)
    force[3] = (I_y - I_z) * q * r + I_xz * p * q - I_yz * (r * r - q * q) - I_xy * p * r
    force[3] += m * (y_g * (u * q - v * p) - z_g * (w * p - u * r))
    force[4] = (I_z - I_x) * r * p + I_xy * q * r - I_xz * (p * p - r * r) - I_yz * q * p
    force[4] += m * (z_g * (v * r - w * q) - x_g * (u * q - v * p))
    force[5] = (I_x - I_y) * p * q + I_yz * r * p - I_xy * (q * q - p * p) - I_xz * r * q
    force[5] += m * (x_g * (w * p - u * r) - y_g * (v * r - w * q))
    force[0] -= net * sin_th
    force[1] += net * cos_th * sin_phi
    force[2] += net * cos_th * cos_phi
    force[3] += aside * cos_th * cos_phi - below * cos_th * sin_phi
    force[4] -= along * cos_th * cos_phi + below * sin_th
    force[5] += along * cos_th * sin_phi + aside * sin_th
    for k in range(boat.moving.size):
        j = boat.moving[k]
        force[boat.rows[j]] += c[j] * product(boat.factors, j, atoms)

    for i in range(6):
        acceleration = 0.0
        for j in range(6):
            acceleration += boat.inverse[i, j] * force[j]
        rate[i] = acceleration
        atoms[ATOM_PLACES.UDOT + i] = acceleration
    turning = q * sin_phi + r * cos_phi
    rate[STATE.PHI] = p + turning * sin_th / cos_th
    rate[STATE.THETA] = q * cos_phi - r * sin_phi
    rate[STATE.PSI] = turning / cos_th
    rate[STATE.Z] = -u * sin_th + (v * sin_phi + w * cos_phi) * cos_th


def mass_matrix(body: Numbers, added: Numbers) -> Numbers:
    """Return the mass matrix (6, 6) [kg, kg m, kg m2], [ASSES] III-C-8."""
    m, x, y, z = (
        body[i] for i in (BODY_PLACES.MASS, BODY_PLACES.X_G, BODY_PLACES.Y_G, BODY_PLACES.Z_G)
    )
    I_xy, I_yz, I_xz = body[BODY_PLACES.I_XY], body[BODY_PLACES.I_YZ], body[BODY_PLACES.I_XZ]
    lever = m * np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    inertia = np.diag(body[BODY_PLACES.I_X : BODY_PLACES.I_Z + 1])
    inertia -= np.array([[0.0, I_xy, I_xz], [I_xy, 0.0, I_yz], [I_xz, I_yz, 0.0]])
    return np.block([[m * np.eye(3), lever], [lever.T, inertia]]) - added
