"""The entries of a screen's log, and the moments of its time line.

``model`` keeps them, and drawings read them. A screen keeps its own copy of both, so that it can
scroll back without asking the session.
"""

import contextlib
import math
import re
import textwrap
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Final, NamedTuple

from trainer.config.exercise.outcome import Outcome
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
    "plant": ("!", "alarm"),
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


def entry_of(event: Sentence) -> JournalEntry:
    """Return an event as an entry of the journal."""
    _, seconds, kind, text = event.fields
    return JournalEntry(float(seconds), kind, text)


class AttainablePoint(NamedTuple):
    """What a careful crew could still earn at a moment."""

    seconds: float
    marks: float  # [%]
    so_far: float  # [%] of a run that ended there
    outcome: Outcome  # WON, LOST or OPEN
    beyond: str = ""  # the instructor's order that these marks are not for

    @classmethod
    def of(cls, fields: str) -> "AttainablePoint":
        """Return the point that a fact tells."""
        seconds, marks, so_far, outcome, _, _, *beyond = fields.split(",")
        return cls(float(seconds), float(marks), float(so_far), Outcome(outcome), *beyond[:1])


@dataclass
class Timeline:
    """The moments to return to, the orders planned, the marks still to be had."""

    snapshots: list[TimelineMoment] = field(default_factory=list)
    marks: list[TimelineMoment] = field(default_factory=list)  # remarks, and casualties
    plans: list[TimelineMoment] = field(default_factory=list)  # orders that are to come at a time
    attainable: list[AttainablePoint] = field(default_factory=list)  # for the instructor alone
    unevaluated: str = ""  # why there are none
    furthest: float = 0.0  # [s] that time has reached on this branch
    coming: list[TimelineMoment] = field(default_factory=list)  # snapshots, until all have come

    def take_mark(self, seconds: float, remark: str) -> None:
        """Take a mark."""
        self.marks.append(TimelineMoment(seconds, "M", remark or "marked"))

    def take_casualty(self, seconds: float, words: str) -> None:
        """Take an order by which something breaks."""
        self.marks.append(TimelineMoment(seconds, "C", words))

    def take_plan(self, _seconds: float, subject: str) -> None:
        """Take a planned order, unless its time is not known."""
        _, when, text = (*subject.split(",", 2), "", "")[:3]
        sign = "c" if name_of(text) == "casualty" else "o"
        with contextlib.suppress(ValueError):
            if math.isfinite(seconds := float(when)):
                self.plans.append(TimelineMoment(seconds, sign, text))

    def take_attainable(self, _seconds: float, subject: str) -> None:
        """Take the marks still to be had; there are some again where there were none."""
        self.attainable.append(AttainablePoint.of(subject))
        self.unevaluated = ""

    def take_unevaluated(self, _seconds: float, reason: str) -> None:
        """Take why no marks still to be had are told."""
        self.unevaluated = reason

    def recall(self, facts: Iterable[Sequence[str]]) -> None:
        """Take marks and casualties from before this screen came, in the fields of their facts."""
        for _, seconds, what, subject in facts:
            if what == "mark":
                self.take_mark(float(seconds), subject)
            elif what == "order" and name_of(subject) == "casualty":
                self.take_casualty(float(seconds), subject)
        self.marks = list(dict.fromkeys(self.marks))

    def go_back(self, seconds: float) -> None:
        """Forget what lies after a moment gone back to."""
        self.marks = [each for each in self.marks if each.seconds <= seconds]
        self.attainable = [each for each in self.attainable if each.seconds <= seconds]
        self.furthest = seconds

    def forget(self) -> None:
        """Forget an exercise, because another one begins."""
        self.marks, self.attainable, self.unevaluated, self.furthest = [], [], "", 0.0


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
        self.entries.extendleft(islice(reversed(missed), MAX_ENTRIES - len(self.entries)))
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
