"""Fuzzing of what comes as files: vessels, seas, exercises, studies, tables, JSON lines."""

import functools
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final

import numpy as np

from fuzz.fuzz import (
    TABLE,
    Target,
    only,
    pieces,
    shipped_seeds,
    shipped_texts,
    text_of,
    write_file,
)
from fuzz.lines import GRAMMAR
from trainer.analysis.estimate.boat_file import boat_tables, boat_text, estimate_of
from trainer.analysis.estimate.boat_file import open_hull as load_drawing
from trainer.analysis.guide.contents import load_earlier
from trainer.analysis.guide.trials import load_published
from trainer.analysis.programs.evaluate import evaluate_states
from trainer.boat.assemble import Method, Records, fit_out
from trainer.config.boat.casualties import parse_casualties
from trainer.config.boat.vessel import load_vessel, parse_vessel
from trainer.config.exercise.check_case import parse_case
from trainer.config.exercise.derived import compile_condition
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError, Position, read_text
from trainer.config.ship.derivatives import load_derivatives
from trainer.config.ship.nomoto import load_nomoto
from trainer.config.ship.series import load_series
from trainer.config.ship.ship import parse_ship, ship_text
from trainer.config.tables import read_table
from trainer.config.world.sea import parse_sea
from trainer.config.world.soundings import read_ascii
from trainer.core.kernel import Record
from trainer.identify.judge.fitted import resume_search
from trainer.identify.model.system_files import load_system
from trainer.identify.pages.decca import load_decca, solve_track
from trainer.identify.record.columns import CHANNEL_WORDS, guess_columns
from trainer.identify.record.sources import Column, load_record
from trainer.identify.record.study import load_study
from trainer.identify.ships.vehicle import IdentifiedShip

