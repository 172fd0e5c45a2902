"""Records of a first-order ship whose rudder moves at a rate, or jumps at readings."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

K_TRUE, T_TRUE = 0.08, 22.0  # [1/s], [s]
HELM_DEG = 10.0
STEP_S = 0.01  # of the exact recursion, in whose steps the rudder is a line
HOLD_S = (15.0, 45.0)  # of each helm
STUDY = """
schema = "identify/1"
name = "a ship of first order"
data = "run.csv"
positive_rudder = "starboard"
{more}
[[columns]]
channel = "t"
column = "time"
unit = "s"

[[columns]]
channel = "rudder"
column = "{rudder}"
unit = "deg"

[[columns]]
channel = "heading"
column = "heading"
unit = "deg"

[[columns]]
channel = "yaw_rate"
column = "rate"
unit = "deg/s"

[ship]
length_m = 100
speed_kn = 12

[model]
kind = "nomoto1"
outputs = ["yaw_rate", "heading"]

[armax]
output = "yaw_rate"
most = 2
"""


def sail(
    seed: int,
    *,
    rate: float | None,
    interval: float = 2.0,
    seconds: float = 1500.0,
    rate_error: float = 0.02,
    heading_error: float = 0.2,
) -> Any:
    """Return time, rudder, heading and yaw rate (n, 4) of a trial, degrees, as instruments read.

    The rudder goes from side to side at ``rate`` [deg/s], or jumps at readings if it is None.
    """
    stream = np.random.default_rng(seed)
    count, every = round(seconds / STEP_S) + 1, round(interval / STEP_S)
    order, at, side = np.empty(count), 0.0, 1.0
    while at < count * STEP_S:
        hold = stream.uniform(*HOLD_S)
        first, last = (round(one / STEP_S) for one in (at, at + hold))
        if rate is None:
            first, last = (every * round(one / interval) for one in (at, at + hold))
        order[first:last], at, side = side * HELM_DEG, at + hold, -side
    rudder, most = order.copy(), (rate or np.inf) * STEP_S
    for k in range(1, count) if rate else ():
        rudder[k] = rudder[k - 1] + min(max(order[k - 1] - rudder[k - 1], -most), most)
    stays = np.exp(-STEP_S / T_TRUE)
    mean = 0.5 * (rudder[1:] + rudder[:-1]) if rate else rudder[:-1]
    turning = np.append(0.0, lfilter([1.0], [1.0, -stays], (1.0 - stays) * K_TRUE * mean))
    heading = np.append(0.0, np.cumsum(0.5 * STEP_S * (turning[1:] + turning[:-1])))
    t = STEP_S * np.arange(count)
    rows = np.column_stack([t, rudder, heading, turning])[::every]
    rows[:, 2:] += (heading_error, rate_error) * stream.standard_normal((len(rows), 2))
    rows[:, 2] %= 360.0
    return rows


def write_study(folder: Path, rows: Any, more: str = "", rudder: str = "rudder") -> Path:
    """Write a record and its study; return the study's path."""
    head = f"time,{rudder},heading,rate"
    np.savetxt(folder / "run.csv", rows, "%.4f", ",", header=head, comments="")
    path = folder / "run.toml"
    path.write_text(STUDY.format(more=more, rudder=rudder))
    return path
