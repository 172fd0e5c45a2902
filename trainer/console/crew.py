"""The orders to the crew that a screen waits to see repeated, and wrong repeats.

Aboard, who gets an order repeats it, so that the giver hears whether it was understood. ``model``
fills this from the session's facts; ``drawing/crew_orders`` shows it.
"""

from dataclasses import dataclass, field
from typing import Final, NamedTuple

# the roles that repeat an order, by its axis; one in words is for the whole crew
AXIS_ROLES: Final = {
    "course": ("helm", "pilot", "trainee"),
    "speed": ("helm", "pilot", "trainee"),
    "depth": ("planes", "pilot", "diving", "trainee"),
    "pitch": ("planes", "pilot", "diving", "trainee"),
}
TELL_WORD: Final = "tell"  # the first word of an order in words, which stands for its axis
CREW_ROLES: Final = ("helm", "planes", "pilot", "ballast", "diving", "deck", "scope", "trainee")


class CrewOrder(NamedTuple):
    """An order to the crew: its time, its axis, and its words."""

    seconds: float
    axis: str
    says: str


@dataclass
class CrewOrders:
    """The orders that wait to be repeated, oldest first, one of each axis."""

    waiting: dict[str, CrewOrder] = field(default_factory=dict)
    wrong: str = ""
    told: str = ""  # the last order in words
    rings: int = 0  # how often a bell has been due

    @property
    def oldest(self) -> CrewOrder | None:
        """Return the order that waits longest, None without."""
        return next(iter(self.waiting.values()), None)

    def give(self, seconds: float, subject: str) -> None:
        """Take an order to the crew, which replaces an earlier one on its axis.

        An order that the session sends again, because nobody has repeated it, keeps its time and
        its place: `aye` repeats the newest order, and that is none.
        """
        axis, _, words = subject.partition(" ")
        says = words if axis == TELL_WORD else subject
        before = self.waiting.get(axis)
        again = before is not None and before.says == says
        if not again:
            self.waiting.pop(axis, None)
        since = before.seconds if before and again else seconds
        self.waiting[axis] = CrewOrder(since, axis, says)
        self.told = says if axis == TELL_WORD else self.told
        self.wrong = ""
        self.rings += 1

    def settle(self, _seconds: float, subject: str) -> None:
        """Remove an order that was repeated or belayed, or that this screen has given."""
        self.waiting.pop(subject.partition(" ")[0], None)
        self.wrong = ""

    def mishear(self, _seconds: float, subject: str) -> None:
        """Note a wrong repeat, and ring."""
        said, _, order = subject.partition("; ")
        self.wrong = f"{said}; ordered {order}"
        self.rings += 1

    def forget_waiting(self) -> None:
        """Forget the waiting orders, because the session sends them again."""
        self.waiting.clear()
        self.wrong = ""

    def awaits(self, axis: str, role: str) -> bool:
        """Return whether the order on an axis waits to be repeated by that role."""
        return axis in self.waiting and role in AXIS_ROLES[axis]

    def to_repeat(self, role: str) -> CrewOrder | None:
        """Return the newest order that a role is to repeat, which is what `aye` repeats."""
        return next(iter(self.all_to_repeat(role)), None)

    def all_to_repeat(self, role: str) -> list[CrewOrder]:
        """Return the orders that a role is to repeat, the newest first."""
        return [
            waiting_order
            for waiting_order in reversed(self.waiting.values())
            if role in AXIS_ROLES.get(waiting_order.axis, CREW_ROLES)
        ]
