"""Ships whose coefficients are known, and their records."""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trainer.boat.ship.forces import ROW_COUNT, System, add_terms, set_terms
from trainer.boat.ship.models import ShipModel, model_of, with_roll
from trainer.config.ship.ship import Dimensions, RecordSettings, Roll, ShipFile
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_filter import sail_record
from trainer.identify.record.measurements import Record
from trainer.identify.ships.likelihood import TANKER_PRIOR, ShipProblem
from trainer.identify.ships.records import READING_CHANNELS, ROLL_CHANNELS

NOMOTO_SHIP = """schema = "nomoto/1"
name = "a ship"
length_m = 161
speed_kn = 15
K_per_s = -0.18
T1_s = 118
T2_s = 7.8
T3_s = 18.5
rudder_limit_deg = 35
rudder_rate_deg_s = 2.5
step_s = 0.5
"""

SHIP = ShipFile(
    path=Path("ship.toml"),
    name="tanker",
    dimensions=Dimensions(
        length_m=320.0,
        propeller_diameter_m=9.86,
        wake_fraction=0.4,
        thrust=(0.33, -0.30, -0.12),
        beam_m=58.0,
        draught_m=20.8,
        block_coefficient=0.81,
        rudder_area_m2=112.5,
        rudder_height_m=15.8,
    ),
    records=RecordSettings(),
    sensors=None,
    columns=(),
)
CONSTANTS = np.array(SHIP.constants)
NOISE = np.array([0.004, 0.003, 3e-5, 0.02, 0.02, 1e-4, 5e-4])

# a full tanker that keeps her course
COEFFICIENTS = {
    **{name: mean for name, (mean, _) in TANKER_PRIOR.items()},
    "X_0": -0.05,
    "Y_0": -0.002,
    "N_0": -0.01,
    "N_vvv": 1.0,
    "X_T": 37.0,
}

# the same ship with a small GM: she heels to 10 degrees in a zig-zag
ROLLING = replace(SHIP, name="top-heavy tanker", roll=Roll(gm_m=2.0, radius_m=21.0))
HEELED = COEFFICIENTS | {"K_0": 0.05, "K_v": 14.0, "K_r": -6.0, "K_F": 6.0, "K_phi": -1.1}
HEELED |= {"K_p": -0.14, "Y_phi": 0.02, "N_phi": -0.2}
ROLL_NOISE = np.array([*NOISE[:3], 2e-4, *NOISE[3:], 2e-4, 1e-3])

# of the record without random numbers, section 11
TERMS = ("0", "T", "v", "r", "d", "ur", "vvd", "Td", *("vvv", "vvr", "vrr", "rrr"), "F", "w", "ww")
SURGE = {"0": -0.05, "T": 37, "vv": -0.5, "vr": 1.2, "rr": 0.02, "dd": -0.1, "F": 0.08, "w": -0.001}
SWAY = (-0.001, 0, -0.4, -0.45, -0.11, -5, -2, -2, -8, -0.4, -0.5, 0.1, -0.18, -0.002, 0)
YAW = (-0.005, 0, -3.2, -1.2, 0.65, 20, 10, 60, 5, -12, 0.5, -0.2, 1, 0.001, 0.002)
RUDDER = {"gamma": 0.6, "l": -0.71, "kappa": 0.5, "c_w": 0.5, "gamma_a": -0.03}
SAMPLES = 200


def published(name: str) -> dict[str, float]:
    """Return the coefficients of section 11 for a model."""
    found = {f"X_{term}": float(value) for term, value in SURGE.items()}
    found |= {f"Y_{term}": float(x) for term, x in zip(TERMS, SWAY, strict=True)}
    found |= {f"N_{term}": float(x) for term, x in zip(TERMS, YAW, strict=True)}
    if name == "linear":
        found |= {"Y_v": -0.8, "N_v": -1.0, "N_r": -1.5}
    return found | (RUDDER if name == "mmg" else {})


def made_record(
    name: str, change: dict[str, float] | None = None
) -> tuple[ShipProblem, Numbers, Numbers]:
    """Return the record of section 11 with a problem, its parameters, and the ship's states."""
    values = published(name) | (change or {})
    model = model_of(name, wind=True)
    free = (*model.free, "gamma_a") if name == "mmg" else model.free
    model = ShipModel(name, model.names, free)
    p = len(model.free)
    nothing = np.zeros(p + 7), np.full(p + 7, math.inf)
    begin = np.array([8.0, 0.0, 0.0, 0.0])
    a = np.concatenate([[values[each] for each in model.free], np.log(NOISE), begin])
    table = np.column_stack([np.tile(begin, (SAMPLES, 1)), _inputs()])
    sailing = ShipProblem(model, CONSTANTS, (), *nothing, np.zeros(4))
    states = sailing.sail(a, record_of_rows("made", table))
    table[:, :4] = states + _errors()
    table[50:60, 1] = math.nan
    table[120, :4] = math.nan
    return replace(sailing, trials=(record_of_rows("made", table),)), a, states


def record_of_rows(source: str, rows: Numbers) -> Record:
    """Return a record every 2 s of u, v, r, heading, rudder to starboard, n, wind, p and phi."""
    inputs = ("rudder", "revolutions", "wind_ahead", "wind_starboard")
    names = (*READING_CHANNELS, *inputs, *ROLL_CHANNELS)
    columns: dict[str, Any] = dict(zip(names, rows.T.copy(), strict=False))
    columns["rudder"] = -columns["rudder"]
    t, places = np.arange(0.0, 2.0 * len(rows), 2.0), np.arange(len(rows))
    return Record(source=source, t=t, rows=places, names={}, between_readings="straight", **columns)


