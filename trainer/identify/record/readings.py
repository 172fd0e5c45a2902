"""The readings of a channel's own instrument, and what goes on between them.

A logger that writes all channels in each row repeats the last reading of a slow one, or leaves its
cell empty. A repeat is no reading: a fit that takes it for one finds a ship that is late. Whether a
column was filled forward its changes tell: nearly all lie in rows of one phase, or keep the beat of
another clock.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.record.measurements import FIN_CHANNELS, Finding, Record, unwrap_angle

MIN_CHANGES: Final = 12  # of a column, to tell whether it was filled forward
MIN_CELLS: Final = 30
MOST_ROWS: Final = 60  # from reading to reading
PHASE_SHARE: Final = 0.95  # [-] of changes in rows of one phase
PHASE_EVIDENCE: Final = 6.0  # [-] changes times log10 of the rows
BLOCK_CHANGES, MIN_BLOCK_CHANGES = 40, 20  # of another clock, told block by block
CLOCK_ROWS: Final = (2.2, 31.0)  # from reading to reading: two would fit all rows
CLOCK_ROOM: Final = 0.1  # [-] of the circle, beyond a row
CLOCK_CHANCE: Final = -9.0  # log10 that changes lie so by themselves
AGREEING_BLOCKS: Final = 0.9  # [-] of all, within CLOCK_SPREAD
CLOCK_SPREAD: Final = 0.06  # [-]
LONG_RUNS: Final = 0.96  # [-] of runs are no shorter
STAIRS_SHARE: Final = 0.8  # [-] of steps alike and one way: a coarse instrument in a steady turn
GAP_READINGS: Final = 1.5  # [-] of a channel's usual interval: a longer one is a gap
PATH_WORDS: Final = {"straight": "straight", "step": "as it stood"}
MOVING_SHARE: Final = 0.1  # [-] of its largest change: a rudder that changes more is moving
MAX_UNDER_WAY_SHARE: Final = 0.1  # [-] of its moves that a jumping rudder shows under way
MIN_MOVES: Final = 3  # of a rudder, to tell whether it jumps from reading to reading
RARE_ROWS: Final = 2.0  # [rows] from reading to reading, of a channel that is rarer than its rows
OUTPUT_CHANNELS: Final = ("heading", "yaw_rate", "sway", "bow_sway", "stern_sway")
ACTING_CHANNELS: Final = ("rudder", "stern", "bow", *FIN_CHANNELS, "revolutions", "command_speed")
ANGLE_CHANNELS: Final = ("heading", "longitude")  # that jump by a turn


class Hold(NamedTuple):
    """How a column's readings stand in its cells."""

    every: float  # [rows] from reading to reading, 1 where each cell is one
    kept: NDArray[np.bool_]  # (n,) cells that are readings
    exact: bool = True  # else by another clock: read some time in the row before


def find_hold(values: Numbers) -> Hold:
    """Return how the readings of a column (n,) without empty cells stand in it."""
    each = Hold(1.0, np.ones(len(values), bool))
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    if len(values) < MIN_CELLS or not MIN_CHANGES <= len(changes) <= 0.53 * len(values):
        return each
    rows = np.arange(len(values))
    best = each
    for every in range(2, min(MOST_ROWS, int(len(values) / (PHASE_SHARE * len(changes))) + 1) + 1):
        counts = np.bincount(changes % every, minlength=every)
        share = float(counts.max()) / len(changes)
        if share >= PHASE_SHARE and len(changes) * math.log10(every) > PHASE_EVIDENCE:
            best = Hold(float(every), rows % every == np.argmax(counts))  # divisors agree as well
    if best.every > 1.0 or _is_staircase(np.diff(values)[changes - 1]):
        return best
    beat = _find_beat(changes)
    if not beat:
        return each
    first = np.append(True, np.diff(values) != 0.0)
    since = rows - np.maximum.accumulate(np.where(first, rows, 0))
    stands = (since > 0) & (since % max(round(beat), 1) == 0) & (since >= 1.6 * beat)
    return Hold(beat, first | stands, exact=False)


