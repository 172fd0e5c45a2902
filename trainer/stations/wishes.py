"""What one line wants to be sent: its channels, and whether it hears of events."""

from collections import deque
from operator import attrgetter
from typing import Protocol

from trainer.config import nearest
from trainer.reply import Refused, Reply
from trainer.stations.channels import CHANNELS, EVENTS, TELETYPE
from trainer.stations.display import Display, Sentences, Teletype, Words
from trainer.stations.frame import Pace
from trainer.stations.publisher import Recipient, Subscription
from trainer.stations.roles import INSTRUCTOR, STRANGER, Role, blind


class Sending(Protocol):
    """Whoever sends what is subscribed: a publisher, or one that does so promptly."""

    @property
    def troubles(self) -> deque[str]:
        """Return what has ended subscriptions, for somebody to tell."""
        ...

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Let this be the picture to send from now on."""
        ...

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        ...

    def strike(self, subscription: Subscription) -> None:
        """Send to it no more."""
        ...


class Wishes:
    """The subscriptions of one line; a channel is there once, the later wish holds."""

    def __init__(self, to: Recipient, sending: Sending) -> None:
        self.events = True
        self._to = to
        self._sending = sending
        self._subscriptions: dict[str, tuple[Subscription, bool]] = {}  # and: for a program

    @property
    def channels(self) -> tuple[str, ...]:
        """Return what is wanted, by name."""
        return (*self._subscriptions, *((EVENTS,) if self.events else ()))

    def begin(self, channel: str, rate: float, role: Role, *, machine: bool) -> None:
        """Have a channel sent, at most ``rate`` [Hz] or 0 at every tick."""
        self.end(channel)
        if channel == EVENTS:
            self.events = True
            return
        subscription = Subscription(
            self._to, channel, rate, display(channel, role, machine=machine)
        )
        self._subscriptions[channel] = subscription, machine
        self._sending.add(subscription)

    def end(self, *channels: str) -> None:
        """Have channels sent no more."""
        for channel in channels:
            self.events = self.events and channel != EVENTS
            if channel in self._subscriptions:
                self._sending.strike(self._subscriptions.pop(channel)[0])

    def keep_for(self, role: Role) -> None:
        """Have what ``role`` may see shown as it sees it, and the rest no more."""
        for channel, (old, machine) in tuple(self._subscriptions.items()):
            self.end(channel)
            if blind(role, channel) is None:
                self.begin(channel, old.rate, role, machine=machine)

    def cancel(self, given: str) -> Reply:
        """Carry out the order to send a channel, or ``all``, no more."""
        there = self.channels
        if given not in (*there, "all"):
            named = ", ".join(there) or "nothing"
            return Refused(f"{given} is not subscribed here; there is {named}")
        ended = there if given == "all" else (given,)
        self.end(*ended)
        return f"no more {', '.join(ended)}" if ended else "nothing was subscribed"


def unknown(channel: str, role: Role) -> str:
    """Return why there is no such channel, naming the nearest that ``role`` has; "" if there is."""
    if channel in (*CHANNELS, TELETYPE, EVENTS):
        return ""
    there = (*role.channels, EVENTS)
    return f"no channel {channel}{nearest(channel, there) or '; there is ' + ', '.join(there)}"


def barred(channel: str, role: Role) -> str | None:
    """Return why a channel, events among them, is not for ``role``; None when it is."""
    if channel == EVENTS and role is not STRANGER:
        return None
    return blind(role, channel)


def display(channel: str, role: Role, *, machine: bool) -> Display:
    """Return how a channel is shown to a program or a reader of that role."""
    if channel == TELETYPE:
        return Teletype(attrgetter("truth" if role is INSTRUCTOR else "readings"))
    return Sentences(CHANNELS[channel]) if machine else Words(CHANNELS[channel])
