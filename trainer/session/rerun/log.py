"""The log hands the publisher's offers and all events to feeds as well."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import click

from trainer.session.rerun.collector import Heard, Taken
from trainer.session.rerun.feed import Feed
from trainer.session.stations.station import News
from trainer.session.stations.subscriptions import Promptly, Publisher, Subscription
from trainer.session.stations.view import Pace
from trainer.session.time.ledger import Ledger


@dataclass
class Log:
    """Sends what is subscribed as ``sending`` does, and feeds what there is to be fed."""

    sending: Publisher | Promptly
    ledger: Ledger
    feeds: Sequence[Feed]
    _last: tuple[int, bytes, Pace] | None = field(default=None, init=False)
    _told: set[str] = field(default_factory=set, init=False)

    @property
    def troubles(self) -> deque[str]:
        """Return the news for somebody to tell, with the end of a feed once."""
        for feed in self.feeds:
            if feed.trouble and feed.trouble not in self._told:
                self._told.add(feed.trouble)
                self.sending.troubles.append(feed.trouble)
        return self.sending.troubles

    def offer(self, tick: int, state: bytes, pace: Pace) -> None:
        """Set the picture to send from now on."""
        self.sending.offer(tick, state, pace)
        ledger = self.ledger
        taken = Taken(tick, state, pace, ledger.ticks, ledger.lateness, ledger.work)
        self._last = tick, state, pace
        for feed in self.feeds:
            feed.hand(taken)

    def hear(self, news: News) -> None:
        """Take what has happened."""
        heard = Heard(news.tick, news.kind, news.text)
        for feed in self.feeds:
            feed.hand(heard)

    def add(self, subscription: Subscription) -> None:
        """Send to a subscription from now on, the present picture at once."""
        self.sending.add(subscription)

    def strike(self, subscription: Subscription) -> None:
        """Send to a subscription no more."""
        self.sending.strike(subscription)

    def close(self, patience: float) -> None:
        """Send and feed what is due, waiting for each as long as it may take."""
        if self._last is not None:
            ledger = self.ledger  # the last tick's work has been timed only now
            taken = Taken(*self._last, ledger.ticks, ledger.lateness, ledger.work)
            for feed in self.feeds:
                feed.hand(taken)
        for feed in self.feeds:
            feed.end()
        self.sending.close(patience)
        for feed in self.feeds:
            feed.close()

    def account(self) -> int:
        """Print what has become of feeds that went wrong; return the exit code.

        A file that is not complete is one; a viewer that has gone is not.
        """
        for feed in self.feeds:
            if feed.trouble:
                click.echo(f"trainer: {feed.trouble}", err=True)
        return int(any(feed.trouble and feed.sink.needed for feed in self.feeds))