CONDITIONS: Final = (
    "depth > 100",
    "speed < 4 kn",
    "pitch >= -1.5e1 deg",
    "flood_aft > 20 t",
    "bank_main<= 9 mpa",
)
STUDY: Final = b"""schema = "identify/1"
name = "A zig-zag"
data = "proof.csv"
from_s = 1.0

[ship]
length_m = 100.0

[model]
name = "nomoto-1"

[[columns]]
channel = "heading"
column = "psi"
unit = "deg"
missing = [511, -9999.0]

[[parameters]]
name = "K"
value = 0.1
"""
NOMOTO: Final = b"""schema = "nomoto/1"
name = "A ship"
speed_m_s = 8.0
K_1_s = 0.05
T_s = 20.0
rudder_limit_deg = 35
rudder_rate_deg_s = 3
step_s = 0.5
"""
DERIVATIVES: Final = b"""schema = "derivatives/1"
name = "A ship"
length_m = 329
speed_kn = 15.9
m11 = 1.7
m22 = 0.105
Y_v = -1.59
Y_r = -0.616
N_v = -0.183
N_r = -0.125
Y_delta = 0.199
N_delta = -0.065
"""
SYSTEM: Final = b"""schema = "system/1"
name = "A swing"
inputs = ["fin"]
outputs = ["roll"]
A = [[0, 1], ["-w**2", "-2*z*(w + 0)"]]
B = [[0], ["exp(w)/3"]]
C = [[1, 0]]
R2 = [["s"]]
x0 = [0, "sqrt(s)"]

[[parameters]]
name = "w"
start = 0.5

[[parameters]]
name = "z"
start = 0.1
free = false

[[parameters]]
name = "s"
start = 1e-2
"""
SHIP: Final = b"""schema = "ship/1"
name = "A tanker"
[dimensions]
length_m = 320.0
propeller_diameter_m = 9.86
wake_fraction = 0.4
thrust = [0.33, -0.30, -0.12]
[records]
positive_rudder = "starboard"
[sensors]
sway_kn = 0.04
[[columns]]
channel = "rudder"
column = "delta"
unit = "deg"
[result]
model = "linear"
speed_kn = 15.0
revolutions_per_s = 1.4
[coefficients]
X_0 = -0.05
X_T = 38.0
X_vv = 0.0
X_vr = 1.6
X_rr = 0.0
X_dd = -0.1
Y_0 = 0.0
Y_v = -0.6
Y_r = -0.4
Y_d = -0.1
N_0 = 0.0
N_v = -1.0
N_r = -1.8
N_d = 0.6
gamma = 0.5
l = -0.71
kappa = 0.5
c_w = 0.0
gamma_a = 0.0
[covariance]
Y_d = [0.01, 0.001]
N_d = [0.001, 0.02]
[ranges]
rudder = [-0.2, 0.2]
"""
DECCA: Final = b"""schema = "decca/1"
name = "A turn"
data = "proof.csv"
start_east_m = 1000
start_north_m = 2000

[[slaves]]
colour = "red"
east_m = 50000
north_m = 0
lane_m = 420.5

[[slaves]]
colour = "green"
east_m = 0
north_m = 60000
frequency_khz = 255

[columns]
t_s = "t"
yaw_rate_deg_s = "r"
"""
READINGS: Final = (
    b"t,rudder,heading,red,green,purple\n0,0,1,A12.5,B30.25,\n1,5,2.5,A12.75,B30.5,C51\n"
)
RECORDS: Final = (  # as loggers and spreadsheets write them
    READINGS,
    b"# a logger\n% t,rudder\n// t,rudder,heading\n0,0,359.5\n5,1,511\n10,-1,0.5\n15,0,-9999\n",
    b"sep=;\r\nt;rudder;heading;\r\ns;deg;deg;\r\n0;1,5;0,125;\r\n1.005;-998;1,005;\r\n",
    b't,rudder,heading,lat,,\n2021-01-01 00:00:05 UTC,"1,000",999,"54,30.5 N",,\n00:00:09 GMT,',
)
GRID: Final = (
    b"ncols 2\nnrows 2\nxllcorner 0\nyllcenter 0\ncellsize 1e2\nNODATA_value -9.999e3\n"
    b"nan 12000\n-9999.0 -3.40282e+38\n"
)
STATE: Final = (
    b'{"u": 5, "v": 0, "w": 0, "p": 0, "q": 0, "r": 0, "phi": 0, "theta": 0, "psi": 0, '
    b'"delta_r": 0.1, "delta_s": 0, "delta_b": 0, "u_c": 5, "last_udot": 0, "weight": 4e7}\n'
)
GUIDE: Final = (
    b'{"vessel": "bb2", "sheets": [{"title": "Turn", "judgements": {"modified": [{"quantity": "d",'
    b' "unit": "m", "full": 1.0, "other": 1.1, "verdict": "passed"}]}}], "findings": [{"title": "a"'
    b', "verdict": "b"}], "steps": []}'
)
CHECKPOINT: Final = b'{"model": "nomoto", "cost": 1.5, "parameters": {"K": 0.1, "T": 20.0}}'
BOAT: Final = """schema = "gertler-hagen-2510/1"
[fluid]
rho = 1025
g = 9.81
[vessel]
length = 5.3
mass = 5443.4
weight = 53400
buoyancy = 53400
cg = [0, 0, 0.061]
cb = [0, 0, 0]
Ix = 2038
Iy = 13587
Iz = 13587
[wave_strips]
x_m = [1.963, 1.308, 0.553, -0.209, -0.971, -1.69, -2.309]
displaced_kg = [590.6, 959.2, 960.1, 977.0, 960.1, 797.4, 199.0]
added_down_kg = [500, 900, 900, 900, 900, 700, 200]
added_side_kg = [500, 900, 900, 900, 900, 700, 200]
[[propulsion.sets]]
eta_min = 0
a = -0.004
b = 0
c = 0.004
[[propulsion.sets]]
eta_min = -99
a = -0.004
b = 0
c = -0.004
[coefficients]
"""


Loader = Callable[[Path], Any]
FILE: Final = "proof.toml"
COLUMNS: Final = {
    "t": Column("t", "s"),
    "rudder": Column("rudder", "rad"),
    "heading": Column("heading", "rad"),
}


BRIEFING: Final = re.compile(rb'^briefing = """.*?"""\n', re.DOTALL | re.MULTILINE)
SHORTER: Final = b'briefing = "Go."\n'
STATED: Final = re.compile(
    rb'^\[\[stated\]\].*?^says = "(.*?)"\n.*?(?=^\[|\Z)', re.DOTALL | re.MULTILINE
)


