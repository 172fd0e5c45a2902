"""Ticks of a boat in a compiled loop, and what gives a tick the most to do."""

from typing import Final

import numpy as np

from trainer.boat.assemble import Records
from trainer.boat.machine_code import EMPTY_CHART
from trainer.core.entry import fly

# fmt: off
CASUALTY_KINDS: Final = (
    "rudder-slow", "stern-slow", "bow-slow", "depth-gauge-noisy", "gyro-biased", "log-noisy",
)
# fmt: on


def in_a_loop(records: Records, count: int) -> int:
    """Take ``count`` ticks of a boat without Python between them; return the last status."""
    return int(fly(records, EMPTY_CHART, EMPTY_CHART, np.empty((count, 0))))
