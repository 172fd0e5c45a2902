"""A fitted ship becomes a file that sails: a Nomoto ship, or a vessel file."""

import math
from dataclasses import replace

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.identify.derived import nomoto_of
from trainer.identify.fitting import Fitted
from trainer.identify.nomoto import SCHEMA, NomotoFile, nomoto_text_of
from trainer.identify.nonlinear import Bend
from trainer.identify.steering import averages, coefficients, limits, rewritten
from trainer.units import KNOT

RUDDER_LIMIT = 35.0  # [deg] of many ships, where no vessel file tells
RUDDER_RATE = 2.3  # [deg/s]
STEP = 0.5  # [s]


def nomoto_ship(fitted: Fitted) -> tuple[NomotoFile, dict[str, float]]:
    """Return the ship in a few numbers, and their standard deviations.

    ConfigError if sway and yaw swing together, or the model has no yaw.
    """
    model, ship = fitted.problem.plant.model, fitted.problem.plant.ship
    form = nomoto_of(model, fitted.values, ship)
    if form.T1.imag:
        raise ConfigError("a pair of complex roots has no T1 and T2: write the vessel file instead")
    if not form.K:
        raise ConfigError(f"model {model.name} tells nothing of yaw: no Nomoto ship from it")
    known = dict(zip(fitted.quantity_names, fitted.told.deviations, strict=True))
    rudder = (RUDDER_LIMIT, RUDDER_RATE)
    vessel = fitted.study.ship.vessel if fitted.study.ship else None
    if vessel:
        limit, rate = limits(load_vessel(vessel))
        rudder = math.degrees(limit), math.degrees(rate)
    neutral = 0.0
    if "delta_0" in model.names:
        neutral = float(fitted.values[model.place("delta_0")])
    has_sway = bool(form.K_v)
    file = NomotoFile(
        schema=SCHEMA,
        name=fitted.study.heading.name,
        length_m=ship.length,
        speed_kn=ship.speed / KNOT,
        K_per_s=form.K,
        T1_s=form.T1.real,
        T2_s=form.T2.real,
        T3_s=form.T3,
        K_v_m_s=form.K_v if has_sway else None,
        T3v_s=form.T3v if has_sway else None,
        neutral_deg=neutral or None,
        rudder_limit_deg=rudder[0],
        rudder_rate_deg_s=rudder[1],
        step_s=STEP,
    )
    names = ("K", "T1", "T2", "T3", *(("K_v", "T3v") if has_sway else ()))
    return file, {name: float(known[name]) for name in names if np.isfinite(known[name])}


def nomoto_text(fitted: Fitted, bend: Bend | None) -> str:
    """Return the text of the Nomoto file, with kappa where one was found."""
    ship, deviations = nomoto_ship(fitted)
    if bend is not None:
        ship = replace(ship, kappa_s2=bend.ship.kappa)
        deviations["kappa"] = bend.deviation
    source = f"model {fitted.problem.plant.model.name} fitted to {fitted.record.source}"
    return nomoto_text_of(ship, source.replace("\\", "/").replace('"', "'"), deviations)


def vessel_text(fitted: Fitted) -> str:
    """Return the text of the vessel file with the steering coefficients that were found.

    ConfigError unless Model 1 was fitted to a boat with a vessel file.
    """
    model, study = fitted.problem.plant.model, fitted.study
    vessel = study.ship.vessel if study.ship else None
    if model.name != "1" or vessel is None:
        raise ConfigError("--write-vessel needs model 1 and the vessel file it started from")
    file = load_vessel(vessel)
    found = dict(zip(model.names, map(float, fitted.values), strict=True))
    means = averages(fitted.record)
    values = coefficients(file, found, fitted.problem.plant.ship.speed, means)
    return rewritten(file.text, values, f"identified from {fitted.study.data.name}")
