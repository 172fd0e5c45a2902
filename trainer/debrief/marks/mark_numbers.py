"""The numbers by which marks are made: shares, caps and times, most of them estimates.

They are compiled into the judge (``tallies``), so that this module imports nothing of the package.
"""

from collections.abc import Mapping
from math import radians
from typing import Final

HELD_TIME_S: Final = 30.0  # [s] in the band from which a target counts as reached
SLIP_COST: Final = 3.0  # [s] of them for each second outside; an estimate
EDGE_SHARE: Final = 0.5  # of a band, outside it, over which being there fades; an estimate
SETTLING_WINDOW_S: Final = 120.0  # [s] of a window, in which the boat has to have settled
GATE_TIME_S: Final = 2.0  # [s] for which a limit must be broken before it costs marks
GATE_CAP: Final = 50.0  # [%] most that is left where a limit was wholly broken
FULL_BREACH_S: Final = 30.0  # [s] beyond a limit by FULL_EXCESS of it that break it wholly
FULL_EXCESS: Final = 0.25  # [-] of the limit; an estimate
LEAST_EXCESS: Final[Mapping[str, float]] = {  # [unit of the limit] at least, for limits near 0
    "depth_m": 2.0,
    "pitch_deg": 2.0,
    "heel_deg": 2.0,
    "speed_kn": 0.5,
    "speed_over_ground_kn": 0.5,
    "clearance_m": 0.5,
    "cpa_m": 20.0,
}
TURNED_PITCH, TURNED_HEEL = radians(45.0), radians(60.0)  # [rad] beyond: turned over
LOST_CAP, HARD_CAP = 25.0, 0.0  # [%] most that is left
WHOLE_TASK_PERCENT: Final = 80.0  # [%] marks below which the weakest task takes of the others'
KEEPING_SHARE: Final = 0.3  # of the total, by how the boat was kept
WEAKEST_SHARE: Final = 0.4  # of the total, by the weakest task: so none is won without one
MAX_NOBODY_PERCENT: Final = 50.0  # [%] with nobody aboard; a task that gives more does not count
