"""The seats of a class: which browser may come to which boat.

Whoever comes takes a seat on one boat, and the key of the seat is a cookie of his browser. Without
one no page, line or debrief of a boat is to be had. An instructor's seat is on all boats. Who may
take it, and any role, is for the boat's session to say, because it has the words (``door``).

A person's name stands here alone, for the instructor's page. No session hears it, and no recording
keeps it.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from secrets import token_urlsafe
from typing import Final

from trainer.io.machine import THIS_MACHINE
from trainer.web.bridge import MAX_PAGES_OF_MACHINE, RefusedError

SEAT_COOKIE: Final = "seat"
EVERY_BOAT: Final = 0  # the boat of an instructor's seat
MAX_SEATS: Final = 500  # the one without a line that was taken first gives way
HELD_S: Final = 60.0  # that a seat without a line still counts: a page is loading, or comes back


@dataclass
class Seat:
    """One browser's place on a boat, or on all."""

    boat: int
    name: str  # "" where nobody has said it
    since: float  # [s] when its last line ended, or it was taken
    machine: str  # whose browser it is, as limits count machines
    lines: int = 0  # open now

    def covers(self, boat: int) -> bool:
        """Return whether it is a seat on that boat."""
        return self.boat in (boat, EVERY_BOAT)


@dataclass
class Seats:
    """All seats of a class, by the keys that browsers keep."""

    clock: Callable[[], float] = time.monotonic
    by_key: dict[str, Seat] = field(default_factory=dict)

    def take(
        self, boat: int, name: str, cookies: Mapping[str, str], machine: str = THIS_MACHINE
    ) -> str:
        """Take a seat, in place of the one that this browser has; return its key.

        A machine has as many as it may have pages: then its first without a line gives way, or
        RefusedError.
        """
        had = cookies.get(SEAT_COOKIE, "")
        own = [key for key, seat in self.by_key.items() if seat.machine == machine and key != had]
        if len(own) >= MAX_PAGES_OF_MACHINE:
            silent = next((key for key in own if not self.by_key[key].lines), "")
            if not silent and machine != THIS_MACHINE:
                raise RefusedError(f"{len(own)} seats of your machine are taken: close one of them")
            self.by_key.pop(silent, None)
        self.by_key.pop(had, None)
        if len(self.by_key) >= MAX_SEATS:
            idle = (key for key, seat in self.by_key.items() if not seat.lines)
            self.by_key.pop(next(idle, next(iter(self.by_key))))
        key = token_urlsafe(16)
        self.by_key[key] = Seat(boat, " ".join(name.split()), self.clock(), machine)
        return key

    def seat_of(self, cookies: Mapping[str, str]) -> Seat | None:
        """Return the seat of a browser, None without one."""
        return self.by_key.get(cookies.get(SEAT_COOKIE, ""))

    @contextmanager
    def carrying_line(self, seat: Seat) -> Iterator[None]:
        """Count a line of a seat inside the block."""
        seat.lines += 1
        try:
            yield
        finally:
            seat.lines -= 1
            seat.since = self.clock()

    def crew_of(self, boat: int) -> list[Seat]:
        """Return the seats of those who are on a boat, or have just left it."""
        now = self.clock()
        own = (seat for seat in self.by_key.values() if seat.boat == boat)
        return [seat for seat in own if seat.lines > 0 or now - seat.since < HELD_S]

    def next_free(self, boats: Iterable[int]) -> int | None:
        """Return the first boat with nobody aboard, None where all are taken."""
        return next((boat for boat in boats if not self.crew_of(boat)), None)
