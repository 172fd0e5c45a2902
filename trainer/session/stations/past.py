"""The past of a channel, for a station that comes late or returns.

The order ``history`` asks for it. A thread makes it from the recording's states, which it reads by
its own connection; without a recording from the moments that are kept in memory. Rows are made
like the live ones, so that a wrong gauge shows what it showed then.
"""

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Final, NamedTuple

from trainer.io.orders.grammar import Refused
from trainer.io.orders.words import ANEW_ORDERS
from trainer.io.recording.recording import Recording, RecordingError
from trainer.session.aside import BackgroundTask
from trainer.session.past.history import History
from trainer.session.stations.aids import NO_AIDS
from trainer.session.stations.channels import EVENTS_CHANNEL
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import Role, hears_kind
from trainer.session.stations.station import Fact, News, Request, Station
from trainer.session.stations.subscriptions import display, lack_of, unknown_channel, why_barred
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.time.ledger import Ledger

MAX_ROWS: Final = 360  # rows of a channel: one in ten seconds of an hour, as memory keeps moments
SLICE_ROWS: Final = 12  # rows sent at once
# [s] between slices, and for room: ticks and other lines have their turn
SLICE_PAUSE_S: Final = 0.01
# Channels with values that no recorded state holds: they have no past.
PRESENT_CHANNELS: Final = ("time", "ledger", "scope", "swell", "lookout", "predictor", "safe")

TickState = tuple[int, bytes]  # a tick and the state at its end


class TickSpan(NamedTuple):
    """The ticks that are asked for."""

    branch: int
    first: int
    last: int

    @property
    def ticks(self) -> range:
        """Return the ticks that get a row: evenly spaced, at most MAX_ROWS."""
        every = max(math.ceil((self.last - self.first) / MAX_ROWS), 1)
        return range(-(-self.first // every) * every, self.last + 1, every)


class PastReader:
    """The answers to the order ``history``."""

    def __init__(
        self, history: History, work: BackgroundTask, log: EventLog, kept: Path | None = None
    ) -> None:
        self.aids = NO_AIDS  # that are on: the ghost was there at all times
        self.kept = kept  # the recording
        self._history = history
        self._log = log
        self._boat = history.boat
        self._work = work

    def answer(self, asked: Request) -> None:
        """Answer the order, and send the past of its channel."""
        channel, station, history = asked.order.subject, asked.station, self._history
        if refused := refusal(channel, station.role) or lack_of(channel, self._boat):
            station.answer(asked, refused)
            return
        ticks = math.ceil(asked.order.value / self._boat.method.step)
        span = TickSpan(history.recording.branch, max(history.tick - ticks, 0), history.tick)
        if channel == EVENTS_CHANNEL:
            ends: Mapping[int, float] = {}
            with suppress(RecordingError):  # without it all that memory keeps is told
                ends = history.ends()
            news = recent_news(self._log.news, station.role, span.first, ends)
            station.answer(asked, f"events: {len(news)} of them")
            self._mark(station, "begin", channel)
            for item in news:
                station.tell(item)
            self._mark(station, "end", channel)
            return
        since = span.first * self._boat.method.step
        station.answer(asked, f"{channel}: what it has shown since {since:g} s")
        self._begin(asked, span)

    def _begin(self, asked: Request, span: TickSpan) -> None:
        """Send rows from a thread. The channel's live rows pause until then, to keep the order."""
        channel, station, kept = asked.order.subject, asked.station, self.kept
        wish = station.wishes.pause(channel)
        memory = [] if kept else self._history.automatic.since(span.first)
        self._mark(station, "begin", channel)

        def send() -> None:
            self._send(asked, read_states(kept, span) if kept else memory)

        def end(_: object) -> None:
            self._mark(station, "end", channel)
            if wish and not station.leaving:
                station.wishes.begin(channel, wish[0], station.role, machine=wish[1])

        self._work.begin("past", send, end, end)

    def _send(self, asked: Request, rows: Sequence[TickState]) -> None:
        """Send rows a few at a time, in the thread for it."""
        station = asked.station
        shown = display(asked.order.subject, station.role, machine=asked.heard.machine)
        reader = StateReader(self._boat, Ledger(self._boat.method.step).summary)
        for number, (tick, state) in enumerate(rows):
            if not self._await_room(station):
                return
            for line in shown.lines(reader.frame(Picture(tick, state, Pace(aids=self.aids)))):
                station.line.send(line)
            if number % SLICE_ROWS == SLICE_ROWS - 1:
                time.sleep(SLICE_PAUSE_S)

    def _await_room(self, station: Station) -> bool:
        """Wait until a line has room. Return False once it has gone."""
        while not (station.leaving or station.line.ended or self._work.closing.is_set()):
            if station.line.room:
                return True
            time.sleep(SLICE_PAUSE_S)
        return False

    def _mark(self, station: Station, which: str, channel: str) -> None:
        """Mark for a program where the past begins and ends."""
        fact = Fact("past", f"{which},{channel}")
        history = self._history
        station.note(News(history.tick, history.boat.time, "moment", "", fact))


def refusal(channel: str, role: Role) -> Refused | None:
    """Return why a channel's past is not for a role, None when it is."""
    if channel in PRESENT_CHANNELS:
        return Refused(f"{channel} tells of what is now: it has no past")
    return unknown_channel(channel, role) or why_barred(channel, role)


def read_states(kept: Path, span: TickSpan) -> list[TickState]:
    """Return the states of a span that a recording holds. None where it cannot be read."""
    states = []
    with suppress(RecordingError), closing(Recording.look(kept)) as recording:
        for tick in span.ticks:
            state = recording.state_at(span.branch, tick)
            if state is not None:
                states.append((tick, state))
    return states


def recalled_past(history: History) -> list[News]:
    """Return the events of a resumed recording, and the casualties that were ordered."""
    step = history.boat.method.step
    news = [
        News(
            *(each.tick, each.tick * step, each.kind, each.text),
            Fact("mark", each.text) if each.kind == "mark" else None,
            branch=each.branch,
        )
        for each in history.noted()
    ]
    orders = history.recording.orders(history.recording.branch)
    news += [
        News(
            *(each.tick, each.tick * step, "exercise", each.text, Fact("order", each.text)),
            branch=each.branch,
        )
        for each in orders
        if each.name == "casualty" and each.accepted
    ]
    return sorted(news, key=lambda each: each.tick)


def recent_news(
    news: Iterable[News], role: Role, first: int, ends: Mapping[int, float]
) -> list[News]:
    """Return the news of a role since a tick, on the way to the present.

    News of what a jump in time took back is left out. ``ends`` are those of the branches that lead
    to the present one; there is none without a recording, where no jump leads to another branch.
    """
    heard: list[News] = []
    for item in news:
        if ends and item.tick > ends.get(item.branch, -1):
            continue
        if item.fact and item.fact.what == "back":
            heard = [kept for kept in heard if still_stands(kept, item)]
        if hears_kind(role, item.kind) and item.tick >= first:
            heard.append(item)
    return heard


def still_stands(kept: News, back: News) -> bool:
    """Return whether no jump in time has taken an event back.

    An event of the very tick gone back to stays, unless the run began anew there.
    """
    anew = back.fact is not None and back.fact.subject in ANEW_ORDERS
    return kept.tick < back.tick or (kept.tick == back.tick and not (anew and kept.fact))
