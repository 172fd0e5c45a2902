"""From the parameters of a fitted model to the ship's gains, time constants and stability.

Parameters are what a fit estimates; a navigator knows a ship by K, T1, T2, T3 and its lever arms.
The pages show these, and ``judge/uncertainty`` carries the standard deviations over. Model
document, sections 3.3 to 3.6.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.model.models import Model, Plant, Ship
from trainer.identify.model.nomoto import (
    Nomoto,
    Transfer,
    levers,
    nomoto,
    solve_motion,
    time_constants,
    transfer,
)

QUANTITY_UNITS: Final = {  # and their units
    "K": "1/s",
    "T1": "s",
    "T2": "s",
    "T_imag": "s",  # of T1 and, with the other sign, T2: a complex pair
    "T3": "s",
    "K_v": "m/s",
    "T3v": "s",
    "T": "s",  # of the first-order model
    "T1 + T2": "s",  # known better than either where they are near each other
    "T1 T2": "s^2",
    "1/T1": "1/s",  # above zero: the ship keeps a straight course
    "1/K": "s",
    # of Model 1: lever arms of sway, yaw and rudder, and the margin of stability, above zero
    "l_v": "m",
    "l_r": "m",
    "N_delta/Y_delta": "m",
    "l_r - l_v": "m",
}
DERIVATIVE_NAMES: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "N_delta")


def nomoto_of(model: Model, values: Numbers, ship: Ship) -> Nomoto:
    """Return gains and time constants [SI] of a model's parameters (n,), wind eliminated (3.3, 5).

    Numbers that a model does not have are zero: those of sway with Models 3 and Nomoto's, those of
    yaw with Model 2. ConfigError for a user's own system.
    """
    if model.name not in _NOMOTO_BY_MODEL:
        raise ConfigError(f"model {model.name} is no ship with K and T")
    return _NOMOTO_BY_MODEL[model.name](_named(model, values), ship)


def _named(model: Model, values: Numbers) -> dict[str, float]:
    return dict(zip(model.names, map(float, values), strict=True))


def _model_1(p: dict[str, float], ship: Ship) -> Nomoto:
    L, V = ship.length, ship.speed
    E = np.array([[p["m11"], L * p["m12"]], [p["m21"], L * p["m22"]]]) * L / V**2
    return nomoto(transfer(*solve_motion(E, *_forces(p, ship))))


def _forces(p: dict[str, float], ship: Ship) -> tuple[Numbers, Numbers]:
    """Return Model 1's forces by sway and yaw (2, 2), and by rudder (2,)."""
    L, V = ship.length, ship.speed
    F = np.array([[p["Y_v"] / V, L / V * p["Y_r"]], [p["N_v"] / V, L / V * p["N_r"]]])
    return F, p["Y_delta"] * np.array([1.0, -p["l_delta"]])


def arms_of(model: Model, values: Numbers, ship: Ship) -> Numbers:
    """Return lever arms and stability margin [m] of Model 1, zero of the others (3.4)."""
    if model.name != "1":
        return np.zeros(4)
    return ship.length * np.array(levers(*_forces(_named(model, values), ship)))


def _model_2(p: dict[str, float], ship: Ship) -> Nomoto:
    k, V = ship.speed / ship.length, ship.speed
    a1, a2 = k * p["a1"], k * k * p["a2"]
    c1, c2 = V * k * p["c1"], V * k * k * p["c2"]
    constants = nomoto(Transfer(a1, a2, 0.0, 0.0, 0.0, c1, c2, 0.0))
    return Nomoto(0.0, constants.T1, constants.T2, 0.0, constants.K_v, constants.T3v)


def _model_3(p: dict[str, float], ship: Ship) -> Nomoto:
    k = ship.speed / ship.length
    if p["b2"] == 0.0:  # first order, section 5: the wind is a2
        return _first(k * p["b1"] / p["a1"], 1.0 / (k * p["a1"]))
    a1, a2 = k * p["a1"], k * k * p["a2"]
    T1, T2 = time_constants(a1, a2)
    return Nomoto(k * p["b2"] / p["a2"], T1, T2, p["b1"] / (k * p["b2"]), 0.0, 0.0)


def _first(K: float, T: float) -> Nomoto:
    return Nomoto(K, complex(T), 0j, 0.0, 0.0, 0.0)


def _nomoto_2(p: dict[str, float], ship: Ship) -> Nomoto:
    del ship
    constants = nomoto(Transfer(p["a1"], p["a2"], 0.0, p["b1"], p["b2"], 0.0, 0.0, 0.0))
    return replace(constants, K_v=0.0, T3v=0.0)


_NOMOTO_BY_MODEL: Final[Mapping[str, Callable[[dict[str, float], Ship], Nomoto]]] = {
    "1": _model_1,
    "2": _model_2,
    "3": _model_3,
    "nomoto1": lambda p, _: _first(p["K"], p["T"]),
    "nomoto2": _nomoto_2,
}


def derivatives(model: Model, values: Numbers) -> Numbers:
    """Return the six derivatives in the model's own system. () but for Model 1."""
    if model.name != "1":
        return np.empty(0)
    p = _named(model, values)
    own_derivatives = [p[name] for name in ("Y_v", "Y_r", "N_v", "N_r", "Y_delta")]
    return np.array([*own_derivatives, -p["Y_delta"] * p["l_delta"]])


def quantities(plant: Plant, values: Numbers) -> Numbers:
    """Return derivatives, if the model has such, and the numbers of QUANTITY_UNITS [SI].

    For a user's own system they are those of System.tell.
    """
    model = plant.model
    if model.system is not None:
        return np.asarray(model.system.tell(plant, values))
    ship_like = nomoto_of(model, values, plant.ship)
    T1, T2 = ship_like.T1, ship_like.T2
    numbers = [
        ship_like.K,
        T1.real,
        T2.real,
        T1.imag,
        ship_like.T3,
        ship_like.K_v,
        ship_like.T3v,
        ship_like.first_order,
        (T1 + T2).real if T2 else 0.0,
        (T1 * T2).real,
        (1.0 / T1).real if T1 else math.inf,
        1.0 / ship_like.K if ship_like.K else 0.0,
        *arms_of(model, values, plant.ship),
    ]
    return np.concatenate([derivatives(model, values), numbers])


def quantity_units(model: Model) -> dict[str, str]:
    """Return the names of what ``quantities`` returns, and units."""
    if model.system is not None:
        return dict(model.system.quantities)
    derivatives_of = DERIVATIVE_NAMES if model.name == "1" else ()
    return dict.fromkeys(derivatives_of, "-") | QUANTITY_UNITS
