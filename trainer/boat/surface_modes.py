"""How a boat heaves, pitches and rolls at the surface, at its lightest."""

import math
from typing import Final

import numpy as np

from trainer.core.ballast.buoyancy import segment
from trainer.core.ballast.tanks import NEGATIVE
from trainer.core.kernel import Numbers, Record

LIGHT: Final = 0.05  # [-] of the weight that a boat without tanks is taken to be lighter
HALVINGS: Final = 60


def lightness(c: Record) -> Numbers:
    """Return the share of the buoyancy [-] above the water at the lightest, at most half."""
    blown = c["start"][:, :NEGATIVE].sum(axis=1) * c["g"] * (c["fitted"] != 0.0)
    light = (c["buoyancy"] - c["weight"] + blown) / c["buoyancy"]
    return np.where(light > 0.0, np.minimum(light, 0.5), LIGHT)


def float_height(share: float) -> float:
    """Return the height [-] of the part of a circle above the water, in diameters, by its share."""
    low, high = 0.0, 0.5
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if segment(middle) < share else (low, middle)
    return 0.5 * (low + high)


def surface_modes(c: Record) -> dict[str, Numbers]:
    """Return the frequencies [rad/s] of heave, pitch and roll of boats afloat at their lightest."""
    shares, which = np.unique(lightness(c), return_inverse=True)
    height = np.array([float_height(float(share)) for share in shares])[which]
    chord = 2.0 * np.sqrt(height * (1.0 - height))
    plane = 4.0 * c["buoyancy"] * chord / (math.pi * c["hull_diameter"])
    stiffness = plane[:, None] * c["station_share"]
    heave = stiffness.sum(axis=1) / (c["mass"] * (1.0 - shares[which]) + c["m33"])
    righting = c["z_g"] * c["weight"] - c["z_b"] * c["buoyancy"]
    trim = (stiffness * c["station_x"] ** 2).sum(axis=1)
    pitch = (trim + righting) / (c["I_y"] + c["m55"])
    roll = righting / (c["I_x"] + c["m44"])
    squares = {"heave": heave, "pitch": pitch, "roll": roll}
    return {name: np.sqrt(np.maximum(square, 0.0)) for name, square in squares.items()}
