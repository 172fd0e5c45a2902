"""Recordings that are no file; with them a run needs no ``if``."""

from collections.abc import Callable, Container, Iterator
from dataclasses import replace

from trainer.io.recording.queries import Branch, Journalled, Moment, Noted


class NoRecording:
    """A recording that drops all it is given but orders by their first words.

    There is nothing to go back to. What moments in memory do not hold, the orders kept tell.
    """

    kept: Container[str]  # first words of orders
    wake: Callable[[], object]  # never called

    def __init__(self) -> None:
        self.kept = ()
        self.trouble = self.missing = self.behind = ""
        self.reachable = False
        self.wake = lambda: None
        self.absences = 0
        self.branch = 1
        self._order = 0
        self._orders: list[Journalled] = []

    def order(self, tick: int, who: str, text: str, place: int | None = None) -> int:
        """Keep an order if it is of those to be kept; return its number."""
        self._order += 1
        if self._keeps(text):
            entry = Journalled(self._order, self.branch, tick, who, text, place, None, "")
            self._orders.append(entry)
        return self._order

    def _keeps(self, text: str) -> bool:
        return text.partition(" ")[0] in self.kept

    def answered(self, order: int, answer: str, accepted: bool) -> None:  # noqa: FBT001
        """Keep what became of the latest order, if that is kept."""
        if self._orders and self._orders[-1].id == order:
            self._orders[-1] = replace(self._orders[-1], accepted=accepted, answer=answer)

    def state(self, _tick: int, _state: bytes) -> None:
        """Drop it."""

    def timing(self, _tick: int, _lateness: int, _work: int) -> None:
        """Drop it."""

    def event(self, _tick: int, _kind: str, _who: str, _text: str) -> None:
        """Drop it."""

    def snapshot(self, _name: str, _moment: Moment) -> None:
        """Drop it."""

    def fork(self, moment: Moment, _why: str) -> int:
        """Forget the orders after a moment; return the number of the branch that begins."""
        self._orders = [each for each in self._orders if each.id <= moment.after]
        self.branch += 1
        return self.branch

    def go_on(self, _moment: Moment) -> None:
        """Drop it."""

    def flush(self) -> None:
        """Do nothing."""

    def branches(self) -> list[Branch]:
        """Return none."""
        return []

    def events(self) -> Iterator[Noted]:
        """Return nothing."""
        return iter(())

    def last_tick(self, _branch: int) -> int:
        """Return the start."""
        return 0

    def state_at(self, _branch: int, _tick: int) -> bytes | None:
        """Return nothing."""
        return None

    def moment(self, _branch: int, _tick: int) -> Moment | None:
        """Return nothing."""
        return None

    def orders(self, _branch: int, after: int = 0) -> list[Journalled]:
        """Return those kept after number ``after``."""
        return [each for each in self._orders if each.id > after]

    def snapshots(self) -> list[tuple[str, Moment]]:
        """Return none."""
        return []

    def close(self) -> None:
        """Do nothing."""


class OrdersAlone(NoRecording):
    """All orders of the present branch, in memory; the rest is dropped."""

    def _keeps(self, _text: str) -> bool:
        return True
