"""Surfaces moved by keys: each press adds to what has been ordered, seen or not yet seen."""

from dataclasses import dataclass, field
from typing import Final

from trainer.screen.sight import Sight

FORGET: Final = 1.5  # [s] after which what the boat shows counts again
CHANNEL: Final = {"rudder": "steering", "stern": "diving", "bow": "diving"}
WORDS: Final = {
    "rudder": ("rudder left", "rudder right"),
    "stern": ("stern planes dive", "stern planes rise"),
    "bow": ("bow planes dive", "bow planes rise"),
}


@dataclass
class Levers:
    """What was last asked of each surface [deg], and when."""

    asked: dict[str, tuple[float, float]] = field(default_factory=dict)
    refused: int = 0

    def move(self, surface: str, by: int, sight: Sight) -> str:
        """Return the order that moves a surface ``by`` degrees, "" where the boat has none."""
        shown = sight.picture.number(CHANNEL[surface], f"ordered_{surface}")
        if shown is None:
            return ""
        if sight.refused != self.refused:  # beyond its limit, most likely
            self.refused = sight.refused
            self.asked.clear()
        angle, when = self.asked.get(surface, (shown, float("-inf")))
        now = sight.clock()
        wanted = round(angle if now - when < FORGET else shown) + by
        self.asked[surface] = wanted, now
        return f"{WORDS[surface][wanted > 0]} {abs(wanted)}"
