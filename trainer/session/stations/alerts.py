"""The alerts of a session: each lasts as long as its condition, and until seen.

The states are those of IMO MSC.302(87), as two open projects have IEC 62923-1 (OpenBridge, Signal
K); the standard itself was not read. ``event_log`` raises alerts and tells of them; the session
says after each tick what holds still. An alert of one's own condition is raised anew where that
becomes worse: the one before is over then.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Final, NamedTuple

from trainer.boat.calls import MonitorCall, Rank
from trainer.io.status_line import clock

MAX_OPEN_ALERTS: Final = 100  # alerts at most that hold, or wait to be seen
MAX_PAST_ALERTS: Final = 200  # of those that are over and seen, the latest
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


@dataclass
class AlertBook:
    """All alerts of a run that are open, and the last of the others."""

    open: dict[int, Alert] = field(default_factory=dict)  # by their numbers
    past: deque[Alert] = field(default_factory=lambda: deque(maxlen=MAX_PAST_ALERTS))
    number: int = 0  # of the last

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
        self.number += 1
        alert = Alert(self.number, call.key, kind, call.rank, call.text, now)
        self.open[self.number] = alert
        while len(self.open) > MAX_OPEN_ALERTS:
            self._put_away(self.open[min(self.open)])
        return alert

    def supersede(self, key: str, now: Instant) -> Iterator[Alert]:
        """Yield what a new alert of a condition replaces: it is owed no more."""
        for alert in [each for each in self.open.values() if key and each.key == key]:
            yield self._put_away(replace(alert, over=alert.over or now, seen=alert.seen or now))

    def see(self, alert: Alert, by: str, now: Instant) -> Alert:
        """Return an alert acknowledged by a role."""
        return self._keep(replace(alert, seen=now, seen_by=by))

    def end(self, holding: Collection[str], now: Instant, remark_ticks: int) -> Iterator[Alert]:
        """Yield each alert that is over now, by the conditions that hold."""
        for alert in list(self.open.values()):
            stands = now.tick - alert.raised.tick < remark_ticks
            if alert.over is None and not (alert.key in holding if alert.key else stands):
                yield self._keep(replace(alert, over=now))

    def follow(self, stands: Callable[[Instant], bool]) -> None:
        """Take all back to a moment: only those instants ``stand`` that lead to it."""
        alerts = [*self.past, *self.open.values()]
        self.open.clear()
        self.past.clear()
        for alert in alerts:
            if stands(alert.raised):
                seen, over = (
                    when if when and stands(when) else None for when in (alert.seen, alert.over)
                )
                self._keep(replace(alert, seen=seen, over=over))

    def _keep(self, alert: Alert) -> Alert:
        """Keep an alert among the open ones for as long as it is."""
        if alert.over is not None and not alert.owed:
            return self._put_away(alert)
        self.open[alert.number] = alert
        return alert

    def _put_away(self, alert: Alert) -> Alert:
        self.open.pop(alert.number, None)
        self.past.append(alert)
        return alert
