"""Subscriptions of lines to channels, and the senders that serve them.

``station`` makes them, and ``shown`` offers each picture. A thread sends the pictures, because the
tick that offers one may wait for nobody. A subscription gets the latest picture when its rate
allows, and those between are passed over. Where no time is kept, every picture is sent at once.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Final, Protocol

from trainer.boat.boat import Boat
from trainer.config.files import nearest
from trainer.io.orders.grammar import Refused, Reply
from trainer.session.stations.channels import CHANNELS, EVENTS_CHANNEL, TELETYPE_CHANNEL
from trainer.session.stations.display import Display, SentenceDisplay, TeletypeDisplay, WordDisplay
from trainer.session.stations.roles import INSTRUCTOR_ROLE, STRANGER_ROLE, Role, channel_refusal
from trainer.session.stations.view import Frame, Pace, Picture, StateReader

MAX_ROUND_RATE_HZ: Final = 100.0  # [Hz] of looking for due subscriptions, however fast ticks come
MAX_KEPT_TROUBLES: Final = 64  # errors kept until the session announces them


class Recipient(Protocol):
    """The far end of a subscription. Sending to it never waits."""

    def send(self, line: str) -> None:
        """Take one line."""


@dataclass(eq=False)
class Subscription:
    """One channel on one line, at most ``rate`` times a second; 0: every picture."""

    to: Recipient
    channel: str
    rate: float  # [Hz]
    display: Display
    seen: Picture | None = field(default=None, repr=False)
    due: float = -math.inf  # [s] on the clock

    def wait(self, picture: Picture, now: float) -> float:
        """Return the time [s] until the picture may be sent, infinity when it has been.

        The first comes at once, and so does a change in how time runs.
        """
        if self.seen is picture or self.seen == picture:
            return math.inf
        if self.seen is None or self.seen.pace != picture.pace:
            return 0.0
        return max(self.due - now, 0.0)

    def show(self, frame: Frame, picture: Picture, now: float) -> None:
        """Send a frame. The next is due a period after this one was due, so that the rate holds.

        After one that came before it was due, it is due a period from now.
        """
        self.seen = picture
        period = 1.0 / self.rate if self.rate else 0.0
        self.due = period + (self.due if now - period < self.due <= now else now)
        for line in self.display.lines(frame):
            self.to.send(line)


class Roster:
    """The subscriptions of all lines."""

    def __init__(self, reader: StateReader) -> None:
        self.troubles: deque[str] = deque(maxlen=MAX_KEPT_TROUBLES)
        self._reader = reader
        self._change = threading.Lock()  # of the list, which is replaced and never altered
        # A list, because CPython keeps a dropped tuple in reserve instead of freeing it.
        self._subscriptions: list[Subscription] = []

    @property
    def empty(self) -> bool:
        """Return whether there is no subscription."""
        return not self._subscriptions

    def lack(self, channel: str) -> Refused | None:
        """Return why the boat has no such channel, None where it has."""
        return lack_of(channel, self._reader.boat)

    def add(self, subscription: Subscription) -> None:
        """Enter a subscription."""
        with self._change:
            self._subscriptions = [*self._subscriptions, subscription]

    def strike(self, subscription: Subscription) -> None:
        """Remove a subscription, if it is still there."""
        with self._change:
            self._subscriptions = [s for s in self._subscriptions if s is not subscription]

    def serve(self, picture: Picture, now: float) -> float:
        """Send the picture to all that are due; return the time [s] to the next."""
        frame: Frame | None = None
        soonest = math.inf
        for subscription in self._subscriptions:
            if subscription.wait(picture, now) <= 0.0:
                try:
                    frame = frame or self._reader.frame(picture)
                    subscription.show(frame, picture, now)
                except Exception as error:  # noqa: BLE001 one display's bug must not blind the others
                    self._end(subscription, error)
                    continue
            soonest = min(soonest, subscription.wait(picture, now))
        return soonest

    def _end(self, subscription: Subscription, error: Exception) -> None:
        self.strike(subscription)
        self.troubles.append(
            f"{subscription.channel} ended on one line: {type(error).__name__}: {error}"
        )


class RosterSender:
    """The part of a sender that knows its roster."""

    def __init__(self, roster: Roster, clock: Callable[[], float] = time.monotonic) -> None:
        self.roster = roster
        self.troubles = roster.troubles
        self._clock = clock

    def lack(self, channel: str) -> Refused | None:
        """Return why the boat has no such channel, None where it has."""
        return self.roster.lack(channel)

    def strike(self, subscription: Subscription) -> None:
        """Send to a subscription no more, except what is being sent at this moment."""
        self.roster.strike(subscription)


class Publisher(RosterSender):
    """Send pictures from a thread; the tick that offers one never waits for it."""

    def __init__(self, roster: Roster, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(roster, clock)
        self._offered: tuple[int, bytes, Pace] | None = None  # a picture when somebody looks
        # free: a call waits to be heard; an event would take the tick several times as long
        self._called = threading.Lock()
        self._called.acquire()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="publisher", daemon=True)
        self._thread.start()

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Set the picture to send from now on."""
        self._offered = tick, state, pace
        if not self.roster.empty:
            self._call()

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        self.roster.add(subscription)
        self._call()

    def close(self, patience: float) -> None:
        """Send what is due and end the thread, waiting at most ``patience`` [s]."""
        self._closing.set()
        self._call()
        self._thread.join(patience)

    def _call(self) -> None:
        """Wake the thread. Several calls before it wakes count as one."""
        try:
            self._called.release()
        except RuntimeError:  # somebody has called already
            return

    def _run(self) -> None:
        wait = math.inf
        while True:
            self._called.acquire(timeout=-1 if math.isinf(wait) else wait)
            closing = self._closing.is_set()
            if self._offered is not None:
                wait = self.roster.serve(Picture(*self._offered), self._clock())
            if closing:
                return
            if not self.roster.empty:  # the first to come is served at once
                self._closing.wait(1.0 / MAX_ROUND_RATE_HZ)


