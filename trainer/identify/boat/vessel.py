"""A vessel file as a fit takes it: numbers for kernels, and its parameters."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from trainer.config.boat.propulsion import ThrustRows
from trainer.config.boat.vessel import VesselFile
from trainer.config.boat.vessel_records import ThrustSet
from trainer.core.kernel import Numbers
from trainer.identify.boat.motion import BoatNumbers, mass_matrix
from trainer.identify.boat.regressors import (
    HEIGHT_KEY,
    PARAMETER_NAMES,
    TERM_NUMBERS,
)
from trainer.units import KNOT

REFERENCE_LENGTH_M: Final = 70.2  # [m] of BB2, from which usual sizes are scaled
REFERENCE_SPEED_M_S: Final = 5.144  # [m/s] 10 kn
AHEAD_ROW: Final = {"a1": "a", "b1": "b", "c1": "c"}  # of a thrust row, by parameter


@dataclass(frozen=True)
class FittedVessel:
    """A boat whose coefficients are to be fitted; the rest of its file stays."""

    file: VesselFile

    @property
    def length(self) -> float:
        """Return the reference length [m]."""
        return self.file.hull.length

    @property
    def speed(self) -> float:
        """Return the design speed [m/s], at which the file starts."""
        return self.file.run.start_speed_kn * KNOT

    @property
    def pace(self) -> float:
        """Return U/L over that of BB2 at 10 kn [-]: how much faster all happens."""
        return (self.speed / REFERENCE_SPEED_M_S) * (REFERENCE_LENGTH_M / self.length)

    @cached_property
    def thrust(self) -> dict[str, float]:
        """Return the ahead row of thrust."""
        first = self.file.thrust.ahead[0]
        return {key: float(getattr(first, name)) for key, name in AHEAD_ROW.items()}

    @cached_property
    def values(self) -> Numbers:
        """Return the parameters as the file has them: primes [-] and the height [m]."""
        found = {**self.file.coefficients, **self.thrust, HEIGHT_KEY: self.file.hull.cb[2]}
        return np.array([found[name] for name in PARAMETER_NAMES])

    @cached_property
    def scales(self) -> Numbers:
        """Return rho/2 L^n of each coefficient, in SI."""
        return np.asarray(0.5 * self.file.fluid.rho * self.length**TERM_NUMBERS.powers)

    def body(self, height: float) -> Numbers:
        """Return the numbers of motion.BODY, the centre of buoyancy at ``height`` [m]."""
        hull, whole = self.file.hull, self.file.propulsion.eta_speed == "whole"
        centres = *hull.cg, *hull.cb[:2], height
        inertia = hull.Ix, hull.Iy, hull.Iz, hull.Ixy, hull.Iyz, hull.Ixz
        return np.array([hull.mass, hull.weight, hull.buoyancy, *centres, *inertia, float(whole)])

    def mass(self, values: Numbers) -> Numbers:
        """Return the mass matrix (6, 6) of parameters (m,), added mass in it."""
        forces, added, table = values[:-1] * self.scales, np.zeros((6, 6)), TERM_NUMBERS
        for j in np.flatnonzero(table.axes >= 0):
            added[table.rows[j], table.axes[j]] = forces[j]
        return mass_matrix(self.body(values[-1]), added)

    def has_inertia(self, values: Numbers) -> bool:
        """Return whether each motion has inertia, for parameters (m,)."""
        mass = self.mass(values)
        return bool(np.linalg.eigvalsh(0.5 * (mass + mass.T))[0] > 0.0)

    def numbers(self, values: Numbers) -> BoatNumbers:
        """Return the boat of parameters (m,), as ``values`` has them, for kernels."""
        body, forces, table = self.body(values[-1]), values[:-1] * self.scales, TERM_NUMBERS
        inverse = np.linalg.inv(self.mass(values))
        parts = table.factors, table.rows, table.moving
        return BoatNumbers(body, forces, self.scales, np.ascontiguousarray(inverse), *parts)

    def with_values(self, values: Numbers) -> VesselFile:
        """Return the vessel with other parameters (m,)."""
        found = named(values)
        kept = {key: found[key] for key in self.file.coefficients}
        rows, hull = self.file.thrust, self.file.hull
        ahead, astern = (
            tuple(ThrustSet(**joined_row(asdict(row), self.thrust, found)) for row in part)
            for part in rows
        )
        thrust = ThrustRows(ahead, (astern[0], astern[1]))
        hull = replace(hull, cb=(*hull.cb[:2], found[HEIGHT_KEY]))
        return replace(self.file, coefficients=kept, thrust=thrust, hull=hull)


def joined_row(
    row: Mapping[str, Any], before: Mapping[str, float], found: Mapping[str, float]
) -> dict[str, Any]:
    """Return a thrust row after a fit of the ahead row.

    Where rows meet they have a number in common, and keep it so.
    """
    changed = dict(row)
    for key, name in AHEAD_ROW.items():
        if row[name] == before[key]:
            changed[name] = found[key]
    return changed


def named(values: Numbers) -> dict[str, float]:
    """Return parameters by name."""
    return dict(zip(PARAMETER_NAMES, map(float, values), strict=True))
