"""A ship's run of which the track is known, as lanes of a Decca chain and the study of them."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from helpers.places import DATA
from trainer.identify.pages.decca import Point, Slave, lane_at

CASES: Any = json.loads((DATA / "identification" / "decca.json").read_text())
CHAIN = {
    colour: Slave(Point(*place), CASES["chain"]["lane_width"][colour])
    for colour, place in CASES["chain"]["slaves"].items()
}
TRACK = CASES["track"]

FILE = """
schema = "decca/1"
name = "a run off the coast"
data = "lanes.csv"
start_east_m = {east}
start_north_m = {north}

[[slaves]]
colour = "red"
east_m = 60000
north_m = 70000
lane_m = 881.3235294117648

[[slaves]]
colour = "green"
east_m = 95000
north_m = -20000
lane_m = 1175.0980392156862

[[slaves]]
colour = "purple"
east_m = -40000
north_m = -80000
lane_m = 705.0588235294117
"""


def write_run(folder: Path, antenna: float = 0.0, extra: str = "") -> Path:
    """Write the lanes and their study, with the antenna so far ahead [m]; return the study's path.

    The axis x0 of the track is north.
    """
    x, y, psi = (np.array(TRACK[key]) for key in ("x0", "y0", "psi"))
    east = 30000.0 + y + antenna * np.sin(psi)
    north = 20000.0 + x + antenna * np.cos(psi)
    lines = ["t,heading,red,green,purple"]
    for i, place in enumerate(map(Point, east, north)):
        lanes = (repr(float(lane_at(CHAIN[c], place))) for c in ("red", "green", "purple"))
        lines.append(f"{5.0 * i},{math.degrees(psi[i])!r},{','.join(lanes)}")
    (folder / "lanes.csv").write_text("\n".join(lines) + "\n")
    study = folder / "run.toml"
    study.write_text(FILE.format(east=float(east[0]), north=float(north[0])) + extra)
    return study
