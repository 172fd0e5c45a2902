"""What the coefficients of a boat say before it moves: symmetry, inertia, margins, reversal."""

import math
from dataclasses import dataclass

import numpy as np

from trainer.boat import Boat
from trainer.core import full
from trainer.files.terms import coefficient_terms
from trainer.files.vessel_file import VesselFile
from trainer.fitout import Method
from trainer.study.linear import respond

SIDED = ("Y_star", "K_star", "N_star", "K_star_eta")  # [ASSES] equations (2), (4), (6)


def absent(file: VesselFile, *, kept: bool) -> dict[str, list[str]]:
    """Return by equation the coefficients not given; ``kept``: that the compact set would keep."""
    found: dict[str, list[str]] = {}
    for term in coefficient_terms():
        if term.key in file.absent and term.kept == kept:
            found.setdefault(term.equation, []).append(term.key)
    return found


def asymmetries(file: VesselFile) -> dict[str, float]:
    """Return by name what makes port and starboard differ: coefficients [-], [m] and [kg m2]."""
    hull = file.hull
    sided = {name: file.coefficients[name] for name in SIDED}
    sided |= {"y_G": hull.cg[1], "y_B": hull.cb[1], "I_xy": hull.Ixy, "I_yz": hull.Iyz}
    return {name: value for name, value in sided.items() if value != 0.0}


@dataclass(frozen=True)
class Inertia:
    """The 6x6 mass matrix, scaled by its own diagonal, and how fast the lagged sweep forgets."""

    condition: float
    smallest: float  # smallest eigenvalue of the symmetric part
    definite: bool
    contraction: dict[str, float]  # spectral radius of the sweep by equation set


def inertia(file: VesselFile, step: float) -> Inertia:
    """Return condition [-], definiteness and contraction [-] of the boat at rest."""
    contraction = {}
    for equations in ("full", "modified"):
        boat = Boat(file, Method(equations, "lagged", "exact", "adams2", step))
        boat.state.u = boat.state.u_c = 1.0
        contraction[equations] = float(abs(np.linalg.eigvals(respond(boat).G)).max())
    matrix = np.zeros((6, 6))
    boat = Boat(file, Method("full", "exact", "exact", "adams2", step))
    full.inertia(boat.records.vessel, boat.records.state, matrix)
    scale = np.sqrt(abs(np.diag(matrix)))  # of masses and of mass times length squared
    scaled = matrix / np.outer(scale, scale)
    smallest = float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min())
    return Inertia(float(np.linalg.cond(scaled)), smallest, smallest > 0.0, contraction)


def _ratio(above: float, below: float) -> float | None:
    """Return above/below, None where there is nothing to divide by."""
    return above / below if below != 0.0 else None


def margins(file: VesselFile) -> dict[str, float | None]:
    """Return the margins of stability [-] in the vertical and horizontal plane, Gv and Gh.

    Gv = 1 - M_w (Z_q + m')/(Z_w M_q), Gh = 1 - N_v (Y_r - m')/(Y_v N_r), as printed for SUBOFF
    (Roddy 1990); None where a damping is zero.
    """
    c = file.coefficients
    mass = file.hull.mass / (0.5 * file.fluid.rho * file.hull.length**3)
    vertical = _ratio(c["M_w"] * (c["Z_q"] + mass), c["Z_w"] * c["M_q"])
    horizontal = _ratio(c["N_v"] * (c["Y_r"] - mass), c["Y_v"] * c["N_r"])
    return {
        "Gv": None if vertical is None else 1.0 - vertical,
        "Gh": None if horizontal is None else 1.0 - horizontal,
    }


def critical_speed(file: VesselFile, plane: str) -> float | None:
    """Return the speed [m/s] at which depth control by the "stern" or "bow" planes reverses.

    Linear, program EC470: u^2 = Z_d R/(Z_w M_d - Z_d M_w), R = 2 (z_B B - z_G W)/(rho L^3). None if
    there is no such speed or no such plane.
    """
    c, hull = file.coefficients, file.hull
    force, moment = c[f"Z_d{plane[0]}"], c[f"M_d{plane[0]}"]
    couple = 2.0 * (hull.cb[2] * hull.buoyancy - hull.cg[2] * hull.weight)
    stiffness = force * couple / (file.fluid.rho * hull.length**3)
    square = _ratio(stiffness, c["Z_w"] * moment - force * c["M_w"])
    return math.sqrt(square) if square is not None and square > 0.0 else None
