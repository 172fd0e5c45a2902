"""Four models of ships that are not linear, and their coefficients.

A coefficient is named by its equation and its term: ``N_vvr`` is the factor of v'^2 r' in the yaw
equation, an acceleration in prime units (over U^2/L, in yaw over U^2/L^2). ``mmg`` has the rudder
in the slipstream; ``abkowitz``, ``mavmm`` and ``linear`` have the rudder's angle. A ship whose
file has ``[roll]`` has an equation more in any of them, K; K_phi and K_p are in units of the
stiffness g GM/k^2 and of its root.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trainer.boat.ship.forces import HEELING, LEVEL, TERM_ROWS, Driven, Terms
from trainer.config.files import ConfigError, nearest
from trainer.config.ship import ShipFile
from trainer.core.kernel import Numbers

AXES: Final = "XYNK"
NONLINEAR: Final = ("gamma", "l", "kappa", "c_w", "gamma_a")
FIXED: Final = {"gamma": 0.5, "l": -0.71, "kappa": 0.5, "c_w": 0.0, "gamma_a": 0.0}
CUBES: Final = "vvv vvr vrr rrr"
MODELS: Final[Mapping[str, tuple[str, str]]] = {  # terms of surge; of sway and yaw
    "linear": ("0 T vv vr rr dd", "0 v r d"),
    "mavmm": ("0 T vr rr dd", "0 T v r ur d vvd Td"),
    "abkowitz": ("0 T vv vr rr dd", f"0 v r d {CUBES} vvd Td"),
    "mmg": ("0 T vv vr rr F", f"0 v r {CUBES} F"),
}
WIND: Final = ("X_w", "Y_w", "N_w", "N_ww")
OF_ROLL: Final = ("K_phi", "K_p", "Y_phi", "N_phi")  # times roll or roll rate
NOISES: Final = (  # of each equation, and of each reading
    ("sigma_w_u", "sigma_w_v", "sigma_w_r", "sigma_w_p"),
    ("sigma_e_u", "sigma_e_v", "sigma_e_r", "sigma_e_psi", "sigma_e_p", "sigma_e_phi"),
)
ABKOWITZ: Final = {  # his terms beside the cubes: nothing, unless a ship's file gives them
    "X": "u uu uuu udd vd uvd",
    **dict.fromkeys("YN", "u uu vu ru ud uud ddd vdd"),
}
FURTHER: Final = tuple(f"{axis}_{term}" for axis in ABKOWITZ for term in ABKOWITZ[axis].split())
OF_SPEED: Final = ("X_u", "X_uu", "X_uuu")  # which have the thrust in them, so that these do not
OF_THRUST: Final = ("X_T", "Y_Td", "N_Td")


@dataclass(frozen=True)
class Model:
    """A model: its coefficients, in the order of the kernels."""

    name: str
    names: tuple[str, ...]  # factors of terms, then the nonlinear ones
    free: tuple[str, ...]
    held: Mapping[str, float] = field(default_factory=dict)  # by the ship's file, where it has them
    driven: Driven = LEVEL  # the equations' places in the state

    @property
    def states(self) -> int:
        """Return how many states there are, and readings."""
        return 2 * len(self.driven) - 2

    @property
    def noises(self) -> tuple[str, ...]:
        """Return the names of disturbances and of errors of readings."""
        return (*NOISES[0][: len(self.driven)], *NOISES[1][: self.states])

    @property
    def terms(self) -> Terms:
        """Return place and row of each factor."""
        return np.array([_term(name) for name in self.names[: -len(NONLINEAR)]])

    @property
    def places(self) -> Terms:
        """Return the places of the free coefficients (p, 1)."""
        return np.array([self.names.index(name) for name in self.free]).reshape(-1, 1)

    def whole(self, values: Mapping[str, float]) -> Numbers:
        """Return every coefficient, as the kernels take them; what is not given is fixed."""
        known = {**FIXED, **self.held, **values}
        return np.array([known.get(name, 0.0) for name in self.names])

    def without(self, names: tuple[str, ...]) -> "Model":
        """Return the model with some of its free coefficients fixed."""
        return replace(self, free=tuple(name for name in self.free if name not in names))


def _term(name: str) -> tuple[int, int]:
    """Return place and row of the term of a coefficient."""
    axis, _, term = name.partition("_")
    if name in OF_ROLL:
        times = 1 if term == "p" else 2
        return AXES.index(axis) + times * len(AXES), TERM_ROWS["one" if axis == "K" else "1"]
    own = {"X_F": "X_F", "X_w": "X_w"}.get(name, "1" if term == "0" else term)
    return AXES.index(axis), TERM_ROWS[own]


def model_of(name: str, *, wind: bool) -> Model:
    """Return the model of that name, with wind where there was some."""
    surge, others = MODELS[name]
    factors = [f"X_{term}" for term in surge.split()]
    factors += [f"{axis}_{term}" for axis in "YN" for term in others.split()]
    factors += WIND if wind else ()
    curved = ("gamma", "l", "kappa", "c_w") if name == "mmg" else ()
    return Model(name, (*factors, *NONLINEAR), (*factors, *curved))


def heeling(model: Model) -> Model:
    """Return a model with roll."""
    rudder = "K_F" if "N_F" in model.names else "K_d"
    wind = ("K_w",) if "N_w" in model.names else ()
    own = ("K_0", "K_v", "K_r", rudder, *wind, *OF_ROLL)
    names, free = (
        (
            *(name for name in given if name not in NONLINEAR),
            *own,
            *(x for x in given if x in NONLINEAR),
        )
        for given in (model.names, model.free)
    )
    return replace(model, names=names, free=free, driven=HEELING)


def model_for(ship: ShipFile, name: str, *, wind: bool) -> Model:
    """Return the model with roll and further terms, where a ship's file gives them. ConfigError.

    Further terms are held. Where surge has speed in them the thrust is part of that, and held at
    nothing.
    """
    model = model_of(name, wind=wind)
    if ship.roll is not None:
        model = heeling(model)
    given = {key: ship.coefficients[key] for key in FURTHER if key in ship.coefficients}
    if name != "abkowitz" or not given:
        return model
    if ship.dimensions.advance_m is None:
        raise ConfigError(
            f"{ship.path.name}: [dimensions] lacks advance_m, which {min(given)} needs"
        )
    names = (*model.names[: -len(NONLINEAR)], *given, *NONLINEAR)
    held = OF_THRUST if any(key in given for key in OF_SPEED) else ()
    whole = replace(model, names=names, held={**dict.fromkeys(held, 0.0), **given})
    return whole.without(held)


def check_names(ship: ShipFile, model: Model) -> None:
    """Check that a ship's file has the model's coefficients and no others; ConfigError."""
    name, given = ship.path.name, ship.coefficients
    if missing := [key for key in model.free if key not in given]:
        raise ConfigError(f"{name}: [coefficients] lacks {', '.join(missing)}")
    known = (*model.names, *model.held, *WIND, "K_w")
    if strange := [key for key in given if key not in known]:
        hint = nearest(strange[0], (*known, *(FURTHER if model.name == "abkowitz" else ())))
        raise ConfigError(
            f"{name}: [coefficients] {strange[0]} is none of model {model.name}{hint}"
        )
