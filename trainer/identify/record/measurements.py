"""A record of a ship under helm, as read and as models take it.

The rudder is positive when it turns the ship to port (trailing edge to port), as in the report and
in the trainer; a source with the other sign says so in the study file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.record.evidence import Ratio
from trainer.units import DEGREE

CHANNEL_UNITS: Final = {  # what may be recorded beside time, and its unit
    "rudder": "rad",
    "heading": "rad",
    "yaw_rate": "rad/s",
    "sway": "m/s",
    "bow_sway": "m/s",
    "stern_sway": "m/s",
    "speed": "m/s",
}
SHIP_CHANNEL_UNITS: Final = {  # likewise, of ships that are not linear
    "revolutions": "1/s",
    **dict.fromkeys(("north_velocity", "east_velocity"), "m/s"),  # over ground
    **dict.fromkeys(("wind_speed", "wind_ahead", "wind_starboard"), "m/s"),  # as the ship feels it
    "wind_from": "rad",
    "roll": "rad",
    "roll_rate": "rad/s",
}
FIN_CHANNELS: Final = ("fin_1", "fin_2", "fin_3", "fin_4")  # of an X-tail, as Record has them
BOAT_CHANNEL_UNITS: Final = {  # likewise, of boats that dive
    **dict.fromkeys(("stern", "bow", "pitch", *FIN_CHANNELS), "rad"),
    "pitch_rate": "rad/s",
    "depth": "m",
    **dict.fromkeys(("command_speed", "ground_speed"), "m/s"),
}
POSITION_CHANNELS: Final = ("latitude", "longitude")  # that sway is made of
MIN_SAMPLES_EACH: Final = 5  # to a coefficient, at least
STANDING_SHARE: Final = 0.1  # [-] of the rate of a rudder under way: one that is slower stands
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Finding:
    """Something about a record that an analyst should know; row 0 is the whole column."""

    column: str
    row: int
    text: str

    def __str__(self) -> str:
        where = f"row {self.row}: " if self.row else ""
        return f"{where}{self.column}: {self.text}"


@dataclass(frozen=True, kw_only=True)
class Record:
    """Columns of one length. NaN is a missing value, None a channel that was not recorded.

    ``between_readings`` is one of INPUT_PATHS: the rudder goes straight from ``t[k]`` to
    ``t[k+1]``, or ``rudder[k]`` stands until then. The heading does not jump from 360 to 0 degrees.
    ``rows`` is each sample's row in its source, counted from 1, and ``names`` the source's own word
    for each channel: both are for messages. ``findings`` has what an analyst should know.
    """

    source: str
    t: Numbers  # [s] rising
    rudder: Numbers | None = None  # [rad] positive turns to port
    heading: Numbers | None = None  # [rad]
    yaw_rate: Numbers | None = None  # [rad/s]
    sway: Numbers | None = None  # [m/s] at the centre of mass, positive to starboard
    bow_sway: Numbers | None = None  # [m/s] at the forward log
    stern_sway: Numbers | None = None  # [m/s] at the aft log
    speed: Numbers | None = None  # [m/s]
    latitude: Numbers | None = None  # [rad] of the antenna
    longitude: Numbers | None = None  # [rad] likewise
    revolutions: Numbers | None = None  # [1/s]
    north_velocity: Numbers | None = None  # [m/s] over ground
    east_velocity: Numbers | None = None  # [m/s] likewise
    wind_speed: Numbers | None = None  # [m/s] as the ship feels it
    wind_from: Numbers | None = None  # [rad] from ahead, positive to starboard
    wind_ahead: Numbers | None = None  # [m/s] as the ship feels it
    wind_starboard: Numbers | None = None  # [m/s] likewise
    roll: Numbers | None = None  # [rad] positive to starboard
    roll_rate: Numbers | None = None  # [rad/s]
    stern: Numbers | None = None  # [rad] planes, positive puts the bow down
    bow: Numbers | None = None  # [rad] planes, positive puts the bow up
    fin_1: Numbers | None = None  # [rad] of an X-tail, below to starboard; all as x_plane_mix
    fin_2: Numbers | None = None  # [rad] above to starboard
    fin_3: Numbers | None = None  # [rad] above to port
    fin_4: Numbers | None = None  # [rad] below to port
    pitch: Numbers | None = None  # [rad] bow up
    pitch_rate: Numbers | None = None  # [rad/s]
    depth: Numbers | None = None  # [m] of the boat's origin
    command_speed: Numbers | None = None  # [m/s] that the revolutions stand for
    ground_speed: Numbers | None = None  # [m/s] ahead, over ground
    rows: NDArray[np.int64]
    names: Mapping[str, str]
    findings: tuple[Finding, ...] = ()
    plain: Mapping[str, Numbers] = field(default_factory=dict)  # columns of a user's own system
    driving: tuple[str, ...] = ()  # of them, those that act
    between_readings: str = "step"
    units: Mapping[str, str] = field(default_factory=dict)  # that the source's numbers are in
    evidence: tuple[Ratio, ...] = ()  # what the channels say of each other

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channels that were recorded."""
        return tuple(name for name in CHANNEL_UNITS if getattr(self, name) is not None)

    @property
    def values(self) -> dict[str, Numbers]:
        """Return all columns by channel, those of a user's own system too."""
        pairs = ((item.name, getattr(self, item.name)) for item in fields(self))
        columns = {name: one for name, one in pairs if isinstance(one, np.ndarray)}
        return {**{k: v for k, v in columns.items() if k not in ("t", "rows")}, **self.plain}

    def with_values(self, columns: Mapping[str, Numbers]) -> "Record":
        """Return the record with other numbers in its columns."""
        plain = {name: columns[name] for name in self.plain}
        named: dict[str, Any] = {k: v for k, v in columns.items() if k not in plain}
        return replace(self, plain=plain, **named)

    @property
    def interval(self) -> float:
        """Return the usual time [s] from reading to reading of what was read most often."""
        known = [np.isfinite(values) for values in self.values.values()]
        if not known or any(map(np.all, known)):
            return float(np.median(np.diff(self.t)))
        own = [float(np.median(np.diff(self.t[one]))) for one in known if one.sum() > 1]
        return min(own, default=float(np.median(np.diff(self.t))))

    def column(self, channel: str) -> Numbers:
        """Return a channel; ConfigError if it was not recorded."""
        values: Numbers | None = self.plain.get(channel, getattr(self, channel, None))
        if values is None:
            has = ", ".join(self.channels) or "nothing"
            raise ConfigError(f"{self.source}: no {channel} was recorded; there is {has}")
        return values

    @property
    def turning(self) -> Numbers | None:
        """Return the yaw rate [rad/s], that of the heading if no rate was recorded."""
        if self.yaw_rate is not None or self.heading is None:
            return self.yaw_rate
        change = np.diff(np.unwrap(np.nan_to_num(self.heading))) / np.diff(self.t)
        change[np.isnan(np.diff(self.heading))] = np.nan
        return np.append(change, change[-1])

    def name(self, channel: str) -> str:
        """Return the source's word for a channel."""
        return self.names.get(channel, channel)

    def row(self, index: int) -> int:
        """Return the row of a sample in its source, counted from 1."""
        return int(self.rows[index])

    def finding(self, channel: str, text: str, index: int | np.integer | None = None) -> Finding:
        """Return a finding about a channel: at the sample of an index, or all."""
        return Finding(self.name(channel), 0 if index is None else self.row(int(index)), text)

    def part(self, indices: Any) -> "Record":
        """Return the samples at ``indices``, a slice or a mask."""
        columns = {name: values[indices] for name, values in self.values.items()}
        return replace(self, t=self.t[indices], rows=self.rows[indices]).with_values(columns)

    def between(self, begin: float, end: float, least: int = 2) -> "Record":
        """Return the samples from ``begin`` to ``end`` [s]; ConfigError if fewer than ``least``."""
        inside = (self.t >= begin) & (self.t <= end)
        if np.count_nonzero(inside) < least:
            raise ConfigError(
                f"{self.source}: fewer than {least} rows from {begin:g} s to {end:g} s; "
                f"it has {self.t[0]:g} s to {self.t[-1]:g} s"
            )
        return self.part(inside)

    def every(self, count: int) -> "Record":
        """Return each ``count``-th sample, the rudder as its mean until the next one.

        The mean keeps the effect of a rudder that moved between the samples taken, and stands from
        each to the next. Other inputs are averaged too.
        """
        if count == 1:
            return self
        thin = self.part(slice(None, None, count))
        starts = np.arange(0, len(self.t), count)
        sizes = np.diff([*starts, len(self.t)])
        held = {name: self.mean_ahead(self.plain[name]) for name in self.driving}
        held = {name: np.add.reduceat(one, starts) / sizes for name, one in held.items()}
        thin = replace(thin, plain={**thin.plain, **held}, between_readings="step")
        if self.rudder is None:
            return thin
        return replace(thin, rudder=np.add.reduceat(self.mean_ahead(self.rudder), starts) / sizes)

    def mean_ahead(self, acting: Numbers) -> Numbers:
        """Return the mean of an input (n,) from each sample to the next."""
        begin, slope = lines_between(self.t, acting[:, None], self.between_readings)
        return np.asarray(begin + 0.5 * slope * np.diff(self.t, append=self.t[-1])[:, None])[:, 0]


