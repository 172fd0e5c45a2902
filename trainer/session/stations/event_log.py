"""The events of a session: each is recorded, sent to stations, and kept for latecomers.

The parts of a session call ``tell`` for what happened, and ``alert`` for what somebody has to
acknowledge. The kind of an event decides which roles hear of it (``stations/roles``). An event has
words for people and, for programs, a fact: no program has to read the words.
"""

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

from trainer.boat.calls import MonitorCall, Rank
from trainer.io.noise_log import CrowdLog
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import TRAINEE
from trainer.io.recording.facts import NOTE_KIND
from trainer.io.recording.recording import Moment, RecordingError
from trainer.io.status_line import clock
from trainer.session.past.history import History
from trainer.session.stations.alert_table import alert_row
from trainer.session.stations.alerts import REMARK_S, Alert, AlertBook, AlertNote, Instant
from trainer.session.stations.own_alerts import SILENCE_S, OwnAlerts
from trainer.session.stations.roles import INSTRUCTOR_ROLE, Role, hears_kind
from trainer.session.stations.station import Fact, News, Saying, Station

MAX_KEPT_EVENTS: Final = 500  # of what has happened, for who comes late
MARK: Final = "mark"  # the kind of a remark that somebody makes by the order ``mark``
CREW_KIND: Final = "crew"  # the kind of orders to the crew, of repeats and of reports
# facts of the crew's talk whose news is of another kind than CREW_KIND
SPOKEN_FACTS: Final = ("wrong-way", "exercise", "report")
MAX_LISTED_ALERTS: Final = 20  # that are over, of the order `alerts`
UNSAFE_TEXT: Final = "should the power go, the last orders would be lost; they act and are recorded"
SAFE_TEXT: Final = "what was ordered is safe should the power go"


class CallCounter(Protocol):
    """A monitor that keeps the times [s] of each of its calls."""

    times: dict[str, list[float]]


