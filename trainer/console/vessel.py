"""A screen's vessel: how far its controls go, and what can break."""

import contextlib
from dataclasses import dataclass, field
from typing import NamedTuple


class CasualtyOffer(NamedTuple):
    """A casualty that can be ordered: its usual order, and its meaning."""

    name: str
    degree: str = ""
    says: str = ""


@dataclass
class Vessel:
    """The ranges and casualties of which the session tells."""

    ranges: dict[str, float] = field(default_factory=dict)  # of controls, and its bells [kn]
    casualties: list[CasualtyOffer] = field(default_factory=list)
    coming: list[CasualtyOffer] = field(default_factory=list)  # casualties, until all have come

    def take_range(self, _seconds: float, subject: str) -> None:
        """Take a range: "rudder=30", or "bell=ahead full:12" as "ahead full"."""
        key, _, value = subject.partition("=")
        name, colon, size = value.rpartition(":")
        with contextlib.suppress(ValueError):
            self.ranges[name if colon else key] = float(size)
