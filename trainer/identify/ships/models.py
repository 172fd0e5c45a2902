"""Four models of ships that are not linear: coefficients, and what books say.

A coefficient is named by its equation and its term: ``N_vvr`` is the factor of v'^2 r' in the yaw
equation, an acceleration in prime units (over U^2/L, in yaw over U^2/L^2). ``mmg`` has the rudder
in the slipstream; ``abkowitz``, ``mavmm`` and ``linear`` have the rudder's angle. A ship whose
file has ``[roll]`` has an equation more in any of them, K; K_phi and K_p are in units of the
stiffness g GM/k^2 and of its root.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, nearest
from trainer.core.kernel import Numbers
from trainer.identify.kernels.ship_forces import HEELING, LEVEL, TERM_ROWS, Driven, Terms
from trainer.identify.ships.ship_file import Dimensions, ShipFile

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

Prior = Mapping[str, tuple[float, float]]  # mean and standard deviation before the strength

# Full tankers, L/B 5.5, C_B 0.81 (model-tests of KVLCC2): the default where a ship file has no form
TANKER: Final[Prior] = {
    "X_T": (38.0, 2.0),
    "X_F": (0.09, 0.05),
    "X_vv": (0.0, 3.0),
    "X_vr": (1.6, 1.0),
    "X_rr": (0.0, 0.3),
    "X_w": (-0.001, 0.002),
    "Y_0": (0.0, 0.04),
    "Y_v": (-0.6, 0.3),
    "Y_r": (-0.43, 0.15),
    "Y_vvv": (-3.0, 3.0),
    "Y_vvr": (-0.4, 1.0),
    "Y_vrr": (-0.8, 1.0),
    "Y_rrr": (0.0, 0.5),
    "Y_F": (-0.2, 0.1),
    "Y_w": (-0.002, 0.003),
    "N_0": (0.0, 0.04),
    "N_v": (-4.4, 1.5),
    "N_r": (-1.8, 0.8),
    "N_vvv": (0.0, 3.0),
    "N_vvr": (-4.6, 4.0),
    "N_vrr": (0.8, 2.0),
    "N_rrr": (-0.44, 0.6),
    "N_F": (1.2, 0.4),
    "N_w": (0.0, 0.004),
    "N_ww": (0.0, 0.01),
    "gamma": (0.5, 0.15),
    "l": (-0.71, 0.02),
    "kappa": (0.5, 0.02),
    "c_w": (0.4, 0.2),
}
# Of the order of a container ship of small GM (Son and Nomoto 1981), from memory: as wide as known
HEEL: Final[Prior] = {
    "K_0": (0.0, 1.0),
    "K_v": (8.0, 16.0),
    "K_r": (-2.0, 8.0),
    "K_F": (3.0, 6.0),
    "K_w": (0.0, 0.02),
    "K_phi": (-1.0, 0.4),
    "K_p": (-0.1, 0.2),
    "Y_phi": (0.0, 0.1),
    "N_phi": (-0.2, 0.5),
}
HULL: Final = tuple(f"{axis}_{term}" for axis in "YN" for term in ("v", "r"))
SHARE: Final = 0.45  # [-] of a mean by formula that is its standard deviation
GYRATION: Final = 0.25  # [L] radius of a ship
THRUST_LEFT: Final = 0.78  # [-] 1-t, of a full ship
SURGE_WATER: Final = 0.075  # [-] of the mass that moves ahead with it
HULL_RUDDER: Final = 0.31, 0.46  # a_H and -x_H/L, of a full ship
RUDDER_ARM: Final = 0.5  # [L]


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


def prior_of(model: Model, ship: ShipFile) -> tuple[Prior, str]:
    """Return what books say of the free coefficients, and which book says it.

    A model without cubes has no book: its slopes are those of the range it was fitted in.
    """
    form = kijima(ship.dimensions)
    whole = {**TANKER, **HEEL, **form}
    if model.name in ("linear", "mavmm"):
        whole = {name: one for name, one in whole.items() if name not in HULL}
    known = {name: whole[name] for name in model.free if name in whole}
    source = "formulas of Kijima and others 1990, by the ship's form" if form else "full tankers"
    return known, source + (", in roll a container ship" if "K_v" in known else "")


def kijima(hull: Dimensions) -> Prior:
    """Return the coefficients that length, beam, draught and block say; empty without these.

    Kijima, Katsuno, Nakiri and Furukawa 1990 (J Soc Nav Arch Japan 168), even keel, over 1/2 rho L
    d U^2; N_vrr as published there, with C_B d/B. Masses: 2 C_B B/L, the water's pi d/L in sway (a
    plate of the draught) and a twelfth of it in yaw: estimates, which only set a weak prior.
    """
    B, d, C_B = hull.beam_m, hull.draught_m, hull.block_coefficient
    if B is None or d is None or C_B is None:
        return {}
    L = hull.length_m
    k, a, e = 2.0 * d / L, C_B * B / L, d * (1.0 - C_B) / B
    own, water = 2.0 * a, math.pi * d / L
    sway = own + water
    yaw = own * GYRATION**2 + water / 12.0
    found = {
        "X_T": THRUST_LEFT / (own * d / L * (1.0 + SURGE_WATER)),
        "Y_v": -(0.5 * math.pi * k + 1.4 * a) / sway,
        "Y_r": -1.5 * a / sway,
        "Y_vrr": -5.95 * e / sway,
        "Y_vvr": (1.5 * d * C_B / B - 0.65) / sway,
        "N_v": -k / yaw,
        "N_r": (-0.54 * k + k * k) / yaw,
        "N_rrr": (0.5 * a - 0.09) / yaw,
        "N_vrr": (0.5 * d * C_B / B - 0.05) / yaw,
        "N_vvr": -(57.5 * a * a - 18.4 * a + 1.6) / yaw,
    }
    found |= _rudder(hull, sway * L * d, yaw * L * d)
    least = {name: TANKER[name][1] for name in ("Y_vvr", "Y_vrr", "N_rrr", "N_vrr", "N_vvr")}
    spread = {name: max(SHARE * abs(mean), least.get(name, 0.0)) for name, mean in found.items()}
    spread["X_T"] = 0.1 * found["X_T"]
    return {name: (mean, spread[name]) for name, mean in found.items()}


def _rudder(hull: Dimensions, sway: float, yaw: float) -> dict[str, float]:
    """Return the gains of a rudder of known area and height, by Fujii's slope of lift."""
    if hull.rudder_area_m2 is None or hull.rudder_height_m is None:
        return {}
    ratio = hull.rudder_height_m**2 / hull.rudder_area_m2
    lift = hull.rudder_area_m2 * 6.13 * ratio / (ratio + 2.25)
    a_H, x_H = HULL_RUDDER
    return {"Y_F": -(1.0 + a_H) * lift / sway, "N_F": (RUDDER_ARM + a_H * x_H) * lift / yaw}