class PromptSender(RosterSender):
    """Send pictures in the caller's thread, every one: for runs that keep no time."""

    _picture: Picture | None = None

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Send this picture at once to each subscription that is due."""
        self._picture = Picture(tick, state, pace)
        self.roster.serve(self._picture, self._clock())

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        self.roster.add(subscription)
        if self._picture is not None:
            self.roster.serve(self._picture, self._clock())

    def close(self, _patience: float) -> None:
        """Do nothing, because all has been sent."""


class Sender(Protocol):
    """The sender of subscriptions: a publisher, or one that sends promptly."""

    @property
    def troubles(self) -> deque[str]:
        """Return the errors that have ended subscriptions, which the session announces."""

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Set the picture to send from now on."""

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""

    def strike(self, subscription: Subscription) -> None:
        """Send to it no more."""

    def lack(self, channel: str) -> Refused | None:
        """Return why the boat has no such channel, None where it has."""


class Subscriptions:
    """The subscriptions of one line. A later wish for a channel replaces the earlier one."""

    def __init__(self, to: Recipient, sending: Sender) -> None:
        self.events = True
        self._to = to
        self._sending = sending
        self._subscriptions: dict[str, tuple[Subscription, bool]] = {}  # and: for a program

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the names of the subscribed channels."""
        return (*self._subscriptions, *((EVENTS_CHANNEL,) if self.events else ()))

    def begin(self, channel: str, rate: float, role: Role, *, machine: bool) -> None:
        """Subscribe a channel at ``rate`` [Hz] at most, or 0 at every tick."""
        self.end(channel)
        if channel == EVENTS_CHANNEL:
            self.events = True
            return
        subscription = Subscription(
            self._to, channel, rate, display(channel, role, machine=machine)
        )
        self._subscriptions[channel] = subscription, machine
        self._sending.add(subscription)

    def lack(self, channel: str) -> Refused | None:
        """Return why the boat has no such channel, None where it has."""
        return self._sending.lack(channel)

    def pause(self, channel: str) -> tuple[float, bool] | None:
        """Unsubscribe a channel. Return its rate, and whether it is for a program.

        None if it was not sent.
        """
        entry = self._subscriptions.get(channel)
        self.end(*(() if channel == EVENTS_CHANNEL else (channel,)))
        return (entry[0].rate, entry[1]) if entry else None

    def end(self, *channels: str) -> None:
        """Unsubscribe channels."""
        for channel in channels:
            self.events = self.events and channel != EVENTS_CHANNEL
            if channel in self._subscriptions:
                self._sending.strike(self._subscriptions.pop(channel)[0])

    def keep_for(self, role: Role) -> None:
        """Keep the channels that ``role`` may see, shown as it sees them; end the rest."""
        for channel, (old, machine) in tuple(self._subscriptions.items()):
            self.end(channel)
            if channel_refusal(role, channel) is None:
                self.begin(channel, old.rate, role, machine=machine)

    def cancel(self, given: str) -> Reply:
        """Carry out the order to end a channel's subscription, or ``all``."""
        channels = self.channels
        if given not in (*channels, "all"):
            named = ", ".join(channels) or "nothing"
            return Refused(f"{given} is not subscribed here; there is {named}")
        ended = channels if given == "all" else (given,)
        self.end(*ended)
        return f"no more {', '.join(ended)}" if ended else "nothing was subscribed"


def rate_of(channel: str, wished: float) -> float:
    """Return the rate [Hz] at which an order subscribes; 0: every tick."""
    fastest = CHANNELS[channel].fastest if channel in CHANNELS else math.inf
    return wished if math.isinf(fastest) else min(wished or fastest, fastest)


def unknown_channel(channel: str, role: Role) -> Refused | None:
    """Return why there is no such channel, with the nearest of ``role``; None if known."""
    if channel in (*CHANNELS, TELETYPE_CHANNEL, EVENTS_CHANNEL):
        return None
    channels = (*role.channels, EVENTS_CHANNEL)
    hint = nearest(channel, channels) or "; there is " + ", ".join(channels)
    return Refused(f"no channel {channel}{hint}")


def why_barred(channel: str, role: Role) -> Refused | None:
    """Return why a channel, events among them, is not for ``role``; None when it is."""
    if channel == EVENTS_CHANNEL and role is not STRANGER_ROLE:
        return None
    return channel_refusal(role, channel)


def lack_of(channel: str, boat: Boat) -> Refused | None:
    """Return why a boat has no such channel, None where it has."""
    return CHANNELS[channel].lack(boat) if channel in CHANNELS else None


def display(channel: str, role: Role, *, machine: bool) -> Display:
    """Return how a channel is shown to a program or a reader of that role."""
    if channel == TELETYPE_CHANNEL:
        return TeletypeDisplay(attrgetter("truth" if role is INSTRUCTOR_ROLE else "readings"))
    return SentenceDisplay(CHANNELS[channel]) if machine else WordDisplay(CHANNELS[channel])
