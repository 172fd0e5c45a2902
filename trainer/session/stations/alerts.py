"""The alerts of a session: each lasts as long as its condition, and until seen.

The states are those of IMO MSC.302(87), as two open projects have IEC 62923-1 (OpenBridge, Signal
K); the standard itself was not read. ``event_log`` raises alerts and tells of them; the session
says after each tick what holds still. An alert of one's own condition is raised anew where that
becomes worse: the one before is over then.

All that becomes of an alert is a note. A recording keeps the notes, so that a jump in time, a run
that goes on, and a debrief have the alerts as they were.
"""

import json
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Final, NamedTuple

from trainer.boat.calls import MonitorCall, Rank
from trainer.config.files import ConfigError
from trainer.io.recording.facts import NOTE_KIND
from trainer.io.recording.recording import RecordedEvent
from trainer.io.status_line import clock

MAX_OPEN_ALERTS: Final = 100  # alerts at most that hold, or wait to be seen
MAX_PAST_ALERTS: Final = 200  # of those that are over and seen, the latest
MAX_KEPT_NOTES: Final = 5000  # of all branches, the latest
REMARK_S: Final = 60.0  # [s] that an alert without a condition of its own stands
RANKS: Final = tuple(Rank)  # the most urgent first
SEEN_RANKS: Final = (Rank.ALARM, Rank.WARNING)  # that somebody has to acknowledge


class AlertState(Enum):
    """What is to be done about an alert. The value is the word that programs get."""

    ACTIVE = "active"  # it holds, and nobody has acknowledged it
    SILENCED = "silenced"  # the same, without its sound for a while
    ACKNOWLEDGED = "acknowledged"  # it holds
    RECTIFIED = "rectified"  # it is over, and nobody has acknowledged it
    NORMAL = "normal"  # it is over


class Instant(NamedTuple):
    """A moment of the run, on its branch."""

    branch: int
    tick: int
    seconds: float


@dataclass(frozen=True)
class Alert:
    """One alert, and what has become of it."""

    number: int
    key: str  # of its condition, "" where it has none
    kind: str  # of the events that tell of it
    rank: Rank
    text: str
    raised: Instant
    seen: Instant | None = None
    seen_by: str = ""  # a role
    over: Instant | None = None
    silenced: tuple[tuple[str, Instant], ...] = ()  # at which role, and when

    @property
    def owed(self) -> bool:
        """Return whether somebody still has to acknowledge it."""
        return self.rank in SEEN_RANKS and self.seen is None

    @property
    def settled_kind(self) -> str:
        """Return the kind of events of its end, which the same roles hear."""
        return "exercise" if self.kind == "watch" else "alert"

    @property
    def calls(self) -> bool:
        """Return whether it sounds until it is silenced, seen or over."""
        return self.over is None and (self.owed or self.rank is Rank.EMERGENCY)

    @property
    def words(self) -> str:
        """Return its text without the tick at which it was raised."""
        return self.text.partition(" s): ")[2] or self.text

    @property
    def place(self) -> tuple[bool, int, int]:
        """Return its place in the list: what is owed first, then rank, then the newest."""
        return not (self.owed or self.calls), RANKS.index(self.rank), -self.number

    def account(self, *, silent: bool) -> str:
        """Return it in a line, with what has become of it and when."""
        line = f"{self.number} {self.rank.value} at {clock(self.raised.seconds)}, "
        line += f"{self.state(silent=silent).value}: {self.words}"
        if self.seen and self.seen_by:
            after = self.seen.seconds - self.raised.seconds
            line += f"; acknowledged by {self.seen_by} after {after:g} s"
        return line + (f"; over at {clock(self.over.seconds)}" if self.over else "")

    def state(self, *, silent: bool) -> AlertState:
        """Return its state where it is ``silent``, or not."""
        if self.over is not None:
            return AlertState.RECTIFIED if self.owed else AlertState.NORMAL
        if not self.calls and self.rank is not Rank.CAUTION:
            return AlertState.ACKNOWLEDGED
        return AlertState.SILENCED if self.calls and silent else AlertState.ACTIVE


class AlertStep(Enum):
    """What becomes of an alert. The values stand in recordings."""

    RAISED = "raised"
    SILENCED = "silenced"
    SEEN = "seen"
    OVER = "over"
    REPLACED = "replaced"  # by a new one of the same condition


class AlertNote(NamedTuple):
    """A step of an alert; only the first has its kind, rank, key and text."""

    step: AlertStep
    number: int
    when: Instant
    by: str = ""  # a role
    alert: tuple[str, str, str, str] = ("", "", "", "")  # kind, rank, key, text

    @property
    def line(self) -> str:
        """Return it as a recording has it."""
        named = self.alert if self.step is AlertStep.RAISED else ()
        return json.dumps([self.step.value, self.number, *named])

    @classmethod
    def of(cls, event: RecordedEvent, step_s: float) -> "AlertNote":
        """Return a recorded note; ConfigError if it is damaged."""
        when = Instant(event.branch, event.tick, event.tick * step_s)
        try:
            step, number, *alert = json.loads(event.text)
            note = cls(AlertStep(step), int(number), when, event.role)
            if note.step is not AlertStep.RAISED:
                return note
            kind, rank, key, text = map(str, alert)
            return note._replace(alert=(kind, Rank(rank).value, key, text))
        except (ValueError, TypeError, RecursionError):
            raise ConfigError(f"recording: {NOTE_KIND} at tick {event.tick}: damaged") from None


