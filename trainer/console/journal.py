"""The entries of a screen's log, and the samples of its strip charts.

``model`` keeps them, and drawings read them. A screen keeps its own copy of both, so that it can
scroll back without asking the session.
"""

import bisect
import math
import re
import textwrap
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.io.orders.grammar import name_of
from trainer.io.orders.sentences import Sentence

MAX_ENTRIES: Final = 1000  # the latest
MERGE_TIME_S: Final = 5.0  # [s] of the boat's time, within which presses of a control are one entry
FIGURE_PATTERN: Final = re.compile(r" [\d.]+")  # what differs between presses
# by kind: the sign before the text, and the ink
KIND_SIGNS: Final = {
    "sent": (">", "value"),
    "answer": (" ", "plain"),
    "refused": ("?", "warning"),
    "watch": ("!", "alarm"),
    "pilot": ("!", "warning"),
    "depth": ("!", "alarm"),
    "trouble": ("!", "alarm"),
    "lost": ("!", "alarm"),
    "moment": ("<", "title"),
    "time": ("=", "plain"),
    "mark": ("*", "good"),
    "order": ("-", "plain"),
    "crew": ("o", "ordered"),
    "shown": ("~", "good"),
    "exercise": ("-", "ordered"),
    "station": ("-", "dim"),
    "briefing": (" ", "plain"),
}
OTHER_SIGN: Final = ("-", "plain")
MAX_TRACE_TICKS: Final = 4800  # ticks: 40 minutes at half a second


class JournalEntry(NamedTuple):
    """One line of the log: an order, an answer or an event."""

    seconds: float | None  # None: at no time of the boat's
    kind: str
    text: str


class TimelineMoment(NamedTuple):
    """Something on the time line."""

    seconds: float  # of the boat's time
    sign: str  # the letter that it has there
    text: str


def plan_of(subject: str) -> list[TimelineMoment]:
    """Return a planned order for the time line, none where its time is not known."""
    _, when, text = (*subject.split(",", 2), "", "")[:3]
    try:
        seconds = float(when)
    except ValueError:
        return []
    sign = "c" if name_of(text) == "casualty" else "o"
    return [TimelineMoment(seconds, sign, text)] if math.isfinite(seconds) else []


def entry_of(event: Sentence) -> JournalEntry:
    """Return an event as an entry of the journal."""
    _, seconds, kind, text = event.fields
    return JournalEntry(float(seconds), kind, text)


@dataclass
class Journal:
    """The entries, oldest first, and how far back the screen looks."""

    entries: deque[JournalEntry] = field(default_factory=lambda: deque(maxlen=MAX_ENTRIES))
    changes: int = 0
    back: int = 0  # lines

    def add(self, seconds: float | None, kind: str, text: str) -> None:
        """Enter something, and show the end of the journal.

        Several presses of one control are one entry, that of the last.
        """
        new = JournalEntry(seconds, kind, text)
        if self.entries and follows(self.entries[-1], new):
            self.entries.pop()
        self.entries.append(new)
        self.changes += 1
        self.back = 0

    def recall(self, entries: Sequence[JournalEntry]) -> None:
        """Put earlier entries before the present ones, without those that are there already."""
        known = set(self.entries)
        missed = [entry for entry in entries if entry not in known]
        self.entries.extendleft(reversed(missed[-(MAX_ENTRIES - len(self.entries)) :]))
        self.changes += 1

    def look_back(self, lines: int) -> None:
        """Look further back, or less far."""
        self.back = max(self.back + lines, 0)
        self.changes += 1


def follows(last: JournalEntry, new: JournalEntry) -> bool:
    """Return whether an order moves the control that the last order moved a moment ago."""
    if last.kind != "order" or new.kind != "order" or last.seconds is None or new.seconds is None:
        return False
    # the same words before the figure: the same control; without any figure it is no such order
    alike = FIGURE_PATTERN.split(last.text)[0] == FIGURE_PATTERN.split(new.text)[0] != new.text
    return alike and 0.0 <= new.seconds - last.seconds <= MERGE_TIME_S


def clock(seconds: float) -> str:
    """Return a time as HH:MM:SS."""
    whole = int(max(seconds, 0.0))
    return f"{whole // 3600:02}:{whole // 60 % 60:02}:{whole % 60:02}"


def wrap_entry(entry: JournalEntry, width: int) -> list[tuple[str, str, str]]:
    """Return an entry in lines of a time, a text and an ink."""
    sign, ink = KIND_SIGNS.get(entry.kind, OTHER_SIGN)
    when = " " * 8 if entry.seconds is None else clock(entry.seconds)
    room = max(width - len(when) - 5, 8)
    texts = textwrap.wrap(entry.text, room) or [""]
    first, *rest = texts
    return [(when, f"{sign} {first}", ink), *((" " * 8, f"  {text}", ink) for text in rest)]


class Sample(NamedTuple):
    """A quantity at one time; None where nothing is ordered, or the boat lacks it."""

    actual: float | None
    ordered: float | None
    ghost: float | None = None  # of the reference crew's run


@dataclass
class Trace:
    """Samples of some quantities, by time."""

    quantities: int
    times: list[float] = field(default_factory=list)  # [s]
    samples: list[Sequence[Sample]] = field(default_factory=list)

    def add(self, seconds: float, samples: Sequence[Sample]) -> None:
        """Add the samples of a time. Later ones are dropped, because time has gone back."""
        place = bisect.bisect_left(self.times, seconds)
        del self.times[place:], self.samples[place:]
        self.times.append(seconds)
        self.samples.append(tuple(samples))
        # a quarter more may gather, so that the lists are not cut at every tick
        if len(self.times) > MAX_TRACE_TICKS + MAX_TRACE_TICKS // 4:
            del self.times[:-MAX_TRACE_TICKS], self.samples[:-MAX_TRACE_TICKS]

    def recall(self, rows: Sequence[tuple[float, Sequence[Sample]]]) -> None:
        """Put samples of earlier times among the present ones, which stay."""
        traced = dict(zip(self.times, self.samples, strict=True))
        latest = self.times[-1] if self.times else math.inf
        whole = {seconds: samples for seconds, samples in rows if seconds < latest} | traced
        self.times = sorted(whole)[-MAX_TRACE_TICKS:]
        self.samples = [whole[seconds] for seconds in self.times]

    def recall_ghost(self, rows: Sequence[tuple[float, Sequence[float | None]]]) -> None:
        """Put the ghost's values of earlier times beside the samples."""
        times = [seconds for seconds, _ in rows]
        for place, (seconds, samples) in enumerate(zip(self.times, self.samples, strict=True)):
            row = bisect.bisect_right(times, seconds) - 1
            if row >= 0 and samples and samples[0].ghost is None:
                pairs = zip(samples, rows[row][1], strict=True)
                self.samples[place] = tuple(each._replace(ghost=value) for each, value in pairs)

    def series(self, quantity: int, span: float, columns: int) -> list[Sample | None]:
        """Return a quantity at times over the last ``span`` [s], None before the first."""
        if not self.times:
            return [None] * columns
        end, values = self.times[-1], []
        for column in range(columns):
            when = end - span * (columns - 1 - column) / max(columns - 1, 1)
            place = bisect.bisect_right(self.times, when + 1e-9) - 1
            values.append(self.samples[place][quantity] if place >= 0 else None)
        return values
