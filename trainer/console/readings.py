"""The latest values of the channels, and their past before this screen came.

``model`` keeps them, and drawings read them. A value with a rate is extrapolated from its tick, no
further than the next one. A value without is interpolated from the last reading but one to the
last, and so shows the boat one tick late.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from trainer.io.orders.sentences import Sentence

# the field of a channel's rate [unit/s], by that of the value
RATE_FIELDS: Final = {
    "depth": "depth_rate",
    "heading": "turn_rate",
    "speed": "speed_rate",
    "pitch": "pitch_rate",
    "heel": "heel_rate",
}
CIRCULAR_FIELDS: Final = frozenset({"heading"})  # [deg] 360 is 0
MAX_NUMBER: Final = 1e9  # of a number, in any unit
MAX_INTERVAL_S: Final = 1.0  # [s] between readings; later ones are shown at once


@dataclass(frozen=True)
class ChannelReading:
    """A channel at one tick."""

    tick: int
    seconds: float
    arrived: float  # [s] on the console's clock
    values: dict[str, str]

    def number(self, name: str) -> float | None:
        """Return a value as a number, None for a text or an absurd number."""
        try:
            value = float(self.values.get(name, ""))
        except ValueError:
            return None
        return value if abs(value) <= MAX_NUMBER else None


NO_READING: Final = ChannelReading(0, 0.0, -math.inf, {})


@dataclass
class ChannelReadings:
    """The messages of the session for each channel, by its name."""

    names: dict[str, list[str]] = field(default_factory=dict)
    last: dict[str, ChannelReading] = field(default_factory=dict)
    before: dict[str, ChannelReading] = field(default_factory=dict)
    changes: int = 0  # grows with everything that has come

    def take(self, sentence: Sentence, now: float) -> str:
        """Take names or values; return the channel whose values they are, "" for names."""
        channel, *rest = sentence.fields
        self.changes += 1
        if sentence.kind == "TRN":
            self.names[channel] = [each.partition(":")[0] for each in rest]
            return ""
        values = dict(zip(self.names.get(channel, ()), rest[2:], strict=False))
        self.before[channel] = self.last.get(channel, NO_READING)
        self.last[channel] = ChannelReading(int(rest[0]), float(rest[1]), now, values)
        return channel

    def forget(self) -> None:
        """Forget all readings, because the line is lost and they are old."""
        self.before.clear()
        self.changes += 1

    def reading(self, channel: str) -> ChannelReading:
        """Return the latest of a channel, an empty one where nothing has come."""
        return self.last.get(channel, NO_READING)

    def number(self, channel: str, name: str) -> float | None:
        """Return a value, None where there is none."""
        return self.reading(channel).number(name)

    def word(self, channel: str, name: str) -> str:
        """Return a value as it is written, "" where there is none."""
        return self.reading(channel).values.get(name, "")

    def rows(self, channel: str, prefix: str) -> Iterator[str]:
        """Yield the fields of a channel that begin so and hold something."""
        values = self.reading(channel).values
        return (name for name in values if name.startswith(prefix) and values[name])

    @property
    def seconds(self) -> float:
        """Return the time [s] of the latest tick."""
        return self.reading("time").seconds

    @property
    def frozen(self) -> bool:
        """Return whether time stands still."""
        return self.word("time", "time") == "frozen"

    @property
    def pace(self) -> float:
        """Return the speed of time over the clock's. 0: as fast as it can."""
        return self.number("time", "speed") or 0.0

    def smooth(self, channel: str, name: str, now: float) -> float | None:
        """Return where a value is at a moment [s] of the console's clock."""
        last = self.reading(channel)
        value = last.number(name)
        if value is None or self.frozen:
            return value
        rate = last.number(RATE_FIELDS.get(name, ""))
        if rate is not None:
            return self._wrapped(name, value + rate * self._since(last, now))
        # where a value is on its way from the reading before to the last one
        last, before = self.reading(channel), self.before.get(channel, NO_READING)
        start, took = before.number(name), last.arrived - before.arrived
        if start is None or not 0.0 < took < MAX_INTERVAL_S or before.tick >= last.tick:
            return value
        way = value - start
        if name in CIRCULAR_FIELDS:
            way = (way + 180.0) % 360.0 - 180.0
        return self._wrapped(name, start + way * min(max(now - last.arrived, 0.0) / took, 1.0))

    def _since(self, last: ChannelReading, now: float) -> float:
        """Return the time [s] of the boat since a reading, at most a tick's."""
        step = last.seconds / last.tick if last.tick else 0.0
        return min(max(now - last.arrived, 0.0) * self.pace, step)

    def _wrapped(self, name: str, value: float) -> float:
        return value % 360.0 if name in CIRCULAR_FIELDS else value