def text(parse: Callable[[str, Path], Any]) -> Callable[[bytes], None]:
    """Return the proof of a reader of a file's text, beside shipped files alone."""

    def take(data: bytes) -> None:
        with suppress(ConfigError), only(FILE, text_of(data)) as path:
            parse(read_text(path), path)

    return take


def load_proof(load: Loader) -> Callable[[bytes], None]:
    """Return the proof of a reader of a TOML file."""
    return text(lambda _text, path: load(path))


def open_proof(load: Loader, name: str) -> Callable[[bytes], None]:
    """Return the proof of a reader that opens a file itself."""

    def take(data: bytes) -> None:
        with suppress(ConfigError):
            load(write_file(name, data))

    return take


def exercise(text: str, path: Path) -> None:
    """Read an exercise, with the vessel that it names."""
    found = parse_exercise(text, path)
    if found.heading.vessel:
        _load_named(found.heading.vessel)


@functools.cache
def _load_named(name: str) -> Any:
    return load_vessel(name)


def vessel(text: str, path: Path) -> None:
    """Read a vessel and fit it out: what is accepted has to be computable."""
    records = fit_out(parse_vessel(text, path), Method("full", "lagged", "exact", "adams2", 0.5))
    for record in records:
        if np.isnan(record.view(np.float64)).any():
            raise AssertionError("something in its records is no number")


def ship(text: str, path: Path) -> None:
    """Read the file of a ship, write it and read it again; let it sail."""
    found = parse_ship(text, path)
    plain = replace(found, result=None, covariance=None)
    again = parse_ship(ship_text(plain, found.name), path)
    if (again.name, again.dimensions, again.records) != (
        found.name,
        found.dimensions,
        found.records,
    ):
        raise AssertionError("what is written is another ship")
    if found.result is not None:
        IdentifiedShip(found)


def hull(path: Path) -> None:
    """Read a hull and estimate its boat, whose numbers a vessel may have."""
    made = estimate_of(load_drawing(str(path)))
    if not np.isfinite([*made.values.values(), *made.sd.values()]).all():
        raise AssertionError("a coefficient or its deviation is no number")
    parse_vessel(boat_text(made, boat_tables(made)), path)


def condition(data: bytes) -> None:
    """Read a condition on the state."""
    with suppress(ConfigError):
        compile_condition(text_of(data), Position(FILE, ""))


def states(data: bytes) -> None:
    """Read states as `trainer boat evaluate` does, and compute what they lead to."""
    records, at_rest = _bb2()
    records.state[:] = at_rest
    with suppress(ConfigError):
        for answer in evaluate_states(records, text_of(data).splitlines()):
            if "nan" in answer or "inf" in answer:
                raise AssertionError(f"no number: {answer}")


