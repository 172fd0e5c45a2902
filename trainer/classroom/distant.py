"""A boat of a class whose session runs elsewhere: ``trainer serve`` on another machine.

The class leads to it, and neither begins, resumes nor ends it. Its session asks for its own words,
so these have to be those of the class. Whether it answers is known by the lines that pages ask for.
"""

import threading
from dataclasses import dataclass, field
from socket import socket

from trainer.classroom.fleet import BoatState, Tell
from trainer.config.exercise.class_file import BoatRow
from trainer.io import client
from trainer.io.serial_line import LinkError


@dataclass
class DistantBoat:
    """One boat whose session is another machine's; what is heard of it is told."""

    row: BoatRow
    tell: Tell
    state: BoatState = BoatState.STARTING
    resumed: int = 0  # by the class, which never does
    _lock: threading.Lock = field(default_factory=threading.Lock)  # of its state

    @property
    def title(self) -> str:
        """Return its number, and its name if it has one."""
        return self.row.title

    @property
    def address(self) -> str:
        """Return where its session is."""
        return self.row.on or ""

    def reach(self) -> socket:
        """Return a line to its session; LinkError. What has changed is told."""
        try:
            end = client.reach(self.address)
        except LinkError as error:
            self._note(BoatState.AWAY, f"is lost: {error}; its own machine begins it again")
            raise
        self._note(BoatState.AT_SEA, "answers")
        return end

    def begin(self) -> None:
        """Look whether it answers, and wait for nothing."""
        threading.Thread(target=self._look, name=self.title, daemon=True).start()

    def ask_to_end(self) -> None:
        """Leave it at sea: its session is its own machine's."""

    def end(self, timeout_s: float) -> None:
        """Leave it at sea, at once."""

    def has_ended(self) -> bool:
        """Return that it may answer again."""
        return False

    def _look(self) -> None:
        try:
            self.reach().close()
        except LinkError:
            return  # it is told

    def _note(self, state: BoatState, told: str) -> None:
        with self._lock:
            changed, self.state = self.state is not state, state
        if changed:
            self.tell(f"{self.title} {told}")