def unwrap_angle(angle: Numbers) -> Numbers:
    """Return an angle [rad] that does not jump by whole turns; NaN stays."""
    unwrapped_angle, known = angle.copy(), ~np.isnan(angle)
    unwrapped_angle[known] = np.unwrap(unwrapped_angle[known])
    return unwrapped_angle


def lines_between(t: Numbers, inputs: Numbers, between_readings: str) -> tuple[Numbers, Numbers]:
    """Return where inputs (n, u) begin at each time ``t`` (n,), and their slopes.

    Straight inputs go from each reading to the next. A rudder that begins or ends its way between
    two readings goes round a corner there, where its lines before and after meet: the straight line
    is moved so that its mean is that of the corner. Steps have no rise, as have the last inputs.
    """
    slope, corner = np.zeros_like(inputs), np.zeros_like(inputs)
    if between_readings == "straight":
        interval = np.diff(t)[:, None]
        slope[:-1] = np.diff(inputs, axis=0) / interval
        before, own, after = slope[:-3], slope[1:-2], slope[2:-1]
        small, large = np.sort(np.abs(np.stack([before, after])), axis=0)
        bends = (small < STANDING_SHARE * large) & ((own - before) * (after - own) > 0.0)
        depth = (before - own) * (after - own) / np.where(bends, after - before, 1.0)
        corner[1:-2] = np.where(bends, 0.5 * interval[1:-1] * depth, 0.0)
    return inputs + corner, slope


