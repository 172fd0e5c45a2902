"""A line of a station, typed by a test."""

from dataclasses import dataclass, field

from trainer.io.lines import OverlongLine


@dataclass
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