@dataclass
class EventLog:
    """The news of one run."""

    history: History
    counters: Sequence[CallCounter] = ()
    stations: list[Station] = field(default_factory=list)
    news: deque[News] = field(default_factory=lambda: deque(maxlen=MAX_KEPT_EVENTS))
    heard: Station | None = None  # who is listened to
    hearers: list[Callable[[News], None]] = field(default_factory=list)  # of all; they never wait
    alerts: AlertBook = field(default_factory=AlertBook)
    own_alerts: OwnAlerts = field(default_factory=OwnAlerts)  # of the pages
    unrecorded: str = ""  # why nothing more is recorded, once that has been announced
    unsafe: bool = False  # it was announced that the disk is behind
    _counts: dict[int, list[dict[str, list[float]]]] = field(default_factory=dict)  # by branch
    _branch: int = field(init=False)  # as it was when last looked at
    strangers: CrowdLog = field(init=False)  # of all who have not said for good who they are

    def __post_init__(self) -> None:
        self._branch = self.history.recording.branch
        self.strangers = CrowdLog(self.tell, time.monotonic)
        self.alerts.keep = self._keep_note

    def tell(
        self,
        kind: str,
        text: str,
        by: Station | None = None,
        fact: Fact | None = None,
        saying: Saying | None = None,
    ) -> None:
        """Record an event, and send it to all whose role hears of it but ``by``.

        ``by`` gets only the fact, because it has the answer to its order.
        """
        boat = self.history.boat
        # A remark may be anybody's, so its text names who made it.
        said = text
        if kind == MARK and by:
            said = f"mark by {self.signature(by)}: {text}"
            saying = Saying(by.role.name, f"mark: {text}")
        branch = self.history.recording.branch
        news = News(self.history.tick, boat.time, kind, said, fact, saying, branch)
        talk = kind == CREW_KIND or (fact is not None and fact.what in SPOKEN_FACTS)
        keeper = self.history.flown.talk if talk else self.history.recording
        keeper.event(news.tick, kind, *((by.who, text, by.role.name) if by else ("", text)))
        for hear in self.hearers:
            hear(news)
        self._spread(news, by)

    def alert(self, kind: str, call: MonitorCall, fact: Fact | None = None) -> None:
        """Raise an alert: news with a number by which it is acknowledged.

        It is kept for as long as its condition holds, or somebody owes it a look.
        """
        self._replay_alerts()
        known = self.alerts.noted(kind, call, self._now) if self.history.flown.replaying else None
        replaced = [] if known else [*self.alerts.supersede(call.key, self._now)]
        for alert in replaced:
            self._tell_state(alert)
        alert = known or self.alerts.add(kind, call, self._now)
        news = self._news_of(alert)._replace(fact=fact, branch=alert.raised.branch)
        self.history.recording.event(news.tick, kind, "", news.text)
        for hear in self.hearers:  # they get it as it is recorded, without the alert's number
            hear(news)
        number = "" if alert.rank is Rank.CAUTION else f" [{alert.number}]"
        self._spread(news._replace(text=f"{news.text}{number}"), None)
        for station in self.stations:
            self._note_alert(station, alert)

    def settle(self, holding: set[str]) -> None:
        """Tell which alerts are over, by the keys of those that hold after a tick."""
        self._replay_alerts()
        remark_ticks = self.history.boat.ticks_in(REMARK_S)
        for alert in [*self.alerts.end(holding, self._now, remark_ticks)]:
            if alert.rank is not Rank.CAUTION:
                self.tell(alert.settled_kind, f"alert {alert.number} over: {alert.words}")
            self._tell_state(alert)

    def take_up(self, holding: set[str]) -> None:
        """Tell programs all alerts of a moment to which nobody has flown.

        What holds there and is not known is raised without news: it has not happened just now.
        """
        for key in sorted(holding - self.alerts.keys):
            row = alert_row(key)
            call = MonitorCall(f"{row.title}: {row.begins}", row.rank, key)
            self.alerts.add(row.kind, call, self._now)
        for station in self.stations:
            self.note_alerts(station)

    def acknowledge(self, order: Order, by: Station) -> Reply:
        """Mark one alert as seen; an instructor may all that are his. Tell the others."""
        heard = {a.number: a for a in self._heard_by(by) if a.owed}
        if order.word == "all" and by.role is not INSTRUCTOR_ROLE and heard:
            each = "; ".join(f"ack {number}" for number in heard)
            return Refused(f"each alert is acknowledged by itself: {each}")
        mine = [n for n, alert in heard.items() if not self._answerers(alert, by)]
        wanted = mine if order.word == "all" else [int(order.value)]
        found = self.alerts.open.get(wanted[0]) if wanted else None
        if found is None or found not in self._heard_by(by) or not (found.owed or found.calls):
            numbers = ", ".join(map(str, heard)) or "none"
            return Refused(f"no such alert is open here; there is {numbers}")
        silence = f"ack silent {wanted[0]}"
        if found.rank is Rank.EMERGENCY:
            return Refused(f"an emergency takes no acknowledgement: {silence}")
        if others := self._answerers(found, by):
            return Refused(f"{' or '.join(others)} acknowledges it; here only {silence}")
        for number in wanted:
            alert = self.alerts.see(heard[number], by.role.name, self._now)
            saying = Saying(by.role.name, f"alert {number} seen: {alert.words}")
            self.tell(alert.settled_kind, ": ".join(saying), by, Fact("ack", str(number)), saying)
            self._tell_state(alert)
        return f"seen: {', '.join(map(str, wanted))}"

    def _heard_by(self, station: Station) -> list[Alert]:
        """Return the open alerts that a station hears of, in the order of the list."""
        return [each for each in self.alerts.listed if hears_kind(station.role, each.kind)]

    def _answerers(self, alert: Alert, station: Station) -> list[str]:
        """Return the roles that acknowledge an alert in place of a station, none if it may."""
        manned = [role for role in alert_row(alert.key).roles if self.attended(role)]
        return [] if station.role.name in (TRAINEE, *manned) else manned

    def account_alerts(self, station: Station) -> list[str]:
        """Return the open alerts in words; to an instructor also the last that are over."""
        role = station.role.name
        lines = [
            alert.account(silent=self.own_alerts.silent_for(str(alert.number), role) > 0.0)
            for alert in self._heard_by(station)
        ]
        past = [*self.alerts.past] if station.role is INSTRUCTOR_ROLE else []
        return lines + [
            alert.account(silent=False) for alert in past[: -MAX_LISTED_ALERTS - 1 : -1]
        ]

    def tell_duties(self) -> None:
        """Tell programs who acknowledges the alerts now, because a station has come or gone."""
        for alert in self.alerts.open.values():
            self._tell_state(alert)

    def silence(self, order: Order, by: Station) -> Reply:
        """Silence an alert, or one of a page's own, at a station for a while."""
        number = int(order.value)
        alert = self.alerts.open.get(number)
        if alert is None or not alert.calls or not hears_kind(by.role, alert.kind):
            return Refused(f"no alert {number} sounds here")
        self.own_alerts.silence(str(number), by.role.name, self.history.tick)
        self._tell_state(self.alerts.silence(alert, by.role.name, self._now))
        return f"alert {number} is silent here for {SILENCE_S:g} s"

    def note_own_alert(self, order: Order, by: Station) -> Reply:
        """Note what a page says of an alert of its own. Tell the other pages of its role."""
        fact = self.own_alerts.note(order, by.role.name, self.history.tick)
        for station in self.stations:
            if station.role is by.role and station is not by:
                self.note(station, [fact])
        return order.text

    def follow(self, moment: Moment) -> None:
        """Forget alerts and counts later than a moment to which time has jumped."""
        self._follow_alerts(moment)
        self.own_alerts.follow(moment)
        left_branch, self._branch = self._branch, self.history.recording.branch
        self._counts[left_branch] = [each.times for each in self.counters]
        begun = self._counts.get(self._parent(), self._counts[left_branch])
        now = self.history.boat.time
        for counter, times in zip(self.counters, begun, strict=True):
            past = {what: [t for t in when if t <= now] for what, when in times.items()}
            counter.times = {what: when for what, when in past.items() if when}
        for station in self.stations:
            if station.role is INSTRUCTOR_ROLE:
                self._note_branches(station)

    def recall_alerts(self) -> None:
        """Have the alerts of a recorded run as they were; ConfigError if damaged."""
        step = self.history.boat.method.step
        self.alerts.recall(AlertNote.of(each, step) for each in self.history.recording.notes())
        self._follow_alerts(self.history.now())

    def _follow_alerts(self, moment: Moment) -> None:
        """Have the alerts as they were at a moment."""
        ends: dict[int, float] = {}
        with contextlib.suppress(RecordingError):
            ends = self.history.ends()
        self.alerts.follow(
            lambda when: (
                when.tick <= min(moment.tick, ends.get(when.branch, -1 if ends else math.inf))
            )
        )

    def _replay_alerts(self) -> None:
        """In a replay, have the alerts become again what they became at this tick."""
        tick, replaying = self.history.tick, self.history.flown.replaying
        if replaying and any(note.when.tick == tick for note in self.alerts.notes):
            self.put_back_alerts()

    def put_back_alerts(self) -> None:
        """Have this moment's alerts as they are recorded; tell programs if any differ."""
        before = {**self.alerts.open}
        self._follow_alerts(self.history.now())
        if self.alerts.open != before:
            for station in self.stations:
                self.note_alerts(station)

    def _keep_note(self, note: AlertNote) -> None:
        """Record what has become of an alert; a replay has it already."""
        if not self.history.flown.replaying:
            self.alerts.notes.append(note)
            self.history.recording.event(note.when.tick, NOTE_KIND, note.by, note.line, note.by)

    def _note_branches(self, station: Station) -> None:
        """Send a program the branches, before it hears of a jump to one of them."""
        with contextlib.suppress(RecordingError):
            self.note(station, [Fact("branch", each.fields) for each in self.history.branches()])

    def _parent(self) -> int:
        """Return the branch that the present one began from, 0 where that cannot be read."""
        present = self._branch if self._branch not in self._counts else 0  # a replay begins none
        with contextlib.suppress(RecordingError):
            parents = {each.id: each.parent or 0 for each in self.history.recording.branches()}
            return parents.get(present, 0)
        return 0

    def recall(self, waiting: Callable[[str], Iterable[tuple[int, Fact]]]) -> None:
        """Send programs the orders that wait for each role, because time has jumped."""
        step = self.history.boat.method.step
        for station in self.stations:
            for tick, fact in waiting(station.role.name):
                station.note(News(tick, tick * step, CREW_KIND, "", fact))

    def note_alerts(self, station: Station) -> None:
        """Send a program all alerts that are open, and what was seen of its own."""
        step = self.history.boat.method.step
        for tick, fact in self.own_alerts.standing(station.role.name):
            station.note(News(tick, tick * step, "exercise", "", fact))
        heard = self._heard_by(station)
        self.note(station, [Fact("alerts", str(len(heard)))])
        for alert in heard:
            self._note_alert(station, alert)

    @property
    def _now(self) -> Instant:
        history = self.history
        return Instant(history.recording.branch, history.tick, history.boat.time)

    def _news_of(self, alert: Alert) -> News:
        return News(alert.raised.tick, alert.raised.seconds, alert.kind, alert.text)

    def _note_alert(self, station: Station, alert: Alert) -> None:
        """Send a program an alert: its rank, its number with its text, and its state."""
        if not hears_kind(station.role, alert.kind):
            return
        news, number = self._news_of(alert), alert.number
        facts = [Fact("alert-rank", f"{number},{alert.rank.value}")]
        facts += [Fact("alert", f"{number},{alert.kind},{alert.text}")]
        facts += [Fact("ack", str(number))] * (alert.seen is not None)
        for fact in (*facts, self._state_of(alert, station)):
            station.note(news._replace(fact=fact))

    def _tell_state(self, alert: Alert) -> None:
        """Send programs what has become of an alert."""
        for station in self.stations:
            if hears_kind(station.role, alert.kind):
                self.note(station, [self._state_of(alert, station)])

    def _state_of(self, alert: Alert, station: Station) -> Fact:
        left = self.own_alerts.silent_for(str(alert.number), station.role.name)
        state = alert.state(silent=left > 0.0)
        duty = " ".join(self._answerers(alert, station)) or "you"
        fields = str(alert.number), state.value, f"{left:.1f}", duty, alert.key.partition(":")[0]
        return Fact("alert-state", ",".join(fields))

    def _spread(self, news: News, by: Station | None) -> None:
        """Keep news for latecomers, and send it to all; ``by`` gets only the fact.

        The giver of an order to the crew also gets the fact ``own-order``, because it must not
        repeat its own order.
        """
        self.news.append(news)
        for station in self.stations:
            if station is not by:
                station.tell(news)
            else:
                station.note(news)
                if news.fact and news.fact.what == "crew-order":
                    station.note(news._replace(fact=Fact("own-order", news.fact.subject)))

    def pass_on(
        self, order: Order, answer: Reply, station: Station, kind: str | None, what: str
    ) -> None:
        """Tell the others of an order and its answer.

        News of an obeyed order is of that ``kind``; None: ``exercise`` if it is an instructor's,
        else ``order``. Its fact is ``what``. A refusal has no fact.
        """
        kinds = "exercise" if station.role is INSTRUCTOR_ROLE else "order"
        refused = isinstance(answer, Refused)
        result = f"refused: {answer.reason}" if isinstance(answer, Refused) else str(answer)
        words = f"{order.text}: {result}"
        fact = None if refused else Fact(what, order.text)
        told_kind = kinds if refused else kind or kinds
        text = f"{self.signature(station)}: {words}"
        self.tell(told_kind, text, station, fact, Saying(station.role.name, words))

    def attended(self, role: str) -> bool:
        """Return whether a station has that role."""
        return any(station.role.name == role for station in self.stations)

    def signature(self, station: Station) -> str:
        """Return the role of a speaker; its line too where there are several instructors."""
        several = sum(1 for each in self.stations if each.role is INSTRUCTOR_ROLE) > 1
        return station.who if several and station.role is INSTRUCTOR_ROLE else station.role.name

    def note(self, station: Station, facts: Iterable[Fact]) -> None:
        """Send a station facts of the present tick, if it is a program."""
        for fact in facts:
            station.note(News(self.history.tick, self.history.boat.time, "exercise", "", fact))

    def attended_by_others(self, station: Station) -> frozenset[str]:
        """Return the roles of all stations but one."""
        return frozenset(other.role.name for other in self.stations if other is not station)

    def as_kept(self, answer: Reply) -> Reply:
        """Return an answer, with a note if its order could not be recorded."""
        if self.history.recording.trouble and not isinstance(answer, Refused):
            return f"{answer} (not recorded)"
        return answer

    def tell_trouble(self) -> None:
        """Announce once that recording fails, and once that it works again."""
        self._tell_behind()
        recording = self.history.recording
        if recording.trouble == self.unrecorded:
            return
        self.unrecorded = recording.trouble
        lost = f"lost in all: {recording.missing}" if recording.missing else "nothing is lost"
        back = f"recorded again in branch {recording.branch}; {lost}"
        text = f"NOT RECORDED: {recording.trouble}" if recording.trouble else back
        self.tell("trouble", text)

    def _tell_behind(self) -> None:
        """Announce once that the disk is behind, and once that it has caught up.

        While it is behind, a loss of power would lose the last orders.
        """
        why = self.history.recording.behind
        if bool(why) is self.unsafe:
            return
        self.unsafe = bool(why)
        text = (
            f"THE DISK IS BEHIND: {why}; {UNSAFE_TEXT}"
            if why
            else f"the disk has caught up: {SAFE_TEXT}"
        )
        self.tell("trouble", text)

    def log(self, kind: str, text: str) -> None:
        """Announce what the station that is being heard logs about its own line."""
        if self.heard and not self.heard.settled:
            self.strangers.log(kind, text)
        else:
            self.tell(kind, text, self.heard)

    def lately(self, role: Role, count: int) -> list[str]:
        """Return the last ``count`` events that ``role`` hears of, in words."""
        heard = [news for news in self.news if hears_kind(role, news.kind)]
        return [f"{clock(news.seconds)} {news.text}" for news in heard[-count:]]
