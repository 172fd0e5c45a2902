"""How far each coefficient may be trusted, and draws of whole sets.

``boat_file`` writes the deviations, ``survey`` makes bands of draws, and ``trainer boat sweep``
draws whole boats. A draw varies the constants of the method first, by the covariance of their fit,
then each coefficient by the rest of its standard deviation. The constants come first because they
move coefficients together, such as N_v, N_r and Y_v: independent draws would make impossible boats.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.estimate.coefficients import (
    CoefficientValues,
    Hull,
    bare_masses,
    coefficients,
    hull_of,
)
from trainer.analysis.sweep.draws import fill_normals, stream_number, uniforms
from trainer.config.boat.hull import BOW_CONTROL, read_hull
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, Position, as_table
from trainer.core.kernel import Numbers
from trainer.core.terms import TERM_TABLE, THRUST_KEYS

TABLES_PATH: Final = Path(__file__).with_name("constants.toml")
ETA_DEVIATION: Final = 0.15  # of its parent, a coefficient of eta
LINEAR_TERMS: Final = ("Y_v", "N_v", "Y_r", "N_r", "Z_w", "M_w", "Z_q", "M_q")
OWN_SHARE: Final = 0.25  # of the deviation of those, beside the constants
TWIN_COEFFICIENTS: Final = {
    "N_vdot": "Y_rdot",
    "M_wdot": "Z_qdot",
    "Y_pdot": "K_vdot",
    "N_pdot": "K_rdot",
}
# fmt: off
FIXED_SIGN_COEFFICIENTS: Final = (  # damping, added mass and control effect never change their sign
    "X_udot", "Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot",
    "Y_v", "N_r", "Z_w", "M_q", "K_p", "K_pap", "Y_vav", "Z_waw", "N_rar", "M_qaq",
    "Y_dr", "N_dr", "Z_ds", "M_ds", "Z_db", "M_db",
)
# fmt: on
MIN_REMAINING_SHARE: Final = 0.1  # of the estimate is left of them
CONSTANT_NUDGE: Final = 1e-3  # of the logarithm of a constant
SMALL_CRAFT_LENGTH_M: Final = 5.0  # [m] below it openings count
TESTED_RANGES: Final = {"L/D": (5.0, 12.0), "breadth/height": (0.8, 1.25)}
AFT_STATION_LENGTHS: Final = 0.75  # [lengths] tail surfaces lie aft of it


@cache
def tables() -> Mapping[str, Any]:
    """Return the constants with their covariance, and the rules of the deviations."""
    return tomllib.loads(TABLES_PATH.read_text(encoding="utf-8"))


def fitted_constants() -> dict[str, float]:
    """Return the nine constants that are fitted [-]."""
    return dict(tables()["fitted"])


def range_warnings(hull: Hull) -> tuple[str, ...]:
    """Return in words where a hull is outside the range of the method."""
    s = hull.shape
    ratios = {
        "L/D": s.length / s.diameter,
        "breadth/height": float(s.breadth.max() / s.height.max()),
    }
    problems = [
        f"{name} is {ratios[name]:.3g}, the method is tested from {low:g} to {high:g}"
        for name, (low, high) in TESTED_RANGES.items()
        if not low <= ratios[name] <= high
    ]
    problems += [
        f"{panel.name} at {panel.station(0.25) / s.length:.2f} lengths, a tail is aft of "
        f"{AFT_STATION_LENGTHS:g}"
        for panel in hull.panels
        if panel.control not in ("none", BOW_CONTROL)
        and panel.station(0.25) < AFT_STATION_LENGTHS * s.length
    ]
    return tuple(dict.fromkeys(problems))


def deviations(hull: Hull, c: Mapping[str, float], mass: float) -> dict[str, float]:
    """Return the standard deviation [-] of each of the 131 coefficients; ``mass`` in kg."""
    bare = bare_masses(hull, fitted_constants()["added_mass"])
    scales = {  # what deviations are shares of [-]
        **{key: abs(value) for key, value in c.items()},
        "mass": 2.0 * mass / (hull.file.water.rho * hull.ell**3),
        "munk_y": bare["X_udot"] - bare["Y_vdot"],
        "munk_z": bare["X_udot"] - bare["Z_wdot"],
        "larger": max(abs(c["Y_vdot"]), abs(c["Z_wdot"])),
        "turning": max(abs(c["N_rdot"]), abs(c["M_qdot"])),
    }
    wide = 2.0 if range_warnings(hull) else 1.0
    sizes = {}
    for rule in tables()["deviation"]:
        for key in rule["keys"]:
            size = rule["share"] * scales[rule.get("of", key)]
            sizes[key] = wide * (size + rule.get("more", 0.0) * scales[rule.get("unit", "mass")])
    for term in TERM_TABLE:
        if term.key not in sizes:
            sizes[term.key] = wide * ETA_DEVIATION * scales[term.key.removesuffix("_eta")]
    return sizes


def relative_deviation(c: Mapping[str, float], mass: float, key: str) -> float:
    """Return the standard deviation [-] of a coefficient that no drawing gave.

    It is the estimate's share of the boat's own coefficients, and no more than the coefficient
    itself; ``mass`` is m'. What the estimate adds for a coefficient near zero is left out.
    """
    scales = {
        **{name: abs(value) for name, value in c.items()},
        "mass": mass,
        "munk_y": abs(c["X_udot"] - c["Y_vdot"]),
        "munk_z": abs(c["X_udot"] - c["Z_wdot"]),
    }
    for rule in tables()["deviation"]:
        if key in rule["keys"]:
            return float(min(rule["share"] * scales[rule.get("of", key)], scales[key]))
    return ETA_DEVIATION * scales[key]


@cache
def coefficient_origins() -> dict[str, str]:
    """Return what each coefficient is made of, in words."""
    origins = {key: rule["rests"] for rule in tables()["deviation"] for key in rule["keys"]}
    return {
        term.key: origins.get(term.key, "no formula; 15 % of its parent") for term in TERM_TABLE
    }


@dataclass(frozen=True)
class Estimate:
    """The coefficients of a hull, with the deviations from which sets are drawn."""

    hull: Hull
    mass: float  # [kg]
    constants: Mapping[str, float]  # [-] those fitted
    covariance: Numbers  # of their logarithms
    values: Mapping[str, float]  # [-] in use: estimated, or put in their place
    sd: Mapping[str, float]  # [-]

    @cached_property
    def estimated(self) -> CoefficientValues:
        """Return what the formulas give [-]."""
        return coefficients(self.hull, self.constants)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the names of the constants that a draw varies, those fitted first."""
        loose = (name for name in tables()["unfitted"] if name != "openings")
        return (*self.constants, *loose)

    @cached_property
    def root(self) -> Numbers:
        """Return the matrix from normal deviates to those of the constants' logarithms."""
        fit, whole = len(self.constants), np.zeros((len(self.names), len(self.names)))
        whole[:fit, :fit] = self.covariance
        for i, name in enumerate(self.names[fit:], start=fit):
            whole[i, i] = tables()["unfitted"][name] ** 2
        return root_of(whole)

    @cached_property
    def common_parts(self) -> Numbers:
        """Return what a deviate of each constant adds to coefficients (16, 131) as in estimated."""
        change = np.array(
            [list(self._changed(row).values()) for row in CONSTANT_NUDGE * np.eye(len(self.names))]
        )
        slopes = (change - np.array(list(self.estimated.values()))) / CONSTANT_NUDGE
        return np.asarray(self.root @ slopes)

    @cached_property
    def by_constants(self) -> CoefficientValues:
        """Return the part [-] of each coefficient's deviation that comes from the constants."""
        spread = np.sqrt(np.sum(self.common_parts**2, axis=0))
        return dict(zip(self.estimated, map(float, spread), strict=True))

    def _changed(self, logarithms: Numbers) -> CoefficientValues:
        """Return the coefficients with the logarithms of the constants changed."""
        factors = np.exp(logarithms)
        changed_constants = {
            name: self.constants.get(name, 1.0) * float(factor)
            for name, factor in zip(self.names, factors, strict=True)
        }
        return coefficients(self.hull, changed_constants)

    def draw(self, number: int) -> CoefficientValues:
        """Return the coefficients of one draw [-]; number 0 is the estimate itself."""
        if number == 0:
            return dict(self.values)
        normals = deviates(number, len(self.names) + len(TERM_TABLE))
        logarithms = self.root @ normals[: len(self.names)]
        i = self.names.index("resistance")
        if self.hull.ell < SMALL_CRAFT_LENGTH_M and logarithms[i] > 0.0:
            of = tables()["unfitted"]
            logarithms[i] *= of["openings"] / of["resistance"]
        changed, own_normals = self._changed(logarithms), normals[len(self.names) :]
        drawn = {
            term.key: self._drawn(term.key, changed[term.key], float(own_normals[i]))
            for i, term in enumerate(TERM_TABLE)
            if term.key not in THRUST_KEYS
        }
        drawn |= {twin: drawn[key] for twin, key in TWIN_COEFFICIENTS.items() if twin in drawn}
        return drawn | {key: changed[key] for key in THRUST_KEYS}

    def _drawn(self, key: str, changed: float, deviate: float) -> float:
        """Return one coefficient [-] by the constants drawn and a deviate of its own."""
        sd, common, value = self.sd[key], self.by_constants[key], self.values[key]
        shared = min(1.0, sd / common) if common > 0.0 else 0.0
        rest = OWN_SHARE * sd if key in LINEAR_TERMS else math.sqrt(max(sd**2 - common**2, 0.0))
        drawn = value + shared * (changed - self.estimated[key]) + rest * deviate
        return keep_sign(key, value, drawn)


