"""A session with an instructor and whoever comes, conducted by a test without a clock."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest

from helpers.boats import make_boat
from helpers.line import Line, fields_of
from helpers.sessions import free_session, prompt_sender
from trainer.boat.casualties import arm_casualty
from trainer.boat.limits import LimitMonitor
from trainer.boat.world.world import world_of
from trainer.config.exercise.derived import Loss, compile_condition
from trainer.config.exercise.exercise import ConditionalCasualty, ExerciseLimits
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import Position
from trainer.config.world.world import WorldTables
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.io.recording.recording import Recording
from trainer.session.exercise.marks import DebriefSource, Judgement, WrittenDebrief
from trainer.session.exercise.terms import Terms
from trainer.session.past.plan import Plan
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.units import KNOT

MARKS: Final = Judgement(Outcome.NOT_REACHED, 42.0, ("depth: 42",))
PLACE: Final = Position("exercise.toml", "lost")


class Crewed:
    """A session of BB2 with an instructor and whoever comes, at full speed, heard at will."""

    def __init__(
        self,
        path: Path,
        *,
        lost: Sequence[str] = (),
        seconds: float | None = 5.0,
        schedule: Sequence[ScheduledOrder] = (),
        armed: Sequence[ConditionalCasualty] = (),
        world: WorldTables | None = None,
        hand: frozenset[str] = frozenset(),
        plan: Plan | None = None,  # of an exercise
        clock: Callable[[], float] = time.monotonic,  # of what is shown
    ) -> None:
        self.boat = make_boat("bb2", "modified")
        if plan:
            plan.start(self.boat)
            schedule = plan.schedule
        else:
            self.boat.start(10.0 * KNOT, 60.0, 0.0)
            self.boat.world = world_of(self.boat, world or {})
        self.recording = Recording.create(path, {}, self.boat.records.state.tobytes())
        self.now = 0.0
        self.judged = threading.Event()
        self.wake = threading.Event()
        self.sending = prompt_sender(self.boat, clock)
        for each in armed:
            arm_casualty(self.boat, each.condition, each.casualty, each.rule)
        self.session = free_session(
            *(self.boat, self.recording, self.sending),
            schedule=schedule,
            armed=armed,
            monitor=LimitMonitor.over(self.boat, ExerciseLimits()),
            wake=self.wake,
            by_hand={"hand": hand, "allowed": frozenset(plan.allowed if plan else ())},
            terms=Terms(
                plan,
                losses=[
                    Loss(conditions=(compile_condition(text, PLACE),), seconds=1.0, text=text)
                    for text in lost
                ],
                seconds=seconds,
                kept=path,
                debriefing=DebriefSource(self._judge, self._write),
            ),
        )
        self.conduct = self.session.conduct
        self.conduct.marks.scored = True
        self.conduct.muster.clock = self.conduct.command.clock = lambda: self.now
        self.instructor = self.comes("instructor")

    def _judge(self, path: Path, branch: int) -> Judgement:
        assert path.exists()
        self.judged.set()
        reasons = (f"branch {branch}: 42",)
        return replace(MARKS, reasons=reasons, uncounted=("Stern jam answered",))

    def _write(
        self,
        path: Path,
        branch: int,
        _closing: threading.Event,
        share: Callable[[float], object],
    ) -> WrittenDebrief:
        share(0.25)
        page = str(path.with_suffix(f".branch{branch}.html"))
        return WrittenDebrief(page, [(2.0, "0:02: much was lost.")])

    def allow_next(self) -> None:
        """Let another exercise follow in the same process."""
        training = self.conduct.training
        training.terms = replace(training.terms, barred=None)

    def comes(self, role: str) -> Line:
        """Let a station come that says who it is."""
        line = Line(f"line {len(self.session.event_log.stations) + 1}")
        self.attach(line, role)
        return line

    def attach(self, line: Line, role: str) -> None:
        """Let a station come at a line."""
        station = Station(line, Access(), self.sending, self.session.event_log.log)
        self.session.event_log.stations.append(station)
        self.say(line, f"role {role}")

    def leaves(self, line: Line) -> None:
        line.ended = True
        self.session.attendance.listen()

    def say(self, line: Line, words: str) -> tuple[str, str]:
        """Give an order as a program; return ok or no, and the answer."""
        line.waiting = [order_sentence(words, "7")]
        before = len(line.sent)
        self.session.attendance.listen()
        told = [parse_sentence(each) for each in line.sent[before:]]
        answers = [each.fields for each in told if each and each.tag == "7"]
        self.said = [text for kind, text in answers if kind == "say"]
        return answers[-1][0], answers[-1][1]

    def order(self, words: str) -> str:
        """Give an order that is to be obeyed, as the instructor; return the answer."""
        kind, text = self.say(self.instructor, words)
        assert kind == "ok", text
        return text

    def refused(self, words: str, by: Line | None = None) -> str:
        kind, text = self.say(by or self.instructor, words)
        assert kind == "no", text
        return text

    def fly(self, ticks: int) -> None:
        """Let time go on for so many ticks, or until it stands still."""
        self.session.time.pacer.run()
        for _ in range(ticks):
            if not self.session.time.frozen:
                self.session.tick()

    def settle(self, true: Callable[[], object]) -> None:
        """Let what is done beside the session be taken."""
        for _ in range(1000):
            self.session.attendance.listen()
            if true():
                return
            self.wake.wait(0.01)
            self.wake.clear()
        raise AssertionError

    def facts(self, line: Line, what: str) -> list[str]:
        return [subject for each, subject in self.all_facts(line) if each == what]

    def all_facts(self, line: Line) -> list[tuple[str, str]]:
        """Return the name and the subject of each fact that a line was told."""
        return [(told[2], told[3]) for told in fields_of(line.sent, "TRF")]

    def events(self, line: Line, kind: str) -> list[str]:
        return [told[3] for told in fields_of(line.sent, "TRE") if told[2] == kind]


Begin = Callable[..., Crewed]


@pytest.fixture
def crewed(tmp_path: Path) -> Iterator[Begin]:
    begun: list[Crewed] = []

    def begin(**settings: object) -> Crewed:
        begun.append(Crewed(tmp_path / f"{len(begun)}.trainer", **settings))  # type: ignore[arg-type]
        return begun[-1]

    yield begin
    for each in begun:
        each.recording.close()


@pytest.fixture
def ship(crewed: Begin) -> Crewed:
    """Return a session without an end."""
    return crewed(seconds=None)


@pytest.fixture
def drill(crewed: Begin) -> Crewed:
    """Return a session that ends at 5 s."""
    return crewed()
