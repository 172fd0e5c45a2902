"""Where stations come in by themselves, as a session knows it."""

from typing import Protocol

from trainer.session.stations.station import Station


class Reception(Protocol):
    """Where stations come in by themselves."""

    @property
    def awaited(self) -> bool:
        """Return whether a run that nobody attends to goes on for whoever may come."""
        ...

    def newcomers(self) -> list[Station]:
        """Return those that have come since the last call."""
        ...


class Closed:
    """Nobody comes in by himself."""

    awaited = False

    def newcomers(self) -> list[Station]:
        """Return nobody."""
        return []
