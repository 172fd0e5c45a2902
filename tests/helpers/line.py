"""A line of a station, typed by a test."""

import threading
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from trainer.io.lines import OverlongLine
from trainer.io.orders.sentences import parse_sentence


@dataclass(eq=False)  # a line is itself, whatever it has been sent
class Line:
    """A line typed by the test, which keeps all that it is sent."""

    name: str
    waiting: list[str | OverlongLine] = field(default_factory=list)
    sent: list[str] = field(default_factory=list)
    trouble: str = ""
    dropped: int = 0
    room: bool = True
    ended: bool = False

    def take(self, most: int) -> list[str | OverlongLine]:
        taken, self.waiting = self.waiting[:most], self.waiting[most:]
        return taken

    def send(self, line: str) -> None:
        self.sent.append(line)

    def close(self, patience: float) -> None:
        assert patience >= 0.0
        self.ended = True


class ScriptedLine:
    """A line whose orders a test has written before, and the sender of its subscriptions."""

    name, trouble, dropped, room = "script", "", 0, True

    def __init__(self, wake: threading.Event | None = None) -> None:
        self.wake = wake or threading.Event()
        self.heard: list[str] = []
        self.troubles: deque[str] = deque()

    def send(self, line: str) -> None:
        self.heard.append(line)

    def close(self, patience: float) -> None:
        del patience

    def add(self, subscription: object) -> None:
        del subscription

    def strike(self, subscription: object) -> None:
        del subscription

    def lack(self, channel: str) -> None:
        del channel


def fields_of(lines: Iterable[str], kind: str) -> list[tuple[str, ...]]:
    """Return the fields of each sentence of a kind among the lines that a program was sent."""
    found = map(parse_sentence, lines)
    return [each.fields for each in found if each and each.kind == kind]