def _inputs() -> Numbers:
    """Return rudder, revolutions and wind of the record (n, 4)."""
    k = np.arange(SAMPLES)
    rudder = math.radians(15.0) * np.sin(2.0 * math.pi * k / 80.0)
    return np.column_stack([rudder, np.full(SAMPLES, 1.5), 3.0 + 0.01 * k, 2.0 - 0.02 * k])


def _errors() -> Numbers:
    """Return errors of readings without random numbers (n, 4)."""
    k, m = np.arange(SAMPLES)[:, None], np.arange(4)[None, :]
    places = (k * k * (31 + 2 * m) + 7 * k + 5 * m) % 1009
    return np.asarray(NOISE[3:] * math.sqrt(3.0) * (2.0 * places / 1009.0 - 1.0))


def sailed_zigzag(angle: float, seed: int, samples: int = 300) -> tuple[Record, Numbers]:
    """Return a zig-zag of the tanker under disturbances, read with errors, and its first state.

    A negative angle [deg] goes to port first.
    """
    stream = np.random.default_rng(seed)
    model = model_of("mmg", wind=False)
    whole, T, rate = model.whole(COEFFICIENTS), 2.0, math.radians(2.32)
    state, rudder, side = np.array([8.0, 0.0, 0.0, 0.0]), 0.0, math.copysign(1.0, angle)
    rows = []
    for _ in range(samples):
        rows.append([*state, rudder, 1.5, 0.0, 0.0])
        if side * state[3] > math.radians(abs(angle)):
            side = -side
        wanted = side * math.radians(abs(angle))
        then = rudder + float(np.clip(wanted - rudder, -rate * T, rate * T))
        state = _sailed(whole, model, state, (rudder, then))
        state[:3] += NOISE[:3] * math.sqrt(T) * stream.standard_normal(3)
        rudder = then
    table = np.array(rows)
    first = table[0, :4].copy()
    table[:, :4] += NOISE[3:] * stream.standard_normal((samples, 4))
    return record_of_rows(f"zigzag {angle:g}", table), first


def _sailed(whole: Numbers, model: ShipModel, state: Numbers, helm: tuple[float, float]) -> Numbers:
    """Return the state two seconds on, by four steps of Runge and Kutta."""
    work, out, h = np.empty((ROW_COUNT, 1)), np.empty((3, 1)), 0.5

    def rates(x: Numbers, part: float) -> Numbers:
        inputs = np.array([helm[0] + part * (helm[1] - helm[0]), 1.5, 0.0, 0.0])
        set_terms(work, CONSTANTS, x, inputs, whole[-5:])
        add_terms(work, model.terms, whole, CONSTANTS, out)
        return np.array([*out[:, 0], x[2]])

    for i in range(4):
        k1 = rates(state, i / 4.0)
        k2 = rates(state + 0.5 * h * k1, (i + 0.5) / 4.0)
        k3 = rates(state + 0.5 * h * k2, (i + 0.5) / 4.0)
        k4 = rates(state + h * k3, (i + 1.0) / 4.0)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return state


def rolled_zigzag(angle: float, seed: int, samples: int = 300) -> tuple[Record, Numbers]:
    """Return a zig-zag of the tanker of small GM as ``sailed_zigzag`` does, with roll."""
    stream, T, rate = np.random.default_rng(seed), 2.0, math.radians(2.32)
    model = with_roll(model_of("mmg", wind=False))
    whole, out, none = model.whole(HEELED), np.empty((2, 6)), np.empty((0, 1), np.int64)
    state, rudder, side = np.array([8.0, *[0.0] * 5]), 0.0, math.copysign(1.0, angle)
    table = np.zeros((samples + 1, 12))
    table[:, 5], table[:, 8], table[:, 9] = 1.5, T, 1.0
    for row in table[:-1]:
        row[:4], row[10:], row[4] = state[:4], state[4:], rudder
        if side * state[3] > math.radians(abs(angle)):
            side = -side
        wanted = side * math.radians(abs(angle))
        rudder += float(np.clip(wanted - rudder, -rate * T, rate * T))
        step = np.vstack([row, row])
        step[1, 4], step[:, 9] = rudder, 4.0
        values = np.concatenate([whole, ROLL_NOISE, state])
        system = System(np.array(ROLLING.constants), model.terms, values, none, model.driven)
        assert sail_record(system, step, out) == 2
        state = out[1].copy()
        state[[0, 1, 2, 4]] += ROLL_NOISE[:4] * math.sqrt(T) * stream.standard_normal(4)
    table = np.ascontiguousarray(table[:-1])
    first = np.array([*table[0, :4], *table[0, 10:]])
    table[:, [0, 1, 2, 3, 10, 11]] += ROLL_NOISE[4:] * stream.standard_normal((samples, 6))
    return record_of_rows(f"rolled {angle:g}", np.delete(table, [8, 9], axis=1)), first


def write_columns(columns: Mapping[str, Numbers], path: Path) -> Path:
    """Write columns as a CSV file, an empty field for each NaN; return its path."""
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    path.write_text("\n".join(lines).replace("nan", "") + "\n", encoding="utf-8")
    return path


def trainer_columns(trial: Record) -> dict[str, Numbers]:
    """Return a record's columns as the trainer writes them, of a ship that does not roll."""
    names = {"u": "speed", "v": "sway", "r": "yaw_rate", "psi": "heading"}
    names |= {"t": "t", "delta_r": "rudder", "n": "revolutions"}
    return {
        name: getattr(trial, names[name]) for name in ("t", "u", "v", "r", "psi", "delta_r", "n")
    }
