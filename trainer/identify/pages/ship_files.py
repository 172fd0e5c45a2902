"""A fit written as a file that sails: of a Nomoto ship or a vessel.

``--write-nomoto`` and ``--write-vessel`` call it; ``manoeuvre`` and ``steering`` take both files.
A vessel file keeps all but its six linear steering coefficients, Y_v to N_dr.
"""

import math
import re
from dataclasses import replace
from typing import Any, Final

import numpy as np

from trainer.analysis.programs.characteristic import MeanMotions
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError, toml_value
from trainer.config.ship.nomoto import NOMOTO_SCHEMA, NomotoFile, nomoto_text_of
from trainer.identify.fitting.nonlinear import BendEstimate
from trainer.identify.judge.fitted import ModelFit
from trainer.identify.model.derived import nomoto_of
from trainer.identify.model.nomoto import limits
from trainer.identify.record.measurements import Record
from trainer.units import KNOT

USUAL_LIMIT_DEG: Final = 35.0  # [deg] of many ships' rudders, where no vessel file tells
USUAL_RATE_DEG_S: Final = 2.3  # [deg/s]
SHIP_STEP_S: Final = 0.5  # [s]
NUMBER_PATTERN: Final = r"[-+]?(?:\d[\d_]*)?\.?\d+(?:[eE][-+]?\d+)?"


def nomoto_ship(fitted: ModelFit) -> tuple[NomotoFile, dict[str, float]]:
    """Return the ship in a few numbers, and their standard deviations.

    ConfigError if sway and yaw swing together, or the model has no yaw.
    """
    model, ship = fitted.problem.plant.model, fitted.problem.plant.ship
    form = nomoto_of(model, fitted.values, ship)
    if form.T1.imag:
        raise ConfigError("a pair of complex roots has no T1 and T2: write the vessel file instead")
    if not form.K:
        raise ConfigError(f"model {model.name} tells nothing of yaw: no Nomoto ship from it")
    known = dict(zip(fitted.quantity_names, fitted.quantity_spread.deviations, strict=True))
    rudder = (USUAL_LIMIT_DEG, USUAL_RATE_DEG_S)
    vessel = fitted.study.ship.vessel if fitted.study.ship else None
    if vessel:
        limit, rate = limits(load_vessel(vessel))
        rudder = math.degrees(limit), math.degrees(rate)
    neutral = 0.0
    if "delta_0" in model.names:
        neutral = float(fitted.values[model.index("delta_0")])
    has_sway = bool(form.K_v)
    file = NomotoFile(
        schema=NOMOTO_SCHEMA,
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
        step_s=SHIP_STEP_S,
    )
    names = ("K", "T1", "T2", "T3", *(("K_v", "T3v") if has_sway else ()))
    return file, {name: float(known[name]) for name in names if np.isfinite(known[name])}


def nomoto_text(fitted: ModelFit, bend: BendEstimate | None) -> str:
    """Return the text of the Nomoto file, with kappa or H(r) where one was found."""
    ship, deviations = nomoto_ship(fitted)
    if bend is not None:
        bent_ship = bend.ship
        numbers: dict[str, Any] = {
            "K_per_s": bent_ship.K,
            "T1_s": bent_ship.T1,
            "T2_s": bent_ship.T2,
        }
        numbers |= {"T3_s": bent_ship.T3, "kappa_s2": None if bent_ship.H else bent_ship.kappa}
        numbers |= dict(zip(("H1_s", "H2_s2", "H3_s3"), bent_ship.H or (None,) * 3, strict=True))
        if "delta_0" not in fitted.problem.plant.model.names:
            numbers["neutral_deg"] = math.degrees(bent_ship.delta_0)
        ship = replace(ship, **numbers)
        deviations |= bend.deviations
    source = f"model {fitted.problem.plant.model.name} fitted to {fitted.record.source}"
    return nomoto_text_of(ship, source, deviations)


def vessel_text(fitted: ModelFit) -> str:
    """Return the text of the vessel file with the steering coefficients that were found.

    ConfigError unless Model 1 was fitted to a boat with a vessel file.
    """
    model, study = fitted.problem.plant.model, fitted.study
    vessel = study.ship.vessel if study.ship else None
    if model.name != "1" or vessel is None:
        raise ConfigError("--write-vessel needs model 1 and the vessel file it started from")
    file = load_vessel(vessel)
    parameters = dict(zip(model.names, map(float, fitted.values), strict=True))
    means = averages(fitted.record)
    values = coefficients(file, parameters, fitted.problem.plant.ship.speed, means)
    return rewrite_coefficients(file.text, values, f"identified from {fitted.study.data.name}")


def averages(record: Record) -> MeanMotions:
    """Return the mean |v| [m/s] and |r| [rad/s] for a record's quadratic terms.

    They are E|x|^3/E x^2, because the line a |x|_mean x is then nearest to a |x| x in the mean
    square.
    """
    sizes = []
    for values in (record.sway, record.yaw_rate):
        known = np.abs(values[~np.isnan(values)]) if values is not None else np.zeros(1)
        power = float(np.mean(known**2))
        sizes.append(float(np.mean(known**3)) / power if power > 0.0 else 0.0)
    return MeanMotions(v=sizes[0], r=sizes[1])


def coefficients(
    file: VesselFile, found: dict[str, float], speed: float, means: MeanMotions
) -> dict[str, float]:
    """Return the vessel file's coefficients [-] for Model 1's in prime units.

    The file keeps its own quadratic terms. So their part at the record's ``means`` is taken off the
    linear coefficients, else it would count twice.
    """
    c, hull = file.coefficients, file.hull
    mass = hull.mass / (0.5 * file.fluid.rho * hull.length**3)
    v, r = means.v / speed, means.r * hull.length / speed
    x_g = hull.cg[0] / hull.length
    return {
        "Y_v": found["Y_v"] - c["Y_vav"] * v - c["Y_var"] * r,
        "Y_r": found["Y_r"] + mass,
        "N_v": found["N_v"] - c["N_vav"] * v,
        "N_r": found["N_r"] + mass * x_g - c["N_avr"] * v - c["N_rar"] * r,
        "Y_dr": found["Y_delta"],
        "N_dr": -found["Y_delta"] * found["l_delta"],
    }


def rewrite_coefficients(text: str, values: dict[str, float], remark: str) -> str:
    """Return the text of a vessel file with these coefficients, and a remark on each.

    ConfigError if the file does not give one on a line of its own.
    """
    rows = text.split("\n")
    tables = [i for i, row in enumerate(rows) if row.lstrip().startswith("[")]
    inside = [
        i
        for first, end in zip(tables, [*tables[1:], len(rows)], strict=True)
        for i in range(first + 1, end)
        if rows[first].lstrip().startswith("[coefficients")
    ]
    for key, value in values.items():
        line = re.compile(rf"(\s*{re.escape(key)}\s*=\s*){NUMBER_PATTERN}.*")
        match = next(((i, one) for i in inside if (one := line.fullmatch(rows[i]))), None)
        if match is None:
            message = f"the vessel file has no line {key} = ...: add one, such as {key} = 0"
            raise ConfigError(message)
        rows[match[0]] = f"{match[1][1]}{toml_value(value, '.6g')}  # {remark}"
    return "\n".join(rows)
