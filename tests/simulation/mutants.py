"""Faults put back into the product, each of which a law has to find.

``FAULTS`` has fourteen that nobody made, at places where a careless hand would make them, and five
that seeds found in the product. Those are mended; the scripts that show them are kept in
``tests/simulation/kept``.
"""

# ruff: noqa: SLF001  a fault lies in private parts

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest

from simulation.play import Change
from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.world.contacts import ContactState
from trainer.io.connection import MAX_WAITING_LINES, Connection
from trainer.io.lines import OverlongLine
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording import file
from trainer.io.recording.durability import NEVER_DUE, Syncer
from trainer.io.recording.recording import RecordedOrder, Recording, RecordingError
from trainer.session import dispatch, jump, resume
from trainer.session.crew.orders_in_force import OrdersInForce
from trainer.session.dispatch import Dispatch
from trainer.session.exercise.conduct import Conduct
from trainer.session.nmea.outlets import SteadySubscription
from trainer.session.nmea.transponders import Messages, Transponders
from trainer.session.parts import Parts
from trainer.session.questions import Questions
from trainer.session.stations.station import Duty, Fact, LongAnswer, Request
from trainer.session.stations.view import Picture

Fault = Callable[[pytest.MonkeyPatch], None]


def gather(patch: pytest.MonkeyPatch, method: str) -> None:
    """Have a method of the recording gather its rows as ticks are."""
    write = getattr(Recording, method)

    def gathered(self: Recording, *given: object, **more: object) -> object:
        with pytest.MonkeyPatch.context() as quiet:
            quiet.setattr(Recording, "flush", lambda *_: None)
            return write(self, *given, **more)

    patch.setattr(Recording, method, gathered)


def gather_journal(patch: pytest.MonkeyPatch) -> None:
    """Gather the journal as ticks are: an answered order reaches the file within a second."""
    gather(patch, "order")
    gather(patch, "answered")


def gather_answers(patch: pytest.MonkeyPatch) -> None:
    """Gather the answers alone: after a kill it is not known which order was refused."""
    gather(patch, "answered")


def plan_refused(patch: pytest.MonkeyPatch) -> None:
    """Plan again what the journal has, whether it was refused or not."""
    read = OrdersInForce.read

    def read_all(
        self: OrdersInForce, given: Iterable[RecordedOrder], tick: int = 0, after: int = 0
    ) -> None:
        read(self, [replace(order, accepted=True) for order in given], tick, after)

    patch.setattr(OrdersInForce, "read", read_all)


def answer_before_journal(patch: pytest.MonkeyPatch) -> None:
    """Write the journal when the answer has gone out."""
    gather_journal(patch)
    hear = Dispatch.hear

    def hear_and_write(self: Dispatch, asked: Request) -> None:
        hear(self, asked)
        self.session.history.recording.flush()

    patch.setattr(Dispatch, "hear", hear_and_write)


def leave_mark_waiting(patch: pytest.MonkeyPatch) -> None:
    """Answer a mark, and let it wait until others are written."""

    def mark(self: Questions, asked: Request) -> Reply:
        remark = asked.order.subject
        self.log.tell("mark", remark or "marked", asked.station, Fact("mark", remark))
        return self.log.as_kept(f"marked at {self.history.boat.time:g} s")

    patch.setattr(Questions, "_mark", mark)


def run_after_end(patch: pytest.MonkeyPatch) -> None:
    """Let time go on after the end of an exercise."""
    for word in ("run", "step"):
        ended = replace(ORDER_WORDS[word], after_end=True)
        patch.setitem(ORDER_WORDS, word, ended)


def refuse_too_late(patch: pytest.MonkeyPatch) -> None:
    """Have a refused order leave a trace in the boat."""

    def obey(boat: Boat, order: Order) -> Reply:
        answer = obey_order(boat, order)
        if isinstance(answer, Refused):
            boat.state.hover_integral += 1.0
        return answer

    patch.setattr(dispatch, "obey_order", obey)


def forget_last_orders(patch: pytest.MonkeyPatch) -> None:
    """Go on with a recording without the orders after its last state."""
    patch.setattr(resume, "obey_order", lambda _boat, _order: "done")


def lose_short_write(patch: pytest.MonkeyPatch) -> None:
    """Throw away what a short write leaves of a line."""

    def write(self: Connection) -> None:
        with self._lock:
            batch = b"".join(self._said)
        if not batch:
            return
        sent = self._end.send(batch)
        with self._lock:
            self._said_bytes -= sent
            while sent > 0:
                sent -= len(self._said.popleft())

    patch.setattr(Connection, "_write", write)


def never_sync(patch: pytest.MonkeyPatch) -> None:
    """Do not ask the disk."""
    patch.setattr(Syncer, "_sync", lambda self: setattr(self, "_due", NEVER_DUE))


