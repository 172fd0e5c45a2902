"""A session that goes on as a record that a watch can judge.

A session shows its gauges tick by tick. Here they become the record that its recording would be, so
that the watch of ``watch`` says the same of both. A jump in time, a gap, or a boat near the surface
begins the record anew. What the watch finds is told once, in sentences as short as a remark may be.
"""

import math
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from trainer.boat.boat import turning_signs
from trainer.config.files import ConfigError, raise_problems
from trainer.identify.boat.altered import WINDOW_LENGTHS, window_rows
from trainer.identify.boat.trial import (
    INTERVAL_RANGE_S,
    MIN_READINGS,
    SLOWEST_M_S,
    Trial,
    every_tick,
    lay_out,
    least_depth,
    read_by_instruments,
    trial_problems,
    without_unflown,
)
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.boat.watch import (
    JUDGED_WINDOWS,
    MEMORY_WINDOWS,
    BoatChange,
    BoatWatch,
)
from trainer.identify.boat.watch_page import amount_words, clock_words
from trainer.identify.record.findings import unwrap_heading
from trainer.identify.record.measurements import Record
from trainer.units import DEGREE, KNOT

# by channel of a session: its fields, the channel of a record that each is, and its unit in SI
SHOWN_FIELDS: Final[Mapping[str, Mapping[str, tuple[str, float]]]] = {
    "gauges": {
        "depth": ("depth", 1.0),
        "heading": ("heading", DEGREE),
        "speed": ("speed", KNOT),
        "pitch": ("pitch", DEGREE),
        "heel": ("roll", DEGREE),
    },
    "steering": {"rudder": ("rudder", DEGREE)},
    "diving": {"stern": ("stern", DEGREE), "bow": ("bow", DEGREE)},
    "engine": {"rpm": ("revolutions", 1.0 / 60.0)},
}
SURFACE_CHANNELS: Final = ("rudder", "stern", "bow")
MAX_GAP_LENGTHS: Final = WINDOW_LENGTHS / 4.0  # [L/U] without a reading: more begins a record anew
REMARK_LETTERS: Final = 52  # that the line of a mark has room for