def _is_staircase(jumps: Numbers) -> bool:
    """Return whether a coarse instrument turns steadily: steps alike, and one way."""
    size = np.abs(jumps)
    alike = float(np.mean(np.abs(size / size.min() - 1.0) < 0.02))
    return alike > STAIRS_SHARE and float(np.mean(jumps[1:] * jumps[:-1] > 0.0)) > STAIRS_SHARE


def _find_beat(changes: NDArray[np.int64]) -> float:
    """Return the rows from reading to reading of another clock, 0 if there is none.

    Folded by it, all changes of a block lie within one row of the circle.
    """
    starts = range(0, max(len(changes) - BLOCK_CHANGES, 0) + 1, BLOCK_CHANGES)
    found = list[float]()
    for number, first in enumerate(starts):
        if len(found) < number - (1.0 - AGREEING_BLOCKS) * len(starts):
            return 0.0
        part = changes[first : first + BLOCK_CHANGES]
        since = (part - part[0]).astype(float)
        top = min(CLOCK_ROWS[1], since[-1] / MIN_CHANGES)
        if len(part) < MIN_BLOCK_CHANGES or top <= CLOCK_ROWS[0]:
            continue
        rates = np.arange(1.0 / top, 1.0 / CLOCK_ROWS[0], CLOCK_ROOM / since[-1])
        turns = np.sort((since * rates[:, None]) % 1.0, axis=1)
        room = 1.0 - np.diff(turns, axis=1, append=turns[:, :1] + 1.0).max(axis=1)
        chance = len(part) * np.log10(np.clip(np.maximum(room, rates), 1e-9, 1.0))
        good = (room - rates < CLOCK_ROOM) & (chance < CLOCK_CHANCE)
        beat = 1.0 / float(rates[np.argmin(np.where(good, chance, 0.0))])
        if good.any() and np.mean(np.diff(part) >= math.floor(beat)) > LONG_RUNS:
            found.append(beat)
    beat = float(np.median(found)) if found else 0.0
    near = np.abs(np.array(found) - beat) < CLOCK_SPREAD * beat
    whole = len(found) >= AGREEING_BLOCKS * len(starts)
    return beat if found and whole and float(near.mean()) >= AGREEING_BLOCKS else 0.0


def keep_readings(record: Record) -> Record:
    """Return the record without cells that only repeat a reading, and told.

    What another clock has read is put half a row earlier, where it was on the mean: the record then
    has a row of its own for it.
    """
    step = float(np.median(np.diff(record.t)))
    columns, findings, moved = record.values, list(record.findings), list[str]()
    for name, values in columns.items():
        known = np.flatnonzero(np.isfinite(values))
        hold = find_hold(values[known])
        acts = name in ACTING_CHANNELS or name in record.plain
        # what stands between two jumps is an order that stands
        if hold.every == 1.0 or (acts and jumps_at_readings(values[known[hold.kept]])):
            if known.size > 1 and rows_between(values) >= RARE_ROWS:
                often = float(np.median(np.diff(record.t[known])))
                text = f"{known.size} readings, one in {often:.3g} s"
                findings.append(record.finding(name, text))
            continue
        columns[name] = np.full_like(values, np.nan)
        columns[name][known[hold.kept]] = values[known[hold.kept]]
        text = f"filled forward: a reading each {hold.every:.3g} rows; the others are left out"
        if not hold.exact:
            moved.append(name)
            text += f". Read at times that the file does not know to a row ({step:.3g} s)"
            text += ": no band has that"
        findings.append(record.finding(name, text))
    record = replace(record.with_values(columns), findings=tuple(findings))
    return _put_earlier(record, moved, 0.5 * step) if moved else record