def keep_sign(key: str, value: float, drawn: float) -> float:
    """Return a drawn coefficient; a tenth of its value where its sign may not change."""
    least = MIN_REMAINING_SHARE * value
    return least if key in FIXED_SIGN_COEFFICIENTS and drawn * value < least * value else drawn


@dataclass(frozen=True, eq=False)
class JointCoefficients:
    """Coefficients of a ship that was fitted, with their covariance."""

    values: Mapping[str, float]  # by name, as the covariance has them in its rows
    covariance: Numbers

    @cached_property
    def root(self) -> Numbers:
        """Return the matrix that turns normal deviates into deviations of the coefficients."""
        return root_of(self.covariance)

    def draw(self, number: int) -> CoefficientValues:
        """Return the coefficients of one draw; number 0 is the fit itself."""
        if number == 0:
            return dict(self.values)
        drawn = list(self.values.values()) + self.root @ deviates(number, len(self.values))
        return dict(zip(self.values, map(float, drawn), strict=True))

    def drawn_tables(self, table: Mapping[str, Any], number: int) -> dict[str, Any]:
        """Return the tables of a ship's file with a draw of its coefficients in them."""
        return {**table, "coefficients": {**table["coefficients"], **self.draw(number)}}


def root_of(covariance: Numbers) -> Numbers:
    """Return the symmetric root of a covariance; eigenvalues negative by rounding count as 0."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)


def deviates(number: int, count: int) -> Numbers:
    """Return the normal deviates [-] of a draw, the same on every machine."""
    normals = np.empty(count)
    fill_normals(uniforms(number, stream_number("estimate", ""), 0, count), normals)
    return normals


def estimate_hull(hull: Hull, mass: float) -> Estimate:
    """Return the estimate of a hull of a mass [kg] by the fitted constants."""
    values = coefficients(hull, fitted_constants())
    covariance = np.array(tables()["covariance"]["rows"])
    sd = deviations(hull, values, mass)
    return Estimate(hull, mass, fitted_constants(), covariance, values, sd)


def filed_estimate(file: VesselFile, table: Mapping[str, Any]) -> Estimate:
    """Return the estimate that a vessel file has, with the file's own coefficients.

    ``table`` holds its tables. ConfigError if it has none, or one that is damaged.
    """
    position = Position(file.path.name, "estimate")
    if "estimate" not in table:
        problem = "lacks the table [estimate]: it is no boat of trainer boat estimate"
        raise ConfigError(f"{file.path.name}: {problem}")
    estimate_table = as_table(table["estimate"], position)
    needed = ("constants", "covariance", "sd", "hull")
    if lacking := [key for key in needed if key not in estimate_table]:
        raise ConfigError(position.problem(f"lacks {', '.join(lacking)}"))
    hull = hull_of(read_hull(estimate_table["hull"], file.path))
    names = tuple(fitted_constants())
    constants = _numbers(estimate_table["constants"], names, position.inside("constants"))
    sd = _numbers(
        estimate_table["sd"], tuple(term.key for term in TERM_TABLE), position.inside("sd")
    )
    rows = _rows(estimate_table["covariance"], len(names), position)
    made = coefficients(hull, constants)
    values = made | dict(file.coefficients)
    return Estimate(hull, file.hull.mass, constants, rows, values, sd)


def filed_joint(table: Mapping[str, Any], position: Position) -> JointCoefficients:
    """Return the fitted coefficients of a ship's file, with their covariance.

    ``table`` holds its tables. ConfigError if it has no covariance, or one that is damaged.
    """
    if "covariance" not in table:
        raise ConfigError(position.problem("lacks the table [covariance]: no fit has written it"))
    rows = as_table(table["covariance"], position.inside("covariance"))
    given_values = as_table(table.get("coefficients", {}), position.inside("coefficients"))
    for name in rows:
        value = given_values.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            problem = "must be a number: [covariance] has a row of it"
            raise ConfigError(position.inside("coefficients").wrong(name, value, problem))
    values = {name: float(given_values[name]) for name in rows}
    return JointCoefficients(values, _rows(list(rows.values()), len(rows), position))


def filed_fit(file: VesselFile, table: Mapping[str, Any]) -> JointCoefficients:
    """Return the coefficients of a boat that was fitted to its trials, with their covariance.

    ``table`` holds the tables of its file. Thrust is a1, b1, c1 of the ahead row, and z_b [m] the
    height of buoyancy. ConfigError if the covariance is damaged.
    """
    position, first = Position(file.path.name, "covariance"), file.thrust.ahead[0]
    known = {**file.coefficients, "a1": first.a, "b1": first.b, "c1": first.c}
    known["z_b"] = file.hull.cb[2]
    rows = as_table(table["covariance"], position)
    for name in rows:
        if name not in known:
            raise ConfigError(position.problem(f"{name}: is no coefficient of this boat"))
    covariance = _rows(list(rows.values()), len(rows), position)
    return JointCoefficients({name: known[name] for name in rows}, covariance)


def drawn_fit(known: JointCoefficients, table: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return the tables of a fitted boat with a draw of its coefficients in them.

    ``table`` has its coefficients flat. Damping, added mass and controls keep their sign.
    """
    pairs = known.draw(number).items()
    drawn = {key: keep_sign(key, known.values[key], value) for key, value in pairs}
    thrust, vessel = dict(table["propulsion"]), dict(table["vessel"])
    ahead = [row for row in thrust["sets"] if row.get("going") != "astern"]
    first = max(ahead, key=lambda row: float(row["eta_min"]))
    changed = {name: drawn.get(f"{name}1", first[name]) for name in "abc"}
    thrust["sets"] = [{**row, **changed} if row is first else row for row in thrust["sets"]]
    vessel["cb"] = [*vessel["cb"][:2], drawn.get("z_b", vessel["cb"][2])]
    coefficients = {key: drawn.get(key, value) for key, value in table["coefficients"].items()}
    return {**table, "coefficients": coefficients, "propulsion": thrust, "vessel": vessel}