def recorded_alerts(notes: Iterable[AlertNote]) -> list[Alert]:
    """Return what became of each alert, by the notes of a run."""
    book = AlertBook(past=deque(), notes=deque(notes))
    book.follow(lambda _: True)
    return book.all


@dataclass
class AlertBook:
    """The open alerts of a run, the last of the others, and their notes."""

    open: dict[int, Alert] = field(default_factory=dict)  # by their numbers
    past: deque[Alert] = field(default_factory=lambda: deque(maxlen=MAX_PAST_ALERTS))
    number: int = 0  # of the last
    notes: deque[AlertNote] = field(default_factory=lambda: deque(maxlen=MAX_KEPT_NOTES))
    keep: Callable[[AlertNote], object] = lambda _: None  # a note of now, for good

    @property
    def listed(self) -> list[Alert]:
        """Return the open ones in the order of the list."""
        return sorted(self.open.values(), key=lambda alert: alert.place)

    @property
    def keys(self) -> set[str]:
        """Return the conditions that hold."""
        return {alert.key for alert in self.open.values() if alert.over is None}

    def add(self, kind: str, call: MonitorCall, now: Instant) -> Alert:
        """Return a new alert, with the next number."""
        named = kind, call.rank.value, call.key, call.text
        return self._write(AlertNote(AlertStep.RAISED, self.number + 1, now, "", named))

    def supersede(self, key: str, now: Instant) -> Iterator[Alert]:
        """Yield what a new alert of a condition replaces: it is owed no more."""
        for alert in [each for each in self.open.values() if key and each.key == key]:
            yield self._write(AlertNote(AlertStep.REPLACED, alert.number, now))

    def see(self, alert: Alert, by: str, now: Instant) -> Alert:
        """Return an alert acknowledged by a role."""
        return self._write(AlertNote(AlertStep.SEEN, alert.number, now, by))

    def silence(self, alert: Alert, by: str, now: Instant) -> Alert:
        """Return an alert silenced at a role."""
        return self._write(AlertNote(AlertStep.SILENCED, alert.number, now, by))

    def end(self, holding: Collection[str], now: Instant, remark_ticks: int) -> Iterator[Alert]:
        """Yield each alert that is over now, by the conditions that hold."""
        for alert in list(self.open.values()):
            stands = now.tick - alert.raised.tick < remark_ticks
            if alert.over is None and not (alert.key in holding if alert.key else stands):
                yield self._write(AlertNote(AlertStep.OVER, alert.number, now))

    def noted(self, kind: str, call: MonitorCall, now: Instant) -> Alert | None:
        """Return the alert that came at this tick by the notes, None if none did."""
        alike = (each for each in self.all if (each.raised.tick, each.kind) == (now.tick, kind))
        return next(
            (each for each in alike if (each.key, each.text) == (call.key, call.text)), None
        )

    def recall(self, notes: Iterable[AlertNote]) -> None:
        """Take the notes of an earlier process; ``follow`` makes alerts of them."""
        self.notes.extend(notes)
        self.number = max((each.number for each in self.notes), default=0)

    def follow(self, stands: Callable[[Instant], bool]) -> None:
        """Take all to a moment: only those notes ``stand`` that lead to it."""
        self.open.clear()
        self.past.clear()
        for note in self.notes:
            known = note.step is AlertStep.RAISED or note.number in self.open
            if known and stands(note.when):
                self._take(note)

    @property
    def all(self) -> list[Alert]:
        """Return all alerts that are kept, as they came."""
        return sorted([*self.past, *self.open.values()], key=lambda alert: alert.number)

    def _write(self, note: AlertNote) -> Alert:
        """Have a note of now kept; return the alert that it makes, or changes."""
        self.keep(note)
        self.number = max(self.number, note.number)
        return self._take(note)

    def _take(self, note: AlertNote) -> Alert:
        """Return an alert after a step of it. It is open for as long as it holds, or is owed."""
        now = note.when
        if note.step is AlertStep.RAISED:
            kind, rank, key, text = note.alert
            alert = Alert(note.number, key, kind, Rank(rank), text, now)
        else:
            alert = self.open[note.number]
        match note.step:
            case AlertStep.SEEN:
                alert = replace(alert, seen=now, seen_by=note.by)
            case AlertStep.SILENCED:
                alert = replace(alert, silenced=(*alert.silenced, (note.by, now)))
            case AlertStep.OVER:
                alert = replace(alert, over=now)
            case AlertStep.REPLACED:
                alert = replace(alert, over=alert.over or now, seen=alert.seen or now)
        if alert.over is not None and not alert.owed:
            self.open.pop(alert.number, None)
            self.past.append(alert)
            return alert
        self.open[alert.number] = alert
        while len(self.open) > MAX_OPEN_ALERTS:
            self.past.append(self.open.pop(min(self.open)))
        return alert
