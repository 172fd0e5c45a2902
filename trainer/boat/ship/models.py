"""Four models of ships that are not linear, and their coefficients.

A coefficient is named by its equation and its term: ``N_vvr`` is the factor of v'^2 r' in the yaw
equation, an acceleration in prime units (over U^2/L, in yaw over U^2/L^2). ``mmg`` has the rudder
in the slipstream; ``abkowitz``, ``mavmm`` and ``linear`` have the rudder's angle. A ship whose file
has ``[roll]`` has an equation more in any of them, K; K_phi and K_p are in units of the stiffness g
GM/k^2 and of its root. ``identify/ships`` fits them and ``motion`` sails them. They differ in how
much a record must tell: ``linear`` needs least.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trainer.boat.ship.forces import HEEL_EQUATIONS, LEVEL_EQUATIONS, TERM_ROWS, DrivenStates, Terms
from trainer.config.files import ConfigError, nearest
from trainer.config.ship.ship import ShipFile
from trainer.core.kernel import Numbers

AXIS_LETTERS: Final = "XYNK"
NONLINEAR_NAMES: Final = ("gamma", "l", "kappa", "c_w", "gamma_a")
FIXED_VALUES: Final = {"gamma": 0.5, "l": -0.71, "kappa": 0.5, "c_w": 0.0, "gamma_a": 0.0}
CUBIC_TERMS: Final = "vvv vvr vrr rrr"
MODELS: Final[Mapping[str, tuple[str, str]]] = {  # terms of surge; of sway and yaw
    "linear": ("0 T vv vr rr dd", "0 v r d"),
    "mavmm": ("0 T vr rr dd", "0 T v r ur d vvd Td"),
    "abkowitz": ("0 T vv vr rr dd", f"0 v r d {CUBIC_TERMS} vvd Td"),
    "mmg": ("0 T vv vr rr F", f"0 v r {CUBIC_TERMS} F"),
}
WIND_NAMES: Final = ("X_w", "Y_w", "N_w", "N_ww")
ROLL_NAMES: Final = ("K_phi", "K_p", "Y_phi", "N_phi")  # times roll or roll rate
NOISE_NAMES: Final = (  # of each equation, and of each reading
    ("sigma_w_u", "sigma_w_v", "sigma_w_r", "sigma_w_p"),
    ("sigma_e_u", "sigma_e_v", "sigma_e_r", "sigma_e_psi", "sigma_e_p", "sigma_e_phi"),
)
ABKOWITZ_TERMS: Final = {  # his terms beside the cubes: nothing, unless a ship's file gives them
    "X": "u uu uuu udd vd uvd",
    **dict.fromkeys("YN", "u uu vu ru ud uud ddd vdd"),
}
FURTHER_NAMES: Final = tuple(
    f"{axis}_{term}" for axis in ABKOWITZ_TERMS for term in ABKOWITZ_TERMS[axis].split()
)
SPEED_NAMES: Final = ("X_u", "X_uu", "X_uuu")  # which have the thrust in them, so that these do not
THRUST_NAMES: Final = ("X_T", "Y_Td", "N_Td")


@dataclass(frozen=True)
class ShipModel:
    """A model: its coefficients, in the order of the kernels."""

    name: str
    names: tuple[str, ...]  # factors of terms, then the nonlinear ones
    free: tuple[str, ...]
    held: Mapping[str, float] = field(default_factory=dict)  # by the ship's file, where it has them
    driven: DrivenStates = LEVEL_EQUATIONS  # the equations' indices in the state

    @property
    def states(self) -> int:
        """Return how many states there are, and readings."""
        return 2 * len(self.driven) - 2

    @property
    def noises(self) -> tuple[str, ...]:
        """Return the names of disturbances and of errors of readings."""
        return (*NOISE_NAMES[0][: len(self.driven)], *NOISE_NAMES[1][: self.states])

    @property
    def terms(self) -> Terms:
        """Return part and row of each factor."""
        return np.array([_term(name) for name in self.names[: -len(NONLINEAR_NAMES)]])

    @property
    def indices(self) -> Terms:
        """Return the indices of the free coefficients (p, 1)."""
        return np.array([self.names.index(name) for name in self.free]).reshape(-1, 1)

    def whole(self, values: Mapping[str, float]) -> Numbers:
        """Return every coefficient, as the kernels take them; what is not given is fixed."""
        known = {**FIXED_VALUES, **self.held, **values}
        return np.array([known.get(name, 0.0) for name in self.names])

    def without(self, names: tuple[str, ...]) -> "ShipModel":
        """Return the model with some of its free coefficients fixed."""
        return replace(self, free=tuple(name for name in self.free if name not in names))


def _term(name: str) -> tuple[int, int]:
    """Return part and row of the term of a coefficient."""
    axis, _, term = name.partition("_")
    if name in ROLL_NAMES:
        times = 1 if term == "p" else 2
        return AXIS_LETTERS.index(axis) + times * len(AXIS_LETTERS), TERM_ROWS[
            "one" if axis == "K" else "1"
        ]
    term_name = {"X_F": "X_F", "X_w": "X_w"}.get(name, "1" if term == "0" else term)
    return AXIS_LETTERS.index(axis), TERM_ROWS[term_name]


def model_of(name: str, *, wind: bool) -> ShipModel:
    """Return the model of that name, with wind where there was some."""
    surge, others = MODELS[name]
    factors = [f"X_{term}" for term in surge.split()]
    factors += [f"{axis}_{term}" for axis in "YN" for term in others.split()]
    factors += WIND_NAMES if wind else ()
    curved = ("gamma", "l", "kappa", "c_w") if name == "mmg" else ()
    return ShipModel(name, (*factors, *NONLINEAR_NAMES), (*factors, *curved))


def with_roll(model: ShipModel) -> ShipModel:
    """Return a model with roll."""
    rudder = "K_F" if "N_F" in model.names else "K_d"
    wind = ("K_w",) if "N_w" in model.names else ()
    roll_names = ("K_0", "K_v", "K_r", rudder, *wind, *ROLL_NAMES)
    names, free = (
        (
            *(name for name in listed if name not in NONLINEAR_NAMES),
            *roll_names,
            *(x for x in listed if x in NONLINEAR_NAMES),
        )
        for listed in (model.names, model.free)
    )
    return replace(model, names=names, free=free, driven=HEEL_EQUATIONS)


def model_for(ship: ShipFile, name: str, *, wind: bool) -> ShipModel:
    """Return the model with roll and further terms, where a ship's file gives them. ConfigError.

    Further terms are held, not fitted. Terms in the speed of surge have the thrust in them, so that
    the terms of thrust are held at 0 beside them.
    """
    model = model_of(name, wind=wind)
    if ship.roll is not None:
        model = with_roll(model)
    further = {key: ship.coefficients[key] for key in FURTHER_NAMES if key in ship.coefficients}
    if name != "abkowitz" or not further:
        return model
    if ship.dimensions.advance_m is None:
        raise ConfigError(
            f"{ship.path.name}: [dimensions] lacks advance_m, which {min(further)} needs"
        )
    names = (*model.names[: -len(NONLINEAR_NAMES)], *further, *NONLINEAR_NAMES)
    held = THRUST_NAMES if any(key in further for key in SPEED_NAMES) else ()
    whole = replace(model, names=names, held={**dict.fromkeys(held, 0.0), **further})
    return whole.without(held)


def check_names(ship: ShipFile, model: ShipModel) -> None:
    """Check that a ship's file has the model's coefficients and no others; ConfigError."""
    name, coefficients = ship.path.name, ship.coefficients
    if missing := [key for key in model.free if key not in coefficients]:
        raise ConfigError(f"{name}: [coefficients] lacks {', '.join(missing)}")
    known = (*model.names, *model.held, *WIND_NAMES, "K_w")
    if strange := [key for key in coefficients if key not in known]:
        hint = nearest(strange[0], (*known, *(FURTHER_NAMES if model.name == "abkowitz" else ())))
        raise ConfigError(
            f"{name}: [coefficients] {strange[0]} is none of model {model.name}{hint}"
        )