def lose_line(patch: pytest.MonkeyPatch) -> None:
    """Lose a line that comes while those before it are taken."""

    def take(self: Connection, most: int) -> list[str | OverlongLine]:
        with self._lock:
            held_back = len(self._heard) >= MAX_WAITING_LINES
        lines = list(self._heard)[:most]
        with self._lock:  # between the two another may have come
            if len(lines) < most:
                self._heard.clear()
            else:
                for _ in lines:
                    self._heard.popleft()
            self._asks = self._asks or bool(lines)
        if held_back:
            self._stir()
        return lines

    patch.setattr(Connection, "take", take)


def forget_command(patch: pytest.MonkeyPatch) -> None:
    """Let an instructor order who has no command."""
    patch.setattr(dispatch, "ORDER_GATES", dispatch.ORDER_GATES[1:])


def take_end_back(patch: pytest.MonkeyPatch) -> None:
    """Do not look whether a jump has come to the exercise's end."""
    follow_jump = jump.follow_jump

    def follow_unseen(session: Parts) -> None:
        with pytest.MonkeyPatch.context() as blind:
            blind.setattr(Conduct, "judge_moment", lambda conduct: conduct.damage_watch.look())
            follow_jump(session)

    for module in (dispatch, jump):
        patch.setattr(module, "follow_jump", follow_unseen)


def spin_hub(patch: pytest.MonkeyPatch) -> None:
    """Have a line that is closed ring the bell of the thread that closes it."""
    close = Connection.close

    def close_and_stir(self: Connection, patience: float) -> None:
        close(self, patience)
        self._stir()

    patch.setattr(Connection, "close", close_and_stir)


def die_of_question(patch: pytest.MonkeyPatch) -> None:
    """Let a question about a past that cannot be read end the session."""
    duties = Questions.duties

    def uncaught(duty: Duty) -> Duty:
        def ask(asked: Request) -> Reply | LongAnswer | None:
            try:
                return duty(asked)
            except RecordingError as error:
                raise RuntimeError(str(error)) from error

        return ask

    def uncaught_duties(self: Questions) -> Mapping[str, Duty]:
        answered: Mapping[str, Duty] = duties.__get__(self)
        return {word: uncaught(duty) for word, duty in answered.items()}

    patch.setattr(Questions, "duties", property(uncaught_duties))


def trust_killed(patch: pytest.MonkeyPatch) -> None:
    """Do not ask the disk for what a killed process had not asked for."""

    def reopen(path: Path) -> Recording:
        return Recording._writing(file.reopen(path), path)

    patch.setattr(Recording, "reopen", reopen)


def fall_silent(patch: pytest.MonkeyPatch) -> None:
    """Forget when what has just been sent is due again, unless another picture comes."""
    steadily = SteadySubscription.wait

    def wait_steadily(self: SteadySubscription, picture: Picture, now: float) -> float:
        just_sent = self.seen == picture and self.due > now
        return math.inf if just_sent else steadily(self, picture, now)

    patch.setattr(SteadySubscription, "wait", wait_steadily)


def share_recording(patch: pytest.MonkeyPatch) -> None:
    """Let a second session have a recording that another writes."""
    patch.setattr(file, "_claim", lambda *_: None)


def tell_one_report(patch: pytest.MonkeyPatch) -> None:
    """Send a ship's name only with a set that has not its place."""
    due = Transponders._due

    def due_first(
        self: Transponders, ship: ContactState, before: float, now: float
    ) -> Iterator[Messages]:
        yield from itertools.islice(due(self, ship, before, now), 1)

    patch.setattr(Transponders, "_due", due_first)


FOUND: Final[Mapping[str, Fault]] = {
    "end-taken-back": take_end_back,
    "hub-spins": spin_hub,
    "question-kills": die_of_question,
    "kill-then-power": trust_killed,
    "silent-in-a-freeze": fall_silent,
}
FAULTS: Final[Mapping[str, Fault]] = {
    "journal-gathered": gather_journal,
    "answer-before-journal": answer_before_journal,
    "answers-gathered": gather_answers,
    "refused-planned": plan_refused,
    "mark-waiting": leave_mark_waiting,
    "run-after-end": run_after_end,
    "refused-too-late": refuse_too_late,
    "last-orders-forgotten": forget_last_orders,
    "short-write-lost": lose_short_write,
    "never-synced": never_sync,
    "line-lost": lose_line,
    "command-forgotten": forget_command,
    "recording-shared": share_recording,
    "name-untold": tell_one_report,
    **FOUND,
}


def with_fault(fault: Fault) -> Change:
    """Return the change of the product that puts a fault back."""

    @contextlib.contextmanager
    def change() -> Iterator[None]:
        with pytest.MonkeyPatch.context() as patch:
            fault(patch)
            yield

    return change
