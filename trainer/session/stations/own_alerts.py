"""What a station has seen or silenced of the alerts that its pages find.

A station may have several pages, and each may be loaded anew, so that no page keeps this. The
session knows such an alert by the name that pages give it, and not what it is about. It says
nothing of an alert that nobody has seen: that one sounds.
"""

import time
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.io.orders.grammar import Order
from trainer.io.recording.recording import Moment
from trainer.session.stations.station import Fact

SILENCE_S: Final = 30.0  # that Silence lasts, as the pages' alert-sounder.js has it
MAX_KEPT_ALERTS: Final = 50  # of one role, the latest
SEEN, SILENT = "seen", "silent"  # what may be said of an alert, beside that it is over


class SeenAlert(NamedTuple):
    """What was last said of an alert, and at which tick."""

    word: str
    tick: int
    due: float  # [s] on the machine's clock, until when it is silent

    def fact(self, name: str) -> Fact:
        """Return what a page is told of the alert of that name."""
        left = max(self.due - time.monotonic(), 0.0)
        return Fact("own-alert", f"{name},{self.word},{left if self.word == SILENT else 0.0:.1f}")


@dataclass
class OwnAlerts:
    """What each role has seen and silenced, by the names of the alerts."""

    by_role: dict[str, dict[str, SeenAlert]] = field(default_factory=dict)

    def note(self, order: Order, role: str, tick: int) -> Fact:
        """Keep what an order says of an alert; return it for the role's other pages."""
        kept, name = self.by_role.setdefault(role, {}), order.subject
        said = SeenAlert(order.word, tick, time.monotonic() + SILENCE_S)
        if said.word in (SEEN, SILENT):
            kept[name] = said
        else:
            kept.pop(name, None)
        for oldest in list(kept)[:-MAX_KEPT_ALERTS]:
            del kept[oldest]
        return said.fact(name)

    def silence(self, name: str, role: str, tick: int) -> None:
        """Keep that an alert of that name is silent for a while."""
        silent = SeenAlert(SILENT, tick, time.monotonic() + SILENCE_S)
        self.by_role.setdefault(role, {})[name] = silent

    def silent_for(self, name: str, role: str) -> float:
        """Return how long [s] an alert is silent still, 0 for one that is not."""
        said = self.by_role.get(role, {}).get(name)
        return max(said.due - time.monotonic(), 0.0) if said and said.word == SILENT else 0.0

    def standing(self, role: str) -> list[tuple[int, Fact]]:
        """Return what stands for a page that comes to a role, each with its tick."""
        now, kept = time.monotonic(), self.by_role.get(role, {})
        stands = {name: said for name, said in kept.items() if said.word == SEEN or said.due > now}
        return [(said.tick, said.fact(name)) for name, said in stands.items()]

    def follow(self, moment: Moment) -> None:
        """Forget what was said later than a moment to which time has jumped."""
        for role, kept in self.by_role.items():
            early = {name: said for name, said in kept.items() if said.tick <= moment.tick}
            self.by_role[role] = early
