"""Numbers that loggers write where there is no reading: 511, or -9999.

``sources`` reads records by it, because a filter follows them as if the ship had jumped.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.record.measurements import Record

USUAL_CODES: Final = (
    *(511.0, 655.35, 999.0, 999.9, 9999.0, 32767.0, 65535.0, 99999.0),
    *(-999.0, -9999.0, -32767.0, -32768.0, -99999.0),
)
CODES_TEXT: Final = "usual are 511, 999, -9999, 32767, 65535, of AIS 91 and 102.3"
MAX_SIZES: Final = {  # of what a ship does, SI: beyond is no reading
    **dict.fromkeys(("rudder", "yaw_rate", "latitude"), 0.5 * math.pi),
    **dict.fromkeys(("sway", "bow_sway", "stern_sway", "speed"), 50.0),
    **dict.fromkeys(("north_velocity", "east_velocity"), 50.0),
    **dict.fromkeys(("wind_speed", "wind_ahead", "wind_starboard", "revolutions"), 110.0),
    **dict.fromkeys(("wind_from", "roll", "roll_rate"), math.radians(500.0)),
}
CODE_SHARE: Final = 1.4  # [-] of the largest other number: a usual code beyond it is one
HEADING_RANGE_DEG: Final = (-185.0, 365.0)  # [deg] of a heading within a turn, and its noise
MAX_JUMP_DEG: Final = 60.0  # [deg] from row to row; more, and back, is no ship's
MAX_JUMP_ROWS: Final = 5  # [rows] until it is back
USUAL_STEPS: Final = 6.0  # [-] of the usual change from row to row: a jump is more
MAX_CODES: Final = 3  # [numbers] that one logger writes for no reading
MAX_ROWS_TOLD: Final = 10


def find_codes(numbers: Numbers) -> tuple[float, ...]:
    """Return the usual codes among numbers that are far beyond all others."""
    usual = np.isin(numbers, USUAL_CODES)
    largest = float(np.nanmax(np.abs(numbers), where=~usual, initial=0.0))
    return tuple(np.unique(numbers[usual & (np.abs(numbers) > CODE_SHARE * largest)]).tolist())


def find_impossible(channel: str, values: Numbers, unit: str) -> tuple[int, str] | None:
    """Return the index of a reading [SI] that no ship has, and why; else None."""
    beyond = np.abs(np.nan_to_num(values)) > MAX_SIZES.get(channel, math.inf)
    degrees = f'; are these degrees? say unit = "{unit.replace("rad", "deg")}"' * ("rad" in unit)
    text = f"no {channel} in {unit} is so large{degrees}; if it stands for no reading"
    return (int(np.argmax(beyond)), text) if beyond.any() else None


def without_jumps(record: Record) -> Record:
    """Return the record, readings of its heading missing that leave it and come back."""
    if record.heading is None:
        return record
    known = np.flatnonzero(~np.isnan(record.heading))
    degrees = np.degrees(record.heading[known])
    indices = known[sorted({*_outside(degrees), *_back_again(degrees)})]
    if not indices.size:
        return record
    rows, raw = record.rows[indices].tolist(), math.degrees(record.heading[indices[0]])
    told = f"{len(rows)} missing, rows {', '.join(map(str, rows[:MAX_ROWS_TOLD]))}"
    finding = record.finding("heading", f"{raw:g} deg is no heading here: {told}", indices[0])
    heading = record.heading.copy()
    heading[indices] = np.nan
    return replace(record, heading=heading, findings=(*record.findings, finding))


def _outside(heading: Numbers) -> Iterator[int]:
    """Yield the readings [deg] outside one turn: a few numbers, reached by no small step."""
    outside = (heading < HEADING_RANGE_DEG[0]) | (heading > HEADING_RANGE_DEG[1])
    steps = np.abs(np.diff(heading))[np.diff(outside)]
    if steps.size and steps.min() > MAX_JUMP_DEG and np.unique(heading[outside]).size <= MAX_CODES:
        yield from np.flatnonzero(outside).tolist()


def _back_again(heading: Numbers) -> Iterator[int]:
    """Yield the readings [deg] far from those before and after them, in a few rows."""
    steps, done = _turned(np.diff(heading)), 0
    limit = max(MAX_JUMP_DEG, USUAL_STEPS * float(np.median(steps))) if len(steps) else math.inf
    for i in (np.flatnonzero(steps > limit) + 1).tolist():
        away = _turned(heading[i : i + MAX_JUMP_ROWS + 1] - heading[i - 1]) > limit
        if i >= done and not away.all():
            done = i + int(np.argmin(away)) + 1
            yield from range(i, done - 1)


def _turned(change: Numbers) -> Numbers:
    """Return the size of a change of heading [deg], by the shorter way."""
    return np.asarray(np.abs(np.mod(change + 180.0, 360.0) - 180.0))
