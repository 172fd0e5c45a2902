"""What is known of a boat before its records: an estimate, or an earlier fit.

The parameters that a fit moves are standard normal by construction: a coefficient is its mean plus
``root`` times z. What is common to coefficients stands in ``root``, so the information of the prior
is the unit matrix, and no covariance that is singular need be inverted. A posterior is the prior of
the next fit.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from trainer.analysis.estimate.uncertainty import (
    LINEAR_TERMS,
    OWN_SHARE,
    TWIN_COEFFICIENTS,
    Estimate,
    JointCoefficients,
    deviates,
    filed_estimate,
    filed_fit,
    keep_sign,
)
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError, parse_toml
from trainer.core.kernel import Numbers
from trainer.identify.boat.matrices import root_of_covariance
from trainer.identify.boat.regressors import HEIGHT_KEY, PARAMETER_NAMES
from trainer.identify.boat.vessel import AHEAD_ROW, FittedVessel

THRUST_SHARE: Final = 0.02  # [-] of a1, b1 and c1, each by itself beside the resistance
HEIGHT_SHARE: Final = 0.15  # [-] of the height of buoyancy over gravity, from a drawing


@dataclass(frozen=True, eq=False)
class Knowledge:
    """Parameters with their deviations from z, which is standard normal: values + root z."""

    values: Numbers  # (m,) as regressors.PARAMETER_NAMES
    root: Numbers  # (m, k)

    @cached_property
    def sd(self) -> Numbers:
        """Return the standard deviation (m,) of each parameter."""
        return np.asarray(np.sqrt(np.sum(self.root**2, axis=1)))

    def draw(self, number: int) -> Numbers:
        """Return the parameters of one draw (m,); number 0 is the values themselves.

        Damping, added mass and the effect of controls keep their sign.
        """
        if number == 0:
            return self.values
        drawn = self.values + self.root @ deviates(number, self.root.shape[1])
        return np.array([*map(keep_sign, PARAMETER_NAMES, self.values, drawn)])


@dataclass(frozen=True, eq=False)
class Prior(Knowledge):
    """What is known before a fit, and of which boat."""

    vessel: FittedVessel
    tables: Mapping[str, Any]  # of the vessel's file
    common: int  # the first columns of root, which many boats have in common; 0 after a fit


def read_prior(name_or_path: str) -> Prior:
    """Return what a vessel file says of its boat and its deviations.

    ConfigError if it has none, or a damaged table of them.
    """
    file = load_vessel(name_or_path)
    tables = parse_toml(file.text, file.path.name)
    vessel = FittedVessel(file)
    if "covariance" in tables:
        root, common = fitted_root(filed_fit(file, tables)), 0
    elif "estimate" in tables:
        made = filed_estimate(file, tables)
        root, common = estimate_root(made, vessel), len(made.names)
    else:
        raise ConfigError(
            f"{file.path.name}: has no deviations, neither [estimate] nor [covariance]: a fit "
            "begins with what trainer boat estimate HULL -o FILE writes, or with an earlier fit"
        )
    return Prior(vessel.values, root, vessel, tables, common)


def estimate_root(made: Estimate, vessel: FittedVessel) -> Numbers:
    """Return ``Estimate.draw`` linearised: parameters (m,) by deviates of the normal (k,).

    First come the constants of the method, then what each coefficient has of its own. Equal added
    masses share a deviate.
    """
    columns = dict(zip(made.estimated, made.common_parts.T, strict=True))
    shared = np.zeros((len(PARAMETER_NAMES), len(made.names)))
    own = np.zeros(len(PARAMETER_NAMES))
    for i, name in enumerate(PARAMETER_NAMES):
        if name == HEIGHT_KEY:
            hull = vessel.file.hull
            own[i] = HEIGHT_SHARE * abs(hull.cg[2] - hull.cb[2])
            continue
        sd, common = made.sd[name], made.by_constants[name]
        shared[i] = columns[name] * (min(1.0, sd / common) if common > 0.0 else 0.0)
        if name in AHEAD_ROW:
            own[i] = THRUST_SHARE * abs(vessel.values[i])
        elif name in LINEAR_TERMS:
            own[i] = OWN_SHARE * sd
        else:
            own[i] = math.sqrt(max(sd**2 - common**2, 0.0))
    alone = np.diag(own)
    for twin, key in TWIN_COEFFICIENTS.items():
        first, second = PARAMETER_NAMES.index(key), PARAMETER_NAMES.index(twin)
        alone[second], shared[second] = alone[first], shared[first]
    return np.hstack([shared, alone[:, alone.any(axis=0)]])


def fitted_root(known: JointCoefficients) -> Numbers:
    """Return the root (m, k) of the covariance of an earlier fit."""
    # scaled by the deviations, because their sizes differ by many powers of ten
    sd = np.sqrt(np.maximum(np.diag(known.covariance), 0.0))
    scale = np.where(sd > 0.0, sd, 1.0)
    root = np.zeros((len(PARAMETER_NAMES), len(scale)))
    scaled = known.covariance / np.outer(scale, scale)
    indices = [PARAMETER_NAMES.index(name) for name in known.values]
    root[indices] = scale[:, None] * root_of_covariance(scaled)
    return root