def _numbers(table: object, names: tuple[str, ...], position: Position) -> dict[str, float]:
    """Return numbers by name; ConfigError if one is lacking, none, or negative."""
    given_values = as_table(table, position)
    for name in names:
        value = given_values.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0.0:
            raise ConfigError(position.wrong(name, value, "must be a number, 0 or more"))
    return {name: float(given_values[name]) for name in names}


def _rows(rows: object, count: int, position: Position) -> Numbers:
    """Return the covariance; ConfigError if it is no symmetric matrix of that size."""
    try:
        matrix = np.array(rows, float)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape != (count, count) or not np.allclose(matrix, matrix.T, rtol=1e-5, atol=0.0):
        problem = f"must be {count} rows of {count} numbers, symmetric"
        raise ConfigError(position.problem(f"covariance: {problem}"))
    return matrix


def drawn_tables(made: Estimate, table: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return the tables of a vessel with a draw of its coefficients in them."""
    drawn = made.draw(number)
    coefficient_values = {key: value for key, value in drawn.items() if key not in THRUST_KEYS}
    rows = []
    for row in table["propulsion"]["sets"]:  # in the ratio of the draw to the estimate
        keys = {name: f"{name}{'1' if row['eta_min'] >= 0.0 else '3'}" for name in "abc"}
        scaled = {
            name: row[name] * (drawn[key] / made.estimated[key])
            for name, key in keys.items()
            if made.estimated[key] != 0.0
        }
        rows.append({**row, **scaled})
    propulsion = {**table["propulsion"], "sets": rows}
    return {**table, "coefficients": coefficient_values, "propulsion": propulsion}