@dataclass
class LiveRecord:
    """What a session has shown since the record was begun, by tick."""

    vessel: FittedVessel
    biases: Mapping[str, float] = field(default_factory=dict)  # of Instruments
    rows: dict[int, dict[str, float]] = field(default_factory=dict)  # by tick
    seconds: list[float] = field(default_factory=list)  # of the rows
    forgotten: int = 0  # readings that were the first of this record
    number: int = 0  # of records begun
    latest: int = -1  # tick that was heard of

    def __post_init__(self) -> None:
        self._signs = turning_signs(self.vessel.file.coefficients)
        self._coming: dict[str, float] = {}  # of the tick that is being told
        self._heard: set[str] = set()

    def hear(self, channel: str, tick: int, seconds: float, values: Mapping[str, str]) -> str:
        """Take what a channel shows; return why the record begins anew, "" if not."""
        if channel not in SHOWN_FIELDS:
            return ""
        why = ""
        if tick != self.latest:
            if tick < self.latest:
                why = self.begin("time has gone back")
            self.latest, self._coming, self._heard = tick, {}, set()
        for name, (taken, size) in SHOWN_FIELDS[channel].items():
            text = values.get(name, "")
            sign = self._signs[taken] or 1.0 if taken in SURFACE_CHANNELS else 1.0
            self._coming[taken] = sign * size * float(text) if text else math.nan
        self._heard.add(channel)
        return self._keep(tick, seconds) or why if len(self._heard) == len(SHOWN_FIELDS) else why

    def begin(self, why: str) -> str:
        """Begin the record anew; return why, "" where nothing had been kept."""
        had = bool(self.rows)
        self.rows, self.seconds, self.forgotten = {}, [], 0
        self.number += had
        return why if had else ""

    def _keep(self, tick: int, seconds: float) -> str:
        """Keep a whole tick, if it is one that is needed; return why the record begins anew."""
        least = least_depth(self.vessel)
        if least is not None and self._coming["depth"] < least:
            return self.begin(f"less than {least:.3g} m deep: the surface is not in the model")
        if self._coming["speed"] < SLOWEST_M_S:
            return self.begin(f"slower than {SLOWEST_M_S:g} m/s or astern")
        why = ""
        if self.rows:
            first = next(iter(self.rows))
            gap = seconds - self.seconds[-1]
            if tick in self.rows:
                return ""
            if gap > MAX_GAP_LENGTHS * self.vessel.length / self.vessel.speed:
                why = self.begin(f"nothing was heard for {gap:.0f} s")
            elif (tick - first) % every_tick(
                self.vessel, (seconds - self.seconds[0]) / (tick - first)
            ):
                return ""
        self.rows[tick] = self._coming
        self.seconds.append(seconds)
        return why

    @property
    def window_rows(self) -> int:
        """Return the readings from judgement to judgement."""
        steps = np.diff(self.seconds)
        interval = float(np.median(steps)) if len(steps) else INTERVAL_RANGE_S[1]
        return window_rows(self.vessel, interval)

    def trial(self) -> Trial:
        """Return the record of the windows that count; ConfigError why it cannot be judged yet.

        What is older is forgotten.
        """
        if len(self.rows) < MIN_READINGS:
            raise ConfigError(f"{len(self.rows)} of {MIN_READINGS} readings have come")
        old = len(self.rows) - 1 - MEMORY_WINDOWS * self.window_rows
        if old > 0:
            interval = float(np.median(np.diff(self.seconds)))
            self.forgotten += round((self.seconds[old] - self.seconds[0]) / interval)
            self.rows, self.seconds = dict([*self.rows.items()][old:]), self.seconds[old:]
        rows = [*self.rows.values()]
        columns: dict[str, Any] = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        t, numbers = np.array(self.seconds), np.arange(1, len(rows) + 1)
        source = f"the session from {clock_words(t[0])} on"
        record = Record(source=source, t=t, rows=numbers, names={}, **columns)
        laid = lay_out(unwrap_heading(record), self.vessel)
        trial = read_by_instruments(laid, self.forgotten)
        raise_problems([*trial_problems(trial, self.vessel)])
        return without_unflown(replace(trial, biases=self.biases))


@dataclass
class LiveVerdict:
    """What has been told of one record, so that it is told once."""

    told: tuple[str, ...] = ()  # the parts, the likeliest first
    final: bool = False  # enough came after the change to name its part

    def news(self, report: BoatWatch, begun: float) -> list[str]:
        """Return what to tell of a judgement, nothing where all is told.

        ``begun`` [s] is where its record begins in the session.
        """
        change = report.change
        if change is None or self.final:
            return []
        names = tuple(one.name for one in change.parts)
        self.final = len([t for t in report.t if t > change.told.t]) >= JUDGED_WINDOWS
        if self.told and names[0] == self.told[0]:
            return []
        self.told = names
        return [*change_remarks(change, begun)]


def change_remarks(change: BoatChange, begun: float) -> Iterator[str]:
    """Yield a change in sentences of at most REMARK_LETTERS; ``begun`` [s] is the record's."""
    first, *others = change.parts
    since = clock_words(begun + change.earliest.seconds)
    yield f"{first.name} {amount_words(first.value, first.unit, sign=True)} since {since}"
    if others:
        words = f"or {'; '.join(one.name for one in others)}: not told apart"
        yield from textwrap.wrap(words, REMARK_LETTERS)


def state_words(report: BoatWatch, begun: float) -> str:
    """Return how far a boat now is from the one that was fitted."""
    latest = [row[-1] for row in report.deviations]
    at = int(np.argmax(latest))
    return (
        f"{clock_words(begun + report.t[-1])}  most: {report.parts[at].name} "
        f"{latest[at]:.1f} (told beyond {report.limit:g})"
    )
