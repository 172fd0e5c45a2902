"""The present moment as it is offered to the screens, and how time runs.

A state alone does not say whether time is frozen, how fast it runs, or what was last said to the
crew. ``ScreenOutput`` adds that to each state, and hands both to the sender (``subscriptions``).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from trainer.io.orders.grammar import Refused
from trainer.session.crew.crew import CrewTalk
from trainer.session.past.history import History
from trainer.session.stations.aids import NO_AIDS, ShownAids
from trainer.session.stations.channels import EVENTS_CHANNEL
from trainer.session.stations.display import panel
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import LongAnswer, Station
from trainer.session.stations.status import status_lines
from trainer.session.stations.subscriptions import (
    Sender,
    display,
    lack_of,
    unknown_channel,
    why_barred,
)
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.timekeeping import Timekeeping


@dataclass
class ScreenOutput:
    """The output to the screens of one session."""

    history: History
    time: Timekeeping
    crew: CrewTalk
    sending: Sender
    aids: ShownAids = NO_AIDS
    seen: Callable[[], object] = bool  # called after a moment that may stand still is shown
    lesson: str = ""  # the step of a lesson, in place of the words to the crew
    _pace: Pace = field(default_factory=Pace)  # as it was last shown: what changes it shows it
    _reader: StateReader = field(init=False)

    def __post_init__(self) -> None:
        self._reader = StateReader(self.history.boat, self.time.ledger.summary)

    def show(self) -> None:
        """Show the present moment, and how time runs from here on."""
        now, time, flown = self.history.now(), self.time, self.history.flown
        told = self.lesson or self.crew.told
        self._pace = Pace(
            *(time.frozen, time.speed, now.branch, flown.replaying, told, now.after),
            *(flown.shows_way, self.aids, self.crew.bill.shown),
        )
        self.sending.offer(now.tick, now.state, self._pace)
        self.seen()

    @property
    def behind(self) -> bool:
        """Return whether a branch has begun that is not shown, as after a gap."""
        return self._pace.branch != self.history.recording.branch

    def show_tick(self, tick: int, state: bytes) -> None:
        """Show the state after a tick. How time runs has not changed."""
        if self.behind:
            self._pace = self._pace._replace(branch=self.history.recording.branch)
        self.sending.offer(tick, state, self._pace)

    def take_words(self) -> None:
        """Note the last words to the crew, which the next state shows."""
        told = self.lesson or self.crew.told
        self._pace = self._pace._replace(told=told, hands=self.crew.bill.shown)

    def show_lesson(self, text: str) -> None:
        """Show the step of a lesson from the next state on, "" for none."""
        self.lesson = text
        self.take_words()

    def status(self, station: Station) -> list[str]:
        """Return all lines about the boat that a station may know."""
        if station.role is INSTRUCTOR_ROLE:
            return status_lines(self.history.boat, self.time.ledger.summary())
        return panel(station.role.channels, self._frame())

    def status_of(self, channel: str, station: Station) -> LongAnswer | Refused:
        """Return what one channel shows, or why a station does not see it."""
        role, boat = station.role, self.history.boat
        if channel == EVENTS_CHANNEL:
            return Refused("events are no state: `log` tells the last of them")
        refused = unknown_channel(channel, role) or why_barred(channel, role)
        if refusal := refused or lack_of(channel, boat):
            return refusal
        return LongAnswer(display(channel, role, machine=False).lines(self._frame()))

    def _frame(self) -> Frame:
        return self._reader.frame(Picture(self.history.tick, self.history.now().state, self._pace))
