"""Stand-ins for a recording where a run has none, so that callers need no ``if``.

They have the methods of ``recording.Recording``. ``NoRecording`` drops everything; ``OrderMemory``
remembers the orders alone, for the Python face, which lists them.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from trainer.io.recording.facts import NO_CREW_FACT, BranchCause, CrewFact, Giver
from trainer.io.recording.queries import Branch, Moment, RecordedEvent, RecordedOrder


class NoRecording:
    """A recording that drops all it is given. A run can go back only to moments in memory."""

    wake: Callable[[], object]  # never called

    def __init__(self) -> None:
        self.trouble = self.missing = self.behind = ""
        self.reachable = False
        self.wake = lambda: None
        self.absences = 0
        self.branch = 1
        self._order = 0

    def order(self, _tick: int, _giver: Giver, _text: str, _entry: int | None = None) -> int:
        """Drop an order; return its number."""
        self._order += 1
        return self._order

    def answered(
        self,
        _order: int,
        _answer: str,
        _accepted: bool,  # noqa: FBT001
        _crew: CrewFact = NO_CREW_FACT,
    ) -> None:
        """Drop it."""

    def _drop(self, *_: object) -> None:
        """Drop it."""

    state = timing = event = snapshot = flush = close = _drop

    def fork(self, _moment: Moment, _why: str, _cause: BranchCause = BranchCause.JUMP) -> int:
        """Return the number of the branch that begins; drop its moment."""
        self.branch += 1
        return self.branch

    def go_on(self, _moment: Moment) -> bool:
        """Return that nothing is recorded."""
        return False

    def branches(self) -> list[Branch]:
        """Return none."""
        return []

    def events(self) -> Iterator[RecordedEvent]:
        """Return nothing."""
        return iter(())

    notes = events

    def last_tick(self, _branch: int) -> int:
        """Return the tick of the start, since no later one is recorded."""
        return 0

    def state_at(self, _branch: int, _tick: int) -> bytes | None:
        """Return nothing."""
        return None

    def moment(self, _branch: int, _tick: int) -> Moment | None:
        """Return nothing."""
        return None

    def orders(self, _branch: int, _after: int = 0) -> list[RecordedOrder]:
        """Return none."""
        return []

    def snapshots(self) -> list[tuple[str, Moment]]:
        """Return none."""
        return []


class OrderMemory(NoRecording):
    """A recording in memory: only the orders of the present branch."""

    def __init__(self, orders: Iterable[RecordedOrder] = ()) -> None:
        """Remember orders that were given before."""
        super().__init__()
        self._orders = [*orders]
        self._order = max((each.id for each in self._orders), default=0)

    def order(self, tick: int, giver: Giver, text: str, entry: int | None = None) -> int:
        """Keep an order; return its number."""
        number = super().order(tick, giver, text, entry)
        self._orders.append(RecordedOrder(number, self.branch, tick, giver, text, entry, None, ""))
        return number

    def answered(
        self,
        order: int,
        answer: str,
        accepted: bool,  # noqa: FBT001
        crew: CrewFact = NO_CREW_FACT,
    ) -> None:
        """Keep what became of the latest order."""
        if self._orders and self._orders[-1].id == order:
            self._orders[-1] = replace(
                self._orders[-1], accepted=accepted, answer=answer, crew=crew
            )

    def fork(self, moment: Moment, why: str, cause: BranchCause = BranchCause.JUMP) -> int:
        """Forget the orders after a moment; return the number of the new branch."""
        self._orders = [each for each in self._orders if each.id <= moment.after]
        return super().fork(moment, why, cause)

    def orders(self, _branch: int, after: int = 0) -> list[RecordedOrder]:
        """Return those after number ``after``."""
        return [each for each in self._orders if each.id > after]