def _put_earlier(record: Record, names: Sequence[str], seconds: float) -> Record:
    """Return the record with readings of some channels earlier, in rows of their own."""
    early = np.any([np.isfinite(record.values[name]) for name in names], axis=0)
    begin = len(record.t)
    order = np.append(np.arange(begin), np.flatnonzero(early))
    late = order[begin:]
    t = np.append(record.t, record.t[late] - seconds)
    wide = record.part(order)
    columns = wide.values
    for name, values in columns.items():
        values[slice(None, begin) if name in names else slice(begin, None)] = np.nan
    said = np.any([np.isfinite(values) for values in columns.values()], axis=0)
    rows = np.argsort(t, kind="stable")
    return replace(wide.with_values(columns), t=t).part(rows[said[rows]])


def jumps_at_readings(values: Numbers) -> bool:
    """Return whether nearly all of several moves are done, nearly wholly, between two readings."""
    change = np.diff(values[np.isfinite(values)])
    size = np.abs(change)
    least = MOVING_SHARE * float(np.max(size, initial=0.0))
    pair = np.sort(np.stack([size[1:], size[:-1]]), axis=0)
    under_way = (change[1:] * change[:-1] > 0.0) & (pair[0] > np.maximum(least, pair[1] / 4.0))
    moves = np.count_nonzero(size > least)
    few = np.count_nonzero(under_way) <= MAX_UNDER_WAY_SHARE * moves
    return bool(moves >= MIN_MOVES and few)


def fill_inputs(record: Record, inputs: Sequence[str], path: str) -> Record:
    """Return the record with its inputs known in each row: between readings as ``path`` says.

    ConfigError if one has no reading at all. A gap is told.
    """
    columns, findings = record.values, list(record.findings)
    for name in inputs:
        if (values := columns.get(name)) is None:
            continue
        known = np.flatnonzero(np.isfinite(values))
        if not known.size:
            raise ConfigError(f"{record.source}: {record.name(name)}: has no value at all")
        findings += find_gaps(record, name, known, f": taken {PATH_WORDS[path]} across it")
        if path == "step":
            last = np.searchsorted(known, np.arange(len(values)), side="right") - 1
            columns[name] = values[known[np.maximum(last, 0)]]
        elif known.size < len(values):
            columns[name] = np.interp(record.t, record.t[known], values[known])
    return replace(record.with_values(columns), findings=tuple(findings))


def find_gaps(
    record: Record, name: str, known: NDArray[np.int64], what: str = ""
) -> Iterator[Finding]:
    """Yield the longest gap between ``known`` readings of a channel, longer than its intervals."""
    ends = np.concatenate([record.t[:1], record.t[known], record.t[-1:]])
    steps = np.diff(ends)
    usual = float(np.median(steps[1:-1])) if len(known) > 1 else math.inf
    longest = int(np.argmax(steps))
    count = np.count_nonzero(steps > GAP_READINGS * usual)
    if count:
        more = f"; {count - 1} more such gaps" if count > 1 else ""
        text = f"has no reading for {steps[longest]:.4g} s, one each {usual:.3g} s else{what}"
        yield record.finding(name, text + more, known[min(longest, len(known) - 1)])


def rows_between(values: Numbers) -> float:
    """Return the usual rows from reading to reading of a column; infinite of none."""
    known = np.flatnonzero(np.isfinite(values))
    return float(np.median(np.diff(known))) if known.size > 1 else math.inf


def at_readings(record: Record, leads: Sequence[str] = OUTPUT_CHANNELS) -> Record:
    """Return the record with all channels laid on readings of the rarest lead.

    A record that has all of them in each row comes back as it is.
    """
    columns = record.values
    every = {name: rows_between(columns[name]) for name in leads if name in columns}
    rare = {name: rows for name, rows in every.items() if RARE_ROWS <= rows < math.inf}
    if not rare:
        return record
    lead = max(rare, key=rare.__getitem__)
    for name, values in columns.items():
        known = np.isfinite(values)
        if name != lead and rows_between(values) >= RARE_ROWS and known.any():
            angle = name in ANGLE_CHANNELS
            own = unwrap_angle(values[known]) if angle else values[known]
            columns[name] = np.interp(record.t, record.t[known], own)
    return record.with_values(columns).part(np.isfinite(record.values[lead]))
