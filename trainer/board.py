"""What has happened: recorded, told to whoever hears of such things, and kept for latecomers."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from trainer.history import History
from trainer.io.teletype import clock
from trainer.stations.roles import Role, hears
from trainer.stations.station import News, Station

KEPT: Final = 500  # of what has happened, for who comes late


@dataclass
class Board:
    """The news of one run."""

    history: History
    stations: list[Station] = field(default_factory=list)
    news: deque[News] = field(default_factory=lambda: deque(maxlen=KEPT))
    heard: Station | None = None  # who is listened to
    hearers: list[Callable[[News], None]] = field(default_factory=list)  # of all; they never wait

    def tell(self, kind: str, text: str, by: Station | None = None) -> None:
        """Record what has happened, and tell whose role hears of such things but ``by``."""
        boat = self.history.boat
        # a remark is anybody's words: who hears it hears whose
        said = f"mark by {by.role.name}: {text}" if kind == "mark" and by else text
        news = News(self.history.tick, boat.time, kind, said)
        self.news.append(news)
        self.history.recording.event(news.tick, kind, by.who if by else "", text)
        for hear in self.hearers:
            hear(news)
        for station in self.stations:
            if station is not by:
                station.tell(news)

    def log(self, kind: str, text: str) -> None:
        """Tell what the station that is listened to has to say of itself."""
        self.tell(kind, text, self.heard)

    def lately(self, role: Role, count: int) -> list[str]:
        """Return the last of what ``role`` hears of."""
        heard = [news for news in self.news if hears(role, news.kind)]
        return [f"{clock(news.seconds)} {news.text}" for news in heard[-count:]]
