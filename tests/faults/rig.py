"""The rig of the faults: programs forked by the thousand, sessions, their orders, the results."""

import random
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from helpers.nursery import start_trainer
from helpers.waiting import eventually, once_it_can
from soak.audit import Answered, Check, journal, lost_marks
from soak.operators import Orders
from soak.session_process import Caller, GoneError

from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import Recording
from trainer.session.stations.roles import INSTRUCTOR_ROLE, Role

MARKS: Final = 0.2  # [-] of a mark after an order


@dataclass
class Tried:
    """The result of one kind of fault."""

    fault: str
    promise: str
    times: int = 0
    orders: int = 0  # answered before, between and after
    wrong: list[str] = field(default_factory=list)
    seen: dict[str, int] = field(default_factory=dict)  # how it ended, and how often

    def note(self, how: str) -> None:
        """Count one way that it ended."""
        self.seen[how] = self.seen.get(how, 0) + 1

    def must(self, held: object, otherwise: str) -> None:
        """Note what is wrong unless it held."""
        if not held:
            self.wrong.append(f"{self.times}: {otherwise}")


@dataclass(frozen=True)
class Bench:
    """A folder to work in, and the dice."""

    folder: Path
    dice: random.Random

    def told(self) -> str:
        """Return what programs have told since the last call."""
        path = self.folder / "told.txt"
        text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
        path.unlink(missing_ok=True)
        return text

    def start(self, *words: str, **limits: int) -> subprocess.Popen[str]:
        """Start a program of `trainer` that may have no more than the limits of ``resource``."""
        with (self.folder / "told.txt").open("a", encoding="utf-8") as told:
            return start_trainer(*words, stdout=told, stderr=told, limits=limits)

    def run(self, *words: str, **limits: int) -> int:
        """Run a program of `trainer` to its end. Return its exit code."""
        with self.start(*words, **limits) as process:
            return process.wait()

    def serve(self, path: Path, *words: str, **limits: int) -> "Session":
        """Start a session that records to ``path`` and listens in the folder."""
        door = self.folder / "door.sock"
        door.unlink(missing_ok=True)
        ports = ("--listen", "none", "--socket", str(door), "--verbose", "--record", str(path))
        return Session(self.start("serve", *words, *ports, **limits), path, door)


@dataclass
class Session:
    """A session under a fault."""

    process: subprocess.Popen[str]
    path: Path
    door: Path
    answered: list[Answered] = field(default_factory=list)

    @contextmanager
    def instructed(self) -> Iterator[Caller]:
        """Yield a line of the instructor, once the session listens; GoneError if it does not."""
        by = once_it_can(lambda: Caller(self.door), GoneError)
        try:
            by.ask("role instructor")
            yield by
        finally:
            by.hang_up()

    def order(self, by: Caller, words: str) -> str:
        """Give an order to the boat and note that it was obeyed; return the answer."""
        obeyed, answer = by.ask(words)
        order = parse(words)
        if obeyed and isinstance(order, Order):
            self.answered.append(Answered("", order.text))
        return answer

    def order_some(
        self, by: Caller, dice: random.Random, count: int, role: Role = INSTRUCTOR_ROLE
    ) -> None:
        """Give random orders, of those that a role may give."""
        orders = Orders(role, dice)
        for _ in range(count):
            self.order(by, orders.next())
            if dice.random() < MARKS:
                self.mark(by, f"mark-{dice.randrange(10**9)}")

    def mark(self, by: Caller, remark: str) -> None:
        """Mark a moment and note that it was answered."""
        if by.ask(f"mark {remark}")[0]:
            self.answered.append(Answered("", remark, mark=True))


def is_journalled(recording: Recording, session: Session) -> Check:
    """Return whether what was answered is in the journal, beside what came of itself."""
    written = [order.text for order in journal(recording) if order.accepted is not False]
    wanted = [order.text for order in session.answered if not order.mark]
    missing = lost_marks(recording, session.answered)
    rest = iter(written)
    held = all(text in rest for text in wanted) and not missing
    told = f"{len(written)} written, {len(wanted)} answered, {len(missing)} marks lost"
    return Check("answered orders", held, told)


def is_told(by: Caller, words: str) -> bool:
    """Return whether the session tells of it before long. What it has told is then forgotten."""

    def is_come() -> bool:
        by.ask("snapshots")  # brings what has been told meanwhile
        return any(words in news.fields[3] for news in by.news)

    told = eventually(is_come)
    if told:
        by.news.clear()
    return told


def is_logged(by: Caller, words: str) -> bool:
    """Return whether it is in the session's log before long. It may be older than the line."""

    def is_there() -> bool:
        by.ask("log 100")
        return any(words in text for text in by.said)

    return eventually(is_there)
