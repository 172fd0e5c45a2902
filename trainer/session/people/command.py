"""Which of several instructors may give orders; the others watch and mark.

Two instructors who change time or casualties at once would undo each other's work. So one of them
holds command. Another may ask for it, and gets it when the holder agrees, leaves, or has not
answered for 10 s. ``dispatch`` asks ``elsewhere`` before it obeys an instructor.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from trainer.io.orders.grammar import Refused, Reply
from trainer.session.doors.alarm import Alarm
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Fact, Request, Station

ANSWER_TIMEOUT_S: Final = 10.0  # [s] for the holder to keep command, as docs/instructor.md says


@dataclass
class Command:
    """Which of several instructors orders; the others watch and mark."""

    log: EventLog
    wake: Callable[[], object]  # has the session's thread listen
    clock: Callable[[], float] = time.monotonic
    holder: Station | None = None
    asker: Station | None = None
    until: float = 0.0  # [s] on the clock, to answer who asks

    def __post_init__(self) -> None:
        self._alarm = Alarm(self.wake)

    def tend(self) -> None:
        """Pass command on if its holder has left, or has not answered in time."""
        if self.asker and self.asker not in self.log.stations:
            self.asker = None
        if self.holder and self.holder not in self.log.stations:
            self._pass_to(next(iter(self._instructors()), None))
        elif self.asker and self.clock() >= self.until:
            self._pass_to(self.asker)
        elif self.asker:
            self._alarm.set(self.until - self.clock())

    def elsewhere(self, station: Station) -> Refused | None:
        """Return which other instructor has command, None where this one has it."""
        self._settle(station)
        if self.holder is station or self.holder is None:
            return None
        return Refused(f"{self.holder.line.name} has command: take command asks for it")

    def ask(self, asked: Request) -> Reply:
        """Ask the holder for command. A holder who does not answer in time loses it."""
        station = asked.station
        self._settle(station)
        if self.holder is None or self.holder is station:
            return "you have command"
        if self.asker not in (None, station):
            return Refused(f"{self.asker.line.name} has asked for it already")
        self.asker, self.until = station, self.clock() + ANSWER_TIMEOUT_S
        self._alarm.set(ANSWER_TIMEOUT_S)
        name = station.line.name
        within = f"within {ANSWER_TIMEOUT_S:g} s"
        text = f"{name} asks for command: give command, or keep command, {within}"
        self.log.tell("exercise", text, station, Fact("asked", name))
        holder = self.holder.line.name
        return f"{holder} is asked; without an answer {within} you have command"

    def give(self, asked: Request) -> Reply:
        """Give command to the instructor who asked for it, else to another one."""
        taker = self.asker
        if taker is None:
            others = [each for each in self._instructors() if each is not asked.station]
            taker = others[0] if others else None
        if taker is None:
            return Refused("there is no other instructor")
        self._pass_to(taker)
        return f"{taker.line.name} has command"

    def keep(self, asked: Request) -> Reply:
        """Refuse command to the instructor who asks for it."""
        asker, self.asker = self.asker, None
        if asker is None:
            return Refused("nobody has asked for command")
        holder = asked.station
        text = f"{holder.line.name} keeps command"
        self.log.tell("exercise", text, holder, Fact("command", holder.line.name))
        return "you keep command"

    def _instructors(self) -> list[Station]:
        instructors = [each for each in self.log.stations if each.role is INSTRUCTOR_ROLE]
        return [each for each in instructors if not each.line.ended and not each.leaving]

    def _settle(self, station: Station) -> None:
        """Give command to the instructor who came first, if nobody has it."""
        instructors = self._instructors()
        if self.holder not in instructors:
            self.holder = next(iter(instructors), station)

    def _pass_to(self, taker: Station | None) -> None:
        self.holder, self.asker = taker, None
        if taker is not None:
            name = taker.line.name
            self.log.tell("exercise", f"{name} has command", fact=Fact("command", name))
