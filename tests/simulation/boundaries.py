"""A process is killed at each turn between an order's arrival and its answer.

A seed kills at any turn of a long life, and seldom within the few in which an order is journalled,
obeyed and answered. Here a short script has one order at its end, and a kill at each of these
turns. The session that goes on is compared as a whole: it has to be the one that stood before the
order, or the one after it. Once it is the latter it stays so, and after the answer it is no other.
"""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from simulation.machine import SECOND_NS, Task
from simulation.play import Change, Stage, folder_in_memory
from simulation.script import Act, Ending, Life, Player, Script, Visit
from trainer.io.recording.recording import MARK_KIND
from trainer.session.session import Session

PACE_S: Final = 3.0  # from word to word: what is stepped in between is on the disk before the next
LONGEST_S: Final = 60.0  # until the order at the end is heard
RESUMED_S: Final = 1.0  # that the next process is looked at
TURNS_AFTER: Final = 12  # of the answer, in which a kill takes nothing any more
# The order at the end is the one in which a kill strikes.
ROWS: Final = (
    "depth 70|order depth 90",
    "order depth 90|tell helm steady|belay",
    "step 4|in 10 s depth 80",
    "in 10 s depth 80|in 20 s course 010|cancel all",
    "casualty rudder-stuck|casualty bus-port-lost",
    "casualty bus-port-lost|step 4|ack all",
    "step 4|snapshot A",
    "snapshot A|in 10 s depth 80|order depth 90|step 6|restore A",
    "order depth 90|step 20|in 10 s depth 80|backtrack 5 s",
    "step 4|sea state 4|mark here",
)


class Whole(NamedTuple):
    """All that a session is, for who goes on with it."""

    state: bytes
    tick: int
    branch: int
    branches: str
    frozen: bool
    over: str
    plans: object
    words: object  # to the crew
    watch: object  # who has relieved whom
    alerts: tuple[tuple[str, str, str], ...]  # the open ones: their keys, words, and who has seen
    command: object  # who has it
    snapshots: str
    marks: tuple[tuple[int, str], ...]

    @classmethod
    def of(cls, session: Session) -> "Whole":
        """Return what a session is now."""
        history, recording = session.history, session.history.recording
        branches = ((b.id, b.parent, b.tick, b.after, b.cause) for b in recording.branches())
        marks = (each for each in recording.events() if each.kind == MARK_KIND)
        return cls(
            session.boat.plain.tobytes(),
            history.tick,
            recording.branch,
            repr(list(branches)),
            session.time.frozen,
            session.conduct.ending.over,
            session.agenda.plans,
            session.crew.talk,
            repr(session.crew.bill),
            tuple((a.key, a.words, a.seen_by) for a in session.event_log.alerts.open.values()),
            session.conduct.command.holder,
            repr(sorted(history.snapshots().items())),
            tuple((each.tick, each.text) for each in marks),
        )

    def unlike(self, other: "Whole") -> list[str]:
        """Return the names of what is not alike."""
        return [name for name in self._fields if getattr(self, name) != getattr(other, name)]


# The kill itself has broken a law, and nothing goes on.
NO_WHOLE: Final = Whole(
    *(b"", -1, 0, "", False, "", None, None, None), alerts=(), command=None, snapshots="", marks=()
)


class Resumed(NamedTuple):
    """A session that was killed in the midst of an order, and what goes on."""

    turns: int  # after the order's arrival, until the kill
    answered: bool
    whole: Whole
    breaches: tuple[str, ...]


@dataclass
class Boundary(Stage):
    """The stage of one row, whose first process is killed at its last order."""

    turns: int = 0  # -1: before the order comes
    last: int = 0  # the number of the last order
    answered: bool = False
    whole: Whole | None = field(default=None)

    def _let_live(self, session: Task) -> None:
        if self.docket.life > 1:
            super()._let_live(session)
            return
        machine, docket = self.machine, self.docket
        heard, longest = self.last - (self.turns < 0), machine.now + int(LONGEST_S * SECOND_NS)
        machine.run(longest, lambda: docket.orders >= heard)
        if self.turns < 0:
            machine.run(machine.now + int(0.9 * PACE_S * SECOND_NS))
        kill = machine.turns + self.turns
        machine.run(longest, lambda: machine.turns >= kill)
        self.answered = self.turns >= 0 and docket.answers > self.last  # its role comes first

    def _look(self, session: Task, others: int) -> None:
        super()._look(session, others)
        if self.docket.life > 1 and self.witness.session:
            self.whole = Whole.of(self.witness.session)


def script_of(row: str) -> Script:
    """Return the script of a row, killed at its last word."""
    acts = tuple(Act(PACE_S, words) for words in row.split("|"))
    player = Player("instructor", (Visit(0.1, acts),))
    killed = Life(1, LONGEST_S, Ending.KILLED, 1, (player,), interleaving=1.0, frozen=True)
    resumed = Life(2, RESUMED_S, Ending.SIGNAL, 1, (), frozen=True)
    return Script("", 0.0, 1.0, (killed, resumed))


def kill_at(row: str, turns: int, *changes: Change) -> Resumed:
    """Kill a process some turns after the last order comes, and go on."""
    with folder_in_memory(), contextlib.ExitStack() as stack:
        for change in changes:
            stack.enter_context(change())
        stage = Boundary(script_of(row), turns=turns, last=len(row.split("|")))
        docket = stage.play()
    assert stage.whole or docket.breaches
    return Resumed(turns, stage.answered, stage.whole or NO_WHOLE, tuple(map(str, docket.breaches)))


def kill_at_each(row: str, every: int, *changes: Change) -> Iterator[Resumed]:
    """Yield what goes on after kills before and after a last order comes.

    Ends some turns after the answer; ``every`` second, third turn is enough for a look.
    """
    turns, more = -1, TURNS_AFTER
    while more > 0:
        yield (resumed := kill_at(row, turns, *changes))
        turns += every if turns >= 0 else 1
        more -= every * resumed.answered


def faults_of(resumed: list[Resumed]) -> list[str]:
    """Return what is wrong with what goes on after kills at turns in order."""
    before, after = resumed[0].whole, resumed[-1].whole
    faults, taken = [], False
    for each in resumed:
        at = f"turn {each.turns}"
        faults += [f"{at}: {breach}" for breach in each.breaches]
        if each.whole is NO_WHOLE:
            continue
        if each.whole == after:
            taken = True
        elif each.whole != before:
            unlike = f"{each.whole.unlike(before)} before, {each.whole.unlike(after)} after"
            faults.append(f"{at}: neither what was before nor after: {unlike}")
        elif taken or each.answered:
            faults.append(f"{at}: the order is gone: {each.whole.unlike(after)}")
    return faults