def check_count(record: Record, samples: int, coefficients: int) -> None:
    """Check that there are enough samples to a coefficient; ConfigError with both counts."""
    if samples < MIN_SAMPLES_EACH * coefficients:
        raise ConfigError(
            f"{record.source}: {samples} samples for {coefficients} coefficients: needs "
            f"{MIN_SAMPLES_EACH} to each, {MIN_SAMPLES_EACH * coefficients}: record longer, "
            "take more of the rows "
            '(every, from_s, to_s), fit a simpler model, or fix some, free = "no"'
        )


@dataclass(frozen=True)
class Samples:
    """Readings and inputs at each time; NaN is a missing reading.

    ``inputs[k]`` acts from ``t[k]`` to ``t[k+1]``, or if ``between_readings`` is "straight" the
    inputs go straight from each to the next. Before the first sample the input is taken to be the
    first one.
    """

    t: Numbers  # (n,) [s] rising
    outputs: Numbers  # (n, y)
    inputs: Numbers  # (n, u)
    between_readings: str = "step"

    @cached_property
    def steps(self) -> tuple[Numbers, Indices]:
        """Return the different intervals (m,) [s] and which of them follows each sample (n,).

        After the last sample comes an interval like the one before it.
        """
        if len(self.t) < 2:
            raise ConfigError("a record of fewer than two samples has no interval")
        gaps = np.diff(self.t)
        usual = float(np.median(gaps))
        intervals, which = np.unique(np.round(gaps / usual, 9), return_inverse=True)
        return intervals * usual, np.append(which, which[-1]).astype(np.int64)

    @cached_property
    def table(self) -> Numbers:
        """Return readings, inputs of the sample before, inputs (n, y+2u).

        Of straight inputs it is readings, inputs, slopes before and after the sample (n, y+3u).
        """
        acting = self.inputs
        before = np.vstack([acting[:1], acting[:-1]])
        parts = [before, acting]
        if self.between_readings == "straight":
            begin, after = lines_between(self.t, acting, self.between_readings)
            parts = [begin, np.vstack([np.zeros_like(after[:1]), after[:-1]]), after]
        return np.ascontiguousarray(np.hstack([self.outputs, *parts]))

    @property
    def counted(self) -> int:
        """Return how many samples have a reading."""
        return int(np.count_nonzero(~np.all(np.isnan(self.outputs), axis=1)))

    @property
    def whole(self) -> bool:
        """Return whether no reading is missing."""
        return not np.isnan(self.outputs).any()

    def without(self, excluded: NDArray[np.bool_]) -> "Samples":
        """Return the samples with the readings of some (n,), or single readings (n, y), missing."""
        outputs = self.outputs.copy()
        outputs[excluded] = np.nan
        return replace(self, outputs=outputs)


def samples_of(
    record: Record, outputs: tuple[str, ...], inputs: tuple[str, ...] = ("rudder",)
) -> Samples:
    """Return channels of a record and its rudder, or other inputs, in the models' units."""
    count = len(record.t)
    columns = [[_in_units(record, name) for name in names] for names in (outputs, inputs)]
    parts = [np.column_stack(one) if one else np.empty((count, 0)) for one in columns]
    return Samples(record.t, parts[0], parts[1], record.between_readings)


def _in_units(record: Record, channel: str) -> Numbers:
    """Return a channel in the models' unit, another column as it stands."""
    values = record.column(channel)
    if channel in record.plain:
        return values
    return values / DEGREE if channel == "rudder" else values * OUTPUT_UNITS[channel][1]
