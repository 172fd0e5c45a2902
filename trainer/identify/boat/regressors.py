"""The terms of Report 2510 as products, generated from the table of terms.

A force is linear in its coefficients: F = sum of C times a product of velocities, angles and slip.
The same product is therefore the force's slope by the coefficient, and ``motion`` and ``filter``
take both from here. Left out are the second and third thrust rows, since a fit is of a boat that
goes ahead.
"""

import re
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.core.terms import TERM_TABLE, Term
from trainer.identify.kernels.kernel import indices

# what the terms are products of; the last six are accelerations
# fmt: off
ATOM_NAMES: Final = (
    "1", "u", "v", "w", "p", "q", "r", "|u|", "|w|", "|p|", "|q|", "|r|", "sgn(v)", "sgn(w)",
    "(v^2+w^2)^0.5", "dr", "ds", "db", "uc", "(eta-1)",
    "udot", "vdot", "wdot", "pdot", "qdot", "rdot",
)
# fmt: on
# the same as names of Python, for kernels
ATOM_PLACES: Final = indices(
    "ONE U V W P Q R ABS_U ABS_W ABS_P ABS_Q ABS_R SIGN_V SIGN_W CROSS DR DS DB UC SLIP"
    " UDOT VDOT WDOT PDOT QDOT RDOT"
)
MAX_FACTORS: Final = 5  # of one term
DRAG_FACTORS: Final = ("u", "|u|")  # of a1, as the core has it: drag always acts against the way
REAR_ROWS: Final = ("a2", "b2", "c2", "a3", "b3", "c3")  # thrust off the ahead row
FITTED_TERMS: Final = tuple(term for term in TERM_TABLE if term.key not in REAR_ROWS)
HEIGHT_KEY: Final = "z_b"  # [m] of the centre of buoyancy, fitted beside the coefficients
PARAMETER_NAMES: Final = (*(term.key for term in FITTED_TERMS), HEIGHT_KEY)


class TermTable(NamedTuple):
    """The fitted terms as numbers, for kernels."""

    factors: NDArray[np.int64]  # (terms, MAX_FACTORS) indices of atoms
    rows: NDArray[np.int64]  # (terms,) 0 to 5, X Y Z K M N
    powers: NDArray[np.int64]  # (terms,) of the length
    moving: NDArray[np.int64]  # (m,) terms that multiply no acceleration
    axes: NDArray[np.int64]  # (terms,) the acceleration that a term multiplies; -1: none


def split_factors(term: Term) -> list[str]:
    """Return what a term multiplies, as names of ATOM_NAMES; ``q^2`` is q twice."""
    if term.key == "a1":
        return [*DRAG_FACTORS]
    words = term.multiplies.replace("|w (v^2+w^2)^0.5|", "|w| (v^2+w^2)^0.5").split()
    factors: list[str] = []
    for word in words:
        square = re.fullmatch(r"(\w+)\^2", word)
        factors += [square[1], square[1]] if square else [word]
    return factors


def _numbers() -> TermTable:
    """Return the table of the fitted terms."""
    factors = np.zeros((len(FITTED_TERMS), MAX_FACTORS), np.int64)
    axes = np.full(len(FITTED_TERMS), -1)
    for j, term in enumerate(FITTED_TERMS):
        found = [ATOM_NAMES.index(name) for name in split_factors(term)]
        factors[j, : len(found)] = found
        if max(found) >= ATOM_PLACES.UDOT:
            axes[j] = max(found) - ATOM_PLACES.UDOT
    rows = np.array(["XYZKMN".index(term.equation) for term in FITTED_TERMS])
    powers = np.array([term.power for term in FITTED_TERMS])
    return TermTable(factors, rows, powers, np.flatnonzero(axes < 0), axes)


TERM_NUMBERS: Final = _numbers()
