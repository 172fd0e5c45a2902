"""The alerts that a session tells a screen of, in the order of its list.

``model`` fills this from the session's facts; ``drawing/alerts`` shows it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

RANK_WORDS: Final = ("emergency", "alarm", "warning", "caution")  # the most urgent first
SILENCED_STATE: Final = "silenced"
OWED_STATES: Final = ("active", SILENCED_STATE, "rectified")  # of who has not acknowledged it
NORMAL_STATE: Final = "normal"


@dataclass(frozen=True)
class ListedAlert:
    """One alert that is open."""

    number: int
    seconds: float  # at which it came
    rank: str
    text: str
    last_state: str = "active"  # its state, as told last
    due: float = 0.0  # [s] on the screen's clock, until when it is silent
    duty: str = "you"  # or the roles that acknowledge it

    def state(self, now: float) -> str:
        """Return its state at a time [s] on the screen's clock."""
        return (
            "active" if self.last_state == SILENCED_STATE and self.due <= now else self.last_state
        )

    @property
    def owed(self) -> bool:
        """Return whether it calls, or somebody still has to acknowledge it."""
        return self.rank != "caution" and self.last_state in OWED_STATES

    @property
    def place(self) -> tuple[bool, int, int]:
        """Return its place: what is owed first, then rank, then the newest."""
        return not self.owed, RANK_WORDS.index(self.rank), -self.number


@dataclass
class AlertList:
    """The alerts that are open for a station."""

    clock: Callable[[], float]
    alerts: dict[int, ListedAlert] = field(default_factory=dict)  # by their numbers
    _ranks: dict[int, str] = field(default_factory=dict)  # told before their alerts

    @property
    def listed(self) -> list[ListedAlert]:
        """Return them in the order of the list."""
        return sorted(self.alerts.values(), key=lambda each: each.place)

    def begin(self, _seconds: float, _count: str) -> None:
        """Forget all: those that are open come anew."""
        self.alerts.clear()

    def take_rank(self, _seconds: float, subject: str) -> None:
        """Take the rank of the next alert."""
        number, _, rank = subject.partition(",")
        if rank in RANK_WORDS:
            self._ranks = {int(number): rank}

    def take(self, seconds: float, subject: str) -> None:
        """Take an alert, whose words begin with its tick."""
        number, _, text = subject.split(",", 2)
        words = text.partition(" s): ")[2] or text
        rank = self._ranks.pop(int(number), "caution")
        self.alerts[int(number)] = ListedAlert(int(number), seconds, rank, words)

    def take_state(self, _seconds: float, subject: str) -> None:
        """Take what has become of an alert, which leaves the list once nothing is due."""
        number, state, left, duty, _ = subject.split(",", 4)
        known = self.alerts.pop(int(number), None)
        if known and state != NORMAL_STATE:
            due = self.clock() + float(left)
            self.alerts[known.number] = replace(known, last_state=state, due=due, duty=duty)
