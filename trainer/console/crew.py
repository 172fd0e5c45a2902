"""Orders to the crew that have not been repeated yet, and what was repeated wrong."""

from dataclasses import dataclass, field
from typing import ClassVar, Final, NamedTuple

# whose an order is, by its axis; what is told in words is everybody's
ADDRESSED: Final = {
    "course": ("helm", "pilot"),
    "speed": ("helm", "pilot"),
    "depth": ("planes", "pilot", "diving"),
    "pitch": ("planes", "pilot", "diving"),
}
CREW: Final = ("helm", "planes", "pilot", "ballast", "diving")


class CrewOrder(NamedTuple):
    """An order to the crew: its time, its axis, and the words in which it was said."""

    seconds: float
    axis: str
    says: str


@dataclass
class CrewOrders:
    """The orders that wait to be repeated, oldest first, one of each axis."""

    FACTS: ClassVar = frozenset({"crew-order", "repeated", "wrong-repeat"})
    waiting: dict[str, CrewOrder] = field(default_factory=dict)
    wrong: str = ""
    rings: int = 0  # how often a bell has been due

    @property
    def oldest(self) -> CrewOrder | None:
        """Return the order that waits longest, None without."""
        return next(iter(self.waiting.values()), None)

    def take(self, seconds: float, what: str, subject: str) -> None:
        """Take a fact of FACTS."""
        if what == "crew-order":
            self.give(seconds, subject)
        elif what == "repeated":
            self.repeat(subject)
        else:
            self.mishear(subject)

    def give(self, seconds: float, subject: str) -> None:
        """Take an order to the crew, in place of an earlier one on the same axis."""
        axis = subject.split(" ", 1)[0]
        if axis == "clear":
            self.waiting.pop(subject.rpartition(" ")[2], None)
            return
        self.waiting.pop(axis, None)
        self.waiting[axis] = CrewOrder(seconds, axis, subject)
        self.wrong = ""
        self.rings += 1

    def repeat(self, subject: str) -> None:
        """Take the repeat of an order, said as the order was."""
        self.waiting.pop(subject.split(" ", 1)[0], None)
        self.wrong = ""

    def mishear(self, subject: str) -> None:
        """Take a repeat that was another than the order."""
        self.wrong = subject
        self.rings += 1

    def go_back(self, seconds: float) -> None:
        """Forget what was ordered after a moment gone back to."""
        self.waiting = {a: each for a, each in self.waiting.items() if each.seconds <= seconds}
        self.wrong = ""

    def awaits(self, axis: str) -> bool:
        """Return whether the order on an axis waits to be repeated."""
        return axis in self.waiting

    def awaited(self, role: str) -> CrewOrder | None:
        """Return the oldest order that a role is to repeat, None without."""
        mine = (o for o in self.waiting.values() if role in ADDRESSED.get(o.axis, CREW))
        return next(mine, None)
