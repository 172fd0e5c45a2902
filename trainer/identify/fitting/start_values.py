"""Where an estimate starts: the parameters of a model before its record is fitted.

``study_problem`` asks. Model 1's ship comes from a vessel file or the study, that of the other
models from a regression on the record. Errors of readings start as the scatter of neighbouring
samples, disturbances as those that would make a tenth of the motion.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.model.models import OUTPUT_UNITS, Plant
from trainer.identify.model.nomoto import rate_coefficients
from trainer.identify.record.measurements import Record
from trainer.identify.record.study_records import ParameterRow

DISTURBANCE_SHARE: Final = 0.1  # [-] of the yaw rate (sway with Model 2) that disturbances make
MIN_ERRORS: Final = {"sway": 1e-3, "yaw_rate": 1e-3, "heading": 1e-3}  # errors [kn], [deg/s], [deg]
ACCELERATION_NAMES: Final = ("m11", "m12", "m21", "m22")
DERIVATIVE_NAMES: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta")
FREE_NAMES: Final[Mapping[str, tuple[str, ...]]] = {  # beside errors and the initial state
    "1": (*DERIVATIVE_NAMES, "Y_0", "N_0", "R1_Y", "R1_N"),
    "2": ("a1", "a2", "c1", "c2", "f2", "R1_1", "R1_2"),
    "3": ("a1", "a2", "b1", "b2", "f1", "R1_1", "R1_2"),
    "nomoto1": ("K", "T", "delta_0", "R1_r"),
    "nomoto2": ("a1", "a2", "b1", "b2", "delta_0", "R1_1", "R1_2"),
}
TURNING_ERRORS: Final = {"yaw_rate": "R2_r", "heading": "R2_psi"}
ERROR_NAMES: Final[Mapping[str, Mapping[str, str]]] = {  # of what is read
    "1": {"sway": "R2_v1", "bow_sway": "R2_v1", "stern_sway": "R2_v2", **TURNING_ERRORS},
    "2": {"sway": "R2_v"},
    **dict.fromkeys(("3", "nomoto1", "nomoto2"), TURNING_ERRORS),
}
INITIAL_STATE_NAMES: Final[
    Mapping[str, tuple[tuple[str, str], ...]]
] = {  # initial state: what reads it
    "1": (("x1_0", "sway"), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
    "2": (("x1_0", "sway"), ("x2_0", "")),
    "3": (("x1_0", ""), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
    "nomoto1": (("x1_0", "yaw_rate"), ("x2_0", "heading")),
    "nomoto2": (("x1_0", ""), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
}
DISTURBANCE_NAMES: Final = ("R1_Y", "R1_N", "R1_1", "R1_2", "R1_r")


def free_names(plant: Plant, rows: Sequence[ParameterRow]) -> tuple[str, ...]:
    """Return the parameters to estimate: the model's usual ones, as ``rows`` have it otherwise.

    The initial heading is held if no heading is read, because no other reading depends on it.
    """
    model = plant.model
    names = list(FREE_NAMES[model.name])
    names += dict.fromkeys(ERROR_NAMES[model.name][output] for output in plant.outputs)
    heading = "heading" in plant.outputs
    names += [
        name for name, channel in INITIAL_STATE_NAMES[model.name] if channel != "heading" or heading
    ]
    chosen = set(model.indices(names))
    for word, change in (("yes", chosen.update), ("no", chosen.difference_update)):
        change(model.indices(row.name for row in rows if row.free == word))
    return tuple(name for index, name in enumerate(model.names) if index in chosen)


def start_values(
    plant: Plant, record: Record, ship: Mapping[str, float], rows: Sequence[ParameterRow]
) -> Numbers:
    """Return all parameters (n,) to start from; ``ship`` has those known of the ship.

    ConfigError that names the parameters of Model 1 which neither ``ship`` nor ``rows`` give.
    """
    model = plant.model
    known_values = dict(ship) if model.name == "1" else {}
    stated_starts = {row.name: row.start for row in rows if row.start is not None}
    shown = _regress(plant, record) | _read(plant, record)
    values = model.vector(
        **shown | {name: stated_starts[name] for name in model.given if name in stated_starts}
    )
    for name in stated_starts.keys() - set(model.given):
        known_values[model.names[model.index(name)]] = stated_starts[name]
    for name, value in known_values.items():
        values[model.index(name)] = value
    if model.name == "1":
        lacking = [
            name for name in (*ACCELERATION_NAMES, *DERIVATIVE_NAMES) if name not in known_values
        ]
        if lacking:
            raise ConfigError(
                f"model 1 lacks a start for {', '.join(lacking)}: give a vessel, or "
                "[[parameters]]; m11 to m22 cannot be estimated, the others start from a similar "
                "ship"
            )
    _disturb(plant, record, values, known_values)
    return values


def _read(plant: Plant, record: Record) -> dict[str, float]:
    """Return initial state and variances of errors as the record shows them."""
    kind = plant.model.name
    starts = {}
    for output in plant.outputs:
        values = record.column(output) * OUTPUT_UNITS[output][1]
        known = values[~np.isnan(values)]
        least = MIN_ERRORS.get(output, MIN_ERRORS["sway"])
        rough = np.diff(known, 3) / math.sqrt(20.0)  # white noise of unit variance has 20
        starts[ERROR_NAMES[kind][output]] = max(float(np.var(rough)), least**2)
    for name, channel in INITIAL_STATE_NAMES[kind]:
        if channel and channel in record.channels:
            values = record.column(channel) * OUTPUT_UNITS[channel][1]
            starts[name] = float(values[~np.isnan(values)][0])
    return starts


def _regress(plant: Plant, record: Record) -> dict[str, float]:
    """Return the ship of yaw or sway alone by regression on the record; () for Model 1."""
    kind = plant.model.name
    if kind == "1":
        return {}
    k = plant.ship.speed / plant.ship.length
    gain, T = first_order(record, "sway" if kind == "2" else "yaw_rate")
    T2, T3 = T / 8.0, T / 4.0  # an estimate from many ships: a start need not be near
    T1 = T + T3 - T2
    if kind == "nomoto1":
        return {"K": gain, "T": T}
    if kind == "nomoto2":
        return {"K": gain, "T1": T1, "T2": T2, "T3": T3}
    a1, a2, b1, b2 = rate_coefficients(gain, T1, T2, T3)
    values = {"a1": a1 / k, "a2": a2 / k**2}
    if kind == "3":
        return values | {"b1": b1 / k**2, "b2": b2 / k**3}
    V = plant.ship.speed
    return values | {"c1": b1 / (k * V), "c2": b2 / (k**2 * V)}


def first_order(record: Record, channel: str) -> tuple[float, float]:
    """Return gain and time constant [s] of rudder to a channel by least squares, SI.

    A yaw rate that was not read is derived from the heading.
    """
    values = record.column("turning" if channel == "yaw_rate" else channel)
    rudder, step = record.column("rudder"), record.interval
    usual = np.abs(np.diff(record.t) - step) < 0.01 * step
    good = usual & ~np.isnan(values[1:]) & ~np.isnan(values[:-1])
    if np.count_nonzero(good) < 4:
        raise ConfigError(f"{record.source}: {channel} has too few neighbouring values to start")
    regressors = np.column_stack([values[:-1], rudder[:-1], np.ones(len(rudder) - 1)])[good]
    p, b, _ = np.linalg.lstsq(regressors, values[1:][good], rcond=None)[0]
    # noise may put the pole outside 0 to 1, where no ship has one: a start need not be exact
    p = min(max(float(p), 0.2), 0.99)
    return float(b) / (1.0 - p), -step / math.log(p)


def _disturb(plant: Plant, record: Record, values: Numbers, known: Mapping[str, float]) -> None:
    """Write the densities of disturbance that make a tenth of the motion, unless given."""
    model = plant.model
    names = [name for name in DISTURBANCE_NAMES if name in model.names and name not in known]
    if not names:
        return
    for name in names:
        values[model.index(name)] = 1.0
    noise = plant.blocks(values[None]).noise[0]
    index = 0 if model.name in ("nomoto1", "2") else 1
    seen = record.sway if model.name == "2" else record.yaw_rate
    seen = record.column("turning")[:-1] if seen is None else seen
    motion = float(np.nanstd(seen)) or 1e-6  # the usual size of it, SI
    density = (
        (DISTURBANCE_SHARE * motion) ** 2
        / max(noise[index, index], 1e-300)
        / (5.0 * record.interval)
    )
    for name in names:
        values[model.index(name)] = density
