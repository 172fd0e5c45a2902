"""A feed carries what the tick hands over to one outlet, by its own thread.

Handing over is an append. Where time runs as fast as it can and the outlet does not keep up the
tick waits, so that nothing is lost; where time is kept it never does, and what there is no room for
is counted.
"""

import math
import threading
from collections import deque
from typing import Final, Protocol

from trainer.session.rerun.batch import Batch
from trainer.session.rerun.collector import Gathering, Handed, Taken

CHUNK: Final = 4096  # handed on at once
ROOM: Final = 4 * CHUNK  # states that may wait: 32 MB
LONGEST: Final = 2.0  # [s] that a tick waits for room


class Sink(Protocol):
    """Where batches go; its methods may wait, and raise when they cannot go on."""

    name: str  # in what is told of it
    period: float  # [s] from batch to batch
    patience: float  # [s] that it has for what is left at the end
    needed: bool  # a run has failed where it has

    def open(self) -> None:
        """Get ready."""
        ...

    def write(self, batch: Batch) -> None:
        """Take a batch, and bring it out."""
        ...

    def close(self) -> None:
        """End."""
        ...


class Feed:
    """One outlet with its thread."""

    def __init__(self, sink: Sink, step: float) -> None:
        """Carry to ``sink``, from a run with that step [s]."""
        self.trouble = ""  # what has become of it, "" while all is well
        self.lost = 0  # pictures
        self.sink = sink
        self._gathering = Gathering(step)
        self._waiting: deque[Handed] = deque()
        self._called = threading.Event()
        self._room = threading.Event()
        self._closing = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=sink.name, daemon=True)
        self._thread.start()

    def hand(self, handed: Handed) -> None:
        """Take what is to be carried; an append, unless there is no room."""
        waiting = self._waiting
        if len(waiting) >= CHUNK and not self._make_room(handed):
            return
        waiting.append(handed)

    def end(self) -> None:
        """Carry what waits by the thread, and end."""
        self._closing.set()
        self._called.set()

    def close(self) -> None:
        """End, waiting for it no longer than the sink has patience."""
        self.end()
        if not self._over.wait(self.sink.patience):
            self._tell("it did not take all in time: its end is missing")
        elif self.lost:
            self._tell(f"{self.lost} ticks are missing: it did not take them in time")

    def _make_room(self, handed: Handed) -> bool:
        """Call the thread; return whether there is room, waiting for it where time is not kept."""
        if self._over.is_set():
            return False
        if not self._called.is_set():
            self._called.set()
        hurried = isinstance(handed, Taken) and math.isinf(handed.pace.speed)
        if len(self._waiting) < ROOM:
            return True
        self._room.clear()
        if len(self._waiting) >= ROOM and not (hurried and self._room.wait(LONGEST)):
            self.lost += isinstance(handed, Taken)
            return False
        return True

    def _tell(self, trouble: str) -> None:
        self.trouble = self.trouble or f"{self.sink.name}: {trouble}"

    def _run(self) -> None:
        try:
            self.sink.open()
            while not self._closing.is_set():
                self._called.wait(self.sink.period)
                self._called.clear()
                self._carry()
            self._carry()
            self.sink.close()
        except Exception as error:  # noqa: BLE001 whatever fails here, the run goes on
            self._tell(f"{reason(error)}; nothing more goes there")
        finally:
            self._over.set()
            self._waiting.clear()
            self._room.set()

    def _carry(self) -> None:
        """Carry what waits by now, piece by piece."""
        while count := min(len(self._waiting), CHUNK):
            handed = [self._waiting.popleft() for _ in range(count)]
            self._room.set()
            self.sink.write(self._gathering.batch(handed))


def reason(error: Exception) -> str:
    """Return what an error says, in one line."""
    told = str(error).splitlines() or [type(error).__name__]
    return told[0]
