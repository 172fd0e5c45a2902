"""The past of a session before a screen came, or while its line was lost.

The screen asks for it by the order ``history``, so that its charts and its log do not begin empty.
The answer comes between two marks, among the present values.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.console.readings import ChannelReading
from trainer.io.orders.sentences import Sentence

EVENTS_CHANNEL: Final = "events"
PAST_FACT: Final = "past"  # which marks where the past of a channel begins or ends
# [s] of the boat's time; a screen that missed less does not ask for its past
LATE_TIME_S: Final = 15.0
Rows = dict[str, dict[float, ChannelReading]]  # by channel and time [s]


@dataclass
class PastAnswers:
    """The rows and events that have come in answer to the screen's questions."""

    wanted: set[str] = field(default_factory=set)  # channels that have not come to their end
    rows: Rows = field(default_factory=dict)
    events: list[Sentence] = field(default_factory=list)
    _open: set[str] = field(default_factory=set)

    def ask(self, channels: Iterable[str], send: Callable[[str], bool]) -> None:
        """Ask for the past of channels, and of what happened."""
        self.rows.clear()
        self.events.clear()
        self._open.clear()
        self.wanted = {*channels, EVENTS_CHANNEL}
        for channel in sorted(self.wanted):
            send(f"history {channel}")

    def mark(self, subject: str) -> str:
        """Take a mark where the past of a channel begins or ends. Return a channel that ended."""
        which, _, channel = subject.partition(",")
        if which == "begin":
            self._open.add(channel)
            return ""
        self._open.discard(channel)
        self.wanted.discard(channel)
        return channel

    def takes(self, sentence: Sentence, names: Sequence[str]) -> bool:
        """Take a sentence if it is of the past; return whether it was."""
        if sentence.kind == "TRS" and sentence.fields[0] in self._open:
            channel, tick, seconds, *values = sentence.fields
            reading = ChannelReading(
                int(tick), float(seconds), 0.0, dict(zip(names, values, strict=False))
            )
            self.rows.setdefault(channel, {})[reading.seconds] = reading
            return True
        happened = sentence.kind in ("TRE", "TRF") and sentence.fields[2] != PAST_FACT
        if happened and EVENTS_CHANNEL in self._open:
            self.events.append(sentence)
            return True
        return False

    def number(self, seconds: float, channel: str, name: str) -> float | None:
        """Return the value of a field at a time [s], None before its first."""
        reading = self.rows.get(channel, {}).get(seconds)
        return reading.number(name) if reading else None