@functools.cache
def _bb2() -> tuple[Records, Record]:
    """Return a boat's records, and its state at rest."""
    records = fit_out(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    return records, records.state.copy()


def lanes(path: Path) -> None:
    """Read the lanes of a Decca study."""
    solve_track(_decca(path), smooth=False)


@functools.cache
def _decca(readings: Path) -> Any:
    """Return a study of these readings."""
    study = write_file("decca.toml", DECCA.replace(b"proof.csv", readings.name.encode()))
    return load_decca(study)


# What a checkpoint is asked about: a search for two parameters.
SEARCH: Final[Any] = SimpleNamespace(
    names=("K", "T"), scale=1.0, plant=SimpleNamespace(model=SimpleNamespace(name="nomoto"))
)


def vessels() -> list[bytes]:
    """Return a small boat alone, and with each shipped table that it lacks."""
    found = [BOAT]
    for key, text in shipped_texts().items():
        if key.startswith("configs/vessels/"):
            tables = {TABLE.findall(piece)[0]: piece for piece in pieces(text)[1:]}
            found += [BOAT + _with_terms(name, tables) for name in tables if f"[{name}" not in BOAT]
    return [text.encode() for text in found]


def _with_terms(name: str, tables: Mapping[str, str]) -> str:
    """Return a table, one of compensation after the table of what a hull adds to the set."""
    return tables["compact"] * name.startswith("compensation.") + tables[name]


def cut(name: str) -> Callable[[], list[bytes]]:
    """Return a function that returns a shipped file in pieces, its heading before each."""

    def seeds() -> list[bytes]:
        heading, *tables = pieces(shipped_texts()[f"configs/{name}.toml"])
        return [(heading + table).encode() for table in tables]

    return seeds


def without_texts(seed: bytes) -> bytes:
    """Return an exercise with a short briefing, without the figures of the long one."""
    short = BRIEFING.sub(SHORTER, seed)
    words = b" ".join(STATED.sub(b"", short).split())
    return STATED.sub(lambda row: row[0] if row[1] in words else b"", short)


def exercises() -> list[bytes]:
    """Return the shipped exercises, their briefings short: they are most of each.

    One that reads a grid of the ground beside it is not among them.
    """
    seeds = [without_texts(seed) for seed in shipped_seeds("exercises")]
    return [seed for seed in seeds if b"grid =" not in seed]


TARGETS: Final = (
    Target("vessel", "a vessel file, made into a boat", text(vessel), vessels, 3000),
    Target("sea", "a sea file", text(parse_sea), lambda: shipped_seeds("seas"), spared=()),
    Target("case", "a check case", text(parse_case), lambda: shipped_seeds("check-cases"), 4000),
    Target(
        "casualties",
        "a table of casualties",
        text(lambda text, path: parse_casualties(text, path, {})),
        cut("casualties/standard"),
        640,
    ),
    Target("exercise", "an exercise file", text(exercise), exercises, 6000, GRAMMAR),
    Target(
        "trials", "published results of a boat", load_proof(load_published), cut("trials/bb2"), 2000
    ),
    Target(
        "condition",
        "a condition on the state",
        condition,
        lambda: [c.encode() for c in CONDITIONS],
        64,
    ),
    Target(
        "study", "a study of a ship from its record", load_proof(load_study), lambda: [STUDY], 512
    ),
    Target(
        "hull",
        "a drawing, its boat estimated",
        load_proof(hull),
        lambda: shipped_seeds("hulls"),
        2400,
    ),
    Target(
        "ship",
        "a ship that is not linear",
        text(ship),
        lambda: [SHIP, *shipped_seeds("ships")],
        10_000,
        spared=(),
    ),
    Target(
        "nomoto",
        "a ship of a few parameters",
        load_proof(load_nomoto),
        lambda: [NOMOTO],
        spared=(),
    ),
    Target(
        "derivatives",
        "a table of a ship's derivatives",
        load_proof(load_derivatives),
        lambda: [DERIVATIVES],
        spared=(),
    ),
    Target("system", "matrices with expressions", load_proof(load_system), lambda: [SYSTEM], 512),
    Target("decca", "a chain of Decca stations", load_proof(load_decca), lambda: [DECCA], 512),
    Target(
        "lanes", "readings of Decca lanes, CSV", open_proof(lanes, "lanes.csv"), lambda: [*RECORDS]
    ),
    Target(
        "record",
        "a record of a ship, CSV",
        open_proof(lambda path: load_record(path, COLUMNS), "record.csv"),
        lambda: [*RECORDS],
    ),
    Target(
        "columns",
        "the columns of a record, guessed",
        open_proof(lambda path: guess_columns(read_table(path), CHANNEL_WORDS), "guess.csv"),
        lambda: [*RECORDS],
    ),
    Target(
        "grid",
        "soundings on an ESRI ASCII grid",
        open_proof(lambda path: read_ascii(path.read_bytes(), path), "grid.asc"),
        lambda: [GRID],
    ),
    Target(
        "series", "a series to be fitted, CSV", open_proof(load_series, "t.csv"), lambda: [*RECORDS]
    ),
    Target("evaluate", "states to be evaluated, JSON lines", states, lambda: [STATE], 512),
    Target(
        "baseline",
        "an earlier guide, JSON or HTML",
        open_proof(lambda path: load_earlier(path, "bb2"), "guide.json"),
        lambda: [GUIDE],
        512,
    ),
    Target(
        "checkpoint",
        "a search that was left, JSON",
        open_proof(lambda path: resume_search(path, SEARCH), "search.json"),
        lambda: [CHECKPOINT],
    ),
)
